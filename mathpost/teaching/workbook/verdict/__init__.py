"""Is it right, and if not: which cell first, and why?

`judge` (with `sampled`) compares the calculations at random inputs; `readings` says which rotation is meant
where that is open, `tables` what a whole table of NC words has in common, with `machine_causes`. `where` finds
the first wrong cell, `why` the slip. `beside` judges the cells that no result needs, of the `scope`: vectors
and single cells by what is `known` (`beside_vectors`, `beside_numbers`), all by the cells `around` and by what
is `labelled`. `inputs` compares what is given with labels and texts. `reason` says which rule judged a cell.
"""
