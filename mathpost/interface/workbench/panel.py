"""A command of the shell as a panel: its options as controls, run and cancel, results, downloads."""

import base64
import os
import threading
import time
from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from typing import Any

import ipywidgets as widgets
from IPython.display import display

from mathpost.errors import MathpostError
from mathpost.files import read_text, write_bytes
from mathpost.interface.workbench.options import IS_APP, Option, options
from mathpost.interface.workbench.run import Made, Run

SENTENCE = "Run this cell: it needs Python."
STYLE = Path(__file__).parent / "panel.css"
# Where there is no Python, the sentence is shown instead of JupyterLab's message on a widget that it cannot find.
WITHOUT_PYTHON = """.jp-OutputArea:has(.mathpost-panel:not(.jupyter-widgets-disconnected)) .mathpost-sentence,
.jp-OutputArea:has(.mathpost-sentence) .jp-OutputArea-child + * .jp-OutputArea-output:not(:has(*)),
.mathpost-panel.jupyter-widgets-disconnected { display: none }
.mathpost-sentence { padding: 8px 12px; border: 1px dashed #bbb; max-width: 560px }"""
LARGEST = 32 * 2**20  # bytes of a download; more is saved to a folder
WIDE = widgets.Layout(width="100%")


class Shown(widgets.VBox):
    """Controls and a line with their result; where there is no Python, one sentence."""

    def __init__(
        self, command: str, controls: Sequence[widgets.Widget], below: Sequence[widgets.Widget] = ()
    ) -> None:
        self.command, self.said = command, widgets.HTML()
        style = widgets.HTML(f"<style>{read_text(STYLE)}</style>")
        super().__init__([style, *controls, self.said, *below], layout=WIDE)
        self.add_class("mathpost-panel")

    def tell(self, text: str, kind: str = "") -> None:
        """Show one line: a result, or an error."""
        self.said.value = f'<div class="mathpost-said {kind}" role="status">{escape(text)}</div>'

    def __repr__(self) -> str:
        return f"{self.command}: {SENTENCE}"

    def _ipython_display_(self, **_kwargs: Any) -> None:
        """Show a sentence for readers without Python, and the panel in its place for those with it."""
        sentence = f'<style>{WITHOUT_PYTHON}</style><div class="mathpost-sentence">{SENTENCE}</div>'
        display({"text/plain": repr(self), "text/html": sentence}, raw=True)
        view = self._repr_mimebundle_()
        display({kind: view[kind] for kind in view if "widget-view" in kind}, raw=True)


