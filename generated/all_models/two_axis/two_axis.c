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

#define EQUATIONS 1405933682
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

void two_axis_inertia_matrix_prepared(const double *q, const double *p, const double *c, double *A)
{
    two_axis_inertia_matrix_at(1, q, p, c, A);
}

void two_axis_inertia_matrix(const double *q, const double *p, double *A)
{
    double c[TWO_AXIS_INERTIA_MATRIX_CONSTANTS];
    two_axis_inertia_matrix_prepare(p, c);
    two_axis_inertia_matrix_prepared(q, p, c, A);
}

void two_axis_inertia_matrix_batch(size_t states, const double *q, const double *p, double *A)
{
    double c[TWO_AXIS_INERTIA_MATRIX_CONSTANTS];
    two_axis_inertia_matrix_prepare(p, c);
    size_t first = 0;
    for (; states < WIDTH && first < states; first++)
        two_axis_inertia_matrix_at(states, q + first, p, c, A + first);
    for (; first < states; first += WIDTH) {
        if (first + WIDTH > states)
            first = states - WIDTH; /* The last ones overlap with those before. */
        LANES(two_axis_inertia_matrix_at)(states, q + first, p, c, A + first);
    }
}

void two_axis_bias_forces(const double *q, const double *qd, const double *p, double *H)
{
    two_axis_bias_forces_at(1, q, qd, p, H);
}

void two_axis_bias_forces_batch(size_t states, const double *q, const double *qd, const double *p, double *H)
{
    size_t first = 0;
    for (; states < WIDTH && first < states; first++)
        two_axis_bias_forces_at(states, q + first, qd + first, p, H + first);
    for (; first < states; first += WIDTH) {
        if (first + WIDTH > states)
            first = states - WIDTH; /* The last ones overlap with those before. */
        LANES(two_axis_bias_forces_at)(states, q + first, qd + first, p, H + first);
    }
}

void two_axis_geometric_model(const double *q, const double *p, double *T)
{
    two_axis_geometric_model_at(1, q, p, T);
}

void two_axis_geometric_model_batch(size_t states, const double *q, const double *p, double *T)
{
    size_t first = 0;
    for (; states < WIDTH && first < states; first++)
        two_axis_geometric_model_at(states, q + first, p, T + first);
    for (; first < states; first += WIDTH) {
        if (first + WIDTH > states)
            first = states - WIDTH; /* The last ones overlap with those before. */
        LANES(two_axis_geometric_model_at)(states, q + first, p, T + first);
    }
}

#else /* The equations. */
#if EQUATIONS != 1405933682
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

INLINE void OF(two_axis_inertia_matrix_angles)(size_t stride, const double *restrict q, ANGLE *restrict angle)
{
    (void)stride;
    const ANGLE q6 = LOAD(q + 5*stride);
    angle[0] = q6;
}

