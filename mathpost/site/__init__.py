"""The site: lessons, machines, commands and reference as pages that need no server and no network.

Read `build` first: what there is, in which order it is made, and how a page gets its frame. `lesson` makes a
notebook a page, `commands` runs the examples of ``commands.toml``, `reference` has the docstrings of what lessons
use, `course_map` shows what builds on what, `search` divides all pages into what is found. How a page looks is in
``templates``.
"""
