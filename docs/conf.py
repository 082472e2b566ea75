"""The documentation site: `python -m sphinx -W docs site` builds it, without a network and without computing.

What the code says (keys, results of each kind of study, figures, the interface) is written from the code to
docs/generated before Sphinx reads it, so that it cannot fall behind; texts in docs/kinds include what is
written there of their kind. Pages that compute are written to docs/extra.
"""

import re
import sys
from pathlib import Path

DOCS = Path(__file__).parent
sys.path[:0] = [str(DOCS)]

from pages import live, write  # noqa: E402  found by the path above
from pages.text import unmarked  # noqa: E402
from pygments.lexers.special import TextLexer  # noqa: E402

import jointplay  # noqa: E402  after the path, by which nothing of it is found

project = "jointplay"
author = "The jointplay authors"
copyright = author
version = release = jointplay.__version__

extensions = ["myst_parser", "sphinx.ext.autodoc", "sphinx.ext.napoleon", "pages.mathml"]
exclude_patterns = ["pages"]
html_extra_path = ["extra"]
myst_enable_extensions = ["dollarmath", "deflist"]
myst_heading_anchors = 4
highlight_language = "none"  # what names no language is output, and no Python
html_theme = "furo"
html_title = "jointplay"
html_static_path = ["pages/formulas.css"]
html_css_files = ["formulas.css"]
html_math_renderer = "mathml"
html_show_copyright = html_show_sphinx = False
html_copy_source = False

default_role = "literal"  # docstrings quote code in single backticks
napoleon_google_docstring = False
napoleon_use_rtype = False
autodoc_typehints = "none"  # docstrings say types in words
autodoc_member_order = "bysource"


def _without_marks(_app, _page, source):
    """Take the marks of measured numbers away: a line that begins with one would end its paragraph."""
    source[0] = unmarked(source[0])


def _no_signature_of_records(_app, what, _name, _obj, _options, signature, _returns):
    """Take signatures from records: all of their keywords are listed below them."""
    return ("", "") if what == "class" else (signature, "")


def _to_what_is_written(_app, _page, source):
    """Lead to the pages that are written from the code, which a checkout does not have."""
    source[0] = re.sub(r"\]\(((?:\.\./)*)reference\.md#(\w+)", r"](\1generated/\2.md", source[0])
    source[0] = re.sub(r"\]\(((?:\.\./)*)notebooks/(\w+)\.ipynb", r"](\1generated/\2.md", source[0])


def setup(app):
    """Write the generated pages, and let records be described by their keys."""
    app.connect("source-read", _without_marks)
    write(DOCS / "generated")
    live.write(DOCS / "extra" / "live")
    app.add_lexer("csv", TextLexer)
    app.connect("source-read", _to_what_is_written)
    app.connect("autodoc-process-signature", _no_signature_of_records)
