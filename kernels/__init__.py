"""Warp kernels only: arrays in, arrays out.

Conventions of this folder: one thread's work is stated in the first line of every kernel;
inputs come first, what is written ends in `_out`. Element tensors are stored with the derivative
direction as the row: `gradient[e][j, i]` = du_i/dX_j, so that F = I + gradient^T, and the stress
that is conjugate to it, `stress[e][j, i]` = weight * P_ij. In this layout the reduced quantities are
plain matrix products of the stacked (3 * tet_count, columns) gradient operator.
"""

from .startup import start_warp

start_warp()
