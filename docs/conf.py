"""The manual: Sphinx with myst. `make docs` builds it; pages of `generated/` are
written first, by `_ext/generate.py`.

Sphinx, as most of the manual is docstrings in the numpy convention and data of the
package: it reads them, checks all references, and takes warnings as errors. Equations
of docstrings are literal blocks, those of pages are MathML, so that neither building
nor reading needs a network.
"""

import sys
from pathlib import Path

HERE = Path(__file__).parent
sys.path[:0] = [str(HERE / "_ext"), str(HERE.parent)]

import generate  # noqa: E402

import contbed  # noqa: E402

generate.write(HERE / "generated")

project = "contbed"
author = "the contbed developers"
copyright = "the contbed developers"
version = release = contbed.__version__

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.napoleon",
    "docstrings",
    "mathml",
]
myst_enable_extensions = ["deflist", "dollarmath", "fieldlist"]
myst_heading_anchors = 4
exclude_patterns = ["_ext", "_build", "notebooks"]
default_role = "code"
html_theme = "furo"
html_title = "contbed"
html_static_path = ["_static"]
html_css_files = ["manual.css"]
html_copy_source = False
autodoc_member_order = "bysource"
autodoc_typehints = "description"
autodoc_typehints_description_target = "documented_params"
napoleon_use_rtype = False
# what the examples of the manual show is TOML, output of a terminal and Python
highlight_language = "python"
