"""One tilted working plane: in every control's words, and the positions that machines and controls take for it.

Read `tilted_plane` first (the plane in every notation), then `positioning` (both positions of the rotary axes, the
third angle, and the position that Fanuc, Heidenhain and Siemens take); `pose` shows a pose and its positions.
`mathpost.shop.controls.plane_blocks` writes a plane as NC text and reads it back.
"""
