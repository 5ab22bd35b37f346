"""Several bodies are told to people; a single one is not."""

from typing import Any

from limbgram.report.parts import part_lines, parts_section

OUTSIDE: dict[str, Any] = {
    "number": 1,
    "relation": "chosen",
    "name": "the surface",
    "area": 64_100.0,
    "middle": [1.0, 2.0, 70.2],
    "size": 151.0,
    "file": "surface.stl",
    "reason": "",
}
INSIDE = {
    **OUTSIDE,
    "number": 2,
    "relation": "other side",
    "name": "the other side of its wall",
    "area": 52_340.0,
    "file": "surface-part-2.stl",
}


def test_one_body_is_not_told() -> None:
    assert part_lines([OUTSIDE], "mm") == ()
    assert parts_section([OUTSIDE], "mm") == ""


def test_each_of_several_is_told_with_area_place_and_file() -> None:
    first, outside, inside = part_lines([OUTSIDE, INSIDE], "mm")
    assert "2 bodies" in first
    assert "--part" in first
    place = "round x 1, y 2, z 70 mm, 151 mm long (surface.stl)"
    assert outside == f"  part 1: the surface, 641 cm\N{SUPERSCRIPT TWO}, {place}"
    assert "the other side of its wall, 523 cm" in inside
    page = parts_section([OUTSIDE, INSIDE], "mm")
    assert "surface-part-2.stl" in page
    assert page.count("<tr") == 3


def test_a_part_that_could_not_be_measured_says_why() -> None:
    failed = {**INSIDE, "file": None, "reason": "Hardly a place looks alike."}
    assert part_lines([OUTSIDE, failed], "mm")[2].endswith(". Hardly a place looks alike.")
    assert "Hardly a place looks alike." in parts_section([OUTSIDE, failed], "mm")


def test_areas_without_scale_are_no_square_centimetres() -> None:
    assert "cm" not in " ".join(part_lines([OUTSIDE, INSIDE], "unitless"))
