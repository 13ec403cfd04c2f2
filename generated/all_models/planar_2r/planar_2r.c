/* planar_2r: generated models in double precision. Equation numbers are those of Khalil and Gautier.
 *
 * Fastest with -O3 -march=native -ffp-contract=fast -fno-math-errno -fno-trapping-math, and for AVX-512
 * -mprefer-vector-width=512. Not with -ffast-math, which costs accuracy.
 * A batch computes LANES states side by side; a number of states that is a large power of two makes caches slow. Entry k of an input is at k*stride, of a work array or result at k*lanes.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "planar_2r.h"

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

const double planar_2r_defaults[PLANAR_2R_PARAMETERS] = {
    9.81, /* g0 [m/s2] */
    2.5, /* m1 [kg] */
    1.5, /* m2 [kg] */
    0.4, /* l1 [m] */
    0.3, /* l2 [m] */
    0.2, /* lc1 [m] */
    0.15, /* lc2 [m] */
    0.035, /* I1 [kg m2] */
    0.012 /* I2 [kg m2] */
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

INLINE void planar_2r_direct_dynamics_constants(const double *restrict p, double *restrict c)
{
    const double m1 = p[PLANAR_2R_P_m1];
    const double m2 = p[PLANAR_2R_P_m2];
    const double l1 = p[PLANAR_2R_P_l1];
    const double lc1 = p[PLANAR_2R_P_lc1];
    const double lc2 = p[PLANAR_2R_P_lc2];
    const double I1 = p[PLANAR_2R_P_I1];
    const double I2 = p[PLANAR_2R_P_I2];

    /* Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14]. */
    const double MS1_x = m1*lc1;
    const double J1_yy = I1 + lc1*MS1_x;

    /* Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14]. */
    const double MS2_x = m2*lc2;
    const double J2_yy = I2 + lc2*MS2_x;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32]. */
    const double Hinv2 = 1.0/J2_yy;
    const double UH2_2 = MS2_x*Hinv2;
    const double K2_22a = m2 - MS2_x*UH2_2;
    const double K2_22b = m2 - K2_22a;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32]. */
    const double Js1_66a = l1*l1;

    c[0] = MS1_x;
    c[1] = J1_yy;
    c[2] = MS2_x;
    c[3] = Hinv2;
    c[4] = UH2_2;
    c[5] = K2_22a;
    c[6] = K2_22b;
    c[7] = Js1_66a;
}

void planar_2r_direct_dynamics_prepare(const double *p, double *c)
{
    planar_2r_direct_dynamics_constants(p, c);
}

INLINE void planar_2r_direct_dynamics_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double q1 = q[0*stride];
    const double q2 = q[1*stride];
    angle[0*lanes] = q1;
    angle[1*lanes] = q2;
}

