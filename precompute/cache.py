"""On-disk cache of precomputed arrays, keyed by everything that they depend on.

A file is trusted only if its format version, its key and the SHA-256 of its arrays all match what
is asked for and what it holds; a stale, truncated or foreign file is rebuilt and replaced.
"""

import hashlib
import json
import logging
import os
import sys
import tempfile
import zipfile
import zlib
from collections.abc import Callable, Mapping
from pathlib import Path
from typing import Any

import numpy as np
from numpy.typing import NDArray

FORMAT_VERSION = 1

Arrays = dict[str, NDArray]

_UNREADABLE = (
    OSError, ValueError, KeyError, EOFError, RuntimeError, NotImplementedError, zipfile.BadZipFile, zlib.error
)  # fmt: skip

log = logging.getLogger(__name__)


def lingual_cache_dir() -> Path:
    """Folder of the cache: $LINGUAL_CACHE, or the platform's cache folder with /lingual."""
    if configured := os.environ.get("LINGUAL_CACHE"):
        return Path(configured)
    if sys.platform == "darwin":
        return Path.home() / "Library" / "Caches" / "lingual"
    if sys.platform == "win32":
        return Path(os.environ.get("LOCALAPPDATA", Path.home())) / "lingual" / "cache"
    return Path(os.environ.get("XDG_CACHE_HOME", Path.home() / ".cache")) / "lingual"


def digest(*arrays: NDArray) -> str:
    """SHA-256 of shapes, types and values, for use in a key."""
    sha = hashlib.sha256()
    for array in arrays:
        sha.update(f"{array.shape}{array.dtype.str}".encode())
        sha.update(np.ascontiguousarray(array).tobytes())
    return sha.hexdigest()


def cached(name: str, key: Mapping[str, object], build: Callable[[], Arrays]) -> Arrays:
    """The arrays that `build` makes, read from the cache when a trustworthy file is there.

    name: prefix of the file's name. key: everything that the result depends on, JSON-serialisable;
    the format version is added. A folder that cannot be written costs only the next call's time.
    """
    identity = json.dumps({"format": FORMAT_VERSION, "name": name, **key}, sort_keys=True)
    path = lingual_cache_dir() / f"{name}-{hashlib.sha256(identity.encode()).hexdigest()[:16]}.npz"
    arrays = _read(path, identity)
    if arrays is None:
        arrays = build()
        _write(path, identity, arrays)
    return arrays


def _checksum(arrays: Arrays) -> str:
    names = sorted(arrays)
    return hashlib.sha256("".join(n + digest(arrays[n]) for n in names).encode()).hexdigest()


def _read(path: Path, identity: str) -> Arrays | None:
    try:
        archive = np.load(path, allow_pickle=False)
        if not isinstance(archive, np.lib.npyio.NpzFile):
            raise ValueError("it is not an archive of arrays")
        with archive as file:
            arrays = {name: file[name] for name in file.files}
        stored_identity = str(arrays.pop("__identity__"))
        stored_checksum = str(arrays.pop("__checksum__"))
    except (FileNotFoundError, NotADirectoryError):
        return None
    except _UNREADABLE as error:
        log.warning("The cache file %s cannot be read (%s); it is built again.", path, error)
        return None
    if stored_identity != identity or stored_checksum != _checksum(arrays):
        log.warning("The cache file %s does not hold what its name says; it is built again.", path)
        return None
    return arrays


def _write(path: Path, identity: str, arrays: Arrays) -> None:
    named: dict[str, Any] = {"__identity__": identity, "__checksum__": _checksum(arrays), **arrays}
    part: Path | None = None
    try:
        path.parent.mkdir(parents=True, exist_ok=True)
        with tempfile.NamedTemporaryFile(dir=path.parent, suffix=".part", delete=False) as file:
            part = Path(file.name)
            np.savez(file, **named)
        os.replace(part, path)
    except OSError as error:
        log.warning("The cache file %s cannot be written (%s); the work is repeated next time.", path, error)
        if part is not None:
            part.unlink(missing_ok=True)
