"""Sigma: one standard deviation along the normal for every measured vertex.

In      the measured mesh, the normal equations of its last round, which photos measured what, and
        the metric scene with the covariance of its cameras.
Out     the mesh with its sigmas: local errors of each vertex (variance, the distance over which
        they are alike, and how much longer a line along the limb is than along the measured
        surface), and errors that all vertices share (displacement by one standard deviation of each
        source). It speaks of the shape: where the surface lies in the world is not part of it.
Method  Noise: what single photos pull the surface by, each solved through the thin plate, is how
        they disagree (a sandwich with the photos as clusters: Liang and Zeger 1986); it holds
        sensor noise, shading, pose errors and gaps alike. What holds the surface against the pulls
        is texture that the photos share, and not the slopes of their noise (`signal_share`).
        Detail: the plate takes (1 - H) off the surface x, H being its response. What it would take
        off again and again, (1 - H)^2 H x, is seen where there is paint, and for relief whose power
        falls like the wave number's fifth to seventh power the lost part has about a constant
        multiple of its energy. Elsewhere it is as much more as relief can stand off the plate
        unseen: drawn from the plate's energy less what is held (kriging's variance), which grows
        like the square of the length that is not seen, while the limb's own grows as paint shows
        it to. Energies are pooled over neighbours. Of folds detail is alike all along them
        (`creases`).
        Lines: relief of slope s makes a line longer by s^2 / 4 of itself, whatever its direction;
        what is lost follows from the slope of (1 - H) x, what noise adds from the slope of the
        photos' disagreement.
        Shared: a photo moved by p sees another point of the tangent plane, s_k p away; the surface
        moves by -sum (t_k - t)'(s_k - s) / sum |t_k - t|^2 to make the photos agree again, t_k
        being how far along the plane photo k moves for a millimetre along the normal, t and s
        their means (texture alike in all directions). The scale is set anew from the board in each
        case, and what only moves the surface as a whole is taken off: a shape has no place.
        Faces: photos are sampled all over the flat faces, which therefore lie in the limb as
        deep as their vertices stand out of it; a fifth of the chordal deviation is left.
        Gaps: depth maps span what lies between paint as chords do, in all gaps alike, and the
        rounds take back about a half.
        docs/method.
"""

from dataclasses import dataclass, replace
from typing import NamedTuple

import numpy as np
import scipy.sparse as sp
from jaxtyping import Bool, Float64, Int32

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.lens import LENS_SIZE, POSE_SIZE, project_and_differentiate
from limbgram.core.geometry.smoothed_length import PLATE_MM
from limbgram.core.kernels import njit
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import edge_lengths, find_edges
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.measuring.creases import lost_creases_mm
from limbgram.reconstruction.measuring.disagreement import (
    DETAIL_RINGS,
    NOISE_RINGS,
    PAINTED,
    PROBES,
    SEED,
    WIDE_RINGS,
    Pool,
    pulls_of,
    times_unseen,
    usual_square,
)
from limbgram.reconstruction.measuring.grain import pooled_products, products_of_slopes
from limbgram.reconstruction.measuring.measurement_pass import JointEquations, SeenSurface
from limbgram.reconstruction.measuring.thin_plate import (
    ThinPlate,
    bending_of,
    curvature_of,
    solve,
    solve_all,
    stiffness_of,
)
from limbgram.reconstruction.measuring.usual_plate import ByUsualPlate
from limbgram.reconstruction.scale.metric import MetricScene

