"""Stack: several scans of one limb, laid on the first and measured at the same heights."""

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from jaxtyping import Float64

from limbgram.errors import MeasureError
from limbgram.shape.comparing.comparing import CompareOptions, at_odds, lay
from limbgram.shape.comparing.frames import Axes, axes_of, in_limb_frame, outside_of
from limbgram.shape.comparing.levels import alike_in_detail, changes_by_level, shared_heights_mm
from limbgram.shape.comparing.registration import Alignment
from limbgram.shape.limb import Limb


@dataclass(frozen=True, kw_only=True)
class Stack:
    """Measures of n scans at k heights."""

    axes: Axes
    alignments: tuple[Alignment, ...]
    """Of all but the first."""
    heights_mm: Float64[np.ndarray, " k"]
    from_mm: float | None
    """Lower bound of the volume; None for the distal end."""
    volumes_mm3: Float64[np.ndarray, " n"]
    volume_sigmas_mm3: Float64[np.ndarray, " n"]
    """NaN where a scan carries no sigmas."""
    tapes_mm: Float64[np.ndarray, "n k"]
    """Girths as a tape reads them; NaN where there is no whole section."""
    tape_sigmas_mm: Float64[np.ndarray, "n k"]
    notes: tuple[str, ...]


def stack(limbs: Sequence[Limb], options: CompareOptions) -> Stack:
    """Lay all on the first and measure them between the heights that all have.

    Raises:
        MeasureError: a scan cannot be laid on the first, or its volume is open.
    """
    limbs = [outside_of(limb) for limb in limbs]
    first = limbs[0]
    axes = axes_of(first)
    alignments = tuple(lay(first, limb, axes, options.registration) for limb in limbs[1:])
    meshes = [in_limb_frame(first.mesh, axes.limb_from_mesh)] + [
        in_limb_frame(limb.mesh, axes.limb_from_mesh @ alignment.first_from_second)
        for limb, alignment in zip(limbs[1:], alignments)
    ]
    meshes = alike_in_detail(meshes)
    shared = set(shared_heights_mm(meshes[0], meshes[0], options.spacing_mm))
    for mesh in meshes[1:]:
        shared &= set(shared_heights_mm(meshes[0], mesh, options.spacing_mm))
    heights = tuple(sorted(shared))
    if not heights:
        raise MeasureError("The scans share no level: look at their alignment.")
    loose_mm = [0.0, *(alignment.slide_sigma_mm for alignment in alignments)]
    against = [
        changes_by_level(meshes[0], mesh, heights, sigma_mm)
        for mesh, sigma_mm in zip(meshes, loose_mm)
    ]
    for limb, change in zip(limbs, against):
        if change.volume is None:
            raise MeasureError(f"{limb.name or 'A scan'}: {change.reason}")
    starts = {change.from_mm for change in against}
    if len(starts) > 1:
        raise MeasureError(
            "Some of the scans are open at their distal end and others are closed, so their "
            "volumes mean different things. Fill the distal end of all, or leave the odd one out."
        )
    volumes = [change.volume.second for change in against if change.volume is not None]
    tapes = [
        [level.measures["tape_mm"].second if level.measures else None for level in change.levels]
        for change in against
    ]
    notes = [note for limb in limbs for note in limb.notes]
    notes += [note for alignment in alignments for note in alignment.notes]
    notes += [note for limb in limbs[1:] for note in at_odds(first, limb)]
    notes += [axes.note] if axes.note else []
    return Stack(
        axes=axes,
        alignments=alignments,
        heights_mm=np.array(heights),
        from_mm=starts.pop(),
        volumes_mm3=np.array([figure.value for figure in volumes]),
        volume_sigmas_mm3=np.array([_sigma(figure.sigma) for figure in volumes]),
        tapes_mm=np.array([[np.nan if f is None else f.value for f in row] for row in tapes]),
        tape_sigmas_mm=np.array(
            [[np.nan if f is None else _sigma(f.sigma) for f in row] for row in tapes]
        ),
        notes=tuple(dict.fromkeys(notes)),
    )


def _sigma(sigma: float | None) -> float:
    return np.nan if sigma is None else sigma
