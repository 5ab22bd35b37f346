"""The room: flat panels with textures or prints, and the stand of the limb.

In      a seed, and the boards on the table.
Out     Panels (rectangles with a texture or a printed pattern) and the stand's mesh.
Frame   world: the table's top is z = 0.
"""

from dataclasses import dataclass, field, replace
from itertools import pairwise

import cv2
import numpy as np
from jaxtyping import Float32, Float64, UInt8

from limbgram.core.geometry.arrays import Vector3
from limbgram.core.geometry.frames import Rigid
from limbgram.core.mesh.mesh import Mesh
from limbgram.synthetic.props.board import LaidBoard, PrintedBoard

MARGIN_MM = 15.0


@dataclass(frozen=True)
class Panel:
    """A rectangle that is visible from its front: corner, unit edges, size and picture."""

    origin: Vector3
    right: Vector3
    down: Vector3
    """right x down points INTO the panel, as for a printed page."""
    size_mm: Float64[np.ndarray, "2"]
    picture: UInt8[np.ndarray, "h w 3"] | PrintedBoard
    print_from_panel: Float64[np.ndarray, "4"] = field(
        default_factory=lambda: np.array([0.0, 0.0, 1.0, 1.0])
    )
    """Of a printed board: offset (x, y, mm from the corner of the margin) and scale (x, y) of the
    part of the print that the panel shows."""
    loose: int = 0
    """Number of the movable thing, from 1, of which it is a part; 0: fixed."""


def board_panels(laid: LaidBoard) -> tuple[Panel, ...]:
    """The board with a white margin; a bent one as a flat strip for each column of squares.

    The corners of the strips lie on the arc.
    """
    pose, printed = laid.world_from_board, laid.printed
    width, height = printed.size_mm + 2 * MARGIN_MM
    short = 1.0 / (1.0 + printed.stretch)
    start_y = MARGIN_MM * (1.0 - short)
    if printed.sag_mm == 0:
        margin = pose.rotation @ np.array([MARGIN_MM, MARGIN_MM, 0.0])
        return (
            Panel(
                pose.translation - margin,
                pose.rotation[:, 0],
                pose.rotation[:, 1],
                np.array([width, height]),
                printed,
                np.array([0.0, start_y, 1.0, short]),
            ),
        )
    folds = np.arange(printed.board.squares[0] + 1) * printed.square_mm
    folds = np.concatenate([[-MARGIN_MM], folds, [width - MARGIN_MM]])
    bent = printed.bent_mm(folds)
    strips: list[Panel] = []
    for start, stop, along, beyond in zip(folds, folds[1:], bent, bent[1:], strict=False):
        chord = beyond - along
        wide = float(np.linalg.norm(chord))
        corner = pose.apply(np.array([[along[0], -MARGIN_MM, along[1]]]))[0]
        strips.append(
            Panel(
                corner,
                pose.rotation @ np.array([chord[0], 0.0, chord[1]]) / wide,
                pose.rotation[:, 1],
                np.array([wide, height]),
                printed,
                np.array([start + MARGIN_MM, start_y, (stop - start) / wide, short]),
            )
        )
    return tuple(strips)


def shifted_about(
    panels: tuple[Panel, ...], reach_mm: float, seed: int, photo_idx: int
) -> tuple[Panel, ...]:
    """The room with its movable things shifted for one photo.

    Each slides by up to `reach_mm` in x and y, and turns about its corner by up to a degree for
    every 5 mm of that.
    """
    moved: list[Panel] = []
    for panel in panels:
        if not panel.loose:
            moved.append(panel)
            continue
        rng = np.random.default_rng((seed, 32, photo_idx, panel.loose))
        x, y, turn = rng.uniform(-reach_mm, reach_mm, 3)
        about = next(one.origin for one in panels if one.loose == panel.loose)
        spin = Rigid.from_rotation_vector(np.array([0.0, 0.0, np.radians(turn / 5.0)]), np.zeros(3))
        shift = about + np.array([x, y, 0.0]) - spin.apply(about[None])[0]
        moved.append(moved_panel(panel, Rigid(spin.rotation, shift)))
    return tuple(moved)


def moved_panel(panel: Panel, motion: Rigid) -> Panel:
    """The panel after a motion in the room."""
    return replace(
        panel,
        origin=motion.apply(panel.origin[None])[0],
        right=motion.rotation @ panel.right,
        down=motion.rotation @ panel.down,
    )


