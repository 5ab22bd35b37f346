"""Acceptance tests of kits whose errors are put in and known."""

from dataclasses import replace

import numpy as np
import pytest

from limbgram.capture.acceptance import MeasuredCapture as Shown
from limbgram.capture.acceptance import accept, assign, decide, without_outcome
from limbgram.capture.artefact import (
    Artefact,
    CylinderStandard,
    LengthStandard,
    MeshStandard,
    SphereStandard,
)
from limbgram.capture.permissible_errors import Permissible, parse_limits
from limbgram.capture.probing import ProbedBody, find_spheres, surface_of
from limbgram.core.errors import MeasureError, OptionsError
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import told
from limbgram.synthetic.props.gauges import BallBar, GaugeCylinder, make_gauge
from limbgram.synthetic.props.limb import LimbKind, make_limb

BAR = Artefact(
    name="bar",
    sha256="0" * 64,
    spheres=tuple(
        SphereStandard(name=name, diameter_mm=50.0, uncertainty_mm=0.004) for name in "AB"
    ),
    lengths=(LengthStandard(first="A", second="B", length_mm=150.0, uncertainty_mm=0.006),),
)
MARKED = Artefact(
    name="marked bar",
    sha256="1" * 64,
    lengths=(
        LengthStandard(first="mark 3", second="mark 8", length_mm=300.0, uncertainty_mm=0.02),
    ),
)


def capture(mesh: Mesh, name: str = "capture 1") -> Shown:
    return Shown(
        name=name,
        id=name,
        photos=15,
        light="green",
        scale="the scale board",
        meshes=(mesh,),
        surface=surface_of([mesh]),
    )


def bar_capture(scale: float = 1.0, noise_mm: float = 0.0, name: str = "capture 1") -> Shown:
    limb = make_gauge(BallBar(), 1.2, 60.0)
    noise = np.random.default_rng(len(name)).normal(0, noise_mm, len(limb.mesh))[:, None]
    return capture(
        limb.mesh.with_vertices(scale * (limb.mesh.vertices_mm + noise * limb.normals)), name
    )


@pytest.mark.parametrize(
    ("error", "uncertainty", "expected"),
    [
        (0.09, 0.01, "pass"),
        (-0.09, 0.01, "pass"),
        (0.0901, 0.01, "cannot tell"),
        (-0.1099, 0.01, "cannot tell"),
        (0.1101, 0.01, "fail"),
        (0.1, 0.0, "pass"),
    ],
)
def test_the_artefacts_uncertainty_is_on_neither_side(
    error: float, uncertainty: float, expected: str
) -> None:
    assert decide(error, uncertainty, 0.1) == expected


def test_an_error_of_scale_is_found_in_the_spacing_and_in_the_size() -> None:
    limits = parse_limits(["0.3", "spacing=0.05"])
    found = accept(BAR, [bar_capture(1.001)], limits)
    errors = {(one.kind, one.name): one for one in found.values}
    assert errors["spacing", "A to B"].error_mm == pytest.approx(0.15, abs=1e-3)
    assert errors["size", "A"].error_mm == pytest.approx(0.05, abs=1e-3)
    assert errors["spacing", "A to B"].outcome == "fail"
    assert errors["size", "A"].outcome == "pass"
    assert found.outcome == "fail"
    assert without_outcome(found.headline).code == "kit.too_large"
    assert "sphere-spacing error" in told(found.headline)
    spread = next(one for one in found.spreads if one.kind == "spacing")
    assert spread.bias_share == pytest.approx(0.001, abs=1e-5)


def test_a_good_kit_passes_and_repeats_tell_bias_and_spread() -> None:
    captures = [
        bar_capture(scale, 0.02, f"capture {k}") for k, scale in enumerate((0.9998, 1.0002))
    ]
    found = accept(BAR, captures, parse_limits(["0.2"]))
    assert found.outcome == "pass"
    spread = next(one for one in found.spreads if one.kind == "spacing")
    assert spread.count == 2
    assert spread.bias_mm == pytest.approx(0.0, abs=5e-3)
    assert spread.spread_mm == pytest.approx(0.06 / np.sqrt(2), abs=5e-3)


def test_an_error_at_the_limit_leaves_the_test_undecided() -> None:
    found = accept(BAR, [bar_capture(1.001)], parse_limits(["spacing=0.150"]))
    assert found.outcome == "cannot tell"
    assert "nearer to the limit than the artefact is known" in told(found.headline)


def test_a_sphere_that_is_not_there_leaves_the_test_undecided() -> None:
    three = replace(
        BAR,
        spheres=(*BAR.spheres, SphereStandard(name="C", diameter_mm=30.0, uncertainty_mm=0.01)),
    )
    found = accept(three, [bar_capture()], parse_limits(["0.2"]))
    assert found.outcome == "cannot tell"
    assert [one.name for one in found.not_measured] == ["sphere C"]


def test_nothing_measured_is_a_refusal() -> None:
    cylinder = make_gauge(GaugeCylinder(), 1.5, 60.0).mesh
    with pytest.raises(MeasureError, match="Nothing of bar was measured") as refused:
        accept(BAR, [capture(cylinder)], parse_limits(["0.2"]))
    finding = refused.value.finding
    assert (finding.code, finding.values["artefact"]) == ("kit.nothing_measured", "bar")


