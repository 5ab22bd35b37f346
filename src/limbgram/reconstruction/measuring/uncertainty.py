"""Uncertainty: one standard deviation along the normal for every measured vertex.

In      the measured mesh, the normal equations of its last round, the photos of each vertex, and
        the metric scene with the covariance of its cameras.
Out     the mesh with its sigmas: local errors of each vertex (variance, correlation length, and how
        much longer a line along the limb is than along the measured surface), and errors that all
        vertices share (displacement by one standard deviation of each source). Sigmas describe the
        shape, not its position in the world.
Method  Noise: the right-hand side of each photo, solved through the thin plate, shows how photos
        disagree (a sandwich estimator with the photos as clusters: Liang and Zeger 1986); it
        contains sensor noise, shading, pose errors and gaps. The matrix of that solution contains
        the texture that photos share, not the slopes of their noise (`signal_share`).
        Detail: the plate removes (1 - H) x from the surface x, H being its response. (1 - H)^2 H x
        is observed where there is paint, and for relief whose power falls like the wave number's
        fifth to seventh power the lost part has about a constant multiple of its energy. Elsewhere
        that grows with the variance of relief given the data (kriging variance), which is sampled
        from the plate's prior. It grows with the square of the length over which nothing is
        observed; the limb's own relief grows with length as paint shows. Energies are pooled over
        neighbourhoods. Lost detail of folds is correlated all along them (`creases`).
        Lines: relief of slope s lengthens a line by the fraction s^2 / 4 in the mean of all
        directions. What is lost follows from the slope of (1 - H) x, what noise adds from the slope
        of the photos' disagreement.
        Shared: a photo moved by p sees another point of the tangent plane, s_k p away; the surface
        moves by -sum (t_k - t)'(s_k - s) / sum |t_k - t|^2 to make the photos agree again, t_k
        being how far along the plane photo k moves for a millimetre along the normal, t and s
        their means (for isotropic texture). Board or known lengths set the scale in each case
        anew, and rigid motions of the whole surface are removed: they do not change its shape.
        Faces: photos are sampled all over the flat faces, whose middles therefore lie as deep in
        the limb as their vertices stand out of it; a fifth of the chordal deviation remains.
        Gaps: depth maps span the gaps between paint as chords do, all with the same sign, and the
        rounds correct about a half of that.
        docs/method.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float64, Int32

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, project_and_differentiate
from limbgram.core.geometry.smoothed_length import FILTER_LENGTH_MM
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import edge_lengths, find_edges
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.measuring.anisotropic_plate import (
    pooled_structure_tensors,
    structure_tensors,
)
from limbgram.reconstruction.measuring.creases import lost_creases_mm
from limbgram.reconstruction.measuring.disagreement import (
    DAB_ERROR_CORRELATION,
    DETAIL_RINGS,
    ERROR_CORRELATION,
    MIN_PAINTED_SIGNAL,
    NOISE_RINGS,
    PROBES,
    SEED,
    WIDE_RINGS,
    Pool,
    error_over_disagreement,
    probe_right_sides,
    robust_mean_square,
)
from limbgram.reconstruction.measuring.measurement_pass import JointEquations, ObservedSurface
from limbgram.reconstruction.measuring.reference_plate import ReferencePlateFit
from limbgram.reconstruction.measuring.thin_plate import (
    PlainPlates,
    ThinPlate,
    bending_matrix,
    solve,
    solve_all,
)
from limbgram.reconstruction.scale.metric import MetricScene

_LOST_PER_DETAIL = 12.0
"""Energy of the detail that the plate removed over that of (1 - H)^2 H x. Theory gives 30 for
relief of all wave lengths, less where the mesh or the relief ends; seven captures of our own have 7
to 14."""
_GROWTH_LENGTHS = (0.35, 0.7, 1.0, 1.4, 2.0, 4.0)
"""Plate lengths, in that of the typical vertex, at which the growth of relief is measured."""
_DETAIL_BY_SHARE, _SLOPE_BY_SHARE = 0.5, 0.25
"""Powers with which the lost detail and slope grow with the plate's share of the reference
stiffness. Theory, plates of 2 mm on edges of 3 mm, shares of 0.6, 0.4 and 0.2: 0.69, 0.49, 0.24 of
the energy and 0.89, 0.81, 0.65 of the slope along a smoothed line where relief ends at 5 mm; 0.77,
0.61, 0.40 and 0.90, 0.82, 0.68 at 2.5 mm; 0.83, 0.70, 0.50 and 0.94, 0.89, 0.78 over wrinkles.
These powers: 0.77, 0.63, 0.45 and 0.88, 0.80, 0.67."""
_NOISE_IN_DETAIL = 0.055
"""Energy of white noise in (1 - H)^2 H x over that of its error: B(4.5, 1.5) / B(.5, 1.5), from its
spectrum through the plate."""
_LOST_SLOPE, _LOST_SLOPE_PER_MM = -6.0, 17.0
"""Squared slope that the plate removed from the relief ((1 - H^2) of it), as far as a line keeps it
at the smoothing length, over that of (1 - H) H x: an offset, and a slope by the plate's length; at
least 0. Relief of skin and cloth has a shortest wave length, which hardly matters to a smoothed
line: for 0.8, 1.8 and 2.25 mm theory gives 9, 23 and 31 times the observed slope for relief that
ends at 5 mm, 7, 29 and 38 if at 2.5 mm, 8, 30 and 39 if nowhere (14, 30, 39;
26, 63, 77; and 70 to 160 without smoothing, where captures of relief that ends at 5 mm had 12 to 15
at 0.8 mm and 23 to 40 at 1.7 to 2.2 mm)."""
_LOST_SLOPE_SIGMA, _FOLDED_SIGMA = 0.25, 0.3
"""Relative standard deviations of that factor, and of its part that lies across folds."""
_ISOTROPIC_EXCESS = 0.15
"""Apparent anisotropy of isotropic relief, by chance and because photos from round a limb see its
relief less well round it than along it. With this, contours round creased skin err by 0.09 mm,
without it by 0.13 mm, and by 0.14 mm if folds count as isotropic."""
_NOISE_SLOPE_EXPONENT = 2.7
"""Exponent in 1 / (1 + (smoothing length / plate length)^this), the share of the squared slope of
noise that a smoothed line keeps: 0.50, 0.75, 0.90, 0.94 for 0.8 to 2.25 mm; theory (white data
noise through the plate) gives 0.47, 0.72, 0.89 and 0.94."""
_BANDS = (0.67, 1.0), (1.5, 2.25)
"""Two bands of wave lengths, in lengths of the plate, whose heights show how relief grows with its
wave length. Adjacent bands show it less well: each contains only a few waves of a limb."""
_BAND_RATIOS = 2.40, 2.65
"""Height of the relief in the coarser band over that in the finer one: at the first ratio, relief
is about as high at all lengths; from the second on, the factors above hold. Theory: 2.14 for relief
of one height at all lengths, 2.43 for relief that grows with the power 0.2 of its length, 3.2 for
0.7. Eleven of thirteen wrinkled captures have 2.04 to 2.39, eighteen usual ones 2.73 to 3.28,
limb_ring15 2.90, foot_ring24 2.77, limb_sparse15 3.17."""
_MIN_RELIEF_OVER_NOISE = 1.0
"""Energy of relief over that of noise in the finer band, from which the ratio is used."""
_WRINKLED_SLOPE, _WRINKLED_SLOPE_PER_MM, _WRINKLED_DETAIL = 0.5, 0.43, 2.0
"""Factors of wrinkled relief: on the lost slope, an offset and a slope by the plate's length
(captures have 1.4 at 2.1 mm, theory less than one below 1 mm, where most relief is finer than the
smoothing length); on the lost energy, by theory."""
_NOISE_SLOPE_SIGMA = 0.17
"""Relative standard deviation of the squared slope of the noise: correlated errors of the photos
may be steeper or flatter than uncorrelated ones. This and the two above make the errors of 120
contours (`intervals.py`, 24 captures in five settings) the most likely; folds are too few there, so
that 0.3 is a bound."""
_DRAWS = 4
"""Samples of the plate's prior for the kriging variance."""
_FLOOR_SHARE = 0.01
"""Share of the median noise and information that is added at every vertex."""
_DENSITY_RINGS, _DRAW_RINGS = 3, 8
"""Rings over which the logarithm of the information is averaged for the expected variance, and over
which the samples correct that: four samples alone scatter by a third."""
_START_ERROR_PX, _CORRECTING_ROUNDS, _GAP_RINGS = 0.3, 2, 6
"""Error, in pixels, of the surface that the joint rounds start from, in the middle of a wide gap;
the number of rounds assumed to correct it, as further ones correct less than predicted; and rings
within which the gap's middle is searched. Of 0 to 0.45 px, 0.25 to 0.3 makes the errors of ten
captures with little paint the most likely."""
_UNCONFIRMED_PX = 0.12
"""Additional error, in pixels, where fewer than two photos agree."""
_MAX_START_ERROR_LEFT = 0.5
"""A guessed vertex that keeps more than this of an error is still a guess: in eight captures with
half of the paint left out, errors of guesses were 0.5 px below this and up to 4.9 mm above it."""
_LONG_EDGE_RATIO = 1.5
"""Length of an edge, in median edges, from which its ends count as unsupported. Where such an edge,
a guess or a vertex on which no two photos agree touches a fill, two patchy captures were up to 9 mm
off with sigmas of 0.3 mm; without them the rest has an RMS of 0.16 mm (0.31) and of 0.20 (0.23)."""
_CORRELATION_LENGTHS = 2.26
"""Correlation length over plate length: pi reach^2 is the area 16 length^2 of its noise."""


