"""Sliders that drive one picture.

A figure is made once, its artists are moved and it is drawn into an `ipywidgets.Image`: twice as fast as a new
figure for each position, and nothing but ipywidgets and matplotlib is needed. The views of the lessons are in the
modules `view_…`.
"""

import base64
import io
import math

import ipywidgets
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure


class View(ipywidgets.VBox):
    """Sliders above a picture and a line of numbers.

    Parameters
    ----------
    build : callable
        ``build(figure)`` draws the picture's artists once and returns ``update(**values)``, which moves them
        to the sliders' values and returns the line of numbers as HTML, or None.
    sliders : dict
        Name (a Python identifier, the keyword of `update`) to ``(low, high, start)`` or
        ``(low, high, start, step)``; the label is the name with blanks for underscores.
    size : tuple of 2 floats, keyword only
        Inches, drawn at 72 dots to the inch.

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
        self.figure = Figure(figsize=size, dpi=72, layout="constrained")
        FigureCanvasAgg(self.figure)
        self.update = build(self.figure)
        self.sliders = {name: _slider(name, *limits) for name, limits in sliders.items()}
        self.image = ipywidgets.Image(format="png", layout=ipywidgets.Layout(width=f"{size[0] * 100:.0f}px"))
        self.numbers = ipywidgets.HTML()
        self.redraw()
        for slider in self.sliders.values():
            slider.observe(self.redraw, names="value")
        super().__init__([*self.sliders.values(), self.image, self.numbers])

    def redraw(self, _change=None):
        """Move the artists to the sliders' values and draw."""
        self.numbers.value = self.update(**{name: s.value for name, s in self.sliders.items()}) or ""
        png = io.BytesIO()
        self.figure.savefig(png, format="png")
        self.image.value = png.getvalue()

    def _repr_mimebundle_(self, **options):
        """Add the picture itself, for a reader who has no running kernel."""
        bundle = super()._repr_mimebundle_(**options)
        return {**bundle, "image/png": base64.b64encode(self.image.value).decode()}

    def __repr__(self):
        return f"View({', '.join(self.sliders)})"


def _slider(name, low, high, start, step=None):
    return ipywidgets.FloatSlider(
        description=name.replace("_", " "),
        min=low,
        max=high,
        value=start,
        step=step or 10.0 ** math.floor(math.log10((high - low) / 100)),
        layout=ipywidgets.Layout(width="600px"),
        style={"description_width": "120px"},
    )
