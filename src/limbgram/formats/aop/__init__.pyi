"""AOP: its names, each imported when it is first used."""

from .cost import AopReport, DistalCap, GirthLevel
from .grammar import AopFile, AopLandmark, parse_aop
from .profiles import Profile, landmarks_to_file
from .reading import PLACE_COMMENT, AopReading, read_aop, read_aop_soup
from .writing import AopOptions, LineEnd, Own, write_aop

__all__ = [
    "PLACE_COMMENT",
    "AopFile",
    "AopLandmark",
    "AopOptions",
    "AopReading",
    "AopReport",
    "DistalCap",
    "GirthLevel",
    "LineEnd",
    "Own",
    "Profile",
    "landmarks_to_file",
    "parse_aop",
    "read_aop",
    "read_aop_soup",
    "write_aop",
]
