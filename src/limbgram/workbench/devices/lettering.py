"""Lettering: raised text on the outer side of a printed device: patient, side, date.

In      a shell's solid, a place on it, the way in which the text runs, and the text.
Out     a closed solid, to be joined to the device: it takes nothing off the wall.
Method  The outlines of a bold typeface stand on the tangent plane of the place and go along its
        normal onto the outer side, from under the surface to above it. No two points of the plane
        meet in one, so that no letter crosses itself.
Fails   EditError: a character that the typeface lacks, or a text that reaches beyond the outer side
        or round it.
"""

from typing import Final

import manifold3d
import numpy as np
from embreex.mesh_construction import TriangleMesh
from embreex.rtcore_scene import EmbreeScene
from jaxtyping import Float64, Int32
from manifold3d import CrossSection

from limbgram.core.errors import EditError
from limbgram.core.geometry.arrays import Points3, Vector3
from limbgram.core.mesh.mesh import Mesh, unit
from limbgram.core.mesh.topology import edge_lengths, find_edges
from limbgram.workbench.devices.fittings import Part, mesh_of

CAPITAL_MM: Final = 7.0
"""Height of capitals; their strokes are 1.9 mm wide, which nozzles of 0.4 mm print cleanly."""
RAISED_MM: Final = 0.8
_EMBEDDED_MM = 0.4
"""How far a letter reaches under the surface: less than any wall."""
_EDGE_LENGTH_MM = 1.0
_LOOK_FROM_MM = 30.0
"""Height above the place from which rays are cast onto the surface."""
_STEEPEST_SLOPE = np.tan(np.radians(55.0))
"""Slope against the tangent plane up to which a letter can be read."""
_TYPEFACE: Final = "DejaVu Sans"
"""It comes with matplotlib, so that letters are the same on every machine."""
_LONGEST = 60
"""Most characters of a text; no limb has room for more."""
_OUTLINE_POINTS = 100.0
"""Size at which outlines are taken, before they are scaled."""


def lettering(shell: Mesh, text: str, place_mm: Vector3, outward: Vector3, runs: Vector3) -> Part:
    """Raised text on a shell, its middle at a place.

    Args:
        shell: Closed, in the limb frame.
        place_mm: On or under the outer side.
        outward: Outward normal there, roughly.
        runs: Direction in which the text runs, roughly.

    Raises:
        EditError: see the head of this file.
    """
    flat = _flat_letters(text)
    skin = _OuterSide(shell)
    for _ in range(2):  # the first normal is one face's, the second is that of all under the text
        axes = _text_axes(outward, runs)
        met = skin.faces_under(place_mm + flat.vertices_mm[:, :2] @ axes[:2], axes[2])
        if (met < 0).any():
            raise _no_room_error(text, flat, place_mm)
        outward = unit(skin.normals[met].mean(0, keepdims=True))[0]
    axes = _text_axes(outward, runs)
    height_mm = skin.heights_mm(place_mm + flat.vertices_mm[:, :2] @ axes[:2], axes[2])
    if not _is_gentle(flat, height_mm):
        raise _no_room_error(text, flat, place_mm)
    local = np.column_stack([flat.vertices_mm[:, :2], height_mm + flat.vertices_mm[:, 2]])
    return Part(solid=flat.with_vertices(place_mm + local @ axes), how="join", name="lettering")


def _flat_letters(text: str) -> Mesh:
    """The letters as a flat solid: x along the text, y up, z from below the plane to above."""
    from matplotlib.font_manager import FontProperties, findfont, get_font
    from matplotlib.textpath import TextPath

    typeface = FontProperties(family=_TYPEFACE, weight="bold")
    face = get_font(findfont(typeface))
    missing = [one for one in text if not (one.isprintable() and face.get_char_index(ord(one)))]
    if missing:
        raise EditError("device.lettering.character", text=text, character=missing[0])
    if not text.strip() or len(text) > _LONGEST:
        raise EditError("device.lettering.length", text=text[:_LONGEST], most=_LONGEST)
    capital = TextPath((0, 0), "H", _OUTLINE_POINTS, prop=typeface).get_extents().height
    no_formula = text.replace("$", r"\$")  # else what stands between two dollar signs is one
    path = TextPath((0, 0), no_formula, _OUTLINE_POINTS, prop=typeface)
    rings = [np.asarray(one) * CAPITAL_MM / capital for one in path.to_polygons()]
    outline = CrossSection(rings, manifold3d.FillRule.EvenOdd)
    solid = outline.extrude(_EMBEDDED_MM + RAISED_MM).refine_to_length(_EDGE_LENGTH_MM)
    made = mesh_of(solid)
    low, high = made.vertices_mm.min(0), made.vertices_mm.max(0)
    middle = (low + high) / 2
    return made.with_vertices(made.vertices_mm - [middle[0], middle[1], _EMBEDDED_MM])


def _text_axes(outward: Vector3, runs: Vector3) -> Float64[np.ndarray, "3 3"]:
    """Rows: along the text, up across it, outward."""
    along = unit((runs - (runs @ outward) * outward)[None])[0]
    return np.stack([along, np.cross(outward, along), outward])


class _OuterSide:
    """The outer side of a shell, hit by parallel rays."""

    def __init__(self, shell: Mesh) -> None:
        self._corners = shell.vertices_mm[shell.faces]
        self.normals = unit(shell.face_normals())
        self._scene = EmbreeScene()
        TriangleMesh(self._scene, self._corners.astype(np.float32))

    def faces_under(self, points_mm: Points3, outward: Vector3) -> Int32[np.ndarray, " n"]:
        """The face that a ray from above each point hits first; -1 for none."""
        starts = (points_mm + _LOOK_FROM_MM * outward).astype(np.float32)
        ways = np.broadcast_to(-outward, starts.shape).astype(np.float32)
        return np.asarray(self._scene.run(starts, ways))

    def heights_mm(self, points_mm: Points3, outward: Vector3) -> Float64[np.ndarray, " n"]:
        """Height of the surface over each point; NaN where nothing is hit."""
        met = self.faces_under(points_mm, outward)
        normals = self.normals[met]
        off = ((self._corners[met, 0] - points_mm) * normals).sum(1)
        return np.where(met >= 0, off / (normals @ outward), np.nan)


def _is_gentle(flat: Mesh, height_mm: Float64[np.ndarray, " n"]) -> bool:
    """Whether the surface under the letters has no step and no steep slope."""
    ends = find_edges(flat.faces).ends
    along_mm = edge_lengths(flat.vertices_mm * [1.0, 1.0, 0.0], ends)
    rise_mm = np.abs(height_mm[ends[:, 0]] - height_mm[ends[:, 1]])
    return bool((rise_mm <= _STEEPEST_SLOPE * along_mm + 1e-3).all())  # NaN is no


def _no_room_error(text: str, flat: Mesh, place_mm: Vector3) -> EditError:
    long_mm, wide_mm = np.ptp(flat.vertices_mm[:, :2], axis=0).tolist()
    x, y, z = place_mm.tolist()
    return EditError(
        "device.lettering.room", text=text, long_mm=long_mm, wide_mm=wide_mm, point_mm=(x, y, z)
    )
