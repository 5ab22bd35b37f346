"""A limb that shrank by a known volume: told within its interval, and nothing coloured for it."""

from dataclasses import replace

import numpy as np
import pytest
from scipy.spatial.transform import Rotation

from limbgram.core.geometry.frames import Rigid
from limbgram.core.interval import COVER
from limbgram.findings import told
from limbgram.report.drawings.differences import ambiguous_vertices
from limbgram.workbench.compare.comparison import CompareOptions, Comparison, compare
from limbgram.workbench.compare.messages import comparison_lines, comparison_tree, verdict
from limbgram.workbench.compare.over_time import repeats
from limbgram.workbench.compare.registration import RegistrationOptions
from limbgram.workbench.limb import Landmark, Limb, LimbFrame

SHRINKS = 0.974
"""Of every radius: 5.1 % of the volume, the tip stays."""
PLACES = {
    "patellar tendon": (0.0, 185.0),
    "fibula head": (1.4, 170.0),
    "popliteal crease": (3.2, 180.0),
    "tibia end": (0.3, 60.0),
}
"""Angle from the front, and height."""


def marked(limb: Limb, rng: np.random.Generator, off_mm: float) -> Limb:
    """Landmarks on the surface where the same places of the skin lie, each marked a little off."""
    mesh = limb.mesh
    marks: list[Landmark] = []
    for name, (angle, height) in PLACES.items():
        x, y, z = mesh.vertices_mm.T
        off = np.angle(np.exp(1j * (np.arctan2(x, y) - angle)))
        place = mesh.vertices_mm[np.argmin((50 * off) ** 2 + (z - height) ** 2)]
        marks.append(Landmark(name=name, position_mm=place + rng.normal(0, off_mm, 3)))
    return replace(limb, landmarks=tuple(marks))


def lying(limb: Limb, seed: int) -> Limb:
    """Elsewhere, in a scanner's axes, and not aligned."""
    pose = Rigid(Rotation.random(random_state=seed).as_matrix(), np.array([70.0, -20, 5]))
    return replace(
        limb.unaligned(),
        mesh=limb.mesh.with_vertices(pose.apply(limb.mesh.vertices_mm)),
        landmarks=tuple(
            replace(mark, position_mm=pose.apply(mark.position_mm[None])[0])
            for mark in limb.landmarks
        ),
    )


def narrower(limb: Limb) -> Limb:
    vertices = limb.mesh.vertices_mm * np.array([SHRINKS, SHRINKS, 1.0])
    return limb.with_mesh(limb.mesh.with_vertices(vertices))


def pair(make_limb, seed: int, off_mm: float = 0.7) -> tuple[Limb, Limb]:
    """A scan, and one of other triangles after the limb shrank."""
    rng = np.random.default_rng(seed)
    first = marked(make_limb(), rng, off_mm)
    second = marked(narrower(make_limb(spokes=77, rows=61, turn=0.03)), rng, off_mm)
    return first, lying(second, seed)


def true_change_mm3(found: Comparison) -> float:
    return (SHRINKS**2 - 1) * found.levels.volume.first.value


def at_tip(found: Comparison) -> np.ndarray:
    return np.asarray(found.first_in_limb.vertices_mm[:, 2] < 3.0)


@pytest.mark.slow
def test_shared_landmarks_tell_the_shrinkage_and_leave_the_tip_alone(make_limb) -> None:
    """Marks 0.7 mm off on either scan; without them the shape slides and the tip turns red."""
    off: list[float] = []
    for seed in range(6):
        first, second = pair(make_limb, seed)
        found = compare(first, second)
        assert found.alignment.way == "landmarks"
        change, sigma = found.levels.volume, found.levels.laid_sigma_mm3
        off.append((change.difference - true_change_mm3(found)) / (COVER * sigma))
        tip_mm = found.deviation.on_first.difference_mm[at_tip(found)]
        red = (np.abs(tip_mm) > 0.25) & ~ambiguous_vertices(found)[at_tip(found)]
        assert not red.any()
        assert COVER * sigma < 0.02 * change.first.value, "nor is everything allowed"
    assert max(np.abs(off)) < 1
    by_shape = compare(first, second, CompareOptions(registration=RegistrationOptions(way="icp")))
    assert np.nanmax(by_shape.deviation.on_first.difference_mm[at_tip(by_shape)]) > 0.5


