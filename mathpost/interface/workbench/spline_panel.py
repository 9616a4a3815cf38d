"""The clamped cubic of source 002 as a panel: n, Δt and the slopes, with the results of proof and time law."""

import ipywidgets as widgets
import numpy as np

from mathpost.errors import MathpostError
from mathpost.interface.workbench.panel import Shown
from mathpost.kinematics import Kinematics
from mathpost.path.cl import CLData
from mathpost.path.deviation import AXIS_TOLERANCE, TOLERANCE, strays
from mathpost.path.motion import Motion
from mathpost.path.region import through_the_records
from mathpost.shop.post.time_law import block_times, time_law
from mathpost.sources import yu_dan

MOST = 200  # points
HOW = {"style": {"description_width": "150px"}, "layout": {"width": "480px"}, "continuous_update": False}


class SplinePanel(Shown):
    """A panel of the cubic through one region; each change is proved at once.

    Parameters
    ----------
    kin, cl, joints, region
        As in `mathpost.sources.yu_dan.smooth`.
    """

    def __init__(self, kin: Kinematics, cl: CLData, joints: np.ndarray, region: tuple[int, int]) -> None:
        self.kin, self.cl, self.joints, self.region = kin, cl, joints, region
        self.n = widgets.IntSlider(5, 1, MOST, description="points n", **HOW)
        self.dt = [_number(f"Δt{index}, records", 0.2, 3) for index in "₁₂"]
        self.slopes = [_number(f"slope k{index}, times", 0, 3) for index in "₁₂"]
        controls = [self.n, *self.dt, *self.slopes]
        super().__init__("spline", controls)
        for each in controls:
            each.observe(lambda _: self.prove(), "value")
        self.prove()

    def cubic(self) -> Motion:
        """Return the motion through the region that the controls describe."""
        into, out = map(_virtual_time, self.dt, self.slopes)
        place, joints = yu_dan.smooth(self.kin, self.cl, self.joints, self.region, self.n.value, dt=(into, out))
        return Motion.on_part(joints, place)

    def prove(self) -> None:
        """Show the largest errors between the blocks, the seconds of the whole path, and joints out of travel."""
        try:
            motion = self.cubic()
        except MathpostError as error:
            self.tell(str(error), "wrong")
            return
        tip, axis = (each.max() for each in strays(self.kin, self.cl, motion))
        run, machine = through_the_records(self.joints, [motion]), self.kin.machine
        tips, feeds = self.kin.forward(run.joints)[0], self.cl.feeds[run.record[1:]]
        asked = block_times(machine, run.joints, tips, feeds, run.in_cut)
        seconds = time_law(machine, run.joints, asked).seconds[-1]
        said = f"tip {tip:.4f} mm, tool axis {np.degrees(axis):.3f}° at most from the CL data, {seconds:.2f} s"
        outside = run.joints[~machine.within(run.joints).all(axis=1)]
        if len(outside):
            said += f"; out of travel: {'; '.join(machine.out_of_travel(outside[0]))}"
        is_kept = tip <= TOLERANCE and axis <= AXIS_TOLERANCE and not len(outside)
        self.tell(said, "right" if is_kept else "wrong")


def _number(name: str, low: float, high: float) -> widgets.FloatSlider:
    return widgets.FloatSlider(1, min=low, max=high, step=0.05, description=name, **HOW)


def _virtual_time(dt: widgets.FloatSlider, slope: widgets.FloatSlider) -> float:
    """Return the Δt of equation (7) that makes a slope f times as steep: Δt / f; infinite for a level one."""
    return dt.value / slope.value if slope.value else np.inf
