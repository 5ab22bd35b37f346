"""STL, binary and text. A binary file may begin with "solid": its length tells what it is."""

import re

import numpy as np

from limbgram.errors import ShapeFileError
from limbgram.shape.reading.soup import Soup, triangles_merged

_HEADER = 84
_RECORD = np.dtype([("normal", "<f4", 3), ("corners", "<f4", (3, 3)), ("attribute", "<u2")])
_VERTEX = re.compile(rb"vertex\s+(\S+)\s+(\S+)\s+(\S+)", re.IGNORECASE)


def read_stl(content: bytes, name: str) -> Soup:
    """The triangles, corners at one place merged; normals are left out, the winding holds."""
    count = int.from_bytes(content[80:_HEADER], "little") if len(content) >= _HEADER else -1
    if len(content) == _HEADER + count * _RECORD.itemsize:
        records = np.frombuffer(content, _RECORD, offset=_HEADER)
        corners = records["corners"].astype(np.float64)
        return Soup(mesh=triangles_merged(corners), stated_unit=stated_unit(content[:80]))
    if content[:512].lstrip()[:5].lower() == b"solid":
        return Soup(mesh=triangles_merged(_text(content, name)))
    if len(content) < _HEADER or b"\0" not in content:
        kind = "it is empty" if not content else f"{len(content):,} bytes of something else"
        raise ShapeFileError(
            f"{name} is no STL file, whatever its name says: {kind}. Choose the file that the "
            "scanner or program exported, or export it again."
        )
    have = (len(content) - _HEADER) // _RECORD.itemsize
    raise ShapeFileError(
        f"{name} is no whole STL file: its header promises {max(count, 0):,} triangles and there "
        f"is room for {max(have, 0):,}. It was probably cut off on its way: copy it again."
    )


def stated_unit(header: bytes) -> str | None:
    """What a header of ours says of the unit."""
    found = re.search(rb"limbgram.*unit: (\w+)", header)
    return found[1].decode("ascii") if found else None


def _text(content: bytes, name: str) -> np.ndarray:
    try:
        numbers = np.array(_VERTEX.findall(content)).astype(np.float64)
    except ValueError as error:
        raise ShapeFileError(
            f"{name} is damaged: a corner is no number ({error}). Export it again."
        ) from error
    if not len(numbers) or len(numbers) % 3 or b"endsolid" not in content[-1000:].lower():
        raise ShapeFileError(
            f"{name} is no whole STL file: it ends after {len(numbers)} corners without saying "
            "that this is the end. It was probably cut off on its way: copy it again."
        )
    return numbers.reshape(-1, 3, 3)
