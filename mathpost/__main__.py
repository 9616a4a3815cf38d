"""``python -m mathpost``: the shell, see `mathpost.shell`."""

import sys

from mathpost.shell.main import main

if __name__ == "__main__":
    sys.exit(main())
