"""The noise of photos that disagree, on a linear problem whose errors are drawn."""

from dataclasses import dataclass, replace
from functools import cache, cached_property, lru_cache

import numpy as np
import pytest
import scipy.sparse as sp

from limbgram.core.geometry.smoothed_length import smoothed_length
from limbgram.core.mesh.mesh import Mesh
from limbgram.reconstruction.measuring.anisotropic_plate import with_anisotropic_plate
from limbgram.reconstruction.measuring.measurement_pass import (
    JointEquations,
    ObservedSurface,
    match_jointly,
)
from limbgram.reconstruction.measuring.reference_plate import fit_reference_plate, with_softer_plate
from limbgram.reconstruction.measuring.thin_plate import (
    ThinPlate,
    bending_force,
    quadrics,
    solve,
    stiffness_of,
    tangent_axes,
    thin_plate_of,
)
from limbgram.reconstruction.measuring.uncertainty import (
    LocalErrors,
    filled_or_unsupported,
    local_errors,
)

SIDE, EDGE_MM, PHOTOS = 60, 1.2, 5
LENGTH_MM = 0.8
PIXEL_MM = EDGE_MM / 4.5
NOISE_MM = 0.08
"""Of what one photo says about the offset of one face."""


@dataclass(frozen=True)
class Solved:
    mesh: Mesh
    seen: ObservedSurface
    equations: JointEquations
    errors_mm: np.ndarray

    @cached_property
    def local(self) -> LocalErrors:
        """Errors of what the reference plate measured."""
        return _local(self.mesh, self.seen, self.equations)


def solved(
    common: float,
    seed: int,
    wave_mm: float = 0.0,
    shortest_mm: float = 4.0,
    bare_mm: float = 0.0,
    growth: float = 1.0,
    turn_rad: float | None = None,
    share: float = 1.0,
    crease_mm: float = 0.0,
    dabs_mm: float = np.inf,
) -> Solved:
    """As `_solved`, which computes it once for tests that ask for the same."""
    return _solved(
        common, seed, wave_mm, shortest_mm, bare_mm, growth, turn_rad, share, crease_mm, dabs_mm
    )


@lru_cache(maxsize=32)
def _solved(
    common: float,
    seed: int,
    wave_mm: float,
    shortest_mm: float,
    bare_mm: float,
    growth: float,
    turn_rad: float | None,
    share: float,
    crease_mm: float,
    dabs_mm: float,
) -> Solved:
    """A flat surface (or one with waves of that amplitude) measured by photos that err alike.

    By a plate with that share of the usual stiffness; `crease_mm` are folds beside its middle.

    Within `bare_mm` of its middle the photos show nothing, and with `dabs_mm` nothing right of the
    middle but in dabs of that radius. With `turn_rad` all waves run nearly
    that way, from x; without, each goes its own.
    """
    mesh = _sheet()
    random = np.random.default_rng(seed)
    count = len(mesh.faces)
    shared, own = random.normal(size=(count, 1)), random.normal(size=(count, PHOTOS))
    noise = NOISE_MM * (np.sqrt(common) * shared + np.sqrt(1 - common) * own)
    true_mm = wave_mm * _waves(mesh.vertices_mm, random, shortest_mm, growth, turn_rad)
    true_mm += crease_mm * _folds(mesh)
    thin_plate = _plate_of_sheet()
    weight = 1 / NOISE_MM**2
    spread = sp.csr_matrix(
        (np.full(3 * count, 1 / 3), (np.repeat(np.arange(count), 3), mesh.faces.ravel())),
        (count, len(mesh)),
    )
    bare = (_from_middle(mesh) < bare_mm) | (_beside_dabs_mm(mesh) > dabs_mm)
    shown = (_from_middle(mesh)[mesh.faces].mean(1) >= bare_mm).astype(float)
    shown[_beside_dabs_mm(mesh)[mesh.faces].mean(1) > dabs_mm] = 0.0
    weighted = sp.csr_matrix(weight * spread.T @ sp.diags(shown))
    data = sp.csr_matrix(PHOTOS * weighted @ spread + 1e-3 * sp.eye(len(mesh)))
    told = noise + (spread @ true_mm)[:, None]
    right = weighted @ told.sum(1)
    density = float(np.median(data.diagonal() / thin_plate.area_mm2))
    stiffness = share * stiffness_of(thin_plate, density, LENGTH_MM)
    system = sp.csr_matrix(data + bending_force(thin_plate, stiffness) @ thin_plate.laplacian)
    moved_mm = solve(system, right, np.zeros(len(mesh)))
    left = told - (spread @ moved_mm)[:, None]
    told_apart = left * np.sqrt(1 - 1 / PHOTOS)  # texture takes one
    lifted = mesh.vertices_mm + moved_mm[:, None] * [0.0, 0.0, 1.0]
    mesh = mesh.with_vertices(lifted)
    axes = tangent_axes(np.tile([0.0, 0.0, 1.0], (len(mesh), 1)))
    seen = ObservedSurface(
        thin_plate=thin_plate,
        axes=axes,
        quadric=0 * quadrics(mesh, thin_plate, axes),
        seen_by=np.tile(np.arange(PHOTOS, dtype=np.int32), (len(mesh), 1)),
        pixel_mm=np.full(len(mesh), PIXEL_MM),
    )
    equations = JointEquations(
        weights=data.diagonal(),
        hessian=data,
        right=weighted @ left.sum(1),
        right_by_photo=(weight * shown[:, None] * told_apart).astype(np.float32),
        photo_count=np.full(len(mesh), PHOTOS),
        length_mm=LENGTH_MM,
        stiffness=stiffness,
        stiffness_share=share,
        plate=thin_plate,
        cross_grain_factor=np.ones(len(mesh)),
        signal=np.where(bare, 0.1, 1.0),
        texture_hessian=sp.csr_matrix(
            data + 1.4 * sp.eye(len(mesh))
        ),  # belief in the given surface
        other_hessian=sp.csr_matrix((len(mesh), len(mesh))),
    )
    return Solved(mesh, seen, equations, moved_mm - true_mm)


