"""Drives the real window with real key and mouse events; run by test_window.py under Xvfb.

Prints "done" and exits with 0 when everything went as it should.
"""

import subprocess
import threading
import time

import numpy as np
from synthetic_session import SyntheticSession

from lingual.viewer.camera import VIEWS
from lingual.viewer.glfw_library import glfw
from lingual.viewer.scene import default_camera
from lingual.viewer.window import ViewerWindow, run_window


def xdotool(*arguments: object) -> None:
    subprocess.run(["xdotool", *map(str, arguments)], check=True, timeout=20)


class Driver:
    """A window and the events sent to it."""

    def __init__(self, session: SyntheticSession) -> None:
        self.window = ViewerWindow(session, width=900, height=640)
        self.panels = self.window.panels
        self.frames(3)
        xdotool("windowfocus", glfw.get_x11_window(self.window._window))
        self.frames(3)

    def frames(self, count: int = 8) -> None:
        for _ in range(count):
            self.window.frame()

    def key(self, *names: str) -> None:
        for name in names:
            xdotool("key", name)
            self.frames()

    def drag(self, start: tuple[float, float], end: tuple[float, float], button: int = 1) -> None:
        xdotool("mousemove", round(start[0]), round(start[1]))
        self.frames(3)
        xdotool("mousedown", button)
        self.frames(3)
        xdotool("mousemove", round(end[0]), round(end[1]))
        self.frames(3)
        xdotool("mouseup", button)
        self.frames(3)


def check_playback(driver: Driver) -> None:
    playback = driver.panels.playback
    assert playback.playing
    before = playback.time
    driver.frames(4)
    assert playback.time != before
    driver.key("space")
    assert not playback.playing
    playback.seek(0.30)
    driver.key("Right", "Right", "Left")
    assert abs(playback.time - 0.31) < 1e-9, playback.time
    driver.key("Up")
    assert playback.speed == 2.0
    driver.key("Down", "Down", "l", "Home")
    assert (playback.speed, playback.loop, playback.time) == (0.5, False, 0.0)


def check_scrubbing(driver: Driver) -> None:
    view = driver.panels.viewport
    y = view.height + 22
    driver.drag((0.2 * view.width, y), (0.5 * view.width, y))
    assert abs(driver.panels.playback.time - 0.5) < 0.02, driver.panels.playback.time
    assert not driver.panels.playback.playing


def check_camera(driver: Driver) -> None:
    view, session = driver.panels.viewport, driver.panels.session
    middle = (0.5 * view.width, 0.5 * view.height)
    rest = default_camera(session.model)
    driver.drag(middle, (middle[0] + 60, middle[1] + 30))
    assert abs(driver.panels.camera.azimuth - rest.azimuth) > 0.1
    driver.drag(middle, (middle[0] + 60, middle[1]), button=3)
    assert np.linalg.norm(driver.panels.camera.target - rest.target) > 1e-3
    xdotool("click", 4)
    driver.frames()
    assert driver.panels.camera.distance < rest.distance
    driver.key("r")
    assert driver.panels.camera.azimuth == rest.azimuth
    assert np.all(driver.panels.camera.target == rest.target)
    for i, (name, (azimuth, _)) in enumerate(VIEWS.items()):
        driver.key(str(i + 1))
        assert abs(np.rad2deg(driver.panels.camera.azimuth) - azimuth) < 1e-6, name


def check_options(driver: Driver) -> None:
    options, session = driver.panels.options, driver.panels.session
    for name in (*session.field_names()[1:], session.field_names()[0]):
        driver.key("f")
        assert options.field_name == name
        assert (driver.panels.scalar is None) == (name == "none")
    driver.key("c", "n")
    assert options.cut
    assert not options.show_labels
    session.failure = "Step 31 at 0.31 s did not converge."
    driver.frames()
    session.failure, session.notice = None, "2 frames did not converge."
    driver.frames()
    session.notice = None


def check_sizes(driver: Driver) -> None:
    handle = driver.window._window
    for size in ((1, 1), (30, 400), (500, 20), (900, 640)):
        glfw.set_window_size(handle, *size)
        driver.frames(5)
    glfw.iconify_window(handle)
    driver.frames(3)
    glfw.restore_window(handle)
    driver.frames(3)


def check_closing_while_simulating() -> None:
    """The user closes the window mid-playback while a thread still simulates."""
    session = SyntheticSession(duration=60.0, simulated=-1.0)
    stop = threading.Event()

    def simulate() -> None:
        while not stop.is_set():
            session.simulate_until(session.history.frame_count / 100.0)
            time.sleep(0.01)

    def close_soon() -> None:
        while session.history.frame_count < 30:
            time.sleep(0.05)
        xdotool("search", "--name", "Lingual", "windowfocus", "key", "ctrl+q")

    threads = [threading.Thread(target=simulate), threading.Thread(target=close_soon)]
    for thread in threads:
        thread.start()
    run_window(session, width=500, height=400)
    stop.set()
    for thread in threads:
        thread.join()
    assert session.history.frame_count >= 30


def main() -> None:
    driver = Driver(SyntheticSession())
    check_playback(driver)
    check_scrubbing(driver)
    check_camera(driver)
    check_options(driver)
    check_sizes(driver)
    driver.key("space")
    driver.window.close()
    check_closing_while_simulating()
    print("done")


if __name__ == "__main__":
    main()
