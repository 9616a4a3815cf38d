"""``python -m mathpost``: the shell, see `mathpost.interface.shell`."""

import sys

from mathpost.interface.shell import stopping


def main() -> int:
    """Run the command that the command line names; a signal before it begins ends it at once."""
    stopping.take(stopping.at_once)
    from mathpost.interface.shell.main import main as run

    return run()


if __name__ == "__main__":
    sys.exit(main())
