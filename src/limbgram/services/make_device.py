"""Make a device: an order on an aligned limb, and its files: solid, positive, drawing, order.

In      an aligned shape as read; what is asked, typed or in an order's file.
Out     the device and its files, each read back; or a preview, with handles and thickness, at once.
Fails   EditError, with the place; OptionsError: an order that cannot be meant. Nothing is written
        unless the device was proved.

Nothing here is strength tested, and every file says so.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Final, Literal

import numpy as np

from limbgram.core.errors import OptionsError, ShapeFileError
from limbgram.core.files import make_folder, read_content, require_folder, write_bytes
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.mesh.topology import enclosed_by
from limbgram.core.request_fields import AtMost, Flag
from limbgram.findings import Finding, told
from limbgram.formats.limb_file import write_limb
from limbgram.formats.reading import ShapeFile, read_mesh
from limbgram.formats.sidecar import hash_of
from limbgram.formats.stl import write_stl
from limbgram.formats.threemf import Told, write_3mf
from limbgram.services.export import file_name
from limbgram.services.parse_text import VALUE, ZONE, Value
from limbgram.workbench.devices.device import Fabrication, WallZone
from limbgram.workbench.devices.making import (
    FinishedDevice,
    ImportedBody,
    Order,
    Preview,
    device_named,
    make_device,
    preview_device,
)
from limbgram.workbench.devices.order import KnownBody, OrderFile, encode_order, read_order
from limbgram.workbench.limb import marked_red
from limbgram.workbench.recipe.file import read_recipe
from limbgram.workbench.recipe.recipe import Recipe

_LARGEST_BYTES = 1 << 30

Bed = Literal["standing", "upside-down", "lying"]
_TURNS: Final[Mapping[Bed, np.ndarray]] = {
    "standing": np.eye(3),
    "upside-down": np.diag([1.0, -1.0, -1.0]),
    "lying": np.array([[1.0, 0, 0], [0, 0, -1.0], [0, 1.0, 0]]),
}
"""As worn; the brim on the bed; on the back, the front upwards."""


@dataclass(frozen=True, kw_only=True)
class MakeDeviceRequest:
    """A device and its numbers; what is not given is usual, or as the order's file has it."""

    device: str | None = None
    """Which device; see --list."""
    values: Annotated[tuple[Annotated[Value, VALUE], ...], AtMost(100), Flag("set")] = ()
    """A measure of it: NAME=NUMBER."""
    zones: Annotated[tuple[Annotated[WallZone, ZONE], ...], AtMost(100), Flag("zone")] = ()
    """A printed wall thicker or thinner round a landmark: LANDMARK=ADD:REACH in mm. It runs out
    over 10 mm beyond its reach. With an order, the same landmark goes over it, and 0 takes it
    out."""
    made: Fabrication | None = None
    """Printed, or draped of a sheet that thins as it stretches."""
    order: Path | None = None
    """An order's file (.toml) to go by; what is typed goes over it."""
    recipe: Path | None = None
    """Recipe that makes the positive of the limb (.toml)."""
    join: tuple[Path, ...] = ()
    """A body to join, such as a housing (.stl), in the plate's frame: origin in the middle of its
    lower face, Z up, Y forwards."""
    cut: tuple[Path, ...] = ()
    """A body to cut out, in the same frame."""
    lettering: str | None = None
    """Text raised on the outer side of a printed wall, as whose it is, which side, what date; ""
    for none."""
    bed: Bed = "standing"
    """How it lies on the printer's bed: standing as worn, upside-down, or lying on its back."""


@dataclass(frozen=True, kw_only=True)
class DeviceFiles:
    """A device and what was written of it."""

    made: FinishedDevice
    written: tuple[Path, ...]
    said: tuple[Finding, ...]
    figures: Mapping[str, Any]
    """As JSON holds them."""


def preview(read: ShapeFile, ask: MakeDeviceRequest) -> Preview:
    """Handles, edges, ranges and the thickness on the positive, without a body.

    Raises:
        EditError: the device cannot be drawn on this limb; says where.
    """
    return preview_device(read.limb, _order_to_make(read, ask).order)


def make(read: ShapeFile, ask: MakeDeviceRequest, folder: Path) -> DeviceFiles:
    """Make a device and write its files into a folder.

    Raises:
        EditError: the device cannot be made on this limb; says where.
        OptionsError: the order is for another limb, or names bodies that were not given.
        ExportError: the folder cannot be made, or a file did not read back as it was written.
    """
    require_folder(folder)
    ordered = _order_to_make(read, ask)
    made = make_device(read.limb, ordered.order)
    make_folder(folder)
    written = _write_files(read, made, ordered, folder, ask.bed)
    return DeviceFiles(made=made, written=written, said=made.findings, figures=figures_of(made))


def figures_of(made: FinishedDevice) -> dict[str, Any]:
    """A device in figures; its side is the positive's, which a recipe may have mirrored."""
    preview, wall = made.preview, made.wall
    alignment, enclosed = made.alignment, enclosed_by(made.solid)
    return {
        "device": preview.device.name,
        "made": preview.made,
        "side": preview.positive.side,
        "values": dict(preview.values),
        "handles": handles_of(preview),
        "volume_ml": enclosed.volume_mm3 / 1000,
        "extent_mm": np.ptp(made.solid.vertices_mm, axis=0).tolist(),
        "triangles": len(made.solid.faces),
        "watertight": enclosed.watertight,
        "wall": {
            "thinnest_mm": wall.thinnest_mm,
            "thinnest_point_in_limb_mm": list(wall.thinnest_point_mm),
            "thickest_mm": wall.thickest_mm,
            "off_from_asked_mm": wall.off_mm,
        },
        "limb_from_plate": None
        if alignment is None
        else {
            "rotation": alignment.limb_from_plate.rotation.tolist(),
            "translation_mm": alignment.limb_from_plate.translation.tolist(),
        },
        "strength_tested": False,
    }