@pytest.mark.parametrize(
    ("common", "low", "high"),
    [pytest.param(0.0, 0.65, 0.82, marks=pytest.mark.slow), (0.2, 0.8, 0.95)],
)
def test_noise_is_told_by_how_photos_disagree(common: float, low: float, high: float) -> None:
    """Whether photos err alike by nothing or by the most that captures showed, sigma is near.

    Errors of captures are alike by 0.05 to 0.2 (docs/method/uncertainty.md). A sheet without relief
    has no lost detail, so its sigma is somewhat wide.
    """
    ratios: list[float] = []
    for seed in range(4):
        found = solved(common, seed)
        sigma = np.sqrt(found.local.variance_mm2)
        inside = _inside()
        ratios.append(float(np.sqrt(np.mean((found.errors_mm / sigma)[inside] ** 2))))
    assert low < np.mean(ratios) < high


@pytest.mark.parametrize(
    "numbers",
    [
        (0, 4),
        (0, 2, 5),
        *(
            pytest.param(one, marks=pytest.mark.slow)
            for one in ((0, 8), (0, 1), (0, 1, 2, 3, 4, 5))
        ),
    ],
)
def test_noise_is_the_sum_of_the_photos_squares_whatever_their_numbers(
    numbers: tuple[int, ...],
) -> None:
    """Pulls of the photos that see a place cancel: the texture is the mean of what they show.

    Signs by the number of the photo told nothing of two photos that were four apart, and a third
    too much of two that follow one another.
    """
    random = np.random.default_rng(2)
    found, mesh = solved(0.0, 1), _sheet()  # flat: it has lost no detail
    first = random.integers(0, 40, len(mesh))
    seen_by = (first[:, None] + numbers).astype(np.int32)
    right_by_photo = random.normal(size=(len(mesh.faces), len(numbers)))
    right_by_photo -= right_by_photo.mean(axis=1, keepdims=True)
    equations = replace(
        found.equations,
        right_by_photo=right_by_photo.astype(np.float32),
        photo_count=np.full(len(mesh), len(numbers)),
    )
    variance = _local(mesh, replace(found.seen, seen_by=seen_by), equations).variance_mm2

    plate = (
        bending_force(found.seen.thin_plate, equations.stiffness) @ found.seen.thin_plate.laplacian
    )
    system, photo = sp.csr_matrix(equations.texture_hessian + plate), seen_by[mesh.faces[:, 0]]
    squares = np.zeros(len(mesh))
    for number in np.unique(photo):
        pulls = np.repeat(np.where(photo == number, right_by_photo, 0.0).sum(axis=1) / 3, 3)
        right = np.bincount(mesh.faces.ravel(), pulls, len(mesh))
        squares += solve(system, right, np.zeros(len(mesh))) ** 2
    count, common = len(numbers), 0.14  # docs/method/uncertainty.md
    unseen = count / (count - 1) * (1 + (count - 1) * common) / (1 - common)
    inside = _inside()
    assert 0.88 < variance[inside].mean() / (unseen * squares[inside].mean()) < 1.12


