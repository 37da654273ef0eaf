"""How the documentation is built: `make docs`. Nothing in the built pages is fetched from another host."""

import sys
from importlib.metadata import version as version_of
from pathlib import Path

sys.path.insert(0, str(Path(__file__).parent / "_extensions"))

project = "simfield"
author = "The simfield developers"
project_copyright = "the simfield developers, BSD 3-Clause"
version = release = version_of("simfield")

extensions = [
    "myst_parser",
    "sphinx.ext.autodoc",
    "sphinx.ext.viewcode",
    "sphinx_click",
    "mathml",
    "catalogue",
    "plain_docstrings",
]
# paragraphs of single branches, on their way into decisions.md
exclude_patterns = ["_build", "_extensions"]

myst_enable_extensions = ["dollarmath", "colon_fence", "deflist"]
myst_heading_anchors = 3

html_theme = "furo"
html_title = f"simfield {version}"
html_static_path = ["_static"]
html_css_files = ["simfield.css"]
html_math_renderer = "mathml"
html_show_sphinx = False
html_copy_source = False
# A fixed palette of two blues; the fonts are those of the reader's system.
html_theme_options = {
    "light_css_variables": {
        "color-brand-primary": "#0060a0",
        "color-brand-content": "#0060a0",
    },
    "dark_css_variables": {
        "color-brand-primary": "#6cb6e8",
        "color-brand-content": "#6cb6e8",
    },
}
pygments_style = "friendly"

# Names in single backticks of a docstring are links where they lead somewhere, and code elsewhere.
default_role = "py:obj"
# A listing in a docstring is a formula; blocks of code say what they are.
highlight_language = "none"
autodoc_member_order = "bysource"
autodoc_typehints = "signature"
autodoc_default_options = {"members": True}
autodoc_type_aliases = {"Floats": "Floats", "Indices": "Indices"}
autodoc_preserve_defaults = True
python_maximum_signature_line_length = 100
add_module_names = False
