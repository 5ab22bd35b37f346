"""Pictures of every page of the app, as a browser shows it, for the documentation and for eyes.

Usage: python benchmarks/app_screens.py CASES CASE_ID -o FOLDER [--waiting CASE_ID] [--only result]

CASES is a folder of cases of `limbgram app`, CASE_ID a case in it that is computed and aligned,
--waiting one that has photos and no shape yet. Nothing in the folder is changed: what is drawn for
a picture is dropped again. Writes FOLDER/PAGE-SIZE.png at 1440 x 900, and at a tablet's and a
phone's size, each light and dark; with --beside DRAWN also FOLDER/PAGE-SIZE-beside.png, the page
next to its drawing DRAWN/PAGE-1440.png. The pages of the app on a network (signing in, locked) are
those of a second server, which has a user and no cases. Needs Playwright and Chromium; WebGL is
drawn by software, so this takes some minutes.
"""

import argparse
import io
import json
import math
import shutil
import subprocess
import sys
import tempfile
from collections.abc import Callable, Generator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from PIL import Image
from playwright.sync_api import Browser, Page, StorageState, sync_playwright
from playwright.sync_api import Error as PlaywrightError

from harness import asking


@dataclass(frozen=True)
class Size:
    """A window, and what its user wishes."""

    width: int
    height: int
    scheme: Literal["light", "dark"]
    touch: bool = False


SIZES = {
    "desk": Size(1440, 900, "light"),
    "dark": Size(1440, 900, "dark"),
    "tablet": Size(1024, 768, "light", touch=True),
    "tablet-dark": Size(1024, 768, "dark", touch=True),
    "upright": Size(820, 1180, "light", touch=True),
    "phone": Size(390, 844, "light", touch=True),
    "phone-dark": Size(390, 844, "dark", touch=True),
}
WAIT_MS = 90_000
USER, PASSWORD = "A. Meier", "a password of the pictures"
LEVELS = 32
"""Of each of red, green and blue in a small picture: a palette loses hues that are rare."""
MOST_BYTES = 120_000
"""Of a picture that is made smaller for the documentation."""


def no_act(_page: Page) -> None:
    """The page as it opens."""


@dataclass(frozen=True)
class Shot:
    """A page, and what a user does in it before the picture."""

    address: str
    """After the #; {case} is the case that is computed, {waiting} the one that is not."""
    settled: str = "#content"
    """What stands on the page once it is ready."""
    act: Callable[[Page], None] = no_act
    network: bool = False
    """Of the app on a network."""


def main() -> None:
    parser = asking(__doc__)
    parser.add_argument("cases", type=Path)
    parser.add_argument("case_id")
    parser.add_argument("--waiting", default="", help="A case with photos, not computed.")
    parser.add_argument("--only", default=",".join(SHOTS))
    parser.add_argument("--sizes", default=",".join(SIZES))
    parser.add_argument("--beside", type=Path, help="Folder of drawings of the pages.")
    parser.add_argument(
        "--width",
        type=int,
        default=0,
        help="Reduce pictures to this width, or to fewer pixels so that each stays below 120 kB.",
    )
    given = parser.parse_args()
    given.out.mkdir(parents=True, exist_ok=True)
    chromium = shutil.which("chromium")
    if chromium is None:
        sys.exit("The command chromium is needed.")
    names = given.only.split(",")
    if not given.waiting:
        names = [name for name in names if "{waiting}" not in SHOTS[name].address]
    with sync_playwright() as playwright:
        browser = playwright.chromium.launch(
            executable_path=chromium, args=["--enable-unsafe-swiftshader", "--no-sandbox"]
        )
        here = [name for name in names if not SHOTS[name].network]
        if here:
            with serving("--cases", str(given.cases)) as link:
                shoot_all(browser, link, here, given)
        there = [name for name in names if SHOTS[name].network]
        if there:
            with on_network() as link:
                shoot_all(browser, link, there, given)
        browser.close()


