"""What the user sees in the terminal: progress bars, warnings in one line, errors in one sentence."""

import logging
import warnings
from collections.abc import Iterator
from contextlib import contextmanager

from rich.console import Console
from rich.progress import BarColumn, Progress, TaskID, TextColumn, TimeElapsedColumn, TimeRemainingColumn

error_console = Console(stderr=True, highlight=False)
console = Console(highlight=False)


class StageBars:
    """One bar a stage, made when the stage first reports; a `precompute.progress.Progress`."""

    def __init__(self, progress: Progress) -> None:
        self._progress = progress
        self._tasks: dict[str, TaskID] = {}

    def __call__(self, stage: str, fraction: float) -> None:
        if stage not in self._tasks:
            self._tasks[stage] = self._progress.add_task(stage, total=1.0)
        self._progress.update(self._tasks[stage], completed=fraction)

    def finish(self) -> None:
        """Draws no more bars: a window takes over."""
        self._progress.stop()

    def counted(self, stage: str):  # type: ignore[no-untyped-def]
        """A callback (done, total) for the same bars."""
        return lambda done, total: self(stage, done / max(1, total))


@contextmanager
def stage_bars() -> Iterator[StageBars]:
    """Progress bars on the terminal (nothing is drawn where the output is not one)."""
    columns = (
        TextColumn("{task.description:<28}"),
        BarColumn(),
        TextColumn("{task.percentage:>3.0f} %"),
        TimeElapsedColumn(),
        TimeRemainingColumn(),
    )
    with Progress(*columns, console=error_console, disable=not error_console.is_terminal) as progress:
        yield StageBars(progress)


def plain_messages() -> None:
    """Sends warnings and log records to standard error, one line each, without their source."""

    def show(message, category, filename, lineno, file=None, line=None) -> None:  # type: ignore[no-untyped-def]
        error_console.print(f"[yellow]warning:[/] {message}", soft_wrap=True)

    warnings.showwarning = show
    warnings.simplefilter("default", UserWarning)
    logging.basicConfig(level=logging.WARNING, format="%(levelname)s: %(message)s")
    logging.addLevelName(logging.WARNING, "warning")
