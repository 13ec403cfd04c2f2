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
