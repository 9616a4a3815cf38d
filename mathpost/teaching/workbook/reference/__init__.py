"""A hand-in compared with a teacher's workbook, both as functions of the same inputs, whatever they compute.

Nothing is recognised. `homework` is what a teacher asks: the reference, its inputs and its results. `quantities`
has the labels and the values of a workbook at samples of its inputs (`functions` those of its functions that
rotations do not need). `inputs` finds the inputs of the reference in a hand-in (`matched`), by `roles` where
nothing but what they do tells. `compared` has both workbooks at the same samples, and `results` finds the results.
`forks` are conditions and the like that take one of several ways; `branches` moves inputs (`moved`) to take each.
`where` is the one cell whose change, one of `changes`, makes right what is missing, `unlike` the part in which two
formulas differ; the quantities of the reference are what may occur on the way there. `hand_in` goes this way for
one file, `statements` are what is said of it; `check` is what is called.
"""
