"""Masks of a finished case: the limb's silhouette in each photo, as images that people can correct.

In      a finished case: its photos, their poses, and its surface.
Out     FOLDER/NAME.png for every placed photo NAME: white is the limb, black is the rest, as large
        as the photo, and upright or broad as it is seen, as paint programs want it; of a photo that
        is stored turned by half it lies as stored. FOLDER/at-a-glance.jpg shows all of them.
        `reconstruct --masks FOLDER` takes them, as they are or corrected in any paint program.
Method  the surface as each photo sees it, its holes filled, and a margin round it, so that the
        limb's own edge is never lost.
Fails   CaseError: no finished case, photos that were altered, or a folder that holds something:
        masks corrected by hand are never written over.
"""

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

import cv2
import numpy as np
from jaxtyping import UInt8
from PIL import Image

from limbgram.cases.case_assessment import kept_evidence, require_unaltered
from limbgram.cases.contact_sheet import CaptionedPicture, contact_sheet
from limbgram.cases.folder import CaseFolder
from limbgram.core.errors import CaseError, OptionsError
from limbgram.core.files import require_folder, written_whole
from limbgram.core.geometry.arrays import ColourImage, Mask
from limbgram.core.geometry.lens import View
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.run import Run, in_parallel
from limbgram.reconstruction.photos.decoding import halvings_to, load_colour
from limbgram.reconstruction.photos.masks import mask_as_png, upright
from limbgram.reconstruction.photos.photo import Photo
from limbgram.report.drawings.shading import rasterise

MARGIN_MM = 5.0
"""Round the surface: more than surface and camera poses are ever wrong by."""
WIDEST_MARGIN_MM = 100.0
SHEET = "at-a-glance.jpg"
_DRAWN_PX = 1600
"""Longest side at which the surface is drawn; its outline is smooth between those pixels."""
_DRAWING_MB = 150.0
_THUMB_PX = 300
_COLUMNS = 5
_DIMMED = 0.3
_OUTLINE = (217, 130, 43)


@dataclass(frozen=True, kw_only=True)
class MaskFolder:
    """The folder with the masks of a case."""

    folder: Path
    masks: tuple[Path, ...]
    without: tuple[str, ...]
    """Photos without a mask: they were not placed, or do not show the surface."""

    @property
    def sheet(self) -> Path:
        return self.folder / SHEET


def write_masks(case: CaseFolder, folder: Path, run: Run, margin_mm: float) -> MaskFolder:
    """Write the mask of every placed photo of a finished case into a new folder.

    Raises:
        CaseError: it is no finished case, its photos were altered, or the folder is not empty.
        OptionsError: the margin is no length from 0 to 100 mm.
        ExportError: the folder cannot be made.
    """
    if not 0.0 <= margin_mm <= WIDEST_MARGIN_MM:  # not a number is not either
        raise OptionsError(
            "case.mask_margin", margin_mm=margin_mm, widest_mm=WIDEST_MARGIN_MM, usual_mm=MARGIN_MM
        )
    if folder.exists() and not (folder.is_dir() and not any(folder.iterdir())):
        raise CaseError("case.masks_folder_taken", folder=str(folder))
    require_folder(folder.parent)
    evidence = kept_evidence(case)
    require_unaltered(evidence.photos.photos)
    scene, mesh = evidence.metric.scene, evidence.mesh
    names = _mask_names(scene.names)

    def draw(idx: int) -> tuple[str, ColourImage] | None:
        photo = evidence.photos.photos[idx]
        mask = mask_of(mesh, scene.view(idx), margin_mm)
        if not mask.any():
            return None
        (beside / names[photo.name]).write_bytes(mask_as_png(mask, photo.exif))
        return photo.name, _thumb(photo, mask)

    def draw_all() -> list[tuple[str, ColourImage] | None]:
        return in_parallel(draw, scene.placed, each_mb=_DRAWING_MB)

    draw_all.__name__ = "draw_masks"
    with written_whole(folder) as beside:
        beside.mkdir(parents=True)
        drawn = [one for one in run(draw_all) if one is not None]
        if drawn:
            pictures = [CaptionedPicture(names[name], thumb) for name, thumb in drawn]
            sheet = Image.fromarray(contact_sheet(pictures, _COLUMNS))
            sheet.save(beside / SHEET, "JPEG", quality=90)
    made = {name for name, _ in drawn}
    return MaskFolder(
        folder=folder,
        masks=tuple(folder / names[name] for name, _ in drawn),
        without=tuple(name for name in scene.names if name not in made),
    )


def _mask_names(photos: Sequence[str]) -> dict[str, str]:
    """NAME.png for NAME.jpg, or NAME.jpg.png where another photo is called NAME too."""
    stems = [Path(name).stem for name in photos]
    return {
        name: f"{stem if stems.count(stem) == 1 else name}.png" for name, stem in zip(photos, stems)
    }


def mask_of(mesh: Mesh, view: View, margin_mm: float) -> Mask:
    """The pixels of a photo that show the surface, its holes filled, and a margin round it."""
    camera = view.camera
    factor = min(1.0, _DRAWN_PX / max(camera.width_px, camera.height_px))
    width, height = round(camera.width_px * factor), round(camera.height_px * factor)
    in_camera = view.camera_from_world.apply(mesh.vertices_mm)
    pixels = np.column_stack([camera.project(in_camera), in_camera[:, 2]])
    pixels[:, 0] = (pixels[:, 0] + 0.5) * width / camera.width_px - 0.5
    pixels[:, 1] = (pixels[:, 1] + 0.5) * height / camera.height_px - 0.5
    projected = np.asarray(np.isfinite(pixels).all(axis=1))
    faces = mesh.faces[projected[mesh.faces].all(axis=1)]
    face_idx, _ = rasterise(np.nan_to_num(pixels), faces, height, width)
    shown = (face_idx >= 0).astype(np.uint8)
    outlines, _ = cv2.findContours(shown, cv2.RETR_EXTERNAL, cv2.CHAIN_APPROX_NONE)
    filled = cv2.drawContours(shown, outlines, -1, 1, cv2.FILLED)
    depth_mm = float(np.median(in_camera[:, 2]))
    margin_px = max(round(camera.fx * factor * margin_mm / max(depth_mm, 1e-9)), 0)
    disc = cv2.getStructuringElement(cv2.MORPH_ELLIPSE, (2 * margin_px + 1, 2 * margin_px + 1))
    dilated = cv2.dilate(filled, disc).astype(np.float32)
    size_px = camera.width_px, camera.height_px
    return np.greater(np.asarray(cv2.resize(dilated, size_px)), 0.5)


def _thumb(photo: Photo, mask: Mask) -> UInt8[np.ndarray, "rows columns 3"]:
    """A small photo, upright, dimmed where the mask is black, and the mask's edge."""
    image = load_colour(photo, halvings_to(photo.width_px, _THUMB_PX))
    factor = _THUMB_PX / max(photo.width_px, photo.height_px)
    size = max(1, round(photo.width_px * factor)), max(1, round(photo.height_px * factor))
    small = np.array(cv2.resize(image, size, interpolation=cv2.INTER_AREA))
    used = cv2.resize(mask.astype(np.uint8), size, interpolation=cv2.INTER_NEAREST)
    small[used == 0] = (small[used == 0] * _DIMMED).astype(np.uint8)
    outlines, _ = cv2.findContours(used, cv2.RETR_LIST, cv2.CHAIN_APPROX_NONE)
    cv2.drawContours(small, outlines, -1, _OUTLINE, 1)
    return upright(small, photo.exif)
