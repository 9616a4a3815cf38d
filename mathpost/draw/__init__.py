"""Pictures of kinematics: plots, and machines that move in the browser.

Read `plot` for figures. For machines that move: `solid` and `arrangement` (the bodies), `scene` (a picture of
them), `moving` and `live` (how pictures and curves move in a page), `picture` (the still image of a scene).
"""
