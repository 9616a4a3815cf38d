"""What a shop needs: programs for its machine and control, and the machine as it really is.

Read `post` first (from CL data to a proved program), then `controls` (a control's words, a file each) and `plane`
(tilted working planes). `measure` finds axes, heads and offsets from readings, `compensate` makes up for the errors
that are left. `codegen` prints the chain and its inverse for other programs.
"""
