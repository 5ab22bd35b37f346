"""Refusals: every way in which limbgram declines to give an answer.

Each message says what happened, the likely cause, and what to do about it.
A part that was set aside (a photo, a pair, a board) is not an error but a value
in the product of its stage; a bug of ours is left to crash.

LimbgramError            exit code
    OptionsError             2   an option has a value that cannot be used
    PhotoError               3   the photos cannot be read
    CaseError                3   the case folder, or a file for which no other error
                                 stands here, cannot be read or written
    ShapeFileError           3   a shape's file cannot be read
    CalibrationError         4   the board photos do not determine the camera
    MatchingError            4   the photos do not overlap, or show nothing to match
    BudgetError              4   the work needs more memory than it may use
    PlacementError           4   the photos cannot be joined to one scene
    PlanError                4   no capture as asked reaches the accuracy asked for
    ScaleError               4   no scale, or lengths that contradict each other
    RegionError              4   the limb cannot be told from its surroundings
    DenseError               4   too little of the surface could be measured
    SurfaceError             4   the points do not make a surface
    MeasureError             4   a measure has no answer on this shape
    EditError                4   an edit would spoil the shape
    CarveError               4   the shape cannot be carved or spoken in a format
    ExportError              5   a file could not be written and verified
    MissingError             3   there is nothing of the name that was asked for
    cases.job_supervision.JobDied
                             6   the system or a library ended the program
    Cancelled              130   the user asked to stop

A result that was made and judged red is no refusal: its files are written, named as what they
are (surface-RED.stl), and the command ends with RED_EXIT_CODE, 7. Green and amber end with 0. A
test that can neither be passed nor failed ends with UNDECIDED_EXIT_CODE, 8.

What the system says about a file becomes a finding in `disk_finding`, where it is caught.
What is told to people goes through `printable`: names of files come from anywhere.
"""

import errno
import re
import unicodedata
from collections.abc import Callable, Generator
from contextlib import AbstractContextManager, contextmanager
from typing import Any, Self

from limbgram.findings import Finding, Value, fault, told

RED_EXIT_CODE = 7
"""Exit code of a command whose answer is a red verdict."""
UNDECIDED_EXIT_CODE = 8
"""Exit code of a test that can neither be passed nor failed."""
_FULL = (errno.ENOSPC, errno.EDQUOT)
_IN_THE_WAY = (errno.EISDIR, errno.ENOTDIR, errno.EEXIST, errno.ENOTEMPTY)
AS_IS = "said.as_is"
"""Code of a message quoted from a library, the system or an earlier version."""
_CODE = re.compile(r"[a-z][a-z0-9_]*(\.[a-z0-9_]+)+")
_CONTROL = ("Cc", "Cs", "Zl", "Zp")
_REORDERING = "\u202a\u202b\u202c\u202d\u202e\u2066\u2067\u2068\u2069"
"""Characters that reorder text on a terminal: `gpj.exe` reads as `exe.jpg`."""


class LimbgramError(Exception):
    """Base of every refusal; the command line ends with its `exit_code`.

    `EditError("edit.wall.thin", least_mm=2.0)` carries the finding of that code; its text is the
    finding's English sentence and advice.
    """

    exit_code = 4

    def __init__(self, code: str, /, **values: Value) -> None:
        super().__init__(code)
        self.finding = fault(code, **values) if _CODE.fullmatch(code) else in_words(code)

    def __str__(self) -> str:
        return told(self.finding)

    @classmethod
    def of(cls, finding: Finding) -> Self:
        """The refusal that carries this finding."""
        error = cls.__new__(cls)
        Exception.__init__(error, finding.code)
        error.finding = finding
        return error

    def __reduce__(self) -> tuple[Any, ...]:
        return _raised_again, (type(self), self.finding), self.__dict__


class OptionsError(LimbgramError):
    """An option has a value that cannot be used."""

    exit_code = 2


class PhotoError(LimbgramError):
    """The photos cannot be read, or too few are left."""

    exit_code = 3


class CaseError(LimbgramError):
    """The case folder cannot be read or written."""

    exit_code = 3


class ShapeFileError(LimbgramError):
    """A shape's file cannot be read."""

    exit_code = 3


class CalibrationError(LimbgramError):
    """The board photos do not determine the camera."""


