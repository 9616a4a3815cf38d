"""A spreadsheet as functions: what it is, whether it is right, which cell is not and why."""

from mathpost.workbook.checking import FileReport, check_file
from mathpost.workbook.recognise import Task

__all__ = ["FileReport", "Task", "check_file"]