INLINE void OF(two_axis_inertia_matrix_state)(size_t stride, const double *restrict q, const double *restrict p, const double *restrict c, const ANGLE *restrict sine, const ANGLE *restrict cosine, double *restrict A)
{
    (void)stride;
    const NUMBER q2 = LOAD(q + 1*stride);
    const NUMBER q3 = LOAD(q + 2*stride);
    const NUMBER q4 = LOAD(q + 3*stride);
    const NUMBER q5 = LOAD(q + 4*stride);
    const NUMBER q7 = LOAD(q + 6*stride);
    const NUMBER q8 = LOAD(q + 7*stride);
    const NUMBER q9 = LOAD(q + 8*stride);
    const NUMBER q10 = LOAD(q + 9*stride);
    const NUMBER q11 = LOAD(q + 10*stride);
    const NUMBER q13 = LOAD(q + 11*stride);
    const double D4 = p[TWO_AXIS_P_D4];
    const double A1_13a = c[0];
    const double J5_cyyb = c[1];
    const double A1_4a = c[2];

    /* Geometry, joint 6 (cart_yaw) [1]. */
    const NUMBER sin_q6 = sine[0];
    const NUMBER cos_q6 = cosine[0];

    /* Composite inertias and inertia matrix, joint 13 (sensor_head) [8], [13]. */
    const NUMBER A1_13b = D4 + q2;
    const NUMBER A1_13 = -(A1_13a + 0.6*A1_13b);

    /* Composite inertias and inertia matrix, joint 11 (ram) [8], [13]. */
    const NUMBER A6_11 = 95.0*q7;
    const NUMBER A2_11 = 95.0*cos_q6;
    const NUMBER A3_11 = -95.0*sin_q6;
    const NUMBER A1_11a = q3 + q4 + q5;
    const NUMBER A1_11 = A6_11 - D4*A3_11 - q2*A3_11 + A2_11*A1_11a;

    /* Composite inertias and inertia matrix, joint 10 (y_chain_1) [8], [13]. */
    const NUMBER MS10_c_za = 95.0*q11;
    const NUMBER MS10_c_z = MS10_c_za - 14.25;
    const NUMBER J10_cyy = q11*(MS10_c_za - 28.5) + 9.2375;
    const NUMBER A6_10 = 103.0*q7;
    const NUMBER A2_10 = 103.0*cos_q6;
    const NUMBER A3_10 = -103.0*sin_q6;
    const NUMBER A1_10 = A6_10 - D4*A3_10 - q2*A3_10 + A2_10*A1_11a;

    /* Composite inertias and inertia matrix, joint 9 (motor_y) [8], [13]. */
    const NUMBER MS9_c_z = MS10_c_z + 103.0*q10;
    const NUMBER J9_cyy = J10_cyy + q10*(MS10_c_z + MS9_c_z);

    /* Composite inertias and inertia matrix, joint 8 (cart_y) [8], [13]. */
    const NUMBER J8_cyya = MS9_c_z + 103.0*q9;
    const NUMBER J8_cyy = J9_cyy + q9*(MS9_c_z + J8_cyya) + 34.984;
    const NUMBER MS8_c_z = J8_cyya + 63.0;
    const NUMBER A6_8a = 313.0*q7;
    const NUMBER A6_8 = A6_8a + 4.2;
    const NUMBER A2_8 = 313.0*cos_q6;
    const NUMBER A3_8 = -313.0*sin_q6;
    const NUMBER A1_8 = A6_8 - D4*A3_8 - q2*A3_8 + A2_8*A1_11a;

    /* Composite inertias and inertia matrix, joint 7 (cart_x) [8], [13]. */
    const NUMBER MS7_c_y = -(MS8_c_z + 313.0*q8);
    const NUMBER J7_cxx = J8_cyy + q8*(MS8_c_z - MS7_c_y);
    const NUMBER A1_7 = -(q2*A2_8 + D4*A2_8 - MS7_c_y + A3_8*A1_11a);

    /* Composite inertias and inertia matrix, joint 6 (cart_yaw) [8], [13]. */
    const NUMBER J6_czz = J7_cxx + q7*(A6_8a + 8.4);
    const NUMBER A3_6 = cos_q6*MS7_c_y - sin_q6*A6_8;
    const NUMBER A2_6 = sin_q6*MS7_c_y + cos_q6*A6_8;
    const NUMBER A1_6 = J6_czz - D4*A3_6 - q2*A3_6 + A2_6*A1_11a;

    /* Composite inertias and inertia matrix, joint 5 (motor_x) [8], [13]. */
    const NUMBER J5_cyya = 0.6*q13;
    const NUMBER J5_cyy = q13*J5_cyya + 0.001 + J5_cyyb + 3.0 + J6_czz;
    const NUMBER MS5_c_x = A1_13a - A3_6;
    const NUMBER MS5_c_z = J5_cyya + A2_6;
    const NUMBER A1_5 = -(MS5_c_x + 358.6*A1_13b);

    /* Composite inertias and inertia matrix, joint 4 (motor_secondary) [8], [13]. */
    const NUMBER MS4_c_z = MS5_c_z + 358.6*q5;
    const NUMBER J4_cyy = J5_cyy + q5*(MS5_c_z + MS4_c_z) + 12.0;
    const NUMBER A1_4b = MS5_c_x + A1_4a;
    const NUMBER A1_4 = -(A1_4b + 448.6*q2);

    /* Composite inertias and inertia matrix, joint 3 (bed_x) [8], [13]. */
    const NUMBER MS3_c_z = MS4_c_z + 448.6*q4;
    const NUMBER J3_cyy = J4_cyy + q4*(MS4_c_z + MS3_c_z) + D4*(MS5_c_x + A1_4b) + 1200.0;
    const NUMBER MS3_c_x = A1_4b - 500.0;
    const NUMBER A1_3 = -(MS3_c_x + 2948.6*q2);

    /* Composite inertias and inertia matrix, joint 2 (bed_y) [8], [13]. */
    const NUMBER MS2_c_y = MS3_c_z + 2948.6*q3;
    const NUMBER J2_cxx = J3_cyy + q3*(MS3_c_z + MS2_c_y);

    /* Composite inertias and inertia matrix, joint 1 (bed_yaw) [8], [13]. */
    const NUMBER J1_czz = J2_cxx + q2*(MS3_c_x - A1_3);

    /* Results. */
    STORE(A + 0*stride, J1_czz);
    STORE(A + 1*stride, MS2_c_y);
    STORE(A + 2*stride, A1_3);
    STORE(A + 3*stride, A1_4);
    STORE(A + 4*stride, A1_5);
    STORE(A + 5*stride, A1_6);
    STORE(A + 6*stride, A1_7);
    STORE(A + 7*stride, A1_8);
    STORE(A + 8*stride, A1_10);
    STORE(A + 9*stride, A1_10);
    STORE(A + 10*stride, A1_11);
    STORE(A + 11*stride, A1_13);
    STORE(A + 12*stride, MS2_c_y);
    STORE(A + 13*stride, 2948.6);
    STORE(A + 14*stride, 0.0);
    STORE(A + 15*stride, 0.0);
    STORE(A + 16*stride, 0.0);
    STORE(A + 17*stride, A2_6);
    STORE(A + 18*stride, -A3_8);
    STORE(A + 19*stride, A2_8);
    STORE(A + 20*stride, A2_10);
    STORE(A + 21*stride, A2_10);
    STORE(A + 22*stride, A2_11);
    STORE(A + 23*stride, 0.0);
    STORE(A + 24*stride, A1_3);
    STORE(A + 25*stride, 0.0);
    STORE(A + 26*stride, 2948.6);
    STORE(A + 27*stride, 448.6);
    STORE(A + 28*stride, 358.6);
    STORE(A + 29*stride, A3_6);
    STORE(A + 30*stride, A2_8);
    STORE(A + 31*stride, A3_8);
    STORE(A + 32*stride, A3_10);
    STORE(A + 33*stride, A3_10);
    STORE(A + 34*stride, A3_11);
    STORE(A + 35*stride, 0.6);
    STORE(A + 36*stride, A1_4);
    STORE(A + 37*stride, 0.0);
    STORE(A + 38*stride, 448.6);
    STORE(A + 39*stride, 448.6);
    STORE(A + 40*stride, 358.6);
    STORE(A + 41*stride, A3_6);
    STORE(A + 42*stride, A2_8);
    STORE(A + 43*stride, A3_8);
    STORE(A + 44*stride, A3_10);
    STORE(A + 45*stride, A3_10);
    STORE(A + 46*stride, A3_11);
    STORE(A + 47*stride, 0.6);
    STORE(A + 48*stride, A1_5);
    STORE(A + 49*stride, 0.0);
    STORE(A + 50*stride, 358.6);
    STORE(A + 51*stride, 358.6);
    STORE(A + 52*stride, 358.6);
    STORE(A + 53*stride, A3_6);
    STORE(A + 54*stride, A2_8);
    STORE(A + 55*stride, A3_8);
    STORE(A + 56*stride, A3_10);
    STORE(A + 57*stride, A3_10);
    STORE(A + 58*stride, A3_11);
    STORE(A + 59*stride, 0.6);
    STORE(A + 60*stride, A1_6);
    STORE(A + 61*stride, A2_6);
    STORE(A + 62*stride, A3_6);
    STORE(A + 63*stride, A3_6);
    STORE(A + 64*stride, A3_6);
    STORE(A + 65*stride, J6_czz);
    STORE(A + 66*stride, MS7_c_y);
    STORE(A + 67*stride, A6_8);
    STORE(A + 68*stride, A6_10);
    STORE(A + 69*stride, A6_10);
    STORE(A + 70*stride, A6_11);
    STORE(A + 71*stride, 0.0);
    STORE(A + 72*stride, A1_7);
    STORE(A + 73*stride, -A3_8);
    STORE(A + 74*stride, A2_8);
    STORE(A + 75*stride, A2_8);
    STORE(A + 76*stride, A2_8);
    STORE(A + 77*stride, MS7_c_y);
    STORE(A + 78*stride, 313.0);
    STORE(A + 79*stride, 0.0);
    STORE(A + 80*stride, 0.0);
    STORE(A + 81*stride, 0.0);
    STORE(A + 82*stride, 0.0);
    STORE(A + 83*stride, 0.0);
    STORE(A + 84*stride, A1_8);
    STORE(A + 85*stride, A2_8);
    STORE(A + 86*stride, A3_8);
    STORE(A + 87*stride, A3_8);
    STORE(A + 88*stride, A3_8);
    STORE(A + 89*stride, A6_8);
    STORE(A + 90*stride, 0.0);
    STORE(A + 91*stride, 313.0);
    STORE(A + 92*stride, 103.0);
    STORE(A + 93*stride, 103.0);
    STORE(A + 94*stride, 95.0);
    STORE(A + 95*stride, 0.0);
    STORE(A + 96*stride, A1_10);
    STORE(A + 97*stride, A2_10);
    STORE(A + 98*stride, A3_10);
    STORE(A + 99*stride, A3_10);
    STORE(A + 100*stride, A3_10);
    STORE(A + 101*stride, A6_10);
    STORE(A + 102*stride, 0.0);
    STORE(A + 103*stride, 103.0);
    STORE(A + 104*stride, 283.0);
    STORE(A + 105*stride, 103.0);
    STORE(A + 106*stride, 95.0);
    STORE(A + 107*stride, 0.0);
    STORE(A + 108*stride, A1_10);
    STORE(A + 109*stride, A2_10);
    STORE(A + 110*stride, A3_10);
    STORE(A + 111*stride, A3_10);
    STORE(A + 112*stride, A3_10);
    STORE(A + 113*stride, A6_10);
    STORE(A + 114*stride, 0.0);
    STORE(A + 115*stride, 103.0);
    STORE(A + 116*stride, 103.0);
    STORE(A + 117*stride, 103.0);
    STORE(A + 118*stride, 95.0);
    STORE(A + 119*stride, 0.0);
    STORE(A + 120*stride, A1_11);
    STORE(A + 121*stride, A2_11);
    STORE(A + 122*stride, A3_11);
    STORE(A + 123*stride, A3_11);
    STORE(A + 124*stride, A3_11);
    STORE(A + 125*stride, A6_11);
    STORE(A + 126*stride, 0.0);
    STORE(A + 127*stride, 95.0);
    STORE(A + 128*stride, 95.0);
    STORE(A + 129*stride, 95.0);
    STORE(A + 130*stride, 95.0);
    STORE(A + 131*stride, 0.0);
    STORE(A + 132*stride, A1_13);
    STORE(A + 133*stride, 0.0);
    STORE(A + 134*stride, 0.6);
    STORE(A + 135*stride, 0.6);
    STORE(A + 136*stride, 0.6);
    STORE(A + 137*stride, 0.0);
    STORE(A + 138*stride, 0.0);
    STORE(A + 139*stride, 0.0);
    STORE(A + 140*stride, 0.0);
    STORE(A + 141*stride, 0.0);
    STORE(A + 142*stride, 0.0);
    STORE(A + 143*stride, 0.6);
}

