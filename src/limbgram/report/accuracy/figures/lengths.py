"""Lengths: what sets the scale (control), what tests it (check), and how well the board is seen."""

import numpy as np

from limbgram.report.accuracy.evidence import Evidence, Json
from limbgram.scale.metric import LengthCheck
from limbgram.shape.measures.taping import TapeWitness

_BOARD_LABEL = "board, "
"""How `scale.plate` labels lengths between the board's own corners."""


def length_figures(evidence: Evidence) -> Json:
    """The scale, its control and check lengths apart, and the board's sightings."""
    scale = evidence.metric.scale
    checks = [one for one in scale.lengths if one.role == "check"]
    controls = [one for one in scale.lengths if one.role == "control"]
    return {
        "unit": scale.unit,
        "source": scale.source,
        "relative_sigma": scale.relative_sigma,
        "control": [_length(one) for one in controls],
        "check": [_length(one) for one in checks],
        "control_rms": _rms(controls),
        "check_rms": _rms(checks),
        "check_worst": max((abs(one.error) for one in checks), default=float("nan")),
        "check_worst_label": max(checks, key=lambda one: abs(one.error)).label if checks else "",
        "checked_off_the_board": any(not one.label.startswith(_BOARD_LABEL) for one in checks),
        "tapes": [_tape(one) for one in evidence.tapes.found] if scale.unit == "mm" else [],
        "board": _board(evidence),
    }


def _length(one: LengthCheck) -> Json:
    return {
        "label": one.label,
        "known_mm": one.known_mm,
        "measured_mm": one.measured_mm,
        "error_mm": one.measured_mm - one.known_mm,
        "error": one.error,
        "sigma_mm": one.sigma_mm,
    }


def _tape(one: TapeWitness) -> Json:
    off_mm = one.measured_mm - one.taped.girth_mm
    return {
        "place": one.taped.place,
        "read_mm": one.taped.girth_mm,
        "measured_mm": one.measured_mm,
        "error_mm": off_mm,
        "error": off_mm / one.taped.girth_mm,
        "sigma_mm": one.sigma_mm,
        "reason": one.reason,
    }


def _rms(lengths: list[LengthCheck]) -> float:
    """Of the relative errors."""
    if not lengths:
        return float("nan")
    return float(np.sqrt(np.mean([one.error**2 for one in lengths])))


def _board(evidence: Evidence) -> Json | None:
    found, scene = evidence.detections, evidence.metric.scene
    if found is None:
        return None
    placed = {scene.names[k] for k in scene.placed}
    seen = [photo for photo in found.photos if photo.name in placed]
    return {
        "board": str(found.board),
        "photos": len(seen),
        "placed_photos": len(placed),
        "corners": len(found.corners_mm),
        "corners_per_photo": float(np.mean([len(photo.ids) for photo in seen]))
        if seen
        else float("nan"),
        "diagonal_mm": float(np.linalg.norm(np.ptp(found.corners_mm, axis=0))),
    }
