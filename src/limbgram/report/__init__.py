"""Report: pictures, figures and one page about a reconstruction.

In      the products of all stages.
Out     Pictures (PNG), a summary (JSON tree) and a self-contained HTML page.
"""

from limbgram.report.page import page_of, stage_title
from limbgram.report.pictures import Picture, Pictures, draw
from limbgram.report.summary import INTENDED_USE, summarise

__all__ = [
    "INTENDED_USE",
    "Picture",
    "Pictures",
    "draw",
    "page_of",
    "stage_title",
    "summarise",
]
