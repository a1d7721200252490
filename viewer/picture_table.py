"""Rows of stills in one picture, side by side, with names, a title for each row and its colour bars."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from numpy.typing import NDArray

from .camera import framing
from .movie import save_picture
from .offscreen import OffscreenRenderer
from .overlay import INK, Sprite, colour_bar_sprite, paste, text_sprite
from .session_view import ScalarField
from .stills import PictureRow, StillSession
from .view_options import ViewOptions

_BAR_SHARE = 0.36  # width of one colour bar with its ticks, in cells
_TITLE_SHARE = 0.13  # height of a row's title and of a still's name, in cells
_HIDDEN_TISSUES = dict.fromkeys(("bone", "tooth", "mucosa"), False)


def picture_table(
    rows: Sequence[PictureRow], cell: tuple[int, int] = (380, 285), backdrop: str = "light"
) -> NDArray[np.uint8]:
    """The rows below each other, (height, width, 4) RGBA; cell: width and height of one still [pixels].

    Raises LingualError when nothing can be drawn on this machine.
    """
    return np.vstack(_equally_wide([_row_picture(row, cell, backdrop) for row in rows]))


def write_picture_table(path: Path, rows: Sequence[PictureRow], cell: tuple[int, int] = (380, 285)) -> Path:
    """Writes the table as a picture (PNG, or what Pillow makes of the ending).

    Raises LingualError when it cannot be drawn or written.
    """
    save_picture(picture_table(rows, cell), path)
    return path


def _row_picture(row: PictureRow, cell: tuple[int, int], backdrop: str) -> NDArray[np.uint8]:
    width, height = cell
    session = StillSession(row.model, row.stills)
    everything = np.concatenate([row.model.skin.vertices(still.nodes) for still in row.stills])
    camera = framing(everything, row.view, width / height)
    options = ViewOptions(
        show_tissue=_HIDDEN_TISSUES, show_sensors=False, show_targets=False, show_colour_bar=False, backdrop=backdrop
    )
    ink = INK[backdrop]
    cells = []
    with OffscreenRenderer(session, width, height) as renderer:
        for k, still in enumerate(row.stills):
            picture = renderer.render(float(k), camera=camera, field=session.field_name(k), options=options).copy()
            line = _plain(round(_TITLE_SHARE * height), width, picture)
            name = _fitting_text(still.name, 0.066 * height, 0.98 * width, ink)
            paste(line, name, (width - name.shape[1]) // 2, round(0.03 * height))
            cells.append(np.vstack([picture, line]))
    bars = {(s.title, s.span, s.categories): s for s in (still.scalar for still in row.stills) if s is not None}
    cells += [_bar(scalar, round(_BAR_SHARE * width), height, backdrop, cells[0]) for scalar in bars.values()]
    body = np.hstack(cells)
    title = _plain(round(_TITLE_SHARE * height), body.shape[1], body)
    paste(title, text_sprite(row.title, 0.078 * height, ink), round(0.05 * width), round(0.03 * height))
    return np.vstack([title, body])


def _fitting_text(text: str, size: float, width: float, ink: tuple[int, int, int]) -> Sprite:
    """Text of that size [pixels], or smaller where it would be wider than `width`."""
    sprite = text_sprite(text, size, ink)
    return sprite if sprite.shape[1] <= width else text_sprite(text, size * width / sprite.shape[1], ink)


def _bar(
    scalar: ScalarField, width: int, height: int, backdrop: str, like: NDArray[np.uint8]
) -> NDArray[np.uint8]:
    """A colour bar beside cells as tall as `like`."""
    picture = _plain(len(like), width, like)
    sprite = colour_bar_sprite(scalar, round(1.9 * height), INK[backdrop])
    paste(picture, sprite, round(0.92 * width) - sprite.shape[1], round(0.08 * height))
    return picture


def _plain(height: int, width: int, like: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """A picture of the colour in another's top corner."""
    return np.tile(like[0, 0], (height, width, 1))


def _equally_wide(pictures: list[NDArray[np.uint8]]) -> list[NDArray[np.uint8]]:
    """Pictures (height, width, 4) filled up at their right edges to the widest."""
    widest = max(picture.shape[1] for picture in pictures)
    return [np.hstack([p, _plain(len(p), widest - p.shape[1], p)]) for p in pictures]
