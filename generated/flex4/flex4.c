/* flex4: generated models in double precision. Equation numbers are those of Khalil and Gautier.
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

#include "flex4.h"

#define EQUATIONS 3658434138
#ifdef __GNUC__
#define INLINE static inline __attribute__((always_inline, unused))
#define APART static __attribute__((noinline, unused))
#else
#define INLINE static inline
#define APART static
#endif
#define EXCESS (FLT_EVAL_METHOD%16 != 0) /* whether numbers are kept longer than their type */

const double flex4_defaults[FLEX4_PARAMETERS] = {
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
    NAN, /* k2 */
    NAN, /* L2 */
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
    NAN, /* k4 */
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
#include "flex4.c"
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
#include "flex4.c"

INLINE void flex4_direct_dynamics_constants(const double *restrict p, double *restrict c)
{
    const double ZZ1 = p[FLEX4_P_ZZ1];
    const double IA1 = p[FLEX4_P_IA1];
    const double L2 = p[FLEX4_P_L2];
    const double XZ3 = p[FLEX4_P_XZ3];
    const double YZ3 = p[FLEX4_P_YZ3];
    const double ZZ3 = p[FLEX4_P_ZZ3];
    const double M3 = p[FLEX4_P_M3];
    const double IA3 = p[FLEX4_P_IA3];
    const double XX4 = p[FLEX4_P_XX4];
    const double XY4 = p[FLEX4_P_XY4];
    const double YY4 = p[FLEX4_P_YY4];
    const double ZZ4 = p[FLEX4_P_ZZ4];
    const double M4 = p[FLEX4_P_M4];

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const double dJ4_xy = XX4 - YY4;
    const double Js4_44a = 2.0*XY4;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32]. */
    const double Hinv4 = 1.0/ZZ4;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32]. */
    const double Js3_33 = M3 + M4;
    const double H3 = ZZ3 + IA3;
    const double Hinv3 = 1.0/H3;
    const double UH3_4 = XZ3*Hinv3;
    const double UH3_5 = YZ3*Hinv3;
    const double K3_45a = XZ3*UH3_4;
    const double K3_45b = XZ3*UH3_5;
    const double K3_45c = YZ3*UH3_5;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32]. */
    const double Js2_66a = L2*Js3_33;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32]. */
    const double H1 = ZZ1 + IA1;

    c[0] = dJ4_xy;
    c[1] = Js4_44a;
    c[2] = Hinv4;
    c[3] = Hinv3;
    c[4] = UH3_4;
    c[5] = UH3_5;
    c[6] = K3_45a;
    c[7] = K3_45b;
    c[8] = K3_45c;
    c[9] = Js2_66a;
    c[10] = H1;
}

void flex4_direct_dynamics_prepare(const double *p, double *c)
{
    flex4_direct_dynamics_constants(p, c);
}

void flex4_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    flex4_direct_dynamics_at(1, q, qd, tau, p, c, qdd);
}

void flex4_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[FLEX4_DIRECT_DYNAMICS_CONSTANTS];
    flex4_direct_dynamics_prepare(p, c);
    flex4_direct_dynamics_prepared(q, qd, tau, p, c, qdd);
}

void flex4_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[FLEX4_DIRECT_DYNAMICS_CONSTANTS];
    flex4_direct_dynamics_prepare(p, c);
    size_t first = 0;
    for (; states < WIDTH && first < states; first++)
        flex4_direct_dynamics_at(states, q + first, qd + first, tau + first, p, c, qdd + first);
    for (; first < states; first += WIDTH) {
        if (first + WIDTH > states)
            first = states - WIDTH; /* The last ones overlap with those before. */
        LANES(flex4_direct_dynamics_at)(states, q + first, qd + first, tau + first, p, c, qdd + first);
    }
}

