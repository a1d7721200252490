"""Pictures a second that the real window reaches while the demonstration is simulated and played.

    xvfb-run -s "-screen 0 1280x720x24" python benchmarks/window.py [--seconds N] [--field NAME]

`work` is what a picture costs; `interval` is from one picture to the next, at the display's rate if the
work allows. The first second, in which buffers and shaders warm up, is left out.
"""

import argparse
import json
import time
from pathlib import Path

import numpy as np

from lingual.app.wiring import SessionRequest, build_session
from lingual.viewer.session_view import NO_FIELD
from lingual.viewer.view_options import ViewOptions
from lingual.viewer.window import ViewerWindow


def _figures(work: np.ndarray, intervals: np.ndarray, chosen: np.ndarray) -> dict[str, float]:
    work, intervals = work[chosen], intervals[chosen]
    return {
        "pictures": int(chosen.sum()),
        "frames_per_second": 1e3 / float(intervals.mean()),
        "work_ms_median": float(np.median(work)),
        "work_ms_p95": float(np.percentile(work, 95)),
        "interval_ms_p95": float(np.percentile(intervals, 95)),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seconds", type=float, default=10.0)
    parser.add_argument("--field", default=NO_FIELD)
    parser.add_argument("--json", type=Path, default=None)
    arguments = parser.parse_args()

    session = build_session(SessionRequest())
    session.start()
    window = ViewerWindow(session, width=1280, height=720, options=ViewOptions(field_name=arguments.field))
    window.panels.playback.playing = True
    work, intervals, simulating = [], [], []
    end = time.perf_counter() + arguments.seconds
    previous = time.perf_counter()
    while (now := time.perf_counter()) < end:
        window.frame()
        intervals.append(1e3 * (now - previous))
        work.append(window.panels.timing.work[-1])
        simulating.append(session.history.frame_count < session.simulation.trajectory.frame_count)
        previous = now
    renderer = window.panels.renderer
    window.close()
    session.stop()

    warm = np.cumsum(intervals) > 1000.0
    simulating = np.array(simulating)
    result = {
        "renderer": renderer,
        "while_simulating": _figures(np.array(work), np.array(intervals), warm & simulating),
        "after": _figures(np.array(work), np.array(intervals), warm & ~simulating),
        "simulation_step_ms": float(np.median(session.history.scalar("step_ms"))),
    }
    print(json.dumps(result, indent=2))
    if arguments.json:
        arguments.json.write_text(json.dumps(result, indent=2) + "\n")


if __name__ == "__main__":
    main()
