/* two_axis: generated models in double precision. Equation numbers are those of Khalil and Gautier.
 *
 * Fastest with -O3 -march=native -ffp-contract=fast -fno-math-errno -fno-trapping-math, and for AVX-512
 * -mprefer-vector-width=512. Not with -ffast-math, which costs accuracy.
 * A batch computes LANES states side by side; a number of states that is a large power of two makes caches slow. Entry k of an input is at k*stride, of a work array or result at k*lanes.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "two_axis.h"

#ifdef __GNUC__
#define INLINE static inline __attribute__((always_inline, unused))
#define APART static __attribute__((noinline, unused))
#define ALIGNED __attribute__((aligned(64)))
#else
#define INLINE static inline
#define APART static
#define ALIGNED
#endif
#define LANES 8

const double two_axis_defaults[TWO_AXIS_PARAMETERS] = {
    0.35, /* D4 [m] */
    0.15, /* D12 [m] */
    0.25, /* L12 [m] */
    0.12 /* D13 [m] */
};

/* Angles up to this size, in rad, take the branch-free way; larger ones, infinities and NaN the library's. */
#ifdef __FAST_MATH__ /* takes the rounding of k apart */
#undef LARGEST_ANGLE
#define LARGEST_ANGLE -1.0
#endif
#ifndef LARGEST_ANGLE
#define LARGEST_ANGLE 1048576.0
#endif

/* Sines and cosines of n angles, within 1.5 units in the last place up to LARGEST_ANGLE.
 *
 * x = k pi/2 + r with pi/2 in three parts, of which k times the first two are exact; polynomials in r; the last two
 * bits of k, read from the sum that rounds it, choose sine or cosine and the signs.
 */
INLINE void circles(size_t n, const double *restrict x, double *restrict sine, double *restrict cosine)
{
    uint64_t large = 0;
    for (size_t i = 0; i < n; i++)
        large |= !(fabs(x[i]) <= LARGEST_ANGLE);
    if (large) {
        for (size_t i = 0; i < n; i++) {
            sine[i] = sin(x[i]);
            cosine[i] = cos(x[i]);
        }
        return;
    }
    for (size_t i = 0; i < n; i++) {
        const double rounder = 0x1.8p52;
        const double rounded = x[i]*0x1.45f306dc9c883p-1 + rounder;
        const double k = rounded - rounder;
        const double t = x[i] - k*0x1.921fb544p+0, u = k*0x1.0b4611a6p-34, v = t - u;
        const double r = v + (((t - v) - u) - k*0x1.3198a2e037073p-69);
        const double z = r*r;
        const double s = r + r*z*(-0x1.5555555555555p-3 + z*(0x1.1111111110bb2p-7 + z*(-0x1.a01a019e83900p-13
            + z*(0x1.71de37965e0e8p-19 + z*(-0x1.ae600acd78df1p-26 + z*0x1.5e0b04aa9e9dbp-33)))));
        const double c = 1.0 - (0.5*z - z*z*(0x1.5555555555555p-5 + z*(-0x1.6c16c16c16967p-10 + z*(0x1.a01a019f4e9f7p-16
            + z*(-0x1.27e4fa17c076bp-22 + z*(0x1.1eeb68cb4c486p-29 + z*-0x1.907d8bf27a69cp-37))))));
        uint64_t quarter, bits_s, bits_c;
        memcpy(&quarter, &rounded, sizeof quarter);
        memcpy(&bits_s, &s, sizeof bits_s);
        memcpy(&bits_c, &c, sizeof bits_c);
        const uint64_t exchange = (0 - (quarter & 1)) & (bits_s ^ bits_c);
        bits_s ^= exchange ^ ((quarter & 2) << 62);
        bits_c ^= exchange ^ (((quarter + 1) & 2) << 62);
        memcpy(&sine[i], &bits_s, sizeof bits_s);
        memcpy(&cosine[i], &bits_c, sizeof bits_c);
    }
}

/* The last states of a batch, fewer than LANES, the last one repeated. */
INLINE void load(size_t entries, size_t states, size_t count, const double *restrict from, double *restrict to)
{
    for (size_t k = 0; k < entries; k++)
        for (size_t l = 0; l < LANES; l++)
            to[k*LANES + l] = from[k*states + (l < count ? l : count - 1)];
}

/* Results of `count` states, LANES or fewer, put in their places. */
INLINE void store(size_t entries, size_t states, size_t count, const double *restrict from, double *restrict to)
{
    for (size_t k = 0; k < entries; k++)
        for (size_t l = 0; l < count; l++)
            to[k*states + l] = from[k*LANES + l];
}

INLINE void two_axis_direct_dynamics_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double q1 = q[0*stride];
    const double q6 = q[5*stride];
    angle[0*lanes] = q1;
    angle[1*lanes] = q6;
}