def test_detail_that_the_thin_plate_takes_is_told() -> None:
    found = solved(0.1, 7, wave_mm=0.3)
    sigma = np.sqrt(found.local.variance_mm2)
    inside = _inside()
    smooth = solved(0.1, 7)
    error, error_smooth = found.errors_mm[inside].std(), smooth.errors_mm[inside].std()
    assert error > 1.4 * error_smooth  # the waves were lost
    assert 0.7 < error / np.sqrt(np.mean(sigma[inside] ** 2)) < 1.4


@pytest.mark.parametrize(
    ("wave_mm", "shortest_mm"),
    [
        (0.3, 4.0),
        (0.0, 4.0),
        pytest.param(0.3, 2.0, marks=pytest.mark.slow),
        pytest.param(0.1, 2.0, marks=pytest.mark.slow),
    ],
)
def test_a_line_gets_back_what_lost_relief_took_and_gives_what_noise_added(
    wave_mm: float, shortest_mm: float
) -> None:
    """Relief of 0.1 mm is half hidden in the noise: there the interval holds, no more."""
    truly: list[float] = []
    told: list[np.ndarray] = []
    for seed in range(3):
        found = solved(0.1, seed, wave_mm, shortest_mm)
        lift, inside = found.mesh.vertices_mm[:, 2], _inside()
        truly.append(_longer(lift - found.errors_mm) - _longer(lift))
        lost = found.local.lost_length
        told.append(lost[inside].mean(0))
    expected, sigma = np.mean(told, axis=0)
    assert abs(expected - np.mean(truly)) < 1.96 * sigma
    if wave_mm == 0.3:
        assert 0.6 < expected / np.mean(truly) < 2.2
        assert sigma < 0.6 * expected
    if wave_mm == 0:
        assert np.mean(truly) < 0
        assert expected < 0  # noise makes lines longer


@pytest.mark.parametrize(("turn_rad", "times"), [(0.0, 2.0), (np.pi / 2, 0.0)])
def test_a_line_across_folds_gets_back_twice_as_much_and_one_along_them_nothing(
    turn_rad: float, times: float
) -> None:
    """As what it lost in the mean of all directions."""
    truly: list[float] = []
    told: list[np.ndarray] = []
    for seed in range(3):
        found = solved(0.1, seed, 0.3, turn_rad=turn_rad)
        lift, inside = found.mesh.vertices_mm[:, 2], _inside()
        truly.append(_longer(lift - found.errors_mm) - _longer(lift))
        local = found.local
        across = local.lost_across[inside]
        size = np.linalg.norm(across, axis=1)
        along_x = 2 * across[:, 0] ** 2 / size - size
        told.append(np.array([*local.lost_length[inside].mean(0), along_x.mean()]))
    expected, sigma, more = np.mean(told, axis=0)
    assert times - 0.7 < np.mean(truly) / expected < times + 0.7
    assert (expected + more) / expected == pytest.approx(times, abs=0.3)
    assert abs(expected + more - np.mean(truly)) < 1.96 * sigma
    assert sigma < 0.5 * expected


@pytest.mark.parametrize(
    ("growth", "shortest_mm"),
    [(1.0, 4.0), (0.2, 2.5), pytest.param(0.0, 2.5, marks=pytest.mark.slow)],
)
def test_relief_that_stays_high_at_short_waves_is_told_to_be_lost(
    growth: float, shortest_mm: float
) -> None:
    """Before, errors over wrinkles were 1.6 times what sigma said."""
    ratios: list[float] = []
    for seed in range(2):
        found = solved(0.1, seed, 0.3, shortest_mm, growth=growth)
        variance = found.local.variance_mm2
        inside = _inside()
        ratios.append(float(np.sqrt(np.mean(found.errors_mm[inside] ** 2 / variance[inside]))))
    assert 0.8 < np.mean(ratios) < 1.35


@pytest.mark.parametrize(
    ("growth", "shortest_mm", "least"),
    [(1.0, 4.0, 0.8), (0.2, 2.5, 0.9), pytest.param(0.0, 2.5, 0.9, marks=pytest.mark.slow)],
)
def test_a_line_gets_back_what_wrinkles_lost(
    growth: float, shortest_mm: float, least: float
) -> None:
    """All of it, which is 1; told as usual relief, wrinkles would give back two thirds."""
    truly: list[float] = []
    told: list[np.ndarray] = []
    for seed in range(2):
        found = solved(0.1, seed, 0.3, shortest_mm, growth=growth)
        lift, inside = found.mesh.vertices_mm[:, 2], _inside()
        truly.append(_longer(lift - found.errors_mm) - _longer(lift))
        lost = found.local.lost_length
        told.append(lost[inside].mean(0))
    expected, sigma = np.mean(told, axis=0)
    assert abs(expected - np.mean(truly)) < 1.96 * sigma
    assert least < expected / np.mean(truly) < 1.8


