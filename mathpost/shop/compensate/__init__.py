"""The errors of a machine: found from readings, and made up for by a program.

Read `model` first: the chain with its errors as symbols, and the measured errors of one machine. Then
`compensation`: the joints with which that machine goes where it should. `drift` follows errors from part to part.

From readings to a machine: the methods, with what each takes on trust, are data in
`data/measurements/methods.toml`; `readings` brings files of every method to one form (`positioning`, `gauge` and
`instrument` are theirs), `estimate` makes one `calibration` of them (`held`, `moved`, `unmeasured`, `problem`,
`probed`), `residuals` say whether they fit, `agree` whether files do, `further` what else to measure. `calibrate`
does all of it, and asks `suspect` for the cause where they do not fit; `handover` and `terms` write what was found.
"""
