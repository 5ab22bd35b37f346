"""Limbs with exact landmarks, from shapes of others and from formulas, for `devices.py`.

In      the folder of captures with its shapes.
Out     limbs in their limb frames: feet with shanks and trunks cut out of four whole bodies,
        transtibial limbs of OpenLimbTT, transfemoral cones.
Method  The bodies have one topology: a landmark, chosen once by its vertex, lies at the same place
        of the body on all. Their 13,000 vertices are subdivided twice (Loop), the landmarks with
        them. OpenLimbTT's shapes have one order of triangles: a landmark chosen on the mean by a
        ray is the same triangle on all.
"""

import sys
from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import trimesh
from jaxtyping import Float64

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import face_components, with_faces
from limbgram.formats.reading import read_shape
from limbgram.formats.triangle_soup import sound_mesh
from limbgram.workbench.bodies import outer_bodies
from limbgram.workbench.devices.body import Body
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.spine import Spine
from limbgram.workbench.edits.toe_bridge import ToeBridge
from limbgram.workbench.limb import AlignedLimb, KindName, Landmark, Limb, LimbFrame, Side

sys.path.append(str(Path(__file__).parents[1]))
from tests.truth.anatomy.conftest import BODIES, FOOT, HEAD, TRUNK_MM

GAP = 0.1
"""Widest gap between toes that is closed, as a share of the foot's length."""
_TALL = {"adult_female": 0.92, "adult_male": 1.0, "baby": 0.34, "child": 0.72}
"""Heights of the bodies, as shares of the man's."""
_OPENLIMB = {
    "mean": "Full Size Mean_Skin_Shape",
    "long": "1p20",
    "short": "1m20",
    "bulbous": "102p",
    "conical": "102m",
}
"""OpenLimbTT's first two modes at two standard deviations."""
_STUMP_MM = {
    "mid patella": ((0, 0, 205), (0, -1, 0)),
    "patellar tendon": ((0, 0, 172), (0, -1, 0)),
    "distal end": ((0, 0, 20), (0, 0, 1)),
    "lateral femoral epicondyle": ((0, -5, 205), (-1, 0, 0)),
    "medial femoral epicondyle": ((0, -5, 205), (1, 0, 0)),
}
"""On the mean: a place of a line, and from where it is looked along."""
_THIGH_MM = {
    "anterior superior iliac spine": (30, 85, 330),
    "greater trochanter": (90, 0, 290),
    "ischial tuberosity": (-35, -80, 262),
    "adductor longus tendon": (-75, 40, 262),
    "perineum": (-90, 0, 258),
    "gluteal fold": (0, -85, 245),
    "distal end": (0, 0, 0),
}
_MIRROR = np.array([-1.0, 1.0, 1.0])


@dataclass(frozen=True)
class Subject:
    """A limb under a name; made when it is asked for."""

    name: str
    size: float
    """Of an adult man's."""
    make: Callable[[], Limb]


def ten_of(kind: KindName, data: Path) -> tuple[Subject, ...]:
    """Ten limbs of a kind."""
    makers = {"foot": _feet, "torso": _trunks, "transtibial": _stumps, "transfemoral": _thighs}
    return tuple(makers[kind](data / "shapes"))


def foot_of(whole: Mesh, side: Side = "right", size: float = 1.0) -> Limb:
    """The right foot of a body with its shank, open above the knee's condyles, toes apart."""
    knee = max(whole.vertices_mm[FOOT[one], 2] for one in ("fibula head", "medial tibial condyle"))
    top = knee + 0.04 * float(whole.vertices_mm[:, 2].max())
    high = top + 0.06 * float(whole.vertices_mm[:, 2].max())
    fine = _finer(whole, (whole.vertices_mm[:, 0] > -1.0) & (whole.vertices_mm[:, 2] < high), FOOT)
    mesh = keep_positive(fine.mesh, fine.mesh.vertices_mm[:, 0]).mesh
    mesh = _largest(keep_positive(mesh, top - mesh.vertices_mm[:, 2]).mesh)
    middle = 0.5 * (fine.places["medial malleolus"] + fine.places["lateral malleolus"])
    return _limb(mesh, fine.places, "foot", side, size, [*middle[:2], 0.0])


