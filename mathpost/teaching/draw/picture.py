"""A still picture of a scene, for pages that run no scripts: the drawing of `live.js` in NumPy."""

from __future__ import annotations

import io
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image, ImageColor, ImageDraw, ImageFont

from mathpost.teaching.draw.solid import put

if TYPE_CHECKING:
    from mathpost.teaching.draw.scene import Line, Scene

FINE = 2  # oversampling
HIDDEN = 0.35  # opacity of a line behind a solid
BACKGROUND = np.full((256, 3), 243, dtype=np.uint8)


def camera(azimuth: float, elevation: float) -> np.ndarray:
    """Return a parallel projection, angles in degrees, Z upwards: the unit vectors right, up and to the viewer."""
    a, e = np.radians([azimuth, elevation])
    right = [-np.sin(a), np.cos(a), 0.0]
    up = [-np.sin(e) * np.cos(a), -np.sin(e) * np.sin(a), np.cos(e)]
    return np.array([right, up, [np.cos(a) * np.cos(e), np.sin(a) * np.cos(e), np.sin(e)]])


class View:
    """A scene seen in a window of `size` pixels."""

    def __init__(self, scene: Scene, size: tuple[int, int]) -> None:
        self.scene, self.size = scene, np.array(size)
        self.camera = camera(scene.azimuth, scene.elevation)
        self.scale = 0.5 * min(size) / scene.radius

    def pixels(self, body: str, points: np.ndarray) -> np.ndarray:
        """Return points (..., 3) of a body as pixels to the right, pixels down, and depth towards the viewer."""
        away = put(self.scene.places[body], np.asarray(points)) - self.scene.middle
        return away @ self.camera.T * [self.scale, -self.scale, 1] + [*self.size / 2, 0]

    def seen(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Return the number of the solid seen in each pixel (−1: none), its lightness and its depth."""
        width, height = self.size
        depth, light = np.full(width * height, -np.inf), np.zeros(width * height)
        solid = np.full(width * height, -1)
        if self.scene.solids:
            number, corners, shade = self._facing()
            triangle, pixels, z, lightness = filled(corners, shade, self.size)
            np.maximum.at(depth, pixels, z)
            nearest = np.flatnonzero(z == depth[pixels])[::-1]  # of two at one depth the first is written last
            solid[pixels[nearest]] = number[triangle[nearest]]
            light[pixels[nearest]] = lightness[nearest]
        return solid.reshape(height, width), light.reshape(height, width), depth.reshape(height, width)

    def _facing(self) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
        """Triangles that face the viewer: numbers of their solids, pixels and lightness of their corners."""
        placed, turned, count = [], [], []
        for each in self.scene.solids:
            triangles, upright = each.surface
            placed.append(self.pixels(each.body, triangles.reshape(-1, 3)))
            turned.append(upright.reshape(-1, 3) @ (self.camera @ self.scene.places[each.body][:3, :3]).T)
            count.append(len(triangles))
        corners, normals = (np.concatenate(parts).reshape(-1, 3, 3) for parts in (placed, turned))
        number = np.repeat(np.arange(len(count)), count)
        (ax, ay), (bx, by) = (corners[:, end, :2].T - corners[:, 0, :2].T for end in (1, 2))
        front = ax * by - ay * bx < -1e-12  # rows count downwards
        return number[front], corners[front], _light(normals[front])

    def draw(self) -> Image.Image:
        """Return the picture, a PIL image."""
        solid, light, depth = self.seen()
        shades = [_shades(ImageColor.getrgb(each.colour)) for each in self.scene.solids]
        picture = Image.fromarray(np.array([*shades, BACKGROUND])[solid, light.astype(int)])
        ink = ImageDraw.Draw(picture)
        for line in self.scene.lines:
            for part in line.parts:
                self._stroke(ink, line, self.pixels(line.body, np.asarray(part, dtype=float)), depth)
        self._letters(ink)
        return picture

    def _stroke(self, ink: ImageDraw.ImageDraw, line: Line, points: np.ndarray, depth: np.ndarray) -> None:
        colour = np.array(ImageColor.getrgb(line.colour))
        shown, faint = colour.tolist(), (255 - HIDDEN * (255 - colour)).astype(int).tolist()
        pieces = []  # ends, and whether it is unobstructed
        for start, end in pairwise(points):
            count = max(1, int(np.hypot(*(end - start)[:2]) / (8 * FINE)))
            for a, b in pairwise(start + np.linspace(0, 1, count + 1)[:, None] * (end - start)):
                x, y = ((a + b)[:2] / 2).astype(int)
                inside = 0 <= x < self.size[0] and 0 <= y < self.size[1]
                open_ = line.over or not (inside and depth[y, x] > (a + b)[2] / 2 + 0.012 * self.scene.radius)
                pieces.append(([*a[:2], *b[:2]], open_))
        width = round(FINE * line.width)
        for ends, open_ in pieces:
            if line.halo and open_:
                ink.line(ends, fill="white", width=width + round(2.5 * FINE))
        for ends, open_ in pieces[:: 2 if line.dash else 1]:
            ink.line(ends, fill=tuple(shown if open_ else faint), width=width)

    def _letters(self, ink: ImageDraw.ImageDraw) -> None:
        font = ImageFont.load_default(size=14 * FINE)
        wanted = [self.pixels(label.body, label.at)[:2] for label in self.scene.labels]
        for label, at in zip(self.scene.labels, spread(wanted, 20.0 * FINE), strict=True):
            ink.text(
                tuple(at), label.text, label.colour, font, anchor="mm", stroke_width=2 * FINE, stroke_fill="white"
            )


def filled(corners: np.ndarray, shade: np.ndarray, size: np.ndarray) -> tuple[np.ndarray, ...]:
    """Return the pixels whose middles are in triangles: four arrays of triangle, pixel, depth and lightness.

    `corners`, shape (n, 3, 3), are those of `View.pixels`, `shade`, shape (n, 3), is the lightness at each. A pixel
    is a number, row by row; it comes once for each triangle.
    """
    x, y, z = np.moveaxis(corners, 2, 0)
    # In a triangle the shares of its corners are linear: inverse @ (1, x, y), and none is below 0.
    inverse = np.linalg.inv(np.stack([np.ones_like(x), x, y], axis=1))
    values = np.stack([z, shade], axis=1) @ inverse
    top = np.clip(np.ceil(y.min(axis=1) - 0.5), 0, size[1]).astype(int)
    bottom = np.clip(np.floor(y.max(axis=1) + 0.5), 0, size[1]).astype(int)
    # Each row of each triangle: it begins and ends where a share is 0.
    triangle, row = _runs(top, bottom)
    level, slope = inverse[triangle, :, 0] + inverse[triangle, :, 2] * (row[:, None] + 0.5), inverse[triangle, :, 1]
    with np.errstate(divide="ignore", invalid="ignore"):
        zero = -level / slope
    left = np.where(slope > 0, zero, -np.inf).max(axis=1, initial=-1)
    right = np.where(slope < 0, zero, np.inf).min(axis=1, initial=size[0] + 1)
    run, column = _runs(
        np.ceil(left.clip(0) - 0.5).astype(int), np.floor(right.clip(max=size[0]) + 0.5).astype(int)
    )
    # Each pixel of each row.
    begin = values[triangle, :, 0] + values[triangle, :, 2] * (row[:, None] + 0.5)
    step = values[triangle, :, 1]
    depth, light = (begin[run, k] + step[run, k] * (column + 0.5) for k in (0, 1))
    return triangle[run], row[run] * size[0] + column, depth, light


def _runs(first: np.ndarray, end: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The numbers from each `first` to before its `end`, one after the other, and behind which pair each is."""
    count = np.maximum(end - first, 0)
    pair = np.repeat(np.arange(len(count)), count)
    return pair, np.arange(count.sum()) + np.repeat(first - (np.cumsum(count) - count), count)


def _light(normals: np.ndarray) -> np.ndarray:
    """Lightness, 1 to 254, by normals in the camera's view: soft from above, some from the right, a highlight."""
    right, up, near = np.moveaxis(normals, -1, 0)
    light = np.maximum(-0.45 * right + 0.7 * up + 0.55 * near, 0)
    back = np.maximum(0.8 * right - 0.2 * up, 0)
    gloss = np.maximum(-0.26 * right + 0.48 * up + 0.84 * near, 0)
    for _ in range(3):
        gloss = gloss * gloss  # to the power of 24: NumPy is slow at powers above 2
    return np.minimum(1 + 200 * (0.6 + 0.42 * light + 0.1 * back) + 40 * gloss * gloss * gloss, 254)


def _shades(colour: tuple[int, ...]) -> np.ndarray:
    """The 256 shades of a colour, bytes of shape (256, 3): cool in the shadow, white in the highlight."""
    light = np.arange(256)[:, None]
    shine, dim = np.maximum(light - 200, 0) / 90, np.minimum(light / 200, 1)
    rgb = np.array(colour) * dim * (1 - shine) + 255 * shine + (1 - dim) * [0, 10, 20]
    return np.clip(rgb, 0, 255).astype(np.uint8)


def png(scenes: Sequence[Scene], size: tuple[int, int], columns: int) -> bytes:
    """Return several scenes, in `columns`, as a small PNG file, bytes."""
    width, height = size
    whole = Image.new("RGB", (FINE * width * columns, FINE * height * -(-len(scenes) // columns)), "white")
    for number, scene in enumerate(scenes):
        row, column = divmod(number, columns)
        picture = View(scene, (FINE * width, FINE * height)).draw()
        whole.paste(picture, (picture.width * column, picture.height * row))
    return small_png(whole.resize((whole.width // FINE, whole.height // FINE), Image.Resampling.BOX), 64)


def small_png(picture: Image.Image, colours: int = 256) -> bytes:
    """Return a picture as a PNG file, bytes, of so many colours: a third of the size that all its shades need."""
    file = io.BytesIO()
    picture.convert("RGB").quantize(colours, dither=Image.Dither.NONE).save(file, format="PNG", optimize=True)
    return file.getvalue()


def spread(positions: Sequence[np.ndarray] | np.ndarray, gap: float, rounds: int = 12) -> np.ndarray:
    """Return positions, shape (n, 2), pushed apart until no two are closer than `gap`."""
    positions = np.array(positions, dtype=float)
    for _ in range(rounds):
        for i in range(len(positions)):
            for j in range(i):
                away = positions[i] - positions[j]
                distance = np.hypot(*away)
                if distance < gap:
                    push = away / distance * (gap - distance) / 2 if distance > 1e-6 else np.array([gap / 2, 0])
                    positions[i] += push
                    positions[j] -= push
    return positions
