"""The errors of a machine in its chain, and how a program makes up for them.

Read `error_model` first (the chain with errors), `machine_errors` (their values, from a file), then `calibrated`
and `compensation` (what is put into the inverse, and one step of the total differential), last `drift` (from part
to part).
"""
