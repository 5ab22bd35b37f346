"""Drawings put points where they are, turned as people hold the photo."""

import json
import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from limbgram.core.geometry.frames import Rigid
from limbgram.core.geometry.lens import Camera, View
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.typed import Mismatch, tree_of
from limbgram.findings import note, told
from limbgram.reconstruction.budget import Resolution
from limbgram.reconstruction.photos.photo import Exif, Photo, SetAside
from limbgram.reconstruction.scale.metric import LengthCheck, Scale
from limbgram.report.case import case_report
from limbgram.report.drawings.drawing import Picture
from limbgram.report.drawings.photographs import _side_by_side, _upright, drawn_part
from limbgram.report.drawings.surfaces import _frustum
from limbgram.report.html import html_of
from limbgram.report.pictures import Pictures
from limbgram.report.summary import (
    CloudSummary,
    LengthSummary,
    MatchSummary,
    MeshSummary,
    PhotoSummary,
    ScaleSummary,
    SceneSummary,
    StageSummary,
    Summary,
    Verdict,
    facts,
    mesh_figures,
    summary_of,
)
from limbgram.report.verdict_light import Light


@pytest.mark.parametrize("turns", [0, 1, 2, 3])
@pytest.mark.parametrize("size", [(60, 40), (2400, 1600)])
def test_a_point_stays_on_its_spot_when_the_photo_is_turned(
    tmp_path: Path, turns: int, size: tuple[int, int]
) -> None:
    width, height = size
    pixels = np.zeros((height, width, 3), np.uint8)
    side = height // 10
    pixels[2 * side : 3 * side, 7 * side : 8 * side] = 255
    Image.fromarray(pixels).save(tmp_path / "a.png")
    photo = Photo(
        name="a.png",
        path=tmp_path / "a.png",
        width_px=width,
        height_px=height,
        exif=Exif(quarter_turns=turns),
        sha256="",
        camera_idx=0,
    )
    spot_px = np.array([[7.5 * side - 0.5, 2.5 * side - 0.5]])
    image, xy_px = _upright(photo, spot_px)
    assert (image.shape[0] > image.shape[1]) == (turns % 2 == 1)
    weight = image[..., 0].astype(float)
    y, x = np.indices(weight.shape)
    centre = np.array([(x * weight).sum(), (y * weight).sum()]) / weight.sum()
    np.testing.assert_allclose(xy_px[0], centre, atol=0.2)


@pytest.mark.parametrize(("step", "said"), [(1, ""), (2, " (one in 2 is drawn)")])
def test_a_thinned_drawing_says_by_how_much(step: int, said: str) -> None:
    assert drawn_part(step) == said


def test_pictures_of_other_heights_lie_side_by_side() -> None:
    left, right = np.full((20, 30, 3), 10, np.uint8), np.full((40, 25, 3), 20, np.uint8)
    both, offset_px = _side_by_side(left, right)
    assert both.shape == (40, offset_px + 25, 3)
    assert (both[:20, :30] == 10).all()
    assert (both[:, offset_px:] == 20).all()
    assert (both[20:, :30] == 255).all()


def length(role: str, error: float) -> LengthCheck:
    return LengthCheck(
        label=f"A{role}",
        known_mm=100,
        measured_mm=100 * (1 + error),
        sigma_mm=0.01,
        role=role,  # type: ignore[arg-type]
        between="points",
        marks=(),
    )


def scale(*lengths: LengthCheck, unit: str = "mm") -> Scale:
    source = "board" if unit == "mm" else "none"
    return Scale(unit=unit, source=source, relative_sigma=1e-4, lengths=lengths)  # type: ignore[arg-type]


def test_the_facts_say_scale_check_and_what_is_missing() -> None:
    placed = note("verdict.photos_placed", placed=0, photos=0)
    several = facts(scale(length("check", 0.001), length("check", -0.002)), [], [])
    assert several[1:] == (placed,)
    assert several[0].code == "verdict.scale_checked"
    assert several[0].values == {
        "source": "board",
        "lengths": 2,
        "rms": pytest.approx(math.sqrt((0.001**2 + 0.002**2) / 2)),
        "worst": pytest.approx(0.002),
        "label": "Acheck",
    }
    one = facts(scale(length("control", 0.1), length("check", -0.002)), [], [])
    assert "checked on 1 other length: it agrees to 0.200% (Acheck)." in told(one[0])
    alone = facts(scale(length("control", 0.0)), [], [])
    assert alone == (note("verdict.scale_not_checked", source="board"), placed)
    assert facts(scale(unit="unitless"), [], [])[0] == note("verdict.no_scale")
    plain = scale()
    aside = [SetAside("a", note("said.as_is", message="b"))]
    assert facts(plain, [], aside)[2:] == (note("verdict.set_aside", files=1),)
    assert facts(plain, [], [], 0.31)[2:] == (note("verdict.torn_off", share=0.31),)
    assert facts(plain, [], [], 0.01)[2:] == ()
    assert facts(plain, [], [], laid=12)[2:] == (note("verdict.laid_back", points=12),)
    assert facts(plain, [], [], others=2)[2:] == (note("verdict.other_bodies", bodies=2),)


