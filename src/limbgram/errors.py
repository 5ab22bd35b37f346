"""Refusals: every way in which limbgram declines to give an answer.

Each message says what happened, the likely cause, and what to do about it.
A part that was set aside (a photo, a pair, a board) is not an error but a value
in the product of its stage; a bug of ours is left to crash.

LimbgramError            exit code
    OptionsError             2   an option has a value that cannot be used
    PhotoError               3   the photos cannot be read
    CaseError                3   the case folder cannot be read or written
    ShapeFileError           3   a shape's file cannot be read
    CalibrationError         4   the board photos do not determine the camera
    MatchingError            4   the photos do not overlap, or show nothing to match
    PlacementError           4   the photos cannot be joined to one scene
    ScaleError               4   no scale, or lengths that contradict each other
    RegionError              4   the limb cannot be told from its surroundings
    DenseError               4   too little of the surface could be measured
    SurfaceError             4   the points do not make a surface
    MeasureError             4   a measure has no answer on this shape
    EditError                4   an edit would spoil the shape
    CarveError               4   the shape cannot be carved or spoken in a format
    ExportError              5   a file could not be written and verified
    cases.supervision.JobDied
                             6   the system or a library ended the program
    Cancelled              130   the user asked to stop
"""


class LimbgramError(Exception):
    """Root of every refusal; `exit_code` is what the command line returns."""

    exit_code = 4


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


class PlacementError(LimbgramError):
    """The photos cannot be joined to one scene."""


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


class Cancelled(LimbgramError):
    """The user asked to stop; what is finished is kept."""

    exit_code = 130
