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

MOST = 300  # s for anything: a bound, not a measure


def wait(status, errors, ready, what):
    """Wait until the control is `ready`; what it complains of is an error."""
    end = time.monotonic() + MOST
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

    waiting = [linuxcnc.EXEC_WAITING_FOR_MOTION, linuxcnc.EXEC_WAITING_FOR_MOTION_AND_IO]
    waiting += [linuxcnc.EXEC_WAITING_FOR_MOTION_QUEUE]

    def until(ready, what):
        wait(status, errors, ready, what)

    def enter(mode):
        command.mode(mode)
        until(lambda: status.task_mode == mode, "mode")

    def until_done(number, what):
        """Until the lines before `M68 E0 Q` with this number are done: it waits for what moves."""
        until(lambda: status.aout[0] == number and status.interp_state == linuxcnc.INTERP_IDLE, what)

    def hal(words):
        return subprocess.run(["halcmd", *words.split()], check=True, capture_output=True, text=True).stdout.strip()

    command.state(linuxcnc.STATE_ESTOP_RESET)
    until(lambda: status.task_state == linuxcnc.STATE_ESTOP_RESET, "reset")
    command.state(linuxcnc.STATE_ON)
    until(lambda: status.task_state == linuxcnc.STATE_ON, "on")
    enter(linuxcnc.MODE_MANUAL)
    command.home(-1)
    until(lambda: all(status.homed[: status.joints]), "home")
    for program, first, samples in job["runs"]:
        enter(linuxcnc.MODE_MDI)
        for line in (*first, "M68 E0 Q2"):
            command.mdi(line)
            command.wait_complete(MOST)
        until_done(2, first)
        enter(linuxcnc.MODE_AUTO)
        command.program_open(program)
        command.wait_complete(MOST)
        sampler = subprocess.Popen(["halsampler", "-t", samples])
        hal("setp sampler.0.enable 1")
        command.feedrate(0)  # until all is read that can be: the motion is not to wait for the reader
        command.wait_complete(MOST)
        command.auto(linuxcnc.AUTO_RUN, 0)
        until(lambda: status.exec_state in waiting and status.queue > 0, "read")
        command.feedrate(1)
        until_done(1, "end")
        hal("setp sampler.0.enable 0")
        while hal("getp sampler.0.curr-depth") != "0":
            time.sleep(0.002)
        sampler.send_signal(signal.SIGTERM)
        sampler.wait()


if __name__ == "__main__":
    folder = Path(__file__).parent
    try:
        operate(json.loads((folder / "job.json").read_text(encoding="utf-8")))
        said = "done"
    except Exception as error:  # the control is to be switched off whatever happens
        said = repr(error)
    (folder / "said.txt").write_text(said, encoding="utf-8")
    sys.exit(0)
