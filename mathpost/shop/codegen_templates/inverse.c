int inverse(const double tip[3], const double axis[3], double q[2][5]) {
    const double pi = 3.14159265358979323846, length = sqrt(axis[0]*axis[0] + axis[1]*axis[1] + axis[2]*axis[2]);
    double pose[8] = {tip[0], tip[1], tip[2], axis[0]/length, axis[1]/length, axis[2]/length, 0, 0}, found[12];
    reach(pose + 3, pose + 6);
    if (!(pose[6] >= -$tolerance && pose[7] >= -$tolerance)) return 0;
    pose[6] = fmax(pose[6], 0);
    pose[7] = fmax(pose[7], 0);
    solve(pose, found);
    for (int branch = 0; branch < 2; branch++) {
        const double *const solution = found + 6*branch;
        double *const joints = q[branch];
        for (int joint = 0; joint < 5; joint++) joints[joint] = solution[joint];
        for (int joint = 3; joint < 5; joint++)
            joints[joint] += joints[joint] > pi ? -2*pi : joints[joint] <= -pi ? 2*pi : 0;
        if (!(solution[5] < $pole)) continue;
        joints[$workpiece_side] = 0;
        const double closing[5] = {tip[0], tip[1], tip[2], joints[3], joints[4]};
        close_loop(closing, joints);
    }
    return 2;
}
