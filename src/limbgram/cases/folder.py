"""The case folder: what lies where, taking photos in, and the lock that keeps it to one run.

CASE/photos/          the photos as received: copies, never altered
CASE/frames/VIDEO/    of a video: the frames that were taken, and why (see `video_frames`)
CASE/camera.json      the camera (camera-2.json, ... where there are several)
CASE/stages/NAME/     one folder a stage: product.json, arrays.npz, stage.json (key, options)
CASE/deliverables/    the files for other programs
CASE/report/          pictures; CASE/report.html shows them; CASE/summary.json has the figures
CASE/accuracy.*       the case's estimate of its own error: JSON, page, PDF
CASE/accuracy-truth.* the same from a comparison with a truth
CASE/case.json        versions, hashes, verdicts, timings
CASE/superseded/      results of an earlier run that no longer stand, until a run finishes again
CASE/log.txt          output of the libraries
"""

import os
import re
import shutil
import sys
from collections.abc import Generator, Sequence
from contextlib import ExitStack, contextmanager, suppress
from dataclasses import dataclass
from pathlib import Path
from typing import Literal

from limbgram.cases.fingerprint import file_sha256
from limbgram.core.errors import CaseError, PhotoError, disk_finding, is_full, system_reason
from limbgram.core.files import file_lock, written_whole
from limbgram.findings import Finding, fault
from limbgram.reconstruction.photos.masks import (
    MASKS_FOLDER,
    find_mask,
    mask_in,
    no_mask_fits,
    require_masks_folder,
)
from limbgram.reconstruction.photos.photo import SetAside, left_out
from limbgram.reconstruction.photos.reading import Candidate, candidates_in

_LEFTOVER = re.compile(
    r"\.[0-9a-f]{16}\.\d+\.(part(\.\w+)?|old)|\.([0-9a-f]{16}|.+\.(json|html|pdf|png))\.half"
)
"""Temporary files, as `written_whole` names them, and as earlier versions did."""
_OWN_LEFTOVER = re.compile(r"\..+\.(half|part|old)(\.\w+)?")
"""The same in folders in which only this program writes."""
_FICLONE = 0x40049409
"""Linux's request to let a file share the bytes of another one (ioctl_ficlone)."""
_LISTED_AT_MOST = 5
UNREADABLE = ".unreadable-"
"""In the name of a file that could not be read and was set aside (`case_record.set_aside`)."""


@dataclass(frozen=True)
class CaseFolder:
    """Paths inside one case."""

    root: Path

    @property
    def photos(self) -> Path:
        return self.root / "photos"

    @property
    def frames(self) -> Path:
        return self.root / "frames"

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
    def surface_picture(self) -> Path:
        return self.report / "surface.png"

    @property
    def log(self) -> Path:
        return self.root / "log.txt"

    @property
    def record(self) -> Path:
        return self.root / "case.json"

    @property
    def label_file(self) -> Path:
        """What people say of it (`shelf.Label`)."""
        return self.root / "label.json"

    @property
    def is_case(self) -> bool:
        """Whether it is one: it has its record, or one that was set aside, or a label."""
        aside = self.root.glob(f"{self.record.stem}{UNREADABLE}*")
        return self.record.exists() or self.label_file.exists() or any(aside)

    @property
    def job_file(self) -> Path:
        """What is kept of its job (`job_queue`)."""
        return self.root / "job.json"

    @property
    def superseded(self) -> Path:
        return self.root / "superseded"

    @property
    def summary(self) -> Path:
        return self.root / "summary.json"

    @property
    def page(self) -> Path:
        return self.root / "report.html"

    def accuracy(
        self, suffix: Literal["json", "html", "pdf"], *, against_truth: bool = False
    ) -> Path:
        """The case's own accuracy, or that of its comparison with a truth."""
        return self.root / f"accuracy{'-truth' if against_truth else ''}.{suffix}"

    def camera_file(self, idx: int) -> Path:
        return self.root / ("camera.json" if idx == 0 else f"camera-{idx + 1}.json")


def require_apart(case: CaseFolder, sources: Sequence[Path]) -> None:
    """Refuse a case folder that is the folder of the photos: its files would lie among them.

    Raises:
        CaseError: they are one folder, or the sources are where the case would put its copies.
    """
    root = case.root.resolve()
    for source in (source for source in sources if source.is_dir()):
        place = source.resolve()
        if root in (place, place / MASKS_FOLDER):
            raise CaseError("case.among_photos", folder=str(source), other=str(source / "case"))
        if place in (root / "photos", root / "photos-left-out") and not case.is_case:
            raise CaseError("case.photos_in_its_place", photos=str(source), case=str(case.root))


