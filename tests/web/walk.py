"""The whole job by clicks alone, in a real browser: photos in, a checked shape and its file out.

What a click picks is held against the place that is drawn there, at three sizes; the file that is
saved against what the command line makes of the same scan and recipe; every page against axe.
Changes are made with answers that come late, in another order or not at all, with a reload and with
Back in between, and from two windows: what the server has in the end is what hands did.

Needs Playwright, Chromium and `npm ci` in web/; takes minutes, so it runs when it is asked for:
`python -m pytest tests/web/walk.py`; the changes alone, in some minutes, with `-k answers`.
"""

import json
import math
import re
import shutil
import socket
import subprocess
import tomllib
from collections.abc import Generator, Iterator
from contextlib import contextmanager
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
import pytest
from playwright.sync_api import Page, expect, sync_playwright
from pypdfium2 import PdfDocument

from limbgram.core.mesh.topology import with_faces
from limbgram.formats.ply import write_ply
from limbgram.synthetic.options import SMALL
from limbgram.synthetic.truth import stage_truth

AXE = Path(__file__).parents[2] / "web" / "node_modules" / "axe-core" / "axe.min.js"
NEAR_MM = 0.2
MOVED_MM = np.array([10.0, -20.0, 30.0])
"""From an earlier visit to today."""
USER, PASSWORD = "A. Meier", "a password of the walk"
PLACES = ("cases", "cameras", "settings")
STEPS = ("capture", "result", "align", "measure", "rectify", "send", "record", "compare")
COMPUTED_MS = 480_000
expect.set_options(timeout=30_000)
WAYS = """
const real = (window.real = window.fetch);
let number = 0;
const lostOnce = new Set();
window.fetch = async (input, init) => {
  const way = sessionStorage.getItem("test.way") ?? "as it is";
  const request = new Request(input, init);
  const act = request.headers.get("Act-Id");
  const late = [2000, 200, 1100][number++ % 3];
  const wait = (ms) => new Promise((go) => setTimeout(go, ms));
  if (way === (act ? "stopped" : "deaf")) await wait(1e9);
  const answer = await real(request);
  if (way === "late") await wait(act ? 2000 : late);
  if (way === "limb last" && request.url.includes("/surface?")) await wait(4000);
  if (way === "lost" && act && !lostOnce.has(act)) {
    lostOnce.add(act);
    throw new TypeError("Failed to fetch");
  }
  return answer;
};
"""
"""How answers reach the page: as they are; late, those of questions in another order; each act's
first one never; no act leaves the page at all, as before a reload; nothing that it asks for; or the
limb after all else."""

OUT_OF_PLACE = """() => {
  const box = (one) => one.getBoundingClientRect();
  const shown = (one) => box(one).width > 0 && !one.closest(".unseen");
  const name = (one) => (one.textContent || one.ariaLabel || one.className).trim();
  const out = [];
  for (const one of [...document.querySelectorAll(".pane *, #content *")].filter(shown)) {
    if (one.matches(".btn, .seg, th, td, .field")) {
      const holds = one.closest("section, .next, .acts, .camera-card");
      const pad = holds && getComputedStyle(holds);
      const edge = holds && box(holds).right - parseFloat(pad.paddingRight);
      if (holds && box(one).right > edge + 1) out.push(name(one));
    }
    if (one.matches(".btn, .field") && one.scrollWidth > one.clientWidth + 1) out.push(name(one));
  }
  const steps = [...document.querySelectorAll(".rail a")].filter(shown).map((one) => {
    const words = document.createRange();
    words.selectNodeContents(one);
    return [name(one), words.getBoundingClientRect()];
  });
  const rail = box(document.querySelector(".rail"));
  for (const [words, at] of steps) {
    if (rail.height > rail.width && (at.left < rail.left || at.right > rail.right)) out.push(words);
    for (const [other, there] of steps) {
      const apart = at.right <= there.left || there.right <= at.left;
      if (words !== other && !apart && at.top < there.bottom && there.top < at.bottom)
        out.push(`${words} on ${other}`);
    }
  }
  return out;
}"""
"""Words of controls that are cut, lie beyond the padding of what holds them, or on each other."""


@dataclass(frozen=True)
class App:
    """The app that runs, and where its cases lie."""

    origin: str
    cases: Path
    page: Page