def test_a_plate_too_stiff_for_its_relief_is_softened_and_errs_less() -> None:
    stiff = solved(0.1, 3, wave_mm=0.3)
    usual = fit_reference_plate(stiff.mesh, stiff.seen, stiff.equations)
    share = with_softer_plate(stiff.seen, stiff.equations, usual).stiffness_share
    soft, inside = solved(0.1, 3, wave_mm=0.3, share=share), _inside()
    assert share < 0.8
    assert soft.errors_mm[inside].std() < 0.95 * stiff.errors_mm[inside].std()


def test_a_plate_over_noise_alone_stays_as_stiff() -> None:
    found = solved(0.1, 3)
    usual = fit_reference_plate(found.mesh, found.seen, found.equations)
    assert with_softer_plate(found.seen, found.equations, usual) is found.equations


@pytest.mark.parametrize("share", [pytest.param(0.6, marks=pytest.mark.slow), 0.4])
@pytest.mark.parametrize(
    ("wave_mm", "shortest_mm"), [(0.3, 4.0), pytest.param(0.1, 2.0, marks=pytest.mark.slow)]
)
def test_what_a_softer_plate_loses_is_told(
    share: float, wave_mm: float, shortest_mm: float
) -> None:
    ratios: list[float] = []
    for seed in range(2):
        found = solved(0.1, seed, wave_mm, shortest_mm, share=share)
        stiff = solved(0.1, seed, wave_mm, shortest_mm)
        usual = fit_reference_plate(stiff.mesh, stiff.seen, stiff.equations)
        variance = local_errors(found.mesh, found.seen, found.equations, usual).variance_mm2
        inside = _inside()
        ratios.append(float(np.sqrt(np.mean(found.errors_mm[inside] ** 2 / variance[inside]))))
    assert 0.75 < np.mean(ratios) < 1.25


@pytest.mark.parametrize("turn_rad", [0.0, 0.7])
def test_a_plate_follows_folds_that_run_one_way(turn_rad: float) -> None:
    """Whichever way they run on the mesh. It errs less over them, and holds as much noise back."""
    usual, leaning = zip(*(_followed(0.3, seed, turn_rad) for seed in range(3)), strict=True)
    assert np.mean(leaning) < 0.9 * np.mean(usual)


@pytest.mark.parametrize("wave_mm", [0.0, 0.3])
def test_a_plate_without_grain_to_follow_errs_as_before(wave_mm: float) -> None:
    """Over noise alone, and over relief that runs all ways."""
    usual, leaning = zip(*(_followed(wave_mm, seed, None) for seed in range(3)), strict=True)
    assert 0.9 < np.mean(leaning) / np.mean(usual) < 1.03


def _followed(wave_mm: float, seed: int, turn_rad: float | None) -> tuple[float, float]:
    """RMS error of the reference plate and of one that follows the grain, mm."""
    found, inside = solved(0.1, seed, wave_mm, turn_rad=turn_rad), _inside()
    _, mesh = _leaning(found)
    errors_mm = found.errors_mm + (mesh.vertices_mm - found.mesh.vertices_mm)[:, 2]
    return float(found.errors_mm[inside].std()), float(errors_mm[inside].std())


def _leaning(found: Solved) -> tuple[JointEquations, Mesh]:
    """The equations with a plate that follows the grain, and what it measures."""
    usual = fit_reference_plate(found.mesh, found.seen, found.equations)
    equations = with_anisotropic_plate(found.seen, found.equations, usual)
    moves_mm = match_jointly(found.mesh, equations)
    lifted = found.mesh.vertices_mm + moves_mm[:, None] * found.seen.axes[:, 2]
    return equations, found.mesh.with_vertices(lifted)


