"""The pages: lessons, machines, commands and reference, made by Sphinx; they need no server and no network.

Read `sources` first: it writes what Sphinx reads, lessons as MyST-NB takes them, and pages from ``templates``, in
which the map of the course is drawn and the modules of the reference are listed. `commands` runs the examples of
``commands.toml``. ``conf.py`` sets Sphinx up: formulas as MathML, and a search that finds Chinese words within a
sentence.
"""
