/* rx90: generated models in double precision. Equation numbers are those of Khalil and Gautier.
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

#include "rx90.h"

#define EQUATIONS 3411329826
#ifdef __GNUC__
#define INLINE static inline __attribute__((always_inline, unused))
#define APART static __attribute__((noinline, unused))
#else
#define INLINE static inline
#define APART static
#endif
#define EXCESS (FLT_EVAL_METHOD%16 != 0) /* whether numbers are kept longer than their type */

const double rx90_defaults[RX90_PARAMETERS] = {
    NAN, /* XX1 */
    NAN, /* XY1 */
    NAN, /* XZ1 */
    NAN, /* YY1 */
    NAN, /* YZ1 */
    NAN, /* ZZ1 */
    NAN, /* MX1 */
    NAN, /* MY1 */
    NAN, /* MZ1 */
    NAN, /* M1 */
    NAN, /* IA1 */
    NAN, /* XX2 */
    NAN, /* XY2 */
    NAN, /* XZ2 */
    NAN, /* YY2 */
    NAN, /* YZ2 */
    NAN, /* ZZ2 */
    NAN, /* MX2 */
    NAN, /* MY2 */
    NAN, /* MZ2 */
    NAN, /* M2 */
    NAN, /* IA2 */
    NAN, /* D3 */
    NAN, /* XX3 */
    NAN, /* XY3 */
    NAN, /* XZ3 */
    NAN, /* YY3 */
    NAN, /* YZ3 */
    NAN, /* ZZ3 */
    NAN, /* MX3 */
    NAN, /* MY3 */
    NAN, /* MZ3 */
    NAN, /* M3 */
    NAN, /* IA3 */
    NAN, /* RL4 */
    NAN, /* XX4 */
    NAN, /* XY4 */
    NAN, /* XZ4 */
    NAN, /* YY4 */
    NAN, /* YZ4 */
    NAN, /* ZZ4 */
    NAN, /* MX4 */
    NAN, /* MY4 */
    NAN, /* MZ4 */
    NAN, /* M4 */
    NAN, /* IA4 */
    NAN, /* XX5 */
    NAN, /* XY5 */
    NAN, /* XZ5 */
    NAN, /* YY5 */
    NAN, /* YZ5 */
    NAN, /* ZZ5 */
    NAN, /* MX5 */
    NAN, /* MY5 */
    NAN, /* MZ5 */
    NAN, /* M5 */
    NAN, /* IA5 */
    NAN, /* XX6 */
    NAN, /* XY6 */
    NAN, /* XZ6 */
    NAN, /* YY6 */
    NAN, /* YZ6 */
    NAN, /* ZZ6 */
    NAN, /* MX6 */
    NAN, /* MY6 */
    NAN, /* MZ6 */
    NAN, /* M6 */
    NAN, /* IA6 */
    NAN /* G3 */
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
#include "rx90.c"
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
#include "rx90.c"

INLINE void rx90_direct_dynamics_constants(const double *restrict p, double *restrict c)
{
    const double YY5 = p[RX90_P_YY5];
    const double M5 = p[RX90_P_M5];
    const double XX6 = p[RX90_P_XX6];
    const double XY6 = p[RX90_P_XY6];
    const double YY6 = p[RX90_P_YY6];
    const double ZZ6 = p[RX90_P_ZZ6];
    const double M6 = p[RX90_P_M6];
    const double IA6 = p[RX90_P_IA6];

    /* Forward recursion: velocities, joint 6 (j6) [1], [3], [7], [14]. */
    const double dJ6_xy = XX6 - YY6;
    const double Js6_44a = 2.0*XY6;

    /* Backward recursion: articulated inertias and wrenches, joint 6 (j6) [28]-[32]. */
    const double H6 = ZZ6 + IA6;
    const double Hinv6 = 1.0/H6;
    const double rho6 = IA6*Hinv6;
    const double UH6_6 = ZZ6*Hinv6;
    const double K6_66 = ZZ6*rho6;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (j5) [28]-[32]. */
    const double Js5_22 = M5 + M6;
    const double Js5_55 = YY5 + K6_66;

    c[0] = dJ6_xy;
    c[1] = Js6_44a;
    c[2] = Hinv6;
    c[3] = rho6;
    c[4] = UH6_6;
    c[5] = Js5_22;
    c[6] = Js5_55;
}

void rx90_direct_dynamics_prepare(const double *p, double *c)
{
    rx90_direct_dynamics_constants(p, c);
}

void rx90_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    rx90_direct_dynamics_at(1, q, qd, tau, p, c, qdd);
}

void rx90_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[RX90_DIRECT_DYNAMICS_CONSTANTS];
    rx90_direct_dynamics_prepare(p, c);
    rx90_direct_dynamics_prepared(q, qd, tau, p, c, qdd);
}

void rx90_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[RX90_DIRECT_DYNAMICS_CONSTANTS];
    rx90_direct_dynamics_prepare(p, c);
    size_t first = 0;
    for (; states < WIDTH && first < states; first++)
        rx90_direct_dynamics_at(states, q + first, qd + first, tau + first, p, c, qdd + first);
    for (; first < states; first += WIDTH) {
        if (first + WIDTH > states)
            first = states - WIDTH; /* The last ones overlap with those before. */
        LANES(rx90_direct_dynamics_at)(states, q + first, qd + first, tau + first, p, c, qdd + first);
    }
}

INLINE void rx90_inverse_dynamics_constants(const double *restrict p, double *restrict c)
{
    const double XX2 = p[RX90_P_XX2];
    const double YY2 = p[RX90_P_YY2];
    const double ZZ2 = p[RX90_P_ZZ2];
    const double XX3 = p[RX90_P_XX3];
    const double YY3 = p[RX90_P_YY3];
    const double ZZ3 = p[RX90_P_ZZ3];
    const double XX4 = p[RX90_P_XX4];
    const double YY4 = p[RX90_P_YY4];
    const double ZZ4 = p[RX90_P_ZZ4];
    const double XX5 = p[RX90_P_XX5];
    const double YY5 = p[RX90_P_YY5];
    const double ZZ5 = p[RX90_P_ZZ5];
    const double XX6 = p[RX90_P_XX6];
    const double YY6 = p[RX90_P_YY6];
    const double ZZ6 = p[RX90_P_ZZ6];

    /* Forward recursion: velocities, accelerations, wrenches, joint 2 (j2) [1], [3], [6], [12]. */
    const double dJ2_yz = YY2 - ZZ2;
    const double dJ2_xz = XX2 - ZZ2;
    const double dJ2_xy = XX2 - YY2;

    /* Forward recursion: velocities, accelerations, wrenches, joint 3 (j3) [1], [3], [6], [12]. */
    const double dJ3_yz = YY3 - ZZ3;
    const double dJ3_xz = XX3 - ZZ3;
    const double dJ3_xy = XX3 - YY3;

    /* Forward recursion: velocities, accelerations, wrenches, joint 4 (j4) [1], [3], [6], [12]. */
    const double dJ4_yz = YY4 - ZZ4;
    const double dJ4_xz = XX4 - ZZ4;
    const double dJ4_xy = XX4 - YY4;

    /* Forward recursion: velocities, accelerations, wrenches, joint 5 (j5) [1], [3], [6], [12]. */
    const double dJ5_yz = YY5 - ZZ5;
    const double dJ5_xz = XX5 - ZZ5;
    const double dJ5_xy = XX5 - YY5;

    /* Forward recursion: velocities, accelerations, wrenches, joint 6 (j6) [1], [3], [6], [12]. */
    const double dJ6_yz = YY6 - ZZ6;
    const double dJ6_xz = XX6 - ZZ6;
    const double dJ6_xy = XX6 - YY6;

    c[0] = dJ2_yz;
    c[1] = dJ2_xz;
    c[2] = dJ2_xy;
    c[3] = dJ3_yz;
    c[4] = dJ3_xz;
    c[5] = dJ3_xy;
    c[6] = dJ4_yz;
    c[7] = dJ4_xz;
    c[8] = dJ4_xy;
    c[9] = dJ5_yz;
    c[10] = dJ5_xz;
    c[11] = dJ5_xy;
    c[12] = dJ6_yz;
    c[13] = dJ6_xz;
    c[14] = dJ6_xy;
}

void rx90_inverse_dynamics_prepare(const double *p, double *c)
{
    rx90_inverse_dynamics_constants(p, c);
}

void rx90_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    rx90_inverse_dynamics_at(1, q, qd, qdd_motor, p, c, tau, qdd);
}

void rx90_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[RX90_INVERSE_DYNAMICS_CONSTANTS];
    rx90_inverse_dynamics_prepare(p, c);
    rx90_inverse_dynamics_prepared(q, qd, qdd_motor, p, c, tau, qdd);
}

void rx90_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[RX90_INVERSE_DYNAMICS_CONSTANTS];
    rx90_inverse_dynamics_prepare(p, c);
    size_t first = 0;
    for (; states < WIDTH && first < states; first++)
        rx90_inverse_dynamics_at(states, q + first, qd + first, qdd_motor + first, p, c, tau + first, qdd + first);
    for (; first < states; first += WIDTH) {
        if (first + WIDTH > states)
            first = states - WIDTH; /* The last ones overlap with those before. */
        LANES(rx90_inverse_dynamics_at)(states, q + first, qd + first, qdd_motor + first, p, c, tau + first, qdd + first);
    }
}

#else /* The equations. */
#if EQUATIONS != 3411329826
#error "this rx90.c is not the file that includes it: a generated file keeps its name"
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

INLINE void OF(rx90_direct_dynamics_angles)(size_t stride, const double *restrict q, ANGLE *restrict angle)
{
    (void)stride;
    const ANGLE th2 = LOAD(q + 1*stride);
    const ANGLE th3 = LOAD(q + 2*stride);
    const ANGLE th4 = LOAD(q + 3*stride);
    const ANGLE th5 = LOAD(q + 4*stride);
    const ANGLE th6 = LOAD(q + 5*stride);
    angle[0] = th2;
    angle[1] = th3;
    angle[2] = th4;
    angle[3] = th5;
    angle[4] = th6;
}

