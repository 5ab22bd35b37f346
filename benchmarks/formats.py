"""Formats: our readers and writers against those of trimesh and ezdxf, on the same files.

    python benchmarks/formats.py -o benchmarks/results/formats.json

writes formats.json. Three things are compared:

- a sphere of 250,000 triangles: seconds, memory above what the process had, and whether the
  triangles (of readers) or the bytes (of writers) are equal. Each run is a process of its own;
  ours includes reading the written file back and comparing it.
- damaged files, the mutants of `mutants.py`: how many are refused, how many are read as another
  shape without a word, and how many take too long or too much memory.
- what a reader gives of a file that holds more than triangles.
"""

import io
import multiprocessing
import os
import resource
import signal
import tempfile
import time
import warnings
from collections import Counter
from collections.abc import Callable
from pathlib import Path
from types import FrameType
from typing import Any

import ezdxf
import numpy as np
import trimesh
from ezdxf.addons.r12writer import r12writer
from trimesh.exchange.gltf import export_glb
from trimesh.exchange.stl import export_stl, export_stl_ascii

from harness import asking, found_before, machine, made_on, write
from limbgram.core.errors import LimbgramError
from limbgram.core.mesh.mesh import Mesh
from limbgram.findings import told
from limbgram.formats.dxf_r12 import write_polyface_dxf, write_r12_dxf
from limbgram.formats.glb import read_glb, write_glb
from limbgram.formats.obj import read_obj, write_obj
from limbgram.formats.ply import read_ply, write_ply
from limbgram.formats.reading import read_limb
from limbgram.formats.stl import read_stl, write_stl
from mutants import mutant, readers

ROUND, RINGS = 500, 251
"""Of the sphere: 250,000 triangles."""
LIMIT_S, LIMIT_BYTES = 5.0, 6 << 30
"""Of the processor's time, and of memory, for a damaged file."""
REPEATS, LONG_S = 3, 20.0
"""How often each is run, unless it takes so long."""
DAMAGED = ("stl-binary", "stl-text", "obj", "ply-binary", "ply-polygons", "ply-text", "glb")
Triangles = np.ndarray


def ball() -> Mesh:
    """A closed sphere of 100 mm, with all that a vertex can have."""
    tilt = np.linspace(0, np.pi, RINGS + 1)[1:-1]
    turn = 2 * np.pi * np.arange(ROUND) / ROUND
    rings = np.stack(
        [np.outer(np.sin(tilt), np.cos(turn)), np.outer(np.sin(tilt), np.sin(turn))], axis=-1
    )
    heights = np.broadcast_to(np.cos(tilt)[:, None, None], (*rings.shape[:2], 1))
    places = np.concatenate([rings, heights], axis=-1).reshape(-1, 3)
    places = 100 * np.concatenate([places, [[0, 0, 1], [0, 0, -1]]])
    here = np.arange(ROUND)
    after = (here + 1) % ROUND
    faces = [
        np.column_stack([np.full(ROUND, len(places) - 2), here, after]),
        np.column_stack(
            [np.full(ROUND, len(places) - 1), (RINGS - 2) * ROUND + after,
             (RINGS - 2) * ROUND + here]
        ),
    ]  # fmt: skip
    for ring in range(RINGS - 2):
        low, high = (ring + 1) * ROUND, ring * ROUND
        faces += [
            np.column_stack([high + here, low + here, low + after]),
            np.column_stack([high + here, low + after, high + after]),
        ]
    rng = np.random.default_rng(3)
    count = len(places)
    return Mesh(
        vertices_mm=places,
        faces=np.concatenate(faces).astype(np.int32),
        colours=rng.integers(0, 256, (count, 3), np.uint8),
        sigma_mm=rng.uniform(0.01, 0.2, count).astype(np.float32),
    )


def _surface(mesh: Mesh) -> trimesh.Trimesh:
    return trimesh.Trimesh(mesh.vertices_mm, mesh.faces, vertex_colors=mesh.colours, process=False)


