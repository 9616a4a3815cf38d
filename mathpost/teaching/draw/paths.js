// Views of whole paths: one tool axis with both solutions, a walk along a program, and the curves beside it.
import {
    DEGREE, KINDS, Scene, across, angle, ceil, cos, fit, fixed, floor, later, length,
    list, make, max, min, minus, round, sin, stage,
} from "./live.js";
import { outOfTravel, pose, singular, words } from "./machine.js";

// Curves over the records of a path: both branches, what was chosen, travel and singular regions, and a cursor.
class Curves {
    constructor(spec, parent) {
        Object.assign(this, spec);
        this.canvas = stage(parent, spec.title);
        this.canvas.setAttribute("aria-label", spec.title);
    }
    show(at) { this.at = at; later(this, () => this.paint()); }
    paint() {
        const dpr = fit(this.canvas), ink = this.canvas.getContext("2d"), w = this.canvas.width / dpr, h = this.canvas.height / dpr;
        const [left, foot, top] = [46, 22, 8], values = this.curves.flatMap((c) => c.values).filter(Number.isFinite);
        const room = 0.08 * (max(...values) - min(...values)) || 1, low = min(...values) - room, high = max(...values) + room;
        const first = this.records[0], last = this.records[this.records.length - 1];
        const px = (r) => left + (w - left - 8) * (r - first) / (last - first || 1), py = (v) => top + (h - top - foot) * (high - v) / (high - low);
        ink.setTransform(dpr, 0, 0, dpr, 0, 0);
        ink.clearRect(0, 0, w, h);
        const box = (x, y, x2, y2, fill) => { ink.fillStyle = fill; ink.fillRect(x, y, x2 - x, y2 - y); };
        for (const [a, b] of this.singular) box(px(a), top, px(b), h - foot, "#7f7f7f33");
        const [from, to] = this.limits.map((v, i) => max(low, min(high, v === null ? (i ? high : low) : v)));
        box(left, py(from), w - 8, py(low), "#f0e44266"); box(left, py(high), w - 8, py(to), "#f0e44266");
        const stroke = (colour, width, dash, points) => {
            Object.assign(ink, { strokeStyle: colour, lineWidth: width });
            ink.setLineDash(dash); ink.beginPath();
            points.forEach(([x, y], i) => { if (Number.isFinite(y)) i ? ink.lineTo(x, y) : ink.moveTo(x, y); });
            ink.stroke(); ink.setLineDash([]);
        };
        for (const c of this.curves) stroke(c.colour, c.width, c.dash, c.values.map((v, i) => [px(this.records[i]), py(v)]));
        stroke("#999", 1, [], [[left, top], [left, h - foot], [w - 8, h - foot]]);
        stroke("#d55e00", 2, [], [[px(this.at), top], [px(this.at), h - foot]]);
        Object.assign(ink, { fillStyle: "#444", font: "11px system-ui, sans-serif", textBaseline: "middle", textAlign: "right" });
        const step = [1, 2, 5, 10, 15, 30, 45, 60, 90, 180, 360, 720, 1800, 3600].find((s) => (high - low) / s < 6) || 36000;
        for (let v = ceil(low / step) * step; v <= high; v += step) ink.fillText(fixed(v, 0), left - 4, py(v));
        Object.assign(ink, { textAlign: "center" });
        const every = ceil((last - first) / 8) || 1;
        for (let r = ceil(first); r <= last; r += every) ink.fillText(r, px(r), h - foot / 2);
    }
}