INLINE void OF(rx90_direct_dynamics_state)(size_t stride, const double *restrict qd, const double *restrict tau, const double *restrict p, const double *restrict c, const ANGLE *restrict sine, const ANGLE *restrict cosine, double *restrict qdd)
{
    (void)stride;
    const NUMBER qd1 = LOAD(qd + 0*stride);
    const NUMBER qd2 = LOAD(qd + 1*stride);
    const NUMBER qd3 = LOAD(qd + 2*stride);
    const NUMBER qd4 = LOAD(qd + 3*stride);
    const NUMBER qd5 = LOAD(qd + 4*stride);
    const NUMBER qd6 = LOAD(qd + 5*stride);
    const NUMBER tau1 = LOAD(tau + 0*stride);
    const NUMBER tau2 = LOAD(tau + 1*stride);
    const NUMBER tau3 = LOAD(tau + 2*stride);
    const NUMBER tau4 = LOAD(tau + 3*stride);
    const NUMBER tau5 = LOAD(tau + 4*stride);
    const NUMBER tau6 = LOAD(tau + 5*stride);
    const double ZZ1 = p[RX90_P_ZZ1];
    const double IA1 = p[RX90_P_IA1];
    const double XX2 = p[RX90_P_XX2];
    const double XY2 = p[RX90_P_XY2];
    const double XZ2 = p[RX90_P_XZ2];
    const double YY2 = p[RX90_P_YY2];
    const double YZ2 = p[RX90_P_YZ2];
    const double ZZ2 = p[RX90_P_ZZ2];
    const double MX2 = p[RX90_P_MX2];
    const double MY2 = p[RX90_P_MY2];
    const double MZ2 = p[RX90_P_MZ2];
    const double IA2 = p[RX90_P_IA2];
    const double D3 = p[RX90_P_D3];
    const double XX3 = p[RX90_P_XX3];
    const double XY3 = p[RX90_P_XY3];
    const double XZ3 = p[RX90_P_XZ3];
    const double YY3 = p[RX90_P_YY3];
    const double YZ3 = p[RX90_P_YZ3];
    const double ZZ3 = p[RX90_P_ZZ3];
    const double MX3 = p[RX90_P_MX3];
    const double MY3 = p[RX90_P_MY3];
    const double MZ3 = p[RX90_P_MZ3];
    const double M3 = p[RX90_P_M3];
    const double IA3 = p[RX90_P_IA3];
    const double RL4 = p[RX90_P_RL4];
    const double XX4 = p[RX90_P_XX4];
    const double XY4 = p[RX90_P_XY4];
    const double XZ4 = p[RX90_P_XZ4];
    const double YY4 = p[RX90_P_YY4];
    const double YZ4 = p[RX90_P_YZ4];
    const double ZZ4 = p[RX90_P_ZZ4];
    const double MX4 = p[RX90_P_MX4];
    const double MY4 = p[RX90_P_MY4];
    const double MZ4 = p[RX90_P_MZ4];
    const double M4 = p[RX90_P_M4];
    const double IA4 = p[RX90_P_IA4];
    const double XX5 = p[RX90_P_XX5];
    const double XY5 = p[RX90_P_XY5];
    const double XZ5 = p[RX90_P_XZ5];
    const double YY5 = p[RX90_P_YY5];
    const double YZ5 = p[RX90_P_YZ5];
    const double ZZ5 = p[RX90_P_ZZ5];
    const double MX5 = p[RX90_P_MX5];
    const double MY5 = p[RX90_P_MY5];
    const double MZ5 = p[RX90_P_MZ5];
    const double M5 = p[RX90_P_M5];
    const double IA5 = p[RX90_P_IA5];
    const double XX6 = p[RX90_P_XX6];
    const double XY6 = p[RX90_P_XY6];
    const double XZ6 = p[RX90_P_XZ6];
    const double YY6 = p[RX90_P_YY6];
    const double YZ6 = p[RX90_P_YZ6];
    const double ZZ6 = p[RX90_P_ZZ6];
    const double MX6 = p[RX90_P_MX6];
    const double MY6 = p[RX90_P_MY6];
    const double MZ6 = p[RX90_P_MZ6];
    const double M6 = p[RX90_P_M6];
    const double G3 = p[RX90_P_G3];
    const double dJ6_xy = c[0];
    const double Js6_44a = c[1];
    const double Hinv6 = c[2];
    const double rho6 = c[3];
    const double UH6_6 = c[4];
    const double Js5_22 = c[5];
    const double Js5_55 = c[6];

    /* Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14]. */
    const NUMBER sin_th2 = sine[0];
    const NUMBER cos_th2 = cosine[0];
    const NUMBER w2_x = qd1*sin_th2;
    const NUMBER w2_y = qd1*cos_th2;
    const NUMBER g2_4 = qd1*qd2;
    const NUMBER Vk2_1 = -G3*sin_th2;
    const NUMBER Vk2_2 = -G3*cos_th2;
    const NUMBER b2_5a = XX2*w2_x + XY2*w2_y + XZ2*qd2;
    const NUMBER b2_4a = XY2*w2_x + YY2*w2_y + YZ2*qd2;
    const NUMBER b2_4b = XZ2*w2_x + YZ2*w2_y + ZZ2*qd2;
    const NUMBER b2_4 = MZ2*Vk2_2 - (w2_y*b2_4b - qd2*b2_4a);
    const NUMBER b2_5 = -(qd2*b2_5a - w2_x*b2_4b + MZ2*Vk2_1);
    const NUMBER b2_6 = -(w2_x*b2_4a - w2_y*b2_5a + MX2*Vk2_2 - MY2*Vk2_1);

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const NUMBER sin_th3 = sine[1];
    const NUMBER cos_th3 = cosine[1];
    const NUMBER w3_x = cos_th3*w2_x + sin_th3*w2_y;
    const NUMBER w3_y = cos_th3*w2_y - sin_th3*w2_x;
    const NUMBER w3_z = qd2 + qd3;
    const NUMBER Vk3_3a = D3*qd2;
    const NUMBER Vk3_1a = D3*w2_y;
    const NUMBER Vk3_3 = w2_x*Vk3_3a;
    const NUMBER g3_4 = qd3*w2_y;
    const NUMBER g3_5 = -qd3*w2_x;
    const NUMBER Vk3_1b = w2_y*Vk3_1a + qd2*Vk3_3a - Vk2_1;
    const NUMBER Vk3_1c = w2_x*Vk3_1a + Vk2_2;
    const NUMBER Vk3_1 = sin_th3*Vk3_1c - cos_th3*Vk3_1b;
    const NUMBER Vk3_2 = sin_th3*Vk3_1b + cos_th3*Vk3_1c;
    const NUMBER b3_2a = MY3*w3_z - MZ3*w3_y;
    const NUMBER b3_1a = MX3*w3_z - MZ3*w3_x;
    const NUMBER b3_1b = MY3*w3_x - MX3*w3_y;
    const NUMBER b3_5a = XX3*w3_x + XY3*w3_y + XZ3*w3_z;
    const NUMBER b3_4a = XY3*w3_x + YY3*w3_y + YZ3*w3_z;
    const NUMBER b3_4b = XZ3*w3_x + YZ3*w3_y + ZZ3*w3_z;
    const NUMBER b3_1 = w3_z*b3_1a - w3_y*b3_1b - M3*Vk3_1;
    const NUMBER b3_2 = w3_z*b3_2a + w3_x*b3_1b - M3*Vk3_2;
    const NUMBER b3_3 = -(w3_x*b3_1a + w3_y*b3_2a + M3*Vk3_3);
    const NUMBER b3_4 = w3_z*b3_4a - w3_y*b3_4b + MZ3*Vk3_2 - MY3*Vk3_3;
    const NUMBER b3_5 = MX3*Vk3_3 - MZ3*Vk3_1 - (w3_z*b3_5a - w3_x*b3_4b);
    const NUMBER b3_6 = -(w3_x*b3_4a - w3_y*b3_5a + MX3*Vk3_2 - MY3*Vk3_1);

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const NUMBER sin_th4 = sine[2];
    const NUMBER cos_th4 = cosine[2];
    const NUMBER w4_x = cos_th4*w3_x - sin_th4*w3_z;
    const NUMBER w4_y = -(sin_th4*w3_x + cos_th4*w3_z);
    const NUMBER w4_z = qd4 + w3_y;
    const NUMBER g4_2a = RL4*w3_z;
    const NUMBER g4_1a = RL4*w3_x;
    const NUMBER g4_4 = -qd4*w3_z;
    const NUMBER g4_5 = -qd4*w3_x;
    const NUMBER g4_1 = w3_y*g4_1a + Vk3_1;
    const NUMBER g4_2 = -(Vk3_3 + w3_y*g4_2a);
    const NUMBER g4_3 = Vk3_2 - (w3_x*g4_1a + w3_z*g4_2a);
    const NUMBER b4_2a = MY4*w4_z - MZ4*w4_y;
    const NUMBER b4_1a = MX4*w4_z - MZ4*w4_x;
    const NUMBER b4_1b = MY4*w4_x - MX4*w4_y;
    const NUMBER b4_1 = w4_z*b4_1a - w4_y*b4_1b;
    const NUMBER b4_2 = w4_z*b4_2a + w4_x*b4_1b;
    const NUMBER b4_3 = -(w4_x*b4_1a + w4_y*b4_2a);
    const NUMBER b4_5a = XX4*w4_x + XY4*w4_y + XZ4*w4_z;
    const NUMBER b4_4a = XY4*w4_x + YY4*w4_y + YZ4*w4_z;
    const NUMBER b4_4b = XZ4*w4_x + YZ4*w4_y + ZZ4*w4_z;
    const NUMBER b4_4 = w4_z*b4_4a - w4_y*b4_4b;
    const NUMBER b4_5 = w4_x*b4_4b - w4_z*b4_5a;
    const NUMBER b4_6 = w4_y*b4_5a - w4_x*b4_4a;

    /* Forward recursion: velocities, joint 5 (j5) [1], [3], [7], [14]. */
    const NUMBER sin_th5 = sine[3];
    const NUMBER cos_th5 = cosine[3];
    const NUMBER w5_x = cos_th5*w4_x + sin_th5*w4_z;
    const NUMBER w5_y = cos_th5*w4_z - sin_th5*w4_x;
    const NUMBER w5_z = qd5 - w4_y;
    const NUMBER g5_4 = qd5*w4_z;
    const NUMBER g5_5 = -qd5*w4_x;
    const NUMBER b5_2a = MY5*w5_z - MZ5*w5_y;
    const NUMBER b5_1a = MX5*w5_z - MZ5*w5_x;
    const NUMBER b5_1b = MY5*w5_x - MX5*w5_y;
    const NUMBER b5_1 = w5_z*b5_1a - w5_y*b5_1b;
    const NUMBER b5_2 = w5_z*b5_2a + w5_x*b5_1b;
    const NUMBER b5_3 = -(w5_x*b5_1a + w5_y*b5_2a);
    const NUMBER b5_5a = XX5*w5_x + XY5*w5_y + XZ5*w5_z;
    const NUMBER b5_4a = XY5*w5_x + YY5*w5_y + YZ5*w5_z;
    const NUMBER b5_4b = XZ5*w5_x + YZ5*w5_y + ZZ5*w5_z;
    const NUMBER b5_4 = w5_z*b5_4a - w5_y*b5_4b;
    const NUMBER b5_5 = w5_x*b5_4b - w5_z*b5_5a;
    const NUMBER b5_6 = w5_y*b5_5a - w5_x*b5_4a;

    /* Forward recursion: velocities, joint 6 (j6) [1], [3], [7], [14]. */
    const NUMBER sin_th6 = sine[4];
    const NUMBER cos_th6 = cosine[4];
    const NUMBER Js6_26 = MX6*cos_th6 - MY6*sin_th6;
    const NUMBER Js6_16 = -(MX6*sin_th6 + MY6*cos_th6);
    const NUMBER Js6_46 = XZ6*cos_th6 - YZ6*sin_th6;
    const NUMBER Js6_56 = XZ6*sin_th6 + YZ6*cos_th6;
    const NUMBER w6_z = qd6 + w5_y;
    const NUMBER b6_2a = qd6*w5_z;
    const NUMBER b6_1a = qd6*w5_x;
    const NUMBER b6_2b = MZ6*w5_z - Js6_16*w6_z;
    const NUMBER b6_1b = Js6_26*w6_z - MZ6*w5_x;
    const NUMBER b6_1c = Js6_26*w5_z - Js6_16*w5_x;
    const NUMBER b6_4a = Js6_46*w5_x - Js6_56*w5_z + ZZ6*w6_z;
    const NUMBER b6_1 = w5_z*b6_1c + w6_z*b6_1b + MZ6*b6_1a;
    const NUMBER b6_2 = w6_z*b6_2b + w5_x*b6_1c - MZ6*b6_2a;
    const NUMBER b6_3 = -(w5_x*b6_1b - w5_z*b6_2b + Js6_16*b6_2a + Js6_26*b6_1a);
    const NUMBER Js6_44b = sin_th6*dJ6_xy + cos_th6*Js6_44a;
    const NUMBER Js6_44c = sin_th6*Js6_44b;
    const NUMBER Js6_44 = XX6 - Js6_44c;
    const NUMBER Js6_45 = cos_th6*Js6_44b - XY6;
    const NUMBER Js6_55 = YY6 + Js6_44c;
    const NUMBER b6_5a = Js6_46*w6_z + w5_x*Js6_44 - w5_z*Js6_45;
    const NUMBER b6_4b = Js6_56*w6_z - (w5_z*Js6_55 - w5_x*Js6_45);
    const NUMBER b6_4 = w5_z*b6_4a + w6_z*b6_4b + b6_2a*Js6_44 + b6_1a*Js6_45;
    const NUMBER b6_5 = w5_x*b6_4a - w6_z*b6_5a + b6_2a*Js6_45 + b6_1a*Js6_55;
    const NUMBER b6_6 = Js6_46*b6_2a + Js6_56*b6_1a - (w5_x*b6_4b + w5_z*b6_5a);

    /* Backward recursion: articulated inertias and wrenches, joint 6 (j6) [28]-[32]. */
    const NUMBER UH6_1 = Js6_16*Hinv6;
    const NUMBER UH6_2 = Js6_26*Hinv6;
    const NUMBER UH6_4 = Js6_46*Hinv6;
    const NUMBER UH6_5 = Js6_56*Hinv6;
    const NUMBER K6_16 = Js6_16*rho6;
    const NUMBER K6_26 = Js6_26*rho6;
    const NUMBER K6_46 = Js6_46*rho6;
    const NUMBER K6_56 = Js6_56*rho6;
    const NUMBER K6_14 = -Js6_16*UH6_4;
    const NUMBER K6_11 = M6 - Js6_16*UH6_1;
    const NUMBER K6_15 = MZ6 - Js6_16*UH6_5;
    const NUMBER K6_12 = -Js6_16*UH6_2;
    const NUMBER K6_24 = -(MZ6 + Js6_26*UH6_4);
    const NUMBER K6_25 = -Js6_26*UH6_5;
    const NUMBER K6_22 = M6 - Js6_26*UH6_2;
    const NUMBER K6_44 = Js6_44 - Js6_46*UH6_4;
    const NUMBER K6_45 = Js6_45 - Js6_46*UH6_5;
    const NUMBER K6_55 = Js6_55 - Js6_56*UH6_5;
    const NUMBER Gb6 = tau6 + b6_6;
    const NUMBER qdf6 = Hinv6*Gb6;
    const NUMBER al6_1 = Js6_16*qdf6 - b6_1;
    const NUMBER al6_2 = Js6_26*qdf6 - b6_2;
    const NUMBER al6_4 = Js6_46*qdf6 - b6_4;
    const NUMBER al6_5 = Js6_56*qdf6 - b6_5;
    const NUMBER al6_6 = tau6*UH6_6 - rho6*b6_6;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (j5) [28]-[32]. */
    const NUMBER Js5_11 = M5 + K6_11;
    const NUMBER Js5_33 = M5 + K6_22;
    const NUMBER Js5_15 = MZ5 + K6_16;
    const NUMBER Js5_16 = -(MY5 + K6_15);
    const NUMBER Js5_24 = -(MZ5 + Js6_16);
    const NUMBER Js5_26 = MX5 + Js6_26;
    const NUMBER Js5_34 = MY5 - K6_24;
    const NUMBER Js5_35 = -(MX5 + K6_26);
    const NUMBER Js5_45 = XY5 + K6_46;
    const NUMBER Js5_56 = YZ5 - K6_56;
    const NUMBER bs5_2 = b5_2 + b6_3;
    const NUMBER K5_11a = 2.0*cos_th5;
    const NUMBER Js5_44 = XX5 + K6_44;
    const NUMBER Js5_46 = XZ5 - K6_45;
    const NUMBER Js5_66 = ZZ5 + K6_55;
    const NUMBER bs5_1 = b5_1 - al6_1;
    const NUMBER bs5_3 = b5_3 + al6_2;
    const NUMBER bs5_4 = b5_4 - al6_4;
    const NUMBER bs5_5 = b5_5 - al6_6;
    const NUMBER bs5_6 = b5_6 + al6_5;
    const NUMBER H5 = IA5 + Js5_66;
    const NUMBER Hinv5 = 1.0/H5;
    const NUMBER rho5 = IA5*Hinv5;
    const NUMBER UH5_6 = Js5_66*Hinv5;
    const NUMBER UH5_1 = Js5_16*Hinv5;
    const NUMBER UH5_2 = Js5_26*Hinv5;
    const NUMBER UH5_3 = K6_25*Hinv5;
    const NUMBER UH5_4 = Js5_46*Hinv5;
    const NUMBER UH5_5 = Js5_56*Hinv5;
    const NUMBER K5_16a = -Js5_16*rho5;
    const NUMBER K5_16b = Js5_26*rho5;
    const NUMBER K5_36 = K6_25*rho5;
    const NUMBER K5_46a = Js5_46*rho5;
    const NUMBER K5_46b = Js5_56*rho5;
    const NUMBER K5_66 = Js5_66*rho5;
    const NUMBER K5_14a = K6_14 - Js5_16*UH5_4;
    const NUMBER K5_11b = Js5_11 - Js5_16*UH5_1;
    const NUMBER K5_44a = Js5_44 - Js5_46*UH5_4;
    const NUMBER K5_14b = Js5_15 - Js5_16*UH5_5;
    const NUMBER K5_11c = -Js5_16*UH5_2;
    const NUMBER K5_44b = Js5_45 - Js5_46*UH5_5;
    const NUMBER K5_13a = K6_12 + Js5_16*UH5_3;
    const NUMBER K5_14c = Js5_26*UH5_4 - Js5_24;
    const NUMBER K5_14d = Js5_26*UH5_5;
    const NUMBER K5_11d = Js5_22 - Js5_26*UH5_2;
    const NUMBER K5_44c = Js5_55 - Js5_56*UH5_5;
    const NUMBER K5_13b = -Js5_26*UH5_3;
    const NUMBER K5_34a = Js5_34 - K6_25*UH5_4;
    const NUMBER K5_34b = K6_25*UH5_5 - Js5_35;
    const NUMBER K5_33 = Js5_33 - K6_25*UH5_3;
    const NUMBER K5_11e = sin_th5*(K5_11b - K5_11d) + K5_11a*K5_11c;
    const NUMBER K5_11f = sin_th5*K5_11e;
    const NUMBER K5_11 = K5_11b - K5_11f;
    const NUMBER K5_12 = cos_th5*K5_11e - K5_11c;
    const NUMBER K5_22 = K5_11d + K5_11f;
    const NUMBER K5_13 = -(cos_th5*K5_13a + sin_th5*K5_13b);
    const NUMBER K5_23 = cos_th5*K5_13b - sin_th5*K5_13a;
    const NUMBER K5_14e = sin_th5*(K5_14a + K5_14d) + cos_th5*(K5_14b - K5_14c);
    const NUMBER K5_14f = sin_th5*K5_14e;
    const NUMBER K5_14 = K5_14a - K5_14f;
    const NUMBER K5_15a = cos_th5*K5_14e;
    const NUMBER K5_15 = K5_14c + K5_15a;
    const NUMBER K5_24 = K5_15a - K5_14b;
    const NUMBER K5_25 = K5_14f - K5_14d;
    const NUMBER K5_16 = -(cos_th5*K5_16a + sin_th5*K5_16b);
    const NUMBER K5_26 = cos_th5*K5_16b - sin_th5*K5_16a;
    const NUMBER K5_34 = cos_th5*K5_34a + sin_th5*K5_34b;
    const NUMBER K5_35 = sin_th5*K5_34a - cos_th5*K5_34b;
    const NUMBER K5_44d = sin_th5*(K5_44a - K5_44c) + K5_11a*K5_44b;
    const NUMBER K5_44e = sin_th5*K5_44d;
    const NUMBER K5_44 = K5_44a - K5_44e;
    const NUMBER K5_45 = cos_th5*K5_44d - K5_44b;
    const NUMBER K5_55 = K5_44c + K5_44e;
    const NUMBER K5_46 = cos_th5*K5_46a - sin_th5*K5_46b;
    const NUMBER K5_56 = sin_th5*K5_46a + cos_th5*K5_46b;
    const NUMBER Gb5 = tau5 + bs5_6;
    const NUMBER qdf5 = Hinv5*Gb5;
    const NUMBER al5_1a = bs5_1 - Js5_16*qdf5;
    const NUMBER al5_1b = bs5_2 - Js5_26*qdf5;
    const NUMBER al5_4a = bs5_4 - Js5_46*qdf5;
    const NUMBER al5_4b = Js5_56*qdf5 - bs5_5;
    const NUMBER al5_1 = g5_4*K5_14 + g5_5*K5_15 - (cos_th5*al5_1a - sin_th5*al5_1b);
    const NUMBER al5_2 = g5_4*K5_24 + g5_5*K5_25 - (sin_th5*al5_1a + cos_th5*al5_1b);
    const NUMBER al5_3 = g5_4*K5_34 + g5_5*K5_35 + K6_25*qdf5 - bs5_3;
    const NUMBER al5_4 = g5_4*K5_44 + g5_5*K5_45 - (cos_th5*al5_4a + sin_th5*al5_4b);
    const NUMBER al5_5 = g5_4*K5_45 + g5_5*K5_55 - (sin_th5*al5_4a - cos_th5*al5_4b);
    const NUMBER al5_6 = g5_4*K5_46 + g5_5*K5_56 + tau5*UH5_6 - bs5_6*rho5;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32]. */
    const NUMBER K4_11a = 2.0*cos_th4;
    const NUMBER Js4_11 = M4 + K5_11;
    const NUMBER Js4_22 = M4 + K5_33;
    const NUMBER Js4_33 = M4 + K5_22;
    const NUMBER Js4_15 = MZ4 - K5_16;
    const NUMBER Js4_16 = K5_15 - MY4;
    const NUMBER Js4_24 = -(MZ4 + K5_34);
    const NUMBER Js4_26 = MX4 - K5_35;
    const NUMBER Js4_34 = MY4 + K5_24;
    const NUMBER Js4_35 = -(MX4 + K5_26);
    const NUMBER Js4_44 = XX4 + K5_44;
    const NUMBER Js4_45 = XY4 - K5_46;
    const NUMBER Js4_46 = XZ4 + K5_45;
    const NUMBER Js4_55 = YY4 + K5_66;
    const NUMBER Js4_56 = YZ4 - K5_56;
    const NUMBER Js4_66 = ZZ4 + K5_55;
    const NUMBER bs4_1 = b4_1 - al5_1;
    const NUMBER bs4_2 = b4_2 + al5_3;
    const NUMBER bs4_3 = b4_3 - al5_2;
    const NUMBER bs4_4 = b4_4 - al5_4;
    const NUMBER bs4_5 = b4_5 + al5_6;
    const NUMBER bs4_6 = b4_6 - al5_5;
    const NUMBER H4 = IA4 + Js4_66;
    const NUMBER Hinv4 = 1.0/H4;
    const NUMBER rho4 = IA4*Hinv4;
    const NUMBER UH4_6 = Js4_66*Hinv4;
    const NUMBER UH4_1 = Js4_16*Hinv4;
    const NUMBER UH4_2 = Js4_26*Hinv4;
    const NUMBER UH4_3 = K5_25*Hinv4;
    const NUMBER UH4_4 = Js4_46*Hinv4;
    const NUMBER UH4_5 = Js4_56*Hinv4;
    const NUMBER K4_16a = -Js4_16*rho4;
    const NUMBER K4_16b = Js4_26*rho4;
    const NUMBER K4_36 = K5_25*rho4;
    const NUMBER K4_46a = Js4_46*rho4;
    const NUMBER K4_46b = Js4_56*rho4;
    const NUMBER K4_66 = Js4_66*rho4;
    const NUMBER K4_14a = K5_14 - Js4_16*UH4_4;
    const NUMBER K4_11b = Js4_11 - Js4_16*UH4_1;
    const NUMBER K4_44a = Js4_44 - Js4_46*UH4_4;
    const NUMBER K4_14b = Js4_15 - Js4_16*UH4_5;
    const NUMBER K4_11c = -(K5_13 + Js4_16*UH4_2);
    const NUMBER K4_44b = Js4_45 - Js4_46*UH4_5;
    const NUMBER K4_13a = Js4_16*UH4_3 - K5_12;
    const NUMBER K4_14c = Js4_26*UH4_4 - Js4_24;
    const NUMBER K4_14d = Js4_26*UH4_5 - K5_36;
    const NUMBER K4_11d = Js4_22 - Js4_26*UH4_2;
    const NUMBER K4_44c = Js4_55 - Js4_56*UH4_5;
    const NUMBER K4_13b = -(K5_23 + Js4_26*UH4_3);
    const NUMBER K4_34a = Js4_34 - K5_25*UH4_4;
    const NUMBER K4_34b = K5_25*UH4_5 - Js4_35;
    const NUMBER K4_33 = Js4_33 - K5_25*UH4_3;
    const NUMBER K4_11e = sin_th4*(K4_11b - K4_11d) + K4_11a*K4_11c;
    const NUMBER K4_11f = sin_th4*K4_11e;
    const NUMBER K4_11 = K4_11b - K4_11f;
    const NUMBER K4_12 = cos_th4*K4_11e - K4_11c;
    const NUMBER K4_22 = K4_11d + K4_11f;
    const NUMBER K4_13 = -(cos_th4*K4_13a + sin_th4*K4_13b);
    const NUMBER K4_23 = cos_th4*K4_13b - sin_th4*K4_13a;
    const NUMBER K4_14e = sin_th4*(K4_14a + K4_14d) + cos_th4*(K4_14b - K4_14c);
    const NUMBER K4_14f = sin_th4*K4_14e;
    const NUMBER K4_14 = K4_14a - K4_14f;
    const NUMBER K4_15a = cos_th4*K4_14e;
    const NUMBER K4_15 = K4_14c + K4_15a;
    const NUMBER K4_24 = K4_15a - K4_14b;
    const NUMBER K4_25 = K4_14f - K4_14d;
    const NUMBER K4_16 = -(cos_th4*K4_16a + sin_th4*K4_16b);
    const NUMBER K4_26 = cos_th4*K4_16b - sin_th4*K4_16a;
    const NUMBER K4_34 = cos_th4*K4_34a + sin_th4*K4_34b;
    const NUMBER K4_35 = sin_th4*K4_34a - cos_th4*K4_34b;
    const NUMBER K4_44d = sin_th4*(K4_44a - K4_44c) + K4_11a*K4_44b;
    const NUMBER K4_44e = sin_th4*K4_44d;
    const NUMBER K4_44 = K4_44a - K4_44e;
    const NUMBER K4_45 = cos_th4*K4_44d - K4_44b;
    const NUMBER K4_55 = K4_44c + K4_44e;
    const NUMBER K4_46 = cos_th4*K4_46a - sin_th4*K4_46b;
    const NUMBER K4_56 = sin_th4*K4_46a + cos_th4*K4_46b;
    const NUMBER Gb4 = tau4 + bs4_6;
    const NUMBER qdf4 = Hinv4*Gb4;
    const NUMBER al4_1a = bs4_1 - Js4_16*qdf4;
    const NUMBER al4_1b = bs4_2 - Js4_26*qdf4;
    const NUMBER al4_4a = bs4_4 - Js4_46*qdf4;
    const NUMBER al4_4b = Js4_56*qdf4 - bs4_5;
    const NUMBER al4_1 = g4_1*K4_11 + g4_2*K4_12 + g4_3*K4_13 + g4_4*K4_14 + g4_5*K4_15 - (cos_th4*al4_1a - sin_th4*al4_1b);
    const NUMBER al4_2 = g4_1*K4_12 + g4_2*K4_22 + g4_3*K4_23 + g4_4*K4_24 + g4_5*K4_25 - (sin_th4*al4_1a + cos_th4*al4_1b);
    const NUMBER al4_3 = g4_1*K4_13 + g4_2*K4_23 + g4_3*K4_33 + g4_4*K4_34 + g4_5*K4_35 + K5_25*qdf4 - bs4_3;
    const NUMBER al4_4 = g4_1*K4_14 + g4_2*K4_24 + g4_3*K4_34 + g4_4*K4_44 + g4_5*K4_45 - (cos_th4*al4_4a + sin_th4*al4_4b);
    const NUMBER al4_5 = g4_1*K4_15 + g4_2*K4_25 + g4_3*K4_35 + g4_4*K4_45 + g4_5*K4_55 - (sin_th4*al4_4a - cos_th4*al4_4b);
    const NUMBER al4_6 = g4_1*K4_16 + g4_2*K4_26 + g4_3*K4_36 + g4_4*K4_46 + g4_5*K4_56 + tau4*UH4_6 - bs4_6*rho4;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32]. */
    const NUMBER K3_22a = 2.0*cos_th3;
    const NUMBER Js3_14a = -RL4*K4_12;
    const NUMBER Js3_14 = K4_14 + Js3_14a;
    const NUMBER Js3_16a = K4_15 + RL4*K4_11;
    const NUMBER Js3_34a = RL4*K4_22 - K4_24;
    const NUMBER Js3_36 = K4_25 - Js3_14a;
    const NUMBER Js3_11 = M3 + K4_11;
    const NUMBER Js3_22 = M3 + K4_33;
    const NUMBER Js3_33 = M3 + K4_22;
    const NUMBER Js3_15 = MZ3 + K4_16;
    const NUMBER Js3_16 = -(MY3 + Js3_16a);
    const NUMBER Js3_24 = K4_34 - RL4*K4_23 - MZ3;
    const NUMBER Js3_26 = MX3 - (K4_35 + RL4*K4_13);
    const NUMBER Js3_34 = MY3 + Js3_34a;
    const NUMBER Js3_35 = -(MX3 + K4_26);
    const NUMBER Js3_44 = XX3 + K4_44 + RL4*(Js3_34a - K4_24);
    const NUMBER Js3_45 = XY3 + K4_46 - RL4*K4_26;
    const NUMBER Js3_46 = XZ3 - (K4_45 + RL4*(K4_14 - Js3_36));
    const NUMBER Js3_55 = YY3 + K4_66;
    const NUMBER Js3_56 = YZ3 - (K4_56 + RL4*K4_16);
    const NUMBER Js3_66 = ZZ3 + K4_55 + RL4*(K4_15 + Js3_16a);
    const NUMBER bs3_1 = b3_1 - al4_1;
    const NUMBER bs3_2 = b3_2 - al4_3;
    const NUMBER bs3_3 = b3_3 + al4_2;
    const NUMBER bs3_4 = b3_4 + RL4*al4_2 - al4_4;
    const NUMBER bs3_5 = b3_5 - al4_6;
    const NUMBER bs3_6 = b3_6 + al4_5 + RL4*al4_1;
    const NUMBER H3 = IA3 + Js3_66;
    const NUMBER Hinv3 = 1.0/H3;
    const NUMBER rho3 = IA3*Hinv3;
    const NUMBER UH3_6 = Js3_66*Hinv3;
    const NUMBER UH3_1 = Js3_16*Hinv3;
    const NUMBER UH3_2 = Js3_26*Hinv3;
    const NUMBER UH3_3 = Js3_36*Hinv3;
    const NUMBER UH3_4 = Js3_46*Hinv3;
    const NUMBER UH3_5 = Js3_56*Hinv3;
    const NUMBER K3_36 = Js3_36*rho3;
    const NUMBER K3_46a = Js3_46*rho3;
    const NUMBER K3_46b = Js3_56*rho3;
    const NUMBER K3_66 = Js3_66*rho3;
    const NUMBER K3_44a = Js3_44 - Js3_46*UH3_4;
    const NUMBER K3_24a = Js3_15 - Js3_16*UH3_5;
    const NUMBER K3_44b = Js3_45 - Js3_46*UH3_5;
    const NUMBER K3_24b = Js3_26*UH3_5 - K4_36;
    const NUMBER K3_22b = Js3_22 - Js3_26*UH3_2;
    const NUMBER K3_44c = Js3_55 - Js3_56*UH3_5;
    const NUMBER K3_34a = Js3_34 - Js3_36*UH3_4;
    const NUMBER K3_34b = Js3_36*UH3_5 - Js3_35;
    const NUMBER K3_33 = Js3_33 - Js3_36*UH3_3;
    const NUMBER K3_22 = K3_22b + sin_th3*(sin_th3*(Js3_11 - Js3_16*UH3_1 - K3_22b) - K3_22a*(Js3_16*UH3_2 - K4_13));
    const NUMBER K3_23 = -(sin_th3*(K4_12 + Js3_16*UH3_3) + cos_th3*(K4_23 + Js3_26*UH3_3));
    const NUMBER K3_24c = sin_th3*(Js3_14 - Js3_16*UH3_4 + K3_24b) + cos_th3*(K3_24a - (Js3_26*UH3_4 - Js3_24));
    const NUMBER K3_24 = cos_th3*K3_24c - K3_24a;
    const NUMBER K3_25 = sin_th3*K3_24c - K3_24b;
    const NUMBER K3_26 = sin_th3*(Js3_16*rho3) + cos_th3*(Js3_26*rho3);
    const NUMBER K3_34 = cos_th3*K3_34a + sin_th3*K3_34b;
    const NUMBER K3_35 = sin_th3*K3_34a - cos_th3*K3_34b;
    const NUMBER K3_44d = sin_th3*(K3_44a - K3_44c) + K3_22a*K3_44b;
    const NUMBER K3_44e = sin_th3*K3_44d;
    const NUMBER K3_44 = K3_44a - K3_44e;
    const NUMBER K3_45 = cos_th3*K3_44d - K3_44b;
    const NUMBER K3_55 = K3_44c + K3_44e;
    const NUMBER K3_46 = cos_th3*K3_46a - sin_th3*K3_46b;
    const NUMBER K3_56 = sin_th3*K3_46a + cos_th3*K3_46b;
    const NUMBER Gb3 = tau3 + bs3_6;
    const NUMBER qdf3 = Hinv3*Gb3;
    const NUMBER al3_4a = bs3_4 - Js3_46*qdf3;
    const NUMBER al3_4b = Js3_56*qdf3 - bs3_5;
    const NUMBER al3_2 = g3_4*K3_24 + g3_5*K3_25 - (sin_th3*(bs3_1 - Js3_16*qdf3) + cos_th3*(bs3_2 - Js3_26*qdf3));
    const NUMBER al3_3 = g3_4*K3_34 + g3_5*K3_35 + Js3_36*qdf3 - bs3_3;
    const NUMBER al3_4 = g3_4*K3_44 + g3_5*K3_45 - (cos_th3*al3_4a + sin_th3*al3_4b);
    const NUMBER al3_5 = g3_4*K3_45 + g3_5*K3_55 - (sin_th3*al3_4a - cos_th3*al3_4b);
    const NUMBER al3_6 = g3_4*K3_46 + g3_5*K3_56 + tau3*UH3_6 - bs3_6*rho3;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32]. */
    const NUMBER Js2_36 = K3_36 + D3*K3_23;
    const NUMBER Js2_44 = XX2 + K3_44;
    const NUMBER Js2_45 = XY2 - (D3*K3_34 - K3_45);
    const NUMBER Js2_46 = XZ2 + K3_46 + D3*K3_24;
    const NUMBER Js2_55 = YY2 + K3_55 - D3*(K3_35 + K3_35 - D3*K3_33);
    const NUMBER Js2_56 = YZ2 + K3_56 - D3*(Js2_36 - K3_25);
    const NUMBER Js2_66 = ZZ2 + K3_66 + D3*(K3_26 + K3_26 + D3*K3_22);
    const NUMBER bs2_4 = b2_4 - al3_4;
    const NUMBER bs2_5 = b2_5 + D3*al3_3 - al3_5;
    const NUMBER bs2_6 = b2_6 - (al3_6 + D3*al3_2);
    const NUMBER H2 = IA2 + Js2_66;
    const NUMBER Hinv2 = 1.0/H2;
    const NUMBER UH2_4 = Js2_46*Hinv2;
    const NUMBER UH2_5 = Js2_56*Hinv2;
    const NUMBER K2_45a = Js2_45 - Js2_46*UH2_5;
    const NUMBER K2_45b = Js2_55 - Js2_56*UH2_5;
    const NUMBER K2_45c = sin_th2*(Js2_44 - Js2_46*UH2_4 - K2_45b) + 2.0*cos_th2*K2_45a;
    const NUMBER K2_45 = cos_th2*K2_45c - K2_45a;
    const NUMBER K2_55 = K2_45b + sin_th2*K2_45c;
    const NUMBER Gb2 = tau2 + bs2_6;
    const NUMBER qdf2 = Hinv2*Gb2;
    const NUMBER al2_5 = g2_4*K2_45 + sin_th2*(Js2_46*qdf2 - bs2_4) + cos_th2*(Js2_56*qdf2 - bs2_5);

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32]. */
    const NUMBER Js1_66 = ZZ1 + K2_55;
    const NUMBER H1 = IA1 + Js1_66;
    const NUMBER Gb1 = tau1 - al2_5;
    const NUMBER qdf1 = Gb1/H1;

    /* Forward recursion: accelerations and torques, joint 2 (j2) [33]-[36]. */
    const NUMBER wd2_x = cos_th2*g2_4 + sin_th2*qdf1;
    const NUMBER wd2_y = cos_th2*qdf1 - sin_th2*g2_4;
    const NUMBER qdd2 = qdf2 - (UH2_4*wd2_x + UH2_5*wd2_y);

    /* Forward recursion: accelerations and torques, joint 3 (j3) [33]-[36]. */
    const NUMBER Vr3_1a = D3*qdd2;
    const NUMBER Vr3_3 = -D3*wd2_y;
    const NUMBER wd3_xa = g3_4 + wd2_x;
    const NUMBER wd3_xb = -(g3_5 + wd2_y);
    const NUMBER Vr3_1 = sin_th3*Vr3_1a;
    const NUMBER Vr3_2 = cos_th3*Vr3_1a;
    const NUMBER wd3_x = cos_th3*wd3_xa - sin_th3*wd3_xb;
    const NUMBER wd3_y = -(sin_th3*wd3_xa + cos_th3*wd3_xb);
    const NUMBER qdd3 = qdf3 - (UH3_1*Vr3_1 + UH3_2*Vr3_2 + UH3_3*Vr3_3) - (UH3_4*wd3_x + UH3_5*wd3_y) - UH3_6*qdd2;
    const NUMBER wd3_z = qdd2 + qdd3;

    /* Forward recursion: accelerations and torques, joint 4 (j4) [33]-[36]. */
    const NUMBER vd4_xa = -(g4_1 + Vr3_1 - RL4*wd3_z);
    const NUMBER vd4_xb = Vr3_3 + RL4*wd3_x - g4_2;
    const NUMBER vd4_z = g4_3 + Vr3_2;
    const NUMBER wd4_xa = -(g4_4 + wd3_x);
    const NUMBER wd4_xb = wd3_z - g4_5;
    const NUMBER vd4_x = -(cos_th4*vd4_xa + sin_th4*vd4_xb);
    const NUMBER vd4_y = sin_th4*vd4_xa - cos_th4*vd4_xb;
    const NUMBER wd4_x = -(cos_th4*wd4_xa + sin_th4*wd4_xb);
    const NUMBER wd4_y = sin_th4*wd4_xa - cos_th4*wd4_xb;
    const NUMBER qdd4 = qdf4 - (UH4_1*vd4_x + UH4_2*vd4_y + UH4_3*vd4_z) - (UH4_4*wd4_x + UH4_5*wd4_y) - UH4_6*wd3_y;
    const NUMBER wd4_z = wd3_y + qdd4;

    /* Forward recursion: accelerations and torques, joint 5 (j5) [33]-[36]. */
    const NUMBER wd5_xa = g5_4 + wd4_x;
    const NUMBER wd5_xb = -(g5_5 + wd4_z);
    const NUMBER vd5_x = cos_th5*vd4_x + sin_th5*vd4_z;
    const NUMBER vd5_y = cos_th5*vd4_z - sin_th5*vd4_x;
    const NUMBER wd5_x = cos_th5*wd5_xa - sin_th5*wd5_xb;
    const NUMBER wd5_y = -(sin_th5*wd5_xa + cos_th5*wd5_xb);
    const NUMBER qdd5 = qdf5 - (UH5_1*vd5_x + UH5_2*vd5_y - UH5_3*vd4_y) - (UH5_4*wd5_x + UH5_5*wd5_y) + UH5_6*wd4_y;
    const NUMBER wd5_z = qdd5 - wd4_y;

    /* Forward recursion: accelerations and torques, joint 6 (j6) [33]-[36]. */
    const NUMBER qdd6 = qdf6 - (UH6_1*vd5_x + UH6_2*vd4_y) - (UH6_4*wd5_x - UH6_5*wd5_z) - UH6_6*wd5_y;

    /* Results. */
    STORE(qdd + 0*stride, qdf1);
    STORE(qdd + 1*stride, qdd2);
    STORE(qdd + 2*stride, qdd3);
    STORE(qdd + 3*stride, qdd4);
    STORE(qdd + 4*stride, qdd5);
    STORE(qdd + 5*stride, qdd6);
}

