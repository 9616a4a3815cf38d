// Bodies and frames that move in the browser: canvas, sliders and numbers around functions that sympy printed.
// Machines are in machine.js, whole paths in paths.js, curves in chart.js.
const { abs, atan2, ceil, cos, exp, floor, hypot, max, min, PI, round, sin } = Math;
const DEGREE = PI / 180;
const dot = (a, b) => a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
const cross = (a, b) => [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
const plus = (a, s, b) => a.map((x, i) => x + s * b[i]);
const minus = (a, b) => plus(a, -1, b);
const length = (a) => hypot(...a);
const unit = (a) => a.map((x) => x / length(a));
const angle = (a, b) => 2 * atan2(length(minus(a, b)), length(plus(a, 1, b)));
const fixed = (x, digits) => { const s = x.toFixed(digits); return Number(s) === 0 ? s.replace("-", "") : s; };
// Lines of text: {:4} is the next number with four decimals, {?words} shows the words if it is not 0.
function written(text, numbers) {
    let i = 0;
    return text.map((line) => line.replace(/\{(?::(\d+)|\?([^}]*))\}/g, (_, digits, words) => {
        const x = numbers[i++];
        return digits ? fixed(x, Number(digits)) : x ? words : "";
    }));
}
const list = (values, digits) => [...values].map((x) => fixed(x, digits)).join(" ");
const apply = (m, k, p) => [0, 4, 8].map((r) => m[k + r] * p[0] + m[k + r + 1] * p[1] + m[k + r + 2] * p[2] + m[k + r + 3]);
const across = (a) => { const x = unit(cross(a, abs(a[0]) < 0.6 ? [1, 0, 0] : [0, 1, 0])); return [x, cross(unit(a), x)]; };
const WORLD = [1, 0, 0, 0, 0, 1, 0, 0, 0, 0, 1, 0];

// A solid as triangles: corner x y z and its normal, rounded where faces meet at less than 37 degrees.
function mesh(solid) {
    const { profile, from, along, corners, faces } = solid, found = [];
    if (!faces) {
        const n = profile ? 40 : max(...solid.rings.map((ring) => ring.length)), [x, y] = profile ? across(along) : [];
        const rings = solid.rings || profile.map(([r, h]) => Array.from({ length: n }, (_, i) => {
            const c = r * cos(2 * PI * i / n), s = r * sin(2 * PI * i / n);
            return from.map((o, k) => o + h * along[k] + c * x[k] + s * y[k]);
        }));
        for (let k = 1; k < rings.length; k++) for (let i = 0; i < n; i++) {
            const at = (ring, j) => ring[j % ring.length], [a, b] = [rings[k - 1], rings[k]];
            found.push([at(a, i), at(a, i + 1), at(b, i + 1)], [at(a, i), at(b, i + 1), at(b, i)]);
        }
    } else for (const face of faces) found.push(face.map((i) => corners[i]));
    const flat = found.map((t) => ({ t, n: cross(minus(t[1], t[0]), minus(t[2], t[0])) })).filter((f) => length(f.n) > 1e-9);
    const around = new Map(), key = (p) => p.map((x) => round(100 * x)).join();
    for (const f of flat) {
        f.n = unit(f.n);
        for (const p of f.t) around.has(key(p)) ? around.get(key(p)).push(f.n) : around.set(key(p), [f.n]);
    }
    return Float64Array.from(flat.flatMap((f) => f.t.flatMap((p) => {
        const near = around.get(key(p)).filter((n) => dot(n, f.n) > 0.8);
        return [...p, ...unit(near.reduce((sum, n) => plus(sum, 1, n), [0, 0, 0]))];
    })));
}

// 256 shades of a colour as pixels: cool in the shadow, white in the highlight.
function shades(colour) {
    const rgb = [1, 3, 5].map((i) => parseInt(colour.slice(i, i + 2), 16));
    return Uint32Array.from({ length: 256 }, (_, i) => {
        const light = min(1, i / 200), shine = max(0, i - 200) / 90;
        const [r, g, b] = rgb.map((c, k) => min(255, c * light * (1 - shine) + 255 * shine + (1 - light) * 10 * k));
        return 255 << 24 | b << 16 | g << 8 | r;
    });
}

