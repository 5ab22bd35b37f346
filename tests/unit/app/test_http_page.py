"""The page about the API: its program does what it says against a server on a socket."""

import re
import threading
from pathlib import Path

import httpx
import numpy as np
import pytest

from limbgram.app.local_server import ServeOptions, serve
from limbgram.cases.shelf import Shelf
from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.ply import write_ply
from limbgram.formats.reading import read_limb

PAGE = Path(__file__).parents[3] / "docs" / "library" / "http.md"


def test_the_program_of_the_page_brings_the_files(
    tmp_path: Path, limb: Mesh, monkeypatch: pytest.MonkeyPatch
) -> None:
    case = Shelf(tmp_path / "cases")
    case.open()
    made = case.new_case("transtibial", "left")
    made.folder.deliverables.mkdir()
    write_ply(limb, made.folder.deliverables / "surface.ply", "mm")
    ready = threading.Event()
    links: list[str] = []

    def opened(link: str) -> None:
        links.append(link)
        ready.set()

    options = ServeOptions(cases=tmp_path / "cases", no_browser=True)
    threading.Thread(target=serve, args=(options, opened), daemon=True).start()
    assert ready.wait(30)
    with httpx.Client(base_url=links[0].partition("/start")[0], timeout=60) as client:
        client.get(links[0])
        root = f"/api/v1/cases/{made.case_id}/limb"
        front = limb.vertices_mm[np.argmax(limb.vertices_mm[:, 1])].tolist()
        client.put(f"{root}/places/patellar tendon", json={"position_mm": front})
        axes = {"side": "left", "proximal": [0, 0, 1], "anterior": [0, 1, 0]}
        client.post(f"{root}/align", json=axes).raise_for_status()
        link = client.post("/api/v1/session/links").json()["url"]
    program = re.search(r"```python\n(.*?)```", PAGE.read_text("utf-8"), re.DOTALL)
    assert program is not None
    monkeypatch.chdir(tmp_path)
    exec(compile(program[1], PAGE.name, "exec"), {"link": link})
    brought = list(tmp_path.glob(f"{made.case_id}-L-*.aop"))
    assert len(brought) == 1
    height = np.ptp(read_limb(brought[0]).mesh.vertices_mm[:, 2])
    assert height == pytest.approx(np.ptp(limb.vertices_mm[:, 2]), abs=15)
