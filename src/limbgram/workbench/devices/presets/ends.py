"""Ends of sockets: a pad under the limb's end, and a strip behind that stiffens a printed wall."""

from limbgram.core.request_fields import Within
from limbgram.workbench.devices.device import Pad, Ridge
from limbgram.workbench.devices.trims import Measure, TrimPoint

PAD = Measure(
    name="pad_mm",
    usual=4.0,
    within=Within(0, 8),
    en="Distal pad, on the wall",
    de="Distale Verstärkung, auf der Wand",
)
STRIP = Measure(
    name="strip_mm",
    usual=2.0,
    within=Within(0, 5),
    en="Strip behind, on the wall",
    de="Streifen hinten, auf der Wand",
)
DISTAL_PAD = Pad(
    name="distal pad",
    at=TrimPoint(name="distal end", at="distal end", seen_from="plantar"),
    reach_mm=18.0,
    falloff_mm=25.0,
    add_mm="pad_mm",
)


def strip_behind(to: str) -> Ridge:
    """A strip from the distal end up the back to below a landmark's level."""
    return Ridge(
        name="strip behind",
        through=(
            TrimPoint(name="strip, low", at="distal end", up_mm=45.0, around_deg=180.0),
            TrimPoint(name="strip, high", at=to, up_mm=-30.0, around_deg=180.0),
        ),
        width_mm=24.0,
        falloff_mm=10.0,
        add_mm="strip_mm",
    )
