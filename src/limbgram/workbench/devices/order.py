"""The order's file: TOML that a person can read and correct, from which a device is made again.

    format = "limbgram device"
    version = 1
    device = "solid-afo"
    made = "draped"
    lettering = "A. M. left"
    limb_sha256 = "..."

    [values]
    ankle_lateral_mm = 12.0

    [free]
    "edge: ankle, lateral" = [44.0, 3.0, 71.0]

    [[zone]]
    at = "lateral malleolus"
    add_mm = 1.5
    reach_mm = 25.0

    [[body]]
    name = "lock.stl"
    cut = false
    sha256 = "..."

Every value is written, usual ones too: an order stands by itself. The recipe of the positive stands
in it whole, as the text `recipe`. Bodies of other makers are not in it: they are given again, and
known by their hashes.
"""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, cast, get_args

from limbgram.core.errors import OptionsError, ShapeFileError
from limbgram.core.files import read_content, toml_of
from limbgram.core.typed import Mismatch, any_value_of
from limbgram.workbench.devices.device import Fabrication, WallZone, devices
from limbgram.workbench.devices.trims import FreePoints
from limbgram.workbench.recipe.file import encode_recipe, parse_recipe, toml_text
from limbgram.workbench.recipe.recipe import Recipe

_FORMAT, _VERSION = "limbgram device", 1
_LARGEST_BYTES = 4_000_000
_KEYS = {
    *("format", "version", "device", "made", "limb_sha256"),
    *("values", "free", "zone", "body", "recipe", "lettering"),
}


@dataclass(frozen=True, kw_only=True)
class KnownBody:
    """A body of another maker, as an order names it."""

    name: str
    cut: bool
    sha256: str


@dataclass(frozen=True, kw_only=True)
class OrderFile:
    """What an order's file holds."""

    device: str
    made: Fabrication
    values: Mapping[str, float]
    free: FreePoints
    recipe: Recipe
    zones: tuple[WallZone, ...] = ()
    bodies: tuple[KnownBody, ...] = ()
    limb_sha256: str = ""
    lettering: str = ""


def read_order(path: Path | str) -> OrderFile:
    """Read an order.

    Raises:
        ShapeFileError: it cannot be read, or is no order.
        OptionsError: a key or value that is not known.
    """
    path = Path(path)
    return parse_order(read_content(path, _LARGEST_BYTES, ShapeFileError), path.name)


def parse_order(text: str | bytes, name: str) -> OrderFile:
    """An order from its text, or the bytes of its file."""
    try:
        tree = toml_of(text)
    except ValueError as error:
        raise ShapeFileError("device.file.no_toml", name=name, reason=str(error)) from error
    if tree.get("format") != _FORMAT or tree.get("version") != _VERSION:
        raise ShapeFileError(
            "device.file.other_format", name=name, format=_FORMAT, version=_VERSION
        )
    unknown = sorted(set(tree) - _KEYS)
    if unknown:
        raise OptionsError("device.file.unknown", name=name, key=unknown[0])
    try:
        recipe = _value(tree, "recipe", str, "")
        device = _value(tree, "device", str, "")
        return OrderFile(
            device=device,
            made=_value(tree, "made", Fabrication, _usual_fabrication(device)),
            values=_table(tree, "values", float),
            free=_table(tree, "free", tuple[float, float, float]),
            zones=_value(tree, "zone", tuple[WallZone, ...], ()),
            bodies=_value(tree, "body", tuple[KnownBody, ...], ()),
            recipe=parse_recipe(recipe, name) if recipe else Recipe(name=""),
            limb_sha256=_value(tree, "limb_sha256", str, ""),
            lettering=_value(tree, "lettering", str, ""),
        )
    except Mismatch as error:
        raise OptionsError("device.file.value", name=name, reason=str(error)) from error


def encode_order(order: OrderFile) -> bytes:
    """The order's file; reading it gives an equal order."""
    lines = [
        f'format = "{_FORMAT}"',
        f"version = {_VERSION}",
        f"device = {toml_text(order.device)}",
        f"made = {toml_text(order.made)}",
    ]
    if order.lettering:
        lines.append(f"lettering = {toml_text(order.lettering)}")
    if order.limb_sha256:
        lines.append(f"limb_sha256 = {toml_text(order.limb_sha256)}")
    if order.recipe.entries:
        lines.append(f"recipe = {toml_text(encode_recipe(order.recipe).decode())}")
    lines += ["", "[values]"]
    lines += [f"{name} = {float(value)!r}" for name, value in order.values.items()]
    if order.free:
        lines += ["", "[free]"]
        lines += [
            f"{toml_text(name)} = [{', '.join(repr(float(one)) for one in place)}]"
            for name, place in order.free.items()
        ]
    for zone in order.zones:
        lines += ["", "[[zone]]", f"at = {toml_text(zone.at)}"]
        lines += [f"add_mm = {zone.add_mm!r}", f"reach_mm = {zone.reach_mm!r}"]
    for body in order.bodies:
        lines += ["", "[[body]]", f"name = {toml_text(body.name)}"]
        lines += [f"cut = {str(body.cut).lower()}", f"sha256 = {toml_text(body.sha256)}"]
    return ("\n".join(lines) + "\n").encode()


def _usual_fabrication(device: str) -> Fabrication:
    """How a device is usually made; of one that is not known, which is refused later, as any."""
    known = devices().get(device)
    return get_args(Fabrication)[0] if known is None else known.usual_fabrication


def _value(tree: Mapping[str, Any], key: str, hint: Any, otherwise: Any) -> Any:
    return any_value_of(tree[key], hint, key) if key in tree else otherwise


def _table(tree: Mapping[str, Any], key: str, hint: Any) -> dict[str, Any]:
    found: object = tree.get(key, {})
    if not isinstance(found, dict):
        raise Mismatch(f"{key} must be a table")
    rows = cast(dict[str, Any], found)
    return {name: any_value_of(one, hint, f"{key}.{name}") for name, one in rows.items()}