INLINE void two_axis_direct_dynamics_state(size_t stride, size_t lanes, const double *restrict q, const double *restrict qd, const double *restrict tau, const double *restrict p, const double *restrict sine, const double *restrict cosine, double *restrict qdd)
{
    (void)stride, (void)lanes;
    const double q1 = q[0*stride];
    const double q2 = q[1*stride];
    const double q3 = q[2*stride];
    const double q4 = q[3*stride];
    const double q5 = q[4*stride];
    const double q6 = q[5*stride];
    const double q7 = q[6*stride];
    const double q8 = q[7*stride];
    const double q9 = q[8*stride];
    const double q10 = q[9*stride];
    const double q11 = q[10*stride];
    const double q13 = q[11*stride];
    const double qd1 = qd[0*stride];
    const double qd2 = qd[1*stride];
    const double qd3 = qd[2*stride];
    const double qd4 = qd[3*stride];
    const double qd5 = qd[4*stride];
    const double qd6 = qd[5*stride];
    const double qd7 = qd[6*stride];
    const double qd8 = qd[7*stride];
    const double qd9 = qd[8*stride];
    const double qd10 = qd[9*stride];
    const double qd11 = qd[10*stride];
    const double qd13 = qd[11*stride];
    const double tau5 = tau[0*stride];
    const double tau9 = tau[1*stride];
    const double D4 = p[TWO_AXIS_P_D4];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Forward recursion: velocities, joint 1 (bed_yaw) [1], [3], [7], [14]. */
    const double sin_q1 = sine[0*lanes];
    const double cos_q1 = cosine[0*lanes];
    const double Vk1_1 = 9.81*sin_q1;
    const double Vk1_2 = 9.81*cos_q1;
    const double ww1_zz = qd1*qd1;

    /* Forward recursion: velocities, joint 2 (bed_y) [1], [3], [7], [14]. */
    const double g2_1a = 2.0*qd1;
    const double g2_1 = Vk1_1 - qd2*g2_1a;
    const double g2_3 = Vk1_2 - q2*ww1_zz;

    /* Forward recursion: velocities, joint 3 (bed_x) [1], [3], [7], [14]. */
    const double g3_3 = -q3*ww1_zz;
    const double g3_2 = -qd3*g2_1a;
    const double b3_1 = -500.0*ww1_zz;

    /* Forward recursion: velocities, joint 4 (motor_secondary) [1], [3], [7], [14]. */
    const double g4_3 = -q4*ww1_zz;
    const double g4_1 = qd4*g2_1a - D4*ww1_zz;

    /* Forward recursion: velocities, joint 5 (motor_x) [1], [3], [7], [14]. */
    const double g5_3 = -q5*ww1_zz;
    const double g5_1 = qd5*g2_1a;

    /* Forward recursion: velocities, joint 6 (cart_yaw) [1], [3], [7], [14]. */
    const double sin_q6 = sine[1*lanes];
    const double cos_q6 = cosine[1*lanes];
    const double w6_z = qd1 + qd6;
    const double ww6_zz = w6_z*w6_z;

    /* Forward recursion: velocities, joint 7 (cart_x) [1], [3], [7], [14]. */
    const double g7_3 = -q7*ww6_zz;
    const double g7_1a = 2.0*w6_z;
    const double g7_1 = qd7*g7_1a;

    /* Forward recursion: velocities, joint 8 (cart_y) [1], [3], [7], [14]. */
    const double g8_3 = -q8*ww6_zz;
    const double g8_2 = -qd8*g7_1a;
    const double b8_1 = 4.2*ww6_zz;
    const double b8_3 = 63.0*ww6_zz;

    /* Forward recursion: velocities, joint 9 (motor_y) [1], [3], [7], [14]. */
    const double g9_3 = -q9*ww6_zz;
    const double g9_1 = -qd9*g7_1a;

    /* Forward recursion: velocities, joint 10 (y_chain_1) [1], [3], [7], [14]. */
    const double g10_3 = -q10*ww6_zz;
    const double g10_1 = -qd10*g7_1a;

    /* Forward recursion: velocities, joint 11 (ram) [1], [3], [7], [14]. */
    const double g11_3 = -q11*ww6_zz;
    const double g11_1 = -qd11*g7_1a;
    const double b11_3 = -14.25*ww6_zz;

    /* Forward recursion: velocities, joint 13 (sensor_head) [1], [3], [7], [14]. */
    const double Js5_15 = 0.6*q13;
    const double b13_1 = (D13*ww1_zz - qd13*g2_1a)*0.6;
    const double b13_3 = Js5_15*ww1_zz;

    /* Backward recursion: articulated inertias and wrenches, joint 13 (sensor_head) [28]-[32]. */
    const double Gamma13 = -25000000.0*q13;
    const double Gb13 = Gamma13 + b13_3;
    const double qdf13 = 1.6666666666666667*Gb13;

    /* Backward recursion: articulated inertias and wrenches, joint 11 (ram) [28]-[32]. */
    const double Gamma11 = -250000000.0*q11;
    const double Gb11 = Gamma11 + b11_3;
    const double al11_1 = 95.0*g11_1;
    const double al11_5 = -14.25*g11_1;
    const double qdf11 = 0.010526315789473684*Gb11;

    /* Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [28]-[32]. */
    const double Gamma10 = -120000000.0*q10;
    const double Js10_15a = 95.0*q11;
    const double Js10_15 = Js10_15a - 14.25;
    const double Js10_55 = q11*(Js10_15a - 28.5) + 9.2375;
    const double Gb10 = Gamma10 - Gamma11;
    const double qdf10 = 0.125*Gb10;
    const double bs10_5 = -(al11_5 + q11*al11_1);
    const double al10_1 = al11_1 + 103.0*g10_1;
    const double al10_5 = Js10_15*g10_1 - bs10_5;

    /* Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [28]-[32]. */
    const double Js9_15 = Js10_15 + 103.0*q10;
    const double Js9_55 = Js10_55 + q10*(Js10_15 + Js9_15);
    const double Gb9 = tau9 - Gamma10;
    const double qdf9 = 0.005555555555555556*Gb9;
    const double bs9_5 = -(al10_5 + q10*al10_1);
    const double al9_1 = al10_1 + 103.0*g9_1;
    const double al9_5 = Js9_15*g9_1 - bs9_5;

    /* Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [28]-[32]. */
    const double Gamma8 = -500000000.0*q8;
    const double Js8_15a = Js9_15 + 103.0*q9;
    const double Js8_15 = Js8_15a + 63.0;
    const double K8_44 = Js9_55 + q9*(Js9_15 + Js8_15a) + 34.9;
    const double bs8_5 = -(al9_5 + q9*al9_1);
    const double bs8_1 = b8_1 - al9_1;
    const double bs8_3 = b8_3 - Gamma10;
    const double Gb8 = Gamma8 + bs8_3;
    const double qdf8 = 0.004761904761904762*Gb8;
    const double al8_2 = 313.0*g8_2 - bs8_1;
    const double al8_4 = bs8_5 + 0.02*Gb8 - Js8_15*g8_2;

    /* Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [28]-[32]. */
    const double Gamma7 = -350000000.0*q7;
    const double Js7_16 = Js8_15 + 313.0*q8;
    const double Js7_44 = K8_44 + q8*(Js8_15 + Js7_16);
    const double UH7_4 = -0.003194888178913738*Js7_16;
    const double K7_55 = Js7_44 + Js7_16*UH7_4;
    const double bs7_4 = q8*al8_2 - al8_4;
    const double Gb7 = Gamma7 - al8_2;
    const double qdf7 = 0.003194888178913738*Gb7;
    const double al7_5 = -(bs7_4 + Js7_16*qdf7);

    /* Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [28]-[32]. */
    const double Gamma6 = -11000000.0*q6;
    const double al6_1 = cos_q6*Gamma8 + sin_q6*Gamma7;
    const double al6_2 = sin_q6*Gamma8 - cos_q6*Gamma7;
    const double bs6_6 = -(q7*Gamma8 + al7_5);
    const double Gb6 = Gamma6 + bs6_6;
    const double qdf6 = Gb6/K7_55;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [28]-[32]. */
    const double Js5_55 = q13*Js5_15 + 3.001;
    const double bs5_3 = al6_2 - Gamma13;
    const double Gb5 = tau5 + bs5_3;
    const double qdf5 = 0.022222222222222223*Gb5;
    const double bs5_1 = b13_1 - al6_1;
    const double bs5_5 = D13*Gamma13 + q13*b13_1 - Gamma6;
    const double al5_1 = 45.6*g5_1 - bs5_1;
    const double al5_5 = Js5_15*g5_1 - bs5_5;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [28]-[32]. */
    const double Gamma4 = -600000000.0*q4;
    const double Js4_15 = Js5_15 + 45.6*q5;
    const double Js4_55 = Js5_55 + q5*(Js5_15 + Js4_15) + 12.0;
    const double Gb4 = Gamma4 - tau5;
    const double qdf4 = 0.011111111111111112*Gb4;
    const double bs4_5 = -(al5_5 + q5*al5_1);
    const double al4_1 = al5_1 + 135.6*g4_1;
    const double al4_5 = Js4_15*g4_1 - bs4_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [28]-[32]. */
    const double Gamma3 = -100000000.0*q3;
    const double Js3_15 = Js4_15 + 135.6*q4;
    const double K3_44 = Js4_55 + q4*(Js4_15 + Js3_15) + 1100.0;
    const double Gb3 = Gamma3 - Gamma4;
    const double qdf3 = 0.0004*Gb3;
    const double bs3_5 = D4*Gamma4 - (al4_5 + q4*al4_1);
    const double bs3_1 = b3_1 - al4_1;
    const double al3_2 = bs3_1 + 2635.6*g3_2;
    const double al3_4 = -(Js3_15*g3_2 + bs3_5 - 0.2*Gb3);

    /* Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [28]-[32]. */
    const double Gamma2 = -150000000.0*q2;
    const double Js2_34 = Js3_15 + 2635.6*q3;
    const double Js2_44 = K3_44 + q3*(Js3_15 + Js2_34);
    const double UH2_4 = 0.0003794202458643193*Js2_34;
    const double K2_55 = Js2_44 - Js2_34*UH2_4;
    const double bs2_4 = q3*al3_2 - al3_4;
    const double Gb2 = Gamma2 + al3_2;
    const double qdf2 = 0.0003794202458643193*Gb2;
    const double al2_5 = bs2_4 - Js2_34*qdf2;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [28]-[32]. */
    const double Gamma1 = -40000000.0*q1;
    const double bs1_6 = q2*Gamma3 + al2_5;
    const double Gb1 = Gamma1 + bs1_6;
    const double qdf1 = Gb1/K2_55;

    /* Forward recursion: accelerations and torques, joint 2 (bed_y) [33]-[36]. */
    const double vd2_y = g2_1 - q2*qdf1;
    const double vd2_z = qdf2 - UH2_4*qdf1;
    const double qdd2 = vd2_z - g2_3;

    /* Forward recursion: accelerations and torques, joint 3 (bed_x) [33]-[36]. */
    const double vd3_x = vd2_z + q3*qdf1 - g3_2;
    const double vd3_z = qdf3 - 0.2*qdf1;
    const double qdd3 = vd3_z - (g3_3 + vd2_y);

    /* Forward recursion: accelerations and torques, joint 4 (motor_secondary) [33]-[36]. */
    const double vd4_x = g4_1 + vd3_x + q4*qdf1;
    const double qdd4 = qdf4 + D4*qdf1 - vd3_z - g4_3;

    /* Forward recursion: accelerations and torques, joint 5 (motor_x) [33]-[36]. */
    const double qdd5 = qdf5 - (qdf4 + g5_3);
    const double vd5_x = g5_1 + vd4_x + q5*qdf1;

    /* Forward recursion: accelerations and torques, joint 6 (cart_yaw) [33]-[36]. */
    const double vd6_x = cos_q6*vd5_x - sin_q6*qdf5;
    const double vd6_y = -(cos_q6*qdf5 + sin_q6*vd5_x);
    const double qdd6 = qdf6 - qdf1;

    /* Forward recursion: accelerations and torques, joint 7 (cart_x) [33]-[36]. */
    const double vd7_y = -(g7_1 + vd6_x + q7*qdf6);
    const double vd7_z = qdf7 - UH7_4*qdf6;
    const double qdd7 = vd6_y - g7_3 + vd7_z;

    /* Forward recursion: accelerations and torques, joint 8 (cart_y) [33]-[36]. */
    const double vd8_z = qdf8 - 0.02*qdf6;
    const double qdd8 = vd7_y - g8_3 + vd8_z;

    /* Forward recursion: accelerations and torques, joint 9 (motor_y) [33]-[36]. */
    const double vd9_z = qdf9 + g9_3 + vd8_z;

    /* Forward recursion: accelerations and torques, joint 10 (y_chain_1) [33]-[36]. */
    const double qdd10 = qdf10 - (g10_3 + vd9_z);

    /* Forward recursion: accelerations and torques, joint 11 (ram) [33]-[36]. */
    const double qdd11 = qdf11 - (qdf10 + g11_3);

    /* Forward recursion: accelerations and torques, joint 13 (sensor_head) [33]-[36]. */
    const double qdd13 = qdf13 - (qdf5 - D13*qdf1);

    /* Results. */
    qdd[0*lanes] = qdf1;
    qdd[1*lanes] = qdd2;
    qdd[2*lanes] = qdd3;
    qdd[3*lanes] = qdd4;
    qdd[4*lanes] = qdd5;
    qdd[5*lanes] = qdd6;
    qdd[6*lanes] = qdd7;
    qdd[7*lanes] = qdd8;
    qdd[8*lanes] = qdf9;
    qdd[9*lanes] = qdd10;
    qdd[10*lanes] = qdd11;
    qdd[11*lanes] = qdd13;
}

