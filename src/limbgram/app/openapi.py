"""OpenAPI: the description of the API, from which the client's types are made.

Runs as `python -m limbgram.app.openapi web/openapi.json`.
"""

import json
import sys
from pathlib import Path
from typing import Any

from limbgram.app.access import Access
from limbgram.app.server import build
from limbgram.app.state import AppState
from limbgram.cases.shelf import Shelf


def document() -> dict[str, Any]:
    """The description; no case is opened for it."""
    app_state = AppState(Shelf(Path("cases")), Access(frozenset()))
    described = build(app_state).openapi()
    described["info"]["version"] = "1"  # of the API, which other versions of the program keep
    return described


def text_of(described: dict[str, Any]) -> str:
    return json.dumps(described, indent=1, ensure_ascii=False) + "\n"


def main() -> None:
    Path(sys.argv[1]).write_text(text_of(document()), encoding="utf-8")


if __name__ == "__main__":
    main()
