"""From CL data to a verified NC program.

Read `postprocess` first, which takes the steps of this room in turn, then `options` (what is asked for) and
`steps`, which are taken for each tool. Solutions and the singular region are chosen in `mathpost.path`; `ways`
compares the ways through it by `time_law`; then `proof` and `report`. Programs are written and read back in
`mathpost.shop.controls`; `verify` judges any program against its CL data.
"""
