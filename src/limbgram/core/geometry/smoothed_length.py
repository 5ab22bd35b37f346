"""Smoothed length: how long a line over a limb is, which has no answer until its scale is stated.

Into ever finer folds a line gets ever longer: round a knitted sock a contour is 1 to 2 mm longer
than over what it is knitted on, and no photo at arm's length shows the knit. A taut tape rests on
the knit's tops, which no photo shows either; a real one is 6 to 15 mm wide and presses them down.
Contours, tapes and ways over the surface are therefore measured on the line at a smoothing length
of 5 mm, here, and nowhere else. No source of the trade states one.

In      a closed or open polyline.
Out     the length of the line once it is smoothed, or of a tape drawn taut round it, and how it
        changes with each point of the given line.
Method  the line is taken at even steps along itself, and each coordinate goes through the spline
        filter 1 / (1 + (k l)^4), l = smoothing length / 2 pi: half of a wave of 5 mm stays, 94 % of
        one of 10 mm, 2.5 % of one of 2 mm, and a circle of 10 mm in radius keeps its length to
        0.0001. An open line is turned about its ends, which stay. The tape is the convex hull of
        the smoothed line. Slopes are exact, by reverse differentiation of every step, the way along
        the line too.
"""

import math
from dataclasses import dataclass
from functools import cached_property

import numpy as np
from jaxtyping import Float64, Int64
from numpy.fft import irfft, rfft
from scipy.fft import dst

from limbgram.core.geometry.arrays import Points2
from limbgram.core.geometry.hull import around

SMOOTHING_MM = 5.0
"""Wave length of which half the height stays."""
PLATE_MM = SMOOTHING_MM / (2 * math.pi)
"""Length of the plate that smooths so: l in 1 / (1 + (k l)^4)."""
SMOOTHED_OVER = f"smoothed over {SMOOTHING_MM:g} mm"
"""What stands beside every such length."""
STEPS_PER_MM = 32 / SMOOTHING_MM
"""Even steps on a line: a right angle is cut by 0.002 mm more than the filter cuts it."""
_FEWEST = 32


@dataclass(frozen=True)
class SmoothedLength:
    """Length of a line at the smoothing length; its parts are computed where they are asked for."""

    value_mm: float
    _line: "_Line"
    _opened: Float64[np.ndarray, "m d"]
    _passed: Int64[np.ndarray, " p"]
    """From each smoothed point that is passed straight to one onward."""
    _onward: Int64[np.ndarray, " p"]
    _ways: Float64[np.ndarray, "p d"]
    _lengths: Float64[np.ndarray, " p"]

    @classmethod
    def of(
        cls, line: "_Line", filtered: "_Filtered", passed: Int64[np.ndarray, " p"]
    ) -> "SmoothedLength":
        """Of the straight pieces that join the smoothed points that are passed."""
        smooth, opened = filtered
        onward = np.roll(passed, -1)
        if not line.closed:
            passed, onward = passed[:-1], onward[:-1]
        ways = smooth[onward] - smooth[passed]
        lengths = np.linalg.norm(ways, axis=1)
        return cls(float(lengths.sum()), line, opened, passed, onward, ways, lengths)

    @cached_property
    def slopes(self) -> Float64[np.ndarray, "n d"]:
        """Change of it for a millimetre of each given point."""
        along = self._ways / np.maximum(self._lengths, np.finfo(float).tiny)[:, None]
        pulls = np.zeros_like(self._opened)
        pulls[self._passed] -= along
        pulls[self._onward] += along
        by_length = float((pulls * self._opened).sum())
        return self._line.given(_pulled(self._line, pulls), by_length)

    @cached_property
    def along_mm(self) -> Float64[np.ndarray, " n"]:
        """What of it lies along the smoothed line, by the given point; of a tape, the rest is
        bridges over hollows."""
        touching = np.zeros(len(self._opened))
        on_line = (self._passed + 1 - self._onward) % len(touching) == 0
        touching[self._passed] += np.where(on_line, self._lengths / 2, 0.0)
        touching[self._onward] += np.where(on_line, self._lengths / 2, 0.0)
        return self._line.shared(touching)


def smoothed(points_mm: Float64[np.ndarray, "n d"], *, closed: bool) -> Float64[np.ndarray, "m d"]:
    """A polyline at even steps, smoothed; a closed one does not repeat its first point."""
    line = _Line.along(points_mm, closed)
    return _filtered(line, line.points_mm)[0]


def smoothed_length(points_mm: Float64[np.ndarray, "n d"], *, closed: bool) -> SmoothedLength:
    """How long a polyline is once it is smoothed."""
    line = _Line.along(points_mm, closed)
    return SmoothedLength.of(line, _filtered(line, line.points_mm), np.arange(len(line.points_mm)))


def taut_length(points_mm: Points2) -> SmoothedLength:
    """What a tape drawn taut round a closed outline reads, once the outline is smoothed.

    Raises:
        QhullError: the outline has no inside.
    """
    line = _Line.along(points_mm, closed=True)
    filtered = _filtered(line, line.points_mm)
    return SmoothedLength.of(line, filtered, around(filtered[0]))