WHOLE void OF(rx90_direct_dynamics_at)(size_t stride, const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    ANGLE angle[5];
    ANGLE sine[5];
    ANGLE cosine[5];
    OF(rx90_direct_dynamics_angles)(stride, q, angle);
    if (OF(circles)(5, angle, sine, cosine)) {
        ANGLE far[5]; /* a copy, so that the angles themselves stay in registers */
        for (size_t k = 0; k < 5; k++)
            far[k] = angle[k];
        far_circles(5*(sizeof(ANGLE)/sizeof(double)), (const double *)far, (double *)sine, (double *)cosine);
    }
    OF(rx90_direct_dynamics_state)(stride, qd, tau, p, c, sine, cosine, qdd);
}

INLINE void OF(rx90_inverse_dynamics_angles)(size_t stride, const double *restrict q, ANGLE *restrict angle)
{
    (void)stride;
    const ANGLE th2 = LOAD(q + 1*stride);
    const ANGLE th3 = LOAD(q + 2*stride);
    const ANGLE th4 = LOAD(q + 3*stride);
    const ANGLE th5 = LOAD(q + 4*stride);
    const ANGLE th6 = LOAD(q + 5*stride);
    angle[0] = th2;
    angle[1] = th3;
    angle[2] = th4;
    angle[3] = th5;
    angle[4] = th6;
}

