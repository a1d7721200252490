"""`lingual compare`: two or three short runs, their table, JSON and pictures, and what is refused before any run."""

import json
from dataclasses import replace

import numpy as np
import pytest
from rich.console import Console

from lingual.analysis.solver_comparison import SolverRun, surface_distance
from lingual.app import compare as module
from lingual.app.compare import ComparedRun, comparison_report, comparison_table
from lingual.app.comparison_plots import write_plots
from lingual.app.report import simulation_report
from lingual.app.simulation import Simulation
from lingual.model import LingualError
from lingual.solver.full_space import SolverFullSpace

THREE = ("full", "modal-warping:modes=40", "full:material=neo-hookean,contact=off")
PER_FRAME = {"step_ms", "volume_ratio", "strain_energy", "sensor_error_mm"}
DISTANCES = {"distance_mm_mean", "distance_mm_max", "hausdorff_mm"}


@pytest.fixture
def compare(lingual, wedge_file, write_luo, luo_rows):
    """Function (*arguments, solvers, file) -> exit code, output, errors of the command: the wedge, in 6 frames."""
    recording = write_luo(luo_rows[20:80])

    def run(*arguments, solvers=THREE, file=recording):
        chosen = [part for text in solvers for part in ("--solver", text)]
        code, out, err = lingual(
            "compare", file, "--mesh", wedge_file, "--units", "mm", "--frames", "6", *chosen, *arguments
        )
        return code, out, [line for line in err.splitlines() if not line.startswith("warning:")]

    return run


@pytest.fixture(scope="module")
def compared(small_tongue, trajectory):
    """The small tongue by the full solver, the same again, and one 3 mm to the left."""
    simulation = Simulation(SolverFullSpace(small_tongue), trajectory)
    simulation.run()
    run = SolverRun("full", 480, simulation.history)
    shifted = SolverRun("shifted", 480, replace_nodes(simulation.history, small_tongue, [0.0, 0.003, 0.0]))
    same = replace(run, label="again")
    report = simulation_report(simulation, "block")
    return [
        ComparedRun(run, report, None),
        ComparedRun(same, report, surface_distance(small_tongue, same, run)),
        ComparedRun(shifted, report, surface_distance(small_tongue, shifted, run)),
    ]


def replace_nodes(history, tongue, shift):
    """The history with every node moved."""
    moved = type(history)(tongue.mesh.node_count, tongue.sensors.count)
    for k, time in enumerate(history.time):
        sample = history.sample(time)
        scalars = {name: history.scalar(name)[k] for name in history.scalar_names}
        nodes = sample.nodes + np.array(shift)
        moved.append(time, nodes, sample.sensors, sample.sensor_targets, sample.jaw_translation, **scalars)
    return moved


def test_three_solvers_on_a_recording_give_table_json_curves_and_pictures(compare, tmp_path):
    code, out, err = compare("--json", tmp_path / "j" / "c.json", "--out", tmp_path / "pictures")
    if "EGL" in "".join(err):
        pytest.skip("no EGL with OpenGL 4.1")
    assert (code, err) == (0, [])
    for word in ("6 frames, distances from the surface of 'full'", "660", "Hausdorff", "Written"):
        assert word in " ".join(out.split())
    for name in ("curves.png", "curves.svg", "shapes.png"):
        assert (tmp_path / "pictures" / name).stat().st_size > 10_000
    report = json.loads((tmp_path / "j" / "c.json").read_text())
    assert (report["reference"], report["frame_count"], len(report["time"])) == ("full", 6, 6)
    full, modal, other = report["solvers"]
    assert [s["label"] for s in report["solvers"]] == list(THREE)
    assert [s["solver"] for s in report["solvers"]] == ["full", "modal-warping", "full"]
    assert [s["material"] for s in report["solvers"]] == ["stvk", "stvk", "neo-hookean"]
    assert modal["dof_count"] == 40
    assert set(full["frames"]) == PER_FRAME
    assert set(modal["frames"]) == set(other["frames"]) == PER_FRAME | DISTANCES
    for solver in report["solvers"]:
        assert {len(values) for values in solver["frames"].values()} == {6}
        assert solver["unconverged_frames"] == []
    assert "distance_mm_mean" not in full
    for solver in (modal, other):
        assert 0.0 < solver["distance_mm_mean"] <= solver["distance_mm_max"] < 10.0
        assert solver["hausdorff_relative_mean"] < solver["hausdorff_mm_mean"]


def test_the_reference_is_the_full_solver_wherever_it_stands(compare, tmp_path):
    solvers = ("modal-warping:modes=20", "full")
    assert compare("--json", tmp_path / "c.json", solvers=solvers)[0] == 0
    report = json.loads((tmp_path / "c.json").read_text())
    assert report["reference"] == "full"
    assert [s["label"] for s in report["solvers"]] == list(solvers)
    assert report["solvers"][0]["distance_mm_max"] > 0.0


def test_without_a_full_solver_the_first_is_the_reference(compare, tmp_path):
    solvers = ("modal-warping:modes=20", "modal-warping:modes=40")
    assert compare("--json", tmp_path / "c.json", solvers=solvers)[0] == 0
    assert json.loads((tmp_path / "c.json").read_text())["reference"] == solvers[0]