@dataclass(frozen=True, kw_only=True)
class LocalErrors:
    """Errors of each vertex that are correlated with those of its neighbourhood alone."""

    variance_mm2: Float64[np.ndarray, " n"]
    reach_mm: float
    """Errors of two vertices at a distance d correlate by exp(-(d / reach)^2)."""
    lost_length: Float64[np.ndarray, "n 2"]
    """As `Mesh.lost_length` has it."""
    lost_across: Float64[np.ndarray, "n 3"]
    """As `Mesh.lost_across` has it."""
    start_error_left: Float64[np.ndarray, " n"]
    """Share of an error of the given surface that remains after the rounds, 0 to 1."""
    creases_mm: Float64[np.ndarray, "n 2"]
    """Two sources of error from lost creases, in quadrature, correlated all along the folds; part
    of the variance."""


def local_errors(
    mesh: Mesh, observed: ObservedSurface, equations: JointEquations, reference: ReferencePlateFit
) -> LocalErrors:
    """Local errors of a mesh that was measured with these equations.

    Args:
        equations: With the plate that measured the mesh.
        reference: The response of the reference plate to the same equations.
    """
    thin_plate = observed.thin_plate
    plate = sp.csr_matrix(bending_matrix(equations.plate, equations.stiffness))
    pool = Pool.of(thin_plate, equations.photo_count)
    painted = pool.restricted_to(equations.signal > MIN_PAINTED_SIGNAL)
    error_factor = error_over_disagreement(equations.photo_count)
    kriging = _kriging_variance(thin_plate, equations, pool)
    noise_level = kriging * _noise_per_information(mesh, equations, pool)

    start_error_left = _start_error_left(plate, equations)
    share, probes = equations.stiffness_share, reference.probes
    if share < 1 or equations.plate is not thin_plate:
        system = sp.csr_matrix(equations.texture_hessian + plate)
        probes = solve_all(system, probe_right_sides(mesh, observed, equations))
    squares = [probe**2 for probe in probes]
    correlation = _error_correlation(pool, painted)
    noise = _noise_energy(squares, equations, pool, noise_level, NOISE_RINGS, correlation)
    noise *= 1 - start_error_left  # photos displace a vertex as far as they correct it
    plates = PlainPlates.of(reference.surface, thin_plate)
    unseen = _unseen_relief(kriging, plates, thin_plate, equations, painted)
    probe_energy = error_factor * np.mean(np.square(reference.probes), axis=0)
    narrow, wide = (
        _extrapolated((reference.removed - reference.removed_smoothed) ** 2, unseen, painted, rings)
        - _NOISE_IN_DETAIL * _extrapolated(probe_energy, unseen, painted, rings)
        for rings in (DETAIL_RINGS, WIDE_RINGS)
    )
    detail = np.maximum(narrow, wide)  # dabs show less of it than continuous paint
    wrinkled = _wrinkled(reference, plates, equations, painted)
    lost_per_detail = _LOST_PER_DETAIL * (1 + (_WRINKLED_DETAIL - 1) * wrinkled)
    lost_per_detail *= share**_DETAIL_BY_SHARE
    variance = noise + lost_per_detail * np.maximum(detail, 0.0)
    variance += _chordal_deviation_mm(observed, pool) ** 2
    start_px2 = _start_error_variance_px2(start_error_left, equations, thin_plate)
    variance += start_px2 * observed.pixel_mm**2

    slopes2 = [_squared_slope(thin_plate, probe) for probe in probes]
    noise_slope2 = _noise_energy(slopes2, equations, pool, noise_level, WIDE_RINGS)
    slopes = _DetailSlopes.of(mesh, observed, equations, reference, pool, unseen / kriging)
    lost_slope = _LostSlope.of(equations, wrinkled)
    return LocalErrors(
        variance_mm2=variance,
        reach_mm=_CORRELATION_LENGTHS * _typical_length_mm(thin_plate, equations),
        lost_length=lost_slope.length(slopes, noise_slope2),
        lost_across=lost_slope.lost_per_detail / 4 * slopes.folds[:, None] * slopes.across,
        start_error_left=start_error_left,
        creases_mm=_capped(lost_creases_mm(mesh, observed, equations, reference), variance, pool),
    )