Object.assign(KINDS, {
    // One tool axis and both solutions of it.
    both(state, [m], ui) {
        const { about, tip } = state, [sphere, ...scenes] = state.scenes.map((spec) => new Scene(spec, ui.panes));
        const arrow = sphere.lines.find((line) => line.name === "tool"), zero = across(about.pole);
        const controls = ui.controls(state.sliders, () => update());
        const opposite = () => { controls.values[1] += controls.values[1] > 0 ? -180 : 180; update(); };
        ui.buttons([...ui.places(controls), ["turn by 180°", opposite]], [sphere, ...scenes]);
        ui.player(controls, 1);
        function update() {
            const [tilt, direction] = controls.values.map((x) => x * DEGREE);
            const axis = about.pole.map((p, i) => cos(tilt) * p + sin(tilt) * (cos(direction) * zero[0][i] + sin(direction) * zero[1][i]));
            const found = m.inverse(tip, axis);
            arrow.parts = [[[0, 0, 0], axis]];
            sphere.show([]);
            controls.show();
            const said = scenes.map((scene, i) => {
                scene.show(found ? m.places(found[i]) : [], found !== null);
                if (!found) return `${scene.spec.title}: the tool axis is out of reach`;
                const out = outOfTravel(about, found[i]);
                return `${scene.spec.title}: ${words(about.names, found[i])}${out && `; ${out}`}`;
            });
            ui.say([`tool axis ${list(axis, 4)}, ${singular(about, axis)}`, ...said]);
        }
        return update;
    },
    // A walk along the blocks of a program.
    walk(state, machines, ui) {
        const { cl, about, joints, place, singular: near, depth } = state, [m] = machines, scene = new Scene(state.scenes[0], ui.panes);
        const interpolate = (rows, place, at) => {
            let k = 1;
            while (k < place.length - 1 && place[k] < at) k++;
            if (place.length < 2) return rows[0];
            const t = max(0, min(1, (at - place[k - 1]) / (place[k] - place[k - 1])));
            return rows[k - 1].map((x, i) => x + t * (rows[k][i] - x));
        };
        const named = (name) => scene.lines.find((line) => line.name === name), way = named("true tip"), n = joints.length;
        const numbers = joints.map((_, k) => [k]), at = numbers.flat(), every = depth ? (depth.length - 1) / (n - 1) : n > 200 ? 0 : 24;
        const tips = Array.from({ length: every && (n - 1) * every + 1 }, (_, i) => pose(m, interpolate(joints, at, i / every))[0]);
        way.parts = [tips];
        const upTo = (record, tip) => { // draw the path so far, and return how deep the tool is
            const [block] = interpolate(numbers, place, record), k = floor(block * every), deep = depth.map((d) => d > 0.01);
            way.parts = [[...tips.slice(0, k + 1), tip]];
            named("in the part").parts = tips.slice(1, k + 1).flatMap((p, i) => deep[i] && deep[i + 1] ? [[tips[i], p]] : []);
            return interpolate(depth.map((d) => [d]), depth.map((_, i) => i), block * every)[0];
        };
        const panels = [3, 4].map((joint) => {
            const found = cl.map((r) => m.inverse(r.slice(0, 3), r.slice(3)));
            const chosen = cl.map((_, i) => interpolate(joints, place, i)[joint] / DEGREE);
            const branch = (k) => { let turn = 0, old = null; return found.map((both, i) => {
                if (!both) return NaN;
                const x = both[k][joint] / DEGREE;
                turn += 360 * round(((old === null ? chosen[i] : old) - x - turn) / 360);
                return old = x + turn;
            }); };
            const curves = [{ values: chosen, colour: "#7f7f7f88", width: 6, dash: [] }, { values: branch(0), colour: "#009e73", width: 2, dash: [] }, { values: branch(1), colour: "#cc79a7", width: 2, dash: [6, 4] }];
            return new Curves({ title: `${about.names[joint]}, degrees, over the records`, records: cl.map((_, i) => i + 1), limits: about.limits[joint], singular: near, curves }, ui.plots());
        });
        const controls = ui.controls(state.sliders, () => update());
        ui.buttons(ui.places(controls), [scene]);
        ui.player(controls, 0);
        function update() {
            const record = controls.values[0], at = record - 1, k = min(cl.length - 1, floor(at)), next = cl[min(cl.length - 1, k + 1)], t = at - k;
            const wanted = cl[k].map((x, i) => x + t * (next[i] - x)), turned = angle(cl[k].slice(3), next.slice(3));
            const axis = turned < 1e-9 ? cl[k].slice(3) : [3, 4, 5].map((i) => (sin((1 - t) * turned) * cl[k][i] + sin(t * turned) * next[i]) / sin(turned));
            controls.show();
            const q = interpolate(joints, place, at), [tip, tool] = pose(m, q), deep = depth ? upTo(at, tip) : 0;
            scene.show(m.places(q));
            const off = `tip ${fixed(length(minus(tip, wanted.slice(0, 3))), 4)} mm and axis ${fixed(angle(tool, axis) / DEGREE, 3)}° off the CL data`;
            const out = [deep > 0.01 ? `the tool is ${fixed(deep, 2)} mm in the part` : "", outOfTravel(about, q)];
            panels.forEach((panel) => panel.show(record));
            ui.say([`record ${fixed(record, 2)}: ${words(about.names, q)}`, `${off}, ${singular(about, tool)}`], out.filter(Boolean).join("; "));
        }
        return update;
    },
});
