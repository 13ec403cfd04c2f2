/* rx90: generated models in double precision. Equation numbers are those of Khalil and Gautier.
 *
 * Fastest with -O3 -march=native -ffp-contract=fast -fno-math-errno -fno-trapping-math, and for AVX-512
 * -mprefer-vector-width=512. Not with -ffast-math, which costs accuracy.
 * A batch computes LANES states side by side; a number of states that is a large power of two makes caches slow. Entry k of an input is at k*stride, of a work array or result at k*lanes.
 */
#include <math.h>
#include <stdint.h>
#include <string.h>

#include "rx90.h"

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

INLINE void rx90_direct_dynamics_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double th2 = q[1*stride];
    const double th3 = q[2*stride];
    const double th4 = q[3*stride];
    const double th5 = q[4*stride];
    const double th6 = q[5*stride];
    angle[0*lanes] = th2;
    angle[1*lanes] = th3;
    angle[2*lanes] = th4;
    angle[3*lanes] = th5;
    angle[4*lanes] = th6;
}

INLINE void rx90_direct_dynamics_state(size_t stride, size_t lanes, const double *restrict qd, const double *restrict tau, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict qdd)
{
    (void)stride, (void)lanes;
    const double qd1 = qd[0*stride];
    const double qd2 = qd[1*stride];
    const double qd3 = qd[2*stride];
    const double qd4 = qd[3*stride];
    const double qd5 = qd[4*stride];
    const double qd6 = qd[5*stride];
    const double tau1 = tau[0*stride];
    const double tau2 = tau[1*stride];
    const double tau3 = tau[2*stride];
    const double tau4 = tau[3*stride];
    const double tau5 = tau[4*stride];
    const double tau6 = tau[5*stride];
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
    const double sin_th2 = sine[0*lanes];
    const double cos_th2 = cosine[0*lanes];
    const double w2_x = qd1*sin_th2;
    const double w2_y = qd1*cos_th2;
    const double g2_4 = qd1*qd2;
    const double Vk2_1 = -G3*sin_th2;
    const double Vk2_2 = -G3*cos_th2;
    const double b2_5a = XX2*w2_x + XY2*w2_y + XZ2*qd2;
    const double b2_4a = XY2*w2_x + YY2*w2_y + YZ2*qd2;
    const double b2_4b = XZ2*w2_x + YZ2*w2_y + ZZ2*qd2;
    const double b2_4 = MZ2*Vk2_2 - (w2_y*b2_4b - qd2*b2_4a);
    const double b2_5 = -(qd2*b2_5a - w2_x*b2_4b + MZ2*Vk2_1);
    const double b2_6 = -(w2_x*b2_4a - w2_y*b2_5a + MX2*Vk2_2 - MY2*Vk2_1);

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const double sin_th3 = sine[1*lanes];
    const double cos_th3 = cosine[1*lanes];
    const double w3_x = cos_th3*w2_x + sin_th3*w2_y;
    const double w3_y = cos_th3*w2_y - sin_th3*w2_x;
    const double w3_z = qd2 + qd3;
    const double Vk3_3a = D3*qd2;
    const double Vk3_1a = D3*w2_y;
    const double Vk3_3 = w2_x*Vk3_3a;
    const double g3_4 = qd3*w2_y;
    const double g3_5 = -qd3*w2_x;
    const double Vk3_1b = w2_y*Vk3_1a + qd2*Vk3_3a - Vk2_1;
    const double Vk3_1c = w2_x*Vk3_1a + Vk2_2;
    const double Vk3_1 = sin_th3*Vk3_1c - cos_th3*Vk3_1b;
    const double Vk3_2 = sin_th3*Vk3_1b + cos_th3*Vk3_1c;
    const double b3_2a = MY3*w3_z - MZ3*w3_y;
    const double b3_1a = MX3*w3_z - MZ3*w3_x;
    const double b3_1b = MY3*w3_x - MX3*w3_y;
    const double b3_5a = XX3*w3_x + XY3*w3_y + XZ3*w3_z;
    const double b3_4a = XY3*w3_x + YY3*w3_y + YZ3*w3_z;
    const double b3_4b = XZ3*w3_x + YZ3*w3_y + ZZ3*w3_z;
    const double b3_1 = w3_z*b3_1a - w3_y*b3_1b - M3*Vk3_1;
    const double b3_2 = w3_z*b3_2a + w3_x*b3_1b - M3*Vk3_2;
    const double b3_3 = -(w3_x*b3_1a + w3_y*b3_2a + M3*Vk3_3);
    const double b3_4 = w3_z*b3_4a - w3_y*b3_4b + MZ3*Vk3_2 - MY3*Vk3_3;
    const double b3_5 = MX3*Vk3_3 - MZ3*Vk3_1 - (w3_z*b3_5a - w3_x*b3_4b);
    const double b3_6 = -(w3_x*b3_4a - w3_y*b3_5a + MX3*Vk3_2 - MY3*Vk3_1);

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const double sin_th4 = sine[2*lanes];
    const double cos_th4 = cosine[2*lanes];
    const double w4_x = cos_th4*w3_x - sin_th4*w3_z;
    const double w4_y = -(sin_th4*w3_x + cos_th4*w3_z);
    const double w4_z = qd4 + w3_y;
    const double g4_2a = RL4*w3_z;
    const double g4_1a = RL4*w3_x;
    const double g4_4 = -qd4*w3_z;
    const double g4_5 = -qd4*w3_x;
    const double g4_1 = w3_y*g4_1a + Vk3_1;
    const double g4_2 = -(Vk3_3 + w3_y*g4_2a);
    const double g4_3 = Vk3_2 - (w3_x*g4_1a + w3_z*g4_2a);
    const double b4_2a = MY4*w4_z - MZ4*w4_y;
    const double b4_1a = MX4*w4_z - MZ4*w4_x;
    const double b4_1b = MY4*w4_x - MX4*w4_y;
    const double b4_1 = w4_z*b4_1a - w4_y*b4_1b;
    const double b4_2 = w4_z*b4_2a + w4_x*b4_1b;
    const double b4_3 = -(w4_x*b4_1a + w4_y*b4_2a);
    const double b4_5a = XX4*w4_x + XY4*w4_y + XZ4*w4_z;
    const double b4_4a = XY4*w4_x + YY4*w4_y + YZ4*w4_z;
    const double b4_4b = XZ4*w4_x + YZ4*w4_y + ZZ4*w4_z;
    const double b4_4 = w4_z*b4_4a - w4_y*b4_4b;
    const double b4_5 = w4_x*b4_4b - w4_z*b4_5a;
    const double b4_6 = w4_y*b4_5a - w4_x*b4_4a;

    /* Forward recursion: velocities, joint 5 (j5) [1], [3], [7], [14]. */
    const double sin_th5 = sine[3*lanes];
    const double cos_th5 = cosine[3*lanes];
    const double w5_x = cos_th5*w4_x + sin_th5*w4_z;
    const double w5_y = cos_th5*w4_z - sin_th5*w4_x;
    const double w5_z = qd5 - w4_y;
    const double g5_4 = qd5*w4_z;
    const double g5_5 = -qd5*w4_x;
    const double b5_2a = MY5*w5_z - MZ5*w5_y;
    const double b5_1a = MX5*w5_z - MZ5*w5_x;
    const double b5_1b = MY5*w5_x - MX5*w5_y;
    const double b5_1 = w5_z*b5_1a - w5_y*b5_1b;
    const double b5_2 = w5_z*b5_2a + w5_x*b5_1b;
    const double b5_3 = -(w5_x*b5_1a + w5_y*b5_2a);
    const double b5_5a = XX5*w5_x + XY5*w5_y + XZ5*w5_z;
    const double b5_4a = XY5*w5_x + YY5*w5_y + YZ5*w5_z;
    const double b5_4b = XZ5*w5_x + YZ5*w5_y + ZZ5*w5_z;
    const double b5_4 = w5_z*b5_4a - w5_y*b5_4b;
    const double b5_5 = w5_x*b5_4b - w5_z*b5_5a;
    const double b5_6 = w5_y*b5_5a - w5_x*b5_4a;

    /* Forward recursion: velocities, joint 6 (j6) [1], [3], [7], [14]. */
    const double sin_th6 = sine[4*lanes];
    const double cos_th6 = cosine[4*lanes];
    const double Js6_26 = MX6*cos_th6 - MY6*sin_th6;
    const double Js6_16 = -(MX6*sin_th6 + MY6*cos_th6);
    const double Js6_46 = XZ6*cos_th6 - YZ6*sin_th6;
    const double Js6_56 = XZ6*sin_th6 + YZ6*cos_th6;
    const double w6_z = qd6 + w5_y;
    const double b6_2a = qd6*w5_z;
    const double b6_1a = qd6*w5_x;
    const double b6_2b = MZ6*w5_z - Js6_16*w6_z;
    const double b6_1b = Js6_26*w6_z - MZ6*w5_x;
    const double b6_1c = Js6_26*w5_z - Js6_16*w5_x;
    const double b6_4a = Js6_46*w5_x - Js6_56*w5_z + ZZ6*w6_z;
    const double b6_1 = w5_z*b6_1c + w6_z*b6_1b + MZ6*b6_1a;
    const double b6_2 = w6_z*b6_2b + w5_x*b6_1c - MZ6*b6_2a;
    const double b6_3 = -(w5_x*b6_1b - w5_z*b6_2b + Js6_16*b6_2a + Js6_26*b6_1a);
    const double Js6_44b = sin_th6*dJ6_xy + cos_th6*Js6_44a;
    const double Js6_44c = sin_th6*Js6_44b;
    const double Js6_44 = XX6 - Js6_44c;
    const double Js6_45 = cos_th6*Js6_44b - XY6;
    const double Js6_55 = YY6 + Js6_44c;
    const double b6_5a = Js6_46*w6_z + w5_x*Js6_44 - w5_z*Js6_45;
    const double b6_4b = Js6_56*w6_z - (w5_z*Js6_55 - w5_x*Js6_45);
    const double b6_4 = w5_z*b6_4a + w6_z*b6_4b + b6_2a*Js6_44 + b6_1a*Js6_45;
    const double b6_5 = w5_x*b6_4a - w6_z*b6_5a + b6_2a*Js6_45 + b6_1a*Js6_55;
    const double b6_6 = Js6_46*b6_2a + Js6_56*b6_1a - (w5_x*b6_4b + w5_z*b6_5a);

    /* Backward recursion: articulated inertias and wrenches, joint 6 (j6) [28]-[32]. */
    const double UH6_1 = Js6_16*Hinv6;
    const double UH6_2 = Js6_26*Hinv6;
    const double UH6_4 = Js6_46*Hinv6;
    const double UH6_5 = Js6_56*Hinv6;
    const double K6_16 = Js6_16*rho6;
    const double K6_26 = Js6_26*rho6;
    const double K6_46 = Js6_46*rho6;
    const double K6_56 = Js6_56*rho6;
    const double K6_14 = -Js6_16*UH6_4;
    const double K6_11 = M6 - Js6_16*UH6_1;
    const double K6_15 = MZ6 - Js6_16*UH6_5;
    const double K6_12 = -Js6_16*UH6_2;
    const double K6_24 = -(MZ6 + Js6_26*UH6_4);
    const double K6_25 = -Js6_26*UH6_5;
    const double K6_22 = M6 - Js6_26*UH6_2;
    const double K6_44 = Js6_44 - Js6_46*UH6_4;
    const double K6_45 = Js6_45 - Js6_46*UH6_5;
    const double K6_55 = Js6_55 - Js6_56*UH6_5;
    const double Gb6 = tau6 + b6_6;
    const double qdf6 = Hinv6*Gb6;
    const double al6_1 = Js6_16*qdf6 - b6_1;
    const double al6_2 = Js6_26*qdf6 - b6_2;
    const double al6_4 = Js6_46*qdf6 - b6_4;
    const double al6_5 = Js6_56*qdf6 - b6_5;
    const double al6_6 = tau6*UH6_6 - rho6*b6_6;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (j5) [28]-[32]. */
    const double Js5_11 = M5 + K6_11;
    const double Js5_33 = M5 + K6_22;
    const double Js5_15 = MZ5 + K6_16;
    const double Js5_16 = -(MY5 + K6_15);
    const double Js5_24 = -(MZ5 + Js6_16);
    const double Js5_26 = MX5 + Js6_26;
    const double Js5_34 = MY5 - K6_24;
    const double Js5_35 = -(MX5 + K6_26);
    const double Js5_45 = XY5 + K6_46;
    const double Js5_56 = YZ5 - K6_56;
    const double bs5_2 = b5_2 + b6_3;
    const double K5_11a = 2.0*cos_th5;
    const double Js5_44 = XX5 + K6_44;
    const double Js5_46 = XZ5 - K6_45;
    const double Js5_66 = ZZ5 + K6_55;
    const double bs5_1 = b5_1 - al6_1;
    const double bs5_3 = b5_3 + al6_2;
    const double bs5_4 = b5_4 - al6_4;
    const double bs5_5 = b5_5 - al6_6;
    const double bs5_6 = b5_6 + al6_5;
    const double H5 = IA5 + Js5_66;
    const double Hinv5 = 1.0/H5;
    const double rho5 = IA5*Hinv5;
    const double UH5_6 = Js5_66*Hinv5;
    const double UH5_1 = Js5_16*Hinv5;
    const double UH5_2 = Js5_26*Hinv5;
    const double UH5_3 = K6_25*Hinv5;
    const double UH5_4 = Js5_46*Hinv5;
    const double UH5_5 = Js5_56*Hinv5;
    const double K5_16a = -Js5_16*rho5;
    const double K5_16b = Js5_26*rho5;
    const double K5_36 = K6_25*rho5;
    const double K5_46a = Js5_46*rho5;
    const double K5_46b = Js5_56*rho5;
    const double K5_66 = Js5_66*rho5;
    const double K5_14a = K6_14 - Js5_16*UH5_4;
    const double K5_11b = Js5_11 - Js5_16*UH5_1;
    const double K5_44a = Js5_44 - Js5_46*UH5_4;
    const double K5_14b = Js5_15 - Js5_16*UH5_5;
    const double K5_11c = -Js5_16*UH5_2;
    const double K5_44b = Js5_45 - Js5_46*UH5_5;
    const double K5_13a = K6_12 + Js5_16*UH5_3;
    const double K5_14c = Js5_26*UH5_4 - Js5_24;
    const double K5_14d = Js5_26*UH5_5;
    const double K5_11d = Js5_22 - Js5_26*UH5_2;
    const double K5_44c = Js5_55 - Js5_56*UH5_5;
    const double K5_13b = -Js5_26*UH5_3;
    const double K5_34a = Js5_34 - K6_25*UH5_4;
    const double K5_34b = K6_25*UH5_5 - Js5_35;
    const double K5_33 = Js5_33 - K6_25*UH5_3;
    const double K5_11e = sin_th5*(K5_11b - K5_11d) + K5_11a*K5_11c;
    const double K5_11f = sin_th5*K5_11e;
    const double K5_11 = K5_11b - K5_11f;
    const double K5_12 = cos_th5*K5_11e - K5_11c;
    const double K5_22 = K5_11d + K5_11f;
    const double K5_13 = -(cos_th5*K5_13a + sin_th5*K5_13b);
    const double K5_23 = cos_th5*K5_13b - sin_th5*K5_13a;
    const double K5_14e = sin_th5*(K5_14a + K5_14d) + cos_th5*(K5_14b - K5_14c);
    const double K5_14f = sin_th5*K5_14e;
    const double K5_14 = K5_14a - K5_14f;
    const double K5_15a = cos_th5*K5_14e;
    const double K5_15 = K5_14c + K5_15a;
    const double K5_24 = K5_15a - K5_14b;
    const double K5_25 = K5_14f - K5_14d;
    const double K5_16 = -(cos_th5*K5_16a + sin_th5*K5_16b);
    const double K5_26 = cos_th5*K5_16b - sin_th5*K5_16a;
    const double K5_34 = cos_th5*K5_34a + sin_th5*K5_34b;
    const double K5_35 = sin_th5*K5_34a - cos_th5*K5_34b;
    const double K5_44d = sin_th5*(K5_44a - K5_44c) + K5_11a*K5_44b;
    const double K5_44e = sin_th5*K5_44d;
    const double K5_44 = K5_44a - K5_44e;
    const double K5_45 = cos_th5*K5_44d - K5_44b;
    const double K5_55 = K5_44c + K5_44e;
    const double K5_46 = cos_th5*K5_46a - sin_th5*K5_46b;
    const double K5_56 = sin_th5*K5_46a + cos_th5*K5_46b;
    const double Gb5 = tau5 + bs5_6;
    const double qdf5 = Hinv5*Gb5;
    const double al5_1a = bs5_1 - Js5_16*qdf5;
    const double al5_1b = bs5_2 - Js5_26*qdf5;
    const double al5_4a = bs5_4 - Js5_46*qdf5;
    const double al5_4b = Js5_56*qdf5 - bs5_5;
    const double al5_1 = g5_4*K5_14 + g5_5*K5_15 - (cos_th5*al5_1a - sin_th5*al5_1b);
    const double al5_2 = g5_4*K5_24 + g5_5*K5_25 - (sin_th5*al5_1a + cos_th5*al5_1b);
    const double al5_3 = g5_4*K5_34 + g5_5*K5_35 + K6_25*qdf5 - bs5_3;
    const double al5_4 = g5_4*K5_44 + g5_5*K5_45 - (cos_th5*al5_4a + sin_th5*al5_4b);
    const double al5_5 = g5_4*K5_45 + g5_5*K5_55 - (sin_th5*al5_4a - cos_th5*al5_4b);
    const double al5_6 = g5_4*K5_46 + g5_5*K5_56 + tau5*UH5_6 - bs5_6*rho5;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32]. */
    const double K4_11a = 2.0*cos_th4;
    const double Js4_11 = M4 + K5_11;
    const double Js4_22 = M4 + K5_33;
    const double Js4_33 = M4 + K5_22;
    const double Js4_15 = MZ4 - K5_16;
    const double Js4_16 = K5_15 - MY4;
    const double Js4_24 = -(MZ4 + K5_34);
    const double Js4_26 = MX4 - K5_35;
    const double Js4_34 = MY4 + K5_24;
    const double Js4_35 = -(MX4 + K5_26);
    const double Js4_44 = XX4 + K5_44;
    const double Js4_45 = XY4 - K5_46;
    const double Js4_46 = XZ4 + K5_45;
    const double Js4_55 = YY4 + K5_66;
    const double Js4_56 = YZ4 - K5_56;
    const double Js4_66 = ZZ4 + K5_55;
    const double bs4_1 = b4_1 - al5_1;
    const double bs4_2 = b4_2 + al5_3;
    const double bs4_3 = b4_3 - al5_2;
    const double bs4_4 = b4_4 - al5_4;
    const double bs4_5 = b4_5 + al5_6;
    const double bs4_6 = b4_6 - al5_5;
    const double H4 = IA4 + Js4_66;
    const double Hinv4 = 1.0/H4;
    const double rho4 = IA4*Hinv4;
    const double UH4_6 = Js4_66*Hinv4;
    const double UH4_1 = Js4_16*Hinv4;
    const double UH4_2 = Js4_26*Hinv4;
    const double UH4_3 = K5_25*Hinv4;
    const double UH4_4 = Js4_46*Hinv4;
    const double UH4_5 = Js4_56*Hinv4;
    const double K4_16a = -Js4_16*rho4;
    const double K4_16b = Js4_26*rho4;
    const double K4_36 = K5_25*rho4;
    const double K4_46a = Js4_46*rho4;
    const double K4_46b = Js4_56*rho4;
    const double K4_66 = Js4_66*rho4;
    const double K4_14a = K5_14 - Js4_16*UH4_4;
    const double K4_11b = Js4_11 - Js4_16*UH4_1;
    const double K4_44a = Js4_44 - Js4_46*UH4_4;
    const double K4_14b = Js4_15 - Js4_16*UH4_5;
    const double K4_11c = -(K5_13 + Js4_16*UH4_2);
    const double K4_44b = Js4_45 - Js4_46*UH4_5;
    const double K4_13a = Js4_16*UH4_3 - K5_12;
    const double K4_14c = Js4_26*UH4_4 - Js4_24;
    const double K4_14d = Js4_26*UH4_5 - K5_36;
    const double K4_11d = Js4_22 - Js4_26*UH4_2;
    const double K4_44c = Js4_55 - Js4_56*UH4_5;
    const double K4_13b = -(K5_23 + Js4_26*UH4_3);
    const double K4_34a = Js4_34 - K5_25*UH4_4;
    const double K4_34b = K5_25*UH4_5 - Js4_35;
    const double K4_33 = Js4_33 - K5_25*UH4_3;
    const double K4_11e = sin_th4*(K4_11b - K4_11d) + K4_11a*K4_11c;
    const double K4_11f = sin_th4*K4_11e;
    const double K4_11 = K4_11b - K4_11f;
    const double K4_12 = cos_th4*K4_11e - K4_11c;
    const double K4_22 = K4_11d + K4_11f;
    const double K4_13 = -(cos_th4*K4_13a + sin_th4*K4_13b);
    const double K4_23 = cos_th4*K4_13b - sin_th4*K4_13a;
    const double K4_14e = sin_th4*(K4_14a + K4_14d) + cos_th4*(K4_14b - K4_14c);
    const double K4_14f = sin_th4*K4_14e;
    const double K4_14 = K4_14a - K4_14f;
    const double K4_15a = cos_th4*K4_14e;
    const double K4_15 = K4_14c + K4_15a;
    const double K4_24 = K4_15a - K4_14b;
    const double K4_25 = K4_14f - K4_14d;
    const double K4_16 = -(cos_th4*K4_16a + sin_th4*K4_16b);
    const double K4_26 = cos_th4*K4_16b - sin_th4*K4_16a;
    const double K4_34 = cos_th4*K4_34a + sin_th4*K4_34b;
    const double K4_35 = sin_th4*K4_34a - cos_th4*K4_34b;
    const double K4_44d = sin_th4*(K4_44a - K4_44c) + K4_11a*K4_44b;
    const double K4_44e = sin_th4*K4_44d;
    const double K4_44 = K4_44a - K4_44e;
    const double K4_45 = cos_th4*K4_44d - K4_44b;
    const double K4_55 = K4_44c + K4_44e;
    const double K4_46 = cos_th4*K4_46a - sin_th4*K4_46b;
    const double K4_56 = sin_th4*K4_46a + cos_th4*K4_46b;
    const double Gb4 = tau4 + bs4_6;
    const double qdf4 = Hinv4*Gb4;
    const double al4_1a = bs4_1 - Js4_16*qdf4;
    const double al4_1b = bs4_2 - Js4_26*qdf4;
    const double al4_4a = bs4_4 - Js4_46*qdf4;
    const double al4_4b = Js4_56*qdf4 - bs4_5;
    const double al4_1 = g4_1*K4_11 + g4_2*K4_12 + g4_3*K4_13 + g4_4*K4_14 + g4_5*K4_15 - (cos_th4*al4_1a - sin_th4*al4_1b);
    const double al4_2 = g4_1*K4_12 + g4_2*K4_22 + g4_3*K4_23 + g4_4*K4_24 + g4_5*K4_25 - (sin_th4*al4_1a + cos_th4*al4_1b);
    const double al4_3 = g4_1*K4_13 + g4_2*K4_23 + g4_3*K4_33 + g4_4*K4_34 + g4_5*K4_35 + K5_25*qdf4 - bs4_3;
    const double al4_4 = g4_1*K4_14 + g4_2*K4_24 + g4_3*K4_34 + g4_4*K4_44 + g4_5*K4_45 - (cos_th4*al4_4a + sin_th4*al4_4b);
    const double al4_5 = g4_1*K4_15 + g4_2*K4_25 + g4_3*K4_35 + g4_4*K4_45 + g4_5*K4_55 - (sin_th4*al4_4a - cos_th4*al4_4b);
    const double al4_6 = g4_1*K4_16 + g4_2*K4_26 + g4_3*K4_36 + g4_4*K4_46 + g4_5*K4_56 + tau4*UH4_6 - bs4_6*rho4;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32]. */
    const double K3_22a = 2.0*cos_th3;
    const double Js3_14a = -RL4*K4_12;
    const double Js3_14 = K4_14 + Js3_14a;
    const double Js3_16a = K4_15 + RL4*K4_11;
    const double Js3_34a = RL4*K4_22 - K4_24;
    const double Js3_36 = K4_25 - Js3_14a;
    const double Js3_11 = M3 + K4_11;
    const double Js3_22 = M3 + K4_33;
    const double Js3_33 = M3 + K4_22;
    const double Js3_15 = MZ3 + K4_16;
    const double Js3_16 = -(MY3 + Js3_16a);
    const double Js3_24 = K4_34 - RL4*K4_23 - MZ3;
    const double Js3_26 = MX3 - (K4_35 + RL4*K4_13);
    const double Js3_34 = MY3 + Js3_34a;
    const double Js3_35 = -(MX3 + K4_26);
    const double Js3_44 = XX3 + K4_44 + RL4*(Js3_34a - K4_24);
    const double Js3_45 = XY3 + K4_46 - RL4*K4_26;
    const double Js3_46 = XZ3 - (K4_45 + RL4*(K4_14 - Js3_36));
    const double Js3_55 = YY3 + K4_66;
    const double Js3_56 = YZ3 - (K4_56 + RL4*K4_16);
    const double Js3_66 = ZZ3 + K4_55 + RL4*(K4_15 + Js3_16a);
    const double bs3_1 = b3_1 - al4_1;
    const double bs3_2 = b3_2 - al4_3;
    const double bs3_3 = b3_3 + al4_2;
    const double bs3_4 = b3_4 + RL4*al4_2 - al4_4;
    const double bs3_5 = b3_5 - al4_6;
    const double bs3_6 = b3_6 + al4_5 + RL4*al4_1;
    const double H3 = IA3 + Js3_66;
    const double Hinv3 = 1.0/H3;
    const double rho3 = IA3*Hinv3;
    const double UH3_6 = Js3_66*Hinv3;
    const double UH3_1 = Js3_16*Hinv3;
    const double UH3_2 = Js3_26*Hinv3;
    const double UH3_3 = Js3_36*Hinv3;
    const double UH3_4 = Js3_46*Hinv3;
    const double UH3_5 = Js3_56*Hinv3;
    const double K3_36 = Js3_36*rho3;
    const double K3_46a = Js3_46*rho3;
    const double K3_46b = Js3_56*rho3;
    const double K3_66 = Js3_66*rho3;
    const double K3_44a = Js3_44 - Js3_46*UH3_4;
    const double K3_24a = Js3_15 - Js3_16*UH3_5;
    const double K3_44b = Js3_45 - Js3_46*UH3_5;
    const double K3_24b = Js3_26*UH3_5 - K4_36;
    const double K3_22b = Js3_22 - Js3_26*UH3_2;
    const double K3_44c = Js3_55 - Js3_56*UH3_5;
    const double K3_34a = Js3_34 - Js3_36*UH3_4;
    const double K3_34b = Js3_36*UH3_5 - Js3_35;
    const double K3_33 = Js3_33 - Js3_36*UH3_3;
    const double K3_22 = K3_22b + sin_th3*(sin_th3*(Js3_11 - Js3_16*UH3_1 - K3_22b) - K3_22a*(Js3_16*UH3_2 - K4_13));
    const double K3_23 = -(sin_th3*(K4_12 + Js3_16*UH3_3) + cos_th3*(K4_23 + Js3_26*UH3_3));
    const double K3_24c = sin_th3*(Js3_14 - Js3_16*UH3_4 + K3_24b) + cos_th3*(K3_24a - (Js3_26*UH3_4 - Js3_24));
    const double K3_24 = cos_th3*K3_24c - K3_24a;
    const double K3_25 = sin_th3*K3_24c - K3_24b;
    const double K3_26 = sin_th3*(Js3_16*rho3) + cos_th3*(Js3_26*rho3);
    const double K3_34 = cos_th3*K3_34a + sin_th3*K3_34b;
    const double K3_35 = sin_th3*K3_34a - cos_th3*K3_34b;
    const double K3_44d = sin_th3*(K3_44a - K3_44c) + K3_22a*K3_44b;
    const double K3_44e = sin_th3*K3_44d;
    const double K3_44 = K3_44a - K3_44e;
    const double K3_45 = cos_th3*K3_44d - K3_44b;
    const double K3_55 = K3_44c + K3_44e;
    const double K3_46 = cos_th3*K3_46a - sin_th3*K3_46b;
    const double K3_56 = sin_th3*K3_46a + cos_th3*K3_46b;
    const double Gb3 = tau3 + bs3_6;
    const double qdf3 = Hinv3*Gb3;
    const double al3_4a = bs3_4 - Js3_46*qdf3;
    const double al3_4b = Js3_56*qdf3 - bs3_5;
    const double al3_2 = g3_4*K3_24 + g3_5*K3_25 - (sin_th3*(bs3_1 - Js3_16*qdf3) + cos_th3*(bs3_2 - Js3_26*qdf3));
    const double al3_3 = g3_4*K3_34 + g3_5*K3_35 + Js3_36*qdf3 - bs3_3;
    const double al3_4 = g3_4*K3_44 + g3_5*K3_45 - (cos_th3*al3_4a + sin_th3*al3_4b);
    const double al3_5 = g3_4*K3_45 + g3_5*K3_55 - (sin_th3*al3_4a - cos_th3*al3_4b);
    const double al3_6 = g3_4*K3_46 + g3_5*K3_56 + tau3*UH3_6 - bs3_6*rho3;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32]. */
    const double Js2_36 = K3_36 + D3*K3_23;
    const double Js2_44 = XX2 + K3_44;
    const double Js2_45 = XY2 - (D3*K3_34 - K3_45);
    const double Js2_46 = XZ2 + K3_46 + D3*K3_24;
    const double Js2_55 = YY2 + K3_55 - D3*(K3_35 + K3_35 - D3*K3_33);
    const double Js2_56 = YZ2 + K3_56 - D3*(Js2_36 - K3_25);
    const double Js2_66 = ZZ2 + K3_66 + D3*(K3_26 + K3_26 + D3*K3_22);
    const double bs2_4 = b2_4 - al3_4;
    const double bs2_5 = b2_5 + D3*al3_3 - al3_5;
    const double bs2_6 = b2_6 - (al3_6 + D3*al3_2);
    const double H2 = IA2 + Js2_66;
    const double Hinv2 = 1.0/H2;
    const double UH2_4 = Js2_46*Hinv2;
    const double UH2_5 = Js2_56*Hinv2;
    const double K2_45a = Js2_45 - Js2_46*UH2_5;
    const double K2_45b = Js2_55 - Js2_56*UH2_5;
    const double K2_45c = sin_th2*(Js2_44 - Js2_46*UH2_4 - K2_45b) + 2.0*cos_th2*K2_45a;
    const double K2_45 = cos_th2*K2_45c - K2_45a;
    const double K2_55 = K2_45b + sin_th2*K2_45c;
    const double Gb2 = tau2 + bs2_6;
    const double qdf2 = Hinv2*Gb2;
    const double al2_5 = g2_4*K2_45 + sin_th2*(Js2_46*qdf2 - bs2_4) + cos_th2*(Js2_56*qdf2 - bs2_5);

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32]. */
    const double Js1_66 = ZZ1 + K2_55;
    const double H1 = IA1 + Js1_66;
    const double Gb1 = tau1 - al2_5;
    const double qdf1 = Gb1/H1;

    /* Forward recursion: accelerations and torques, joint 2 (j2) [33]-[36]. */
    const double wd2_x = cos_th2*g2_4 + sin_th2*qdf1;
    const double wd2_y = cos_th2*qdf1 - sin_th2*g2_4;
    const double qdd2 = qdf2 - (UH2_4*wd2_x + UH2_5*wd2_y);

    /* Forward recursion: accelerations and torques, joint 3 (j3) [33]-[36]. */
    const double Vr3_1a = D3*qdd2;
    const double Vr3_3 = -D3*wd2_y;
    const double wd3_xa = g3_4 + wd2_x;
    const double wd3_xb = -(g3_5 + wd2_y);
    const double Vr3_1 = sin_th3*Vr3_1a;
    const double Vr3_2 = cos_th3*Vr3_1a;
    const double wd3_x = cos_th3*wd3_xa - sin_th3*wd3_xb;
    const double wd3_y = -(sin_th3*wd3_xa + cos_th3*wd3_xb);
    const double qdd3 = qdf3 - (UH3_1*Vr3_1 + UH3_2*Vr3_2 + UH3_3*Vr3_3) - (UH3_4*wd3_x + UH3_5*wd3_y) - UH3_6*qdd2;
    const double wd3_z = qdd2 + qdd3;

    /* Forward recursion: accelerations and torques, joint 4 (j4) [33]-[36]. */
    const double vd4_xa = -(g4_1 + Vr3_1 - RL4*wd3_z);
    const double vd4_xb = Vr3_3 + RL4*wd3_x - g4_2;
    const double vd4_z = g4_3 + Vr3_2;
    const double wd4_xa = -(g4_4 + wd3_x);
    const double wd4_xb = wd3_z - g4_5;
    const double vd4_x = -(cos_th4*vd4_xa + sin_th4*vd4_xb);
    const double vd4_y = sin_th4*vd4_xa - cos_th4*vd4_xb;
    const double wd4_x = -(cos_th4*wd4_xa + sin_th4*wd4_xb);
    const double wd4_y = sin_th4*wd4_xa - cos_th4*wd4_xb;
    const double qdd4 = qdf4 - (UH4_1*vd4_x + UH4_2*vd4_y + UH4_3*vd4_z) - (UH4_4*wd4_x + UH4_5*wd4_y) - UH4_6*wd3_y;
    const double wd4_z = wd3_y + qdd4;

    /* Forward recursion: accelerations and torques, joint 5 (j5) [33]-[36]. */
    const double wd5_xa = g5_4 + wd4_x;
    const double wd5_xb = -(g5_5 + wd4_z);
    const double vd5_x = cos_th5*vd4_x + sin_th5*vd4_z;
    const double vd5_y = cos_th5*vd4_z - sin_th5*vd4_x;
    const double wd5_x = cos_th5*wd5_xa - sin_th5*wd5_xb;
    const double wd5_y = -(sin_th5*wd5_xa + cos_th5*wd5_xb);
    const double qdd5 = qdf5 - (UH5_1*vd5_x + UH5_2*vd5_y - UH5_3*vd4_y) - (UH5_4*wd5_x + UH5_5*wd5_y) + UH5_6*wd4_y;
    const double wd5_z = qdd5 - wd4_y;

    /* Forward recursion: accelerations and torques, joint 6 (j6) [33]-[36]. */
    const double qdd6 = qdf6 - (UH6_1*vd5_x + UH6_2*vd4_y) - (UH6_4*wd5_x - UH6_5*wd5_z) - UH6_6*wd5_y;

    /* Results. */
    qdd[0*lanes] = qdf1;
    qdd[1*lanes] = qdd2;
    qdd[2*lanes] = qdd3;
    qdd[3*lanes] = qdd4;
    qdd[4*lanes] = qdd5;
    qdd[5*lanes] = qdd6;
}

