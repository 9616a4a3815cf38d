"""CL data: the path of one or more tools as arrays, read from APT files of several systems.

Read `cl` first (the data), then `cl_lines` (statements as they stand in a file), `cl_words` (what each word does)
and `arcs`. `text` reads and writes many numbers at once.
"""
