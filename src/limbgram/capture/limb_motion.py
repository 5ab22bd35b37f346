"""Limb motion: how the limb moved and bent between the photos, in a unit that means something."""

from collections.abc import Iterator
from dataclasses import dataclass

from limbgram.core.geometry.arrays import Points3
from limbgram.findings import Finding, doubt, fault
from limbgram.reconstruction.calibration.cameras import Cameras
from limbgram.reconstruction.mapping.scene import Scene
from limbgram.reconstruction.movement import (
    bending_found,
    in_report_unit,
    lens_doubt,
    movement_found,
)
from limbgram.reconstruction.scale.metric import MetricScene


@dataclass(frozen=True)
class LimbMotion:
    """The limb's movement and bending, in a unit that people understand."""

    scene: Scene
    unit: str

    def findings(self, cameras: Cameras) -> Iterator[Finding]:
        """Findings that the limb bent, or moved where its own points do not place the photos."""
        scene, unit = self.scene, self.unit
        movement, bending = scene.movement, scene.bending
        if movement is not None and movement.moved and not movement.alone:
            yield fault("coach.moved", how=movement_found(movement, scene.names, unit))
        if bending is not None and bending.moved:
            lens = lens_doubt(scene, cameras)
            yield fault("coach.bent", how=bending_found(bending, scene.names, unit, lens))

    def notes(self) -> Iterator[Finding]:
        """Notes that the limb, or what lies round it, moved as one piece, which is harmless."""
        scene, unit = self.scene, self.unit
        movement = scene.movement
        if movement is not None and movement.moved and movement.alone:
            yield doubt("coach.moved_alone", how=movement_found(movement, scene.names, unit))
        elif movement is not None and (movement.beside or movement.pushed or movement.misfit):
            yield movement_found(movement, scene.names, unit)
        if scene.bending is not None and scene.bending.misfit:
            yield bending_found(scene.bending, scene.names, unit)


def limb_motion(metric: MetricScene, limb: Points3) -> LimbMotion:
    """The limb's motion in mm, or as shares of its length where the scale is unknown.

    Args:
        limb: Points of what the cameras aim at.
    """
    scene, unit = in_report_unit(metric, limb)
    return LimbMotion(scene, unit)


def kept_still(scene: Scene) -> bool | None:
    """Whether the limb kept still and kept its shape; None if either is unknown."""
    seen = (scene.movement, scene.bending)
    if any(one is not None and one.moved for one in seen):
        return False
    if any(one is None or one.kind == "unknown" for one in seen):
        return None
    return True