_LOST_PER_SEEN = 12.0
"""Energy of the detail that the plate took over that of (1 - H)^2 H x. Theory says 30 for endless
relief, less where the mesh or the relief ends; seven captures of our own asked for 7 to 14."""
_LENGTHS = (0.35, 0.7, 1.0, 1.4, 2.0, 4.0)
"""Lengths, in those below which the plate rules at the usual vertex, at which the growth of relief
is measured."""
_DETAIL_BY_SHARE, _SLOPE_BY_SHARE = 0.5, 0.25
"""A plate of so much less stiffness loses so much less: powers of its share of the usual stiffness.
Theory, plates of 2 mm on edges of 3 mm, shares of 0.6, 0.4 and 0.2: 0.69, 0.49, 0.24 of the energy
and 0.89, 0.81, 0.65 of the slope along a smoothed line where relief ends at 5 mm; 0.77, 0.61, 0.40
and 0.90, 0.82, 0.68 at 2.5 mm; 0.83, 0.70, 0.50 and 0.94, 0.89, 0.78 over wrinkles. These powers:
0.77, 0.63, 0.45 and 0.88, 0.80, 0.67."""
_NOISE_IN_SEEN = 0.055
"""Energy that white noise leaves in (1 - H)^2 H x, over that of its error: B(4.5, 1.5) / B(.5, 1.5)
(its spectrum through the plate)."""
_LOST_SLOPE, _LOST_SLOPE_PER_MM = -6.0, 17.0
"""Squared slope that the plate took from the relief ((1 - H^2) of it), as far as a line keeps it at
the smoothing length, over that of (1 - H) H x: so much, and so much for each millimetre of the
plate's length, none below nothing. Skin and cloth end at some wave length of their own, which
hardly matters to a smoothed line: for 0.8, 1.8 and 2.25 mm theory says 9, 23 and 31 times what is
seen of relief that ends at 5 mm, 7, 29 and 38 if at 2.5 mm, 8, 30 and 39 if nowhere (14, 30, 39;
26, 63, 77; and 70 to 160 without smoothing, where captures of relief that ends at 5 mm had 12 to 15
at 0.8 mm and 23 to 40 at 1.7 to 2.2 mm)."""
_LOST_SLOPE_SIGMA, _FOLDED_SIGMA = 0.25, 0.3
"""Standard deviation of the factor, and of what of it lies across folds, as a fraction."""
_ALL_WAYS = 0.15
"""Waves of all ways show so much more of their squared slope one way, by chance and because photos
from round a limb see its relief less well round it than along it. With it contours round creased
skin err by 0.09 mm, without by 0.13 mm, and by 0.14 mm if folds count as waves of all ways."""
_NOISE_KEPT = 2.7
"""The plate's noise keeps 1 / (1 + (smoothing plate / plate)^this) of its squared slope along a
smoothed line: 0.50, 0.75, 0.90, 0.94 for 0.8 to 2.25 mm, where theory (white data noise through
the plate) says 0.47, 0.72, 0.89 and 0.94."""
_BANDS = (0.67, 1.0), (1.5, 2.25)
"""Two bands of wave lengths, in lengths of the plate, whose heights tell how relief grows with its
length. Neighbouring bands tell it less well: each holds only a few waves of a limb."""
_BAND_RATIOS = 2.40, 2.65
"""Height of the relief in the coarser band over that in the finer one: at the first, relief is
about as high at all lengths; from the second on, the factors above hold. Theory: 2.14 for relief of
one height at all lengths, 2.43 for relief that grows with the power 0.2 of its length, 3.2 for 0.7.
Eleven of thirteen wrinkled captures have 2.04 to 2.39, eighteen usual ones 2.73 to 3.28,
limb_ring15 2.90, foot_ring24 2.77, limb_sparse15 3.17."""
_LEAST_RELIEF = 1.0
"""Energy of relief over that of noise in the finer band, from which the two bands tell of it."""
_WRINKLED_SLOPE, _WRINKLED_SLOPE_PER_MM, _WRINKLED_DETAIL = 0.5, 0.43, 2.0
"""How much more slope is lost there: so much, and so much for each millimetre of the plate's length
(captures ask for 1.4 at 2.1 mm, and theory for less than one below 1 mm, where most of it is finer
than the smoothing length); and how much more energy, by theory."""
_NOISE_SLOPE_SIGMA = 0.17
"""Standard deviation, as a fraction, of the squared slope of the noise: what photos get wrong alike
is steeper or less so than what they get wrong apart. This and the two above make the errors of 120
contours (`intervals.py`, 24 captures in five settings) the most likely; folds told too little of
themselves there, so that 0.3 is a bound."""
_DRAWS = 4
"""Of relief that stands off the plate unseen."""
_LEAST_SEEN = 0.01
"""Of the usual vertex's pull and hold, what every vertex has at least."""
_SMOOTH_RINGS, _EVEN_RINGS = 3, 8
"""Rings over which the hold of the data is averaged (its logarithm) for what a plate would leave of
relief, and rings over which the draws correct that: four draws alone scatter by a third."""
_GIVEN_PX, _ROUNDS, _GAP_RINGS = 0.3, 2, 6
"""What is wrong with the surface that the joint rounds start from in the middle of a wide gap, in
pixels; how many rounds count that take from it what the photos do not agree to, as further ones
take less than they say; and rings within which the gap's deepest place is looked for. Of 0 to
0.45 px, 0.25 to 0.3 makes the errors of ten captures with little paint the most likely."""
_ALONE_PX = 0.12
"""What is more wrong, in pixels, where fewer than two photos agree on what they show."""
_PUSHED_PX = 0.35
"""No noise pushes the surface further, in pixels, where nothing holds it but belief."""
_MOST_LEFT = 0.5
"""A guessed place of which more than this is left is still a guess: in eight captures with half of
the paint left out, errors of guesses were 0.5 px below this and up to 4.9 mm above it."""
_LONG_EDGE = 1.5
"""From how many times the usual edge one counts as a bridge. Where such a bridge, a guess or a
place on which no two photos agree touches a fill, two patchy captures were up to 9 mm off with
sigmas of 0.3 mm; without them the rest has an RMS of 0.16 mm (0.31) and of 0.20 (0.23)."""
_CORRELATION_LENGTHS = 2.26
"""Reach of the errors in lengths of the plate: pi reach^2 is the area 16 length^2 of its noise."""


