"""Quadrics: how the surface bends round each vertex, by least squares over two rings (compiled)."""

import numpy as np
from jaxtyping import Float64
from numba import njit

from limbgram.measuring.plate.bending import Plate
from limbgram.surface.mesh import Mesh


def quadrics(
    mesh: Mesh, plate: Plate, axes: Float64[np.ndarray, "n 3 3"]
) -> Float64[np.ndarray, "n 3"]:
    """Curvature (uu, uv, vv), 1/mm, of the least-squares quadric through each vertex's rings."""
    count = len(mesh)
    normal, right = np.zeros((count, 5, 5)), np.zeros((count, 5))
    _add_up(
        plate.neighbours.indptr.astype(np.int32),
        plate.neighbours.indices.astype(np.int32),
        mesh.vertices_mm,
        axes,
        normal,
        right,
    )
    diagonal = np.einsum("nii->ni", normal)
    diagonal *= 1.0 + 1e-4
    diagonal += 1e-9
    return np.linalg.solve(normal, right[..., None])[:, 2:, 0]


@njit(cache=True, nogil=True)
def _add_up(starts, others, vertices, axes, normal, right):
    """Normal equations of slopes (2) and curvatures (3) over the neighbours' neighbours."""
    count = len(vertices)
    seen = np.full(count, -1, np.int32)
    terms = np.empty(5)
    for centre in range(count):
        seen[centre] = centre
        for near in range(starts[centre], starts[centre + 1]):
            ring = others[near]
            for far in range(starts[ring], starts[ring + 1]):
                other = others[far]
                if seen[other] == centre:
                    continue
                seen[other] = centre
                u = v = height = 0.0
                for k in range(3):
                    step = vertices[other, k] - vertices[centre, k]
                    u += axes[centre, 0, k] * step
                    v += axes[centre, 1, k] * step
                    height += axes[centre, 2, k] * step
                terms[0], terms[1] = u, v
                terms[2], terms[3], terms[4] = 0.5 * u * u, u * v, 0.5 * v * v
                for a in range(5):
                    right[centre, a] += terms[a] * height
                    for b in range(a, 5):
                        normal[centre, a, b] += terms[a] * terms[b]
        for a in range(5):
            for b in range(a):
                normal[centre, a, b] = normal[centre, b, a]
