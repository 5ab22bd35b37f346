"""Labels: places for a text, on wide and gently curved parts of a device."""

from limbgram.workbench.devices.device import Label
from limbgram.workbench.devices.trims import TrimPoint

BEHIND_CALF = Label(
    at=TrimPoint(
        name="calf, behind",
        at="fibula head",
        up_mm=("-below_fibula_mm", -60.0),
        around_deg=180.0,
    ),
    runs="up",
)
FRONT_OF_SHIN = Label(
    at=TrimPoint(name="shin", at="tibial tubercle", up_mm=-60.0, around_deg=0.0),
    runs="up",
)
UNDER_SOLE = Label(
    at=TrimPoint(
        name="sole",
        at="heel",
        towards="second toe",
        share=0.35,
        axes="foot",
        seen_from="plantar",
    ),
    runs="ahead",
)
BESIDE_WAIST = Label(
    at=TrimPoint(name="side, right", at="navel", around_deg=90.0),
    runs="round",
)


def beside_socket(to: str) -> Label:
    """Laterally, half way up from the distal end to a landmark."""
    return Label(
        at=TrimPoint(name="side", at="distal end", towards=to, share=0.5, around_deg=90.0),
        runs="up",
    )