def trunk_of(whole: Mesh, man: Mesh, wide: float = 1.0, tall: float = 1.0) -> Limb:
    """The trunk of a body, open at neck, shoulders and thighs."""
    ids = {
        one: int(np.linalg.norm(man.vertices_mm - np.array(at, float), axis=1).argmin())
        for one, at in TRUNK_MM.items()
    }
    size = float(whole.vertices_mm[:, 2].max() / man.vertices_mm[:, 2].max())
    high = whole.vertices_mm[ids["seventh cervical vertebra"], 2] + 15 * size
    low = whole.vertices_mm[ids["pubic symphysis"], 2] - 25 * size
    beside = float(np.abs(whole.vertices_mm[ids["right axilla"], 0])) + 12 * size
    near = (whole.vertices_mm[:, 2] > low - 80 * size) & (whole.vertices_mm[:, 2] < high + 60)
    fine = _finer(whole, near & (np.abs(whole.vertices_mm[:, 0]) < beside + 100 * size), ids)
    mesh = keep_positive(fine.mesh, fine.mesh.vertices_mm[:, 2] - low).mesh
    mesh = keep_positive(mesh, high - mesh.vertices_mm[:, 2]).mesh
    belly = 0.5 * (fine.places["right waist"][2] + fine.places["right axilla"][2])
    for sign in (1, -1):
        aside = np.maximum(sign * mesh.vertices_mm[:, 0] - beside, 0)
        arm = (mesh.vertices_mm[:, 2] > belly) * aside  # a baby's belly is wider than its arms
        mesh = keep_positive(mesh, 0.5 - arm).mesh
    mesh = _largest(outer_bodies(Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces)).mesh)
    return _limb(mesh, fine.places, "torso", "none", np.array([wide, wide, tall]), [0, 0, 0])


def head_of(whole: Mesh) -> Limb:
    """The head of a body, open at the neck."""
    ear, top = (whole.vertices_mm[HEAD[one], 2] for one in ("right tragion", "vertex"))
    chin = float(ear - 0.8 * (top - ear))
    fine = _finer(whole, whole.vertices_mm[:, 2] > chin - 0.2 * (top - ear), HEAD)
    mesh = _largest(keep_positive(fine.mesh, fine.mesh.vertices_mm[:, 2] - chin).mesh)
    middle = 0.5 * (fine.places["right tragion"] + fine.places["left tragion"])
    return _limb(mesh, fine.places, "head", "none", 1.0, [*middle[:2], chin])


def body_of(data: Path, name: str) -> Mesh:
    return read_shape(data / "shapes" / "human" / f"{name}.ply", 1.0).limb.mesh


def _feet(shapes: Path) -> Iterator[Subject]:
    sizes = [(name, side, 1.0) for side in ("right", "left") for name in BODIES[::-1]]
    sizes += [("adult_female", "right", 1.12), ("child", "left", 1.2)]
    for name, side, size in sizes:

        def make(name: str = name, side: Side = side, size: float = size) -> Limb:
            limb = foot_of(body_of(shapes.parent, name), side, size)
            marks = {one.name: one.position_mm for one in limb.landmarks}
            length = float(np.linalg.norm(marks["second toe"] - marks["heel"]))
            return do_edit(limb, ToeBridge(gap_mm=GAP * length))

        named = f"{name}, {side}" + (f", x {size:g}" if size != 1 else "")
        yield Subject(named, size * _TALL[name], make)