class MatchingError(LimbgramError):
    """The photos do not overlap, or show nothing that can be matched."""


class BudgetError(LimbgramError):
    """The work needs more memory than it may use."""


class PlacementError(LimbgramError):
    """The photos cannot be joined to one scene."""


class PlanError(LimbgramError):
    """No capture as asked reaches the accuracy asked for."""


class ScaleError(LimbgramError):
    """There is no scale, or the known lengths contradict each other."""


class RegionError(LimbgramError):
    """The limb cannot be told from its surroundings."""


class DenseError(LimbgramError):
    """Too little of the surface could be measured."""


class SurfaceError(LimbgramError):
    """The points do not make a surface."""


class MeasureError(LimbgramError):
    """A measure has no answer on this shape."""


class EditError(LimbgramError):
    """An edit would spoil the shape: it would fold, tear or cut through itself."""


class CarveError(LimbgramError):
    """The shape cannot be carved, or is none that the asked format can hold."""


class ExportError(LimbgramError):
    """A file could not be written, or did not read back as it was written."""

    exit_code = 5


class FoldedShapeError(ExportError):
    """A surface folds, crosses itself or branches; printers and carvers take it literally."""


class MissingError(LimbgramError, LookupError):
    """There is no case, photo or file of the name that was asked for."""

    exit_code = 3


class Cancelled(LimbgramError):
    """The user asked to stop; what is finished is kept."""

    exit_code = 130


@contextmanager
def refusals_saying(more: Callable[[Finding], Finding]) -> Generator[None]:
    """Change the finding of an EditError on its way out."""
    try:
        yield
    except EditError as error:
        error.finding = more(error.finding)
        raise


def refusals_about(what: str) -> AbstractContextManager[None]:
    """Give the EditErrors raised inside a subject: what was being made.

    Shared functions do not know which edit calls them. The innermost subject counts.
    """
    return refusals_saying(lambda finding: finding.about(what))


def in_words(message: str) -> Finding:
    """The finding that quotes a message of a library or an earlier version."""
    return fault(AS_IS, message=message)


def _raised_again(kind: type[LimbgramError], finding: Finding) -> LimbgramError:
    """A refusal unpickled, as from another process."""
    return kind.of(finding)


def is_full(error: OSError) -> bool:
    """Whether the disk is full."""
    return error.errno in _FULL


def reason_of(error: Exception) -> Finding:
    """A refusal's finding, or a quote of another exception's message."""
    return error.finding if isinstance(error, LimbgramError) else in_words(str(error))


def system_reason(error: OSError) -> Finding:
    """The finding that quotes the system's message about a file."""
    kind = errno.errorcode.get(error.errno or 0)
    return fault("disk.said", error=kind, text=error.strerror or str(error))


def disk_finding(error: OSError) -> Finding:
    """The finding for an error of the file system, with its likely cause and advice."""
    named = error.filename2 or error.filename
    name = None if named is None else str(named)
    match error.errno:
        case number if number in _FULL:
            return fault("disk.full", name=name)
        case errno.EACCES | errno.EPERM:
            return fault("disk.not_yours", name=name)
        case errno.EROFS:
            return fault("disk.read_only", name=name)
        case errno.ENOENT:
            return fault("disk.not_there", name=name)
        case number if number in _IN_THE_WAY:
            return fault("disk.in_the_way", name=name)
        case errno.ENAMETOOLONG:
            return fault("disk.long_name", name=name)
        case errno.ELOOP:
            return fault("disk.loop", name=name)
        case errno.EMFILE | errno.ENFILE | errno.ENOMEM | errno.EAGAIN:
            return fault("disk.no_means", name=name, why=system_reason(error))
        case _:
            return fault("disk.failing", name=name, why=system_reason(error))


def with_full_stop(text: str) -> str:
    """A text that ends with one full stop."""
    return f"{text.removesuffix('.')}."


def printable(text: str, keep: str = "\n\t") -> str:
    """A text that is safe on a terminal or a page.

    Control characters, surrogates and characters that reorder text are escaped, except for those
    in `keep`.
    """
    return "".join(
        letter
        if letter in keep or not (unicodedata.category(letter) in _CONTROL or letter in _REORDERING)
        else letter.encode("unicode_escape").decode("ascii")
        for letter in text
    )
