"""What Sphinx reads: copies of the lessons and texts, and a page for each machine and command."""

import re
import shutil
import tempfile
from collections.abc import Iterator
from dataclasses import dataclass
from importlib import metadata
from pathlib import Path
from typing import Any

import nbformat
from jinja2 import Environment, FileSystemLoader, StrictUndefined
from nbformat import NotebookNode

import mathpost
from mathpost import machine_file
from mathpost.detective.causes import CAUSES
from mathpost.errors import InputError
from mathpost.files import data_file, read_text, write_text
from mathpost.interface.site import commands
from mathpost.kinematics import Kinematics
from mathpost.teaching.course import machine_page, view_machine
from mathpost.teaching.course.exercise import EXERCISES

HERE = Path(__file__).parent
TEXTS = ("TEACHING.md", "AUTHORS.md", "../.github/CONTRIBUTING.md", "../CHANGELOG.md")  # relative to the lessons
MIXUPS = "<!-- mix-ups -->"  # the place of the tables in TEACHING.md
FRONT = "dmu50v"  # the machine on the front page
LITE = "lite/index.html"  # the lessons that run in the browser, if they were built there
NOTEBOOK = re.compile(r"""(href=["'][^"':\s]+)\.ipynb(?=["'#])""")
GUESS = re.compile(r"^Write a guess in the place of None.*\n?", re.MULTILINE)  # there is nothing to run in a page
QUOTED = re.compile('"([^"]+)"')


@dataclass(frozen=True)
class Lesson:
    """A notebook and the facts that its first cells state; empty where they do not."""

    name: str
    notebook: NotebookNode

    @property
    def texts(self) -> list[str]:
        """The first two cells of text."""
        found = [cell.source for cell in self.notebook.cells if cell.cell_type == "markdown"]
        return [*found, "", ""][:2]

    @property
    def title(self) -> str:
        """Such as "05 · The inverse: from the tool to the joints (运动学逆解)"."""
        return self.texts[0].partition("\n")[0].lstrip("# ") or self.name

    @property
    def needs(self) -> list[str]:
        """The names of the lessons that come before."""
        needs = self.texts[0].partition("**Time**")[0].partition("**You need first**")[2]
        return list(dict.fromkeys(re.findall(r"\]\(([^)/]+)\.ipynb\)", needs)))

    @property
    def minutes(self) -> str:
        """How long it takes."""
        return (re.findall(r"\d+", self.texts[0].partition("**Time**")[2]) or [""])[0]

    @property
    def goals(self) -> str:
        """What a reader can do afterwards, a list in Markdown."""
        return self.texts[1].partition("**Afterwards you can**")[2].partition("\n#")[0].strip(" :…\n")


def read(path: Path) -> Lesson:
    """Return a lesson; `InputError` if the file is not a notebook."""
    try:
        return Lesson(path.stem, nbformat.read(path, as_version=4))
    except (OSError, ValueError) as error:
        raise InputError(f"{path}", "a notebook", f"{error}".splitlines()[0]) from None


def page(lesson: Lesson, head: str) -> NotebookNode:
    """Return a lesson as MyST-NB takes it: `head` under the title, solutions left out, hidden code folded."""
    made, views = nbformat.from_dict(lesson.notebook), 0
    made.cells = [cell for cell in made.cells if "solution" not in cell.metadata.get("tags", [])]
    if not made.cells or made.cells[0].cell_type != "markdown" or not made.cells[0].source.startswith("# "):
        made.cells.insert(0, nbformat.v4.new_markdown_cell(f"# {lesson.name}"))
    title, _, text = made.cells[0].source.partition("\n")
    made.cells[0].source = f"{title}\n\n{head}\n{text}"
    for cell in made.cells:
        cell.source = NOTEBOOK.sub(r"\1.html", cell.source) if cell.cell_type == "markdown" else cell.source
        if cell.metadata.get("jupyter", {}).get("source_hidden"):
            cell.metadata.tags = [*cell.metadata.get("tags", []), "hide-input"]
        for output in cell.get("outputs", []):
            data = output.get("data", {})
            if "text" in output:
                output.text = GUESS.sub("", output.text)
            if "text/html" in data:
                shown = NOTEBOOK.sub(r"\1.html", data["text/html"])
                views += shown.count('<iframe title="view"')
                data["text/html"] = shown.replace('<iframe title="view"', f'<iframe title="Moving view {views}"')
            if "image/png" in data:
                cell.metadata.mystnb = {"image": {"alt": described(output)}}
        if "outputs" in cell:
            cell.outputs = [output for output in cell.outputs if output.get("text", "shown").strip()]
    return made


