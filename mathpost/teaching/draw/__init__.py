"""Pictures of kinematics: plots, and machines that move in the browser.

Read `plot` for figures. For machines that move: `solid`, `part` and `arrangement` (the bodies), `scene` (bodies,
lines and camera), `picture` (its still image), `live` (scenes that move in a page) and `curves` (figures that do).
Those that draw no figure load no matplotlib. `colours` has one for each role. `described` and `described_scene`
tell a picture in numbers, for those who cannot see it, and for tests.
"""