@dataclass(frozen=True, kw_only=True)
class LocalErrors:
    """What each vertex has for itself and its neighbours."""

    variance_mm2: Float64[np.ndarray, " n"]
    reach_mm: float
    """Errors of two vertices d apart are alike by exp(-(d / reach)^2)."""
    lost_length: Float64[np.ndarray, "n 2"]
    """As `Mesh.lost_length` has it."""
    lost_across: Float64[np.ndarray, "n 3"]
    """As `Mesh.lost_across` has it."""
    left: Float64[np.ndarray, " n"]
    """What the rounds leave of an error of the given surface, 0 to 1."""
    creases_mm: Float64[np.ndarray, "n 2"]
    """What creases lost, alike all along them, a part of the variance: two sources of error, a
    quarter of a wave apart."""


def local_errors(
    mesh: Mesh, seen: SeenSurface, equations: JointEquations, usual: ByUsualPlate
) -> LocalErrors:
    """Variances along the normal of what the photos measured.

    Args:
        equations: With the plate that measured the mesh.
        usual: What the usual plate made of the same equations.
    """
    thin_plate = seen.thin_plate
    bending = bending_of(equations.plate, equations.stiffness)
    plate = sp.csr_matrix(bending @ equations.plate.laplacian)
    system = sp.csr_matrix(equations.held + plate)
    pool = Pool.of(thin_plate, equations.photos)
    painted, alone = pool.among(equations.signal > PAINTED), times_unseen(equations.photos)
    free = _free(thin_plate, equations, pool)
    loud = free * _loudness(mesh, equations, pool)

    left = _left(plate, equations)
    share, probes = equations.stiffness_share, usual.probes
    if share < 1 or equations.plate is not thin_plate:
        probes = solve_all(system, pulls_of(mesh, seen, equations))
    squares = [probe**2 for probe in probes]
    noise = _noise(squares, equations, pool, loud, NOISE_RINGS)
    noise /= 1 + left * noise / (_PUSHED_PX * seen.pixel_mm) ** 2
    unseen = _unseen(free, usual, thin_plate, equations, painted)
    in_seen = alone * np.mean(np.square(usual.probes), axis=0)
    near, wide = (
        _as_in_paint((usual.taken - usual.again) ** 2, unseen, painted, rings)
        - _NOISE_IN_SEEN * _as_in_paint(in_seen, unseen, painted, rings)
        for rings in (DETAIL_RINGS, WIDE_RINGS)
    )
    detail = np.maximum(near, wide)  # dabs show less of it than even paint
    wrinkled = _wrinkled(usual, thin_plate, equations, painted)
    per_seen = _LOST_PER_SEEN * (1 + (_WRINKLED_DETAIL - 1) * wrinkled) * share**_DETAIL_BY_SHARE
    variance = noise + per_seen * np.maximum(detail, 0.0)
    variance += _chord(seen, pool) ** 2
    variance += _given(left, equations, thin_plate) * seen.pixel_mm**2

    steep = [_squared_slope(thin_plate, probe) for probe in probes]
    roughened = _noise(steep, equations, pool, loud, WIDE_RINGS)
    steep = [
        _squared_slope(thin_plate, probe - held)
        for probe, held in zip(usual.probes, usual.kept, strict=True)
    ]
    in_taken = _as_in_paint(alone * np.mean(steep, axis=0), unseen / free, painted, WIDE_RINGS)
    steepness = _squared_slope(thin_plate, usual.taken)
    steepness = _as_in_paint(steepness, unseen / free, painted, WIDE_RINGS)
    relief = np.maximum(steepness - in_taken, 0.0)
    across, more_one_way = _one_way(mesh, usual.taken, seen, pool)
    folded = np.clip((more_one_way - _ALL_WAYS) * steepness, 0.0, relief)
    slope = _LostSlope.of(equations, wrinkled)
    return LocalErrors(
        variance_mm2=variance,
        reach_mm=_CORRELATION_LENGTHS * _usual_length_mm(thin_plate, equations),
        lost_length=slope.length(relief, folded, in_taken, roughened),
        lost_across=slope.times / 4 * folded[:, None] * across,
        left=left,
        creases_mm=_within(lost_creases_mm(mesh, seen, equations, usual), variance, pool),
    )


