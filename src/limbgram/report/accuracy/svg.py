"""SVG charts: plain strings, no script, readable without colour; texts scale with the page."""

import math
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from html import escape
from typing import Any

INK, FAINT, GRID = "#22303a", "#66747d", "#dde4e8"
BLUE, ORANGE, GREEN, AMBER, RED = "#2b6ca3", "#d9822b", "#2f7d4f", "#b8780a", "#b8403a"
SURE_SIGMAS = 2.5
"""Mean residuals nearer to none than this many of their standard errors are drawn faintly."""
_LEFT, _BOTTOM, _TOP, _RIGHT = 46, 40, 12, 12


@dataclass(frozen=True)
class Series:
    """One line of a chart."""

    label: str
    values: Sequence[float]
    colour: str


def chart(width: int, height: int, title: str, body: str) -> str:
    """An SVG that fits its column; `title` is read out to those who cannot see it."""
    return (
        f'<svg viewBox="0 0 {width} {height}" width="{width}" role="img" '
        f'aria-label="{escape(title)}" '
        f'font-size="11" fill="{INK}"><title>{escape(title)}</title>{body}</svg>'
    )


def figure(svg: str, caption: str) -> str:
    """A chart with the sentence that explains it."""
    return f"<figure>{svg}<figcaption>{escape(caption)}</figcaption></figure>"


def histogram(
    edges: Sequence[float], series: Sequence[Series], unit: str, title: str, width: int = 460
) -> str:
    """Counts between edges as stepped outlines, several series over one another."""
    height, top = 220, max((max(one.values, default=0.0) for one in series), default=0.0) or 1.0
    plot = _Plot(width, height, (edges[0], edges[-1]), (0.0, 1.05 * top))
    parts = [plot.frame(unit)]
    for idx, one in enumerate(series):
        points = [(edges[0], 0.0)]
        for low, high, value in zip(edges[:-1], edges[1:], one.values, strict=True):
            points += [(low, value), (high, value)]
        points.append((edges[-1], 0.0))
        path = " ".join(f"{plot.x(x):.1f},{plot.y(y):.1f}" for x, y in points)
        fill = f'fill="{one.colour}" fill-opacity="{0.75 if len(series) == 1 else 0.25}"'
        parts.append(f'<polygon points="{path}" {fill} stroke="{one.colour}"/>')
        if len(series) > 1:
            parts.append(_key(width, idx, one))
    return chart(width, height, title, "".join(parts))


def curve(
    x: Sequence[float], y: Sequence[float], units: tuple[str, str], title: str, width: int = 460
) -> str:
    """Points joined by a line, and the diagonal on which both would be equal."""
    height, reach = 220, 1.08 * max((*x, *y), default=1.0) or 1.0
    plot = _Plot(width, height, (0.0, reach), (0.0, reach))
    path = " ".join(f"{plot.x(a):.1f},{plot.y(b):.1f}" for a, b in zip(x, y, strict=True))
    dots = "".join(
        f'<circle cx="{plot.x(a):.1f}" cy="{plot.y(b):.1f}" r="3.5" fill="{BLUE}"/>'
        for a, b in zip(x, y, strict=True)
    )
    diagonal = (
        f'<line x1="{plot.x(0):.1f}" y1="{plot.y(0):.1f}" x2="{plot.x(reach):.1f}" '
        f'y2="{plot.y(reach):.1f}" stroke="{FAINT}" stroke-dasharray="5 4"/>'
    )
    line = f'<polyline points="{path}" fill="none" stroke="{BLUE}" stroke-width="1.5"/>'
    name = f'<text x="{_LEFT + 6}" y="{_TOP + 12}" fill="{FAINT}">{escape(units[1])}</text>'
    return chart(width, height, title, plot.frame(units[0]) + diagonal + line + dots + name)