void two_axis_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double angle[2];
    double sine[2];
    double cosine[2];
    two_axis_direct_dynamics_angles(1, 1, q, angle);
    circles(2, angle, sine, cosine);
    two_axis_direct_dynamics_state(1, 1, q, qd, tau, p, sine, cosine, qdd);
}

APART void two_axis_direct_dynamics_state_lanes(size_t stride, const double *restrict q, const double *restrict qd, const double *restrict tau, const double *restrict p, const double *restrict sine, const double *restrict cosine, double *restrict qdd)
{
    for (size_t l = 0; l < LANES; l++)
        two_axis_direct_dynamics_state(stride, LANES, q + l, qd + l, tau + l, p, sine + l, cosine + l, qdd + l);
}

static void two_axis_direct_dynamics_lanes(size_t stride, const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double angle[2*LANES] ALIGNED;
    double sine[2*LANES] ALIGNED;
    double cosine[2*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        two_axis_direct_dynamics_angles(stride, LANES, q + l, angle + l);
    circles(2*LANES, angle, sine, cosine);
    two_axis_direct_dynamics_state_lanes(stride, q, qd, tau, p, sine, cosine, qdd);
}

void two_axis_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double found_qdd[12*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        two_axis_direct_dynamics_lanes(states, q + first, qd + first, tau + first, p, found_qdd);
        store(12, states, LANES, found_qdd, qdd + first);
    }
    if (count) {
        double last_q[12*LANES] ALIGNED;
        load(12, states, count, q + first, last_q);
        double last_qd[12*LANES] ALIGNED;
        load(12, states, count, qd + first, last_qd);
        double last_tau[2*LANES] ALIGNED;
        load(2, states, count, tau + first, last_tau);
        two_axis_direct_dynamics_lanes(LANES, last_q, last_qd, last_tau, p, found_qdd);
        store(12, states, count, found_qdd, qdd + first);
    }
}

INLINE void two_axis_inverse_dynamics_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double q1 = q[0*stride];
    const double q6 = q[5*stride];
    angle[0*lanes] = q1;
    angle[1*lanes] = q6;
}

INLINE void two_axis_inverse_dynamics_state(size_t stride, size_t lanes, const double *restrict q, const double *restrict qd, const double *restrict qdd_motor, const double *restrict p, const double *restrict sine, const double *restrict cosine, double *restrict tau, double *restrict qdd)
{
    (void)stride, (void)lanes;
    const double q1 = q[0*stride];
    const double q2 = q[1*stride];
    const double q3 = q[2*stride];
    const double q4 = q[3*stride];
    const double q5 = q[4*stride];
    const double q6 = q[5*stride];
    const double q7 = q[6*stride];
    const double q8 = q[7*stride];
    const double q9 = q[8*stride];
    const double q10 = q[9*stride];
    const double q11 = q[10*stride];
    const double q13 = q[11*stride];
    const double qd1 = qd[0*stride];
    const double qd2 = qd[1*stride];
    const double qd3 = qd[2*stride];
    const double qd4 = qd[3*stride];
    const double qd5 = qd[4*stride];
    const double qd6 = qd[5*stride];
    const double qd7 = qd[6*stride];
    const double qd8 = qd[7*stride];
    const double qd9 = qd[8*stride];
    const double qd10 = qd[9*stride];
    const double qd11 = qd[10*stride];
    const double qd13 = qd[11*stride];
    const double qdd5 = qdd_motor[0*stride];
    const double qdd9 = qdd_motor[1*stride];
    const double D4 = p[TWO_AXIS_P_D4];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Forward recursion: velocities, joint 1 (bed_yaw) [1], [3], [7], [14]. */
    const double sin_q1 = sine[0*lanes];
    const double cos_q1 = cosine[0*lanes];
    const double Vk1_1 = 9.81*sin_q1;
    const double Vk1_2 = 9.81*cos_q1;
    const double ww1_zz = qd1*qd1;

    /* Forward recursion: velocities, joint 2 (bed_y) [1], [3], [7], [14]. */
    const double g2_1a = 2.0*qd1;
    const double g2_1 = Vk1_1 - qd2*g2_1a;
    const double g2_3 = Vk1_2 - q2*ww1_zz;

    /* Forward recursion: velocities, joint 3 (bed_x) [1], [3], [7], [14]. */
    const double g3_3 = -q3*ww1_zz;
    const double g3_2 = -qd3*g2_1a;
    const double b3_1 = -500.0*ww1_zz;

    /* Forward recursion: velocities, joint 4 (motor_secondary) [1], [3], [7], [14]. */
    const double g4_3 = -q4*ww1_zz;
    const double g4_1 = qd4*g2_1a - D4*ww1_zz;

    /* Forward recursion: velocities, joint 5 (motor_x) [1], [3], [7], [14]. */
    const double g5_3 = -q5*ww1_zz;
    const double g5_1 = qd5*g2_1a;

    /* Forward recursion: velocities, joint 6 (cart_yaw) [1], [3], [7], [14]. */
    const double sin_q6 = sine[1*lanes];
    const double cos_q6 = cosine[1*lanes];
    const double w6_z = qd1 + qd6;
    const double ww6_zz = w6_z*w6_z;

    /* Forward recursion: velocities, joint 7 (cart_x) [1], [3], [7], [14]. */
    const double g7_3 = -q7*ww6_zz;
    const double g7_1a = 2.0*w6_z;
    const double g7_1 = qd7*g7_1a;

    /* Forward recursion: velocities, joint 8 (cart_y) [1], [3], [7], [14]. */
    const double g8_3 = -q8*ww6_zz;
    const double g8_2 = -qd8*g7_1a;
    const double b8_1 = 4.2*ww6_zz;
    const double b8_3 = 63.0*ww6_zz;

    /* Forward recursion: velocities, joint 9 (motor_y) [1], [3], [7], [14]. */
    const double g9_3 = -q9*ww6_zz;
    const double g9_1 = -qd9*g7_1a;

    /* Forward recursion: velocities, joint 10 (y_chain_1) [1], [3], [7], [14]. */
    const double g10_3 = -q10*ww6_zz;
    const double g10_1 = -qd10*g7_1a;

    /* Forward recursion: velocities, joint 11 (ram) [1], [3], [7], [14]. */
    const double g11_3 = -q11*ww6_zz;
    const double g11_1 = -qd11*g7_1a;
    const double b11_3 = -14.25*ww6_zz;

    /* Forward recursion: velocities, joint 13 (sensor_head) [1], [3], [7], [14]. */
    const double Js5_15 = 0.6*q13;
    const double b13_1 = (D13*ww1_zz - qd13*g2_1a)*0.6;
    const double b13_3 = Js5_15*ww1_zz;

    /* Backward recursion: articulated inertias and wrenches, joint 13 (sensor_head) [50]-[56]. */
    const double Gamma13 = -25000000.0*q13;
    const double Gb13 = Gamma13 + b13_3;
    const double qdf13 = 1.6666666666666667*Gb13;

    /* Backward recursion: articulated inertias and wrenches, joint 11 (ram) [50]-[56]. */
    const double Gamma11 = -250000000.0*q11;
    const double Gb11 = Gamma11 + b11_3;
    const double al11_1 = 95.0*g11_1;
    const double al11_5 = -14.25*g11_1;
    const double qdf11 = 0.010526315789473684*Gb11;

    /* Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [50]-[56]. */
    const double Gamma10 = -120000000.0*q10;
    const double Js10_15a = 95.0*q11;
    const double Js10_15 = Js10_15a - 14.25;
    const double Js10_55 = q11*(Js10_15a - 28.5) + 9.2375;
    const double Gb10 = Gamma10 - Gamma11;
    const double qdf10 = 0.125*Gb10;
    const double bs10_5 = -(al11_5 + q11*al11_1);
    const double al10_1 = al11_1 + 103.0*g10_1;
    const double al10_5 = Js10_15*g10_1 - bs10_5;

    /* Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [50]-[56]. */
    const double Js9_15 = Js10_15 + 103.0*q10;
    const double Js9_55 = Js10_55 + q10*(Js10_15 + Js9_15);
    const double bs9_5 = -(al10_5 + q10*al10_1);
    const double al9_1 = al10_1 + 103.0*g9_1;
    const double al9_5 = Js9_15*g9_1 - bs9_5;

    /* Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [50]-[56]. */
    const double Gamma8 = -500000000.0*q8;
    const double Js8_15a = Js9_15 + 103.0*q9;
    const double Js8_15 = Js8_15a + 63.0;
    const double K8_44 = Js9_55 + q9*(Js9_15 + Js8_15a) + 34.9;
    const double bs8_5 = -(al9_5 + q9*al9_1);
    const double bs8_1 = b8_1 - al9_1;
    const double bs8_3 = b8_3 - Gamma10;
    const double Gb8 = Gamma8 + bs8_3;
    const double qdf8 = 0.004761904761904762*Gb8;
    const double al8_2 = 313.0*g8_2 - bs8_1;
    const double al8_4 = bs8_5 + 0.02*Gb8 - Js8_15*g8_2;

    /* Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [50]-[56]. */
    const double Gamma7 = -350000000.0*q7;
    const double Js7_16 = Js8_15 + 313.0*q8;
    const double Js7_44 = K8_44 + q8*(Js8_15 + Js7_16);
    const double UH7_4 = -0.003194888178913738*Js7_16;
    const double K7_55 = Js7_44 + Js7_16*UH7_4;
    const double bs7_4 = q8*al8_2 - al8_4;
    const double Gb7 = Gamma7 - al8_2;
    const double qdf7 = 0.003194888178913738*Gb7;
    const double al7_5 = -(bs7_4 + Js7_16*qdf7);

    /* Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [50]-[56]. */
    const double Gamma6 = -11000000.0*q6;
    const double al6_1 = cos_q6*Gamma8 + sin_q6*Gamma7;
    const double al6_2 = sin_q6*Gamma8 - cos_q6*Gamma7;
    const double bs6_6 = -(q7*Gamma8 + al7_5);
    const double Gb6 = Gamma6 + bs6_6;
    const double qdf6 = Gb6/K7_55;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [50]-[56]. */
    const double Js5_55 = q13*Js5_15 + 3.001;
    const double bs5_3 = al6_2 - Gamma13;
    const double bs5_1 = b13_1 - al6_1;
    const double bs5_5 = D13*Gamma13 + q13*b13_1 - Gamma6;
    const double al5_1 = 45.6*g5_1 - bs5_1;
    const double al5_5 = Js5_15*g5_1 - bs5_5;
    const double al5_3 = (qdd5 + g5_3)*45.0 - bs5_3;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [50]-[56]. */
    const double Gamma4 = -600000000.0*q4;
    const double Js4_15 = Js5_15 + 45.6*q5;
    const double Js4_55 = Js5_55 + q5*(Js5_15 + Js4_15) + 12.0;
    const double bs4_5 = -(al5_5 + q5*al5_1);
    const double al4_1 = al5_1 + 135.6*g4_1;
    const double al4_5 = Js4_15*g4_1 - bs4_5;
    const double Gb4 = Gamma4 - al5_3;
    const double qdf4 = 0.007407407407407408*Gb4;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [50]-[56]. */
    const double Gamma3 = -100000000.0*q3;
    const double Js3_15 = Js4_15 + 135.6*q4;
    const double K3_44 = Js4_55 + q4*(Js4_15 + Js3_15) + 1100.0;
    const double Gb3 = Gamma3 - Gamma4;
    const double qdf3 = 0.0004*Gb3;
    const double bs3_5 = D4*Gamma4 - (al4_5 + q4*al4_1);
    const double bs3_1 = b3_1 - al4_1;
    const double al3_2 = bs3_1 + 2635.6*g3_2;
    const double al3_4 = -(Js3_15*g3_2 + bs3_5 - 0.2*Gb3);

    /* Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [50]-[56]. */
    const double Gamma2 = -150000000.0*q2;
    const double Js2_34 = Js3_15 + 2635.6*q3;
    const double Js2_44 = K3_44 + q3*(Js3_15 + Js2_34);
    const double UH2_4 = 0.0003794202458643193*Js2_34;
    const double K2_55 = Js2_44 - Js2_34*UH2_4;
    const double bs2_4 = q3*al3_2 - al3_4;
    const double Gb2 = Gamma2 + al3_2;
    const double qdf2 = 0.0003794202458643193*Gb2;
    const double al2_5 = bs2_4 - Js2_34*qdf2;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [50]-[56]. */
    const double Gamma1 = -40000000.0*q1;
    const double bs1_6 = q2*Gamma3 + al2_5;
    const double Gb1 = Gamma1 + bs1_6;
    const double qdf1 = Gb1/K2_55;

    /* Forward recursion: accelerations and torques, joint 2 (bed_y) [57]-[61]. */
    const double vd2_y = g2_1 - q2*qdf1;
    const double vd2_z = qdf2 - UH2_4*qdf1;
    const double qdd2 = vd2_z - g2_3;

    /* Forward recursion: accelerations and torques, joint 3 (bed_x) [57]-[61]. */
    const double vd3_x = vd2_z + q3*qdf1 - g3_2;
    const double vd3_z = qdf3 - 0.2*qdf1;
    const double qdd3 = vd3_z - (g3_3 + vd2_y);

    /* Forward recursion: accelerations and torques, joint 4 (motor_secondary) [57]-[61]. */
    const double vd4_x = g4_1 + vd3_x + q4*qdf1;
    const double qdd4 = D4*qdf1 - vd3_z - g4_3 + qdf4;

    /* Forward recursion: accelerations and torques, joint 5 (motor_x) [57]-[61]. */
    const double vd5_x = g5_1 + vd4_x + q5*qdf1;
    const double f5_3 = al5_3 + 0.3333333333333333*Gb4;
    const double vd5_z = qdd5 + g5_3 + qdf4;

    /* Forward recursion: accelerations and torques, joint 6 (cart_yaw) [57]-[61]. */
    const double qdd6 = qdf6 - qdf1;
    const double vd6_x = cos_q6*vd5_x - sin_q6*vd5_z;
    const double vd6_y = -(sin_q6*vd5_x + cos_q6*vd5_z);

    /* Forward recursion: accelerations and torques, joint 7 (cart_x) [57]-[61]. */
    const double vd7_z = qdf7 - UH7_4*qdf6;
    const double vd7_y = -(g7_1 + q7*qdf6 + vd6_x);
    const double qdd7 = vd7_z + vd6_y - g7_3;

    /* Forward recursion: accelerations and torques, joint 8 (cart_y) [57]-[61]. */
    const double vd8_z = qdf8 - 0.02*qdf6;
    const double qdd8 = vd8_z + vd7_y - g8_3;

    /* Forward recursion: accelerations and torques, joint 9 (motor_y) [57]-[61]. */
    const double Gamma9 = Gamma10 + 180.0*qdd9;
    const double vd9_z = qdd9 + g9_3 + vd8_z;

    /* Forward recursion: accelerations and torques, joint 10 (y_chain_1) [57]-[61]. */
    const double qdd10 = qdf10 - (g10_3 + vd9_z);

    /* Forward recursion: accelerations and torques, joint 11 (ram) [57]-[61]. */
    const double qdd11 = qdf11 - (qdf10 + g11_3);

    /* Forward recursion: accelerations and torques, joint 13 (sensor_head) [57]-[61]. */
    const double qdd13 = qdf13 - (vd5_z - D13*qdf1);

    /* Results. */
    tau[0*lanes] = f5_3;
    tau[1*lanes] = Gamma9;
    qdd[0*lanes] = qdf1;
    qdd[1*lanes] = qdd2;
    qdd[2*lanes] = qdd3;
    qdd[3*lanes] = qdd4;
    qdd[4*lanes] = qdd5;
    qdd[5*lanes] = qdd6;
    qdd[6*lanes] = qdd7;
    qdd[7*lanes] = qdd8;
    qdd[8*lanes] = qdd9;
    qdd[9*lanes] = qdd10;
    qdd[10*lanes] = qdd11;
    qdd[11*lanes] = qdd13;
}

