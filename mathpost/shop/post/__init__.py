"""From CL data to a verified NC program.

Read `postprocess` first, which takes the steps of this room in turn, then `options` (what is asked for) and
`steps`, which are taken for each tool on its `tool_path`. Solutions and the singular region are chosen in
`mathpost.path`; `ways` compares the ways through it by `time_law`; then `proof` and `report`. Programs are written
and read back in `mathpost.shop.controls`.

What a control has words for: `draft`, `own_words`, `arcs`, `holes`, `tilted`. What moves in the air: `approach`,
`jumps`; whether the tool meets anything: `body`, `solids`, `cuts`, `clear`, `every_move`. `verify` judges any
program: `along` (where it is on the path), `pace` (its feeds), `explained` (which one slip would explain it).
"""