@pytest.fixture(scope="session")
def capture(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A small capture with its truth."""
    folder = tmp_path_factory.mktemp("capture") / "made"
    command("make-capture", str(folder), "--photos", "12", "--width", "800", "--seed", "23")
    return folder


@pytest.fixture(scope="session")
def app(tmp_path_factory: pytest.TempPathFactory) -> Iterator[App]:
    """The app in Chromium, signed in by its start link."""
    cases = tmp_path_factory.mktemp("cases")
    with serving("--cases", str(cases)) as link, sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=shutil.which("chromium"),
            args=["--enable-unsafe-swiftshader", "--no-sandbox"],
        )
        page = browser.new_page(viewport={"width": 1200, "height": 750}, locale="en-GB")
        page.set_default_timeout(120_000)
        page.goto(link)
        page.get_by_role("heading", name="Cases").wait_for()
        yield App(link.split("/start")[0], cases, page)
        browser.close()


def test_photos_become_a_checked_file_by_clicks_alone(
    app: App, capture: Path, tmp_path: Path
) -> None:
    page = app.page
    camera = tmp_path / "camera.json"
    board = ("--board", "14x10", "--square", "10")
    command("calibrate", str(capture / "calibration"), *board, "-o", str(camera))

    # A calibrated camera is taken in.
    page.goto(f"{app.origin}/#/cameras")
    page.get_by_role("button", name="New camera").click()
    page.get_by_label("Name of the camera").fill("Test camera")
    page.get_by_role("button", name="Make the entry").click()
    page.locator(".camera-card input[type=file]").set_input_files(camera)
    page.locator(".camera-card .chip.green").wait_for()
    no_serious_fault(app)

    # A case, its photos, the run.
    new_case(app)
    photos = sorted((capture / "images").iterdir())
    page.locator("#photo-files").set_input_files(photos)
    page.get_by_role("heading", name=f"{len(photos)} photos are here", exact=True).wait_for()
    page.get_by_label("Camera", exact=True).select_option(index=1)
    no_serious_fault(app)
    page.get_by_role("button", name="Compute anyway").click()
    page.locator(".confirm").get_by_role("button", name="Compute anyway").click()
    paused_cancelled_continued(app)
    page.get_by_role("button", name="Next: mark places to align").wait_for(timeout=COMPUTED_MS)
    case_id = page.url.split("/case/")[1].split("/")[0]
    no_serious_fault(app)

    # Landmarks, picked where they are drawn at three sizes.
    page.get_by_role("button", name="Next: mark places to align").click()
    page.locator(".armed-note").wait_for()
    page.locator(".overlay .bar path").wait_for(state="attached")
    box = page.locator(".limb-canvas").bounding_box()
    assert box is not None
    middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    with page.expect_response(lambda answer: "/limb/places/" in answer.url):
        page.mouse.click(middle[0], middle[1] - 90)
    page.locator(".places-list li.placed").first.wait_for()
    for _ in range(3):
        picked_again_lies_where_it_was(app, case_id)
        page.mouse.move(middle[0], middle[1] - 60)
        page.mouse.wheel(0, -240)
        page.wait_for_timeout(600)
    no_serious_fault(app)
    page.get_by_role("button", name="Set front and axis").click()
    page.get_by_text("Front set", exact=True).wait_for()
    guessed_and_turned_by_hand(app, case_id)

    # Measure, then an edit by drawing and dragging.
    page.get_by_role("button", name="Next: measure").click()
    page.locator(".tape-input").first.wait_for()
    no_serious_fault(app)
    page.get_by_role("button", name="Next: rectify").click()
    page.locator(".tools").wait_for()
    page.locator(".overlay .ruler .flag").wait_for(state="attached")
    page.wait_for_timeout(1500)
    draw_round(app, middle[0], middle[1] + 20, 45)
    page.locator(".pane .edit .eff:not(.waits)").wait_for()
    drag_handle(app, 20)
    page.locator(".pane .edit .eff:not(.waits)").wait_for()
    no_serious_fault(app)
    page.locator(".pane .edit").get_by_role("button", name="Keep", exact=True).click()
    page.locator(".edits .ed").wait_for()
    recipe = (app.cases / case_id / "work" / "recipe.toml").read_text("utf-8")
    assert tomllib.loads(recipe)["edit"][0]["do"] == "load"

    template_learned_and_tried(app)
    trimline_dragged_cut_and_undone(app, case_id)
    compared_with_the_scan(app)
    compared_with_an_earlier_state(app)

    # The file, after the two checks.
    page.get_by_role("button", name="Next: send").click()
    page.locator(".opt", has_text="STL").click()
    assert page.locator("#save-file").count() == 0
    page.locator(".lr.left").click()
    page.locator(".mirror").wait_for()
    assert page.locator("#save-file").count() == 0
    page.locator(".tick input").check()
    no_serious_fault(app)
    with page.expect_download() as saving:
        page.locator("#save-file").click()
    saved = Path(saving.value.path()).read_bytes()

    # The same bytes as the command line's.
    work = app.cases / case_id / "work"
    scan = next(one for one in work.iterdir() if one.name in ("surface.ply", "surface-RED.ply"))
    edited, stl = tmp_path / "edited.ply", tmp_path / "out.stl"
    command("edit", "apply", str(scan), str(work / "recipe.toml"), "-o", str(edited))
    command("export", str(edited), "--to", "stl", "--side", "left", "-o", str(stl))
    assert saved == stl.read_bytes()


def test_a_phone_sends_photos_through_a_door_that_is_switched_on(app: App, capture: Path) -> None:
    desk = app.page
    photos = sorted((capture / "images").iterdir())
    new_case(app)
    desk.get_by_role("button", name="From a phone").click()
    desk.get_by_role("button", name="Switch on and show the code").wait_for()
    assert desk.locator(".qr").count() == 0
    desk.get_by_role("button", name="Switch on and show the code").click()
    desk.locator(".qr").wait_for()
    no_serious_fault(app)
    browser = desk.context.browser
    assert browser is not None
    phone = browser.new_context(
        viewport={"width": 390, "height": 844}, locale="en-GB", has_touch=True, is_mobile=True
    )
    held = App(app.origin, app.cases, phone.new_page())
    page = held.page
    page.goto(desk.locator(".from-phone .mono").inner_text())
    page.get_by_role("button", name="Choose from the phone").wait_for()
    no_serious_fault(held)
    page.locator("#phone-files").set_input_files(photos[:4])
    page.get_by_role("heading", name="4 of 4 are on the clinic machine").wait_for()

    # Without a network the photos wait, and go on by themselves.
    phone.set_offline(True)
    page.locator("#phone-files").set_input_files(photos[4:7])
    page.get_by_text("3 photos wait here. Keep this page open.").wait_for()
    no_serious_fault(held)
    phone.set_offline(False)
    page.get_by_role("heading", name="7 of 7 are on the clinic machine").wait_for()
    desk.get_by_role("heading", name="7 photos are here", exact=True).wait_for()
    received = app.cases / desk.url.split("/case/")[1].split("/")[0] / "received"
    arrived = [one for one in received.rglob("*.jpg") if one.name in {p.name for p in photos}]
    assert len(arrived) == 7

    # The coach's answer reaches both; a door that is shut lets nothing in.
    page.locator(".phone-page .dial").wait_for()
    desk.locator(".expected").wait_for()
    no_serious_fault(held)
    no_serious_fault(app)
    desk.get_by_role("button", name="Switch off").click()
    desk.get_by_text("Sending from a phone is off.").wait_for()
    page.locator("#phone-files").set_input_files(photos[7])
    page.get_by_text("1 photo waits here. Keep this page open.").wait_for()
    phone.close()


def test_every_page_is_without_serious_faults_of_access(app: App) -> None:
    every_page(app)


@pytest.mark.parametrize(
    ("width", "height", "scheme"),
    [(1440, 900, "dark"), (1024, 768, "light"), (820, 1180, "dark"), (390, 844, "light")],
)
def test_pages_of_other_sizes_and_dark_ones_too(
    app: App, width: int, height: int, scheme: Literal["light", "dark"]
) -> None:
    with another_window(app, width, height, scheme) as other:
        every_page(other)
        wider = "document.documentElement.scrollWidth - innerWidth"
        assert other.page.evaluate(wider) <= 0, "the page is wider than its window"
        opened_panels(other)


@pytest.mark.parametrize(("width", "height"), [(1200, 750), (820, 1180), (390, 844)])
def test_german_words_fit_their_places(app: App, width: int, height: int) -> None:
    """They are the longest: nothing lies beyond what holds it, and no step on another one."""
    with another_window(app, width, height, "light") as other:
        other.page.add_init_script("localStorage.setItem('limbgram.language', 'de')")
        for place in PLACES:
            other.page.goto(f"{app.origin}/#/{place}")
            other.page.locator("#content h1, #content h2").first.wait_for()
            assert other.page.evaluate(OUT_OF_PLACE) == [], place
        for step in STEPS:
            other.page.goto(f"{app.origin}/#/case/{computed(app)}/{step}")
            other.page.locator(f'.rail [aria-current][href$="/{step}"]').wait_for()
            other.page.wait_for_timeout(1500)
            assert other.page.evaluate(OUT_OF_PLACE) == [], step


@pytest.mark.parametrize(
    ("width", "height", "scheme"), [(1440, 900, "light"), (390, 844, "dark"), (1024, 768, "dark")]
)
def test_signing_in_and_the_lock_are_without_faults_and_hide_the_limb(
    app: App, width: int, height: int, scheme: Literal["light", "dark"], tmp_path: Path
) -> None:
    cases = tmp_path / "cases"
    add = ["app", "users", "add", USER, "--cases", str(cases), "--password-stdin"]
    subprocess.run([program(), *add], input=PASSWORD + "\n", text=True, check=True)
    network = ("--network", "--address", "127.0.0.1", "--port", str(free_port()))
    with (
        serving("--cases", str(cases), *network) as link,
        another_window(app, width, height, scheme, link) as other,
    ):
        page = other.page
        page.get_by_role("heading", name="Sign in").wait_for()
        no_serious_fault(other)
        signed_in(page, "not the password")
        page.get_by_text("The name or the password is not right.").wait_for()
        no_serious_fault(other)
        signed_in(page, PASSWORD)
        page.get_by_role("heading", name="Cases").wait_for()
        no_serious_fault(other)

        # Locked: what lies beneath is neither seen nor reached, and goes on after the password.
        page.get_by_role("button", name="New case").first.click()
        page.get_by_label("A few words, if you want").fill("second fitting")
        page.get_by_role("button", name="Lock", exact=True).click()
        page.get_by_role("heading", name="This page is locked.").wait_for()
        assert not page.get_by_label("A few words, if you want").is_visible()
        assert page.evaluate(f"fetch('{other.origin}/api/v1/cases').then((a) => a.status)") == 423
        no_serious_fault(other)
        page.get_by_label("Password").fill(PASSWORD)
        page.get_by_role("button", name="Unlock").click()
        words = page.get_by_label("A few words, if you want")
        words.wait_for()
        assert words.input_value() == "second fitting"


@dataclass(frozen=True)
class Worked:
    """A case with an aligned shape, and a window whose way to the server can be spoiled."""

    app: App
    case_id: str

    @property
    def page(self) -> Page:
        return self.app.page

    def open(self, step: str, way: str = "as it is") -> None:
        self.page.goto(f"{self.app.origin}/#/case/{self.case_id}/{step}")
        self.through(way)
        self.page.reload()

    def through(self, way: str) -> None:
        self.page.evaluate(f"sessionStorage.setItem('test.way', '{way}')")

    def asked(self, what: str, method: str = "GET", body: object = None) -> Any:
        """What the server itself says, past the page."""
        return asked(self.page, f"/api/v1/cases/{self.case_id}{what}", method, body)

    def settled(self) -> None:
        """Wait until no act is on its way, here or before a reload."""
        self.page.wait_for_function("() => !sessionStorage.getItem('limbgram.acts')")


@pytest.fixture
def worked(app: App) -> Iterator[Worked]:
    with another_window(app, 1200, 800, "light") as other:
        yield made_case(other)


def made_case(app: App) -> Worked:
    """A case with a shape that nobody had to compute, a place on it, and axes."""
    app.page.add_init_script(WAYS)
    app.page.goto(f"{app.origin}/#/cases")
    kind = {"kind": "transtibial", "side": "left"}
    case_id: str = asked(app.page, "/api/v1/cases", "POST", kind)["id"]
    limb = stage_truth(SMALL).limb.mesh
    folder = app.cases / case_id / "deliverables"
    folder.mkdir()
    write_ply(limb, folder / "surface.ply", "mm")
    case = Worked(app, case_id)
    front = limb.vertices_mm[np.argmax(limb.vertices_mm[:, 1])].tolist()
    case.asked("/limb/places/patellar tendon", "PUT", {"position_mm": front})
    axes = {"side": "left", "kind": "transtibial", "proximal": [0, 0, 1], "anterior": [0, 1, 0]}
    case.asked("/limb/align", "POST", axes)
    return case


def asked(page: Page, path: str, method: str = "GET", body: object = None) -> Any:
    return page.evaluate(
        """async ([path, method, body]) => {
            const headers = { "Content-Type": "application/json" };
            const request = { method, headers, body: body === null ? undefined : body };
            const answer = await (window.real ?? fetch)(path, request);
            if (!answer.ok) throw new Error(`${answer.status} ${await answer.text()}`);
            return await answer.json();
        }""",
        [path, method, None if body is None else json.dumps(body)],
    )


WAYS_BACK = ["as it is", "late", "lost", "reload", "back"]


@pytest.mark.parametrize("way", WAYS_BACK)
def test_answers_late_or_lost_keep_every_reading_of_the_tape(worked: Worked, way: str) -> None:
    page = worked.page
    worked.asked("/tape", "PATCH", {"height_mm": 40.0, "girth_mm": 250.0})
    worked.open("measure", {"reload": "stopped", "back": "late"}.get(way, way))
    typed = {60: "301.5", 80: "302,5", 100: "303", 120: "304", 140: "305"}
    page.get_by_label("Girth by tape at 60 mm").wait_for()
    for height, text in typed.items():
        page.get_by_label(f"Girth by tape at {height} mm").fill(text)
        page.keyboard.press("Tab")
    page.get_by_label("Girth by tape at 40 mm").fill("")
    page.keyboard.press("Enter")
    page.get_by_label("Girth by tape at 120 mm").fill("314")
    page.keyboard.press("Enter")
    expect(page.get_by_label("Girth by tape at 120 mm")).to_have_value("314")
    expect(page.get_by_label("Girth by tape at 40 mm")).to_have_value("")
    if way == "reload":
        worked.through("late")
        page.reload()
        page.get_by_label("Girth by tape at 60 mm").wait_for()
    if way == "back":
        page.go_back()
        page.locator(".tape-input").first.wait_for(state="detached")
        page.go_forward()
        page.get_by_label("Girth by tape at 60 mm").wait_for()
    # On their way or kept: at no time does a field show what was there before.
    expect(page.get_by_label("Girth by tape at 120 mm")).to_have_value("314")
    expect(page.get_by_label("Girth by tape at 40 mm")).to_have_value("")
    worked.settled()
    readings = {one["height_mm"]: one["girth_mm"] for one in worked.asked("/tape")}
    assert readings == {60: 301.5, 80: 302.5, 100: 303, 120: 314, 140: 305}
    for height, girth in readings.items():
        field = page.get_by_label(f"Girth by tape at {height:g} mm")
        expect(field).to_have_value(f"{girth:g}")
    no_serious_fault(worked.app)


@pytest.mark.parametrize("way", ["late", "lost"])
def test_answers_to_two_windows_keep_what_each_reads_by_tape(worked: Worked, way: str) -> None:
    worked.asked("/tape", "PATCH", {"height_mm": 40.0, "girth_mm": 250.0})
    worked.open("measure")
    with another_window(worked.app, 1200, 800, "light") as app:
        app.page.add_init_script(WAYS)
        other = Worked(app, worked.case_id)
        other.open("measure")
        for window in (worked, other):  # both show the first reading before either changes one
            expect(window.page.get_by_label("Girth by tape at 40 mm")).to_have_value("250")
            window.through(way)
        for height, window in ((60, worked), (80, other), (100, worked), (120, other)):
            window.page.get_by_label(f"Girth by tape at {height} mm").fill(f"{300 + height}")
            window.page.keyboard.press("Enter")
        worked.page.get_by_label("Girth by tape at 40 mm").fill("")
        worked.page.keyboard.press("Enter")
        for window in (worked, other):
            window.settled()
        readings = {one["height_mm"]: one["girth_mm"] for one in worked.asked("/tape")}
        assert readings == {60: 360, 80: 380, 100: 400, 120: 420}
        for window in (worked, other):  # each hears of the other's
            expect(window.page.get_by_label("Girth by tape at 40 mm")).to_have_value("")
            for height, girth in readings.items():
                field = window.page.get_by_label(f"Girth by tape at {height:g} mm")
                expect(field).to_have_value(f"{girth:g}")


@pytest.mark.parametrize("way", ["as it is", "late", "lost"])
def test_answers_late_or_lost_bring_readings_and_acceptance_from_clicks_to_the_sheets(
    worked: Worked, way: str
) -> None:
    """A reading that fits, one 12 mm beyond the girth that is accepted, one taken back."""
    page = worked.page
    levels = worked.asked("/measures", "POST", {"spacing_mm": 20})["levels"]
    girths = {round(one["height_mm"]): one["tape_mm"]["value"] for one in levels}
    worked.open("measure", way)
    for height, off_mm in ((60, 0.0), (80, 12.0), (100, -70.0)):
        page.get_by_label(f"Girth by tape at {height} mm").fill(f"{girths[height] + off_mm:.1f}")
        page.keyboard.press("Enter")
    page.get_by_role("heading", name="2 readings disagree").wait_for()
    page.get_by_label("Girth by tape at 100 mm").fill("")
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="1 reading disagrees").wait_for()
    page.get_by_role("button", name="Show it").click()
    page.get_by_text(f"At 80 mm: {girths[80]:.1f} mm by a taut tape").wait_for()
    page.get_by_role("button", name="Go on with the conflict").click()
    page.locator(".tools").wait_for()
    worked.settled()
    page.get_by_role("link", name="Record").click()
    sheet = page.frame_locator("iframe.sheet")
    sheet.get_by_role("cell", name="they contradict each other; accepted").wait_for()
    link = page.get_by_role("link", name="Open the PDF").get_attribute("href")
    assert link == f"{worked.app.origin}/api/v1/cases/{worked.case_id}/record.pdf"
    answer = page.request.get(link)
    paper = PdfDocument(answer.body())
    text = " ".join(sheet.get_textpage().get_text_range() for sheet in paper)
    paper.close()
    printed = " ".join(text.replace("\u200b", "").split())
    assert f"case {worked.case_id}" in printed
    for height, off_mm, said in (
        (60, 0.0, r"[+-]0\.[0-9] ± [0-9.]+ agrees"),
        (80, 12.0, r"-1[12]\.[0-9] ± [0-9.]+ they contradict each other; accepted 20"),
        (100, -70.0, r"\+(70|69)\.[0-9] ± [0-9.]+ they contradict each other; taken back 20"),
    ):
        read, scan = f"{girths[height] + off_mm:.1f}", f"{girths[height]:.1f}"
        assert re.search(f"{height} {re.escape(read)} {re.escape(scan)} {said}", printed), printed


def test_show_it_marks_where_the_surface_is_least_sure(worked: Worked) -> None:
    page = worked.page
    limb = stage_truth(SMALL).limb.mesh
    behind = int(np.argmin(limb.vertices_mm[:, 1]))
    away_mm = np.linalg.norm(limb.vertices_mm - limb.vertices_mm[behind], axis=1)
    sigma_mm = np.where(away_mm < 12, 0.5, 0.05).astype(np.float32)
    folder = worked.app.cases / worked.case_id / "deliverables"
    write_ply(replace(limb, sigma_mm=sigma_mm), folder / "surface.ply", "mm")
    worked.asked("/limb/refresh", "POST")
    worked.open("result")
    page.get_by_text("Least sure at height").wait_for()
    assert page.locator(".overlay .place").count() == 0
    page.get_by_role("button", name="Show it").click()
    page.locator(".overlay .place.chosen:not(.unseen-place)").wait_for(state="attached")
    page.get_by_text("± 0.98 mm", exact=True).wait_for()  # 1.96 of 0.5
    page.wait_for_timeout(1500)
    x, y = drawn_at(worked.app, ".overlay .place.chosen .dot")
    box = page.locator(".limb-canvas").bounding_box()
    assert box is not None
    assert abs(x - box["x"] - box["width"] / 2) < box["width"] / 8
    assert abs(y - box["y"] - box["height"] / 2) < box["height"] / 3
    no_serious_fault(worked.app)


def test_answers_that_are_late_never_let_the_tape_agree_before_it_was_compared(
    worked: Worked,
) -> None:
    page = worked.page
    levels = worked.asked("/measures", "POST", {"spacing_mm": 20})["levels"]
    girth = {round(one["height_mm"]): one["tape_mm"] for one in levels}
    worked.asked("/tape", "PATCH", {"height_mm": 60.0, "girth_mm": girth[60]["value"]})
    worked.open("measure")
    page.get_by_role("heading", name="The tape agrees").wait_for()
    worked.through("late")
    page.get_by_label("Girth by tape at 80 mm").fill(f"{girth[80]['value'] + 40:.1f}")
    page.evaluate(
        """() => {
            window.said = [];
            const look = () => window.said.push(document.querySelector(".pane h2").textContent);
            new MutationObserver(look).observe(document.querySelector(".pane"),
                { subtree: true, childList: true, characterData: true });
        }"""
    )
    page.keyboard.press("Enter")
    page.get_by_role("heading", name="1 reading disagrees").wait_for()
    said = page.evaluate("window.said")
    assert "The tape agrees" not in said
    assert "Comparing the tape with the surface" in said


def test_answers_do_not_overwrite_what_is_being_typed(worked: Worked) -> None:
    page = worked.page
    worked.open("measure", "late")
    page.get_by_label("Girth by tape at 60 mm").fill("301")
    page.keyboard.press("Tab")
    half = page.get_by_label("Girth by tape at 80 mm")
    half.fill("30")
    worked.settled()
    page.wait_for_timeout(2500)  # the comparison of the first comes as well
    expect(half).to_have_value("30")
    expect(half).to_be_focused()
    half.press_sequentially("2")
    half.press("Enter")
    worked.settled()
    assert [one["girth_mm"] for one in worked.asked("/tape")] == [301, 302]


def test_answers_name_a_word_in_place_of_a_girth_which_stays(worked: Worked) -> None:
    page = worked.page
    worked.open("measure")
    field = page.get_by_label("Girth by tape at 60 mm")
    field.fill("abc")
    page.keyboard.press("Tab")
    page.get_by_role("alert").get_by_text("“abc” is no number: nothing was kept.").wait_for()
    expect(field).to_have_value("abc")
    no_serious_fault(worked.app)
    field.fill("34.5")  # centimetres: the server's own refusal, beside the height that it is about
    page.keyboard.press("Enter")
    worked.asked("/tape", "PATCH", {"height_mm": 60.0, "girth_mm": 301.0})
    field.fill("3")
    page.keyboard.press("Enter")
    page.get_by_text("The tape at 60 mm is not kept as 3 mm.").wait_for()
    expect(field).to_have_value("301")
    # Two quick presses are two.
    spacing = page.get_by_label("Every", exact=True)
    page.evaluate(
        """() => {
            const more = [...document.querySelectorAll("button")]
                .find((one) => one.ariaLabel === "More: Every");
            more.click();
            more.click();
        }"""
    )
    expect(spacing).to_have_value("30")


@pytest.mark.parametrize("way", ["as it is", "late", "lost"])
def test_answers_late_or_lost_keep_an_edit_once_that_enter_was_pressed_twice_for(
    worked: Worked, way: str
) -> None:
    page = worked.page
    worked.open("rectify", way)
    page.locator(".overlay .place").first.wait_for(state="attached")
    page.get_by_text("No edit yet").wait_for()
    page.wait_for_timeout(3000 if way == "late" else 1500)
    box = page.locator(".limb-canvas").bounding_box()
    assert box is not None
    draw_round(worked.app, box["x"] + box["width"] / 2, box["y"] + box["height"] / 2, 45)
    page.locator(".pane .edit .eff:not(.waits)").wait_for()
    page.locator(".limb-canvas").focus()
    page.keyboard.press("Enter")
    page.keyboard.press("Enter")
    page.locator(".edits .ed").wait_for()
    page.keyboard.press("Enter")
    worked.settled()
    page.wait_for_timeout(500)
    assert [one["kind"] for one in worked.asked("/recipe")["edits"]] == ["load"]

    # By numbers: the fields stay, and Enter keeps them once until one is changed.
    page.locator(".tool", has_text="Others").click()
    page.get_by_label("Others").select_option("smoothing")
    page.get_by_label("Passes").fill("2")
    page.get_by_label("Passes").press("Enter")
    page.get_by_label("Passes").press("Enter")
    page.locator(".edits .ed").nth(1).wait_for()
    page.get_by_label("Passes").press("Enter")
    worked.settled()
    page.wait_for_timeout(500)
    kinds = [one["kind"] for one in worked.asked("/recipe")["edits"]]
    assert kinds == ["load", "smoothing"]


def test_answers_before_the_limb_is_here_show_what_an_edit_does(worked: Worked) -> None:
    page = worked.page
    worked.open("rectify", "limb last")
    page.locator(".tool", has_text="Others").click()
    page.get_by_label("Others").select_option("smoothing")
    page.get_by_label("Passes").fill("2")
    page.locator(".pane .other-edit .eff:not(.waits)").wait_for(timeout=20_000)


@pytest.mark.parametrize("way", ["late", "lost", "reload", "back"])
def test_answers_late_or_lost_let_a_number_mean_the_edit_that_is_shown(
    worked: Worked, way: str
) -> None:
    page = worked.page
    for passes in (1, 2, 3, 4):
        edit = {"kind": "smoothing", "parameters": {"passes": passes}}
        worked.asked("/recipe/edits", "POST", edit)
    worked.open("rectify", {"reload": "stopped", "back": "late"}.get(way, way))
    rows = page.locator(".edits .ed")
    rows.nth(3).wait_for()
    rows.nth(3).get_by_role("switch").click()
    for left in (3, 2):  # the first one twice, faster than any answer
        rows.nth(0).locator(".ed-name").click()
        page.get_by_role("button", name="Take it out").click()
        expect(rows).to_have_count(left)
    rows.nth(0).get_by_role("switch").click()
    rows.nth(0).get_by_role("switch").click()
    if way == "reload":
        worked.through("late")
        page.reload()
        expect(rows).to_have_count(2)
    if way == "back":
        page.go_back()
        rows.first.wait_for(state="detached")
        page.go_forward()
        expect(rows).to_have_count(2)
    worked.settled()
    edits = worked.asked("/recipe")["edits"]
    assert [(one["parameters"]["passes"], one["on"]) for one in edits] == [(3, True), (4, False)]
    expect(rows).to_have_count(2)


def test_places_of_an_earlier_visit_are_confirmed_by_a_press(worked: Worked) -> None:
    limb, folder = stage_truth(SMALL).limb.mesh, worked.app.cases
    kind = {"kind": "transtibial", "side": "left"}
    today = replace(worked, case_id=asked(worked.page, "/api/v1/cases", "POST", kind)["id"])
    (folder / today.case_id / "deliverables").mkdir()
    moved = limb.with_vertices(limb.vertices_mm + MOVED_MM)
    write_ply(moved, folder / today.case_id / "deliverables" / "surface.ply", "mm")
    today.open("align")
    page = today.page
    row = page.locator(".places-list li", has_text="patellar tendon")
    page.get_by_label("Places of an earlier visit").select_option(worked.case_id)
    expect(row).to_contain_text(re.compile(r"as at the visit, ± \d+\.\d mm"))
    no_serious_fault(today.app)
    row.get_by_role("button", name="It is there: patellar tendon").click()
    today.settled()
    (place,) = today.asked("/limb")["places"]
    (marked,) = worked.asked("/limb")["places"]
    off = np.subtract(place["position_mm"], marked["position_mm"]) - MOVED_MM
    assert np.linalg.norm(off) < 1.0
    expect(row).not_to_contain_text("as at the visit")


def test_answers_to_two_windows_never_change_an_edit_that_one_of_them_does_not_show(
    worked: Worked,
) -> None:
    for passes in (1, 2):
        edit = {"kind": "smoothing", "parameters": {"passes": passes}}
        worked.asked("/recipe/edits", "POST", edit)
    worked.open("rectify")
    worked.page.locator(".edits .ed").nth(1).wait_for()
    with another_window(worked.app, 1200, 800, "light") as app:
        app.page.add_init_script(WAYS)
        other = Worked(app, worked.case_id)
        other.open("rectify")
        other.page.locator(".edits .ed").nth(1).wait_for()
        other.through("deaf")  # it goes on showing both
        rows = worked.page.locator(".edits .ed")
        rows.nth(0).locator(".ed-name").click()
        worked.page.get_by_role("button", name="Take it out").click()
        expect(rows).to_have_count(1)
        worked.settled()
        other.page.locator(".edits .ed").nth(0).get_by_role("switch").click()
        other.page.get_by_text("The recipe was changed meanwhile").wait_for()
        edits = worked.asked("/recipe")["edits"]
        assert [(one["parameters"]["passes"], one["on"]) for one in edits] == [(2, True)]
        # It asks anew and shows what there is; undo is heard in it too.
        other.through("as it is")
        other.page.reload()
        expect(other.page.locator(".edits .ed")).to_have_count(1)
        worked.page.get_by_role("button", name="Undo").click()
        expect(other.page.locator(".edits .ed")).to_have_count(2)


@pytest.mark.parametrize("way", WAYS_BACK)
def test_answers_late_or_lost_keep_every_place(worked: Worked, way: str) -> None:
    page = worked.page
    worked.open("align", {"reload": "stopped", "back": "late"}.get(way, way))
    page.locator(".places-list li.placed").first.wait_for()
    page.wait_for_timeout(1500)
    box = page.locator(".limb-canvas").bounding_box()
    assert box is not None
    names = ["tibial crest", "tibial tubercle", "fibula head"]
    for k, name in enumerate(names):
        row = page.locator(".places-list li", has_text=name[0].upper() + name[1:])
        if row.get_by_role("button").first.get_attribute("aria-pressed") != "true":
            row.get_by_role("button").first.click()
        page.mouse.click(box["x"] + box["width"] / 2, box["y"] + box["height"] / 2 - 60 + 50 * k)
        expect(page.locator(".places-list li.placed")).to_have_count(2 + k)
    page.get_by_role("button", name="Take away: Patellar tendon").click()
    expect(page.locator(".places-list li.placed")).to_have_count(3)
    if way == "reload":
        worked.through("late")
        page.reload()
    if way == "back":
        page.go_back()
        page.go_forward()
    expect(page.locator(".places-list li.placed")).to_have_count(3)
    worked.settled()
    places = [one["name"] for one in worked.asked("/limb")["places"]]
    assert sorted(places) == sorted(names)


@pytest.mark.parametrize("way", ["late", "lost"])
def test_answers_to_two_windows_keep_every_place_that_each_sets(worked: Worked, way: str) -> None:
    with another_window(worked.app, 1200, 800, "light") as app:
        app.page.add_init_script(WAYS)
        other = Worked(app, worked.case_id)
        windows = {"tibial crest": worked, "fibula head": other}
        for window in windows.values():  # both show the first place before either sets another
            window.open("align")
            window.page.locator(".places-list li.placed").first.wait_for()
            window.page.wait_for_timeout(1500)
            window.through(way)
        for k, (name, window) in enumerate(windows.items()):
            page = window.page
            row = page.locator(".places-list li", has_text=name[0].upper() + name[1:])
            if row.get_by_role("button").first.get_attribute("aria-pressed") != "true":
                row.get_by_role("button").first.click()
            box = page.locator(".limb-canvas").bounding_box()
            assert box is not None
            middle = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
            page.mouse.click(middle[0], middle[1] - 40 + 60 * k)
        for window in windows.values():
            window.settled()
            expect(window.page.locator(".places-list li.placed")).to_have_count(3)
    places = [one["name"] for one in worked.asked("/limb")["places"]]
    assert sorted(places) == sorted(["patellar tendon", *windows])


def test_answers_that_are_late_are_told_of_without_moving_the_limb(worked: Worked) -> None:
    """What comes by itself lies over the page: else the next press lands elsewhere on the limb."""
    page = worked.page
    worked.open("align")
    page.locator(".overlay .place").first.wait_for(state="attached")
    before = page.locator(".limb-canvas").bounding_box()
    worked.through("stopped")
    page.get_by_role("button", name="It is there: distal end").click()
    page.get_by_text("1 change is on the way").wait_for()
    assert page.locator(".limb-canvas").bounding_box() == before
    no_serious_fault(worked.app)


@pytest.mark.parametrize("way", ["late", "lost", "reload", "back"])
def test_answers_late_or_lost_keep_what_is_said_of_a_case(worked: Worked, way: str) -> None:
    page = worked.page
    worked.open("measure")
    page.locator(".tape-input").first.wait_for()
    page.goto(f"{worked.app.origin}/#/cases")
    page.get_by_role("button", name=f"More: {worked.case_id}").click()
    page.get_by_role("button", name="Rename").click()
    page.locator(".confirm").get_by_label("A few words, if you want").fill("second fitting")
    page.locator(".confirm .choice", has_text="RIGHT").click()
    worked.through({"reload": "stopped", "back": "late"}.get(way, way))
    page.locator(".confirm").get_by_role("button", name="Save").click()
    page.wait_for_function("() => sessionStorage.getItem('limbgram.acts')")
    if way == "reload":
        worked.through("late")
        page.reload()
    if way == "back":
        page.go_back()
        page.get_by_role("heading", name="Cases").wait_for(state="detached")
        page.go_forward()
    worked.settled()
    label = worked.asked("")
    assert (label["note"], label["side"]) == ("second fitting", "right")
    row = page.locator("tr", has=page.get_by_role("button", name=f"More: {worked.case_id}"))
    expect(row).to_contain_text("second fitting")


def test_answers_to_two_windows_keep_what_each_says_of_a_case(worked: Worked) -> None:
    with another_window(worked.app, 1200, 800, "light") as app:
        app.page.add_init_script(WAYS)
        windows = [worked.page, app.page]
        for page in windows:  # both forms are open before either is kept
            page.goto(f"{app.origin}/#/cases")
            page.get_by_role("button", name=f"More: {worked.case_id}").click()
            page.get_by_role("button", name="Rename").click()
            page.evaluate("sessionStorage.setItem('test.way', 'late')")
        worked.page.locator(".confirm").get_by_label("A few words, if you want").fill("second")
        app.page.locator(".confirm .choice", has_text="RIGHT").click()
        for page in windows:
            page.locator(".confirm").get_by_role("button", name="Save").click()
        for page in windows:
            page.wait_for_function("() => !sessionStorage.getItem('limbgram.acts')")
    label = worked.asked("")
    assert (label["note"], label["side"], label["kind"]) == ("second", "right", "transtibial")


def test_answers_apart_what_one_window_chooses_is_chosen_in_the_other(worked: Worked) -> None:
    worked.open("capture")
    other = worked.page.context.new_page()
    other.goto(f"{worked.app.origin}/#/case/{worked.case_id}/capture")
    for page in (worked.page, other):
        page.get_by_label("Size by", exact=True).wait_for()
    worked.page.get_by_label("I taped one girth, to check the size").check()
    other.get_by_label("Size by", exact=True).select_option("own")
    for page in (worked.page, other):
        expect(page.get_by_label("I taped one girth, to check the size")).to_be_checked()
        expect(page.get_by_label("Size by", exact=True)).to_have_value("own")
    other.close()

    # A reload, and Back and forth, with answers that come late or not at all, lose none of it.
    page = worked.page
    for way in ("late", "deaf"):
        worked.through(way)
        page.reload() if way == "late" else page.go_back()
        worked.through("late")
        page.goto(f"{worked.app.origin}/#/case/{worked.case_id}/capture")
        expect(page.get_by_label("I taped one girth, to check the size")).to_be_checked()
        expect(page.get_by_label("Size by", exact=True)).to_have_value("own")


def every_page(app: App) -> None:
    """Each place and each step of a case that is computed."""
    for place in PLACES:
        app.page.goto(f"{app.origin}/#/{place}")
        app.page.locator("#content h1, #content h2").first.wait_for()
        no_serious_fault(app)
    case_id = computed(app)
    for step in STEPS:
        app.page.goto(f"{app.origin}/#/case/{case_id}/{step}")
        app.page.locator(f'.rail [aria-current][href$="/{step}"]').wait_for()
        app.page.wait_for_timeout(1500)
        no_serious_fault(app)


def opened_panels(app: App) -> None:
    """What opens in pages: help, a new case, a new camera, edits by numbers and by templates."""
    page = app.page
    page.goto(f"{app.origin}/#/cases")
    page.get_by_role("button", name="New case").first.click()
    page.get_by_role("button", name="Help").click()
    no_serious_fault(app)
    page.goto(f"{app.origin}/#/cameras")
    page.get_by_role("button", name="New camera").click()
    no_serious_fault(app)
    page.goto(f"{app.origin}/#/case/{computed(app)}/rectify")
    page.locator(".right-tools").wait_for()
    for tool in ("Brush", "By levels", "Trimline", "Template", "Others"):
        if page.locator(".tool", has_text=tool).is_visible():
            page.locator(".tool", has_text=tool).click()
            page.wait_for_timeout(400)
            no_serious_fault(app)


def computed(app: App) -> str:
    """The case that has a shape."""
    return next(one.name for one in app.cases.iterdir() if (one / "report.html").is_file())


@contextmanager
def another_window(
    app: App, width: int, height: int, scheme: Literal["light", "dark"], link: str | None = None
) -> Generator[App]:
    """A window of another size: of the same session, or at a link of another server."""
    browser = app.page.context.browser
    assert browser is not None
    context = browser.new_context(
        viewport={"width": width, "height": height},
        color_scheme=scheme,
        locale="en-GB",
        has_touch=width < 1200,
        storage_state=app.page.context.storage_state() if link is None else None,
        ignore_https_errors=True,
    )
    page = context.new_page()
    page.set_default_timeout(120_000)
    if link is not None:
        page.goto(link)
    yield App(link or app.origin, app.cases, page)
    context.close()


@contextmanager
def serving(*options: str) -> Generator[str]:
    """The app as its own process; its link."""
    server = subprocess.Popen(
        [program(), "app", "--no-browser", "--json", *options], stdout=subprocess.PIPE, text=True
    )
    assert server.stdout is not None
    try:
        yield json.loads(server.stdout.readline())["link"]
    finally:
        server.terminate()
        server.wait(20)


def free_port() -> int:
    with socket.create_server(("127.0.0.1", 0)) as listening:
        return int(listening.getsockname()[1])


def signed_in(page: Page, password: str) -> None:
    page.get_by_label("Name").fill(USER)
    page.get_by_label("Password").fill(password)
    page.get_by_role("button", name="Sign in", exact=True).click()


def new_case(app: App) -> None:
    """A case of a left leg, by clicks."""
    page = app.page
    page.goto(f"{app.origin}/#/cases")
    page.get_by_role("button", name="New case").first.click()
    page.locator(".case-fields .choice", has_text="LEFT").click()
    page.locator(".case-fields .choice", has_text="Transtibial").click()
    page.get_by_role("button", name="Make the case").click()
    page.locator("#photo-files").wait_for(state="attached")


def paused_cancelled_continued(app: App) -> None:
    """A run is paused, goes on, is cancelled, and continues, each by one button."""
    page = app.page
    page.get_by_role("button", name="Pause").click()
    page.get_by_role("heading", name="Paused").wait_for()
    no_serious_fault(app)
    page.get_by_role("button", name="Go on").click()
    page.get_by_role("heading", name="Computing the shape").wait_for()
    page.get_by_role("button", name="Cancel", exact=True).click()
    page.locator(".confirm").get_by_role("button", name="Cancel the run").click()
    page.get_by_role("heading", name="Stopped at stage").wait_for()
    page.get_by_role("button", name="Continue").click()
    page.get_by_role("heading", name="Computing the shape").wait_for()


def picked_again_lies_where_it_was(app: App, case_id: str) -> None:
    """A place that is clicked where it is drawn stays where it is."""
    page = app.page
    before = place_of(app, case_id)
    x, y = drawn_at(app, ".overlay .place.chosen .dot, .overlay .place.set .dot")
    with page.expect_response(lambda answer: "/limb/places/" in answer.url):
        page.mouse.click(x, y)
    off_mm = float(np.linalg.norm(place_of(app, case_id) - before))
    assert off_mm < NEAR_MM, f"picked {off_mm:.3f} mm beside the place"


def guessed_and_turned_by_hand(app: App, case_id: str) -> None:
    """A guess is confirmed, and the axes are turned by degrees that are typed and kept."""
    page = app.page
    placed = page.locator(".places-list li.placed").count()
    page.get_by_role("button", name="It is there: distal end").click()
    page.locator(".places-list li.placed").nth(placed).wait_for()
    before = front_of(app, case_id)
    page.get_by_label("Turn", exact=True).fill("5")
    page.get_by_label("Turn", exact=True).press("Enter")
    page.locator(".hint-card").wait_for()
    no_serious_fault(app)
    page.get_by_role("button", name="Keep these axes").click()
    page.get_by_text("The axes are kept as turned by hand.").wait_for()
    turned_deg = math.degrees(math.acos(float(before @ front_of(app, case_id))))
    assert abs(turned_deg - 5.0) < 1e-3, f"turned by {turned_deg} degrees"


def front_of(app: App, case_id: str) -> np.ndarray:
    """Forwards, in the mesh's frame."""
    limb: dict[str, Any] = app.page.evaluate(
        f"fetch('/api/v1/cases/{case_id}/limb').then((answer) => answer.json())"
    )
    return np.array(limb["rotation"][1])


def template_learned_and_tried(app: App) -> None:
    """What was done is learned as a template, and tried on the limb without keeping it."""
    page = app.page
    page.locator(".tool", has_text="Template").click()
    page.get_by_role("button", name="Learn one").click()
    page.get_by_label("Name of the template").fill("As here")
    page.wait_for_timeout(400)  # the button's colour fades over while it is switched on
    no_serious_fault(app)
    page.get_by_role("button", name="Learn from 1 case").click()
    page.get_by_label("Which one?").select_option(index=1)
    page.locator(".pane .edit .btn.go:not(.off)").wait_for()
    page.wait_for_timeout(400)
    no_serious_fault(app)
    page.locator(".pane .edit").get_by_role("button", name="Drop", exact=True).click()


def trimline_dragged_cut_and_undone(app: App, case_id: str) -> None:
    """Points round the limb, one of them dragged; what is cut goes through where it was let go."""
    page = app.page
    page.locator(".tool", has_text="Trimline").click()
    box = page.locator(".limb-canvas").bounding_box()
    assert box is not None
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2 - 60
    page.locator(".limb-canvas").focus()
    for side in ("1", "2"):  # from the front, then from behind: round the limb in one direction
        page.keyboard.press(side)
        page.wait_for_timeout(1200)
        for along in (-40, 0, 40):
            page.mouse.click(x + along, y)
            page.wait_for_timeout(300)
    page.get_by_text("6 points.").wait_for()
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x, y + 10, steps=2)
    page.mouse.move(x, y + 24, steps=3)
    page.mouse.up()
    page.wait_for_timeout(400)
    page.get_by_text("6 points.").wait_for()  # it was moved, not joined by another
    drawn: list[list[float]] = page.evaluate(
        """[...document.querySelectorAll(".overlay .drawn .knot")].map((knot) => {
            const box = knot.getBoundingClientRect();
            return [box.x + box.width / 2, box.y + box.height / 2];
        })"""
    )
    assert min(math.hypot(a - x, b - y - 24) for a, b in drawn) < 3
    assert min(math.hypot(a - x, b - y) for a, b in drawn) > 15
    no_serious_fault(app)
    page.get_by_role("button", name="Cut here", exact=True).click()
    page.locator(".edits .ed").nth(1).wait_for()
    recipe = (app.cases / case_id / "work" / "recipe.toml").read_text("utf-8")
    cut = tomllib.loads(recipe)["edit"][1]
    assert cut["do"] == "trimline"
    assert len(cut["through"]) > 6  # between far points others of the line that was drawn
    page.get_by_label("Colours show the difference from").select_option("2")
    page.get_by_text("Against the shape before edit 2").wait_for()
    no_serious_fault(app)
    page.get_by_role("button", name="Undo").click()
    page.locator(".edits .ed").nth(1).wait_for(state="detached")
    page.get_by_text("Against the scan").wait_for()


