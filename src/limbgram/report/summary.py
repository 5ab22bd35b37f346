"""The summary: the figures of a case for machines, and its verdict for people.

In      the products of one reconstruction, its accuracy, what each stage cost.
Out     a Summary that the report shows and `summary.json` keeps (SCHEMA).
"""

import math
from collections.abc import Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np

from limbgram.capture.setup import SetupCited
from limbgram.core.geometry.lens import Camera
from limbgram.core.mesh.mesh import Mesh
from limbgram.core.run import Timing
from limbgram.core.typed import Strictness, value_of
from limbgram.findings import Finding, note, told
from limbgram.reconstruction.budget import Resolution
from limbgram.reconstruction.calibration.cameras import LensSource
from limbgram.reconstruction.mapping.scene import PhotoVerdict, Scene
from limbgram.reconstruction.movement import in_report_unit, movement_remark
from limbgram.reconstruction.photo_lenses import board_told
from limbgram.reconstruction.photos.lenses import lens_notes
from limbgram.reconstruction.photos.masks import mask_notes
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.reconstruction.photos.quality import remarks_by_photo
from limbgram.reconstruction.pipeline import Reconstruction
from limbgram.reconstruction.scale.metric import Scale
from limbgram.report.accuracy.assessment import Assessment
from limbgram.report.accuracy.selfcalibration import SelfCalibration
from limbgram.report.image_scale import ImageScale, image_scales
from limbgram.report.intended_use import OF_SCANS
from limbgram.report.lenses import OwnLensFigures, own_lenses
from limbgram.report.parts import PartSummary, part_summaries
from limbgram.report.verdict_light import Light
from limbgram.workbench.limb import marked_red

SCHEMA: Literal["limbgram-summary/2"] = "limbgram-summary/2"
MOST_LEFT_OUT = 0.05
"""Of the surface: what it lacks of itself beyond this part is told below the verdict."""


@dataclass(frozen=True, kw_only=True)
class Verdict:
    """What the case says of itself: the findings of its accuracy."""

    light: Light
    headline: Finding
    reasons: tuple[Finding, ...]
    facts: tuple[Finding, ...]
    """Scale and its check, photos placed, what was set aside, left out or mended."""
    size_checked: bool = False
    """Whether a length that owes nothing to what set the scale confirms the size; earlier versions
    did not say it."""


@dataclass(frozen=True, kw_only=True)
class LengthSummary:
    """A known length beside the scene's."""

    label: str
    known_mm: float
    measured_mm: float
    sigma_mm: float
    role: Literal["control", "check"]
    error: float


@dataclass(frozen=True, kw_only=True)
class ScaleSummary:
    """What sets the limb's scale."""

    source: Literal["board", "distances", "none"]
    relative_sigma: float
    lengths: tuple[LengthSummary, ...]


@dataclass(frozen=True, kw_only=True)
class PhotoSummary:
    """The outcome of one photo."""

    name: str
    placed: bool
    points: int
    rms_px: float
    reason: str
    remarks: tuple[str, ...]
    features: int
    edge_width_px: float


@dataclass(frozen=True, kw_only=True)
class _Origin:
    """Fields written before those of the camera."""

    label: str
    source: LensSource


@dataclass(frozen=True, kw_only=True)
class CameraSummary(Camera, _Origin):
    """A camera after the adjustment."""


@dataclass(frozen=True, kw_only=True)
class MatchSummary:
    """How many matches were left after each step."""

    pairs_tried: int
    before_correlation: int
    after_correlation: int
    verified_pairs: int
    verified: int


@dataclass(frozen=True, kw_only=True)
class SceneSummary:
    """The placed photos and their points."""

    placed: int
    points: int
    observations: int
    rms_px: float
    notes: tuple[str, ...] = ()
    """How the photos were placed, where that is not as usual."""
    own_lenses: tuple[OwnLensFigures, ...] = ()
    """What differed from photo to photo in the lens, and was solved for each; usually nothing."""


