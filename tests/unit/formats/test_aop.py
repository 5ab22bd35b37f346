"""AOP: numbers known beforehand, every form of the grammar, and every way in which it is broken."""

import codecs
from dataclasses import replace
from itertools import product
from pathlib import Path

import numpy as np
import pytest

from limbgram.core.errors import MeasureError, ShapeFileError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.sections import cut
from limbgram.core.mesh.topology import is_edge_manifold, volume_mm3
from limbgram.core.mesh.tree_cache import tree_on
from limbgram.findings import doubt, note
from limbgram.formats.aop.grammar import parse_aop
from limbgram.formats.aop.reading import read_aop, read_aop_soup
from limbgram.formats.aop.writing import write_aop
from limbgram.formats.export_checks import in_limb_frame
from limbgram.formats.limb_file import write_limb_file
from limbgram.formats.reading import read_limb, read_shape
from limbgram.services.align import AlignRequest, align
from limbgram.workbench.limb import AlignedLimb

RADII = (50, 60, 50, 40)


def tiny(
    *,
    end: str = "\n",
    spokes: tuple[str, ...] = ("4", "90"),
    slices: tuple[str, ...] = ("3", "10"),
    marks: tuple[str, ...] = ("1", "FIB", "1", "2.362", "90", "10"),
    comments: tuple[str, ...] = (),
    side: str = "RIGHT",
) -> bytes:
    """Four spokes and three slices: a square block turned on its corner."""
    lines = ["AAOP1", "AAOP1", *comments, "END COMMENTS", "CYLINDRICAL", side]
    lines += [*marks, *spokes, *slices, *(str(radius) for radius in RADII * 3)]
    return end.join([*lines, ""]).encode("latin-1")


def test_the_tiny_vector() -> None:
    found = read_aop(tiny(), "tiny.aop")
    ring = np.array([[0, 50], [60, 0], [0, -50], [-40, 0]], float)
    for level, z in enumerate((0, 10, 20)):
        expected = np.column_stack([ring, np.full(4, z)])
        np.testing.assert_allclose(found.radius_map.points_mm()[level], expected, atol=1e-12)
    mesh = found.radius_map.surface()
    assert volume_mm3(mesh) == pytest.approx(100_000.0, rel=1e-12)
    (section,) = cut(mesh, [5.0])
    assert section.length_mm == pytest.approx(2 * np.hypot(50, 60) + 2 * np.hypot(50, 40))
    assert section.length_mm == pytest.approx(284.267, abs=5e-4)
    assert section.area_mm2(np.array([0.0, 0, 1])) == pytest.approx(5000.0)
    np.testing.assert_allclose(found.landmarks[0].position_mm, (60.0, 0, 10), atol=0.006)
    assert found.mm_per_landmark_radius == 25.4
    assert found.profile == "omega"
    assert found.frame.side == "right"
    assert found.warnings == ()


def test_millimetre_landmarks_are_told_apart() -> None:
    found = read_aop(tiny(marks=("1", "FIB", "1", "60", "90", "10")), "tiny.aop")
    assert found.mm_per_landmark_radius == 1.0
    np.testing.assert_allclose(found.landmarks[0].position_mm, (60.0, 0, 10), atol=1e-12)


@pytest.mark.parametrize(("unit", "radius"), [("MM", 2.0), ("IN", 50.8)])
def test_our_comment_tells_the_unit(unit: str, radius: float) -> None:
    content = tiny(
        marks=("1", "DEEP", "1", "2", "90", "10"), comments=(f"LANDMARK RADIUS UNIT: {unit}",)
    )
    found = read_aop(content, "tiny.aop")
    np.testing.assert_allclose(found.landmarks[0].position_mm, (radius, 0, 10), atol=1e-9)
    assert found.warnings == ()  # a landmark inside the limb is one