def compared_with_an_earlier_state(app: App) -> None:
    """A second edit, and the shape before it as the other shape: only that edit is seen."""
    page = app.page
    page.get_by_role("link", name="Rectify").click()
    page.locator(".tool", has_text="Others").click()
    page.get_by_label("Others").select_option("smoothing")
    page.get_by_label("Passes").fill("2")
    page.locator(".pane .other-edit .eff:not(.waits)").wait_for()
    page.locator(".pane .edit").get_by_role("button", name="Keep", exact=True).click()
    page.locator(".edits .ed").nth(1).wait_for()
    page.get_by_role("link", name="Compare").click()
    page.get_by_role("combobox", name="The other shape").select_option("before 2")
    page.get_by_role("heading", name="Against the shape before edit 2").wait_for()
    page.locator(".pane .verdict .chip").wait_for()
    no_serious_fault(app)
    page.get_by_role("link", name="Rectify").click()
    page.locator(".edits .ed").nth(1).wait_for()
    page.get_by_role("button", name="Undo").click()
    page.locator(".edits .ed").nth(1).wait_for(state="detached")


def compared_with_the_scan(app: App) -> None:
    """The shape after the recipe beside the scan: the edit is where it differs."""
    page = app.page
    page.get_by_role("link", name="Compare").click()
    page.locator(".pane .verdict .chip").wait_for()
    page.locator(".legend .hatched").wait_for()
    page.get_by_text("Taken as they lie.").wait_for()
    no_serious_fault(app)


