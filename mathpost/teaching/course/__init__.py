"""The exercises and views of the lessons.

Read `verdict` first (one exercise and its mix-ups), then `answers` (the kinds of answer) and `exercise` (the
functions that a learner calls). The exercises are in `exercises.toml` and, by subject, in the folder `exercises`,
the views in `view_rotation` and its neighbours.
"""
