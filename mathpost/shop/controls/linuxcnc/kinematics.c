/* Kinematics module of LinuxCNC for: $title.
 * Switchable by motion.switchkins-type: 0 the joints are X Y Z and the angles, 1 X Y Z are the tool tip in the workpiece.
 * Joints in mm and degrees, in machine coordinates: the words of a program count from `zero`, which G54 holds.
 */
#include "rtapi.h"
#include "rtapi_app.h"
#include "hal.h"
#include "kinematics.h"

$printed
#define JOINTS $joints
static const double zero[3] = {$zero};
static const double radians = 3.14159265358979323846 / 180;
static int tcp = 0;

/* Words, mm and radians, of joints or of a world pose. */
static void words(double *q, double x, double y, double z, const double *angles) {
    q[0] = x - zero[0], q[1] = y - zero[1], q[2] = z - zero[2];
    for (int n = 3; n < JOINTS; n++) q[n] = angles[n - 3] * radians;
}

int kinematicsForward(const double *joint, EmcPose *world, const KINEMATICS_FORWARD_FLAGS *f, KINEMATICS_INVERSE_FLAGS *i) {
    double *const angle[] = {$angles}, q[JOINTS], pose[6];
    (void)f, (void)i;
    world->tran.x = joint[0], world->tran.y = joint[1], world->tran.z = joint[2];
    for (int n = 3; n < JOINTS; n++) *angle[n - 3] = joint[n];
    if (!tcp) return 0;
    words(q, joint[0], joint[1], joint[2], joint + 3);
    forward(q, pose);
    world->tran.x = pose[0] + zero[0], world->tran.y = pose[1] + zero[1], world->tran.z = pose[2] + zero[2];
    return 0;
}

int kinematicsInverse(const EmcPose *world, double *joint, const KINEMATICS_INVERSE_FLAGS *i, KINEMATICS_FORWARD_FLAGS *f) {
    const double *const angle[] = {$angles};
    double q[JOINTS], linear[3];
    (void)f, (void)i;
    joint[0] = world->tran.x, joint[1] = world->tran.y, joint[2] = world->tran.z;
    for (int n = 3; n < JOINTS; n++) joint[n] = *angle[n - 3];
    if (!tcp) return 0;
    words(q, joint[0], joint[1], joint[2], joint + 3);
    close_loop(q, linear);
    for (int n = 0; n < 3; n++) joint[n] = linear[n] + zero[n];
    return 0;
}

KINEMATICS_TYPE kinematicsType(void) { return KINEMATICS_BOTH; }
int kinematicsSwitchable(void) { return 1; }
int kinematicsSwitch(int type) {
    if (type != 0 && type != 1) return -1;
    tcp = type;
    return 0;
}

EXPORT_SYMBOL(kinematicsForward);
EXPORT_SYMBOL(kinematicsInverse);
EXPORT_SYMBOL(kinematicsType);
EXPORT_SYMBOL(kinematicsSwitchable);
EXPORT_SYMBOL(kinematicsSwitch);
MODULE_LICENSE("GPL");

static int component;
int rtapi_app_main(void) {
    component = hal_init("$module");
    return component < 0 ? component : hal_ready(component);
}
void rtapi_app_exit(void) { hal_exit(component); }
