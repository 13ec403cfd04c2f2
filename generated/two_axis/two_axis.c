/* two_axis: generated models in double precision. Equation numbers are those of Khalil and Gautier.
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

#include "two_axis.h"

#define EQUATIONS 3162838275
#ifdef __GNUC__
#define INLINE static inline __attribute__((always_inline, unused))
#define APART static __attribute__((noinline, unused))
#else
#define INLINE static inline
#define APART static
#endif
#define EXCESS (FLT_EVAL_METHOD%16 != 0) /* whether numbers are kept longer than their type */

const double two_axis_defaults[TWO_AXIS_PARAMETERS] = {
    0.35, /* D4 [m] */
    0.15, /* D12 [m] */
    0.25, /* L12 [m] */
    0.12 /* D13 [m] */
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
#include "two_axis.c"
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
#include "two_axis.c"

void two_axis_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    two_axis_direct_dynamics_at(1, q, qd, tau, p, qdd);
}

void two_axis_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    size_t first = 0;
    for (; states < WIDTH && first < states; first++)
        two_axis_direct_dynamics_at(states, q + first, qd + first, tau + first, p, qdd + first);
    for (; first < states; first += WIDTH) {
        if (first + WIDTH > states)
            first = states - WIDTH; /* The last ones overlap with those before. */
        LANES(two_axis_direct_dynamics_at)(states, q + first, qd + first, tau + first, p, qdd + first);
    }
}

void two_axis_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    two_axis_inverse_dynamics_at(1, q, qd, qdd_motor, p, tau, qdd);
}

void two_axis_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    size_t first = 0;
    for (; states < WIDTH && first < states; first++)
        two_axis_inverse_dynamics_at(states, q + first, qd + first, qdd_motor + first, p, tau + first, qdd + first);
    for (; first < states; first += WIDTH) {
        if (first + WIDTH > states)
            first = states - WIDTH; /* The last ones overlap with those before. */
        LANES(two_axis_inverse_dynamics_at)(states, q + first, qd + first, qdd_motor + first, p, tau + first, qdd + first);
    }
}

#else /* The equations. */
#if EQUATIONS != 3162838275
#error "this two_axis.c is not the file that includes it: a generated file keeps its name"
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

INLINE void OF(two_axis_direct_dynamics_angles)(size_t stride, const double *restrict q, ANGLE *restrict angle)
{
    (void)stride;
    const ANGLE q1 = LOAD(q + 0*stride);
    const ANGLE q6 = LOAD(q + 5*stride);
    angle[0] = q1;
    angle[1] = q6;
}

