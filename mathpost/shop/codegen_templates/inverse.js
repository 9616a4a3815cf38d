const close = (tip, rotary) => close_loop([...tip, ...rotary]);
const half_turn = (a) => a > Math.PI ? a - 2 * Math.PI : a <= -Math.PI ? a + 2 * Math.PI : a;

function inverse(tip, axis) {
    const n = axis.map((x) => x / Math.hypot(...axis)), [below, above] = reach(n);
    if (!(below >= -$tolerance && above >= -$tolerance)) return null;
    const found = solve([...tip, ...n, Math.max(below, 0), Math.max(above, 0)]);
    return [found.slice(0, 6), found.slice(6)].map(([x, y, z, first, second, squared]) => {
        const rotary = [half_turn(first), half_turn(second)];
        if (squared >= $pole) return [x, y, z, ...rotary];
        rotary[$workpiece_side - 3] = 0;
        return [...close(tip, rotary), ...rotary];
    });
}