def test_a_radius_in_no_unit_is_put_on_the_surface_and_told() -> None:
    found = read_aop(tiny(marks=("1", "MPT", "1", "303.2", "180", "10")), "tiny.aop")
    np.testing.assert_allclose(found.landmarks[0].position_mm, (0, -50, 10), atol=1e-9)
    assert found.warnings == (doubt("aop.landmark_unit", landmark="MPT", radius=303.2),)


@pytest.mark.parametrize("end", ["\n", "\r", "\r\n"])
@pytest.mark.parametrize("suffix", [".aop", ".AOP"])
def test_lines_may_end_in_any_way(tmp_path: Path, end: str, suffix: str) -> None:
    path = tmp_path / f"tiny{suffix}"
    path.write_bytes(tiny(end=end))
    limb = read_limb(path)
    assert volume_mm3(limb.mesh) == pytest.approx(100_000.0)
    assert limb.frame.side == "right"
    assert [mark.name for mark in limb.landmarks] == ["FIB"]


def test_line_ends_may_be_mixed() -> None:
    content = tiny().replace(b"\n", b"\r", 4).replace(b"\n", b"\r\n", 6)
    assert read_aop(content, "mixed.aop").radius_map.radii_mm.shape == (3, 4)


def test_an_editors_byte_order_mark_is_no_damage() -> None:
    assert read_aop(codecs.BOM_UTF8 + tiny(), "a.aop").radius_map.radii_mm.shape == (3, 4)


def test_names_with_blanks_lines_of_points_and_no_side() -> None:
    marks = ("2", "Patella Tendon Bar ", "1", "50", "0", "5", "TIB ", "2")
    marks += ("50", "0", "0", "50", "180", "20")
    found = read_aop(tiny(marks=marks, side="NONE"), "tiny.aop")
    assert [mark.name for mark in found.landmarks] == ["Patella Tendon Bar", "TIB 1", "TIB 2"]
    np.testing.assert_allclose(found.landmarks[2].position_mm, (0, -50, 20), atol=1e-9)
    assert found.frame.side == "none"
    assert read_aop(tiny(marks=("0",)), "tiny.aop").landmarks == ()


def test_landmarks_of_one_name_are_both_kept_and_told() -> None:
    marks = ("4", "FIB", "1", "50", "0", "5", "FIB", "1", "60", "90", "10", "TIB 1", "1", "50", "0")
    marks += ("10", "TIB", "2", "50", "0", "0", "50", "180", "20")
    found = read_aop(tiny(marks=marks), "tiny.aop")
    names = [mark.name for mark in found.landmarks]
    assert names == ["FIB", "FIB (2)", "TIB 1", "TIB 1 (2)", "TIB 2"]
    np.testing.assert_allclose(found.landmarks[0].position_mm, (0, 50, 5), atol=1e-9)
    np.testing.assert_allclose(found.landmarks[1].position_mm, (60, 0, 10), atol=1e-9)
    assert note("aop.landmark_twice", landmark="FIB", called="FIB (2)") in found.warnings


def test_foreign_letters_do_not_stop_it() -> None:
    content = tiny(comments=("Müller, Söhne",), marks=("1", "Höhe\x07", "1", "50", "0", "5"))
    assert read_aop(content, "tiny.aop").landmarks[0].name == "Höhe"


FORMS = list(
    product(
        [("4", "90"), ("4", "0", "0", "90", "180", "270")],
        [("3", "10"), ("3", "0", "0", "10", "20")],
    )
)


@pytest.mark.parametrize(("spokes", "slices"), FORMS)
def test_four_forms_of_header_give_one_surface(
    spokes: tuple[str, ...], slices: tuple[str, ...]
) -> None:
    found = read_aop(tiny(spokes=spokes, slices=slices), "tiny.aop").radius_map
    expected = read_aop(tiny(), "tiny.aop").radius_map
    np.testing.assert_array_equal(found.points_mm(), expected.points_mm())


def test_a_second_number_on_a_line_is_no_radius() -> None:
    content = tiny().replace(b"\n60\n", b"\n60 0.75\n").replace(b"\n40\n", b"\n4.0E1\n")
    expected = read_aop(tiny(), "tiny.aop").radius_map
    found = read_aop(content, "tiny.aop").radius_map
    np.testing.assert_array_equal(found.radii_mm, expected.radii_mm)


