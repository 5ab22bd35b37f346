"""Inverse of symmetric 3 x 3 matrices inside kernels, without a call to LAPACK."""

import numpy as np
from numba import njit

_SINGULAR = 1e-15


@njit(cache=True, nogil=True)
def invert_symmetric(matrix: np.ndarray, inverse: np.ndarray) -> bool:
    """Fill `inverse`; False, and nothing filled, where the matrix is singular to rounding."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 1], matrix[1, 2], matrix[2, 2]
    first, second, third = d * f - e * e, c * e - b * f, b * e - c * d
    determinant = a * first + b * second + c * third
    if not determinant > _SINGULAR * a * d * f:
        return False
    inverse[0, 0] = first / determinant
    inverse[0, 1] = inverse[1, 0] = second / determinant
    inverse[0, 2] = inverse[2, 0] = third / determinant
    inverse[1, 1] = (a * f - c * c) / determinant
    inverse[1, 2] = inverse[2, 1] = (b * c - a * e) / determinant
    inverse[2, 2] = (a * d - b * b) / determinant
    return True
