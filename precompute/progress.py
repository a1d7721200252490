"""How long work tells its caller how far it has got."""

from collections.abc import Callable

Progress = Callable[[str, float], None]
"""Called with the stage's name and the fraction of it that is done, 0 to 1."""


def silent(stage: str, fraction: float) -> None:
    """Reports nothing."""