@dataclass(frozen=True)
class _Line:
    """A polyline at even steps along itself."""

    steps_mm: Float64[np.ndarray, "k d"]
    """From each given point to the next."""
    lengths_mm: Float64[np.ndarray, " k"]
    closed: bool
    piece: Int64[np.ndarray, " m"]
    """On which piece each even step lies, and how far along it."""
    share: Float64[np.ndarray, " m"]
    part: Float64[np.ndarray, " m"]
    """Of the whole line's length up to there."""
    points_mm: Float64[np.ndarray, "m d"]

    @classmethod
    def along(cls, points_mm: Float64[np.ndarray, "n d"], closed: bool) -> "_Line":
        steps = np.roll(points_mm, -1, axis=0) - points_mm if closed else np.diff(points_mm, axis=0)
        lengths = np.maximum(np.linalg.norm(steps, axis=1), np.finfo(float).tiny)
        walked = np.concatenate([[0.0], np.cumsum(lengths)])
        count = max(_FEWEST, math.ceil(walked[-1] * STEPS_PER_MM))
        part = np.arange(count if closed else count + 1) / count
        piece = np.searchsorted(walked, part * walked[-1], side="right") - 1
        piece = np.clip(piece, 0, len(lengths) - 1)
        share = np.clip((part * walked[-1] - walked[piece]) / lengths[piece], 0.0, 1.0)
        found = points_mm[piece] + share[:, None] * steps[piece]
        return cls(steps, lengths, closed, piece, share, part, found)

    def given(
        self, pulls: Float64[np.ndarray, "m d"], by_length: float
    ) -> Float64[np.ndarray, "n d"]:
        """Slopes at the given points from those at the even steps, and for the line's length.

        A given point takes the even steps on its pieces along, and shifts all those behind it.
        """
        count = len(self.lengths_mm)
        ways = self.steps_mm / self.lengths_mm[:, None]
        shifts = (pulls * ways[self.piece]).sum(1)
        on_piece = np.bincount(self.piece, shifts, count)
        behind = np.cumsum(on_piece[::-1])[::-1] - on_piece
        longer = by_length + shifts @ self.part - behind
        longer -= np.bincount(self.piece, shifts * self.share, count)
        slopes = np.column_stack([self.shared(pull) for pull in pulls.T])
        after = (np.arange(count) + 1) % len(slopes)
        slopes[after] += longer[:, None] * ways
        slopes[:count] -= longer[:, None] * ways
        return slopes

    def shared(self, of_steps: Float64[np.ndarray, " m"]) -> Float64[np.ndarray, " n"]:
        """What belongs to the even steps, shared among the given points by their nearness."""
        count = len(self.lengths_mm) + (not self.closed)
        after = (self.piece + 1) % count
        found = np.bincount(self.piece, (1 - self.share) * of_steps, count)
        return found + np.bincount(after, self.share * of_steps, count)


_Filtered = tuple[Float64[np.ndarray, "m d"], Float64[np.ndarray, "m d"]]
"""The smoothed points, and their change for a millimetre more of the line's length alone."""


def _filtered(line: _Line, points_mm: Float64[np.ndarray, "m d"]) -> _Filtered:
    """The line's points smoothed."""
    stays, opens = _transfer(line)
    if line.closed:
        waves = rfft(points_mm, axis=0)
        smooth, opened = (
            irfft(waves * part[:, None], len(points_mm), axis=0) for part in (stays, opens)
        )
        return smooth, opened
    chord = _chord(line, points_mm)
    waves = _sines((points_mm - chord)[1:-1])
    smooth, opened = chord.copy(), np.zeros_like(chord)
    smooth[1:-1] += _sines(waves * stays[:, None])
    opened[1:-1] = _sines(waves * opens[:, None])
    return smooth, opened


def _pulled(line: _Line, pulls: Float64[np.ndarray, "m d"]) -> Float64[np.ndarray, "m d"]:
    """Slopes at the points from those at the smoothed points: the filter is its own transpose."""
    stays, _ = _transfer(line)
    if line.closed:
        return irfft(rfft(pulls, axis=0) * stays[:, None], len(pulls), axis=0)
    inner = np.zeros_like(pulls)
    inner[1:-1] = _sines(_sines(pulls[1:-1]) * stays[:, None])
    of_chord = pulls - inner
    inner[0] = ((1 - line.part)[:, None] * of_chord).sum(0)
    inner[-1] = (line.part[:, None] * of_chord).sum(0)
    return inner


def _transfer(line: _Line) -> tuple[Float64[np.ndarray, " w"], Float64[np.ndarray, " w"]]:
    """What stays of each wave, and its change for a millimetre more of the line."""
    whole = float(line.lengths_mm.sum())
    count = len(line.part)
    waves = np.arange(count // 2 + 1) if line.closed else np.arange(1, count - 1) / 2
    steep = (2 * math.pi * waves * PLATE_MM / whole) ** 4
    return 1 / (1 + steep), 4 * steep / whole / (1 + steep) ** 2


def _chord(line: _Line, points_mm: Float64[np.ndarray, "m d"]) -> Float64[np.ndarray, "m d"]:
    """Straight from the first point to the last."""
    return points_mm[0] + line.part[:, None] * (points_mm[-1] - points_mm[0])


def _sines(values: Float64[np.ndarray, "m d"]) -> Float64[np.ndarray, "m d"]:
    """To waves that are still at both ends, and back again: its own inverse."""
    return np.asarray(dst(values, type=1, axis=0, norm="ortho"))
