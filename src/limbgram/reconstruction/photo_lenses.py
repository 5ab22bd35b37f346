"""Photo lenses: what lenses of single photos, camera files and a bent board explain, or may.

In      the scene as it is delivered, cameras, and the board's corners, which tell a millimetre.
Out     Explanations, the most likely first (`hypotheses.lens_explanations`,
        `hypotheses.flatness`), in words by `lenses_told`.
"""

from collections.abc import Iterator
from dataclasses import replace

import numpy as np

from limbgram.findings import Finding, doubt, note
from limbgram.reconstruction.calibration.cameras import Cameras, foreign_camera
from limbgram.reconstruction.hypotheses.flatness import SAG_FLOOR_MM, board_bend
from limbgram.reconstruction.hypotheses.lens_explanations import lens_explanations
from limbgram.reconstruction.mapping.lens_deviations import largest_px
from limbgram.reconstruction.mapping.scene import Deviation, Explanation, Scene
from limbgram.reconstruction.movement import millimetre
from limbgram.reconstruction.photos.photo import PhotoSet
from limbgram.reconstruction.scale.board import located_board
from limbgram.reconstruction.scale.visibility import aim_of
from limbgram.reconstruction.targets.board import BoardDetections


def explain_lenses(
    scene: Scene, cameras: Cameras, detections: BoardDetections | None = None
) -> tuple[Explanation, ...]:
    """What lenses and the board's shape explain; lenses' effect is taken where the cameras look."""
    points = scene.points_in_world
    aim = aim_of(scene.views, points)
    limb = points[np.linalg.norm(points - aim.point, axis=1) < aim.reach]
    mm = millimetre(detections, scene)
    found = tuple(
        replace(one, failed=("motion", *one.failed)) if one.kind in _instead_of(scene) else one
        for one in lens_explanations(scene, cameras.calibrations, limb, mm)
    )
    board = None if detections is None else located_board(scene, detections)
    if detections is None or board is None:
        return found
    size_mm = detections.board.square_mm * np.array(detections.board.squares, float)
    bend = board_bend(scene, cameras.calibrations, board, size_mm)
    return found if bend is None else tuple(sorted((*found, bend), key=lambda one: -one.score))


def _instead_of(scene: Scene) -> tuple[Deviation, ...]:
    """Deviations that a limb which lies elsewhere in every photo explains as well."""
    return () if scene.movement is None else scene.movement.instead_of_lenses


def files_contradicted(scene: Scene) -> tuple[Explanation, ...]:
    """That photos have another focal length than their camera file, where it is a fact.

    Photos that differ as much in focal length from each other were zoomed: that says nothing of the
    file.
    """
    told = [one for one in scene.lens_explanations if one.is_fact]
    apart = max((one.high for one in told if one.kind == "focal length"), default=0.0)
    return tuple(one for one in told if one.kind == "camera file" and one.low > apart)


def lenses_told(scene: Scene, cameras: Cameras, photos: PhotoSet) -> Iterator[Finding]:
    """Facts among them, in words; and a board that may be bent.

    Args:
        photos: In whose pixels lengths are told; the scene's own may be reduced.
    """
    yield from board_told(scene)
    for one in scene.lens_explanations:
        if not one.is_fact or one.kind == "bend":
            continue
        camera = scene.camera_idx[one.photos[0]]
        larger = photos.photos[one.photos[0]].width_px / scene.cameras[camera].width_px
        if one.kind == "camera file":
            given = cameras.calibrations[camera]
            given_px = (given.instead_of or given).camera.fx
            by_effect_px = (1.0 + one.effect) * given_px  # while the file still pulls at it
            found_px = by_effect_px if given.instead_of is None else scene.cameras[camera].fx
            yield foreign_camera(larger * given_px, larger * found_px, "placed")
        else:
            yield own_lens_told(scene, one, larger)


def board_told(scene: Scene) -> Iterator[Finding]:
    """That the board is bent, or may be, by more than is usual; in whatever unit the scene is."""
    for one in scene.lens_explanations:
        if one.kind == "bend" and (one.is_fact or one.low >= one.floor):
            yield note(
                "board.bent" if one.is_fact else "board.bent_or_lens",
                sag_mm=SAG_FLOOR_MM * one.effect / one.floor,
                sure_mm=SAG_FLOOR_MM * (one.high - one.effect) / one.floor,
            )


def own_lens_told(scene: Scene, one: Explanation, larger: float = 1.0) -> Finding:
    """A kind of deviation in words; `larger`: pixels told of for each of the scene's."""
    match one.kind:
        case "principal point":
            return note("lens.own.principal_point", most_px=larger * largest_px(scene, one.kind))
        case "focal length":
            return doubt("lens.own.focal_length", share=one.effect)
        case "rolling shutter":
            return note("lens.own.rolling_shutter", most_px=larger * largest_px(scene, one.kind))
        case _:
            raise ValueError(f"{one.kind} is no lens of single photos")
