"""Sends thousands of odd requests to the API, as its own description invites, and wants no fault.

    python .ci/api.py [EXAMPLES]

Starts the app on an empty folder with one finished-looking case, and runs schemathesis over every
route: whatever is sent, no answer may be a fault of the server. Ends with 1 if one is.
"""

import json
import socket
import subprocess
import sys
import tempfile
import threading
from pathlib import Path

import uvicorn

from limbgram.app.access import Access
from limbgram.app.openapi import document
from limbgram.app.server import build
from limbgram.app.state import AppState
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
        app_state = AppState(shelf, Access(frozenset()))
        listening = socket.create_server(("127.0.0.1", 0))
        base = f"http://127.0.0.1:{listening.getsockname()[1]}"
        # Without the guard, which has tests of its own: it would answer nearly all of them.
        config = uvicorn.Config(build(app_state), log_level="error")
        server = uvicorn.Server(config)
        threading.Thread(target=server.run, args=([listening],), daemon=True).start()
        described = Path(scratch) / "openapi.json"
        text = json.dumps(document()).replace("{case_id}", case.case_id)
        described.write_text(text, encoding="utf-8")
        words = [
            *(sys.executable, "-m", "schemathesis.cli", "run", str(described), "--url", base),
            *("--exclude-operation-id", "delete_case"),
            *("--checks", "not_a_server_error", "--max-examples", examples),
            *("--phases", "examples,coverage,fuzzing", "--mode", "all", "--continue-on-failure"),
            *("--request-timeout", "60", "--seed", "1", "--workers", "1"),
            *(part for path in _OUT for part in ("--exclude-path-regex", f"{path}$")),
        ]
        return subprocess.run(words, check=False).returncode


if __name__ == "__main__":
    sys.exit(main())
