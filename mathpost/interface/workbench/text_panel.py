"""Commands whose answer is their printed text: explain, pose, plane, verify, head."""

import argparse
import io
from collections.abc import Callable
from contextlib import redirect_stdout
from html import escape
from pathlib import Path

from mathpost.files import read_text
from mathpost.interface.workbench.run import Made

PAGE = "page.html"
# First words of the lines with the verdict, if it is not the first line.
VERDICT = {"verify": ("travel", "CL data", "rapid")}


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
    words = VERDICT.get(options.command, ())
    told = [next((line for line in lines if line.startswith(word)), "") for word in words]
    verdict = "; ".join(" ".join(line.split()) for line in told if line) or lines[0]
    return Made(verdict, pages, files, fine=status == 0)
