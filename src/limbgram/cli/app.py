"""`limbgram app`: the whole work in a browser: on this machine, or on the clinic's own network."""

import json
import sys
from collections import deque
from collections.abc import Generator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer

from limbgram.app.options import LOCK_AFTER_MIN, NetworkOptions, ServeOptions
from limbgram.cli.replies import Reply, answered
from limbgram.cli.request_options import asking
from limbgram.core.errors import RED_EXIT_CODE, OptionsError
from limbgram.core.run import garbage_collection_paused

if TYPE_CHECKING:
    from limbgram.app.journal import Journal
    from limbgram.app.users import Users

_HELP = """Open the app in the browser: photos go in, a checked shape and its files come out.

Only this machine can reach it. The link works once; close the app with Ctrl-C. What is being
computed then is continued when the app is opened again.

With **--network**, browsers of the clinic's own network reach it too: encrypted, and only for users
that were added on this machine. A log says who did what (`limbgram app log`), a page in which
nobody did anything for a while is locked until its user gives the password again.

1. `limbgram app users add "A. Meier"`
2. `limbgram app --network`
3. on another machine, open the address that it shows, and compare the fingerprint once
"""
_USERS_HELP = """Who may sign in to the app on a network.

What is changed counts at once, also for an app that runs: a user who is removed, or whose password
is changed, is signed out everywhere.
"""
_LIBRARIES = ("argon2", "cryptography", "fastapi", "segno", "uvicorn")

app_command = typer.Typer(help=_HELP, invoke_without_command=True, rich_markup_mode="markdown")
users_app = typer.Typer(help=_USERS_HELP, no_args_is_help=True, rich_markup_mode="markdown")

CasesOption = Annotated[Path, typer.Option(help="Folder of the cases of the app.")]
CASES = ServeOptions.cases
Name = Annotated[str, typer.Argument(help="The user's name, such as 'A. Meier'.")]
FromInput = Annotated[
    bool,
    typer.Option("--password-stdin", help="Read the password from standard input, for a program."),
]
Json = Annotated[bool, typer.Option("--json", help="The answer as one JSON document.")]


@app_command.callback()
@answered
@asking
def _app(
    context: typer.Context,
    ask: ServeOptions,
    reach: NetworkOptions,
    network: Annotated[
        bool,
        typer.Option(
            "--network",
            help="Answer browsers of the network too: encrypted, by name and password.",
            rich_help_panel="On a network",
        ),
    ] = False,
    as_json: Annotated[
        bool, typer.Option("--json", help="The link as a JSON line, once it is good.")
    ] = False,
) -> Reply | None:
    if context.invoked_subcommand is not None:
        if ask.cases != CASES:
            raise OptionsError(
                "options.app.cases_before",
                command=context.invoked_subcommand,
                cases=str(ask.cases),
            )
        return None
    if network:
        _on_network(ask, reach, as_json=as_json)
    elif replace(reach, lock_after_min=LOCK_AFTER_MIN) != NetworkOptions():
        raise OptionsError("options.app.without_network")
    else:
        _on_this_machine(ask, as_json=as_json)
    return Reply(("The app is closed.",), {"closed": True})


def _on_this_machine(ask: ServeOptions, *, as_json: bool) -> None:
    with _libraries():
        from limbgram.app.local_server import serve

    def ready(link: str) -> None:
        _tell(
            {"event": "ready", "link": link},
            f"The app is open: {link}\nThe link is good once, within 15 minutes. End with Ctrl-C.",
            as_json=as_json,
        )

    serve(ask, ready)


def _on_network(ask: ServeOptions, reach: NetworkOptions, *, as_json: bool) -> None:
    with _libraries():
        from limbgram.app.network_server import Reached, serve_on_network

    def ready(reached: Reached) -> None:
        compare = (
            "Browsers do not know its certificate. Compare the fingerprint (SHA-256) once on each "
            f"machine before you go on:\n{reached.fingerprint}\n"
            if reached.own
            else ""
        )
        text = (
            f"The app is open to {reached.users} user{'s' * (reached.users != 1)}: "
            f"{' or '.join(reached.links)}\n"
            f"{compare}End with Ctrl-C."
        )
        _tell(
            {"event": "ready", "link": reached.links[0], **asdict(reached)}, text, as_json=as_json
        )

    serve_on_network(ask, reach, ready)