// Pixels with a depth each: the nearest is shown, even where bodies intersect.
class Raster {
    constructor() { this.canvas = document.createElement("canvas"); }
    resize(width, height) {
        if (this.width === width && this.height === height) return;
        Object.assign(this, { width, height });
        Object.assign(this.canvas, { width, height });
        this.ink = this.canvas.getContext("2d");
        this.image = this.ink.createImageData(width, height);
        this.pixels = new Uint32Array(this.image.data.buffer);
        this.depth = new Float32Array(width * height);
        this.corner = new Float64Array(12);
    }
    clear() { this.pixels.fill(0); this.depth.fill(-1e30); }
    // A mesh by the matrices `m` (at index k) of its body and `view`: pixels across, pixels down, depth.
    solid(mesh, palette, m, k, view) {
        const a = new Float64Array(12), s = this.corner, size = hypot(view[0], view[1], view[2]);
        for (let r = 0; r < 12; r += 4) for (let c = 0; c < 4; c++)
            a[r + c] = view[r] * m[k + c] + view[r + 1] * m[k + 4 + c] + view[r + 2] * m[k + 8 + c] + (c === 3 ? view[r + 3] : 0);
        const turned = (r, i) => a[r] * mesh[i] + a[r + 1] * mesh[i + 1] + a[r + 2] * mesh[i + 2];
        for (let i = 0; i < mesh.length; i += 18) {
            for (let j = 0; j < 3; j++) for (let r = 0; r < 3; r++) s[4 * j + r] = turned(4 * r, i + 6 * j) + a[4 * r + 3];
            const area = (s[4] - s[0]) * (s[9] - s[1]) - (s[8] - s[0]) * (s[5] - s[1]);
            if (!(area < 0)) continue; // seen from behind
            for (let j = 0; j < 3; j++) {
                const normal = i + 6 * j + 3, right = turned(0, normal) / size, up = -turned(4, normal) / size, near = turned(8, normal);
                const gloss = max(0, -0.26 * right + 0.48 * up + 0.84 * near);
                const light = max(0, -0.45 * right + 0.7 * up + 0.55 * near), back = max(0, 0.8 * right - 0.2 * up);
                s[4 * j + 3] = min(254, 1 + 200 * (0.6 + 0.42 * light + 0.1 * back) + 40 * gloss ** 24);
            }
            this.triangle(palette, area);
        }
    }
    triangle(palette, area) {
        const { width, height, pixels, depth } = this, [x0, y0, z0, s0, x1, y1, z1, s1, x2, y2, z2, s2] = this.corner;
        const zx = ((z1 - z0) * (y2 - y0) - (z2 - z0) * (y1 - y0)) / area, zy = ((z2 - z0) * (x1 - x0) - (z1 - z0) * (x2 - x0)) / area;
        const sx = ((s1 - s0) * (y2 - y0) - (s2 - s0) * (y1 - y0)) / area, sy = ((s2 - s0) * (x1 - x0) - (s1 - s0) * (x2 - x0)) / area;
        const low = max(0, ceil(min(y0, y1, y2) - 0.5)), high = min(height, ceil(max(y0, y1, y2) - 0.5));
        for (let row = low; row < high; row++) {
            const y = row + 0.5;
            let left = 1e9, right = -1e9;
            const edge = (xa, ya, xb, yb) => {
                if (ya <= y === yb <= y) return;
                const x = xa + (y - ya) * (xb - xa) / (yb - ya);
                if (x < left) left = x;
                if (x > right) right = x;
            };
            edge(x0, y0, x1, y1); edge(x1, y1, x2, y2); edge(x2, y2, x0, y0);
            const first = max(0, ceil(left - 0.5)), last = min(width, ceil(right - 0.5)), at = row * width;
            let z = z0 + (first + 0.5 - x0) * zx + (y - y0) * zy, s = s0 + (first + 0.5 - x0) * sx + (y - y0) * sy;
            for (let i = at + first; i < at + last; i++) {
                if (z > depth[i]) { depth[i] = z; pixels[i] = palette[max(0, min(255, s | 0))]; }
                z += zx; s += sx;
            }
        }
    }
}

