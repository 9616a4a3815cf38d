"""CL data to a program: its report, the machine walking through it, and why its rotary axes jump."""

import argparse
from collections.abc import Callable, Sequence
from html import escape
from pathlib import Path
from typing import Any

from mathpost.files import write_text
from mathpost.interface.shell import post
from mathpost.interface.workbench.axes import Axes
from mathpost.interface.workbench.panel import Panel
from mathpost.interface.workbench.run import Made
from mathpost.kinematics import Kinematics
from mathpost.path.cl import CLData
from mathpost.shop.post.jumps import jumps
from mathpost.shop.post.postprocess import Result
from mathpost.teaching.course import view_machine

STAGES = ("reading", "choosing", "planning", "writing", "reading back", "proving", "comparing", "drawing")
MOST_LINES = 400  # shown of a program or a list
SUFFIX = {"heidenhain": ".h", "siemens": ".mpf"}


class PostPanel(Panel):
    """The panel of ``post``, with the axes of the machine as numbers that can be changed."""

    def __init__(self, command: str, work: Callable, first: Sequence[str], values: dict[str, Any]) -> None:
        self.axes = Axes()
        super().__init__(command, work, first, {"compare": True} | values)
        self.section("Travel, rates and accelerations of the axes", self.axes)
        machine: Any = self["machine"]
        machine.field.observe(lambda _: self._show_axes(), "value")
        machine.upload.observe(lambda _: self._show_axes(), "value")
        self._show_axes()

    def _show_axes(self) -> None:
        machine: Any = self["machine"]
        content = machine.content()
        self.axes.show(machine.field.value, content and content.decode("utf-8-sig", "replace"))

    def words(self, folder: Path) -> list[str]:
        """Return the command line; a machine whose numbers were changed is a file of its own."""
        words = super().words(folder)
        if (text := self.axes.changed()) is not None:
            changed = folder / f"{Path(self.axes.name).stem}_changed.toml"
            write_text(changed, text)
            words.append(f"--machine={changed}")  # the last one counts
        return words


def work(options: argparse.Namespace, say: Callable[..., None], _folder: Path) -> Made:
    """Make the program as the shell does, and the pages that show it."""

    def stage(name: str) -> None:
        say(name, STAGES.index(name) + 0.5, len(STAGES))

    stage("reading")
    path, setup = post.read(options)
    result = post.made(options, path, setup, stage)
    stage("drawing")
    kin = Kinematics(setup)
    pages = {
        "Report": f"<pre>{escape(str(result.report))}</pre>",
        "Machine": walk(kin, path, result) + why(kin, path, result),
        "Program": shown(result.program),
    }
    files = {f"{Path(path.name).stem}{SUFFIX.get(options.dialect, '.nc')}": result.program.encode()}
    files["report.txt"] = f"{result.report}\n".encode()
    if options.machine.name.endswith("_changed.toml"):
        files[options.machine.name] = options.machine.read_bytes()
    report = result.report
    said = (
        f"{len(result.program.splitlines())} lines, proved: tip {report.path_tip_error:.4f} mm and tool axis "
        f"{report.path_axis_error:.4f}° at most from the CL data, {report.time:.2f} s"
    )
    return Made(said, pages, files)


def walk(kin: Kinematics, path: CLData, result: Result) -> str:
    """Return the machine walking through the records, as HTML; if they are many, every second, third …"""
    view, every = view_machine.short_walk(kin, path, result.joints)
    said = f"<p>Shown is every {every}th record; between them the tip is not on the path.</p>" * (every > 1)
    return said + view._repr_html_()


def why(kin: Kinematics, path: CLData, result: Result) -> str:
    """Return why the rotary axes jump, as HTML."""
    found = jumps(kin, path, result.joints)
    lines = "".join(f"<li>{escape(str(each))}" for each in found[:MOST_LINES])
    more = f"<p>… and {len(found) - MOST_LINES} more" if len(found) > MOST_LINES else ""
    return f"<ul>{lines}</ul>{more}" if found else "<p>No rotary axis jumps from one record to the next.</p>"


def shown(text: str) -> str:
    """Return the first lines of a text, as HTML."""
    lines = text.splitlines()
    more = f"<p>… and {len(lines) - MOST_LINES} more lines</p>" if len(lines) > MOST_LINES else ""
    return f"<pre>{escape(chr(10).join(lines[:MOST_LINES]))}</pre>{more}"
