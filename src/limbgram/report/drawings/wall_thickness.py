"""Wall thickness: the thickness of a wall in colours, from four sides; thin is dark."""

from limbgram.core.mesh.mesh import Mesh
from limbgram.report.drawings.drawing import Drawing
from limbgram.report.drawings.maps import least_map
from limbgram.workbench.edits.thickness import Thickness


def wall_map(mesh_in_limb: Mesh, wall: Thickness) -> Drawing:
    """The wall of a shape in its limb frame."""
    x, y, z = wall.place_mm
    return Drawing(
        least_map(mesh_in_limb, wall.at_vertices_mm, "thickness of the wall, mm"),
        f"How thick the wall is: {wall.thinnest_mm:.2f} mm where it is thinnest, {abs(x):.0f} mm "
        f"to the patient's {'right' if x > 0 else 'left'} of the axis, {abs(y):.0f} mm "
        f"{'before' if y > 0 else 'behind'} it, at a height of {z:.0f} mm; half of it is thicker "
        f"than {wall.median_mm:.2f} mm. Grey: nothing lies opposite, as on a brim.",
    )