// A picture in space. Drag turns it, the wheel zooms once it has been clicked on, arrows and + − 0 do the same.
class Scene {
    constructor(spec, parent) {
        this.spec = spec;
        this.solids = spec.solids.map((o) => ({ ...o, mesh: mesh(o), palette: shades(o.colour) }));
        this.lines = spec.lines.map((line) => ({ ...line }));
        this.raster = new Raster();
        this.canvas = stage(parent, spec.title, spec.colour);
        this.canvas.tabIndex = 0;
        this.canvas.title = "Drag to turn. Click, then wheel to zoom. Double-click to reset.";
        this.canvas.setAttribute("aria-label", `${spec.title || "picture"}; arrow keys turn it, plus and minus zoom, 0 resets`);
        this.reset();
        const turn = (right, down) => {
            this.azimuth -= right;
            this.elevation = max(-90, min(90, this.elevation + down));
            this.draw();
        };
        const zoom = (factor) => { this.zoom = max(0.3, min(8, this.zoom * factor)); this.draw(); };
        const c = this.canvas;
        c.onpointerdown = (event) => {
            let [x, y] = [event.clientX, event.clientY];
            c.setPointerCapture(event.pointerId);
            c.onpointermove = (e) => { turn(0.4 * (e.clientX - x), 0.4 * (e.clientY - y)); [x, y] = [e.clientX, e.clientY]; };
        };
        c.onpointerup = c.onpointercancel = () => { c.onpointermove = null; };
        c.addEventListener("wheel", (event) => {
            if (document.activeElement !== c && !event.ctrlKey) return; // let the page scroll
            event.preventDefault();
            zoom(exp(-event.deltaY / 500));
        }, { passive: false });
        c.ondblclick = () => { this.reset(); this.draw(); };
        c.onkeydown = (event) => {
            const steps = { ArrowLeft: [5, 0], ArrowRight: [-5, 0], ArrowUp: [0, 5], ArrowDown: [0, -5] }[event.key];
            if (steps) turn(...steps); else if (event.key === "+") zoom(1.2); else if (event.key === "-") zoom(1 / 1.2);
            else if (event.key === "0") c.ondblclick(); else return;
            event.preventDefault();
        };
    }
    reset() { Object.assign(this, { azimuth: this.spec.azimuth, elevation: this.spec.elevation, zoom: 1 }); }
    show(places, visible = true) { this.places = [...WORLD, ...places]; this.visible = visible; this.draw(); }
    draw() { later(this, () => this.paint()); }
    paint() {
        const c = this.canvas, dpr = fit(c), w = c.width, h = c.height, fine = dpr >= 1.5 ? 1 : 2;
        const ink = c.getContext("2d"), { middle, radius } = this.spec, raster = this.raster;
        const a = this.azimuth * DEGREE, e = this.elevation * DEGREE, k = 0.5 * min(w, h) / radius * this.zoom;
        const right = [-sin(a), cos(a), 0], up = [-sin(e) * cos(a), -sin(e) * sin(a), cos(e)], towards = [cos(a) * cos(e), sin(a) * cos(e), sin(e)];
        const view = [...right.map((x) => k * x), w / 2 - k * dot(right, middle), ...up.map((x) => -k * x), h / 2 + k * dot(up, middle), ...towards, -dot(towards, middle)];
        ink.setTransform(1, 0, 0, 1, 0, 0);
        ink.clearRect(0, 0, w, h);
        if (!this.visible) return;
        raster.resize(w * fine, h * fine);
        raster.clear();
        const finer = view.map((x, i) => i < 8 ? x * fine : x);
        for (const o of this.solids) raster.solid(o.mesh, o.palette, this.places, 12 * o.body, finer);
        raster.ink.putImageData(raster.image, 0, 0);
        ink.drawImage(raster.canvas, 0, 0, w, h);
        const project = (body, p) => apply(view, 0, apply(this.places, 12 * body, p)), slack = 0.012 * radius;
        const open = ([x, y, z]) => {
            const i = floor(y * fine) * raster.width + floor(x * fine);
            return !(x >= 0 && x < w && y >= 0 && y < h && raster.depth[i] > z + slack);
        };
        ink.lineCap = ink.lineJoin = "round";
        for (const line of this.lines) for (const part of line.parts) this.stroke(ink, line, part.map((p) => project(line.body, p)), open, dpr);
        this.letters(ink, project, dpr);
    }
    // Strong where nothing hides it, faint where something does.
    stroke(ink, line, points, open, dpr) {
        const runs = { true: new Path2D(), false: new Path2D() };
        let before; // a path of thousands of loose pieces is slow to draw: what goes on goes on
        for (let i = 1; i < points.length; i++) {
            const [p, q] = [points[i - 1], points[i]], n = max(1, ceil(hypot(q[0] - p[0], q[1] - p[1]) / (8 * dpr)));
            for (let j = 0; j < n; j++) {
                const at = (t) => p.map((x, k) => x + t * (q[k] - x)), run = runs[line.over || open(at((j + 0.5) / n))];
                if (run !== before) run.moveTo(...at(j / n));
                run.lineTo(...at((j + 1) / n));
                before = run;
            }
        }
        const path = (run, colour, width, dash = []) => {
            Object.assign(ink, { strokeStyle: colour, lineWidth: width * dpr });
            ink.setLineDash(dash.map((x) => x * dpr));
            ink.stroke(runs[run]);
        };
        ink.globalAlpha = 0.35;
        path(false, line.colour, line.width, line.dash ? [2, 6] : [3, 4]);
        ink.globalAlpha = 1;
        if (line.halo) path(true, "#ffffffcc", line.width + 2.5);
        path(true, line.colour, line.width, line.dash ? [3 + line.width, 3 + 2 * line.width] : []);
        ink.setLineDash([]);
        if (line.dot && points.length) {
            const [x, y] = points[points.length - 1];
            ink.beginPath(); ink.arc(x, y, 5 * dpr, 0, 2 * PI);
            Object.assign(ink, { fillStyle: line.colour, strokeStyle: "#fff", lineWidth: 1.5 * dpr });
            ink.fill(); ink.stroke();
        }
    }
    letters(ink, project, dpr) {
        const shown = this.spec.labels.map((label) => project(label.body, label.at).slice(0, 2));
        const size = min(14 * dpr, max(8 * dpr, this.canvas.height / 14)), gap = 1.45 * size; // small letters on a small picture
        for (let round = 0; round < 12; round++) for (let i = 0; i < shown.length; i++) for (let j = 0; j < i; j++) {
            const way = minus(shown[i], shown[j]), far = length(way);
            if (far >= gap) continue;
            const push = far > 1e-6 ? way.map((x) => x / far * (gap - far) / 2) : [gap / 2, 0];
            shown[i] = plus(shown[i], 1, push); shown[j] = minus(shown[j], push);
        }
        Object.assign(ink, { font: `600 ${size}px system-ui, sans-serif`, textAlign: "center", textBaseline: "middle", lineWidth: 0.28 * size });
        this.canvas.written = shown;
        this.spec.labels.forEach((label, i) => {
            ink.strokeStyle = "#ffffffdd"; ink.strokeText(label.text, ...shown[i]);
            ink.fillStyle = label.colour; ink.fillText(label.text, ...shown[i]);
        });
    }
}

