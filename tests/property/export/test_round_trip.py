"""Whatever the mesh, a file reads back as it was written."""

from pathlib import Path
from tempfile import TemporaryDirectory

import numpy as np
from hypothesis import given, settings
from hypothesis import strategies as st
from hypothesis.extra import numpy as hnp

from limbgram.core.mesh.mesh import Mesh
from limbgram.formats.dxf import write_dxf
from limbgram.formats.dxf_r12 import write_r12_dxf
from limbgram.formats.table import FORMATS

coordinates = st.floats(-2000, 2000, allow_nan=False)


@st.composite
def meshes(draw: st.DrawFn) -> Mesh:
    """Any triangles, also flat and repeated ones, that use all their vertices."""
    count = draw(st.integers(3, 12))
    vertices = draw(hnp.arrays(np.float64, (count, 3), elements=coordinates))
    corners = [*range(count), *draw(st.lists(st.integers(0, count - 1), max_size=12))]
    corners += [0] * (-len(corners) % 3)
    coloured = draw(st.booleans())
    colours = draw(hnp.arrays(np.uint8, (count, 3))) if coloured else None
    return Mesh(
        vertices_mm=vertices,
        faces=np.array(corners, np.int32).reshape(-1, 3),
        colours=colours,
        filled=np.arange(count) % 2 == 0 if coloured else None,
    )


@settings(max_examples=15)
@given(mesh=meshes())
def test_every_format_reads_back(mesh: Mesh) -> None:
    # The writers raise if what they read back differs.
    with TemporaryDirectory() as name:
        folder = Path(name)
        for one in (one for one in FORMATS if one.holds_limbs and one.write is not None):
            assert one.write(mesh, folder / f"a{one.suffix}", "mm").stat().st_size > 84


@settings(max_examples=15)
@given(
    corners=hnp.arrays(np.float64, (4, 3), elements=st.floats(-500, 500)),
    spacing_mm=st.floats(20, 200),
)
def test_dxf_of_any_tetrahedron_reads_back(corners: np.ndarray, spacing_mm: float) -> None:
    faces = np.array([[0, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]], np.int32)
    with TemporaryDirectory() as name:
        mesh = Mesh(vertices_mm=corners, faces=faces)
        write_dxf(mesh, Path(name, "b.dxf"), "mm", spacing_mm=spacing_mm)
        path = write_r12_dxf(mesh, Path(name, "a.dxf"), "mm", spacing_mm=spacing_mm)
        assert path.read_text().count("3DFACE") == 4
