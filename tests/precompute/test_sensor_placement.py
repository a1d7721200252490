"""Coils on the midline: arc lengths behind the tip, on the surface, with proper footprints."""

import numpy as np
import pytest

from lingual.model import LingualError, TetMesh
from lingual.precompute.sensor_placement import sensors_at, sensors_on_midline, upper_midline
from lingual.precompute.surfacing import surface_of
from lingual.precompute.tetrahedralise import tetrahedralise

LENGTH, RADIUS = 90.0, 12.0


@pytest.fixture(scope="module")
def sausage() -> TetMesh:
    """A straight capsule along x, 90 mm between its ends, its middle 5 mm to the left."""

    def capsule(p):
        x = np.clip(p[:, 0], -LENGTH + RADIUS, -RADIUS)
        return np.linalg.norm(p - np.stack([x, 0 * x + 5.0, 0 * x], axis=1), axis=1) - RADIUS

    surface = surface_of(capsule, (-95.0, -10.0, -15.0), (5.0, 20.0, 15.0), 2.0)
    return tetrahedralise(surface[0] * 1e-3, surface[1], 1200)


def test_arc_lengths_from_the_tip(sausage):
    sensors = sensors_on_midline(sausage)
    at = sensors.positions(sausage.nodes) * 1e3
    assert sensors.names == ("TT", "TB", "TD", "TR")
    assert np.abs(at[:, 1] - 5.0).max() < 0.5
    quarter = np.pi / 2.0 * RADIUS
    x = [-RADIUS * (1.0 - np.cos(10.0 / RADIUS))] + [-RADIUS - s + quarter for s in (30.0, 45.0, 60.0)]
    z = [RADIUS * np.sin(10.0 / RADIUS), RADIUS, RADIUS, RADIUS]
    assert np.abs(at[:, 0] - x).max() < 0.8
    assert np.abs(at[:, 2] - z).max() < 0.5


def test_footprints_hold_the_point(sausage):
    points = np.array([[-0.030, 0.004, 0.012], [-0.055, 0.006, 0.0118]])
    sensors = sensors_at(sausage, points, ("A", "B"))
    assert np.linalg.norm(sensors.positions(sausage.nodes) - points, axis=1).max() < 4e-4
    for i in range(2):
        nodes = sensors.footprint(i)
        assert len(nodes) >= 3
        assert np.isin(nodes, sausage.boundary_nodes).all()
    assert (sensors.weights.data >= 0.0).all()


def test_points_off_the_surface_snap_to_its_nearest_point(sausage):
    near, far = np.array([-45.0, 5.0, RADIUS + 2.0]), np.array([-45.0, 5.0, 100.0])
    sensors = sensors_at(sausage, 1e-3 * np.array([near, far]), ("A", "B"))
    at = sensors.positions(sausage.nodes) * 1e3
    assert at[0] == pytest.approx([-45.0, 5.0, RADIUS], abs=0.6)
    # Seen from afar a facet is as near as its neighbours, so here only the distance is certain.
    assert np.linalg.norm(at[1] - far) == pytest.approx(100.0 - RADIUS, abs=0.3)


def test_midline_runs_from_tip_to_root(sausage):
    line = upper_midline(sausage) * 1e3
    assert line[0, 0] == pytest.approx(0.0, abs=0.3)
    assert line[-1, 0] < -80.0
    assert line[-1, 2] < 0.0


def test_a_short_tongue_is_named(sausage):
    small = TetMesh(sausage.nodes * 0.1, sausage.tets)
    with pytest.raises(LingualError, match="too short for a sensor 60 mm"):
        sensors_on_midline(small)
