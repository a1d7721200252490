"""Where a session goes: the window, or a film, pictures or one picture without a display."""

import os
import sys
from dataclasses import dataclass
from pathlib import Path

from ..model import LingualError
from ..viewer.view_options import ViewOptions
from .session import Session
from .terminal import StageBars


@dataclass(frozen=True)
class PictureSettings:
    """How pictures are made: size [pixels], frames a second of a film, view, and what is shown."""

    width: int = 1280
    height: int = 720
    frame_rate: float = 50.0
    speed: float = 1.0
    view: str = "three-quarter"
    time: float | None = None
    options: ViewOptions | None = None


def has_display() -> bool:
    """Whether a window can be expected to open."""
    if sys.platform.startswith("linux"):
        return bool(os.environ.get("DISPLAY") or os.environ.get("WAYLAND_DISPLAY"))
    return True


def show(session: Session, settings: PictureSettings) -> None:
    """Opens the window while the simulation runs; returns when it is closed."""
    from ..viewer.window import run_window  # OpenGL is loaded only where it is used

    session.start()
    try:
        run_window(session, width=settings.width, height=settings.height, options=settings.options)
    finally:
        session.stop()


def check_pictures(settings: PictureSettings) -> None:
    """Raises LingualError for a view that there is not, or a rate or speed that is not positive."""
    from ..viewer.camera import VIEWS

    if settings.view not in VIEWS:
        raise LingualError(f"There is no view '{settings.view}'; choose one of {', '.join(VIEWS)}.")
    for option, value in (("--fps", settings.frame_rate), ("--speed", settings.speed)):
        if not 0.0 < value < float("inf"):
            raise LingualError(f"{option} is {value}; it must be positive.")


def write(session: Session, path: Path, settings: PictureSettings, bars: StageBars) -> None:
    """Writes what has been simulated: .mp4 or .gif a film, .png one picture, anything else a folder of pictures."""
    from ..viewer.movie import write_frames, write_movie, write_picture
    from ..viewer.scene import default_camera

    camera = default_camera(session.model)
    camera.look(settings.view)
    width, height, options = settings.width, settings.height, settings.options
    if path.suffix.lower() == ".png":
        time = settings.time if settings.time is not None else most_displaced_time(session)
        write_picture(session, path, time, width=width, height=height, camera=camera, options=options)
        return
    film = write_movie if path.suffix else write_frames
    film(
        session,
        path,
        width=width,
        height=height,
        frame_rate=settings.frame_rate,
        speed=settings.speed,
        camera=camera,
        options=options,
        progress=bars.counted("pictures"),
    )


def most_displaced_time(session: Session) -> float:
    """Time [s] at which the sensors are farthest from rest."""
    trajectory = session.simulation.trajectory
    moved = trajectory.positions - session.model.sensor_rest_positions
    frames = min(session.history.frame_count, trajectory.frame_count)
    farthest = (moved[:frames] ** 2).sum(axis=(1, 2)).argmax()
    return float(trajectory.time[farthest])
