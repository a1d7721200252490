"""Where the letters come from: the fonts that imgui-bundle carries."""

from functools import cache
from importlib.util import find_spec
from pathlib import Path

from PIL import ImageFont


@cache
def font_path(weight: str = "Regular") -> Path | None:
    """File of Roboto in `weight` ("Regular", "Bold"), without importing imgui; None where it is missing."""
    spec = find_spec("imgui_bundle")
    for folder in (spec.submodule_search_locations or ()) if spec else ():
        path = Path(folder) / "assets" / "fonts" / "Roboto" / f"Roboto-{weight}.ttf"
        if path.is_file():
            return path
    return None


@cache
def picture_font(size: float, weight: str = "Regular") -> ImageFont.FreeTypeFont | ImageFont.ImageFont:
    """The font for text in pictures, `size` in pixels."""
    path = font_path(weight)
    return ImageFont.truetype(str(path), size) if path else ImageFont.load_default(size)
