"""The command `limbgram`: one file a command; each parses, calls one function, replies."""

import typer

from limbgram.cli.calibrate import calibrate_command
from limbgram.cli.demo import demo_command
from limbgram.cli.make_capture import make_capture_command
from limbgram.cli.quality.accuracy import accuracy_command
from limbgram.cli.quality.warm_up import warm_up_command
from limbgram.cli.reconstruct import reconstruct_command
from limbgram.cli.workbench.align import align_command
from limbgram.cli.workbench.compare import compare_command
from limbgram.cli.workbench.edit import edit_app
from limbgram.cli.workbench.export import export_command
from limbgram.cli.workbench.measure import measure_command
from limbgram.cli.workbench.report import report_command
from limbgram.cli.workbench.template import template_app

_HELP = """From photographs taken round a limb to its surface in millimetres.

1. `limbgram calibrate BOARD_PHOTOS --board 14x10 --square 10 -o camera.json`
2. `limbgram reconstruct PHOTOS --camera camera.json -o CASE`
3. open CASE/report.html; the files for other programs lie in CASE/deliverables

No photos at hand? `limbgram demo` makes some and goes all the way.

**Exit codes**

- **0**: done
- **1**: a bug of ours: please report the traceback
- **2**: an option cannot be used
- **3**: photos, camera file or case folder cannot be read or written
- **4**: the photos cannot give the answer: the message says why and what to do
- **5**: a file could not be written and verified
- **6**: the system or a library ended the program; the case continues
- **130**: stopped by Ctrl-C; the same command continues
"""

app = typer.Typer(
    name="limbgram",
    help=_HELP,
    no_args_is_help=True,
    add_completion=False,
    pretty_exceptions_show_locals=False,
    rich_markup_mode="markdown",
)
app.command("reconstruct")(reconstruct_command)
app.command("accuracy")(accuracy_command)
app.command("calibrate")(calibrate_command)
app.command("demo")(demo_command)
app.command("make-capture")(make_capture_command)
app.command("warm-up")(warm_up_command)
app.command("align")(align_command)
app.command("measure")(measure_command)
app.command("compare")(compare_command)
app.command("export")(export_command)
app.command("report")(report_command)
app.add_typer(edit_app, name="edit")
app.add_typer(template_app, name="template")