INLINE void flex4_inverse_dynamics_constants(const double *restrict p, double *restrict c)
{
    const double L2 = p[FLEX4_P_L2];
    const double M3 = p[FLEX4_P_M3];
    const double XX4 = p[FLEX4_P_XX4];
    const double XY4 = p[FLEX4_P_XY4];
    const double YY4 = p[FLEX4_P_YY4];
    const double ZZ4 = p[FLEX4_P_ZZ4];
    const double M4 = p[FLEX4_P_M4];

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const double dJ4_xy = XX4 - YY4;
    const double Js4_44a = 2.0*XY4;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [50]-[56]. */
    const double Hinv4 = 1.0/ZZ4;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [50]-[56]. */
    const double Js3_33 = M3 + M4;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [50]-[56]. */
    const double Js2_66a = L2*Js3_33;

    c[0] = dJ4_xy;
    c[1] = Js4_44a;
    c[2] = Hinv4;
    c[3] = Js2_66a;
}

void flex4_inverse_dynamics_prepare(const double *p, double *c)
{
    flex4_inverse_dynamics_constants(p, c);
}

void flex4_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    flex4_inverse_dynamics_at(1, q, qd, qdd_motor, p, c, tau, qdd);
}

void flex4_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[FLEX4_INVERSE_DYNAMICS_CONSTANTS];
    flex4_inverse_dynamics_prepare(p, c);
    flex4_inverse_dynamics_prepared(q, qd, qdd_motor, p, c, tau, qdd);
}

void flex4_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[FLEX4_INVERSE_DYNAMICS_CONSTANTS];
    flex4_inverse_dynamics_prepare(p, c);
    size_t first = 0;
    for (; states < WIDTH && first < states; first++)
        flex4_inverse_dynamics_at(states, q + first, qd + first, qdd_motor + first, p, c, tau + first, qdd + first);
    for (; first < states; first += WIDTH) {
        if (first + WIDTH > states)
            first = states - WIDTH; /* The last ones overlap with those before. */
        LANES(flex4_inverse_dynamics_at)(states, q + first, qd + first, qdd_motor + first, p, c, tau + first, qdd + first);
    }
}

#else /* The equations. */
#if EQUATIONS != 3658434138
#error "this flex4.c is not the file that includes it: a generated file keeps its name"
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

INLINE void OF(flex4_direct_dynamics_angles)(size_t stride, const double *restrict q, ANGLE *restrict angle)
{
    (void)stride;
    const ANGLE th3 = LOAD(q + 2*stride);
    const ANGLE th4 = LOAD(q + 3*stride);
    angle[0] = th3;
    angle[1] = th4;
}

