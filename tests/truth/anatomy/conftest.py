"""Limbs cut out of four whole bodies of one topology: a landmark, chosen once by its vertex, lies
at the same place of the body on all of them.

The bodies stand in the folder of captures, not in the project: z up, the front to +y, in mm.
"""

from collections.abc import Callable
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.reading import read_shape
from limbgram.workbench.bodies import outer_bodies
from limbgram.workbench.edits.cutting import keep_positive
from limbgram.workbench.limb import AlignedLimb, KindName, Landmark, Limb, LimbFrame, Side

BODIES = ("adult_female", "adult_male", "baby", "child")
FOOT = {
    "medial malleolus": 6345,
    "lateral malleolus": 6240,
    "fibula head": 4706,
    "medial tibial condyle": 4675,
    "tibial tubercle": 4681,
    "tibial crest": 4738,
    "first metatarsal head": 6252,
    "fifth metatarsal head": 6195,
    "plantar first metatarsal head": 6280,
    "plantar fifth metatarsal head": 6266,
    "plantar heel": 6223,
    "navicular": 6261,
    "instep": 6222,
    "achilles insertion": 6371,
    "medial calcaneus": 6304,
    "lateral calcaneus": 6337,
    "fifth metatarsal base": 6275,
    "heel": 5856,
    "second toe": 6537,
    "first toe": 4933,
}
"""Vertices of the right leg."""
HEAD = {
    "sellion": 169,
    "glabella": 237,
    "right tragion": 5709,
    "left tragion": 12306,
    "vertex": 879,
    "opisthocranion": 5389,
    "right eurion": 863,
    "left eurion": 7568,
}
TRUNK_MM = {
    "seventh cervical vertebra": (0, -60, 1480),
    "sternal notch": (0, 80, 1450),
    "right axilla": (160, 0, 1300),
    "left axilla": (-160, 0, 1300),
    "xiphoid": (0, 145, 1230),
    "twelfth thoracic vertebra": (0, -60, 1180),
    "third lumbar vertebra": (0, -45, 1080),
    "right waist": (140, 30, 1090),
    "left waist": (-140, 30, 1090),
    "navel": (0, 135, 1080),
    "right iliac spine": (120, 105, 980),
    "left iliac spine": (-120, 105, 980),
    "sacrum": (0, -62, 1000),
    "right trochanter": (178, 30, 890),
    "left trochanter": (-178, 30, 890),
    "pubic symphysis": (0, 110, 890),
    "coccyx": (0, -70, 950),
}
"""Where they lie on the adult man; the vertex there is the landmark on all."""


def body_of(data_folder: Path, name: str) -> Mesh:
    path = data_folder / "shapes" / "human" / f"{name}.ply"
    if not path.is_file():
        pytest.skip("no bodies in the folder of captures")
    return read_shape(path, 1.0).limb.mesh


def limb_of(
    mesh: Mesh, places: dict[str, np.ndarray], kind: KindName, side: Side, sigma_mm: float
) -> Limb:
    """A limb in its limb frame, its surface everywhere as well known."""
    if sigma_mm:
        mesh = replace(mesh, sigma_mm=np.full(len(mesh), sigma_mm, np.float32))
    return AlignedLimb(
        mesh=mesh,
        landmarks=tuple(Landmark(name=name, position_mm=at) for name, at in places.items()),
        frame=LimbFrame(limb_from_mesh=Rigid.identity(), side=side),
        kind=kind,
    )


MakeLimb = Callable[..., Limb]


@pytest.fixture(scope="session")
def foot_of(data_folder: Path) -> MakeLimb:
    """A foot with its shank, cut below the knee; mirrored, a left one."""

    def made(name: str = "adult_male", *, left: bool = False, sigma_mm: float = 0.0) -> Limb:
        whole = body_of(data_folder, name)
        places = {one: whole.vertices_mm[k].copy() for one, k in FOOT.items()}
        knee = max(places["fibula head"][2], places["medial tibial condyle"][2])
        apart = whole.vertices_mm[:, 0]
        mesh = keep_positive(whole, apart).mesh
        top = knee + 0.04 * (whole.vertices_mm[:, 2].max())
        mesh = keep_positive(mesh, top - mesh.vertices_mm[:, 2]).mesh
        mesh = Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces)
        if left:
            flip = np.array([-1.0, 1.0, 1.0])
            places = {one: at * flip for one, at in places.items()}
            mesh = Mesh(vertices_mm=mesh.vertices_mm * flip, faces=mesh.faces[:, ::-1].copy())
        return limb_of(mesh, places, "foot", "left" if left else "right", sigma_mm)

    return made


@pytest.fixture(scope="session")
def head_of(data_folder: Path) -> MakeLimb:
    """A head, open at the neck."""

    def made(name: str = "baby", *, sigma_mm: float = 0.0) -> Limb:
        whole = body_of(data_folder, name)
        places = {one: whole.vertices_mm[k].copy() for one, k in HEAD.items()}
        chin = places["right tragion"][2] - 0.8 * (places["vertex"] - places["right tragion"])[2]
        mesh = keep_positive(whole, whole.vertices_mm[:, 2] - chin).mesh
        mesh = Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces)
        return limb_of(mesh, places, "head", "none", sigma_mm)

    return made


@pytest.fixture(scope="session")
def trunk_of(data_folder: Path) -> MakeLimb:
    """A trunk without arms, open at neck, shoulders and thighs."""

    def made(name: str = "adult_male", *, sigma_mm: float = 0.0) -> Limb:
        man = body_of(data_folder, "adult_male").vertices_mm
        ids = {
            one: int(np.linalg.norm(man - np.array(at, float), axis=1).argmin())
            for one, at in TRUNK_MM.items()
        }
        whole = body_of(data_folder, name)
        places = {one: whole.vertices_mm[k].copy() for one, k in ids.items()}
        size = float(whole.vertices_mm[:, 2].max()) / float(man[:, 2].max())
        mesh = keep_positive(
            whole, whole.vertices_mm[:, 2] - places["pubic symphysis"][2] + 25 * size
        ).mesh
        neck = places["seventh cervical vertebra"][2] + 15 * size
        mesh = keep_positive(mesh, neck - mesh.vertices_mm[:, 2]).mesh
        beside = float(np.abs(places["right axilla"][0])) + 12 * size
        for sign in (1, -1):
            high = np.maximum(sign * mesh.vertices_mm[:, 0] - beside, 0)
            arm = (mesh.vertices_mm[:, 2] > places["right waist"][2]) * high
            mesh = keep_positive(mesh, 0.5 - arm).mesh
        mesh = outer_bodies(Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces)).mesh
        return limb_of(mesh, places, "torso", "none", sigma_mm)

    return made
