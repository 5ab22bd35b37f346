"""Socket, inside: the surface that a socket turns to the limb.

Sensitive places are those of the limb that wears it.
"""

from limbgram.workbench.anatomy.kind import Distance, Kind, Midpoint, Section
from limbgram.workbench.kinds.transtibial import DISTAL_END, PATELLAR_TENDON, POPLITEAL_CREASE
from limbgram.workbench.kinds.transtibial import KIND as TRANSTIBIAL

KIND = Kind(
    name="socket",
    order=8,
    words={"en": "Inside of a socket", "de": "Schaft, innen"},
    sided=True,
    round_ended=True,
    places=(PATELLAR_TENDON.at(4), POPLITEAL_CREASE.at(4), DISTAL_END),
    sensitive=TRANSTIBIAL.sensitive,
    sheet=(
        Distance(
            name="patellar_tendon_to_end_mm",
            en="Patellar tendon to the distal end, along the axis",
            de="Patellasehne bis distales Ende, entlang der Achse",
            start=Midpoint(("distal end",)),
            end=Midpoint(("patellar tendon",)),
            along="long axis",
        ),
        Section(
            name="patellar_tendon_girth_mm",
            en="Girth at the patellar tendon",
            de="Umfang an der Patellasehne",
            at=Midpoint(("patellar tendon",)),
            normal="long axis",
        ),
    ),
)