def _trunks(shapes: Path) -> Iterator[Subject]:
    plain = [(name, 1.0, 1.0) for name in BODIES[::-1]]
    wider = [(name, 1.12, 0.95) for name in ("adult_female", "adult_male", "child")]
    for name, wide, tall in (*plain, *wider, ("child", 0.9, 1.1)):

        def make(name: str = name, wide: float = wide, tall: float = tall) -> Limb:
            man = body_of(shapes.parent, "adult_male")
            return trunk_of(body_of(shapes.parent, name), man, wide, tall)

        yield Subject(f"{name}, {wide:g} wide, {tall:g} tall", _TALL[name], make)
    for name in ("adult_female", "child"):

        def bent(name: str = name) -> Limb:
            limb = trunk_of(body_of(shapes.parent, name), body_of(shapes.parent, "adult_male"))
            marks = {one.name: one.position_mm[2] for one in limb.landmarks}
            waist = marks["right waist"] - marks["sacrum"]
            high = marks["xiphoid"] - marks["sacrum"]
            top = marks["sternal notch"] - marks["sacrum"]
            shape = Spine(
                heights_mm=(0.0, waist, high, top),
                right_mm=(0.0, 0.06 * high, 0.10 * high, 0.02 * high),
                turn_deg=(0.0, 4.0, 9.0, 6.0),
                above="sacrum",
            )
            return do_edit(limb, shape)

        yield Subject(f"{name}, shifted and turned", _TALL[name], bent)


def _stumps(shapes: Path) -> Iterator[Subject]:
    for name in _OPENLIMB:
        for side in ("right", "left"):

            def make(name: str = name, side: Side = side) -> Limb:
                return stump_of(shapes / "openlimb_TT", name, side)

            yield Subject(f"{name}, {side}", 1.0, make)


def stump_of(folder: Path, name: str, side: Side) -> Limb:
    mean = _soup(folder / f"{_OPENLIMB['mean']}.stl")
    unit = np.ptp(mean[..., 2]) / np.ptp(_soup(folder / "Mean_Skin_Shape.stl")[..., 2])
    soup = mean if name == "mean" else unit * _soup(folder / f"{_OPENLIMB[name]}.stl")[: len(mean)]
    low = mean.min((0, 1))[2]
    middle = mean[np.abs(mean[..., 2] + 20) < 10].mean(0)
    turn = np.array([-1.0, -1.0, 1.0])
    stood = turn * (mean - [middle[0], middle[1], low])
    welded = _welded(stood)
    body = Body(Limb(mesh=welded, kind="transtibial"))
    places: dict[str, np.ndarray] = {}
    for mark, (at, look) in _STUMP_MM.items():
        met = body.first_hit_mm(np.array(at, float), np.array(look, float))
        assert met is not None, mark
        face = int(np.linalg.norm(stood.mean(1) - met, axis=1).argmin())
        places[mark] = turn * soup[face].mean(0)
    bent = _largest(welded.with_vertices(_corners_at(welded.faces, turn * soup)))
    mesh = sound_mesh(bent, name).mesh  # as a file of it is read
    end = mesh.vertices_mm[:, 2].min()
    low_part = mesh.vertices_mm[np.abs(mesh.vertices_mm[:, 2] - end - 130) < 10].mean(0)
    return _limb(mesh, places, "transtibial", side, 1.0, [*low_part[:2], end])


def _corners_at(
    faces: np.ndarray, soup: Float64[np.ndarray, "f 3 3"]
) -> Float64[np.ndarray, "n 3"]:
    """Where most corners of each vertex lie: 27 triangles of the modes are laid otherwise."""
    order = np.argsort(faces.ravel(), kind="stable")
    starts = np.cumsum(np.bincount(faces.ravel()))[:-1]
    return np.stack([np.median(one, 0) for one in np.split(soup.reshape(-1, 3)[order], starts)])


def _soup(path: Path) -> Float64[np.ndarray, "f 3 3"]:
    read = trimesh.load(path, process=False)
    return np.array(read.triangles, np.float64)


def _welded(soup: Float64[np.ndarray, "f 3 3"]) -> Mesh:
    """Triangles whose corners at one place, to a ten-thousandth of a millimetre, are one."""
    places, numbers = np.unique(np.round(soup.reshape(-1, 3), 4), axis=0, return_inverse=True)
    faces = numbers.reshape(-1, 3).astype(np.int32)
    whole = (faces != np.roll(faces, 1, axis=1)).all(1)
    return Mesh(vertices_mm=places, faces=faces[whole])


