/* Free motion of the two-axis machine under constant motor forces, at the speed of the generated C.
 *
 *     symoro-elastic generate examples/two_axis.toml
 *     cc -std=c99 -O2 -Igenerated/two_axis examples/free_motion.c generated/two_axis/two_axis.c -lm -o free_motion
 *     ./free_motion
 */
#include <stdio.h>

#include "two_axis.h"

enum { N = TWO_AXIS_JOINTS, STEPS = 50000 };

static void advance(double *q, double *qd, const double *tau, double h)
{
    /* Velocities first, then positions: symplectic, so springs neither gain nor lose energy. */
    double qdd[N];
    two_axis_direct_dynamics(q, qd, tau, two_axis_defaults, qdd);
    for (int j = 0; j < N; ++j) {
        qd[j] += h * qdd[j];
        q[j] += h * qd[j];
    }
}

int main(void)
{
    double q[N] = {0.0}, qd[N] = {0.0};
    const double tau[TWO_AXIS_MOTORS] = {200.0, 1010.0};

    for (int step = 1; step <= STEPS; ++step) {
        advance(q, qd, tau, 1e-6);
        if (step % (STEPS / 5) == 0)
            printf("t = %5.1f ms  motor X %8.4f mm  bed x %8.4f um\n", 1e-3 * step, 1e3 * q[4], 1e6 * q[2]);
    }
    return 0;
}
