"""The `lingual` command: what it does, and one sentence and exit code 2 for what it cannot."""

import json
import subprocess
import sys

import pytest

from lingual import __version__
from lingual.app.simulation import Simulation
from lingual.precompute import reduction

REPORT_KEYS = {
    "solver", "mesh", "node_count", "tet_count", "dof_count", "frame_count", "step_ms", "frames_per_second",
    "volume_drift_max", "det_f_min", "sensor_error_mm_max", "newton_iterations_mean", "inverted_tet_count_max",
    "penetration_mm_max", "contact_points", "volume_mode", "material",
}  # fmt: skip
EXTRA_KEYS = {"contact_count_max", "source", "unconverged_frames", "halved_frame_count", "machine"}


@pytest.fixture
def replay(lingual, wedge_file, tmp_path):
    """Function (*arguments) -> exit code, report: the wedge moved by the demonstration, without pictures."""

    def run(*arguments):
        report = tmp_path / "folder" / "report.json"
        code, _, err = lingual(
            "replay", "--mesh", wedge_file, "--units", "mm", "--headless", "--report", report, *arguments
        )
        assert "Traceback" not in err
        return code, json.loads(report.read_text())

    return run


@pytest.mark.parametrize(
    ("command", "words"),
    [
        ((), ["physically simulated tongue", "replay", "precompute", "info", "--headless", "--out"]),
        (("replay",), ["--mesh", "--solver", "--frames", "--report", "--headless", "--out", "reduced|full"]),
        (("precompute",), ["--mesh", "--domains"]),
        (("info",), ["--mesh", "--units"]),
    ],
)  # fmt: skip
def test_help_names_every_option(lingual, command, words):
    code, out, _ = lingual(*command, "--help")
    assert code == 0
    for word in words:
        assert word in out


def test_version(lingual):
    assert lingual("--version")[:2] == (0, f"lingual {__version__}\n")


@pytest.mark.parametrize(("solver", "dofs"), [("full", 660), ("reduced", 150)])
def test_replay_writes_the_report_that_the_issue_asks_for(replay, solver, dofs):
    code, report = replay("--solver", solver, "--frames", "25")
    assert code == 0
    assert set(report) == REPORT_KEYS | EXTRA_KEYS
    assert (report["solver"], report["frame_count"], report["dof_count"]) == (solver, 25, dofs)
    assert (report["node_count"], report["tet_count"]) == (270, 960)
    assert set(report["step_ms"]) == {"median", "p95"}
    assert 0.0 < report["step_ms"]["median"] <= report["step_ms"]["p95"]
    assert report["sensor_error_mm_max"] < 0.01
    assert report["unconverged_frames"] == []
    assert 0.0 < report["det_f_min"] < 1.0
    assert report["newton_iterations_mean"] > 1.0


def test_a_recording_of_a_file_is_replayed(replay, write_luo, luo_rows):
    recording = write_luo(luo_rows[:60])
    code, report = replay(recording, "--solver", "full", "--frames", "4")
    assert code == 0
    assert report["frame_count"] == 4
    assert recording.name in report["source"]


def wrong(*arguments, says):
    return pytest.param(arguments, says, id=" ".join(arguments))


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        wrong("--solver", "magic", says="no solver 'magic'; choose one of reduced, full"),
        wrong("missing.txt", says="no file missing.txt"),
        wrong("empty.txt", says="empty.txt is empty"),
        wrong("noise.txt", says="noise.txt"),
        wrong("--size", "12by7", says="--size is '12by7'; write it as WIDTHxHEIGHT"),
        wrong("--size", "0x720", says="must be between 1 and 16384"),
        wrong("--field", "charm", says="no field 'charm'; choose one of: none, displacement"),
        wrong("--backdrop", "blue", says="no background 'blue'"),
        wrong("--frames", "0", says="--frames is 0"),
        wrong("--frames", "many", says="Invalid value for '--frames'"),
        wrong("--domains", "2", "--solver", "reduced", says="2 domains are too few"),
        wrong("--mesh", "nowhere", says="no mesh 'nowhere'"),
        wrong("--mesh", "folder", says="no mesh in folder"),
        wrong("--mesh", "cut.ele", says="cut.node, line 17: the file ends after 16 points"),
        wrong("--units", "furlong", says="'furlong' is not known"),
        wrong("--report", "empty.txt/report.json", says="empty.txt/report.json cannot be written"),
        wrong("--nonsense", says="No such option: --nonsense"),
        wrong("--view", "inside", says="no view 'inside'"),
        wrong("--fps", "0", says="--fps is 0.0; it must be positive"),
        wrong("--speed", "-1", says="--speed is -1.0; it must be positive"),
        wrong("--out", "empty.txt/film.mp4", says="empty.txt/film.mp4 cannot be written"),
    ],
)
def test_a_mistake_gets_one_sentence_and_exit_code_2(lingual, wedge_file, tmp_path, arguments, says):
    (tmp_path / "folder").mkdir()
    (tmp_path / "empty.txt").write_text("")
    (tmp_path / "noise.txt").write_bytes(b"\x00\xff\x10 noise")
    (tmp_path / "cut.node").write_text((tmp_path / "tongue.node").read_text()[:400])
    (tmp_path / "cut.ele").write_text((tmp_path / "tongue.ele").read_text())
    code, _, err = lingual(
        "replay", "--headless", "--solver", "full", "--frames", "1", "--mesh", wedge_file, "--units", "mm", *arguments
    )
    errors = [line for line in err.splitlines() if not line.startswith("warning:")]
    assert code == 2
    assert len(errors) == 1
    assert errors[0].startswith("error: ")
    assert says in errors[0]