void two_axis_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double angle[2];
    double sine[2];
    double cosine[2];
    two_axis_inverse_dynamics_angles(1, 1, q, angle);
    circles(2, angle, sine, cosine);
    two_axis_inverse_dynamics_state(1, 1, q, qd, qdd_motor, p, sine, cosine, tau, qdd);
}

APART void two_axis_inverse_dynamics_state_lanes(size_t stride, const double *restrict q, const double *restrict qd, const double *restrict qdd_motor, const double *restrict p, const double *restrict sine, const double *restrict cosine, double *restrict tau, double *restrict qdd)
{
    for (size_t l = 0; l < LANES; l++)
        two_axis_inverse_dynamics_state(stride, LANES, q + l, qd + l, qdd_motor + l, p, sine + l, cosine + l, tau + l, qdd + l);
}

static void two_axis_inverse_dynamics_lanes(size_t stride, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double angle[2*LANES] ALIGNED;
    double sine[2*LANES] ALIGNED;
    double cosine[2*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        two_axis_inverse_dynamics_angles(stride, LANES, q + l, angle + l);
    circles(2*LANES, angle, sine, cosine);
    two_axis_inverse_dynamics_state_lanes(stride, q, qd, qdd_motor, p, sine, cosine, tau, qdd);
}

void two_axis_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double found_tau[2*LANES] ALIGNED;
    double found_qdd[12*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        two_axis_inverse_dynamics_lanes(states, q + first, qd + first, qdd_motor + first, p, found_tau, found_qdd);
        store(2, states, LANES, found_tau, tau + first);
        store(12, states, LANES, found_qdd, qdd + first);
    }
    if (count) {
        double last_q[12*LANES] ALIGNED;
        load(12, states, count, q + first, last_q);
        double last_qd[12*LANES] ALIGNED;
        load(12, states, count, qd + first, last_qd);
        double last_qdd_motor[2*LANES] ALIGNED;
        load(2, states, count, qdd_motor + first, last_qdd_motor);
        two_axis_inverse_dynamics_lanes(LANES, last_q, last_qd, last_qdd_motor, p, found_tau, found_qdd);
        store(2, states, count, found_tau, tau + first);
        store(12, states, count, found_qdd, qdd + first);
    }
}

