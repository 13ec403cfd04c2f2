/* planar_2r: generated models in double precision. Equation numbers are those of Khalil and Gautier.
 *
 * Fastest with -O3 -march=native -ffp-contract=fast -fno-math-errno -fno-trapping-math. Not with -ffast-math, which
 * costs accuracy.
 * The equations stand at the end, once, and are compiled twice: NUMBER is a number, or in a batch a vector of WIDTH numbers.
 * For that the file includes itself and keeps its name. Entry k of an input or result is at k*stride. A number of
 * states that is a large power of two makes caches slow.
 */
#ifndef NUMBER
#include <float.h>
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "planar_2r.h"

#define EQUATIONS 3727661462
#ifdef __GNUC__
#define INLINE static inline __attribute__((always_inline, unused))
#define APART static __attribute__((noinline, unused))
#else
#define INLINE static inline
#define APART static
#endif
#define EXCESS (FLT_EVAL_METHOD%16 != 0) /* whether numbers are kept longer than their type */

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
#if EXCESS || defined(__FAST_MATH__) || defined(__ASSOCIATIVE_MATH__) /* would spoil the rounding of k */
#undef LARGEST_ANGLE
#define LARGEST_ANGLE -1.0
#endif
#ifndef LARGEST_ANGLE
#define LARGEST_ANGLE 1048576.0
#endif

/* The library's sines and cosines of the angles that are too large, infinite or NaN. */
APART void far_circles(size_t n, const double *x, double *sine, double *cosine)
{
    for (size_t i = 0; i < n; i++) {
        if (!(fabs(x[i]) <= LARGEST_ANGLE)) {
            sine[i] = sin(x[i]);
            cosine[i] = cos(x[i]);
        }
    }
}

/* For a batch: vectors of WIDTH numbers, as long as the processor's (-DVECTOR_BYTES=32: no longer than that). */
#if !EXCESS && (defined(__clang__) || __GNUC__ >= 9)
#ifdef VECTOR_BYTES
#elif defined(__AVX512F__)
#define VECTOR_BYTES 64
#elif defined(__AVX__)
#define VECTOR_BYTES 32
#else
#define VECTOR_BYTES 16
#endif
#pragma GCC diagnostic ignored "-Wpsabi" /* on vectors longer than the processor's: no other file is handed any */
#define WIDTH (VECTOR_BYTES/sizeof(double))
#define LANES(name) name##_lanes
#define VECTOR(type) type __attribute__((vector_size(WIDTH*sizeof(type)), may_alias))
typedef VECTOR(double) numbers;
typedef numbers angles;
typedef VECTOR(uint64_t) bits;

INLINE angles lanes_at(const double *x)
{
    angles found;
    memcpy(&found, x, sizeof found);
    return found;
}

#define NUMBER numbers
#define ANGLE angles
#define BITS bits
#define OF(name) name##_lanes
#define WHOLE APART
#define LOAD(x) lanes_at(x)
#define STORE(x, value) do { const angles put = (value) - (numbers){0}; memcpy(x, &put, sizeof put); } while (0)
#include "planar_2r.c"
#undef NUMBER
#undef ANGLE
#undef BITS
#undef OF
#undef WHOLE
#undef LOAD
#undef STORE
#else
#define WIDTH 1
#define LANES(name) name
#endif

/* For one state. */
#define NUMBER double
#define ANGLE double
#define BITS uint64_t
#define OF(name) name
#define WHOLE INLINE
#define LOAD(x) (*(x))
#define STORE(x, value) (*(x) = (value))
#include "planar_2r.c"

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

void planar_2r_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    planar_2r_direct_dynamics_at(1, q, qd, tau, p, c, qdd);
}

void planar_2r_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[PLANAR_2R_DIRECT_DYNAMICS_CONSTANTS];
    planar_2r_direct_dynamics_prepare(p, c);
    planar_2r_direct_dynamics_prepared(q, qd, tau, p, c, qdd);
}

