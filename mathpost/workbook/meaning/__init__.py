"""What a sheet calculates: which cells are inputs, matrices, vectors and results, told by how formulas use them.

`texts` reads what the sheet says. `recognise` (with `given`, `vectors` and `label`) finds rotations, `nc_table`
(with `nc_columns` and `nc_positions`) the words of a machine, `plane_angles` the angles of a tilted plane,
`conversion` angles made of others. Each is a `calculation`, which knows what must stand in its results and what may
stand on the way.
"""
