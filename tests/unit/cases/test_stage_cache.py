"""Nothing is computed twice, and nothing is reused that has changed or is not whole."""

import ast
import errno
import json
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import pytest
from jaxtyping import Float64

from limbgram.cases import fingerprint, stage_cache
from limbgram.cases.case_record import write_record
from limbgram.cases.fingerprint import Fingerprints, code_version
from limbgram.cases.folder import CaseFolder
from limbgram.cases.stage_cache import CachingRun, read_product
from limbgram.core.errors import Cancelled, CaseError
from limbgram.core.run import track

CALLS: list[str] = []


@dataclass(frozen=True)
class Numbers:
    values: Float64[np.ndarray, " n"]
    source: Path


@dataclass(frozen=True)
class Options:
    factor: float = 2.0


def read(sources: tuple[Path, ...]) -> Numbers:
    CALLS.append("read")
    return Numbers(np.array([float(p.read_text()) for p in sources]), sources[0])


def scale(numbers: Numbers, options: Options) -> Numbers:
    CALLS.append("scale")
    return Numbers(numbers.values * options.factor, numbers.source)


def split(numbers: Numbers) -> tuple[Numbers, ...]:
    CALLS.append("split")
    return tuple(Numbers(numbers.values[k : k + 1], numbers.source) for k in track(range(2)))


def wrong(_numbers: Numbers) -> Numbers:
    return Numbers(np.zeros(3, np.float32), Path("x"))  # type: ignore[arg-type]


@pytest.fixture
def files(tmp_path: Path) -> tuple[Path, ...]:
    CALLS.clear()
    photos = tmp_path / "Fall Ä 1" / "photos"
    photos.mkdir(parents=True)
    for k in range(2):
        (photos / f"{k}.txt").write_text(str(k + 1))
    return tuple(sorted(photos.iterdir()))


def chain(files: tuple[Path, ...], factor: float = 2.0) -> tuple[list[str], np.ndarray]:
    """Stages that were computed, and the last product."""
    CALLS.clear()
    run = CachingRun(case=CaseFolder(files[0].parent.parent))
    parts = run(split, run(scale, run(read, files), Options(factor)))
    assert len(run.timings) == 3
    return list(CALLS), np.concatenate([part.values for part in parts])


def test_a_second_run_computes_nothing(files: tuple[Path, ...]) -> None:
    assert chain(files)[0] == ["read", "scale", "split"]
    computed, values = chain(files)
    assert computed == []
    np.testing.assert_array_equal(values, [2, 4])


def test_an_option_recomputes_what_hangs_on_it(files: tuple[Path, ...]) -> None:
    chain(files)
    computed, values = chain(files, factor=3)
    assert computed == ["scale", "split"]
    np.testing.assert_array_equal(values, [3, 6])


def test_a_changed_file_recomputes_all(files: tuple[Path, ...]) -> None:
    chain(files)
    files[1].write_text("50")
    computed, values = chain(files)
    assert computed == ["read", "scale", "split"]
    np.testing.assert_array_equal(values, [2, 100])


