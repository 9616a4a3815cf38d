"""The path: CL data as arrays, which solution each record takes, and the way through the singular region.

Read `cl` first (the data), then `selection` (which branch and winding; `dynamic_programming` finds the cheapest),
`singular` (how near the pole) and `region` (the spline and the other motions through it), with `motion` and
`between_blocks`. `deviation` is how far a machine strays from the path between two poses.

How APT files of several systems are read: `cl_lines` (the statements of a file), `coordinates` (the frame of the
points), `cl_words` (the words), and their effects: `modal` and `orders`, `moves` and `arcs`, `holes`. `text` reads
and writes many numbers at once.
"""
