"""A lesson as part of a page: the facts in its first cells, and all cells as HTML that needs no server.

Links lead to the published lessons, formulas become MathML, solutions are left out. Answers to a guess are folded.
"""

import re
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import nbformat
from jinja2 import pass_context
from jinja2.runtime import Context
from latex2mathml.converter import convert
from nbconvert import HTMLExporter
from nbconvert.filters.markdown_mistune import IPythonRenderer, MarkdownWithMath
from nbconvert.preprocessors import Preprocessor, TagRemovePreprocessor
from nbformat import NotebookNode
from traitlets.config import Config

from mathpost.errors import InputError

TEMPLATES = Path(__file__).parent / "templates"
GUESS = re.compile(r"^Write a guess in the place of None.*\n?", re.MULTILINE)  # there is nothing to run in a page
NOTEBOOK = re.compile(r"""((?:\]\(|href=["'])[^)"':\s]+)\.ipynb(?=[)"'#])""")
OF_JUPYTER = re.compile(r"\A<style>.*?</style>", re.DOTALL)  # of a panel; in a page a style belongs in the head
QUOTED = re.compile('"([^"]+)"')


@dataclass(frozen=True)
class Lesson:
    """A notebook and the facts that its first cells state; empty where they do not."""

    path: Path
    title: str  # such as "05 · The inverse: from the tool to the joints (运动学逆解)"
    needs: tuple[str, ...]  # names of the lessons that come before
    minutes: str
    goals: tuple[str, ...]  # what a reader can do afterwards, Markdown
    code: tuple[str, ...]  # its cells
    body: str  # HTML

    @property
    def name(self) -> str:
        """The name of the notebook without its ending."""
        return self.path.stem

    @property
    def short(self) -> str:
        """The title without the text in parentheses."""
        return re.sub(r"\s*\([^)]*\)$", "", self.title)


class Offline(Preprocessor):
    """Turns links between notebooks into links between pages, formulas in outputs into MathML; numbers views."""

    def preprocess(self, nb: NotebookNode, resources: dict[str, Any]) -> tuple[NotebookNode, dict[str, Any]]:
        """Change all cells."""
        self.views = 0
        return super().preprocess(nb, resources)

    def preprocess_cell(
        self, cell: NotebookNode, resources: dict[str, Any], index: int
    ) -> tuple[NotebookNode, dict[str, Any]]:
        """Change one cell."""
        if cell.cell_type == "markdown":
            cell.source = relinked(cell.source)
        for output in cell.get("outputs", []):
            if "text" in output:
                output["text"] = GUESS.sub("", output["text"])
            data = output.get("data", {})
            for kind in {"text/html", "text/markdown"} & data.keys():
                shown = OF_JUPYTER.sub("", relinked(data[kind]))
                data[kind] = re.sub('<iframe title="view"', self._titled, shown)
            if "text/latex" in data:
                data["text/html"] = f"<div>{formula(data.pop('text/latex').strip('$ '), block=True)}</div>"
            if "image/png" in data:
                output["alt"] = described(output)
        cell.outputs = [output for output in cell.get("outputs", []) if output.get("text", "shown").strip()]
        return cell, resources

    def _titled(self, _: re.Match[str]) -> str:
        self.views += 1
        return f'<iframe title="Moving view {self.views}"'


def relinked(text: str) -> str:
    """Return Markdown or HTML whose links to notebooks lead to pages."""
    return NOTEBOOK.sub(r"\1.html", text)


def formula(latex: str, *, block: bool = False) -> str:
    """Return LaTeX as MathML."""
    return convert(latex, display="block" if block else "inline")


def described(output: dict) -> str:
    """Return the alternative text of a picture: axes and names from its description in numbers."""
    lines = output.get("metadata", {}).get("image/png", {}).get("alt", "picture").splitlines()
    panels = [line for line in lines if line.startswith("picture")]
    names = dict.fromkeys(name for line in lines if not line.startswith("picture") for name in QUOTED.findall(line))
    return "; ".join(panels) + (f"; it shows {', '.join(names)}" if names else "")


class Formulas(IPythonRenderer):
    """Markdown whose formulas become MathML."""

    def inline_math(self, body: str) -> str:
        """Return a formula within a line."""
        return formula(body)

    def block_math(self, body: str) -> str:
        """Return a displayed formula."""
        return formula(body, block=True)


def markdown(text: str, attachments: dict | None = None) -> str:
    """Return Markdown as HTML; `attachments` are the pictures of a cell."""
    renderer = Formulas(escape=False, exclude_anchor_links=True, attachments=attachments or {})
    return MarkdownWithMath(renderer=renderer).render(text)


@pass_context
def _cell(context: Context, text: str) -> str:
    """The filter of nbconvert's templates."""
    return markdown(text, context.get("cell", {}).get("attachments"))


def exporter() -> HTMLExporter:
    """Return the exporter that turns a notebook into the inside of a page."""
    config = Config()
    config.TemplateExporter.extra_template_basedirs = [str(TEMPLATES)]
    config.TemplateExporter.filters = {"markdown2html": _cell}
    config.HTMLExporter.preprocessors = [Offline, TagRemovePreprocessor]
    config.TagRemovePreprocessor.remove_cell_tags = {"solution"}
    return HTMLExporter(config=config, template_name="notebook")


def read(path: Path, made: HTMLExporter) -> Lesson:
    """Return a lesson; `InputError` if the file is not a notebook."""
    try:
        notebook = nbformat.read(path, as_version=4)
    except (OSError, ValueError) as error:
        raise InputError(f"{path}", "a notebook", f"{error}".splitlines()[0]) from None
    head, *later = [cell.source for cell in notebook.cells if cell.cell_type == "markdown"][:2] or [path.stem]
    before, _, minutes = head.partition("**Time**")
    _, _, needs = before.partition("**You need first**")
    goals = later[0].partition("**Afterwards you can**")[2].partition("\n#")[0] if later else ""
    body, _ = made.from_notebook_node(notebook)
    return Lesson(
        path=path,
        title=head.splitlines()[0].lstrip("# "),
        needs=tuple(dict.fromkeys(re.findall(r"\]\(([^)/]+)\.ipynb\)", needs))),
        minutes=(re.findall(r"\d+", minutes) or [""])[0],
        goals=tuple(re.findall(r"^- (.*?)[;.]?$", re.sub(r"\n(?!- )", " ", goals.strip()), re.MULTILINE)),
        code=tuple(cell.source for cell in notebook.cells if cell.cell_type == "code"),
        body=body,
    )