def test_what_levels_along_folds_lose_is_told_on_valleys_and_beside_them() -> None:
    """All along a fold the plate errs alike: its sum is wrong by all of that.

    Errors that are alike over 1.8 mm would sum up, over 50 mm, to a quarter of a vertex's sigma.
    """
    errors: list[np.ndarray] = []
    told: list[np.ndarray] = []
    for seed in (4, 5, 6):
        found = solved(0.1, seed, crease_mm=0.8)
        local, beside = found.local, _inside()
        beside &= _beside_middle_mm(found.mesh) < 7.0
        line = np.round(found.mesh.vertices_mm[:, 0] / (EDGE_MM / 2)).astype(int)
        of_line = np.eye(line.max() + 1)[:, line[beside]]
        of_line = of_line[of_line.sum(1) > 10]
        of_line /= of_line.sum(1, keepdims=True)
        errors.append(of_line @ found.errors_mm[beside])
        told.append(np.linalg.norm(of_line @ local.creases_mm[beside], axis=1))
        assert (local.creases_mm[beside] ** 2).sum(1).mean() < 1.5 * local.variance_mm2.max()
    error, sigma = np.concatenate(errors), np.concatenate(told)
    assert np.sqrt(np.mean(error**2)) > 0.03
    assert 0.6 < np.sqrt(np.mean(error**2) / np.mean(sigma**2)) < 1.6
    # as on a flank, where one source alone tells next to nothing
    assert np.mean(np.abs(error) < 1.96 * sigma) > 0.95


def test_relief_that_runs_all_ways_has_next_to_no_creases() -> None:
    """By chance a place has more than the median; what it says of a line is little all the same."""
    found, inside = solved(0.1, 4, wave_mm=0.3), _inside()
    local = found.local
    line_mm = np.linalg.norm(local.creases_mm[inside].mean(0))
    assert line_mm < 0.1 * np.sqrt(local.variance_mm2[inside].mean())


@pytest.mark.parametrize("wave_mm", [0.0, 0.3])
def test_without_folds_little_of_the_variance_is_that_of_creases(wave_mm: float) -> None:
    """Half of any surface lies above the median place: counted, it had three quarters and more.

    Of a sheet as small as this, chance lets a little more stand out on one and less on another.
    """
    shares: list[float] = []
    for seed in range(4):
        found, inside = solved(0.1, seed, wave_mm=wave_mm), _inside()
        local = found.local
        creases = (local.creases_mm[inside] ** 2).sum(1).mean()
        shares.append(float(creases / local.variance_mm2[inside].mean()))
    assert np.mean(shares) < 0.4


def test_where_no_paint_shows_it_no_crease_is_told() -> None:
    found = solved(0.1, 4, crease_mm=0.8)
    bare = replace(found.equations, signal=np.full(len(found.mesh), 0.1))
    assert not _local(found.mesh, found.seen, bare).creases_mm.any()


def _local(mesh: Mesh, seen: ObservedSurface, equations: JointEquations) -> LocalErrors:
    """Errors of what the reference plate measured."""
    return local_errors(mesh, seen, equations, fit_reference_plate(mesh, seen, equations))


def _longer(lift: np.ndarray) -> float:
    """How much longer lines along the sheet's inner rows are than straight ones, smoothed."""
    x = _sheet().vertices_mm[:, 0].reshape(SIDE, SIDE)
    rows = np.flatnonzero(_inside().reshape(SIDE, SIDE).any(axis=1))
    inner = slice(int(rows[0]), int(rows[-1]) + 1)
    straight = np.ptp(x[inner, inner], axis=1).sum()
    lines = (np.column_stack([x[row, inner], lift.reshape(SIDE, SIDE)[row, inner]]) for row in rows)
    return sum(smoothed_length(line, closed=False).value_mm for line in lines) / straight - 1


def test_where_no_photos_agree_the_given_surface_keeps_its_error() -> None:
    """In the middle of a wide gap that surface is wrong by a third of a pixel.

    The plate carries the paint's height into a narrow gap; where there is paint nothing changes.
    """
    away_mm = _from_middle(_sheet())
    added_px: list[float] = []
    for radius_mm in (1.5, 12.0):
        found = solved(0.1, 1, bare_mm=radius_mm)
        usual = found.local.variance_mm2
        variance = _local(found.mesh, found.seen, _believing(found)).variance_mm2
        added = np.sqrt(np.maximum(variance - usual, 0.0)) / PIXEL_MM
        added_px.append(float(np.median(added[away_mm < 1.5])))
        painted = _inside() & (away_mm > radius_mm + 12 * EDGE_MM)
        assert np.max(added[painted]) < 0.02
    assert added_px[0] < 0.05
    assert 0.25 < added_px[1] < 0.4


