"""Transfemoral socket, ischial containment."""

from limbgram.workbench.devices.device import SOCKET, Device, WidthCheck
from limbgram.workbench.devices.presets.brims import ISCHIAL_CONTAINMENT, SKELETAL_ML
from limbgram.workbench.devices.presets.ends import DISTAL_PAD, PAD, STRIP, strip_behind
from limbgram.workbench.devices.presets.labels import beside_socket

DEVICE = Device(
    name="ischial-containment-socket",
    kind="transfemoral",
    order=24,
    en="Transfemoral socket, ischial containment",
    de="Oberschenkelschaft, sitzbeinumfassend",
    trim=ISCHIAL_CONTAINMENT,
    label=beside_socket("ischial tuberosity"),
    wall=SOCKET,
    pads=(DISTAL_PAD,),
    ridges=(strip_behind("ischial tuberosity"),),
    adapter="hip",
    widths=(WidthCheck(measure="skeletal_ml_mm", at="ischial tuberosity"),),
    more=(SKELETAL_ML, PAD, STRIP),
)
