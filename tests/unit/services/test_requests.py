"""What requests say of their fields is what every door takes."""

from dataclasses import replace
from datetime import date
from typing import Any

import numpy as np
import pytest
import trimesh
import typer
from typer.testing import CliRunner

from limbgram.cli.request_options import asking
from limbgram.core.errors import LimbgramError, OptionsError
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.request_fields import words_of
from limbgram.core.typed import Mismatch, value_of
from limbgram.services.align import AlignRequest
from limbgram.services.compare import CompareRequest, FollowRequest
from limbgram.services.measure import MeasureRequest, measure
from limbgram.services.report import ReportRequest
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.tape import TapeReading

MEASURES = MeasureRequest(
    every_mm=12.5,
    heights_mm=(-20.0, 30.1),
    reference="patella",
    volumes=((20.0, 150.5), (None, 80.0), (0.0, None)),
    lengths=(("patella", "tibia end"),),
    through="left knee",
    sock_mm=0.3,
    tapes=(
        TapeReading(height_mm=-150.0, girth_mm=354.2),
        TapeReading(height_mm=60.0, girth_mm=312.0, sigma_mm=1.0),
    ),
    unaligned=True,
)
ALIGNED = AlignRequest(
    side="left",
    kind="foot",
    axis=(0.1, -0.2, 0.9),
    proximal=(0.0, 0.0, -1.0),
    anterior=(0.0, 1.0, 0.0),
    plumb=("hip", "ankle"),
    flexion_deg=-5.5,
)


@pytest.mark.parametrize(
    "ask",
    [
        MEASURES,
        ALIGNED,
        replace(ALIGNED, axis="fit"),
        CompareRequest(align="landmarks", weights=(("fibula head", 0.5), ("a=b", 0.0))),
        FollowRequest(days=(date(2026, 1, 31), date(2026, 3, 1)), repeatability_per_cent=0.5),
        ReportRequest(align="as-is", every_mm=5.0, reference="patella"),
    ],
    ids=lambda ask: type(ask).__name__,
)
def test_a_request_that_is_typed_as_words_is_asked_as_it_was(ask: Any) -> None:
    heard: list[Any] = []
    app = typer.Typer()

    def command(again: Any) -> None:
        heard.append(again)

    command.__annotations__["again"] = type(ask)
    app.command()(asking(command))
    done = CliRunner().invoke(app, words_of(ask))
    assert done.exit_code == 0, done.output
    assert heard == [ask]


def test_a_file_may_have_a_value_as_a_text_or_in_its_parts() -> None:
    as_texts = {
        "volumes": ["20:150.5", "end:80", "0:end"],
        "lengths": ["patella:tibia end"],
        "tapes": ["-150=354.2", "60=312+-1.96"],
    }
    in_parts = {
        "volumes": [[20, 150.5], [None, 80], [0, None]],
        "lengths": [["patella", "tibia end"]],
        "tapes": [
            {"height_mm": -150, "girth_mm": 354.2},
            {"height_mm": 60, "girth_mm": 312, "sigma_mm": 1},
        ],
    }
    wanted = MeasureRequest(
        volumes=MEASURES.volumes, lengths=MEASURES.lengths, tapes=MEASURES.tapes
    )
    assert value_of(as_texts, MeasureRequest) == value_of(in_parts, MeasureRequest) == wanted


@pytest.mark.parametrize(
    ("tree", "place"),
    [
        ({"volumes": ["20:150", "80:20"]}, r"measure.volumes\[1\]: '80:20' are no two heights"),
        ({"tapes": ["150"]}, r"measure.tapes\[0\]: '150' is no tape reading"),
        ({"every_mm": 0}, "measure.every_mm must lie between"),
        ({"heights_mm": [9000]}, r"measure.heights_mm\[0\] must lie between"),
        ({"csv": "table.csv"}, "measure has no csv"),
    ],
)
def test_what_cannot_be_meant_is_refused_with_its_place(tree: dict[str, Any], place: str) -> None:
    with pytest.raises(Mismatch, match=place):
        value_of(tree, MeasureRequest, "measure")


@pytest.mark.parametrize("height_mm", [float("nan"), float("inf"), 1e9])
def test_a_tape_at_no_height_is_refused(height_mm: float) -> None:
    solid = trimesh.creation.cylinder(radius=50.0, height=200.0)
    limb = Limb(mesh=Mesh(vertices_mm=solid.vertices, faces=solid.faces.astype(np.int32)))
    reading = TapeReading(height_mm=height_mm, girth_mm=300.0)
    with pytest.raises(LimbgramError):
        measure(limb, MeasureRequest(unaligned=True, tapes=(reading,)))


def test_weights_go_with_landmarks_only() -> None:
    with pytest.raises(OptionsError, match="--align landmarks only"):
        CompareRequest(weights=(("patella", 0.5),)).options()
    options = CompareRequest(align="landmarks", weights=(("patella", 0.5),)).options()
    assert options.registration.landmark_weights == {"patella": 0.5}


def test_an_axis_that_is_to_be_fitted_goes_over_that_of_the_file() -> None:
    assert replace(ALIGNED, axis="fit").options(None).fit_anew
    stated = ALIGNED.options(None)
    assert not stated.fit_anew
    np.testing.assert_array_equal(stated.axis, (0.1, -0.2, 0.9))
