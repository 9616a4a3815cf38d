"""The site: lessons, machines, commands and reference as pages that need no server and no network.

Read `build` first: all pages in their order, and the frame that each gets. `lesson` makes a notebook a page,
`commands` runs the examples of ``commands.toml``, `reference` has the docstrings of what lessons use, `course_map`
shows which lesson needs which, `search` divides all pages into sections. ``templates`` has the layout.
"""
