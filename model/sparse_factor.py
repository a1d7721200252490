"""Direct factorisation of sparse symmetric positive definite matrices."""

import numpy as np
import scipy.sparse as sp
import scipy.sparse.linalg as sla


def factorise(matrix: sp.sparray) -> sla.SuperLU:
    """A sparse factor, with an ordering made for symmetric matrices; its `solve` takes vectors or columns.

    Raises numpy.linalg.LinAlgError when the matrix is singular.
    """
    options = {"SymmetricMode": True}
    try:
        return sla.splu(matrix.tocsc(), permc_spec="MMD_AT_PLUS_A", diag_pivot_thresh=0.0, options=options)
    except RuntimeError as error:
        raise np.linalg.LinAlgError(str(error)) from error
