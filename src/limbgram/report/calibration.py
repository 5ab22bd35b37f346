"""Report of a calibration: one picture, and one record for machines and people.

The picture shows the residual vectors in the frame of the photo (a lens or board that the model
misses shows as a pattern), where the board was seen, the RMS of every photo, and the numbers.
"""

import io
import math
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from limbgram.core.geometry.lens import PARAMETERS
from limbgram.core.interval import HOLDS, Interval, plus_minus
from limbgram.findings import LANGUAGES, Finding, told
from limbgram.reconstruction.calibration.adjustment import BOARD_TERMS
from limbgram.reconstruction.calibration.board import BoardCalibration
from limbgram.reconstruction.calibration.screening import Estimate
from limbgram.reconstruction.photos.photo import SetAside
from limbgram.report.drawings.drawing import as_it_is

if TYPE_CHECKING:
    from matplotlib.axes import Axes

_BLUE, _ORANGE, _GREY = "#1f5a8a", "#d9822b", "#777777"


@dataclass(frozen=True, kw_only=True)
class LensNumber:
    """A parameter of the lens."""

    value: float
    sigma: float
    fixed: bool


@dataclass(frozen=True, kw_only=True)
class TestedNumber:
    """A parameter that is delivered only where the photos show it."""

    value: float
    sigma: float
    delivered: bool


@dataclass(frozen=True, kw_only=True)
class LensCorrelations:
    """Correlations of the lens's parameters; zero rows for fixed ones."""

    order: tuple[str, ...]
    matrix: tuple[tuple[float, ...], ...]


@dataclass(frozen=True, kw_only=True)
class CoverageSummary:
    """Where in the picture the board was seen."""

    seen: float
    """Share of the picture."""
    reach: tuple[float, ...]
    """Towards top left, top right, bottom left and bottom right, 0 to 1."""
    edge_sigmas_px: tuple[float, ...]
    """Of a ray's place in these corners; NaN where the lens has no inverse."""


@dataclass(frozen=True, kw_only=True)
class BoardPhoto:
    """A photo that was used."""

    name: str
    rms_px: float
    corners: int
    corners_left_out: int


@dataclass(frozen=True, kw_only=True)
class CalibrationSummary:
    """What `limbgram calibrate --json` replies."""

    camera: str
    size_px: tuple[int, int]
    board: str
    rms_px: float
    sigma0_px: float
    """Standard deviation of one coordinate of one corner."""
    sigma_inflation: float
    """Factor on all sigmas for errors that the corners of one photo share."""
    parameters: dict[str, LensNumber]
    correlations: LensCorrelations
    pixel_aspect: Estimate
    skew_px: TestedNumber
    k3: TestedNumber
    board_shape: dict[str, Estimate] | None
    """How the board differs from flat and true; None: it does not."""
    coverage: CoverageSummary
    photos: tuple[BoardPhoto, ...]
    set_aside: tuple[SetAside, ...]
    doubts: tuple[Finding, ...]


def calibration_picture(result: BoardCalibration) -> bytes:
    """The report picture as PNG."""
    from matplotlib.backends.backend_agg import FigureCanvasAgg
    from matplotlib.figure import Figure

    figure = Figure(figsize=(13.0, 9.0), dpi=110, layout="constrained")
    canvas = FigureCanvasAgg(figure)
    residuals, coverage, photos, numbers = figure.subplots(2, 2).ravel()
    _draw_residuals(residuals, result)
    _draw_coverage(coverage, result)
    _draw_photos(photos, result)
    numbers.axis("off")
    numbers.text(
        0.0,
        1.0,
        as_it_is(calibration_text(result)),
        family="monospace",
        fontsize=8,
        va="top",
        wrap=True,
    )
    picture = io.BytesIO()
    canvas.print_png(picture)
    return picture.getvalue()


def calibration_text(result: BoardCalibration, language: str = LANGUAGES[0]) -> str:
    """A calibration's results as text, a line each; its findings in the language."""
    calibration, camera = result.calibration, result.calibration.camera
    lines = [
        f"{calibration.label or 'unnamed camera'}, {camera.width_px} x {camera.height_px}",
        f"{result.board}",
        f"{len(result.photos)} photos used, {len(result.set_aside)} set aside; "
        f"RMS {calibration.rms_px:.3f} px",
        *(f"  {one.name}: {told(one.reason, language)}" for one in result.set_aside),
        "",
    ]
    for name, value, sigma in zip(PARAMETERS, camera.packed, calibration.sigmas):
        fixed = "held at zero" if sigma == 0 else _spread(sigma)
        lines.append(f"{name:>5} {_rounded(value, sigma):>14} {fixed}")
    lines += [
        "",
        f"pixel aspect fy/fx {_with_spread(result.aspect)}",
        f"skew {_with_spread(result.skew)} px, {_tested_number(result.skew_delivered)}",
        f"k3 {_with_spread(result.k3)}, {_tested_number(result.k3_delivered)}",
        f"{HOLDS}; enlarged {result.inflation:.2f} times for errors shared within a photo",
    ]
    if result.board_shape is not None:
        lines += ["board not flat or true (of its half side):"] + [
            f"{name:>10} {_with_spread(one)}" for name, one in zip(BOARD_TERMS, result.board_shape)
        ]
    return "\n".join(lines + [""] + [f"! {told(doubt, language)}" for doubt in result.doubts])


