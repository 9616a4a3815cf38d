"""A reader and simulator of NC programs that shares nothing with the package: written from the controls' manuals.

In this order: `machine_model` (forward kinematics in plain NumPy), `words` (a character scanner), `reader` (modal
state, moves), `word_address`, `siemens` and `klartext` (the dialects), `judge` (tip, axis, travel, time, the tool's
body). One more control is one more subclass of `reader.Control`.
"""