void rx90_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    double angle[5];
    double sine[5];
    double cosine[5];
    rx90_direct_dynamics_angles(1, 1, q, angle);
    circles(5, angle, sine, cosine);
    rx90_direct_dynamics_state(1, 1, qd, tau, p, c, sine, cosine, qdd);
}

void rx90_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[RX90_DIRECT_DYNAMICS_CONSTANTS];
    rx90_direct_dynamics_prepare(p, c);
    rx90_direct_dynamics_prepared(q, qd, tau, p, c, qdd);
}

APART void rx90_direct_dynamics_state_lanes(size_t stride, const double *restrict qd, const double *restrict tau, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict qdd)
{
    for (size_t l = 0; l < LANES; l++)
        rx90_direct_dynamics_state(stride, LANES, qd + l, tau + l, p, c, sine + l, cosine + l, qdd + l);
}

static void rx90_direct_dynamics_lanes(size_t stride, const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    double angle[5*LANES] ALIGNED;
    double sine[5*LANES] ALIGNED;
    double cosine[5*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        rx90_direct_dynamics_angles(stride, LANES, q + l, angle + l);
    circles(5*LANES, angle, sine, cosine);
    rx90_direct_dynamics_state_lanes(stride, qd, tau, p, c, sine, cosine, qdd);
}

void rx90_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[RX90_DIRECT_DYNAMICS_CONSTANTS];
    rx90_direct_dynamics_prepare(p, c);
    double found_qdd[6*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        rx90_direct_dynamics_lanes(states, q + first, qd + first, tau + first, p, c, found_qdd);
        store(6, states, LANES, found_qdd, qdd + first);
    }
    if (count) {
        double last_q[6*LANES] ALIGNED;
        load(6, states, count, q + first, last_q);
        double last_qd[6*LANES] ALIGNED;
        load(6, states, count, qd + first, last_qd);
        double last_tau[6*LANES] ALIGNED;
        load(6, states, count, tau + first, last_tau);
        rx90_direct_dynamics_lanes(LANES, last_q, last_qd, last_tau, p, c, found_qdd);
        store(6, states, count, found_qdd, qdd + first);
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

    /* Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14]. */
    const double dJ2_yz = YY2 - ZZ2;
    const double dJ2_xz = XX2 - ZZ2;
    const double dJ2_xy = XX2 - YY2;

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const double dJ3_yz = YY3 - ZZ3;
    const double dJ3_xz = XX3 - ZZ3;
    const double dJ3_xy = XX3 - YY3;

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const double dJ4_yz = YY4 - ZZ4;
    const double dJ4_xz = XX4 - ZZ4;
    const double dJ4_xy = XX4 - YY4;

    /* Forward recursion: velocities, joint 5 (j5) [1], [3], [7], [14]. */
    const double dJ5_yz = YY5 - ZZ5;
    const double dJ5_xz = XX5 - ZZ5;
    const double dJ5_xy = XX5 - YY5;

    /* Forward recursion: velocities, joint 6 (j6) [1], [3], [7], [14]. */
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

INLINE void rx90_inverse_dynamics_angles(size_t stride, size_t lanes, const double *restrict q, double *restrict angle)
{
    const double th2 = q[1*stride];
    const double th3 = q[2*stride];
    const double th4 = q[3*stride];
    const double th5 = q[4*stride];
    const double th6 = q[5*stride];
    angle[0*lanes] = th2;
    angle[1*lanes] = th3;
    angle[2*lanes] = th4;
    angle[3*lanes] = th5;
    angle[4*lanes] = th6;
}

INLINE void rx90_inverse_dynamics_state(size_t stride, size_t lanes, const double *restrict qd, const double *restrict qdd_motor, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict tau, double *restrict qdd)
{
    (void)stride, (void)lanes;
    const double qd1 = qd[0*stride];
    const double qd2 = qd[1*stride];
    const double qd3 = qd[2*stride];
    const double qd4 = qd[3*stride];
    const double qd5 = qd[4*stride];
    const double qd6 = qd[5*stride];
    const double qdd1 = qdd_motor[0*stride];
    const double qdd2 = qdd_motor[1*stride];
    const double qdd3 = qdd_motor[2*stride];
    const double qdd4 = qdd_motor[3*stride];
    const double qdd5 = qdd_motor[4*stride];
    const double qdd6 = qdd_motor[5*stride];
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

    /* Forward recursion: velocities, joint 1 (j1) [1], [3], [7], [14]. */
    const double ww1_zz = qd1*qd1;

    /* Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14]. */
    const double sin_th2 = sine[0*lanes];
    const double cos_th2 = cosine[0*lanes];
    const double w2_x = qd1*sin_th2;
    const double w2_y = qd1*cos_th2;
    const double ww2_yz = qd2*w2_y;
    const double ww2_xz = qd2*w2_x;
    const double wd2_x = ww2_yz + qdd1*sin_th2;
    const double wd2_y = qdd1*cos_th2 - ww2_xz;
    const double ww2_xx = w2_x*w2_x;
    const double ww2_xy = w2_x*w2_y;
    const double ww2_zz = qd2*qd2;
    const double vd2_x = -G3*sin_th2;
    const double vd2_y = -G3*cos_th2;

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const double sin_th3 = sine[1*lanes];
    const double cos_th3 = cosine[1*lanes];
    const double w3_x = cos_th3*w2_x + sin_th3*w2_y;
    const double w3_y = cos_th3*w2_y - sin_th3*w2_x;
    const double w3_z = qd2 + qd3;
    const double vd3_xa = ww2_xx - ww2_zz;
    const double vd3_xb = ww1_zz - vd3_xa;
    const double vd3_xc = qdd2 + ww2_xy;
    const double vd3_za = ww2_xz - wd2_y;
    const double wd3_x = qd3*w3_y + cos_th3*wd2_x + sin_th3*wd2_y;
    const double wd3_y = -(qd3*w3_x + sin_th3*wd2_x - cos_th3*wd2_y);
    const double wd3_z = qdd2 + qdd3;
    const double ww3_xx = w3_x*w3_x;
    const double ww3_xy = w3_x*w3_y;
    const double ww3_xz = w3_x*w3_z;
    const double ww3_yz = w3_y*w3_z;
    const double ww3_zz = w3_z*w3_z;
    const double vd3_z = D3*vd3_za;
    const double vd3_xd = D3*vd3_xb - vd2_x;
    const double vd3_xe = -(vd2_y + D3*vd3_xc);
    const double vd3_x = -(cos_th3*vd3_xd + sin_th3*vd3_xe);
    const double vd3_y = sin_th3*vd3_xd - cos_th3*vd3_xe;

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const double sin_th4 = sine[2*lanes];
    const double cos_th4 = cosine[2*lanes];
    const double w4_x = cos_th4*w3_x - sin_th4*w3_z;
    const double w4_y = -(sin_th4*w3_x + cos_th4*w3_z);
    const double w4_z = qd4 + w3_y;
    const double vd4_za = ww3_xx + ww3_zz;
    const double wd4_x = qd4*w4_y - (sin_th4*wd3_z - cos_th4*wd3_x);
    const double wd4_y = -(qd4*w4_x + sin_th4*wd3_x + cos_th4*wd3_z);
    const double wd4_z = qdd4 + wd3_y;
    const double ww4_xx = w4_x*w4_x;
    const double ww4_xy = w4_x*w4_y;
    const double ww4_xz = w4_x*w4_z;
    const double ww4_yz = w4_y*w4_z;
    const double ww4_zz = w4_z*w4_z;
    const double vd4_xa = -(wd4_y + ww4_xz);
    const double vd4_ya = ww4_yz - wd4_x;
    const double vd4_x = -(sin_th4*vd3_z - cos_th4*vd3_x + RL4*vd4_xa);
    const double vd4_y = RL4*vd4_ya - (sin_th4*vd3_x + cos_th4*vd3_z);
    const double vd4_z = vd3_y - RL4*vd4_za;

    /* Forward recursion: velocities, joint 5 (j5) [1], [3], [7], [14]. */
    const double sin_th5 = sine[3*lanes];
    const double cos_th5 = cosine[3*lanes];
    const double w5_x = cos_th5*w4_x + sin_th5*w4_z;
    const double w5_y = cos_th5*w4_z - sin_th5*w4_x;
    const double w5_z = qd5 - w4_y;
    const double wd5_x = qd5*w5_y + cos_th5*wd4_x + sin_th5*wd4_z;
    const double wd5_y = cos_th5*wd4_z - sin_th5*wd4_x - qd5*w5_x;
    const double wd5_z = qdd5 - wd4_y;
    const double ww5_xx = w5_x*w5_x;
    const double ww5_xy = w5_x*w5_y;
    const double ww5_xz = w5_x*w5_z;
    const double ww5_yz = w5_y*w5_z;
    const double ww5_zz = w5_z*w5_z;
    const double vd5_x = cos_th5*vd4_x + sin_th5*vd4_z;
    const double vd5_y = cos_th5*vd4_z - sin_th5*vd4_x;

    /* Forward recursion: velocities, joint 6 (j6) [1], [3], [7], [14]. */
    const double sin_th6 = sine[4*lanes];
    const double cos_th6 = cosine[4*lanes];
    const double w6_x = cos_th6*w5_x - sin_th6*w5_z;
    const double w6_y = -(sin_th6*w5_x + cos_th6*w5_z);
    const double w6_z = qd6 + w5_y;
    const double wd6_x = qd6*w6_y - (sin_th6*wd5_z - cos_th6*wd5_x);
    const double wd6_y = -(qd6*w6_x + sin_th6*wd5_x + cos_th6*wd5_z);
    const double wd6_z = qdd6 + wd5_y;
    const double ww6_xx = w6_x*w6_x;
    const double ww6_xy = w6_x*w6_y;
    const double ww6_xz = w6_x*w6_z;
    const double ww6_yz = w6_y*w6_z;
    const double ww6_zz = w6_z*w6_z;
    const double vd6_x = cos_th6*vd5_x + sin_th6*vd4_y;
    const double vd6_y = cos_th6*vd4_y - sin_th6*vd5_x;

    /* Backward recursion: articulated inertias and wrenches, joint 6 (j6) [50]-[56]. */
    const double f6_1a = ww5_xx + ww5_zz;
    const double f6_1b = ww6_xx - ww6_zz;
    const double f6_1c = f6_1a - f6_1b;
    const double f6_1d = wd6_z - ww6_xy;
    const double f6_1e = -(wd6_y + ww6_xz);
    const double f6_2a = wd6_z + ww6_xy;
    const double f6_2b = ww6_xx + ww6_zz;
    const double f6_2c = ww6_yz - wd6_x;
    const double f6_3a = ww6_xz - wd6_y;
    const double f6_3b = -(wd6_x + ww6_yz);
    const double f6_1 = M6*vd6_x - (MX6*f6_1c + MY6*f6_1d + MZ6*f6_1e);
    const double f6_2 = M6*vd6_y + MX6*f6_2a - MY6*f6_2b + MZ6*f6_2c;
    const double f6_3 = M6*vd5_y + MX6*f6_3a - MY6*f6_3b - MZ6*f6_1a;
    const double f6_4 = YZ6*(f6_1a - f6_2b) - ww6_yz*dJ6_yz + XZ6*f6_2a - XY6*f6_3a + XX6*wd6_x + MY6*vd5_y - MZ6*vd6_y;
    const double f6_5 = -(XZ6*f6_1b - ww6_xz*dJ6_xz - YZ6*f6_1d + XY6*f6_3b - YY6*wd6_y + MX6*vd5_y - MZ6*vd6_x);
    const double f6_6 = MX6*vd6_y - MY6*vd6_x - (XY6*(f6_1c - f6_2b) + ww6_xy*dJ6_xy + YZ6*f6_1e + XZ6*f6_2c - ZZ6*wd6_z);

    /* Backward recursion: articulated inertias and wrenches, joint 5 (j5) [50]-[56]. */
    const double f5_1a = ww4_xx + ww4_zz;
    const double f5_1b = ww5_xx - ww5_zz;
    const double f5_1c = f5_1a - f5_1b;
    const double f5_1d = wd5_z - ww5_xy;
    const double f5_1e = -(wd5_y + ww5_xz);
    const double f5_2a = wd5_z + ww5_xy;
    const double f5_2b = ww5_yz - wd5_x;
    const double f5_3a = ww5_xz - wd5_y;
    const double f5_3b = -(wd5_x + ww5_yz);
    const double f5_1 = -(MX5*f5_1c + MY5*f5_1d + MZ5*f5_1e - M5*vd5_x + sin_th6*f6_2 - cos_th6*f6_1);
    const double f5_2 = M5*vd5_y + MX5*f5_2a - MY5*f6_1a + MZ5*f5_2b + f6_3;
    const double f5_3 = -(M5*vd4_y - (MX5*f5_3a - MY5*f5_3b - MZ5*f5_1a) + sin_th6*f6_1 + cos_th6*f6_2);
    const double f5_4 = YZ5*(f5_1a - f6_1a) - ww5_yz*dJ5_yz + XZ5*f5_2a - XY5*f5_3a + XX5*wd5_x - (MY5*vd4_y
        + MZ5*vd5_y) + cos_th6*f6_4 - sin_th6*f6_5;
    const double f5_5 = f6_6 - (XZ5*f5_1b - ww5_xz*dJ5_xz - YZ5*f5_1d + XY5*f5_3b - YY5*wd5_y - (MZ5*vd5_x + MX5*vd4_y));
    const double f5_6 = -(XY5*(f5_1c - f6_1a) + ww5_xy*dJ5_xy + YZ5*f5_1e + XZ5*f5_2b - ZZ5*wd5_z
        - (MX5*vd5_y - MY5*vd5_x) + sin_th6*f6_4 + cos_th6*f6_5);

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [50]-[56]. */
    const double f4_1a = ww4_xx - ww4_zz;
    const double f4_1b = vd4_za - f4_1a;
    const double f4_1c = wd4_z - ww4_xy;
    const double f4_2a = wd4_z + ww4_xy;
    const double f4_3a = ww4_xz - wd4_y;
    const double f4_3b = -(wd4_x + ww4_yz);
    const double f4_1 = -(MX4*f4_1b + MY4*f4_1c + MZ4*vd4_xa - M4*vd4_x + sin_th5*f5_2 - cos_th5*f5_1);
    const double f4_2 = M4*vd4_y + MX4*f4_2a - MY4*f5_1a + MZ4*vd4_ya - f5_3;
    const double f4_3 = M4*vd4_z + MX4*f4_3a - MY4*f4_3b - MZ4*vd4_za + sin_th5*f5_1 + cos_th5*f5_2;
    const double f4_4 = YZ4*(vd4_za - f5_1a) - ww4_yz*dJ4_yz + XZ4*f4_2a - XY4*f4_3a + XX4*wd4_x + MY4*vd4_z
        - MZ4*vd4_y + cos_th5*f5_4 - sin_th5*f5_5;
    const double f4_5 = -(XZ4*f4_1a - ww4_xz*dJ4_xz - YZ4*f4_1c + XY4*f4_3b - YY4*wd4_y + MX4*vd4_z - MZ4*vd4_x + f5_6);
    const double f4_6 = sin_th5*f5_4 + cos_th5*f5_5 - (XY4*(f4_1b - f5_1a) + ww4_xy*dJ4_xy + YZ4*vd4_xa
        + XZ4*vd4_ya - ZZ4*wd4_z - (MX4*vd4_y - MY4*vd4_x));

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [50]-[56]. */
    const double f3_1a = ww3_xx - ww3_zz;
    const double f3_1b = ww1_zz - f3_1a;
    const double f3_1c = wd3_z - ww3_xy;
    const double f3_1d = -(wd3_y + ww3_xz);
    const double f3_2a = wd3_z + ww3_xy;
    const double f3_2b = ww3_yz - wd3_x;
    const double f3_3a = ww3_xz - wd3_y;
    const double f3_3b = -(wd3_x + ww3_yz);
    const double f3_4a = f4_4 - RL4*f4_2;
    const double f3_4b = -(f4_5 + RL4*f4_1);
    const double f3_1 = -(MX3*f3_1b + MY3*f3_1c + MZ3*f3_1d - M3*vd3_x + sin_th4*f4_2 - cos_th4*f4_1);
    const double f3_2 = M3*vd3_y + MX3*f3_2a - MY3*vd4_za + MZ3*f3_2b + f4_3;
    const double f3_3 = M3*vd3_z + MX3*f3_3a - MY3*f3_3b - MZ3*ww1_zz - (sin_th4*f4_1 + cos_th4*f4_2);
    const double f3_4 = YZ3*(ww1_zz - vd4_za) - ww3_yz*dJ3_yz + XZ3*f3_2a - XY3*f3_3a + XX3*wd3_x + MY3*vd3_z
        - MZ3*vd3_y + cos_th4*f3_4a + sin_th4*f3_4b;
    const double f3_5 = f4_6 - (XZ3*f3_1a - ww3_xz*dJ3_xz - YZ3*f3_1c + XY3*f3_3b - YY3*wd3_y + MX3*vd3_z - MZ3*vd3_x);
    const double f3_6 = -(XY3*(f3_1b - vd4_za) + ww3_xy*dJ3_xy + YZ3*f3_1d + XZ3*f3_2b - ZZ3*wd3_z
        - (MX3*vd3_y - MY3*vd3_x) + sin_th4*f3_4a - cos_th4*f3_4b);

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [50]-[56]. */
    const double f2_4a = ww2_xx + ww2_zz;
    const double f2_4 = YZ2*(ww1_zz - f2_4a) - ww2_yz*dJ2_yz + XZ2*vd3_xc - XY2*vd3_za + XX2*wd2_x - MZ2*vd2_y
        + cos_th3*f3_4 - sin_th3*f3_5;
    const double f2_5 = sin_th3*f3_4 + cos_th3*f3_5 - D3*f3_3 - (XZ2*vd3_xa - ww2_xz*dJ2_xz - YZ2*(qdd2 - ww2_xy)
        - XY2*(ww2_yz + wd2_x) - YY2*wd2_y - MZ2*vd2_x);
    const double f2_6 = f3_6 + D3*(sin_th3*f3_1 + cos_th3*f3_2) - (XY2*(vd3_xb - f2_4a) + ww2_xy*dJ2_xy
        - YZ2*(ww2_xz + wd2_y) + XZ2*(ww2_yz - wd2_x) - ZZ2*qdd2 + MY2*vd2_x - MX2*vd2_y);

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [50]-[56]. */
    const double f1_6 = ZZ1*qdd1 + sin_th2*f2_4 + cos_th2*f2_5;

    /* Forward recursion: accelerations and torques, joint 1 (j1) [57]-[61]. */
    const double Gamma1 = f1_6 + IA1*qdd1;

    /* Forward recursion: accelerations and torques, joint 2 (j2) [57]-[61]. */
    const double Gamma2 = f2_6 + IA2*qdd2;

    /* Forward recursion: accelerations and torques, joint 3 (j3) [57]-[61]. */
    const double Gamma3 = f3_6 + IA3*qdd3;

    /* Forward recursion: accelerations and torques, joint 4 (j4) [57]-[61]. */
    const double Gamma4 = f4_6 + IA4*qdd4;

    /* Forward recursion: accelerations and torques, joint 5 (j5) [57]-[61]. */
    const double Gamma5 = f5_6 + IA5*qdd5;

    /* Forward recursion: accelerations and torques, joint 6 (j6) [57]-[61]. */
    const double Gamma6 = f6_6 + IA6*qdd6;

    /* Results. */
    tau[0*lanes] = Gamma1;
    tau[1*lanes] = Gamma2;
    tau[2*lanes] = Gamma3;
    tau[3*lanes] = Gamma4;
    tau[4*lanes] = Gamma5;
    tau[5*lanes] = Gamma6;
    qdd[0*lanes] = qdd1;
    qdd[1*lanes] = qdd2;
    qdd[2*lanes] = qdd3;
    qdd[3*lanes] = qdd4;
    qdd[4*lanes] = qdd5;
    qdd[5*lanes] = qdd6;
}

void rx90_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    double angle[5];
    double sine[5];
    double cosine[5];
    rx90_inverse_dynamics_angles(1, 1, q, angle);
    circles(5, angle, sine, cosine);
    rx90_inverse_dynamics_state(1, 1, qd, qdd_motor, p, c, sine, cosine, tau, qdd);
}

void rx90_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[RX90_INVERSE_DYNAMICS_CONSTANTS];
    rx90_inverse_dynamics_prepare(p, c);
    rx90_inverse_dynamics_prepared(q, qd, qdd_motor, p, c, tau, qdd);
}

