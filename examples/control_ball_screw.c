/* The controller of the ball-screw axis in real time, 8000 times a second; time steps stand for the machine.
 *
 *     symoro-elastic control examples/ball_screw.toml --damping 0.01 --save tuned.toml
 *     symoro-elastic generate tuned.toml --scene examples/scenes/ball_screw_drives.toml
 *     cc -std=c99 -O2 -ffp-contract=off -Igenerated/ball_screw examples/control_ball_screw.c \
 *         generated/ball_screw/ball_screw.c -lm -o axis
 *     ./axis
 *
 * On the axis itself `advance` goes: encoders are read in its place, and the torque goes to the amplifier.
 * docs/drives.md explains the controller.
 */
#define _POSIX_C_SOURCE 200112L

#include <math.h>
#include <stdio.h>
#include <time.h>

#include "ball_screw.h"

enum { N = BALL_SCREW_JOINTS, NODES = BALL_SCREW_W3_NODES, PERIODS = 800, MOTOR = 0, TABLE = 6, STATES = 1 };

static const double PERIOD = 1.25e-4; /* s, as in [drives]: the torque comes a period after the sample */
static const double LAG = 2e-4;       /* s, of the current loop */

/* Set point: by 2 rad in 0.06 s. */
static void wanted(double t, double r[1], double rd[1], double rdd[1])
{
    const double by = 2.0, lasts = 0.06, x = fmin(t/lasts, 1.0), left = 1.0 - x;

    r[0] = by*x*x*x*x*(35.0 + x*(-84.0 + x*(70.0 - 20.0*x)));
    rd[0] = by*140.0*x*x*x*left*left*left/lasts;
    rdd[0] = by*420.0*x*x*left*left*(1.0 - 2.0*x)/(lasts*lasts);
}

/* The machine over a period: a set point of torque that is held, the current loop behind it, a step of order 3. */
static void advance(double held, double *torque, double q[N], double qd[N])
{
    static const double nodes[NODES] = {0.0, 0.871733043016918, 0.7315799577888524, 1.0}; /* in the header */
    double tau[NODES];

    for (int node = 0; node < NODES; ++node) tau[node] = held + (*torque - held)*exp(-nodes[node]*PERIOD/LAG);
    ball_screw_step_w3(tau, PERIOD, ball_screw_defaults, q, qd);
    *torque = tau[NODES - 1];
}

static double since(const struct timespec *then)
{
    struct timespec now;
    clock_gettime(CLOCK_MONOTONIC, &now);
    return (double)(now.tv_sec - then->tv_sec) + 1e-9*(double)(now.tv_nsec - then->tv_nsec);
}

int main(void)
{
    double q[N] = {0.0}, qd[N] = {0.0}, zc[STATES], held = 0.0, torque = 0.0, largest = 0.0, work = 0.0;
    double r[1], rd[1], rdd[1], u[1];
    const double hold[1] = {0.0}; /* the axis is level; else the torque that holds it, or that of a feed-forward */
    struct timespec tick, awake;

    wanted(0.0, r, rd, rdd);
    ball_screw_control_start(r, rd, rdd, hold, ball_screw_defaults, zc);
    clock_gettime(CLOCK_MONOTONIC, &tick);
    for (int k = 0; k < PERIODS; ++k) {
        tick.tv_nsec += lround(1e9*PERIOD);
        if (tick.tv_nsec >= 1000000000L) {
            tick.tv_nsec -= 1000000000L;
            ++tick.tv_sec;
        }
        clock_nanosleep(CLOCK_MONOTONIC, TIMER_ABSTIME, &tick, NULL);
        clock_gettime(CLOCK_MONOTONIC, &awake);
        wanted(k*PERIOD, r, rd, rdd);
        ball_screw_control(&q[MOTOR], &qd[MOTOR], r, rd, rdd, hold, zc, ball_screw_defaults, u, zc);
        work = fmax(work, since(&awake));
        advance(held, &torque, q, qd);
        held = u[0];
        largest = fmax(largest, fabs(held));
    }
    printf("%d periods of %g ms: the controller took %.2f us at most\n", PERIODS, 1e3*PERIOD, 1e6*work);
    printf("motor %.6f rad, set point of the torque up to %.2f N m\n", q[MOTOR], largest);
    return 0;
}
