"""Lenses of single photos: what differed from photo to photo and is told as a fact."""

from dataclasses import dataclass

from limbgram.findings import told
from limbgram.reconstruction.mapping.lens_deviations import largest_px
from limbgram.reconstruction.mapping.scene import Deviation, Scene
from limbgram.reconstruction.photo_lenses import own_lens_told


@dataclass(frozen=True, kw_only=True)
class OwnLensFigures:
    """One kind of difference between photos that was solved for each of them."""

    kind: Deviation
    largest_px: float
    """Most that it moves a pixel of any photo: at the picture's border where it grows outwards."""
    chance: float
    """That photos of one lens look as much like it."""
    sentence: str


def own_lenses(scene: Scene) -> tuple[OwnLensFigures, ...]:
    """Kinds of difference that are told as facts; what was solved for and is not told is silent."""
    return tuple(
        OwnLensFigures(
            kind=one.kind,
            largest_px=largest_px(scene, one.kind),
            chance=one.chance,
            sentence=told(own_lens_told(scene, one)),
        )
        for one in scene.lens_explanations
        if one.is_fact and one.kind in ("principal point", "focal length", "rolling shutter")
    )
