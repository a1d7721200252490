"""Freeing what lives on the graphics device."""

from typing import Protocol


class Releasable(Protocol):
    """Anything with graphics memory of its own."""

    def release(self) -> None: ...


def release_all(*items: Releasable | None) -> None:
    """Frees the items in this order; None is passed over."""
    for item in items:
        if item is not None:
            item.release()
