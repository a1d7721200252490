"""Kernels between nodes and elements against NumPy."""

import numpy as np
import pytest
import warp as wp

from lingual.kernels.full_space import full_space_kernels

RNG = np.random.default_rng(2)
NODES, ELEMENTS = 9, 12
TETS = np.stack([RNG.permutation(NODES)[:4] for _ in range(ELEMENTS)]).astype(np.int32)
SHAPE_GRADIENTS = RNG.standard_normal((ELEMENTS, 4, 3))


@pytest.fixture
def kernels(types):
    return full_space_kernels(types.numpy.name)


def test_displacement_gradient_sums_the_corners(kernels, types, launch, close):
    u = RNG.standard_normal((NODES, 3))
    inputs = [(u, types.vec3), (TETS, wp.int32), (SHAPE_GRADIENTS, types.vec3)]
    gradient = launch(kernels.displacement_gradient, ELEMENTS, inputs, ELEMENTS, types.mat33)
    close(gradient, np.einsum("eaj,eai->eji", SHAPE_GRADIENTS, u[TETS]))


def lists(owner: np.ndarray, count: int) -> list[tuple[np.ndarray, type]]:
    """Start of each owner's list and the lists of the places in `owner`; -1 owns nothing."""
    members = [np.flatnonzero(owner.ravel() == n) for n in range(count)]
    starts = np.cumsum([0] + [len(m) for m in members])
    return [(starts.astype(np.int32), wp.int32), (np.concatenate(members).astype(np.int32), wp.int32)]


def test_gather_force_adds_every_element_to_its_nodes(kernels, types, launch, close):
    stress = RNG.standard_normal((ELEMENTS, 3, 3))  # [j, i]
    inputs = [(stress, types.mat33), (SHAPE_GRADIENTS, types.vec3), *lists(TETS, NODES)]
    force = launch(kernels.gather_force, NODES, inputs, NODES, types.vec3)
    expected = np.zeros((NODES, 3))
    np.add.at(expected, TETS, np.einsum("eji,eaj->eai", stress, SHAPE_GRADIENTS))
    close(force, expected)


def test_gather_stiffness_adds_node_pairs_and_skips_fixed_ones(kernels, types, launch, close):
    tangent = RNG.standard_normal((ELEMENTS, 3, 3, 3, 3))  # [i, m, j, n]
    pairs = TETS[:, :, None] * NODES + TETS[:, None, :]
    pairs[(TETS[:, :, None] == 0) | (TETS[:, None, :] == 0)] = -1  # node 0 is fixed
    inputs = [(tangent, types.mat33), (SHAPE_GRADIENTS, types.vec3), *lists(pairs, NODES**2)]
    blocks = launch(kernels.gather_stiffness, NODES**2, inputs, NODES**2, types.mat33)
    element = np.einsum("eaj,eimjn,ebn->eabim", SHAPE_GRADIENTS, tangent, SHAPE_GRADIENTS)
    expected = np.zeros((NODES**2, 3, 3))
    np.add.at(expected, pairs[pairs >= 0], element[pairs >= 0])
    close(blocks, expected)
    assert not blocks[:NODES].any()