INLINE void OF(rx90_inverse_dynamics_state)(size_t stride, const double *restrict qd, const double *restrict qdd_motor, const double *restrict p, const double *restrict c, const ANGLE *restrict sine, const ANGLE *restrict cosine, double *restrict tau, double *restrict qdd)
{
    (void)stride;
    const NUMBER qd1 = LOAD(qd + 0*stride);
    const NUMBER qd2 = LOAD(qd + 1*stride);
    const NUMBER qd3 = LOAD(qd + 2*stride);
    const NUMBER qd4 = LOAD(qd + 3*stride);
    const NUMBER qd5 = LOAD(qd + 4*stride);
    const NUMBER qd6 = LOAD(qd + 5*stride);
    const NUMBER qdd1 = LOAD(qdd_motor + 0*stride);
    const NUMBER qdd2 = LOAD(qdd_motor + 1*stride);
    const NUMBER qdd3 = LOAD(qdd_motor + 2*stride);
    const NUMBER qdd4 = LOAD(qdd_motor + 3*stride);
    const NUMBER qdd5 = LOAD(qdd_motor + 4*stride);
    const NUMBER qdd6 = LOAD(qdd_motor + 5*stride);
    const double ZZ1 = p[RX90_P_ZZ1];
    const double IA1 = p[RX90_P_IA1];
    const double XX2 = p[RX90_P_XX2];
    const double XY2 = p[RX90_P_XY2];
    const double XZ2 = p[RX90_P_XZ2];
    const double YY2 = p[RX90_P_YY2];
    const double YZ2 = p[RX90_P_YZ2];
    const double ZZ2 = p[RX90_P_ZZ2];
    const double MX2 = p[RX90_P_MX2];
    const double MY2 = p[RX90_P_MY2];
    const double MZ2 = p[RX90_P_MZ2];
    const double IA2 = p[RX90_P_IA2];
    const double D3 = p[RX90_P_D3];
    const double XX3 = p[RX90_P_XX3];
    const double XY3 = p[RX90_P_XY3];
    const double XZ3 = p[RX90_P_XZ3];
    const double YY3 = p[RX90_P_YY3];
    const double YZ3 = p[RX90_P_YZ3];
    const double ZZ3 = p[RX90_P_ZZ3];
    const double MX3 = p[RX90_P_MX3];
    const double MY3 = p[RX90_P_MY3];
    const double MZ3 = p[RX90_P_MZ3];
    const double M3 = p[RX90_P_M3];
    const double IA3 = p[RX90_P_IA3];
    const double RL4 = p[RX90_P_RL4];
    const double XX4 = p[RX90_P_XX4];
    const double XY4 = p[RX90_P_XY4];
    const double XZ4 = p[RX90_P_XZ4];
    const double YY4 = p[RX90_P_YY4];
    const double YZ4 = p[RX90_P_YZ4];
    const double ZZ4 = p[RX90_P_ZZ4];
    const double MX4 = p[RX90_P_MX4];
    const double MY4 = p[RX90_P_MY4];
    const double MZ4 = p[RX90_P_MZ4];
    const double M4 = p[RX90_P_M4];
    const double IA4 = p[RX90_P_IA4];
    const double XX5 = p[RX90_P_XX5];
    const double XY5 = p[RX90_P_XY5];
    const double XZ5 = p[RX90_P_XZ5];
    const double YY5 = p[RX90_P_YY5];
    const double YZ5 = p[RX90_P_YZ5];
    const double ZZ5 = p[RX90_P_ZZ5];
    const double MX5 = p[RX90_P_MX5];
    const double MY5 = p[RX90_P_MY5];
    const double MZ5 = p[RX90_P_MZ5];
    const double M5 = p[RX90_P_M5];
    const double IA5 = p[RX90_P_IA5];
    const double XX6 = p[RX90_P_XX6];
    const double XY6 = p[RX90_P_XY6];
    const double XZ6 = p[RX90_P_XZ6];
    const double YY6 = p[RX90_P_YY6];
    const double YZ6 = p[RX90_P_YZ6];
    const double ZZ6 = p[RX90_P_ZZ6];
    const double MX6 = p[RX90_P_MX6];
    const double MY6 = p[RX90_P_MY6];
    const double MZ6 = p[RX90_P_MZ6];
    const double M6 = p[RX90_P_M6];
    const double IA6 = p[RX90_P_IA6];
    const double G3 = p[RX90_P_G3];
    const double dJ2_yz = c[0];
    const double dJ2_xz = c[1];
    const double dJ2_xy = c[2];
    const double dJ3_yz = c[3];
    const double dJ3_xz = c[4];
    const double dJ3_xy = c[5];
    const double dJ4_yz = c[6];
    const double dJ4_xz = c[7];
    const double dJ4_xy = c[8];
    const double dJ5_yz = c[9];
    const double dJ5_xz = c[10];
    const double dJ5_xy = c[11];
    const double dJ6_yz = c[12];
    const double dJ6_xz = c[13];
    const double dJ6_xy = c[14];

    /* Forward recursion: velocities, accelerations, wrenches, joint 1 (j1) [1], [3], [6], [12]. */
    const NUMBER ww1_zz = qd1*qd1;
    const NUMBER Fb1_6 = ZZ1*qdd1;

    /* Forward recursion: velocities, accelerations, wrenches, joint 2 (j2) [1], [3], [6], [12]. */
    const NUMBER sin_th2 = sine[0];
    const NUMBER cos_th2 = cosine[0];
    const NUMBER w2_x = qd1*sin_th2;
    const NUMBER w2_y = qd1*cos_th2;
    const NUMBER ww2_yz = qd2*w2_y;
    const NUMBER ww2_xz = qd2*w2_x;
    const NUMBER wd2_ya = qdd1*cos_th2;
    const NUMBER wd2_xa = qdd1*sin_th2;
    const NUMBER wd2_x = ww2_yz + wd2_xa;
    const NUMBER wd2_y = wd2_ya - ww2_xz;
    const NUMBER ww2_xx = w2_x*w2_x;
    const NUMBER ww2_xy = w2_x*w2_y;
    const NUMBER ww2_zz = qd2*qd2;
    const NUMBER Fb2_5a = ww2_xx - ww2_zz;
    const NUMBER Fb2_6a = ww1_zz - Fb2_5a;
    const NUMBER Fb2_4a = qdd2 + ww2_xy;
    const NUMBER Fb2_4b = ww2_xx + ww2_zz;
    const NUMBER Fb2_4c = ww2_xz - wd2_y;
    const NUMBER vd2_x = -G3*sin_th2;
    const NUMBER vd2_y = -G3*cos_th2;
    const NUMBER Fb2_4 = XX2*wd2_x - MZ2*vd2_y + YZ2*(ww1_zz - Fb2_4b) - ww2_yz*dJ2_yz + XZ2*Fb2_4a - XY2*Fb2_4c;
    const NUMBER Fb2_5 = YY2*wd2_y + MZ2*vd2_x - (XZ2*Fb2_5a - ww2_xz*dJ2_xz - YZ2*(qdd2 - ww2_xy) - XY2*(ww2_yz + wd2_x));
    const NUMBER Fb2_6 = ZZ2*qdd2 + MX2*vd2_y - MY2*vd2_x - (XY2*(Fb2_6a - Fb2_4b) + ww2_xy*dJ2_xy - YZ2*wd2_ya
        - XZ2*wd2_xa);

    /* Forward recursion: velocities, accelerations, wrenches, joint 3 (j3) [1], [3], [6], [12]. */
    const NUMBER sin_th3 = sine[1];
    const NUMBER cos_th3 = cosine[1];
    const NUMBER w3_x = cos_th3*w2_x + sin_th3*w2_y;
    const NUMBER w3_y = cos_th3*w2_y - sin_th3*w2_x;
    const NUMBER w3_z = qd2 + qd3;
    const NUMBER wd3_ya = cos_th3*wd2_ya - sin_th3*wd2_xa;
    const NUMBER wd3_xa = sin_th3*wd2_ya + cos_th3*wd2_xa;
    const NUMBER ww3_yz = w3_y*w3_z;
    const NUMBER wd3_x = wd3_xa + ww3_yz;
    const NUMBER ww3_xz = w3_x*w3_z;
    const NUMBER wd3_y = wd3_ya - ww3_xz;
    const NUMBER wd3_z = qdd2 + qdd3;
    const NUMBER ww3_xx = w3_x*w3_x;
    const NUMBER ww3_xy = w3_x*w3_y;
    const NUMBER ww3_zz = w3_z*w3_z;
    const NUMBER Fb3_1a = ww3_xx - ww3_zz;
    const NUMBER Fb3_1b = ww1_zz - Fb3_1a;
    const NUMBER Fb3_1c = wd3_z - ww3_xy;
    const NUMBER Fb3_2a = wd3_z + ww3_xy;
    const NUMBER Fb3_2b = ww3_xx + ww3_zz;
    const NUMBER Fb3_3a = ww3_xz - wd3_y;
    const NUMBER Fb3_3b = -(ww3_yz + wd3_x);
    const NUMBER vd3_z = D3*Fb2_4c;
    const NUMBER vd3_xa = D3*Fb2_6a - vd2_x;
    const NUMBER vd3_xb = -(vd2_y + D3*Fb2_4a);
    const NUMBER vd3_x = -(cos_th3*vd3_xa + sin_th3*vd3_xb);
    const NUMBER vd3_y = sin_th3*vd3_xa - cos_th3*vd3_xb;
    const NUMBER Fb3_1 = M3*vd3_x - (MX3*Fb3_1b + MY3*Fb3_1c - MZ3*wd3_ya);
    const NUMBER Fb3_2 = M3*vd3_y + MX3*Fb3_2a - MY3*Fb3_2b - MZ3*wd3_xa;
    const NUMBER Fb3_3 = M3*vd3_z + MX3*Fb3_3a - MY3*Fb3_3b - MZ3*ww1_zz;
    const NUMBER Fb3_4 = XX3*wd3_x + MY3*vd3_z - MZ3*vd3_y + YZ3*(ww1_zz - Fb3_2b) - ww3_yz*dJ3_yz + XZ3*Fb3_2a - XY3*Fb3_3a;
    const NUMBER Fb3_5 = YY3*wd3_y + MZ3*vd3_x - MX3*vd3_z - (XZ3*Fb3_1a - ww3_xz*dJ3_xz - YZ3*Fb3_1c + XY3*Fb3_3b);
    const NUMBER Fb3_6 = ZZ3*wd3_z + MX3*vd3_y - MY3*vd3_x - (XY3*(Fb3_1b - Fb3_2b) + ww3_xy*dJ3_xy - YZ3*wd3_ya
        - XZ3*wd3_xa);

    /* Forward recursion: velocities, accelerations, wrenches, joint 4 (j4) [1], [3], [6], [12]. */
    const NUMBER sin_th4 = sine[2];
    const NUMBER cos_th4 = cosine[2];
    const NUMBER w4_x = cos_th4*w3_x - sin_th4*w3_z;
    const NUMBER w4_y = -(sin_th4*w3_x + cos_th4*w3_z);
    const NUMBER w4_z = qd4 + w3_y;
    const NUMBER wd4_ya = cos_th4*Fb3_1c - sin_th4*Fb3_3b;
    const NUMBER wd4_xa = sin_th4*Fb3_1c + cos_th4*Fb3_3b;
    const NUMBER ww4_yz = w4_y*w4_z;
    const NUMBER wd4_x = ww4_yz - wd4_xa;
    const NUMBER ww4_xz = w4_x*w4_z;
    const NUMBER wd4_y = -(wd4_ya + ww4_xz);
    const NUMBER wd4_z = qdd4 + wd3_y;
    const NUMBER ww4_xx = w4_x*w4_x;
    const NUMBER ww4_xy = w4_x*w4_y;
    const NUMBER ww4_zz = w4_z*w4_z;
    const NUMBER Fb4_1a = ww4_xx - ww4_zz;
    const NUMBER Fb4_1b = Fb3_2b - Fb4_1a;
    const NUMBER Fb4_1c = wd4_z - ww4_xy;
    const NUMBER Fb4_2a = wd4_z + ww4_xy;
    const NUMBER Fb4_2b = ww4_xx + ww4_zz;
    const NUMBER Fb4_3a = ww4_xz - wd4_y;
    const NUMBER Fb4_3b = -(ww4_yz + wd4_x);
    const NUMBER vd4_x = -(sin_th4*vd3_z - cos_th4*vd3_x + RL4*wd4_ya);
    const NUMBER vd4_y = RL4*wd4_xa - (sin_th4*vd3_x + cos_th4*vd3_z);
    const NUMBER vd4_z = vd3_y - RL4*Fb3_2b;
    const NUMBER Fb4_1 = M4*vd4_x - (MX4*Fb4_1b + MY4*Fb4_1c + MZ4*wd4_ya);
    const NUMBER Fb4_2 = M4*vd4_y + MX4*Fb4_2a - MY4*Fb4_2b + MZ4*wd4_xa;
    const NUMBER Fb4_3 = M4*vd4_z + MX4*Fb4_3a - MY4*Fb4_3b - MZ4*Fb3_2b;
    const NUMBER Fb4_4 = YZ4*(Fb3_2b - Fb4_2b) - ww4_yz*dJ4_yz + XZ4*Fb4_2a - XY4*Fb4_3a - (MZ4*vd4_y
        - (XX4*wd4_x + MY4*vd4_z));
    const NUMBER Fb4_5 = -(MX4*vd4_z - (YY4*wd4_y + MZ4*vd4_x) + XZ4*Fb4_1a - ww4_xz*dJ4_xz - YZ4*Fb4_1c + XY4*Fb4_3b);
    const NUMBER Fb4_6 = ZZ4*wd4_z + MX4*vd4_y - MY4*vd4_x - (XY4*(Fb4_1b - Fb4_2b) + ww4_xy*dJ4_xy + YZ4*wd4_ya
        + XZ4*wd4_xa);

    /* Forward recursion: velocities, accelerations, wrenches, joint 5 (j5) [1], [3], [6], [12]. */
    const NUMBER sin_th5 = sine[3];
    const NUMBER cos_th5 = cosine[3];
    const NUMBER w5_x = cos_th5*w4_x + sin_th5*w4_z;
    const NUMBER w5_y = cos_th5*w4_z - sin_th5*w4_x;
    const NUMBER w5_z = qd5 - w4_y;
    const NUMBER wd5_ya = cos_th5*Fb4_1c + sin_th5*Fb4_3b;
    const NUMBER wd5_xa = sin_th5*Fb4_1c - cos_th5*Fb4_3b;
    const NUMBER ww5_yz = w5_y*w5_z;
    const NUMBER wd5_x = wd5_xa + ww5_yz;
    const NUMBER ww5_xz = w5_x*w5_z;
    const NUMBER wd5_y = wd5_ya - ww5_xz;
    const NUMBER wd5_z = qdd5 - wd4_y;
    const NUMBER ww5_xx = w5_x*w5_x;
    const NUMBER ww5_xy = w5_x*w5_y;
    const NUMBER ww5_zz = w5_z*w5_z;
    const NUMBER Fb5_1a = ww5_xx - ww5_zz;
    const NUMBER Fb5_1b = Fb4_2b - Fb5_1a;
    const NUMBER Fb5_1c = wd5_z - ww5_xy;
    const NUMBER Fb5_2a = wd5_z + ww5_xy;
    const NUMBER Fb5_2b = ww5_xx + ww5_zz;
    const NUMBER Fb5_3a = ww5_xz - wd5_y;
    const NUMBER Fb5_3b = -(ww5_yz + wd5_x);
    const NUMBER vd5_x = cos_th5*vd4_x + sin_th5*vd4_z;
    const NUMBER vd5_y = cos_th5*vd4_z - sin_th5*vd4_x;
    const NUMBER Fb5_1 = M5*vd5_x - (MX5*Fb5_1b + MY5*Fb5_1c - MZ5*wd5_ya);
    const NUMBER Fb5_2 = M5*vd5_y + MX5*Fb5_2a - MY5*Fb5_2b - MZ5*wd5_xa;
    const NUMBER Fb5_3 = MX5*Fb5_3a - MY5*Fb5_3b - MZ5*Fb4_2b - M5*vd4_y;
    const NUMBER Fb5_4 = XX5*wd5_x - MY5*vd4_y - MZ5*vd5_y + YZ5*(Fb4_2b - Fb5_2b) - ww5_yz*dJ5_yz + XZ5*Fb5_2a - XY5*Fb5_3a;
    const NUMBER Fb5_5 = YY5*wd5_y + MZ5*vd5_x + MX5*vd4_y - (XZ5*Fb5_1a - ww5_xz*dJ5_xz - YZ5*Fb5_1c + XY5*Fb5_3b);
    const NUMBER Fb5_6 = ZZ5*wd5_z + MX5*vd5_y - MY5*vd5_x - (XY5*(Fb5_1b - Fb5_2b) + ww5_xy*dJ5_xy - YZ5*wd5_ya
        - XZ5*wd5_xa);

    /* Forward recursion: velocities, accelerations, wrenches, joint 6 (j6) [1], [3], [6], [12]. */
    const NUMBER sin_th6 = sine[4];
    const NUMBER cos_th6 = cosine[4];
    const NUMBER w6_x = cos_th6*w5_x - sin_th6*w5_z;
    const NUMBER w6_y = -(sin_th6*w5_x + cos_th6*w5_z);
    const NUMBER w6_z = qd6 + w5_y;
    const NUMBER wd6_ya = cos_th6*Fb5_1c - sin_th6*Fb5_3b;
    const NUMBER wd6_xa = sin_th6*Fb5_1c + cos_th6*Fb5_3b;
    const NUMBER ww6_yz = w6_y*w6_z;
    const NUMBER wd6_x = ww6_yz - wd6_xa;
    const NUMBER ww6_xz = w6_x*w6_z;
    const NUMBER wd6_y = -(wd6_ya + ww6_xz);
    const NUMBER wd6_z = qdd6 + wd5_y;
    const NUMBER ww6_xx = w6_x*w6_x;
    const NUMBER ww6_xy = w6_x*w6_y;
    const NUMBER ww6_zz = w6_z*w6_z;
    const NUMBER Fb6_1a = ww6_xx - ww6_zz;
    const NUMBER Fb6_1b = Fb5_2b - Fb6_1a;
    const NUMBER Fb6_1c = wd6_z - ww6_xy;
    const NUMBER Fb6_2a = wd6_z + ww6_xy;
    const NUMBER Fb6_2b = ww6_xx + ww6_zz;
    const NUMBER Fb6_3a = ww6_xz - wd6_y;
    const NUMBER Fb6_3b = -(ww6_yz + wd6_x);
    const NUMBER vd6_x = cos_th6*vd5_x + sin_th6*vd4_y;
    const NUMBER vd6_y = cos_th6*vd4_y - sin_th6*vd5_x;
    const NUMBER Fb6_1 = M6*vd6_x - (MX6*Fb6_1b + MY6*Fb6_1c + MZ6*wd6_ya);
    const NUMBER Fb6_2 = M6*vd6_y + MX6*Fb6_2a - MY6*Fb6_2b + MZ6*wd6_xa;
    const NUMBER Fb6_3 = M6*vd5_y + MX6*Fb6_3a - MY6*Fb6_3b - MZ6*Fb5_2b;
    const NUMBER Fb6_4 = YZ6*(Fb5_2b - Fb6_2b) - ww6_yz*dJ6_yz + XZ6*Fb6_2a - XY6*Fb6_3a - (MZ6*vd6_y
        - (XX6*wd6_x + MY6*vd5_y));
    const NUMBER Fb6_5 = -(MX6*vd5_y - (YY6*wd6_y + MZ6*vd6_x) + XZ6*Fb6_1a - ww6_xz*dJ6_xz - YZ6*Fb6_1c + XY6*Fb6_3b);
    const NUMBER Fb6_6 = ZZ6*wd6_z + MX6*vd6_y - MY6*vd6_x - (XY6*(Fb6_1b - Fb6_2b) + ww6_xy*dJ6_xy + YZ6*wd6_ya
        + XZ6*wd6_xa);

    /* Backward recursion: articulated inertias and wrenches, joint 5 (j5) [50]-[56]. */
    const NUMBER f5_1 = Fb5_1 - (sin_th6*Fb6_2 - cos_th6*Fb6_1);
    const NUMBER f5_2 = Fb5_2 + Fb6_3;
    const NUMBER f5_3 = Fb5_3 - (sin_th6*Fb6_1 + cos_th6*Fb6_2);
    const NUMBER f5_4 = Fb5_4 - (sin_th6*Fb6_5 - cos_th6*Fb6_4);
    const NUMBER f5_5 = Fb5_5 + Fb6_6;
    const NUMBER f5_6 = Fb5_6 - (sin_th6*Fb6_4 + cos_th6*Fb6_5);

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [50]-[56]. */
    const NUMBER f4_1 = Fb4_1 - (sin_th5*f5_2 - cos_th5*f5_1);
    const NUMBER f4_2 = Fb4_2 - f5_3;
    const NUMBER f4_3 = Fb4_3 + sin_th5*f5_1 + cos_th5*f5_2;
    const NUMBER f4_4 = Fb4_4 + cos_th5*f5_4 - sin_th5*f5_5;
    const NUMBER f4_5 = Fb4_5 - f5_6;
    const NUMBER f4_6 = Fb4_6 + sin_th5*f5_4 + cos_th5*f5_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [50]-[56]. */
    const NUMBER f3_4a = RL4*f4_2 - f4_4;
    const NUMBER f3_4b = -(f4_5 + RL4*f4_1);
    const NUMBER f3_1 = Fb3_1 - (sin_th4*f4_2 - cos_th4*f4_1);
    const NUMBER f3_2 = Fb3_2 + f4_3;
    const NUMBER f3_3 = Fb3_3 - (sin_th4*f4_1 + cos_th4*f4_2);
    const NUMBER f3_4 = Fb3_4 - (cos_th4*f3_4a - sin_th4*f3_4b);
    const NUMBER f3_5 = Fb3_5 + f4_6;
    const NUMBER f3_6 = Fb3_6 + sin_th4*f3_4a + cos_th4*f3_4b;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [50]-[56]. */
    const NUMBER f2_4 = Fb2_4 + cos_th3*f3_4 - sin_th3*f3_5;
    const NUMBER f2_5 = Fb2_5 + sin_th3*f3_4 + cos_th3*f3_5 - D3*f3_3;
    const NUMBER f2_6 = Fb2_6 + f3_6 + D3*(sin_th3*f3_1 + cos_th3*f3_2);

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [50]-[56]. */
    const NUMBER f1_6 = Fb1_6 + sin_th2*f2_4 + cos_th2*f2_5;

    /* Forward recursion: accelerations and torques, joint 1 (j1) [57]-[61]. */
    const NUMBER Gamma1 = f1_6 + IA1*qdd1;

    /* Forward recursion: accelerations and torques, joint 2 (j2) [57]-[61]. */
    const NUMBER Gamma2 = f2_6 + IA2*qdd2;

    /* Forward recursion: accelerations and torques, joint 3 (j3) [57]-[61]. */
    const NUMBER Gamma3 = f3_6 + IA3*qdd3;

    /* Forward recursion: accelerations and torques, joint 4 (j4) [57]-[61]. */
    const NUMBER Gamma4 = f4_6 + IA4*qdd4;

    /* Forward recursion: accelerations and torques, joint 5 (j5) [57]-[61]. */
    const NUMBER Gamma5 = f5_6 + IA5*qdd5;

    /* Forward recursion: accelerations and torques, joint 6 (j6) [57]-[61]. */
    const NUMBER Gamma6 = Fb6_6 + IA6*qdd6;

    /* Results. */
    STORE(tau + 0*stride, Gamma1);
    STORE(tau + 1*stride, Gamma2);
    STORE(tau + 2*stride, Gamma3);
    STORE(tau + 3*stride, Gamma4);
    STORE(tau + 4*stride, Gamma5);
    STORE(tau + 5*stride, Gamma6);
    STORE(qdd + 0*stride, qdd1);
    STORE(qdd + 1*stride, qdd2);
    STORE(qdd + 2*stride, qdd3);
    STORE(qdd + 3*stride, qdd4);
    STORE(qdd + 4*stride, qdd5);
    STORE(qdd + 5*stride, qdd6);
}

WHOLE void OF(rx90_inverse_dynamics_at)(size_t stride, const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    ANGLE angle[5];
    ANGLE sine[5];
    ANGLE cosine[5];
    OF(rx90_inverse_dynamics_angles)(stride, q, angle);
    if (OF(circles)(5, angle, sine, cosine)) {
        ANGLE far[5]; /* a copy, so that the angles themselves stay in registers */
        for (size_t k = 0; k < 5; k++)
            far[k] = angle[k];
        far_circles(5*(sizeof(ANGLE)/sizeof(double)), (const double *)far, (double *)sine, (double *)cosine);
    }
    OF(rx90_inverse_dynamics_state)(stride, qd, qdd_motor, p, c, sine, cosine, tau, qdd);
}

#endif
