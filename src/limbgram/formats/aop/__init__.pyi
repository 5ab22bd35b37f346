"""AOP: its names, each imported when it is first used."""

from .cost import AopReport, DistalCap, GirthLevel
from .grammar import AopFile, AopLandmark, parse_aop
from .profiles import Profile, landmarks_to_file
from .reading import LIMB_FROM_FILE_COMMENT, AopReading, read_aop, read_aop_soup
from .writing import AopOptions, LineEnd, SourceGrid, write_aop

__all__ = [
    "LIMB_FROM_FILE_COMMENT",
    "AopFile",
    "AopLandmark",
    "AopOptions",
    "AopReading",
    "AopReport",
    "DistalCap",
    "GirthLevel",
    "LineEnd",
    "Profile",
    "SourceGrid",
    "landmarks_to_file",
    "parse_aop",
    "read_aop",
    "read_aop_soup",
    "write_aop",
]
