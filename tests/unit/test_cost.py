"""The comparison of cost: what it divides by what, and what it tells of resized photos."""

import importlib
import json
import sys
from pathlib import Path
from types import ModuleType
from typing import Any

import numpy as np
import pytest
from PIL import Image

FOLDER = str(Path(__file__).parents[2] / "benchmarks")


@pytest.fixture(scope="module")
def cost() -> ModuleType:
    return _benchmark("cost")


@pytest.fixture(scope="module")
def tables() -> ModuleType:
    return _benchmark("cost_tables")


def _benchmark(name: str) -> ModuleType:
    sys.path.insert(0, FOLDER)
    try:
        return importlib.import_module(name)
    finally:
        sys.path.remove(FOLDER)


def _ours(cpu_s: float, exit_code: int = 0) -> dict[str, Any]:
    stage = {"stage": "repair", "cpu_s": 2.0, "wall_s": 1.0, "peak_mb": 300}
    return {
        "exit_code": exit_code,
        "cpu_s": cpu_s,
        "wall_s": cpu_s / 2,
        "peak_mb": 700,
        "triangles": 123456,
        "verdict": "green",
        "placed": 15,
        "stages": [stage, {**stage, "peak_mb": 400}],
    }


def _theirs(sparse_cpu_s: float, exit_code: int = 0) -> dict[str, Any]:
    steps = {"extract": sparse_cpu_s - 2, "match": 1.0, "map": 1.0}
    return {"exit_code": exit_code, "sparse_cpu_s": sparse_cpu_s, "steps_cpu_s": steps}


def _one(ours: list[dict[str, Any]], theirs: list[dict[str, Any]]) -> dict[str, Any]:
    told = {"what": "a limb", "photos": 15, "megapixels": 1.0}
    return told | {"limbgram": ours, "pycolmap": theirs}


def test_the_ratio_is_least_over_least(tables: ModuleType) -> None:
    one = _one([_ours(60.0), _ours(50.0)], [_theirs(100.0), _theirs(120.0)])
    assert tables.ratio(one) == 0.5
    assert "| 0.50 |" in tables.cost_table({"limb": one})


def test_a_run_that_failed_gives_no_figure(tables: ModuleType) -> None:
    failed = {"exit_code": 4, "cpu_s": 1.0, "wall_s": 1.0, "peak_mb": 100, "message": "no"}
    one = _one([failed, _ours(50.0)], [_theirs(100.0), _theirs(9.0, exit_code=1)])
    assert tables.ratio(one) == 0.5
    (line,) = tables.cost_table({"limb": _one([failed], [])}).splitlines()[2:]
    assert "exit 4" in line
    assert "GREEN" not in line


def test_a_red_verdict_is_a_whole_run(tables: ModuleType) -> None:
    assert len(tables.finished([_ours(1.0, exit_code=7), _ours(1.0, exit_code=4)])) == 1


def test_a_stage_that_ran_for_two_bodies_is_added_up(
    tables: ModuleType, cost: ModuleType, tmp_path: Path
) -> None:
    machine = cost.machine()
    results = {"machine": machine, "sets": {"p15x1": _one([_ours(50.0)], [_theirs(100.0)])}}
    written = tables.page(results)
    assert "| repair | 4.0 / 400 |" in written
    assert "## Before" not in written
    tables.plot(results, tmp_path / "out.png")
    assert (tmp_path / "out.png").exists()
    assert "## Before" in tables.page({**results, "before": results})


@pytest.mark.parametrize("factor", [2.0, 0.5])
def test_resized_photos_keep_pixel_centres_and_exif(
    cost: ModuleType, tmp_path: Path, factor: float
) -> None:
    images = tmp_path / "flowerpot" / "images"
    images.mkdir(parents=True)
    rows, columns = np.mgrid[:60, :80]
    spot = np.exp(-((columns - 30.0) ** 2 + (rows - 20.0) ** 2) / (2 * 5.0**2))
    exif = Image.Exif()
    exif[0x0110] = "m1 note"
    for k in range(4):
        picture = Image.fromarray((255 * spot).astype(np.uint8)).convert("RGB")
        picture.save(images / f"P81019-15101{k + 4}.jpg", quality=98, exif=exif)
    cost.resized(tmp_path / "flowerpot", tmp_path / "small", 2, factor)
    made = sorted((tmp_path / "small" / "images").iterdir())
    assert [file.name for file in made] == ["P81019-151014.jpg", "P81019-151016.jpg"]
    with Image.open(made[0]) as picture:
        assert picture.size == (80 * factor, 60 * factor)
        assert picture.getexif()[0x0110] == "m1 note"
        weight = np.asarray(picture.convert("L"), float)
    weight[weight < 8] = 0
    rows, columns = np.mgrid[: weight.shape[0], : weight.shape[1]]
    at = (weight * columns).sum() / weight.sum(), (weight * rows).sum() / weight.sum()
    wanted = np.array([30.5, 20.5]) * factor - 0.5
    np.testing.assert_allclose(at, wanted, atol=0.1)
    picks = json.loads((tmp_path / "small" / "picks.json").read_text("utf-8"))["distances"]
    known = json.loads((Path(FOLDER) / "flowerpot_picks.json").read_text("utf-8"))["distances"]
    named = {file.name for file in made}
    for distance, before in zip(picks, known, strict=True):
        for end in ("first", "second"):
            kept = [pick for pick in before[end] if pick["photo"] in named]
            assert [pick["x_px"] for pick in distance[end]] == [
                pytest.approx((pick["x_px"] + 0.5) * factor - 0.5) for pick in kept
            ]


def test_every_set_has_its_source_and_words(cost: ModuleType) -> None:
    for one in cost.SETS.values():
        assert one.what
        if isinstance(one.source, cost.Resized):
            assert one.source.of in {*cost.SETS, "flowerpot"}
    assert {name for name, one in cost.SETS.items() if one.rival} >= {"limb_ring15", "paper"}
