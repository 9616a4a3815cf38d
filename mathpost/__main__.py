"""``python -m mathpost``: the shell, see `mathpost.shell`."""

import sys

from mathpost.shell import stopping


def main() -> int:
    """Run the command that the command line names; a signal before it begins ends it at once."""
    stopping.take(stopping.at_once)
    from mathpost.shell.main import main as run

    return run()


if __name__ == "__main__":
    sys.exit(main())
