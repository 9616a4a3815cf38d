"""Sphinx's configuration: the field's theme and search, formulas without a script, nothing that needs a network."""

import re
from importlib import metadata
from itertools import pairwise

from docutils import nodes
from latex2mathml.converter import convert
from sphinx.application import Sphinx
from sphinx.search.en import SearchEnglish
from sphinx.writers.html5 import HTML5Translator

project, version = "mathpost", metadata.version("mathpost")
extensions = [
    "myst_nb", "sphinx.ext.autodoc", "sphinx.ext.autosummary", "sphinx.ext.napoleon", "sphinx.ext.intersphinx",
]  # fmt: skip
nb_execution_mode = "off"  # tests run the lessons
myst_enable_extensions = ["dollarmath"]
myst_heading_anchors = 3
templates_path = ["templates"]
default_role = "py:obj"
suppress_warnings = ["mystnb.unknown_mime_type", "ref.python"]  # data behind a verdict; names in two modules
autodoc_default_options = {"members": True}
autodoc_member_order = "bysource"
intersphinx_mapping = {
    "python": ("https://docs.python.org/3", None),
    "numpy": ("https://numpy.org/doc/stable", None),
    "scipy": ("https://docs.scipy.org/doc/scipy", None),
    "sympy": ("https://docs.sympy.org/latest", None),
}
intersphinx_timeout = 5  # s; without a network these links are left out

html_theme, html_title = "pydata_sphinx_theme", "mathpost"
html_static_path, html_css_files = ["static"], ["site.css"]
html_sidebars: dict[str, list[str]] = {"**": []}
html_math_renderer = "mathml"
html_copy_source = html_show_search_summary = False  # a page opened from a disk may not read others
html_search_language = "mathpost"
html_context = {"default_mode": "auto"}
html_theme_options = {
    "show_nav_level": 0, "header_links_before_dropdown": 5, "search_bar_text": "Search", "article_header_start": [],
    "secondary_sidebar_items": {"**": ["page-toc"], "index": []},
    "footer_start": ["licence"], "footer_end": [],
}  # fmt: skip

CHINESE = "\u3400-\u9fff"


class Search(SearchEnglish):
    """English words, with hyphens as in --axis-tolerance; of Chinese, which has no spaces, each two neighbours."""

    lang = "mathpost"
    js_splitter_code = f"""
const chinese = /[{CHINESE}]/, runs = /[{CHINESE}]+|[^{CHINESE}-][^{CHINESE}]*/g;
const paired = run => run.slice(1).map((each, i) => run[i] + each);
const pairs = run => chinese.test(run) && run.length > 1 ? paired([...run]) : [run.replace(/-+$/, "")];
const words = query => query.split(/[^\\p{{L}}\\p{{N}}_-]+/u);
var splitQuery = query => words(query).flatMap(word => word.match(runs) ?? []).flatMap(pairs);
"""

    def split(self, input: str) -> list[str]:
        """Return what is found: words and their parts, characters and pairs of them."""
        found: list[str] = []
        for run in re.findall(f"[{CHINESE}]+|[^\\W{CHINESE}]+(?:-[^\\W{CHINESE}]+)*", input):
            pairs = [*run, *map("".join, pairwise(run))]
            found += pairs if run[0] >= "\u3400" else dict.fromkeys([run, *run.split("-")])
        return found


def formula(page: HTML5Translator, node: nodes.Element) -> None:
    """Write a formula as MathML, a displayed one in a box that scrolls."""
    block = isinstance(node, nodes.math_block)
    made = convert(node.astext(), display="block" if block else "inline")
    page.body.append(f'<div class="formula" tabindex="0">{made}</div>' if block else made)
    raise nodes.SkipNode


def setup(app: Sphinx) -> None:
    """Tell Sphinx of both."""
    app.add_html_math_renderer("mathml", (formula, None), (formula, None))
    app.add_search_language(Search)
