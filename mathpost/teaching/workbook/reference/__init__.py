"""A hand-in compared with a teacher's workbook, both as functions of the same inputs, whatever they compute.

Nothing is recognised. `homework` is what a teacher asks: the reference, its inputs and its results. `quantities`
has the labels and the values of a workbook at samples of its inputs (`functions` those of its functions that
rotations do not need). `inputs` finds the inputs of the reference in a hand-in, by `roles` where nothing but what
they do tells, `results` its results. `forks` are conditions and the like that take one of several ways, and
`branches` moves inputs until each is taken. `where` is the one cell whose change, one of `changes`, makes right
what is missing, `unlike` the part in which two formulas differ; the quantities of the reference are what may occur
on the way there. `hand_in` goes this way for one file, and reports; `check` is what is called.
"""