INLINE void planar_2r_direct_dynamics_state(size_t stride, size_t lanes, const double *restrict qd, const double *restrict tau, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict qdd)
{
    (void)stride, (void)lanes;
    const double qd1 = qd[0*stride];
    const double qd2 = qd[1*stride];
    const double tau1 = tau[0*stride];
    const double tau2 = tau[1*stride];
    const double g0 = p[PLANAR_2R_P_g0];
    const double m2 = p[PLANAR_2R_P_m2];
    const double l1 = p[PLANAR_2R_P_l1];
    const double MS1_x = c[0];
    const double J1_yy = c[1];
    const double MS2_x = c[2];
    const double Hinv2 = c[3];
    const double UH2_2 = c[4];
    const double K2_22a = c[5];
    const double K2_22b = c[6];
    const double Js1_66a = c[7];

    /* Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14]. */
    const double sin_q1 = sine[0*lanes];
    const double cos_q1 = cosine[0*lanes];
    const double Vk1_1 = g0*sin_q1;
    const double Vk1_2 = g0*cos_q1;
    const double b1_6 = -MS1_x*Vk1_2;

    /* Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14]. */
    const double sin_q2 = sine[1*lanes];
    const double cos_q2 = cosine[1*lanes];
    const double w2_z = qd1 + qd2;
    const double Vk2_1a = qd1*(l1*qd1) - Vk1_1;
    const double Vk2_1 = sin_q2*Vk1_2 - cos_q2*Vk2_1a;
    const double Vk2_2 = sin_q2*Vk2_1a + cos_q2*Vk1_2;
    const double b2_2 = -m2*Vk2_2;
    const double b2_6 = -MS2_x*Vk2_2;
    const double b2_1 = w2_z*(MS2_x*w2_z) - m2*Vk2_1;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32]. */
    const double K2_22 = K2_22a + sin_q2*(sin_q2*K2_22b);
    const double Gb2 = tau2 + b2_6;
    const double qdf2 = Hinv2*Gb2;
    const double al2_2 = cos_q2*(MS2_x*qdf2 - b2_2) - sin_q2*b2_1;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32]. */
    const double bs1_6 = b1_6 - (tau2 + l1*al2_2);
    const double Gb1 = tau1 + bs1_6;
    const double Js1_66 = J1_yy + K2_22*Js1_66a;
    const double qdf1 = Gb1/Js1_66;

    /* Forward recursion: accelerations and torques, joint 2 (elbow) [33]-[36]. */
    const double Vr2_2 = cos_q2*(l1*qdf1);
    const double wd2_z = qdf2 - UH2_2*Vr2_2;
    const double qdd2 = wd2_z - qdf1;

    /* Results. */
    qdd[0*lanes] = qdf1;
    qdd[1*lanes] = qdd2;
}

void planar_2r_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    double angle[2];
    double sine[2];
    double cosine[2];
    planar_2r_direct_dynamics_angles(1, 1, q, angle);
    circles(2, angle, sine, cosine);
    planar_2r_direct_dynamics_state(1, 1, qd, tau, p, c, sine, cosine, qdd);
}

void planar_2r_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[PLANAR_2R_DIRECT_DYNAMICS_CONSTANTS];
    planar_2r_direct_dynamics_prepare(p, c);
    planar_2r_direct_dynamics_prepared(q, qd, tau, p, c, qdd);
}

APART void planar_2r_direct_dynamics_state_lanes(size_t stride, const double *restrict qd, const double *restrict tau, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict qdd)
{
    for (size_t l = 0; l < LANES; l++)
        planar_2r_direct_dynamics_state(stride, LANES, qd + l, tau + l, p, c, sine + l, cosine + l, qdd + l);
}

static void planar_2r_direct_dynamics_lanes(size_t stride, const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    double angle[2*LANES] ALIGNED;
    double sine[2*LANES] ALIGNED;
    double cosine[2*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        planar_2r_direct_dynamics_angles(stride, LANES, q + l, angle + l);
    circles(2*LANES, angle, sine, cosine);
    planar_2r_direct_dynamics_state_lanes(stride, qd, tau, p, c, sine, cosine, qdd);
}

void planar_2r_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[PLANAR_2R_DIRECT_DYNAMICS_CONSTANTS];
    planar_2r_direct_dynamics_prepare(p, c);
    double found_qdd[2*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        planar_2r_direct_dynamics_lanes(states, q + first, qd + first, tau + first, p, c, found_qdd);
        store(2, states, LANES, found_qdd, qdd + first);
    }
    if (count) {
        double last_q[2*LANES] ALIGNED;
        load(2, states, count, q + first, last_q);
        double last_qd[2*LANES] ALIGNED;
        load(2, states, count, qd + first, last_qd);
        double last_tau[2*LANES] ALIGNED;
        load(2, states, count, tau + first, last_tau);
        planar_2r_direct_dynamics_lanes(LANES, last_q, last_qd, last_tau, p, c, found_qdd);
        store(2, states, count, found_qdd, qdd + first);
    }
}