def place_of(app: App, case_id: str) -> np.ndarray:
    limb: dict[str, Any] = app.page.evaluate(
        f"fetch('/api/v1/cases/{case_id}/limb').then((answer) => answer.json())"
    )
    return np.array(limb["places"][0]["position_mm"])


def drawn_at(app: App, selector: str) -> tuple[float, float]:
    """The middle of a mark; what lies over the canvas is drawn anew with every picture of it."""
    found = app.page.wait_for_function(
        """(selector) => {
            const mark = document.querySelector(selector);
            const box = mark?.getBoundingClientRect();
            return box && box.width > 0 ? [box.x + box.width / 2, box.y + box.height / 2] : null;
        }""",
        arg=selector,
    )
    x, y = found.json_value()
    return float(x), float(y)


def draw_round(app: App, x: float, y: float, radius: float) -> None:
    mouse = app.page.mouse
    mouse.move(x + radius, y)
    mouse.down()
    for k in range(1, 33):
        angle = 2 * math.pi * k / 32
        mouse.move(x + radius * math.cos(angle), y + radius * math.sin(angle))
    mouse.up()


def drag_handle(app: App, by_px: float) -> None:
    """Pull the handle of the open edit a little farther in."""
    page = app.page
    x, y = drawn_at(app, ".knob .face-of-knob")
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + by_px / 2, y + by_px / 2)
    page.mouse.move(x + by_px, y + by_px)
    page.mouse.up()


