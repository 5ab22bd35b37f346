"""The toe bridge: gaps filled by a ball that rolls over them, and nothing else moved."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation
from tests.unit.workbench.devices.shapes import (
    FOOT_PLACES,
    cone,
    ellipsoid,
    limb_of,
    surface,
    together,
)

from limbgram.core.errors import EditError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.crossings import find_crossings
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import boundary_loops, is_edge_manifold, volume_mm3, with_faces
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.workbench.devices.body import Body
from limbgram.workbench.edits.editing import do_edit
from limbgram.workbench.edits.toe_bridge import ToeBridge
from limbgram.workbench.limb import AlignedLimb, Limb, LimbFrame, Side

TOE_MM, APART_MM, HIGH_MM = 8.0, 20.0, 14.0
"""Radius of two straight toes, and how far their axes are apart and over the floor."""
SIGMA_MM, SHARED_MM, LOST = 0.125, 0.0625, 0.03125
"""What is known of every vertex, exact in single precision."""


@pytest.fixture(scope="module")
def two_toes() -> Limb:
    field = together(
        [
            cone((0, -8, 75), 34, (0, -8, 300), 45, 1.15),
            ellipsoid((0, -25, 32), (34, 42, 34), 2.3),
            ellipsoid((0, 45, 26), (44, 75, 28), 2.6),
            *(
                cone((x, 90, HIGH_MM), TOE_MM, (x, 170, HIGH_MM), TOE_MM)
                for x in (-APART_MM / 2, APART_MM / 2)
            ),
        ],
        0.3,
    )
    mesh = surface(field, (-90, -110, -30), (90, 220, 150), 3.0, 130.0)
    places = {**FOOT_PLACES, "second toe": (-10, 178, 14), "first toe": (-10, 178, 14)}
    low = {name: at for name, at in places.items() if at[2] < 130}
    known = {
        "sigma_mm": np.full(len(mesh), SIGMA_MM, np.float32),
        "shared_mm": np.full((len(mesh), 2), SHARED_MM, np.float32),
        "lost_length": np.full((len(mesh), 2), LOST, np.float32),
    }
    mesh = replace(mesh, **known)
    return limb_of(mesh, low, "foot", "right")


RADIUS_MM = 4.0


@pytest.fixture(scope="module")
def bridged(two_toes: Limb) -> Limb:
    return do_edit(two_toes, ToeBridge(gap_mm=2 * RADIUS_MM))


@pytest.mark.slow
@pytest.mark.parametrize("side", ["right", "left"])
def test_a_scan_that_lies_otherwise_and_the_other_foot_are_filled_alike(
    two_toes: Limb, bridged: Limb, side: Side
) -> None:
    """Upside down and askew, far from where it was, with its own frame told."""
    flip = np.diag([1.0 if side == "right" else -1.0, 1.0, 1.0])
    turn = Rotation.from_euler("xyz", (180, 13, 37), degrees=True).as_matrix()
    far_mm = np.array([400.0, -900.0, 2000.0])

    def there(points_mm: np.ndarray) -> np.ndarray:
        return points_mm @ flip @ turn.T + far_mm

    mesh, limb = two_toes.mesh, two_toes.aligned()
    faces = mesh.faces if side == "right" else np.ascontiguousarray(mesh.faces[:, ::-1])
    marks = [replace(one, position_mm=there(one.position_mm)) for one in limb.landmarks]
    own = limb.limb_from_mesh
    other = AlignedLimb(
        mesh=Mesh(vertices_mm=there(mesh.vertices_mm), faces=faces),
        landmarks=tuple(marks),
        frame=LimbFrame(
            limb_from_mesh=Rigid(
                own.rotation @ turn.T, own.translation - own.rotation @ turn.T @ far_mm
            ),
            side=side,
        ),
        kind=limb.kind,
    )
    after = do_edit(other, ToeBridge(gap_mm=2 * RADIUS_MM))
    asked = there(bridged.mesh.vertices_mm)
    assert tree_on(after.mesh).closest(asked).distances_mm.max() < 1e-3
    assert abs(volume_mm3(after.mesh) - volume_mm3(bridged.mesh)) < 1.0


def test_a_ball_of_half_the_gap_rolls_over_what_is_filled(bridged: Limb) -> None:
    """It touches both toes: how deep it reaches between them follows from their radii."""
    radius, after = RADIUS_MM, bridged
    rise = np.sqrt((TOE_MM + radius) ** 2 - (APART_MM / 2) ** 2)
    body = Body.of(after)
    for sign, look in ((1, -1.0), (-1, 1.0)):
        met = body.first_hit_mm(np.array([0.0, 150.0, 0.0]), np.array([0.0, 0.0, look]))
        assert met is not None
        shallower = sign * (met[2] - HIGH_MM) - (rise - radius)
        assert -0.05 < shallower < 0.25 * radius / 3  # a quarter of a cell of the grid
    assert is_edge_manifold(after.mesh.faces)
    assert len(boundary_loops(after.mesh.faces)) == 1
    assert not len(find_crossings(after.mesh.vertices_mm, after.mesh.faces))


def test_what_has_no_gap_stays_and_landmarks_with_it(two_toes: Limb, bridged: Limb) -> None:
    after = bridged
    assert after.mesh.filled is not None
    off = tree_on(two_toes.mesh).closest(after.mesh.vertices_mm).distances_mm
    assert off[~after.mesh.filled].max() < 0.1
    assert 100 < after.mesh.filled.sum() < 0.3 * len(after.mesh)
    inside = Body.of(after).mesh.vertices_mm[after.mesh.filled]
    assert inside[:, 1].min() > 95
    beyond = inside[inside[:, 1] > 135]  # where the toes have left the foot
    assert len(beyond) > 50
    assert np.abs(beyond[:, 0]).max() < APART_MM / 2
    assert {one.name for one in after.landmarks} == {one.name for one in two_toes.landmarks}
    for one, other in zip(two_toes.landmarks, after.landmarks, strict=True):
        assert np.linalg.norm(one.position_mm - other.position_mm) < 0.3
    assert volume_mm3(after.mesh) > volume_mm3(two_toes.mesh)


def test_what_was_known_of_the_foot_is_known_wherever_it_stayed(bridged: Limb) -> None:
    """Though its triangles are new there; of what was filled nothing was measured."""
    after = bridged.mesh
    for values, known, unmeasured in (
        (after.sigma_mm, SIGMA_MM, np.nan),
        (after.shared_mm, SHARED_MM, 0.0),
        (after.lost_length, LOST, 0.0),
    ):
        assert values is not None
        assert after.filled is not None
        rows = after.filled.reshape(-1, *[1] * (values.ndim - 1))
        expected = np.broadcast_to(np.where(rows, unmeasured, known), values.shape)
        np.testing.assert_array_equal(values, expected)


def test_a_foot_without_toes_or_with_a_hole_there_is_refused(two_toes: Limb) -> None:
    places = two_toes.frame.limb_from_mesh.apply(two_toes.mesh.vertices_mm)

    def without(gone: np.ndarray) -> Limb:
        kept = ~gone[two_toes.mesh.faces].any(1)
        return replace(two_toes, mesh=with_faces(two_toes.mesh, two_toes.mesh.faces[kept]))

    plane = np.linalg.norm(places - [0, 105, 50.0], axis=1) < 14
    for limb, code in (
        (without(places[:, 1] > 88), "edit.toe_bridge.no_toes"),
        (without(plane), "edit.toe_bridge.parted"),
    ):
        with pytest.raises(EditError) as refused:
            do_edit(limb, ToeBridge(gap_mm=8.0))
        assert refused.value.finding.code == code
        assert str(refused.value)
