"""Visits: pairs of scans of one limb, with where the skin at each landmark went in between.

In      the folder of captures with its shapes; a random generator for each pair.
Out     a marked scan, a later one without landmarks and axes, and the truth.
Method  Feet with shanks, trunks and heads of four whole bodies, residual limbs of OpenLimbTT and of
        ampscan, and the program's own ones. A pair is one surface: the later one lost 0 to 4 % of
        its width towards its centreline (a head grew), lost or gained up to 5 mm at one place of
        its kind and up to 3 mm at another one anywhere (of an adult; a child less by its size), has
        its joints turned by a few degrees, is cut elsewhere, has up to three holes, open or filled,
        and lies as it may. Both have noise of 0.1 to 0.4 mm, a part of it white, the rest in waves
        of 15 to 60 mm. Both have the same triangles before holes and cut.
"""

from collections.abc import Callable, Iterator, Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Final, Literal

import numpy as np
from jaxtyping import Bool, Float64

from limbgram.core.geometry.arrays import Points3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import with_faces
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.formats.reading import read_shape
from limbgram.synthetic.props.limb import LimbKind, make_limb
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.repose import Repose
from limbgram.workbench.edits.spine import Spine
from limbgram.workbench.limb import AlignedLimb, KindName, Landmark, Limb, LimbFrame
from limbs import body_of, foot_of, head_of, stump_of, trunk_of

Half = Literal["choose", "report"]
_GONE_MM = 3.0
"""Surface that was measured ends so far before the place of a landmark that is gone."""


MAN_MM = {"foot": 400.0, "torso": 780.0, "head": 380.0, "transtibial": 330.0, "transfemoral": 380.0}
"""Root of the surface's area of an adult man: by it changes of shape are scaled."""
_STUMP: Final[Mapping[str, tuple[float, float]]] = {
    "mid patella": (0, 0.93),
    "patellar tendon": (0, 0.80),
    "tibial tubercle": (0, 0.70),
    "fibula head": (105, 0.72),
    "medial tibial flare": (-65, 0.70),
    "popliteal crease": (180, 0.78),
    "tibial crest": (0, 0.45),
    "calf": (180, 0.45),
    "tibia end": (0, 0.18),
}
_THIGH: Final[Mapping[str, tuple[float, float]]] = {
    "ischial tuberosity": (-150, 0.88),
    "adductor longus tendon": (-75, 0.85),
    "gluteal fold": (180, 0.80),
    "front of the thigh": (0, 0.55),
    "side of the thigh": (95, 0.5),
    "back of the thigh": (180, 0.4),
    "end of the femur": (100, 0.15),
}
"""Places of residual limbs: degrees from anterior towards lateral, and share of the height. They
stand for what lies about there."""
_OPENLIMB = ("mean", "long", "short", "bulbous", "conical")
_WASTING: Final = {
    "foot": "tibial crest",
    "torso": "navel",
    "head": "opisthocranion",
    "transtibial": "calf",
    "transfemoral": "back of the thigh",
}
"""Where each kind loses or gains; of a foot on the other side of the shank, at the calf."""


@dataclass(frozen=True)
class Subject:
    """A limb under a name; made when it is asked for, in its limb frame."""

    name: str
    kind: KindName
    make: Callable[[], Limb]


@dataclass(frozen=True)
class Visits:
    """A marked scan and a later one, with where its landmarks went."""

    marked: Limb
    today: Limb
    places_mm: dict[str, np.ndarray]
    """On the later surface without noise, in its frame; of all landmarks."""
    normals: dict[str, np.ndarray]
    gone: frozenset[str]
    """Landmarks that the later scan does not hold: cut off, or in a hole."""
    changes: dict[str, float]


def subjects_of(kind: KindName, data: Path, half: Half) -> list[Subject]:
    """Every other limb of a kind."""
    every = list(_SUBJECTS[kind](kind, data))
    return every[half == "report" :: 2]


