"""Small dense systems, solved inside compiled kernels without LAPACK.

The calls that pass by LAPACK cost more than these systems themselves. A compiled function takes
`fastmath` and `error_model` from whichever caller is compiled first, and keeps them in its cache;
so the functions here name both, and give every caller the same bits. `adjugate` is inlined instead
and follows the kernel that it stands in.
"""

import math

import numpy as np

from limbgram.core.kernels import inlined, njit

_SINGULAR = 1e-15


@inlined
def adjugate(a: float, b: float, c: float, d: float, e: float, f: float):
    """Of the symmetric matrix [a b c; b d e; c e f]: its six cofactors, in this order, and its
    determinant. The inverse is the cofactors over the determinant.
    """
    first, second, third = d * f - e * e, c * e - b * f, b * e - c * d
    fourth, fifth, sixth = a * f - c * c, b * c - a * e, a * d - b * b
    return first, second, third, fourth, fifth, sixth, a * first + b * second + c * third


@njit(cache=True, nogil=True, fastmath=False, error_model="numpy")
def invert_symmetric(matrix: np.ndarray, inverse: np.ndarray) -> bool:
    """Fill `inverse` of a positive 3 x 3 matrix; False where it is singular to rounding."""
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
    """Fill `answer` of a symmetric positive system by Cholesky's method.

    `system` (n, n + 1) holds the upper triangle and the right side, and is overwritten. False
    where a pivot is not larger than `least`: the system does not determine the answer.
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