// The page around them.
const make = (tag, parent, properties = {}) => parent.appendChild(Object.assign(document.createElement(tag), properties));
function stage(parent, title, colour) {
    const box = make("figure", parent);
    if (title) make("figcaption", box, { textContent: title }).style.color = colour || "inherit";
    return make("canvas", make("div", box), { role: "img" });
}
function fit(canvas) {
    const dpr = devicePixelRatio || 1, box = canvas.parentElement.getBoundingClientRect();
    const w = max(1, round(box.width * dpr)), h = max(1, round(box.height * dpr));
    if (canvas.width !== w || canvas.height !== h) Object.assign(canvas, { width: w, height: h });
    return dpr;
}
const waiting = new Map();
function later(who, paint) {
    if (!waiting.size) requestAnimationFrame(() => { const all = [...waiting.values()]; waiting.clear(); all.forEach((f) => f()); });
    waiting.set(who, paint);
}

// Sliders and number boxes over one array of exact values; the slider's own rounding never comes back.
// What is set by hand stays between the ends of the slider, where the formulas hold.
class Controls {
    constructor(parent, sliders, changed) {
        this.values = sliders.map((s) => s.value);
        this.rows = sliders.map((s, i) => {
            const row = make("label", parent, { className: "slider", hidden: s.hidden || false }), set = (value) => {
                if (Number.isFinite(value)) this.values[i] = max(s.low, min(s.high, value));
                changed(i);
            };
            make("span", row, { textContent: s.name });
            const range = make("input", row, { type: "range", min: s.low, max: s.high, step: "any" });
            range.setAttribute("aria-label", s.name);
            range.oninput = () => set(range.valueAsNumber);
            range.onkeydown = (event) => { // a native slider without steps goes by a tenth of its length
                const way = { ArrowLeft: -1, ArrowDown: -1, ArrowRight: 1, ArrowUp: 1 }[event.key];
                if (!way) return;
                event.preventDefault();
                set(this.values[i] + way * s.step);
            };
            const box = make("input", row, { type: "number", min: s.low, max: s.high, step: "any" });
            box.setAttribute("aria-label", `${s.name}, ${s.unit || "number"}`);
            box.onchange = () => set(box.valueAsNumber);
            make("small", row, { textContent: s.unit || "" });
            return { range, box };
        });
    }
    show() {
        this.rows.forEach(({ range, box }, i) => { range.value = this.values[i]; box.value = fixed(this.values[i], 3); });
    }
}

