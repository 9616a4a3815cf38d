"""A spreadsheet as functions of its inputs.

`file` (with `safety`) reads cells. `formula` reads a formula as a tree, `tree` walks, changes and writes trees,
`evaluate` gives their values at many inputs at once. `cells` holds the trees of all sheets (with `lookup` and
`shorthand`, which put references for what is looked up or left out), `links` says which uses which, `graph`
evaluates them all; `place` and `samples` define places and values. `neighbours` says which formula the cells around
a cell suggest for it, `edits` what somebody may have meant.
"""
