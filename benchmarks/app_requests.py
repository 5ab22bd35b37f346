"""Requests that nobody would send, made of the app's own OpenAPI document, until the time is up.

    python benchmarks/app_requests.py [--seconds 240] [--seed 1]

Starts `limbgram app` on a case with a surface, places, axes and an edit, signs in, and lets
schemathesis send what the document allows and what it forbids: its examples, coverage and fuzzing
phases. Two runs: one with case ids as they come, which are mostly none; one in which every path is
that of the real case, so that requests reach the code behind it. Left out are streams of events,
which never end; the end of the session; and in the second run what starts a reconstruction or
takes the case away. A server error in any answer is a failure, and is listed. Writes
results/app_requests.json.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from app import API, App, case_of, started
from harness import described, machine, made_on
from limbgram.synthetic.options import SMALL
from limbgram.synthetic.truth import stage_truth

RESULTS = Path(__file__).parent / "results" / "app_requests.json"
DOCUMENT = Path(__file__).parents[1] / "web" / "openapi.json"
PHASES = "examples,coverage,fuzzing"
NEVER = ("GET /api/v1/events", "GET /api/v1/cases/{case_id}/events", "DELETE /api/v1/session")
NOT_ON_THE_CASE = (
    "POST /api/v1/cases/sample",
    "POST /api/v1/cases/{case_id}/job",
    "DELETE /api/v1/cases/{case_id}",
    "POST /api/v1/session/lock",
)


def main() -> None:
    parser = described(__doc__)
    parser.add_argument("--seconds", type=int, default=240, help="Of each of the two runs.")
    parser.add_argument("--seed", type=int, default=1)
    chosen = parser.parse_args()
    runs: list[dict[str, Any]] = []
    with tempfile.TemporaryDirectory() as scratch, started(Path(scratch)) as app:
        case_id = worked_on(app, Path(scratch))
        for name, left_out, parameters in (
            ("any case id", NEVER, {}),
            ("the real case", (*NEVER, *NOT_ON_THE_CASE), {"path.case_id": case_id}),
        ):
            runs.append({"name": name, **sent(app, left_out, parameters, chosen)})
    results = {"machine": machine(), "phases": PHASES, "seed": chosen.seed, "runs": runs}
    RESULTS.write_text(json.dumps(results, indent=1) + "\n", encoding="utf-8")
    sys.exit(any(run["server_errors"] or run["rc"] not in (0, 1) for run in runs))


def worked_on(app: App, folder: Path) -> str:
    """A case with a surface, a place, axes and an edit."""
    limb = stage_truth(SMALL).limb.mesh
    case_id = case_of(app, folder, limb)
    case = f"{API}/cases/{case_id}"
    front = limb.vertices_mm[int(np.argmax(limb.vertices_mm[:, 1]))].tolist()
    axes = {"side": "left", "proximal": [0, 0, 1], "anterior": [0, 1, 0]}
    edit = {"kind": "offset", "parameters": {"distance_mm": -0.5}}
    for answer in (
        app.client.put(f"{case}/limb/places/patellar tendon", json={"position_mm": front}),
        app.client.post(f"{case}/limb/align", json=axes),
        app.client.post(f"{case}/recipe/edits", json=edit),
    ):
        answer.raise_for_status()
    return case_id


def sent(
    app: App, left_out: tuple[str, ...], parameters: dict[str, str], chosen: argparse.Namespace
) -> dict[str, Any]:
    """One run of schemathesis against the server, and what came of it."""
    with tempfile.TemporaryDirectory() as scratch:
        report = Path(scratch) / "report.json"
        options = Path(scratch) / "schemathesis.toml"
        lines = ["[parameters]", *(f'"{name}" = "{value}"' for name, value in parameters.items())]
        for one in left_out:
            lines += ["[[operations]]", f'include-name = "{one}"', "enabled = false"]
        options.write_text("\n".join(lines) + "\n", encoding="utf-8")
        cookie = "; ".join(f"{name}={value}" for name, value in app.client.cookies.items())
        command = ["schemathesis", "--config-file", str(options), "run", str(DOCUMENT)]
        command += ["--url", str(app.client.base_url).rstrip("/"), "-H", f"cookie:{cookie}"]
        command += ["--phases", PHASES, "-c", "not_a_server_error", "--seed", str(chosen.seed)]
        command += ["--max-time", str(chosen.seconds), "--request-timeout", "60"]
        command += ["--continue-on-failure", "--suppress-health-check", "all", "--warnings", "off"]
        command += ["--report", "ndjson", "--report-ndjson-path", str(report)]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        return {
            "rc": done.returncode,
            "seconds": chosen.seconds,
            "left_out": left_out,
            **counted(report),
            "said": done.stdout.splitlines()[-30:],
        }


def counted(report: Path) -> dict[str, Any]:
    """Answers by status, operations that answered, and each server error."""
    statuses: dict[str, int] = {}
    operations: set[str] = set()
    errors: list[str] = []
    for line in report.read_text("utf-8").splitlines():
        for exchange in exchanges(json.loads(line)):
            answer = exchange.get("response")
            if not isinstance(answer, dict):
                continue
            status = int(answer["status_code"])
            statuses[str(status)] = statuses.get(str(status), 0) + 1
            asked = exchange["request"]
            operations.add(f"{asked['method']} {asked['uri'].partition('?')[0]}")
            if status >= 500:
                errors.append(f"{asked['method']} {asked['uri']}: {status}")
    return {
        "answers": dict(sorted(statuses.items())),
        "addresses": len(operations),
        "server_errors": errors,
    }


def exchanges(tree: Any) -> list[dict[str, Any]]:
    """Requests with their responses, wherever the report has them."""
    if isinstance(tree, dict):
        if "request" in tree and "response" in tree:
            return [tree]
        return [one for value in tree.values() for one in exchanges(value)]
    if isinstance(tree, list):
        return [one for value in tree for one in exchanges(value)]
    return []


def page(results: dict[str, Any]) -> str:
    lines = [
        "# app_requests",
        "",
        made_on(results["machine"]),
        "",
        f"schemathesis, phases {results['phases']}, seed {results['seed']}; the check is that no "
        "answer is a server error.",
        "",
        "| run | s | requests | answers by status | addresses | server errors |",
        "|---|---|---|---|---|---|",
    ]
    for run in results["runs"]:
        answers = ", ".join(f"{status}: {count}" for status, count in run["answers"].items())
        lines.append(
            f"| {run['name']} | {run['seconds']} | {sum(run['answers'].values())} | {answers} | "
            f"{run['addresses']} | {len(run['server_errors'])} |"
        )
    for run in results["runs"]:
        lines += ["", f"Left out, {run['name']}: {', '.join(run['left_out'])}."]
        lines += [f"- {one}" for one in run["server_errors"]]
    return "\n".join(lines) + "\n"


if __name__ == "__main__":
    main()
