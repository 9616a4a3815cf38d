// A machine in the browser: its joints as words, its travel, and its joints by hand.
import { DEGREE, KINDS, Scene, abs, angle, fixed, list, make, min, sin } from "./live.js";

const words = (names, q) => names.map((name, i) => name + fixed(i > 2 ? q[i] / DEGREE : q[i], 3)).join(" ");
function outOfTravel({ names, limits }, q) {
    const out = names.flatMap((name, i) => {
        const [low, high] = limits[i], value = i > 2 ? q[i] / DEGREE : q[i], unit = i > 2 ? "°" : "mm";
        const beyond = (low !== null && value < low - 1e-9) || (high !== null && value > high + 1e-9);
        return beyond ? [`${name} ${fixed(value, 3)}${unit} is outside ${low === null ? "-inf" : low} … ${high === null ? "inf" : high}`] : [];
    });
    return out.join("; ");
}
function singular({ pole, reach, tool_side }, axis) {
    if (tool_side === null) return "one rotary axis";
    const from = angle(axis, pole);
    return `${fixed(min(from - reach[0], reach[1] - from) / DEGREE, 2)}° from singular`;
}
const same = (a, b) => abs(sin((a[3] - b[3]) / 2)) + abs(sin((a[4] - b[4]) / 2));
const pose = (m, q) => { const p = [...m.forward(q)]; return [p.slice(0, 3), p.slice(3)]; };

Object.assign(KINDS, {
    // The joints by hand.
    machine(state, [m], ui) {
        const { about, home } = state, scene = new Scene(state.scenes[0], ui.panes);
        const joints = () => controls.values.map((x, i) => i > 2 ? x * DEGREE : x);
        const go = (q) => { controls.values = [...q].map((x, i) => i > 2 ? x / DEGREE : x); update(); };
        const tilt = (angle) => { const q = joints(), r = q.slice(3); r[about.tool_side - 3] = angle; go([...m.close(pose(m, q)[0], r), ...r]); };
        let before;
        const controls = ui.controls(state.sliders, (i) => {
            if (hold.checked && i > 2) { const r = joints().slice(3); go([...m.close(pose(m, before)[0], r), ...r]); } else update();
        });
        const tick = make("label", ui.side, { className: "tick" }), hold = make("input", tick, { type: "checkbox" });
        tick.append(" keep the tip while turning (RTCP)");
        const other = () => {
            const q = joints(), both = m.inverse(...pose(m, q));
            if (both) go(both[same(both[0], q) > same(both[1], q) ? 0 : 1]);
        };
        const two = about.tool_side !== null, limits = two ? about.limits[about.tool_side].filter((limit) => limit !== null) : [];
        const tilts = limits.map((limit) => [`${about.names[about.tool_side]} limit ${fixed(limit, 0)}°`, () => tilt(limit * DEGREE)]);
        const places = [["pole", () => tilt(about.middle)], ...tilts, ["other solution", other]];
        ui.buttons([["home", () => go(home)], ...(two ? places : [])], [scene]);
        function update() {
            const q = joints(), [tip, axis] = pose(m, q);
            before = q;
            controls.show();
            scene.show(m.places(q));
            ui.say([`tip ${list(tip, 3)}, tool axis ${list(axis, 4)}, ${singular(about, axis)}`], outOfTravel(about, q));
        }
        return update;
    },
});
export { outOfTravel, pose, singular, words };
