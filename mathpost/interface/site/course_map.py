"""The map of the course: which lesson builds on which, as curves beside the list of lessons."""

from collections.abc import Sequence

ROW, WIDE = 10, 30  # units of the drawing: the height of a row, the width of all
THIN = 'vector-effect="non-scaling-stroke"'


def svg(lessons: Sequence[tuple[str, Sequence[str]]]) -> str:
    """Return a drawing with a column of points, one for each lesson, and a curve from each lesson that it needs.

    Parameters
    ----------
    lessons
        Names of lessons in their order, with the names of those that they need; names that are not among them are
        left out.

    Returns
    -------
    str
        SVG without a size: as high as the rows of a list, whatever their height.
    """
    order = {name: number for number, (name, _) in enumerate(lessons)}
    curves, points = [], []
    for name, needs in lessons:
        end = ROW * (order[name] + 0.5)
        points.append(f'<path {THIN} d="M{WIDE} {end:g}h0"/>')
        for need in needs:
            if need in order:
                start = ROW * (order[need] + 0.5)
                bend = WIDE - min(WIDE - 1, 4 + 3 * abs(order[name] - order[need]))
                curves.append(
                    f'<path {THIN} d="M{WIDE} {start:g}C{bend} {start:g} {bend} {end:g} {WIDE} {end:g}"/>'
                )
    high = ROW * len(order)
    drawn = f'<g class="needs">{"".join(curves)}</g><g class="lessons">{"".join(points)}</g>'
    return f'<svg aria-hidden="true" viewBox="0 0 {WIDE} {high}" preserveAspectRatio="none">{drawn}</svg>'
