"""The interactive window: one loop that advances the clock, draws the scene and the panels."""

import sys
import time
from collections.abc import Iterator
from contextlib import contextmanager

from .context import is_software, renderer_name, window_context
from .detail import FULL_DETAIL, SOFTWARE_DETAIL
from .frame_timing import FrameTiming
from .glfw_library import glfw
from .glfw_window import content_scale, open_window, refresh_rate
from .gui import Gui
from .layout import arrange, draw_panels
from .panels.panel_context import PanelContext
from .playback import Playback
from .resolution import AdaptiveScale, ScaledPicture
from .scene import Scene, default_camera
from .session_view import NO_FIELD, SessionView, sample_at, simulated_until
from .theme import PANEL
from .view_options import ViewOptions
from .window_input import handle_input

_IDLE_AFTER = 0.5  # [s] without change until the window sleeps between events
_IDLE_WAIT = 0.1  # [s]


class ViewerWindow:
    """A window on a session. `frame` shows one picture; `close` frees everything.

    samples: multisampling; None takes 4 on a graphics card and none when the processor draws.

    Raises LingualError when there is no display or no OpenGL 4.1.
    """

    def __init__(
        self,
        session: SessionView,
        *,
        width: int = 1280,
        height: int = 720,
        samples: int | None = None,
        options: ViewOptions | None = None,
    ) -> None:
        self._window = open_window(session.title, width, height, samples)
        self._context = window_context()
        self._software = is_software(self._context)
        detail = SOFTWARE_DETAIL if self._software else FULL_DETAIL
        self._scene = Scene(self._context, session.model, detail)
        self._gui = Gui(self._window, content_scale(self._window))
        self._period = 1.0 / refresh_rate()
        self._scale, self._picture = AdaptiveScale(self._period), ScaledPicture(self._context)
        self._last_begin = self._last_change = self._due = time.perf_counter()
        self._shown: tuple | None = None
        self.panels = PanelContext(
            session=session,
            playback=Playback(session.duration),
            camera=default_camera(session.model),
            options=options or ViewOptions(),
            timing=FrameTiming(),
            renderer=renderer_name(self._context),
            sample=sample_at(session, 0.0),
        )

    @property
    def closed(self) -> bool:
        """Whether the user has asked to close the window."""
        return bool(glfw.window_should_close(self._window)) or self.panels.close_requested

    def frame(self) -> None:
        """Handles events and shows one picture; sleeps until the next one is due."""
        self._wait_or_poll()
        begin = time.perf_counter()
        interval, self._last_begin = begin - self._last_begin, begin
        width, height = glfw.get_framebuffer_size(self._window)
        if width < 1 or height < 1 or glfw.get_window_attrib(self._window, glfw.ICONIFIED):
            self._advance(interval)
            glfw.wait_events_timeout(_IDLE_WAIT)
            return
        self._advance(interval)
        self._draw(width, height)
        if self._software:
            self._context.finish()  # so that what the processor draws counts as work
        work = time.perf_counter() - begin
        glfw.swap_buffers(self._window)
        self.panels.timing.add(work, interval)
        if self._software:
            self._scale.add(work)
        self._pace()

    def _pace(self) -> None:
        """Sleeps until the next picture is due, where swapping buffers has not already waited for it."""
        now = time.perf_counter()
        self._due = max(self._due + self._period, now)
        time.sleep(self._due - now)

    def _advance(self, elapsed: float) -> None:
        """Moves the clock and, where something else is to be shown, fetches and uploads it."""
        panels, session, options = self.panels, self.panels.session, self.panels.options
        panels.playback.advance(elapsed, simulated_until(session), frontier_final=session.failure is not None)
        name, now = options.field_name, panels.playback.time
        wanted = (now, name, options.cut, options.show_tongue, options.show_targets, panels.playback.frontier)
        if wanted == self._shown:
            return
        self._shown, self._last_change = wanted, time.perf_counter()
        panels.sample = sample_at(session, now)
        panels.scalar = None if name == NO_FIELD else session.field(name, panels.sample)
        self._scene.update(panels.sample, panels.scalar, options)

    def _draw(self, width: int, height: int) -> None:
        """The scene first; while the device draws it, the panels, which change the next picture."""
        panels, screen = self.panels, self._context.screen
        window_width, window_height = glfw.get_window_size(self._window)
        panels.viewport = arrange(window_width, window_height)
        view, scale_x, scale_y = panels.viewport, width / window_width, height / window_height
        view_width, view_height = max(round(view.width * scale_x), 1), max(round(view.height * scale_y), 1)
        scale = self._scale.scale
        if scale < 1.0:
            self._picture.begin(max(round(scale * view_width), 1), max(round(scale * view_height), 1))
            self._scene.draw(panels.camera, view_width / view_height, panels.options)
        screen.use()
        screen.viewport = (
            round(view.left * scale_x),
            height - round(view.top * scale_y) - view_height,
            view_width,
            view_height,
        )
        screen.clear(PANEL.x, PANEL.y, PANEL.z, 1.0, depth=1.0, viewport=(0, 0, width, height))
        if scale < 1.0:
            self._picture.show()
        else:
            self._scene.draw(panels.camera, view_width / view_height, panels.options)
        self._gui.flush()
        self._gui.begin()
        draw_panels(panels, window_width, window_height)
        handle_input(panels)
        self._gui.finish()
        screen.viewport = (0, 0, width, height)
        self._gui.draw()

    def _wait_or_poll(self) -> None:
        """Spares the processor while nothing moves."""
        idle = time.perf_counter() - self._last_change > _IDLE_AFTER
        if idle and not self.panels.playback.playing:
            before = time.perf_counter()
            glfw.wait_events_timeout(_IDLE_WAIT)
            if time.perf_counter() - before < 0.95 * _IDLE_WAIT:
                self._last_change = time.perf_counter()
        else:
            glfw.poll_events()

    def close(self) -> None:
        """Frees everything on the graphics device and removes the window."""
        self._gui.release()
        self._scene.release()
        self._picture.release()
        self._context.release()
        glfw.destroy_window(self._window)
        glfw.terminate()


def run_window(
    session: SessionView,
    *,
    width: int = 1280,
    height: int = 720,
    samples: int | None = None,
    options: ViewOptions | None = None,
) -> None:
    """Opens a window on `session` and returns when the user closes it.

    Raises LingualError when there is no display or no OpenGL 4.1.
    """
    window = ViewerWindow(session, width=width, height=height, samples=samples, options=options)
    try:
        with _responsive_threads():
            while not window.closed:
                window.frame()
    finally:
        window.close()


@contextmanager
def _responsive_threads() -> Iterator[None]:
    """Makes a simulating thread hand over within a millisecond instead of five."""
    before = sys.getswitchinterval()
    sys.setswitchinterval(0.001)
    try:
        yield
    finally:
        sys.setswitchinterval(before)
