"""Both solvers with every constitutive law, against closed forms and linear elasticity."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.optimize import brentq

from lingual.kernels.materials import MATERIALS
from lingual.model import Material, TetMesh
from lingual.model.discretisation import Discretisation
from lingual.solver.full_space import SolverFullSpace
from lingual.solver.reduced import SolverReduced

GRAVITY = 9.81
SIDEWAYS = (0.0, -0.8, 0.0)
NEW_LAWS = [name for name in MATERIALS if name != "stvk"]
"""What the other tests of this folder do not run with."""


def material_of(model: str, young_modulus: float = 6912.0, poisson_ratio: float = 0.3, **rest: float) -> Material:
    """A material of the law with these moduli at small strain; mooney-rivlin also stiffens, by C20 = C10 / 2."""
    half_shear = young_modulus / (4.0 * (1.0 + poisson_ratio))
    return Material(
        model,
        young_modulus=young_modulus,
        poisson_ratio=poisson_ratio,
        mooney_rivlin=(half_shear, 0.0, 0.0, 0.5 * half_shear, 0.0),
        bulk_modulus=young_modulus / (3.0 * (1.0 - 2.0 * poisson_ratio)),
        **rest,
    )


@pytest.fixture(scope="module", params=MATERIALS)
def model(request) -> str:
    return request.param


@pytest.fixture(scope="module", params=NEW_LAWS)
def new_law(request) -> str:
    return request.param


def test_small_strain_moduli_are_those_asked_for(model):
    material = material_of(model)
    assert material.lame_mu == pytest.approx(6912.0 / 2.6)
    assert material.lame_lambda == pytest.approx(6912.0 * 0.3 / (1.3 * 0.4))


# --- Uniaxial extension -------------------------------------------------------------------------------------------


def stvk_principal(material, s):
    e = 0.5 * (s**2 - 1.0)
    return s * (2.0 * material.lame_mu * e + material.lame_lambda * e.sum())


def neo_hookean_principal(material, s):
    mu, lam = 4.0 / 3.0 * material.lame_mu, material.lame_lambda + 5.0 / 6.0 * material.lame_mu
    J = np.prod(s)
    return mu * (1.0 - 1.0 / (s @ s + 1.0)) * s + lam * (J - 1.0 - 0.75 * mu / lam) * J / s


def corotational_principal(material, s):
    return 2.0 * material.lame_mu * (s - 1.0) + material.lame_lambda * (s.sum() - 3.0)


def mooney_rivlin_principal(material, s):
    """With C10 and C20 only: dPsi/ds_i = (C10 + 2 C20 i) di/ds_i + kappa (J - 1) J / s_i."""
    c10, _, _, c20, _ = material.mooney_rivlin
    J, I1 = np.prod(s), s @ s
    i = J ** (-2.0 / 3.0) * I1 - 3.0
    slope = 2.0 * J ** (-2.0 / 3.0) * (s - I1 / (3.0 * s))
    return (c10 + 2.0 * c20 * i) * slope + material.bulk_modulus * (J - 1.0) * J / s


PRINCIPAL_STRESSES = {
    "stvk": stvk_principal,
    "neo-hookean": neo_hookean_principal,
    "corotational": corotational_principal,
    "mooney-rivlin": mooney_rivlin_principal,
}


def uniaxial(material, stretch: float) -> tuple[float, float]:
    """Lateral stretch and axial first Piola stress [Pa] of a bar with free sides."""
    stresses = PRINCIPAL_STRESSES[material.model]

    def lateral_stress(t: float) -> float:
        return stresses(material, np.array([stretch, t, t]))[1]

    t = brentq(lateral_stress, 0.6, 1.4, xtol=1e-14)
    return t, stresses(material, np.array([stretch, t, t]))[0]


def beside_a_held_scrap(mesh: TetMesh) -> tuple[TetMesh, np.ndarray]:
    """The mesh and one tetrahedron a metre away, whose four nodes are to be held: nothing holds the rest."""
    scrap = 0.01 * np.concatenate([np.zeros((1, 3)), np.eye(3)]) - [1.0, 0.0, 0.0]
    tets = np.concatenate([mesh.tets, mesh.node_count + np.arange(4)[None]])
    return TetMesh(np.concatenate([mesh.nodes, scrap]), tets), mesh.node_count + np.arange(4)


@pytest.mark.parametrize("stretch", [0.75, 1.5])
def test_a_bar_drawn_out_follows_the_law_s_closed_form(model, stretch, block, tongue_of, control_of, advance):
    """Symmetry planes at x = 0, y = 0 and z = 0, and the end moved along x: a homogeneous large strain.

    Nothing else holds the bar, so it comes to rest in ordinary steps, strongly damped: each halves what is left.
    """
    size, h = np.array([0.03, 0.02, 0.02]), 0.02
    mesh, material = block(tuple(size), (3, 2, 2)), material_of(model, damping_stiffness=h)
    moved = np.flatnonzero((mesh.nodes == 0.0).any(axis=1) | (mesh.nodes[:, 0] == size[0]))
    with_scrap, held = beside_a_held_scrap(mesh)
    bar = replace(tongue_of(with_scrap, {f"S{n}": n for n in moved}, material), fixed_nodes=held)
    symmetry = {(f"S{n}", a): 0.0 for n in moved for a in range(3) if mesh.nodes[n, a] == 0.0}
    end = [n for n in moved if mesh.nodes[n, 0] == size[0]]
    solver, state = SolverFullSpace(bar, tolerance=1e-6), None
    for share in [0.25, 0.5, 0.75] + 35 * [1.0]:
        drawn = {(f"S{n}", 0): share * (stretch - 1.0) * size[0] for n in end}
        state = advance(solver, control_of(bar, symmetry | drawn), h, state=state)
    lateral, stress = uniaxial(material, stretch)
    expected = mesh.nodes * [stretch, lateral, lateral]
    np.testing.assert_allclose(state.position.numpy()[: mesh.node_count], expected, rtol=0, atol=1e-7)
    pull = state.sensor_force.numpy()[[bar.sensors.names.index(f"S{n}") for n in end], 0].sum()
    assert pull == pytest.approx(stress * size[1] * size[2], rel=1e-4)


# --- Statics ------------------------------------------------------------------------------------------------------


def test_a_linear_field_on_the_boundary_is_reproduced_inside(
    new_law, block, tongue_of, control_of, static, displacement
):
    """Patch test: uniform F is in equilibrium, also nonlinearly and nearly incompressible."""
    mesh = block((0.03, 0.02, 0.02), (4, 3, 3))
    moved = [n for n in mesh.boundary_nodes if mesh.nodes[n, 0] > 0.0]
    patch = tongue_of(mesh, {f"S{n}": n for n in moved}, Material(new_law))
    field = mesh.nodes[:, :1] * [0.2, -0.15, 0.1]  # zero on the held face
    imposed = {(f"S{n}", axis): field[n, axis] for n in moved for axis in range(3)}
    solver = SolverFullSpace(patch)
    state = static(solver, control_of(patch, imposed), load_steps=2)
    inside = np.setdiff1d(np.arange(mesh.node_count), mesh.boundary_nodes)
    np.testing.assert_allclose(displacement(solver, state)[inside], field[inside], rtol=0, atol=1e-9)


def linear_stiffness(tongue) -> np.ndarray:
    """Hooke's law on linear tetrahedra, summed in NumPy, (3 nodes, 3 nodes)."""
    mesh, mu, lam = tongue.mesh, tongue.material.lame_mu, tongue.material.lame_lambda
    g = mesh.shape_gradients.reshape(-1, 4, 3)
    delta = np.eye(3)
    blocks = lam * np.einsum("eai,ebj->eaibj", g, g) + mu * np.einsum("eaj,ebi->eaibj", g, g)
    blocks += mu * np.einsum("eak,ebk,ij->eaibj", g, g, delta)
    blocks *= mesh.volumes[:, None, None, None, None]
    index = (3 * mesh.tets[:, :, None] + np.arange(3)).reshape(-1, 12)
    K = np.zeros((3 * mesh.node_count, 3 * mesh.node_count))
    np.add.at(K, (index[:, :, None], index[:, None, :]), blocks.reshape(-1, 12, 12))
    return K