def _unseen(
    free: Float64[np.ndarray, " n"],
    usual: ByUsualPlate,
    thin_plate: ThinPlate,
    equations: JointEquations,
    painted: Pool,
) -> Float64[np.ndarray, " n"]:
    """How far the limb's relief stands off the plate unseen, squared, over the usual vertex's.

    Where the plate's own has `free`, what is not seen is as long as its root: so much relief as a
    plate of that length takes off what was measured.
    """
    length_mm, told = _usual_length_mm(thin_plate, equations), painted.counted
    taken = [_taken_by(times * length_mm, usual, thin_plate, [])[0] for times in _LENGTHS]
    heights = np.array([usual_square(each[told]) for each in taken])
    if not heights.all():  # flat, or no vertex to tell
        return free
    growth = np.log(heights / heights[_LENGTHS.index(1.0)])
    return np.exp(np.interp(np.log(free), 2 * np.log(_LENGTHS), growth))


def _as_in_paint(
    squares: Float64[np.ndarray, " n"],
    unseen: Float64[np.ndarray, " n"],
    painted: Pool,
    rings: int,
) -> Float64[np.ndarray, " n"]:
    """Energies as paint near by shows them, enlarged by as much more as is left unseen."""
    return unseen * painted.energy(squares / unseen, rings)


def _within(
    sources_mm: Float64[np.ndarray, "n k"], variance: Float64[np.ndarray, " n"], pool: Pool
) -> Float64[np.ndarray, "n k"]:
    """Sources of error, less high where the whole variance near by does not hold them all."""
    theirs = pool.energy((sources_mm**2).sum(axis=1), DETAIL_RINGS)
    over = np.maximum(theirs / pool.energy(variance, DETAIL_RINGS), 1.0)
    return sources_mm / np.sqrt(over)[:, None]


def all_filled(
    mesh: Mesh,
    equations: JointEquations,
    guessed: Bool[np.ndarray, " n"],
    left: Float64[np.ndarray, " n"],
) -> Bool[np.ndarray, " n"]:
    """What was filled, guesses that no texture holds, and what beside those is held as badly.

    A fill that starts millimetres off bends its sides towards it: guesses found by patches that
    reach into it, vertices on which no two photos agree, and long faces that bridge the step.

    Args:
        guessed: Vertices that no depth map had.
        left: Of an error of the given surface, as `LocalErrors` has it.
    """
    filled = np.zeros(len(mesh), bool) if mesh.filled is None else mesh.filled
    filled = filled | (guessed & (left > _MOST_LEFT))
    weak = guessed | (equations.photos < 2) | _bridging(mesh)
    beside = np.zeros(len(mesh), bool)
    beside[mesh.faces[filled[mesh.faces].any(axis=1)]] = True
    return filled | (beside & weak)