def make_room(seed: int, *, under_stand: bool) -> tuple[Panel, ...]:
    """Table, floor, walls with posters, and papers and boxes on the table."""
    rng = np.random.default_rng((seed, 8))
    turn = rng.uniform(0, 2 * np.pi)
    table = _grain(rng, (700, 1000), (3, 60), (150, 122, 96), 16)
    if under_stand:
        table = _shaded(table, np.array([500.0, 350.0]), 90.0)
    panels = [
        _flat(np.zeros(2), turn, (1500, 1050), 0.0, table),
        _flat(
            np.zeros(2),
            0.0,
            (6000, 6000),
            -720.0,
            _grain(rng, (750, 750), (9, 9), (70, 66, 62), 12),
        ),
    ]
    for side in range(4):
        panels.append(
            _upright(
                side,
                0.0,
                840.0,
                (6000, 3120),
                3000.0,
                _grain(rng, (300, 500), (40, 40), (104, 104, 102), 5),
            )
        )
        for at in (-900.0, 700.0):
            size = rng.uniform(600, 1100, 2)
            middle = at + rng.uniform(-200, 200), rng.uniform(-200, 500)
            poster = _upright(side, *middle, (size[0], size[1]), 2980.0, _poster(rng, size))
            panels.append(_loosened(poster, panels))
    for k in range(4):
        around = turn + 0.4 + k * np.pi / 2 + rng.uniform(-0.3, 0.3)
        place = rng.uniform(330, 400) * np.array([np.cos(around), np.sin(around)])
        leaflet = _flat(
            place,
            rng.uniform(0, 6.28),
            (148, 105),
            0.4 + 0.1 * k,
            _poster(rng, np.array([148, 105])),
        )
        panels.append(_loosened(leaflet, panels))
        around += 0.7
        place = rng.uniform(370, 440) * np.array([np.cos(around), np.sin(around)])
        top, *sides = _box(rng, place)
        panels.append(_loosened(top, panels))
        panels += [replace(one, loose=panels[-1].loose) for one in sides]
    return tuple(panels)


def _loosened(panel: Panel, others: list[Panel]) -> Panel:
    """The panel as a movable thing of its own."""
    return replace(panel, loose=1 + max(one.loose for one in others))


def make_screens(
    seed: int, camera: Vector3, distance_mm: float, behind: bool, before: bool
) -> tuple[Panel, ...]:
    """Patterned screens that face a camera: one behind the limb, and a strip on each side."""
    rng = np.random.default_rng((seed, 15))
    level = np.array([camera[0], camera[1], 0.0])
    inward = -level / np.linalg.norm(level)
    panels: list[Panel] = []
    if behind:
        size = np.array([1100.0, 700.0])
        panels.append(_facing(420.0 * inward, inward, 0.0, size, _cloth(rng, size)))
    if before:
        near = 0.3 * distance_mm
        for side in (-1.0, 1.0):
            size = np.array([110.0, 260.0])
            along = side * (80.0 + 0.5 * size[0])
            base = camera[2] * near / float(np.linalg.norm(level))
            panel = _facing(-near * inward, inward, along, size, _cloth(rng, size))
            panels.append(moved_panel(panel, Rigid(np.eye(3), np.array([0.0, 0.0, 0.5 * base]))))
    return tuple(panels)


def _cloth(rng: np.random.Generator, size_mm: np.ndarray) -> UInt8[np.ndarray, "h w 3"]:
    """A dense pattern of shapes of about a centimetre."""
    share = 10.0 / float(size_mm.min())
    count = int(size_mm.prod() / 500.0)
    return _poster(rng, size_mm, count, (0.4 * share, 1.5 * share), 2200.0)


def _facing(
    middle: np.ndarray, inward: np.ndarray, along: float, size: np.ndarray, picture: np.ndarray
) -> Panel:
    """An upright panel on the table that faces opposite to `inward`."""
    down = np.array([0.0, 0.0, -1.0])
    right = np.cross(down, inward)
    corner = middle + (along - 0.5 * size[0]) * right - size[1] * down
    return Panel(corner, right, down, size, picture)


def make_stand(base_mm: float) -> Mesh:
    """A disc and a thin pole that ends a millimetre under the limb."""
    corners = np.array(
        [(0, 0), (60, 0), (60, 11), (14, 11), (14, base_mm - 1), (0, base_mm - 1)], float
    )
    rings = []
    for start, stop in pairwise(corners):
        steps = int(np.ceil(np.linalg.norm(stop - start) / 6)) + 1
        rings.append(start + np.linspace(0, 1, steps)[:, None] * (stop - start))
    profile = np.concatenate(rings)
    columns = 96
    angle = 2 * np.pi * np.arange(columns) / columns
    around = np.stack([np.cos(angle), np.sin(angle)], -1)
    flat = profile[:, None, :1] * around
    height = np.broadcast_to(profile[:, 1, None, None], (len(profile), columns, 1))
    vertices = np.concatenate([flat, height], -1).reshape(-1, 3)
    ids = np.arange(len(vertices)).reshape(len(profile), columns)
    ids = np.concatenate([ids, ids[:, :1]], 1)
    a, b, c, d = ids[:-1, :-1], ids[:-1, 1:], ids[1:, 1:], ids[1:, :-1]
    faces = np.concatenate([np.stack([a, b, c], -1), np.stack([a, c, d], -1)]).reshape(-1, 3)
    return Mesh(vertices_mm=vertices, faces=faces.astype(np.int32))


def _flat(
    middle: np.ndarray, turn: float, size: tuple[float, float], z: float, picture: np.ndarray
) -> Panel:
    right = np.array([np.cos(turn), np.sin(turn), 0.0])
    down = np.array([right[1], -right[0], 0.0])
    origin = np.array([*middle, z]) - 0.5 * size[0] * right - 0.5 * size[1] * down
    return Panel(origin, right, down, np.array(size, float), picture)


