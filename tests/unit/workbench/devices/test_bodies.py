"""Devices on bodies from elsewhere: a foot cut out of a whole body, and a mean residual limb."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import trimesh

from limbgram.core.errors import EditError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import face_components, with_faces
from limbgram.workbench.devices.body import Body
from limbgram.workbench.devices.making import Order, make_device
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.limb import AlignedLimb, Kind, Landmark, Limb, LimbFrame

Hit = tuple[float, float, float, str]
"""x, y and z of a line, and from where it is looked along."""
_LOOKS = {"lateral": (-1, 0, 0), "medial": (1, 0, 0), "front": (0, -1, 0), "back": (0, 1, 0)}


def marked(mesh: Mesh, kind: Kind, places: dict[str, Hit]) -> Limb:
    frame = LimbFrame(limb_from_mesh=Rigid.identity(), side="right")
    body = Body(AlignedLimb(mesh=mesh, kind=kind, frame=frame))
    marks: list[Landmark] = []
    for name, (x, y, z, seen) in places.items():
        met = body.first_hit_mm(
            np.array([x, y, z], float), np.array(_LOOKS.get(seen, (0, 0, 1)), float)
        )
        assert met is not None, name
        marks.append(Landmark(name=name, position_mm=met))
    return AlignedLimb(mesh=mesh, kind=kind, frame=frame, landmarks=tuple(marks))


def foot_of(path: Path) -> Limb:
    """The right foot and shank of a body that stands, faces +Y, 285 thousandths of its height."""
    whole = trimesh.load(path, process=True)
    top = 0.285 * float(whole.vertices[:, 2].max())
    mesh = Mesh(vertices_mm=np.array(whole.vertices, float), faces=whole.faces.astype(np.int32))
    near = (mesh.vertices_mm[:, 0] > 0) & (mesh.vertices_mm[:, 2] < top + 60)
    part = with_faces(mesh, mesh.faces[near[mesh.faces].all(1)])
    fine = trimesh.Trimesh(part.vertices_mm, part.faces, process=False).subdivide_loop(2)
    mesh = Mesh(vertices_mm=np.array(fine.vertices, float), faces=fine.faces.astype(np.int32))
    mesh = keep_positive(mesh, top - mesh.vertices_mm[:, 2]).mesh
    pieces = face_components(mesh.faces)
    mesh = with_faces(mesh, mesh.faces[pieces == np.bincount(pieces).argmax()])
    shank = mesh.vertices_mm[np.abs(mesh.vertices_mm[:, 2] - 0.3 * top) < 0.02 * top].mean(0)
    mesh = mesh.with_vertices(mesh.vertices_mm - [*shank[:2], 0.0])
    low = mesh.vertices_mm[mesh.vertices_mm[:, 2] < 0.1 * top]
    heel, toe = float(low[:, 1].min()), low[np.argmax(low[:, 1])]
    length = float(toe[1]) - heel
    behind = float(low[low[:, 1] < heel + 10][:, 0].mean())
    return marked(
        mesh,
        "foot",
        {
            "lateral malleolus": (0, heel + 0.20 * length, 0.155 * top, "lateral"),
            "medial malleolus": (0, heel + 0.24 * length, 0.175 * top, "medial"),
            "fibula head": (0, 0, 0.9 * top, "lateral"),
            "heel": (behind, 0, 0.05 * top, "back"),
            "first metatarsal head": (0, heel + 0.72 * length, 0.035 * top, "medial"),
            "fifth metatarsal head": (0, heel + 0.62 * length, 0.03 * top, "lateral"),
            "second toe": (float(toe[0]), 0, float(toe[2]), "front"),
        },
    )


def residual_limb(path: Path) -> Limb:
    """The mean transtibial limb, turned to face +Y; 257 mm from its end to over the patella."""
    read = trimesh.load(path, process=True)
    mesh = Mesh(vertices_mm=np.array(read.vertices, float), faces=read.faces.astype(np.int32))
    turned = mesh.vertices_mm * [-1, -1, 1]
    middle = turned[np.abs(turned[:, 2] + 20) < 10].mean(0)
    mesh = mesh.with_vertices(turned - [*middle[:2], float(turned[:, 2].min())])
    return marked(
        mesh,
        "transtibial",
        {
            "mid patella": (0, 0, 205, "front"),
            "patellar tendon": (0, 0, 172, "front"),
            "distal end": (0, 0, 20, "below"),
            "lateral femoral epicondyle": (0, -5, 205, "lateral"),
            "medial femoral epicondyle": (0, -5, 205, "medial"),
        },
    )


@pytest.mark.slow
@pytest.mark.parametrize("name", ["smo", "ucbl", "foot-orthosis"])
@pytest.mark.parametrize("who", ["adult_female", "child"])
def test_a_foot_of_a_body_gets_its_orthosis(data_folder: Path, who: str, name: str) -> None:
    limb = foot_of(data_folder / "shapes" / "human" / f"{who}.ply")
    made = make_device(limb, Order(device=name))
    assert made.wall.off_mm < 0.06
    assert made.wall.thinnest_mm > 0.4 * 4.8


@pytest.mark.slow
@pytest.mark.parametrize("name", ["ptb-socket", "supracondylar-socket", "tsb-socket"])
def test_a_residual_limb_gets_its_socket(data_folder: Path, name: str) -> None:
    shapes = data_folder / "shapes" / "openlimb_TT"
    limb = residual_limb(shapes / "Full Size Mean_Skin_Shape.stl")
    made = make_device(limb, Order(device=name, values={"pilot_mm": 8.0}))
    assert made.wall.off_mm < 0.05
    assert made.wall.thinnest_mm > 4.9


@pytest.mark.slow
def test_bare_toes_are_refused_where_a_toe_plate_would_follow_them(data_folder: Path) -> None:
    limb = foot_of(data_folder / "shapes" / "human" / "adult_female.ply")
    with pytest.raises(EditError) as refused:
        make_device(limb, Order(device="solid-afo"))
    assert refused.value.finding.code == "device.trim.crosses"
    place = refused.value.finding.values["point_mm"]
    assert isinstance(place, tuple)
    assert place[1] > 100  # at the toes


def test_a_line_through_a_vertex_does_not_slip_through_the_surface() -> None:
    """A landmark may be a vertex: of lines through those of spheres one in eighty met nothing."""
    ball = trimesh.creation.icosphere(3, 50.0)
    rng = np.random.default_rng(1)
    for _ in range(4):
        middle, look = rng.uniform(-40, 40, 3), rng.normal(size=3)
        look /= np.linalg.norm(look)
        places = np.asarray(ball.vertices) + middle
        body = Body(Limb(mesh=Mesh(vertices_mm=places, faces=ball.faces.astype(np.int32))))
        for place in places[(places - middle) @ look < -15]:
            met = body.first_hit_mm(place, look)
            assert met is not None
            np.testing.assert_allclose(met, place, atol=0.01)
        beside = np.linalg.svd(look[None])[2][1]
        assert body.first_hit_mm(middle + 50.1 * beside, look) is None


@pytest.mark.parametrize(
    ("moved", "code"),
    [
        ({"first metatarsal head": (-40.0, 0.0), "fifth metatarsal head": (40.0, 1.0)}, "on_line"),
        ({"second toe": (0.0, 0.0)}, "on_point"),
    ],
)
def test_a_foot_whose_landmarks_span_no_plane_is_refused(
    bodies: dict[str, Limb], moved: dict[str, tuple[float, float]], code: str
) -> None:
    """Metatarsal heads marked on both sides of the heel, or a toe marked on the heel."""
    foot = bodies["foot"]
    heel_mm = next(one.position_mm for one in foot.landmarks if one.name == "heel")
    landmarks = tuple(
        replace(one, position_mm=heel_mm + np.array([*moved[one.name], 0.0]))
        if one.name in moved
        else one
        for one in foot.landmarks
    )
    with pytest.raises(EditError) as refused:
        Body.of(replace(foot, landmarks=landmarks)).directions("foot")
    assert refused.value.finding.code == f"anatomy.{code}"