def _bridging(mesh: Mesh) -> Bool[np.ndarray, " n"]:
    """Ends of edges much longer than the usual one."""
    ends = find_edges(mesh.faces).ends
    long = edge_lengths(mesh.vertices_mm, ends)
    bridging = np.zeros(len(mesh), bool)
    bridging[ends[long > _LONG_EDGE * np.median(long)]] = True
    return bridging


def _free(
    thin_plate: ThinPlate, equations: JointEquations, pool: Pool
) -> Float64[np.ndarray, " n"]:
    """How far relief can stand off the plate unseen, squared, over the usual vertex's.

    Drawn: relief whose curvature is white, as the plate has it, and what of it the data leave. It
    is what kriging says: small in paint, larger in gaps, and more so the wider they are.
    """
    random = np.random.default_rng(SEED)
    # of relief that runs all ways: how wide a gap is has nothing to do with the grain round it
    plate = bending_of(thin_plate, equations.stiffness) @ thin_plate.laplacian
    system = sp.csr_matrix(equations.held + plate)
    root = np.sqrt(equations.stiffness)
    forces = [
        thin_plate.laplacian.T @ (root * random.standard_normal(len(root))) for _ in range(_DRAWS)
    ]
    left = np.zeros(len(root))
    for drawn in solve_all(system, forces):
        left += drawn**2
    # what a plate leaves where data hold it evenly, so that the draws only tell of gaps and rims
    density = np.maximum(equations.held.diagonal() / thin_plate.area_mm2, np.finfo(float).tiny)
    even = np.exp(-pool.mean(np.log(density), _SMOOTH_RINGS) / 2)
    left = even * pool.mean(left / even, _EVEN_RINGS)
    return left / np.median(left[pool.counted] if pool.counted.any() else left)


def _left(plate: sp.csr_matrix, equations: JointEquations) -> Float64[np.ndarray, " n"]:
    """What the rounds leave of an error of the given surface that is the same everywhere, 0 to 1.

    Paint takes it away, and the plate carries that into narrow gaps.
    """
    system = sp.csr_matrix(equations.soft + plate)
    left, diagonal = np.ones(len(equations.weights)), system.diagonal()
    for _ in range(_ROUNDS):
        right = equations.unheld @ left
        left = solve(system, right, right / diagonal)
    return np.clip(left, 0.0, 1.0)


def _given(
    left: Float64[np.ndarray, " n"], equations: JointEquations, thin_plate: ThinPlate
) -> Float64[np.ndarray, " n"]:
    """Variance of what is left of the given surface's own errors, px^2.

    Depth maps go wrong in the middle of wide gaps, and the plate carries that towards the paint;
    over a gap with dabs round it they are right.
    """
    ring = sp.csr_matrix(thin_plate.neighbours + sp.eye(len(left)))
    deepest = left
    for _ in range(_GAP_RINGS):
        deepest = np.maximum.reduceat(deepest[ring.indices], ring.indptr[:-1])
    alone = np.where(equations.photos < 2, _ALONE_PX**2, 0.0)
    return _GIVEN_PX**2 * left * deepest**2 + alone


def _loudness(mesh: Mesh, equations: JointEquations, pool: Pool) -> Float64[np.ndarray, " n"]:
    """Energy of the photos' pulls over what holds the surface against them."""
    pulls = np.repeat(np.sum(equations.pull.astype(np.float64) ** 2, axis=1), 3)
    loud = pool.mean(np.bincount(mesh.faces.ravel(), pulls, len(mesh)))
    held = pool.mean(equations.held.diagonal())
    # where next to nothing is seen, the ratio is that of the whole surface
    return _with_least(loud) / _with_least(held)


def _with_least(values: Float64[np.ndarray, " n"]) -> Float64[np.ndarray, " n"]:
    """A little of the usual one more; most of a surface may have none at all."""
    some = values[values > 0]
    return values + (_LEAST_SEEN * np.median(some) if len(some) else 1.0)


def _usual_length_mm(thin_plate: ThinPlate, equations: JointEquations) -> float:
    """Below what length the plate rules at the usual vertex, which may be a bare one."""
    usual = np.median(equations.weights * equations.signal / thin_plate.area_mm2)
    stiff = np.median(equations.stiffness / thin_plate.area_mm2)
    return max(equations.measuring_length_mm, float((stiff / usual) ** 0.25))


