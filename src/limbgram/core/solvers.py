"""Small dense systems, solved inside compiled kernels without LAPACK, whose calls cost more.

A compiled function takes `fastmath` and `error_model` from whichever caller is compiled first, and
keeps them in its cache; the functions here set both, so that every caller gets the same bits.
`adjugate` is inlined and follows the kernel that it stands in.
"""

import math

import numpy as np

from limbgram.core.kernels import inlined, njit

_SINGULAR = 1e-15


@inlined
def adjugate(a: float, b: float, c: float, d: float, e: float, f: float):
    """Six cofactors and the determinant of the symmetric matrix [a b c; b d e; c e f].

    The cofactors stand in the same order; divided by the determinant they are the inverse.
    """
    first, second, third = d * f - e * e, c * e - b * f, b * e - c * d
    fourth, fifth, sixth = a * f - c * c, b * c - a * e, a * d - b * b
    return first, second, third, fourth, fifth, sixth, a * first + b * second + c * third


@njit(cache=True, nogil=True, fastmath=False, error_model="numpy")
def invert_symmetric(matrix: np.ndarray, inverse: np.ndarray) -> bool:
    """Fill the inverse of a positive definite 3 x 3 matrix; False if it is numerically singular."""
    a, b, c = matrix[0, 0], matrix[0, 1], matrix[0, 2]
    d, e, f = matrix[1, 1], matrix[1, 2], matrix[2, 2]
    first, second, third, fourth, fifth, sixth, determinant = adjugate(a, b, c, d, e, f)
    if not determinant > _SINGULAR * a * d * f:
        return False
    inverse[0, 0] = first / determinant
    inverse[0, 1] = inverse[1, 0] = second / determinant
    inverse[0, 2] = inverse[2, 0] = third / determinant
    inverse[1, 1] = fourth / determinant
    inverse[1, 2] = inverse[2, 1] = fifth / determinant
    inverse[2, 2] = sixth / determinant
    return True


@njit(cache=True, nogil=True, fastmath=False, error_model="numpy")
def solve_positive(system: np.ndarray, least: float, answer: np.ndarray) -> bool:
    """Solve a symmetric positive definite system by Cholesky's method, into `answer`.

    `system` (n, n + 1) holds the upper triangle and the right-hand side, and is overwritten. False
    if a pivot is not larger than `least`: the system does not determine the answer.
    """
    size = len(system)
    for a in range(size):
        for c in range(a):
            system[a, a] -= system[c, a] * system[c, a]
        if not system[a, a] > least:
            return False
        system[a, a] = math.sqrt(system[a, a])
        for b in range(a + 1, size + 1):
            for c in range(a):
                system[a, b] -= system[c, a] * system[c, b]
            system[a, b] /= system[a, a]
    for a in range(size - 1, -1, -1):
        value = system[a, size]
        for b in range(a + 1, size):
            value -= system[a, b] * answer[b]
        answer[a] = value / system[a, a]
    return True