def _unseen_relief(
    kriging: Float64[np.ndarray, " n"],
    plates: PlainPlates,
    thin_plate: ThinPlate,
    equations: JointEquations,
    painted: Pool,
) -> Float64[np.ndarray, " n"]:
    """Variance of the limb's relief that the data do not show, over that of the typical vertex.

    A kriging variance grows with the square of the length over which nothing is observed; the
    limb's relief of that length is as high as what a plate of that length removes.
    """
    length_mm = _typical_length_mm(thin_plate, equations)
    removed = [plates.removed(factor * length_mm)[0] for factor in _GROWTH_LENGTHS]
    energies = np.array([robust_mean_square(heights[painted.counted]) for heights in removed])
    if not energies.all():  # a flat surface, or no painted vertex
        return kriging
    growth = np.log(energies / energies[_GROWTH_LENGTHS.index(1.0)])
    return np.exp(np.interp(np.log(kriging), 2 * np.log(_GROWTH_LENGTHS), growth))


def _extrapolated(
    squares: Float64[np.ndarray, " n"],
    unseen: Float64[np.ndarray, " n"],
    painted: Pool,
    rings: int,
) -> Float64[np.ndarray, " n"]:
    """Energies at nearby painted vertices, scaled with the unobserved relief."""
    return unseen * painted.energy(squares / unseen, rings)


