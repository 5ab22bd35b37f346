"""HTML: a report as one page that holds everything, asks nothing of the network, runs no script.

In      a Report.
Out     HTML text. Pictures are PNG inside it, charts are SVG.
Method  the template `templates/report.html`; jinja2 escapes every word that it is given.
"""

import base64
import re
from html import escape
from itertools import count

from jinja2 import Environment, PackageLoader, StrictUndefined
from markupsafe import Markup

from limbgram.findings import Gravity, advice, sentence
from limbgram.report.blocks import Report
from limbgram.report.drawings.drawing import Chart, Picture

_PX_PER_IN = 135
"""Of a chart on the page: its letters are then as large as those of the captions."""
_LEFT_OUT = re.compile(
    r'<metadata>.*?</metadata>|<style type="text/css">.*?</style>|<!--.*?-->|(?<=<g) id="[^"]*"',
    re.DOTALL,
)
"""What matplotlib says of itself, a style for the whole page, and names that repeat."""
_SVG_HEAD = re.compile(r"\A.*?<svg [^>]*?(viewBox=\"[^\"]*\")[^>]*>", re.DOTALL)
_TYPED = re.compile("`([^`]+)`")
"""What sentences give to be typed, such as an option."""


def _with_code(said: object) -> object:
    if type(said) is not str:
        return said
    return Markup(_TYPED.sub(r"<code>\1</code>", escape(said)))


_TEMPLATES = Environment(
    loader=PackageLoader("limbgram.report"),
    finalize=_with_code,
    autoescape=True,
    undefined=StrictUndefined,
    trim_blocks=True,
    lstrip_blocks=True,
)


def html_of(report: Report) -> str:
    """The report as one self-contained page."""
    number = count(1)

    def image(one: Picture | Chart) -> Markup:
        return _png(one) if isinstance(one, Picture) else _svg_element(one, next(number))

    return _TEMPLATES.get_template("report.html").render(
        report=report, image=image, sentence=sentence, advice=advice, FAULT=Gravity.FAULT
    )


def _png(picture: Picture) -> Markup:
    data = base64.b64encode(picture.png.tobytes()).decode()
    return Markup('<img alt="{}" src="data:image/png;base64,{}">').format(picture.title, data)


def _svg_element(chart: Chart, number: int) -> Markup:
    """The chart as an element of the page; `number` keeps its inner names apart from others'."""
    svg = _LEFT_OUT.sub("", chart.svg(f"chart {number}", chart.width_in, chart.height_in))
    title = escape(chart.title)
    width_px = round(chart.width_in * _PX_PER_IN)
    head = rf'<svg \1 width="{width_px}" role="img" aria-label="{{title}}"><title>{{title}}</title>'
    return Markup(_SVG_HEAD.sub(head, svg, count=1).replace("{title}", title))
