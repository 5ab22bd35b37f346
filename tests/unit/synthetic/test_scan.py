"""Scans of known shapes become limbs of the same shape, upright and not mirrored."""

from pathlib import Path

import numpy as np
import pytest
import trimesh
from scipy.spatial.transform import Rotation

from limbgram.core.errors import OptionsError, ShapeFileError
from limbgram.synthetic.options import CaptureOptions
from limbgram.synthetic.props.limb import Limb, Relief
from limbgram.synthetic.props.scan import distance_for, limb_of_scan, read_scan
from limbgram.synthetic.truth import stage_truth

SMOOTH = Relief(rms_mm=0.0)
LYING = Rotation.from_euler("xyz", [80.0, 25.0, -130.0], degrees=True)
"""So that the long axis is no axis of the file."""
OFF_MM = np.array([30.0, -40.0, 500.0])


def written(
    folder: Path, mesh: trimesh.Trimesh, name: str = "scan.stl", scale: float = 1.0
) -> Path:
    turned = mesh.copy()
    turned.vertices = scale * (LYING.apply(turned.vertices) + OFF_MM)
    path = folder / name
    turned.export(path)
    return path


def turned(radii: np.ndarray, heights: np.ndarray, columns: int = 90) -> trimesh.Trimesh:
    """A surface of rings; radii of 0 are points, and open ends stay open."""
    angles = 2 * np.pi * np.arange(columns) / columns
    radii = np.broadcast_to(radii.reshape(len(heights), -1), (len(heights), columns))
    x, y = radii * np.cos(angles), radii * np.sin(angles)
    z = np.broadcast_to(heights[:, None], radii.shape)
    ids = np.arange(radii.size).reshape(radii.shape)
    a, b = ids[:-1], np.roll(ids, -1, 1)[:-1]
    d, c = ids[1:], np.roll(ids, -1, 1)[1:]
    faces = np.concatenate([np.stack(f, -1).reshape(-1, 3) for f in ((a, b, c), (a, c, d))])
    return trimesh.Trimesh(np.stack([x, y, z], -1).reshape(-1, 3), faces)


def dome(radius_mm: float, length_mm: float) -> trimesh.Trimesh:
    """An open tube with half a sphere on it."""
    straight = np.linspace(0.0, length_mm, 60)
    rise = np.linspace(0.0, np.pi / 2, 40)[1:]
    radii = np.concatenate([np.full(60, radius_mm), radius_mm * np.cos(rise)])
    return turned(radii, np.concatenate([straight, length_mm + radius_mm * np.sin(rise)]))


def limb_of(path: Path, mm_per_unit: float | None = None) -> Limb:
    return limb_of_scan(read_scan(path, mm_per_unit), 3, 1.5, 60.0, SMOOTH)


def radii_at(limb: Limb, low: float, high: float) -> np.ndarray:
    """Of the skin between two heights over the cut."""
    points = limb.mesh.vertices_mm[~limb.cut]
    over = points[:, 2] - limb.base_mm
    return np.linalg.norm(points[(over > low) & (over < high), :2], axis=1)


def test_a_dome_stands_upright_with_its_own_radius_and_height(tmp_path: Path) -> None:
    limb = limb_of(written(tmp_path, dome(50.0, 180.0)))
    np.testing.assert_allclose(radii_at(limb, 10.0, 165.0), 50.0, atol=0.08)  # 90 facets: 0.03
    top = limb.mesh.vertices_mm - [0.0, 0.0, limb.mesh.vertices_mm[:, 2].max() - 50.0]
    np.testing.assert_allclose(np.linalg.norm(top[top[:, 2] > 1.0], axis=1), 50.0, atol=0.1)
    assert 225.0 < limb.height_mm < 230.05  # the lowest row of the open end is left out
    assert limb.mesh.vertices_mm[:, 2].min() == pytest.approx(60.0)


def test_a_closed_cylinder_keeps_its_radius_up_to_its_flat_end(tmp_path: Path) -> None:
    cylinder = trimesh.creation.cylinder(40.0, 200.0, sections=128)
    limb = limb_of(written(tmp_path, cylinder))
    np.testing.assert_allclose(radii_at(limb, 5.0, 150.0), 40.0, atol=0.05)
    np.testing.assert_allclose(radii_at(limb, 150.0, 190.0), 40.0, atol=0.3)  # facets rounded
    assert limb.height_mm == pytest.approx(200.0, abs=1.6)
    inner = np.linalg.norm(limb.mesh.vertices_mm[:, :2], axis=1) < 30.0
    flat = limb.mesh.vertices_mm[inner & ~limb.cut, 2]
    assert np.ptp(flat) < 0.3


