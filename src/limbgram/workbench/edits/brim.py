"""The brim: the proximal opening of a limb."""

import numpy as np
from jaxtyping import Int64

from limbgram.core.errors import EditError
from limbgram.core.mesh.topology import boundary_loops
from limbgram.workbench.edits.regions import points_in_limb_frame
from limbgram.workbench.limb import Limb


def brim_loop(limb: Limb) -> Int64[np.ndarray, " b"]:
    """The proximal opening: the longest loop of open edges in the upper half of the limb.

    Raises:
        EditError: the shape is closed there.
    """
    heights = points_in_limb_frame(limb)[:, 2]
    middle = (heights.min() + heights.max()) / 2
    upper = [loop for loop in boundary_loops(limb.mesh.faces) if heights[loop].mean() > middle]
    if not upper:
        raise EditError("edit.no_brim")
    ends = limb.mesh.vertices_mm
    lengths = [np.linalg.norm(ends[loop] - ends[np.roll(loop, -1)], axis=1).sum() for loop in upper]
    return upper[int(np.argmax(lengths))].astype(np.int64)
