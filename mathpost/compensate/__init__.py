"""The errors of a machine, and how a program makes up for them.

Read `model` first: the chain with its errors as symbols, and the measured errors of one machine. Then
`compensation`: the joints with which that machine goes where it should. `drift` follows errors from part to part.
"""