// Each kind of view: it makes its pictures and controls and returns the function that a change of the sliders calls.
const KINDS = {
    // Any printed functions: places of bodies, the points of lines, and the numbers of a text.
    formula(state, [m], ui) {
        const scenes = state.scenes.map((spec) => new Scene(spec, ui.panes)), controls = ui.controls(state.sliders, () => update());
        ui.buttons(ui.places(controls), scenes);
        if (Number.isInteger(state.play)) ui.player(controls, state.play);
        function update() {
            const q = controls.values.map((x, i) => x * state.sliders[i].factor), points = [...m.points(q)];
            controls.show();
            for (const scene of scenes) {
                for (const line of scene.lines) if (line.points) line.parts = [Array.from({ length: line.points }, () => points.splice(0, 3))];
                scene.show(m.places(q));
            }
            ui.say(written(state.text, m.numbers(q)));
        }
        return update;
    },
};

function start(root, state, machines) {
    root.className = `live ${state.layout}`;
    const panes = make("div", root, { className: state.scenes.length > 3 ? "panes many" : "panes" }), side = make("div", root, { className: "side" });
    const holder = make("div", side), said = make("output", make("div", root, { className: "said" }));
    let plots;
    const ui = {
        panes, side,
        plots: () => plots = plots || make("div", panes, { className: "plots" }),
        controls: (sliders, changed) => new Controls(holder, sliders, changed),
        // A row of buttons, pairs of label and action, and one that turns the pictures back.
        buttons(actions, scenes = []) {
            const row = make("div", side, { className: "buttons" }), back = () => scenes.forEach((scene) => { scene.reset(); scene.draw(); });
            const all = scenes.length ? [...actions, ["reset view", back]] : actions;
            return all.map(([textContent, onclick]) => make("button", row, { type: "button", textContent, onclick }));
        },
        // Places of interest as such pairs, with the values that they set, null where a slider stays.
        places: (controls) => (state.places || []).map(([label, at]) => [label, () => {
            [at].flat().forEach((x, i) => { if (x !== null) controls.values[i] = x; });
            update();
        }]),
        say(lines, wrong = "") {
            said.textContent = "";
            lines.forEach((textContent) => make("div", said, { textContent }));
            make("div", said, { className: "wrong", textContent: wrong });
        },
        // Play, pause and a step for one slider: its whole length in twelve seconds, in the browser's own time.
        player(controls, index) {
            const { low, high, step } = state.sliders[index];
            let before = null;
            const go = (value) => { controls.values[index] = max(low, min(high, value)); update(); };
            const run = (now) => {
                if (before === null) return;
                const value = controls.values[index] + (now - before) / 12000 * (high - low);
                before = now;
                go(value >= high ? low : value);
                requestAnimationFrame(run);
            };
            const [play] = ui.buttons([["play", () => {
                play.textContent = before === null ? "pause" : "play";
                before = before === null ? performance.now() : null;
                if (before !== null) requestAnimationFrame(run);
            }], ["− step", () => go(controls.values[index] - step)], ["+ step", () => go(controls.values[index] + step)]]);
        },
    };
    let update;
    try {
        update = KINDS[state.kind](state, machines, ui);
        new ResizeObserver(update).observe(panes);
        update();
    } catch (error) { // an older browser: the still picture that lies under this page shows
        root.className = root.textContent = "";
        throw error;
    }
}
export {
    DEGREE, KINDS, Scene, abs, across, angle, ceil, cos, fit, fixed, floor, later, length,
    list, make, max, min, minus, PI, round, sin, stage, written, start,
};