def handles_of(preview: Preview) -> list[dict[str, Any]]:
    """The handles that an app drags: places with their measure, range and direction."""
    return [
        {
            "loop": one.loop,
            "point": one.point,
            "point_in_limb_mm": list(one.point_mm),
            "measure": one.measure,
            "value": one.value,
            "least": one.least,
            "most": one.most,
            "along_in_limb": None if one.along is None else list(one.along),
        }
        for one in preview.handles
    ]


@dataclass(frozen=True)
class _OrderToMake:
    order: Order
    bodies: tuple[KnownBody, ...]


def _order_to_make(read: ShapeFile, ask: MakeDeviceRequest) -> _OrderToMake:
    """The order: the values given, over those of an order's file."""
    kept = None if ask.order is None else read_order(ask.order)
    if kept is not None and kept.limb_sha256 and kept.limb_sha256 != read.sha256:
        raise OptionsError("device.file.other_limb", name=_name(ask.order))
    device = ask.device or (None if kept is None else kept.device)
    if device is None:
        raise OptionsError("device.none_asked")
    same = kept if kept is not None and kept.device == device else None
    made = ask.made or (None if same is None else same.made)
    values = {**_values_of_fabrication(same, made), **dict(ask.values)}
    recipe = Recipe(name="") if kept is None else kept.recipe
    if ask.recipe is not None:
        recipe = read_recipe(ask.recipe)
    bodies = [
        _body(path, cut=cut)
        for cut, paths in ((False, ask.join), (True, ask.cut))
        for path in paths
    ]
    given = {one.known for one in bodies}
    missing = [one for one in (kept.bodies if kept is not None else ()) if one not in given]
    if missing:
        raise OptionsError("device.file.body", name=missing[0].name, cut=missing[0].cut)
    order = Order(
        device=device,
        values=values,
        made=made,
        free={} if same is None else same.free,
        recipe=recipe,
        bodies=tuple(one.body for one in bodies),
        zones=_zones(ask, kept),
        lettering=_lettering(ask, kept),
    )
    return _OrderToMake(order, tuple(one.known for one in bodies))


def _zones(ask: MakeDeviceRequest, kept: OrderFile | None) -> tuple[WallZone, ...]:
    zones = (*(() if kept is None else kept.zones), *ask.zones)
    by_place = {zone.at: zone for zone in zones}
    return tuple(zone for zone in by_place.values() if zone.add_mm != 0)


def _lettering(ask: MakeDeviceRequest, kept: OrderFile | None) -> str:
    if ask.lettering is not None:
        return ask.lettering
    return "" if kept is None else kept.lettering


def _values_of_fabrication(kept: OrderFile | None, made: Fabrication | None) -> dict[str, float]:
    """An order's values, without those of another fabrication than the one asked for."""
    if kept is None:
        return {}
    device = device_named(kept.device)
    others = {one.name for each in device.wall for one in device.measures(each)}
    own = {one.name for one in device.measures(made or kept.made)}
    return {name: value for name, value in kept.values.items() if name not in others - own}


@dataclass(frozen=True)
class _GivenBody:
    body: ImportedBody
    known: KnownBody


def _body(path: Path, *, cut: bool) -> _GivenBody:
    sha256 = hash_of(read_content(path, _LARGEST_BYTES, ShapeFileError))
    body = ImportedBody(name=path.name, solid=read_mesh(path), cut=cut)
    return _GivenBody(body, KnownBody(name=path.name, cut=cut, sha256=sha256))


def _name(path: Path | None) -> str:
    return "" if path is None else path.name


def _write_files(
    read: ShapeFile, made: FinishedDevice, ordered: _OrderToMake, folder: Path, bed: Bed
) -> tuple[Path, ...]:
    from limbgram.report.drawings.devices import device_drawing
    from limbgram.report.drawings.drawing import png

    preview, doubt, side = made.preview, read.limb.doubt, made.preview.positive.side

    def named(kind: str, what: str = "") -> Path:
        stem = f"{preview.device.name}{what and f'-{what}'}"
        path = folder / file_name(stem, kind, side)
        return marked_red(path) if doubt else path

    kept = OrderFile(
        device=preview.device.name,
        made=preview.made,
        values=preview.values,
        free=ordered.order.free,
        recipe=ordered.order.recipe,
        zones=ordered.order.zones,
        bodies=ordered.bodies,
        limb_sha256=read.sha256,
        lettering=ordered.order.lettering,
    )
    told_of_it = Told(
        title=f"{preview.device.en}, {side}" if side != "none" else preview.device.en,
        description=" ".join(told(one) for one in (*made.findings, doubt) if one is not None),
        bed_from_mesh=bed_from(made.solid, bed),
    )
    drawing = device_drawing(made, side)
    return (
        write_3mf(made.solid, named("3mf"), "mm", told=told_of_it),
        write_stl(made.solid, named("stl"), "mm"),
        write_limb(preview.positive, named("ply", "positive")),
        write_bytes(named("png", "drawing"), png(drawing.figure).tobytes()),
        write_bytes(named("toml"), encode_order(kept)),
    )


def bed_from(solid: Mesh, bed: Bed) -> Rigid:
    """The motion to a print bed: turned as asked, the lowest corner at the bed's."""
    turn = _TURNS[bed]
    lowest = (solid.vertices_mm @ turn.T).min(0)
    return Rigid(turn.copy(), -lowest)
