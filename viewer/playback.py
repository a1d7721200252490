"""The playback clock: when to show, given how far the simulation has got. No graphics here."""

from dataclasses import dataclass

SPEEDS = (0.05, 0.1, 0.25, 0.5, 1.0, 2.0, 4.0)
"""Playback speeds offered to the user, as factors of real time."""

FRAME_STEP = 0.01
"""Simulation step [s], by which the arrow keys move."""


@dataclass
class Playback:
    """Time on screen.

    duration: end of the trajectory [s]. time: what is shown [s]. frontier: simulated so far [s]; time
    never passes it. playing, loop: as they say. speed: factor of real time. waiting: playing, but the
    simulation is not there yet.
    """

    duration: float
    time: float = 0.0
    frontier: float = 0.0
    playing: bool = True
    loop: bool = True
    speed: float = 1.0
    waiting: bool = False

    def advance(self, elapsed: float, frontier: float, *, frontier_final: bool = False) -> None:
        """Moves on by `elapsed` seconds of the wall clock.

        frontier: time simulated so far [s]. frontier_final: it will not move any more (finished, failed),
        so that playback ends or loops there instead of waiting.
        """
        self.frontier = frontier
        end = min(self.duration, frontier) if frontier_final else self.duration
        self.waiting = False
        if self.playing:
            self.time += max(elapsed, 0.0) * self.speed
            if self.time >= end and frontier >= end:
                self._finish(end)
            elif self.time > frontier:
                self.waiting = True
        self.time = min(max(self.time, 0.0), frontier)

    def _finish(self, end: float) -> None:
        if self.loop and end > 0.0:
            self.time = 0.0
        else:
            self.time, self.playing = end, False

    def toggle(self) -> None:
        """Plays or pauses; at the end, plays from the beginning."""
        if not self.playing and self.time >= self.duration - 1e-9:
            self.time = 0.0
        self.playing = not self.playing

    def step(self, frames: int) -> None:
        """Pauses and moves by whole simulation frames, backwards when negative."""
        self.seek((round(self.time / FRAME_STEP) + frames) * FRAME_STEP)
        self.playing = False

    def seek(self, time: float) -> None:
        """Shows `time` [s], as near as the simulation has got."""
        self.time = min(max(time, 0.0), self.duration, self.frontier)

    def rewind(self) -> None:
        """Back to the beginning."""
        self.time = 0.0

    def faster(self, notches: int) -> None:
        """Moves along SPEEDS from the nearest one."""
        nearest = min(range(len(SPEEDS)), key=lambda i: abs(SPEEDS[i] - self.speed))
        self.speed = SPEEDS[min(max(nearest + notches, 0), len(SPEEDS) - 1)]
