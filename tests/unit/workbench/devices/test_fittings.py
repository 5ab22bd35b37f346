"""Fittings: holes where adapters have them, other makers' bodies, and how a socket stands."""

import numpy as np
import pytest
import trimesh
from tests.unit.workbench.devices.shapes import make_stump

from limbgram.core.errors import EditError
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import volume_mm3
from limbgram.workbench.devices.adapter import adapter_under
from limbgram.workbench.devices.body import Body
from limbgram.workbench.devices.device import ADAPTER, FlexedJoint, devices
from limbgram.workbench.devices.fittings import imported_part, plate, pyramid, with_parts
from limbgram.workbench.devices.layout import CoveredArea
from limbgram.workbench.devices.proof import require_solid
from limbgram.workbench.devices.shell import Layout
from limbgram.workbench.devices.trims import values_of
from limbgram.workbench.limb import Limb

UNMOVED = Rigid.identity()


def mesh_of(solid: trimesh.Trimesh) -> Mesh:
    return Mesh(vertices_mm=np.asarray(solid.vertices, float), faces=solid.faces.astype(np.int32))


def body(size: float = 60.0, up: float = 30.0) -> Mesh:
    return mesh_of(
        trimesh.creation.box((size, size, 60.0)).apply_translation([0, 0, 14.0 + up - 2])
    )


def test_the_plate_has_four_holes_36_mm_apart() -> None:
    solid = with_parts(body(), plate(UNMOVED, width_mm=65.0, height_mm=14.0, hole_mm=6.5))
    require_solid(solid)
    lower = solid.vertices_mm[np.abs(solid.vertices_mm[:, 2]) < 1e-6]
    for x in (-18.0, 18.0):
        for y in (-18.0, 18.0):
            off = np.hypot(lower[:, 0] - x, lower[:, 1] - y)
            rim = off[off < 5]
            assert len(rim) >= 90
            np.testing.assert_allclose(rim, 3.25, atol=1e-6)
    cut = volume_mm3(with_parts(body(), plate(UNMOVED, width_mm=65, height_mm=14, hole_mm=5.0)))
    more = volume_mm3(solid)
    assert cut - more == pytest.approx(
        4 * np.pi * (3.25**2 - 2.5**2) * 14.5, rel=2e-3
    )  # and 0.5 mm into the body


def test_a_pyramid_hangs_under_the_plate_wider_at_its_end() -> None:
    parts = [*plate(UNMOVED, width_mm=65.0, height_mm=14.0, hole_mm=6.5), pyramid(UNMOVED, 16.0)]
    solid = with_parts(body(), parts)
    require_solid(solid)
    below = solid.vertices_mm[solid.vertices_mm[:, 2] < -15.9]
    assert below[:, 2].min() == pytest.approx(-16.0)
    np.testing.assert_allclose(np.ptp(below, axis=0)[:2], 21.0, atol=1e-6)
    neck = solid.vertices_mm[np.abs(solid.vertices_mm[:, 2]) < 1e-6]
    inner = neck[np.abs(neck[:, :2]).max(1) < 12]
    np.testing.assert_allclose(np.ptp(inner, axis=0)[:2], 21 - 32 * np.tan(np.radians(15)))


def test_a_body_of_another_maker_is_joined_or_cut_out() -> None:
    lock = mesh_of(trimesh.creation.cylinder(12.0, 30.0).apply_translation([0, 0, 80.0]))
    joined = with_parts(body(), [imported_part("lock", lock, UNMOVED, "join")])
    cut = with_parts(body(), [imported_part("lock", lock, UNMOVED, "cut")])
    for solid in (joined, cut):
        require_solid(solid)
    own, inside = volume_mm3(body()), volume_mm3(lock) * 7 / 30
    assert volume_mm3(joined) == pytest.approx(own + volume_mm3(lock) - inside, rel=1e-6)
    assert volume_mm3(cut) == pytest.approx(own - inside, rel=1e-6)


