"""From any file to targets on a mesh; damaged files in bulk."""

import warnings

import numpy as np
import pytest
import scipy.sparse as sp
from scipy.signal import savgol_filter

from lingual.model import EmbeddedSurface, LingualError, SensorLayout, TetMesh, TongueModel, Trajectory
from lingual.speech import RecordingWarning, fit_to_sensors, load_trajectory, read_recording, write_trajectory


def test_a_sentence_is_filtered_and_relative_to_the_jaw(write_luo, luo_rows):
    trajectory = load_trajectory(write_luo(luo_rows))
    assert trajectory.frame == "jaw"
    filtered = savgol_filter(-luo_rows[:, 1:].reshape(300, 7, 2) * 1e-3, 21, 3, axis=0)
    jaw = filtered[:, 4] - filtered[0, 4]
    np.testing.assert_allclose(trajectory.jaw_translation[:, [0, 2]], jaw, atol=1e-8)
    np.testing.assert_allclose(trajectory.positions[:, :, [0, 2]], filtered - jaw[:, None], atol=1e-8)
    assert not trajectory.jaw_translation[0].any()


def test_unfiltered_and_at_another_rate(write_luo, luo_rows):
    path = write_luo(luo_rows)
    plain = load_trajectory(path, smoothed=False, rate=50.0)
    raw = read_recording(path)
    assert plain.frame_count == 150
    np.testing.assert_allclose(plain.positions[0], raw.positions[0], equal_nan=True)


def test_a_finished_trajectory_comes_back_unchanged(tmp_path, write_luo, luo_rows):
    finished = load_trajectory(write_luo(luo_rows))
    for name in ("t.csv", "t.npz"):
        write_trajectory(tmp_path / name, finished)
        back = load_trajectory(tmp_path / name)
        np.testing.assert_array_equal(back.positions, finished.positions)
        np.testing.assert_array_equal(back.jaw_translation, finished.jaw_translation)


def test_a_csv_of_a_recording_is_treated_as_the_recording(tmp_path, write_luo, luo_rows):
    path = write_luo(luo_rows)
    raw = read_recording(path)
    head = Trajectory(raw.time, raw.channels, raw.positions, raw.measured)
    write_trajectory(tmp_path / "t.csv", head)
    np.testing.assert_array_equal(
        load_trajectory(tmp_path / "t.csv").positions, load_trajectory(path).positions
    )


def test_drop_outs_in_a_csv_are_bridged(tmp_path, write_luo, luo_rows):
    raw = read_recording(write_luo(luo_rows))
    path = tmp_path / "t.csv"
    write_trajectory(path, Trajectory(raw.time, raw.channels, raw.positions, raw.measured))
    lines = path.read_text().splitlines(keepends=True)
    header = next(i for i, line in enumerate(lines) if line.startswith("time_s"))
    cells = lines[header + 50].split(",")
    lines[header + 50] = ",".join([cells[0], "", *cells[2:]])
    path.write_text("".join(lines))
    with pytest.warns(RecordingWarning, match="channel TR has 1 missing of 300"):
        load_trajectory(path)


def test_without_a_jaw_channel_all_motion_is_the_tongues(tmp_path, luo_rows, write_luo):
    raw = read_recording(write_luo(luo_rows))
    path = tmp_path / "t.npz"
    write_trajectory(
        path, Trajectory(raw.time, raw.channels, raw.positions, raw.measured).select(("TT", "TB"))
    )
    with pytest.warns(RecordingWarning, match="no jaw channel LI"):
        trajectory = load_trajectory(path)
    assert trajectory.frame == "jaw"
    assert not trajectory.jaw_translation.any()


def test_uneven_frames_are_resampled_with_a_warning(tmp_path, luo_rows, write_luo):
    raw = read_recording(write_luo(luo_rows))
    keep = np.delete(np.arange(300), [40, 41, 150])
    path = tmp_path / "t.csv"
    write_trajectory(path, Trajectory(raw.time[keep], raw.channels, raw.positions[keep], raw.measured))
    with pytest.warns(RecordingWarning, match="not evenly spaced; it is resampled to 99"):
        load_trajectory(path)


