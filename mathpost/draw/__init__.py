"""Pictures of kinematics: plots, and machines that move in the browser.

Read `plot` for figures. For machines that move: `solid` and `arrangement` (the bodies), `scene` (what a picture is
made of), `moving` and `live` (how it and curves move in a page), `picture` (how it stands still).
"""
