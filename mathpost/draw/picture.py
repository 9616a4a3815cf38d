"""A still picture of a scene, for pages that run no scripts: the drawing of `live.js` in NumPy."""

from __future__ import annotations

import io
from collections.abc import Sequence
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from PIL import Image, ImageColor, ImageDraw, ImageFont

from mathpost.draw.solid import put

if TYPE_CHECKING:
    from mathpost.draw.scene import Line, Scene

FINE = 2  # oversampling
HIDDEN = 0.35  # opacity of a line behind a solid


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
        depth, light = np.full((height, width), -np.inf), np.zeros((height, width))
        solid = np.full((height, width), -1)
        columns, rows = np.arange(width) + 0.5, np.arange(height)[:, None] + 0.5
        for number, each in enumerate(self.scene.solids):
            triangles, normals = each.surface
            corners = self.pixels(each.body, triangles)
            shade = _light(normals @ self.scene.places[each.body][:3, :3].T @ self.camera.T)
            (x0, y0, _), (x1, y1, _), (x2, y2, _) = np.moveaxis(corners, (1, 2), (0, 1))
            area = (x1 - x0) * (y2 - y0) - (x2 - x0) * (y1 - y0)
            low = np.clip(np.ceil(corners[..., :2].min(axis=1) - 0.5), 0, self.size).astype(int)
            high = np.clip(np.floor(corners[..., :2].max(axis=1) + 0.5), 0, self.size).astype(int)
            front = (area < -1e-12) & (high > low).all(axis=1)
            numbers = (numbers[front].tolist() for numbers in (corners, shade, area, low, high))
            for points, (s0, s1, s2), area, (left, top), (right, bottom) in zip(*numbers, strict=True):
                (x0, y0, z0), (x1, y1, z1), (x2, y2, z2) = points
                x, y = columns[left:right], rows[top:bottom]
                b = ((x - x0) * (y2 - y0) - (y - y0) * (x2 - x0)) / area
                c = ((y - y0) * (x1 - x0) - (x - x0) * (y1 - y0)) / area
                z = z0 + b * (z1 - z0) + c * (z2 - z0)
                window = slice(top, bottom), slice(left, right)
                inside = (b >= 0) & (c >= 0) & (b + c <= 1) & (z > depth[window])
                np.copyto(depth[window], z, where=inside)
                np.copyto(light[window], s0 + b * (s1 - s0) + c * (s2 - s0), where=inside)
                np.copyto(solid[window], number, where=inside)
        return solid, light, depth

    def draw(self) -> Image.Image:
        """Return the picture, a PIL image."""
        solid, light, depth = self.seen()
        colours = np.array([ImageColor.getrgb(each.colour) for each in self.scene.solids] or [(0, 0, 0)])
        shine = np.maximum(light - 200, 0)[..., None] / 90
        dim = np.minimum(light / 200, 1)[..., None]
        rgb = colours[solid] * dim * (1 - shine) + 255 * shine + (1 - dim) * [0, 10, 20]
        rgb = np.where(solid[..., None] < 0, 243, np.clip(rgb, 0, 255))
        picture = Image.fromarray(rgb.astype(np.uint8))
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


def _light(normals: np.ndarray) -> np.ndarray:
    """Lightness, 1 to 254, by normals in the camera's view: soft from above, some from the right, a highlight."""
    right, up, near = np.moveaxis(normals, -1, 0)
    light = np.maximum(-0.45 * right + 0.7 * up + 0.55 * near, 0)
    back = np.maximum(0.8 * right - 0.2 * up, 0)
    gloss = np.maximum(-0.26 * right + 0.48 * up + 0.84 * near, 0) ** 24
    return np.minimum(1 + 200 * (0.6 + 0.42 * light + 0.1 * back) + 40 * gloss, 254)


def png(scenes: Sequence[Scene], size: tuple[int, int], columns: int) -> bytes:
    """Return several scenes, in `columns`, as a small PNG file, bytes."""
    width, height = size
    whole = Image.new("RGB", (FINE * width * columns, FINE * height * -(-len(scenes) // columns)), "white")
    for number, scene in enumerate(scenes):
        row, column = divmod(number, columns)
        picture = View(scene, (FINE * width, FINE * height)).draw()
        whole.paste(picture, (picture.width * column, picture.height * row))
    whole = whole.resize((whole.width // FINE, whole.height // FINE), Image.Resampling.BOX)
    file = io.BytesIO()
    whole.quantize(64, dither=Image.Dither.NONE).save(file, format="PNG", optimize=True)
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
