"""What the app costs: its start, edits over HTTP, sixty photos sent at once, frames a second.

    python benchmarks/app.py [--photos 60] [--megabytes 8] [--repeats 5] [--uploads 3]
                             [--only starts,edits,frames]

Starts `limbgram app` as its own process and asks it as a browser does. Writes
results/app.json; parts that are not asked for stay as they were measured before, each with
its own machine and commit. Edits are timed from the request to the last byte of the answer, on a
synthetic limb of some 250,000 triangles: each is previewed with another depth each time, so that
nothing is taken from what was done before, and then kept. Frames are those in which the page drew
while the limb was turned by the mouse, in Chromium, and what drew them is named; they need
Playwright.
"""

import json
import os
import shutil
import statistics
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from concurrent.futures import ThreadPoolExecutor
from contextlib import contextmanager
from http.client import HTTPConnection
from pathlib import Path
from typing import Any

import httpx
import numpy as np

from harness import described, machine, made_on
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import with_faces
from limbgram.formats.ply import write_ply
from limbgram.synthetic.options import SMALL
from limbgram.synthetic.truth import stage_truth
from limbgram.workbench.edits.refinement import refine_where

API = "/api/v1"
RESULTS = Path(__file__).parent / "results" / "app.json"
PINGING = """
import json, sys, threading, time
from http.client import HTTPConnection
line = HTTPConnection(sys.argv[1], timeout=60)
ended, took = threading.Event(), []
def watch():
    sys.stdin.read()
    ended.set()
threading.Thread(target=watch, daemon=True).start()
while not ended.is_set():
    began = time.perf_counter()
    line.request("GET", "/api/v1/session", headers={"cookie": sys.argv[2]})
    assert line.getresponse().read()
    took.append(time.perf_counter() - began)
    if len(took) == 1:
        print(flush=True)
    time.sleep(0.02)
print(json.dumps(took))
"""
COUNTING = """
globalThis.drawnFrames = [];
let drew = false;
const draw = WebGL2RenderingContext.prototype.drawElements;
WebGL2RenderingContext.prototype.drawElements = function (...all) {
  drew = true;
  return draw.apply(this, all);
};
const each = (time) => {
  if (drew) drawnFrames.push(time);
  drew = false;
  requestAnimationFrame(each);
};
requestAnimationFrame(each);
"""
"""Notes when each frame was that drew triangles."""
RENDERER = """() => {
  const canvas = document.querySelector(".limb-canvas");
  const gl = canvas.getContext("webgl2");
  const named = gl.getExtension("WEBGL_debug_renderer_info");
  const renderer = named ? gl.getParameter(named.UNMASKED_RENDERER_WEBGL) : "not named";
  return { renderer, width: canvas.width, height: canvas.height };
}"""
TRIANGLES = (100_000, 250_000, 500_000)
TURNED_S = 5.0
EDITS: dict[str, dict[str, Any]] = {
    "load": {"at": "patellar tendon", "depth_mm": 3.0, "falloff_mm": 18.0},
    "relieve": {"at": "patellar tendon", "depth_mm": 3.0, "falloff_mm": 18.0},
    "reduction": {"heights_mm": [80, 200], "per_cent": [1.0, 3.0], "of": "girth"},
    "offset": {"distance_mm": -1.0},
    "smoothing": {"passes": 4},
}


def main() -> None:
    parser = described(__doc__)
    parser.add_argument("--photos", type=int, default=60)
    parser.add_argument("--megabytes", type=float, default=8.0)
    parser.add_argument("--repeats", type=int, default=5)
    parser.add_argument("--uploads", type=int, default=3, help="Times; each on a fresh server.")
    parser.add_argument("--only", default="starts,edits,frames", help="Parts to measure anew.")
    chosen = parser.parse_args()
    parts = chosen.only.split(",")
    results: dict[str, Any] = {}
    if RESULTS.is_file():
        results = json.loads(RESULTS.read_text("utf-8"))
    if "starts" in parts:
        results |= {"machine": machine(), "starts": [], "uploads": []}
    for _ in range(chosen.uploads if "starts" in parts else 0):
        with tempfile.TemporaryDirectory() as scratch, started(Path(scratch)) as app:
            results["starts"].append(
                {
                    "seconds": app.start_s,
                    "computed_s": app.start_cpu_s,
                    "rest_mb": app.memory_mb("VmRSS"),
                    "load": os.getloadavg()[0],
                }
            )
            sent = uploaded(app, chosen.photos, int(chosen.megabytes * 1e6))
            results["uploads"].append(sent)
    if "edits" in parts:
        limb = large_limb(250_000)
        with tempfile.TemporaryDirectory() as scratch, started(Path(scratch)) as app:
            results["edits_machine"] = machine()
            results["load"] = os.getloadavg()[0]
            results["triangles"] = len(limb.faces)
            results["edits"] = edited(app, Path(scratch), limb, chosen.repeats)
            results["edits_load_after"] = os.getloadavg()[0]
    if "frames" in parts:
        with tempfile.TemporaryDirectory() as scratch, started(Path(scratch)) as app:
            results["frames_machine"] = machine()
            results["frames"] = drawn(app, Path(scratch))
    RESULTS.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")


