"""The pages of docs/ as a site: `sphinx-build -W -b html docs build/site`.

A warning, such as a broken link or a name that is gone, fails.
"""

from dataclasses import is_dataclass

from sphinx.application import Sphinx
from sphinx.ext.napoleon import Config, GoogleDocstring

project = "limbgram"
author = "the authors of limbgram"

extensions = ["myst_parser", "sphinx.ext.autodoc"]
myst_heading_anchors = 3

autodoc_default_options = {"members": True, "undoc-members": True}
autodoc_member_order = "bysource"
autodoc_preserve_defaults = True
autodoc_typehints_format = "short"
python_maximum_signature_line_length = 88
add_module_names = False
default_role = "code"

html_theme = "furo"
html_title = "limbgram"
html_copy_source = False
html_show_copyright = False
html_show_sphinx = False


def sections(
    app: Sphinx, what: str, name: str, thing: object, options: object, lines: list[str]
) -> None:
    """Args and Raises of a function as Sphinx has them; what a field says stays as it is."""
    if what not in ("attribute", "data", "property"):
        lines[:] = GoogleDocstring(lines, Config(), app, what, name, thing, options).lines()


def signature(
    app: Sphinx, what: str, name: str, thing: object, options: object, *shown: str | None
) -> tuple[str, None] | None:
    """A dataclass is called with its fields, which follow anyway."""
    return ("", None) if what == "class" and is_dataclass(thing) else None


def setup(app: Sphinx) -> None:
    app.connect("autodoc-process-docstring", sections)
    app.connect("autodoc-process-signature", signature)
