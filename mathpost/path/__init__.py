"""The path: CL data as arrays, which solution each record takes, and the way through the singular region.

Read `cl` first (the data), then `selection` (which branch and winding; `dynamic_programming` finds the cheapest,
and among equals the one that travels least), `singular` (how near the pole) and `region` (the motions through it;
the cubic itself is in `mathpost.sources.yu_dan`), with `motion` and `between_blocks`. `deviation` is how far a
machine strays from the path between two poses, with the default tolerances of tip and tool axis, which `post` and
`verify` share.

How APT files of several systems are read: `cl_lines` (the statements of a file), `coordinates` (the frame of the
points), `cl_words` (the words; those without an effect are in `data/cl/words.toml`), and their effects: `modal` and
`orders`, `moves` and `arcs`, `holes`; `pieces` are runs of records that a control may have words for. `nc_words`
reads the words of NC blocks, of which CL data may have some. `text` reads and writes many numbers at once.
"""
