"""What a sheet calculates: which cells are inputs, matrices, vectors and results, judged by how formulas use them.

Rotations: `given` (which cells are inputs, which matrices), `vectors` (which are linear in lengths), `names` (what
the texts call them, with `label` and `texts`; the words are data, which `vocabulary` reads), `turns` (what turns a
vector, and about what), `recognise` (which of all these are results), `rows` (what the rows of a table have in
common). Machines: `machine_table` where a table of NC words is, by its headings; `words` has its rows, which
`typed_words` judges as numbers. Each yields a `calculation`, which knows the required values of its results and the
values that may occur on the way to them.
"""
