"""How people reach all of it: commands, panels and pages.

Read `shell` first (the commands), then `workbench` (the same as panels in a notebook) and `site` (the course as web
pages). Nothing below imports these rooms.
"""
