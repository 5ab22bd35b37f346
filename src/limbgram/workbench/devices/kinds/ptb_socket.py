"""Transtibial socket, PTB."""

from limbgram.workbench.devices.device import SOCKET, Device
from limbgram.workbench.devices.presets.brims import PTB
from limbgram.workbench.devices.presets.ends import DISTAL_PAD, PAD, STRIP, strip_behind
from limbgram.workbench.devices.presets.labels import beside_socket

DEVICE = Device(
    name="ptb-socket",
    kind="transtibial",
    order=20,
    en="Transtibial socket, PTB",
    de="Unterschenkelschaft, PTB",
    trim=PTB,
    label=beside_socket("patellar tendon"),
    wall=SOCKET,
    pads=(DISTAL_PAD,),
    ridges=(strip_behind("patellar tendon"),),
    adapter="knee",
    more=(PAD, STRIP),
)
