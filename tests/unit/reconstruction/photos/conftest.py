"""Small photos on disk."""

from collections.abc import Callable
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

Writer = Callable[..., Path]


@pytest.fixture
def write_photo(tmp_path: Path) -> Writer:
    """Write a picture of seeded noise blobs: name, seed, size and EXIF tags by choice."""

    def write(name: str, seed: int = 0, size: tuple[int, int] = (120, 90), **tags: object) -> Path:
        coarse = np.random.default_rng(seed).integers(0, 256, (9, 12, 3), dtype=np.uint8)
        picture = Image.fromarray(coarse).resize(size, Image.Resampling.BICUBIC)
        exif = Image.Exif()
        exif[0x010F], exif[0x0110] = tags.get("make", "Maker"), tags.get("model", "Model 1")
        exif[0x0112] = tags.get("orientation", 1)
        details = exif.get_ifd(0x8769)
        details[0x920A] = tags.get("focal_mm", 50.0)
        named = {"lens": 0xA434, "film_mm": 0xA405, "zoom": 0xA404, "serial": 0xA431}
        for tag, value in (named | {"taken": 0x9003, "fraction": 0x9291}).items():
            if tag in tags:
                details[value] = tags[tag]
        path = tmp_path / name
        path.parent.mkdir(parents=True, exist_ok=True)
        picture.save(path, exif=exif.tobytes())  # else a TIFF lacks the details
        return path

    return write