@dataclass(frozen=True, kw_only=True)
class CloudSummary:
    """The points of the depth maps."""

    points: int
    spacing: float


@dataclass(frozen=True, kw_only=True)
class MeshSummary:
    """Size of the surface."""

    vertices: int
    faces: int
    size: tuple[float, ...]
    area: float
    volume: float | None
    """None where the surface is open."""
    left_out_share: float
    filled_share: float
    open_edges: int
    laid_back: int = 0
    """Vertices that the measurement had folded and that went back among their neighbours, as
    guesses; no fold is left in what is delivered. Earlier versions did not say it."""


@dataclass(frozen=True, kw_only=True)
class StageSummary:
    """What a stage cost; one that was taken up, what it cost then."""

    stage: str
    wall_s: float
    cpu_s: float
    peak_mb: float
    reused: bool


@dataclass(frozen=True, kw_only=True)
class Summary:
    """The figures of a case; NaN stands for what is not known, JSON has null for it."""

    schema: Literal["limbgram-summary/2"] = SCHEMA
    verdict: Verdict
    intended_use: str = OF_SCANS
    unit: Literal["mm", "unitless"]
    scale: ScaleSummary
    photos: tuple[PhotoSummary, ...]
    set_aside: tuple[SetAside, ...]
    cameras: tuple[CameraSummary, ...]
    matches: MatchSummary
    scene: SceneSummary
    image_scale: tuple[ImageScale, ...]
    cloud: CloudSummary
    resolution: Resolution
    mesh: MeshSummary
    parts: tuple[PartSummary, ...]
    stages: tuple[StageSummary, ...]
    self_calibration: SelfCalibration | None = None
    """What missing camera files cost."""
    setups: tuple[SetupCited, ...] = ()
    """Acceptance tests of the kit."""


def summary_of(tree: object) -> Summary:
    """The summary in the tree of a summary.json.

    Raises:
        Mismatch: it is none.
    """
    return value_of(tree, Summary, "the summary", Strictness(special=_null_is_unknown))


def _null_is_unknown(tree: object, hint: Any, _at: str) -> object:
    return math.nan if hint is float and tree is None else NotImplemented


def summarise(
    done: Reconstruction,
    assessed: Assessment,
    timings: Sequence[Timing],
    reused: Sequence[str] = (),
) -> Summary:
    """Summarise a reconstruction in figures."""
    scene, scale = done.metric.scene, done.metric.scale
    return Summary(
        verdict=Verdict(
            light=assessed.light,
            headline=assessed.headline,
            reasons=assessed.reasons,
            facts=facts(
                scale,
                scene.verdicts,
                done.photos.set_aside,
                left_out_share(done.mesh),
                len(done.others),
                count_laid_back(done.mesh),
            ),
            size_checked=assessed.size_checked,
        ),
        unit=scale.unit,
        scale=_scale(scale),
        photos=_photos(done),
        set_aside=(*done.photos.set_aside, *scale.set_aside),
        cameras=tuple(
            CameraSummary(label=one.label, source=one.source, **asdict(camera))
            for one, camera in zip(done.cameras.calibrations, scene.cameras, strict=True)
        ),
        matches=_matches(done),
        scene=_scene(done),
        image_scale=tuple(image_scales(done.photos, done.metric)),
        cloud=CloudSummary(points=len(done.cloud), spacing=done.cloud.spacing_mm),
        resolution=done.resolution,
        mesh=mesh_figures(done.mesh),
        parts=_file_names(part_summaries(done), assessed.light),
        stages=tuple(
            StageSummary(**asdict(timing), reused=name in reused)
            for name, timing in zip(_stage_product_names(timings), timings, strict=True)
        ),
        self_calibration=assessed.self_calibration,
        setups=assessed.setups,
    )


def _matches(done: Reconstruction) -> MatchSummary:
    return MatchSummary(
        pairs_tried=done.matches.pairs_tried,
        before_correlation=done.matches.descriptor_matches,
        after_correlation=sum(len(pair) for pair in done.matches.pairs),
        verified_pairs=len(done.pairs.verified),
        verified=sum(len(pair.matches) for pair in done.pairs.verified),
    )