def test_a_body_that_is_open_or_apart_is_refused_by_name() -> None:
    lock = mesh_of(trimesh.creation.cylinder(12.0, 30.0).apply_translation([0, 0, 300.0]))
    opened = Mesh(vertices_mm=lock.vertices_mm, faces=lock.faces[1:])
    inside_out = Mesh(vertices_mm=lock.vertices_mm, faces=lock.faces[:, ::-1].copy())
    for bad in (opened, inside_out):
        with pytest.raises(EditError) as refused:
            imported_part("lock.stl", bad, UNMOVED, "join")
        assert refused.value.finding.code == "device.part.open"
        assert refused.value.finding.values["name"] == "lock.stl"
    with pytest.raises(EditError) as refused:
        with_parts(body(), [imported_part("lock.stl", lock, UNMOVED, "join")])
    assert refused.value.finding.code == "device.part.apart"


def socket_of(limb: Limb) -> tuple[Body, Layout]:
    body = Body.of(limb)
    covered = CoveredArea(positive=body.mesh, beyond_mm=body.mesh.vertices_mm[:, 2] - 170.0)
    thick = np.full(len(body.mesh), 5.0)
    return body, Layout(positive=covered.positive, beyond_mm=covered.beyond_mm, thickness_mm=thick)


@pytest.mark.parametrize(("joint", "ahead"), [("knee", 1.0), ("hip", -1.0)])
@pytest.mark.parametrize("side", ["right", "left"])
def test_the_socket_leans_over_its_plate_as_asked(
    side: str, joint: FlexedJoint, ahead: float
) -> None:
    """Seen from the plate: below a flexed knee its upper end lies in front, below a flexed hip
    behind, for a thigh points forwards; adducted, it lies outwards."""
    body, layout = socket_of(make_stump("right" if side == "right" else "left"))
    out = 1.0 if side == "right" else -1.0
    flat = dict.fromkeys(("flexion_deg", "adduction_deg", "toe_out_deg", "inset_mm"), 0.0)

    def turned(**asked: float) -> Rigid:
        values = values_of(ADAPTER, {**flat, **asked})
        return adapter_under(body, layout, values, joint).alignment.limb_from_plate.inverse

    up = np.array([0.0, 0, 1])
    flexed = turned(flexion_deg=10.0).rotation @ up
    np.testing.assert_allclose(
        flexed, [0, ahead * np.sin(np.radians(10)), np.cos(np.radians(10))], atol=1e-9
    )
    adducted = turned(adduction_deg=8.0).rotation @ up
    np.testing.assert_allclose(adducted[0] * out, np.sin(np.radians(8)), atol=1e-9)
    foot = turned(toe_out_deg=6.0).inverse.rotation @ np.array([0.0, 1, 0])
    np.testing.assert_allclose(foot[0] * out, np.sin(np.radians(6)), atol=1e-9)
    inset = turned(inset_mm=7.0).centre - turned().centre
    np.testing.assert_allclose(inset, [-7.0 * out, 0, 0], atol=1e-9)


def test_a_socket_goes_by_the_joint_above_its_limb() -> None:
    joints = {(one.kind, one.adapter) for one in devices().values() if one.adapter}
    assert joints == {("transtibial", "knee"), ("transfemoral", "hip")}


def test_the_plate_lies_below_the_end_by_what_is_built() -> None:
    body, layout = socket_of(make_stump())
    values = values_of(ADAPTER, {"flexion_deg": 0.0, "adduction_deg": 0.0, "build_mm": 22.0})
    origin = adapter_under(body, layout, values, "knee").alignment.limb_from_plate.translation
    lowest = body.mesh.vertices_mm[:, 2].min()
    assert origin[2] == pytest.approx(lowest - 5.0 - 22.0 - 14.0, abs=1e-9)


@pytest.mark.parametrize("side", ["right", "left"])
def test_the_foot_is_turned_by_as_much_as_is_told_whatever_the_socket_s_lean(side: str) -> None:
    """About the line, from the limb's front as it is seen along the line."""
    body, layout = socket_of(make_stump("right" if side == "right" else "left"))
    lean = {"flexion_deg": 30.0, "adduction_deg": 20.0, "toe_out_deg": 20.0}
    alignment = adapter_under(body, layout, values_of(ADAPTER, lean), "knee").alignment
    _, foot, up = alignment.limb_from_plate.rotation.T
    front = np.array([0.0, 1.0, 0.0])
    ahead = front - (front @ up) * up
    turned = np.degrees(np.arctan2(np.cross(foot, ahead) @ up, foot @ ahead))
    assert turned * (1 if side == "right" else -1) == pytest.approx(alignment.toe_out_deg)