class Panel(Shown):
    """A panel of one command.

    Parameters
    ----------
    command : str
        One of `mathpost.interface.shell.main.COMMANDS`.
    work : callable
        ``work(options, say, folder)``, a function of a module, makes a `Made` in a process of its own; the folder
        is removed when it ends. ``say(stage, done, total, row)`` reports its progress; a `row`, HTML, is added to
        those shown.
    first : sequence of str
        The options in sight; the others are in a section that unfolds.
    values : dict
        Initial values of options.
    """

    def __init__(self, command: str, work: Callable, first: Sequence[str], values: dict[str, Any]) -> None:
        self.work = work
        self.options = options(command, dict(values))
        self.run = widgets.Button(description="Run", button_style="primary", tooltip="with the values above")
        self.cancel = widgets.Button(description="Cancel", disabled=True, tooltip="stop at once; nothing is left")
        self.bar = widgets.FloatProgress(min=0, max=1, layout=widgets.Layout(width="220px"))
        self.stage = widgets.HTML()
        self.found, self.rows = widgets.VBox(layout=WIDE), widgets.VBox(layout=WIDE)
        self.sections = widgets.Accordion(layout=WIDE)
        self.files: dict[str, bytes] = {}
        self.running: Run | None = None
        self.thread: threading.Thread | None = None
        self.run.on_click(lambda _: self.start())
        self.cancel.on_click(lambda _: self.running and self.running.stop())
        buttons = widgets.HBox([self.run, self.cancel, self.bar, self.stage])
        shown = [self.options[name].box for name in first]
        super().__init__(command, [*shown, self.sections, buttons], [self.found])
        if more := [each.box for name, each in self.options.items() if name not in first]:
            self.section("Further options", widgets.VBox(more))

    def section(self, title: str, content: widgets.Widget) -> None:
        """Add a section that unfolds."""
        self.sections.children = (*self.sections.children, content)
        self.sections.set_title(len(self.sections.children) - 1, title)

    def __getitem__(self, name: str) -> Option:
        """Return the control of an option."""
        return self.options[name]

    def words(self, folder: Path) -> list[str]:
        """Return the command line that the controls make; files that it needs are written into `folder`."""
        return [self.command, *(word for each in self.options.values() for word in each.words(folder))]

    def start(self) -> None:
        """Run the command; `wait` for its end."""
        if self.thread is not None and self.thread.is_alive():
            return
        self.running = run = Run(self.work)
        self.files = {}
        self.said.value, self.stage.value, self.rows.children, self.found.children = "", "", (), (self.rows,)
        try:
            words = self.words(run.folder)
        except MathpostError as error:
            run.clear()
            self.tell(str(error).removeprefix(f"{run.folder}{os.sep}"), "wrong")
            return
        self.run.disabled, self.cancel.disabled, self.bar.value = True, False, 0
        self.begun = time.monotonic()
        self.now: tuple[str, float] = ("starting", self.begun)
        self.thread = threading.Thread(target=self._follow, args=(run, words), daemon=True)
        self.thread.start()

    def wait(self) -> None:
        """Wait until the run has ended."""
        if self.thread is not None:
            self.thread.join()

    def _follow(self, run: Run, words: list[str]) -> None:
        made = run(words, self.told)
        self.run.disabled, self.cancel.disabled = False, True
        if isinstance(made, Made):
            self.bar.value = 1
            self.stage.value = f"{time.monotonic() - self.begun:.1f} s"
            self.tell(made.said, {True: "right", False: "wrong", None: ""}[made.fine])
            self.show(made)
        else:
            self.bar.value, self.stage.value = 0, ""
            self.tell(made or "stopped: nothing is left of this run", "wrong" if made else "")

    def told(self, stage: str = "", done: float = 0, total: float = 0, row: str = "") -> None:
        """Show the progress of the run: the stage and its seconds, and a result so far."""
        if row:
            self.rows.children = (*self.rows.children, widgets.HTML(row, layout=WIDE))
        if stage and stage != self.now[0]:
            self.now = (stage, time.monotonic())
        if total:
            self.bar.value = done / total
        stage, since = self.now
        self.stage.value = f"{escape(stage)} … {time.monotonic() - since:.0f} s"

    def show(self, made: Made) -> None:
        """Show the results: pages in tabs, and downloads."""
        self.files = made.files
        pages = widgets.Tab([widgets.HTML(page, layout=WIDE) for page in made.pages.values()], layout=WIDE)
        pages.titles = tuple(made.pages)
        self.found.children = (self.downloads(), *[pages] * bool(made.pages), self.rows)

    def downloads(self) -> widgets.Widget:
        """Return links that save each file, and a field to write all of them to a folder."""
        links = [download(name, content) for name, content in self.files.items() if len(content) <= LARGEST]
        if not self.files:
            return widgets.HTML()
        if IS_APP:
            return widgets.HTML(" ".join(links))
        where = widgets.Text(
            placeholder="or a folder on the server", description="save to", layout={"width": "300px"}
        )
        button, said = widgets.Button(description="Save", tooltip="write all files there"), widgets.HTML()
        button.on_click(lambda _: self._save(where.value, said))
        return widgets.HBox([widgets.HTML(" ".join(links)), where, button, said])

    def _save(self, folder: str, said: widgets.HTML) -> None:
        try:
            if not (folder := folder.strip()) or not Path(folder).is_dir():
                raise MathpostError(f"{folder or 'save to'}: expected a folder that is there, found none")
            taken = [name for name in self.files if (Path(folder) / name).exists()]
            if taken:
                raise MathpostError(f"{', '.join(taken)}: not written, it is there already")
            for name, content in self.files.items():
                write_bytes(Path(folder) / name, content)
        except MathpostError as error:
            said.value = f'<span class="mathpost-said wrong">{escape(str(error))}</span>'
        else:
            said.value = f"{len(self.files)} written"


def download(name: str, content: bytes) -> str:
    """Return a link that saves a file, as HTML."""
    data = base64.b64encode(content).decode()
    link = f'download="{escape(name)}" href="data:application/octet-stream;base64,{data}"'
    return f'<a class="mathpost-download" {link}>⤓ {escape(name)}</a>'
