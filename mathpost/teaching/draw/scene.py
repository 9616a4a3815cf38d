"""A scene: solids, lines and letters on bodies that move, and the camera that sees them.

`machine` makes the scene of a machine of any arrangement; `best` finds joints and a camera that hide nothing
important and let no two axes coincide.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, field, replace
from itertools import combinations, product
from typing import TYPE_CHECKING, Any

import numpy as np
import sympy as sp
from numpy.typing import ArrayLike

from mathpost.rotation import unit
from mathpost.teaching.draw.arrangement import Arrangement, arrange, placing
from mathpost.teaching.draw.colours import COLOUR
from mathpost.teaching.draw.picture import View, camera
from mathpost.teaching.draw.solid import Solid, put

if TYPE_CHECKING:
    from mathpost.kinematics import Kinematics
    from mathpost.path.cl import CLData
    from mathpost.teaching.draw.part import Part

DARK = "#333b41"
# Azimuth and elevation, degrees.
CAMERAS = [(-58, 22), (-35, 22), (-70, 32), (-125, 22), (-20, 30), (-48, 35), (-110, 35)]
# Tool-side and workpiece-side angle, degrees.
STARTS = [(30, 30), (30, 60), (-30, 30), (30, -60), (-30, -60), (40, 110)]
SHORT = 0.3  # an axis seen at less than this share of its length points at the viewer
APART = np.radians(12)  # two axes closer than this on the screen look like one
SHOWN = {"workpiece": 0.35, "tool": 0.5}  # share of a body that must be visible


@dataclass
class Line:
    """Polylines on a body; `over` shows them through solids, symbolic `points` move one (see `live`)."""

    body: str
    parts: Sequence[ArrayLike]
    colour: str
    width: float = 2.0
    name: str | None = None
    dash: bool = False
    halo: bool = False
    over: bool = False
    dot: bool = False
    points: Sequence[sp.Matrix] = ()


@dataclass
class Label:
    """A letter at a point of a body."""

    body: str
    at: np.ndarray
    text: str
    colour: str


@dataclass
class Scene:
    """A picture in space. Lengths in mm, `azimuth` and `elevation` of the camera in degrees.

    `places` are the 4×4 matrices of all bodies by name, the bed first. `extent` are points, shape (n, 3), that must
    be in the picture; `frame` finds its `middle` and half its height, `radius`.
    """

    solids: list[Solid] = field(default_factory=list)
    lines: list[Line] = field(default_factory=list)
    labels: list[Label] = field(default_factory=list)
    places: dict[str, np.ndarray] = field(default_factory=lambda: {"bed": np.eye(4)})
    extent: np.ndarray = field(default_factory=lambda: np.zeros((1, 3)))
    middle: np.ndarray = field(default_factory=lambda: np.zeros(3))
    radius: float = 1.0
    azimuth: float = -58.0
    elevation: float = 22.0
    title: str = ""
    colour: str = DARK

    def triad(
        self,
        body: str,
        letters: Iterable[str],
        *,
        length: float,
        colour: str,
        origin: ArrayLike = (0, 0, 0),
        width: float = 2.0,
    ) -> None:
        """Add a frame: three axes with their letters, seen through solids."""
        origin = np.asarray(origin, dtype=float)
        arms = [[origin, origin + length * e] for e in np.eye(3)]
        self.lines.append(Line(body, arms, colour, width, halo=True, over=True))
        ends = zip(np.eye(3), letters, strict=True)
        self.labels += [Label(body, origin + 1.16 * length * e, letter, colour) for e, letter in ends]

    def frame(self, azimuth: float, elevation: float, *, aspect: float = 1.2) -> Scene:
        """Return the scene seen by this camera, its `extent` just inside a window of `aspect` (width to height)."""
        view = camera(azimuth, elevation)
        seen = view @ self.extent.T
        low, high = seen.min(axis=1), seen.max(axis=1)
        middle = [*(low + high)[:2] / 2, seen[2].mean()] @ view
        radius = 0.53 * max(high[1] - low[1], (high[0] - low[0]) / aspect)
        return replace(self, azimuth=azimuth, elevation=elevation, middle=middle, radius=radius)

    def state(self) -> dict[str, Any]:
        """The scene for the browser, ready for JSON."""
        number = {name: index for index, name in enumerate(self.places)}
        solids = [{"body": number[s.body], "colour": s.colour} | s.state() for s in self.solids]
        lines = []
        for line in self.lines:
            parts = [np.round(np.asarray(part), 3).tolist() for part in line.parts]
            made = vars(line) | {"body": number[line.body], "parts": parts, "points": len(line.points)}
            lines.append({key: value for key, value in made.items() if value or key in ("body", "parts")})
        labels = [vars(e) | {"body": number[e.body], "at": np.round(e.at, 2).tolist()} for e in self.labels]
        state = {"solids": solids, "lines": lines, "labels": labels, "middle": np.round(self.middle, 2).tolist()}
        state["radius"] = round(float(self.radius), 2)
        return state | {key: getattr(self, key) for key in ("azimuth", "elevation", "title", "colour")}


def machine(
    kin: Kinematics, cl: CLData | None = None, *, title: str = "", part: Part | None = None
) -> tuple[Scene, Arrangement]:
    """Return the scene of a machine, and its `Arrangement`.

    With CL data the workpiece is fitted to them, and the path of the tip and some tool axes are drawn. A `Part`
    takes the place of the workpiece's sketch.
    """
    made = arrange(kin, cl, part)
    scene = Scene(made.solids, places=placing(kin.machine)(made.home), title=title)
    tables = [rotary.name for rotary in kin.machine.rotary if rotary.carries == "workpiece"]
    tool_side = str(kin.inverse_symbolic.tool_side)
    for name, ends in made.lines.items():
        colour = COLOUR["tool side" if name == tool_side else "workpiece side"]
        scene.lines.append(Line(name, [ends], colour, 2.2, dash=name == tool_side, halo=True, over=True))
        # The turntable's name is written under it, not on the workpiece.
        scene.labels.append(Label(name, ends[0 if [name] == tables[-1:] else 1], name, colour))
    arm = 0.42 * made.size
    corner = [*made.plate.min(axis=0)[:2], made.plate[:, 2].max()]
    scene.triad("bed", "XYZ", length=0.7 * arm, colour=DARK, origin=corner)
    scene.triad("workpiece", "xyz", length=arm, colour=COLOUR["workpiece"])
    scene.labels.append(Label("tool", np.array([-0.17 * made.size, 0, 0.3 * made.size]), "n", COLOUR["tool"]))
    if cl is not None:  # the tip's path through up to 400 records, the tool axis at up to 60, evenly spread
        many, few = (np.linspace(0, len(cl) - 1, min(len(cl), most)).astype(int) for most in (400, 60))
        arms = [[p, p + 0.16 * made.size * n] for p, n in zip(cl.points[few], cl.axes[few], strict=True)]
        scene.lines.append(Line("workpiece", arms, "#e9a56b", 1.0))
        scene.lines.append(Line("workpiece", [cl.points[many]], "#000000", 1.2))
    scene.extent = _extent(kin, made)
    return scene, made


def _extent(kin: Kinematics, made: Arrangement) -> np.ndarray:
    """The points of plate, table and head, also at 45 and 90 degrees."""
    still = ("bed", *kin.machine.joint_names[:3])
    moving = [(solid.body, solid.triangles().reshape(-1, 3)) for solid in made.solids if solid.body not in still]
    points = []
    for joints in turned(kin, made, [[0, 0], [45, 0], [-45, 0], [45, 90], [45, -90]]):
        places = placing(kin.machine)(joints)
        points += [put(places[body], corners) for body, corners in moving]
    return np.concatenate([*points, made.plate])


def best(
    kin: Kinematics,
    scene: Scene,
    tries: Iterable[np.ndarray],
    *,
    aspect: float = 1.2,
    cameras: Sequence[tuple[float, float]] = CAMERAS,
    apart: float = APART,
) -> tuple[np.ndarray, Scene]:
    """Return joints, one of `tries` (n, 5), and the scene with them, from one of `cameras`.

    It is the first pair in which nothing is `crossed` or `covered`, or the one with the least of both. Axes that
    are seen closer than `apart`, radians, are crossed.
    """
    found = []
    for joints, angles in product(tries, cameras):
        seen = replace(scene.frame(*angles, aspect=aspect), places=placing(kin.machine)(joints))
        found.append((crossed(kin, seen, apart) or covered(seen), joints, seen))
        if not found[-1][0]:
            break
    return min(found, key=lambda each: len(each[0]))[1:]


def turned(kin: Kinematics, made: Arrangement, angles: Sequence[Sequence[float]] = STARTS) -> np.ndarray:
    """Return joints (n, 5) of tool-side and workpiece-side angles (n, 2), degrees, in travel; the tip stays."""
    tool_side = (kin.tool_side or kin.workpiece_side) - 3
    rotary = np.radians(angles)[:, [tool_side, 1 - tool_side][: len(kin.machine.rotary)]]
    return kin.close(kin.forward(made.home)[0], np.clip(rotary, *kin.machine.limits[3:].T))


def crossed(kin: Kinematics, scene: Scene, apart: float = APART) -> list[str]:
    """Return, as sentences, which axes of the machine or the workpiece coincide on the screen."""
    places, view = scene.places, camera(scene.azimuth, scene.elevation)
    axes = {"the tool axis": places["tool"][:3, 2]}
    for rotary in kin.machine.rotary:
        axes[rotary.name] = places[rotary.name][:3, :3] @ unit(np.array(rotary.axis))
    return together(axes, view, apart) + together(
        dict(zip("xyz", places["workpiece"][:3, :3].T, strict=True)), view
    )


def covered(scene: Scene) -> list[str]:
    """Return, as sentences, which important bodies are behind others."""
    size, said = (150, 110), []
    seen, _, _ = View(scene, size).seen()
    for body, share in SHOWN.items():
        alone = replace(scene, solids=[solid for solid in scene.solids if solid.body == body])
        whole = (View(alone, size).seen()[0] >= 0).sum()
        mine = [number for number, solid in enumerate(scene.solids) if solid.body == body]
        if np.isin(seen, mine).sum() < share * whole:
            said.append(f"the {body} is hidden")
    return said


def together(directions: dict[str, np.ndarray], view: np.ndarray, apart: float = APART) -> list[str]:
    """Return, as sentences, which unit vectors, a dict by name, look parallel or like a point to a `camera`."""
    flat = {name: view[:2] @ direction for name, direction in directions.items()}
    said = [f"{name} points at the viewer" for name, seen in flat.items() if np.hypot(*seen) < SHORT]
    for first, second in combinations(flat, 2):
        a, b = flat[first], flat[second]
        seen = abs(a[0] * b[1] - a[1] * b[0]) / max(np.hypot(*a) * np.hypot(*b), 1e-12)
        really = np.arcsin(min(1.0, float(np.linalg.norm(np.cross(directions[first], directions[second])))))
        if seen < np.sin(min(apart, really / 2)):  # nearly parallel axes cannot look far apart
            said.append(f"{first} and {second} fall together")
    return said


def clearest(directions: dict[str, np.ndarray], normals: Sequence[np.ndarray] = ()) -> tuple[int, int]:
    """Return the azimuth and elevation from which the fewest of these unit vectors coincide.

    `normals` are those of plates, none of which should be seen edge-on.
    """
    azimuths, elevations = [-60, -50, -40, -30, -70, -20, -80, -100, -115, -130], [22, 30, 15, 38]

    def faults(seen: tuple[int, int]) -> int:
        view = camera(*seen)
        return len(together(directions, view)) + sum(abs(view[2] @ normal) < SHORT for normal in normals)

    return min(product(azimuths, elevations), key=faults)