INLINE void two_axis_inertia_matrix_constants(const double *restrict p, double *restrict c)
{
    const double D4 = p[TWO_AXIS_P_D4];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Composite inertias and inertia matrix, joint 13 (sensor_head) [8], [13]. */
    const double A1_13a = 0.6*D13;

    /* Composite inertias and inertia matrix, joint 5 (motor_x) [8], [13]. */
    const double J5_cyyb = D13*A1_13a;

    /* Composite inertias and inertia matrix, joint 4 (motor_secondary) [8], [13]. */
    const double A1_4a = 448.6*D4;

    c[0] = A1_13a;
    c[1] = J5_cyyb;
    c[2] = A1_4a;
}

void two_axis_inertia_matrix_prepare(const double *p, double *c)
{
    two_axis_inertia_matrix_constants(p, c);
}

INLINE void two_axis_inertia_matrix_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double q6 = q[5*stride];
    angle[0*lanes] = q6;
}

INLINE void two_axis_inertia_matrix_state(size_t stride, size_t lanes, const double *restrict q, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict A)
{
    (void)stride, (void)lanes;
    const double q2 = q[1*stride];
    const double q3 = q[2*stride];
    const double q4 = q[3*stride];
    const double q5 = q[4*stride];
    const double q7 = q[6*stride];
    const double q8 = q[7*stride];
    const double q9 = q[8*stride];
    const double q10 = q[9*stride];
    const double q11 = q[10*stride];
    const double q13 = q[11*stride];
    const double D4 = p[TWO_AXIS_P_D4];
    const double A1_13a = c[0];
    const double J5_cyyb = c[1];
    const double A1_4a = c[2];

    /* Geometry, joint 6 (cart_yaw) [1]. */
    const double sin_q6 = sine[0*lanes];
    const double cos_q6 = cosine[0*lanes];

    /* Composite inertias and inertia matrix, joint 13 (sensor_head) [8], [13]. */
    const double A1_13b = D4 + q2;
    const double A1_13 = -(A1_13a + 0.6*A1_13b);

    /* Composite inertias and inertia matrix, joint 11 (ram) [8], [13]. */
    const double A6_11 = 95.0*q7;
    const double A2_11 = 95.0*cos_q6;
    const double A3_11 = -95.0*sin_q6;
    const double A1_11a = q3 + q4 + q5;
    const double A1_11 = A6_11 - D4*A3_11 - q2*A3_11 + A2_11*A1_11a;

    /* Composite inertias and inertia matrix, joint 10 (y_chain_1) [8], [13]. */
    const double MS10_c_za = 95.0*q11;
    const double MS10_c_z = MS10_c_za - 14.25;
    const double J10_cyy = q11*(MS10_c_za - 28.5) + 9.2375;
    const double A6_10 = 103.0*q7;
    const double A2_10 = 103.0*cos_q6;
    const double A3_10 = -103.0*sin_q6;
    const double A1_10 = A6_10 - D4*A3_10 - q2*A3_10 + A2_10*A1_11a;

    /* Composite inertias and inertia matrix, joint 9 (motor_y) [8], [13]. */
    const double MS9_c_z = MS10_c_z + 103.0*q10;
    const double J9_cyy = J10_cyy + q10*(MS10_c_z + MS9_c_z);

    /* Composite inertias and inertia matrix, joint 8 (cart_y) [8], [13]. */
    const double J8_cyya = MS9_c_z + 103.0*q9;
    const double J8_cyy = J9_cyy + q9*(MS9_c_z + J8_cyya) + 34.984;
    const double MS8_c_z = J8_cyya + 63.0;
    const double A6_8a = 313.0*q7;
    const double A6_8 = A6_8a + 4.2;
    const double A2_8 = 313.0*cos_q6;
    const double A3_8 = -313.0*sin_q6;
    const double A1_8 = A6_8 - D4*A3_8 - q2*A3_8 + A2_8*A1_11a;

    /* Composite inertias and inertia matrix, joint 7 (cart_x) [8], [13]. */
    const double MS7_c_y = -(MS8_c_z + 313.0*q8);
    const double J7_cxx = J8_cyy + q8*(MS8_c_z - MS7_c_y);
    const double A1_7 = -(q2*A2_8 + D4*A2_8 - MS7_c_y + A3_8*A1_11a);

    /* Composite inertias and inertia matrix, joint 6 (cart_yaw) [8], [13]. */
    const double J6_czz = J7_cxx + q7*(A6_8a + 8.4);
    const double A3_6 = cos_q6*MS7_c_y - sin_q6*A6_8;
    const double A2_6 = sin_q6*MS7_c_y + cos_q6*A6_8;
    const double A1_6 = J6_czz - D4*A3_6 - q2*A3_6 + A2_6*A1_11a;

    /* Composite inertias and inertia matrix, joint 5 (motor_x) [8], [13]. */
    const double J5_cyya = 0.6*q13;
    const double J5_cyy = q13*J5_cyya + 0.001 + J5_cyyb + 3.0 + J6_czz;
    const double MS5_c_x = A1_13a - A3_6;
    const double MS5_c_z = J5_cyya + A2_6;
    const double A1_5 = -(MS5_c_x + 358.6*A1_13b);

    /* Composite inertias and inertia matrix, joint 4 (motor_secondary) [8], [13]. */
    const double MS4_c_z = MS5_c_z + 358.6*q5;
    const double J4_cyy = J5_cyy + q5*(MS5_c_z + MS4_c_z) + 12.0;
    const double A1_4b = MS5_c_x + A1_4a;
    const double A1_4 = -(A1_4b + 448.6*q2);

    /* Composite inertias and inertia matrix, joint 3 (bed_x) [8], [13]. */
    const double MS3_c_z = MS4_c_z + 448.6*q4;
    const double J3_cyy = J4_cyy + q4*(MS4_c_z + MS3_c_z) + D4*(MS5_c_x + A1_4b) + 1200.0;
    const double MS3_c_x = A1_4b - 500.0;
    const double A1_3 = -(MS3_c_x + 2948.6*q2);

    /* Composite inertias and inertia matrix, joint 2 (bed_y) [8], [13]. */
    const double MS2_c_y = MS3_c_z + 2948.6*q3;
    const double J2_cxx = J3_cyy + q3*(MS3_c_z + MS2_c_y);

    /* Composite inertias and inertia matrix, joint 1 (bed_yaw) [8], [13]. */
    const double J1_czz = J2_cxx + q2*(MS3_c_x - A1_3);

    /* Results. */
    A[0*lanes] = J1_czz;
    A[1*lanes] = MS2_c_y;
    A[2*lanes] = A1_3;
    A[3*lanes] = A1_4;
    A[4*lanes] = A1_5;
    A[5*lanes] = A1_6;
    A[6*lanes] = A1_7;
    A[7*lanes] = A1_8;
    A[8*lanes] = A1_10;
    A[9*lanes] = A1_10;
    A[10*lanes] = A1_11;
    A[11*lanes] = A1_13;
    A[12*lanes] = MS2_c_y;
    A[13*lanes] = 2948.6;
    A[14*lanes] = 0.0;
    A[15*lanes] = 0.0;
    A[16*lanes] = 0.0;
    A[17*lanes] = A2_6;
    A[18*lanes] = -A3_8;
    A[19*lanes] = A2_8;
    A[20*lanes] = A2_10;
    A[21*lanes] = A2_10;
    A[22*lanes] = A2_11;
    A[23*lanes] = 0.0;
    A[24*lanes] = A1_3;
    A[25*lanes] = 0.0;
    A[26*lanes] = 2948.6;
    A[27*lanes] = 448.6;
    A[28*lanes] = 358.6;
    A[29*lanes] = A3_6;
    A[30*lanes] = A2_8;
    A[31*lanes] = A3_8;
    A[32*lanes] = A3_10;
    A[33*lanes] = A3_10;
    A[34*lanes] = A3_11;
    A[35*lanes] = 0.6;
    A[36*lanes] = A1_4;
    A[37*lanes] = 0.0;
    A[38*lanes] = 448.6;
    A[39*lanes] = 448.6;
    A[40*lanes] = 358.6;
    A[41*lanes] = A3_6;
    A[42*lanes] = A2_8;
    A[43*lanes] = A3_8;
    A[44*lanes] = A3_10;
    A[45*lanes] = A3_10;
    A[46*lanes] = A3_11;
    A[47*lanes] = 0.6;
    A[48*lanes] = A1_5;
    A[49*lanes] = 0.0;
    A[50*lanes] = 358.6;
    A[51*lanes] = 358.6;
    A[52*lanes] = 358.6;
    A[53*lanes] = A3_6;
    A[54*lanes] = A2_8;
    A[55*lanes] = A3_8;
    A[56*lanes] = A3_10;
    A[57*lanes] = A3_10;
    A[58*lanes] = A3_11;
    A[59*lanes] = 0.6;
    A[60*lanes] = A1_6;
    A[61*lanes] = A2_6;
    A[62*lanes] = A3_6;
    A[63*lanes] = A3_6;
    A[64*lanes] = A3_6;
    A[65*lanes] = J6_czz;
    A[66*lanes] = MS7_c_y;
    A[67*lanes] = A6_8;
    A[68*lanes] = A6_10;
    A[69*lanes] = A6_10;
    A[70*lanes] = A6_11;
    A[71*lanes] = 0.0;
    A[72*lanes] = A1_7;
    A[73*lanes] = -A3_8;
    A[74*lanes] = A2_8;
    A[75*lanes] = A2_8;
    A[76*lanes] = A2_8;
    A[77*lanes] = MS7_c_y;
    A[78*lanes] = 313.0;
    A[79*lanes] = 0.0;
    A[80*lanes] = 0.0;
    A[81*lanes] = 0.0;
    A[82*lanes] = 0.0;
    A[83*lanes] = 0.0;
    A[84*lanes] = A1_8;
    A[85*lanes] = A2_8;
    A[86*lanes] = A3_8;
    A[87*lanes] = A3_8;
    A[88*lanes] = A3_8;
    A[89*lanes] = A6_8;
    A[90*lanes] = 0.0;
    A[91*lanes] = 313.0;
    A[92*lanes] = 103.0;
    A[93*lanes] = 103.0;
    A[94*lanes] = 95.0;
    A[95*lanes] = 0.0;
    A[96*lanes] = A1_10;
    A[97*lanes] = A2_10;
    A[98*lanes] = A3_10;
    A[99*lanes] = A3_10;
    A[100*lanes] = A3_10;
    A[101*lanes] = A6_10;
    A[102*lanes] = 0.0;
    A[103*lanes] = 103.0;
    A[104*lanes] = 283.0;
    A[105*lanes] = 103.0;
    A[106*lanes] = 95.0;
    A[107*lanes] = 0.0;
    A[108*lanes] = A1_10;
    A[109*lanes] = A2_10;
    A[110*lanes] = A3_10;
    A[111*lanes] = A3_10;
    A[112*lanes] = A3_10;
    A[113*lanes] = A6_10;
    A[114*lanes] = 0.0;
    A[115*lanes] = 103.0;
    A[116*lanes] = 103.0;
    A[117*lanes] = 103.0;
    A[118*lanes] = 95.0;
    A[119*lanes] = 0.0;
    A[120*lanes] = A1_11;
    A[121*lanes] = A2_11;
    A[122*lanes] = A3_11;
    A[123*lanes] = A3_11;
    A[124*lanes] = A3_11;
    A[125*lanes] = A6_11;
    A[126*lanes] = 0.0;
    A[127*lanes] = 95.0;
    A[128*lanes] = 95.0;
    A[129*lanes] = 95.0;
    A[130*lanes] = 95.0;
    A[131*lanes] = 0.0;
    A[132*lanes] = A1_13;
    A[133*lanes] = 0.0;
    A[134*lanes] = 0.6;
    A[135*lanes] = 0.6;
    A[136*lanes] = 0.6;
    A[137*lanes] = 0.0;
    A[138*lanes] = 0.0;
    A[139*lanes] = 0.0;
    A[140*lanes] = 0.0;
    A[141*lanes] = 0.0;
    A[142*lanes] = 0.0;
    A[143*lanes] = 0.6;
}

