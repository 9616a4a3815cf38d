"""Pictures of kinematics: plots, and machines that move in the browser.

Read `plot` for figures. For machines that move: `solid`, `part` and `arrangement` (the bodies), `scene` (bodies,
lines and camera), `picture` (its still image), `live` (scenes that move in a page) and `curves` (figures that do).
Those that draw no figure load no matplotlib.
"""
