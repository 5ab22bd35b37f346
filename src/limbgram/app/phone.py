"""Phone: a link and a QR code with which a phone in the same network sends photos of one case.

What passes is encrypted where the app is on a network; else it is not, and the reply says so.
"""

import segno
from fastapi import APIRouter, Request
from pydantic import BaseModel, Field

from limbgram.app.phone_port import own_address
from limbgram.app.state import AppStateHere, CaseHere, SessionHere

router = APIRouter(tags=["phone"])


class Phone(BaseModel):
    """The port for a phone."""

    open: bool
    url: str = Field(default="", description="To open on the phone; good once, within 15 minutes.")
    qr_svg: str = Field(default="", description="The same to be photographed: an SVG picture.")
    encrypted: bool = Field(default=False, description="Whether others in the network can listen.")
    closes_s: float = Field(default=0.0, description="Until it closes by itself.")


@router.get("/cases/{case_id}/phone")
def read_phone(app_state: AppStateHere, case: CaseHere) -> Phone:
    """Whether a phone can send photos of this case now."""
    port = app_state.phone_ports.of(case)
    if port is None:
        return Phone(open=False)
    secret = port.access.scheme == "https"
    return Phone(open=True, encrypted=secret, closes_s=port.closes_s)


@router.post("/cases/{case_id}/phone", status_code=201)
def open_phone(
    app_state: AppStateHere,
    case: CaseHere,
    request: Request,
    session: SessionHere,
) -> Phone:
    """Open the port for a phone in the same network, and make a link and a QR code for it."""
    signed = app_state.access.signed(session)
    who = signed.who if signed else ""
    good = app_state.access.vouched(who)
    port = app_state.phone_ports.open(case, request.app, own_address, good)
    token = port.access.new_link_token(f"phone of {who}" if who else "", good)
    url = f"{port.origin}/start?token={token}&to=phone/{case.case_id}"
    picture = segno.make(url, error="m").svg_inline(scale=4, border=2)
    return Phone(
        open=True,
        url=url,
        qr_svg=picture,
        encrypted=port.access.scheme == "https",
        closes_s=port.closes_s,
    )


@router.delete("/cases/{case_id}/phone", status_code=204)
def close_phone(app_state: AppStateHere, case: CaseHere) -> None:
    """Close the port."""
    app_state.phone_ports.close(case)
