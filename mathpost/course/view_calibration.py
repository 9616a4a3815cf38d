"""Views with sliders for lessons 08 to 11: datum, horizontal head, rotation centre, RTCP zero."""

import numpy as np

from mathpost.draw import plot
from mathpost.draw.chart import recorded
from mathpost.draw.formula import slider
from mathpost.draw.widget import View
from mathpost.errors import InputError
from mathpost.measure import horizontal_head, rotary_axis, work_offset


def datum_after_rotation(centre_a, centre_b, point):
    """Turn A and B and see where a point of the part goes: both stack orders, and one centre for both axes."""
    tables = {
        "AB": work_offset.ab_table(centre_a, centre_b, order="AB"),
        "BA": work_offset.ab_table(centre_a, centre_b, order="BA"),
    }
    common = (centre_b[0], centre_a[1], centre_b[2])
    tables["AB, one centre"] = work_offset.with_common_centre(tables["AB"], common)
    colours = (plot.COLOUR["first branch"], plot.COLOUR["second branch"], plot.COLOUR["published"])
    way = np.linspace(0, 1, 60)

    def build(figure):
        views = figure.subplots(1, 2)
        lines = []
        for axes, (across, centre) in zip(views, ((0, centre_b), (1, centre_a)), strict=True):
            reach = 1.1 * max(np.linalg.norm(np.subtract(point, c)) for c in (centre_a, centre_b))
            axes.plot(centre[across], centre[2], "+", color=plot.COLOUR["machine"], markersize=12)
            axes.plot(point[across], point[2], "o", color=plot.COLOUR["workpiece"], fillstyle="none")
            axes.set(xlim=centre[across] + reach * np.array([-1, 1]), ylim=centre[2] + reach * np.array([-1, 1]))
            axes.set(xlabel=f"{'XY'[across]} (mm)", ylabel="Z (mm)", aspect="equal")
            styles = zip(tables, colours, ("-", "--", ":"), strict=True)
            lines.append(
                [axes.plot([], [], s, color=c, marker="o", markevery=[-1], label=n)[0] for n, c, s in styles]
            )
        figure.legend(*views[0].get_legend_handles_labels(), loc="outside lower center", ncols=3, fontsize=8)

        def update(A, B):
            text = []
            for index, (name, table) in enumerate(tables.items()):
                path = work_offset.moved(point, table, {"A": 0, "B": 0}, {"A": A * way, "B": B * way}, degrees=True)
                for across in (0, 1):
                    lines[across][index].set_data(path[:, across], path[:, 2])
                text.append(f"{name}: {work_offset.words(path[-1])}")
            return "<br>".join(text)

        return update

    return View(build, {"A": (-90, 90, -30, 1), "B": (-180, 180, 70, 1)}, size=(8.0, 4.2))


def five_face_head(fitted):
    """Turn a horizontal head, seen from above: its frame, its vector, and what the printed program would take."""
    table = fitted.head()

    def build(figure):
        axes = figure.subplots()
        reach = 1.5 * np.linalg.norm(table.vectors[0, :2])
        axes.plot(*table.vectors[:, :2].T, color=plot.COLOUR["machine"], linewidth=0.8)
        axes.plot(*fitted.measured.vectors[:, :2].T, "o", color=plot.COLOUR["published"], label="measured")
        axes.set(xlim=(-reach, reach), ylim=(-reach, reach), xlabel="X (mm)", ylabel="Y (mm)", aspect="equal")
        (arm,) = axes.plot(
            [], [], color=plot.COLOUR["tool"], linewidth=3, label="U, from vertical to horizontal head"
        )
        arrows = [
            axes.plot([], [], color=plot.COLOUR[c], linewidth=2, label=n)[0]
            for n, c in (("X'", "first branch"), ("Z'", "workpiece"))
        ]
        figure.legend(loc="outside lower center", ncols=4, fontsize=8)

        def update(angle):
            try:
                head, kind = fitted.measured, "measured"
                vector = head.vector(angle)
            except InputError:
                head, kind = table, "predicted"
                vector = head.vector(angle)
            frame = horizontal_head.lhy(head, (0, 0, 0), angle)
            arm.set_data(*np.array([(0, 0), vector[:2]]).T)
            for arrow, direction in zip(arrows, frame.rotation.T[[0, 2]], strict=True):
                arrow.set_data(*np.array([vector[:2], vector[:2] + 120 * direction[:2]]).T)
            off = np.linalg.norm(vector - fitted.measured.vectors[0])
            return [*frame.block.splitlines(), f"{kind}; U₀ in its place would be {off:.2f} mm off"]

        return update

    return recorded(build, slider("angle", 0, 360, 45, step=2.5), size=(6.0, 5.0), height=560)