def require_new_or_ours(case: CaseFolder) -> None:
    """Refuse a folder of something else, in which files of the same names would be written over.

    Raises:
        CaseError: it is no case, and holds what has the name of a case's file.
    """
    if case.is_case or not case.root.is_dir():
        return
    names = ("photos", "stages", "deliverables", "report", "summary.json", "report.html")
    found = [name for name in names if (case.root / name).exists()]
    found += sorted(file.name for file in case.root.glob("accuracy*.*"))
    if found:
        raise CaseError("case.folder_taken", folder=str(case.root), names=tuple(found))


def take_in(
    case: CaseFolder, sources: Sequence[Path], masks: Path | None = None
) -> tuple[SetAside, ...]:
    """Copy photos, or the photos in folders and their masks, into the case's photo folder.

    A copy shares its bytes with the original where the disk can do so until one of them changes
    (never a hard link: altered in place, the original would change the case). Photos of an earlier
    run that are not among the sources are moved to CASE/photos-left-out, where none takes the place
    of another; so are those of a name that another photo has by now within the case itself, where
    the app receives photos and films are taken apart.

    Args:
        masks: Folder of masks that take the place of those beside the photos.

    Returns:
        What was not taken in, and why.

    Raises:
        PhotoError: a source does not exist, two of them have one name, or there are no photos.
        CaseError: the case holds another file under the same name, or is the photos' own folder.
    """
    wanted: dict[Path, Path] = {}
    files, set_aside = incoming(sources, masks)
    require_apart(case, sources)
    for source, name in files:
        if wanted.setdefault(name, source).resolve() != source.resolve():
            raise PhotoError("case.photos_of_one_name", one=str(source), two=str(wanted[name]))
    for name, source in list(wanted.items()):
        reason = _copy_in(case, source, name)
        if reason is not None:
            set_aside.append(SetAside(name.name, reason))
            del wanted[name]
    if not wanted:
        raise _no_photos(sources, set_aside)
    for kept in sorted(case.photos.rglob("*")):
        name = kept.relative_to(case.photos)
        if kept.is_file() and name not in wanted:
            _move_aside(case, name)
    return tuple(set_aside)


def _move_aside(case: CaseFolder, name: Path) -> None:
    """Move a photo of the case to those that are left out."""
    aside = _place_aside(case.left_out / name, case.photos / name)
    aside.parent.mkdir(parents=True, exist_ok=True)
    (case.photos / name).replace(aside)


def _place_aside(wanted: Path, file: Path) -> Path:
    """Where a file is moved to: beside another one that has the name already."""
    place, number = wanted, 1
    while place.exists() and file_sha256(place) != file_sha256(file):
        number += 1
        place = wanted.with_stem(f"{wanted.stem}-{number}")
    return place


def incoming(
    sources: Sequence[Path], masks: Path | None = None
) -> tuple[list[tuple[Path, Path]], list[SetAside]]:
    """Pictures and the names, relative to the photo folder, under which they are kept.

    Raises:
        PhotoError: a source does not exist, or no mask in the folder of masks is any photo's.
    """
    found = candidates_in(sources)
    if masks is not None:
        require_masks_folder(masks)
    pictures = [(one.path, Path(one.name)) for one in found.photos]
    masked = [(one, _mask_of(one, masks)) for one in found.photos]
    for photo, mask in masked:
        if mask is not None:
            pictures.append((mask, Path(MASKS_FOLDER) / f"{_mask_stem(mask, photo)}.png"))
    if masks is not None and found.photos and len(pictures) == len(found.photos):
        raise no_mask_fits(masks, found.photos[0].path)
    return pictures, list(found.set_aside)


def _mask_of(photo: Candidate, masks: Path | None) -> Path | None:
    """A photo's mask in a folder, or the one that lies beside it."""
    return find_mask(photo.path) if masks is None else mask_in(masks, photo.path, photo.name)


def _mask_stem(mask: Path, photo: Candidate) -> str:
    """The name of a photo's mask in the case: by the photo's full name, or by its stem.

    The mask follows its photo, which may have another name in the case.
    """
    by_full_name = mask.stem in (photo.path.name, photo.name)
    return photo.name if by_full_name else Path(photo.name).stem


