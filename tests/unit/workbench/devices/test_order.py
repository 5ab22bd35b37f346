"""The order's file says all that a device is made from, and is read as it was written."""

from pathlib import Path

import pytest
from tests.unit.file_sizes import require_takes_up_to

from limbgram.core.errors import LimbgramError
from limbgram.workbench.devices.order import (
    KnownBody,
    OrderFile,
    encode_order,
    parse_order,
    read_order,
)
from limbgram.workbench.edits.offset import Offset
from limbgram.workbench.recipe.recipe import Entry, Recipe

WHOLE = OrderFile(
    device="solid-afo",
    made="draped",
    values={"ankle_lateral_mm": 12.0, "sheet_mm": 4.8},
    free={"edge: ankle, lateral": (1.5, -2.0, 71.0)},
    recipe=Recipe(name='a "quoted" one', entries=(Entry(edit=Offset(distance_mm=1.0)),)),
    bodies=(KnownBody(name="lock.stl", cut=True, sha256="00ff"),),
    limb_sha256="abc",
)


@pytest.mark.parametrize(
    "order",
    [WHOLE, OrderFile(device="ucbl", made="printed", values={}, free={}, recipe=Recipe(name=""))],
)
def test_it_is_read_as_it_was_written(order: OrderFile) -> None:
    text = encode_order(order)
    assert parse_order(text.decode(), "a.toml") == order
    assert encode_order(parse_order(text.decode(), "a.toml")) == text


@pytest.mark.parametrize(
    ("change", "code"),
    [
        (('format = "limbgram device"', 'format = "limbgram recipe"'), "device.file.other_format"),
        (("version = 1", "version = 2"), "device.file.other_format"),
        (("made =", "maid ="), "device.file.unknown"),
        (('made = "draped"', 'made = "cast"'), "device.file.value"),
        (("= 12.0", '= "12"'), "device.file.value"),
        (("= 12.0", "= nan"), "device.file.value"),
        (("[1.5, -2.0, 71.0]", "[1.5, -2.0]"), "device.file.value"),
        (("version = 1", "version ="), "device.file.no_toml"),
    ],
)
def test_what_is_no_order_is_refused(change: tuple[str, str], code: str) -> None:
    text = encode_order(WHOLE).decode()
    assert change[0] in text
    with pytest.raises(LimbgramError) as refused:
        parse_order(text.replace(*change), "a.toml")
    assert refused.value.finding.code == code


def test_a_file_is_read_up_to_4_mb(tmp_path: Path) -> None:
    require_takes_up_to(read_order, tmp_path / "order.toml", 4_000_000)


@pytest.mark.parametrize(("device", "made"), [("solid-afo", "draped"), ("ptb-socket", "printed")])
def test_an_order_that_does_not_say_how_is_made_as_usual(device: str, made: str) -> None:
    text = f'format = "limbgram device"\nversion = 1\ndevice = "{device}"\n'
    assert parse_order(text, "a.toml").made == made
