"""What a sheet calculates: which cells are inputs, matrices, vectors and results, told by how formulas use them.

Rotations: `given` (which cells are inputs, which matrices), `vectors` (which are linear in lengths), `names`
(what the texts call them, with `label` and `texts`), `turns` (what turns a vector, and about what), `recognise`
(which of all these are results), `rows` (what the rows of a table have in common). Others: `find_planes` the
angles of a tilted plane, `nc_table` the words of a machine (with `nc_columns`, `nc_headings` and `nc_roles` for
tables, `nc_positions` for single positions, `nc_numbers` for words without formulas), `conversion` angles made
of others. Each yields a `calculation`, which knows what must stand in its results and what may stand on the
way; that of a plane stands in `plane_angles`.
"""
