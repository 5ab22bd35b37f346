"""What clinicians can ask for stands on their pages by its name."""

from pathlib import Path

import pytest

from limbgram.workbench.devices.device import Device, devices
from limbgram.workbench.edits.edit import Edit, name_of
from limbgram.workbench.edits.editing import EDITS

CLINIC = Path(__file__).parents[3] / "docs" / "clinic"
PAGES = {page.name: page.read_text("utf-8") for page in CLINIC.glob("*.md")}


@pytest.mark.parametrize("device", devices().values(), ids=lambda one: one.name)
def test_every_device_stands_on_the_page_of_its_trade(device: Device) -> None:
    page = "orthoses.md" if device.kind in ("foot", "torso") else "sockets.md"
    assert f"`{device.name}`" in PAGES[page]


@pytest.mark.parametrize("edit", EDITS, ids=name_of)
def test_every_edit_is_named_on_a_page(edit: type[Edit]) -> None:
    name = name_of(edit)
    assert any(f"`{name}`" in page or f"toml {name} " in page for page in PAGES.values())