def test_an_input_of_equal_content_stops_the_recomputing(
    files: tuple[Path, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    chain(files)
    versions = {"read": "another version of its code"}
    plain = Fingerprints.key
    monkeypatch.setattr(
        Fingerprints,
        "key",
        lambda self, stage, inputs: plain(self, stage, inputs) + versions.get(stage.__name__, ""),
    )
    assert chain(files)[0] == ["read"]


@pytest.mark.parametrize("name", ["product.json", "arrays.npz", "stage.json"])
@pytest.mark.parametrize("damage", ["cut", "flipped", "gone"])
def test_what_is_not_whole_is_computed_again(
    files: tuple[Path, ...], name: str, damage: str
) -> None:
    chain(files)
    file = files[0].parent.parent / "stages" / "scale" / name
    content = file.read_bytes()
    match damage:
        case "cut":
            file.write_bytes(content[: len(content) // 2])
        case "flipped":
            middle = content.index(b"key") + 8 if name == "stage.json" else len(content) // 2
            file.write_bytes(
                content[:middle] + bytes([content[middle] ^ 1]) + content[middle + 1 :]
            )
        case _:
            file.unlink()
    computed, values = chain(files)
    assert computed == ["scale"]
    np.testing.assert_array_equal(values, [2, 4])


def damaged(content: bytes, chance: np.random.Generator) -> bytes:
    """A file with a flipped bit, a changed digit, or without its end or its middle."""
    place = int(chance.integers(len(content)))
    digits = [k for k, byte in enumerate(content) if chr(byte).isdigit()]
    match int(chance.integers(4)):
        case 0:
            byte = content[place] ^ (1 << int(chance.integers(8)))
            return content[:place] + bytes([byte]) + content[place + 1 :]
        case 1:
            place = digits[int(chance.integers(len(digits)))]
            digit = (content[place] - ord("0") + int(chance.integers(1, 10))) % 10
            return content[:place] + str(digit).encode() + content[place + 1 :]
        case 2:
            return content[:place]
        case _:
            return content[:place] + content[place + 1 :]


@pytest.mark.parametrize("name", ["product.json", "arrays.npz", "stage.json"])
def test_no_damage_is_taken_up(files: tuple[Path, ...], name: str) -> None:
    chain(files)
    folder = files[0].parent.parent / "stages" / "scale"
    key = json.loads((folder / "stage.json").read_text("utf-8"))["key"]
    whole = (folder / name).read_bytes()
    chance = np.random.default_rng(7)
    for _ in range(200):
        changed = damaged(whole, chance)
        if changed == whole:
            continue
        (folder / name).write_bytes(changed)
        with pytest.raises(LookupError):
            read_product(folder, key, Numbers, folder)
    (folder / name).write_bytes(whole)
    assert read_product(folder, key, Numbers, folder)


def test_a_case_can_be_moved(files: tuple[Path, ...]) -> None:
    chain(files)
    old = files[0].parent.parent
    new = old.rename(old.with_name("moved"))
    moved = tuple(new / "photos" / file.name for file in files)
    assert chain(moved)[0] == []
    run = CachingRun(case=CaseFolder(new))
    assert run(read, moved).source == moved[0].resolve()


def test_a_product_that_breaks_its_promise_is_a_bug_at_once(files: tuple[Path, ...]) -> None:
    run = CachingRun(case=CaseFolder(files[0].parent.parent))
    with pytest.raises(TypeError, match="float32"):
        run(wrong, run(read, files))


def test_the_same_stage_twice_keeps_both(files: tuple[Path, ...]) -> None:
    run = CachingRun(case=CaseFolder(files[0].parent.parent))
    run(scale, run(scale, run(read, files), Options()), Options())
    assert list(run.keys) == ["read", "scale", "scale-2"]
    again = CachingRun(case=run.case)
    CALLS.clear()
    twice = again(scale, again(scale, again(read, files), Options()), Options())
    np.testing.assert_array_equal(twice.values, [4, 8])
    assert CALLS == []


def test_stopping_keeps_what_is_finished(files: tuple[Path, ...]) -> None:
    run = CachingRun(case=CaseFolder(files[0].parent.parent))
    scaled = run(scale, run(read, files), Options())
    run.listener = lambda stage, done, _total: (
        run.cancel() if (stage, done) == ("split", 1) else None
    )
    with pytest.raises(Cancelled):
        run(split, scaled)
    assert chain(files)[0] == ["split"]


def test_a_full_disk_gives_advice_and_leaves_a_case_that_continues(
    files: tuple[Path, ...], monkeypatch: pytest.MonkeyPatch
) -> None:
    def full(*_: object) -> None:
        raise OSError(errno.ENOSPC, "No space left on device")

    with monkeypatch.context() as patch:
        patch.setattr(stage_cache.np, "savez", full)
        with pytest.raises(CaseError, match=r"is full .* run the same command again"):
            chain(files)
    assert chain(files)[0] == ["read", "scale", "split"]


def test_stages_that_cannot_be_written_give_advice(files: tuple[Path, ...]) -> None:
    (files[0].parent.parent / "stages").write_text("no folder")
    with pytest.raises(CaseError, match=r"is in the way: .* run the same command again"):
        chain(files)


def test_only_what_was_delivered_is_listed(tmp_path: Path) -> None:
    case = CaseFolder(tmp_path)
    for name in ("surface.stl", ".surface.1.part.stl", "colmap/images.txt", ".colmap.1.old/x.txt"):
        (case.deliverables / name).parent.mkdir(parents=True, exist_ok=True)
        (case.deliverables / name).write_bytes(b"")
    write_record(case, "finished", CachingRun(case=case))
    listed = [one["path"] for one in json.loads(case.record.read_text("utf-8"))["files"]]
    assert listed == ["deliverables/colmap/images.txt", "deliverables/surface.stl"]


def test_code_version_follows_imports() -> None:
    first = code_version("limbgram.core.geometry.frames")
    assert first != code_version("limbgram.core.geometry.lens")
    read_by_lens = set(
        fingerprint._imported(Path(fingerprint._PACKAGE / "core/geometry/lens.py").read_bytes())
    )
    assert "limbgram.core.geometry.frames" in read_by_lens


def test_imports_are_found_wherever_they_stand() -> None:
    source = b"""'''Text, in which a line begins like one:
import of nothing (
'''
import a.b, c
from d import (
    e,  # why
    f,
)
def g():
    if h:
        from i.j import k  # why
    return "import l"
"""
    found = {"a.b", "c", "d", "d.e", "d.f", "i.j", "i.j.k"}
    assert set(fingerprint._imported(source)) == found
    without_text = source[source.rindex(b"'''") + 3 :]
    assert set(fingerprint._imported(without_text)) == found
    by_name = without_text + b"import_module('m')\n"
    assert set(fingerprint._imported(by_name)) == found | {"m"}


def statements(node: ast.AST) -> Iterator[ast.stmt]:
    """All of a module, however deep: imports are statements, and most of a text is expressions."""
    for field in ("body", "orelse", "finalbody", "handlers", "cases"):
        for one in getattr(node, field, ()):
            if isinstance(one, ast.stmt):
                yield one
            yield from statements(one)


def test_imports_of_our_own_sources_are_those_of_the_whole_text() -> None:
    for file in fingerprint._PACKAGE.rglob("*.py"):
        source = file.read_bytes()
        whole = {
            name
            for node in statements(ast.parse(source))
            if isinstance(node, ast.Import | ast.ImportFrom)
            for name in (
                [alias.name for alias in node.names]
                if isinstance(node, ast.Import)
                else [str(node.module), *(f"{node.module}.{alias.name}" for alias in node.names)]
            )
        }
        assert whole <= set(fingerprint._imported(source)), file


def test_code_version_has_the_libraries_that_the_code_can_use(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    stages = {
        "limbgram.reconstruction.photos.reading": {
            "pillow",
            "pi_heif",
            "rawpy",
            "numpy",
            "opencv-python-headless",
        },
        "limbgram.reconstruction.measuring.measurement": {"numba", "llvmlite", "embreex", "scipy"},
        "limbgram.reconstruction.mapping.placement": {"pycolmap"},
    }
    plain = fingerprint.version
    before = {module: code_version(module) for module in stages}
    for module, libraries in stages.items():
        for library in libraries | {"matplotlib"}:
            fingerprint.code_version.cache_clear()
            fingerprint._library_version.cache_clear()
            with monkeypatch.context() as patch:
                if library in ("pi_heif", "rawpy"):  # may come later than the rest
                    installed = fingerprint._all_distributions() | {library: [library]}
                    patch.setattr(fingerprint, "_all_distributions", lambda found=installed: found)
                patch.setattr(
                    fingerprint,
                    "version",
                    lambda name, other=library: "another" if name == other else plain(name),
                )
                assert (code_version(module) == before[module]) == (library == "matplotlib")
    fingerprint.code_version.cache_clear()
    fingerprint._library_version.cache_clear()


def test_code_version_needs_no_library_that_may_be_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    module, optional = "limbgram.reconstruction.photos.reading", ("pi_heif", "rawpy")
    plain = fingerprint.version
    present = {
        name: found
        for name, found in fingerprint._all_distributions().items()
        if name not in optional
    }
    found: list[str] = []
    for installed in (present, *(present | {name: [name]} for name in optional)):
        fingerprint.code_version.cache_clear()
        fingerprint._library_version.cache_clear()
        with monkeypatch.context() as patch:
            patch.setattr(fingerprint, "_all_distributions", lambda here=installed: here)
            patch.setattr(
                fingerprint, "version", lambda name: "1.0" if name in optional else plain(name)
            )
            found.append(code_version(module))
            told = fingerprint.library_versions(frozenset(optional))
        assert told == {name: f"{name} 1.0" if name in installed else "none" for name in optional}
    assert len(set(found)) == 3
    fingerprint.code_version.cache_clear()
    fingerprint._library_version.cache_clear()


def test_fingerprints_tell_dtype_shape_and_content_apart() -> None:
    of = Fingerprints().of
    values = [
        np.zeros(4),
        np.zeros(4, np.float32),
        np.zeros((2, 2)),
        np.zeros(5),
        np.array([0, 0, 0, -0.0]),
        (np.zeros(4),),
        None,
        "",
        0,
    ]
    assert len({of(value) for value in values}) == len(values)