def _upright(
    side: int,
    along: float,
    height: float,
    size: tuple[float, float],
    away: float,
    picture: np.ndarray,
) -> Panel:
    """A panel on wall `side` that faces the middle of the room."""
    inward = np.array([(1, 0), (0, 1), (-1, 0), (0, -1)][side], float)
    right = np.array([-inward[1], inward[0], 0.0])
    down = np.array([0.0, 0.0, -1.0])
    middle = np.array([*(-inward * away), height]) + along * right
    return Panel(
        middle - 0.5 * size[0] * right - 0.5 * size[1] * down,
        right,
        down,
        np.array(size, float),
        picture,
    )


def _box(rng: np.random.Generator, place: np.ndarray) -> list[Panel]:
    """A cuboid on the table: its top and four sides."""
    turn, tall = rng.uniform(0, 6.28), rng.uniform(35, 75)
    wide, deep = rng.uniform(45, 80, 2)
    panels = [_flat(place, turn, (wide, deep), tall, _poster(rng, np.array([wide, deep])))]
    side, back = panels[0].right, -panels[0].down
    down = np.array([0.0, 0.0, -1.0])
    for outward, width, reach in (
        (side, deep, wide),
        (-side, deep, wide),
        (back, wide, deep),
        (-back, wide, deep),
    ):
        across = np.array([-outward[1], outward[0], 0.0])
        origin = np.array([*place, tall]) + 0.5 * reach * outward - 0.5 * width * across
        size = np.array([width, tall])
        panels.append(Panel(origin, across, down, size, _poster(rng, size)))
    return panels


def _grain(
    rng: np.random.Generator,
    shape: tuple[int, int],
    grain: tuple[int, int],
    colour: tuple[int, int, int],
    depth: float,
) -> UInt8[np.ndarray, "h w 3"]:
    """Wood, carpet or plaster: noise in octaves, stretched to `grain` texels down and across."""
    total = np.zeros(shape, np.float32)
    for octave in range(5):
        small = (
            max(4, round(shape[1] * 2**octave / (grain[1] * 8))),
            max(4, round(shape[0] * 2**octave / (grain[0] * 8))),
        )
        small = min(small[0], shape[1]), min(small[1], shape[0])
        noise = rng.normal(size=small[::-1]).astype(np.float32)
        total += cv2.resize(noise, shape[::-1], interpolation=cv2.INTER_CUBIC) * 0.8**octave
    total *= depth / total.std()
    picture = np.array(colour, np.float32) + total[..., None]
    return np.clip(picture, 6, 245).astype(np.uint8)


def _shaded(
    picture: UInt8[np.ndarray, "h w 3"], middle_texel: np.ndarray, reach_texels: float
) -> UInt8[np.ndarray, "h w 3"]:
    """The picture darkened round a texel, as under the limb."""
    y, x = np.indices(picture.shape[:2], dtype=np.float32)
    away2 = (x - middle_texel[0]) ** 2 + (y - middle_texel[1]) ** 2
    light: Float32[np.ndarray, "h w"] = 1 - 0.4 * np.exp(-away2 / (2 * reach_texels**2))
    return (picture * light[..., None]).astype(np.uint8)


def _poster(
    rng: np.random.Generator,
    size_mm: np.ndarray,
    shapes: int = 28,
    reaches: tuple[float, float] = (0.03, 0.16),
    longest_px: float = 600.0,
) -> UInt8[np.ndarray, "h w 3"]:
    """A poster or leaflet: random shapes and words on a background.

    `reaches` are the sizes of shapes, as shares of its shorter side.
    """
    per_mm = min(3.0, longest_px / size_mm.max())
    height, width = int(size_mm[1] * per_mm) + 1, int(size_mm[0] * per_mm) + 1
    ground = rng.integers(90, 225, 3).tolist()
    picture = np.full((height, width, 3), ground, np.uint8)
    span = min(width, height)
    for _ in range(shapes):
        colour = rng.integers(20, 235, 3).tolist()
        at = int(rng.integers(0, width)), int(rng.integers(0, height))
        reach = int(rng.uniform(*reaches) * span) + 1
        thick = int(rng.choice([-1, -1, max(1, reach // 5)]))
        match int(rng.integers(0, 4)):
            case 0:
                cv2.circle(picture, at, reach, colour, thick, cv2.LINE_AA)
            case 1:
                cv2.rectangle(picture, at, (at[0] + 2 * reach, at[1] + reach), colour, thick)
            case 2:
                axes = (reach, reach // 2 + 1)
                cv2.ellipse(picture, at, axes, float(rng.uniform(0, 180)), 0, 360, colour, thick)
            case _:
                word = "".join(rng.choice(list("AEHKLMNORSTX"), 4))
                font, wide = cv2.FONT_HERSHEY_DUPLEX, max(1, reach // 12)
                cv2.putText(picture, word, at, font, reach / 24, colour, wide, cv2.LINE_AA)
    return cv2.GaussianBlur(picture, (0, 0), 0.6)