def test_table_and_json_tell_the_distances(compared, small_tongue):
    console = Console(width=200, record=True)
    console.print(comparison_table("block", compared))
    full, again, shifted = (
        next(line for line in console.export_text(clear=False).splitlines() if line.strip("│ ").startswith(name))
        for name in ("full", "again", "shifted")
    )
    assert "3.00" not in full
    assert again.count("0.00") >= 3
    assert shifted.count("3.00") == 2  # mean and largest distance; Hausdorff's is after alignment
    reference, same, moved = comparison_report(small_tongue, compared)["solvers"]
    assert "hausdorff_mm_max" not in reference
    assert max(same["distance_mm_max"], same["hausdorff_mm_max"]) < 1e-3
    assert moved["distance_mm_mean"] == pytest.approx(3.0, rel=1e-4)
    assert moved["frames"]["distance_mm_max"] == pytest.approx([3.0] * 8, rel=1e-4)


def test_a_long_name_leaves_the_figures_legible_in_80_columns(compared, small_tongue):
    name = "reduced:domains=12,material=neo-hookean,volume=none"
    long = replace(compared[2], run=replace(compared[2].run, label=name))
    console = Console(width=80, record=True)
    console.print(comparison_table("block", [compared[0], long]))
    text = console.export_text()
    assert text.count("3.00") == 2
    assert "greatest error in mm" in " ".join(text.split())
    assert max(map(len, text.splitlines())) <= 80


def test_curves_hold_a_line_for_every_run(compared, tmp_path):
    write_plots(tmp_path, compared)
    text = (tmp_path / "curves.svg").read_text()
    assert text.lstrip().startswith("<?xml")
    assert (tmp_path / "curves.png").read_bytes().startswith(b"\x89PNG")
    for each, colour in zip(compared, ("#0072b2", "#d55e00", "#009e73"), strict=True):
        assert text.count(colour) >= (4 if each.distance is None else 7)


def test_curves_that_cannot_be_written_are_an_error_of_one_sentence(compared, tmp_path):
    with pytest.raises(LingualError, match="cannot be written in"):
        write_plots(tmp_path / "nowhere", compared)


def test_figures_are_kept_where_nothing_can_be_drawn(compare, monkeypatch, tmp_path):
    def fail(*_):
        raise LingualError("Nothing can be drawn here.")

    monkeypatch.setattr(module, "_write_pictures", fail)
    code, out, err = compare("--json", tmp_path / "c.json", "--out", tmp_path / "p", solvers=THREE[:2])
    assert code == 2
    assert "Nothing can be drawn here" in "".join(err)
    assert "Hausdorff" in out
    assert len(json.loads((tmp_path / "c.json").read_text())["solvers"]) == 2


@pytest.mark.parametrize(
    ("solvers", "arguments", "says"),
    [
        (("full",), (), "1 solvers are given (full); name two or three different ones"),
        (("full", "full"), (), "name two or three different ones"),
        (("full", "reduced", "modal-warping", "reduced:domains=8"), (), "4 solvers are given"),
        (("full", "magic"), (), "no solver 'magic'"),
        (("full", "reduced:speed=2"), (), "'speed=2' in 'reduced:speed=2' is not an option"),
        (("full", "full:material=rubber"), (), "no material 'rubber'"),
        (("full", "reduced:domains=2"), (), "2 domains are too few"),
        (("full", "modal-warping:modes=0"), (), "0 modes were asked for"),
        (THREE, ("--frames", "0"), "--frames is 0; it must be 1 or more"),
        (THREE, ("--out", "a.txt"), "a.txt is a file; --out names a folder"),
        (THREE, ("--out", "a.txt/b"), "cannot be written"),
        (THREE, ("--json", "a.txt/c.json"), "cannot be written"),
        (THREE, ("--mesh", "nowhere"), "no mesh 'nowhere'"),
    ],
)
def test_a_mistake_gets_one_sentence_before_anything_is_simulated(
    compare, monkeypatch, tmp_path, solvers, arguments, says
):
    (tmp_path / "a.txt").write_text("")
    monkeypatch.setattr(Simulation, "run", None)  # would fail if it were called
    code, _, errors = compare(*arguments, solvers=solvers)
    assert code == 2
    assert len(errors) == 1
    assert errors[0].startswith("error: ")
    assert says in errors[0]


def test_a_recording_that_is_not_there_is_named(compare):
    code, _, errors = compare(file="missing.txt")
    assert code == 2
    assert ["no file missing.txt" in error for error in errors] == [True]


def test_full_and_reduced_are_compared_when_none_is_named(lingual, monkeypatch):
    asked = []
    monkeypatch.setattr(module, "compare", asked.append)
    assert lingual("compare", "--frames", "3")[0] == 0
    assert asked == [module.CompareRequest(None, ("full", "reduced"), frame_limit=3)]


def test_help_names_every_option(lingual):
    code, out, _ = lingual("compare", "--help")
    assert code == 0
    for word in ("--solver", "--mesh", "--units", "--frames", "--out", "--json"):
        assert word in out