def _wrinkled(
    usual: ByUsualPlate, thin_plate: ThinPlate, equations: JointEquations, painted: Pool
) -> float:
    """Whether relief stays high at short waves, and so goes on where it is not seen, 0 to 1.

    Told by how much more of it lies in a coarser band of lengths than in a finer one (`_BANDS`),
    where paint shows it, both without the energy of noise.
    """
    rough, smooth = _BAND_RATIOS
    fine, coarse = _bands(usual, thin_plate, equations, painted)
    if min(fine.relief, coarse.relief) <= 0 or fine.relief < _LEAST_RELIEF * fine.noise:
        return 0.0
    ratio = np.sqrt(coarse.relief / fine.relief)
    return float(np.clip((smooth - ratio) / (smooth - rough), 0.0, 1.0))


class _Band(NamedTuple):
    """Energies of one band of lengths, mm^2."""

    relief: float
    noise: float


def _bands(
    usual: ByUsualPlate, thin_plate: ThinPlate, equations: JointEquations, painted: Pool
) -> list[_Band]:
    """What lies in either of the two bands of lengths."""
    told = painted.counted
    loads = [thin_plate.area_mm2 * probe for probe in usual.probes]
    unseen = times_unseen(equations.photos)[told]
    found: list[_Band] = []
    for band in _BANDS:
        taken: list[Float64[np.ndarray, "k n"]] = []
        for times in band:
            length_mm = times * equations.length_mm
            taken.append(np.array(_taken_by(length_mm, usual, thin_plate, loads))[:, told])
        whole, *noises = taken[1] - taken[0]
        noise = sum(usual_square(np.sqrt(unseen) * each) for each in noises) / PROBES
        found.append(_Band(usual_square(whole) - noise, noise))
    return found


def _taken_by(
    length_mm: float,
    usual: ByUsualPlate,
    thin_plate: ThinPlate,
    loads: list[Float64[np.ndarray, " n"]],
) -> list[Float64[np.ndarray, " n"]]:
    """What a plate of that length takes off the measured surface, mm, and what is left of loads."""
    bending = bending_of(thin_plate, stiffness_of(thin_plate, 1.0, length_mm))
    system = sp.csr_matrix(sp.diags(thin_plate.area_mm2) + bending @ thin_plate.laplacian)
    flattening = bending @ curvature_of(usual.surface, thin_plate, length_mm)
    return solve_all(system, [flattening, *loads])


@dataclass(frozen=True)
class _LostSlope:
    """How much longer a line is for the squared slope that the plate took off."""

    times: float
    """Squared slope that the plate took over that of (1 - H) H x of the usual plate."""
    noise_kept: float
    """Of the squared slope of the noise on the surface, by a smoothed line."""

    @classmethod
    def of(cls, equations: JointEquations, wrinkled: float) -> "_LostSlope":
        """For that plate; `wrinkled`: whether relief stays high at short waves, 0 to 1."""
        length_mm = equations.length_mm
        more = 1 + (_WRINKLED_SLOPE + _WRINKLED_SLOPE_PER_MM * length_mm - 1) * wrinkled
        times = more * max(_LOST_SLOPE + _LOST_SLOPE_PER_MM * length_mm, 0.0)
        return cls(
            times * equations.stiffness_share**_SLOPE_BY_SHARE,
            1 / (1 + (PLATE_MM / equations.measuring_length_mm) ** _NOISE_KEPT),
        )

    def length(
        self,
        relief: Float64[np.ndarray, " n"],
        folded: Float64[np.ndarray, " n"],
        in_taken: Float64[np.ndarray, " n"],
        roughened: Float64[np.ndarray, " n"],
    ) -> Float64[np.ndarray, "n 2"]:
        """How much longer a line along the limb is, and the standard deviation of that, per length.

        Both lines are smoothed (`core/geometry/smoothed_length`); flat faces are finer and add
        nothing. Relief of slope s lengthens a line by s^2 / 4 over all ways.

        Args:
            relief: squared slope of (1 - H) H x, the usual plate's.
            folded: what of it lies across folds more than along them.
            in_taken: squared slope of the noise, as taken off beside it.
            roughened: squared slope of the noise on the surface.
        """
        lost, roughened = self.times / 4 * relief, self.noise_kept / 4 * roughened
        variance = (
            (_LOST_SLOPE_SIGMA * lost) ** 2
            + (_FOLDED_SIGMA * self.times / 4 * folded) ** 2
            + (_NOISE_SLOPE_SIGMA * self.times / 4 * in_taken) ** 2
            + (_NOISE_SLOPE_SIGMA * roughened) ** 2
        )
        return np.column_stack([lost - roughened, np.sqrt(variance)])


