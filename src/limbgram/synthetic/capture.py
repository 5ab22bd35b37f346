"""Capture: rendered photos of a synthetic limb, with the exact truth beside them.

In      CaptureOptions.
Out     a folder, written atomically: images/, calibration/ and truth/ (mesh.ply, cameras.json,
        board.json, notes.json, masks/).
Fails   CaseError: the folder exists already, or cannot be written.
"""

import os
import shutil
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np
from jaxtyping import Bool
from PIL import Image

from limbgram.core.errors import CaseError, system_reason
from limbgram.core.files import require_folder
from limbgram.core.geometry.arrays import Mask
from limbgram.core.geometry.lens import View
from limbgram.core.run import in_parallel
from limbgram.synthetic.faults import Session, crept, exposure_of, readout_of
from limbgram.synthetic.movement import MovementKind, bent, shares_of
from limbgram.synthetic.options import DEFAULTS, CaptureOptions
from limbgram.synthetic.props.board import PrintedBoard
from limbgram.synthetic.props.limb import Limb
from limbgram.synthetic.props.paint import Painting, bake
from limbgram.synthetic.props.plates import lay_plates
from limbgram.synthetic.props.room import (
    Panel,
    board_panels,
    make_room,
    make_screens,
    make_stand,
    moved_panel,
    shifted_about,
)
from limbgram.synthetic.props.stickers import stick
from limbgram.synthetic.rendering.developing import (
    LinearPicture,
    defocused,
    denoised,
    developed,
    exposed,
    shaken,
    sharpened,
    softened,
    store_again,
    write_jpeg,
)
from limbgram.synthetic.rendering.renderer import (
    RenderScene,
    inverse_depth_of,
    render,
    seen,
    silhouette,
)
from limbgram.synthetic.rendering.shading import Light, Lighting, light_of, shadow_edge
from limbgram.synthetic.truth import Truth, ideal_camera, stage_truth
from limbgram.synthetic.truth_files import write_record
from limbgram.synthetic.turned_limb import TurnedOver, Turning, standing_photos

_TEXELS_PER_PIXEL = 3.0
"""Resolution of the texture: finer paint would show in no photo."""
_FINEST_TEXEL_MM = 0.08


@dataclass(frozen=True)
class Capture:
    """A capture on disk and its truth."""

    folder: Path
    options: CaptureOptions
    truth: Truth

    @property
    def photos(self) -> tuple[Path, ...]:
        return tuple(self.folder / "images" / view.name for view in self.truth.views)

    @property
    def calibration_photos(self) -> tuple[Path, ...]:
        views = self.truth.calibration_views
        return tuple(self.folder / "calibration" / view.name for view in views)


def make_capture(folder: Path | str, options: CaptureOptions = DEFAULTS) -> Capture:
    """Photograph a synthetic limb and a calibration board into a new folder."""
    folder = Path(folder)
    if folder.exists():
        raise CaseError("made.there_already", folder=str(folder))
    require_folder(folder.parent)
    truth = stage_truth(options)
    beside = folder.with_name(f".{folder.name}.{os.getpid()}.part")
    try:
        for part in ("images", "calibration", "truth/masks"):
            (beside / part).mkdir(parents=True)
        _take_all(beside, truth, options)
        beside.rename(folder)
    except OSError as error:
        raise CaseError("made.not_written", folder=str(folder), why=system_reason(error)) from error
    finally:
        shutil.rmtree(beside, ignore_errors=True)
    return Capture(folder, options, truth)


def _take_all(folder: Path, truth: Truth, options: CaptureOptions) -> None:
    """Take every photo and write the truth."""
    limb_scene, board_scene = _scenes(truth, options)
    middle = truth.limb.mesh.vertices_mm.mean(0)

    def take(photo_idx: int) -> Bool[np.ndarray, " n"] | None:
        if photo_idx >= len(truth.views):
            view = truth.calibration_views[photo_idx - len(truth.views)]
            flash_mm = float(np.linalg.norm(view.centre_in_world))
            light = light_of(Lighting(), view.camera_from_world, flash_mm, np.zeros(3))
            shot = _Shot(view, Session.CALIBRATION, photo_idx - len(truth.views), photo_idx)
            _take(shot, board_scene, light, folder / "calibration", options)
            return None
        view, limb = truth.views[photo_idx], _limb_in(truth, photo_idx, options)
        view_in_room = truth.in_room(photo_idx)
        edge = shadow_edge(options.lighting, middle, _shadow_seed(options), photo_idx)
        camera_from_room = view_in_room.camera_from_world
        light = light_of(options.lighting, camera_from_room, options.distance_mm, edge)
        scene = _scene_in_photo(limb_scene, truth, photo_idx, limb, options)
        shot = _Shot(view_in_room, Session.RING, photo_idx, photo_idx)
        _take(shot, scene, light, folder / "images", options)
        _write_mask(silhouette(view, limb), folder / "truth" / "masks" / view.name)
        return seen(view, limb)

    visible = in_parallel(take, range(len(truth.views) + len(truth.calibration_views)))
    counts = np.sum([flags for flags in visible if flags is not None], axis=0)
    write_record(folder / "truth", truth, options, counts.astype(np.uint8))


def _shadow_seed(options: CaptureOptions) -> int:
    """Another one where something moves: direction and lean are drawn in the same way."""
    return options.seed if options.movement is None else options.seed + 1


