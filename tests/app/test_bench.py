"""`lingual bench`: every measure of a small tongue in a few frames, its JSON, and what is refused."""

import json

import numpy as np
import pytest
import warp as wp

from lingual.app.bench import command, measures
from lingual.app.bench.subject import LUO_TONGUE, SIZES, Subject, mesh_of
from lingual.app.bench.timing import median_ms, median_over_frames_ms
from lingual.model.contact_forces import CollisionPoints
from lingual.model.contact_scene import ContactScene
from lingual.model.signed_distance import SignedDistanceGrid
from lingual.precompute.pressure_subspace import PressureSettings, build_pressure_subspace
from lingual.precompute.progress import silent
from lingual.precompute.reduction import all_element_model

KEYS = {
    "reduced_frame_ms", "reduced_frames_per_second", "full_step_ms", "full_over_reduced", "volume_full_ms",
    "volume_subspace_ms", "volume_full_over_subspace", "modal_frame_ms", "batch_frames_per_second", "peers", "machine",
}  # fmt: skip


@pytest.fixture(scope="module")
def subject(small_tongue, tmp_path_factory) -> Subject:
    """The block with every element integrated, few pressure modes, and bone 5 mm above it."""
    subject = Subject(small_tongue, silent)
    mesh = small_tongue.mesh
    top = np.flatnonzero(np.isclose(mesh.nodes[:, 2], 0.02) & (mesh.nodes[:, 0] > 0.0))
    height = 1e-3 * np.arange(60)
    bone = np.tile((0.025 - height).astype(np.float32), (101, 61, 1))
    with pytest.MonkeyPatch.context() as patch:
        patch.setenv("LINGUAL_CACHE", str(tmp_path_factory.mktemp("cache")))
        model = all_element_model(small_tongue, 5)
        pressure = build_pressure_subspace(model, PressureSettings(key_frame_count=24))
    grid = SignedDistanceGrid("head", np.array([-0.02, -0.015, 0.0]), 1e-3, bone)
    scene = ContactScene(CollisionPoints(top, mesh.boundary_areas[top]), (grid,))
    vars(subject).update(model=model, pressure=pressure, scene=scene)
    return subject


@pytest.fixture
def quick(monkeypatch, subject, tmp_path):
    """A few frames of the block whatever size is asked for; returns the meshes that were."""
    asked = []

    def load(mesh, progress):
        asked.append(mesh)
        return subject

    monkeypatch.setenv("LINGUAL_CACHE", str(tmp_path / "cache"))
    monkeypatch.setattr(Subject, "load", load)
    counts = {"FRAMES": 14, "FULL_FRAMES": 5, "REPETITIONS": 3, "FULL_VOLUME_REPETITIONS": 1}
    for name, value in counts.items():
        monkeypatch.setattr(command, name, value)
    for name, value in {"MODE_COUNT": 20, "HOST_BATCH": 3, "BATCH_FRAMES": 3, "DEVICE_BATCH": 8}.items():
        monkeypatch.setattr(measures, name, value)
    return asked


def test_every_measure_is_printed_and_written(lingual, quick, subject, tmp_path):
    peers = tmp_path / "peers.json"
    peers.write_text(json.dumps({"small": {"another program": 12.5}}))
    code, out, err = lingual("bench", "--size", "small", "--peers", peers, "--json", tmp_path / "b" / "bench.json")
    assert (code, err) == (0, "")
    assert quick == ["head-small"]
    results = json.loads((tmp_path / "b" / "bench.json").read_text())
    assert list(results) == ["small"]
    small = results["small"]
    assert set(small) >= KEYS
    assert (small["node_count"], small["tet_count"], small["dof_count"]) == (180, 576, 150)
    assert small["contact_points"] == len(subject.scene.points.nodes) > 0
    assert small["pressure_modes"] == subject.pressure.mode_count > 0
    assert small["batch_size"] == 3
    for key in KEYS - {"peers", "machine"}:
        assert np.isfinite(small[key])
        assert small[key] > 0.0
    assert small["reduced_frames_per_second"] == pytest.approx(1e3 / small["reduced_frame_ms"])
    assert small["full_over_reduced"] == pytest.approx(small["full_step_ms"] / small["reduced_frame_ms"])
    assert small["volume_full_over_subspace"] == pytest.approx(small["volume_full_ms"] / small["volume_subspace_ms"])
    assert small["peers"] == {"another program": 12.5}
    assert "cores" in small["machine"]
    assert ("cuda" in small) == wp.is_cuda_available()
    text = " ".join(out.split())
    for word in ("reduced frame", "full over reduced", "modal warping", "peer: another program", "12.5 ms", "cores"):
        assert word in text