def test_a_guess_over_bare_skin_stays_one_and_a_guess_in_paint_was_measured() -> None:
    """What was measured from the start is no guess, wherever it lies."""
    found = solved(0.1, 1, bare_mm=12.0)
    away_mm = _from_middle(_sheet())
    local = _local(found.mesh, found.seen, _believing(found))
    everywhere = np.ones(len(found.mesh), np.bool_)
    guesses = filled_or_unsupported(found.mesh, found.equations, everywhere, local.start_error_left)
    assert guesses[away_mm < 8].all()
    assert not guesses[_inside() & (away_mm > 14)].any()
    assert not filled_or_unsupported(
        found.mesh, found.equations, ~everywhere, local.start_error_left
    ).any()


@pytest.mark.parametrize("weak", ["guessed", "agreed on by one photo", "stretched", "held"])
def test_weak_places_beside_a_fill_belong_to_it_and_no_others(weak: str) -> None:
    """What is held, or weak somewhere else, is measured."""
    found = solved(0.1, 1)
    away_mm = _from_middle(found.mesh)
    fill = away_mm < 3 * EDGE_MM
    beside = found.mesh.faces[fill[found.mesh.faces].any(axis=1)]
    side = np.isin(np.arange(len(fill)), beside) & ~fill
    far = (away_mm > 12 * EDGE_MM) & (away_mm < 14 * EDGE_MM)
    chosen = side | far
    mesh, photo_count = replace(found.mesh, filled=fill), found.equations.photo_count.copy()
    guessed = chosen & (weak == "guessed")
    if weak == "agreed on by one photo":
        photo_count[chosen] = 1
    if weak == "stretched":
        lifted = mesh.vertices_mm.copy()
        lifted[chosen, 2] += 3 * EDGE_MM
        mesh = mesh.with_vertices(lifted)
    equations = replace(found.equations, photo_count=photo_count)
    filled = filled_or_unsupported(mesh, equations, guessed, np.zeros(len(mesh)))
    assert filled[fill].all()
    assert filled[side].all() == (weak != "held")
    assert not filled[away_mm > 5 * EDGE_MM].any()


def test_a_guess_is_filled_from_where_half_of_an_error_would_stay() -> None:
    """In eight captures errors of guesses were 0.5 px below one half, up to 4.9 mm above it."""
    found = solved(0.1, 1)
    everywhere = np.ones(len(found.mesh), bool)
    held = np.full(len(found.mesh), 0.45)
    assert not filled_or_unsupported(found.mesh, found.equations, everywhere, held).any()
    assert filled_or_unsupported(found.mesh, found.equations, everywhere, held + 0.1).all()


def test_a_surface_that_photos_hardly_see_has_finite_sigmas() -> None:
    """No photo sees most of it: the inside of a pot, or the floor of a cast."""
    found = solved(0.1, 1)
    right_by_photo = found.equations.right_by_photo.copy()
    right_by_photo[_from_middle(found.mesh)[found.mesh.faces].mean(1) > 15.0] = 0.0
    seldom = replace(found.equations, right_by_photo=right_by_photo)
    with np.errstate(all="raise", under="ignore"):
        variance = _local(found.mesh, found.seen, seldom).variance_mm2
    assert np.isfinite(variance).all()
    assert (variance > 0).all()


def test_noise_pushes_an_unheld_place_no_further_than_the_given_surface_lets_it() -> None:
    found = solved(0.1, 1, bare_mm=12.0)
    away_mm = _from_middle(_sheet())
    loud = found.equations.right_by_photo.copy()
    loud[(away_mm[found.mesh.faces] < 9).all(1)] = 40.0  # of one sign in all photos
    loud[:, ::2] *= -1
    equations = replace(_believing(found), right_by_photo=loud)
    sigma = np.sqrt(_local(found.mesh, found.seen, equations).variance_mm2)
    free = replace(found.equations, right_by_photo=loud)
    unbounded = np.sqrt(_local(found.mesh, found.seen, free).variance_mm2)
    middle = away_mm < 4
    assert np.median(unbounded[middle]) > 1.5 * PIXEL_MM
    assert np.median(sigma[middle]) < 0.7 * PIXEL_MM


def test_a_vertex_that_one_photo_sees_is_a_little_less_sure() -> None:
    found = solved(0.1, 1)
    usual = found.local.variance_mm2
    photo_count = found.equations.photo_count.copy()
    photo_count[500] = 1
    alone = replace(found.equations, photo_count=photo_count)
    variance = _local(found.mesh, found.seen, alone).variance_mm2
    added_px = np.sqrt(variance[500] - usual[500]) / PIXEL_MM
    assert 0.1 < added_px < 0.25


