"""A board of known size as a ruler lying in the scene."""

from limbgram.scale.plate.joining import adjusted_with_board
from limbgram.scale.plate.lens import foreign_lens
from limbgram.scale.plate.plate import Plate, find_plate

__all__ = ["Plate", "adjusted_with_board", "find_plate", "foreign_lens"]