def _of_bodies(kind: KindName, data: Path) -> Iterator[Subject]:
    for name in ("adult_male", "adult_female", "child", "baby"):

        def make(name: str = name) -> Limb:
            body = body_of(data, name)
            if kind == "foot":
                return foot_of(body)
            if kind == "torso":
                return trunk_of(body, body_of(data, "adult_male"))
            return head_of(body)

        yield Subject(name, kind, make)


def _of_stumps(kind: KindName, data: Path) -> Iterator[Subject]:
    own = [(LimbKind.TRANSTIBIAL, seed) for seed in (11, 12, 13)] + [
        (LimbKind.BULBOUS, seed) for seed in (14, 15, 16)
    ]
    scans = ["stl_file", "stl_file_2"]
    for name in _OPENLIMB:
        yield Subject(f"OpenLimbTT, {name}", kind, lambda name=name: _openlimb(data, name))
        if scans:
            path = data / "shapes" / "ampscan" / f"{scans.pop(0)}.stl"
            yield Subject(f"ampscan, {path.stem}", kind, lambda path=path: _scanned(path))
        which, seed = own.pop(0)
        yield _own(kind, which, seed, _STUMP)
        which, seed = own.pop(-1)
        yield _own(kind, which, seed, _STUMP)
        if not own:
            return


def _of_thighs(kind: KindName, _: Path) -> Iterator[Subject]:
    for seed in range(21, 29):
        yield _own(kind, LimbKind.TRANSFEMORAL, seed, _THIGH)


_SUBJECTS: Final[dict[KindName, Callable[[KindName, Path], Iterator[Subject]]]] = {
    "foot": _of_bodies,
    "torso": _of_bodies,
    "head": _of_bodies,
    "transtibial": _of_stumps,
    "transfemoral": _of_thighs,
}


def _own(
    kind: KindName, which: LimbKind, seed: int, places: Mapping[str, tuple[float, float]]
) -> Subject:
    def make() -> Limb:
        made = make_limb(which, seed, 2.5, 0.0)
        mesh = with_faces(made.mesh, made.mesh.faces[~made.cut[made.mesh.faces].any(1)])
        ahead = made.anterior_rad - np.pi / 2
        turn = Rigid.from_rotation_vector(np.array([0.0, 0.0, -ahead]), np.zeros(3)).rotation
        flip = np.diag([-1.0, 1.0, -1.0])  # the distal end, which stood up, hangs down
        mesh = Mesh(vertices_mm=mesh.vertices_mm @ (flip @ turn).T, faces=mesh.faces)
        return _marked(mesh, kind, made.side, places)

    return Subject(f"own {which.value}, {seed}", kind, make)


def _openlimb(data: Path, name: str) -> Limb:
    limb = stump_of(data / "shapes" / "openlimb_TT", name, "right")
    more = _marked(limb.mesh, "transtibial", "right", _STUMP).landmarks
    known = {one.name for one in limb.landmarks}
    return replace(
        limb, landmarks=(*limb.landmarks, *(one for one in more if one.name not in known))
    )


