"""What a machine is, from readings: rotary axes and heads, work offsets, angular errors; and other cutters.

Read `fit` first (least squares on a symbolic model), then `rotary_axis`, which uses it, and `horizontal_head`;
`work_offset`, `angular_error` with `spline`, and `cutter` stand alone. `csv_table` reads the tables of all.
"""
