"""Lessons as tests: printed numbers by tolerance, numbers in the prose by what measured them, texts in pictures."""

import ast
import re

import pytest
from nbval.plugin import IPyNbCell, IPyNbFile

from mathpost.teaching.classroom.lessons import same, without_views
from tests import kernels

# A number in markdown, and behind it, where readers do not see it, what it was measured by and how it is printed:
# leans by 4.4°<!-- np.degrees(lean) .1f -->
MARK = re.compile(r"<!--\s*(?P<expression>[^<>]+?)\s+(?P<digits>[\w.,+]+)\s*-->")
MARKED = re.compile(r"(?P<number>[-+−]?\d[\d.,]*(?<=\d))[^\d<>]*$")


class TolerantText(str):
    """Text equal to another if the words are the same and the numbers agree to 1e-9."""

    __slots__ = ()

    def __eq__(self, other):
        return same(self, other)

    def __ne__(self, other):
        return not self == other

    __hash__ = str.__hash__


class Prose(pytest.Item):
    """The numbers of one markdown cell, measured anew in the kernel, after the cells before it."""

    def __init__(self, *, text, **options):
        super().__init__(**options)
        self.text = text

    def runtest(self):
        wrong = []
        for mark in MARK.finditer(self.text):
            marked = MARKED.search(MARK.sub("", self.text[: mark.start()]))
            number = marked["number"].replace("−", "-") if marked else "no number before the mark"
            known, now = self._measured(mark["expression"], mark["digits"])
            if not known:
                wrong.append(f"the text says {number}, {mark[0][4:-3].strip()} cannot be measured: {now}")
            elif number != now:
                wrong.append(f"the text says {number}, {mark['expression']} is {now}")
        if wrong:
            raise AssertionError("\n".join(wrong))

    def _measured(self, expression, digits):
        """Whether the kernel knows the expression, and its value in these digits, or why not."""
        value = _asked(self.parent.kernel, f"format({expression}, {digits!r})")
        if value["status"] == "ok":
            return True, ast.literal_eval(value["data"]["text/plain"])
        return False, value["evalue"]

    def repr_failure(self, failed):
        return str(failed.value)

    def reportinfo(self):
        return self.path, 0, f"{self.parent.name}::{self.name}"


def _asked(kernel, expression):
    """The value of an expression in a kernel, as Jupyter's messages have it."""
    asked = kernel.kc.execute("", silent=True, user_expressions={"value": expression})
    answer = {"parent_header": {}}
    while answer["parent_header"].get("msg_id") != asked:
        answer = kernel.kc.get_shell_msg(timeout=60)
    return answer["content"]["user_expressions"]["value"]


def _setup(file, setup=IPyNbFile.setup):
    """Start the kernel; a cell fails if it draws a picture in which texts overlap, and says which."""
    setup(file)
    _asked(file.kernel, "__import__('tests.draw.overlap', fromlist=['watch']).watch()")


def _collect(file, cells=IPyNbFile.collect):
    """The code cells, as nbval has them, and between them the markdown cells that carry marks."""
    code = cells(file)
    first = next(code, None)  # reads the notebook
    code = iter([] if first is None else [first, *code])
    for number, cell in enumerate(file.nb.cells):
        if cell.cell_type == "code":
            yield next(code)
        elif cell.cell_type == "markdown" and MARK.search(cell.source):
            yield Prose.from_parent(file, name=f"Prose {number}", text=cell.source)


_sanitize = IPyNbCell.sanitize
IPyNbCell.sanitize = lambda cell, text: TolerantText(without_views(str(_sanitize(cell, text))))
IPyNbFile.collect = _collect
IPyNbFile.setup = _setup
kernels.fork()
