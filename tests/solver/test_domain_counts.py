"""The reduced solver with few and with many domains."""

import pytest

from lingual.precompute.reduction import all_element_model
from lingual.solver.reduced import SolverReduced


@pytest.mark.parametrize("domain_count", [4, 8, 14])
def test_a_step_converges_and_meets_its_targets(small_tongue, control_of, advance, domain_count):
    """The basis keeps its full rank as long as there are nodes enough for it: 180 here, 27 of them held."""
    model = all_element_model(small_tongue, domain_count)
    assert model.column_count == 10 * domain_count
    solver = SolverReduced(model)
    state = advance(solver, control_of(small_tongue, {("TT", 2): 0.003, ("TD", 2): 0.001}), 0.01, steps=3)
    moved = small_tongue.sensors.positions(state.position.numpy()) - small_tongue.sensor_rest_positions
    assert moved[0, 2] == pytest.approx(0.003, abs=1e-8)
    assert moved[2, 2] == pytest.approx(0.001, abs=1e-8)
