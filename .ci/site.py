"""Whether the pages of a site ask nothing of other computers: `python .ci/site.py SITE`."""

import re
import sys
from pathlib import Path

LOADED = re.compile(
    r"""<(?:script|link|img|iframe)\b[^>]*\b(?:src|href)=["']?(?:https?:)?//[^>]*>"""
    r"""|url\(["']?(?:https?:)?//[^)]*\)|@import[^;]*//[^;]*;""",
    re.IGNORECASE,
)

pages = [*Path(sys.argv[1]).rglob("*.html"), *Path(sys.argv[1]).rglob("*.css")]
asked = [(page, found) for page in pages for found in LOADED.findall(page.read_text("utf-8"))]
if asked or not pages:
    sys.exit("\n".join(f"{page} loads {found}" for page, found in asked) or "There are no pages.")
