"""Pictures of the surface for the accuracy page: sigma of every vertex, error where known."""

import numpy as np
from jaxtyping import Float64

from limbgram.report.accuracy.assessment import Assessment
from limbgram.report.accuracy.evidence import Evidence
from limbgram.report.drawings.drawing import Picture, png
from limbgram.report.drawings.maps import signed_map, size_map
from limbgram.report.drawings.surfaces import four_sides


def accuracy_pictures(evidence: Evidence, assessment: Assessment) -> tuple[Picture, ...]:
    """Error map where the truth is known; sigma map, or what was measured and what filled."""
    pictures: list[Picture] = []
    if assessment.off_mm is not None:
        pictures.append(_error_map(evidence, assessment.off_mm))
    if evidence.mesh.sigma_mm is not None:
        pictures.append(_sigma_map(evidence, evidence.mesh.sigma_mm.astype(np.float64)))
    else:
        drawing = four_sides(evidence.mesh, evidence.metric)
        title = "What was measured, and what was filled in"
        pictures.append(Picture("measured", title, drawing.caption, png(drawing.figure)))
    return tuple(pictures)


def _error_map(evidence: Evidence, off_mm: Float64[np.ndarray, " n"]) -> Picture:
    figure = signed_map(
        evidence.mesh, off_mm, "distance from the truth, mm (red: outside)", in_mm=True
    )
    caption = (
        "Signed distance of every measured vertex from the truth. Grey: not compared, because "
        "fewer than three photos see the truth there; orange: filled in, not measured."
    )
    return Picture("error", "Where it is off", caption, png(figure))


def _sigma_map(evidence: Evidence, sigma_mm: Float64[np.ndarray, " n"]) -> Picture:
    label = f"sigma along the normal, {evidence.unit}"
    figure = size_map(evidence.mesh, sigma_mm, label, in_mm=evidence.unit == "mm")
    caption = (
        "How sure each place is: one standard deviation along the normal, cameras and scale "
        "included. Orange is filled in: no photo measured it."
    )
    return Picture("sigma", "How sure the surface is", caption, png(figure))