void two_axis_inertia_matrix_prepared(const double *q, const double *p, const double *c, double *A)
{
    double angle[1];
    double sine[1];
    double cosine[1];
    two_axis_inertia_matrix_angles(1, 1, q, angle);
    circles(1, angle, sine, cosine);
    two_axis_inertia_matrix_state(1, 1, q, p, c, sine, cosine, A);
}

void two_axis_inertia_matrix(const double *q, const double *p, double *A)
{
    double c[TWO_AXIS_INERTIA_MATRIX_CONSTANTS];
    two_axis_inertia_matrix_prepare(p, c);
    two_axis_inertia_matrix_prepared(q, p, c, A);
}

APART void two_axis_inertia_matrix_state_lanes(size_t stride, const double *restrict q, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict A)
{
    for (size_t l = 0; l < LANES; l++)
        two_axis_inertia_matrix_state(stride, LANES, q + l, p, c, sine + l, cosine + l, A + l);
}

static void two_axis_inertia_matrix_lanes(size_t stride, const double *q, const double *p, const double *c, double *A)
{
    double angle[1*LANES] ALIGNED;
    double sine[1*LANES] ALIGNED;
    double cosine[1*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        two_axis_inertia_matrix_angles(stride, LANES, q + l, angle + l);
    circles(1*LANES, angle, sine, cosine);
    two_axis_inertia_matrix_state_lanes(stride, q, p, c, sine, cosine, A);
}

void two_axis_inertia_matrix_batch(size_t states, const double *q, const double *p, double *A)
{
    double c[TWO_AXIS_INERTIA_MATRIX_CONSTANTS];
    two_axis_inertia_matrix_prepare(p, c);
    double found_A[144*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        two_axis_inertia_matrix_lanes(states, q + first, p, c, found_A);
        store(144, states, LANES, found_A, A + first);
    }
    if (count) {
        double last_q[12*LANES] ALIGNED;
        load(12, states, count, q + first, last_q);
        two_axis_inertia_matrix_lanes(LANES, last_q, p, c, found_A);
        store(144, states, count, found_A, A + first);
    }
}

INLINE void two_axis_bias_forces_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double q1 = q[0*stride];
    const double q6 = q[5*stride];
    angle[0*lanes] = q1;
    angle[1*lanes] = q6;
}

INLINE void two_axis_bias_forces_state(size_t stride, size_t lanes, const double *restrict q, const double *restrict qd, const double *restrict p, const double *restrict sine, const double *restrict cosine, double *restrict H)
{
    (void)stride, (void)lanes;
    const double q2 = q[1*stride];
    const double q3 = q[2*stride];
    const double q4 = q[3*stride];
    const double q5 = q[4*stride];
    const double q7 = q[6*stride];
    const double q8 = q[7*stride];
    const double q9 = q[8*stride];
    const double q10 = q[9*stride];
    const double q11 = q[10*stride];
    const double q13 = q[11*stride];
    const double qd1 = qd[0*stride];
    const double qd2 = qd[1*stride];
    const double qd3 = qd[2*stride];
    const double qd4 = qd[3*stride];
    const double qd5 = qd[4*stride];
    const double qd6 = qd[5*stride];
    const double qd7 = qd[6*stride];
    const double qd8 = qd[7*stride];
    const double qd9 = qd[8*stride];
    const double qd10 = qd[9*stride];
    const double qd11 = qd[10*stride];
    const double qd13 = qd[11*stride];
    const double D4 = p[TWO_AXIS_P_D4];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Forward recursion: velocities, joint 1 (bed_yaw) [1], [3], [7], [14]. */
    const double sin_q1 = sine[0*lanes];
    const double cos_q1 = cosine[0*lanes];
    const double ww1_zz = qd1*qd1;
    const double vd1_x = 9.81*sin_q1;
    const double vd1_y = 9.81*cos_q1;

    /* Forward recursion: velocities, joint 2 (bed_y) [1], [3], [7], [14]. */
    const double vd2_z = vd1_y - q2*ww1_zz;
    const double vd2_ya = 2.0*qd1;
    const double vd2_y = vd1_x - qd2*vd2_ya;

    /* Forward recursion: velocities, joint 3 (bed_x) [1], [3], [7], [14]. */
    const double vd3_z = vd2_y - q3*ww1_zz;
    const double vd3_x = vd2_z + qd3*vd2_ya;

    /* Forward recursion: velocities, joint 4 (motor_secondary) [1], [3], [7], [14]. */
    const double vd4_z = vd3_z - q4*ww1_zz;
    const double vd4_x = qd4*vd2_ya - (D4*ww1_zz - vd3_x);

    /* Forward recursion: velocities, joint 5 (motor_x) [1], [3], [7], [14]. */
    const double vd5_z = vd4_z - q5*ww1_zz;
    const double vd5_x = qd5*vd2_ya + vd4_x;

    /* Forward recursion: velocities, joint 6 (cart_yaw) [1], [3], [7], [14]. */
    const double sin_q6 = sine[1*lanes];
    const double cos_q6 = cosine[1*lanes];
    const double w6_z = qd1 + qd6;
    const double ww6_zz = w6_z*w6_z;
    const double vd6_x = cos_q6*vd5_x - sin_q6*vd5_z;
    const double vd6_y = -(sin_q6*vd5_x + cos_q6*vd5_z);

    /* Forward recursion: velocities, joint 7 (cart_x) [1], [3], [7], [14]. */
    const double vd7_ya = 2.0*w6_z;
    const double vd7_z = -(q7*ww6_zz + vd6_y);
    const double vd7_y = -(qd7*vd7_ya + vd6_x);

    /* Forward recursion: velocities, joint 8 (cart_y) [1], [3], [7], [14]. */
    const double vd8_z = -(q8*ww6_zz + vd7_y);
    const double vd8_x = vd7_z - qd8*vd7_ya;

    /* Forward recursion: velocities, joint 9 (motor_y) [1], [3], [7], [14]. */
    const double vd9_z = vd8_z - q9*ww6_zz;
    const double vd9_x = vd8_x - qd9*vd7_ya;

    /* Forward recursion: velocities, joint 10 (y_chain_1) [1], [3], [7], [14]. */
    const double vd10_z = vd9_z - q10*ww6_zz;
    const double vd10_x = vd9_x - qd10*vd7_ya;

    /* Forward recursion: velocities, joint 11 (ram) [1], [3], [7], [14]. */
    const double vd11_z = vd10_z - q11*ww6_zz;
    const double vd11_x = vd10_x - qd11*vd7_ya;

    /* Forward recursion: velocities, joint 13 (sensor_head) [1], [3], [7], [14]. */
    const double vd13_z = vd5_z - q13*ww1_zz;
    const double vd13_x = qd13*vd2_ya - (D13*ww1_zz - vd5_x);

    /* Backward recursion: articulated inertias and wrenches, joint 13 (sensor_head) [15]. */
    const double f13_1 = 0.6*vd13_x;
    const double f13_3 = 0.6*vd13_z;

    /* Backward recursion: articulated inertias and wrenches, joint 11 (ram) [15]. */
    const double f11_1 = 95.0*vd11_x;
    const double f11_3 = 14.25*ww6_zz + 95.0*vd11_z;
    const double f11_5 = -14.25*vd11_x;

    /* Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [15]. */
    const double f10_5 = f11_5 + q11*f11_1;
    const double f10_1 = 8.0*vd10_x + f11_1;
    const double f10_3 = 8.0*vd10_z + f11_3;

    /* Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [15]. */
    const double f9_5 = f10_5 + q10*f10_1;

    /* Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [15]. */
    const double f8_1 = f10_1 - (4.2*ww6_zz - 210.0*vd8_x);
    const double f8_3 = f10_3 - (63.0*ww6_zz - 210.0*vd8_z);
    const double f8_5 = f9_5 + q9*f10_1 - (4.2*vd8_z - 63.0*vd8_x);

    /* Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [15]. */
    const double f7_4 = -(f8_5 + q8*f8_1);

    /* Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [15]. */
    const double f6_6 = f7_4 + q7*f8_3;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [15]. */
    const double f5_1 = 45.0*vd5_x + f13_1 + cos_q6*f8_3 + sin_q6*f8_1;
    const double f5_3 = 45.0*vd5_z + f13_3 + cos_q6*f8_1 - sin_q6*f8_3;
    const double f5_5 = q13*f13_1 - D13*f13_3 + f6_6;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [15]. */
    const double f4_5 = f5_5 + q5*f5_1;
    const double f4_1 = 90.0*vd4_x + f5_1;
    const double f4_3 = 90.0*vd4_z + f5_3;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [15]. */
    const double f3_1 = 500.0*ww1_zz + 2500.0*vd3_x + f4_1;
    const double f3_3 = 2500.0*vd3_z + f4_3;
    const double f3_5 = 500.0*vd3_z + f4_5 + q4*f4_1 - D4*f4_3;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [15]. */
    const double f2_4 = f3_5 + q3*f3_1;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [15]. */
    const double f1_6 = f2_4 - q2*f3_3;

    /* Results. */
    H[0*lanes] = f1_6;
    H[1*lanes] = f3_1;
    H[2*lanes] = f3_3;
    H[3*lanes] = f4_3;
    H[4*lanes] = f5_3;
    H[5*lanes] = f6_6;
    H[6*lanes] = f8_1;
    H[7*lanes] = f8_3;
    H[8*lanes] = f10_3;
    H[9*lanes] = f10_3;
    H[10*lanes] = f11_3;
    H[11*lanes] = f13_3;
}