INLINE void OF(two_axis_direct_dynamics_state)(size_t stride, const double *restrict q, const double *restrict qd, const double *restrict tau, const double *restrict p, const ANGLE *restrict sine, const ANGLE *restrict cosine, double *restrict qdd)
{
    (void)stride;
    const NUMBER q1 = LOAD(q + 0*stride);
    const NUMBER q2 = LOAD(q + 1*stride);
    const NUMBER q3 = LOAD(q + 2*stride);
    const NUMBER q4 = LOAD(q + 3*stride);
    const NUMBER q5 = LOAD(q + 4*stride);
    const NUMBER q6 = LOAD(q + 5*stride);
    const NUMBER q7 = LOAD(q + 6*stride);
    const NUMBER q8 = LOAD(q + 7*stride);
    const NUMBER q9 = LOAD(q + 8*stride);
    const NUMBER q10 = LOAD(q + 9*stride);
    const NUMBER q11 = LOAD(q + 10*stride);
    const NUMBER q13 = LOAD(q + 11*stride);
    const NUMBER qd1 = LOAD(qd + 0*stride);
    const NUMBER qd2 = LOAD(qd + 1*stride);
    const NUMBER qd3 = LOAD(qd + 2*stride);
    const NUMBER qd4 = LOAD(qd + 3*stride);
    const NUMBER qd5 = LOAD(qd + 4*stride);
    const NUMBER qd6 = LOAD(qd + 5*stride);
    const NUMBER qd7 = LOAD(qd + 6*stride);
    const NUMBER qd8 = LOAD(qd + 7*stride);
    const NUMBER qd9 = LOAD(qd + 8*stride);
    const NUMBER qd10 = LOAD(qd + 9*stride);
    const NUMBER qd11 = LOAD(qd + 10*stride);
    const NUMBER qd13 = LOAD(qd + 11*stride);
    const NUMBER tau5 = LOAD(tau + 0*stride);
    const NUMBER tau9 = LOAD(tau + 1*stride);
    const double D4 = p[TWO_AXIS_P_D4];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Forward recursion: velocities, joint 1 (bed_yaw) [1], [3], [7], [14]. */
    const NUMBER sin_q1 = sine[0];
    const NUMBER cos_q1 = cosine[0];
    const NUMBER Vk1_1 = 9.81*sin_q1;
    const NUMBER Vk1_2 = 9.81*cos_q1;
    const NUMBER ww1_zz = qd1*qd1;

    /* Forward recursion: velocities, joint 2 (bed_y) [1], [3], [7], [14]. */
    const NUMBER g2_1a = 2.0*qd1;
    const NUMBER g2_1 = Vk1_1 - qd2*g2_1a;
    const NUMBER g2_3 = Vk1_2 - q2*ww1_zz;

    /* Forward recursion: velocities, joint 3 (bed_x) [1], [3], [7], [14]. */
    const NUMBER g3_3 = -q3*ww1_zz;
    const NUMBER g3_2 = -qd3*g2_1a;
    const NUMBER b3_1 = -500.0*ww1_zz;

    /* Forward recursion: velocities, joint 4 (motor_secondary) [1], [3], [7], [14]. */
    const NUMBER g4_3 = -q4*ww1_zz;
    const NUMBER g4_1 = qd4*g2_1a - D4*ww1_zz;

    /* Forward recursion: velocities, joint 5 (motor_x) [1], [3], [7], [14]. */
    const NUMBER g5_3 = -q5*ww1_zz;
    const NUMBER g5_1 = qd5*g2_1a;

    /* Forward recursion: velocities, joint 6 (cart_yaw) [1], [3], [7], [14]. */
    const NUMBER sin_q6 = sine[1];
    const NUMBER cos_q6 = cosine[1];
    const NUMBER w6_z = qd1 + qd6;
    const NUMBER ww6_zz = w6_z*w6_z;

    /* Forward recursion: velocities, joint 7 (cart_x) [1], [3], [7], [14]. */
    const NUMBER g7_3 = -q7*ww6_zz;
    const NUMBER g7_1a = 2.0*w6_z;
    const NUMBER g7_1 = qd7*g7_1a;

    /* Forward recursion: velocities, joint 8 (cart_y) [1], [3], [7], [14]. */
    const NUMBER g8_3 = -q8*ww6_zz;
    const NUMBER g8_2 = -qd8*g7_1a;
    const NUMBER b8_1 = 4.2*ww6_zz;
    const NUMBER b8_3 = 63.0*ww6_zz;

    /* Forward recursion: velocities, joint 9 (motor_y) [1], [3], [7], [14]. */
    const NUMBER g9_3 = -q9*ww6_zz;
    const NUMBER g9_1 = -qd9*g7_1a;

    /* Forward recursion: velocities, joint 10 (y_chain_1) [1], [3], [7], [14]. */
    const NUMBER g10_3 = -q10*ww6_zz;
    const NUMBER g10_1 = -qd10*g7_1a;

    /* Forward recursion: velocities, joint 11 (ram) [1], [3], [7], [14]. */
    const NUMBER g11_3 = -q11*ww6_zz;
    const NUMBER g11_1 = -qd11*g7_1a;
    const NUMBER b11_3 = -14.25*ww6_zz;

    /* Forward recursion: velocities, joint 13 (sensor_head) [1], [3], [7], [14]. */
    const NUMBER Js5_15 = 0.6*q13;
    const NUMBER b13_1 = (D13*ww1_zz - qd13*g2_1a)*0.6;
    const NUMBER b13_3 = Js5_15*ww1_zz;

    /* Backward recursion: articulated inertias and wrenches, joint 13 (sensor_head) [28]-[32]. */
    const NUMBER Gamma13 = -25000000.0*q13;
    const NUMBER Gb13 = Gamma13 + b13_3;
    const NUMBER qdf13 = 1.6666666666666667*Gb13;

    /* Backward recursion: articulated inertias and wrenches, joint 11 (ram) [28]-[32]. */
    const NUMBER Gamma11 = -250000000.0*q11;
    const NUMBER Gb11 = Gamma11 + b11_3;
    const NUMBER al11_1 = 95.0*g11_1;
    const NUMBER al11_5 = -14.25*g11_1;
    const NUMBER qdf11 = 0.010526315789473684*Gb11;

    /* Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [28]-[32]. */
    const NUMBER Gamma10 = -120000000.0*q10;
    const NUMBER Js10_15a = 95.0*q11;
    const NUMBER Js10_15 = Js10_15a - 14.25;
    const NUMBER Js10_55 = q11*(Js10_15a - 28.5) + 9.2375;
    const NUMBER Gb10 = Gamma10 - Gamma11;
    const NUMBER qdf10 = 0.125*Gb10;
    const NUMBER bs10_5 = -(al11_5 + q11*al11_1);
    const NUMBER al10_1 = al11_1 + 103.0*g10_1;
    const NUMBER al10_5 = Js10_15*g10_1 - bs10_5;

    /* Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [28]-[32]. */
    const NUMBER Js9_15 = Js10_15 + 103.0*q10;
    const NUMBER Js9_55 = Js10_55 + q10*(Js10_15 + Js9_15);
    const NUMBER Gb9 = tau9 - Gamma10;
    const NUMBER qdf9 = 0.005555555555555556*Gb9;
    const NUMBER bs9_5 = -(al10_5 + q10*al10_1);
    const NUMBER al9_1 = al10_1 + 103.0*g9_1;
    const NUMBER al9_5 = Js9_15*g9_1 - bs9_5;

    /* Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [28]-[32]. */
    const NUMBER Gamma8 = -500000000.0*q8;
    const NUMBER Js8_15a = Js9_15 + 103.0*q9;
    const NUMBER Js8_15 = Js8_15a + 63.0;
    const NUMBER K8_44 = Js9_55 + q9*(Js9_15 + Js8_15a) + 34.9;
    const NUMBER bs8_5 = -(al9_5 + q9*al9_1);
    const NUMBER bs8_1 = b8_1 - al9_1;
    const NUMBER bs8_3 = b8_3 - Gamma10;
    const NUMBER Gb8 = Gamma8 + bs8_3;
    const NUMBER qdf8 = 0.004761904761904762*Gb8;
    const NUMBER al8_2 = 313.0*g8_2 - bs8_1;
    const NUMBER al8_4 = bs8_5 + 0.02*Gb8 - Js8_15*g8_2;

    /* Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [28]-[32]. */
    const NUMBER Gamma7 = -350000000.0*q7;
    const NUMBER Js7_16 = Js8_15 + 313.0*q8;
    const NUMBER Js7_44 = K8_44 + q8*(Js8_15 + Js7_16);
    const NUMBER UH7_4 = -0.003194888178913738*Js7_16;
    const NUMBER K7_55 = Js7_44 + Js7_16*UH7_4;
    const NUMBER bs7_4 = q8*al8_2 - al8_4;
    const NUMBER Gb7 = Gamma7 - al8_2;
    const NUMBER qdf7 = 0.003194888178913738*Gb7;
    const NUMBER al7_5 = -(bs7_4 + Js7_16*qdf7);

    /* Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [28]-[32]. */
    const NUMBER Gamma6 = -11000000.0*q6;
    const NUMBER al6_1 = cos_q6*Gamma8 + sin_q6*Gamma7;
    const NUMBER al6_2 = sin_q6*Gamma8 - cos_q6*Gamma7;
    const NUMBER bs6_6 = -(q7*Gamma8 + al7_5);
    const NUMBER Gb6 = Gamma6 + bs6_6;
    const NUMBER qdf6 = Gb6/K7_55;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [28]-[32]. */
    const NUMBER Js5_55 = q13*Js5_15 + 3.001;
    const NUMBER bs5_3 = al6_2 - Gamma13;
    const NUMBER Gb5 = tau5 + bs5_3;
    const NUMBER qdf5 = 0.022222222222222223*Gb5;
    const NUMBER bs5_1 = b13_1 - al6_1;
    const NUMBER bs5_5 = D13*Gamma13 + q13*b13_1 - Gamma6;
    const NUMBER al5_1 = 45.6*g5_1 - bs5_1;
    const NUMBER al5_5 = Js5_15*g5_1 - bs5_5;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [28]-[32]. */
    const NUMBER Gamma4 = -600000000.0*q4;
    const NUMBER Js4_15 = Js5_15 + 45.6*q5;
    const NUMBER Js4_55 = Js5_55 + q5*(Js5_15 + Js4_15) + 12.0;
    const NUMBER Gb4 = Gamma4 - tau5;
    const NUMBER qdf4 = 0.011111111111111112*Gb4;
    const NUMBER bs4_5 = -(al5_5 + q5*al5_1);
    const NUMBER al4_1 = al5_1 + 135.6*g4_1;
    const NUMBER al4_5 = Js4_15*g4_1 - bs4_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [28]-[32]. */
    const NUMBER Gamma3 = -100000000.0*q3;
    const NUMBER Js3_15 = Js4_15 + 135.6*q4;
    const NUMBER K3_44 = Js4_55 + q4*(Js4_15 + Js3_15) + 1100.0;
    const NUMBER Gb3 = Gamma3 - Gamma4;
    const NUMBER qdf3 = 0.0004*Gb3;
    const NUMBER bs3_5 = D4*Gamma4 - (al4_5 + q4*al4_1);
    const NUMBER bs3_1 = b3_1 - al4_1;
    const NUMBER al3_2 = bs3_1 + 2635.6*g3_2;
    const NUMBER al3_4 = -(Js3_15*g3_2 + bs3_5 - 0.2*Gb3);

    /* Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [28]-[32]. */
    const NUMBER Gamma2 = -150000000.0*q2;
    const NUMBER Js2_34 = Js3_15 + 2635.6*q3;
    const NUMBER Js2_44 = K3_44 + q3*(Js3_15 + Js2_34);
    const NUMBER UH2_4 = 0.0003794202458643193*Js2_34;
    const NUMBER K2_55 = Js2_44 - Js2_34*UH2_4;
    const NUMBER bs2_4 = q3*al3_2 - al3_4;
    const NUMBER Gb2 = Gamma2 + al3_2;
    const NUMBER qdf2 = 0.0003794202458643193*Gb2;
    const NUMBER al2_5 = bs2_4 - Js2_34*qdf2;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [28]-[32]. */
    const NUMBER Gamma1 = -40000000.0*q1;
    const NUMBER bs1_6 = q2*Gamma3 + al2_5;
    const NUMBER Gb1 = Gamma1 + bs1_6;
    const NUMBER qdf1 = Gb1/K2_55;

    /* Forward recursion: accelerations and torques, joint 2 (bed_y) [33]-[36]. */
    const NUMBER vd2_y = g2_1 - q2*qdf1;
    const NUMBER vd2_z = qdf2 - UH2_4*qdf1;
    const NUMBER qdd2 = vd2_z - g2_3;

    /* Forward recursion: accelerations and torques, joint 3 (bed_x) [33]-[36]. */
    const NUMBER vd3_x = vd2_z + q3*qdf1 - g3_2;
    const NUMBER vd3_z = qdf3 - 0.2*qdf1;
    const NUMBER qdd3 = vd3_z - (g3_3 + vd2_y);

    /* Forward recursion: accelerations and torques, joint 4 (motor_secondary) [33]-[36]. */
    const NUMBER vd4_x = g4_1 + vd3_x + q4*qdf1;
    const NUMBER qdd4 = qdf4 + D4*qdf1 - vd3_z - g4_3;

    /* Forward recursion: accelerations and torques, joint 5 (motor_x) [33]-[36]. */
    const NUMBER qdd5 = qdf5 - (qdf4 + g5_3);
    const NUMBER vd5_x = g5_1 + vd4_x + q5*qdf1;

    /* Forward recursion: accelerations and torques, joint 6 (cart_yaw) [33]-[36]. */
    const NUMBER vd6_x = cos_q6*vd5_x - sin_q6*qdf5;
    const NUMBER vd6_y = -(cos_q6*qdf5 + sin_q6*vd5_x);
    const NUMBER qdd6 = qdf6 - qdf1;

    /* Forward recursion: accelerations and torques, joint 7 (cart_x) [33]-[36]. */
    const NUMBER vd7_y = -(g7_1 + vd6_x + q7*qdf6);
    const NUMBER vd7_z = qdf7 - UH7_4*qdf6;
    const NUMBER qdd7 = vd6_y - g7_3 + vd7_z;

    /* Forward recursion: accelerations and torques, joint 8 (cart_y) [33]-[36]. */
    const NUMBER vd8_z = qdf8 - 0.02*qdf6;
    const NUMBER qdd8 = vd7_y - g8_3 + vd8_z;

    /* Forward recursion: accelerations and torques, joint 9 (motor_y) [33]-[36]. */
    const NUMBER vd9_z = qdf9 + g9_3 + vd8_z;

    /* Forward recursion: accelerations and torques, joint 10 (y_chain_1) [33]-[36]. */
    const NUMBER qdd10 = qdf10 - (g10_3 + vd9_z);

    /* Forward recursion: accelerations and torques, joint 11 (ram) [33]-[36]. */
    const NUMBER qdd11 = qdf11 - (qdf10 + g11_3);

    /* Forward recursion: accelerations and torques, joint 13 (sensor_head) [33]-[36]. */
    const NUMBER qdd13 = qdf13 - (qdf5 - D13*qdf1);

    /* Results. */
    STORE(qdd + 0*stride, qdf1);
    STORE(qdd + 1*stride, qdd2);
    STORE(qdd + 2*stride, qdd3);
    STORE(qdd + 3*stride, qdd4);
    STORE(qdd + 4*stride, qdd5);
    STORE(qdd + 5*stride, qdd6);
    STORE(qdd + 6*stride, qdd7);
    STORE(qdd + 7*stride, qdd8);
    STORE(qdd + 8*stride, qdf9);
    STORE(qdd + 9*stride, qdd10);
    STORE(qdd + 10*stride, qdd11);
    STORE(qdd + 11*stride, qdd13);
}