def shoot_all(browser: Browser, link: str, names: Sequence[str], given: argparse.Namespace) -> None:
    """Each of some pages at each size, of one server."""
    origin, _, token = link.partition("/start")
    state: StorageState | None = None
    if token:
        first = browser.new_context()
        first.new_page().goto(link)
        state = first.storage_state()
    for size in given.sizes.split(","):
        wanted = SIZES[size]
        for name in names:
            shot = SHOTS[name]
            context = browser.new_context(
                viewport={"width": wanted.width, "height": wanted.height},
                color_scheme=wanted.scheme,
                has_touch=wanted.touch,
                locale="en-GB",
                storage_state=state,
                ignore_https_errors=True,
            )
            page = context.new_page()
            page.set_default_timeout(WAIT_MS)
            page.goto(
                f"{origin}/#/" + shot.address.format(case=given.case_id, waiting=given.waiting)
            )
            page.locator(shot.settled).first.wait_for()
            page.wait_for_timeout(1500)
            try:
                shot.act(page)
            except PlaywrightError as error:
                sys.stderr.write(f"{name} {size}: {str(error).splitlines()[0]}\n")
            page.wait_for_timeout(1200)
            content = page.screenshot()
            save(content, given.out / f"{name}-{size}.png", given.width)
            if given.beside is not None:
                put_beside(content, given.beside, given.out, name, size)
            context.close()


@contextmanager
def serving(*options: str) -> Generator[str]:
    """The app as its own process; its link."""
    program = shutil.which("limbgram")
    if program is None:
        sys.exit("The command limbgram is needed.")
    server = subprocess.Popen(
        [program, "app", "--no-browser", "--json", *options], stdout=subprocess.PIPE, text=True
    )
    assert server.stdout is not None
    try:
        yield json.loads(server.stdout.readline())["link"]
    finally:
        server.terminate()
        server.wait(30)


@contextmanager
def on_network() -> Generator[str]:
    """The app on a network that is this machine alone, with one user."""
    with tempfile.TemporaryDirectory() as folder:
        subprocess.run(
            ["limbgram", "app", "users", "add", USER, "--cases", folder, "--password-stdin"],
            input=PASSWORD + "\n",
            text=True,
            check=True,
            capture_output=True,
        )
        network = ("--network", "--address", "127.0.0.1", "--port", "18443")
        with serving("--cases", folder, *network) as link:
            yield link


def press(*names: str) -> Callable[[Page], None]:
    """Buttons, one after the other."""

    def act(page: Page) -> None:
        for name in names:
            page.get_by_role("button", name=name).first.click()
            page.wait_for_timeout(500)

    return act


def side_said(page: Page) -> None:
    page.locator(".lr.left").click()
    page.locator(".mirror, .notice.red").first.wait_for()


def record_shown(page: Page) -> None:
    page.frame_locator("iframe.sheet").locator("h1").first.wait_for()


def checked(page: Page) -> None:
    page.locator(".expected").wait_for()


def point_asked(page: Page) -> None:
    x, y = middle(page)
    page.mouse.click(x, y)
    page.locator(".witnesses").wait_for()


def tool(name: str) -> Callable[[Page], None]:
    def act(page: Page) -> None:
        page.locator(".tool", has_text=name).click()
        page.wait_for_timeout(600)

    return act


def region_drawn(page: Page) -> None:
    """A closed line round the middle of the limb, and what the edit does to it."""
    x, y = middle(page)
    page.mouse.move(x + 45, y)
    page.mouse.down()
    for k in range(1, 33):
        angle = 2 * math.pi * k / 32
        page.mouse.move(x + 45 * math.cos(angle), y + 45 * math.sin(angle))
    page.mouse.up()
    page.locator(".pane .edit .eff:not(.waits)").wait_for()


def brushed(page: Page) -> None:
    tool("Brush")(page)
    x, y = middle(page)
    page.mouse.move(x - 30, y - 40)
    page.mouse.down()
    for k in range(1, 17):
        page.mouse.move(x - 30 + 4 * k, y - 40 + 4 * k)
    page.mouse.up()
    page.locator(".pane .edit .eff:not(.waits)").wait_for()


def trimmed(page: Page) -> None:
    tool("Trimline")(page)
    x, y = middle(page)
    for dx, dy in ((-40, -60), (0, -40), (40, -60)):
        page.mouse.click(x + dx, y + dy)
        page.wait_for_timeout(300)


def locked(page: Page) -> None:
    page.get_by_label("Name").fill(USER)
    page.get_by_label("Password").fill(PASSWORD)
    page.get_by_role("button", name="Sign in").click()
    page.get_by_role("button", name="Lock").click()
    page.get_by_role("button", name="Unlock").wait_for()


def refused_entry(page: Page) -> None:
    page.get_by_label("Name").fill(USER)
    page.get_by_label("Password").fill("not the password")
    page.get_by_role("button", name="Sign in").click()
    page.locator(".entry .notice").wait_for()


