"""The exercises of the lessons, by subject; their sentences are in `exercises.toml` beside this folder."""
