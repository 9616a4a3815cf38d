"""A class: lessons handed out, collected and marked, and the command that reruns the lessons.

Read `assign` (lessons without solutions), `handed_in`, `judged` and `grade` (files handed in, their verdicts and
marks), `grade_page` (the report), `kept` (earlier verdicts). `rerun` runs a notebook in a sandbox, which `apart`
makes; `lessons` says what changed in a lesson that is run again.
"""