def middle(page: Page) -> tuple[float, float]:
    """Of the canvas with the limb, once it is drawn."""
    page.locator(".overlay .bar path").first.wait_for(state="attached")
    box = page.locator(".limb-canvas").bounding_box()
    assert box is not None
    return box["x"] + box["width"] / 2, box["y"] + box["height"] / 2


TOOLS = ".right-tools"
SHOTS = {
    "cases": Shot("cases"),
    "cases-new": Shot("cases", act=press("New case")),
    "capture": Shot("case/{case}/capture", ".grid .ph"),
    "capture-waiting": Shot("case/{waiting}/capture", ".grid .ph", checked),
    "from-phone": Shot(
        "case/{waiting}/capture",
        ".grid .ph",
        press("From a phone", "Switch on and show the code"),
    ),
    "result": Shot("case/{case}/result", TOOLS),
    "point": Shot("case/{case}/result", TOOLS, point_asked),
    "align": Shot("case/{case}/align", TOOLS),
    "measure": Shot("case/{case}/measure", ".tape-input"),
    "rectify": Shot("case/{case}/rectify", TOOLS),
    "region": Shot("case/{case}/rectify", TOOLS, region_drawn),
    "brush": Shot("case/{case}/rectify", TOOLS, brushed),
    "trimline": Shot("case/{case}/rectify", TOOLS, trimmed),
    "levels": Shot("case/{case}/rectify", TOOLS, tool("By levels")),
    "templates": Shot("case/{case}/rectify", TOOLS, tool("Template")),
    "other-edits": Shot("case/{case}/rectify", TOOLS, tool("Others")),
    "compare": Shot("case/{case}/compare", ".pane .verdict"),
    "send": Shot("case/{case}/send", ".lr.left", side_said),
    "record": Shot("case/{case}/record", "iframe.sheet", record_shown),
    "help": Shot("case/{case}/result", TOOLS, press("Help")),
    "expert": Shot("case/{case}/align", TOOLS, press("Expert")),
    "cameras": Shot("cameras"),
    "calibration": Shot("cameras", act=press("New camera")),
    "settings": Shot("settings"),
    "phone-page": Shot("phone/{waiting}", ".phone-act"),
    "sign-in": Shot("cases", ".entry", network=True),
    "sign-in-refused": Shot("cases", ".entry", refused_entry, network=True),
    "locked": Shot("cases", ".entry", locked, network=True),
}


def put_beside(content: bytes, drawn: Path, out: Path, name: str, size: str) -> None:
    """The page at the right of its drawing, where there is one of that size."""
    sizes = {"desk": f"{name}-1440", "dark": f"{name}-1440-dark", "phone": "phone-390"}
    drawing = drawn / f"{sizes.get(size, '')}.png"
    if not drawing.is_file() or (size == "phone" and name != "phone-page"):
        return
    left, right = Image.open(drawing).convert("RGB"), Image.open(io.BytesIO(content)).convert("RGB")
    left = left.resize((round(left.width * right.height / left.height), right.height))
    both = Image.new("RGB", (left.width + right.width + 12, right.height), "white")
    both.paste(left, (0, 0))
    both.paste(right, (left.width + 12, 0))
    both.save(out / f"{name}-{size}-beside.png", optimize=True)


def save(content: bytes, path: Path, width: int) -> None:
    """A PNG of all hues; with a width, of as few pixels as MOST_BYTES needs, in LEVELS of light."""
    whole = Image.open(io.BytesIO(content)).convert("RGB")
    if not width:
        whole.save(path, optimize=True)
        return
    written = io.BytesIO()
    while not written.tell() or written.tell() > MOST_BYTES:
        written = io.BytesIO()
        in_levels(scaled(whole, width)).save(written, "PNG", optimize=True)
        width -= 40
    path.write_bytes(written.getvalue())


def in_levels(picture: Image.Image) -> Image.Image:
    step = 256 // LEVELS
    return picture.point([min(255, (k + step // 2) // step * step) for k in range(256)] * 3)


def scaled(picture: Image.Image, width: int) -> Image.Image:
    if not 0 < width < picture.width:
        return picture
    height = round(picture.height * width / picture.width)
    return picture.resize((width, height), Image.Resampling.LANCZOS)


if __name__ == "__main__":
    main()