def test_a_cantilever_sags_a_little_as_a_linear_elastic_one(
    make_solver, new_law, block, tongue_of, control_of, static, displacement
):
    """Under a ten-thousandth of its weight, against K u = M g solved by NumPy, in the subspace where there is one."""
    mesh = block((0.06, 0.012, 0.012), (10, 2, 2))
    solver = make_solver(tongue_of(mesh, {"TT": 98, "TB": 80, "TD": 62, "TR": 35}, material_of(new_law)))
    tongue, gravity = solver.tongue, np.array([0.0, 0.0, -1e-4 * GRAVITY])
    U = np.eye(3 * mesh.node_count)[:, np.repeat(np.isin(np.arange(mesh.node_count), tongue.free_nodes), 3)]
    if isinstance(solver, SolverReduced):
        U = np.kron(solver.model.basis, np.eye(3))
    load = (tongue.node_masses[:, None] * gravity).ravel()
    expected = (U @ np.linalg.solve(U.T @ linear_stiffness(tongue) @ U, U.T @ load)).reshape(-1, 3)
    sag = displacement(solver, static(solver, control_of(tongue, gravity=tuple(gravity))))
    np.testing.assert_allclose(sag, expected, rtol=0, atol=2e-3 * abs(expected).max())


POSTURE = {("TT", 0): -0.003, ("TT", 2): 0.008, ("TB", 2): 0.005, ("TD", 0): -0.002, ("TR", 1): 0.001}