def summary(light: Light) -> Summary:
    first = note("said.as_is", message="5 < 6 & so on")
    said = note("verdict.no_size", size=first, first=None, second=None)
    return Summary(
        verdict=Verdict(
            light=light,
            headline=note("verdict.headline", light=light, verdict=said),
            reasons=(first, note("said.as_is", message="another <reason>")),
            facts=(note("verdict.photos_placed", placed=3, photos=4),),
        ),
        intended_use="use",
        unit="mm",
        scale=ScaleSummary(
            source="board",
            relative_sigma=1e-4,
            lengths=(
                LengthSummary(
                    label="x", role="check", known_mm=1.0, measured_mm=1.0, error=0.0, sigma_mm=0.1
                ),
            ),
        ),
        photos=(
            PhotoSummary(
                name="<a>.jpg",
                placed=False,
                points=1,
                rms_px=math.nan,
                reason="too dark",
                remarks=(),
                features=1,
                edge_width_px=1.0,
            ),
        ),
        set_aside=(SetAside("notes.txt", note("said.as_is", message="no photo")),),
        cameras=(),
        matches=MatchSummary(
            pairs_tried=1, before_correlation=1, after_correlation=1, verified_pairs=1, verified=1
        ),
        scene=SceneSummary(placed=3, points=9, observations=27, rms_px=math.nan),
        image_scale=(),
        cloud=CloudSummary(points=1, spacing=1.0),
        resolution=Resolution(
            edge_mm=1.0,
            face_parts=1,
            photo_halvings=0,
            depth_share=1.0,
            notes=(note("said.as_is", message="Edges are <long>."),),
        ),
        mesh=MeshSummary(
            vertices=3,
            faces=1,
            size=(1.0, 1.0, 0.0),
            area=0.5,
            volume=None,
            left_out_share=0.0,
            filled_share=0.0,
            open_edges=3,
        ),
        parts=(),
        stages=(StageSummary(stage="match", wall_s=1.0, cpu_s=2.0, peak_mb=math.nan, reused=True),),
    )


PICTURES = Pictures((Picture("p", "Title", "Caption", np.zeros(3, np.uint8)),))


@pytest.mark.parametrize("light", ["green", "amber", "red"])
def test_the_page_has_the_colour_the_word_and_every_reason_of_the_verdict(light: Light) -> None:
    """Whatever else the summary says: a photo that is not placed makes no red page by itself."""
    page = html_of(case_report(summary(light), PICTURES, "A <case>"))
    banner = page[page.index('<div class="banner') : page.index("</div>")]
    assert banner.startswith(f'<div class="banner {light}"><b>{light.upper()}</b>')
    assert banner.count("5 &lt; 6 &amp; so on") == 1
    assert "another &lt;reason&gt;" in banner
    assert "3 of 4 photos" in page
    assert "&lt;a&gt;.jpg" in page
    assert "<h1>A &lt;case&gt;</h1>" in page
    assert "<p>Edges are &lt;long&gt;.</p>" in page


def test_what_was_done_with_the_photos_stands_before_the_pictures() -> None:
    """A moved limb or a turntable is no detail of the stages' times."""
    plain = summary("amber")
    scene = replace(plain.scene, notes=("The limb moved.", "The camera stood still."))
    page = html_of(case_report(replace(plain, scene=scene), PICTURES, "A case"))
    where = [page.index(words) for words in ("The limb moved.", "The camera stood still.")]
    assert page.index("3 of 4 photos") < where[0] < where[1] < page.index("<h2>Title</h2>")
    quiet = replace(plain, resolution=replace(plain.resolution, notes=()))
    assert "What was done" not in html_of(case_report(quiet, PICTURES, "A case"))


def test_a_summary_is_read_as_it_was_written() -> None:
    tree = json.loads(json.dumps(tree_of(summary("green")), allow_nan=False))
    assert tree["photos"][0]["rms_px"] is None
    assert tree_of(summary_of(tree)) == tree
    assert math.isnan(summary_of(tree).stages[0].peak_mb)
    del tree["verdict"]["light"]
    with pytest.raises(Mismatch, match=r"the summary\.verdict needs light"):
        summary_of(tree)


def test_json_gets_none_for_what_is_no_number() -> None:
    tree = tree_of({"a": [1.0, float("nan")], "b": (float("inf"), "x", 3)})
    assert tree == {"a": [1.0, None], "b": [None, "x", 3]}


def test_a_drawn_camera_reaches_to_the_edges_of_its_picture() -> None:
    """Half a pixel beyond the middles of the corner pixels."""
    lens = Camera(width_px=200, height_px=150, fx=300.0, fy=300.0, cx=99.5, cy=74.5)
    view = View("a.jpg", lens, Rigid(np.eye(3), np.array([1.0, 2.0, 3.0])))
    rim = _frustum(view, 10.0)[:4, 1]
    edges = [(-0.5, -0.5), (199.5, -0.5), (199.5, 149.5), (-0.5, 149.5)]
    np.testing.assert_allclose(view.project(rim), edges, atol=1e-9)


def test_what_was_filled_is_a_share_of_the_area() -> None:
    """One large triangle over a hole beside a hundred small ones, as large as all of them."""
    small = np.array([[0.0, 0, 0], [1, 0, 0], [0, 1, 0]])
    places = [small + np.array([0.0, 2.0 * k, 0.0]) for k in range(100)]
    vertices_mm = np.concatenate([*places, 10 * small + np.array([50.0, 0.0, 0.0])])
    faces = np.arange(len(vertices_mm), dtype=np.int32).reshape(-1, 3)
    mesh = Mesh(vertices_mm=vertices_mm, faces=faces, filled=np.arange(303) >= 300)
    assert mesh_figures(mesh).filled_share == pytest.approx(0.5)