def test_all_sizes_are_measured_when_none_is_named(lingual, quick, monkeypatch, tmp_path):
    monkeypatch.setattr(command, "measure", lambda subject, size, progress: _figures(size))
    assert lingual("bench", "--luo", "my-mesh", "--json", "b.json")[0] == 0
    assert quick == ["head-small", "my-mesh", "head-large"]
    assert list(json.loads((tmp_path / "b.json").read_text())) == list(SIZES)


def test_sizes_measured_before_an_interruption_are_kept(lingual, quick, monkeypatch, tmp_path):
    def measure(subject, size, progress):
        if size == "paper":
            raise KeyboardInterrupt
        return _figures(size)

    monkeypatch.setattr(command, "measure", measure)
    assert lingual("bench", "--json", "b.json")[0] == 130
    assert list(json.loads((tmp_path / "b.json").read_text())) == ["small", "luo"]


def _figures(size: str) -> dict[str, object]:
    return {"mesh": size, "node_count": 1, "tet_count": 1, "tolerance": 1e-5, "machine": "here"}


def test_the_mesh_of_luo_is_taken_where_it_is(monkeypatch, tmp_path):
    monkeypatch.chdir(tmp_path)
    assert [mesh_of(size, None) for size in SIZES] == ["head-small", None, "head-large"]
    assert mesh_of("luo", "my-mesh") == "my-mesh"
    (tmp_path / "checkout").mkdir()
    monkeypatch.chdir(tmp_path / "checkout")
    LUO_TONGUE.mkdir(parents=True)
    assert mesh_of("luo", None) == str(LUO_TONGUE)


def test_the_motion_that_is_measured_starts_at_once(subject):
    """A resting tongue converges without an iteration: a measure of it says nothing."""
    assert abs(subject.targets[0]).max() > 0.0
    assert abs(subject.targets[: command.FULL_FRAMES]).max() > 3e-3
    steps = abs(np.diff(subject.targets[:12], axis=0)).max(axis=1)
    assert steps.min() > 1e-5


def test_medians_leave_the_warm_up_out(monkeypatch):
    clock = iter([0.0, 9.0, 10.0, 10.5, 11.0, 11.25, 12.0, 13.0])
    monkeypatch.setattr("lingual.app.bench.timing.time.perf_counter", lambda: next(clock))
    seen = []
    assert median_over_frames_ms(seen.append, 4, 1) == pytest.approx(500.0)
    assert seen == [0, 1, 2, 3]


def test_median_of_repetitions_counts_the_calls(monkeypatch):
    clock = iter([0.0, 1.0, 2.0, 2.25, 3.0, 3.5])
    monkeypatch.setattr("lingual.app.bench.timing.time.perf_counter", lambda: next(clock))
    calls = []
    assert median_ms(lambda: calls.append(None), 3, warm_up=4) == pytest.approx(500.0)
    assert len(calls) == 7


@pytest.mark.parametrize(
    ("arguments", "says"),
    [
        (("--size", "huge"), "no size 'huge'; choose from small, luo, paper"),
        (("--peers", "missing.json"), "missing.json cannot be read as JSON"),
        (("--peers", "text.json"), "text.json cannot be read as JSON"),
        (("--peers", "list.json"), "list.json does not hold figures by mesh size"),
        (("--json", "text.json/b.json"), "cannot be written"),
    ],
)
def test_a_mistake_gets_one_sentence(lingual, monkeypatch, tmp_path, arguments, says):
    (tmp_path / "text.json").write_text("no JSON")
    (tmp_path / "list.json").write_text("[1, 2]")
    monkeypatch.setattr(Subject, "load", None)  # would fail if it were called
    code, _, err = lingual("bench", *arguments)
    assert code == 2
    assert err.startswith("error: ")
    assert says in " ".join(err.split())


def test_help_names_every_option(lingual):
    code, out, _ = lingual("bench", "--help")
    assert code == 0
    for word in ("--size", "--luo", "--peers", "--json"):
        assert word in out