class App:
    """The app as a process, and a client that is signed in."""

    def __init__(self, folder: Path) -> None:
        began = time.perf_counter()
        self.process = subprocess.Popen(
            ["limbgram", "app", "--cases", str(folder), "--no-browser", "--json"],
            stdout=subprocess.PIPE,
            text=True,
        )
        assert self.process.stdout is not None
        link = json.loads(self.process.stdout.readline())["link"]
        self.client = httpx.Client(base_url=link.partition("/start")[0], timeout=120)
        self.client.get(link).raise_for_status()
        self.client.get(f"{API}/cases").raise_for_status()
        self.start_s = time.perf_counter() - began
        self.start_cpu_s = self.cpu_s()

    def cpu_s(self) -> float:
        """Seconds that its threads have computed so far: other load does not change them much."""
        times = Path(f"/proc/{self.process.pid}/stat").read_text("ascii").rpartition(")")[2].split()
        return (int(times[11]) + int(times[12])) / os.sysconf("SC_CLK_TCK")

    def memory_mb(self, which: str) -> float:
        told = Path(f"/proc/{self.process.pid}/status").read_text("ascii")
        line = next(line for line in told.splitlines() if line.startswith(which))
        return int(line.split()[1]) / 1024


@contextmanager
def started(folder: Path) -> Iterator[App]:
    app = App(folder)
    try:
        yield app
    finally:
        app.process.terminate()
        app.process.wait(20)


def large_limb(triangles: int) -> Mesh:
    """A limb of about so many triangles: its triangles halved, or its upper part left away."""
    mesh = stage_truth(SMALL).limb.mesh
    edge_mm = {100_000: 3.0, 250_000: 1.62, 500_000: 1.2}[triangles]
    fine = refine_where(mesh, np.ones(len(mesh.faces), bool), edge_mm)
    if len(fine.faces) < 1.1 * triangles:
        return fine
    heights = fine.vertices_mm[fine.faces[:, 0], 2]
    return with_faces(fine, fine.faces[np.argsort(heights, kind="stable")[:triangles]])


def uploaded(app: App, photos: int, size: int) -> dict[str, Any]:
    """All photos at once over their own connections, and a ping meanwhile.

    The ping is asked by a process of its own, as by another browser: in the process that sends it
    would wait for sixty threads.
    """
    case = f"{API}/cases/" + app.client.post(f"{API}/cases", json={}).json()["id"]
    random = np.random.default_rng(1)
    contents = [random.bytes(size) for _ in range(4)]
    address = str(app.client.base_url).removeprefix("http://").rstrip("/")
    cookie = "; ".join(f"{name}={value}" for name, value in app.client.cookies.items())

    def send(number: int) -> bool:
        line = HTTPConnection(address, timeout=300)
        name = f"{case}/photos/IMG_{number:04d}.jpg"
        line.request("PUT", name, body=contents[number % 4], headers={"cookie": cookie})
        return bool(json.loads(line.getresponse().read())["whole"])

    asking = subprocess.Popen(
        [sys.executable, "-c", PINGING, address, cookie],
        stdin=subprocess.PIPE,
        stdout=subprocess.PIPE,
        text=True,
    )
    assert asking.stdin is not None
    assert asking.stdout is not None
    asking.stdout.readline()  # it has begun
    before_s = app.cpu_s()
    began = time.perf_counter()
    with ThreadPoolExecutor(photos) as pool:
        whole = sum(pool.map(send, range(photos)))
    took = time.perf_counter() - began
    pings: list[float] = json.loads(asking.communicate()[0])
    return {
        "photos": photos,
        "megabytes_each": size / 1e6,
        "whole": whole,
        "seconds": took,
        "computed_s": app.cpu_s() - before_s,
        "ping_median_ms": 1000 * statistics.median(pings),
        "ping_p99_ms": 1000 * float(np.quantile(pings, 0.99)),
        "ping_most_ms": 1000 * max(pings),
        "pings": len(pings),
        "peak_mb": app.memory_mb("VmHWM"),
    }