# How each reads, to triangles in the file's own order.


def _ours(read: Callable[[bytes, str], Any]) -> Callable[[Path], Triangles]:
    def reading(path: Path) -> Triangles:
        mesh = read(path.read_bytes(), path.name).mesh
        return mesh.vertices_mm[mesh.faces]

    return reading


def _theirs(path: Path) -> Triangles:
    read = trimesh.load_mesh(path, process=False)
    return np.asarray(read.vertices, np.float64)[np.asarray(read.faces)]


def _their_scene(path: Path) -> Triangles:
    read = trimesh.load_scene(path, process=False).to_mesh()
    upright = np.asarray(read.vertices, np.float64) @ [[1.0, 0, 0], [0, 0, 1], [0, -1, 0]]
    return upright[np.asarray(read.faces)]


def _their_shape(path: Path) -> tuple[Triangles, tuple[str, ...]]:
    return (_their_scene(path) * 1000 if path.suffix == ".glb" else _theirs(path)), ()


READERS: dict[str, tuple[Callable[[Path], Triangles], Callable[[Path], Triangles]]] = {
    "ball.stl": (_ours(read_stl), _theirs),
    "text.stl": (_ours(read_stl), _theirs),
    "ball.obj": (_ours(read_obj), _theirs),
    "ball.ply": (_ours(read_ply), _theirs),
    "text.ply": (_ours(read_ply), _theirs),
    "ball.glb": (_ours(read_glb), _their_scene),
}


# How each writes.


def _r12_faces(mesh: Mesh, path: Path) -> None:
    with r12writer(path) as drawing:
        for corners in mesh.vertices_mm[mesh.faces].tolist():
            drawing.add_3dface(corners, layer="SURFACE_MM")


def _r12_polyface(mesh: Mesh, path: Path) -> None:
    with r12writer(path) as drawing:
        drawing.add_polyface(mesh.vertices_mm.tolist(), mesh.faces.tolist(), layer="SURFACE_MM")


def _glb(mesh: Mesh, path: Path) -> None:
    path.write_bytes(export_glb(trimesh.Scene([_surface(mesh)])))


Write = Callable[[Mesh, Path], object]
WRITERS: dict[str, tuple[Write, Write]] = {
    "stl": (
        lambda mesh, path: write_stl(mesh, path, "mm"),
        lambda mesh, path: path.write_bytes(export_stl(_surface(mesh))),
    ),
    "ply": (
        lambda mesh, path: write_ply(mesh, path, "mm"),
        lambda mesh, path: _surface(mesh).export(path),
    ),
    "obj": (
        lambda mesh, path: write_obj(mesh, path, "mm"),
        lambda mesh, path: _surface(mesh).export(path, digits=6),
    ),
    "glb": (lambda mesh, path: write_glb(mesh, path, "mm"), _glb),
    "dxf": (lambda mesh, path: write_r12_dxf(mesh, path, "mm", spacing_mm=1000), _r12_faces),
    "dxf polyface": (
        lambda mesh, path: write_polyface_dxf(mesh, path, spacing_mm=1000),
        _r12_polyface,
    ),
}


# Seconds and memory, in a process each.


def _peak() -> int:
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _run(work: Callable[[], object], warm: Callable[[], object]) -> dict[str, Any]:
    warm()  # imports, and kernels compiled
    before, times = _peak(), []
    try:
        for _ in range(REPEATS):
            began = time.process_time()
            work()
            times.append(time.process_time() - began)
            if sum(times) > LONG_S:
                break
    except (ValueError, TypeError, LimbgramError) as refusal:
        return {"refused": f"{type(refusal).__name__}: {refusal}"[:120]}
    return {"seconds": round(min(times), 3), "memory_mb": (_peak() - before) >> 20}