void planar_2r_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[PLANAR_2R_DIRECT_DYNAMICS_CONSTANTS];
    planar_2r_direct_dynamics_prepare(p, c);
    size_t first = 0;
    for (; states < WIDTH && first < states; first++)
        planar_2r_direct_dynamics_at(states, q + first, qd + first, tau + first, p, c, qdd + first);
    for (; first < states; first += WIDTH) {
        if (first + WIDTH > states)
            first = states - WIDTH; /* The last ones overlap with those before. */
        LANES(planar_2r_direct_dynamics_at)(states, q + first, qd + first, tau + first, p, c, qdd + first);
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

    /* Forward recursion: velocities, accelerations, wrenches, joint 1 (shoulder) [1], [3], [6], [12]. */
    const double MS1_x = m1*lc1;
    const double J1_yy = I1 + lc1*MS1_x;

    /* Forward recursion: velocities, accelerations, wrenches, joint 2 (elbow) [1], [3], [6], [12]. */
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

void planar_2r_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    planar_2r_inverse_dynamics_at(1, q, qd, qdd_motor, p, c, tau, qdd);
}

void planar_2r_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[PLANAR_2R_INVERSE_DYNAMICS_CONSTANTS];
    planar_2r_inverse_dynamics_prepare(p, c);
    planar_2r_inverse_dynamics_prepared(q, qd, qdd_motor, p, c, tau, qdd);
}

void planar_2r_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[PLANAR_2R_INVERSE_DYNAMICS_CONSTANTS];
    planar_2r_inverse_dynamics_prepare(p, c);
    size_t first = 0;
    for (; states < WIDTH && first < states; first++)
        planar_2r_inverse_dynamics_at(states, q + first, qd + first, qdd_motor + first, p, c, tau + first, qdd + first);
    for (; first < states; first += WIDTH) {
        if (first + WIDTH > states)
            first = states - WIDTH; /* The last ones overlap with those before. */
        LANES(planar_2r_inverse_dynamics_at)(states, q + first, qd + first, qdd_motor + first, p, c, tau + first, qdd + first);
    }
}

#else /* The equations. */
#if EQUATIONS != 3727661462
#error "this planar_2r.c is not the file that includes it: a generated file keeps its name"
#endif

/* Sine and cosine, within 1.5 units in the last place up to LARGEST_ANGLE.
 *
 * x = k pi/2 + r with pi/2 in three parts, of which k times the first two are exact; polynomials in r; the last two
 * bits of k, read from the sum that rounds it, choose sine or cosine and the signs.
 */
INLINE void OF(circle)(const ANGLE *restrict angle, ANGLE *restrict sine, ANGLE *restrict cosine)
{
#ifdef __clang__
#pragma clang fp reassociate(off)
#endif
    const ANGLE x = *angle;
    const double rounder = 0x1.8p52;
    const ANGLE rounded = x*0x1.45f306dc9c883p-1 + rounder;
    const ANGLE k = rounded - rounder;
    const ANGLE t = x - k*0x1.921fb544p+0, v = t - k*0x1.0b4611a6p-34;
    const ANGLE r = v + (((t - v) - k*0x1.0b4611a6p-34) - k*0x1.3198a2e037073p-69);
    const ANGLE z = r*r;
    const ANGLE s = r + r*z*(-0x1.5555555555555p-3 + z*(0x1.1111111110bb2p-7 + z*(-0x1.a01a019e83900p-13
        + z*(0x1.71de37965e0e8p-19 + z*(-0x1.ae600acd78df1p-26 + z*0x1.5e0b04aa9e9dbp-33)))));
    const ANGLE c = 1.0 - (0.5*z - z*z*(0x1.5555555555555p-5 + z*(-0x1.6c16c16c16967p-10 + z*(0x1.a01a019f4e9f7p-16
        + z*(-0x1.27e4fa17c076bp-22 + z*(0x1.1eeb68cb4c486p-29 + z*-0x1.907d8bf27a69cp-37))))));
    BITS quarter, bits_s, bits_c;
    memcpy(&quarter, &rounded, sizeof quarter);
    memcpy(&bits_s, &s, sizeof bits_s);
    memcpy(&bits_c, &c, sizeof bits_c);
    const BITS exchange = (0 - (quarter & 1)) & (bits_s ^ bits_c);
    bits_s ^= exchange ^ ((quarter & 2) << 62);
    bits_c ^= exchange ^ (((quarter + 1) & 2) << 62);
    memcpy(sine, &bits_s, sizeof bits_s);
    memcpy(cosine, &bits_c, sizeof bits_c);
}