def test_sigma_is_even_where_the_data_are() -> None:
    """Without the data's own hold beside them, four draws alone would give 0.154."""
    apart: list[float] = []
    for seed in (1, 3):
        found = solved(0.1, seed)
        variance = found.local.variance_mm2
        rows = np.log(variance).reshape(SIDE, SIDE)[7:-7, 7:-7] / 2
        apart.append(float(np.std(rows[:, 5:] - rows[:, :-5])))
    assert 0.02 < np.mean(apart) < 0.135


def test_photos_err_more_alike_where_little_is_painted() -> None:
    """The same disagreement of five photos tells 1.45 times the energy if a quarter is painted."""
    found = solved(0.1, 2)
    usual = _local(found.mesh, found.seen, found.equations).variance_mm2
    painted = np.random.default_rng(2).random(len(found.mesh)) < 0.25
    sparse = replace(found.equations, signal=np.where(painted, 1.0, 0.5))
    more = _local(found.mesh, found.seen, sparse).variance_mm2 / usual
    assert 1.25 < np.median(more[_inside()]) < 1.6


def _believing(found: Solved) -> JointEquations:
    """The same equations where the steps believe in the given surface to a pixel."""
    believed = sp.eye(len(found.mesh)) / PIXEL_MM**2
    return replace(
        found.equations,
        hessian=sp.csr_matrix(found.equations.hessian + believed),
        other_hessian=sp.csr_matrix(believed),
    )


@pytest.mark.slow
def test_sigma_grows_over_a_bare_patch_the_more_the_wider_it_is() -> None:
    """Relief under a gap in the paint is not seen: the plate runs straight over it.

    It grows with the gap as paint round it shows that it grows: waves end at 16 mm, so that a gap
    of 14 mm costs hardly more than one of 8 mm.
    """
    away_mm = _from_middle(_sheet())
    middle, round_it = away_mm < 2, _inside() & (away_mm > 10)
    errors: list[float] = []
    sigmas: list[float] = []
    for radius_mm in (0.0, 4.0, 7.0):
        variances: list[np.ndarray] = []
        squares: list[np.ndarray] = []
        for seed in range(4):
            found = solved(0.1, seed, wave_mm=0.3, shortest_mm=2.0, bare_mm=radius_mm)
            squares.append(found.errors_mm**2)
            local = found.local
            variances.append(local.variance_mm2)
        rest = np.sqrt(np.mean(np.array(variances)[:, round_it]))
        errors.append(float(np.sqrt(np.mean(np.array(squares)[:, middle]))))
        sigmas.append(float(np.sqrt(np.mean(np.array(variances)[:, middle]))))
        assert 0.025 < rest < 0.05  # the gap is no matter of theirs
    assert errors[1] > 2 * errors[0]  # the gap costs what it is to cost
    assert sigmas[1] > 1.6 * sigmas[0]
    assert sigmas[2] > 1.1 * sigmas[1]
    for error, sigma in zip(errors[1:], sigmas[1:], strict=True):
        assert 0.6 * error < sigma < 1.2 * error


def test_sigma_grows_between_dabs_as_errors_do() -> None:
    """Dense paint on one half and dabs 8 mm apart beside it, over waves of 4 mm and longer.

    If relief between dabs grew only as the plate's own, errors there were twice what is stated.
    """
    right_mm = _right_mm(_sheet())
    halves = _inside() & (right_mm < -8), _inside() & (right_mm > 8)
    squares: list[np.ndarray] = []
    variances: list[np.ndarray] = []
    for seed in range(3):
        found = solved(0.1, seed, wave_mm=0.3, growth=0.7, dabs_mm=2.8)
        squares.append(found.errors_mm**2)
        variances.append(_local(found.mesh, found.seen, _believing(found)).variance_mm2)
    dense, dabs = (
        np.sqrt(np.mean(np.array(squares)[:, half]) / np.mean(np.array(variances)[:, half]))
        for half in halves
    )
    assert 0.8 < dense < 1.3
    assert 0.7 < dabs / dense < 1.4  # 1.85 in proportion to the plate's


def test_noise_taken_for_texture_makes_a_vertex_less_sure() -> None:
    """The photos pull as much as anywhere, and a tenth of it is what truly holds."""
    found = solved(0.1, 2)
    usual = found.local.variance_mm2
    noisy = _from_middle(_sheet()) < 10
    root = sp.diags(np.where(noisy, np.sqrt(0.1), 1.0))
    held = sp.csr_matrix(root @ found.equations.texture_hessian @ root)
    told = replace(found.equations, texture_hessian=held, signal=np.where(noisy, 0.1, 1.0))
    sigma = np.sqrt(_local(found.mesh, found.seen, told).variance_mm2 / usual)
    away_mm = _from_middle(_sheet())
    assert np.median(sigma[away_mm < 6]) > 1.5
    assert 0.9 < np.median(sigma[_inside() & (away_mm > 20)]) < 1.1


