"""A spreadsheet as functions of its inputs.

`file` (with `safety`) reads cells, `formula` makes trees of formulas and evaluates them at many inputs at once,
`graph` (with `lookup`) links the cells of all sheets. `neighbours` says what the formulas around a cell ask of it,
`edits` what somebody may have meant.
"""