/* Sines and cosines of n angles; whether some are left to `far_circles`. */
INLINE int OF(circles)(size_t n, const ANGLE *restrict angle, ANGLE *restrict sine, ANGLE *restrict cosine)
{
    const double *x = (const double *)angle;
    uint64_t large = 0;
    for (size_t i = 0; i < n*(sizeof(ANGLE)/sizeof(double)); i++)
        large |= !(fabs(x[i]) <= LARGEST_ANGLE);
    for (size_t k = 0; k < n; k++)
        OF(circle)(&angle[k], &sine[k], &cosine[k]);
    return large != 0;
}

INLINE void OF(planar_2r_direct_dynamics_angles)(size_t stride, const double *restrict q, ANGLE *restrict angle)
{
    (void)stride;
    const ANGLE q1 = LOAD(q + 0*stride);
    const ANGLE q2 = LOAD(q + 1*stride);
    angle[0] = q1;
    angle[1] = q2;
}

INLINE void OF(planar_2r_direct_dynamics_state)(size_t stride, const double *restrict qd, const double *restrict tau, const double *restrict p, const double *restrict c, const ANGLE *restrict sine, const ANGLE *restrict cosine, double *restrict qdd)
{
    (void)stride;
    const NUMBER qd1 = LOAD(qd + 0*stride);
    const NUMBER qd2 = LOAD(qd + 1*stride);
    const NUMBER tau1 = LOAD(tau + 0*stride);
    const NUMBER tau2 = LOAD(tau + 1*stride);
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
    const NUMBER sin_q1 = sine[0];
    const NUMBER cos_q1 = cosine[0];
    const NUMBER Vk1_1 = g0*sin_q1;
    const NUMBER Vk1_2 = g0*cos_q1;
    const NUMBER b1_6 = -MS1_x*Vk1_2;

    /* Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14]. */
    const NUMBER sin_q2 = sine[1];
    const NUMBER cos_q2 = cosine[1];
    const NUMBER w2_z = qd1 + qd2;
    const NUMBER Vk2_1a = qd1*(l1*qd1) - Vk1_1;
    const NUMBER Vk2_1 = sin_q2*Vk1_2 - cos_q2*Vk2_1a;
    const NUMBER Vk2_2 = sin_q2*Vk2_1a + cos_q2*Vk1_2;
    const NUMBER b2_2 = -m2*Vk2_2;
    const NUMBER b2_6 = -MS2_x*Vk2_2;
    const NUMBER b2_1 = w2_z*(MS2_x*w2_z) - m2*Vk2_1;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32]. */
    const NUMBER K2_22 = K2_22a + sin_q2*(sin_q2*K2_22b);
    const NUMBER Gb2 = tau2 + b2_6;
    const NUMBER qdf2 = Hinv2*Gb2;
    const NUMBER al2_2 = cos_q2*(MS2_x*qdf2 - b2_2) - sin_q2*b2_1;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32]. */
    const NUMBER bs1_6 = b1_6 - (tau2 + l1*al2_2);
    const NUMBER Gb1 = tau1 + bs1_6;
    const NUMBER Js1_66 = J1_yy + K2_22*Js1_66a;
    const NUMBER qdf1 = Gb1/Js1_66;

    /* Forward recursion: accelerations and torques, joint 2 (elbow) [33]-[36]. */
    const NUMBER Vr2_2 = cos_q2*(l1*qdf1);
    const NUMBER wd2_z = qdf2 - UH2_2*Vr2_2;
    const NUMBER qdd2 = wd2_z - qdf1;

    /* Results. */
    STORE(qdd + 0*stride, qdf1);
    STORE(qdd + 1*stride, qdd2);
}

WHOLE void OF(planar_2r_direct_dynamics_at)(size_t stride, const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    ANGLE angle[2];
    ANGLE sine[2];
    ANGLE cosine[2];
    OF(planar_2r_direct_dynamics_angles)(stride, q, angle);
    if (OF(circles)(2, angle, sine, cosine)) {
        ANGLE far[2]; /* a copy, so that the angles themselves stay in registers */
        for (size_t k = 0; k < 2; k++)
            far[k] = angle[k];
        far_circles(2*(sizeof(ANGLE)/sizeof(double)), (const double *)far, (double *)sine, (double *)cosine);
    }
    OF(planar_2r_direct_dynamics_state)(stride, qd, tau, p, c, sine, cosine, qdd);
}

