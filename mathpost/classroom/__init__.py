"""A class: lessons handed out, collected and marked, and the command that reruns the lessons.

Read `assign` (lessons without solutions), `handed_in`, `judged` and `grade` (what came back, file by file, and its
marks), `grade_page` (the report), `kept` (what was judged before). `rerun` runs a notebook in a bounded place,
which `apart` makes; `lessons` says what changed in a lesson that is run anew.
"""
