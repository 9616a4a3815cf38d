"""A spreadsheet as functions: what it is, whether it is right, which cell is not and why.

Read `check`, which calls the others in turn: `file` (with `safety`) reads cells, `graph` (with `formula`) evaluates
them at many inputs at once, `recognise` tells what is what, `calculation` what may stand where, and `judge` (with
`edits`) finds the first wrong cell. `nc_table` (with `nc_columns`) and `plane_angles` are other calculations,
`values` (with `label`, `threes`) knows sheets of numbers; `folder` checks a class, `symbolic` shows it as sympy.
"""

from mathpost.workbook.check import check_file
from mathpost.workbook.folder import check_folder, mark
from mathpost.workbook.recognise import Task, task_file
from mathpost.workbook.report import FileReport
from mathpost.workbook.symbolic import symbolic

__all__ = ["FileReport", "Task", "check_file", "check_folder", "mark", "symbolic", "task_file"]
