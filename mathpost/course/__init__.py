"""The lessons' exercises and views, and the means to run the lessons anew.

Read `verdict` first (one exercise and its mix-ups), `answers` (what may be asked for) and `exercise` (as the
learner meets it); then `exercises.toml` and, by lesson, `exercises_rotation` and the others; the views likewise,
from `view_rotation` on; `drawings` has pictures that stand still.
"""
