"""Pictures of kinematics: plots, and machines that move in the browser.

Read `plot` for figures. For machines that move: `solid`, `part` and `arrangement` (the bodies), `scene` (what is
seen), `picture` (its still image), `live` (how scenes and curves move in a page).
"""