def calibration_summary(result: BoardCalibration) -> CalibrationSummary:
    """A calibration's results for machines."""
    calibration, camera = result.calibration, result.calibration.camera
    shape = result.board_shape
    return CalibrationSummary(
        camera=calibration.label,
        size_px=(camera.width_px, camera.height_px),
        board=str(result.board),
        rms_px=calibration.rms_px,
        sigma0_px=result.sigma0_px,
        sigma_inflation=result.inflation,
        parameters={
            name: LensNumber(value=float(value), sigma=float(sigma), fixed=bool(sigma == 0))
            for name, value, sigma in zip(PARAMETERS, camera.packed, calibration.sigmas)
        },
        correlations=LensCorrelations(
            order=PARAMETERS, matrix=tuple(map(tuple, result.correlations.tolist()))
        ),
        pixel_aspect=result.aspect,
        skew_px=TestedNumber(
            value=result.skew.value, sigma=result.skew.sigma, delivered=result.skew_delivered
        ),
        k3=TestedNumber(
            value=result.k3.value, sigma=result.k3.sigma, delivered=result.k3_delivered
        ),
        board_shape=None if shape is None else dict(zip(BOARD_TERMS, shape)),
        coverage=CoverageSummary(
            seen=result.coverage.seen,
            reach=tuple(result.coverage.reach.tolist()),
            edge_sigmas_px=tuple(result.edge_sigmas_px.tolist()),
        ),
        photos=tuple(
            BoardPhoto(
                name=photo.name,
                rms_px=photo.rms_px,
                corners=len(photo.ids),
                corners_left_out=photo.dropped,
            )
            for photo in result.photos
        ),
        set_aside=result.set_aside,
        doubts=result.doubts,
    )


def _draw_residuals(axes: "Axes", result: BoardCalibration) -> None:
    xy = np.concatenate([photo.xy_px for photo in result.photos])
    off = np.concatenate([photo.residuals_px for photo in result.photos])
    camera, rms_px = result.calibration.camera, result.calibration.rms_px
    length_px = camera.width_px / 30.0
    axes.quiver(
        xy[:, 0], xy[:, 1], off[:, 0], off[:, 1],
        angles="xy", scale_units="xy", scale=max(rms_px, 1e-9) / length_px,
        width=0.0012, color=_BLUE,
    )  # fmt: skip
    axes.plot([0, length_px], [0, 0], color=_ORANGE, lw=3, solid_capstyle="butt")
    axes.text(0, 0, f"{rms_px:.3f} px", color=_ORANGE, va="bottom")
    axes.set_title("Residuals: seen minus projected")
    _frame(axes, result)


def _draw_coverage(axes: "Axes", result: BoardCalibration) -> None:
    camera = result.calibration.camera
    picture = axes.imshow(
        np.where(result.coverage.counts > 0, result.coverage.counts, np.nan),
        extent=(-0.5, camera.width_px - 0.5, camera.height_px - 0.5, -0.5),
        cmap="viridis",
        aspect="auto",
    )
    axes.figure.colorbar(picture, ax=axes, label="corners in all photos")
    axes.set_title(f"Coverage: {result.coverage.seen:.0%} of the picture (white: never seen)")
    _frame(axes, result)


def _draw_photos(axes: "Axes", result: BoardCalibration) -> None:
    names = [as_it_is(photo.name) for photo in result.photos]
    rms_px = [photo.rms_px for photo in result.photos]
    axes.barh(range(len(names)), rms_px, color=_BLUE)
    axes.axvline(result.calibration.rms_px, color=_ORANGE, lw=1)
    axes.set_yticks(range(len(names)), names, fontsize=min(8.0, 240.0 / len(names)))
    axes.invert_yaxis()
    axes.set_xlabel("RMS, px")
    axes.set_title("Photo by photo (line: all)")


def _frame(axes: "Axes", result: BoardCalibration) -> None:
    camera = result.calibration.camera
    axes.set_xlim(-0.5, camera.width_px - 0.5)
    axes.set_ylim(camera.height_px - 0.5, -0.5)
    axes.set_aspect("equal")
    axes.tick_params(colors=_GREY, labelsize=7)


def _with_spread(one: Estimate) -> str:
    return f"{_rounded(one.value, one.sigma)} {_spread(one.sigma)}"


def _tested_number(delivered: bool) -> str:
    return "delivered" if delivered else "held at zero in the camera"


def _rounded(value: float, sigma: float) -> str:
    """A value with two digits of its sigma."""
    return f"{value:g}" if sigma <= 0 else f"{value:.{_decimals(sigma)}f}"


def _decimals(sigma: float) -> int:
    return max(0, min(8, 1 - math.floor(math.log10(sigma)))) if sigma > 0 else 0


def _spread(sigma: float) -> str:
    return plus_minus(Interval.of_sigma(sigma), _decimals(sigma))
