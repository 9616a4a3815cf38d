"""The exercises by subject, a file each; their texts and mix-ups are in `exercises.toml` beside this folder.

`rotation` has those of lessons 01 and 02, `quaternion` 02b, `tilted` 03 and 03b, `links` 04, `selection` 05 and 06,
`blade` 07, `capstone` 07c, `calibration` 08 to 11b, `compensation` 12 to 14.
"""