def _capped(
    sources_mm: Float64[np.ndarray, "n k"], variance: Float64[np.ndarray, " n"], pool: Pool
) -> Float64[np.ndarray, "n k"]:
    """Sources of error, scaled down where their energy exceeds the variance around."""
    source_energy = pool.energy((sources_mm**2).sum(axis=1), DETAIL_RINGS)
    excess = np.maximum(source_energy / pool.energy(variance, DETAIL_RINGS), 1.0)
    return sources_mm / np.sqrt(excess)[:, None]


def filled_or_unsupported(
    mesh: Mesh,
    equations: JointEquations,
    guessed: Bool[np.ndarray, " n"],
    start_error_left: Float64[np.ndarray, " n"],
) -> Bool[np.ndarray, " n"]:
    """Filled vertices, guesses without texture, and unsupported vertices beside those.

    A fill that starts millimetres off bends its surroundings towards it: guesses found by patches
    that reach into it, vertices on which no two photos agree, and long faces across the step.

    Args:
        guessed: Vertices that no depth map had.
        start_error_left: As `LocalErrors` has it.
    """
    filled = ~mesh.measured
    filled = filled | (guessed & (start_error_left > _MAX_START_ERROR_LEFT))
    unsupported = guessed | (equations.photo_count < 2) | _at_long_edges(mesh)
    beside = np.zeros(len(mesh), bool)
    beside[mesh.faces[filled[mesh.faces].any(axis=1)]] = True
    return filled | (beside & unsupported)


def _at_long_edges(mesh: Mesh) -> Bool[np.ndarray, " n"]:
    """Ends of edges much longer than the median one."""
    ends = find_edges(mesh.faces).ends
    lengths = edge_lengths(mesh.vertices_mm, ends)
    at_long_edges = np.zeros(len(mesh), bool)
    at_long_edges[ends[lengths > _LONG_EDGE_RATIO * np.median(lengths)]] = True
    return at_long_edges


def _kriging_variance(
    thin_plate: ThinPlate, equations: JointEquations, pool: Pool
) -> Float64[np.ndarray, " n"]:
    """Variance of the plate's prior given the data, over that of the typical vertex.

    It is sampled: relief of white curvature, as far as the data leave it undetermined. It is small
    in paint, and grows in gaps with their width.
    """
    random = np.random.default_rng(SEED)
    # The plate is isotropic: the width of a gap does not depend on the grain round it.
    plate = bending_matrix(thin_plate, equations.stiffness)
    system = sp.csr_matrix(equations.texture_hessian + plate)
    root = np.sqrt(equations.stiffness)
    forces = [
        thin_plate.laplacian.T @ (root * random.standard_normal(len(root))) for _ in range(_DRAWS)
    ]
    variance = np.zeros(len(root))
    for sample in solve_all(system, forces):
        variance += sample**2
    # This is the variance under uniform data, so that the samples only add gaps and rims.
    information = equations.texture_hessian.diagonal()
    density = np.maximum(information / thin_plate.area_mm2, np.finfo(float).tiny)
    expected = np.exp(-pool.mean(np.log(density), _DENSITY_RINGS) / 2)
    variance = expected * pool.mean(variance / expected, _DRAW_RINGS)
    return variance / np.median(variance[pool.counted] if pool.counted.any() else variance)


def _start_error_left(plate: sp.csr_matrix, equations: JointEquations) -> Float64[np.ndarray, " n"]:
    """Share of a constant error of the given surface that remains after the rounds, 0 to 1.

    Paint corrects it, and the plate propagates that into narrow gaps.
    """
    system = sp.csr_matrix(equations.hessian + plate)
    left, diagonal = np.ones(len(equations.weights)), system.diagonal()
    for _ in range(_CORRECTING_ROUNDS):
        right = equations.other_hessian @ left
        left = solve(system, right, right / diagonal)
    return np.clip(left, 0.0, 1.0)


def _start_error_variance_px2(
    start_error_left: Float64[np.ndarray, " n"], equations: JointEquations, thin_plate: ThinPlate
) -> Float64[np.ndarray, " n"]:
    """Variance of what remains of the given surface's own errors, px^2.

    Depth maps err in the middle of wide gaps, and the plate propagates that towards the paint; over
    narrow gaps between dabs they are right.
    """
    ring = sp.csr_matrix(thin_plate.neighbours + sp.eye(len(start_error_left)))
    gap_maximum = start_error_left
    for _ in range(_GAP_RINGS):
        gap_maximum = np.maximum.reduceat(gap_maximum[ring.indices], ring.indptr[:-1])
    unconfirmed = np.where(equations.photo_count < 2, _UNCONFIRMED_PX**2, 0.0)
    return _START_ERROR_PX**2 * start_error_left * gap_maximum**2 + unconfirmed


def _noise_per_information(
    mesh: Mesh, equations: JointEquations, pool: Pool
) -> Float64[np.ndarray, " n"]:
    """Energy of the photos' right-hand sides over the information of their texture."""
    squares = np.repeat(np.sum(equations.right_by_photo.astype(np.float64) ** 2, axis=1), 3)
    noise = pool.mean(np.bincount(mesh.faces.ravel(), squares, len(mesh)))
    information = pool.mean(equations.texture_hessian.diagonal())
    # The floors give vertices with hardly any texture the ratio of the whole surface.
    return _with_floor(noise) / _with_floor(information)


