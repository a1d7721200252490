"""What was repaired or assumed in a recording: shown to the user, never silent, never fatal."""

import warnings


class RecordingWarning(UserWarning):
    """A recording is used, but not as it stands in its file; the message says what was done."""


def warn(source: str, text: str) -> None:
    """Issues a RecordingWarning about the file `source`; `text` is one sentence."""
    warnings.warn(f"{source}: {text}", RecordingWarning, stacklevel=3)
