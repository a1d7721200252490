"""Equilibria: patch test, cantilever, balance of forces, and what sensors impose."""

from dataclasses import replace

import numpy as np
import pytest

from lingual.model import Material
from lingual.model.discretisation import Discretisation
from lingual.solver.full_space import SolverFullSpace

GRAVITY = 9.81


def test_a_linear_field_on_the_boundary_is_reproduced_inside(block, tongue_of, control_of, static, displacement):
    """Patch test: uniform F is in equilibrium, also nonlinearly and at nu = 0.49."""
    mesh = block((0.03, 0.02, 0.02), (4, 3, 3))
    moved = [n for n in mesh.boundary_nodes if mesh.nodes[n, 0] > 0.0]
    patch = tongue_of(mesh, {f"S{n}": n for n in moved})
    field = mesh.nodes[:, :1] * [0.2, -0.15, 0.1]  # zero on the held face
    imposed = {(f"S{n}", axis): field[n, axis] for n in moved for axis in range(3)}
    solver = SolverFullSpace(patch)
    state = static(solver, control_of(patch, imposed), load_steps=2)
    inside = np.setdiff1d(np.arange(mesh.node_count), mesh.boundary_nodes)
    assert len(inside) == 12
    np.testing.assert_allclose(displacement(solver, state)[inside], field[inside], rtol=0, atol=1e-10)


def test_a_cantilever_converges_to_timoshenko_under_its_own_weight(block, tongue_of, control_of, static, displacement):
    """Small deflection, nu = 0.3. Linear elements are too stiff in bending; the excess falls with refinement."""
    length, side, gravity = 0.06, 0.012, 1e-3
    material = Material(poisson_ratio=0.3)
    area, inertia = side**2, side**4 / 12.0
    shear = 10.0 * 1.3 / (12.0 + 11.0 * 0.3) * material.lame_mu
    weight = material.density * gravity * area
    expected = weight * length**4 / (8.0 * material.young_modulus * inertia) + weight * length**2 / (2 * shear * area)

    def stiffness(divisions: int) -> float:
        """Of the bar at its tip, relative to the beam's."""
        mesh = block((length, side, side), (5 * divisions, divisions, divisions))
        bar = tongue_of(mesh, {"TT": mesh.node_count - 1}, material)
        solver = SolverFullSpace(bar)
        state = static(solver, control_of(bar, gravity=(0.0, 0.0, -gravity)))
        tip = mesh.nodes[:, 0] == length
        return -expected / displacement(solver, state)[tip, 2].mean()

    coarse, middle, fine = (stiffness(n) for n in (2, 4, 8))
    assert 1.0 < fine < middle < coarse
    assert fine == pytest.approx(1.0, abs=0.1)
    assert np.log2((coarse - 1.0) / (middle - 1.0)) > 1.5
    assert np.log2((middle - 1.0) / (fine - 1.0)) > 1.5
    limit = fine - (middle - fine) ** 2 / (coarse - 2.0 * middle + fine)  # Aitken
    assert limit == pytest.approx(1.0, abs=0.02)


PULL = {("TT", 0): -0.002, ("TT", 2): 0.006, ("TD", 2): 0.004, ("TR", 1): 0.001}


@pytest.fixture(scope="module")
def pulled(solver, control_of, static):
    """The small tongue in gravity, in equilibrium with some sensor coordinates imposed."""
    return static(solver, control_of(solver.tongue, PULL, (0.0, 0.0, -GRAVITY)), load_steps=3)


def test_sensor_targets_are_met(solver, pulled):
    tongue = solver.tongue
    moved = tongue.sensors.positions(pulled.position.numpy()) - tongue.sensor_rest_positions
    for (name, axis), value in PULL.items():
        assert moved[tongue.sensors.names.index(name), axis] == pytest.approx(value, abs=1e-9)


def test_coordinates_that_are_not_imposed_are_free(solver, pulled):
    """They move, and no force acts along them."""
    force = pulled.sensor_force.numpy()
    imposed = {(solver.tongue.sensors.names.index(name), axis) for name, axis in PULL}
    moved = solver.tongue.sensors.positions(pulled.position.numpy()) - solver.tongue.sensor_rest_positions
    for place in np.ndindex(*force.shape):
        if place in imposed:
            assert abs(force[place]) > 1e-6
        else:
            assert force[place] == 0.0
            assert abs(moved[place]) > 1e-6


def test_sensor_forces_weight_and_attachment_balance_in_force_and_moment(small_tongue, control_of, static):
    """Full space, where every node is in equilibrium: what holds sensors and bone carries the weight."""
    solver = SolverFullSpace(small_tongue, tolerance=1e-9)
    state = static(solver, control_of(small_tongue, PULL, (0.0, 0.0, -GRAVITY)), load_steps=3)
    tongue, x = small_tongue, state.position.numpy()
    discretisation = Discretisation(tongue.mesh, tongue.material)
    discretisation.set_displacement(x - tongue.mesh.nodes)
    free, fixed = tongue.free_nodes, tongue.fixed_nodes
    forces = np.zeros_like(x)
    forces[fixed] = discretisation.internal_force()[fixed]  # held: the support gives what the tissue lacks
    forces[free, 2] -= GRAVITY * tongue.node_masses[free]
    forces += tongue.sensors.weights.T @ state.sensor_force.numpy()
    weight = GRAVITY * tongue.node_masses.sum()
    np.testing.assert_allclose(forces.sum(axis=0), 0.0, atol=1e-5 * weight)
    np.testing.assert_allclose(np.cross(x, forces).sum(axis=0), 0.0, atol=1e-5 * weight * 0.06)


def test_a_sensor_that_is_lifted_is_pushed_upward_and_by_twice_as_much_for_twice_the_lift(solver, control_of, static):
    lifted = [static(solver, control_of(solver.tongue, {("TT", 2): lift})) for lift in (1e-5, 2e-5)]
    once, twice = (state.sensor_force.numpy()[0, 2] for state in lifted)
    assert once > 0.0
    assert twice == pytest.approx(2.0 * once, rel=2e-3)


def test_the_reaction_is_the_slope_of_the_energy_along_the_sensor(solver, control_of, static, total_energy):
    """dE/dtarget = force, by central differences about a deformed state without load."""
    energy = total_energy(solver)

    def at(lift: float):
        state = static(solver, control_of(solver.tongue, {("TT", 2): lift}), load_steps=2)
        state.velocity.zero_()
        state.coordinate_velocity.zero_()
        return state

    slope = (energy(at(0.0051)) - energy(at(0.0049))) / 0.0002
    assert at(0.005).sensor_force.numpy()[0, 2] == pytest.approx(slope, rel=1e-4)


def test_held_nodes_never_move(solver, pulled):
    fixed = solver.tongue.fixed_nodes
    np.testing.assert_allclose(pulled.position.numpy()[fixed], solver.tongue.mesh.nodes[fixed], rtol=0, atol=1e-15)


def test_a_lighter_tongue_sags_less(make_solver, small_tongue, control_of, static, displacement):
    sag = []
    for density in (500.0, 1000.0):
        solver = make_solver(replace(small_tongue, material=Material(density=density)))
        state = static(solver, control_of(solver.tongue, gravity=(0.0, 0.0, -1e-3)))
        sag.append(displacement(solver, state)[:, 2].min())
    assert sag[1] == pytest.approx(2.0 * sag[0], rel=1e-3)
