"""Commands whose answer is their printed text: explain, pose, plane, verify, head."""

import argparse
import io
from collections.abc import Callable
from contextlib import redirect_stdout
from html import escape
from pathlib import Path
from typing import Any

from mathpost.files import read_text
from mathpost.interface.workbench.panel import Panel
from mathpost.interface.workbench.run import Made

PAGE = "page.html"
VERDICT = {
    "verify": ("travel", "CL data", "rapid")
}  # first words of the lines with the verdict, if it is not the first line


def explain(**values: Any) -> Panel:
    """Return the panel of ``explain``: which misreading gives this number."""
    return Panel("explain", work, ("angles", "sequence", "point", "result", "machine", "axis"), values)


def pose(**values: Any) -> Panel:
    """Return the panel of ``pose``: a tool axis to every position, or joints to tip and tool axis."""
    return Panel("pose", work, ("machine", "axis", "tip", "joints", "present"), values)


def plane(**values: Any) -> Panel:
    """Return the panel of ``plane``: a tilted plane in every control's words."""
    return Panel("plane", work, ("words", "point", "normal", "machine", "present"), values)


def verify(**values: Any) -> Panel:
    """Return the panel of ``verify``: a program of any post against its CL data."""
    return Panel("verify", work, ("program", "machine", "dialect", "cl", "origin"), values)


def head(**values: Any) -> Panel:
    """Return the panel of ``head``: a horizontal head from its measured vectors."""
    return Panel("head", work, ("vectors", "at", "turns", "measured", "sigma"), values)


def work(options: argparse.Namespace, say: Callable[..., None], folder: Path) -> Made:
    """Run the command as the shell does, and show its printed text, and the page that it can write."""
    say(options.command)
    if has_page := "page" in options:
        options.page = folder / PAGE
    with redirect_stdout(io.StringIO()) as said:
        status = options.run(options)
    text = said.getvalue()
    pages, files = {"Answer": f"<pre>{escape(text)}</pre>"}, {f"{options.command}.txt": text.encode()}
    if has_page:
        page = read_text(options.page)
        frame = 'style="width:100%;height:640px;border:0" sandbox="allow-scripts" title="machine"'
        pages["Machine"] = f'<iframe {frame} srcdoc="{escape(page)}"></iframe>'
        files[PAGE] = page.encode()
    lines = list(filter(None, text.splitlines()))
    told = [
        next((line for line in lines if line.startswith(word)), "") for word in VERDICT.get(options.command, "")
    ]
    verdict = "; ".join(" ".join(line.split()) for line in told if line) or lines[0]
    return Made(verdict, pages, files, fine=status == 0)
