"""A spreadsheet as a calculation: what it is, whether it is right, which cell is not and why.

Read `file` and `layout` first (what stands where), then `check` (every step judged) with `diagnosis` (why), and
`folder` (a class's workbooks). `nc_table` checks tables of NC words against CL data.
"""