def _reading(name: str, who: int, folder: Path) -> dict[str, Any]:
    read = READERS[name][who]
    return _run(lambda: read(folder / name), lambda: read(folder / f"small-{name}"))


def _writing(name: str, who: int, folder: Path) -> dict[str, Any]:
    write, path = WRITERS[name][who], folder / f"written-{who}.{name[:3]}"
    mesh = ball()
    small = Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces[:4])
    return _run(lambda: write(mesh, path), lambda: write(small, path))


def _alone(work: Callable[..., dict[str, Any]], *arguments: Any) -> dict[str, Any]:
    pool = multiprocessing.get_context("fork").Pool(1)
    found = pool.apply(work, arguments)
    pool.close()
    pool.join()
    return found


def speed(folder: Path) -> dict[str, Any]:
    """Every reader and writer on the large sphere."""
    mesh = ball()
    small = Mesh(vertices_mm=mesh.vertices_mm, faces=mesh.faces[:4])
    for begin, one in (("", mesh), ("small-", small)):
        write_stl(one, folder / f"{begin}ball.stl", "mm")
        write_ply(one, folder / f"{begin}ball.ply", "mm")
        write_obj(one, folder / f"{begin}ball.obj", "mm")
        write_glb(one, folder / f"{begin}ball.glb", "mm")
        surface = _surface(one)
        (folder / f"{begin}text.stl").write_text(export_stl_ascii(surface))
        surface.export(folder / f"{begin}text.ply", encoding="ascii")
    found: dict[str, Any] = {"read": {}, "written": {}}
    for name, (ours, theirs) in READERS.items():
        pair = [_alone(_reading, name, who, folder) for who in (0, 1)]
        apart = np.abs(ours(folder / name) - theirs(folder / name)).max()
        found["read"][name] = {"ours": pair[0], "theirs": pair[1], "largest_apart": float(apart)}
    for name in WRITERS:
        pair = [_alone(_writing, name, who, folder) for who in (0, 1)]
        files = [folder / f"written-{who}.{name[:3]}" for who in (0, 1)]
        same = all(file.exists() for file in files)
        same = same and files[0].read_bytes() == files[1].read_bytes()
        found["written"][name] = {"ours": pair[0], "theirs": pair[1], "same_bytes": same}
        for file in files:
            file.unlink(missing_ok=True)
    return found


# Damaged files.


def _shape_of(triangles: Triangles) -> bytes:
    """The same for the same triangles in any order, to a thousandth of a unit."""
    rounded = np.round(triangles.reshape(-1, 9), 3) + 0.0
    return rounded[np.lexsort(rounded.T)].tobytes()


def _our_shape(path: Path) -> tuple[Triangles, tuple[str, ...]]:
    limb = read_limb(path)
    return limb.mesh.vertices_mm[limb.mesh.faces], tuple(map(told, limb.notes))


class _TooLong(BaseException):
    pass


def _too_long(_signal: int, _frame: FrameType | None) -> None:
    raise _TooLong


def damaged(name: str, who: int, count: int, seed: int) -> dict[str, Any]:
    """What becomes of damaged files of one kind."""
    warnings.simplefilter("ignore")
    os.dup2(os.open(os.devnull, os.O_WRONLY), 2)
    resource.setrlimit(resource.RLIMIT_AS, (LIMIT_BYTES, LIMIT_BYTES))
    signal.signal(signal.SIGPROF, _too_long)
    reader, read = readers()[name], (_our_shape, _their_shape)[who]
    found: Counter[str] = Counter()
    kinds: Counter[str] = Counter()
    with tempfile.TemporaryDirectory() as place:
        path = Path(place, f"scan{reader.ending}")
        path.write_bytes(reader.whole)
        try:
            triangles, usual = read(path)
        except Exception as error:  # a library promises no kind of error
            return {"kinds": {f"the whole file is refused: {error}": 1}}
        whole = _shape_of(triangles)
        for idx in range(count):
            path.write_bytes(mutant(reader, seed, idx))
            signal.setitimer(signal.ITIMER_PROF, LIMIT_S)
            try:
                triangles, notes = read(path)
                same = _shape_of(triangles) == whole
                noted = notes != usual
                kind = "the same shape" if same else "with a note" if noted else "another shape"
                kind = kind if len(triangles) else "no triangle"
                found[f"read, {kind}"] += 1
            except LimbgramError:
                found["refused"] += 1
            except _TooLong:
                found["too long"] += 1
            except MemoryError:
                found["too much memory"] += 1
            except Exception as error:  # a library promises no kind of error
                found["raised"] += 1
                kinds[type(error).__name__] += 1
            finally:
                signal.setitimer(signal.ITIMER_PROF, 0)
    return {**found, "kinds": dict(kinds.most_common())}


