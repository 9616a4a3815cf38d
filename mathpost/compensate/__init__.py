"""The errors of a machine: found from readings, and made up for by a program.

Read `model` first: the chain with its errors as symbols, and the measured errors of one machine. Then
`compensation`: the joints with which that machine goes where it should. `drift` follows errors from part to part.
`readings` brings files of every method to one form, `calibrate` makes one estimate of them, `handover` writes it.
"""