INLINE void planar_2r_inverse_dynamics_constants(const double *restrict p, double *restrict c)
{
    const double m1 = p[PLANAR_2R_P_m1];
    const double m2 = p[PLANAR_2R_P_m2];
    const double lc1 = p[PLANAR_2R_P_lc1];
    const double lc2 = p[PLANAR_2R_P_lc2];
    const double I1 = p[PLANAR_2R_P_I1];
    const double I2 = p[PLANAR_2R_P_I2];

    /* Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14]. */
    const double MS1_x = m1*lc1;
    const double J1_yy = I1 + lc1*MS1_x;

    /* Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14]. */
    const double MS2_x = m2*lc2;
    const double J2_yy = I2 + lc2*MS2_x;

    c[0] = MS1_x;
    c[1] = J1_yy;
    c[2] = MS2_x;
    c[3] = J2_yy;
}

void planar_2r_inverse_dynamics_prepare(const double *p, double *c)
{
    planar_2r_inverse_dynamics_constants(p, c);
}

INLINE void planar_2r_inverse_dynamics_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double q1 = q[0*stride];
    const double q2 = q[1*stride];
    angle[0*lanes] = q1;
    angle[1*lanes] = q2;
}

INLINE void planar_2r_inverse_dynamics_state(size_t stride, size_t lanes, const double *restrict qd, const double *restrict qdd_motor, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict tau, double *restrict qdd)
{
    (void)stride, (void)lanes;
    const double qd1 = qd[0*stride];
    const double qd2 = qd[1*stride];
    const double qdd1 = qdd_motor[0*stride];
    const double qdd2 = qdd_motor[1*stride];
    const double g0 = p[PLANAR_2R_P_g0];
    const double m2 = p[PLANAR_2R_P_m2];
    const double l1 = p[PLANAR_2R_P_l1];
    const double MS1_x = c[0];
    const double J1_yy = c[1];
    const double MS2_x = c[2];
    const double J2_yy = c[3];

    /* Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14]. */
    const double sin_q1 = sine[0*lanes];
    const double cos_q1 = cosine[0*lanes];
    const double ww1_zz = qd1*qd1;
    const double vd1_x = g0*sin_q1;
    const double vd1_y = g0*cos_q1;

    /* Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14]. */
    const double sin_q2 = sine[1*lanes];
    const double cos_q2 = cosine[1*lanes];
    const double w2_z = qd1 + qd2;
    const double wd2_z = qdd1 + qdd2;
    const double ww2_zz = w2_z*w2_z;
    const double vd2_xa = vd1_x - l1*ww1_zz;
    const double vd2_xb = vd1_y + l1*qdd1;
    const double vd2_x = cos_q2*vd2_xa + sin_q2*vd2_xb;
    const double vd2_y = cos_q2*vd2_xb - sin_q2*vd2_xa;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [50]-[56]. */
    const double f2_1 = m2*vd2_x - MS2_x*ww2_zz;
    const double f2_2 = m2*vd2_y + MS2_x*wd2_z;
    const double f2_6 = J2_yy*wd2_z + MS2_x*vd2_y;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [50]-[56]. */
    const double f1_6 = qdd1*J1_yy + MS1_x*vd1_y + f2_6 + l1*(sin_q2*f2_1 + cos_q2*f2_2);

    /* Results. */
    tau[0*lanes] = f1_6;
    tau[1*lanes] = f2_6;
    qdd[0*lanes] = qdd1;
    qdd[1*lanes] = qdd2;
}

void planar_2r_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    double angle[2];
    double sine[2];
    double cosine[2];
    planar_2r_inverse_dynamics_angles(1, 1, q, angle);
    circles(2, angle, sine, cosine);
    planar_2r_inverse_dynamics_state(1, 1, qd, qdd_motor, p, c, sine, cosine, tau, qdd);
}

void planar_2r_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[PLANAR_2R_INVERSE_DYNAMICS_CONSTANTS];
    planar_2r_inverse_dynamics_prepare(p, c);
    planar_2r_inverse_dynamics_prepared(q, qd, qdd_motor, p, c, tau, qdd);
}

