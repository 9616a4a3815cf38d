"""A reader and simulator of NC programs that shares nothing with the package: written from the controls' manuals.

In this order: `machine_model` (forward kinematics in plain NumPy), `words` (a character scanner), `reader` (modal
state, moves), `word_address`, `siemens` and `klartext` (the dialects), `judge` (tip, tool axis, travel, time, clearance).
Another control is another subclass of `reader.Control`.
"""