def _with_floor(values: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    """Values plus a small share of the median positive one; most of a surface may have zeros."""
    positive = values[values > 0]
    return values + (_FLOOR_SHARE * np.median(positive) if len(positive) else 1.0)


def _typical_length_mm(thin_plate: ThinPlate, equations: JointEquations) -> float:
    """Length below which the plate dominates the data at the typical vertex, even a bare one."""
    density = np.median(equations.weights * equations.signal / thin_plate.area_mm2)
    stiffness = np.median(equations.stiffness / thin_plate.area_mm2)
    return max(equations.measuring_length_mm, float((stiffness / density) ** 0.25))


def _wrinkled(
    reference: ReferencePlateFit, plates: PlainPlates, equations: JointEquations, painted: Pool
) -> float:
    """How far relief stays high at short wave lengths, and so below the observed ones, 0 to 1.

    It follows from how much more relief lies in a coarser band of lengths than in a finer one
    (`_BANDS`) at painted vertices, both without the energy of noise.
    """
    rough, smooth = _BAND_RATIOS
    fine, coarse = _bands(reference, plates, equations, painted)
    if min(fine.relief, coarse.relief) <= 0 or fine.relief < _MIN_RELIEF_OVER_NOISE * fine.noise:
        return 0.0
    ratio = np.sqrt(coarse.relief / fine.relief)
    return float(np.clip((smooth - ratio) / (smooth - rough), 0.0, 1.0))


class _Band(NamedTuple):
    """Energies of one band of lengths, mm^2."""

    relief: float
    noise: float


def _bands(
    reference: ReferencePlateFit, plates: PlainPlates, equations: JointEquations, painted: Pool
) -> list[_Band]:
    """Energies in the two bands of lengths at painted vertices."""
    error_factor = error_over_disagreement(equations.photo_count)[painted.counted]
    found: list[_Band] = []
    for band in _BANDS:
        removed: list[Float64[np.ndarray, "k n"]] = []
        for factor in band:
            heights = plates.removed(factor * equations.length_mm, reference.probes)
            removed.append(np.array(heights)[:, painted.counted])
        total, *noises = removed[1] - removed[0]
        noise = sum(robust_mean_square(np.sqrt(error_factor) * each) for each in noises) / PROBES
        found.append(_Band(robust_mean_square(total) - noise, noise))
    return found


@dataclass(frozen=True, kw_only=True)
class _DetailSlopes:
    """Squared slopes of (1 - H) H x, the detail that the reference plate removes."""

    relief: Float64[np.ndarray, " n"]
    """Of the limb's relief."""
    folds: Float64[np.ndarray, " n"]
    """Excess of the relief's slope across folds over that along them."""
    noise: Float64[np.ndarray, " n"]
    """Of the noise in the detail."""
    across: Float64[np.ndarray, "n 3"]
    """Unit tangent across the folds."""

    @classmethod
    def of(
        cls,
        mesh: Mesh,
        observed: ObservedSurface,
        equations: JointEquations,
        reference: ReferencePlateFit,
        pool: Pool,
        unseen: Float64[np.ndarray, " n"],
    ) -> "_DetailSlopes":
        """Those of painted vertices, extrapolated in proportion to `unseen`."""
        thin_plate = observed.thin_plate
        painted = pool.restricted_to(equations.signal > MIN_PAINTED_SIGNAL)
        error_factor = error_over_disagreement(equations.photo_count)
        of_probes = [
            _squared_slope(thin_plate, probe - smoothed)
            for probe, smoothed in zip(reference.probes, reference.smoothed_probes, strict=True)
        ]
        noise = error_factor * np.mean(of_probes, axis=0)
        noise = _extrapolated(noise, unseen, painted, WIDE_RINGS)
        total = _squared_slope(thin_plate, reference.removed)
        total = _extrapolated(total, unseen, painted, WIDE_RINGS)
        relief = np.maximum(total - noise, 0.0)
        across, anisotropy = _anisotropy(mesh, reference.removed, observed, pool)
        folds = np.clip((anisotropy - _ISOTROPIC_EXCESS) * total, 0.0, relief)
        return cls(relief=relief, folds=folds, noise=noise, across=across)


@dataclass(frozen=True)
class _LostSlope:
    """How much the squared slope that the plate removed changes the length of a line."""

    lost_per_detail: float
    """Squared slope that the plate removed over that of (1 - H) H x of the reference plate."""
    noise_kept: float
    """Share of the squared slope of the surface's noise that a smoothed line keeps."""

    @classmethod
    def of(cls, equations: JointEquations, wrinkled: float) -> "_LostSlope":
        """The factors of the equations' plate; `wrinkled` as `_wrinkled` returns it."""
        length_mm = equations.length_mm
        more = 1 + (_WRINKLED_SLOPE + _WRINKLED_SLOPE_PER_MM * length_mm - 1) * wrinkled
        lost_per_detail = more * max(_LOST_SLOPE + _LOST_SLOPE_PER_MM * length_mm, 0.0)
        return cls(
            lost_per_detail * equations.stiffness_share**_SLOPE_BY_SHARE,
            1 / (1 + (FILTER_LENGTH_MM / equations.measuring_length_mm) ** _NOISE_SLOPE_EXPONENT),
        )

    def length(
        self, detail: _DetailSlopes, noise_slope2: Float64[np.ndarray, " n"]
    ) -> Float64[np.ndarray, "n 2"]:
        """How much longer a line along the limb is, and the standard deviation of that, per length.

        Both lines are smoothed (`core/geometry/smoothed_length`); flat faces are finer and add
        nothing. Relief of slope s lengthens a line by s^2 / 4 in the mean of all directions.

        Args:
            detail: Squared slopes of what the reference plate removes.
            noise_slope2: Squared slope of the noise on the surface.
        """
        lost = self.lost_per_detail / 4 * detail.relief
        added = self.noise_kept / 4 * noise_slope2
        variance = (
            (_LOST_SLOPE_SIGMA * lost) ** 2
            + (_FOLDED_SIGMA * self.lost_per_detail / 4 * detail.folds) ** 2
            + (_NOISE_SLOPE_SIGMA * self.lost_per_detail / 4 * detail.noise) ** 2
            + (_NOISE_SLOPE_SIGMA * added) ** 2
        )
        return np.column_stack([lost - added, np.sqrt(variance)])


def _anisotropy(
    mesh: Mesh, lift: Float64[np.ndarray, " n"], observed: ObservedSurface, pool: Pool
) -> tuple[Float64[np.ndarray, "n 3"], Float64[np.ndarray, " n"]]:
    """Unit tangent of the steepest direction, and the anisotropy of the squared slope.

    It is 0 for isotropic relief and 1 for parallel folds; noise, being isotropic, lowers it.
    """
    tensors = pooled_structure_tensors(mesh, structure_tensors(mesh, lift), pool, WIDE_RINGS)
    tangents = observed.axes[:, :2]
    squares, directions = np.linalg.eigh(np.einsum("nai,nij,nbj->nab", tangents, tensors, tangents))
    total = np.maximum(squares.sum(1), np.finfo(float).tiny)
    across = np.einsum("na,nai->ni", directions[:, :, 1], tangents)
    return across, np.clip((squares[:, 1] - squares[:, 0]) / total, 0.0, 1.0)


def _squared_slope(
    thin_plate: ThinPlate, lift: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, " n"]:
    """Squared gradient of `lift`: |grad f|^2 = (laplace(f^2) - 2 f laplace(f)) / 2."""
    return thin_plate.laplacian @ lift**2 / 2 - lift * (thin_plate.laplacian @ lift)


def _noise_energy(
    energies: list[Float64[np.ndarray, " n"]],
    equations: JointEquations,
    pool: Pool,
    noise_level: Float64[np.ndarray, " n"],
    rings: int,
    correlation: float | Float64[np.ndarray, " n"] = ERROR_CORRELATION,
) -> Float64[np.ndarray, " n"]:
    """Energy of the photos' errors, correlated ones included."""
    error_factor = error_over_disagreement(equations.photo_count, correlation)
    return (
        error_factor
        * noise_level
        * pool.energy(np.sum(energies, axis=0) / (PROBES * noise_level), rings)
    )


def _error_correlation(pool: Pool, painted: Pool) -> Float64[np.ndarray, " n"]:
    """Effective correlation of the photos' errors: the less is painted around, the larger."""
    around = np.maximum(pool.counted_shares[WIDE_RINGS], np.finfo(float).tiny)
    bare = 1 - np.clip(painted.counted_shares[WIDE_RINGS] / around, 0.0, 1.0)
    return ERROR_CORRELATION + (DAB_ERROR_CORRELATION - ERROR_CORRELATION) * bare


def _chordal_deviation_mm(observed: ObservedSurface, pool: Pool) -> Float64[np.ndarray, " n"]:
    """Height of the surface over the middle of an edge: edge^2 / 8 R.

    On a mesh as coarse as its relief it is most of the error of single vertices; what measures of
    the faces have of it is a separate source (`FACES`).
    """
    edge2 = observed.thin_plate.area_mm2 * 2 / np.sqrt(3)
    return edge2 / 8 * np.abs(pool.mean((observed.quadric[:, 0] + observed.quadric[:, 2]) / 2))


_CAMERA_MODES, _WEAKER_MODES = 6, 5
"""Camera modes kept as shared sources, and the next ones, which are added to the local part."""
_SAMPLED_VERTICES = 2000
"""Vertices from which the strongest modes are computed."""
_MIN_SPREAD = 1e-4
"""Mean square of t_k - t below which photos look along nearly one ray and do not measure."""


@dataclass(frozen=True, kw_only=True)
class SharedErrors:
    """Errors along the normal, by vertex, that all vertices share."""

    modes_mm: Float64[np.ndarray, "n k"]
    """The scale first, then the cameras' strongest modes."""
    rest_mm2: Float64[np.ndarray, " n"]
    """Variance of the cameras' other modes."""


def shared_errors(
    mesh: Mesh,
    axes: Float64[np.ndarray, "n 3 3"],
    seen_by: Int32[np.ndarray, "n c"],
    measured: Bool[np.ndarray, " n"],
    metric: MetricScene,
) -> SharedErrors:
    """Errors of scale and cameras on the surface."""
    sampled = np.flatnonzero(measured)
    sampled = sampled[:: max(1, len(sampled) // _SAMPLED_VERTICES)]
    vertices, normals = mesh.vertices_mm, axes[:, 2]
    from_centre = vertices - (vertices[sampled] if len(sampled) else vertices).mean(0)
    growth = np.einsum("ni,ni->n", from_centre, normals)
    rigid_moves = np.hstack([normals, np.cross(from_centre, normals)])
    scale = np.nan_to_num(metric.scale.relative_sigma) * growth[:, None]
    scale -= rigid_moves @ _rigid_fit(rigid_moves[sampled], scale[sampled])
    covariance = metric.scene.camera_covariance
    if covariance is None or not len(sampled):
        return SharedErrors(modes_mm=scale, rest_mm2=np.zeros(len(mesh)))

    root = _covariance_root(covariance)
    by_cameras = metric.scale.by_cameras
    if by_cameras is None:  # no length that these cameras measured sets the scale
        rigid_moves = np.hstack([rigid_moves, growth[:, None]])
        by_cameras = np.zeros(len(root))
    sampled_moves = _displacements(
        vertices[sampled], axes[sampled], seen_by[sampled], metric.scene, root
    )
    sampled_moves += np.outer(growth[sampled], by_cameras @ root)
    fit = _rigid_fit(rigid_moves[sampled], sampled_moves)
    sampled_moves -= rigid_moves[sampled] @ fit
    values, vectors = np.linalg.eigh(sampled_moves.T @ sampled_moves)
    strongest = vectors[:, np.argsort(-values)[: _CAMERA_MODES + _WEAKER_MODES]]
    modes = _displacements(vertices, axes, seen_by, metric.scene, root @ strongest)
    modes += np.outer(growth, by_cameras @ root @ strongest) - rigid_moves @ (fit @ strongest)
    return SharedErrors(
        modes_mm=np.hstack([scale, modes[:, :_CAMERA_MODES]]),
        rest_mm2=(modes[:, _CAMERA_MODES:] ** 2).sum(1),
    )


def _rigid_fit(
    rigid_moves: Float64[np.ndarray, "m g"], moves: Float64[np.ndarray, "m r"]
) -> Float64[np.ndarray, "g r"]:
    """Least-squares coefficients of the rigid motions that reproduce these moves."""
    return np.linalg.lstsq(rigid_moves, moves, rcond=None)[0]


def _covariance_root(covariance: Float64[np.ndarray, "u u"]) -> Float64[np.ndarray, "u r"]:
    """A square root of the covariance: columns whose outer products add up to it."""
    sigma = np.sqrt(np.diag(covariance))
    scale = np.where(sigma > 0, sigma, 1.0)
    values, vectors = np.linalg.eigh(covariance / np.outer(scale, scale))
    kept = values > 1e-12 * values[-1]
    return scale[:, None] * vectors[:, kept] * np.sqrt(values[kept])


def _displacements(
    vertices: Points3,
    axes: Float64[np.ndarray, "n 3 3"],
    seen_by: Int32[np.ndarray, "n c"],
    scene: Scene,
    root: Float64[np.ndarray, "u r"],
) -> Float64[np.ndarray, "n r"]:
    """Moves along the normal for each column of camera parameters."""
    moves = np.zeros((len(vertices), root.shape[1]))
    _displace(
        np.ascontiguousarray(vertices),
        np.ascontiguousarray(axes),
        np.ascontiguousarray(seen_by),
        np.stack([scene.view(photo).packed for photo in scene.placed]),
        np.array(scene.lens_idx),
        np.ascontiguousarray(root),
        moves,
    )
    return moves


@njit(cache=True, nogil=True)
def _displace(
    vertices: np.ndarray,
    axes: np.ndarray,
    seen_by: np.ndarray,
    views: np.ndarray,
    camera_of: np.ndarray,
    root: np.ndarray,
    moves: np.ndarray,
):
    """Fill `moves`, zeros at first, at vertices whose photos see them from different directions."""
    columns, lenses = root.shape[1], POSE_SIZE * len(views)
    xy, by_point = np.empty(2), np.empty((2, 3))
    by_pose, by_lens = np.empty((2, POSE_SIZE)), np.empty((2, LENS_SIZE))
    frame, plane, t, sum_t = np.empty((2, 3)), np.empty((2, 2)), np.empty(2), np.empty(2)
    pixels, sum_s, sum_ts = np.empty((2, columns)), np.empty((2, columns)), np.empty(columns)
    for n in range(len(vertices)):
        count, sum_tt = 0, 0.0
        sum_t[:], sum_s[:], sum_ts[:] = 0.0, 0.0, 0.0
        for k in seen_by[n]:
            if k < 0:
                continue
            project_and_differentiate(views[k], vertices[n], xy, by_point, by_pose, by_lens)
            first = lenses + LENS_SIZE * camera_of[k]
            for a in range(2):
                for axis in range(3):
                    frame[a, axis] = 0.0
                    for j in range(3):
                        frame[a, axis] += by_point[a, j] * axes[n, axis, j]
                pixels[a] = 0.0
                for j in range(POSE_SIZE):
                    for r in range(columns):
                        pixels[a, r] += by_pose[a, j] * root[POSE_SIZE * k + j, r]
                for j in range(LENS_SIZE):
                    for r in range(columns):
                        pixels[a, r] += by_lens[a, j] * root[first + j, r]
            determinant = frame[0, 0] * frame[1, 1] - frame[0, 1] * frame[1, 0]
            plane[0, 0], plane[0, 1] = frame[1, 1] / determinant, -frame[0, 1] / determinant
            plane[1, 0], plane[1, 1] = -frame[1, 0] / determinant, frame[0, 0] / determinant
            for a in range(2):
                t[a] = plane[a, 0] * frame[0, 2] + plane[a, 1] * frame[1, 2]
                sum_t[a] += t[a]
                sum_tt += t[a] * t[a]
                for r in range(columns):
                    s = plane[a, 0] * pixels[0, r] + plane[a, 1] * pixels[1, r]
                    sum_s[a, r] += s
                    sum_ts[r] += t[a] * s
            count += 1
        if count == 0:
            continue
        spread = sum_tt - (sum_t[0] * sum_t[0] + sum_t[1] * sum_t[1]) / count
        if spread > _MIN_SPREAD * count:
            for r in range(columns):
                error_factor = (sum_t[0] * sum_s[0, r] + sum_t[1] * sum_s[1, r]) / count
                moves[n, r] = (error_factor - sum_ts[r]) / spread


SCALE, CAMERAS, OFFSET = "scale", "cameras and lens", "offset of the whole surface"
FACES, GAPS, CREASES = "flat faces", "gaps between paint", "lost depth of creases"
"""Names of the shared sources, as `Mesh.shared_sources` has them."""
_FACES_LEFT = 0.2
"""Standard deviation of the offset of flat faces as a whole, in chordal deviations. On a ball it is
0.05 to 0.07 for edges of 4 to 8 pixels, -0.25 to -0.30 for edges of 15."""
_SUNK_PX = 0.13
"""Standard deviation of the common offset in all gaps between paint, in pixels, where an error of
the given surface remains whole: depth maps span gaps as chords do. Errors per remaining share:
-0.20 to -0.07 px on seven sparse and bare captures, -0.18 to 0.10 on four others."""
OFFSET_PX = 0.006
"""Standard deviation of the whole surface's offset from the sampling of photos, in pixels: volumes
of 53 small captures (seeds 6000 to 7088) give -0.007 px for thighs, -0.003 for shanks and 0.003 for
bulbous limbs, and unknown blur adds 0.002. Errors of 139 volumes (seeds 9000 to 11099) were 0.92 of
what 0.005 states; of 30 made by later code (seeds 32100 to 35007) 1.2 of what 0.0045 states."""


def with_sigma(
    mesh: Mesh,
    observed: ObservedSurface,
    equations: JointEquations,
    reference: ReferencePlateFit,
    metric: MetricScene,
    guessed: Bool[np.ndarray, " n"],
) -> Mesh:
    """The mesh with its sigmas; NaN at filled vertices.

    Args:
        guessed: Vertices that no depth map had. Patches correlate by chance on bare skin too, so
            such a vertex counts as filled unless it is textured.
    """
    local = local_errors(mesh, observed, equations, reference)
    filled = filled_or_unsupported(mesh, equations, guessed, local.start_error_left)
    measured = ~filled & (equations.photo_count > 1)
    shared = shared_errors(mesh, observed.axes, observed.seen_by, measured, metric)
    offset_mm = OFFSET_PX * observed.pixel_mm
    faces_mm = _FACES_LEFT * mesh.chordal_deviations_mm()
    gaps_mm = _SUNK_PX * local.start_error_left * observed.pixel_mm
    beside_mm = np.column_stack([shared.modes_mm, offset_mm, faces_mm])
    within_mm = np.column_stack([gaps_mm, local.creases_mm])  # these are part of the local variance
    cameras, creases = shared.modes_mm.shape[1] - 1, local.creases_mm.shape[1]
    variance = local.variance_mm2 + shared.rest_mm2 + (beside_mm**2).sum(1)
    return replace(
        mesh,
        filled=filled,
        sigma_mm=np.where(filled, np.nan, np.sqrt(variance)).astype(np.float32),
        shared_mm=np.column_stack([beside_mm, within_mm]).astype(np.float32),
        shared_sources=(SCALE, *cameras * (CAMERAS,), OFFSET, FACES, GAPS, *creases * (CREASES,)),
        correlation_mm=local.reach_mm,
        lost_length=local.lost_length.astype(np.float32),
        lost_across=local.lost_across.astype(np.float32),
    )
