"""AOP: the exchange format of the trade, a radius map round the carving axis."""

from limbgram.formats.aop.cost import AopReport, DistalCap, GirthLevel
from limbgram.formats.aop.grammar import AopFile, AopLandmark, parse_aop
from limbgram.formats.aop.profiles import Profile, landmarks_to_file
from limbgram.formats.aop.reading import PLACE_COMMENT, AopReading, read_aop, read_aop_soup
from limbgram.formats.aop.writing import AopOptions, LineEnd, Own, write_aop
from limbgram.workbench.carving.radius_map import RadiusMap

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
    "RadiusMap",
    "landmarks_to_file",
    "parse_aop",
    "read_aop",
    "read_aop_soup",
    "write_aop",
]