void two_axis_bias_forces(const double *q, const double *qd, const double *p, double *H)
{
    double angle[2];
    double sine[2];
    double cosine[2];
    two_axis_bias_forces_angles(1, 1, q, angle);
    circles(2, angle, sine, cosine);
    two_axis_bias_forces_state(1, 1, q, qd, p, sine, cosine, H);
}

APART void two_axis_bias_forces_state_lanes(size_t stride, const double *restrict q, const double *restrict qd, const double *restrict p, const double *restrict sine, const double *restrict cosine, double *restrict H)
{
    for (size_t l = 0; l < LANES; l++)
        two_axis_bias_forces_state(stride, LANES, q + l, qd + l, p, sine + l, cosine + l, H + l);
}

static void two_axis_bias_forces_lanes(size_t stride, const double *q, const double *qd, const double *p, double *H)
{
    double angle[2*LANES] ALIGNED;
    double sine[2*LANES] ALIGNED;
    double cosine[2*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        two_axis_bias_forces_angles(stride, LANES, q + l, angle + l);
    circles(2*LANES, angle, sine, cosine);
    two_axis_bias_forces_state_lanes(stride, q, qd, p, sine, cosine, H);
}

void two_axis_bias_forces_batch(size_t states, const double *q, const double *qd, const double *p, double *H)
{
    double found_H[12*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        two_axis_bias_forces_lanes(states, q + first, qd + first, p, found_H);
        store(12, states, LANES, found_H, H + first);
    }
    if (count) {
        double last_q[12*LANES] ALIGNED;
        load(12, states, count, q + first, last_q);
        double last_qd[12*LANES] ALIGNED;
        load(12, states, count, qd + first, last_qd);
        two_axis_bias_forces_lanes(LANES, last_q, last_qd, p, found_H);
        store(12, states, count, found_H, H + first);
    }
}

INLINE void two_axis_geometric_model_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double q1 = q[0*stride];
    const double q6 = q[5*stride];
    angle[0*lanes] = q1;
    angle[1*lanes] = q6;
}

