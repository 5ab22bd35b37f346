"""Disagreement: by how much single photos pull the surface apart, and energies over neighbourhoods.

In      the surface as the photos see it and the equations of a round.
Out     sums of the photos' pulls; what energy of their disagreement tells of the energy of their
        errors; means over the vertices near by, of those that were measured.
"""

from dataclasses import dataclass

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float64, Int64

from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.measurement_pass import JointEquations, SeenSurface
from limbgram.reconstruction.measuring.thin_plate import ThinPlate

PROBES = 6
"""Sums of the photos' pulls with signs drawn anew; each costs a solution. What they tell of two
photos alone scatters by 1 / sqrt(6) in its square, of six photos by 0.1."""
PAINTED = 0.8
"""Signal from which a vertex tells how high the relief is: bare skin has 0.1, dabs 0.9."""
SHOWN = 0.5
"""Signal from which a vertex, and its paint near by a crease, shows: more texture than noise holds
the surface."""
NOISE_RINGS, DETAIL_RINGS, WIDE_RINGS = 20, 10, 40
"""Neighbourhoods over which energies are pooled."""
SEED = 11
"""Of all that is drawn."""
_COMMON = 0.14
"""Correlation of two photos' errors: 0.05 to 0.2 with the surface held at the truth."""
_MOST_OVER_POOLED = 9.0
"""An energy further over its wide mean than this is an oddity of the mesh."""
_RIM_RINGS = 3


def pulls_of(
    mesh: Mesh, seen: SeenSurface, equations: JointEquations
) -> list[Float64[np.ndarray, " n"]]:
    """What the photos pull the surface by, added up with signs.

    Each photo's sign is drawn by itself: the mean square of the sums is then the sum of the photos'
    squares, however few photos see a place and whatever their pulls have in common.
    """
    photo = seen.seen_by[mesh.faces[:, 0]]
    signs = np.random.default_rng(SEED).choice((-1.0, 1.0), (PROBES, photo.max(initial=0) + 1))
    found: list[Float64[np.ndarray, " n"]] = []
    for drawn in signs:
        pulls = np.repeat((equations.pull * drawn[photo]).sum(axis=1) / 3, 3)
        found.append(np.bincount(mesh.faces.ravel(), pulls, len(mesh)))
    return found


def times_unseen(photos: Int64[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    """Energy of the photos' errors, those that they have alike too, over their disagreement's."""
    count = np.maximum(photos, 2).astype(np.float64)
    return count / (count - 1) * (1 + (count - 1) * _COMMON) / (1 - _COMMON)


def usual_square(values: Float64[np.ndarray, " n"]) -> float:
    """Mean of the squares, single odd ones cut off; 0 of nothing."""
    if not len(values):
        return 0.0
    squares = values**2
    return float(np.mean(np.minimum(squares, 2 * _MOST_OVER_POOLED * np.median(squares))))


@dataclass(frozen=True)
class Pool:
    """Means over neighbourhoods of vertices."""

    step: sp.csr_matrix
    """Mean over a vertex and its neighbours."""
    counted: Bool[np.ndarray, " n"]
    """Away from the rim, and measured."""
    shares: dict[int, Float64[np.ndarray, " n"]]
    """Of what is counted, within so many rings of each vertex."""

    @classmethod
    def of(cls, thin_plate: ThinPlate, photos: Int64[np.ndarray, " n"]) -> "Pool":
        ring = sp.csr_matrix(thin_plate.neighbours + sp.eye(len(photos)))
        step = sp.csr_matrix(sp.diags(1 / np.asarray(ring.sum(1)).ravel()) @ ring)
        near_rim = thin_plate.is_boundary.astype(np.float64)
        for _ in range(_RIM_RINGS):
            near_rim = step @ near_rim
        return cls._counting(step, (near_rim == 0) & (photos > 1))

    @classmethod
    def _counting(cls, step: sp.csr_matrix, counted: Bool[np.ndarray, " n"]) -> "Pool":
        shares, share = dict[int, Float64[np.ndarray, " n"]](), counted.astype(np.float64)
        for ring_count in range(1, WIDE_RINGS + 1):
            share = step @ share
            if ring_count in (DETAIL_RINGS, NOISE_RINGS, WIDE_RINGS):
                shares[ring_count] = share
        return cls(step, counted, shares)

    def among(self, chosen: Bool[np.ndarray, " n"]) -> "Pool":
        """The same of these vertices alone; of all where none is left."""
        counted = self.counted & chosen
        return self._counting(self.step, counted) if counted.any() else self

    def mean(
        self, values: Float64[np.ndarray, "n ..."], rings: int = 3
    ) -> Float64[np.ndarray, "n ..."]:
        for _ in range(rings):
            values = self.step @ values
        return values

    def energy(self, squares: Float64[np.ndarray, " n"], rings: int) -> Float64[np.ndarray, " n"]:
        """Mean of the counted vertices near by, single odd ones cut off."""
        if not self.counted.any():
            return squares
        counted = squares[self.counted]
        most = 2 * _MOST_OVER_POOLED * float(np.median(counted))
        usual = float(np.mean(np.minimum(counted, most)))
        capped = np.minimum(squares, 2 * _MOST_OVER_POOLED * usual)
        wide = self._counted_mean(capped, WIDE_RINGS, usual)
        return self._counted_mean(np.minimum(squares, _MOST_OVER_POOLED * wide), rings, usual)

    def _counted_mean(
        self, values: Float64[np.ndarray, " n"], rings: int, otherwise: float
    ) -> Float64[np.ndarray, " n"]:
        """Far from any counted vertex the whole surface's mean takes over."""
        total = self.mean(np.where(self.counted, values, 0.0), rings)
        return (total + 0.02 * otherwise) / (self.shares[rings] + 0.02)