def _one_way(
    mesh: Mesh, lift: Float64[np.ndarray, " n"], seen: SeenSurface, pool: Pool
) -> tuple[Float64[np.ndarray, "n 3"], Float64[np.ndarray, " n"]]:
    """The way that most of the squared slope lies, and its share there less that across it: 0 of
    waves of all ways, 1 of folds side by side. Noise, which lies all ways, takes away from it."""
    products = pooled_products(mesh, products_of_slopes(mesh, lift), pool, WIDE_RINGS)
    flat = seen.axes[:, :2]
    squares, ways = np.linalg.eigh(np.einsum("nai,nij,nbj->nab", flat, products, flat))
    whole = np.maximum(squares.sum(1), np.finfo(float).tiny)
    across = np.einsum("na,nai->ni", ways[:, :, 1], flat)
    return across, np.clip((squares[:, 1] - squares[:, 0]) / whole, 0.0, 1.0)


def _squared_slope(
    thin_plate: ThinPlate, lift: Float64[np.ndarray, " n"]
) -> Float64[np.ndarray, " n"]:
    """Of the surface lifted by that: |grad f|^2 = (laplace(f^2) - 2 f laplace(f)) / 2."""
    return thin_plate.laplacian @ lift**2 / 2 - lift * (thin_plate.laplacian @ lift)


def _noise(
    energies: list[Float64[np.ndarray, " n"]],
    equations: JointEquations,
    pool: Pool,
    loud: Float64[np.ndarray, " n"],
    rings: int,
) -> Float64[np.ndarray, " n"]:
    """Energy of the photos' disagreement, and of what they get wrong alike."""
    unseen = times_unseen(equations.photos)
    return unseen * loud * pool.energy(np.sum(energies, axis=0) / (PROBES * loud), rings)


def _chord(seen: SeenSurface, pool: Pool) -> Float64[np.ndarray, " n"]:
    """How far vertices stand out where faces are flat and the surface is round: edge^2 / 8 R.

    Of a mesh as coarse as its relief that is most of what single vertices err by; what measures of
    the faces have of it is a source of its own (`FACES`).
    """
    edge2 = seen.thin_plate.area_mm2 * 2 / np.sqrt(3)
    return edge2 / 8 * np.abs(pool.mean((seen.quadric[:, 0] + seen.quadric[:, 2]) / 2))


_CAMERA_MODES, _WEAKER_MODES = 6, 5
"""Sources kept by themselves beside the scale; the next ones go to the local part."""
_ASKED = 2000
"""Vertices that tell which modes are strong."""
_LEAST_SPREAD = 1e-4
"""Photos that look along nearly one ray (mean square of t_k - t) do not measure."""


