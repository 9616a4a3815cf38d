// Curves in panels: positions of one slider as Python recorded them, or printed functions of several sliders.
import { KINDS, fit, fixed, later, make, max, min, PI, round, stage, written } from "./live.js";

class Panel {
    constructor(spec, parent) {
        Object.assign(this, spec);
        this.canvas = stage(parent, spec.title);
        this.canvas.setAttribute("aria-label", spec.title || `${spec.y.label} over ${spec.x.label}`);
    }
    paint() {
        const dpr = fit(this.canvas), ink = this.canvas.getContext("2d"), w = this.canvas.width / dpr, h = this.canvas.height / dpr;
        ink.setTransform(dpr, 0, 0, dpr, 0, 0);
        ink.clearRect(0, 0, w, h);
        ink.font = "12px system-ui, sans-serif";
        const widest = max(0, ...this.column.flatMap(({ y }) => y.ticks.map(([, text]) => ink.measureText(text).width)));
        let [left, right, top, foot] = this.drawn ? [widest + 28, w - 10, 8, h - 38] : [4, w - 4, 4, h - 4];
        const span = ({ limits, log }) => limits.map((v) => log ? Math.log10(v) : v), [x0, x1] = span(this.x), [y0, y1] = span(this.y);
        if (this.equal) {
            const scale = min((right - left) / Math.abs(x1 - x0), (foot - top) / Math.abs(y1 - y0));
            const spareX = right - left - scale * Math.abs(x1 - x0), spareY = foot - top - scale * Math.abs(y1 - y0);
            left += spareX / 2; right -= spareX / 2; top += spareY / 2; foot -= spareY / 2;
        }
        const px = (v) => left + (right - left) * ((this.x.log ? Math.log10(v) : v) - x0) / (x1 - x0);
        const py = (v) => foot - (foot - top) * ((this.y.log ? Math.log10(v) : v) - y0) / (y1 - y0);
        if (this.drawn) this.scales(ink, left, right, top, foot, px, py);
        ink.save();
        ink.beginPath(); ink.rect(left, top, right - left, foot - top); ink.clip();
        for (const artist of this.artists) this.artist(ink, artist, px, py);
        ink.restore();
    }
    scales(ink, left, right, top, foot, px, py) {
        Object.assign(ink, { fillStyle: "#444", strokeStyle: "#e6e6e6", lineWidth: 1, textAlign: "center", textBaseline: "top" });
        const line = (x, y, x2, y2) => { ink.beginPath(); ink.moveTo(x, y); ink.lineTo(x2, y2); ink.stroke(); };
        let free = -1e9;
        for (const [at, text] of [...this.x.ticks].sort((a, b) => px(a[0]) - px(b[0]))) {
            const x = px(at), half = ink.measureText(text).width / 2 + 3;
            line(x, top, x, foot);
            if (x - half > free) { ink.fillText(text, x, foot + 5); free = x + half; }
        }
        ink.fillText(this.x.label, (left + right) / 2, foot + 21);
        Object.assign(ink, { textAlign: "right", textBaseline: "middle" });
        for (const [at, text] of this.y.ticks) { line(left, py(at), right, py(at)); ink.fillText(text, left - 5, py(at)); }
        ink.save();
        ink.translate(9, (top + foot) / 2); ink.rotate(-PI / 2); ink.textAlign = "center";
        ink.fillText(this.y.label, 0, 0);
        ink.restore();
        ink.strokeStyle = "#888"; ink.strokeRect(left, top, right - left, foot - top);
    }
    artist(ink, { points, colour, width, dash, marker, open, last, fill, text }, px, py) {
        const at = [];
        for (let i = 0; i < points.length; i += 2) at.push(points[i] === null || points[i + 1] === null ? null : [px(points[i]), py(points[i + 1])]);
        if (text !== undefined) {
            Object.assign(ink, { fillStyle: colour, textAlign: "center", textBaseline: "middle" });
            if (at[0]) ink.fillText(text, ...at[0]);
            return;
        }
        ink.beginPath();
        at.forEach((p, i) => { if (p) i && at[i - 1] ? ink.lineTo(...p) : ink.moveTo(...p); });
        if (fill) { ink.fillStyle = fill; ink.fill(); return; }
        Object.assign(ink, { strokeStyle: colour, fillStyle: open ? "#fff" : colour, lineWidth: width });
        ink.setLineDash(dash);
        if (width) ink.stroke();
        ink.setLineDash([]);
        ink.lineWidth = 1.5;
        if (marker) for (const p of last ? at.slice(-1) : at) if (p) {
            const [x, y] = p, r = 4;
            ink.beginPath();
            if (marker === "o") { ink.arc(x, y, r, 0, 2 * PI); ink.fill(); }
            if (marker === "." ) { ink.arc(x, y, 2, 0, 2 * PI); ink.fill(); }
            if (marker === "x") { ink.moveTo(x - r, y - r); ink.lineTo(x + r, y + r); ink.moveTo(x - r, y + r); ink.lineTo(x + r, y - r); }
            if (marker === "+") { ink.moveTo(x - 6, y); ink.lineTo(x + 6, y); ink.moveTo(x, y - 6); ink.lineTo(x, y + 6); }
            if (marker === "_") { ink.moveTo(x - 12, y); ink.lineTo(x + 12, y); }
            ink.stroke();
        }
    }
}