def test_what_is_odd_is_told() -> None:
    open_turn = read_aop(tiny(spokes=("4", "80")), "t").warnings
    assert open_turn == (note("aop.not_one_turn", spokes=4, spacing_deg=80.0),)
    half = ("4", "0", "0", "60", "120", "180")
    listed = read_aop(tiny(spokes=half, marks=("0",)), "t").warnings
    assert listed == (note("aop.not_one_turn", spokes=4, spacing_deg=60.0),)
    longer = read_aop(tiny() + b"more\nand more\n", "t").warnings
    assert longer == (note("aop.lines_left_out", lines=2),)


def test_a_shape_that_ends_in_points_closes() -> None:
    points = tiny().replace(b"\n50\n60\n50\n40\n", b"\n0\n0\n0\n0\n", 1)
    content = points[: points.rindex(b"50\n60\n50\n40\n")] + b"0\n0\n0\n0\n"
    mesh = read_aop(content, "tiny.aop").radius_map.surface()
    assert is_edge_manifold(mesh.faces)
    assert volume_mm3(mesh) == pytest.approx(2 * 5000 * 10 / 3)
    assert len(mesh) == 6  # two tips and a ring


def test_ampscans_files_stand_one_spoke_behind() -> None:
    found = read_aop(tiny(comments=("Exported from ampscan",), marks=("0",)), "tiny.aop")
    assert found.profile == "ampscan"
    assert found.warnings == (doubt("aop.ampscan_turn", early=False), doubt("aop.front_left_open"))
    assert not found.frame.front_told
    # Its first radius, 50, lies one spacing after the front: at the patient's right.
    np.testing.assert_allclose(found.radius_map.points_mm()[0, 1], (50, 0, 0), atol=1e-9)
    np.testing.assert_allclose(found.radius_map.points_mm()[0, 0], (0, 40, 0), atol=1e-9)


def test_early_ampscan_files_count_the_other_way_and_are_told() -> None:
    comments = ("Exported from ampscan",)
    content = tiny(comments=comments, marks=("0",), slices=("3", "0", "0", "10", "20"))
    found = read_aop(content, "tiny.aop")
    assert found.profile == "ampscan-early"
    np.testing.assert_allclose(found.radius_map.points_mm()[0, 3], (-60, 0, 0), atol=1e-9)
    assert found.warnings == (doubt("aop.ampscan_turn", early=True), doubt("aop.front_left_open"))
    with pytest.raises(ShapeFileError, match="mirrored"):
        read_aop(tiny(comments=comments, spokes=FORMS[2][0]), "tiny.aop")


BROKEN = {
    "BAOP1": (1, "AAOP1", "BAOP1"),
    "SPHERICAL": (4, "CYLINDRICAL", "SPHERICAL"),
    "FRONT": (5, "RIGHT", "FRONT"),
    "-1": (6, "\n1\nFIB", "\n-1\nFIB"),
    "many": (6, "\n1\nFIB", "\n999999\nFIB"),
    "1.5": (6, "\n1\nFIB", "\n1.5\nFIB"),
    "nan": (9, "2.362", "nan"),
    "1e308": (10, "\n90\n10\n", "\n1e308\n10\n"),
    "two spokes": (12, "\n4\n90\n", "\n2\n90\n"),
    "spokes": (12, "\n4\n90\n", "\n3601\n90\n"),
    "slices": (14, "\n3\n10\n", "\n999999999999\n10\n"),
    "spacing": (15, "\n3\n10\n", "\n3\n-10\n"),
    "radius": (17, "\n60\n", "\n-60\n"),
    "inf": (17, "\n60\n", "\ninf\n"),
    "word": (17, "\n60\n", "\nsixty\n"),
    "blank": (17, "\n60\n", "\n\n"),
    "three": (17, "\n60\n", "\n60 1 2\n"),
}


