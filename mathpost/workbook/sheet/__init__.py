"""A spreadsheet as functions of its inputs.

`file` (with `safety`) reads cells. `formula` reads a formula as a tree, `tree` walks, changes and writes trees,
`evaluate` gives their values at many inputs at once. `cells` holds the trees of all sheets (with `lookup` and
`shorthand`, which put references for what is looked up or left out), `links` says which uses which, `graph`
evaluates them all; `place` and `samples` are what a place and a value are. `neighbours` says what the formulas
around a cell ask of it, `edits` what somebody may have meant.
"""