def _scanned(path: Path) -> Limb:
    """A scan of a residual limb, its long axis upright, its open end up."""
    mesh = read_shape(path, 1.0).limb.mesh
    points = mesh.vertices_mm - mesh.vertices_mm.mean(0)
    axes = np.linalg.svd(points[:: max(len(points) // 5000, 1)], full_matrices=False)[2]
    turn = axes[[1, 2, 0]] * np.array([[1.0], [1.0], [np.sign(np.linalg.det(axes[[1, 2, 0]]))]])
    points = points @ turn.T
    ends = [np.ptp(points[np.abs(points[:, 2] - z) < 10, :2], axis=0).sum()
            for z in (points[:, 2].min(), points[:, 2].max())]  # fmt: skip
    if ends[0] > ends[1]:
        points = points * np.array([-1.0, 1.0, -1.0])
    return _marked(Mesh(vertices_mm=points, faces=mesh.faces), "transtibial", "right", _STUMP)


def _marked(
    mesh: Mesh,
    kind: KindName,
    side: Literal["left", "right"],
    places: Mapping[str, tuple[float, float]],
) -> Limb:
    """With landmarks at angles and heights, in the axes of the shape."""
    points = mesh.vertices_mm
    low, high = points[:, 2].min(), points[:, 2].max()
    lateral = 1.0 if side == "right" else -1.0
    marks: list[Landmark] = []
    for name, (angle_deg, share) in places.items():
        z = low + share * (high - low)
        ring = points[np.abs(points[:, 2] - z) < 10.0]
        away = points[:, :2] - 0.5 * (ring[:, :2].min(0) + ring[:, :2].max(0))
        angles = np.degrees(np.arctan2(lateral * away[:, 0], away[:, 1]))
        off_deg = np.abs((angles - angle_deg + 180) % 360 - 180)
        at = points[np.argmin(off_deg + np.abs(points[:, 2] - z))]
        marks.append(Landmark(name=name, position_mm=at.copy()))
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side=side)
    return AlignedLimb(mesh=mesh, landmarks=tuple(marks), frame=frame, kind=kind)


def visits(subject: Subject, rng: np.random.Generator) -> Visits:
    """A marked scan of a limb and a later one."""
    base = subject.make()
    size_mm = float(np.sqrt(base.mesh.area_mm2()))
    scale = size_mm / MAN_MM[subject.kind]
    at = tree_on(base.mesh).closest(np.stack([one.position_mm for one in base.landmarks]))
    corners, shares = base.mesh.faces[at.faces], _shares(base.mesh, at.faces, at.points_mm)
    names = [one.name for one in base.landmarks]

    def on(points: Points3) -> Points3:
        """Where the skin at the landmarks lies on other vertices."""
        return np.einsum("nk,nkc->nc", shares, points[corners])

    noisy = _noise(base.mesh, base.mesh.vertices_mm, rng)
    marked = replace(
        base,
        mesh=base.mesh.with_vertices(noisy),
        landmarks=tuple(
            Landmark(name=name, position_mm=place, sigma_mm=0.0)
            for name, place in zip(names, on(noisy), strict=True)
        ),
        name="before.ply",
    )
    turned, changes = _turned(base, rng)
    points = _thinner(turned, float(rng.uniform(0.0, 0.04)), changes, rng)
    points = _swollen(base, points, scale, changes, rng)
    truth = base.mesh.with_vertices(points)
    normals = truth.vertex_normals()[corners].sum(1)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    scan = base.mesh.with_vertices(_noise(base.mesh, points, rng))
    scan, kept = _cut(scan, subject.kind, changes, rng)
    scan, left = _holed(scan, size_mm, changes, rng)
    places = on(points)
    away_mm = tree_on(with_faces(scan, scan.faces[_measured_faces(scan, left)])).closest(places)
    gone = away_mm.distances_mm > _GONE_MM
    pose = Rigid.from_rotation_vector(rng.normal(0.0, 1.5, 3), rng.uniform(-300.0, 300.0, 3))
    today = Limb(mesh=scan.moved(pose), kind=subject.kind, name="today.ply")
    return Visits(
        marked=marked,
        today=today,
        places_mm=dict(zip(names, pose.apply(places), strict=True)),
        normals=dict(zip(names, normals @ pose.rotation.T, strict=True)),
        gone=frozenset(name for name, one in zip(names, gone, strict=True) if one),
        changes=changes | {"size_mm": size_mm, "kept": float(kept)},
    )


def _measured_faces(mesh: Mesh, filled: Bool[np.ndarray, " n"]) -> Bool[np.ndarray, " f"]:
    """Those that were measured."""
    return np.asarray(~filled[mesh.faces].any(1))


def _shares(mesh: Mesh, faces: np.ndarray, places: Points3) -> Float64[np.ndarray, "n 3"]:
    """Barycentric, of places in their triangles."""
    one, two, three = np.moveaxis(mesh.vertices_mm[mesh.faces[faces]], 1, 0)
    whole = np.cross(two - one, three - one)
    square = np.sum(whole * whole, axis=1)
    second = np.sum(np.cross(places - one, three - one) * whole, axis=1) / square
    third = np.sum(np.cross(two - one, places - one) * whole, axis=1) / square
    return np.stack([1 - second - third, second, third], axis=1)


def _noise(mesh: Mesh, points: Points3, rng: np.random.Generator) -> Points3:
    """Along the normals, 0.1 to 0.4 mm RMS: white, and waves of 15 to 60 mm."""
    rms_mm, white = rng.uniform(0.1, 0.4), rng.uniform(0.2, 0.8)
    count = 200
    ways = rng.normal(0.0, 1.0, (count, 3))
    ways *= (2 * np.pi / rng.uniform(15.0, 60.0, count) / np.linalg.norm(ways, axis=1))[:, None]
    waves = np.cos(points @ ways.T + rng.uniform(0, 2 * np.pi, count)).sum(1) * np.sqrt(2 / count)
    own = rng.normal(0.0, 1.0, len(points))
    height = rms_mm * (np.sqrt(white) * own + np.sqrt(1 - white) * waves)
    return points + height[:, None] * mesh.with_vertices(points).vertex_normals()


def _turned(limb: Limb, rng: np.random.Generator) -> tuple[Limb, dict[str, float]]:
    """Joints held otherwise, by a few degrees."""
    changes: dict[str, float] = {}
    if limb.kind == "foot":
        for joint, most_deg in (("ankle", 6.0), ("hindfoot", 3.0), ("toes", 5.0)):
            by_deg = float(rng.uniform(-most_deg, most_deg))
            limb = do_edit(limb, Repose(joint=joint, by_deg=by_deg))
            changes[f"{joint}_deg"] = by_deg
    elif limb.kind == "torso":
        for joint in ("side bend", "extension"):
            by_deg = float(rng.uniform(-4.0, 4.0))
            limb = do_edit(limb, Repose(joint=joint, by_deg=by_deg, band_mm=60.0))
            changes[f"{joint}_deg"] = by_deg
        marks = {one.name: one.position_mm[2] for one in limb.landmarks}
        heights = [marks[one] - marks["sacrum"] for one in ("right waist", "xiphoid")]
        turn_deg = float(rng.uniform(-4.0, 4.0))
        spine = Spine(
            heights_mm=(0.0, *heights),
            turn_deg=(0.0, 0.5 * turn_deg, turn_deg),
            above="sacrum",
        )
        limb = do_edit(limb, spine)
        changes["rotation_deg"] = turn_deg
    elif limb.kind == "transtibial":
        by_deg = float(rng.uniform(-4.0, 4.0))
        limb = limb.with_mesh(limb.mesh.with_vertices(_bent(limb.mesh.vertices_mm, by_deg)))
        changes["knee_deg"] = by_deg
    return limb, changes


def _bent(points: Points3, by_deg: float) -> Points3:
    """What lies below the knee turned about it, over a band of two fifths of the height."""
    low, high = points[:, 2].min(), points[:, 2].max()
    middle = np.array([0.0, points[:, 1].mean(), low + 0.8 * (high - low)])
    share = np.clip((middle[2] - points[:, 2]) / (0.2 * (high - low)) * 0.5 + 0.5, 0, 1)
    angles = np.radians(by_deg) * share**2 * (3 - 2 * share)
    away = points - middle
    cosine, sine = np.cos(angles), np.sin(angles)
    turned = [away[:, 0], cosine * away[:, 1] - sine * away[:, 2],
              sine * away[:, 1] + cosine * away[:, 2]]  # fmt: skip
    return middle + np.stack(turned, axis=1)


def _thinner(
    limb: Limb, share: float, changes: dict[str, float], rng: np.random.Generator
) -> Points3:
    """Vertices nearer to the centreline by a share; a head has grown by it, not evenly."""
    points = limb.mesh.vertices_mm
    if limb.kind == "head":
        changes["growth"] = share
        return points * (1 + share + rng.uniform(-0.005, 0.005, 3))
    changes["loss"] = share
    if limb.kind != "foot":
        heights = np.linspace(points[:, 2].min(), points[:, 2].max(), 60)
        weight = np.exp(-(((points[:, 2] - heights[:, None]) / 25.0) ** 2))
        middles = np.stack([weight @ points[:, k] / weight.sum(1) for k in (0, 1)], axis=1)
        line = np.stack([np.interp(points[:, 2], heights, middles[:, k]) for k in (0, 1)], axis=1)
        flat = line + (1 - share) * (points[:, :2] - line)
        return np.column_stack([flat, points[:, 2]])
    line = limb.centreline()
    stops = np.linspace(0.0, line.length_mm, 200)
    middles = np.stack([line.at(one).point_mm for one in stops])
    found = np.empty_like(points)
    for start in range(0, len(points), 4000):
        own = points[start : start + 4000]
        apart = np.linalg.norm(own[:, None] - middles[None], axis=2)
        near = np.exp(-(apart - apart.min(1, keepdims=True)) / 5.0)
        middle = near / near.sum(1, keepdims=True) @ middles
        found[start : start + 4000] = own + share * (middle - own)
    return found


def _swollen(
    base: Limb,
    points: Points3,
    scale: float,
    changes: dict[str, float],
    rng: np.random.Generator,
) -> Points3:
    """Volume lost or gained at a place of the kind and at another one, along the normals."""
    size_mm = float(np.sqrt(base.mesh.area_mm2()))
    assert base.kind is not None
    spot = base.landmark(_WASTING[base.kind]).position_mm
    if base.kind == "foot":
        level = np.abs(base.mesh.vertices_mm[:, 2] - spot[2]) < 0.03 * size_mm
        rear = np.where(level, base.mesh.vertices_mm[:, 1], np.inf).argmin()
        spot = base.mesh.vertices_mm[rear]
    other = base.mesh.vertices_mm[rng.integers(len(base.mesh))]
    mesh = base.mesh.with_vertices(points)
    height = np.zeros(len(points))
    most = {"place": (spot, -5.0, 1.0), "elsewhere": (other, -3.0, 3.0)}
    for name, (middle, low_mm, high_mm) in most.items():
        by_mm = scale * float(rng.uniform(low_mm, high_mm))
        reach_mm = size_mm * float(rng.uniform(0.06, 0.14))
        away = np.linalg.norm(base.mesh.vertices_mm - middle, axis=1) / reach_mm
        height += by_mm * np.exp(-(away**2))
        changes[f"{name}_mm"] = by_mm
    return points + height[:, None] * mesh.vertex_normals()


def _cut(
    mesh: Mesh, kind: KindName, changes: dict[str, float], rng: np.random.Generator
) -> tuple[Mesh, float]:
    """Without up to a tenth of its height at the open end, aslant; of a head at the lower one."""
    z = mesh.vertices_mm[:, 2]
    share = float(rng.uniform(0.0, 0.1))
    changes["cut"] = share
    slope = rng.uniform(-0.1, 0.1, 2)
    tilt = (mesh.vertices_mm[:, :2] - mesh.vertices_mm[:, :2].mean(0)) @ slope
    if kind == "head":
        level = z - tilt - (z.min() + share * np.ptp(z))
    else:
        level = (z.max() - share * np.ptp(z)) - z + tilt
    kept = keep_positive(mesh, level).mesh
    return kept, float(kept.area_mm2() / mesh.area_mm2())


def _holed(
    mesh: Mesh, size_mm: float, changes: dict[str, float], rng: np.random.Generator
) -> tuple[Mesh, Bool[np.ndarray, " n"]]:
    """Up to three holes, each left open or filled as it was; and which vertices are filled."""
    count = int(rng.integers(0, 4))
    changes["holes"] = count
    filled, open_ = np.zeros(len(mesh), bool), np.zeros(len(mesh), bool)
    for _ in range(count):
        middle = mesh.vertices_mm[rng.integers(len(mesh))]
        inside = np.linalg.norm(mesh.vertices_mm - middle, axis=1) < size_mm * rng.uniform(
            0.02, 0.06
        )
        if rng.random() < 0.5:
            filled |= inside
        else:
            open_ |= inside
    mesh = replace(mesh, filled=filled)
    cut = with_faces(mesh, mesh.faces[~open_[mesh.faces].any(1)])
    assert cut.filled is not None
    return cut, cut.filled