def _copy_in(case: CaseFolder, source: Path, name: Path) -> Finding | None:
    """Copy a photo into the case; returns the reason if it cannot be read."""
    kept = case.photos / name
    try:
        sha256 = file_sha256(source)
    except PermissionError:
        return fault("photo.file.forbidden")
    except OSError as error:
        return fault("photo.file.unread", why=system_reason(error))
    if kept.exists():
        if kept.resolve() == source.resolve():
            return None
        same = file_sha256(kept) == sha256
        if not same and name.parent.name != MASKS_FOLDER:  # masks are corrected again and again
            if not source.resolve().is_relative_to(case.root.resolve()):
                raise CaseError(
                    "case.other_photo", name=str(name), folder=str(case.photos), photo=str(source)
                )
            _move_aside(case, name)  # replaced where the case received it
        if same and not kept.samefile(source):
            return None
    kept.parent.mkdir(parents=True, exist_ok=True)

    def require_same(copy: Path) -> None:
        if file_sha256(copy) != sha256:
            raise CaseError("case.copy_differs", photo=str(source), folder=str(case.photos))

    with written_whole(kept, require_same) as beside:
        _copy(source, beside)
    return None


def _copy(source: Path, to: Path) -> None:
    """Copy a file; on a file system that can, the copy shares its blocks until one changes."""
    with source.open("rb") as reader, to.open("wb") as writer:
        if sys.platform == "linux":
            import fcntl

            with suppress(OSError):  # another disk, or one that cannot share bytes
                fcntl.ioctl(writer, _FICLONE, reader.fileno())
                return
        shutil.copyfileobj(reader, writer)


def _no_photos(sources: Sequence[Path], set_aside: Sequence[SetAside]) -> PhotoError:
    where = ", ".join(str(source) for source in sources[:_LISTED_AT_MOST])
    folders = [
        file.name
        for source in sources
        if source.is_dir() and os.access(source, os.R_OK)
        for file in sorted(source.iterdir())
        if file.is_dir() and not file.name.startswith(".") and file.name != MASKS_FOLDER
    ]
    return PhotoError(
        "case.no_photos",
        sources=where,
        folders=tuple(folders[:_LISTED_AT_MOST]) or None,
        aside=len(set_aside),
        left_out=left_out(set_aside),
    )


def sweep(case: CaseFolder) -> None:
    """Remove temporary files that killed runs left; the case must be locked."""
    ours = (case.photos, case.photos / MASKS_FOLDER, case.frames, case.stages, case.deliverables)
    shared = (case.root, case.report)
    folders = [*((one, _LEFTOVER) for one in shared), *((one, _OWN_LEFTOVER) for one in ours)]
    for folder, leftover in folders:
        for path in sorted(folder.glob(".*")):
            if not leftover.fullmatch(path.name):
                continue
            if path.is_dir() and not path.is_symlink():
                shutil.rmtree(path, ignore_errors=True)
            else:
                path.unlink()


@contextmanager
def locked(case: CaseFolder) -> Generator[None]:
    """Lock the case; the system unlocks it even if this process dies.

    Raises:
        CaseError: another run has locked it, or the folder cannot be made.
    """
    with ExitStack() as held:
        try:
            case.root.mkdir(parents=True, exist_ok=True)
            ours = held.enter_context(file_lock(case.root / ".lock", wait=False))
        except OSError as error:
            raise cannot_be_made(case, error) from error
        if not ours:
            raise CaseError("case.locked", case=str(case.root))
        yield


def cannot_be_made(case: CaseFolder, error: OSError) -> CaseError:
    """The refusal of a case folder that cannot be begun."""
    return CaseError("case.folder_fails", folder=str(case.root), reason=disk_finding(error))


@contextmanager
def with_disk_advice(case: CaseFolder) -> Generator[None]:
    """Turn the system's errors about files into refusals with advice.

    An error without a number does not come from the system: it is a bug, and passes.
    """
    try:
        yield
    except OSError as error:
        if error.errno is None:
            raise
        if not is_full(error):
            raise CaseError("case.disk", reason=disk_finding(error)) from error
        free_mb = shutil.disk_usage(case.root).free / 2**20
        raise CaseError("case.disk_full", case=str(case.root), free_mb=free_mb) from error
