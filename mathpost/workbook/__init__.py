"""A spreadsheet as functions: what it is, whether it is right, which cell is not and why.

Read `check`, which calls the others in turn: `sheet/` reads formulas as functions, `task` says what was asked,
`meaning/` what is calculated, `verdict/` whether that is right and why not. A check ends in a `report`; `folder`
checks a class, `symbolic` shows a sheet as sympy.
"""

from mathpost.workbook.check import check_file
from mathpost.workbook.folder import check_folder, mark
from mathpost.workbook.report import FileReport
from mathpost.workbook.symbolic import symbolic
from mathpost.workbook.task import Task, task_file

__all__ = ["FileReport", "Task", "check_file", "check_folder", "mark", "symbolic", "task_file"]
