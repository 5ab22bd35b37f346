"""Transtibial socket, supracondylar."""

from limbgram.workbench.devices.device import SOCKET, Device
from limbgram.workbench.devices.presets.brims import SUPRACONDYLAR
from limbgram.workbench.devices.presets.ends import DISTAL_PAD, PAD, STRIP, strip_behind
from limbgram.workbench.devices.presets.labels import beside_socket

DEVICE = Device(
    name="supracondylar-socket",
    kind="transtibial",
    order=21,
    en="Transtibial socket, supracondylar",
    de="Unterschenkelschaft, suprakondylär",
    trim=SUPRACONDYLAR,
    label=beside_socket("patellar tendon"),
    wall=SOCKET,
    pads=(DISTAL_PAD,),
    ridges=(strip_behind("patellar tendon"),),
    adapter="knee",
    more=(PAD, STRIP),
)
