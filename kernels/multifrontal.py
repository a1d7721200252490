"""Assembly of the dense fronts of a sparse Cholesky factorisation, in float32.

A front eliminates `own` unknowns and couples them with `boundary` later ones. It is stored as a panel of `own`
columns with own + boundary rows, column by column, and an update matrix of boundary x boundary, column by
column; of every symmetric matrix only the lower half counts.
"""

from functools import cache
from types import SimpleNamespace

import warp as wp


@cache
def multifrontal_kernels() -> SimpleNamespace:
    """Kernels `place_blocks` and `extend_add`."""

    @wp.kernel(module="unique")
    def place_blocks(
        blocks: wp.array(dtype=wp.mat33f),
        block_of_entry: wp.array(dtype=wp.int32),
        entry_offset: wp.array(dtype=wp.int32),
        entry_rows: wp.array(dtype=wp.int32),
        panel_out: wp.array(dtype=wp.float32),
    ):
        """One thread writes one 3x3 block of the matrix into its front's panel."""
        n = wp.tid()
        block = blocks[block_of_entry[n]]
        for c in range(3):
            for r in range(3):
                panel_out[entry_offset[n] + c * entry_rows[n] + r] = block[r, c]

    @wp.kernel(module="unique")
    def extend_add(
        update: wp.array(dtype=wp.float32),
        child_offset: int,
        child_size: int,
        places: wp.array(dtype=wp.int32),
        places_offset: int,
        own_nodes: int,
        panel_offset: int,
        parent_offset: int,
        parent_size: int,
        panel_out: wp.array(dtype=wp.float32),
        update_out: wp.array(dtype=wp.float32),
    ):
        """One thread adds one node's three columns of a child's update matrix to the parent's front.

        places: node of the parent's front (own nodes first) for each node of the child's boundary.
        `update_out` is `update`: the two matrices are different parts of one array.
        """
        column_node = wp.tid()
        target = places[places_offset + column_node]
        rows = 3 * own_nodes + parent_size
        for row_node in range(column_node, child_size / 3):
            row = 3 * places[places_offset + row_node]
            source = child_offset + 3 * column_node * child_size + 3 * row_node
            if target < own_nodes:
                into = panel_offset + 3 * target * rows + row
                for c in range(3):
                    for r in range(3):
                        panel_out[into + c * rows + r] += update[source + c * child_size + r]
            else:
                into = parent_offset + 3 * (target - own_nodes) * parent_size + row - 3 * own_nodes
                for c in range(3):
                    for r in range(3):
                        update_out[into + c * parent_size + r] += update[source + c * child_size + r]

    return SimpleNamespace(place_blocks=place_blocks, extend_add=extend_add)