INLINE void OF(flex4_direct_dynamics_state)(size_t stride, const double *restrict q, const double *restrict qd, const double *restrict tau, const double *restrict p, const double *restrict c, const ANGLE *restrict sine, const ANGLE *restrict cosine, double *restrict qdd)
{
    (void)stride;
    const NUMBER th2 = LOAD(q + 1*stride);
    const NUMBER th4 = LOAD(q + 3*stride);
    const NUMBER qd1 = LOAD(qd + 0*stride);
    const NUMBER qd2 = LOAD(qd + 1*stride);
    const NUMBER qd3 = LOAD(qd + 2*stride);
    const NUMBER qd4 = LOAD(qd + 3*stride);
    const NUMBER tau1 = LOAD(tau + 0*stride);
    const NUMBER tau3 = LOAD(tau + 1*stride);
    const double ZZ2 = p[FLEX4_P_ZZ2];
    const double k2 = p[FLEX4_P_k2];
    const double L2 = p[FLEX4_P_L2];
    const double XX3 = p[FLEX4_P_XX3];
    const double XY3 = p[FLEX4_P_XY3];
    const double XZ3 = p[FLEX4_P_XZ3];
    const double YY3 = p[FLEX4_P_YY3];
    const double YZ3 = p[FLEX4_P_YZ3];
    const double ZZ3 = p[FLEX4_P_ZZ3];
    const double MX3 = p[FLEX4_P_MX3];
    const double MY3 = p[FLEX4_P_MY3];
    const double MZ3 = p[FLEX4_P_MZ3];
    const double XX4 = p[FLEX4_P_XX4];
    const double XY4 = p[FLEX4_P_XY4];
    const double XZ4 = p[FLEX4_P_XZ4];
    const double YY4 = p[FLEX4_P_YY4];
    const double YZ4 = p[FLEX4_P_YZ4];
    const double ZZ4 = p[FLEX4_P_ZZ4];
    const double MX4 = p[FLEX4_P_MX4];
    const double MY4 = p[FLEX4_P_MY4];
    const double MZ4 = p[FLEX4_P_MZ4];
    const double k4 = p[FLEX4_P_k4];
    const double G3 = p[FLEX4_P_G3];
    const double dJ4_xy = c[0];
    const double Js4_44a = c[1];
    const double Hinv4 = c[2];
    const double Hinv3 = c[3];
    const double UH3_4 = c[4];
    const double UH3_5 = c[5];
    const double K3_45a = c[6];
    const double K3_45b = c[7];
    const double K3_45c = c[8];
    const double Js2_66a = c[9];
    const double H1 = c[10];

    /* Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14]. */
    const NUMBER w2_z = qd1 + qd2;

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const NUMBER sin_th3 = sine[0];
    const NUMBER cos_th3 = cosine[0];
    const NUMBER w3_x = sin_th3*w2_z;
    const NUMBER w3_y = cos_th3*w2_z;
    const NUMBER Vk3_1a = w2_z*(L2*w2_z);
    const NUMBER g3_4 = qd3*w2_z;
    const NUMBER Vk3_1 = -(cos_th3*Vk3_1a + G3*sin_th3);
    const NUMBER Vk3_2 = sin_th3*Vk3_1a - G3*cos_th3;
    const NUMBER b3_3 = w3_y*(MZ3*w3_y - MY3*qd3) - w3_x*(MX3*qd3 - MZ3*w3_x);
    const NUMBER b3_5a = XX3*w3_x + XY3*w3_y + XZ3*qd3;
    const NUMBER b3_4a = XY3*w3_x + YY3*w3_y + YZ3*qd3;
    const NUMBER b3_4b = XZ3*w3_x + YZ3*w3_y + ZZ3*qd3;
    const NUMBER b3_4 = MZ3*Vk3_2 - (w3_y*b3_4b - qd3*b3_4a);
    const NUMBER b3_5 = -(qd3*b3_5a - w3_x*b3_4b + MZ3*Vk3_1);
    const NUMBER b3_6 = -(w3_x*b3_4a - w3_y*b3_5a + MX3*Vk3_2 - MY3*Vk3_1);

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const NUMBER sin_th4 = sine[1];
    const NUMBER cos_th4 = cosine[1];
    const NUMBER Js4_26 = MX4*cos_th4 - MY4*sin_th4;
    const NUMBER Js4_16 = -(MX4*sin_th4 + MY4*cos_th4);
    const NUMBER Js4_46 = XZ4*cos_th4 - YZ4*sin_th4;
    const NUMBER Js4_56 = XZ4*sin_th4 + YZ4*cos_th4;
    const NUMBER w4_z = qd3 + qd4;
    const NUMBER b4_3a = qd4*w3_y;
    const NUMBER b4_3b = qd4*w3_x;
    const NUMBER b4_4a = Js4_46*w3_x + Js4_56*w3_y + ZZ4*w4_z;
    const NUMBER b4_3 = -(w3_x*(Js4_26*w4_z - MZ4*w3_x) - w3_y*(MZ4*w3_y + Js4_16*w4_z) + Js4_26*b4_3b - Js4_16*b4_3a);
    const NUMBER Js4_44b = sin_th4*dJ4_xy + cos_th4*Js4_44a;
    const NUMBER Js4_44c = sin_th4*Js4_44b;
    const NUMBER Js4_44 = XX4 - Js4_44c;
    const NUMBER Js4_45 = cos_th4*Js4_44b - XY4;
    const NUMBER Js4_55 = YY4 + Js4_44c;
    const NUMBER b4_5a = Js4_46*w4_z + w3_x*Js4_44 + w3_y*Js4_45;
    const NUMBER b4_4b = Js4_56*w4_z + w3_x*Js4_45 + w3_y*Js4_55;
    const NUMBER b4_4 = MZ4*Vk3_2 - (b4_3a*Js4_44 - b4_3b*Js4_45) - (w3_y*b4_4a - w4_z*b4_4b);
    const NUMBER b4_5 = w3_x*b4_4a - w4_z*b4_5a + b4_3b*Js4_55 - b4_3a*Js4_45 - MZ4*Vk3_1;
    const NUMBER b4_6 = -(Js4_16*Vk3_1 + Js4_26*Vk3_2 + Js4_46*b4_3a - Js4_56*b4_3b + w3_x*b4_4b - w3_y*b4_5a);

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32]. */
    const NUMBER Gamma4 = -k4*th4;
    const NUMBER UH4_4 = Js4_46*Hinv4;
    const NUMBER UH4_5 = Js4_56*Hinv4;
    const NUMBER K4_44 = Js4_44 - Js4_46*UH4_4;
    const NUMBER K4_45 = Js4_45 - Js4_46*UH4_5;
    const NUMBER K4_55 = Js4_55 - Js4_56*UH4_5;
    const NUMBER Gb4 = Gamma4 + b4_6;
    const NUMBER qdf4 = Hinv4*Gb4;
    const NUMBER al4_4 = Js4_46*qdf4 - b4_4;
    const NUMBER al4_5 = Js4_56*qdf4 - b4_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32]. */
    const NUMBER Js3_34 = MY3 - Js4_16;
    const NUMBER Js3_35 = -(MX3 + Js4_26);
    const NUMBER bs3_3 = b3_3 + b4_3;
    const NUMBER bs3_6 = b3_6 - Gamma4;
    const NUMBER K3_34 = cos_th3*Js3_34 - sin_th3*Js3_35;
    const NUMBER K3_35 = sin_th3*Js3_34 + cos_th3*Js3_35;
    const NUMBER Gb3 = tau3 + bs3_6;
    const NUMBER qdf3 = Hinv3*Gb3;
    const NUMBER al3_3 = g3_4*K3_34 - bs3_3;
    const NUMBER Js3_44 = XX3 + K4_44;
    const NUMBER Js3_45 = XY3 + K4_45;
    const NUMBER Js3_55 = YY3 + K4_55;
    const NUMBER bs3_4 = b3_4 - al4_4;
    const NUMBER bs3_5 = b3_5 - al4_5;
    const NUMBER K3_45d = K3_45b - Js3_45;
    const NUMBER K3_45e = K3_45c - Js3_55;
    const NUMBER K3_45f = sin_th3*(K3_45a - Js3_44 - K3_45e) + 2.0*cos_th3*K3_45d;
    const NUMBER K3_45 = K3_45d - cos_th3*K3_45f;
    const NUMBER K3_55 = -(K3_45e + sin_th3*K3_45f);
    const NUMBER al3_5 = g3_4*K3_45 + sin_th3*(XZ3*qdf3 - bs3_4) + cos_th3*(YZ3*qdf3 - bs3_5);

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32]. */
    const NUMBER Gamma2 = -k2*th2;
    const NUMBER Js2_66 = ZZ2 - (L2*(K3_35 + K3_35 - Js2_66a) - K3_55);
    const NUMBER bs2_6 = L2*al3_3 - al3_5;
    const NUMBER Gb2 = Gamma2 + bs2_6;
    const NUMBER qdf2 = Gb2/Js2_66;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32]. */
    const NUMBER Gb1 = tau1 - Gamma2;
    const NUMBER qdf1 = Gb1/H1;

    /* Forward recursion: accelerations and torques, joint 2 (j2) [33]-[36]. */
    const NUMBER qdd2 = qdf2 - qdf1;

    /* Forward recursion: accelerations and torques, joint 3 (j3) [33]-[36]. */
    const NUMBER wd3_x = cos_th3*g3_4 + sin_th3*qdf2;
    const NUMBER wd3_y = cos_th3*qdf2 - sin_th3*g3_4;
    const NUMBER qdd3 = qdf3 - (UH3_4*wd3_x + UH3_5*wd3_y);

    /* Forward recursion: accelerations and torques, joint 4 (j4) [33]-[36]. */
    const NUMBER wd4_z = qdf4 - (UH4_4*wd3_x + UH4_5*wd3_y);
    const NUMBER qdd4 = wd4_z - qdd3;

    /* Results. */
    STORE(qdd + 0*stride, qdf1);
    STORE(qdd + 1*stride, qdd2);
    STORE(qdd + 2*stride, qdd3);
    STORE(qdd + 3*stride, qdd4);
}