@dataclass(frozen=True, kw_only=True)
class SharedErrors:
    """By vertex, along the normal."""

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
    """Scale and camera errors on the surface."""
    asked = np.flatnonzero(measured)
    asked = asked[:: max(1, len(asked) // _ASKED)]
    vertices, normals = mesh.vertices_mm, axes[:, 2]
    arms = vertices - (vertices[asked] if len(asked) else vertices).mean(0)
    growth = np.einsum("ni,ni->n", arms, normals)
    in_place = np.hstack([normals, np.cross(arms, normals)])
    scale = np.nan_to_num(metric.scale.relative_sigma) * growth[:, None]
    scale -= in_place @ _laid(in_place[asked], scale[asked])
    covariance = metric.scene.camera_covariance
    if covariance is None or not len(asked):
        return SharedErrors(modes_mm=scale, rest_mm2=np.zeros(len(mesh)))

    root = _root(covariance)
    by_cameras = metric.scale.by_cameras
    if by_cameras is None:  # the scale was found otherwise: cameras do not make it grow
        in_place = np.hstack([in_place, growth[:, None]])
        by_cameras = np.zeros(len(root))
    few = _displacements(vertices[asked], axes[asked], seen_by[asked], metric.scene, root)
    few += np.outer(growth[asked], by_cameras @ root)
    laid = _laid(in_place[asked], few)
    few -= in_place[asked] @ laid
    values, turn = np.linalg.eigh(few.T @ few)
    strongest = turn[:, np.argsort(-values)[: _CAMERA_MODES + _WEAKER_MODES]]
    modes = _displacements(vertices, axes, seen_by, metric.scene, root @ strongest)
    modes += np.outer(growth, by_cameras @ root @ strongest) - in_place @ (laid @ strongest)
    return SharedErrors(
        modes_mm=np.hstack([scale, modes[:, :_CAMERA_MODES]]),
        rest_mm2=(modes[:, _CAMERA_MODES:] ** 2).sum(1),
    )


def _laid(
    in_place: Float64[np.ndarray, "m g"], moves: Float64[np.ndarray, "m r"]
) -> Float64[np.ndarray, "g r"]:
    """Shifts and turns that lay moved surfaces on themselves again."""
    return np.linalg.lstsq(in_place, moves, rcond=None)[0]


def _root(covariance: Float64[np.ndarray, "u u"]) -> Float64[np.ndarray, "u r"]:
    """Columns whose outer products add up to the covariance."""
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
    """Moves along the normal for each column of camera numbers."""
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
    """Fill `moves`, zeros, of the vertices whose photos look from sides enough."""
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
        if spread > _LEAST_SPREAD * count:
            for r in range(columns):
                alone = (sum_t[0] * sum_s[0, r] + sum_t[1] * sum_s[1, r]) / count
                moves[n, r] = (alone - sum_ts[r]) / spread


SCALE, CAMERAS, OFFSET = "scale", "cameras and lens", "offset of the whole surface"
FACES, GAPS, CREASES = "flat faces", "gaps between paint", "lost depth of creases"
"""Sources of what all vertices share, as `Mesh.shared_sources` has them."""
_FACES_LEFT = 0.2
"""Standard deviation of how far flat faces as a whole lie off the limb, in chordal deviations. On a
ball 0.05 to 0.07 of them for edges of 4 to 8 pixels, -0.25 to -0.30 for edges of 15."""
_SUNK_PX = 0.13
"""How far the surface lies in or out in all gaps between paint alike, in pixels where all of an
error of the given surface is left: depth maps span them as chords do. Slopes of the errors on what
is left: -0.20 to -0.07 px on seven sparse and bare captures, -0.18 to 0.10 on four others."""
OFFSET_PX = 0.006
"""How far the whole surface may lie in or out by the way photos are sampled, in pixels: volumes of
53 small captures (seeds 6000 to 7088) say -0.007 px for thighs, -0.003 for shanks and 0.003 for
bulbous limbs, and blur that is not known adds 0.002. Errors of 139 volumes (seeds 9000 to 11099)
were 0.92 of what 0.005 states; of 30 made by later code (seeds 32100 to 35007) 1.2 of what 0.0045
states."""


def with_sigma(
    mesh: Mesh,
    seen: SeenSurface,
    equations: JointEquations,
    usual: ByUsualPlate,
    metric: MetricScene,
    guessed: Bool[np.ndarray, " n"],
) -> Mesh:
    """The mesh with its sigmas; NaN at filled vertices.

    Args:
        guessed: Vertices that no depth map had. Patches that look alike by chance are found on bare
            skin too, so such a vertex counts as filled unless texture holds it.
    """
    local = local_errors(mesh, seen, equations, usual)
    filled = all_filled(mesh, equations, guessed, local.left)
    measured = ~filled & (equations.photos > 1)
    shared = shared_errors(mesh, seen.axes, seen.seen_by, measured, metric)
    offset_mm = OFFSET_PX * seen.pixel_mm
    faces_mm = _FACES_LEFT * mesh.chordal_deviations_mm()
    gaps_mm = _SUNK_PX * local.left * seen.pixel_mm
    beside_mm = np.column_stack([shared.modes_mm, offset_mm, faces_mm])
    within_mm = np.column_stack([gaps_mm, local.creases_mm])  # of the local variance
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
