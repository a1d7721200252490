"""The real window, under Xvfb, driven by real events in another process."""

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest

HERE = Path(__file__).parent


@pytest.fixture(scope="module")
def display():
    """Number of a virtual screen of this test's own."""
    for program in ("Xvfb", "xdotool"):
        if shutil.which(program) is None:
            pytest.skip(f"{program} is not installed (apt-get install xvfb xdotool)")
    read_end, write_end = os.pipe()
    server = subprocess.Popen(
        ["Xvfb", "-displayfd", str(write_end), "-screen", "0", "1280x800x24", "-nolisten", "tcp"],
        pass_fds=[write_end], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL,
    )  # fmt: skip
    os.close(write_end)
    with os.fdopen(read_end) as pipe:
        number = pipe.readline().strip()
    if not number:
        server.wait()
        pytest.skip("Xvfb does not start here")
    yield f":{number}"
    server.terminate()
    server.wait()


def run(arguments, environment):
    return subprocess.run(
        [sys.executable, *arguments], env=environment, capture_output=True, text=True, timeout=120, cwd=HERE
    )


def test_the_window_plays_steps_scrubs_turns_resizes_and_closes(display):
    done = run(["drive_window.py"], {**os.environ, "DISPLAY": display})
    assert done.returncode == 0, done.stderr
    assert done.stdout.strip() == "done"
    assert done.stderr == ""


def test_without_a_display_one_sentence_says_what_to_do():
    hidden = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY")}
    code = (
        "from synthetic_session import SyntheticSession\n"
        "from lingual.model import LingualError\n"
        "from lingual.viewer.window import run_window\n"
        "try:\n    run_window(SyntheticSession(0.1))\n"
        "except LingualError as error:\n    print(error)\n"
    )
    done = run(["-c", code], hidden)
    assert done.returncode == 0, done.stderr
    assert "--headless" in done.stdout


def test_importing_the_viewer_opens_nothing():
    code = (
        "import sys, lingual.viewer.session_view\n"
        "print(sorted({'moderngl', 'glfw', 'imgui_bundle'} & set(sys.modules)))"
    )
    assert run(["-c", code], dict(os.environ)).stdout.strip() == "[]"