def case_of(app: App, folder: Path, limb: Mesh) -> str:
    """A case with that surface, as a run delivers it."""
    case_id = str(app.client.post(f"{API}/cases", json={"kind": "transtibial"}).json()["id"])
    delivered = folder / case_id / "deliverables"
    delivered.mkdir()
    write_ply(limb, delivered / "surface.ply", "mm")
    return case_id


def drawn(app: App, folder: Path) -> list[dict[str, Any]]:
    """Frames a second while limbs of several sizes are turned by the mouse."""
    from playwright.sync_api import sync_playwright  # this part alone needs a browser

    made: list[dict[str, Any]] = []
    link = app.client.post(f"{API}/session/links").json()["url"]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"),
            args=["--enable-unsafe-swiftshader", "--no-sandbox"],
        )
        page = browser.new_page(viewport={"width": 1440, "height": 900})
        page.set_default_timeout(120_000)
        page.add_init_script(COUNTING)
        page.goto(link)
        page.locator("#content h1").first.wait_for()
        for triangles in TRIANGLES:
            limb = large_limb(triangles)
            case_id = case_of(app, folder, limb)
            began = time.perf_counter()
            page.goto(f"{str(app.client.base_url).rstrip('/')}/#/case/{case_id}/align")
            page.locator(".overlay .bar path").first.wait_for(state="attached")
            shown_s = time.perf_counter() - began
            page.wait_for_timeout(1500)
            box = page.locator(".limb-canvas").bounding_box()
            assert box is not None
            page.mouse.move(box["x"] + 40, box["y"] + 200)  # beside the limb: a drag there turns it
            page.mouse.down()
            page.evaluate("drawnFrames = []")
            turning, step = time.perf_counter(), 0
            while time.perf_counter() - turning < TURNED_S:
                step += 1
                page.mouse.move(box["x"] + 40 + step % 200, box["y"] + 200)
            frames: list[float] = page.evaluate("drawnFrames")
            drawing: dict[str, Any] = page.evaluate(RENDERER)  # at rest it draws more pixels
            page.mouse.up()
            gaps = np.diff(np.array(frames))
            made.append(
                {
                    "triangles": len(limb.faces),
                    "shown_s": shown_s,
                    "frames": len(frames),
                    "per_second": 1000 / float(gaps.mean()),
                    "slowest_ms": float(gaps.max()),
                    "load": os.getloadavg()[0],
                    **drawing,
                }
            )
        browser.close()
    return made


def edited(app: App, folder: Path, limb: Mesh, repeats: int) -> dict[str, Any]:
    """Preview and keep each kind of edit."""
    case = f"{API}/cases/{case_of(app, folder, limb)}"
    middle = np.abs(limb.vertices_mm[:, 2] - limb.vertices_mm[:, 2].mean()) < 2
    front = limb.vertices_mm[middle][np.argmax(limb.vertices_mm[middle, 1])]
    place = {"position_mm": front.tolist()}
    app.client.put(f"{case}/limb/places/patellar tendon", json=place).raise_for_status()
    axes = {"side": "left", "proximal": [0, 0, 1], "anterior": [0, 1, 0]}
    app.client.post(f"{case}/limb/align", json=axes).raise_for_status()
    warm = {"kind": "smoothing", "parameters": {"passes": 1}}
    app.client.post(f"{case}/recipe/preview", json=warm).raise_for_status()
    return {
        kind: one_edit(app, case, kind, parameters, repeats) for kind, parameters in EDITS.items()
    }


