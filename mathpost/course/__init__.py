"""The exercises and views of the lessons, the marking of a class, and the command that reruns the lessons.

Read `verdict` first (one exercise and its mix-ups), then `answers` (the kinds of answer) and `exercise` (what the
learner calls). The exercises themselves are in `exercises.toml` and, by lesson, in `exercises_rotation` and its
neighbours, the views in `view_rotation` and its neighbours. `grade` marks a class.
"""