# What else is in a file.


def kept(folder: Path) -> dict[str, dict[str, list[bool]]]:
    """What our reader, then trimesh, gives of files that hold more than triangles."""
    mesh = ball()
    corners = _write_kept(mesh, folder)
    our_ply, our_glb = (
        read((folder / name).read_bytes(), name)
        for read, name in ((read_ply, "all.ply"), (read_glb, "all.glb"))
    )
    obj_ours = read_obj((folder / "quad.obj").read_bytes(), "quad.obj").mesh
    ply_ours = read_ply((folder / "quad.ply").read_bytes(), "quad.ply").mesh
    ply, obj, quads = (
        trimesh.load_mesh(folder / name, process=False)
        for name in ("all.ply", "quad.obj", "quad.ply")
    )
    (glb,) = trimesh.load_scene(folder / "all.glb", process=False).geometry.values()

    sigma, colours = mesh.sigma_mm, mesh.colours
    assert sigma is not None
    assert colours is not None
    raw = ply.metadata["_ply_raw"]["vertex"]["data"]
    metres = (sigma * 0.001).astype(np.float32)
    obj_colours = np.tile(np.array([255, 0, 128], np.uint8), (4, 1))
    return {
        "ply": {
            "colours": [
                _has(our_ply.mesh.colours, colours),
                _has(ply.visual.vertex_colors[:, :3], colours),
            ],
            "sigma": [_has(our_ply.mesh.sigma_mm, sigma), _has(raw["scalar_sigma"], sigma)],
            "unit": [our_ply.stated_unit == "mm", "mm" in str(ply.units)],
            "double precision": [
                _has(ply_ours.vertices_mm, corners),
                _has(quads.vertices, corners),
            ],
            "quads": [len(ply_ours.faces) == 2, len(quads.faces) == 2],
        },
        "obj": {
            "colours": [
                _has(obj_ours.colours, obj_colours),
                _has(obj.visual.vertex_colors[:, :3], obj_colours),
            ],
            "double precision": [
                _has(obj_ours.vertices_mm, corners),
                _has(obj.vertices, corners),
            ],
            "quads": [len(obj_ours.faces) == 2, len(obj.faces) == 2],
        },
        "glb": {
            "colours": [
                _has(our_glb.mesh.colours, colours),
                _has(glb.visual.vertex_colors[:, :3], colours),
            ],
            "sigma": [
                _has(our_glb.mesh.sigma_mm, metres),
                _has(glb.vertex_attributes.get("_SIGMA"), metres),
            ],
            "unit": [our_glb.stated_unit == "m", glb.units == "m"],
        },
    }


def _has(held: Any, wanted: np.ndarray) -> bool:
    return held is not None and np.array_equal(np.asarray(held).reshape(wanted.shape), wanted)


