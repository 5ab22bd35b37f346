"""A reading of the tape is held against a surface in four places, and all say the same of it."""

import re
from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from fastapi.testclient import TestClient

from limbgram.app.access import Access
from limbgram.app.server import guarded
from limbgram.app.state import AppState
from limbgram.cases.shelf import Shelf
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.tape import AGREES_SIGMAS
from limbgram.formats.ply import write_ply
from limbgram.formats.reading import read_limb
from limbgram.reconstruction.scale.stated_lengths import TapedGirth
from limbgram.reconstruction.scale.taped_girths import TapeWitness, TapeWitnesses
from limbgram.report.accuracy.assessment import assess
from limbgram.report.accuracy.evidence import Evidence
from limbgram.synthetic import SMALL
from limbgram.synthetic.props.limb import make_limb
from limbgram.workbench.limb import Limb
from limbgram.workbench.measures.measuring import LimbMeasureOptions, measure_limb
from limbgram.workbench.measures.tape import TapeCheck, TapeReading

API, HOST = "/api/v1", "127.0.0.1:8000"


@pytest.fixture
def app_state(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> AppState:
    for name in ("XDG_STATE_HOME", "LOCALAPPDATA"):
        monkeypatch.setenv(name, str(tmp_path / "state"))
    access = Access(frozenset({HOST}))
    return AppState(Shelf(tmp_path / "cases"), access, origin=lambda: f"http://{HOST}")


@pytest.fixture
def client(app_state: AppState, tmp_path: Path) -> Iterator[TestClient]:
    static = tmp_path / "static"
    static.mkdir()
    (static / "index.html").write_text("<!doctype html><title>limbgram</title>", "utf-8")
    with TestClient(guarded(app_state, static), base_url=f"http://{HOST}") as signed_in:
        signed_in.get(f"/start?token={app_state.access.new_link_token()}")
        yield signed_in


@pytest.fixture(scope="module")
def limb() -> Mesh:
    """A surface that is sure to 0.2 mm."""
    limb = make_limb(SMALL.kind, SMALL.seed, 8.0, 60.0).mesh
    return replace(limb, sigma_mm=np.full(len(limb.vertices_mm), 0.2, np.float32))


@pytest.fixture
def case(client: TestClient, app_state: AppState, limb: Mesh) -> Path:
    """The folder of a case with that surface, aligned."""
    case_id = client.post(f"{API}/cases", json={"kind": "transtibial"}).json()["id"]
    folder = app_state.shelf.root / case_id / "deliverables"
    folder.mkdir()
    write_ply(limb, folder / "surface.ply", "mm")
    axes = {"side": "left", "kind": "transtibial", "proximal": [0, 0, 1], "anterior": [0, 1, 0]}
    assert client.post(f"{API}/cases/{case_id}/limb/align", json=axes).status_code == 200
    return folder.parent


READINGS = {60.0: 0.99, 80.0: -0.99, 100.0: 1.01, 120.0: -1.01}
"""By height, how far beyond the surface's girth, in shares of what agrees."""


def test_table_verdict_app_and_record_say_the_same_of_each_reading(
    client: TestClient, case: Path, with_sigmas: Evidence
) -> None:
    scan = read_limb(case / "work" / "surface.ply")
    any_girths = _in_table(scan, dict.fromkeys(READINGS, 300.0))
    girths_mm = {
        height_mm: one.measured.value + share * AGREES_SIGMAS * one.sigma_mm
        for (height_mm, share), one in zip(READINGS.items(), any_girths, strict=True)
    }
    table = _in_table(scan, girths_mm)
    assert [one.conflict for one in table] == [False, False, True, True]
    assert [_by_verdict(with_sigmas, one) for one in table] == [False, False, True, True]

    url = f"{API}/cases/{case.name}"
    for height_mm, girth_mm in girths_mm.items():
        reading = {"height_mm": height_mm, "girth_mm": girth_mm}
        assert client.patch(f"{url}/tape", json=reading).status_code == 200
    app = client.post(f"{url}/measures", json={}).json()["tape"]
    assert [one["conflict"] for one in app] == [False, False, True, True]
    record = client.get(f"{url}/record.html").text
    rows = re.findall(r"<tr>(?:(?!</tr>).)*(?:agrees|contradict each other).*?</tr>", record, re.S)
    assert ["contradict" in one for one in rows] == [False, False, True, True]
    for one, girth_mm in zip(rows, girths_mm.values(), strict=True):
        assert f"{girth_mm:.1f}" in one


def _in_table(scan: Limb, girths_mm: dict[float, float]) -> tuple[TapeCheck, ...]:
    readings = (TapeReading(height_mm=h, girth_mm=girth) for h, girth in girths_mm.items())
    return measure_limb(scan, LimbMeasureOptions(tape=tuple(readings))).tape


def _by_verdict(evidence: Evidence, table: TapeCheck) -> bool:
    """Whether the verdict on a capture contradicts the reading."""
    witness = TapeWitness(
        taped=TapedGirth(girth_mm=table.read_mm),
        measured_mm=table.measured.value,
        sigma_mm=table.sigma_mm,
    )
    found = assess(replace(evidence, tapes=TapeWitnesses((witness,))))
    (said,) = (one for one in found.criteria if one.key == "tape")
    return said.light != "green"
