"""From readings to what a machine, a head or a cutter really is.

Read `fit` first, the least-squares fit that `rotary_axis` and `horizontal_head` use, then `work_offset` and
`cutter`. `angular_error`, `spline` and `control_table` make compensation tables of an axis; `csv_table` reads all
the files.
"""
