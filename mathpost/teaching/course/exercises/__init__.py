"""The exercises of the lessons by subject, a file each; their texts are in `exercises.toml` beside this folder."""
