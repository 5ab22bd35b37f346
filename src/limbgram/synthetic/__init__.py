"""Synthetic: rendered captures of synthetic limbs, with the exact truth beside them.

In      CaptureOptions: limb, paint, walk round, lens, board, noise.
Out     a Capture: photos, calibration photos and truth in a folder.
"""

from limbgram.synthetic.capture import Capture, make_capture
from limbgram.synthetic.faults import Faults
from limbgram.synthetic.movement import Movement, MovementKind
from limbgram.synthetic.options import SMALL, CaptureOptions
from limbgram.synthetic.photographer import Lens
from limbgram.synthetic.props.bent import BentShape
from limbgram.synthetic.props.board import CALIBRATION_BOARD, SCALE_BOARD, PrintedBoard
from limbgram.synthetic.props.details import SkinDetails
from limbgram.synthetic.props.limb import LimbKind, Relief
from limbgram.synthetic.props.paint import MAGENTA, Paint, SockSpot, places_mm, scattered_spots
from limbgram.synthetic.props.scan import Scan, distance_for, read_scan
from limbgram.synthetic.props.stickers import SockSticker, sticker_places_mm
from limbgram.synthetic.rendering.shading import Lighting, Shadow
from limbgram.synthetic.truth import SurfacePoints, Truth, stage_truth, surface_points
from limbgram.synthetic.turned_limb import TurnedOver, Turning
from limbgram.synthetic.usual_faults import PHONE, Fault, with_faults

__all__ = [
    "CALIBRATION_BOARD",
    "MAGENTA",
    "PHONE",
    "SCALE_BOARD",
    "SMALL",
    "BentShape",
    "Capture",
    "CaptureOptions",
    "Fault",
    "Faults",
    "Lens",
    "Lighting",
    "LimbKind",
    "Movement",
    "MovementKind",
    "Paint",
    "PrintedBoard",
    "Relief",
    "Scan",
    "Shadow",
    "SkinDetails",
    "SockSpot",
    "SockSticker",
    "SurfacePoints",
    "Truth",
    "TurnedOver",
    "Turning",
    "distance_for",
    "make_capture",
    "places_mm",
    "read_scan",
    "scattered_spots",
    "stage_truth",
    "sticker_places_mm",
    "surface_points",
    "with_faults",
]
