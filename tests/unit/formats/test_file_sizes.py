"""No file of ours is as large as what a reader still looks into."""

from collections.abc import Callable
from pathlib import Path

import pytest
from tests.unit.file_sizes import require_takes_up_to

from limbgram.formats.camera import read_camera
from limbgram.formats.gcode.machine import read_machine
from limbgram.formats.sidecar import progress_of


@pytest.mark.parametrize(
    ("read", "name", "most_bytes"),
    [
        (read_camera, "camera.json", 1_000_000),
        (read_machine, "machine.toml", 64 * 1024),
        (progress_of, "scan.limb.json", 4_000_000),
    ],
)
def test_a_file_is_read_up_to_its_size(
    tmp_path: Path, read: Callable[[Path], object], name: str, most_bytes: int
) -> None:
    require_takes_up_to(read, tmp_path / name, most_bytes)
