"""A reader and simulator of NC programs that shares nothing with the package: written from the controls' manuals.

`machine_model` (forward kinematics in plain NumPy) → `words` (a character scanner) → `reader` (modal state, moves) →
`word_address` and `klartext` (the two families of dialects) → `judge` (tip, tool axis, travel, time, clearance).
"""
