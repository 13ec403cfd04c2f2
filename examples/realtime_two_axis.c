/* The two-axis machine in real time: 1000 time steps a second, with the servos of its motors inside the step.
 *
 *     symoro-elastic ladder examples/two_axis.toml --scene examples/scenes/two_axis_move.toml --out reduced.toml
 *     symoro-elastic generate examples/two_axis.toml --scene reduced.toml --model direct_dynamics \
 *         --model static_deflections --model geometric_model_with_deflections
 *     cc -std=c99 -O2 -Igenerated/two_axis examples/realtime_two_axis.c generated/two_axis/two_axis.c -lm -o realtime
 *     ./realtime
 *
 * With permission, `chrt --fifo 80 ./realtime` keeps other programs from delaying it. docs/scenes.md explains
 * the scene, and where the numbers below come from.
 */
#define _POSIX_C_SOURCE 200112L

#include <math.h>
#include <stdio.h>
#include <sys/mman.h>
#include <time.h>

#include "two_axis.h"

enum { N = TWO_AXIS_JOINTS, MOTORS = TWO_AXIS_MOTORS, NODES = TWO_AXIS_W2_NODES, PERIODS = 250, TOOL = 11, STATIC = 6 };

static const double PERIOD = 1e-3; /* s */

/* Equilibrium at the start, torques that hold it, and gains of the servos. */
static const double start[N] = {-1.03e-06, 0.0, 0.0, -3.746e-06, 0.0, 0.1};
static const double hold[MOTORS] = {0.0, 1010.43};
static const double kp[MOTORS] = {8848100.35, 6982745.11};
static const double kd[MOTORS] = {90126.01, 71125.66};

/* Reference positions and velocities of the motors: by 0.08 m and 0.05 m in 0.15 s. */
static void wanted(double t, double r[MOTORS], double rd[MOTORS])
{
    static const double from[MOTORS] = {0.0, 0.1}, by[MOTORS] = {0.08, 0.05}, lasts = 0.15;
    const double x = fmin(t/lasts, 1.0), left = 1.0 - x;

    for (int m = 0; m < MOTORS; ++m) {
        r[m] = from[m] + by[m]*x*x*x*x*(35.0 + x*(-84.0 + x*(70.0 - 20.0*x)));
        rd[m] = by[m]*140.0*x*x*x*left*left*left/lasts;
    }
}

/* One period: the step takes the torques and the reference motion at its nodes, t and t + h. */
static void advance(double t, double q[N], double qd[N])
{
    double tau[NODES*MOTORS], r[NODES*MOTORS], rd[NODES*MOTORS];

    for (int node = 0; node < NODES; ++node) {
        wanted(t + node*PERIOD, r + node*MOTORS, rd + node*MOTORS);
        for (int m = 0; m < MOTORS; ++m) tau[node*MOTORS + m] = hold[m];
    }
    two_axis_step_w2_servo(tau, r, rd, kp, kd, PERIOD, two_axis_defaults, q, qd);
}

/* The tool, with the deflections of the springs that the step leaves out: they follow from the accelerations. */
static void tool(double t, const double q[N], const double qd[N], double position[3])
{
    static const int motor[MOTORS] = {2, 5}; /* entries of q */
    double r[MOTORS], rd[MOTORS], tau[MOTORS], qdd[N], deflected[STATIC], T[TWO_AXIS_FRAMES*16];

    wanted(t, r, rd);
    for (int m = 0; m < MOTORS; ++m) tau[m] = hold[m] + kp[m]*(r[m] - q[motor[m]]) + kd[m]*(rd[m] - qd[motor[m]]);
    two_axis_direct_dynamics(q, qd, tau, two_axis_defaults, qdd);
    two_axis_static_deflections(q, qd, qdd, two_axis_defaults, deflected);
    two_axis_geometric_model_with_deflections(q, deflected, two_axis_defaults, T);
    for (int k = 0; k < 3; ++k) position[k] = T[16*TOOL + 4*k + 3];
}

static double since(const struct timespec *then)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - then->tv_sec) + 1e-9*(double)(now.tv_nsec - then->tv_nsec);
}

static void add(struct timespec *time, long nanoseconds)
{
    time->tv_nsec += nanoseconds;
    if (time->tv_nsec >= 1000000000L) {
        time->tv_nsec -= 1000000000L;
        ++time->tv_sec;
    }
}

int main(void)
{
    double q[N], qd[N] = {0.0}, position[3], work = 0.0, whole = 0.0;
    struct timespec tick, awake;
    int overruns = 0;

    for (int j = 0; j < N; ++j) q[j] = start[j];
    mlockall(MCL_CURRENT | MCL_FUTURE); /* no page is fetched from the disk in the middle of a period */
    clock_gettime(CLOCK_MONOTONIC, &tick);
    for (int k = 0; k < PERIODS; ++k) {
        add(&tick, lround(1e9*PERIOD));
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &tick, NULL);
        clock_gettime(CLOCK_MONOTONIC, &awake);
        advance(k*PERIOD, q, qd); /* a controller would read its encoders before, and write its set points after */
        work = fmax(work, since(&awake));
        whole = fmax(whole, since(&tick));
        overruns += since(&tick) > PERIOD;
    }
    tool(PERIODS*PERIOD, q, qd, position);
    printf("%d periods of %g ms: longest step %.1f us, end of the step %.1f us after the tick at most, %d overruns\n",
           PERIODS, 1e3*PERIOD, 1e6*work, 1e6*whole, overruns);
    printf("motor_x %.9f m, motor_y %.9f m, tool %.9f %.9f %.9f m\n",
           q[2], q[5], position[0], position[1], position[2]);
    return 0;
}
