"""Which convention gives this number? Someone's result in, the misreadings that explain it out, the simplest first.

Read `misreadings` first, which enumerates them for Euler angles, then `euler_angles.explain`, which tries them all;
`rotary_axes.explain_joints` does the same for the rotary angles of a machine.
"""
