"""The shell: ``python -m mathpost post …``, ``check …`` and so on, a file each.

A command's file has `add_arguments`, which declares its arguments, and `run`, which runs it and returns the exit
status. Only the file of the requested command is loaded. Read `main` first; `options` has what several commands
share.
"""
