"""Cast or positive: a shape of plaster or foam of which only side and long axis are said.

Who knows of what limb it is says that kind instead, and has its landmarks and its sheet.
"""

from limbgram.workbench.anatomy.kind import Kind
from limbgram.workbench.kinds.transtibial import DISTAL_END

KIND = Kind(
    name="cast",
    order=7,
    words={"en": "Cast or positive", "de": "Abguss oder Positiv"},
    sided=True,
    round_ended=True,
    places=(DISTAL_END,),
)
