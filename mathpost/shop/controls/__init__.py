"""What a control takes: its file of data, the blocks of a program, their writer and their reader.

Read `control` first (a control is a file of words, read by `keys`; `phrases` for more than a straight move,
`geometry` for the entries of its parameters), then `blocks` (the moves of a program), `writer` (`between`: what it
says between moves), and `reader` with `lines`, `words` (as one expression), `meanings` (what its words do),
`coordinates` (where they count from), `track` (the moves), `arcs_and_holes`, `variables` (constants), `calls`
(subprograms), `stops` (all that is not read). `plane_blocks` are the blocks of a tilted plane, `plane_forms` all
forms of G68.2, `compensation_table` the table of a positioning error. `simulation` writes a folder in which a
machine runs on LinuxCNC.
"""