def _thighs(_: Path) -> Iterator[Subject]:
    for size in (0.85, 0.92, 1.0, 1.08, 1.15):
        for side in ("right", "left"):

            def make(size: float = size, side: Side = side) -> Limb:
                return _thigh(size, side)

            yield Subject(f"cone x {size:g}, {side}", size, make)


def _thigh(size: float, side: Side) -> Limb:
    """A cone with a round end, 380 mm long, 0.95 as deep as wide, open at the top."""
    around = 2 * np.pi * np.arange(180) / 180
    dome = np.linspace(-0.5 * np.pi, 0.0, 40)[1:]
    tube = np.linspace(0.0, 325.0, 110)[1:]
    radii = np.concatenate([55 * np.cos(dome), 55 + 45 * tube / 365])
    heights = np.concatenate([55 + 55 * np.sin(dome), 55 + tube])
    rings = np.stack(
        [
            np.outer(radii, np.cos(around)),
            0.95 * np.outer(radii, np.sin(around)),
            np.repeat(heights[:, None], len(around), 1),
        ],
        -1,
    )
    vertices = np.concatenate([np.zeros((1, 3)), rings.reshape(-1, 3)])
    ids = 1 + np.arange(rings[..., 0].size).reshape(rings.shape[:2])
    after = np.roll(ids, -1, axis=1)
    fan = np.stack([np.zeros_like(ids[0]), after[0], ids[0]], -1)
    one = np.stack([ids[:-1], after[:-1], after[1:]], -1).reshape(-1, 3)
    two = np.stack([ids[:-1], after[1:], ids[1:]], -1).reshape(-1, 3)
    mesh = Mesh(vertices_mm=vertices, faces=np.concatenate([fan, one, two]).astype(np.int32))
    places = {
        name: vertices[np.linalg.norm(vertices - np.array(at, float), axis=1).argmin()]
        for name, at in _THIGH_MM.items()
    }
    return _limb(mesh, places, "transfemoral", side, size, [0, 0, 0])


@dataclass(frozen=True)
class _Fine:
    mesh: Mesh
    places: Mapping[str, np.ndarray]


def _finer(whole: Mesh, near: np.ndarray, ids: Mapping[str, int]) -> _Fine:
    """A part of a body, subdivided twice; and where some of its vertices lie then."""
    faces = whole.faces[near[whole.faces].all(1)]
    used = np.unique(faces)
    numbers = np.full(len(whole), -1)
    numbers[used] = np.arange(len(used))
    coarse = trimesh.Trimesh(whole.vertices_mm[used], numbers[faces], process=False)
    fine = coarse.subdivide_loop(2)
    vertices = np.array(fine.vertices, np.float64)
    moved = np.linalg.norm(vertices[: len(used)] - whole.vertices_mm[used], axis=1)
    assert np.median(moved) < 2.0  # the old vertices come first
    places = {one: vertices[numbers[k]].copy() for one, k in ids.items() if numbers[k] >= 0}
    return _Fine(Mesh(vertices_mm=vertices, faces=fine.faces.astype(np.int32)), places)


def _largest(mesh: Mesh) -> Mesh:
    pieces = face_components(mesh.faces)
    return with_faces(mesh, mesh.faces[pieces == np.bincount(pieces).argmax()])


def _limb(
    mesh: Mesh,
    places: Mapping[str, np.ndarray],
    kind: KindName,
    side: Side,
    size: float | np.ndarray,
    origin: list[float],
) -> Limb:
    """In its limb frame; a left one is the right one mirrored."""
    turn = np.multiply(size, _MIRROR if side == "left" else np.ones(3))
    faces = mesh.faces[:, ::-1].copy() if side == "left" else mesh.faces
    start = np.array(origin, float)
    return AlignedLimb(
        mesh=Mesh(vertices_mm=(mesh.vertices_mm - start) * turn, faces=faces),
        landmarks=tuple(
            Landmark(name=name, position_mm=(at - start) * turn) for name, at in places.items()
        ),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side=side),
        kind=kind,
    )
