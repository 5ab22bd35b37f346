"""The case folder: what lies where, taking photos in, and the lock that keeps it to one run.

CASE/photos/          the photos as received, never altered
CASE/camera.json      the camera (camera-2.json, ... where there are several)
CASE/stages/NAME/     one folder a stage: product.json, arrays.npz, stage.json (key, options)
CASE/deliverables/    the files for other programs
CASE/report/          pictures; CASE/report.html shows them; CASE/summary.json has the figures
CASE/accuracy.*       what the case knows of its own error: JSON, page, PDF
CASE/accuracy-truth.* the same beside a truth that it was compared with
CASE/case.json        versions, hashes, verdicts, timings
CASE/log.txt          what the libraries said
"""

import errno
import os
import shutil
import sys
from collections.abc import Generator, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import IO, Literal

from limbgram.cases.keeping.fingerprint import file_sha256
from limbgram.errors import CaseError, PhotoError

_SPACE_ERRORS = (errno.ENOSPC, errno.EDQUOT)


@dataclass(frozen=True)
class CaseFolder:
    """Paths inside one case."""

    root: Path

    @property
    def photos(self) -> Path:
        return self.root / "photos"

    @property
    def left_out(self) -> Path:
        return self.root / "photos-left-out"

    @property
    def stages(self) -> Path:
        return self.root / "stages"

    @property
    def deliverables(self) -> Path:
        return self.root / "deliverables"

    @property
    def report(self) -> Path:
        return self.root / "report"

    @property
    def log(self) -> Path:
        return self.root / "log.txt"

    @property
    def record(self) -> Path:
        return self.root / "case.json"

    @property
    def summary(self) -> Path:
        return self.root / "summary.json"

    @property
    def page(self) -> Path:
        return self.root / "report.html"

    def accuracy(
        self, suffix: Literal["json", "html", "pdf"], *, against_truth: bool = False
    ) -> Path:
        """What the case says of itself, or what a comparison with a truth said."""
        return self.root / f"accuracy{'-truth' if against_truth else ''}.{suffix}"

    def camera_file(self, idx: int) -> Path:
        return self.root / ("camera.json" if idx == 0 else f"camera-{idx + 1}.json")


def take_in(case: CaseFolder, sources: Sequence[Path]) -> None:
    """Bring files, or the files in folders and their masks, into the case's photo folder.

    A file is linked where the disk allows it, and copied otherwise. Photos of an earlier run
    that are not among the sources are moved to CASE/photos-left-out.

    Raises:
        PhotoError: a source does not exist, or two of them have one name.
        CaseError: the case holds another file under the same name.
    """
    wanted: dict[Path, Path] = {}
    for source, name in _incoming(sources):
        if wanted.setdefault(name, source).resolve() != source.resolve():
            raise PhotoError(
                f"{source} and {wanted[name]} have the same name. Results are told by photo "
                "name: rename one of the two."
            )
    for half in case.photos.rglob(".*.half"):
        half.unlink()
    for name, source in wanted.items():
        _take_in_one(case, source, name)
    for kept in sorted(case.photos.rglob("*")):
        name = kept.relative_to(case.photos)
        if kept.is_file() and name not in wanted:
            (case.left_out / name).parent.mkdir(parents=True, exist_ok=True)
            kept.replace(case.left_out / name)


def _incoming(sources: Sequence[Path]) -> Iterator[tuple[Path, Path]]:
    """Files and the names, relative to the photo folder, under which they are kept."""
    for source in sources:
        if source.is_file():
            yield source, Path(source.name)
        elif source.is_dir():
            for file in sorted((*source.iterdir(), *(source / "masks").glob("*"))):
                if file.is_file() and not file.name.startswith("."):
                    yield file, file.relative_to(source)
        else:
            raise PhotoError(
                f"{source} does not exist. Check the spelling; a folder of photos or photo files "
                "are expected."
            )


def _take_in_one(case: CaseFolder, source: Path, name: Path) -> None:
    kept = case.photos / name
    if kept.exists():
        same = kept.samefile(source) or (
            kept.stat().st_size == source.stat().st_size
            and file_sha256(kept) == file_sha256(source)
        )
        if not same:
            raise CaseError(
                f"{name} in {case.photos} is another file than {source}. A case never alters the "
                "photos it received. Use a new case folder, or rename one of the two."
            )
        return
    kept.parent.mkdir(parents=True, exist_ok=True)
    half = kept.with_name(f".{kept.name}.half")
    try:
        half.hardlink_to(source.resolve())
    except OSError:
        shutil.copyfile(source, half)
    half.replace(kept)


@contextmanager
def locked(case: CaseFolder) -> Generator[None]:
    """Hold the case; the system lets it go even if this process dies.

    Raises:
        CaseError: another run holds it, or the folder cannot be made.
    """
    try:
        case.root.mkdir(parents=True, exist_ok=True)
        file = (case.root / ".lock").open("a+")
    except OSError as error:
        raise CaseError(
            f"The case folder {case.root} cannot be made or written: {error.strerror}. "
            "Choose a folder on a disk that you may write to."
        ) from error
    with file:
        if not _try_lock(file):
            raise CaseError(
                f"Another run is working in {case.root}. Wait until it has ended, or choose "
                "another case folder with -o."
            )
        yield


def _try_lock(file: IO[str]) -> bool:
    try:
        if sys.platform == "win32":
            import msvcrt

            msvcrt.locking(file.fileno(), msvcrt.LK_NBLCK, 1)
        else:
            import fcntl

            fcntl.flock(file, fcntl.LOCK_EX | fcntl.LOCK_NB)
    except OSError:
        return False
    return True


@contextmanager
def written_whole(path: Path) -> Generator[Path]:
    """Write a file beside its place, sync it, rename it: it is there whole or not at all."""
    path.parent.mkdir(parents=True, exist_ok=True)
    half = path.with_name(f".{path.name}.half")
    yield half
    sync(half)
    half.replace(path)


def sync(path: Path) -> None:
    """Have the system put a file on the disk."""
    handle = os.open(path, os.O_RDWR)
    try:
        os.fsync(handle)
    finally:
        os.close(handle)


@contextmanager
def enough_disk(case: CaseFolder) -> Generator[None]:
    """Turn a full disk into advice; what is finished stays usable."""
    try:
        yield
    except OSError as error:
        if error.errno not in _SPACE_ERRORS:
            raise
        free_mb = shutil.disk_usage(case.root).free / 2**20
        raise CaseError(
            f"The disk of {case.root} is full ({free_mb:.0f} MB free). Free some space (a case "
            "needs about 50 MB a photo) and run the same command again: it continues where it "
            "stopped."
        ) from error