INLINE void OF(planar_2r_inverse_dynamics_angles)(size_t stride, const double *restrict q, ANGLE *restrict angle)
{
    (void)stride;
    const ANGLE q1 = LOAD(q + 0*stride);
    const ANGLE q2 = LOAD(q + 1*stride);
    angle[0] = q1;
    angle[1] = q2;
}

INLINE void OF(planar_2r_inverse_dynamics_state)(size_t stride, const double *restrict qd, const double *restrict qdd_motor, const double *restrict p, const double *restrict c, const ANGLE *restrict sine, const ANGLE *restrict cosine, double *restrict tau, double *restrict qdd)
{
    (void)stride;
    const NUMBER qd1 = LOAD(qd + 0*stride);
    const NUMBER qd2 = LOAD(qd + 1*stride);
    const NUMBER qdd1 = LOAD(qdd_motor + 0*stride);
    const NUMBER qdd2 = LOAD(qdd_motor + 1*stride);
    const double g0 = p[PLANAR_2R_P_g0];
    const double m2 = p[PLANAR_2R_P_m2];
    const double l1 = p[PLANAR_2R_P_l1];
    const double MS1_x = c[0];
    const double J1_yy = c[1];
    const double MS2_x = c[2];
    const double J2_yy = c[3];

    /* Forward recursion: velocities, accelerations, wrenches, joint 1 (shoulder) [1], [3], [6], [12]. */
    const NUMBER sin_q1 = sine[0];
    const NUMBER cos_q1 = cosine[0];
    const NUMBER ww1_zz = qd1*qd1;
    const NUMBER vd1_x = g0*sin_q1;
    const NUMBER vd1_y = g0*cos_q1;
    const NUMBER Fb1_6 = qdd1*J1_yy + MS1_x*vd1_y;

    /* Forward recursion: velocities, accelerations, wrenches, joint 2 (elbow) [1], [3], [6], [12]. */
    const NUMBER sin_q2 = sine[1];
    const NUMBER cos_q2 = cosine[1];
    const NUMBER w2_z = qd1 + qd2;
    const NUMBER wd2_z = qdd1 + qdd2;
    const NUMBER ww2_zz = w2_z*w2_z;
    const NUMBER vd2_xa = vd1_x - l1*ww1_zz;
    const NUMBER vd2_xb = vd1_y + l1*qdd1;
    const NUMBER vd2_x = cos_q2*vd2_xa + sin_q2*vd2_xb;
    const NUMBER vd2_y = cos_q2*vd2_xb - sin_q2*vd2_xa;
    const NUMBER Fb2_1 = m2*vd2_x - MS2_x*ww2_zz;
    const NUMBER Fb2_2 = m2*vd2_y + MS2_x*wd2_z;
    const NUMBER Fb2_6 = J2_yy*wd2_z + MS2_x*vd2_y;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [50]-[56]. */
    const NUMBER f1_6 = Fb1_6 + Fb2_6 + l1*(sin_q2*Fb2_1 + cos_q2*Fb2_2);

    /* Results. */
    STORE(tau + 0*stride, f1_6);
    STORE(tau + 1*stride, Fb2_6);
    STORE(qdd + 0*stride, qdd1);
    STORE(qdd + 1*stride, qdd2);
}

WHOLE void OF(planar_2r_inverse_dynamics_at)(size_t stride, const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    ANGLE angle[2];
    ANGLE sine[2];
    ANGLE cosine[2];
    OF(planar_2r_inverse_dynamics_angles)(stride, q, angle);
    if (OF(circles)(2, angle, sine, cosine)) {
        ANGLE far[2]; /* a copy, so that the angles themselves stay in registers */
        for (size_t k = 0; k < 2; k++)
            far[k] = angle[k];
        far_circles(2*(sizeof(ANGLE)/sizeof(double)), (const double *)far, (double *)sine, (double *)cosine);
    }
    OF(planar_2r_inverse_dynamics_state)(stride, qd, qdd_motor, p, c, sine, cosine, tau, qdd);
}

#endif