@pytest.fixture
def model(wedge):
    """A model whose sensors are single nodes, in another order than any recording."""
    mesh = TetMesh(wedge[0] * 1e-3, wedge[1])
    chosen = [200, 150, 100, 60]
    weights = sp.csr_array((np.ones(4), (range(4), chosen)), shape=(4, mesh.node_count))
    skin = EmbeddedSurface(mesh.boundary_triangles, sp.csr_array(sp.eye_array(mesh.node_count)))
    return TongueModel("wedge", mesh, np.arange(10), SensorLayout(("TD", "TT", "TR", "TB"), weights), skin)


def test_sensors_move_as_their_coils_did(write_luo, luo_rows, model):
    trajectory = load_trajectory(write_luo(luo_rows))
    targets = fit_to_sensors(trajectory, model)
    assert targets.channels == ("TD", "TT", "TR", "TB")
    assert targets.frame == "jaw"
    np.testing.assert_allclose(targets.positions[0], model.sensor_rest_positions, atol=1e-15)
    moved = targets.positions[:, 1] - model.sensor_rest_positions[1]
    recorded = trajectory.positions[:, 3] - trajectory.positions[0, 3]
    np.testing.assert_allclose(moved[:, [0, 2]], recorded[:, [0, 2]], atol=1e-15)
    assert not moved[:, 1].any()
    assert targets.measured.tolist() == [[True, False, True]] * 4
    np.testing.assert_array_equal(targets.jaw_translation, trajectory.jaw_translation)


def test_rest_may_be_the_mean_of_some_frames(write_luo, luo_rows, model):
    targets = fit_to_sensors(load_trajectory(write_luo(luo_rows)), model, reference_frames=30)
    np.testing.assert_allclose(targets.positions[:30].mean(axis=0), model.sensor_rest_positions, atol=1e-12)


def test_what_cannot_be_fitted_is_named(write_luo, luo_rows, model):
    trajectory = load_trajectory(write_luo(luo_rows))
    with pytest.raises(LingualError, match=r"for the sensors TD, TR of 'wedge'; it has TB, TT"):
        fit_to_sensors(trajectory.select(("TB", "TT")), model)
    with pytest.raises(LingualError, match="mean of 301 frames; choose 1 to 300"):
        fit_to_sensors(trajectory, model, reference_frames=301)
    head = Trajectory(trajectory.time, trajectory.channels, trajectory.positions, trajectory.measured)
    with pytest.raises(LingualError, match="in the head frame"):
        fit_to_sensors(head, model)
    blind = Trajectory(
        trajectory.time, trajectory.channels, trajectory.positions, trajectory.measured & False, frame="jaw"
    )
    with pytest.raises(LingualError, match="no measured channel for the sensors TD, TT, TR, TB"):
        fit_to_sensors(blind, model)


def outcome(path) -> str:
    """ "used", "repaired" (with a warning) or "refused" (with an error of ours); anything else fails."""
    message = trajectory = None
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        try:
            trajectory = load_trajectory(path)
        except LingualError as error:
            message = str(error)
    if trajectory is None:
        assert str(path) in message
        assert "\n" not in message
        return "refused"
    assert np.isfinite(trajectory.positions[:, trajectory.measured]).all()
    assert all(issubclass(w.category, RecordingWarning) for w in caught)
    return "repaired" if caught else "used"


def test_a_sample_cut_at_every_kilobyte_is_refused(shared_data, tmp_path):
    content = (shared_data / "ema/luo/20150624_0_041_sync.txt").read_bytes()
    path = tmp_path / "cut.txt"
    for length in [*range(0, len(content), 1024), *range(len(content) - 20, len(content))]:
        path.write_bytes(content[:length])
        assert outcome(path) == "refused", length


def test_flipped_bits_of_a_sample_are_harmless_repaired_or_refused(shared_data, tmp_path):
    content = (shared_data / "ema/luo/20150624_0_043_sync.txt").read_bytes()
    path = tmp_path / "flipped.txt"
    clean = load_trajectory(shared_data / "ema/luo/20150624_0_043_sync.txt")
    rng = np.random.default_rng(7)
    for _ in range(60):
        damaged = bytearray(content)
        damaged[rng.integers(len(content))] ^= 1 << int(rng.integers(8))
        path.write_bytes(damaged)
        if outcome(path) != "refused":
            with warnings.catch_warnings():
                warnings.simplefilter("ignore")
                error = np.abs(load_trajectory(path).positions - clean.positions)
            assert np.nanmax(error) < 3e-3  # what one unnoticed sample leaves after the filter
