"""Repair: makes one component of the surface without holes, open at the brim alone.

In      the Parts of a surface, the number of one of them, and the Cloud it was made from.
Out     a Mesh: one component, manifold, outward, no opening but the brim; new vertices are marked
        `filled`, and `repairs` counts what was done.
Method  tell the brim from the holes; fill holes with a triangulation of minimal area, remeshed and
        shaped as a thin plate (Liepa 2003).
Fails   SurfaceError: nothing is left, or a hole cannot be closed.
"""

from dataclasses import replace

from scipy.spatial import KDTree

from limbgram.core.errors import SurfaceError
from limbgram.core.geometry.arrays import Faces
from limbgram.core.mesh.mesh import Cloud, Mesh, Repairs
from limbgram.core.mesh.topology import (
    boundary_loops,
    face_components,
    is_edge_manifold,
    is_vertex_manifold,
    with_faces,
)
from limbgram.reconstruction.surface.cleaning import drop_dangling, largest_manifold
from limbgram.reconstruction.surface.holes import fill_holes, find_openings
from limbgram.reconstruction.surface.parts import MIN_FACES, Parts, oriented_outwards, too_few_faces


def repair(parts: Parts, cloud: Cloud, number: int | None = None) -> Mesh:
    """One part as a surface without holes, with the cloud's colours; None: the chosen part."""
    vertices, part_faces = parts.mesh.vertices_mm, parts.faces(number or parts.chosen)
    main = largest_manifold(vertices, drop_dangling(part_faces))
    if len(main) < MIN_FACES:
        raise too_few_faces(len(part_faces), len(main))
    start = with_faces(Mesh(vertices_mm=vertices, faces=main), main)
    start = oriented_outwards(start, cloud)
    openings = find_openings(start.vertices_mm, start.faces)
    whole = fill_holes(start.vertices_mm, start.faces, openings.holes)
    brim = openings.brim
    _check_topology(whole.faces, 0 if brim is None else 1)
    nearest = KDTree(cloud.points_mm).query(whole.vertices_mm)[1]
    is_chosen = number in (None, parts.chosen)
    return replace(
        whole,
        colours=cloud.colours[nearest],
        repairs=Repairs(
            islands_dropped=parts.crumbs if is_chosen else 0,
            island_share=parts.left_out_share if is_chosen else 0.0,
            holes_filled=len(openings.holes),
            part=number or parts.chosen,
            part_given=parts.given and is_chosen,
            others=parts.others if is_chosen else (),
        ),
    )


def _check_topology(faces: Faces, openings: int) -> None:
    """Refuse a surface that is not one manifold component with so many openings."""
    whole = is_edge_manifold(faces) and is_vertex_manifold(faces)
    if not whole or len(boundary_loops(faces)) != openings or face_components(faces).any():
        raise SurfaceError("surface.holes")