def one_edit(
    app: App, case: str, kind: str, parameters: dict[str, Any], repeats: int
) -> dict[str, Any]:
    previews: list[float] = []
    kept: list[float] = []
    computed: list[float] = []
    failed: list[str] = []
    size = 0
    for number in range(repeats + 1):
        asked = {"kind": kind, "parameters": varied(parameters, number)}
        began, before_s = time.perf_counter(), app.cpu_s()
        answer = app.client.post(f"{case}/recipe/preview", json=asked)
        middle, after_s = time.perf_counter(), app.cpu_s()
        keeping = app.client.post(f"{case}/recipe/edits", json=asked)
        ended = time.perf_counter()
        if answer.status_code != 200 or keeping.status_code != 201:
            failed.append(keeping.json()["message"])
            continue
        size = len(answer.content)
        app.client.post(f"{case}/recipe/undo")
        if number:  # the first one may compile
            previews.append(middle - began)
            kept.append(ended - middle)
            computed.append(after_s - before_s)
    return {
        "preview_ms": [round(1000 * one, 1) for one in previews],
        "keep_ms": [round(1000 * one, 1) for one in kept],
        "preview_cpu_ms": [round(1000 * one) for one in computed],
        "bytes": size,
        "failed": failed,
    }


def varied(parameters: dict[str, Any], number: int) -> dict[str, Any]:
    """The same edit, a little otherwise."""
    changed = dict(parameters)
    for name in ("depth_mm", "distance_mm"):
        if name in changed:
            changed[name] *= 1 + 0.01 * number
    if "per_cent" in changed:
        changed["per_cent"] = [one + 0.05 * number for one in changed["per_cent"]]
    if "passes" in changed:
        changed["passes"] += number
    return changed


def page(results: dict[str, Any]) -> str:
    return "\n".join((
        "# app",
        "",
        made_on(results["machine"]),
        "",
        "The load of the system is that of the last minute. Above the number of cores, times are "
        "those of a busy machine; computed seconds are the server's own.",
        "",
        "| start, s | computed, s | memory then, MB | load |",
        "|---|---|---|---|",
        *(
            f"| {one['seconds']:.1f} | {one['computed_s']:.1f} | {one['rest_mb']:.0f} | "
            f"{one['load']:.1f} |"
            for one in results["starts"]
        ),
        "",
        "From the command to the first answered list of cases. Then, on each of these servers, "
        "photos are sent all at once, and meanwhile another process pings:",
        "",
        "| photos whole | of MB | took, s | computed, s | ping ms: median | 99 of 100 | most | "
        "pings | most memory, MB |",
        "|---|---|---|---|---|---|---|---|---|",
        *(
            f"| {one['whole']} of {one['photos']} | {one['megabytes_each']:g} | "
            f"{one['seconds']:.1f} | {one['computed_s']:.1f} | {one['ping_median_ms']:.0f} | "
            f"{one['ping_p99_ms']:.0f} | {one['ping_most_ms']:.0f} | {one['pings']} | "
            f"{one['peak_mb']:.0f} |"
            for one in results["uploads"]
        ),
        "",
        *_edits(results),
        "",
        *_frames(results),
        "",
    ))  # fmt: skip


def _edits(results: dict[str, Any]) -> Iterator[str]:
    yield from (
        made_on(results["edits_machine"]),
        "",
        f"Load of the system when edits began {results['load']:.1f}, and when they ended "
        f"{results['edits_load_after']:.1f}.",
        "",
        f"Edits on {results['triangles']:,} triangles, ms from request to answer, median and most:",
        "",
        "| edit | preview | computed in a preview | keep | answer, kB | refused |",
        "|---|---|---|---|---|---|",
    )
    for kind, one in results["edits"].items():
        cells = [
            f"{statistics.median(times):.0f}, {max(times):.0f}" if times else "-"
            for times in (one["preview_ms"], one["preview_cpu_ms"], one["keep_ms"])
        ]
        yield f"| {kind} | {' | '.join(cells)} | {one['bytes'] / 1000:.0f} | {len(one['failed'])} |"


def _frames(results: dict[str, Any]) -> Iterator[str]:
    yield from (
        made_on(results["frames_machine"]),
        "",
        f"The limb is turned by the mouse for {TURNED_S:g} s in a window of 1440 x 900; a frame "
        "counts when triangles were drawn for it. While it moves the page may draw fewer pixels.",
        "",
        "| triangles | shown after, s | frames a second | longest between two, ms | canvas | drawn "
        "by | load |",
        "|---|---|---|---|---|---|---|",
        *(
            f"| {one['triangles']:,} | {one['shown_s']:.1f} | {one['per_second']:.1f} | "
            f"{one['slowest_ms']:.0f} | {one['width']} x {one['height']} | {one['renderer']} | "
            f"{one['load']:.1f} |"
            for one in results["frames"]
        ),
    )


if __name__ == "__main__":
    main()
