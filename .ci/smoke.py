"""What the wheel must do alone: from a folder without the course, with its dependencies only."""

import subprocess
import sys
import tempfile

import mathpost
from mathpost.files import data_file

blade, sheet = data_file("cl/blade.cl"), data_file("workbooks/missing_transpose.xlsx")
POST = ["post", blade, "--machine", "dmu50v", "-o", "blade.h"]
COMMANDS = {  # and the exit status of each
    ("--version",): 0,
    tuple(POST): 0,
    ("verify", "blade.h", "--machine", "dmu50v", "--cl", blade): 0,
    ("check", sheet): 1,
    ("plane", "PLANE", "SPATIAL", "SPA+0", "SPB+54.7356", "SPC+45", "--machine", "bc_table"): 0,
    ("print", "ac_table", "--to", "c", "-o", "machine.c"): 0,
}
with tempfile.TemporaryDirectory() as folder:
    for words, status in COMMANDS.items():
        found = subprocess.run([sys.executable, "-m", "mathpost", *words], cwd=folder).returncode
        if found != status:
            sys.exit(f"{words[0]}: exit status {found}, expected {status}")
print("the wheel works:", mathpost.__file__, "on Python", sys.version.split()[0])
