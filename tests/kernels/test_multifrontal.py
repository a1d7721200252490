"""Assembly of fronts against NumPy."""

import numpy as np
import warp as wp

from lingual.kernels.multifrontal import multifrontal_kernels

RNG = np.random.default_rng(4)


def test_extend_add_places_the_lower_half_of_a_child_among_its_parents_nodes():
    """A child with 4 boundary nodes; its parent eliminates 2 nodes and couples them with 3."""
    child, own, boundary, places = 12, 2, 9, np.array([0, 1, 2, 4], dtype=np.int32)
    full = RNG.standard_normal((child, child)).astype(np.float32)
    full += full.T
    update: wp.array = wp.array(np.concatenate([full.ravel(), np.zeros(boundary**2)]), dtype=wp.float32, device="cpu")
    panel = wp.zeros(3 * own * (3 * own + boundary), dtype=wp.float32, device="cpu")
    at: wp.array = wp.array(places, dtype=wp.int32, device="cpu")
    inputs = [update, 0, child, at, 0, own, 0, child**2, boundary]
    wp.launch(multifrontal_kernels().extend_add, child // 3, inputs, [panel, update], device="cpu")
    unknowns = (3 * places[:, None] + np.arange(3)).ravel()
    expected = np.zeros((15, 15), dtype=np.float32)
    expected[np.ix_(unknowns, unknowns)] = full
    lower = np.tril(np.ones((15, 15), dtype=bool))
    left = panel.numpy().reshape(3 * own, 15).T
    right = update.numpy()[child**2 :].reshape(boundary, boundary).T
    np.testing.assert_array_equal(left[lower[:, : 3 * own]], expected[:, : 3 * own][lower[:, : 3 * own]])
    np.testing.assert_array_equal(np.tril(right), np.tril(expected[3 * own :, 3 * own :]))


def test_place_blocks_writes_column_by_column():
    blocks = RNG.standard_normal((3, 3, 3)).astype(np.float32)
    arrays = [wp.array(blocks, dtype=wp.mat33f, device="cpu")]
    arrays += [wp.array(np.array(a, dtype=np.int32), dtype=wp.int32, device="cpu") for a in ([2, 0], [0, 3], [6, 6])]
    panel = wp.zeros(18, dtype=wp.float32, device="cpu")
    wp.launch(multifrontal_kernels().place_blocks, 2, arrays, [panel], device="cpu")
    np.testing.assert_array_equal(panel.numpy().reshape(3, 6).T, np.concatenate([blocks[2], blocks[0]]))
