"""Lens deviations: per-photo deviations from the camera's lens: stabiliser, focus, rolling shutter.

A camera's lens is one for all its photos. Three faults of real cameras break that: an optical
stabiliser moves the picture on the sensor (principal point), autofocus changes the focal length,
and a rolling shutter takes the rows of a picture one after the other while the camera moves.
To first order the last is a stretch of the rows against the columns where the camera nods, a skew
where it turns and, where it rolls by w from row to row, p2 = -w with a shift of the principal point
by -3 fx w, because
    (-w y^2, w x y) = -w (3 x^2 + y^2, 2 x y) + 3 w (1 + x^2, x y) - (3 w, 0)
and the middle term is a turn of the camera. Where it is carried, what lies as far away as the rest
moves in the same ways: carried along its rows it is a skew, across them a stretch, and along its
axis by v it is a shift of the principal point by -fy v, because
    (v x y, v y^2) = v (x y, 1 + y^2) - (0, v)
and the first term is a turn again. So each fault is a few numbers that are added to the lens
parameters, and whatever takes a photo's `View` takes them along.
"""

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from jaxtyping import Float64, Int64
from scipy.sparse import csr_array, eye_array, hstack, vstack

from limbgram.core.geometry.lens import LENS_SIZE, PARAMETERS, POSE_SIZE, Camera
from limbgram.core.interval import chi_square_tail
from limbgram.reconstruction.mapping.scene import Deviation, OwnLenses, Scene

DEVIATIONS: tuple[Deviation, ...] = ("principal point", "focal length", "rolling shutter")
PRIOR_SPREAD = {"principal point": 0.03, "focal length": 0.02, "rolling shutter": 0.01}
"""Standard deviation of the parameters before the capture tells it: of the picture's width (a
stabiliser that turns the view by two degrees), of the focal length, and of pixels a row. More than
that is no fault of a single photo."""
FEWEST_PHOTOS = 6
"""Fewest photos that tell lenses of single photos: with fewer, poses absorb the deviations."""
_BOUND_LEVEL = 0.025
"""Significance level of a spread beyond its bound: one side of an interval of 95 %."""
_LEAST_SPREAD = 1e-4
"""Lower bound of a spread: a spread of zero would fix the parameters for good."""
_ROW = {name: k for k, name in enumerate(PARAMETERS)}


def parameter_count(deviation: Deviation) -> int:
    """Number of parameters of a kind of deviation."""
    match deviation:
        case "principal point":
            return 2
        case "focal length":
            return 1
        case "rolling shutter":
            return 4


def basis_of(deviations: Sequence[Deviation], camera: Camera) -> Float64[np.ndarray, "lens q"]:
    """Change of a photo's lens parameters by one unit of each parameter of its deviation.

    The principal point counts in widths of the picture, the focal length in parts of itself, rows
    in pixels a pixel.
    """
    columns: list[Float64[np.ndarray, " ten"]] = []
    for deviation in deviations:
        match deviation:
            case "principal point":
                columns += [_column(cx=camera.width_px), _column(cy=camera.width_px)]
            case "focal length":
                columns += [_column(fx=camera.fx, fy=camera.fy, skew=camera.skew)]
            case "rolling shutter":
                roll = _column(p2=1.0, cx=3.0 * camera.fx)
                carried = _column(cy=camera.fy)
                columns += [_column(fy=camera.fy), _column(skew=camera.fx), roll, carried]
    return np.array(columns).reshape(-1, LENS_SIZE).T


def _column(**parts: float) -> Float64[np.ndarray, " lens"]:
    """A vector of lens parameters, zero but for these."""
    column = np.zeros(LENS_SIZE)
    for name, part in parts.items():
        column[_ROW[name]] = part
    return column


def with_photo_lenses(scene: Scene) -> Scene:
    """The scene with a lens deviation in every photo, without parameters yet."""
    if scene.own is not None:
        return scene
    photos = len(scene.names)
    none = OwnLenses(
        deviations=(),
        values=np.zeros((photos, 0)),
        spread=np.zeros(0),
        shifts=np.zeros((photos, LENS_SIZE)),
        chances=(),
    )
    return replace(scene, own=none, camera_covariance=None)


def with_deviation(scene: Scene, deviation: Deviation, chance: float = 1.0) -> Scene:
    """The scene with one more kind of lens deviation, zero in all photos, to be solved for."""
    photos, more = len(scene.names), parameter_count(deviation)
    before = with_photo_lenses(scene).own
    assert before is not None
    own = OwnLenses(
        deviations=(*before.deviations, deviation),
        values=np.hstack([before.values, np.zeros((photos, more))]),
        spread=np.concatenate([before.spread, np.full(more, PRIOR_SPREAD[deviation])]),
        shifts=before.shifts,
        chances=(*before.chances, chance),
    )
    return replace(scene, own=own, camera_covariance=None)


def with_spread_of(scene: Scene, solved: Scene) -> Scene:
    """The scene with the spread of lens deviations that another solution ended with."""
    assert scene.own is not None
    assert solved.own is not None
    return replace(scene, own=replace(scene.own, spread=solved.own.spread))


def implausible_deviations(scene: Scene) -> tuple[Deviation, ...]:
    """Kinds of deviation whose spread is significantly larger than real cameras have.

    Few photos show a spread by chance that is half as large again as the true one.
    """
    own, first, photos = scene.own, 0, len(scene.placed)
    assert own is not None
    beyond: list[Deviation] = []
    for kind in own.deviations:
        numbers = slice(first, first + parameter_count(kind))
        first = numbers.stop
        widest = float(own.spread[numbers].max()) / PRIOR_SPREAD[kind]
        if chi_square_tail(photos * widest**2, photos) < _BOUND_LEVEL:
            beyond.append(kind)
    return tuple(beyond)