INLINE void two_axis_geometric_model_state(size_t stride, size_t lanes, const double *restrict q, const double *restrict p, const double *restrict sine, const double *restrict cosine, double *restrict T)
{
    (void)stride, (void)lanes;
    const double q2 = q[1*stride];
    const double q3 = q[2*stride];
    const double q4 = q[3*stride];
    const double q5 = q[4*stride];
    const double q7 = q[6*stride];
    const double q8 = q[7*stride];
    const double q9 = q[8*stride];
    const double q10 = q[9*stride];
    const double q11 = q[10*stride];
    const double q13 = q[11*stride];
    const double D4 = p[TWO_AXIS_P_D4];
    const double D12 = p[TWO_AXIS_P_D12];
    const double L12 = p[TWO_AXIS_P_L12];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Geometry, joint 1 (bed_yaw) [1], [2]. */
    const double sin_q1 = sine[0*lanes];
    const double cos_q1 = cosine[0*lanes];

    /* Geometry, joint 2 (bed_y) [1], [2]. */
    const double P2_x = -q2*sin_q1;
    const double P2_y = q2*cos_q1;

    /* Geometry, joint 3 (bed_x) [1], [2]. */
    const double P3_x = P2_x + q3*cos_q1;
    const double P3_y = P2_y + q3*sin_q1;

    /* Geometry, joint 4 (motor_secondary) [1], [2]. */
    const double P4_x = q4*cos_q1 - (D4*sin_q1 - P3_x);
    const double P4_y = P3_y + D4*cos_q1 + q4*sin_q1;

    /* Geometry, joint 5 (motor_x) [1], [2]. */
    const double P5_x = P4_x + q5*cos_q1;
    const double P5_y = P4_y + q5*sin_q1;

    /* Geometry, joint 6 (cart_yaw) [1], [2]. */
    const double sin_q6 = sine[1*lanes];
    const double cos_q6 = cosine[1*lanes];
    const double A6_11 = -(sin_q1*cos_q6 + cos_q1*sin_q6);
    const double A6_12 = sin_q1*sin_q6 - cos_q1*cos_q6;

    /* Geometry, joint 7 (cart_x) [1], [2]. */
    const double P7_x = P5_x - q7*A6_12;
    const double P7_y = P5_y - q7*A6_11;

    /* Geometry, joint 8 (cart_y) [1], [2]. */
    const double P8_x = P7_x + q8*A6_11;
    const double P8_y = P7_y - q8*A6_12;

    /* Geometry, joint 9 (motor_y) [1], [2]. */
    const double P9_x = P8_x + q9*A6_11;
    const double P9_y = P8_y - q9*A6_12;

    /* Geometry, joint 10 (y_chain_1) [1], [2]. */
    const double P10_x = P9_x + q10*A6_11;
    const double P10_y = P9_y - q10*A6_12;

    /* Geometry, joint 11 (ram) [1], [2]. */
    const double P11_x = P10_x + q11*A6_11;
    const double P11_y = P10_y - q11*A6_12;

    /* Geometry, joint 12 (tool) [1], [2]. */
    const double P12_x = L12*A6_11 - (D12*A6_12 - P11_x);
    const double P12_y = P11_y - D12*A6_11 - L12*A6_12;

    /* Geometry, joint 13 (sensor_head) [1], [2]. */
    const double P13_x = q13*cos_q1 - (D13*sin_q1 - P5_x);
    const double P13_y = P5_y + D13*cos_q1 + q13*sin_q1;

    /* Results. */
    T[0*lanes] = cos_q1;
    T[1*lanes] = -sin_q1;
    T[2*lanes] = 0.0;
    T[3*lanes] = 0.0;
    T[4*lanes] = sin_q1;
    T[5*lanes] = cos_q1;
    T[6*lanes] = 0.0;
    T[7*lanes] = 0.0;
    T[8*lanes] = 0.0;
    T[9*lanes] = 0.0;
    T[10*lanes] = 1.0;
    T[11*lanes] = 0.0;
    T[12*lanes] = 0.0;
    T[13*lanes] = 0.0;
    T[14*lanes] = 0.0;
    T[15*lanes] = 1.0;
    T[16*lanes] = 0.0;
    T[17*lanes] = cos_q1;
    T[18*lanes] = -sin_q1;
    T[19*lanes] = P2_x;
    T[20*lanes] = 0.0;
    T[21*lanes] = sin_q1;
    T[22*lanes] = cos_q1;
    T[23*lanes] = P2_y;
    T[24*lanes] = 1.0;
    T[25*lanes] = 0.0;
    T[26*lanes] = 0.0;
    T[27*lanes] = 0.0;
    T[28*lanes] = 0.0;
    T[29*lanes] = 0.0;
    T[30*lanes] = 0.0;
    T[31*lanes] = 1.0;
    T[32*lanes] = -sin_q1;
    T[33*lanes] = 0.0;
    T[34*lanes] = cos_q1;
    T[35*lanes] = P3_x;
    T[36*lanes] = cos_q1;
    T[37*lanes] = 0.0;
    T[38*lanes] = sin_q1;
    T[39*lanes] = P3_y;
    T[40*lanes] = 0.0;
    T[41*lanes] = 1.0;
    T[42*lanes] = 0.0;
    T[43*lanes] = 0.0;
    T[44*lanes] = 0.0;
    T[45*lanes] = 0.0;
    T[46*lanes] = 0.0;
    T[47*lanes] = 1.0;
    T[48*lanes] = -sin_q1;
    T[49*lanes] = 0.0;
    T[50*lanes] = cos_q1;
    T[51*lanes] = P4_x;
    T[52*lanes] = cos_q1;
    T[53*lanes] = 0.0;
    T[54*lanes] = sin_q1;
    T[55*lanes] = P4_y;
    T[56*lanes] = 0.0;
    T[57*lanes] = 1.0;
    T[58*lanes] = 0.0;
    T[59*lanes] = 0.0;
    T[60*lanes] = 0.0;
    T[61*lanes] = 0.0;
    T[62*lanes] = 0.0;
    T[63*lanes] = 1.0;
    T[64*lanes] = -sin_q1;
    T[65*lanes] = 0.0;
    T[66*lanes] = cos_q1;
    T[67*lanes] = P5_x;
    T[68*lanes] = cos_q1;
    T[69*lanes] = 0.0;
    T[70*lanes] = sin_q1;
    T[71*lanes] = P5_y;
    T[72*lanes] = 0.0;
    T[73*lanes] = 1.0;
    T[74*lanes] = 0.0;
    T[75*lanes] = 0.0;
    T[76*lanes] = 0.0;
    T[77*lanes] = 0.0;
    T[78*lanes] = 0.0;
    T[79*lanes] = 1.0;
    T[80*lanes] = A6_11;
    T[81*lanes] = A6_12;
    T[82*lanes] = 0.0;
    T[83*lanes] = P5_x;
    T[84*lanes] = -A6_12;
    T[85*lanes] = A6_11;
    T[86*lanes] = 0.0;
    T[87*lanes] = P5_y;
    T[88*lanes] = 0.0;
    T[89*lanes] = 0.0;
    T[90*lanes] = 1.0;
    T[91*lanes] = 0.0;
    T[92*lanes] = 0.0;
    T[93*lanes] = 0.0;
    T[94*lanes] = 0.0;
    T[95*lanes] = 1.0;
    T[96*lanes] = 0.0;
    T[97*lanes] = -A6_11;
    T[98*lanes] = -A6_12;
    T[99*lanes] = P7_x;
    T[100*lanes] = 0.0;
    T[101*lanes] = A6_12;
    T[102*lanes] = -A6_11;
    T[103*lanes] = P7_y;
    T[104*lanes] = 1.0;
    T[105*lanes] = 0.0;
    T[106*lanes] = 0.0;
    T[107*lanes] = 0.0;
    T[108*lanes] = 0.0;
    T[109*lanes] = 0.0;
    T[110*lanes] = 0.0;
    T[111*lanes] = 1.0;
    T[112*lanes] = -A6_12;
    T[113*lanes] = 0.0;
    T[114*lanes] = A6_11;
    T[115*lanes] = P8_x;
    T[116*lanes] = -A6_11;
    T[117*lanes] = 0.0;
    T[118*lanes] = -A6_12;
    T[119*lanes] = P8_y;
    T[120*lanes] = 0.0;
    T[121*lanes] = -1.0;
    T[122*lanes] = 0.0;
    T[123*lanes] = 0.0;
    T[124*lanes] = 0.0;
    T[125*lanes] = 0.0;
    T[126*lanes] = 0.0;
    T[127*lanes] = 1.0;
    T[128*lanes] = -A6_12;
    T[129*lanes] = 0.0;
    T[130*lanes] = A6_11;
    T[131*lanes] = P9_x;
    T[132*lanes] = -A6_11;
    T[133*lanes] = 0.0;
    T[134*lanes] = -A6_12;
    T[135*lanes] = P9_y;
    T[136*lanes] = 0.0;
    T[137*lanes] = -1.0;
    T[138*lanes] = 0.0;
    T[139*lanes] = 0.0;
    T[140*lanes] = 0.0;
    T[141*lanes] = 0.0;
    T[142*lanes] = 0.0;
    T[143*lanes] = 1.0;
    T[144*lanes] = -A6_12;
    T[145*lanes] = 0.0;
    T[146*lanes] = A6_11;
    T[147*lanes] = P10_x;
    T[148*lanes] = -A6_11;
    T[149*lanes] = 0.0;
    T[150*lanes] = -A6_12;
    T[151*lanes] = P10_y;
    T[152*lanes] = 0.0;
    T[153*lanes] = -1.0;
    T[154*lanes] = 0.0;
    T[155*lanes] = 0.0;
    T[156*lanes] = 0.0;
    T[157*lanes] = 0.0;
    T[158*lanes] = 0.0;
    T[159*lanes] = 1.0;
    T[160*lanes] = -A6_12;
    T[161*lanes] = 0.0;
    T[162*lanes] = A6_11;
    T[163*lanes] = P11_x;
    T[164*lanes] = -A6_11;
    T[165*lanes] = 0.0;
    T[166*lanes] = -A6_12;
    T[167*lanes] = P11_y;
    T[168*lanes] = 0.0;
    T[169*lanes] = -1.0;
    T[170*lanes] = 0.0;
    T[171*lanes] = 0.0;
    T[172*lanes] = 0.0;
    T[173*lanes] = 0.0;
    T[174*lanes] = 0.0;
    T[175*lanes] = 1.0;
    T[176*lanes] = -A6_12;
    T[177*lanes] = 0.0;
    T[178*lanes] = A6_11;
    T[179*lanes] = P12_x;
    T[180*lanes] = -A6_11;
    T[181*lanes] = 0.0;
    T[182*lanes] = -A6_12;
    T[183*lanes] = P12_y;
    T[184*lanes] = 0.0;
    T[185*lanes] = -1.0;
    T[186*lanes] = 0.0;
    T[187*lanes] = 0.0;
    T[188*lanes] = 0.0;
    T[189*lanes] = 0.0;
    T[190*lanes] = 0.0;
    T[191*lanes] = 1.0;
    T[192*lanes] = -sin_q1;
    T[193*lanes] = 0.0;
    T[194*lanes] = cos_q1;
    T[195*lanes] = P13_x;
    T[196*lanes] = cos_q1;
    T[197*lanes] = 0.0;
    T[198*lanes] = sin_q1;
    T[199*lanes] = P13_y;
    T[200*lanes] = 0.0;
    T[201*lanes] = 1.0;
    T[202*lanes] = 0.0;
    T[203*lanes] = 0.0;
    T[204*lanes] = 0.0;
    T[205*lanes] = 0.0;
    T[206*lanes] = 0.0;
    T[207*lanes] = 1.0;
}

void two_axis_geometric_model(const double *q, const double *p, double *T)
{
    double angle[2];
    double sine[2];
    double cosine[2];
    two_axis_geometric_model_angles(1, 1, q, angle);
    circles(2, angle, sine, cosine);
    two_axis_geometric_model_state(1, 1, q, p, sine, cosine, T);
}

APART void two_axis_geometric_model_state_lanes(size_t stride, const double *restrict q, const double *restrict p, const double *restrict sine, const double *restrict cosine, double *restrict T)
{
    for (size_t l = 0; l < LANES; l++)
        two_axis_geometric_model_state(stride, LANES, q + l, p, sine + l, cosine + l, T + l);
}

static void two_axis_geometric_model_lanes(size_t stride, const double *q, const double *p, double *T)
{
    double angle[2*LANES] ALIGNED;
    double sine[2*LANES] ALIGNED;
    double cosine[2*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        two_axis_geometric_model_angles(stride, LANES, q + l, angle + l);
    circles(2*LANES, angle, sine, cosine);
    two_axis_geometric_model_state_lanes(stride, q, p, sine, cosine, T);
}

void two_axis_geometric_model_batch(size_t states, const double *q, const double *p, double *T)
{
    double found_T[208*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        two_axis_geometric_model_lanes(states, q + first, p, found_T);
        store(208, states, LANES, found_T, T + first);
    }
    if (count) {
        double last_q[12*LANES] ALIGNED;
        load(12, states, count, q + first, last_q);
        two_axis_geometric_model_lanes(LANES, last_q, p, found_T);
        store(208, states, count, found_T, T + first);
    }
}
