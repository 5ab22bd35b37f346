"""Pictures of every page of the app, as a browser shows it, for the documentation and for eyes.

Usage: python benchmarks/app_screens.py CASES CASE_ID -o FOLDER [--only result,send]

CASES is a folder of cases of `limbgram app`, CASE_ID a case in it that is computed and aligned.
Writes FOLDER/PAGE-SIZE.png at 1440 x 900, light and dark, at a tablet's and a phone's size; with
--beside DRAWN also FOLDER/PAGE-SIZE-beside.png, the page next to its drawing DRAWN/PAGE-1440.png.
Needs Playwright and Chromium; WebGL is drawn by software, so this takes a minute or two.
"""

import argparse
import io
import json
import shutil
import subprocess
import sys
from pathlib import Path
from typing import Literal

from PIL import Image
from playwright.sync_api import Page, sync_playwright

SIZES: dict[str, tuple[int, int, Literal["light", "dark"]]] = {
    "desk": (1440, 900, "light"),
    "dark": (1440, 900, "dark"),
    "tablet": (1024, 768, "light"),
    "phone": (390, 844, "light"),
}
PAGES = {
    "cases": "cases",
    "capture": "case/{case}/capture",
    "result": "case/{case}/result",
    "align": "case/{case}/align",
    "measure": "case/{case}/measure",
    "rectify": "case/{case}/rectify",
    "compare": "case/{case}/compare",
    "send": "case/{case}/send",
    "record": "case/{case}/record",
    "cameras": "cameras",
    "settings": "settings",
    "phone-page": "phone/{case}",
}
SETTLED = {
    "capture": ".grid .ph",
    "result": ".right-tools",
    "align": ".right-tools",
    "measure": ".tape-input",
    "rectify": ".right-tools",
    "compare": ".pane .verdict",
    "send": ".lr.left",
    "record": "iframe.sheet",
    "phone-page": ".phone-act",
}
LEVELS = 32
"""Of each of red, green and blue in a small picture: a palette loses hues that are rare."""
MOST_BYTES = 120_000
"""Of a picture that is made smaller for the documentation."""


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0] if __doc__ else "")
    parser.add_argument("cases", type=Path)
    parser.add_argument("case_id")
    parser.add_argument("-o", "--out", type=Path, required=True)
    parser.add_argument("--only", default=",".join(PAGES))
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
    program, chromium = shutil.which("limbgram"), shutil.which("chromium")
    if program is None or chromium is None:
        sys.exit("The commands limbgram and chromium are needed.")
    server = subprocess.Popen(
        [program, "app", "--no-browser", "--json", "--cases", str(given.cases)],
        stdout=subprocess.PIPE,
        text=True,
    )
    assert server.stdout is not None
    link = json.loads(server.stdout.readline())["link"]
    origin = link.split("/start")[0]
    try:
        with sync_playwright() as playwright:
            browser = playwright.chromium.launch(
                executable_path=chromium, args=["--enable-unsafe-swiftshader", "--no-sandbox"]
            )
            first = browser.new_context()
            first.new_page().goto(link)
            state = first.storage_state()
            for size in given.sizes.split(","):
                width, height, scheme = SIZES[size]
                context = browser.new_context(
                    viewport={"width": width, "height": height},
                    color_scheme=scheme,
                    locale="en-GB",
                    storage_state=state,
                )
                page = context.new_page()
                for name in given.only.split(","):
                    shoot(page, f"{origin}/#/{PAGES[name].format(case=given.case_id)}", name)
                    content = page.screenshot()
                    save(content, given.out / f"{name}-{size}.png", given.width)
                    if given.beside is not None:
                        put_beside(content, given.beside, given.out, name, size)
                context.close()
            browser.close()
    finally:
        server.terminate()


def shoot(page: Page, address: str, name: str) -> None:
    """Open a page and wait until it stands."""
    page.goto(address)
    if name in SETTLED:
        page.locator(SETTLED[name]).first.wait_for(timeout=90_000)
    if name == "capture" and page.locator(".step.shut").count() and page.locator(".ph img").count():
        page.locator(".expected").wait_for(timeout=90_000)
    if name == "send":
        page.locator(".lr.left").click()
        page.locator(".mirror, .notice.red").first.wait_for(timeout=90_000)
    if name == "record":
        page.frame_locator("iframe.sheet").locator("h1").first.wait_for(timeout=90_000)
    page.wait_for_timeout(2500)


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