def test_what_goes_wild_in_one_place_makes_the_rest_no_less_sure() -> None:
    found = solved(0.1, 1)
    usual = np.sqrt(found.local.variance_mm2)
    wild = (found.mesh.faces == 30 * SIDE + 30).any(1)
    right_by_photo = found.equations.right_by_photo.copy()
    right_by_photo[wild] *= 1000
    equations = replace(found.equations, right_by_photo=right_by_photo)
    sigma = np.sqrt(_local(found.mesh, found.seen, equations).variance_mm2)
    apart_mm = np.linalg.norm(
        found.mesh.vertices_mm - found.mesh.vertices_mm[30 * SIDE + 30], axis=1
    )
    far = _inside() & (apart_mm > 25)
    assert far.sum() > 500
    assert 0.98 < np.median(sigma[far] / usual[far]) < 1.05
    assert sigma[30 * SIDE + 30] > 1.5 * usual[30 * SIDE + 30]


@cache
def _plate_of_sheet() -> ThinPlate:
    return thin_plate_of(_sheet())


@cache
def _sheet() -> Mesh:
    """A rhomb of equilateral triangles."""
    column, row = (part.ravel() for part in np.meshgrid(np.arange(SIDE), np.arange(SIDE)))
    at = np.arange(SIDE * SIDE).reshape(SIDE, SIDE)
    a, b, c, d = (part.ravel() for part in (at[:-1, :-1], at[:-1, 1:], at[1:, :-1], at[1:, 1:]))
    x, y = EDGE_MM * (column + 0.5 * row), EDGE_MM * np.sqrt(3) / 2 * row
    return Mesh(
        vertices_mm=np.stack([x, y, np.zeros(len(x))], 1),
        faces=np.concatenate([np.stack([a, b, c], 1), np.stack([b, d, c], 1)]).astype(np.int32),
    )


def _waves(
    points: np.ndarray,
    random: np.random.Generator,
    shortest_mm: float,
    growth: float,
    turn_rad: float | None,
) -> np.ndarray:
    """Waves of up to 16 mm, the long ones higher by that power; standard deviation 1."""
    lengths = np.geomspace(shortest_mm, 16.0, 20)
    heights = lengths**growth
    heights *= np.sqrt(2) / np.linalg.norm(heights)
    total = np.zeros(len(points))
    for length, height in zip(lengths, heights, strict=True):
        turn, phase = random.uniform(0, 2 * np.pi, 2)
        if turn_rad is not None:
            turn = turn_rad + 0.05 * np.sin(turn)
        along = points[:, 0] * np.cos(turn) + points[:, 1] * np.sin(turn)
        total += height * np.sin(2 * np.pi * along / length + phase)
    return total


def _folds(mesh: Mesh) -> np.ndarray:
    """Sharp valleys 4 mm apart within 8 mm of the sheet's middle line; up to 1."""
    beside = _beside_middle_mm(mesh)
    return np.where(beside < 8.0, np.abs(np.sin(np.pi * beside / 4.0)) ** 0.75, 0.0)


def _beside_middle_mm(mesh: Mesh) -> np.ndarray:
    return np.abs(_right_mm(mesh))


def _right_mm(mesh: Mesh) -> np.ndarray:
    x = mesh.vertices_mm[:, 0]
    return x - x.mean()


def _beside_dabs_mm(mesh: Mesh) -> np.ndarray:
    """Distance of each vertex from the nearest place of a grid of 8 mm, right of the middle."""
    flat = mesh.vertices_mm[:, :2] - mesh.vertices_mm[:, :2].mean(0)
    away_mm = np.linalg.norm(flat - 8.0 * np.round(flat / 8.0), axis=1)
    return np.where(flat[:, 0] > 0, away_mm, 0.0)


def _from_middle(mesh: Mesh) -> np.ndarray:
    """Distance of each vertex from the middle of the sheet, mm."""
    flat = mesh.vertices_mm[:, :2]
    return np.linalg.norm(flat - flat.mean(0), axis=1)


def _inside() -> np.ndarray:
    """Vertices away from the rim."""
    place = np.arange(SIDE * SIDE)
    column, row = place % SIDE, place // SIDE
    return (np.minimum(column, row) > 6) & (np.maximum(column, row) < SIDE - 7)
