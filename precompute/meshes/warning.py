"""What was repaired or assumed about a mesh: shown to the user, never silent, never fatal."""

import warnings


class MeshWarning(UserWarning):
    """A mesh is used, but not as it stands in its file; the message says what was done."""


def warn(source: object, text: str) -> None:
    """Issues a MeshWarning about the file `source`; `text` is one sentence."""
    warnings.warn(f"{source}: {text}", MeshWarning, stacklevel=3)
