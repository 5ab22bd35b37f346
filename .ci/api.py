"""Sends thousands of odd requests to the API, as its own description invites, and wants no fault.

    python .ci/api.py [EXAMPLES]

Starts the app on an empty folder with one finished-looking case, and runs schemathesis over every
route: whatever is sent, no answer may be a fault of the server. Ends with 1 if one is.
"""

import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import httpx

from limbgram.app.serving import ServeOptions, serve
from limbgram.cases.shelf import Shelf
from limbgram.formats.ply import write_ply
from limbgram.synthetic.options import SMALL
from limbgram.synthetic.truth import stage_truth

_OUT = ("/events", "/start", "/cases/sample")
"""Streams do not end, and a sample takes a minute to photograph."""


def main() -> int:
    examples = sys.argv[1] if len(sys.argv) > 1 else "20"
    with tempfile.TemporaryDirectory() as scratch:
        root = Path(scratch) / "cases"
        shelf = Shelf(root)
        shelf.open()
        case = shelf.new_case("transtibial", "left")
        case.folder.deliverables.mkdir()
        write_ply(stage_truth(SMALL).limb.mesh, case.folder.deliverables / "surface.ply", "mm")
        ready = threading.Event()
        links: list[str] = []

        def opened(link: str) -> None:
            links.append(link)
            ready.set()

        options = ServeOptions(cases=root, browser=False)
        threading.Thread(target=serve, args=(options, opened), daemon=True).start()
        ready.wait(60)
        base = links[0].partition("/start")[0]
        with httpx.Client(base_url=base) as client:
            client.get(links[0])
            cookie = client.cookies["limbgram_session"]
            description = client.get("/api/v1/openapi.json").text
        described = Path(scratch) / "openapi.json"
        described.write_text(description.replace("{case_id}", case.case_id), encoding="utf-8")
        words = [
            *(sys.executable, "-m", "schemathesis.cli", "run", str(described), "--url", base),
            *("--header", f"Cookie: limbgram_session={cookie}"),
            *("--checks", "not_a_server_error", "--max-examples", examples),
            *("--phases", "examples,coverage,fuzzing", "--mode", "all", "--continue-on-failure"),
            *("--request-timeout", "60", "--seed", "1", "--workers", "1"),
            *(part for path in _OUT for part in ("--exclude-path-regex", f"{path}$")),
        ]
        return subprocess.run(words, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