WHOLE void OF(flex4_direct_dynamics_at)(size_t stride, const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    ANGLE angle[2];
    ANGLE sine[2];
    ANGLE cosine[2];
    OF(flex4_direct_dynamics_angles)(stride, q, angle);
    if (OF(circles)(2, angle, sine, cosine)) {
        ANGLE far[2]; /* a copy, so that the angles themselves stay in registers */
        for (size_t k = 0; k < 2; k++)
            far[k] = angle[k];
        far_circles(2*(sizeof(ANGLE)/sizeof(double)), (const double *)far, (double *)sine, (double *)cosine);
    }
    OF(flex4_direct_dynamics_state)(stride, q, qd, tau, p, c, sine, cosine, qdd);
}

INLINE void OF(flex4_inverse_dynamics_angles)(size_t stride, const double *restrict q, ANGLE *restrict angle)
{
    (void)stride;
    const ANGLE th3 = LOAD(q + 2*stride);
    const ANGLE th4 = LOAD(q + 3*stride);
    angle[0] = th3;
    angle[1] = th4;
}

INLINE void OF(flex4_inverse_dynamics_state)(size_t stride, const double *restrict q, const double *restrict qd, const double *restrict qdd_motor, const double *restrict p, const double *restrict c, const ANGLE *restrict sine, const ANGLE *restrict cosine, double *restrict tau, double *restrict qdd)
{
    (void)stride;
    const NUMBER th2 = LOAD(q + 1*stride);
    const NUMBER th4 = LOAD(q + 3*stride);
    const NUMBER qd1 = LOAD(qd + 0*stride);
    const NUMBER qd2 = LOAD(qd + 1*stride);
    const NUMBER qd3 = LOAD(qd + 2*stride);
    const NUMBER qd4 = LOAD(qd + 3*stride);
    const NUMBER qdd1 = LOAD(qdd_motor + 0*stride);
    const NUMBER qdd3 = LOAD(qdd_motor + 1*stride);
    const double ZZ1 = p[FLEX4_P_ZZ1];
    const double IA1 = p[FLEX4_P_IA1];
    const double ZZ2 = p[FLEX4_P_ZZ2];
    const double k2 = p[FLEX4_P_k2];
    const double L2 = p[FLEX4_P_L2];
    const double XX3 = p[FLEX4_P_XX3];
    const double XY3 = p[FLEX4_P_XY3];
    const double XZ3 = p[FLEX4_P_XZ3];
    const double YY3 = p[FLEX4_P_YY3];
    const double YZ3 = p[FLEX4_P_YZ3];
    const double ZZ3 = p[FLEX4_P_ZZ3];
    const double MX3 = p[FLEX4_P_MX3];
    const double MY3 = p[FLEX4_P_MY3];
    const double MZ3 = p[FLEX4_P_MZ3];
    const double IA3 = p[FLEX4_P_IA3];
    const double XX4 = p[FLEX4_P_XX4];
    const double XY4 = p[FLEX4_P_XY4];
    const double XZ4 = p[FLEX4_P_XZ4];
    const double YY4 = p[FLEX4_P_YY4];
    const double YZ4 = p[FLEX4_P_YZ4];
    const double ZZ4 = p[FLEX4_P_ZZ4];
    const double MX4 = p[FLEX4_P_MX4];
    const double MY4 = p[FLEX4_P_MY4];
    const double MZ4 = p[FLEX4_P_MZ4];
    const double k4 = p[FLEX4_P_k4];
    const double G3 = p[FLEX4_P_G3];
    const double dJ4_xy = c[0];
    const double Js4_44a = c[1];
    const double Hinv4 = c[2];
    const double Js2_66a = c[3];

    /* Forward recursion: velocities, accelerations, wrenches, joint 1 (j1) [1], [3], [6], [12]. */
    const NUMBER Fb1_6 = ZZ1*qdd1;

    /* Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14]. */
    const NUMBER w2_z = qd1 + qd2;

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const NUMBER sin_th3 = sine[0];
    const NUMBER cos_th3 = cosine[0];
    const NUMBER w3_x = sin_th3*w2_z;
    const NUMBER w3_y = cos_th3*w2_z;
    const NUMBER Vk3_1a = w2_z*(L2*w2_z);
    const NUMBER g3_4 = qd3*w2_z;
    const NUMBER Vk3_1 = -(cos_th3*Vk3_1a + G3*sin_th3);
    const NUMBER Vk3_2 = sin_th3*Vk3_1a - G3*cos_th3;
    const NUMBER b3_3 = w3_y*(MZ3*w3_y - MY3*qd3) - w3_x*(MX3*qd3 - MZ3*w3_x);
    const NUMBER b3_5a = XX3*w3_x + XY3*w3_y + XZ3*qd3;
    const NUMBER b3_4a = XY3*w3_x + YY3*w3_y + YZ3*qd3;
    const NUMBER b3_4b = XZ3*w3_x + YZ3*w3_y + ZZ3*qd3;
    const NUMBER b3_4 = MZ3*Vk3_2 - (w3_y*b3_4b - qd3*b3_4a);
    const NUMBER b3_5 = -(qd3*b3_5a - w3_x*b3_4b + MZ3*Vk3_1);
    const NUMBER b3_6 = -(w3_x*b3_4a - w3_y*b3_5a + MX3*Vk3_2 - MY3*Vk3_1);

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const NUMBER sin_th4 = sine[1];
    const NUMBER cos_th4 = cosine[1];
    const NUMBER Js4_26 = MX4*cos_th4 - MY4*sin_th4;
    const NUMBER Js4_16 = -(MX4*sin_th4 + MY4*cos_th4);
    const NUMBER Js4_46 = XZ4*cos_th4 - YZ4*sin_th4;
    const NUMBER Js4_56 = XZ4*sin_th4 + YZ4*cos_th4;
    const NUMBER w4_z = qd3 + qd4;
    const NUMBER b4_3a = qd4*w3_y;
    const NUMBER b4_3b = qd4*w3_x;
    const NUMBER b4_4a = Js4_46*w3_x + Js4_56*w3_y + ZZ4*w4_z;
    const NUMBER b4_3 = -(w3_x*(Js4_26*w4_z - MZ4*w3_x) - w3_y*(MZ4*w3_y + Js4_16*w4_z) + Js4_26*b4_3b - Js4_16*b4_3a);
    const NUMBER Js4_44b = sin_th4*dJ4_xy + cos_th4*Js4_44a;
    const NUMBER Js4_44c = sin_th4*Js4_44b;
    const NUMBER Js4_44 = XX4 - Js4_44c;
    const NUMBER Js4_45 = cos_th4*Js4_44b - XY4;
    const NUMBER Js4_55 = YY4 + Js4_44c;
    const NUMBER b4_5a = Js4_46*w4_z + w3_x*Js4_44 + w3_y*Js4_45;
    const NUMBER b4_4b = Js4_56*w4_z + w3_x*Js4_45 + w3_y*Js4_55;
    const NUMBER b4_4 = MZ4*Vk3_2 - (b4_3a*Js4_44 - b4_3b*Js4_45) - (w3_y*b4_4a - w4_z*b4_4b);
    const NUMBER b4_5 = w3_x*b4_4a - w4_z*b4_5a + b4_3b*Js4_55 - b4_3a*Js4_45 - MZ4*Vk3_1;
    const NUMBER b4_6 = -(Js4_16*Vk3_1 + Js4_26*Vk3_2 + Js4_46*b4_3a - Js4_56*b4_3b + w3_x*b4_4b - w3_y*b4_5a);

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [50]-[56]. */
    const NUMBER Gamma4 = -k4*th4;
    const NUMBER UH4_4 = Js4_46*Hinv4;
    const NUMBER UH4_5 = Js4_56*Hinv4;
    const NUMBER K4_44 = Js4_44 - Js4_46*UH4_4;
    const NUMBER K4_45 = Js4_45 - Js4_46*UH4_5;
    const NUMBER K4_55 = Js4_55 - Js4_56*UH4_5;
    const NUMBER Gb4 = Gamma4 + b4_6;
    const NUMBER qdf4 = Hinv4*Gb4;
    const NUMBER al4_4 = Js4_46*qdf4 - b4_4;
    const NUMBER al4_5 = Js4_56*qdf4 - b4_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [50]-[56]. */
    const NUMBER Js3_34 = MY3 - Js4_16;
    const NUMBER Js3_35 = -(MX3 + Js4_26);
    const NUMBER bs3_3 = b3_3 + b4_3;
    const NUMBER bs3_6 = b3_6 - Gamma4;
    const NUMBER K3_34 = cos_th3*Js3_34 - sin_th3*Js3_35;
    const NUMBER K3_35 = sin_th3*Js3_34 + cos_th3*Js3_35;
    const NUMBER K3_46 = XZ3*cos_th3 - YZ3*sin_th3;
    const NUMBER K3_56 = XZ3*sin_th3 + YZ3*cos_th3;
    const NUMBER al3_3 = g3_4*K3_34 - bs3_3;
    const NUMBER al3_6 = g3_4*K3_46 - (bs3_6 - ZZ3*qdd3);
    const NUMBER Js3_44 = XX3 + K4_44;
    const NUMBER Js3_45 = XY3 + K4_45;
    const NUMBER Js3_55 = YY3 + K4_55;
    const NUMBER bs3_4 = b3_4 - al4_4;
    const NUMBER bs3_5 = b3_5 - al4_5;
    const NUMBER K3_45a = sin_th3*(Js3_44 - Js3_55) + 2.0*cos_th3*Js3_45;
    const NUMBER K3_45 = cos_th3*K3_45a - Js3_45;
    const NUMBER K3_55 = Js3_55 + sin_th3*K3_45a;
    const NUMBER al3_5 = g3_4*K3_45 + sin_th3*(XZ3*qdd3 - bs3_4) + cos_th3*(YZ3*qdd3 - bs3_5);

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [50]-[56]. */
    const NUMBER Gamma2 = -k2*th2;
    const NUMBER Js2_66 = ZZ2 - (L2*(K3_35 + K3_35 - Js2_66a) - K3_55);
    const NUMBER bs2_6 = L2*al3_3 - al3_5;
    const NUMBER Gb2 = Gamma2 + bs2_6;
    const NUMBER qdf2 = Gb2/Js2_66;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [50]-[56]. */
    const NUMBER f1_6 = Gamma2 + Fb1_6;

    /* Forward recursion: accelerations and torques, joint 1 (j1) [57]-[61]. */
    const NUMBER Gamma1 = f1_6 + IA1*qdd1;

    /* Forward recursion: accelerations and torques, joint 2 (j2) [57]-[61]. */
    const NUMBER qdd2 = qdf2 - qdd1;

    /* Forward recursion: accelerations and torques, joint 3 (j3) [57]-[61]. */
    const NUMBER f3_6 = al3_6 + K3_56*qdf2;
    const NUMBER wd3_x = cos_th3*g3_4 + sin_th3*qdf2;
    const NUMBER wd3_y = cos_th3*qdf2 - sin_th3*g3_4;
    const NUMBER Gamma3 = IA3*qdd3 + f3_6;

    /* Forward recursion: accelerations and torques, joint 4 (j4) [57]-[61]. */
    const NUMBER wd4_z = qdf4 - (UH4_4*wd3_x + UH4_5*wd3_y);
    const NUMBER qdd4 = wd4_z - qdd3;

    /* Results. */
    STORE(tau + 0*stride, Gamma1);
    STORE(tau + 1*stride, Gamma3);
    STORE(qdd + 0*stride, qdd1);
    STORE(qdd + 1*stride, qdd2);
    STORE(qdd + 2*stride, qdd3);
    STORE(qdd + 3*stride, qdd4);
}

WHOLE void OF(flex4_inverse_dynamics_at)(size_t stride, const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    ANGLE angle[2];
    ANGLE sine[2];
    ANGLE cosine[2];
    OF(flex4_inverse_dynamics_angles)(stride, q, angle);
    if (OF(circles)(2, angle, sine, cosine)) {
        ANGLE far[2]; /* a copy, so that the angles themselves stay in registers */
        for (size_t k = 0; k < 2; k++)
            far[k] = angle[k];
        far_circles(2*(sizeof(ANGLE)/sizeof(double)), (const double *)far, (double *)sine, (double *)cosine);
    }
    OF(flex4_inverse_dynamics_state)(stride, q, qd, qdd_motor, p, c, sine, cosine, tau, qdd);
}

#endif
