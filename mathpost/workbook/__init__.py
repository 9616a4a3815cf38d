"""A spreadsheet as functions: what it is, whether it is right, which cell is not and why.

Read `check`, which calls the others in turn: `file` (with `safety`) reads cells, `graph` (with `formula` and
`lookup`) evaluates them at many inputs at once, `task` says what was asked, `recognise` (with `given` and
`vectors`) what is what, `calculation` what may stand where. `judge` (with `sampled`) compares, `where` finds the
first wrong cell and `why` (with `edits` and `neighbours`) the slip; `beside` judges the rest by what is `known`,
with `around` by the cells around it and with `labelled` by the labels. `inputs` doubts what is given.
`nc_table` (with `nc_columns`), `plane_angles` and `conversion` are other calculations; `values` (with `label` and
`threes`) knows sheets of numbers; `folder` checks a class, `symbolic` shows a sheet as sympy.
"""

from mathpost.workbook.check import check_file
from mathpost.workbook.folder import check_folder, mark
from mathpost.workbook.report import FileReport
from mathpost.workbook.symbolic import symbolic
from mathpost.workbook.task import Task, task_file

__all__ = ["FileReport", "Task", "check_file", "check_folder", "mark", "symbolic", "task_file"]