def bars(names: Sequence[str], values: Sequence[float], unit: str, title: str) -> str:
    """Horizontal bars, a name and a figure to each."""
    row, left, width = 17, 150, 460
    top = max((value for value in values if math.isfinite(value)), default=0.0) or 1.0
    parts: list[str] = []
    for idx, (name, value) in enumerate(zip(names, values, strict=True)):
        y = 4 + idx * row
        length = (width - left - 70) * max(value, 0.0) / top if math.isfinite(value) else 0.0
        figure = f"{value:.3g} {unit}" if math.isfinite(value) else "not known"
        parts.append(
            f'<text x="{left - 6}" y="{y + 11}" text-anchor="end">{escape(name)}</text>'
            f'<rect x="{left}" y="{y + 1}" width="{length:.1f}" height="{row - 4}" fill="{BLUE}"/>'
            f'<text x="{left + length + 5:.1f}" y="{y + 11}" fill="{FAINT}">{figure}</text>'
        )
    return chart(width, 8 + row * len(names), title, "".join(parts))


def vectors(grid: Any, title: str) -> str:
    """Mean residual of every cell as an arrow, on its RMS as a shade; its scale below."""
    width, rows, columns = 640, grid["rows"], grid["columns"]
    size = (width - 20) / columns
    height = size * rows
    known = [
        math.hypot(x, y)
        for x, y in zip(grid["mean_x_px"], grid["mean_y_px"], strict=True)
        if x is not None
    ]
    longest = max(known, default=0.0) or 1e-9
    roughest = max((one for one in grid["rms_px"] if one is not None), default=0.0) or 1e-9
    stretch = 0.8 * size / longest
    parts = [_ARROW]
    cells = zip(
        grid["mean_x_px"], grid["mean_y_px"], grid["rms_px"], grid["observations"], strict=True
    )
    for idx, (x, y, rms, seen) in enumerate(cells):
        left, top = 10 + size * (idx % columns), size * (idx // columns)
        shade = 0.0 if rms is None else 0.32 * rms / roughest
        parts.append(
            f'<rect x="{left:.1f}" y="{top:.1f}" width="{size:.1f}" height="{size:.1f}" '
            f'fill="{ORANGE}" fill-opacity="{shade:.3f}" stroke="{GRID}"/>'
        )
        if x is not None and rms is not None:
            cx, cy = left + size / 2, top + size / 2
            sure = math.hypot(x, y) > SURE_SIGMAS * rms / math.sqrt(seen)
            parts.append(_arrow(cx, cy, cx + stretch * x, cy + stretch * y, sure=sure))
    y = height + 22
    parts.append(_arrow(14, y, 14 + stretch * longest, y, sure=True))
    parts.append(
        f'<text x="{20 + stretch * longest:.1f}" y="{y + 4:.1f}">{longest:.4f} px mean residual; '
        f"faint: within {SURE_SIGMAS:g} sigmas of none; darkest cell: {roughest:.3f} px RMS</text>"
    )
    return chart(width, round(height + 36), title, "".join(parts))


def matrix(
    names: Sequence[str], rows: Sequence[Sequence[float]], title: str, *, signed: bool
) -> str:
    """A matrix as shaded cells: correlations with figures, or counts as shades alone."""
    size = 40 if signed else max(9, min(24, 560 // max(len(names), 1)))
    left = 54 if signed else 110
    top = max((abs(v) for i, row in enumerate(rows) for j, v in enumerate(row) if i != j),
              default=0.0) or 1.0  # fmt: skip
    parts: list[str] = []
    for i, row in enumerate(rows):
        y = 6 + i * size
        if signed or size >= 9:
            parts.append(
                f'<text x="{left - 5}" y="{y + size / 2 + 4:.1f}" text-anchor="end" '
                f'font-size="{min(11, size)}">{escape(names[i])}</text>'
            )
        for j, value in enumerate(row):
            if signed and j > i:
                continue
            share = min(abs(value) / (1.0 if signed else top), 1.0) if signed or i != j else 0.0
            colour = ORANGE if signed and value < 0 else BLUE
            x = left + j * size
            hint = escape(f"{names[i]}, {names[j]}: {value:.3g}")
            parts.append(
                f'<rect x="{x}" y="{y}" width="{size - 1}" height="{size - 1}" fill="{colour}" '
                f'fill-opacity="{0.04 + 0.8 * share:.3f}"><title>{hint}</title></rect>'
            )
            if signed:
                parts.append(
                    f'<text x="{x + size / 2 - 0.5:.1f}" y="{y + size / 2 + 4:.1f}" '
                    f'text-anchor="middle" fill="{"#fff" if share > 0.6 else INK}">'
                    f"{value:.2f}</text>"
                )
    if signed:
        parts += [
            f'<text x="{left + j * size + size / 2:.1f}" y="{20 + len(names) * size}" '
            f'text-anchor="middle">{escape(name)}</text>'
            for j, name in enumerate(names)
        ]
    return chart(left + size * len(names) + 6, size * len(names) + 30, title, "".join(parts))


@dataclass(frozen=True)
class _Plot:
    width: int
    height: int
    x_range: tuple[float, float]
    y_range: tuple[float, float]

    def x(self, value: float) -> float:
        low, high = self.x_range
        return _LEFT + (self.width - _LEFT - _RIGHT) * (value - low) / (high - low)

    def y(self, value: float) -> float:
        low, high = self.y_range
        return self.height - _BOTTOM - (self.height - _BOTTOM - _TOP) * (value - low) / (high - low)

    def frame(self, unit: str) -> str:
        """Axes with round figures."""
        base = self.y(self.y_range[0])
        parts = [
            f'<line x1="{_LEFT}" x2="{self.width - _RIGHT}" y1="{base}" y2="{base}" '
            f'stroke="{FAINT}"/>'
        ]
        parts += [
            f'<text x="{self.x(tick):.1f}" y="{base + 15:.1f}" text-anchor="middle" '
            f'fill="{FAINT}">{tick:g}</text>'
            for tick in _ticks(*self.x_range)
        ]
        parts += [
            f'<line x1="{_LEFT}" x2="{self.width - _RIGHT}" y1="{self.y(tick):.1f}" '
            f'y2="{self.y(tick):.1f}" stroke="{GRID}"/>'
            f'<text x="{_LEFT - 5}" y="{self.y(tick) + 4:.1f}" text-anchor="end" '
            f'fill="{FAINT}">{tick:g}</text>'
            for tick in _ticks(*self.y_range)
        ]
        middle = (_LEFT + self.width - _RIGHT) / 2
        parts.append(
            f'<text x="{middle}" y="{self.height - 6}" text-anchor="middle">{escape(unit)}</text>'
        )
        return "".join(parts)


def _ticks(low: float, high: float) -> Iterator[float]:
    rough = (high - low) / 5
    power = 10.0 ** math.floor(math.log10(rough)) if rough > 0 else 1.0
    step = next(power * m for m in (1, 2, 5, 10) if power * m >= rough)
    first = math.ceil(low / step - 1e-9)
    for k in range(first, math.floor(high / step + 1e-9) + 1):
        yield round(k * step, 10)


def _key(width: int, idx: int, one: Series) -> str:
    y = _TOP + 10 + 15 * idx
    return (
        f'<rect x="{width - 90}" y="{y - 9}" width="12" height="10" fill="{one.colour}"/>'
        f'<text x="{width - 74}" y="{y}">{escape(one.label)}</text>'
    )


_ARROW = (
    '<defs><marker id="head" viewBox="0 0 8 8" refX="7" refY="4" markerWidth="5" '
    f'markerHeight="5" orient="auto"><path d="M0 0L8 4L0 8z" fill="{BLUE}"/></marker></defs>'
)


def _arrow(x1: float, y1: float, x2: float, y2: float, *, sure: bool) -> str:
    return (
        f'<line x1="{x1:.1f}" y1="{y1:.1f}" x2="{x2:.1f}" y2="{y2:.1f}" stroke="{BLUE}" '
        f'stroke-width="1.5" opacity="{1.0 if sure else 0.3}" marker-end="url(#head)"/>'
    )
