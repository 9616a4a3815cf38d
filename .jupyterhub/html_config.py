"""For `jupyter nbconvert --to html`: pages that need no network.

Links lead to the published lessons, formulas become MathML, solutions are left out. What answers a guess is folded.
"""

import re
from pathlib import Path

from latex2mathml.converter import convert
from nbconvert.filters.markdown_mistune import IPythonRenderer
from nbconvert.preprocessors import Preprocessor, TagRemovePreprocessor

c = get_config()  # noqa: F821


GUESS = re.compile(r"^Write a guess in the place of None.*\n?", re.MULTILINE)  # there is nothing to run in a page


class Offline(Preprocessor):
    """Turn links to neighbouring notebooks into links to pages, and formulas of outputs into MathML."""

    def preprocess_cell(self, cell, resources, _index):
        if cell.cell_type == "markdown":
            cell.source = self.relink(cell.source)
        for output in cell.get("outputs", []):
            if "text" in output:
                output["text"] = GUESS.sub("", output["text"])
            data = output.get("data", {})
            for kind in {"text/html", "text/markdown"} & data.keys():
                data[kind] = self.relink(data[kind])
            if "text/latex" in data:
                data["text/html"] = f"<div>{convert(data.pop('text/latex').strip('$ '), display='block')}</div>"
        return cell, resources

    def relink(self, text):
        return re.sub(r"""((?:\]\(|href=["'])[^)"':\s]+)\.ipynb(?=[)"'#])""", r"\1.html", text)


IPythonRenderer.inline_math = lambda renderer, formula: convert(formula)
IPythonRenderer.block_math = lambda renderer, formula: convert(formula, display="block")

c.TemplateExporter.extra_template_basedirs = [str(Path(__file__).parent / "templates")]
c.HTMLExporter.template_name = "offline"
c.HTMLExporter.preprocessors = [Offline, TagRemovePreprocessor]
c.TagRemovePreprocessor.remove_cell_tags = {"solution"}
