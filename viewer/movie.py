"""Sessions as files: H.264 films, animated GIFs, numbered PNG pictures and single pictures."""

from collections.abc import Callable, Iterator
from pathlib import Path

import imageio_ffmpeg
import numpy as np
from numpy.typing import NDArray
from PIL import Image

from ..model import LingualError
from .camera import Camera
from .offscreen import OffscreenRenderer
from .session_view import SessionView, simulated_until
from .view_options import ViewOptions

Progress = Callable[[int, int], None]
"""Called after each picture with (pictures done, pictures in all)."""

_CODECS = {
    ".mp4": ("libx264", "-crf 17 -preset veryfast -pix_fmt yuv420p -movflags +faststart"),
    ".gif": (
        "gif",
        "-vf split[a][b];[a]palettegen=stats_mode=diff[p];[b][p]paletteuse=dither=bayer:bayer_scale=4",
    ),
}
"""By ending: ffmpeg's codec and parameters."""


def write_movie(
    session: SessionView,
    path: str | Path,
    *,
    width: int = 1280,
    height: int = 720,
    frame_rate: float = 50.0,
    speed: float = 1.0,
    start: float = 0.0,
    end: float | None = None,
    camera: Camera | None = None,
    options: ViewOptions | None = None,
    progress: Progress | None = None,
) -> Path:
    """Films what has been simulated and returns the file's path.

    path: ".mp4" (H.264, yuv420p, which needs even sizes: odd ones grow by a pixel) or ".gif".
    frame_rate [1/s]; speed: factor of real time; start, end [s]: the part to film, None for all.

    Raises LingualError for another kind of file or one that cannot be written.
    """
    path = Path(path)
    if path.suffix.lower() not in _CODECS:
        raise LingualError(f"{path}: a film is written as .mp4 or .gif; give it one of these endings.")
    codec, parameters = _CODECS[path.suffix.lower()]
    times = frame_times(session, frame_rate, speed, start, end)
    size = (width + width % 2, height + height % 2)
    _make_folder(path.parent)
    _check_writable(path)
    writer = imageio_ffmpeg.write_frames(
        str(path), size, pix_fmt_in="rgba", fps=frame_rate, codec=codec, pix_fmt_out=None, quality=None,
        output_params=parameters.split(), macro_block_size=1, ffmpeg_log_level="error",
    )  # fmt: skip
    try:
        writer.send(None)
        for picture in _pictures(session, times, size, camera, options, progress):
            writer.send(np.ascontiguousarray(picture))
    except OSError as error:
        raise LingualError(f"{path}: the film cannot be written ({_last_line(error)}).") from error
    finally:
        writer.close()
    return path


def write_frames(
    session: SessionView,
    folder: str | Path,
    *,
    width: int = 1280,
    height: int = 720,
    frame_rate: float = 50.0,
    speed: float = 1.0,
    start: float = 0.0,
    end: float | None = None,
    camera: Camera | None = None,
    options: ViewOptions | None = None,
    progress: Progress | None = None,
) -> list[Path]:
    """Writes the film as pictures frame_0000.png, ... into `folder` and returns their paths."""
    folder = Path(folder)
    _make_folder(folder)
    times = frame_times(session, frame_rate, speed, start, end)
    paths = []
    for i, picture in enumerate(_pictures(session, times, (width, height), camera, options, progress)):
        paths.append(folder / f"frame_{i:04d}.png")
        save_picture(picture, paths[-1])
    return paths


def write_picture(
    session: SessionView,
    path: str | Path,
    time: float,
    *,
    width: int = 1280,
    height: int = 720,
    camera: Camera | None = None,
    options: ViewOptions | None = None,
) -> Path:
    """Writes one picture at `time` [s] (PNG, or what Pillow makes of the file's ending)."""
    path = Path(path)
    with OffscreenRenderer(session, width, height) as renderer:
        save_picture(renderer.render(time, camera=camera, options=options), path)
    return path


def frame_times(
    session: SessionView, frame_rate: float, speed: float, start: float, end: float | None
) -> NDArray[np.float64]:
    """Times of a film's pictures [s], from `start` to `end` or as far as the simulation has got."""
    if not (frame_rate > 0.0 and speed > 0.0):
        raise LingualError(f"A film of {frame_rate} frames/s at speed {speed} cannot be made: give more than 0.")
    last = min(simulated_until(session), np.inf if end is None else end)
    if last < start:
        raise LingualError(f"Nothing to film: the simulation ends at {last:.2f} s, before {start:.2f} s.")
    step = speed / frame_rate
    count = int(np.floor((last - start) / step + 1e-6)) + 1
    return np.float64(start) + step * np.arange(count, dtype=np.float64)


def _pictures(
    session: SessionView,
    times: NDArray[np.float64],
    size: tuple[int, int],
    camera: Camera | None,
    options: ViewOptions | None,
    progress: Progress | None,
) -> Iterator[NDArray[np.uint8]]:
    """The film's pictures one after the other, (height, width, 4) each."""
    with OffscreenRenderer(session, *size) as renderer:
        for i, time in enumerate(times):
            yield renderer.render(float(time), camera=camera, options=options)
            if progress is not None:
                progress(i + 1, len(times))


def _make_folder(folder: Path) -> None:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError as error:
        raise LingualError(f"{folder}: the folder cannot be made ({error.strerror}).") from error


def _check_writable(path: Path) -> None:
    try:
        path.open("ab").close()
    except OSError as error:
        raise LingualError(f"{path}: the film cannot be written ({error.strerror}).") from error


def save_picture(picture: NDArray[np.uint8], path: Path) -> None:
    """Writes a picture (height, width, 4) with premultiplied alpha, as PNG or what Pillow makes of the ending.

    Raises LingualError when the file cannot be written.
    """
    _make_folder(path.parent)
    opaque = bool((picture[..., 3] == 255).all())
    image = Image.fromarray(picture[..., :3] if opaque else _straight_alpha(picture))
    try:
        image.save(path, compress_level=4)  # of PNG; other formats ignore it
    except (OSError, ValueError) as error:
        raise LingualError(f"{path}: the picture cannot be written ({_last_line(error)}).") from error


def _straight_alpha(picture: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Undoes the premultiplication, as PNG wants it."""
    alpha = np.maximum(picture[..., 3:].astype(np.uint16), 1)
    colour = np.minimum(picture[..., :3] * np.uint16(255) // alpha, 255).astype(np.uint8)
    return np.concatenate([colour, picture[..., 3:]], axis=-1)


def _last_line(error: Exception) -> str:
    lines = [line.strip() for line in str(error).splitlines() if line.strip()]
    return lines[-1] if lines else type(error).__name__