def rotation_centre(rotary, radius=150.0, heights=(50.0, 350.0)):
    """Give a C axis errors, let a ball on its table be followed over a turn, and recover them from the readings."""
    ball = rotary_axis.ball(rotary)
    names = [str(symbol) for symbol in ball.unknowns]
    turn = np.arange(0, 360, 30)
    at = {"angle": np.tile(turn, 2), "x": radius, "y": 0.0, "z": np.repeat(heights, len(turn))}

    def build(figure):
        left, right = figure.subplots(1, 2)
        dots = [
            left.plot([], [], m, color=plot.COLOUR["tool"], label=f"z = {h:.0f}")[0]
            for m, h in zip("ox", heights, strict=True)
        ]
        left.set(xlim=(-90, 90), ylim=(-90, 90), xlabel="e_x (µm)", ylabel="e_y (µm)", aspect="equal")
        left.legend(fontsize=8)
        places = np.arange(4)
        (true,) = right.plot(places, 0 * places, "_", color=plot.COLOUR["published"], markersize=24, label="true")
        (found,) = right.plot(places, 0 * places, "o", color=plot.COLOUR["workpiece"], label="recovered, ±3σ")
        bars = right.vlines(places, 0 * places, 0 * places, color=plot.COLOUR["workpiece"])
        right.set(xlim=(-0.5, 3.5), ylim=(-110, 110), xticks=places, xticklabels=names, ylabel="µm, µrad")
        right.legend(fontsize=8)

        def update(noise_μm, **errors):
            values = 1e-6 * np.array(list(errors.values())) * [1e3, 1e3, 1, 1]
            sigma = max(noise_μm, 1e-6) / 1000
            data = ball.simulate(dict(zip(names, values, strict=True)), at, sigma=sigma, seed=1, degrees=True)
            estimate = ball.identify(data, degrees=True, sigma=sigma)
            unit = np.array([1e3, 1e3, 1e6, 1e6])
            got = unit * list(estimate.values.values())
            spread = 3 * unit * np.sqrt(np.diag(estimate.covariance))
            for dot, rows in zip(dots, (slice(None, len(turn)), slice(len(turn), None)), strict=True):
                dot.set_data(1000 * data["ex"][rows], 1000 * data["ey"][rows])
            true.set_ydata(unit * values)
            found.set_ydata(got)
            bars.set_segments([[(p, g - s), (p, g + s)] for p, g, s in zip(places, got, spread, strict=True)])
            units = ("µm", "µm", "µrad", "µrad")
            return ", ".join(
                f"{n} {g:z.1f} ± {s:.1f} {u}" for n, g, s, u in zip(names, got, spread, units, strict=True)
            )

        return update

    sliders = {
        f"{name}_{unit}": (-60, 60, start, 1)
        for name, unit, start in zip(names, ("μm", "μm", "μrad", "μrad"), (10, -6, -30, 40), strict=True)
    }
    return View(build, sliders | {"noise_μm": (0, 10, 1, 0.5)}, size=(8.0, 4.0))


def rtcp_zero(lengths=(500.0, 700.0)):
    """Give a head a wrong zero and pivot, tilt it to ±ψ with two tools, recover them, and see the source err."""
    tip, way = rotary_axis.rtcp_zero(), np.linspace(-90, 90, 91)

    def build(figure):
        axes = figure.subplots()
        colours = (plot.COLOUR["first branch"], plot.COLOUR["second branch"])
        curves = [
            axes.plot(way, 0 * way, color=c, label=f"L = {x:.0f}")[0] for c, x in zip(colours, lengths, strict=True)
        ]
        dots = [axes.plot([], [], "o", color=c)[0] for c in colours]
        axes.set(xlim=(-95, 95), ylim=(-200, 200), xlabel="ψ (degrees)", ylabel="axial reading (µm)")
        axes.legend(fontsize=8)

        def update(alpha_arcsec, dy_μm, dL_μm, psi, noise_μm):
            true = {"alpha": np.deg2rad(alpha_arcsec / 3600), "dy": dy_μm / 1000, "dL": dL_μm / 1000}
            sigma = max(noise_μm, 1e-6) / 1000
            at = {"angle": np.array([psi, -psi] * 2), "L": np.repeat(lengths, 2)}
            data = tip.simulate(true, at, sigma=sigma, seed=1, degrees=True)
            for line, dot, length, rows in zip(curves, dots, lengths, (slice(2), slice(2, 4)), strict=True):
                line.set_ydata(1000 * tip.predict(true, {"angle": way, "L": length}, degrees=True)["axial"])
                dot.set_data(at["angle"][rows], 1000 * data["axial"][rows])
            estimate = tip.identify(data, degrees=True, sigma=sigma)
            arcsec = 3600 * np.rad2deg(1)
            source = arcsec * rotary_axis.source_zero_angle(data["axial"][2], lengths[1])
            spread = 3 * arcsec * estimate.deviation("alpha")
            return (
                f"alpha {arcsec * estimate['alpha']:z.1f} ± {spread:.1f} arcsec, "
                f"dy {1000 * estimate['dy']:z.1f} µm, dL {1000 * estimate['dL']:z.1f} µm; "
                f"arctan(y/x) of the reading at +ψ: {source:z.1f} arcsec"
            )

        return update

    sliders = {
        "alpha_arcsec": (-40, 40, 29, 1),
        "dy_μm": (-60, 60, 0, 1),
        "dL_μm": (-60, 60, 0, 1),
        "psi": (1, 90, 5, 1),
        "noise_μm": (0, 2, 0, 0.1),
    }
    return View(build, sliders)