APART void rx90_inverse_dynamics_state_lanes(size_t stride, const double *restrict qd, const double *restrict qdd_motor, const double *restrict p, const double *restrict c, const double *restrict sine, const double *restrict cosine, double *restrict tau, double *restrict qdd)
{
    for (size_t l = 0; l < LANES; l++)
        rx90_inverse_dynamics_state(stride, LANES, qd + l, qdd_motor + l, p, c, sine + l, cosine + l, tau + l, qdd + l);
}

static void rx90_inverse_dynamics_lanes(size_t stride, const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    double angle[5*LANES] ALIGNED;
    double sine[5*LANES] ALIGNED;
    double cosine[5*LANES] ALIGNED;
    for (size_t l = 0; l < LANES; l++)
        rx90_inverse_dynamics_angles(stride, LANES, q + l, angle + l);
    circles(5*LANES, angle, sine, cosine);
    rx90_inverse_dynamics_state_lanes(stride, qd, qdd_motor, p, c, sine, cosine, tau, qdd);
}

void rx90_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[RX90_INVERSE_DYNAMICS_CONSTANTS];
    rx90_inverse_dynamics_prepare(p, c);
    double found_tau[6*LANES] ALIGNED;
    double found_qdd[6*LANES] ALIGNED;
    const size_t count = states%LANES;
    size_t first = 0;
    for (; first + LANES <= states; first += LANES) {
        rx90_inverse_dynamics_lanes(states, q + first, qd + first, qdd_motor + first, p, c, found_tau, found_qdd);
        store(6, states, LANES, found_tau, tau + first);
        store(6, states, LANES, found_qdd, qdd + first);
    }
    if (count) {
        double last_q[6*LANES] ALIGNED;
        load(6, states, count, q + first, last_q);
        double last_qd[6*LANES] ALIGNED;
        load(6, states, count, qd + first, last_qd);
        double last_qdd_motor[6*LANES] ALIGNED;
        load(6, states, count, qdd_motor + first, last_qdd_motor);
        rx90_inverse_dynamics_lanes(LANES, last_q, last_qd, last_qdd_motor, p, c, found_tau, found_qdd);
        store(6, states, count, found_tau, tau + first);
        store(6, states, count, found_qdd, qdd + first);
    }
}