def _limb_in(truth: Truth, photo_idx: int, options: CaptureOptions) -> Limb:
    """The limb in the shape that it has in one photo."""
    movement = options.movement
    if movement is None or movement.kind is not MovementKind.BEND:
        return truth.limb
    share = shares_of(movement, len(truth.views), options.seed)[photo_idx]
    return bent(truth.limb, float(share) * movement.shift_mm, options.seed)


def _scene_in_photo(
    scene: RenderScene, truth: Truth, photo_idx: int, limb: Limb, options: CaptureOptions
) -> RenderScene:
    """The limb's scene as it is in one photo."""
    turned_over = isinstance(options.turning, TurnedOver)
    standing = standing_photos(options.photos) if turned_over else options.photos
    room_from_board = truth.room_from_board[photo_idx]
    faults = options.faults
    if faults.creep_mm > 0:
        slid_mm = faults.creep_mm * photo_idx / (options.photos - 1)
        limb = crept(limb, slid_mm, options.seed)
    panels = scene.panels
    if faults.background_mm > 0:
        panels = shifted_about(panels, faults.background_mm, options.seed, photo_idx)
    return replace(
        scene,
        panels=tuple(
            moved_panel(one, room_from_board) if isinstance(one.picture, PrintedBoard) else one
            for one in panels
        ),
        limb=limb,
        stand=scene.stand if photo_idx < standing else None,
        room_from_limb=truth.room_from_limb[photo_idx],
    )


def _scenes(truth: Truth, options: CaptureOptions) -> tuple[RenderScene, RenderScene]:
    """The scene of the limb and that of the calibration board."""
    pixel_mm = options.distance_mm / ideal_camera(options).fx
    texel_mm = max(_FINEST_TEXEL_MM, pixel_mm / _TEXELS_PER_PIXEL)
    painting = Painting(
        options.paint, options.coverage, options.spots, options.bare, options.uneven
    )
    skin = bake(truth.limb, painting, options.seed, texel_mm, pixel_mm)
    stick(skin, truth.limb, options.stickers)
    room = make_room(options.seed, under_stand=True)
    if isinstance(options.turning, Turning):
        camera, screens = truth.in_room(0).centre_in_world, options.turning
        room += make_screens(
            options.seed, camera, options.distance_mm, screens.behind, screens.before
        )
    lying: tuple[Panel, ...] = () if truth.board is None else board_panels(truth.board)
    beside = np.zeros(3) if truth.board is None else truth.board.outline_in_world().mean(0)
    lying += tuple(one.panel for one in lay_plates(options.plates, beside))
    limb_scene = RenderScene(room + lying, truth.limb, make_stand(truth.limb.base_mm), skin)
    bare_room = make_room(options.seed, under_stand=False)
    return limb_scene, RenderScene((*bare_room, *board_panels(truth.calibration_board)))


@dataclass(frozen=True)
class _Shot:
    """One photo to take."""

    view: View
    session: Session
    photo_idx: int
    """Index in its session."""
    number: int
    """Index in the capture."""


def _take(
    shot: _Shot, scene: RenderScene, light: Light, folder: Path, options: CaptureOptions
) -> None:
    """Take one photo; its noise depends on the seed and its number alone."""
    view, faults, seed = shot.view, options.faults, options.seed
    rng = np.random.default_rng((seed, 10, shot.number))
    picture = softened(_through_lens(shot, scene, light, options), options.blur_px)
    if shot.session is Session.RING and shot.photo_idx in options.shaken:
        picture = shaken(picture, options.shake_px, rng.uniform(0, np.pi))
    picture = exposed(picture, exposure_of(faults, seed, shot.session, shot.photo_idx))
    pixels = denoised(developed(picture, options.noise, rng), faults.denoise)
    pixels = sharpened(pixels, faults.sharpen)
    taken = f"2024:03:06 10:{shot.number // 60:02d}:{shot.number % 60:02d}"
    write_jpeg(pixels, folder / view.name, options.lens, taken, options.jpeg_quality)
    if faults.stored_again:
        store_again(folder / view.name, faults.stored_again)


def _through_lens(
    shot: _Shot, scene: RenderScene, light: Light, options: CaptureOptions
) -> LinearPicture:
    """The rendered picture in linear light, with defocus blur."""
    view, faults, colour = shot.view, options.faults, options.lighting.lamp_colour
    rows = view.camera.height_px
    readout = readout_of(faults, rows, options.seed, shot.session, shot.photo_idx)
    if shot.session is Session.RING and colour != (1.0, 1.0, 1.0):
        # Light is additive: the lamp's part is rendered by itself and coloured.
        rest, lamp = light._replace(lamp_strength=0.0), _lamp_alone(light)
        picture = render(view, scene, rest, options.samples, readout)
        lit = render(view, scene, lamp, options.samples, readout)
        picture += lit * np.array(colour, np.float32)
    else:
        picture = render(view, scene, light, options.samples, readout)
    if faults.pupil_mm == 0:
        return picture
    inverse_depth = inverse_depth_of(view, scene)
    focused = inverse_depth[rows // 2 - rows // 8 : rows // 2 + rows // 8]
    columns = focused.shape[1]
    focused = focused[:, columns // 2 - columns // 8 : columns // 2 + columns // 8]
    focus_mm = 1.0 / float(np.median(focused))
    return defocused(picture, inverse_depth, focus_mm, faults.pupil_mm * view.camera.fx)


def _lamp_alone(light: Light) -> Light:
    return light._replace(ambient=0.0, flash_strength=0.0)


def _write_mask(mask: Mask, path: Path) -> None:
    Image.fromarray(mask).save(path.with_suffix(".png"), optimize=True)
