"""Is it right? Every calculation at random inputs, what is wrong, where and why, and what stands beside it.

`judge` compares and repairs: `sampled` has the values of all cells, `readings` says which rotation a text means,
`where` finds the earliest repair and `why` its cause; `tables` has NC words judged. `beside` judges what no
result needs, of `scope`: equal to what is `known`, against the `pattern` around it. `inputs` compares what is given
with what is said of it. A fault carries the rule that found it, one of the sentences at the head of the module that
returns it, and `reason` prints it.
"""