def _scene(done: Reconstruction) -> SceneSummary:
    scene = done.metric.scene
    return SceneSummary(
        placed=len(scene.placed),
        points=len(scene.points_in_world),
        observations=len(scene.observations.xy_px),
        rms_px=float(np.sqrt(np.nanmean(scene.residuals_px() ** 2))),
        notes=(
            *map(told, (*mask_notes(done.photos), *lens_notes(done.photos), *done.still.notes)),
            *_poses_notes(done),
            *_placing_notes(scene),
        ),
        own_lenses=own_lenses(scene),
    )


def _poses_notes(done: Reconstruction) -> tuple[str, ...]:
    if not done.poses.sides:
        return ()
    names = " and ".join(map(told, done.poses.names(done.photos)))
    return (
        f"The object was turned over: {names} show it in two poses. They "
        "were joined by what lies on the object alone; floor, board and room of each pose were "
        "left out, and the board sets the scale in the pose whose photos show it more often. The "
        "surface was made as a closed one, by the Poisson method.",
    )


def _placing_notes(scene: Scene) -> tuple[str, ...]:
    notes: list[str] = []
    if scene.full_size is not None:
        notes.append(
            "The photos were placed by feature points of their full size, which takes longer: "
            f"reduced photos left {told(scene.full_size)}."
        )
    notes += _mark_notes(scene)
    notes += [one.sentence for one in own_lenses(scene)]
    notes += map(told, board_told(scene))
    if scene.movement is not None and scene.movement.alone:
        notes.append(
            "The limb moved, so the photos were placed by the points on the limb alone. The board "
            "sets the size by the photos that agree on where it lies. Where too few agree, its "
            "corners are moved back first, in each photo as far as the surroundings moved."
        )
    return tuple(notes)


def _mark_notes(scene: Scene) -> list[str]:
    marks, photos = scene.marks, len(scene.names)
    if marks is None:
        return []
    paint = (
        f"Paint alone placed {marks.photos_by_paint} of {photos} photos"
        if marks.photos_by_paint < photos
        else "Paint alone left a gap in the ring"
    )
    ids = ", ".join(map(str, marks.ids))
    notes = [f"{paint}; the coded marks {ids} helped: now {len(scene.placed)} are placed."]
    notes += [
        f"The coded mark {one} was left out: {told(why)}."
        for one, why in zip(marks.left_out, marks.reasons, strict=True)
    ]
    return notes


def _file_names(parts: tuple[PartSummary, ...], light: Light) -> tuple[PartSummary, ...]:
    """File names of parts; those of a red result are marked."""
    return tuple(
        replace(part, file=marked_red(Path(part.file)).name)
        if light == "red" and part.file
        else part
        for part in parts
    )


def _stage_product_names(timings: Sequence[Timing]) -> list[str]:
    """Under which name each stage's product is kept: a second part's repair is `repair-2`."""
    names: list[str] = []
    for k, timing in enumerate(timings):
        before = sum(one.stage == timing.stage for one in timings[:k])
        names.append(timing.stage.replace(" ", "_") + f"-{before + 1}" * (before > 0))
    return names


def facts(
    scale: Scale,
    verdicts: Sequence[PhotoVerdict],
    set_aside: Sequence[SetAside],
    left_out: float = 0.0,
    others: int = 0,
    laid: int = 0,
) -> tuple[Finding, ...]:
    """What stands below the verdict: scale, its check, photos placed, what was left out or mended.

    Args:
        left_out: Share of the measured surface.
        others: Bodies of size beside the one that was meant.
        laid: Points that went back among their neighbours.
    """
    placed = sum(verdict.placed for verdict in verdicts)
    found = [_scale_fact(scale), note("verdict.photos_placed", placed=placed, photos=len(verdicts))]
    if set_aside:
        found.append(note("verdict.set_aside", files=len(set_aside)))
    if left_out > MOST_LEFT_OUT:
        found.append(note("verdict.torn_off", share=left_out))
    if laid:
        found.append(note("verdict.laid_back", points=laid))
    if others:
        found.append(note("verdict.other_bodies", bodies=others))
    return tuple(found)


