"""Disagreement: how much single photos disagree on the surface, and energies over neighbourhoods.

In      the surface as the photos see it and the normal equations of a round.
Out     random-sign sums of the photos' right-hand sides; the ratio of the photos' errors to their
        disagreement; means over neighbourhoods of measured vertices.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float64, Int64

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.measurement_pass import JointEquations, ObservedSurface
from limbgram.reconstruction.measuring.thin_plate import ThinPlate

PROBES = 6
"""Random-sign sums of the photos' right-hand sides; each costs a solution. The mean of their
squares scatters by 1 / sqrt(6) where two photos see a place, by 0.1 where six do."""
MIN_PAINTED_SIGNAL = 0.8
"""Signal from which a vertex shows the height of the relief: bare skin has 0.1, dabs 0.9."""
MIN_TEXTURED_SIGNAL = 0.5
"""Signal from which a vertex is textured, and paint near it shows a crease: texture determines the
surface more than noise does."""
NOISE_RINGS, DETAIL_RINGS, WIDE_RINGS = 20, 10, 40
"""Radii, in rings, of the neighbourhoods over which energies are pooled."""
SEED = 11
"""Seed of all random numbers."""
ERROR_CORRELATION, DAB_ERROR_CORRELATION = 0.14, 0.28
"""Effective correlation of two photos' errors in even paint (0.05 to 0.2 with the surface fixed at
the truth), and in a dab far from any other, from the errors of five captures with little paint."""
_OUTLIER_RATIO = 9.0
"""An energy that exceeds its wide mean by more than this factor is an outlier of the mesh."""
_RIM_RINGS = 3


def probe_right_sides(
    mesh: Mesh, observed: ObservedSurface, equations: JointEquations
) -> list[Float64[np.ndarray, " n"]]:
    """Right-hand sides of all photos, summed with random signs; one sum per probe.

    Each photo's sign is drawn independently: the mean square of the sums is then the sum of the
    photos' squares, however few photos see a place and however they are correlated.
    """
    photo = observed.seen_by[mesh.faces[:, 0]]
    signs = np.random.default_rng(SEED).choice((-1.0, 1.0), (PROBES, photo.max(initial=0) + 1))
    found: list[Float64[np.ndarray, " n"]] = []
    for photo_signs in signs:
        shares = np.repeat((equations.right_by_photo * photo_signs[photo]).sum(axis=1) / 3, 3)
        found.append(np.bincount(mesh.faces.ravel(), shares, len(mesh)))
    return found


def error_over_disagreement(
    photo_count: Int64[np.ndarray, " n"],
    correlation: float | Float64[np.ndarray, " n"] = ERROR_CORRELATION,
) -> Float64[np.ndarray, " n"]:
    """Energy of the photos' errors, including correlated ones, over that of their disagreement."""
    count = np.maximum(photo_count, 2).astype(np.float64)
    return count / (count - 1) * (1 + (count - 1) * correlation) / (1 - correlation)


def robust_mean_square(values: Float64[np.ndarray, " n"]) -> float:
    """Mean of the squares with outliers clipped; 0 of no values."""
    if not len(values):
        return 0.0
    squares = values**2
    return float(np.mean(np.minimum(squares, 2 * _OUTLIER_RATIO * np.median(squares))))


@dataclass(frozen=True)
class Pool:
    """Means over neighbourhoods of vertices."""

    ring_mean: sp.csr_matrix
    """(n, n) mean over a vertex and its 1-ring."""
    counted: Bool[np.ndarray, " n"]
    """Measured vertices away from the rim."""
    counted_shares: dict[int, Float64[np.ndarray, " n"]]
    """Weighted share of counted vertices round each vertex, by the number of rings."""

    @classmethod
    def of(cls, thin_plate: ThinPlate, photo_count: Int64[np.ndarray, " n"]) -> "Pool":
        """The pool of all vertices that two photos measured, away from the rim."""
        ring = sp.csr_matrix(thin_plate.neighbours + sp.eye(len(photo_count)))
        ring_mean = sp.csr_matrix(sp.diags(1 / np.asarray(ring.sum(1)).ravel()) @ ring)
        near_rim = thin_plate.is_boundary.astype(np.float64)
        for _ in range(_RIM_RINGS):
            near_rim = ring_mean @ near_rim
        return cls._counting(ring_mean, (near_rim == 0) & (photo_count > 1))

    @classmethod
    def _counting(cls, ring_mean: sp.csr_matrix, counted: Bool[np.ndarray, " n"]) -> "Pool":
        """The pool that counts these vertices."""
        counted_shares, share = dict[int, Float64[np.ndarray, " n"]](), counted.astype(np.float64)
        for ring_count in range(1, WIDE_RINGS + 1):
            share = ring_mean @ share
            if ring_count in (DETAIL_RINGS, NOISE_RINGS, WIDE_RINGS):
                counted_shares[ring_count] = share
        return cls(ring_mean, counted, counted_shares)

    def restricted_to(self, chosen: Bool[np.ndarray, " n"]) -> "Pool":
        """The pool of these vertices alone; this pool where it would have none."""
        counted = self.counted & chosen
        return self._counting(self.ring_mean, counted) if counted.any() else self

    def mean(
        self, values: Float64[np.ndarray, "n ..."], rings: int = 3
    ) -> Float64[np.ndarray, "n ..."]:
        """Means over so many rings of all vertices."""
        for _ in range(rings):
            values = self.ring_mean @ values
        return values

    def energy(self, squares: Float64[np.ndarray, " n"], rings: int) -> Float64[np.ndarray, " n"]:
        """Means over the counted vertices of so many rings, with outliers clipped."""
        if not self.counted.any():
            return squares
        counted = squares[self.counted]
        limit = 2 * _OUTLIER_RATIO * float(np.median(counted))
        typical = float(np.mean(np.minimum(counted, limit)))
        capped = np.minimum(squares, 2 * _OUTLIER_RATIO * typical)
        wide = self._counted_mean(capped, WIDE_RINGS, typical)
        return self._counted_mean(np.minimum(squares, _OUTLIER_RATIO * wide), rings, typical)

    def _counted_mean(
        self, values: Float64[np.ndarray, " n"], rings: int, fallback: float
    ) -> Float64[np.ndarray, " n"]:
        """Means over counted vertices; `fallback` far from any of them."""
        total = self.mean(np.where(self.counted, values, 0.0), rings)
        return (total + 0.02 * fallback) / (self.counted_shares[rings] + 0.02)
