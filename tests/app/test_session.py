"""The session that the viewer sees, and its scalar fields."""

from dataclasses import replace

import numpy as np
import pytest

from lingual.app.fields import FieldSource
from lingual.app.session import Session
from lingual.app.simulation import Simulation
from lingual.model import RigidSurface
from lingual.model.history import Sample
from lingual.precompute.reduction import all_element_model


@pytest.fixture
def sample_of(small_tongue):
    """Function nodes -> a sample with these."""
    rest = small_tongue.sensor_rest_positions
    return lambda nodes: Sample(0.0, nodes.astype(np.float32), rest, rest, np.zeros(3))


def test_a_session_simulates_in_the_background_until_the_end(moving_solver, trajectory):
    session = Session(Simulation(moving_solver(), trajectory), "movement")
    session.start()
    session._thread.join(timeout=20.0)
    assert session.history.frame_count == 8
    assert (session.title, session.solver_name, session.duration) == ("movement", "moving", pytest.approx(0.07))
    assert session.failure is None
    assert session.notice is None
    session.stop()


@pytest.mark.filterwarnings("ignore::pytest.PytestUnhandledThreadExceptionWarning")
def test_a_solver_that_raises_ends_the_simulation_with_a_sentence_and_keeps_the_frames(moving_solver, trajectory):
    solver = moving_solver()
    simulation = Simulation(solver, trajectory)
    whole = solver.step

    def step(state_in, state_out, control, dt):
        if simulation.history.frame_count == 5:
            raise MemoryError("no room")
        whole(state_in, state_out, control, dt)

    solver.step = step
    session = Session(simulation, "movement")
    session.start()
    session._thread.join(timeout=20.0)
    assert session.history.frame_count == 5
    assert session.failure == "The simulation stopped at frame 5: no room"


@pytest.mark.parametrize(("until", "sentence"), [(0.0301, "1 frame did"), (0.0401, "2 frames did")])
def test_frames_that_did_not_converge_are_counted(moving_solver, trajectory, until, sentence):
    solver = moving_solver(lambda time: 0.0 if 0.0201 < time < until else np.inf)
    session = Session(Simulation(solver, trajectory), "movement")
    session.simulate()
    assert session.notice.startswith(sentence)
    assert session.failure is None


def test_fields_of_a_full_solver_have_no_domains(small_tongue):
    assert FieldSource(small_tongue).names() == ("none", "displacement", "strain energy", "det F")


def test_displacement_is_in_millimetres(small_tongue, sample_of):
    moved = sample_of(small_tongue.mesh.nodes + np.array([0.003, 0.0, 0.004]))
    field = FieldSource(small_tongue).field("displacement", moved)
    np.testing.assert_allclose(field.values, 5.0, rtol=1e-4)
    assert field.unit == "mm"


def test_a_uniform_stretch_has_uniform_det_f_and_energy_density(small_tongue, sample_of):
    stretched = sample_of(small_tongue.mesh.nodes * [1.1, 1.0, 1.0])
    fields, material = FieldSource(small_tongue), small_tongue.material
    np.testing.assert_allclose(fields.field("det F", stretched).values, 1.1, rtol=1e-5)
    strain = 0.5 * (1.1**2 - 1.0)
    density = (material.lame_mu + 0.5 * material.lame_lambda) * strain**2
    np.testing.assert_allclose(fields.field("strain energy", stretched).values, density, rtol=1e-4)


def test_domain_weights_are_offered_with_a_reduced_model(small_tongue, sample_of):
    model = all_element_model(small_tongue, 5)
    fields = FieldSource(small_tongue, model)
    assert "domain weight TB" in fields.names()
    field = fields.field("domain weight TB", sample_of(small_tongue.mesh.nodes))
    np.testing.assert_array_equal(field.values, model.domain_weights[:, 1])


def test_the_partition_is_offered_as_categories_with_a_reduced_model(small_tongue, sample_of):
    model = all_element_model(small_tongue, 5)
    fields = FieldSource(small_tongue, model)
    assert "domain" in fields.names()
    field = fields.field("domain", sample_of(small_tongue.mesh.nodes))
    assert field.categories == model.domain_names
    at_seeds = [np.argmin(np.linalg.norm(small_tongue.mesh.nodes - seed, axis=1)) for seed in model.seeds]
    np.testing.assert_array_equal(field.values[at_seeds], np.arange(5))


def test_contact_depth_is_offered_where_there_is_a_mouth(small_tongue, sample_of, block, tmp_path, monkeypatch):
    monkeypatch.setenv("LINGUAL_CACHE", str(tmp_path))
    mesh = block((0.04, 0.03, 0.01), (2, 2, 2))
    bone = RigidSurface("bone", "bone", "head", mesh.nodes + np.array([0.03, 0.0, 0.021]), mesh.boundary_triangles)
    fields = FieldSource(replace(small_tongue, rigid=(bone,)))
    assert "contact depth" in fields.names()
    field = fields.field("contact depth", sample_of(small_tongue.mesh.nodes + np.array([0.0, 0.0, 0.002])))
    middle = np.argmin(np.linalg.norm(small_tongue.mesh.nodes - [0.0525, 0.015, 0.02], axis=1))
    assert field.unit == "mm"
    np.testing.assert_allclose(field.values[middle], 1.0, atol=0.02)
    assert not field.values[small_tongue.mesh.nodes[:, 2] < 0.015].any()


def test_an_unknown_field_is_a_key_error(small_tongue, sample_of):
    with pytest.raises(KeyError):
        FieldSource(small_tongue).field("charm", sample_of(small_tongue.mesh.nodes))