def test_a_cone_stands_on_its_wide_end_and_tapers_as_it_does(tmp_path: Path) -> None:
    heights = np.linspace(0.0, 220.0, 111)
    lidded = turned(np.append(60.0 - 0.15 * heights, 0.0), np.append(heights, 220.0))
    limb = limb_of(written(tmp_path, lidded))
    points = limb.mesh.vertices_mm[~limb.cut]
    over_end = points[:, 2].max() - points[:, 2]
    wall = (over_end > 8.0) & (over_end < 200.0)
    radius = np.linalg.norm(points[wall, :2], axis=1)
    np.testing.assert_allclose(radius, 27.0 + 0.15 * over_end[wall], atol=0.08)


def test_of_a_socket_the_outside_is_taken(tmp_path: Path) -> None:
    """A cup of 5 mm wall, whose thinner closed end goes up."""
    up = np.linspace(0.0, 200.0, 80)
    outer, inner = 60.0 - 0.1 * up, 55.0 - 0.1 * up[:-4]
    radii = np.concatenate([[0.0], inner[::-1], outer, [0.0]])
    cup = turned(radii, np.concatenate([[up[-5]], up[-5::-1], up, [200.0]]))
    limb = limb_of(written(tmp_path, cup))
    points = limb.mesh.vertices_mm[~limb.cut]
    over_end = points[:, 2].max() - points[:, 2]
    wall = (over_end > 10.0) & (over_end < 180.0)
    radius = np.linalg.norm(points[wall, :2], axis=1)
    np.testing.assert_allclose(radius, 40.0 + 0.1 * over_end[wall], atol=0.2)


def test_a_mark_stays_on_its_side(tmp_path: Path) -> None:
    """A rib low down and one higher, a quarter further on: a mirror would turn the other way."""
    heights = np.linspace(0.0, 220.0, 111)[:, None]
    angles = 2 * np.pi * np.arange(120) / 120
    radii = np.full((111, 120), 45.0)
    for at, angle in ((60.0, 1.0), (140.0, 1.0 + np.pi / 2)):
        aside = np.angle(np.exp(1j * (angles - angle)))
        radii += 8.0 * np.exp(-0.5 * (((heights - at) / 12) ** 2 + (45 * aside / 12) ** 2))
    radii *= np.sqrt(np.clip((222.0 - heights) / 40.0, 0.0, 1.0))
    limb = limb_of(written(tmp_path, turned(radii, heights[:, 0], 120)))
    points = limb.mesh.vertices_mm[~limb.cut]
    over_end = points[:, 2].max() - points[:, 2]
    found = []
    for at in (60.0, 140.0):
        ring = points[np.abs(over_end - (221.0 - at)) < 3.0]
        mark = ring[np.argmax(np.linalg.norm(ring[:, :2], axis=1))]
        found.append(np.arctan2(mark[1], mark[0]))
    assert np.angle(np.exp(1j * (found[1] - found[0]))) == pytest.approx(np.pi / 2, abs=0.06)


def test_small_holes_are_filled_and_said(tmp_path: Path) -> None:
    whole = dome(50.0, 180.0)
    middle = np.array([50.0, 0.0, 100.0])
    away = np.linalg.norm(whole.triangles_center - middle, axis=1)
    torn = trimesh.Trimesh(whole.vertices, whole.faces[away > 12.0])
    scan = read_scan(written(tmp_path, torn))
    assert "made.scan.filled" in [note.code for note in scan.notes]
    limb = limb_of_scan(scan, 3, 1.5, 60.0, SMOOTH)
    np.testing.assert_allclose(radii_at(limb, 10.0, 165.0), 50.0, atol=0.3)
    wide = trimesh.Trimesh(whole.vertices, whole.faces[away > 30.0])
    with pytest.raises(ShapeFileError, match=r"hole 5\d mm wide"):
        read_scan(written(tmp_path, wide))


