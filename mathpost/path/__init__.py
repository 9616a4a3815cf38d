"""CL data: the path of one or more tools as arrays, read from APT files of several systems.

Read `cl` first (the data), then `cl_lines` (the statements of a file), `coordinates` (the frame of the points),
`cl_words` (the words), and their effects: `modal` and `orders`, `moves` and `arcs`, `holes`. `text` reads and
writes many numbers at once. `deviation` is how far a machine strays from the path between two poses.
"""
