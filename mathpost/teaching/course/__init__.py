"""The exercises and views of the lessons.

Read `verdict` first (one exercise and its mix-ups), then `answers` (the kinds of answer; `typed` is what a learner
typed, `judged_program` what a learner's program does, at which record each block ends: `match`) and `exercise` (the
functions that a learner calls). The exercises are in `exercises.toml` and, by subject, in the folder `exercises`;
`lesson_data` loads what they need.

What moves in a lesson is in `view_rotation`, `view_globe`, `view_gallery`, `view_machine`, `view_path` and
`view_calibration`; what stands still in `drawings` and, with `setups.toml`, in `setups`. `machine_page` is one
machine as a page, `installed` checks the packages.
"""
