"""Artefact files: what is read, and what is refused with its place."""

import json
from pathlib import Path

import pytest
from tests.unit.file_sizes import require_takes_up_to

from limbgram.capture.artefact import read_artefact
from limbgram.core.errors import CaseError
from limbgram.findings import Finding
from limbgram.synthetic.props.gauges import BallBar, Gauge, GaugeCylinder, calibrated_values

GOOD = """
format = "limbgram artefact"
version = 1
name = "Ball bar 12"
certificate = "4711"
spheres = [
    {name = "A", diameter_mm = 50.012, uncertainty_mm = 0.004, form_mm = 0.003},
    {name = "B", diameter_mm = 50.009, uncertainty_mm = 0.004},
]
lengths = [
    {first = "A", second = "B", length_mm = 150.004, uncertainty_mm = 0.006},
    {first = "mark 7", second = "mark 9", length_mm = 400.0, uncertainty_mm = 0.05},
]
mesh = {name = "foot", file = "foot.stl", uncertainty_mm = 0.02}
"""


def written(folder: Path, text: str) -> Path:
    path = folder / "bar.toml"
    path.write_text(text)
    return path


def test_a_file_is_read(tmp_path: Path) -> None:
    path = written(tmp_path, GOOD)
    path.write_text(GOOD, "utf-8-sig")  # an editor's byte order mark
    found = read_artefact(path)
    assert [one.diameter_mm for one in found.spheres] == [50.012, 50.009]
    assert [one.name for one in found.spacings] == ["A to B"]
    assert [one.mark_ids for one in found.between_marks] == [(7, 9)]
    assert found.mesh is not None
    assert found.mesh.file == str(tmp_path / "foot.stl")
    assert found.gap_mm == pytest.approx(150.004 - 50.009 / 2)


@pytest.mark.parametrize(
    ("old", "new", "told"),
    [
        ("diameter_mm = 50.012", "diameter_mm = 0.05", "the diameter of A is 0.05 mm"),
        (
            "diameter_mm = 50.012",
            'diameter_mm = "50"',
            r"spheres\[0\].diameter_mm must be a number",
        ),
        ("uncertainty_mm = 0.006", "uncertainty_mm = 20.0", "the uncertainty of A to B is 20 mm"),
        ('second = "B"', 'second = "D"', "ends at D, which is no sphere"),
        ('second = "B"', 'second = "A"', "begins where it ends"),
        ('name = "B"', 'name = "A"', "the same name"),
        ("form_mm = 0.003", "form_mm = 9.0", "which no calibrated body has"),
        ("version = 1", "version = 2", "version must be 1"),
        ("limbgram artefact", "artefact", "format must be limbgram artefact"),
        ('certificate = "4711"', "colour = 1", "has no colour"),
    ],
)
def test_what_cannot_be_is_refused(tmp_path: Path, old: str, new: str, told: str) -> None:
    assert old in GOOD
    with pytest.raises(CaseError, match=told):
        read_artefact(written(tmp_path, GOOD.replace(old, new)))


def test_a_file_is_read_up_to_a_megabyte(tmp_path: Path) -> None:
    require_takes_up_to(read_artefact, tmp_path / "bar.toml", 1_000_000)


@pytest.mark.parametrize(
    ("old", "least", "beyond", "code"),
    [
        ("uncertainty_mm = 0.006", 7.5, 7.6, "kit.artefact.uncertainty"),  # 5 % of 150 mm
        ("uncertainty_mm = 0.02", 1.0, 1.01, "kit.artefact.mesh"),
        ("form_mm = 0.003", 2.5, 2.51, "kit.artefact.form"),  # 5 % of 50 mm
    ],
)
def test_a_calibrated_value_is_sure_to_its_share(
    tmp_path: Path, old: str, least: float, beyond: float, code: str
) -> None:
    name = old.partition(" ")[0]
    read_artefact(written(tmp_path, GOOD.replace(old, f"{name} = {least}")))
    with pytest.raises(CaseError) as refused:
        read_artefact(written(tmp_path, GOOD.replace(old, f"{name} = {beyond}")))
    reason = refused.value.finding.values["reason"]
    assert isinstance(reason, Finding)
    assert reason.code == code


def test_an_artefact_has_twelve_spheres_at_most(tmp_path: Path) -> None:
    head = 'format = "limbgram artefact"\nversion = 1\nname = "Plate"\n'
    one = '[[spheres]]\nname = "S{0}"\ndiameter_mm = 30.0\nuncertainty_mm = 0.01\n'
    plate = [head + "".join(one.format(k) for k in range(count)) for count in (12, 13)]
    assert len(read_artefact(written(tmp_path, plate[0])).spheres) == 12
    with pytest.raises(CaseError, match="13 spheres"):
        read_artefact(written(tmp_path, plate[1]))


@pytest.mark.parametrize("gauge", [BallBar(), GaugeCylinder(diameter_mm=80.0)])
def test_a_rendered_gauge_has_its_own_artefact_file(tmp_path: Path, gauge: Gauge) -> None:
    path = tmp_path / "artefact.json"
    path.write_text(json.dumps(calibrated_values(gauge)))
    found = read_artefact(path)
    sizes = [one.diameter_mm for one in found.spheres] or [
        found.cylinder.diameter_mm if found.cylinder is not None else 0.0
    ]
    assert set(sizes) == {gauge.diameter_mm}
    assert [one.length_mm for one in found.lengths] == (
        [gauge.spacing_mm] if isinstance(gauge, BallBar) else []
    )


def test_an_artefact_of_nothing_is_refused(tmp_path: Path) -> None:
    with pytest.raises(CaseError, match="no spheres, no lengths"):
        read_artefact(
            written(tmp_path, 'format = "limbgram artefact"\nversion = 1\nname = "nothing"')
        )


@pytest.mark.parametrize(
    ("old", "within", "beyond"),
    [
        # A twentieth of 50.012 mm is 2.5006 mm, of 400 mm 20 mm.
        ("uncertainty_mm = 0.004, form_mm", "uncertainty_mm = 2.5, form_mm",
         "uncertainty_mm = 2.51, form_mm"),
        ("form_mm = 0.003", "form_mm = 2.5", "form_mm = 2.51"),
        ("uncertainty_mm = 0.05", "uncertainty_mm = 19.9", "uncertainty_mm = 20.1"),
    ],
)  # fmt: skip
def test_a_calibrated_value_is_known_to_a_twentieth_of_it(
    tmp_path: Path, old: str, within: str, beyond: str
) -> None:
    read_artefact(written(tmp_path, GOOD.replace(old, within)))
    with pytest.raises(CaseError):
        read_artefact(written(tmp_path, GOOD.replace(old, beyond)))