def test_a_posture_is_reached_by_every_law_with_the_tongue_s_own_values(
    make_solver, new_law, small_tongue, control_of, advance
):
    """Within one frame: targets met, and the volume kept as well as its law's bulk modulus asks for."""
    solver = make_solver(replace(small_tongue, material=Material(new_law)))
    state = advance(solver, control_of(solver.tongue, POSTURE), 0.01, 3)
    moved = solver.tongue.sensors.positions(state.position.numpy()) - solver.tongue.sensor_rest_positions
    for (name, axis), value in POSTURE.items():
        assert moved[solver.tongue.sensors.names.index(name), axis] == pytest.approx(value, abs=1e-9)
    discretisation = Discretisation(solver.tongue.mesh, solver.tongue.material)
    discretisation.set_displacement(state.position.numpy() - solver.tongue.mesh.nodes)
    det_f = discretisation.elements.energy_density()[1]
    assert det_f.min() > 0.0
    assert det_f @ solver.tongue.mesh.volumes == pytest.approx(solver.tongue.mesh.volumes.sum(), rel=0.05)


def test_a_pressed_block_has_an_indefinite_stiffness_and_a_semidefinite_substitute(model, block):
    """What Newton's method factorises instead: it gives up only energy that the exact stiffness loses."""
    mesh = block((0.02, 0.02, 0.02), (2, 2, 2))
    discretisation = Discretisation(mesh, material_of(model))
    discretisation.set_displacement(mesh.nodes * [0.0, 0.0, -0.5])
    exact = discretisation.stiffness().toarray().copy()
    substitute = discretisation.stiffness(definite=True).toarray()
    largest = np.linalg.eigvalsh(exact)[-1]
    assert np.linalg.eigvalsh(exact)[0] < -1e-3 * largest
    assert np.linalg.eigvalsh(substitute)[0] > -1e-12 * largest
    assert np.linalg.eigvalsh(substitute - exact)[0] > -1e-12 * largest


# --- Motion -------------------------------------------------------------------------------------------------------


@pytest.fixture(scope="module")
def bar_solver(make_solver, bar, new_law):
    """Of the slender undamped bar."""
    return make_solver(replace(bar, material=material_of(new_law, damping_mass=0.0, damping_stiffness=0.0)))


@pytest.fixture(scope="module")
def released(bar_solver, control_of, static):
    """The bar bent by about 10 mm, about to be let go."""
    return static(bar_solver, control_of(bar_solver.tongue, gravity=SIDEWAYS), load_steps=4)


