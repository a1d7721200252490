"""Reading files that a user names: every failure is a LingualError that says which file and why."""

from collections.abc import Iterator
from pathlib import Path

from .errors import LingualError


def read_bytes(path: Path, count: int = -1) -> bytes:
    """The first `count` bytes of a file, all of them when negative.

    Raises LingualError when the file is missing, a directory, unreadable or empty.
    """
    try:
        with open(path, "rb") as file:
            content = file.read(count)
    except FileNotFoundError as error:
        raise LingualError(f"There is no file {path}: check the path.") from error
    except IsADirectoryError as error:
        raise LingualError(f"{path} is a directory: name one of the files in it.") from error
    except (OSError, ValueError) as error:  # ValueError: a NUL in the name
        reason = getattr(error, "strerror", None) or error
        raise LingualError(f"{path} cannot be read ({reason}): check its permissions.") from error
    if not content and count != 0:
        raise LingualError(f"{path} is empty: copy or export it again.")
    return content


def read_text(path: Path) -> str:
    """A text file's content, without a byte-order mark.

    Raises LingualError as read_bytes does, and for a file that is not UTF-8 text.
    """
    content = read_bytes(path)
    bad = content.find(b"\0")
    if bad < 0:
        try:
            return content.decode("utf-8-sig")
        except UnicodeDecodeError as error:
            bad = error.start
    line = content.count(b"\n", 0, bad) + 1
    raise LingualError(f"{path}, line {line}: this is not text; the file is damaged or binary.")


def parse_number(token: str) -> float:
    """The number that `token` writes. Raises ValueError otherwise, also for Python's own 1_000."""
    if "_" in token or not token.isascii():
        raise ValueError(token)
    return float(token)


def check_last_line_ended(path: Path, text: str) -> None:
    """Refuses a file of known length whose last line has no end: its last number may be cut."""
    if not text.endswith(("\n", "\r")):
        line = text.count("\n") + 1
        raise LingualError(
            f"{path}, line {line}: the last line is not ended, so the file may be cut short; "
            "copy it again, or add a line end if it is complete."
        )


def token_lines(text: str) -> Iterator[tuple[int, list[str]]]:
    """Number and tokens of every line that has any, comments (from # on) taken off."""
    for number, line in enumerate(text.splitlines(), start=1):
        tokens = line.partition("#")[0].split()
        if tokens:
            yield number, tokens


def integer(path: Path, line: int, token: str) -> int:
    """A token as a whole number of 18 digits at most. Raises LingualError, naming the line."""
    digits = token.removeprefix("-")
    if not (digits.isascii() and digits.isdigit() and len(digits) <= 18):
        raise LingualError(f"{path}, line {line}: '{token[:30]}' is not a whole number; the file is damaged.")
    return int(token)


def real(path: Path, line: int, token: str) -> float:
    """A token as a number. Raises LingualError, naming the line."""
    try:
        return parse_number(token)
    except ValueError as error:
        raise LingualError(
            f"{path}, line {line}: '{token[:30]}' is not a number; the file is damaged."
        ) from error