def described(output: dict) -> str:
    """Return the alternative text of a picture: axes and names from its description in numbers."""
    lines = output.get("metadata", {}).get("image/png", {}).get("alt", "picture").splitlines()
    panels = [line for line in lines if line.startswith("picture")]
    names = dict.fromkeys(name for line in lines if not line.startswith("picture") for name in QUOTED.findall(line))
    return "; ".join(panels) + (f"; it shows {', '.join(names)}" if names else "")


def pages(folder: Path, output: Path) -> Iterator[tuple[str, str]]:
    """Yield the names and the text of all that Sphinx reads."""
    lessons = [read(path) for path in sorted(folder.glob("*.ipynb"))]
    if not lessons:
        raise InputError(f"{folder}", "a folder of notebooks", "none")
    urls = dict(each.split(", ") for each in metadata.metadata("mathpost").get_all("Project-URL", []))
    machines = {p.stem: Kinematics(machine_file.load(p)) for p in sorted(data_file("machines").glob("*.toml"))}
    shell = commands.read(folder)
    texts = {Path(name).stem.lower(): folder / name for name in TEXTS if (folder / name).exists()}
    jinja = Environment(
        loader=FileSystemLoader(HERE / "templates"), undefined=StrictUndefined, trim_blocks=True, lstrip_blocks=True
    )
    jinja.filters["plain"] = lambda text: re.sub(r"([\\`*_\[\]<$|])", r"\\\1", text)
    jinja.globals |= {
        "lessons": lessons, "machines": machines, "commands": shell, "texts": list(texts),
        "axes": machine_page.axes, "arrangements": machine_page.ARRANGEMENTS, "reach": machine_page.reach,
        "view": lambda kin: view_machine.machine(kin)._repr_html_(), "lite": (output / LITE).exists(),
        "causes": sorted(CAUSES.values(), key=lambda cause: -len(cause["seen"])),
        "slips": [(name.partition("-")[0], name, slip) for name in EXERCISES for slip in EXERCISES[name].slips],
        "offered": {name: getattr(mathpost, name) for name in mathpost.__all__}, "project": urls.get("Repository", "").rstrip("/").partition("://github.com/")[2],
    }  # fmt: skip

    def filled(template: str, **values: Any) -> str:
        return jinja.get_template(f"{template}.md.j2").render(**values)

    yield "index.md", filled("front", kin=machines[FRONT])
    for name in ("lessons", "machines", "commands", "reference"):
        yield f"{name}/index.md", filled(name)
    for each in lessons:
        yield f"lessons/{each.name}.ipynb", nbformat.writes(page(each, filled("head", lesson=each)))
    for name, kin in machines.items():
        yield f"machines/{name}.md", filled("machine", kin=kin)
    for command in shell:
        yield f"commands/{command['name']}.md", filled("command", command=command)
    for name, path in texts.items():
        text = re.sub(r"\]\(([^):/]+)\.ipynb\)", r"](lessons/\1.ipynb)", read_text(path))
        text = re.sub(r"\]\((?:\.\.?[\w.]*/)*(?:\w+/)*(\w+)\.md\)", lambda link: f"]({link[1].lower()}.md)", text)
        yield f"{name}.md", text.replace(MIXUPS, filled("mixups") if MIXUPS in text else "")


def build(folder: Path, output: Path) -> int:
    """Write the pages of a folder of lessons into the folder `output`; return Sphinx's exit status."""
    try:
        from sphinx.cmd.build import build_main
    except ImportError:
        raise InputError("Sphinx", 'that it is installed: pip install -e ".[site]"', "none") from None
    with tempfile.TemporaryDirectory() as work:
        for name, text in pages(folder, output):
            path = Path(work, "source", name)
            path.parent.mkdir(parents=True, exist_ok=True)
            write_text(path, text)
        status = build_main(["-q", "-c", f"{HERE}", "-d", f"{work}/read", f"{work}/source", f"{output}"])
    for path in folder.glob("*.ipynb"):
        shutil.copy(path, output / "lessons")
    return status