def test_an_unknown_command_is_a_usage_error(lingual):
    code, _, err = lingual("sing")
    assert code == 2
    assert err.startswith("error: No such command 'sing'")


def test_frames_already_simulated_are_in_the_report_when_the_run_is_interrupted(
    lingual, wedge_file, tmp_path, monkeypatch
):
    """As by Ctrl-C."""
    record = Simulation._record

    def interrupted(self, frame, *others):
        if frame == 4:
            raise KeyboardInterrupt
        record(self, frame, *others)

    monkeypatch.setattr(Simulation, "_record", interrupted)
    code, _, _ = lingual(
        "replay", "--mesh", wedge_file, "--units", "mm", "--solver", "full", "--headless", "--report", "r.json"
    )
    assert code == 130
    assert json.loads((tmp_path / "r.json").read_text())["frame_count"] == 4


def test_precompute_says_what_it_made_and_the_next_call_finds_it(lingual, wedge_file, monkeypatch):
    monkeypatch.setattr("lingual.precompute.reduction.HELD_OUT_POSES", 4)
    arguments = ("precompute", "--mesh", wedge_file, "--units", "mm")
    code, out, _ = lingual(*arguments)
    assert code == 0
    assert "5 domains, 150 degrees of freedom" in out
    assert "elements as cubature (force error" in " ".join(out.split())
    monkeypatch.setattr("lingual.precompute.reduction._reduce", None)  # would fail if it were called
    assert lingual(*arguments)[1] == out


def test_recordings_train_a_model_of_their_own(lingual, wedge_file, write_luo, luo_rows, monkeypatch):
    """Poses of the recordings are used, and the model is not taken for the one without."""
    monkeypatch.setattr("lingual.precompute.reduction.HELD_OUT_POSES", 4)
    seen = []
    original = reduction._reduce

    def watched(tongue, settings, recordings, progress):
        seen.append([r.source for r in recordings])
        return original(tongue, settings, recordings, progress)

    monkeypatch.setattr(reduction, "_reduce", watched)
    path = str(write_luo(luo_rows))
    arguments = ("precompute", "--mesh", wedge_file, "--units", "mm")
    assert [lingual(*arguments)[0], lingual(*arguments, "--train-on", path)[0]] == [0, 0]
    assert seen == [[], [path]]
    code, _, err = lingual(*arguments, "--train-on", "missing.txt")
    assert code == 2
    assert "no file missing.txt" in err


def test_info_describes_mesh_and_machine(lingual, wedge_file):
    code, out, _ = lingual("info", "--mesh", wedge_file, "--units", "mm")
    assert code == 0
    for word in ("270, 960", "80.0 x 40.0 x 45.0 mm", "sensor TT", "Warp devices"):
        assert word in out


def test_the_installed_command_exits_with_2_and_prints_no_traceback():
    run = subprocess.run(
        [sys.executable, "-m", "lingual.app", "replay", "--headless", "--solver", "magic"],
        capture_output=True,
        text=True,
    )
    assert (run.returncode, run.stdout) == (2, "")
    assert run.stderr == "error: There is no solver 'magic'; choose one of reduced, full, modal-warping.\n"


def test_the_demonstration_moves_the_shipped_head_in_full_space(lingual):
    code, _, err = lingual("replay", "--headless", "--solver", "full", "--frames", "3", "--report", "r.json")
    assert code == 0, err


@pytest.mark.slow
def test_the_demonstration_moves_the_shipped_head_in_the_subspace(lingual, tmp_path):
    """With everything precomputed from nothing, as on a user's first run."""
    code, out, err = lingual("replay", "--headless", "--frames", "60", "--report", "r.json")
    assert (code, err) == (0, "")
    assert "60 frames by the reduced solver" in out
    report = json.loads((tmp_path / "r.json").read_text())
    assert set(report) == REPORT_KEYS | EXTRA_KEYS
    assert report["mesh"] == "head"
    assert report["dof_count"] == 150
    assert report["inverted_tet_count_max"] == 0
    assert report["unconverged_frames"] == []
    assert report["sensor_error_mm_max"] < 0.01
