#!/usr/bin/python3
"""What an operator does at LinuxCNC: power on, home, go to the first position, run each program, sample the joints.

LinuxCNC starts this as its DISPLAY, with the system's Python, which has its module; `job.json` says what to do.
"""

import json
import signal
import subprocess
import sys
import time
from pathlib import Path

MOST = 120  # s, that a program may take
QUIET = 0.5  # s at rest, after which it has ended: on a busy machine the control may be late with its next move


def wait(status, errors, ready, what, limit):
    """Wait until the control is `ready`; what it complains of is an error."""
    end = time.monotonic() + limit
    while True:
        status.poll()
        if error := errors.poll():
            raise RuntimeError(f"{what}: {error[1]}")
        if ready():
            return
        if time.monotonic() > end:
            raise TimeoutError(what)
        time.sleep(0.002)


def operate(job):
    """Do what the job says."""
    import linuxcnc  # of the system's Python, not of the one that runs the tests

    command, status, errors = linuxcnc.command(), linuxcnc.stat(), linuxcnc.error_channel()

    def until(ready, what, limit=20):
        wait(status, errors, ready, what, limit)

    def come_to_rest(what):
        moved = time.monotonic()

        def at_rest():
            nonlocal moved
            done = status.interp_state == linuxcnc.INTERP_IDLE and status.exec_state == linuxcnc.EXEC_DONE
            if not (done and status.queue == 0 and status.inpos):
                moved = time.monotonic()
            return time.monotonic() - moved > QUIET

        until(at_rest, what, MOST)

    command.state(linuxcnc.STATE_ESTOP_RESET)
    until(lambda: status.task_state == linuxcnc.STATE_ESTOP_RESET, "reset")
    command.state(linuxcnc.STATE_ON)
    until(lambda: status.task_state == linuxcnc.STATE_ON, "on")
    command.mode(linuxcnc.MODE_MANUAL)
    command.wait_complete()
    command.home(-1)
    until(lambda: all(status.homed[: status.joints]), "home")
    for program, first, samples in job["runs"]:
        command.mode(linuxcnc.MODE_MDI)
        command.wait_complete()
        for line in first:
            command.mdi(line)
            command.wait_complete(MOST)
            come_to_rest(line)
        sampler = subprocess.Popen(["halsampler", "-t", samples])
        time.sleep(0.1)
        subprocess.run(["halcmd", "setp", "sampler.0.enable", "1"], check=True)
        command.mode(linuxcnc.MODE_AUTO)
        command.wait_complete()
        command.program_open(program)
        command.wait_complete()
        command.feedrate(
            0
        )  # until the control has read the program: on a busy machine it may wait for its own reader
        command.auto(linuxcnc.AUTO_RUN, 0)
        until(lambda: status.interp_state != linuxcnc.INTERP_IDLE and status.queue > 0, "start", 20)
        queued = -1
        while queued != status.queue:
            queued = status.queue
            time.sleep(0.2)
            status.poll()
        command.feedrate(1)
        come_to_rest("end")
        subprocess.run(["halcmd", "setp", "sampler.0.enable", "0"], check=True)
        time.sleep(0.2)
        sampler.send_signal(signal.SIGTERM)
        sampler.wait(5)


if __name__ == "__main__":
    folder = Path(__file__).parent
    try:
        operate(json.loads((folder / "job.json").read_text(encoding="utf-8")))
        said = "done"
    except Exception as error:  # the control is to be switched off whatever happens
        said = repr(error)
    (folder / "said.txt").write_text(said, encoding="utf-8")
    sys.exit(0)