def test_a_ragged_end_is_cut_and_an_open_tube_refused(tmp_path: Path) -> None:
    whole = dome(50.0, 180.0)
    x, _, z = whole.triangles_center.T
    scan = read_scan(
        written(tmp_path, trimesh.Trimesh(whole.vertices, whole.faces[z > 20 + x / 3]))
    )
    assert scan.height_mm == pytest.approx(230.0 - 36.7, abs=4.0)
    assert "made.scan.end_left_out" in [note.code for note in scan.notes]
    tube = trimesh.Trimesh(whole.vertices, whole.faces[z < 175.0])
    with pytest.raises(ShapeFileError, match="holes over"):
        read_scan(written(tmp_path, tube))


def test_two_limbs_in_one_piece_and_a_ball_are_refused(tmp_path: Path) -> None:
    both = _bridged(_tube_at(0.0, 35.0, 200.0), _tube_at(60.0, 25.0, 190.0))
    with pytest.raises(ShapeFileError, match="leave it more than once"):
        read_scan(written(tmp_path, both))
    with pytest.raises(ShapeFileError, match="long axis was not found"):
        read_scan(written(tmp_path, trimesh.creation.icosphere(4, 60.0)))


def _tube_at(x_mm: float, radius_mm: float, length_mm: float) -> trimesh.Trimesh:
    """A closed upright tube beside the axis, of many triangles."""
    heights = np.linspace(0.0, length_mm, 40)
    radii = np.concatenate([[0.0], np.full(40, radius_mm), [0.0]])
    tube = turned(radii, np.concatenate([[0.0], heights, [length_mm]]), 48)
    return trimesh.Trimesh(tube.vertices + x_mm * np.eye(3)[0], tube.faces)


def _bridged(one: trimesh.Trimesh, other: trimesh.Trimesh) -> trimesh.Trimesh:
    """Two bodies joined by a thin tube between a face of each, so that they are one piece."""
    first = int(np.argmax(one.triangles_center[:, 0] - np.abs(one.triangles_center[:, 2] - 130)))
    second = int(
        np.argmin(other.triangles_center[:, 0] + np.abs(other.triangles_center[:, 2] - 130))
    )
    count = len(one.vertices)
    a, b = one.faces[first], other.faces[second][::-1] + count
    near = [np.linalg.norm(one.vertices[a[0]] - other.vertices[v - count]) for v in b]
    b = np.roll(b, -int(np.argmin(near)))
    sides = [
        face
        for k in range(3)
        for face in (
            (a[k], a[(k + 1) % 3], b[(k + 1) % 3]),
            (a[k], b[(k + 1) % 3], b[k]),
        )
    ]
    faces = [np.delete(one.faces, first, 0), np.delete(other.faces, second, 0) + count, sides]
    return trimesh.Trimesh(
        np.concatenate([one.vertices, other.vertices]), np.concatenate(faces), process=False
    )


def test_the_unit_is_the_files_own_or_the_users(tmp_path: Path) -> None:
    path = written(tmp_path, dome(50.0, 180.0), scale=0.001)
    with pytest.raises(ShapeFileError, match="--unit"):
        read_scan(path)
    assert read_scan(path, 1000.0).height_mm == pytest.approx(230.0, abs=4.0)
    with pytest.raises(ShapeFileError, match="Check the unit"):
        read_scan(path, 3000.0)


def test_the_camera_goes_as_far_off_as_the_limb_is_long(tmp_path: Path) -> None:
    scan = read_scan(written(tmp_path, dome(60.0, 320.0)))
    options = CaptureOptions(
        scan=scan, distance_mm=distance_for(scan, 1500.0), mesh_step_mm=2.0, calibration_photos=0
    )
    truth = stage_truth(options)
    skin = truth.limb.mesh.vertices_mm[~truth.limb.cut]
    tops = [view.project(skin)[:, 1].min() / view.camera.height_px for view in truth.views]
    shown = [view.camera.contains(view.project(skin)).mean() for view in truth.views]
    assert np.mean(shown) > 0.97
    assert -0.06 < min(tops) < max(tops) < 0.2


def test_a_scan_is_known_by_its_file_and_stands_alone(tmp_path: Path) -> None:
    path = written(tmp_path, dome(50.0, 180.0))
    scan, again = read_scan(path), read_scan(path)
    assert scan == again
    assert CaptureOptions(scan=scan) == CaptureOptions(scan=again)
    assert scan != read_scan(path, 1.1)
    with pytest.raises(OptionsError, match="nor has it a fin"):
        CaptureOptions(scan=scan, fin_mm=4.0)