@pytest.mark.parametrize("case", BROKEN)
def test_a_broken_line_is_named_with_its_number(case: str) -> None:
    line, old, new = BROKEN[case]
    content = tiny().decode().replace(old, new, 1).encode()
    with pytest.raises(ShapeFileError, match=f"bad.aop, line {line}: expected .*, found "):
        parse_aop(content, "bad.aop")


@pytest.mark.parametrize("number", ["nan", "inf", "-inf"])
def test_an_axis_that_lies_nowhere_is_not_taken(number: str) -> None:
    said = f"LIMB FROM FILE: 1 0 0 {number} 0 1 0 0 0 0 1 0"
    found = read_aop(tiny(comments=(said,)), "tiny.aop")
    np.testing.assert_array_equal(found.frame.limb_from_mesh.translation, np.zeros(3))
    assert doubt("aop.axis_place") in found.warnings


@pytest.mark.parametrize("with_limb_file", [False, True])
def test_a_file_in_inches_keeps_its_axis_in_the_limb(tmp_path: Path, with_limb_file: bool) -> None:
    """The axis of the file lies 5 and 7 inches beside the limb's: it had stayed 5 and 7 mm."""
    said = "LIMB FROM FILE: 1 0 0 5 0 1 0 7 0 0 1 2"
    tenfold = tiny(comments=(said,), marks=("1", "FIB", "1", "60", "90", "10"))
    path = tmp_path / "tiny.aop"
    path.write_bytes(
        tenfold.replace(b"\n50\n60\n50\n40", b"\n5\n6\n5\n4").replace(
            b"\n60\n90\n10", b"\n6\n90\n10"
        )
    )
    if with_limb_file:
        write_limb_file(read_limb(path, 25.4), path, mm_per_unit=25.4)
    shape = read_shape(path, None if with_limb_file else 25.4)
    limb = shape.limb.aligned()
    low = limb.in_limb_frame().mesh.vertices_mm.min(0)
    high = limb.in_limb_frame().mesh.vertices_mm.max(0)
    np.testing.assert_allclose(low, 25.4 * np.array([5 - 4, 7 - 5, 2]), rtol=1e-9)
    np.testing.assert_allclose(high, 25.4 * np.array([5 + 6, 7 + 5, 22]), rtol=1e-9)
    assert shape.declared is not None
    np.testing.assert_allclose(
        shape.declared.limb_from_mesh.translation, 25.4 * np.array([5, 7, 2]), rtol=1e-12
    )
    assert shape.grid is None


def test_places_must_rise() -> None:
    with pytest.raises(ShapeFileError, match="line 18: expected rising slices, found '5'"):
        parse_aop(tiny(slices=("3", "0", "0", "10", "5")), "bad.aop")
    with pytest.raises(ShapeFileError, match="within one turn"):
        parse_aop(tiny(spokes=("4", "0", "0", "90", "180", "360")), "bad.aop")


REAL = {"Example.AOP": 1766.9, "stl_file.aop": 1609.9, "stl_file_2.aop": 1637.3}


@pytest.mark.parametrize("name", REAL)
def test_real_files(data_folder: Path, name: str) -> None:
    limb = read_limb(data_folder / "shapes" / "ampscan" / name)
    assert volume_mm3(limb.mesh) / 1000 == pytest.approx(REAL[name], abs=0.1)
    assert is_edge_manifold(limb.mesh.faces)
    # Only the file of the trade, which names no writer, tells its front.
    assert (not isinstance(limb, AlignedLimb)) == name.startswith("stl_file")
    codes = [one.code for one in limb.notes]
    assert ("aop.front_left_open" in codes) == (not isinstance(limb, AlignedLimb))
    assert "aop.front_taken" not in codes  # its landmarks tell the front


