"""Which convention gives this number? Someone's result in, the misreadings that explain it out, the simplest first.

Read `explanation` first (the parts of an explanation), then `misreadings`, which enumerates them for Euler angles,
and `euler_angles.explain`, which tries them all. `rotations` compares triples, quaternions and matrices;
`rotary_axes.explain_joints` explains the rotary angles of a machine, `positions` its tip and its X Y Z, with
`causes`: the catalogue of mix-ups and their frequencies. `notations` reads one rotation in any notation and shows
it in all; `digits` is the precision of a written number.
"""
