int inverse(const double tip[3], const double axis[3], double q[1][4]) {
    const double pi = 3.14159265358979323846, length = sqrt(axis[0]*axis[0] + axis[1]*axis[1] + axis[2]*axis[2]);
    const double pose[8] = {tip[0], tip[1], tip[2], axis[0]/length, axis[1]/length, axis[2]/length, 0, 0};
    double found[5], made[6];
    solve(pose, found);
    const double angle = found[4] < $pole ? 0 : found[3] <= -pi ? pi : found[3];
    const double closing[4] = {tip[0], tip[1], tip[2], angle};
    q[0][3] = angle;
    close_loop(closing, q[0]);
    forward(q[0], made);
    const double x = made[3] - pose[3], y = made[4] - pose[4], z = made[5] - pose[5];
    return sqrt(x*x + y*y + z*z) <= $printed;
}