WHOLE void OF(two_axis_inertia_matrix_at)(size_t stride, const double *q, const double *p, const double *c, double *A)
{
    ANGLE angle[1];
    ANGLE sine[1];
    ANGLE cosine[1];
    OF(two_axis_inertia_matrix_angles)(stride, q, angle);
    if (OF(circles)(1, angle, sine, cosine)) {
        ANGLE far[1]; /* a copy, so that the angles themselves stay in registers */
        for (size_t k = 0; k < 1; k++)
            far[k] = angle[k];
        far_circles(1*(sizeof(ANGLE)/sizeof(double)), (const double *)far, (double *)sine, (double *)cosine);
    }
    OF(two_axis_inertia_matrix_state)(stride, q, p, c, sine, cosine, A);
}

INLINE void OF(two_axis_bias_forces_angles)(size_t stride, const double *restrict q, ANGLE *restrict angle)
{
    (void)stride;
    const ANGLE q1 = LOAD(q + 0*stride);
    const ANGLE q6 = LOAD(q + 5*stride);
    angle[0] = q1;
    angle[1] = q6;
}

INLINE void OF(two_axis_bias_forces_state)(size_t stride, const double *restrict q, const double *restrict qd, const double *restrict p, const ANGLE *restrict sine, const ANGLE *restrict cosine, double *restrict H)
{
    (void)stride;
    const NUMBER q2 = LOAD(q + 1*stride);
    const NUMBER q3 = LOAD(q + 2*stride);
    const NUMBER q4 = LOAD(q + 3*stride);
    const NUMBER q5 = LOAD(q + 4*stride);
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
    const double D4 = p[TWO_AXIS_P_D4];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Forward recursion: velocities, accelerations, wrenches, joint 1 (bed_yaw) [1], [3], [6], [12]. */
    const NUMBER sin_q1 = sine[0];
    const NUMBER cos_q1 = cosine[0];
    const NUMBER ww1_zz = qd1*qd1;
    const NUMBER vd1_x = 9.81*sin_q1;
    const NUMBER vd1_y = 9.81*cos_q1;

    /* Forward recursion: velocities, accelerations, wrenches, joint 2 (bed_y) [1], [3], [6], [12]. */
    const NUMBER vd2_z = vd1_y - q2*ww1_zz;
    const NUMBER vd2_ya = 2.0*qd1;
    const NUMBER vd2_y = vd1_x - qd2*vd2_ya;

    /* Forward recursion: velocities, accelerations, wrenches, joint 3 (bed_x) [1], [3], [6], [12]. */
    const NUMBER vd3_z = vd2_y - q3*ww1_zz;
    const NUMBER vd3_x = vd2_z + qd3*vd2_ya;
    const NUMBER Fb3_3 = 2500.0*vd3_z;
    const NUMBER Fb3_1 = 500.0*ww1_zz + 2500.0*vd3_x;
    const NUMBER Fb3_5 = 500.0*vd3_z;

    /* Forward recursion: velocities, accelerations, wrenches, joint 4 (motor_secondary) [1], [3], [6], [12]. */
    const NUMBER vd4_z = vd3_z - q4*ww1_zz;
    const NUMBER vd4_x = qd4*vd2_ya - (D4*ww1_zz - vd3_x);
    const NUMBER Fb4_1 = 90.0*vd4_x;
    const NUMBER Fb4_3 = 90.0*vd4_z;

    /* Forward recursion: velocities, accelerations, wrenches, joint 5 (motor_x) [1], [3], [6], [12]. */
    const NUMBER vd5_z = vd4_z - q5*ww1_zz;
    const NUMBER vd5_x = qd5*vd2_ya + vd4_x;
    const NUMBER Fb5_1 = 45.0*vd5_x;
    const NUMBER Fb5_3 = 45.0*vd5_z;

    /* Forward recursion: velocities, accelerations, wrenches, joint 6 (cart_yaw) [1], [3], [6], [12]. */
    const NUMBER sin_q6 = sine[1];
    const NUMBER cos_q6 = cosine[1];
    const NUMBER w6_z = qd1 + qd6;
    const NUMBER ww6_zz = w6_z*w6_z;
    const NUMBER vd6_x = cos_q6*vd5_x - sin_q6*vd5_z;
    const NUMBER vd6_y = -(sin_q6*vd5_x + cos_q6*vd5_z);

    /* Forward recursion: velocities, accelerations, wrenches, joint 7 (cart_x) [1], [3], [6], [12]. */
    const NUMBER vd7_ya = 2.0*w6_z;
    const NUMBER vd7_z = -(q7*ww6_zz + vd6_y);
    const NUMBER vd7_y = -(qd7*vd7_ya + vd6_x);

    /* Forward recursion: velocities, accelerations, wrenches, joint 8 (cart_y) [1], [3], [6], [12]. */
    const NUMBER vd8_z = -(q8*ww6_zz + vd7_y);
    const NUMBER vd8_x = vd7_z - qd8*vd7_ya;
    const NUMBER Fb8_1 = 210.0*vd8_x - 4.2*ww6_zz;
    const NUMBER Fb8_3 = 210.0*vd8_z - 63.0*ww6_zz;
    const NUMBER Fb8_5 = 63.0*vd8_x - 4.2*vd8_z;

    /* Forward recursion: velocities, accelerations, wrenches, joint 9 (motor_y) [1], [3], [6], [12]. */
    const NUMBER vd9_z = vd8_z - q9*ww6_zz;
    const NUMBER vd9_x = vd8_x - qd9*vd7_ya;

    /* Forward recursion: velocities, accelerations, wrenches, joint 10 (y_chain_1) [1], [3], [6], [12]. */
    const NUMBER vd10_z = vd9_z - q10*ww6_zz;
    const NUMBER vd10_x = vd9_x - qd10*vd7_ya;
    const NUMBER Fb10_1 = 8.0*vd10_x;
    const NUMBER Fb10_3 = 8.0*vd10_z;

    /* Forward recursion: velocities, accelerations, wrenches, joint 11 (ram) [1], [3], [6], [12]. */
    const NUMBER vd11_z = vd10_z - q11*ww6_zz;
    const NUMBER vd11_x = vd10_x - qd11*vd7_ya;
    const NUMBER Fb11_1 = 95.0*vd11_x;
    const NUMBER Fb11_3 = 14.25*ww6_zz + 95.0*vd11_z;
    const NUMBER Fb11_5 = -14.25*vd11_x;

    /* Forward recursion: velocities, accelerations, wrenches, joint 13 (sensor_head) [1], [3], [6], [12]. */
    const NUMBER vd13_z = vd5_z - q13*ww1_zz;
    const NUMBER vd13_x = qd13*vd2_ya - (D13*ww1_zz - vd5_x);
    const NUMBER Fb13_1 = 0.6*vd13_x;
    const NUMBER Fb13_3 = 0.6*vd13_z;

    /* Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [15]. */
    const NUMBER f10_5 = Fb11_5 + q11*Fb11_1;
    const NUMBER f10_1 = Fb10_1 + Fb11_1;
    const NUMBER f10_3 = Fb10_3 + Fb11_3;

    /* Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [15]. */
    const NUMBER f9_5 = f10_5 + q10*f10_1;

    /* Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [15]. */
    const NUMBER f8_1 = Fb8_1 + f10_1;
    const NUMBER f8_3 = Fb8_3 + f10_3;
    const NUMBER f8_5 = Fb8_5 + f9_5 + q9*f10_1;

    /* Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [15]. */
    const NUMBER f7_4 = -(f8_5 + q8*f8_1);

    /* Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [15]. */
    const NUMBER f6_6 = f7_4 + q7*f8_3;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [15]. */
    const NUMBER f5_1 = Fb5_1 + Fb13_1 + cos_q6*f8_3 + sin_q6*f8_1;
    const NUMBER f5_3 = Fb5_3 + Fb13_3 + cos_q6*f8_1 - sin_q6*f8_3;
    const NUMBER f5_5 = q13*Fb13_1 - D13*Fb13_3 + f6_6;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [15]. */
    const NUMBER f4_5 = f5_5 + q5*f5_1;
    const NUMBER f4_1 = Fb4_1 + f5_1;
    const NUMBER f4_3 = Fb4_3 + f5_3;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [15]. */
    const NUMBER f3_1 = Fb3_1 + f4_1;
    const NUMBER f3_3 = Fb3_3 + f4_3;
    const NUMBER f3_5 = Fb3_5 + f4_5 + q4*f4_1 - D4*f4_3;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [15]. */
    const NUMBER f2_4 = f3_5 + q3*f3_1;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [15]. */
    const NUMBER f1_6 = f2_4 - q2*f3_3;

    /* Results. */
    STORE(H + 0*stride, f1_6);
    STORE(H + 1*stride, f3_1);
    STORE(H + 2*stride, f3_3);
    STORE(H + 3*stride, f4_3);
    STORE(H + 4*stride, f5_3);
    STORE(H + 5*stride, f6_6);
    STORE(H + 6*stride, f8_1);
    STORE(H + 7*stride, f8_3);
    STORE(H + 8*stride, f10_3);
    STORE(H + 9*stride, f10_3);
    STORE(H + 10*stride, Fb11_3);
    STORE(H + 11*stride, Fb13_3);
}

