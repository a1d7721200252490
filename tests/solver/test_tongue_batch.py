"""Many tongues at once: each moves as it would alone, on every device."""

from dataclasses import replace

import numpy as np
import pytest
import warp as wp

from lingual.model import LingualError, Material
from lingual.precompute.reduction import all_element_model
from lingual.solver.tongue_batch import TongueBatch

FRAMES = 6


@pytest.fixture(scope="module")
def model(small_tongue):
    return all_element_model(small_tongue, 5)


@pytest.fixture(scope="module")
def constrained(small_tongue):
    """Sagittal coordinates of all sensors."""
    selected = np.ones((small_tongue.sensors.count, 3), dtype=bool)
    selected[:, 1] = False
    return selected


@pytest.fixture(scope="module")
def targets(constrained):
    """Displacements [m] (frame, constraint, tongue): three tongues that move differently."""
    time = np.arange(1, FRAMES + 1)[:, None, None] / FRAMES
    phase = np.arange(constrained.sum())[None, :, None] + np.array([0.0, 1.0, 2.5])
    return 4e-3 * np.sin(2.0 * time + phase) - 4e-3 * np.sin(phase)


def _run(batch, targets):
    for frame in targets:
        batch.set_targets(frame)
        batch.step()
        assert batch.converged.all()
    return batch.position.numpy()


def test_a_batch_moves_as_its_tongues_do_alone(model, constrained, targets):
    together = _run(TongueBatch(model, constrained, tongue_count=3), targets)
    alone = [_run(TongueBatch(model, constrained), targets[:, :, t : t + 1])[:, :, 0] for t in range(3)]
    np.testing.assert_allclose(together, np.stack(alone, axis=2), atol=1e-9)
    assert np.abs(together - model.tongue.mesh.nodes[:, :, None]).max() > 3e-3


def test_tongues_of_different_stiffness_and_damping(model, constrained, targets):
    softer, calmer = Material(young_modulus=4000.0), Material(damping_stiffness=0.2, damping_mass=20.0)
    materials = [model.tongue.material, softer, calmer]
    together = _run(TongueBatch(model, constrained, tongue_count=3, materials=materials), targets)
    for t, material in enumerate(materials):
        other = replace(model, tongue=replace(model.tongue, material=material))
        alone = _run(TongueBatch(other, constrained), targets[:, :, t : t + 1])
        np.testing.assert_allclose(together[:, :, t], alone[:, :, 0], atol=1e-8)


def test_tongues_of_different_laws_are_refused(model, constrained):
    with pytest.raises(LingualError, match="one material for each tongue"):
        TongueBatch(model, constrained, tongue_count=2, materials=[Material(), Material("neo-hookean")])


def test_float32_follows_float64(model, constrained, targets):
    double = _run(TongueBatch(model, constrained, tongue_count=3), targets)
    single = _run(TongueBatch(model, constrained, tongue_count=3, precision_name="float32", tolerance=1e-5), targets)
    np.testing.assert_allclose(single, double, atol=2e-6)


def test_sensor_targets_and_forces(model, constrained, targets):
    """Targets are met; twice the small displacement takes twice the force."""
    batch = TongueBatch(model, constrained, step=1e3)
    forces = []
    for size in (1e-6, 2e-6):
        batch.coordinates.zero_()
        batch.velocity.zero_()
        batch.set_targets(np.full(constrained.sum(), size))
        batch.step()
        assert batch.missed_targets.max() < 1e-15
        forces.append(batch.constraint_forces()[:, 0])
    assert np.abs(forces[0]).max() > 1e-6
    np.testing.assert_allclose(forces[1], 2.0 * forces[0], rtol=1e-3, atol=1e-9)


def test_another_time_step_is_taken_up(model, constrained, targets):
    batch = TongueBatch(model, constrained)
    batch.set_targets(targets[0, :, :1])
    batch.step()
    batch.set_time_step(0.005)
    fresh = TongueBatch(model, constrained, step=0.005)
    fresh.coordinates.assign(batch.coordinates)
    fresh.velocity.assign(batch.velocity)
    for each in (batch, fresh):
        each.set_targets(targets[1, :, :1])
        each.step()
    np.testing.assert_allclose(batch.position.numpy(), fresh.position.numpy(), atol=1e-10)


def test_gravity_pulls_each_tongue_its_own_way(model, constrained):
    nothing = np.zeros_like(constrained)
    batch = TongueBatch(model, nothing, tongue_count=2)
    batch.set_gravity(np.array([[0.0, 0.0], [0.0, 0.0], [-9.81, 9.81]]))
    for _ in range(5):
        batch.step()
    down, up = np.moveaxis(batch.position.numpy() - model.tongue.mesh.nodes[:, :, None], 2, 0)
    assert down[:, 2].min() < -1e-5
    assert up[:, 2].max() > 1e-5


@pytest.mark.gpu
@pytest.mark.parametrize("tongue_count", [1, 3, 40])
def test_a_captured_step_is_the_step_of_the_cpu(model, constrained, targets, tongue_count):
    if not wp.is_cuda_available():
        pytest.skip("there is no CUDA device")
    many = 0.1 * targets[:, :, np.arange(tongue_count) % 3]
    host = _run(TongueBatch(model, constrained, tongue_count=tongue_count, tolerance=1e-7), many)
    cuda = TongueBatch(
        model, constrained, tongue_count=tongue_count, tolerance=1e-7, device="cuda:0", captured_evaluations=40
    )
    np.testing.assert_allclose(_run(cuda, many), host, atol=1e-8)
