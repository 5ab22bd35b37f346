"""Pictures: what people look at to believe, or doubt, a reconstruction.

In      the products of one reconstruction.
Out     Pictures as PNG, in the order in which the page shows them.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial

import numpy as np

from limbgram.core.mesh.mesh import Cloud, Mesh
from limbgram.core.run import track
from limbgram.reconstruction.features.detection import Features
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.pipeline import OtherPart
from limbgram.reconstruction.scale.metric import MetricScene
from limbgram.reconstruction.twoview.pairs import Pairs
from limbgram.report.drawings.charts import accuracy_chart, residual_histograms
from limbgram.report.drawings.drawing import Picture, png
from limbgram.report.drawings.photographs import keypoints_on_photo, matches_of_pair
from limbgram.report.drawings.surfaces import cloud_with_cameras, four_sides, sigma_map


@dataclass(frozen=True)
class Pictures:
    """All pictures of a report."""

    pictures: tuple[Picture, ...]


def draw(
    photos: PhotoSet,
    features: Features,
    pairs: Pairs,
    metric: MetricScene,
    cloud: Cloud,
    mesh: Mesh,
    others: Sequence[OtherPart] = (),
) -> Pictures:
    """Draw what each stage found."""
    known = mesh.sigma_mm is not None and bool(np.isfinite(mesh.sigma_mm).any())
    sure = (("sigma", "How sure each point is", lambda: sigma_map(mesh, metric)),)
    beside = (
        (
            f"part-{one.part.number}",
            f"Part {one.part.number}",
            partial(four_sides, one.mesh, metric),
        )
        for one in others
        if one.mesh is not None
    )
    drawings = (
        ("surface", "The surface", lambda: four_sides(mesh, metric)),
        *(sure if known else ()),
        *beside,
        ("cloud", "Points and cameras", lambda: cloud_with_cameras(cloud, metric)),
        ("features", "Keypoints", lambda: keypoints_on_photo(photos, features, metric)),
        ("matches", "Matches of a pair", lambda: matches_of_pair(photos, pairs)),
        ("residuals", "Residuals", lambda: residual_histograms(pairs, metric)),
        ("accuracy", "Accuracy by image scale", lambda: accuracy_chart(photos, metric)),
    )
    pictures: list[Picture] = []
    for name, title, make in track(drawings):
        drawing = make()
        pictures.append(Picture(name, title, drawing.caption, png(drawing.figure)))
    return Pictures(tuple(pictures))
