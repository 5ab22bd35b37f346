"""`limbgram device`: an orthosis or a socket on an aligned limb, as files to print and to check."""

from collections.abc import Iterator
from pathlib import Path
from typing import Annotated, Any

import typer

from limbgram.cli.replies import Reply, answered, language, spoken
from limbgram.cli.request_options import asking
from limbgram.cli.shape_options import READ, UnitOption, shape_of
from limbgram.core.errors import OptionsError, with_full_stop
from limbgram.core.typed import tree_of
from limbgram.services.make_device import MakeDeviceRequest, make
from limbgram.workbench.devices.device import Device, devices
from limbgram.workbench.devices.making import device_named
from limbgram.workbench.devices.trims import Measure
from limbgram.workbench.frame.landmarks import notes_but_unconfirmed


@answered
@asking
def device_command(
    ask: MakeDeviceRequest,
    shape: Annotated[
        Path | None, typer.Argument(help=f"The aligned limb: {READ}.", show_default=False)
    ] = None,
    out: Annotated[
        Path | None,
        typer.Option("-o", "--out", help="Folder for its files.", show_default="SHAPE-DEVICE"),
    ] = None,
    listed: Annotated[
        bool,
        typer.Option(
            "--list", help="List devices; with --device the landmarks and measures of one."
        ),
    ] = False,
    unit: UnitOption = None,
    as_json: Annotated[bool, typer.Option("--json", help="Reply as JSON.")] = False,  # noqa: ARG001
) -> Reply:
    """Make an orthosis or a socket on an aligned limb: one closed solid, read back and proved.

    Written are the solid as 3MF and STL, the positive, a drawing with all measures, and the order,
    from which the same files are made again. Nothing is strength tested.
    """
    if listed:
        return _list(ask.device)
    if shape is None:
        raise OptionsError("device.no_shape")
    folder = out or shape.with_name(f"{shape.stem}-{ask.device or 'device'}")
    read = shape_of(shape, unit)
    done = make(read, ask, folder)
    return Reply(
        (
            *(f"Note: {with_full_stop(spoken(one))}" for one in notes_but_unconfirmed(read.limb)),
            *(spoken(one) for one in done.said),
            *(f"Written: {path}" for path in done.written),
        ),
        {
            **done.figures,
            "findings": tree_of(done.said),
            "written": [str(path) for path in done.written],
        },
    )


def _list(name: str | None) -> Reply:
    chosen = list(devices().values()) if name is None else [device_named(name)]
    lines = (
        [f"{one.name:28s}{_told(one)}" for one in chosen]
        if name is None
        else list(_details(chosen[0]))
    )
    return Reply(tuple(lines), {"devices": [_tree(one) for one in chosen]})


def _told(device: Device) -> str:
    return device.words[language()]


def _details(device: Device) -> Iterator[str]:
    yield _told(device)
    yield f"Kind of limb: {device.kind} (limbgram align --kind {device.kind})"
    yield f"Landmarks: {', '.join(device.landmarks)}"
    yield "Measures, usual value and range; another is given by --set NAME=NUMBER:"
    usually = device.measures(device.usual_fabrication)
    yield from (_line(one) for one in usually)
    for made in device.wall:
        if made != device.usual_fabrication:
            yield f"With --made {made}, in place of {device.wall[device.usual_fabrication].name}:"
            yield from (_line(one) for one in device.measures(made) if one not in usually)


def _line(one: Measure) -> str:
    usual = "has to be given" if one.usual is None else f"{one.usual:g} {one.unit}"
    lies = f"{one.within.least:g} to {one.within.most:g}"
    return f"  {one.name:20s}{usual:>16s}  {lies:14s}{one.label[language()]}"


def _tree(device: Device) -> dict[str, Any]:
    return {
        "name": device.name,
        "kind": device.kind,
        "words": dict(device.words),
        "landmarks": list(device.landmarks),
        "made": list(device.wall),
        "measures": {
            made: [
                {
                    "name": one.name,
                    "usual": one.usual,
                    "least": one.within.least,
                    "most": one.within.most,
                    "words": dict(one.label),
                }
                for one in device.measures(made)
            ]
            for made in device.wall
        },
    }