def _write_kept(mesh: Mesh, folder: Path) -> np.ndarray:
    """Write the mesh, and one face of four corners, double precise; the corners."""
    write_ply(mesh, folder / "all.ply", "mm")
    write_glb(mesh, folder / "all.glb", "mm")
    corners = np.array([[0, 0, 0], [100, 0, 0], [100, 100, 0], [0, 100, 1e-7]]) + 1000
    lines = [f"v {' '.join(map(repr, place))} 1 0 0.5" for place in corners.tolist()]
    (folder / "quad.obj").write_text("\n".join([*lines, "f 1 2 3 4", ""]))
    quad = b"ply\nformat binary_little_endian 1.0\nelement vertex 4\nproperty double x\n"
    quad += b"property double y\nproperty double z\nelement face 1\n"
    quad += b"property list uchar int vertex_indices\nend_header\n"
    quad += corners.tobytes() + b"\4" + np.arange(4, dtype="<i4").tobytes()
    (folder / "quad.ply").write_bytes(quad)
    return corners


# The table.


def page(found: dict[str, Any]) -> str:
    """The figures as tables."""
    out = io.StringIO()
    out.write("# Formats: ours and a library's\n\n")
    out.write(f"{made_on(found['machine'])}. Made by `python benchmarks/formats.py`.\n")
    for what in ("read", "written") if "speed" in found else ():
        out.write(f"\n## {found['triangles']:,} triangles {what}\n\n")
        out.write("| file | ours s | library s | ours MB | library MB | equal |\n")
        out.write("| --- | --- | --- | --- | --- | --- |\n")
        for name, one in found["speed"][what].items():
            cells = [
                str(one[who].get(key, one[who].get("refused", "")))
                for key in ("seconds", "memory_mb")
                for who in ("ours", "theirs")
            ]
            equal = f"{one['largest_apart']:.1g} apart" if what == "read" else one["same_bytes"]
            out.write(f"| {name} | {' | '.join(cells)} | {equal} |\n")
    columns = (
        "refused", "raised", "read, the same shape", "read, with a note", "read, no triangle",
        "read, another shape", "too long", "too much memory",
    )  # fmt: skip
    out.write(f"\n## {found['mutants']} damaged files of each\n\n")
    out.write(f"| file | reader | {' | '.join(columns)} | kinds |\n")
    out.write(f"| --- | --- | {' | '.join('---' for _ in columns)} | --- |\n")
    for name, pair in found["damaged"].items():
        for who, one in pair.items():
            kinds = ", ".join(f"{kind} {times}" for kind, times in one["kinds"].items())
            counts = " | ".join(str(one.get(column, 0)) for column in columns)
            out.write(f"| {name} | {who} | {counts} | {kinds} |\n")
    out.write("\n## What is kept beside triangles\n\n| file | what | ours | trimesh |\n")
    out.write("| --- | --- | --- | --- |\n")
    for name, held in found["kept"].items():
        for what, (ours, theirs) in held.items():
            out.write(f"| {name} | {what} | {ours} | {theirs} |\n")
    return out.getvalue()


def main() -> None:
    parser = asking((__doc__ or "").splitlines()[0])
    parser.add_argument("--mutants", type=int, default=300)
    parser.add_argument("--only", choices=("speed", "kept", "damaged"), help="the rest stays")
    asked = parser.parse_args()
    found: dict[str, Any] = found_before(asked.out, {})
    found |= {
        "machine": machine(),
        "triangles": len(ball().faces),
        "mutants": asked.mutants,
        "libraries": {"trimesh": trimesh.__version__, "ezdxf": ezdxf.__version__},
    }
    parts: dict[str, Callable[[Path], dict[str, Any]]] = {
        "speed": speed,
        "kept": kept,
        "damaged": lambda _: {
            name: {
                who: _alone(damaged, name, k, asked.mutants, 12)
                for k, who in enumerate(("ours", "trimesh"))
            }
            for name in DAMAGED
        },
    }
    for part, work in parts.items():
        if asked.only in (None, part):
            with tempfile.TemporaryDirectory() as place:
                found[part] = work(Path(place))
            write(asked.out, found)


if __name__ == "__main__":
    main()