// What each colour means, once, above the panels.
function legend(parent, panels) {
    const named = new Map(panels.flatMap(({ artists }) => artists.filter((a) => a.label).map((a) => [a.label, a])));
    for (const [label, { colour, width, dash, marker }] of named) {
        const sign = !width ? { o: "●", x: "×", "+": "+", _: "—" }[marker] || "•" : dash.length === 2 ? (dash[0] > 1 ? "- -" : "····") : dash.length ? "-·-" : "——";
        make("b", make("span", parent, { className: "key" }), { textContent: sign }).style.color = colour;
        parent.lastChild.append(` ${label}`);
    }
}

Object.assign(KINDS, {
    chart(state, [m], ui) {
        const key = make("div", ui.panes, { className: "keys" }), grid = make("div", ui.panes, { className: "charts" });
        grid.style.setProperty("--columns", state.columns);
        ui.panes.className = "panes curves";
        const panels = state.panels.map((spec) => new Panel(spec, grid)), moving = panels.flatMap((p) => p.artists.filter((a) => a.points === null));
        panels.forEach((panel, i) => { panel.column = panels.filter((_, k) => (k - i) % state.columns === 0); });
        legend(key, state.panels);
        const controls = ui.controls(state.sliders, () => update());
        if (state.places) ui.buttons(ui.places(controls));
        if (!m) ui.player(controls, 0);
        function update() {
            controls.show();
            let said;
            if (m) {
                const q = controls.values.map((x, i) => x * state.sliders[i].factor), flat = [...m.points(q)], numbers = m.numbers(q);
                moving.forEach((artist, i) => { artist.points = flat.splice(0, 2 * state.counts[i]); });
                said = written(state.text, numbers);
            } else { // what is between two recorded positions is not known
                let i = 0;
                state.sliders.forEach(({ low, high, step }, k) => {
                    const at = round((controls.values[k] - low) / step);
                    controls.rows[k].box.value = fixed(low + at * step, 3);
                    i = i * (round((high - low) / step) + 1) + at; // the last slider runs fastest
                });
                moving.forEach((artist, k) => { const [x, at] = [state.x[k], state.frames[i][k]]; artist.points = x ? at.flatMap((y, n) => [x[n], y]) : at; });
                said = state.said[i];
            }
            for (const panel of panels) later(panel, () => panel.paint());
            ui.say(said);
        }
        return update;
    },
});
