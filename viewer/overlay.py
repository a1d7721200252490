"""Text and colour bar over pictures made without a window.

Everything is a sprite, drawn once by Pillow and kept, then pasted into each picture.
"""

from functools import lru_cache

import numpy as np
from numpy.typing import NDArray
from PIL import Image, ImageDraw

from .colour_bar import labelled_ticks, listed
from .colour_map import colour_table
from .fonts import picture_font
from .session_view import ScalarField

INK = {"dark": (232, 236, 242), "light": (38, 44, 54), "transparent": (120, 128, 140)}
"""Colour of text by backdrop, sRGB."""

Sprite = NDArray[np.uint16]
"""(height, width, 4): colour premultiplied by alpha, alpha, 0 to 255."""


def paste(picture: NDArray[np.uint8], sprite: Sprite, x: int, y: int) -> None:
    """Blends a sprite into an RGBA picture with its top left corner at column x, row y; clips at edges."""
    height, width = picture.shape[:2]
    left, top = max(x, 0), max(y, 0)
    right, bottom = min(x + sprite.shape[1], width), min(y + sprite.shape[0], height)
    if right <= left or bottom <= top:
        return
    part = sprite[top - y : bottom - y, left - x : right - x]
    under = picture[top:bottom, left:right]
    under[:] = part + (under * (255 - part[..., 3:]) + 127) // 255


@lru_cache(maxsize=256)
def text_sprite(text: str, size: float, ink: tuple[int, int, int], plate: bool = False) -> Sprite:
    """Text of `size` pixels; `plate` puts a dark translucent rounded plate behind it."""
    font = picture_font(size)
    left, _, right, _ = font.getbbox(text)
    pad_x, pad_y = (round(0.45 * size), round(0.28 * size)) if plate else (1, 1)
    ascent = round(0.75 * size)
    width, height = round(right - left) + 2 * pad_x, ascent + 2 * pad_y + (0 if plate else round(0.3 * size))
    image = Image.new("RGBA", (width, height), (*ink, 0))
    draw = ImageDraw.Draw(image)
    if plate:
        draw.rounded_rectangle((0, 0, width - 1, height - 1), radius=0.3 * height, fill=(16, 19, 24, 150))
        text_layer = Image.new("RGBA", image.size, (*ink, 0))
        ImageDraw.Draw(text_layer).text((pad_x - left, pad_y + ascent), text, (*ink, 255), font, anchor="ls")
        image.alpha_composite(text_layer)
    else:
        draw.text((pad_x - left, pad_y + ascent), text, (*ink, 255), font, anchor="ls")
    return _premultiplied(image)


def colour_bar_sprite(scalar: ScalarField, height: int, ink: tuple[int, int, int]) -> Sprite:
    """The scalar's colour map with title, unit and ticks, or its categories, for a picture `height` pixels tall."""
    if scalar.categories:
        return _category_list(scalar.title, scalar.categories, height, ink)
    return _colour_bar(scalar.title, scalar.span, scalar.map_name, height, ink)


@lru_cache(maxsize=32)
def _colour_bar(
    title: str, span: tuple[float, float], map_name: str, height: int, ink: tuple[int, int, int]
) -> Sprite:
    unit = max(height / 720.0, 0.5)
    size, bar_width, bar_height = round(17 * unit), round(16 * unit), round(0.36 * height)
    font = picture_font(size)
    labels = labelled_ticks(*span)
    title_width = round(font.getlength(title))
    label_width = max((round(font.getlength(text)) for _, text in labels), default=0)
    width = max(title_width, bar_width + label_width + 2 * size) + 4
    top = round(1.9 * size)
    image = Image.new("RGBA", (width, top + bar_height + size), (*ink, 0))
    draw = ImageDraw.Draw(image)
    draw.text((width - 2, round(0.95 * size)), title, (*ink, 255), font, anchor="rs")
    right = width - 2
    colours = colour_table(map_name, bar_height)[::-1]
    column = np.column_stack([colours, np.full(bar_height, 255, np.uint8)])
    ramp = np.repeat(column[:, None], bar_width, axis=1)
    mask = Image.new("L", (bar_width, bar_height), 0)
    ImageDraw.Draw(mask).rounded_rectangle((0, 0, bar_width - 1, bar_height - 1), radius=3 * unit, fill=255)
    image.paste(Image.fromarray(ramp, "RGBA"), (right - bar_width, top), mask)
    for at, text in labels:
        y = top + (1.0 - at) * (bar_height - 1)
        x = right - bar_width - round(5 * unit)
        draw.line((x, y, x + round(4 * unit), y), (*ink, 200), max(1, round(unit)))
        draw.text((x - round(4 * unit), y), text, (*ink, 255), font, anchor="rm")
    return _premultiplied(image)


@lru_cache(maxsize=32)
def _category_list(title: str, categories: tuple[str, ...], height: int, ink: tuple[int, int, int]) -> Sprite:
    """Title and a swatch with its name for each category, as many as fit into a picture's height."""
    unit = max(height / 720.0, 0.5)
    size = round(17 * unit)
    line = round(1.45 * size)
    room = max(1, int(0.9 * height / line) - 2)
    texts = listed(categories, room)
    font = picture_font(size)
    width = round(max(font.getlength(text) for text in (title, *texts))) + 2 * size + 4
    image = Image.new("RGBA", (width, line * (len(texts) + 1) + size), (*ink, 0))
    draw = ImageDraw.Draw(image)
    draw.text((width - 2, round(0.95 * size)), title, (*ink, 255), font, anchor="rs")
    colours = colour_table("categories")
    for k, text in enumerate(texts):
        y = line * (k + 1) + size
        draw.text((width - 2 - round(1.4 * size), y), text, (*ink, 255), font, anchor="rs")
        if k < len(categories) and text == categories[k]:
            swatch = (width - 2 - size, y - round(0.8 * size), width - 2, y + round(0.1 * size))
            draw.rounded_rectangle(swatch, radius=3 * unit, fill=(*map(int, colours[k]), 255))
    return _premultiplied(image)


def _premultiplied(image: Image.Image) -> Sprite:
    pixels = np.asarray(image, dtype=np.uint16).copy()
    pixels[..., :3] = (pixels[..., :3] * pixels[..., 3:] + 127) // 255
    return pixels