WHOLE void OF(two_axis_bias_forces_at)(size_t stride, const double *q, const double *qd, const double *p, double *H)
{
    ANGLE angle[2];
    ANGLE sine[2];
    ANGLE cosine[2];
    OF(two_axis_bias_forces_angles)(stride, q, angle);
    if (OF(circles)(2, angle, sine, cosine)) {
        ANGLE far[2]; /* a copy, so that the angles themselves stay in registers */
        for (size_t k = 0; k < 2; k++)
            far[k] = angle[k];
        far_circles(2*(sizeof(ANGLE)/sizeof(double)), (const double *)far, (double *)sine, (double *)cosine);
    }
    OF(two_axis_bias_forces_state)(stride, q, qd, p, sine, cosine, H);
}

INLINE void OF(two_axis_geometric_model_angles)(size_t stride, const double *restrict q, ANGLE *restrict angle)
{
    (void)stride;
    const ANGLE q1 = LOAD(q + 0*stride);
    const ANGLE q6 = LOAD(q + 5*stride);
    angle[0] = q1;
    angle[1] = q6;
}

INLINE void OF(two_axis_geometric_model_state)(size_t stride, const double *restrict q, const double *restrict p, const ANGLE *restrict sine, const ANGLE *restrict cosine, double *restrict T)
{
    (void)stride;
    const NUMBER q2 = LOAD(q + 1*stride);
    const NUMBER q3 = LOAD(q + 2*stride);
    const NUMBER q4 = LOAD(q + 3*stride);
    const NUMBER q5 = LOAD(q + 4*stride);
    const NUMBER q7 = LOAD(q + 6*stride);
    const NUMBER q8 = LOAD(q + 7*stride);
    const NUMBER q9 = LOAD(q + 8*stride);
    const NUMBER q10 = LOAD(q + 9*stride);
    const NUMBER q11 = LOAD(q + 10*stride);
    const NUMBER q13 = LOAD(q + 11*stride);
    const double D4 = p[TWO_AXIS_P_D4];
    const double D12 = p[TWO_AXIS_P_D12];
    const double L12 = p[TWO_AXIS_P_L12];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Geometry, joint 1 (bed_yaw) [1], [2]. */
    const NUMBER sin_q1 = sine[0];
    const NUMBER cos_q1 = cosine[0];

    /* Geometry, joint 2 (bed_y) [1], [2]. */
    const NUMBER P2_x = -q2*sin_q1;
    const NUMBER P2_y = q2*cos_q1;

    /* Geometry, joint 3 (bed_x) [1], [2]. */
    const NUMBER P3_x = P2_x + q3*cos_q1;
    const NUMBER P3_y = P2_y + q3*sin_q1;

    /* Geometry, joint 4 (motor_secondary) [1], [2]. */
    const NUMBER P4_x = q4*cos_q1 - (D4*sin_q1 - P3_x);
    const NUMBER P4_y = P3_y + D4*cos_q1 + q4*sin_q1;

    /* Geometry, joint 5 (motor_x) [1], [2]. */
    const NUMBER P5_x = P4_x + q5*cos_q1;
    const NUMBER P5_y = P4_y + q5*sin_q1;

    /* Geometry, joint 6 (cart_yaw) [1], [2]. */
    const NUMBER sin_q6 = sine[1];
    const NUMBER cos_q6 = cosine[1];
    const NUMBER A6_11 = -(sin_q1*cos_q6 + cos_q1*sin_q6);
    const NUMBER A6_12 = sin_q1*sin_q6 - cos_q1*cos_q6;

    /* Geometry, joint 7 (cart_x) [1], [2]. */
    const NUMBER P7_x = P5_x - q7*A6_12;
    const NUMBER P7_y = P5_y - q7*A6_11;

    /* Geometry, joint 8 (cart_y) [1], [2]. */
    const NUMBER P8_x = P7_x + q8*A6_11;
    const NUMBER P8_y = P7_y - q8*A6_12;

    /* Geometry, joint 9 (motor_y) [1], [2]. */
    const NUMBER P9_x = P8_x + q9*A6_11;
    const NUMBER P9_y = P8_y - q9*A6_12;

    /* Geometry, joint 10 (y_chain_1) [1], [2]. */
    const NUMBER P10_x = P9_x + q10*A6_11;
    const NUMBER P10_y = P9_y - q10*A6_12;

    /* Geometry, joint 11 (ram) [1], [2]. */
    const NUMBER P11_x = P10_x + q11*A6_11;
    const NUMBER P11_y = P10_y - q11*A6_12;

    /* Geometry, joint 12 (tool) [1], [2]. */
    const NUMBER P12_x = L12*A6_11 - (D12*A6_12 - P11_x);
    const NUMBER P12_y = P11_y - D12*A6_11 - L12*A6_12;

    /* Geometry, joint 13 (sensor_head) [1], [2]. */
    const NUMBER P13_x = q13*cos_q1 - (D13*sin_q1 - P5_x);
    const NUMBER P13_y = P5_y + D13*cos_q1 + q13*sin_q1;

    /* Results. */
    STORE(T + 0*stride, cos_q1);
    STORE(T + 1*stride, -sin_q1);
    STORE(T + 2*stride, 0.0);
    STORE(T + 3*stride, 0.0);
    STORE(T + 4*stride, sin_q1);
    STORE(T + 5*stride, cos_q1);
    STORE(T + 6*stride, 0.0);
    STORE(T + 7*stride, 0.0);
    STORE(T + 8*stride, 0.0);
    STORE(T + 9*stride, 0.0);
    STORE(T + 10*stride, 1.0);
    STORE(T + 11*stride, 0.0);
    STORE(T + 12*stride, 0.0);
    STORE(T + 13*stride, 0.0);
    STORE(T + 14*stride, 0.0);
    STORE(T + 15*stride, 1.0);
    STORE(T + 16*stride, 0.0);
    STORE(T + 17*stride, cos_q1);
    STORE(T + 18*stride, -sin_q1);
    STORE(T + 19*stride, P2_x);
    STORE(T + 20*stride, 0.0);
    STORE(T + 21*stride, sin_q1);
    STORE(T + 22*stride, cos_q1);
    STORE(T + 23*stride, P2_y);
    STORE(T + 24*stride, 1.0);
    STORE(T + 25*stride, 0.0);
    STORE(T + 26*stride, 0.0);
    STORE(T + 27*stride, 0.0);
    STORE(T + 28*stride, 0.0);
    STORE(T + 29*stride, 0.0);
    STORE(T + 30*stride, 0.0);
    STORE(T + 31*stride, 1.0);
    STORE(T + 32*stride, -sin_q1);
    STORE(T + 33*stride, 0.0);
    STORE(T + 34*stride, cos_q1);
    STORE(T + 35*stride, P3_x);
    STORE(T + 36*stride, cos_q1);
    STORE(T + 37*stride, 0.0);
    STORE(T + 38*stride, sin_q1);
    STORE(T + 39*stride, P3_y);
    STORE(T + 40*stride, 0.0);
    STORE(T + 41*stride, 1.0);
    STORE(T + 42*stride, 0.0);
    STORE(T + 43*stride, 0.0);
    STORE(T + 44*stride, 0.0);
    STORE(T + 45*stride, 0.0);
    STORE(T + 46*stride, 0.0);
    STORE(T + 47*stride, 1.0);
    STORE(T + 48*stride, -sin_q1);
    STORE(T + 49*stride, 0.0);
    STORE(T + 50*stride, cos_q1);
    STORE(T + 51*stride, P4_x);
    STORE(T + 52*stride, cos_q1);
    STORE(T + 53*stride, 0.0);
    STORE(T + 54*stride, sin_q1);
    STORE(T + 55*stride, P4_y);
    STORE(T + 56*stride, 0.0);
    STORE(T + 57*stride, 1.0);
    STORE(T + 58*stride, 0.0);
    STORE(T + 59*stride, 0.0);
    STORE(T + 60*stride, 0.0);
    STORE(T + 61*stride, 0.0);
    STORE(T + 62*stride, 0.0);
    STORE(T + 63*stride, 1.0);
    STORE(T + 64*stride, -sin_q1);
    STORE(T + 65*stride, 0.0);
    STORE(T + 66*stride, cos_q1);
    STORE(T + 67*stride, P5_x);
    STORE(T + 68*stride, cos_q1);
    STORE(T + 69*stride, 0.0);
    STORE(T + 70*stride, sin_q1);
    STORE(T + 71*stride, P5_y);
    STORE(T + 72*stride, 0.0);
    STORE(T + 73*stride, 1.0);
    STORE(T + 74*stride, 0.0);
    STORE(T + 75*stride, 0.0);
    STORE(T + 76*stride, 0.0);
    STORE(T + 77*stride, 0.0);
    STORE(T + 78*stride, 0.0);
    STORE(T + 79*stride, 1.0);
    STORE(T + 80*stride, A6_11);
    STORE(T + 81*stride, A6_12);
    STORE(T + 82*stride, 0.0);
    STORE(T + 83*stride, P5_x);
    STORE(T + 84*stride, -A6_12);
    STORE(T + 85*stride, A6_11);
    STORE(T + 86*stride, 0.0);
    STORE(T + 87*stride, P5_y);
    STORE(T + 88*stride, 0.0);
    STORE(T + 89*stride, 0.0);
    STORE(T + 90*stride, 1.0);
    STORE(T + 91*stride, 0.0);
    STORE(T + 92*stride, 0.0);
    STORE(T + 93*stride, 0.0);
    STORE(T + 94*stride, 0.0);
    STORE(T + 95*stride, 1.0);
    STORE(T + 96*stride, 0.0);
    STORE(T + 97*stride, -A6_11);
    STORE(T + 98*stride, -A6_12);
    STORE(T + 99*stride, P7_x);
    STORE(T + 100*stride, 0.0);
    STORE(T + 101*stride, A6_12);
    STORE(T + 102*stride, -A6_11);
    STORE(T + 103*stride, P7_y);
    STORE(T + 104*stride, 1.0);
    STORE(T + 105*stride, 0.0);
    STORE(T + 106*stride, 0.0);
    STORE(T + 107*stride, 0.0);
    STORE(T + 108*stride, 0.0);
    STORE(T + 109*stride, 0.0);
    STORE(T + 110*stride, 0.0);
    STORE(T + 111*stride, 1.0);
    STORE(T + 112*stride, -A6_12);
    STORE(T + 113*stride, 0.0);
    STORE(T + 114*stride, A6_11);
    STORE(T + 115*stride, P8_x);
    STORE(T + 116*stride, -A6_11);
    STORE(T + 117*stride, 0.0);
    STORE(T + 118*stride, -A6_12);
    STORE(T + 119*stride, P8_y);
    STORE(T + 120*stride, 0.0);
    STORE(T + 121*stride, -1.0);
    STORE(T + 122*stride, 0.0);
    STORE(T + 123*stride, 0.0);
    STORE(T + 124*stride, 0.0);
    STORE(T + 125*stride, 0.0);
    STORE(T + 126*stride, 0.0);
    STORE(T + 127*stride, 1.0);
    STORE(T + 128*stride, -A6_12);
    STORE(T + 129*stride, 0.0);
    STORE(T + 130*stride, A6_11);
    STORE(T + 131*stride, P9_x);
    STORE(T + 132*stride, -A6_11);
    STORE(T + 133*stride, 0.0);
    STORE(T + 134*stride, -A6_12);
    STORE(T + 135*stride, P9_y);
    STORE(T + 136*stride, 0.0);
    STORE(T + 137*stride, -1.0);
    STORE(T + 138*stride, 0.0);
    STORE(T + 139*stride, 0.0);
    STORE(T + 140*stride, 0.0);
    STORE(T + 141*stride, 0.0);
    STORE(T + 142*stride, 0.0);
    STORE(T + 143*stride, 1.0);
    STORE(T + 144*stride, -A6_12);
    STORE(T + 145*stride, 0.0);
    STORE(T + 146*stride, A6_11);
    STORE(T + 147*stride, P10_x);
    STORE(T + 148*stride, -A6_11);
    STORE(T + 149*stride, 0.0);
    STORE(T + 150*stride, -A6_12);
    STORE(T + 151*stride, P10_y);
    STORE(T + 152*stride, 0.0);
    STORE(T + 153*stride, -1.0);
    STORE(T + 154*stride, 0.0);
    STORE(T + 155*stride, 0.0);
    STORE(T + 156*stride, 0.0);
    STORE(T + 157*stride, 0.0);
    STORE(T + 158*stride, 0.0);
    STORE(T + 159*stride, 1.0);
    STORE(T + 160*stride, -A6_12);
    STORE(T + 161*stride, 0.0);
    STORE(T + 162*stride, A6_11);
    STORE(T + 163*stride, P11_x);
    STORE(T + 164*stride, -A6_11);
    STORE(T + 165*stride, 0.0);
    STORE(T + 166*stride, -A6_12);
    STORE(T + 167*stride, P11_y);
    STORE(T + 168*stride, 0.0);
    STORE(T + 169*stride, -1.0);
    STORE(T + 170*stride, 0.0);
    STORE(T + 171*stride, 0.0);
    STORE(T + 172*stride, 0.0);
    STORE(T + 173*stride, 0.0);
    STORE(T + 174*stride, 0.0);
    STORE(T + 175*stride, 1.0);
    STORE(T + 176*stride, -A6_12);
    STORE(T + 177*stride, 0.0);
    STORE(T + 178*stride, A6_11);
    STORE(T + 179*stride, P12_x);
    STORE(T + 180*stride, -A6_11);
    STORE(T + 181*stride, 0.0);
    STORE(T + 182*stride, -A6_12);
    STORE(T + 183*stride, P12_y);
    STORE(T + 184*stride, 0.0);
    STORE(T + 185*stride, -1.0);
    STORE(T + 186*stride, 0.0);
    STORE(T + 187*stride, 0.0);
    STORE(T + 188*stride, 0.0);
    STORE(T + 189*stride, 0.0);
    STORE(T + 190*stride, 0.0);
    STORE(T + 191*stride, 1.0);
    STORE(T + 192*stride, -sin_q1);
    STORE(T + 193*stride, 0.0);
    STORE(T + 194*stride, cos_q1);
    STORE(T + 195*stride, P13_x);
    STORE(T + 196*stride, cos_q1);
    STORE(T + 197*stride, 0.0);
    STORE(T + 198*stride, sin_q1);
    STORE(T + 199*stride, P13_y);
    STORE(T + 200*stride, 0.0);
    STORE(T + 201*stride, 1.0);
    STORE(T + 202*stride, 0.0);
    STORE(T + 203*stride, 0.0);
    STORE(T + 204*stride, 0.0);
    STORE(T + 205*stride, 0.0);
    STORE(T + 206*stride, 0.0);
    STORE(T + 207*stride, 1.0);
}

WHOLE void OF(two_axis_geometric_model_at)(size_t stride, const double *q, const double *p, double *T)
{
    ANGLE angle[2];
    ANGLE sine[2];
    ANGLE cosine[2];
    OF(two_axis_geometric_model_angles)(stride, q, angle);
    if (OF(circles)(2, angle, sine, cosine)) {
        ANGLE far[2]; /* a copy, so that the angles themselves stay in registers */
        for (size_t k = 0; k < 2; k++)
            far[k] = angle[k];
        far_circles(2*(sizeof(ANGLE)/sizeof(double)), (const double *)far, (double *)sine, (double *)cosine);
    }
    OF(two_axis_geometric_model_state)(stride, q, p, sine, cosine, T);
}

#endif
