"""Sliders that drive one picture which only Python can draw: fits, selection over a path.

A figure is made once, its artists are moved and it is drawn into an `ipywidgets.Image`: twice as fast as a new
figure for each position. What sympy can print moves in the browser instead (`mathpost.draw.formula`).
"""

import base64
import io
import math

import ipywidgets
import numpy as np
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

DPI = 100  # of the picture on the screen


class View(ipywidgets.VBox):
    """Sliders with number boxes, a picture and a line of numbers.

    The boxes hold the values. JupyterLab shows a slider at its nearest step and sends that back as if somebody had
    moved it; such an echo changes nothing, so that 54.7356 stays 54.7356.

    Parameters
    ----------
    build : callable
        ``build(figure)`` draws the picture's artists once and returns ``update(**values)``, which moves them
        to the sliders' values and returns the line of numbers as HTML, or None. What it does not change is drawn
        once only.
    sliders : dict
        Name (a Python identifier, the keyword of `update`) to ``(low, high, start)`` or
        ``(low, high, start, step)``; the label is the name with blanks for underscores.
    size : tuple of 2 floats, keyword only
        Inches, drawn at 100 dots to the inch.

    Examples
    --------
    >>> def build(figure):
    ...     line, = figure.subplots().plot([0, 1], [0, 0])
    ...     def update(height):
    ...         line.set_ydata([0, height])
    ...         return f"height {height:.1f}"
    ...     return update
    >>> view = View(build, {"height": (0, 1, 0.5)})
    >>> view.numbers.value
    'height 0.5'
    >>> view.sliders["height"].value = 0.8
    >>> view.numbers.value
    'height 0.8'
    """

    def __init__(self, build, sliders, *, size=(7.0, 4.2)):
        self.figure = Figure(figsize=size, dpi=DPI, layout="constrained")
        FigureCanvasAgg(self.figure)
        self.update = build(self.figure)
        self._moving, self._frame, self._still = set(), None, None
        self.sliders = {name: _slider(name, *limits) for name, limits in sliders.items()}
        self.boxes = {name: _box(slider) for name, slider in self.sliders.items()}
        self.image = ipywidgets.Image(
            format="png", layout=ipywidgets.Layout(width=f"{size[0] * 100:.0f}px", max_width="100%")
        )
        self.numbers = ipywidgets.HTML()
        self.draws = 0
        self.redraw()
        for name, slider in self.sliders.items():
            slider.observe(lambda change, name=name: self._moved(name, change.new), names="value")
            self.boxes[name].observe(lambda change, name=name: self._typed(name, change.new), names="value")
        rows = [ipywidgets.HBox([self.sliders[name], self.boxes[name]]) for name in self.sliders]
        super().__init__([*rows, self.image, self.numbers])

    @property
    def values(self):
        """The exact values, a dict by name."""
        return {name: box.value for name, box in self.boxes.items()}

    def redraw(self):
        """Move the artists to the values and draw."""
        self.numbers.value = self.update(**self.values) or ""
        self.image.value = self._over_what_stands_still()
        self.draws += 1

    def _moved(self, name, value):
        slider, exact = self.sliders[name], self.boxes[name].value
        echo = slider.min + round((exact - slider.min) / slider.step) * slider.step
        if value != exact and not math.isclose(value, echo, abs_tol=1e-6 * slider.step):
            # Steps of 0.05 add up to 3.3500000000000001 in the browser; this is what was meant.
            self.boxes[name].value = round(value, 9)

    def _typed(self, name, value):
        self.sliders[name].value = value
        self.redraw()

    def _over_what_stands_still(self):
        """The picture, with only what moves drawn anew.

        What moves is found out: an artist that an update has changed is animated from then on, in matplotlib's
        sense, and drawn over the rest; limits, labels and artists that come or go ask for a whole new picture.
        """
        canvas, axes = self.figure.canvas, self.figure.axes
        frame = [_frame(each) for each in axes]
        changed = set() if self._still is None else {a for each in axes for a in _artists(each) if a.stale}
        if self._still is None or frame != self._frame or not changed <= self._moving:
            if changed:
                changed |= {each.get_legend() for each in axes} - {None}  # above the curves
            self._moving |= changed
            for artist in changed:
                artist.set_animated(True)
            canvas.draw()
            self._frame = [_frame(each) for each in axes]
            self._still = canvas.copy_from_bbox(self.figure.bbox)
        canvas.restore_region(self._still)
        for artist in sorted(self._moving, key=lambda artist: artist.get_zorder()):
            artist.axes.draw_artist(artist)
        png = io.BytesIO()
        Image.fromarray(np.asarray(canvas.buffer_rgba())).convert("RGB").save(png, format="PNG", compress_level=3)
        return png.getvalue()

    def _repr_mimebundle_(self, **options):
        """Add the picture itself, for a reader who has no running kernel."""
        bundle = super()._repr_mimebundle_(**options)
        return {**bundle, "image/png": base64.b64encode(self.image.value).decode()}

    def __repr__(self):
        return f"View({', '.join(self.sliders)})"


def _artists(axes):
    """What is drawn inside of `axes`."""
    return [*axes.lines, *axes.patches, *axes.collections, *axes.images, *axes.texts]


def _frame(axes):
    """What the picture around the artists depends on."""
    legend = axes.get_legend()
    written = [axes.title, axes.xaxis.label, axes.yaxis.label, *(legend.get_texts() if legend else [])]
    limits = [getattr(axes, f"get_{name}lim")() for name in "xyz" if hasattr(axes, f"get_{name}lim")]
    view = [getattr(axes, name, None) for name in ("elev", "azim")]
    return [text.get_text() for text in written], np.ravel(limits).tolist(), view, set(_artists(axes))


def _slider(name, low, high, start, step=None):
    return ipywidgets.FloatSlider(
        description=name.replace("_", " "),
        min=low,
        max=high,
        value=start,
        step=step or 10.0 ** math.floor(math.log10((high - low) / 100)),
        readout=False,
        layout=ipywidgets.Layout(width="510px"),
        style={"description_width": "120px"},
    )


def _box(slider):
    return ipywidgets.BoundedFloatText(
        min=slider.min, max=slider.max, value=slider.value, step=slider.step, layout=ipywidgets.Layout(width="90px")
    )
