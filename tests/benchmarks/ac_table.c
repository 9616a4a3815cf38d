/* The yardstick: inverse kinematics of a trunnion, A carries C, written by hand as a post-processor has it.

   One branch. The table turns about X through (0, py, pz) and about Z through (cx, cy), both the ISO 841 way, and
   X Y Z are the tool tip. tip and axis are n rows of 3, joints n rows of X Y Z A C, mm and radians. */

#include <math.h>
#include <stddef.h>

void inverse(size_t n, const double *tip, const double *axis, const double *centre, const double *pivot,
             double *joints)
{
    const double cx = centre[0], cy = centre[1], py = pivot[0], pz = pivot[1];
    for (size_t row = 0; row < n; row++, tip += 3, axis += 3, joints += 5) {
        const double i = axis[0], j = axis[1], k = axis[2];
        const double length = sqrt(i * i + j * j + k * k);
        const double a = acos(k / length);
        const double c = i == 0 && j == 0 ? 0 : atan2(i, -j);
        const double ca = cos(a), sa = sin(a), cc = cos(c), sc = sin(c);
        const double x = tip[0] - cx, y = tip[1] - cy, z = tip[2];
        const double turned_x = cc * x + sc * y + cx;
        const double turned_y = -sc * x + cc * y + cy;
        joints[0] = turned_x;
        joints[1] = ca * (turned_y - py) + sa * (z - pz) + py;
        joints[2] = -sa * (turned_y - py) + ca * (z - pz) + pz;
        joints[3] = a;
        joints[4] = c;
    }
}
