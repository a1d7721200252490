"""One run: check what was asked, simulate, and show it or write it."""

import os
from dataclasses import dataclass, field
from pathlib import Path

from ..model import LingualError
from .output import PictureSettings, check_pictures, has_display, show, write
from .report import simulation_report, write_report
from .session import Session
from .solver_options import SolverOptions
from .terminal import console, error_console, stage_bars
from .wiring import SessionRequest, build_session


@dataclass(frozen=True)
class PlayRequest:
    """The choices of one run, in the command line's terms (see `lingual replay --help`)."""

    recording: Path | None = None
    mesh: str | None = None
    solver: SolverOptions = field(default_factory=SolverOptions)
    units: str | None = None
    headless: bool = False
    out: Path | None = None
    frames: int | None = None
    report: Path | None = None
    size: str = "1280x720"
    view: str = "three-quarter"
    field: str = "none"
    cut: bool = False
    speed: float = 1.0
    time: float | None = None
    backdrop: str = "dark"
    fps: float = 50.0


def play(run: PlayRequest) -> None:
    """Simulates and shows or writes. What has been simulated is reported even when the run is interrupted.

    Raises LingualError for anything that cannot be used, before the simulation starts where it can be known.
    """
    windowed = not run.headless and run.out is None and has_display()
    out = None if windowed else _output_path(run)
    settings = _picture_settings(run, windowed)
    check_pictures(settings)
    for path in (out, run.report):
        check_writable(path)
    request = SessionRequest(run.recording, run.mesh, run.solver, run.units, run.frames)
    with stage_bars() as bars:
        session = build_session(request, bars)
        if run.field not in session.field_names():
            names = ", ".join(session.field_names())
            raise LingualError(f"There is no field '{run.field}'; choose one of: {names}.")
        if out is not None and not run.headless and run.out is None:
            error_console.print(f"There is no display; the film goes to {out.resolve()}.", soft_wrap=True)
        try:
            if windowed:
                bars.finish()
                show(session, settings)
            else:
                total = session.simulation.trajectory.frame_count
                session.simulate(lambda frame: bars("simulation", (frame + 1) / total))
                if out is not None:
                    write(session, out, settings, bars)
        finally:
            if run.report is not None:
                write_report(run.report, simulation_report(session.simulation, run.mesh or "head"))
    if not windowed:
        _summarise(session, out)


def _output_path(run: PlayRequest) -> Path | None:
    """Where pictures go: as asked; a film where no window can open; nowhere when only simulating."""
    only_simulate = run.headless and (run.recording is not None or run.report is not None)
    if run.out is not None or only_simulate:
        return run.out
    return Path(f"lingual-{run.recording.stem if run.recording else 'demonstration'}.mp4")


def _picture_settings(run: PlayRequest, windowed: bool) -> PictureSettings:
    from ..viewer.view_options import BACKDROPS, ViewOptions

    if run.backdrop not in BACKDROPS:
        raise LingualError(f"There is no background '{run.backdrop}'; choose one of {', '.join(BACKDROPS)}.")
    width, height = _parse_size(run.size)
    options = ViewOptions(field_name=run.field, cut=run.cut, backdrop=run.backdrop, show_caption=not windowed)
    return PictureSettings(width, height, run.fps, run.speed, run.view, run.time, options)


def _parse_size(text: str) -> tuple[int, int]:
    try:
        width, height = (int(part) for part in text.lower().split("x"))
    except ValueError as error:
        raise LingualError(f"--size is '{text}'; write it as WIDTHxHEIGHT, such as 1280x720.") from error
    if not (0 < width <= 16384 and 0 < height <= 16384):
        raise LingualError(f"--size is {text}; width and height must be between 1 and 16384 pixels.")
    return width, height


def check_writable(path: Path | None) -> None:
    """Refuses a path whose nearest existing folder cannot be written, before any work is done for it."""
    if path is None:
        return
    folder = path.absolute().parent
    while not folder.exists():
        folder = folder.parent
    if not folder.is_dir() or not os.access(folder, os.W_OK):
        raise LingualError(f"{path} cannot be written in {folder}; give another path.")


def _summarise(session: Session, out: Path | None) -> None:
    history = session.history
    if history.frame_count:
        step = history.scalar("step_ms")
        console.print(
            f"{history.frame_count} frames by the {session.solver_name} solver at {1e3 / step.mean():.0f} frames/s; "
            f"sensor error {history.scalar('sensor_error_mm').max():.2g} mm at most, "
            f"smallest det F {history.scalar('det_f_min').min():.2f}, "
            f"volume within {100 * abs(history.scalar('volume_ratio') - 1).max():.2f} %.",
            soft_wrap=True,
        )
    if session.notice:
        error_console.print(f"[yellow]warning:[/] {session.notice}", soft_wrap=True)
    if out is not None:
        console.print(f"Written: {out.resolve()}", soft_wrap=True)
