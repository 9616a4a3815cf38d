const close = (tip, rotary) => close_loop([...tip, ...rotary]);

function inverse(tip, axis) {
    const n = axis.map((x) => x / Math.hypot(...axis)), [x, y, z, angle, squared] = solve([...tip, ...n]);
    const turned = squared < $pole ? 0 : angle <= -Math.PI ? Math.PI : angle;
    const q = [...close(tip, [turned]), turned], made = forward(q);
    return Math.hypot(made[3] - n[0], made[4] - n[1], made[5] - n[2]) <= $printed ? [q] : null;
}
