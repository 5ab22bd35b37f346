"""Transfemoral socket, quadrilateral."""

from limbgram.workbench.devices.device import SOCKET, Device
from limbgram.workbench.devices.presets.brims import QUADRILATERAL
from limbgram.workbench.devices.presets.ends import DISTAL_PAD, PAD, STRIP, strip_behind
from limbgram.workbench.devices.presets.labels import beside_socket

DEVICE = Device(
    name="quadrilateral-socket",
    kind="transfemoral",
    order=23,
    en="Transfemoral socket, quadrilateral",
    de="Oberschenkelschaft, queroval",
    trim=QUADRILATERAL,
    label=beside_socket("ischial tuberosity"),
    wall=SOCKET,
    pads=(DISTAL_PAD,),
    ridges=(strip_behind("ischial tuberosity"),),
    adapter="hip",
    more=(PAD, STRIP),
)
