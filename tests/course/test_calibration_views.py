"""The sliders of lessons 08 to 11, from end to end."""

import pytest

from mathpost.course import view_calibration as views
from mathpost.machine import Rotary
from mathpost.measure import horizontal_head

HEAD = "data/measurements/five_face_head.csv"
VIEWS = {
    "datum": lambda root: views.datum_after_rotation((0, -200, -850), (-350, 0, -900), (-300, -250, -600)),
    "head": lambda root: views.five_face_head(horizontal_head.fit_head(horizontal_head.read_head(root / HEAD))),
    "centre": lambda root: views.rotation_centre(Rotary("C", "workpiece", (0, 0, -1), (0, 0, 0))),
    "rtcp": lambda root: views.rtcp_zero(),
}


@pytest.mark.parametrize("build", VIEWS.values(), ids=VIEWS)
def test_every_slider_moves_picture_and_numbers(build, pytestconfig):
    view = build(pytestconfig.rootpath)
    for slider in view.sliders.values():
        image, numbers = view.image.value, view.numbers.value
        slider.value = slider.max if slider.value != slider.max else slider.min
        assert view.image.value != image and view.numbers.value != numbers
        slider.value = slider.min


def test_the_errors_set_are_the_errors_recovered(pytestconfig):
    view = VIEWS["centre"](pytestconfig.rootpath)
    for slider, value in zip(view.sliders.values(), (25, -35, 45, -55, 0), strict=True):
        slider.value = value
    assert view.numbers.value == "XOC 25.0 ± 0.0 µm, YOC -35.0 ± 0.0 µm, AOC 45.0 ± 0.0 µrad, BOC -55.0 ± 0.0 µrad"
    view = VIEWS["rtcp"](pytestconfig.rootpath)
    for slider, value in zip(view.sliders.values(), (-20, 15, 40, 30, 0), strict=True):
        slider.value = value
    assert view.numbers.value.startswith("alpha -20.0 ± 0.0 arcsec, dy 15.0 µm, dL 40.0 µm")