def test_a_limit_for_nothing_on_the_artefact_is_refused() -> None:
    with pytest.raises(OptionsError, match="can test form, form-all, size, spacing"):
        accept(BAR, [bar_capture()], parse_limits(["length=0.2"]))


def test_a_cylinder_is_tested() -> None:
    artefact = Artefact(
        name="gauge",
        sha256="2" * 64,
        cylinder=CylinderStandard(name="C", diameter_mm=100.1, uncertainty_mm=0.005),
    )
    mesh = make_gauge(GaugeCylinder(), 1.5, 60.0).mesh
    found = accept(artefact, [capture(mesh)], parse_limits(["size=0.05"]))
    size = next(one for one in found.values if one.kind == "size")
    assert size.error_mm == pytest.approx(-0.1, abs=3e-3)
    assert found.outcome == "fail"


def test_lengths_between_marks_and_those_that_set_the_scale() -> None:
    shown = replace(bar_capture(), marks_mm={3: np.zeros(3), 8: np.array([0.0, 300.1, 0.0])})
    found = accept(MARKED, [shown], parse_limits(["length=0.05+L/1000"]))
    (value,) = found.values
    assert value.error_mm == pytest.approx(0.1)
    assert value.permissible_mm == pytest.approx(0.35)
    assert found.outcome == "pass"
    used = replace(shown, gave_scale=(frozenset((8, 3)),))
    with pytest.raises(MeasureError, match="set the scale"):
        accept(MARKED, [used], parse_limits(["0.2"]))


CAST = Artefact(
    name="cast",
    sha256="3" * 64,
    mesh=MeshStandard(name="cast 3", file="", uncertainty_mm=0.01),
)


def test_a_surface_against_its_calibrated_mesh() -> None:
    limb = make_limb(LimbKind.TRANSTIBIAL, 4, 6.0, 60.0).mesh
    grown = limb.with_vertices(limb.vertices_mm + 0.2 * limb.vertex_normals())
    found = accept(CAST, [capture(grown)], parse_limits(["surface=0.1"]), limb)
    (value,) = found.values
    assert value.kind == "surface"
    assert value.error_mm == pytest.approx(0.2, abs=0.05)
    assert found.outcome == "fail"


def test_a_scrap_of_the_calibrated_mesh_proves_no_kit() -> None:
    limb = make_limb(LimbKind.TRANSTIBIAL, 4, 6.0, 60.0).mesh
    around = np.arctan2(*limb.vertices_mm[:, :2].T)
    for share, judged in ((0.3, False), (0.8, True)):
        kept = np.abs(around) < share * np.pi
        part = Mesh(vertices_mm=limb.vertices_mm, faces=limb.faces[kept[limb.faces].all(axis=1)])
        used, faces = np.unique(part.faces, return_inverse=True)
        part = Mesh(vertices_mm=limb.vertices_mm[used], faces=faces.reshape(-1, 3).astype(np.int32))
        if judged:
            found = accept(CAST, [capture(part)], parse_limits(["surface=0.1"]), limb)
            assert found.outcome == "pass"
            assert found.bodies[0].seen == pytest.approx(share, abs=0.1)
        else:
            with pytest.raises(MeasureError, match="50% are needed"):
                accept(CAST, [capture(part)], parse_limits(["surface=0.1"]), limb)


def test_alike_spheres_are_told_apart_by_their_distances() -> None:
    limb = make_gauge(BallBar(), 1.5, 60.0).mesh
    probed = find_spheres(surface_of([limb]), 50.0)[0]

    def at(x: float, y: float) -> ProbedBody:
        return replace(probed, middle_mm=np.array([x, y, 0.0]))

    spheres = [at(0, 0), at(150, 0), at(0, 90), at(400, 400)]  # the last one is none of them
    artefact = replace(
        BAR,
        spheres=tuple(
            SphereStandard(name=name, diameter_mm=50.0, uncertainty_mm=0.0) for name in "ABC"
        ),
        lengths=(
            LengthStandard(first="A", second="B", length_mm=90.0, uncertainty_mm=0.0),
            LengthStandard(first="B", second="C", length_mm=174.93, uncertainty_mm=0.0),
            LengthStandard(first="A", second="C", length_mm=150.0, uncertainty_mm=0.0),
        ),
    )
    chosen = assign(artefact, dict.fromkeys("ABC", spheres))
    places = {name: tuple(one.middle_mm[:2]) for name, one in chosen.items()}
    assert places == {"A": (0, 0), "B": (0, 90), "C": (150, 0)}


@pytest.mark.parametrize("text", ["", "x=0.2", "0", "-1", "size=", "0.1+L", "1.2.3", "nan"])
def test_no_permissible_error(text: str) -> None:
    with pytest.raises(OptionsError):
        parse_limits([text])


def test_a_kind_counts_before_what_is_for_all() -> None:
    limits = parse_limits(["size=0.1", "0.3", "length = 0.05 + L/1000"])
    assert limits["size"] == Permissible(base_mm=0.1)
    assert limits["form"].at(0.0) == 0.3
    assert limits["length"].at(500.0) == pytest.approx(0.55)
    assert "form-all" not in limits  # one stray point decides it: only who names it wants it
    with pytest.raises(OptionsError, match="No permissible error"):
        parse_limits([])