APART void planar_2r_inverse_dynamics_state_lanes(size_t stride, const double *restrict qd, const double *restrict qdd_motor, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict tau, double *restrict qdd)
{
    for (size_t l = 0; l < LANES; l++)
        planar_2r_inverse_dynamics_state(stride, LANES, qd + l, qdd_motor + l, p, c, sine + l, cosine + l, tau + l, qdd + l);
}

static void planar_2r_inverse_dynamics_lanes(size_t stride, const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    double angle[2*LANES] ALIGNED;
    double sine[2*LANES] ALIGNED;
    double cosine[2*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        planar_2r_inverse_dynamics_angles(stride, LANES, q + l, angle + l);
    circles(2*LANES, angle, sine, cosine);
    planar_2r_inverse_dynamics_state_lanes(stride, qd, qdd_motor, p, c, sine, cosine, tau, qdd);
}

void planar_2r_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[PLANAR_2R_INVERSE_DYNAMICS_CONSTANTS];
    planar_2r_inverse_dynamics_prepare(p, c);
    double found_tau[2*LANES] ALIGNED;
    double found_qdd[2*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        planar_2r_inverse_dynamics_lanes(states, q + first, qd + first, qdd_motor + first, p, c, found_tau, found_qdd);
        store(2, states, LANES, found_tau, tau + first);
        store(2, states, LANES, found_qdd, qdd + first);
    }
    if (count) {
        double last_q[2*LANES] ALIGNED;
        load(2, states, count, q + first, last_q);
        double last_qd[2*LANES] ALIGNED;
        load(2, states, count, qd + first, last_qd);
        double last_qdd_motor[2*LANES] ALIGNED;
        load(2, states, count, qdd_motor + first, last_qdd_motor);
        planar_2r_inverse_dynamics_lanes(LANES, last_q, last_qd, last_qdd_motor, p, c, found_tau, found_qdd);
        store(2, states, count, found_tau, tau + first);
        store(2, states, count, found_qdd, qdd + first);
    }
}

INLINE void planar_2r_inertia_matrix_constants(const double *restrict p, double *restrict c)
{
    const double m1 = p[PLANAR_2R_P_m1];
    const double m2 = p[PLANAR_2R_P_m2];
    const double l1 = p[PLANAR_2R_P_l1];
    const double lc1 = p[PLANAR_2R_P_lc1];
    const double lc2 = p[PLANAR_2R_P_lc2];
    const double I1 = p[PLANAR_2R_P_I1];
    const double I2 = p[PLANAR_2R_P_I2];

    /* Geometry, joint 1 (shoulder) [1]. */
    const double MS1_x = m1*lc1;
    const double J1_yy = I1 + lc1*MS1_x;

    /* Geometry, joint 2 (elbow) [1]. */
    const double MS2_x = m2*lc2;
    const double J2_yy = I2 + lc2*MS2_x;

    /* Composite inertias and inertia matrix, joint 1 (shoulder) [8], [13]. */
    const double J1_czza = m2*l1;

    c[0] = J1_yy;
    c[1] = MS2_x;
    c[2] = J2_yy;
    c[3] = J1_czza;
}

void planar_2r_inertia_matrix_prepare(const double *p, double *c)
{
    planar_2r_inertia_matrix_constants(p, c);
}

INLINE void planar_2r_inertia_matrix_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double q2 = q[1*stride];
    angle[0*lanes] = q2;
}

