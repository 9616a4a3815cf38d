"""Set a password on the hub: `python .jupyterhub/password.py NAME`, as the account that runs the hub.

Teachers cannot log in before this was done for them. It also helps a student who forgot a password, and with
`--drop` it lets the student choose one anew. The hub may be running.
"""

import argparse
import base64
import dbm
import getpass
import hashlib
import os
import sys
from pathlib import Path

import bcrypt

CLASS = Path(os.environ.get("MATHPOST_CLASS", Path(__file__).resolve().parent.parent / "class")).resolve()
SHORTEST = 8
LONGEST = 72  # bytes that bcrypt takes; 40 Chinese characters have 120


def fitting(password):
    """What bcrypt is given: the password, or a digest of one that is too long for it."""
    content = password.encode("utf-8", "surrogateescape")
    if len(content) <= LONGEST:
        return password
    return base64.b64encode(hashlib.sha256(content).digest()).decode()


def set_password(passwords, name, password):
    """Store the password of a name of the lists; None removes it."""
    with dbm.open(str(passwords), "c", 0o600) as stored:
        if password is not None:
            stored[name] = bcrypt.hashpw(fitting(password).encode("utf-8", "surrogateescape"), bcrypt.gensalt())
        elif name in stored:
            del stored[name]


def main():
    """Read the password twice from the terminal, or once from standard input."""
    parser = argparse.ArgumentParser(description="Set a password on the hub.")
    parser.add_argument("name", metavar="NAME", type=str.lower, help="as in students.txt or teachers.txt")
    parser.add_argument("--drop", action="store_true", help="forget it: a student's next log-in chooses one")
    options = parser.parse_args()
    lists = [CLASS / "students.txt", CLASS / "teachers.txt"]
    lines = [line for path in lists for line in path.read_text(encoding="utf-8-sig").splitlines()]
    if options.name not in {line.partition("#")[0].strip().lower() for line in lines}:
        sys.exit(f"{options.name}: not in {' or '.join(map(str, lists))}")
    password = None
    if not options.drop:
        terminal = sys.stdin.isatty()
        password = getpass.getpass() if terminal else sys.stdin.readline().rstrip("\n")
        if terminal and getpass.getpass("again: ") != password:
            sys.exit("The two were different; nothing was changed.")
        if len(password) < SHORTEST:
            sys.exit(f"At least {SHORTEST} characters; nothing was changed.")
    (CLASS / "hub").mkdir(mode=0o700, exist_ok=True)
    set_password(CLASS / "hub" / "passwords", options.name, password)


if __name__ == "__main__":
    main()