def test_a_front_that_no_writer_and_no_landmark_tells_is_noted() -> None:
    nobody = read_aop_soup(tiny(marks=("0",)), "tiny.aop").notes
    assert nobody == (note("aop.front_taken"),)
    ours = read_aop_soup(tiny(marks=("0",), comments=("UNIT: MM",)), "tiny.aop").notes
    assert ours == ()
    crest = ("1", "tibial crest", "1", "50", "0", "10")
    assert read_aop_soup(tiny(marks=crest), "tiny.aop").notes == ()


@pytest.mark.parametrize("name", ["stl_file", "stl_file_2"])
def test_a_file_of_ampscan_is_turned_to_its_shape_by_saying_where_the_front_lies(
    data_folder: Path, tmp_path: Path, name: str
) -> None:
    """The STL stood in ampscan with +Y in front; read as it stands, the AOP is back to front."""
    folder = data_folder / "shapes" / "ampscan"
    read = read_shape(folder / f"{name}.aop")
    ask = AlignRequest(side="none")
    with pytest.raises(MeasureError) as refused:
        align(read.limb, ask, read.declared)
    assert refused.value.finding.code == "align.front.left_open"
    surface = read_limb(folder / f"{name}.stl").mesh
    turned = align(read.limb, replace(ask, anterior=(0.0, -1.0, 0.0)), read.declared)
    assert _off_mm(in_limb_frame(turned).mesh.vertices_mm, surface) < 0.5
    kept = align(read.limb, replace(ask, anterior=(0.0, 1.0, 0.0)), read.declared)
    assert _off_mm(in_limb_frame(kept).mesh.vertices_mm, surface) > 4
    # Written by us, its front is told, and a second reading has it where it is.
    report = write_aop(turned, tmp_path / "ours.aop")
    again = read_limb(report.path)
    assert _off_mm(in_limb_frame(again).mesh.vertices_mm, surface) < 0.5


def _off_mm(points: np.ndarray, surface: Mesh) -> float:
    """RMS distance between the tip and the brim, shifted as near as can be: not turned."""
    height = np.ptp(points[:, 2])
    low = points[:, 2].min()
    points = points[(points[:, 2] > low + 0.15 * height) & (points[:, 2] < low + 0.9 * height)]
    tree = tree_on(surface)
    shift = np.array([0.0, 0.0, surface.vertices_mm[:, 2].min() - low])
    found = tree.closest(points + shift)
    for _ in range(15):
        shift = shift + (found.points_mm - (points + shift)).mean(0)
        found = tree.closest(points + shift)
    return float(np.sqrt((found.distances_mm**2).mean()))


def test_no_number_of_a_file_is_beyond_a_hundred_metres() -> None:
    read_aop(tiny(slices=("3", "100000")), "tiny.aop")
    with pytest.raises(ShapeFileError, match=r"100000"):
        read_aop(tiny(slices=("3", "100001")), "tiny.aop")


def test_a_file_has_ten_thousand_comments_at_most() -> None:
    read_aop(tiny(comments=("of a program",) * 9999), "tiny.aop")  # and the second AAOP1
    with pytest.raises(ShapeFileError) as refused:
        read_aop(tiny(comments=("of a program",) * 10_000), "tiny.aop")
    assert refused.value.finding.code == "aop.line"


@pytest.mark.parametrize(("radius", "told"), [("62.9", False), ("63.1", True)])
def test_a_landmark_lies_within_3_mm_of_the_surface(radius: str, told: bool) -> None:
    """The surface is 60 mm from the axis there."""
    found = read_aop(tiny(marks=("1", "FIB", "1", radius, "90", "10")), "tiny.aop")
    assert bool(found.warnings) == told


@pytest.mark.parametrize(
    ("third", "profile"), [("20.0099", "ampscan-early"), ("20.011", "ampscan")]
)
def test_listed_heights_are_even_within_a_thousandth_of_their_spacing(
    third: str, profile: str
) -> None:
    listed = ("3", "0", "0", "10", third)
    found = read_aop(tiny(comments=("ampscan",), slices=listed, marks=("0",)), "tiny.aop")
    assert found.profile == profile
