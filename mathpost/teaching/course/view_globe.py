"""The view of the pole on a globe, for lesson 06."""

import numpy as np
import sympy as sp

from mathpost.rotation import ACTIVE
from mathpost.teaching.draw.colours import COLOUR
from mathpost.teaching.draw.live import Button, Live, TextLine, formula, slider
from mathpost.teaching.draw.scene import DARK, Label, Line, Scene

TILT, DISTANCE, SPEED = sp.symbols("t d omega", real=True)
RADIUS = 100.0  # of the globe
# A tool axis that tilts in a plane at a distance from the pole Z, and its longitude.
AXIS = sp.Matrix([sp.sin(TILT), sp.cos(TILT) * sp.sin(DISTANCE), sp.cos(TILT) * sp.cos(DISTANCE)])
LONGITUDE = sp.atan2(AXIS[1], AXIS[0])


def globe() -> Live:
    """Tool axes as points on a globe whose axis is C: sliders for distance, tilt and speed."""
    meridian = [np.array([np.sin(a), 0, np.cos(a)]) * RADIUS for a in np.linspace(0, np.pi / 3, 41)]
    scene = Scene(title="tool axes on a globe, its axis is C", azimuth=-62.0, elevation=38.0)
    turn = np.linspace(0, 2 * np.pi, 73)
    for tilt in np.radians([10, 20, 30, 40, 50, 60]):
        ring = np.stack([np.sin(tilt) * np.cos(turn), np.sin(tilt) * np.sin(turn), np.cos(tilt) + 0 * turn], axis=1)
        scene.lines.append(Line("bed", [RADIUS * ring], COLOUR["machine"], 0.6))
    for angle in turn[:-1:6]:
        spoke = np.array([[x * np.cos(angle), x * np.sin(angle), z] for x, _, z in meridian])
        scene.lines.append(Line("bed", [spoke], COLOUR["machine"], 0.6))
    path = [RADIUS * AXIS.subs(TILT, sp.rad(angle)) for angle in range(-50, 51, 2)]
    arrow = [sp.zeros(3, 1), 1.25 * RADIUS * AXIS]
    scene.lines.append(Line("bed", [], COLOUR["workpiece"], 2.4, over=True, points=path))
    scene.lines.append(Line("bed", [], COLOUR["tool"], 3.0, over=True, dot=True, points=arrow))
    scene.lines.append(Line("C", [meridian], DARK, 2.4, over=True))
    scene.labels = [Label("bed", np.array([0, 0, 1.3 * RADIUS]), "C", DARK)]
    scene.labels.append(Label("C", 1.12 * meridian[-1], "longitude", DARK))
    scene.middle, scene.radius = np.array([0, 0, 0.72 * RADIUS]), 0.95 * RADIUS
    rate = sp.Abs(LONGITUDE.diff(TILT))
    said = "longitude {:2}°; per degree of tilt it turns by {:2}°: C has to turn at {:1}°/s"
    text: list[TextLine] = [(said, sp.deg(LONGITUDE), rate, rate * SPEED)]
    text.append(("at the nearest point by {:2}°: at {:1}°/s", rate.subs(TILT, 0), rate.subs(TILT, 0) * SPEED))
    sliders = [slider("distance", 0.2, 30, 4, step=0.1), slider("tilt", -50, 50, -12)]
    sliders.append(slider("tool speed", 1, 60, 10, unit="°/s"))
    symbols, places = (DISTANCE, TILT, SPEED), {"C": ACTIVE["Z"](LONGITUDE)}
    buttons: list[Button] = [("through it", [0.2, None, None]), ("nearest point", [None, 0, None])]
    return formula([scene], symbols, sliders, places, text, buttons=buttons)
