"""AOP: the exchange format of the trade, a radius map round the carving axis."""

from limbgram.shape.reading.aop.grammar import AopFile, AopLandmark, parse_aop
from limbgram.shape.reading.aop.profiles import Profile, landmarks_to_file
from limbgram.shape.reading.aop.radiusmap import RadiusMap
from limbgram.shape.reading.aop.reading import PLACE_COMMENT, AopReading, read_aop, read_aop_soup

__all__ = [
    "PLACE_COMMENT",
    "AopFile",
    "AopLandmark",
    "AopReading",
    "Profile",
    "RadiusMap",
    "landmarks_to_file",
    "parse_aop",
    "read_aop",
    "read_aop_soup",
]
