"""The shell: ``python -m mathpost post …``, ``check …`` and so on, one file a command.

A command's file has `add_arguments`, which says what it takes, and `run`, which does it and returns the exit
status. Only the file of the command that is asked for is loaded. Read `main` first; `options` has what several
commands take.
"""