def left_out_share(mesh: Mesh) -> float:
    """What the surface lacks of itself though it was measured, as a part of its area."""
    return 0.0 if mesh.repairs is None else mesh.repairs.island_share


def count_laid_back(mesh: Mesh) -> int:
    """Vertices that the measurement had folded and that went back among their neighbours."""
    return 0 if mesh.repairs is None else mesh.repairs.laid_back


def _scale_fact(scale: Scale) -> Finding:
    if scale.unit == "unitless":
        return note("verdict.no_scale")
    source = "board" if scale.source == "board" else "distances"
    checks = [length for length in scale.lengths if length.role == "check"]
    if not checks:
        return note("verdict.scale_not_checked", source=source)
    worst = max(checks, key=lambda length: abs(length.error))
    return note(
        "verdict.scale_checked",
        source=source,
        lengths=len(checks),
        rms=math.sqrt(sum(length.error**2 for length in checks) / len(checks)),
        worst=abs(worst.error),
        label=worst.label,
    )


def mesh_figures(mesh: Mesh) -> MeshSummary:
    """Size of a mesh; the volume counts where the surface is closed."""
    normals = mesh.face_normals()
    first = mesh.vertices_mm[mesh.faces[:, 0]]
    return MeshSummary(
        vertices=len(mesh),
        faces=len(mesh.faces),
        size=tuple(np.ptp(mesh.vertices_mm, axis=0).tolist()),
        area=float(np.linalg.norm(normals, axis=1).sum() / 2),
        volume=float(np.einsum("fc,fc->", first, normals) / 6) if is_closed(mesh) else None,
        left_out_share=left_out_share(mesh),
        filled_share=mesh.filled_share(),
        open_edges=open_edges(mesh),
        laid_back=count_laid_back(mesh),
    )


def is_closed(mesh: Mesh) -> bool:
    return open_edges(mesh) == 0


def open_edges(mesh: Mesh) -> int:
    """Edges that do not have exactly two faces."""
    edges = np.sort(mesh.faces[:, [0, 1, 1, 2, 2, 0]].reshape(-1, 2), axis=1).astype(np.int64)
    _, counts = np.unique(edges[:, 0] * len(mesh) + edges[:, 1], return_counts=True)
    return int((counts != 2).sum())


def _scale(scale: Scale) -> ScaleSummary:
    return ScaleSummary(
        source=scale.source,
        relative_sigma=scale.relative_sigma,
        lengths=tuple(
            LengthSummary(
                label=one.label,
                known_mm=one.known_mm,
                measured_mm=one.measured_mm,
                sigma_mm=one.sigma_mm,
                role=one.role,
                error=one.error,
            )
            for one in scale.lengths
        ),
    )


def _photos(done: Reconstruction) -> tuple[PhotoSummary, ...]:
    said = remarks_by_photo(done.photos)
    as_told, unit = in_report_unit(done.metric, done.mesh.vertices_mm)
    return tuple(
        PhotoSummary(
            name=photo.name,
            placed=verdict.placed,
            points=verdict.points,
            rms_px=verdict.rms_px,
            reason="" if verdict.reason is None else told(verdict.reason),
            remarks=(
                *map(told, said.get(photo.name, ())),
                *([told(verdict.remark)] if verdict.remark else []),
                *map(told, movement_remark(as_told, number, unit)),
            ),
            features=len(keypoints),
            edge_width_px=photo.sharpness,
        )
        for number, (photo, verdict, keypoints) in enumerate(
            zip(
                done.photos.photos,
                done.metric.scene.verdicts,
                done.features.keypoints,
                strict=True,
            )
        )
    )
