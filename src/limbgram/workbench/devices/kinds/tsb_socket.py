"""Transtibial socket, TSB."""

from limbgram.workbench.devices.device import SOCKET, Device
from limbgram.workbench.devices.presets.brims import TSB
from limbgram.workbench.devices.presets.ends import DISTAL_PAD, PAD, STRIP, strip_behind
from limbgram.workbench.devices.presets.labels import beside_socket

DEVICE = Device(
    name="tsb-socket",
    kind="transtibial",
    order=22,
    en="Transtibial socket, TSB",
    de="Unterschenkelschaft, Vollkontakt",
    trim=TSB,
    label=beside_socket("patellar tendon"),
    wall=SOCKET,
    pads=(DISTAL_PAD,),
    ridges=(strip_behind("patellar tendon"),),
    adapter="knee",
    more=(PAD, STRIP),
)
