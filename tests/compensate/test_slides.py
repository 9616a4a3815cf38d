"""A step in a slide's positioning: from a laser's run in machine coordinates to two tools in two work offsets.

The machine is that of `tests.independent.machine_model`, with encoders of its own: the nose is where the slide's
encoder says, plus the step. A program is read by the reader that was written from the controls' manuals.
"""

import numpy as np
import pytest
import tomlkit

from mathpost.interface.shell.main import main
from tests.independent import judge
from tests.independent.machine_model import Model
from tests.independent.reader import Setup, read

STEP, PLACE = 0.020, 40.0  # mm, and mm in machine coordinates of the slide
LENGTHS = {1: 80.0, 2: 145.0}  # of tools, neither is that of the machine file
SHIFT = (7.0, -18.0, 26.0)  # from the work offset 1, which the first tool uses, to 2, which the second one does
ORIGIN = [15.0, -25.0, 35.0]
TRUNNION = [("A", "workpiece", (-1, 0, 0), (20, 0, -50)), ("C", "workpiece", (0, 0, -1), (10, -30, 0))]
MIXED = [("C", "workpiece", (0, 0, 1), (10, -30, 0)), ("B", "tool", (0, 1, 0), (0, 0, 180))]
HEAD = [("C", "tool", (0, 0, 1), (0, 0, 60)), ("A", "tool", (1, 0, 0), (0, 5, 200))]
LYING = [("A", "workpiece", (1, 0, 0), (0, 40, -50)), ("B", "workpiece", (0, 1, 0), (10, 0, -30))]
# Rotary axes, tool axis, what X Y Z name, and the slide of the spindle.
MACHINES = {
    "tables": (TRUNNION, (0, 0, 1), "tip", "Z"),
    "tables, the slide carries them": (TRUNNION, (0, 0, 1), "tip", "Z"),
    "head and table": (MIXED, (0, 0, 1), "tip", "Z"),
    "head and table, nose": (MIXED, (0, 0, 1), "nose", "Z"),
    "head": (HEAD, (0, 0, 1), "tip", "Z"),
    "head, a point of it": (HEAD, (0, 0, 1), [0, 0, 200], "Z"),
    "a lying spindle": (LYING, (0, -1, 0), "tip", "Y"),
    "a slide across the tool": (MIXED, (0, 0, 1), "tip", "X"),
}


def off(position):
    """By how much a slide is further than its encoder says."""
    return STEP / 2 * (1 + np.tanh((position - PLACE) / 5))


def content(name):
    """The machine file."""
    rotary, axis, named, slide = MACHINES[name]
    keys = ("name", "carries", "axis", "point")
    travel = {"limits": [-90, 90]}  # so that the branch is that of the job
    linear = {slide: {"carries": "workpiece"}} if "carries" in name else {}
    return {
        "name": name,
        "source": "test",
        "rotary": [dict(zip(keys, (*each[:2], *map(list, each[2:])), strict=True)) | travel for each in rotary],
        "workpiece": {"origin": ORIGIN, "offset": 1, "offsets": {"2": np.add(ORIGIN, SHIFT).tolist()}},
        "tool": {"axis": list(axis), "length": 110, "programmed_point": named},
        "linear": linear,
    }


def laser(slide, rng):
    """Three runs forth and back, the machine moved in machine coordinates: no tool length is active."""
    at = np.arange(-200.0, 201.0, 4)
    runs = [1e3 * off(at) + 0.2 * rng.standard_normal(len(at)) for _ in range(6)]
    names = [f"{side}{run}" for run in (1, 2, 3) for side in ("up", "down")]
    rows = [",".join(f"{x:.4f}" for x in row) for row in zip(at, *runs, strict=True)]
    head = f"# method = laser\n# axis = {slide}\n# unit = µm\n"
    return head + "\n".join([",".join(["position", *names]), *rows]) + "\n"


def job(model, slide, rng):
    """CL data whose records are round the step for each tool, and what they are: tips and tool axes."""
    lines, records, index = ["UNITS/MM", "FEDRAT/700,MMPM"], [], "XYZ".index(slide)
    for tool, length in LENGTHS.items():
        lines += [f"MCSYS/NUM,{tool}", f"LOAD/TOOL,{tool},LENGTH,{length:g}"]
        start, turned = rng.uniform(-30, 30, 3), rng.uniform(15, 25, 2)
        for n in range(13):
            slides = start + np.multiply(n, [0.5, 0.3, -0.4])
            slides[index] = PLACE - 12 + 2 * n
            tip, axis = model.place(model.nose_of_slides(slides), turned + 0.2 * n, length)
            counted = tip - np.multiply(SHIFT, tool == 2)
            lines.append("GOTO/" + ",".join(f"{x:.9f}" for x in (*counted, *axis)))
            records.append((tip, axis))
    return "\n".join(lines) + "\n", *(np.array(each) for each in zip(*records, strict=True))


def reached(program, model, slide, dialect, tips, axes):
    """How far the tip of the real machine is from each record, mm."""
    held = dialect != "fanuc"  # by the tool call, not by G43
    offsets = {"G54": np.zeros(3), "G55": np.array(SHIFT), 1: np.zeros(3), 2: np.array(SHIFT)}
    moves = read(program, dialect, Setup(model, offsets=offsets, lengths=LENGTHS, length_on=held))
    samples, along, real = judge.sample(model, moves), np.eye(3)["XYZ".index(slide)], []
    for row, nose, angles in zip(samples.move, samples.nose, samples.angles, strict=True):
        stands = nose + off(model.slides(nose) @ along) * along
        real.append(model.place(stands, angles, moves[row].tool_length))
    real_tips, real_axes = (np.array(each) for each in zip(*real, strict=True))
    near = np.linalg.norm(real_axes[:, None] - axes, axis=2) < 1e-4
    return np.where(near, np.linalg.norm(real_tips[:, None] - tips, axis=2), np.inf).min(axis=0)


@pytest.mark.parametrize("tcp", [False, True], ids=["joints", "tcp"])
@pytest.mark.parametrize("name", MACHINES)
def test_each_tool_meets_the_step_where_its_slide_does(name, tcp, tmp_path, capsys):
    slide, rng = MACHINES[name][3], np.random.default_rng(11)
    dialect = ("heidenhain", "fanuc", "siemens")[list(MACHINES).index(name) % 3]
    model = Model(content(name))
    text, tips, axes = job(model, slide, rng)
    files = {"machine.toml": tomlkit.dumps(content(name)), "laser.csv": laser(slide, rng), "job.cl": text}
    for file, each in files.items():
        (tmp_path / file).write_text(each, encoding="utf-8")
    given, out = str(tmp_path / "machine.toml"), tmp_path / "out"
    assert main(["calibrate", given, str(tmp_path / "laser.csv"), "-o", str(out)]) == 0
    more = ["--tcp"] if tcp else []
    missed = {}
    for errors in ([], ["--errors", str(out / "errors.toml")]):
        of = str(out / "machine.toml")
        command = ["post", str(tmp_path / "job.cl"), "--machine", of, "--dialect", dialect, *more, *errors]
        capsys.readouterr()
        assert main([*command, "--tolerance", "0.05"]) == 0, capsys.readouterr().err
        missed[bool(errors)] = reached(capsys.readouterr().out, model, slide, dialect, tips, axes)
    for tool in np.split(np.arange(len(tips)), len(LENGTHS)):
        assert missed[False][tool].max() > 0.019 and missed[True][tool].max() < 0.0005
