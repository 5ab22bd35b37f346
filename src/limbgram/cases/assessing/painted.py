"""Painted marks of a case: found in its photos, on the surface that it keeps."""

import numpy as np
from scipy.spatial import KDTree

from limbgram.cases.assessing.kept import kept_evidence, require_unaltered
from limbgram.cases.folder import CaseFolder
from limbgram.errors import OptionsError
from limbgram.shape.painted import PaintedMarks, PaintedOptions, find_painted_marks
from limbgram.surface.closest import TriangleTree
from limbgram.surface.mesh import Mesh

_MOST_TRIED = 2000
_SAME_VERTEX_MM = 0.01
"""Files carry places in single precision, or to six decimals."""
_LEAST_SAME = 0.5
"""Share of the vertices that must be the case's own: the rest may have been edited."""
_ALIKE_MM = 0.15
"""So even is the distance of a surface that was only thinned out or moved along its normals."""
_ALIKE_SHARE = 0.95
_THICKEST_SOCK_MM = 8.0


def painted_marks_of(case: CaseFolder, shape: Mesh, options: PaintedOptions) -> PaintedMarks:
    """The marks that a case's photos show, in the frame of a shape made from this case.

    Raises:
        CaseError: it is no finished case, or its products or photos are not what they were.
        OptionsError: the shape is not the case's surface as it lies there; a grey colour.
    """
    kept = kept_evidence(case)
    _require_same_place(case, shape, kept.mesh)
    scene = kept.metric.scene
    photos = [kept.photos.photos[idx] for idx in scene.placed]
    require_unaltered(photos)
    return find_painted_marks(photos, scene.views, kept.mesh, options)


def _require_same_place(case: CaseFolder, shape: Mesh, kept: Mesh) -> None:
    """Half of the shape's vertices are the case's, or it lies evenly over the case's surface.

    A limb that is turned about its axis lies near the case's surface too: nearness tells nothing.
    """
    tried = shape.vertices_mm[:: max(1, len(shape) // _MOST_TRIED)]
    own = KDTree(kept.vertices_mm).query(tried)[0] <= _SAME_VERTEX_MM
    if own.mean() >= _LEAST_SAME:
        return
    near = TriangleTree.of(kept.vertices_mm, kept.faces).closest(tried)
    outside = ((tried - near.points_mm) * kept.face_normals()[near.faces]).sum(1) >= 0
    over_mm = np.where(outside, near.distances_mm, -near.distances_mm)
    middle_mm = float(np.median(over_mm))
    uneven_mm = float(np.quantile(np.abs(over_mm - middle_mm), _ALIKE_SHARE))
    if abs(middle_mm) <= _THICKEST_SOCK_MM and uneven_mm <= _ALIKE_MM:
        return
    raise OptionsError(
        f"The photos of {case.root} are not of this shape as it lies now: its surface lies "
        f"{abs(middle_mm):.1f} mm from the case's (median) and is uneven to it by "
        f"{uneven_mm:.1f} mm. Marks would lie elsewhere on it. Take the case's own "
        f"{case.deliverables / 'surface.ply'}, mark and align that, and edit it afterwards; or "
        "name the case that made this shape."
    )