INLINE void planar_2r_inertia_matrix_state(size_t stride, size_t lanes, const double *restrict p, const double *restrict c, const double *restrict cosine, double *restrict A)
{
    (void)stride, (void)lanes;
    const double l1 = p[PLANAR_2R_P_l1];
    const double J1_yy = c[0];
    const double MS2_x = c[1];
    const double J2_yy = c[2];
    const double J1_czza = c[3];

    /* Geometry, joint 2 (elbow) [1]. */
    const double cos_q2 = cosine[0*lanes];

    /* Composite inertias and inertia matrix, joint 2 (elbow) [8], [13]. */
    const double A1_2a = cos_q2*MS2_x;
    const double A1_2 = J2_yy + l1*A1_2a;

    /* Composite inertias and inertia matrix, joint 1 (shoulder) [8], [13]. */
    const double J1_czz = J1_yy + J2_yy + l1*(A1_2a + A1_2a + J1_czza);

    /* Results. */
    A[0*lanes] = J1_czz;
    A[1*lanes] = A1_2;
    A[2*lanes] = A1_2;
    A[3*lanes] = J2_yy;
}

void planar_2r_inertia_matrix_prepared(const double *q, const double *p, const double *c, double *A)
{
    double angle[1];
    double sine[1];
    double cosine[1];
    planar_2r_inertia_matrix_angles(1, 1, q, angle);
    circles(1, angle, sine, cosine);
    planar_2r_inertia_matrix_state(1, 1, p, c, cosine, A);
}

void planar_2r_inertia_matrix(const double *q, const double *p, double *A)
{
    double c[PLANAR_2R_INERTIA_MATRIX_CONSTANTS];
    planar_2r_inertia_matrix_prepare(p, c);
    planar_2r_inertia_matrix_prepared(q, p, c, A);
}

APART void planar_2r_inertia_matrix_state_lanes(size_t stride, const double *restrict p, const double *restrict c, const double *restrict cosine, double *restrict A)
{
    for (size_t l = 0; l < LANES; l++)
        planar_2r_inertia_matrix_state(stride, LANES, p, c, cosine + l, A + l);
}

static void planar_2r_inertia_matrix_lanes(size_t stride, const double *q, const double *p, const double *c, double *A)
{
    double angle[1*LANES] ALIGNED;
    double sine[1*LANES] ALIGNED;
    double cosine[1*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        planar_2r_inertia_matrix_angles(stride, LANES, q + l, angle + l);
    circles(1*LANES, angle, sine, cosine);
    planar_2r_inertia_matrix_state_lanes(stride, p, c, cosine, A);
}

void planar_2r_inertia_matrix_batch(size_t states, const double *q, const double *p, double *A)
{
    double c[PLANAR_2R_INERTIA_MATRIX_CONSTANTS];
    planar_2r_inertia_matrix_prepare(p, c);
    double found_A[4*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        planar_2r_inertia_matrix_lanes(states, q + first, p, c, found_A);
        store(4, states, LANES, found_A, A + first);
    }
    if (count) {
        double last_q[2*LANES] ALIGNED;
        load(2, states, count, q + first, last_q);
        planar_2r_inertia_matrix_lanes(LANES, last_q, p, c, found_A);
        store(4, states, count, found_A, A + first);
    }
}

INLINE void planar_2r_bias_forces_constants(const double *restrict p, double *restrict c)
{
    const double m1 = p[PLANAR_2R_P_m1];
    const double m2 = p[PLANAR_2R_P_m2];
    const double lc1 = p[PLANAR_2R_P_lc1];
    const double lc2 = p[PLANAR_2R_P_lc2];

    /* Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14]. */
    const double MS1_x = m1*lc1;

    /* Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14]. */
    const double MS2_x = m2*lc2;

    c[0] = MS1_x;
    c[1] = MS2_x;
}

void planar_2r_bias_forces_prepare(const double *p, double *c)
{
    planar_2r_bias_forces_constants(p, c);
}

INLINE void planar_2r_bias_forces_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double q1 = q[0*stride];
    const double q2 = q[1*stride];
    angle[0*lanes] = q1;
    angle[1*lanes] = q2;
}

