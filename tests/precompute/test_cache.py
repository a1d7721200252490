"""The cache gives back what was built, and never trusts a file that is not whole and its own."""

import logging
import os
import pickle
import shutil

import numpy as np
import pytest

from lingual.precompute import cache

KEY = {"mesh": "abc", "count": 3}
ARRAYS = {"a": np.arange(6.0).reshape(2, 3), "names": np.array(["TT", "TB"])}


class Build:
    """Makes the arrays and counts how often it is asked."""

    def __init__(self, arrays=ARRAYS):
        self.arrays, self.count = arrays, 0

    def __call__(self):
        self.count += 1
        return self.arrays


@pytest.fixture
def file(cache_folder):
    """A cache file that holds ARRAYS under KEY."""
    cache.cached("thing", KEY, Build())
    (path,) = cache_folder.iterdir()
    return path


def read_again(caplog) -> tuple[int, list[str]]:
    """How often the arrays were built for a second request, and the warnings of it."""
    build = Build()
    with caplog.at_level(logging.WARNING):
        arrays = cache.cached("thing", KEY, build)
    assert set(arrays) == set(ARRAYS)
    for name, expected in ARRAYS.items():
        np.testing.assert_array_equal(arrays[name], expected)
    return build.count, caplog.messages


def test_the_second_request_is_read_from_the_file(file, caplog):
    assert read_again(caplog) == (0, [])


@pytest.mark.parametrize("key", [{"mesh": "abd", "count": 3}, {"mesh": "abc", "count": 4}, {"mesh": "abc"}])
def test_another_key_is_another_file(file, key):
    build = Build()
    cache.cached("thing", key, build)
    assert build.count == 1
    assert len(list(file.parent.iterdir())) == 2


def test_another_format_version_is_another_file(file, monkeypatch):
    monkeypatch.setattr(cache, "FORMAT_VERSION", cache.FORMAT_VERSION + 1)
    build = Build()
    cache.cached("thing", KEY, build)
    assert build.count == 1


def truncated(path):
    path.write_bytes(path.read_bytes()[:-40])


def emptied(path):
    path.write_bytes(b"")


def text(path):
    path.write_text("not an archive\n")


def one_array(path):
    with path.open("wb") as stream:
        np.save(stream, np.arange(3))


def a_pickle(path):
    path.write_bytes(pickle.dumps({"a": 1}))


def archive_of_others(path):
    np.savez(path, weights=np.zeros(3))


def renamed(path):
    """A sound cache file of another key under this one's name."""
    cache.cached("thing", {"mesh": "other"}, Build({"a": np.zeros(2)}))
    (other,) = (p for p in path.parent.iterdir() if p != path)
    shutil.move(other, path)


def altered(path):
    """Right identity, other numbers: the archive is sound but its checksum is not."""
    with np.load(path) as archive:
        arrays = dict(archive)
    arrays["a"] = arrays["a"] + 1.0
    np.savez(path, **arrays)


def reinterpreted(path):
    """The same bytes under another type."""
    with np.load(path) as archive:
        arrays = dict(archive)
    arrays["a"] = arrays["a"].view(np.int64)
    np.savez(path, **arrays)


def a_folder(path):
    path.unlink()
    path.mkdir()


DAMAGE = [truncated, emptied, text, one_array, a_pickle, archive_of_others, renamed, altered, reinterpreted, a_folder]


@pytest.mark.parametrize("damage", DAMAGE, ids=lambda f: f.__name__)
def test_a_file_that_cannot_be_trusted_is_rebuilt_with_a_warning(file, damage, caplog):
    damage(file)
    count, messages = read_again(caplog)
    assert count == 1
    assert file.name in messages[0]
    assert "built again" in messages[0]
    if damage is not a_folder:
        caplog.clear()
        assert read_again(caplog) == (0, [])


def test_no_flipped_byte_gives_wrong_arrays_or_an_error(file, caplog):
    whole = file.read_bytes()
    rebuilt = 0
    for place in range(len(whole)):
        file.write_bytes(whole[:place] + bytes([whole[place] ^ 0xFF]) + whole[place + 1 :])
        rebuilt += read_again(caplog)[0]
    assert rebuilt > 0.4 * len(whole)  # the rest are time stamps and other fields that nobody reads


def test_a_folder_that_cannot_be_made_costs_only_the_time(tmp_path, monkeypatch, caplog):
    (tmp_path / "file").write_text("")
    monkeypatch.setenv("LINGUAL_CACHE", str(tmp_path / "file" / "cache"))
    for _ in range(2):
        caplog.clear()
        count, messages = read_again(caplog)
        assert count == 1
        assert "cannot be written" in messages[0]


def test_a_write_that_fails_leaves_no_debris(cache_folder, monkeypatch, caplog):
    def fail(*args, **kwargs):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(np, "savez", fail)
    count, messages = read_again(caplog)
    assert count == 1
    assert "No space left" in messages[0]
    assert list(cache_folder.iterdir()) == []


@pytest.mark.skipif(not hasattr(os, "geteuid") or os.geteuid() == 0, reason="root may read everything")
def test_a_folder_that_cannot_be_searched_is_tolerated(file, caplog):
    file.parent.chmod(0)
    try:
        assert read_again(caplog)[0] == 1
    finally:
        file.parent.chmod(0o700)


def test_digest_depends_on_values_shape_and_type():
    a = np.arange(4.0)
    others = [a + 1, a.reshape(2, 2), a.astype(np.float32), a.astype(np.int64)]
    assert len({cache.digest(x) for x in [a, *others]}) == 5
    assert cache.digest(a) == cache.digest(a.copy())


def test_the_folder_is_where_the_environment_says(monkeypatch, tmp_path):
    monkeypatch.setenv("LINGUAL_CACHE", str(tmp_path))
    assert cache.lingual_cache_dir() == tmp_path
    monkeypatch.delenv("LINGUAL_CACHE")
    monkeypatch.setattr(cache.sys, "platform", "linux")
    monkeypatch.setenv("XDG_CACHE_HOME", str(tmp_path))
    assert cache.lingual_cache_dir() == tmp_path / "lingual"
