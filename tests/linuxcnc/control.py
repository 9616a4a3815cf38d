"""LinuxCNC for the tests: a printed folder, compiled, started without a display, many times faster than real time.

Ten times faster is the same motion: rates × 10, accelerations × 100, servo period / 10, F × 10. Nothing of it is
random. It refuses root and knows one instance: each start is an ordinary account with namespaces of its own, in
which the folder of modules is one with the machine's kinematics in it.
"""

import json
import os
import re
import shutil
import subprocess
import tempfile
from pathlib import Path

import numpy as np

FAST = 10
PERIOD = 0.001  # s, of the servo thread, and of the samples as if FAST were 1
MODULES = Path("/usr/lib/linuxcnc/modules")
HEADERS = Path("/usr/include/linuxcnc")
SAMPLER = """
loadrt sampler depth=60000 cfg={}s
addf sampler.0 servo-thread
setp sampler.0.enable 0
net line motion.program-line => sampler.0.pin.{}
"""
NAMESPACES = "unshare --user --map-user=1000 --keep-caps --mount --ipc --pid --kill-child --mount-proc".split()
NOBODY = 65534


def missing():
    """Why LinuxCNC cannot be run here, or nothing."""
    if not shutil.which("linuxcnc") or not shutil.which("halcompile") or not (HEADERS / "kinematics.h").exists():
        return "LinuxCNC (linuxcnc-uspace and linuxcnc-uspace-dev) is not installed"
    if not shutil.which("gcc"):
        return "no C compiler"
    tried = subprocess.run([*NAMESPACES, "mount", "--bind", "/tmp", "/mnt"], capture_output=True, **_ordinary())
    return "" if tried.returncode == 0 else "no user namespaces here, in which LinuxCNC would have its modules"


def _ordinary():
    """How a process is started as an ordinary account."""
    return {"user": NOBODY, "group": NOBODY, "extra_groups": []} if os.getuid() == 0 else {}


def folder():
    """A temporary folder that an ordinary account can reach, which those of pytest are not."""
    return tempfile.TemporaryDirectory(prefix="linuxcnc.", dir="/tmp")


def build(folder):
    """Compile the kinematics of a printed folder beside LinuxCNC's own modules; every warning is an error."""
    (source,) = folder.glob("*.c")
    shutil.copytree(MODULES, folder / "modules", symlinks=True)
    flags = "-O2 -fPIC -shared -DRTAPI -DUSPACE -Wall -Wextra -Werror".split()
    subprocess.run(
        ["gcc", *flags, f"-I{HEADERS}", source, "-o", folder / "modules" / f"{source.stem}.so", "-lm"], check=True
    )


def run(folder, programs, *, hal=""):
    """Run programs, name to text, and to what is typed before; return name to samples: joints (n, j), line (n,)."""
    ini = (folder / "machine.ini").read_text(encoding="utf-8")
    joints = int(re.search(r"^JOINTS = (\d+)", ini, re.M)[1])
    ini = re.sub(r"^(\w*VELOCITY) = (.*)", lambda m: f"{m[1]} = {FAST * float(m[2]):g}", ini, flags=re.M)
    ini = re.sub(r"^(MAX_ACCELERATION) = (.*)", lambda m: f"{m[1]} = {FAST**2 * float(m[2]):g}", ini, flags=re.M)
    ini = re.sub(r"^(SERVO_PERIOD) = (.*)", lambda m: f"{m[1]} = {int(m[2]) // FAST}", ini, flags=re.M)
    ini = ini.replace("COMM_TIMEOUT = 1.0", "COMM_TIMEOUT = 300")  # s; what the motion takes later is lost
    ini = ini.replace("DISPLAY = axis", f"DISPLAY = {folder / 'machinist.py'}")
    (folder / "test.ini").write_text(ini.replace("machine.hal", "test.hal"), encoding="utf-8")
    sampler = SAMPLER.format("f" * joints, joints)
    nets = "".join(f"net joint{n} => sampler.0.pin.{n}\n" for n in range(joints))
    printed = (folder / "machine.hal").read_text(encoding="utf-8")
    (folder / "test.hal").write_text(printed + hal + sampler + nets, encoding="utf-8")
    shutil.copy(Path(__file__).with_name("machinist.py"), folder)
    (folder / "machinist.py").chmod(0o755)
    runs = []
    for name, (text, first) in programs.items():
        (folder / f"{name}.ngc").write_text(_faster(text).replace("\nM2", "\nM68 E0 Q1\nM2"), encoding="ascii")
        runs.append([str(folder / f"{name}.ngc"), [_faster(line) for line in first], str(folder / f"{name}.txt")])
    (folder / "job.json").write_text(json.dumps({"runs": runs}), encoding="utf-8")
    _hand_over(folder)
    environment = {"PATH": os.environ["PATH"], "HOME": str(folder), "RUNTESTS": "1", "DISPLAY": ""}
    started = f'mount --bind "{folder}/modules" {MODULES} && exec linuxcnc "{folder}/test.ini"'
    with (folder / "log.txt").open("wb") as log:
        subprocess.run(
            [*NAMESPACES, "sh", "-c", started], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
            stdout=log, stderr=subprocess.STDOUT, timeout=1200, check=False, **_ordinary(),
        )  # fmt: skip
    said = folder / "said.txt"
    if not said.exists() or said.read_text(encoding="utf-8") != "done":
        reason = said.read_text(encoding="utf-8") if said.exists() else "nothing"
        raise AssertionError(f"LinuxCNC said {reason}\n{(folder / 'log.txt').read_text(errors='replace')[-3000:]}")
    return {name: _samples(folder / f"{name}.txt", joints) for name in programs}


def _faster(text):
    return re.sub(r"\bF(\d+\.?\d*)", lambda m: f"F{FAST * float(m[1]):.5f}", text)


def _hand_over(folder):
    """Give the folder to the ordinary account."""
    if os.getuid() == 0:
        for path in (folder, *folder.iterdir()):
            os.chown(path, NOBODY, NOBODY)


def _samples(file, joints):
    """Joints and line numbers while the program runs, from rest to rest, none lost."""
    numbers = file.read_text(encoding="utf-8").replace("overrun", "")  # which the first line says
    rows = np.fromstring(numbers, sep=" ").reshape(-1, joints + 2)
    moved = np.flatnonzero(np.abs(np.diff(rows[:, 1 : joints + 1], axis=0)).max(axis=1) > 1e-9)
    kept = rows[moved[0] : moved[-1] + 2]
    assert (np.diff(kept[:, 0]) == 1).all()
    return kept[:, 1 : joints + 1], kept[:, joints + 1].astype(int)
