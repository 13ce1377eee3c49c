"""Of Sphinx: the documents, the notebooks (run while the site is built), the API of Python by its docstrings and that of C++ by Doxygen.
scripts/site.sh builds it."""

import re
from pathlib import Path

tree = Path(__file__).resolve().parents[2]

project = "sightline"
release = re.search(r"project\(sightline VERSION (\S+)", (tree / "CMakeLists.txt").read_text()).group(1)
extensions = ["myst_parser", "nbsphinx", "sphinx.ext.autodoc", "sphinx.ext.mathjax", "breathe"]
html_theme = "furo"
html_show_copyright = False
html_title = f"sightline {release}"
exclude_patterns = ["site", "notebooks/out"]

myst_enable_extensions = ["dollarmath", "colon_fence"]
myst_heading_anchors = 4
suppress_warnings = ["myst.header"]

nbsphinx_execute = "always"
nbsphinx_timeout = 120
nbsphinx_requirejs_path = ""  # nothing is fetched from elsewhere

autodoc_member_order = "bysource"
breathe_default_project = "sightline"
breathe_default_members = ("members",)

# Formulas by KaTeX of the system, copied into the site, so that they are read without a network.
katex = Path("/usr/share/javascript/katex")
html_static_path = [str(katex), "static"]
html_css_files = ["katex.min.css"]
mathjax_path = "katex.min.js"
mathjax_options = {"defer": "defer"}
html_js_files = [(name, {"defer": "defer"}) for name in ("contrib/auto-render.js", "render_math.js")]
