"""A spreadsheet as functions: what it is, whether it is right, which cell is not and why.

To know the room, read five files in this order.

1. `check`: one file from its bytes to its report; the whole way on two pages.
2. `sheet.graph`: the formulas of a workbook as functions of their inputs, at eight samples at once.
3. `meaning.recognise`: which cells are inputs, matrices, vectors and results; each result is a `Calculation` that
   knows its required values, and the values that may occur on the way to them.
4. `verdict.judge`: every calculation compared with what is asked for; where it is wrong, the earliest cell whose
   repair makes all that follows right is named, repaired, and the next calculation judged.
5. `verdict.beside`: what no result needs, judged as what its place says it is, or listed.

The modules that these call are in the same rooms, one idea a file: `sheet/` reads, `meaning/` recognises,
`verdict/` judges; the docstring of each room says in which order to read it. A verdict is traced with
``python -m mathpost check FILE --why CELL``: the rule that gave it and the values it used, put into words by
`verdict.reason`.

With a teacher's right workbook nothing of this is asked: `reference` compares two workbooks as functions, whatever
they compute.

`task` is what was asked, `report` what is said of a file, `folder` a class of files, `symbolic` a sheet as sympy.
"""

from mathpost.teaching.workbook.check import check_file
from mathpost.teaching.workbook.folder import check_folder, mark
from mathpost.teaching.workbook.reference.check import Reference
from mathpost.teaching.workbook.reference.homework import Homework
from mathpost.teaching.workbook.report import FileReport
from mathpost.teaching.workbook.symbolic import symbolic
from mathpost.teaching.workbook.task import Task, task_file

__all__ = [
    "FileReport",
    "Homework",
    "Reference",
    "Task",
    "check_file",
    "check_folder",
    "mark",
    "symbolic",
    "task_file",
]