@users_app.command("add")
@answered
def add_command(
    name: Name,
    cases: CasesOption = CASES,
    password_stdin: FromInput = False,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Let somebody sign in; asks for their password, twice."""
    users = _users(cases)
    users.require_new(name)
    journal = _journal(cases, writing=True)
    added = users.add(name, _password(from_input=password_stdin))
    journal.write("this machine", "", f"add_user {added.name}")
    return Reply((f"{added.name} may sign in.",), {"added": added.name})


@users_app.command("password")
@answered
def password_command(
    name: Name,
    cases: CasesOption = CASES,
    password_stdin: FromInput = False,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Give a user another password; they are signed out everywhere."""
    users = _users(cases)
    users.require(name)
    journal = _journal(cases, writing=True)
    changed = users.change(name, _password(from_input=password_stdin))
    journal.write("this machine", "", f"change_password {changed.name}")
    return Reply((f"{changed.name} has another password.",), {"changed": changed.name})


@users_app.command("remove")
@answered
def remove_command(
    name: Name,
    cases: CasesOption = CASES,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Let somebody sign in no more; the log keeps what they did."""
    journal = _journal(cases, writing=True)
    gone = _users(cases).remove(name)
    journal.write("this machine", "", f"remove_user {gone.name}")
    return Reply((f"{gone.name} can sign in no more.",), {"removed": gone.name})


@users_app.command("list")
@answered
def list_command(
    cases: CasesOption = CASES,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """List who may sign in, and since when with their password."""
    users = _users(cases).all()
    lines = [f"{one.name}  (password of {one.made[:10]})" for one in users]
    none = "Nobody may sign in yet. Add somebody: limbgram app users add NAME"
    listed = [{"name": one.name, "password_of": one.made} for one in users]
    return Reply(tuple(lines) or (none,), {"users": listed})


@app_command.command("log")
@answered
def log_command(
    cases: CasesOption = CASES,
    case: Annotated[str, typer.Option(help="Only what was done with this case.")] = "",
    user: Annotated[str, typer.Option(help="Only what this user did.")] = "",
    last: Annotated[int, typer.Option(min=1, help="How many lines are shown, the newest.")] = 50,
    as_json: Json = False,  # noqa: ARG001 - read by `answered`
) -> Reply:
    """Show who did what on the network, and whether the log is as it was written."""
    with _libraries():
        from limbgram.app.users import same_name
    journal = _journal(cases)
    shown: deque[str] = deque(maxlen=last)
    found: deque[dict[str, str | int]] = deque(maxlen=last)
    broken: list[int] = []
    lines = unproved = 0
    for line in journal.lines():
        lines += not line.cut_off
        if not line.whole:
            broken.append(lines + line.cut_off)
        unproved += not line.proved
        act = line.act
        if act is None or (case and act.case != case) or (user and not same_name(act.who, user)):
            continue
        shown.append(
            f"{act.at[:19].replace('T', ' ')}  {act.who or '-':20}  {act.address or '-':15}  "
            f"{act.act:24}  {act.case or '-':7}  {act.status or ''}".rstrip()
        )
        found.append(asdict(act))
    said = f"{lines} lines, each follows the one before it."
    if broken:
        said = (
            f"NOT as it was written: line {broken[0]} was changed, or lines before it were taken "
            f"out or put in, or lines at the end cut off ({len(broken)} such places). Compare it "
            "with a copy that you kept."
        )
    elif not lines:
        said = f"There is no log in {cases}: it begins when the app is served on a network."
    older = (
        f"The first {unproved} lines were not written with this account's key for the log: they "
        "may have been made anew."
    )
    return Reply(
        (*shown, said, older) if unproved else (*shown, said),
        {"lines": lines, "broken": broken[:100], "unproved": unproved, "acts": list(found)},
        exit_code=RED_EXIT_CODE if broken else 0,
    )


app_command.add_typer(users_app, name="users")


def _tell(event: dict[str, object], text: str, *, as_json: bool) -> None:
    sys.stdout.write(f"{json.dumps(event) if as_json else text}\n")
    sys.stdout.flush()


def _users(cases: Path) -> "Users":
    with _libraries():
        from limbgram.app.users import ACCESS_FOLDER, Users
    return Users(cases.absolute() / ACCESS_FOLDER)


def _journal(cases: Path, *, writing: bool = False) -> "Journal":
    """The log of acts; `writing` refuses if it cannot be written."""
    with _libraries():
        from limbgram.app.journal import Journal
        from limbgram.app.users import ACCESS_FOLDER
    journal = Journal(cases.absolute() / ACCESS_FOLDER)
    if writing:
        journal.require_key()
    return journal


def _password(*, from_input: bool) -> str:
    if from_input:
        return sys.stdin.readline().rstrip("\r\n")
    asked: str = typer.prompt("Password", hide_input=True, confirmation_prompt="Once more")
    return asked


@contextmanager
def _libraries() -> Generator[None]:
    """Import what the app needs; a refusal says how to install it."""
    try:
        with garbage_collection_paused():
            yield
    except ModuleNotFoundError as error:
        if error.name not in _LIBRARIES:
            raise
        raise OptionsError("options.app.libraries") from error
