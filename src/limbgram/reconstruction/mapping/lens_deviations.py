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
WIDE = {"principal point": 0.01, "focal length": 0.02, "rolling shutter": 0.01}
"""Standard deviation of the numbers before the capture tells it: of the picture's width, of the
focal length, and of pixels a row. More than that is no fault of a single photo."""
FEWEST_PHOTOS = 6
"""Fewer tell nothing of lenses of single photos: every photo's numbers are a part of its pose."""
_SURELY = 0.025
"""Chance that a spread within bounds looks wider: that of one side of an interval of 95 %."""
_LEAST_SPREAD = 1e-4
"""In parts of the same: a spread of nothing would hold the numbers."""
_ROW = {name: k for k, name in enumerate(PARAMETERS)}


def numbers_of(deviation: Deviation) -> int:
    """How many numbers a photo has of a kind."""
    match deviation:
        case "principal point":
            return 2
        case "focal length":
            return 1
        case "rolling shutter":
            return 4


def basis_of(deviations: Sequence[Deviation], camera: Camera) -> Float64[np.ndarray, "lens q"]:
    """What one unit of each number adds to the lens parameters of a photo.

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
    column = np.zeros(LENS_SIZE)
    for name, part in parts.items():
        column[_ROW[name]] = part
    return column


def with_own(scene: Scene) -> Scene:
    """The scene with lenses of their own that do not differ from the cameras' yet."""
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


def with_room_for(scene: Scene, deviation: Deviation, chance: float = 1.0) -> Scene:
    """The scene with numbers of one more kind, all nought, to be solved for."""
    photos, more = len(scene.names), numbers_of(deviation)
    before = with_own(scene).own
    assert before is not None
    own = OwnLenses(
        deviations=(*before.deviations, deviation),
        values=np.hstack([before.values, np.zeros((photos, more))]),
        spread=np.concatenate([before.spread, np.full(more, WIDE[deviation])]),
        shifts=before.shifts,
        chances=(*before.chances, chance),
    )
    return replace(scene, own=own, camera_covariance=None)


def with_spread_of(scene: Scene, solved: Scene) -> Scene:
    """The scene with the spread that another solution of its own numbers ended with."""
    assert scene.own is not None
    assert solved.own is not None
    return replace(scene, own=replace(scene.own, spread=solved.own.spread))


def beyond_cameras(scene: Scene) -> tuple[Deviation, ...]:
    """Kinds in which lenses of single photos surely differ by more than those of real cameras can.

    Few photos show a spread by chance that is half as large again as the true one.
    """
    own, first, photos = scene.own, 0, len(scene.placed)
    assert own is not None
    beyond: list[Deviation] = []
    for kind in own.deviations:
        numbers = slice(first, first + numbers_of(kind))
        first = numbers.stop
        widest = float(own.spread[numbers].max()) / WIDE[kind]
        if chi_square_tail(photos * widest**2, photos) < _SURELY:
            beyond.append(kind)
    return tuple(beyond)


def largest_px(scene: Scene, kind: Deviation) -> float:
    """Most that a kind moves a pixel of any placed photo, at the border where it grows outwards."""
    own = scene.own
    assert own is not None
    first = sum(numbers_of(one) for one in own.deviations[: own.deviations.index(kind)])
    values = own.values[np.array(scene.placed), first : first + numbers_of(kind)]
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
class Ties:
    """How the lenses of placed photos hang together: the camera's, and their own numbers."""

    camera: Int64[np.ndarray, " p"]
    shared: Float64[np.ndarray, "c lens"]
    basis: Float64[np.ndarray, "c lens q"]
    values: Float64[np.ndarray, "p q"]
    spread: Float64[np.ndarray, " q"]
    held: Float64[np.ndarray, "p lens"]
    """Part of the photos' own shifts that is not solved for."""

    @classmethod
    def of(cls, scene: Scene, cameras: Sequence[Camera], *, solve: bool) -> "Ties":
        """Of a scene whose photos have lenses of their own.

        Args:
            cameras: As calibrated: the numbers count by them.
            solve: Whether the own numbers are solved for; otherwise they are held.
        """
        own, placed = scene.own, np.array(scene.placed)
        assert own is not None
        kinds = own.deviations if solve else ()
        camera = np.array(scene.camera_idx, np.int64)[placed]
        basis = np.array([basis_of(kinds, one) for one in cameras])
        values = own.values[placed] if solve else np.zeros((len(placed), 0))
        moved = np.einsum("piq,pq->pi", basis[camera], values)
        return cls(
            camera=camera,
            shared=np.array([one.packed for one in scene.cameras]),
            basis=basis,
            values=values,
            spread=own.spread if solve else np.zeros(0),
            held=own.shifts[placed] - moved,
        )

    @property
    def solved(self) -> bool:
        """Whether own numbers are solved for."""
        return self.values.shape[1] > 0

    @property
    def lenses(self) -> Float64[np.ndarray, "p lens"]:
        own = np.einsum("piq,pq->pi", self.basis[self.camera], self.values)
        return self.shared[self.camera] + self.held + own

    @property
    def shifts(self) -> Float64[np.ndarray, "p lens"]:
        return self.lenses - self.shared[self.camera]

    @property
    def information(self) -> Float64[np.ndarray, " n"]:
        """Of the photos' own numbers, whose prior is nought give or take their spread."""
        return np.tile(1.0 / self.spread**2, len(self.values))

    @property
    def map(self) -> csr_array:
        """From poses, cameras' lenses and own numbers to poses and photos' lenses."""
        photos = len(self.camera)
        shared = csr_array(
            (
                np.ones(LENS_SIZE * photos),
                (
                    np.arange(LENS_SIZE * photos),
                    (LENS_SIZE * self.camera[:, None] + np.arange(LENS_SIZE)).ravel(),
                ),
            ),
            shape=(LENS_SIZE * photos, self.shared.size),
        )
        size = self.values.shape[1]
        rows = np.repeat(np.arange(LENS_SIZE * photos), size)
        columns = size * (rows // LENS_SIZE) + np.tile(np.arange(size), LENS_SIZE * photos)
        own = csr_array(
            (self.basis[self.camera].ravel(), (rows, columns)),
            shape=(LENS_SIZE * photos, size * photos),
        )
        poses = eye_array(POSE_SIZE * photos, format="csr")
        none = csr_array((POSE_SIZE * photos, self.shared.size + size * photos))
        below = csr_array((LENS_SIZE * photos, POSE_SIZE * photos))
        return csr_array(vstack([hstack([poses, none]), hstack([below, shared, own])]))

    def moved(self, lens_step: Float64[np.ndarray, " l"]) -> "Ties":
        """After a step of the cameras' lenses and of the own numbers."""
        size = self.shared.size
        return replace(
            self,
            shared=self.shared + lens_step[:size].reshape(self.shared.shape),
            values=self.values + lens_step[size:].reshape(self.values.shape),
        )

    def respread(self, variance: Float64[np.ndarray, "p q"]) -> "Ties":
        """With the spread that the capture shows: of the values and of what is open of them.

        One step of expectation and maximisation (Dempster, Laird, Rubin 1977).
        """
        spread = np.sqrt((self.values**2 + variance).mean(0))
        return replace(self, spread=np.maximum(spread, _LEAST_SPREAD))