INLINE void planar_2r_bias_forces_state(size_t stride, size_t lanes, const double *restrict qd, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict H)
{
    (void)stride, (void)lanes;
    const double qd1 = qd[0*stride];
    const double qd2 = qd[1*stride];
    const double g0 = p[PLANAR_2R_P_g0];
    const double m2 = p[PLANAR_2R_P_m2];
    const double l1 = p[PLANAR_2R_P_l1];
    const double MS1_x = c[0];
    const double MS2_x = c[1];

    /* Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14]. */
    const double sin_q1 = sine[0*lanes];
    const double cos_q1 = cosine[0*lanes];
    const double ww1_zz = qd1*qd1;
    const double vd1_x = g0*sin_q1;
    const double vd1_y = g0*cos_q1;

    /* Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14]. */
    const double sin_q2 = sine[1*lanes];
    const double cos_q2 = cosine[1*lanes];
    const double w2_z = qd1 + qd2;
    const double ww2_zz = w2_z*w2_z;
    const double vd2_xa = vd1_x - l1*ww1_zz;
    const double vd2_x = cos_q2*vd2_xa + sin_q2*vd1_y;
    const double vd2_y = cos_q2*vd1_y - sin_q2*vd2_xa;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [15]. */
    const double f2_2 = m2*vd2_y;
    const double f2_1 = m2*vd2_x - MS2_x*ww2_zz;
    const double f2_6 = MS2_x*vd2_y;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [15]. */
    const double f1_6 = MS1_x*vd1_y + f2_6 + l1*(sin_q2*f2_1 + cos_q2*f2_2);

    /* Results. */
    H[0*lanes] = f1_6;
    H[1*lanes] = f2_6;
}

void planar_2r_bias_forces_prepared(const double *q, const double *qd, const double *p, const double *c, double *H)
{
    double angle[2];
    double sine[2];
    double cosine[2];
    planar_2r_bias_forces_angles(1, 1, q, angle);
    circles(2, angle, sine, cosine);
    planar_2r_bias_forces_state(1, 1, qd, p, c, sine, cosine, H);
}

void planar_2r_bias_forces(const double *q, const double *qd, const double *p, double *H)
{
    double c[PLANAR_2R_BIAS_FORCES_CONSTANTS];
    planar_2r_bias_forces_prepare(p, c);
    planar_2r_bias_forces_prepared(q, qd, p, c, H);
}

APART void planar_2r_bias_forces_state_lanes(size_t stride, const double *restrict qd, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict H)
{
    for (size_t l = 0; l < LANES; l++)
        planar_2r_bias_forces_state(stride, LANES, qd + l, p, c, sine + l, cosine + l, H + l);
}

static void planar_2r_bias_forces_lanes(size_t stride, const double *q, const double *qd, const double *p, const double *c, double *H)
{
    double angle[2*LANES] ALIGNED;
    double sine[2*LANES] ALIGNED;
    double cosine[2*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        planar_2r_bias_forces_angles(stride, LANES, q + l, angle + l);
    circles(2*LANES, angle, sine, cosine);
    planar_2r_bias_forces_state_lanes(stride, qd, p, c, sine, cosine, H);
}

void planar_2r_bias_forces_batch(size_t states, const double *q, const double *qd, const double *p, double *H)
{
    double c[PLANAR_2R_BIAS_FORCES_CONSTANTS];
    planar_2r_bias_forces_prepare(p, c);
    double found_H[2*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        planar_2r_bias_forces_lanes(states, q + first, qd + first, p, c, found_H);
        store(2, states, LANES, found_H, H + first);
    }
    if (count) {
        double last_q[2*LANES] ALIGNED;
        load(2, states, count, q + first, last_q);
        double last_qd[2*LANES] ALIGNED;
        load(2, states, count, qd + first, last_qd);
        planar_2r_bias_forces_lanes(LANES, last_q, last_qd, p, c, found_H);
        store(2, states, count, found_H, H + first);
    }
}

INLINE void planar_2r_geometric_model_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double q1 = q[0*stride];
    const double q2 = q[1*stride];
    angle[0*lanes] = q1;
    angle[1*lanes] = q2;
}