def largest_px(scene: Scene, kind: Deviation) -> float:
    """Largest shift of a pixel by a kind of deviation in any placed photo.

    Measured at the border of the photo where it grows outwards.
    """
    own = scene.own
    assert own is not None
    first = sum(parameter_count(one) for one in own.deviations[: own.deviations.index(kind)])
    values = own.values[np.array(scene.placed), first : first + parameter_count(kind)]
    sizes = np.array([(view.camera.width_px, view.camera.height_px) for view in scene.views], float)
    match kind:
        case "principal point":
            moves_px = np.linalg.norm(values, axis=1) * sizes[:, 0]
        case "focal length":
            moves_px = np.abs(values[:, 0]) * 0.5 * np.linalg.norm(sizes, axis=1)
        case "rolling shutter":
            moves_px = np.linalg.norm(values[:, :2], axis=1) * 0.5 * sizes[:, 1]
    return float(moves_px.max(initial=0.0))


@dataclass(frozen=True)
class PhotoLenses:
    """Parametrisation of the placed photos' lenses: the camera's lens plus a deviation of each."""

    camera_idx: Int64[np.ndarray, " p"]
    camera_lenses: Float64[np.ndarray, "c lens"]
    basis: Float64[np.ndarray, "c lens q"]
    """By camera: change of the lens by each parameter of a deviation."""
    values: Float64[np.ndarray, "p q"]
    """By photo, the parameters of its deviation."""
    spread: Float64[np.ndarray, " q"]
    fixed: Float64[np.ndarray, "p lens"]
    """Part of the photos' deviations that is not solved for."""

    @classmethod
    def of(cls, scene: Scene, cameras: Sequence[Camera], *, solve: bool) -> "PhotoLenses":
        """The parametrisation of a scene whose photos have lens deviations.

        Args:
            cameras: As calibrated; they scale the parameters.
            solve: Whether the deviations are solved for; otherwise they are fixed.
        """
        own, placed = scene.own, np.array(scene.placed)
        assert own is not None
        kinds = own.deviations if solve else ()
        camera_idx = np.array(scene.camera_idx, np.int64)[placed]
        basis = np.array([basis_of(kinds, one) for one in cameras])
        values = own.values[placed] if solve else np.zeros((len(placed), 0))
        moved = np.einsum("piq,pq->pi", basis[camera_idx], values)
        return cls(
            camera_idx=camera_idx,
            camera_lenses=np.array([one.packed for one in scene.cameras]),
            basis=basis,
            values=values,
            spread=own.spread if solve else np.zeros(0),
            fixed=own.shifts[placed] - moved,
        )

    @property
    def is_solved(self) -> bool:
        """Whether the deviations are solved for."""
        return self.values.shape[1] > 0

    @property
    def lenses(self) -> Float64[np.ndarray, "p lens"]:
        """Lens parameters of each photo."""
        own = np.einsum("piq,pq->pi", self.basis[self.camera_idx], self.values)
        return self.camera_lenses[self.camera_idx] + self.fixed + own

    @property
    def shifts(self) -> Float64[np.ndarray, "p lens"]:
        """Lens parameters of each photo less those of its camera."""
        return self.lenses - self.camera_lenses[self.camera_idx]

    @property
    def information(self) -> Float64[np.ndarray, " n"]:
        """Diagonal information of the zero-mean prior of the deviations."""
        return np.tile(1.0 / self.spread**2, len(self.values))

    @property
    def jacobian(self) -> csr_array:
        """Jacobian of poses and photos' lenses by poses, cameras' lenses and deviations."""
        photos = len(self.camera_idx)
        shared = csr_array(
            (
                np.ones(LENS_SIZE * photos),
                (
                    np.arange(LENS_SIZE * photos),
                    (LENS_SIZE * self.camera_idx[:, None] + np.arange(LENS_SIZE)).ravel(),
                ),
            ),
            shape=(LENS_SIZE * photos, self.camera_lenses.size),
        )
        size = self.values.shape[1]
        rows = np.repeat(np.arange(LENS_SIZE * photos), size)
        columns = size * (rows // LENS_SIZE) + np.tile(np.arange(size), LENS_SIZE * photos)
        own = csr_array(
            (self.basis[self.camera_idx].ravel(), (rows, columns)),
            shape=(LENS_SIZE * photos, size * photos),
        )
        poses = eye_array(POSE_SIZE * photos, format="csr")
        none = csr_array((POSE_SIZE * photos, self.camera_lenses.size + size * photos))
        below = csr_array((LENS_SIZE * photos, POSE_SIZE * photos))
        return csr_array(vstack([hstack([poses, none]), hstack([below, shared, own])]))

    def moved(self, lens_step: Float64[np.ndarray, " l"]) -> "PhotoLenses":
        """The lenses after a step of the cameras' lenses and of the deviations."""
        size = self.camera_lenses.size
        return replace(
            self,
            camera_lenses=self.camera_lenses + lens_step[:size].reshape(self.camera_lenses.shape),
            values=self.values + lens_step[size:].reshape(self.values.shape),
        )

    def with_estimated_spread(self, variance: Float64[np.ndarray, "p q"]) -> "PhotoLenses":
        """The lenses with the spread re-estimated from the deviations and their variances.

        One step of expectation and maximisation (Dempster, Laird, Rubin 1977).
        """
        spread = np.sqrt((self.values**2 + variance).mean(0))
        return replace(self, spread=np.maximum(spread, _LEAST_SPREAD))