def test_rest_is_stationary(make_solver, new_law, small_tongue, control_of, advance, displacement):
    solver = make_solver(replace(small_tongue, material=Material(new_law)))
    state = advance(solver, control_of(solver.tongue), dt=0.01, steps=2)
    assert not displacement(solver, state).any()
    assert not state.velocity.numpy().any()


def test_a_block_that_nothing_holds_falls_freely_and_keeps_its_shape(
    model, block, tongue_of, control_of, advance, displacement
):
    """Implicit Euler without damping: after n steps every node has moved by g h^2 n (n + 1) / 2."""
    material = replace(Material(model), damping_mass=0.0)
    mesh = block((0.03, 0.02, 0.02), (3, 2, 2))
    with_scrap, held = beside_a_held_scrap(mesh)
    solver = SolverFullSpace(replace(tongue_of(with_scrap, {"TT": 0}, material), fixed_nodes=held))
    steps, h, gravity = 5, 0.01, np.array([1.0, 0.0, -GRAVITY])
    state = advance(solver, control_of(solver.tongue, gravity=tuple(gravity)), h, steps)
    fallen = np.broadcast_to(gravity * h**2 * steps * (steps + 1) / 2, mesh.nodes.shape)
    np.testing.assert_allclose(displacement(solver, state)[: mesh.node_count], fallen, rtol=0, atol=1e-9)


def test_a_clamped_bar_rings_at_its_lowest_eigenfrequency(bar_solver, lowest_mode, control_of, advance):
    """Implicit Euler rings at atan(w h) / h: between its two zero crossings there is half such a period."""
    mode = lowest_mode(bar_solver)
    dt = 2.0 * np.pi / mode.omega / 40.0
    amplitudes = [1.0]
    advance(
        bar_solver, control_of(bar_solver.tongue), dt, 34, mode.state(1.0),
        on_step=lambda state: amplitudes.append(mode.amplitude(state)),
    )  # fmt: skip
    q = np.array(amplitudes)
    before = np.flatnonzero(q[:-1] * q[1:] < 0)
    crossings = (before + q[before] / (q[before] - q[before + 1])) * dt
    assert len(crossings) == 2
    assert np.pi / (crossings[1] - crossings[0]) == pytest.approx(np.arctan(mode.omega * dt) / dt, rel=2e-3)


def test_without_load_the_total_energy_never_grows(bar_solver, released, control_of, advance, total_energy):
    energy = total_energy(bar_solver)
    values = [energy(released)]
    advance(bar_solver, control_of(bar_solver.tongue), 0.01, 25, released, lambda state: values.append(energy(state)))
    assert np.all(np.diff(values) <= 1e-9 * values[0])
    assert 0.0 < values[-1] < 0.9 * values[0]


def test_implicit_euler_is_first_order_in_the_time_step(bar_solver, released, control_of, advance, displacement):
    """The bent bar is let go for a fifth of its period; halving the step halves the error."""
    control, duration = control_of(bar_solver.tongue), 0.04
    ends = [
        displacement(bar_solver, advance(bar_solver, control, duration / steps, steps, released))
        for steps in (10, 20, 40)
    ]
    order = np.log2(np.linalg.norm(ends[0] - ends[1]) / np.linalg.norm(ends[1] - ends[2]))
    assert order == pytest.approx(1.0, abs=0.15)


def test_a_sensor_that_jumps_by_20_mm_does_not_blow_the_tongue_up(
    make_solver, new_law, small_tongue, control_of, displacement
):
    solver = make_solver(replace(small_tongue, material=Material(new_law)))
    control = control_of(solver.tongue, {("TT", 0): 0.0, ("TT", 2): 0.02})
    current, spare = solver.new_state(), solver.new_state()
    far = []
    for _ in range(10):
        solver.step(current, spare, control, 0.01)
        current, spare = spare, current
        far.append(abs(displacement(solver, current)).max())
    assert max(far) < 0.025
    assert far[-1] == pytest.approx(far[-2], rel=0.05)