WHOLE void OF(two_axis_direct_dynamics_at)(size_t stride, const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    ANGLE angle[2];
    ANGLE sine[2];
    ANGLE cosine[2];
    OF(two_axis_direct_dynamics_angles)(stride, q, angle);
    if (OF(circles)(2, angle, sine, cosine)) {
        ANGLE far[2]; /* a copy, so that the angles themselves stay in registers */
        for (size_t k = 0; k < 2; k++)
            far[k] = angle[k];
        far_circles(2*(sizeof(ANGLE)/sizeof(double)), (const double *)far, (double *)sine, (double *)cosine);
    }
    OF(two_axis_direct_dynamics_state)(stride, q, qd, tau, p, sine, cosine, qdd);
}

INLINE void OF(two_axis_inverse_dynamics_angles)(size_t stride, const double *restrict q, ANGLE *restrict angle)
{
    (void)stride;
    const ANGLE q1 = LOAD(q + 0*stride);
    const ANGLE q6 = LOAD(q + 5*stride);
    angle[0] = q1;
    angle[1] = q6;
}

INLINE void OF(two_axis_inverse_dynamics_state)(size_t stride, const double *restrict q, const double *restrict qd, const double *restrict qdd_motor, const double *restrict p, const ANGLE *restrict sine, const ANGLE *restrict cosine, double *restrict tau, double *restrict qdd)
{
    (void)stride;
    const NUMBER q1 = LOAD(q + 0*stride);
    const NUMBER q2 = LOAD(q + 1*stride);
    const NUMBER q3 = LOAD(q + 2*stride);
    const NUMBER q4 = LOAD(q + 3*stride);
    const NUMBER q5 = LOAD(q + 4*stride);
    const NUMBER q6 = LOAD(q + 5*stride);
    const NUMBER q7 = LOAD(q + 6*stride);
    const NUMBER q8 = LOAD(q + 7*stride);
    const NUMBER q9 = LOAD(q + 8*stride);
    const NUMBER q10 = LOAD(q + 9*stride);
    const NUMBER q11 = LOAD(q + 10*stride);
    const NUMBER q13 = LOAD(q + 11*stride);
    const NUMBER qd1 = LOAD(qd + 0*stride);
    const NUMBER qd2 = LOAD(qd + 1*stride);
    const NUMBER qd3 = LOAD(qd + 2*stride);
    const NUMBER qd4 = LOAD(qd + 3*stride);
    const NUMBER qd5 = LOAD(qd + 4*stride);
    const NUMBER qd6 = LOAD(qd + 5*stride);
    const NUMBER qd7 = LOAD(qd + 6*stride);
    const NUMBER qd8 = LOAD(qd + 7*stride);
    const NUMBER qd9 = LOAD(qd + 8*stride);
    const NUMBER qd10 = LOAD(qd + 9*stride);
    const NUMBER qd11 = LOAD(qd + 10*stride);
    const NUMBER qd13 = LOAD(qd + 11*stride);
    const NUMBER qdd5 = LOAD(qdd_motor + 0*stride);
    const NUMBER qdd9 = LOAD(qdd_motor + 1*stride);
    const double D4 = p[TWO_AXIS_P_D4];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Forward recursion: velocities, joint 1 (bed_yaw) [1], [3], [7], [14]. */
    const NUMBER sin_q1 = sine[0];
    const NUMBER cos_q1 = cosine[0];
    const NUMBER Vk1_1 = 9.81*sin_q1;
    const NUMBER Vk1_2 = 9.81*cos_q1;
    const NUMBER ww1_zz = qd1*qd1;

    /* Forward recursion: velocities, joint 2 (bed_y) [1], [3], [7], [14]. */
    const NUMBER g2_1a = 2.0*qd1;
    const NUMBER g2_1 = Vk1_1 - qd2*g2_1a;
    const NUMBER g2_3 = Vk1_2 - q2*ww1_zz;

    /* Forward recursion: velocities, joint 3 (bed_x) [1], [3], [7], [14]. */
    const NUMBER g3_3 = -q3*ww1_zz;
    const NUMBER g3_2 = -qd3*g2_1a;
    const NUMBER b3_1 = -500.0*ww1_zz;

    /* Forward recursion: velocities, joint 4 (motor_secondary) [1], [3], [7], [14]. */
    const NUMBER g4_3 = -q4*ww1_zz;
    const NUMBER g4_1 = qd4*g2_1a - D4*ww1_zz;

    /* Forward recursion: velocities, joint 5 (motor_x) [1], [3], [7], [14]. */
    const NUMBER g5_3 = -q5*ww1_zz;
    const NUMBER g5_1 = qd5*g2_1a;

    /* Forward recursion: velocities, joint 6 (cart_yaw) [1], [3], [7], [14]. */
    const NUMBER sin_q6 = sine[1];
    const NUMBER cos_q6 = cosine[1];
    const NUMBER w6_z = qd1 + qd6;
    const NUMBER ww6_zz = w6_z*w6_z;

    /* Forward recursion: velocities, joint 7 (cart_x) [1], [3], [7], [14]. */
    const NUMBER g7_3 = -q7*ww6_zz;
    const NUMBER g7_1a = 2.0*w6_z;
    const NUMBER g7_1 = qd7*g7_1a;

    /* Forward recursion: velocities, joint 8 (cart_y) [1], [3], [7], [14]. */
    const NUMBER g8_3 = -q8*ww6_zz;
    const NUMBER g8_2 = -qd8*g7_1a;
    const NUMBER b8_1 = 4.2*ww6_zz;
    const NUMBER b8_3 = 63.0*ww6_zz;

    /* Forward recursion: velocities, joint 9 (motor_y) [1], [3], [7], [14]. */
    const NUMBER g9_3 = -q9*ww6_zz;
    const NUMBER g9_1 = -qd9*g7_1a;

    /* Forward recursion: velocities, joint 10 (y_chain_1) [1], [3], [7], [14]. */
    const NUMBER g10_3 = -q10*ww6_zz;
    const NUMBER g10_1 = -qd10*g7_1a;

    /* Forward recursion: velocities, joint 11 (ram) [1], [3], [7], [14]. */
    const NUMBER g11_3 = -q11*ww6_zz;
    const NUMBER g11_1 = -qd11*g7_1a;
    const NUMBER b11_3 = -14.25*ww6_zz;

    /* Forward recursion: velocities, joint 13 (sensor_head) [1], [3], [7], [14]. */
    const NUMBER Js5_15 = 0.6*q13;
    const NUMBER b13_1 = (D13*ww1_zz - qd13*g2_1a)*0.6;
    const NUMBER b13_3 = Js5_15*ww1_zz;

    /* Backward recursion: articulated inertias and wrenches, joint 13 (sensor_head) [50]-[56]. */
    const NUMBER Gamma13 = -25000000.0*q13;
    const NUMBER Gb13 = Gamma13 + b13_3;
    const NUMBER qdf13 = 1.6666666666666667*Gb13;

    /* Backward recursion: articulated inertias and wrenches, joint 11 (ram) [50]-[56]. */
    const NUMBER Gamma11 = -250000000.0*q11;
    const NUMBER Gb11 = Gamma11 + b11_3;
    const NUMBER al11_1 = 95.0*g11_1;
    const NUMBER al11_5 = -14.25*g11_1;
    const NUMBER qdf11 = 0.010526315789473684*Gb11;

    /* Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [50]-[56]. */
    const NUMBER Gamma10 = -120000000.0*q10;
    const NUMBER Js10_15a = 95.0*q11;
    const NUMBER Js10_15 = Js10_15a - 14.25;
    const NUMBER Js10_55 = q11*(Js10_15a - 28.5) + 9.2375;
    const NUMBER Gb10 = Gamma10 - Gamma11;
    const NUMBER qdf10 = 0.125*Gb10;
    const NUMBER bs10_5 = -(al11_5 + q11*al11_1);
    const NUMBER al10_1 = al11_1 + 103.0*g10_1;
    const NUMBER al10_5 = Js10_15*g10_1 - bs10_5;

    /* Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [50]-[56]. */
    const NUMBER Js9_15 = Js10_15 + 103.0*q10;
    const NUMBER Js9_55 = Js10_55 + q10*(Js10_15 + Js9_15);
    const NUMBER bs9_5 = -(al10_5 + q10*al10_1);
    const NUMBER al9_1 = al10_1 + 103.0*g9_1;
    const NUMBER al9_5 = Js9_15*g9_1 - bs9_5;

    /* Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [50]-[56]. */
    const NUMBER Gamma8 = -500000000.0*q8;
    const NUMBER Js8_15a = Js9_15 + 103.0*q9;
    const NUMBER Js8_15 = Js8_15a + 63.0;
    const NUMBER K8_44 = Js9_55 + q9*(Js9_15 + Js8_15a) + 34.9;
    const NUMBER bs8_5 = -(al9_5 + q9*al9_1);
    const NUMBER bs8_1 = b8_1 - al9_1;
    const NUMBER bs8_3 = b8_3 - Gamma10;
    const NUMBER Gb8 = Gamma8 + bs8_3;
    const NUMBER qdf8 = 0.004761904761904762*Gb8;
    const NUMBER al8_2 = 313.0*g8_2 - bs8_1;
    const NUMBER al8_4 = bs8_5 + 0.02*Gb8 - Js8_15*g8_2;

    /* Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [50]-[56]. */
    const NUMBER Gamma7 = -350000000.0*q7;
    const NUMBER Js7_16 = Js8_15 + 313.0*q8;
    const NUMBER Js7_44 = K8_44 + q8*(Js8_15 + Js7_16);
    const NUMBER UH7_4 = -0.003194888178913738*Js7_16;
    const NUMBER K7_55 = Js7_44 + Js7_16*UH7_4;
    const NUMBER bs7_4 = q8*al8_2 - al8_4;
    const NUMBER Gb7 = Gamma7 - al8_2;
    const NUMBER qdf7 = 0.003194888178913738*Gb7;
    const NUMBER al7_5 = -(bs7_4 + Js7_16*qdf7);

    /* Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [50]-[56]. */
    const NUMBER Gamma6 = -11000000.0*q6;
    const NUMBER al6_1 = cos_q6*Gamma8 + sin_q6*Gamma7;
    const NUMBER al6_2 = sin_q6*Gamma8 - cos_q6*Gamma7;
    const NUMBER bs6_6 = -(q7*Gamma8 + al7_5);
    const NUMBER Gb6 = Gamma6 + bs6_6;
    const NUMBER qdf6 = Gb6/K7_55;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [50]-[56]. */
    const NUMBER Js5_55 = q13*Js5_15 + 3.001;
    const NUMBER bs5_3 = al6_2 - Gamma13;
    const NUMBER bs5_1 = b13_1 - al6_1;
    const NUMBER bs5_5 = D13*Gamma13 + q13*b13_1 - Gamma6;
    const NUMBER al5_1 = 45.6*g5_1 - bs5_1;
    const NUMBER al5_5 = Js5_15*g5_1 - bs5_5;
    const NUMBER al5_3 = (qdd5 + g5_3)*45.0 - bs5_3;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [50]-[56]. */
    const NUMBER Gamma4 = -600000000.0*q4;
    const NUMBER Js4_15 = Js5_15 + 45.6*q5;
    const NUMBER Js4_55 = Js5_55 + q5*(Js5_15 + Js4_15) + 12.0;
    const NUMBER bs4_5 = -(al5_5 + q5*al5_1);
    const NUMBER al4_1 = al5_1 + 135.6*g4_1;
    const NUMBER al4_5 = Js4_15*g4_1 - bs4_5;
    const NUMBER Gb4 = Gamma4 - al5_3;
    const NUMBER qdf4 = 0.007407407407407408*Gb4;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [50]-[56]. */
    const NUMBER Gamma3 = -100000000.0*q3;
    const NUMBER Js3_15 = Js4_15 + 135.6*q4;
    const NUMBER K3_44 = Js4_55 + q4*(Js4_15 + Js3_15) + 1100.0;
    const NUMBER Gb3 = Gamma3 - Gamma4;
    const NUMBER qdf3 = 0.0004*Gb3;
    const NUMBER bs3_5 = D4*Gamma4 - (al4_5 + q4*al4_1);
    const NUMBER bs3_1 = b3_1 - al4_1;
    const NUMBER al3_2 = bs3_1 + 2635.6*g3_2;
    const NUMBER al3_4 = -(Js3_15*g3_2 + bs3_5 - 0.2*Gb3);

    /* Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [50]-[56]. */
    const NUMBER Gamma2 = -150000000.0*q2;
    const NUMBER Js2_34 = Js3_15 + 2635.6*q3;
    const NUMBER Js2_44 = K3_44 + q3*(Js3_15 + Js2_34);
    const NUMBER UH2_4 = 0.0003794202458643193*Js2_34;
    const NUMBER K2_55 = Js2_44 - Js2_34*UH2_4;
    const NUMBER bs2_4 = q3*al3_2 - al3_4;
    const NUMBER Gb2 = Gamma2 + al3_2;
    const NUMBER qdf2 = 0.0003794202458643193*Gb2;
    const NUMBER al2_5 = bs2_4 - Js2_34*qdf2;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [50]-[56]. */
    const NUMBER Gamma1 = -40000000.0*q1;
    const NUMBER bs1_6 = q2*Gamma3 + al2_5;
    const NUMBER Gb1 = Gamma1 + bs1_6;
    const NUMBER qdf1 = Gb1/K2_55;

    /* Forward recursion: accelerations and torques, joint 2 (bed_y) [57]-[61]. */
    const NUMBER vd2_y = g2_1 - q2*qdf1;
    const NUMBER vd2_z = qdf2 - UH2_4*qdf1;
    const NUMBER qdd2 = vd2_z - g2_3;

    /* Forward recursion: accelerations and torques, joint 3 (bed_x) [57]-[61]. */
    const NUMBER vd3_x = vd2_z + q3*qdf1 - g3_2;
    const NUMBER vd3_z = qdf3 - 0.2*qdf1;
    const NUMBER qdd3 = vd3_z - (g3_3 + vd2_y);

    /* Forward recursion: accelerations and torques, joint 4 (motor_secondary) [57]-[61]. */
    const NUMBER vd4_x = g4_1 + vd3_x + q4*qdf1;
    const NUMBER qdd4 = D4*qdf1 - vd3_z - g4_3 + qdf4;

    /* Forward recursion: accelerations and torques, joint 5 (motor_x) [57]-[61]. */
    const NUMBER vd5_x = g5_1 + vd4_x + q5*qdf1;
    const NUMBER f5_3 = al5_3 + 0.3333333333333333*Gb4;
    const NUMBER vd5_z = qdd5 + g5_3 + qdf4;

    /* Forward recursion: accelerations and torques, joint 6 (cart_yaw) [57]-[61]. */
    const NUMBER qdd6 = qdf6 - qdf1;
    const NUMBER vd6_x = cos_q6*vd5_x - sin_q6*vd5_z;
    const NUMBER vd6_y = -(sin_q6*vd5_x + cos_q6*vd5_z);

    /* Forward recursion: accelerations and torques, joint 7 (cart_x) [57]-[61]. */
    const NUMBER vd7_z = qdf7 - UH7_4*qdf6;
    const NUMBER vd7_y = -(g7_1 + q7*qdf6 + vd6_x);
    const NUMBER qdd7 = vd7_z + vd6_y - g7_3;

    /* Forward recursion: accelerations and torques, joint 8 (cart_y) [57]-[61]. */
    const NUMBER vd8_z = qdf8 - 0.02*qdf6;
    const NUMBER qdd8 = vd8_z + vd7_y - g8_3;

    /* Forward recursion: accelerations and torques, joint 9 (motor_y) [57]-[61]. */
    const NUMBER Gamma9 = Gamma10 + 180.0*qdd9;
    const NUMBER vd9_z = qdd9 + g9_3 + vd8_z;

    /* Forward recursion: accelerations and torques, joint 10 (y_chain_1) [57]-[61]. */
    const NUMBER qdd10 = qdf10 - (g10_3 + vd9_z);

    /* Forward recursion: accelerations and torques, joint 11 (ram) [57]-[61]. */
    const NUMBER qdd11 = qdf11 - (qdf10 + g11_3);

    /* Forward recursion: accelerations and torques, joint 13 (sensor_head) [57]-[61]. */
    const NUMBER qdd13 = qdf13 - (vd5_z - D13*qdf1);

    /* Results. */
    STORE(tau + 0*stride, f5_3);
    STORE(tau + 1*stride, Gamma9);
    STORE(qdd + 0*stride, qdf1);
    STORE(qdd + 1*stride, qdd2);
    STORE(qdd + 2*stride, qdd3);
    STORE(qdd + 3*stride, qdd4);
    STORE(qdd + 4*stride, qdd5);
    STORE(qdd + 5*stride, qdd6);
    STORE(qdd + 6*stride, qdd7);
    STORE(qdd + 7*stride, qdd8);
    STORE(qdd + 8*stride, qdd9);
    STORE(qdd + 9*stride, qdd10);
    STORE(qdd + 10*stride, qdd11);
    STORE(qdd + 11*stride, qdd13);
}

WHOLE void OF(two_axis_inverse_dynamics_at)(size_t stride, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    ANGLE angle[2];
    ANGLE sine[2];
    ANGLE cosine[2];
    OF(two_axis_inverse_dynamics_angles)(stride, q, angle);
    if (OF(circles)(2, angle, sine, cosine)) {
        ANGLE far[2]; /* a copy, so that the angles themselves stay in registers */
        for (size_t k = 0; k < 2; k++)
            far[k] = angle[k];
        far_circles(2*(sizeof(ANGLE)/sizeof(double)), (const double *)far, (double *)sine, (double *)cosine);
    }
    OF(two_axis_inverse_dynamics_state)(stride, q, qd, qdd_motor, p, sine, cosine, tau, qdd);
}

#endif
