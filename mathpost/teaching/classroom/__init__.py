"""A class: lessons handed out, collected and marked, and the command that reruns the lessons.

Read `assign` (lessons without solutions), `handed_in` (files handed in, and how large they may be), `judged` and
`grade` (their verdicts and marks), `grade_page` (the report), `kept` (earlier verdicts). Nothing that was handed in
is run. `lessons` says what changed in a lesson of the course that is run again.
"""