def test_by_shape_alone_the_interval_holds_the_truth_and_the_tip_is_left_open(make_limb) -> None:
    first, second = (replace(limb, landmarks=()) for limb in pair(make_limb, 3))
    found = compare(first, second.unaligned())
    assert found.alignment.way == "icp"
    change, sigma = found.levels.volume, found.levels.laid_sigma_mm3
    off = abs(change.difference - true_change_mm3(found))
    assert 3000 < off < COVER * sigma
    assert "compare.shape.slides" in [note.code for note in found.notes]
    judged = told(verdict(found).finding)
    assert f"± {COVER * sigma / 1000:.1f} mL" in judged
    assert "± holds in 95 of 100" in judged
    tip = at_tip(found) & (np.abs(found.deviation.on_first.difference_mm) > 0.25)
    assert tip.any()
    assert ambiguous_vertices(found)[tip].all()
    wall = (found.first_in_limb.vertices_mm[:, 2] > 100) & (
        np.abs(found.deviation.on_first.difference_mm) > 1.0
    )
    assert not ambiguous_vertices(found)[wall].any(), "what was taken off the wall stays blue"


def test_both_ways_are_told_and_disagreement_in_the_headline(make_limb) -> None:
    first, second = pair(make_limb, 1)
    found = compare(first, second)
    tree = comparison_tree(found)["by_shape"]
    assert tree["alignment"]["way"] == "icp"
    assert tree["at_odds"] == found.by_shape.at_odds
    change = f"{tree['volume_ml']['difference']:+.1f}"
    assert change in " ".join(comparison_lines(found)[:2])
    # The second's marks slipped 12 mm up the limb, all alike: sure of themselves, and wrong.
    pose = Rigid(Rotation.random(random_state=1).as_matrix(), np.array([70.0, -20, 5]))
    moved = tuple(
        replace(mark, position_mm=mark.position_mm + pose.rotation @ np.array([0, 0, 12.0]))
        for mark in second.landmarks
    )
    wrong = compare(first, replace(second, landmarks=moved))
    assert wrong.alignment.way == "landmarks"
    assert wrong.by_shape.at_odds
    assert "the two ways disagree" in told(verdict(wrong).finding)


@pytest.mark.slow
def test_two_alignments_are_taken_where_the_shape_leaves_the_place_open(make_limb) -> None:
    first = make_limb()
    second = narrower(make_limb(spokes=77, rows=61, turn=0.03))
    aslant = Rigid.from_rotation_vector(np.array([0.004, 0.006, 0.01]), np.array([0.4, 0.3, 0.0]))
    mesh = second.mesh.with_vertices(aslant.apply(second.mesh.vertices_mm))
    again = replace(second, mesh=mesh)
    found = compare(first, again)
    assert found.alignment.way == "as-is"
    change = found.levels.volume
    assert change.difference == pytest.approx(true_change_mm3(found), rel=0.05)
    assert found.by_shape is not None
    assert f"{found.by_shape.volume.difference / 1000:+.1f}" in told(verdict(found).finding)
    # A front that is 40 degrees off on one of them is no good alignment.
    turned = Rigid.from_rotation_vector(np.array([0.0, 0, 0.7]), np.zeros(3))
    odd = replace(second, frame=LimbFrame(limb_from_mesh=turned, side="right"))
    assert compare(first, odd).alignment.way == "icp"


def test_landmarks_that_contradict_each_other_are_not_used(make_limb) -> None:
    first, second = pair(make_limb, 2)
    wrong = (
        replace(second.landmarks[0], position_mm=second.landmarks[3].position_mm),
        *second.landmarks[1:],
    )
    found = compare(first, replace(second, landmarks=wrong))
    assert found.alignment.way == "icp"
    assert "compare.landmarks.unlike" in [note.code for note in found.notes]


def test_repeated_captures_of_one_limb_go_by_its_shape(make_limb) -> None:
    """Marks 2 mm off tell less of an unchanged limb than its surface does."""
    rng = np.random.default_rng(5)
    scans = [marked(make_limb(), rng, 2.0)]
    scans.append(lying(marked(make_limb(spokes=77, rows=61, turn=0.03), rng, 2.0), 5))
    found = repeats(scans, CompareOptions())
    assert found.stack.alignments[0].way == "icp"
    assert compare(*scans).alignment.way == "landmarks"
