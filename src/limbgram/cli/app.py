"""`limbgram app`: the whole work in a browser, on this machine."""

import sys
from pathlib import Path
from typing import Annotated

import typer

from limbgram.cli.replies import Reply, answered
from limbgram.core.errors import OptionsError
from limbgram.core.run import no_search_for_garbage


@answered
def app_command(
    cases: Annotated[
        Path, typer.Option(help="Folder of the cases; made where there is none.")
    ] = Path("limbgram-cases"),
    port: Annotated[
        int,
        typer.Option(min=0, max=65535, help="Port on this machine.", show_default="any free one"),
    ] = 0,
    no_browser: Annotated[
        bool, typer.Option("--no-browser", help="Only show the link, for a program or a browser.")
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="The link as a JSON line, once it is good.")
    ] = False,
) -> Reply:
    """Open the app in the browser: photos go in, a checked shape and its files come out.

    Only this machine can reach it. The link is good once; close the app with Ctrl-C. What is being
    computed then is continued when the app is opened again.
    """
    try:
        with no_search_for_garbage():
            from limbgram.app.serving import ServeOptions, serve
    except ModuleNotFoundError as error:
        if error.name not in ("fastapi", "segno", "uvicorn"):
            raise
        raise OptionsError(
            "The app needs libraries that are not installed. Install them by: "
            "pip install 'limbgram[app]'"
        ) from error

    def ready(link: str) -> None:
        line = f'{{"event": "ready", "link": "{link}"}}' if as_json else (
            f"The app is open: {link}\nThe link is good once, within 15 minutes. End with Ctrl-C."
        )  # fmt: skip
        sys.stdout.write(f"{line}\n")
        sys.stdout.flush()

    serve(ServeOptions(cases=cases, port=port, browser=not no_browser), ready)
    return Reply(("The app is closed.",), {"closed": True})
