"""The true geometry of a machine, a head or a cutter, from readings.

Read `fit` first, the least-squares fit that `rotary_axis` and `horizontal_head` use, then `work_offset` and
`cutter`. `angular_error` and `spline` describe a positioning error over an axis, which a control takes as a table
(`mathpost.shop.controls.compensation_table`); `csv_table` reads all the files:
`headings` finds the line that names the columns, `vocabulary` what these and their units mean.
"""