INLINE void planar_2r_geometric_model_state(size_t stride, size_t lanes, const double *restrict p, const double *restrict sine, const double *restrict cosine, double *restrict T)
{
    (void)stride, (void)lanes;
    const double l1 = p[PLANAR_2R_P_l1];
    const double l2 = p[PLANAR_2R_P_l2];

    /* Geometry, joint 1 (shoulder) [1], [2]. */
    const double sin_q1 = sine[0*lanes];
    const double cos_q1 = cosine[0*lanes];

    /* Geometry, joint 2 (elbow) [1], [2]. */
    const double sin_q2 = sine[1*lanes];
    const double cos_q2 = cosine[1*lanes];
    const double P2_x = l1*cos_q1;
    const double P2_y = l1*sin_q1;
    const double A2_11 = cos_q1*cos_q2 - sin_q1*sin_q2;
    const double A2_12 = -(cos_q1*sin_q2 + sin_q1*cos_q2);

    /* Geometry, joint 3 (tip) [1], [2]. */
    const double P3_x = P2_x + l2*A2_11;
    const double P3_y = P2_y - l2*A2_12;

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
    T[16*lanes] = A2_11;
    T[17*lanes] = A2_12;
    T[18*lanes] = 0.0;
    T[19*lanes] = P2_x;
    T[20*lanes] = -A2_12;
    T[21*lanes] = A2_11;
    T[22*lanes] = 0.0;
    T[23*lanes] = P2_y;
    T[24*lanes] = 0.0;
    T[25*lanes] = 0.0;
    T[26*lanes] = 1.0;
    T[27*lanes] = 0.0;
    T[28*lanes] = 0.0;
    T[29*lanes] = 0.0;
    T[30*lanes] = 0.0;
    T[31*lanes] = 1.0;
    T[32*lanes] = A2_11;
    T[33*lanes] = A2_12;
    T[34*lanes] = 0.0;
    T[35*lanes] = P3_x;
    T[36*lanes] = -A2_12;
    T[37*lanes] = A2_11;
    T[38*lanes] = 0.0;
    T[39*lanes] = P3_y;
    T[40*lanes] = 0.0;
    T[41*lanes] = 0.0;
    T[42*lanes] = 1.0;
    T[43*lanes] = 0.0;
    T[44*lanes] = 0.0;
    T[45*lanes] = 0.0;
    T[46*lanes] = 0.0;
    T[47*lanes] = 1.0;
}

void planar_2r_geometric_model(const double *q, const double *p, double *T)
{
    double angle[2];
    double sine[2];
    double cosine[2];
    planar_2r_geometric_model_angles(1, 1, q, angle);
    circles(2, angle, sine, cosine);
    planar_2r_geometric_model_state(1, 1, p, sine, cosine, T);
}

APART void planar_2r_geometric_model_state_lanes(size_t stride, const double *restrict p, const double *restrict sine, const double *restrict cosine, double *restrict T)
{
    for (size_t l = 0; l < LANES; l++)
        planar_2r_geometric_model_state(stride, LANES, p, sine + l, cosine + l, T + l);
}

static void planar_2r_geometric_model_lanes(size_t stride, const double *q, const double *p, double *T)
{
    double angle[2*LANES] ALIGNED;
    double sine[2*LANES] ALIGNED;
    double cosine[2*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        planar_2r_geometric_model_angles(stride, LANES, q + l, angle + l);
    circles(2*LANES, angle, sine, cosine);
    planar_2r_geometric_model_state_lanes(stride, p, sine, cosine, T);
}

void planar_2r_geometric_model_batch(size_t states, const double *q, const double *p, double *T)
{
    double found_T[48*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        planar_2r_geometric_model_lanes(states, q + first, p, found_T);
        store(48, states, LANES, found_T, T + first);
    }
    if (count) {
        double last_q[2*LANES] ALIGNED;
        load(2, states, count, q + first, last_q);
        planar_2r_geometric_model_lanes(LANES, last_q, p, found_T);
        store(48, states, count, found_T, T + first);
    }
}