def no_serious_fault(app: App) -> None:
    """What axe finds on the page as it is now; colours that change are where they go."""
    app.page.emulate_media(reduced_motion="reduce")
    app.page.evaluate(AXE.read_text("utf-8"))
    found: list[dict[str, Any]] = app.page.evaluate("axe.run().then((found) => found.violations)")
    serious = [
        f"{one['id']}: {one['help']}: {one['nodes'][0]['html'][:200]}"
        for one in found
        if one["impact"] in ("serious", "critical")
    ]
    assert not serious, json.dumps(serious, indent=1)


def command(*arguments: str) -> None:
    """Run the command line as a user would."""
    subprocess.run([program(), *arguments], check=True, capture_output=True)


def program() -> str:
    """The command that users call, of the environment that the tests run in."""
    found = shutil.which("limbgram")
    assert found is not None, "the command limbgram is not on the path"
    return found


def test_an_open_shell_is_said_and_a_wall_offered(worked: Worked) -> None:
    page = worked.page
    shell = page.get_by_text("This file is an open shell")
    limb = stage_truth(SMALL).limb.mesh
    heights = limb.vertices_mm[:, 2]
    low = (heights[limb.faces] < heights.max() - 60).all(1)
    folder = worked.app.cases / worked.case_id / "deliverables"
    write_ply(with_faces(limb, limb.faces[low]), folder / "surface.ply", "mm")
    worked.asked("/limb/refresh", "POST")
    worked.open("send")
    page.locator(".opt", has_text="STL").click()
    shell.wait_for()
    no_serious_fault(worked.app)
    page.get_by_role("button", name="Give it a wall").click()
    expect(page.get_by_label("Others")).to_have_value("wall")


def test_every_kind_of_file_is_offered_and_written(worked: Worked) -> None:
    worked.open("send")
    page = worked.page
    kinds = [one["kind"] for one in asked(page, "/api/v1/exports")]
    page.get_by_role("radio", name="left").click()
    page.get_by_role("button", name="More formats").click()
    assert page.locator(".opt").count() == len(kinds)
    for number in range(len(kinds)):
        page.locator(".opt").nth(number).click()
        ending = "nc" if kinds[number] == "gcode" else kinds[number]
        expect(page.locator(".file-name")).to_contain_text(f".{ending}", timeout=COMPUTED_MS)
    assert len(worked.asked("/exports")) == len(kinds)
