"""Sliders that drive one picture.

A figure is made once, its artists are moved and it is drawn into an `ipywidgets.Image`: twice as fast as a new
figure for each position, and nothing but ipywidgets and matplotlib is needed. The views of the lessons are in the
modules `view_…`.
"""

import base64
import io
import math
from pathlib import Path

import ipywidgets
import numpy as np
import traitlets
from matplotlib.backends.backend_agg import FigureCanvasAgg
from matplotlib.figure import Figure
from PIL import Image

from mathpost.errors import InputError, write_bytes

DPI = 100  # of the picture on the screen
FRAMES = 200  # a run of play has about so many pictures at most
INTERVAL = 100  # ms between two of them


class View(ipywidgets.VBox):
    """Sliders with number boxes, buttons for places worth seeing, a picture and a line of numbers.

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
    places : dict, optional
        Label of a button to the values it sets, a dict by slider; or to a callable that is given the present
        values and returns such a dict.
    play : str, optional
        The slider that play, pause and step drive.

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

    def __init__(self, build, sliders, *, size=(7.0, 4.2), places=None, play=None):
        self.figure = Figure(figsize=size, dpi=DPI, layout="constrained")
        FigureCanvasAgg(self.figure)
        self.update = build(self.figure)
        self._moving, self._frame, self._still = set(), None, None
        self.sliders = {name: _slider(name, *limits) for name, limits in sliders.items()}
        self.boxes = {name: _box(slider) for name, slider in self.sliders.items()}
        self.buttons = {label: ipywidgets.Button(description=label, layout=_NARROW) for label in places or {}}
        self.image = ipywidgets.Image(
            format="png", layout=ipywidgets.Layout(width=f"{size[0] * 100:.0f}px", max_width="100%")
        )
        self.numbers = ipywidgets.HTML()
        self.draws = 0
        self.redraw()
        for slider in self.sliders.values():
            slider.observe(self.redraw, names="value")
        for label, button in self.buttons.items():
            button.on_click(lambda _, place=places[label]: self.go(place))
        rows = [ipywidgets.HBox([self.sliders[name], self.boxes[name]]) for name in self.sliders]
        if play:
            rows.append(ipywidgets.HBox(self._player(play)))
        if self.buttons:
            rows.append(ipywidgets.HBox([*self.buttons.values()], layout=ipywidgets.Layout(flex_flow="row wrap")))
        super().__init__([*rows, self.image, self.numbers])

    @property
    def values(self):
        """The sliders' values, a dict by name."""
        return {name: slider.value for name, slider in self.sliders.items()}

    def go(self, place):
        """Set several sliders, a dict by name or a callable that makes one of the present values; draw once."""
        place = place(self.values) if callable(place) else place
        for slider in self.sliders.values():
            slider.unobserve(self.redraw, names="value")
        try:
            for name, value in place.items():
                self.sliders[name].value = float(value)
        finally:
            for slider in self.sliders.values():
                slider.observe(self.redraw, names="value")
        self.redraw()

    def redraw(self, _change=None):
        """Move the artists to the sliders' values and draw."""
        self.numbers.value = self.update(**self.values) or ""
        self.image.value = self._over_what_stands_still()
        self.draws += 1

    def save(self, path, *, dpi=200):
        """Write the present picture to `path`, a PNG; `OutputError` if that fails."""
        _suffix(path, ".png")
        write_bytes(path, self._png(dpi))

    def animate(self, path, name, *, start=None, end=None, frames=40, rate=10):
        """Write an animation to `path`, a GIF: slider `name` from `start` to `end` in `frames` pictures.

        The ends are those of the slider if not given; `rate` is in pictures a second. The view itself stays.
        """
        _suffix(path, ".gif")
        if name not in self.sliders:
            raise InputError("name", " or ".join(self.sliders), repr(name))
        slider, pictures = self.sliders[name], []
        ends = (slider.min if start is None else start, slider.max if end is None else end)
        for value in np.linspace(*ends, frames):
            self.update(**self.values | {name: float(value)})
            pictures.append(Image.open(io.BytesIO(self._png(DPI))).convert("P", palette=Image.Palette.ADAPTIVE))
        self.update(**self.values)
        gif = io.BytesIO()
        options = {"duration": 1000 / rate, "loop": 0}
        pictures[0].save(gif, format="GIF", save_all=True, append_images=pictures[1:], **options)
        write_bytes(path, gif.getvalue())

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

    def _png(self, dpi):
        png = io.BytesIO()
        self.figure.savefig(png, format="png", dpi=dpi)
        self._still = None  # the layout of another resolution is another one
        return png.getvalue()

    def _player(self, name):
        """Play, pause and stop, and a step back and forth, for one slider."""
        slider = self.sliders[name]
        step = max(slider.step, (slider.max - slider.min) / FRAMES)
        steps = math.ceil((slider.max - slider.min) / step - 1e-9)

        def number(value):
            return round((value - slider.min) / step)

        def show(value):
            # The slider may stand between two steps: only a step that differs from its own moves it.
            if value != number(slider.value):
                slider.value = min(slider.min + value * step, slider.max)

        self.play = ipywidgets.Play(min=0, max=steps, value=number(slider.value), interval=INTERVAL)
        self.play.observe(lambda change: show(change.new), names="value")
        slider.observe(lambda change: setattr(self.play, "value", number(change.new)), names="value")
        self.steps = [ipywidgets.Button(description=sign, layout=_SMALL) for sign in ("− step", "+ step")]
        for button, way in zip(self.steps, (-1, 1), strict=True):
            button.on_click(lambda _, way=way: setattr(self.play, "value", self.play.value + way))
        return [self.play, *self.steps]

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


_NARROW, _SMALL = ipywidgets.Layout(width="auto"), ipywidgets.Layout(width="70px")


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
    """A number box that says what the slider says, and the other way round."""
    box = ipywidgets.BoundedFloatText(
        min=slider.min, max=slider.max, value=slider.value, step=slider.step, layout=ipywidgets.Layout(width="90px")
    )
    # Steps of 0.05 add up to 3.3500000000000001 in the browser; the box shows what was meant.
    traitlets.link((slider, "value"), (box, "value"), transform=(lambda value: round(value, 9), float))
    return box


def _suffix(path, wanted):
    if Path(path).suffix.lower() != wanted:
        raise InputError("path", f"a file name that ends in {wanted}", f"{path}")
