"""Is it right, and if not: which cell first, and why?

`judge` (with `sampled`) compares the calculations at random inputs, `where` finds the first wrong cell, `why` the
slip. `beside` judges the cells that no result needs: by what is `known`, by the cells `around`, by what is
`labelled`. `inputs` doubts what is given. `labels` says which formulas belong beside the labels;
`values` judges the results of sheets of numbers without formulas. `reason` says which rule judged a cell.
"""
