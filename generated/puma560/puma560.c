/* puma560: generated models. Equation numbers are those of Khalil and Gautier. */
#include <math.h>

#include "puma560.h"

const double puma560_defaults[PUMA560_PARAMETERS] = {
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
    NAN, /* R2 */
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
    NAN, /* R3 */
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
    NAN, /* D4 */
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

void puma560_direct_dynamics_prepare(const double *p, double *c)
{
    const double XX2 = p[PUMA560_P_XX2];
    const double YY2 = p[PUMA560_P_YY2];
    const double ZZ2 = p[PUMA560_P_ZZ2];
    const double XX3 = p[PUMA560_P_XX3];
    const double YY3 = p[PUMA560_P_YY3];
    const double ZZ3 = p[PUMA560_P_ZZ3];
    const double XX4 = p[PUMA560_P_XX4];
    const double YY4 = p[PUMA560_P_YY4];
    const double ZZ4 = p[PUMA560_P_ZZ4];
    const double XX5 = p[PUMA560_P_XX5];
    const double YY5 = p[PUMA560_P_YY5];
    const double ZZ5 = p[PUMA560_P_ZZ5];
    const double M5 = p[PUMA560_P_M5];
    const double XX6 = p[PUMA560_P_XX6];
    const double XY6 = p[PUMA560_P_XY6];
    const double XZ6 = p[PUMA560_P_XZ6];
    const double YY6 = p[PUMA560_P_YY6];
    const double YZ6 = p[PUMA560_P_YZ6];
    const double ZZ6 = p[PUMA560_P_ZZ6];
    const double MX6 = p[PUMA560_P_MX6];
    const double MY6 = p[PUMA560_P_MY6];
    const double MZ6 = p[PUMA560_P_MZ6];
    const double M6 = p[PUMA560_P_M6];
    const double IA6 = p[PUMA560_P_IA6];

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

    /* Backward recursion: articulated inertias and wrenches, joint 6 (j6) [28]-[32]. */
    const double H6 = ZZ6 + IA6;
    const double Hinv6 = 1.0/H6;
    const double UH6_1 = -MY6*Hinv6;
    const double UH6_2 = MX6*Hinv6;
    const double UH6_4 = XZ6*Hinv6;
    const double UH6_5 = YZ6*Hinv6;
    const double UH6_6 = ZZ6*Hinv6;
    const double rho6 = IA6*Hinv6;
    const double K6_16 = -MY6*rho6;
    const double K6_26 = MX6*rho6;
    const double K6_46 = XZ6*rho6;
    const double K6_56 = YZ6*rho6;
    const double K6_66 = ZZ6*rho6;
    const double K6_14 = MY6*UH6_4;
    const double K6_11 = M6 + MY6*UH6_1;
    const double K6_44 = XX6 - XZ6*UH6_4;
    const double K6_15 = MZ6 + MY6*UH6_5;
    const double K6_12 = MY6*UH6_2;
    const double K6_45 = XY6 - XZ6*UH6_5;
    const double K6_24 = -(MZ6 + MX6*UH6_4);
    const double K6_25 = -MX6*UH6_5;
    const double K6_22 = M6 - MX6*UH6_2;
    const double K6_55 = YY6 - YZ6*UH6_5;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (j5) [28]-[32]. */
    const double Js5_14a = K6_14 - K6_25;
    const double Js5_13a = K6_11 - K6_22;
    const double Js5_13b = 2.0*K6_12;
    const double Js5_14b = K6_15 + K6_24;
    const double Js5_44a = K6_44 - K6_55;
    const double Js5_44b = 2.0*K6_45;
    const double Js5_22 = M5 + M6;
    const double Js5_55 = YY5 + K6_66;

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
    c[15] = Hinv6;
    c[16] = UH6_1;
    c[17] = UH6_2;
    c[18] = UH6_4;
    c[19] = UH6_5;
    c[20] = UH6_6;
    c[21] = rho6;
    c[22] = K6_16;
    c[23] = K6_26;
    c[24] = K6_46;
    c[25] = K6_56;
    c[26] = K6_14;
    c[27] = K6_11;
    c[28] = K6_44;
    c[29] = K6_15;
    c[30] = K6_12;
    c[31] = K6_45;
    c[32] = K6_24;
    c[33] = K6_25;
    c[34] = K6_22;
    c[35] = K6_55;
    c[36] = Js5_14a;
    c[37] = Js5_13a;
    c[38] = Js5_13b;
    c[39] = Js5_14b;
    c[40] = Js5_44a;
    c[41] = Js5_44b;
    c[42] = Js5_22;
    c[43] = Js5_55;
}

void puma560_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    const double th2 = q[1];
    const double th3 = q[2];
    const double th4 = q[3];
    const double th5 = q[4];
    const double th6 = q[5];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double qd3 = qd[2];
    const double qd4 = qd[3];
    const double qd5 = qd[4];
    const double qd6 = qd[5];
    const double tau1 = tau[0];
    const double tau2 = tau[1];
    const double tau3 = tau[2];
    const double tau4 = tau[3];
    const double tau5 = tau[4];
    const double tau6 = tau[5];
    const double ZZ1 = p[PUMA560_P_ZZ1];
    const double IA1 = p[PUMA560_P_IA1];
    const double R2 = p[PUMA560_P_R2];
    const double XX2 = p[PUMA560_P_XX2];
    const double XY2 = p[PUMA560_P_XY2];
    const double XZ2 = p[PUMA560_P_XZ2];
    const double YY2 = p[PUMA560_P_YY2];
    const double YZ2 = p[PUMA560_P_YZ2];
    const double ZZ2 = p[PUMA560_P_ZZ2];
    const double MX2 = p[PUMA560_P_MX2];
    const double MY2 = p[PUMA560_P_MY2];
    const double MZ2 = p[PUMA560_P_MZ2];
    const double M2 = p[PUMA560_P_M2];
    const double IA2 = p[PUMA560_P_IA2];
    const double D3 = p[PUMA560_P_D3];
    const double R3 = p[PUMA560_P_R3];
    const double XX3 = p[PUMA560_P_XX3];
    const double XY3 = p[PUMA560_P_XY3];
    const double XZ3 = p[PUMA560_P_XZ3];
    const double YY3 = p[PUMA560_P_YY3];
    const double YZ3 = p[PUMA560_P_YZ3];
    const double ZZ3 = p[PUMA560_P_ZZ3];
    const double MX3 = p[PUMA560_P_MX3];
    const double MY3 = p[PUMA560_P_MY3];
    const double MZ3 = p[PUMA560_P_MZ3];
    const double M3 = p[PUMA560_P_M3];
    const double IA3 = p[PUMA560_P_IA3];
    const double D4 = p[PUMA560_P_D4];
    const double RL4 = p[PUMA560_P_RL4];
    const double XX4 = p[PUMA560_P_XX4];
    const double XY4 = p[PUMA560_P_XY4];
    const double XZ4 = p[PUMA560_P_XZ4];
    const double YY4 = p[PUMA560_P_YY4];
    const double YZ4 = p[PUMA560_P_YZ4];
    const double ZZ4 = p[PUMA560_P_ZZ4];
    const double MX4 = p[PUMA560_P_MX4];
    const double MY4 = p[PUMA560_P_MY4];
    const double MZ4 = p[PUMA560_P_MZ4];
    const double M4 = p[PUMA560_P_M4];
    const double IA4 = p[PUMA560_P_IA4];
    const double XX5 = p[PUMA560_P_XX5];
    const double XY5 = p[PUMA560_P_XY5];
    const double XZ5 = p[PUMA560_P_XZ5];
    const double YZ5 = p[PUMA560_P_YZ5];
    const double ZZ5 = p[PUMA560_P_ZZ5];
    const double MX5 = p[PUMA560_P_MX5];
    const double MY5 = p[PUMA560_P_MY5];
    const double MZ5 = p[PUMA560_P_MZ5];
    const double M5 = p[PUMA560_P_M5];
    const double IA5 = p[PUMA560_P_IA5];
    const double XY6 = p[PUMA560_P_XY6];
    const double XZ6 = p[PUMA560_P_XZ6];
    const double YZ6 = p[PUMA560_P_YZ6];
    const double ZZ6 = p[PUMA560_P_ZZ6];
    const double MX6 = p[PUMA560_P_MX6];
    const double MY6 = p[PUMA560_P_MY6];
    const double MZ6 = p[PUMA560_P_MZ6];
    const double G3 = p[PUMA560_P_G3];
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
    const double Hinv6 = c[15];
    const double UH6_1 = c[16];
    const double UH6_2 = c[17];
    const double UH6_4 = c[18];
    const double UH6_5 = c[19];
    const double UH6_6 = c[20];
    const double rho6 = c[21];
    const double K6_16 = c[22];
    const double K6_26 = c[23];
    const double K6_46 = c[24];
    const double K6_56 = c[25];
    const double K6_14 = c[26];
    const double K6_11 = c[27];
    const double K6_44 = c[28];
    const double K6_15 = c[29];
    const double K6_12 = c[30];
    const double K6_45 = c[31];
    const double K6_24 = c[32];
    const double K6_25 = c[33];
    const double K6_22 = c[34];
    const double K6_55 = c[35];
    const double Js5_14a = c[36];
    const double Js5_13a = c[37];
    const double Js5_13b = c[38];
    const double Js5_14b = c[39];
    const double Js5_44a = c[40];
    const double Js5_44b = c[41];
    const double Js5_22 = c[42];
    const double Js5_55 = c[43];

    /* Forward recursion: velocities, joint 1 (j1) [1], [3], [7], [14]. */
    const double ww1_zz = qd1*qd1;

    /* Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14]. */
    const double sin_th2 = sin(th2);
    const double cos_th2 = cos(th2);
    const double w2_x = -qd1*sin_th2;
    const double w2_y = -qd1*cos_th2;
    const double ww2_xx = w2_x*w2_x;
    const double ww2_yy = w2_y*w2_y;
    const double ww2_zz = qd2*qd2;
    const double b2_1a = ww2_yy + ww2_zz;
    const double ww2_xy = w2_x*w2_y;
    const double ww2_xz = qd2*w2_x;
    const double ww2_yz = qd2*w2_y;
    const double g2_3 = -R2*ww1_zz;
    const double b2_1 = MX2*b2_1a - MY2*ww2_xy - MZ2*ww2_xz;
    const double b2_2 = -(MX2*ww2_xy - MY2*(ww2_xx + ww2_zz) + MZ2*ww2_yz);
    const double b2_4 = XY2*ww2_xz - (YZ2*(ww2_yy - ww2_zz) - ww2_yz*dJ2_yz + XZ2*ww2_xy);
    const double b2_5 = XZ2*(ww2_xx - ww2_zz) - ww2_xz*dJ2_xz + YZ2*ww2_xy - XY2*ww2_yz;
    const double b2_6 = XZ2*ww2_yz - (XY2*(ww2_xx - ww2_yy) - ww2_xy*dJ2_xy + YZ2*ww2_xz);

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const double sin_th3 = sin(th3);
    const double cos_th3 = cos(th3);
    const double w3_x = cos_th3*w2_x + sin_th3*w2_y;
    const double w3_y = cos_th3*w2_y - sin_th3*w2_x;
    const double w3_z = qd2 + qd3;
    const double ww3_xx = w3_x*w3_x;
    const double ww3_yy = w3_y*w3_y;
    const double ww3_zz = w3_z*w3_z;
    const double b3_1a = ww3_yy + ww3_zz;
    const double ww3_xy = w3_x*w3_y;
    const double ww3_xz = w3_x*w3_z;
    const double b3_2a = ww3_xx + ww3_zz;
    const double ww3_yz = w3_y*w3_z;
    const double g3_1a = D3*b2_1a - R3*ww2_xz;
    const double g3_1b = D3*ww2_xy + R3*ww2_yz;
    const double g3_3 = D3*ww2_xz - R3*(ww2_xx + ww2_yy);
    const double g3_1 = sin_th3*g3_1b - cos_th3*g3_1a;
    const double g3_2 = sin_th3*g3_1a + cos_th3*g3_1b;
    const double g3_4 = qd3*w3_y;
    const double g3_5 = -qd3*w3_x;
    const double b3_1 = MX3*b3_1a - MY3*ww3_xy - MZ3*ww3_xz;
    const double b3_2 = MY3*b3_2a - MX3*ww3_xy - MZ3*ww3_yz;
    const double b3_3 = MZ3*(ww3_xx + ww3_yy) - (MX3*ww3_xz + MY3*ww3_yz);
    const double b3_4 = XY3*ww3_xz - (YZ3*(ww3_yy - ww3_zz) - ww3_yz*dJ3_yz + XZ3*ww3_xy);
    const double b3_5 = XZ3*(ww3_xx - ww3_zz) - ww3_xz*dJ3_xz + YZ3*ww3_xy - XY3*ww3_yz;
    const double b3_6 = XZ3*ww3_yz - (XY3*(ww3_xx - ww3_yy) - ww3_xy*dJ3_xy + YZ3*ww3_xz);

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const double sin_th4 = sin(th4);
    const double cos_th4 = cos(th4);
    const double w4_x = cos_th4*w3_x - sin_th4*w3_z;
    const double w4_y = -(sin_th4*w3_x + cos_th4*w3_z);
    const double w4_z = qd4 + w3_y;
    const double ww4_xx = w4_x*w4_x;
    const double ww4_yy = w4_y*w4_y;
    const double ww4_zz = w4_z*w4_z;
    const double ww4_xy = w4_x*w4_y;
    const double ww4_xz = w4_x*w4_z;
    const double ww4_yz = w4_y*w4_z;
    const double g4_1a = D4*b3_1a - RL4*ww3_xy;
    const double g4_3 = D4*ww3_xy - RL4*b3_2a;
    const double g4_1b = -(D4*ww3_xz + RL4*ww3_yz);
    const double g4_1 = sin_th4*g4_1b - cos_th4*g4_1a;
    const double g4_2 = sin_th4*g4_1a + cos_th4*g4_1b;
    const double g4_4 = qd4*w4_y;
    const double g4_5 = -qd4*w4_x;
    const double b4_1 = MX4*(ww4_yy + ww4_zz) - MY4*ww4_xy - MZ4*ww4_xz;
    const double b4_2 = MY4*(ww4_xx + ww4_zz) - MX4*ww4_xy - MZ4*ww4_yz;
    const double b4_3 = MZ4*(ww4_xx + ww4_yy) - (MX4*ww4_xz + MY4*ww4_yz);
    const double b4_4 = XY4*ww4_xz - (YZ4*(ww4_yy - ww4_zz) - ww4_yz*dJ4_yz + XZ4*ww4_xy);
    const double b4_5 = XZ4*(ww4_xx - ww4_zz) - ww4_xz*dJ4_xz + YZ4*ww4_xy - XY4*ww4_yz;
    const double b4_6 = XZ4*ww4_yz - (XY4*(ww4_xx - ww4_yy) - ww4_xy*dJ4_xy + YZ4*ww4_xz);

    /* Forward recursion: velocities, joint 5 (j5) [1], [3], [7], [14]. */
    const double sin_th5 = sin(th5);
    const double cos_th5 = cos(th5);
    const double w5_x = cos_th5*w4_x + sin_th5*w4_z;
    const double w5_y = cos_th5*w4_z - sin_th5*w4_x;
    const double w5_z = qd5 - w4_y;
    const double ww5_xx = w5_x*w5_x;
    const double ww5_yy = w5_y*w5_y;
    const double ww5_zz = w5_z*w5_z;
    const double ww5_xy = w5_x*w5_y;
    const double ww5_xz = w5_x*w5_z;
    const double ww5_yz = w5_y*w5_z;
    const double g5_4 = qd5*w5_y;
    const double g5_5 = -qd5*w5_x;
    const double b5_1 = MX5*(ww5_yy + ww5_zz) - MY5*ww5_xy - MZ5*ww5_xz;
    const double b5_2 = MY5*(ww5_xx + ww5_zz) - MX5*ww5_xy - MZ5*ww5_yz;
    const double b5_3 = MZ5*(ww5_xx + ww5_yy) - (MX5*ww5_xz + MY5*ww5_yz);
    const double b5_4 = XY5*ww5_xz - (YZ5*(ww5_yy - ww5_zz) - ww5_yz*dJ5_yz + XZ5*ww5_xy);
    const double b5_5 = XZ5*(ww5_xx - ww5_zz) - ww5_xz*dJ5_xz + YZ5*ww5_xy - XY5*ww5_yz;
    const double b5_6 = XZ5*ww5_yz - (XY5*(ww5_xx - ww5_yy) - ww5_xy*dJ5_xy + YZ5*ww5_xz);

    /* Forward recursion: velocities, joint 6 (j6) [1], [3], [7], [14]. */
    const double sin_th6 = sin(th6);
    const double cos_th6 = cos(th6);
    const double w6_x = cos_th6*w5_x - sin_th6*w5_z;
    const double w6_y = -(sin_th6*w5_x + cos_th6*w5_z);
    const double w6_z = qd6 + w5_y;
    const double ww6_xx = w6_x*w6_x;
    const double ww6_yy = w6_y*w6_y;
    const double ww6_zz = w6_z*w6_z;
    const double ww6_xy = w6_x*w6_y;
    const double ww6_xz = w6_x*w6_z;
    const double ww6_yz = w6_y*w6_z;
    const double g6_4 = qd6*w6_y;
    const double g6_5 = -qd6*w6_x;
    const double b6_1 = MX6*(ww6_yy + ww6_zz) - MY6*ww6_xy - MZ6*ww6_xz;
    const double b6_2 = MY6*(ww6_xx + ww6_zz) - MX6*ww6_xy - MZ6*ww6_yz;
    const double b6_3 = MZ6*(ww6_xx + ww6_yy) - (MX6*ww6_xz + MY6*ww6_yz);
    const double b6_4 = XY6*ww6_xz - (YZ6*(ww6_yy - ww6_zz) - ww6_yz*dJ6_yz + XZ6*ww6_xy);
    const double b6_5 = XZ6*(ww6_xx - ww6_zz) - ww6_xz*dJ6_xz + YZ6*ww6_xy - XY6*ww6_yz;
    const double b6_6 = XZ6*ww6_yz - (XY6*(ww6_xx - ww6_yy) - ww6_xy*dJ6_xy + YZ6*ww6_xz);

    /* Backward recursion: articulated inertias and wrenches, joint 6 (j6) [28]-[32]. */
    const double Gb6 = tau6 + b6_6;
    const double al6_1 = g6_4*K6_14 + g6_5*K6_15 + UH6_1*Gb6 - b6_1;
    const double al6_2 = g6_4*K6_24 + g6_5*K6_25 + UH6_2*Gb6 - b6_2;
    const double al6_3 = MY6*g6_4 - MX6*g6_5 - b6_3;
    const double al6_4 = g6_4*K6_44 + g6_5*K6_45 + UH6_4*Gb6 - b6_4;
    const double al6_5 = g6_4*K6_45 + g6_5*K6_55 + UH6_5*Gb6 - b6_5;
    const double al6_6 = g6_4*K6_46 + g6_5*K6_56 + tau6*UH6_6 - b6_6*rho6;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (j5) [28]-[32]. */
    const double Js5_13c = sin_th6*Js5_13a + cos_th6*Js5_13b;
    const double Js5_11a = sin_th6*Js5_13c;
    const double Js5_13 = K6_12 - cos_th6*Js5_13c;
    const double Js5_14c = sin_th6*Js5_14a + cos_th6*Js5_14b;
    const double Js5_14d = sin_th6*Js5_14c;
    const double Js5_14 = K6_14 - Js5_14d;
    const double Js5_16a = cos_th6*Js5_14c;
    const double Js5_36 = K6_25 + Js5_14d;
    const double Js5_44c = sin_th6*Js5_44a + cos_th6*Js5_44b;
    const double Js5_44d = sin_th6*Js5_44c;
    const double Js5_11 = M5 + K6_11 - Js5_11a;
    const double Js5_33 = M5 + K6_22 + Js5_11a;
    const double Js5_15 = MZ5 - (sin_th6*K6_26 - cos_th6*K6_16);
    const double Js5_16 = -(MY5 + Js5_16a - K6_24);
    const double Js5_24 = MY6*cos_th6 + MX6*sin_th6 - MZ5;
    const double Js5_26 = MX5 - (MY6*sin_th6 - MX6*cos_th6);
    const double Js5_34 = MY5 + K6_15 - Js5_16a;
    const double Js5_35 = -(MX5 + sin_th6*K6_16 + cos_th6*K6_26);
    const double Js5_44 = XX5 + K6_44 - Js5_44d;
    const double Js5_45 = XY5 + cos_th6*K6_46 - sin_th6*K6_56;
    const double Js5_46 = XZ5 + K6_45 - cos_th6*Js5_44c;
    const double Js5_56 = YZ5 - (sin_th6*K6_46 + cos_th6*K6_56);
    const double Js5_66 = ZZ5 + K6_55 + Js5_44d;
    const double bs5_1 = b5_1 + sin_th6*al6_2 - cos_th6*al6_1;
    const double bs5_2 = b5_2 - al6_3;
    const double bs5_3 = b5_3 + sin_th6*al6_1 + cos_th6*al6_2;
    const double bs5_4 = b5_4 - (cos_th6*al6_4 - sin_th6*al6_5);
    const double bs5_5 = b5_5 - al6_6;
    const double bs5_6 = b5_6 + sin_th6*al6_4 + cos_th6*al6_5;
    const double H5 = IA5 + Js5_66;
    const double Hinv5 = 1.0/H5;
    const double UH5_1 = Js5_16*Hinv5;
    const double UH5_2 = Js5_26*Hinv5;
    const double UH5_3 = Js5_36*Hinv5;
    const double UH5_4 = Js5_46*Hinv5;
    const double UH5_5 = Js5_56*Hinv5;
    const double UH5_6 = Js5_66*Hinv5;
    const double rho5 = IA5*Hinv5;
    const double K5_16 = Js5_16*rho5;
    const double K5_26 = Js5_26*rho5;
    const double K5_36 = Js5_36*rho5;
    const double K5_46 = Js5_46*rho5;
    const double K5_56 = Js5_56*rho5;
    const double K5_66 = Js5_66*rho5;
    const double K5_14 = Js5_14 - Js5_16*UH5_4;
    const double K5_11 = Js5_11 - Js5_16*UH5_1;
    const double K5_44 = Js5_44 - Js5_46*UH5_4;
    const double K5_15 = Js5_15 - Js5_16*UH5_5;
    const double K5_12 = -Js5_16*UH5_2;
    const double K5_45 = Js5_45 - Js5_46*UH5_5;
    const double K5_13 = Js5_13 - Js5_16*UH5_3;
    const double K5_24 = Js5_24 - Js5_26*UH5_4;
    const double K5_25 = -Js5_26*UH5_5;
    const double K5_22 = Js5_22 - Js5_26*UH5_2;
    const double K5_55 = Js5_55 - Js5_56*UH5_5;
    const double K5_23 = -Js5_26*UH5_3;
    const double K5_34 = Js5_34 - Js5_36*UH5_4;
    const double K5_35 = Js5_35 - Js5_36*UH5_5;
    const double K5_33 = Js5_33 - Js5_36*UH5_3;
    const double Gb5 = tau5 + bs5_6;
    const double al5_1 = g5_4*K5_14 + g5_5*K5_15 + UH5_1*Gb5 - bs5_1;
    const double al5_2 = g5_4*K5_24 + g5_5*K5_25 + UH5_2*Gb5 - bs5_2;
    const double al5_3 = g5_4*K5_34 + g5_5*K5_35 + UH5_3*Gb5 - bs5_3;
    const double al5_4 = g5_4*K5_44 + g5_5*K5_45 + UH5_4*Gb5 - bs5_4;
    const double al5_5 = g5_4*K5_45 + g5_5*K5_55 + UH5_5*Gb5 - bs5_5;
    const double al5_6 = g5_4*K5_46 + g5_5*K5_56 + tau5*UH5_6 - bs5_6*rho5;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32]. */
    const double Js4_13a = sin_th5*(K5_11 - K5_22) + 2.0*K5_12*cos_th5;
    const double Js4_11a = sin_th5*Js4_13a;
    const double Js4_13 = cos_th5*Js4_13a - K5_12;
    const double Js4_12 = sin_th5*K5_23 - cos_th5*K5_13;
    const double Js4_23 = -(sin_th5*K5_13 + cos_th5*K5_23);
    const double Js4_14a = sin_th5*(K5_14 - K5_25) + cos_th5*(K5_15 + K5_24);
    const double Js4_14b = sin_th5*Js4_14a;
    const double Js4_14 = K5_14 - Js4_14b;
    const double Js4_16a = cos_th5*Js4_14a;
    const double Js4_36 = K5_25 + Js4_14b;
    const double Js4_44a = sin_th5*(K5_44 - K5_55) + 2.0*K5_45*cos_th5;
    const double Js4_44b = sin_th5*Js4_44a;
    const double Js4_11 = M4 + K5_11 - Js4_11a;
    const double Js4_22 = M4 + K5_33;
    const double Js4_33 = M4 + K5_22 + Js4_11a;
    const double Js4_15 = MZ4 + sin_th5*K5_26 - cos_th5*K5_16;
    const double Js4_16 = Js4_16a - K5_24 - MY4;
    const double Js4_24 = -(MZ4 + cos_th5*K5_34 - sin_th5*K5_35);
    const double Js4_26 = MX4 - (sin_th5*K5_34 + cos_th5*K5_35);
    const double Js4_34 = MY4 - (K5_15 - Js4_16a);
    const double Js4_35 = -(MX4 + sin_th5*K5_16 + cos_th5*K5_26);
    const double Js4_44 = XX4 + K5_44 - Js4_44b;
    const double Js4_45 = XY4 - (cos_th5*K5_46 - sin_th5*K5_56);
    const double Js4_46 = XZ4 - (K5_45 - cos_th5*Js4_44a);
    const double Js4_55 = YY4 + K5_66;
    const double Js4_56 = YZ4 - (sin_th5*K5_46 + cos_th5*K5_56);
    const double Js4_66 = ZZ4 + K5_55 + Js4_44b;
    const double bs4_1 = b4_1 + sin_th5*al5_2 - cos_th5*al5_1;
    const double bs4_2 = b4_2 + al5_3;
    const double bs4_3 = b4_3 - (sin_th5*al5_1 + cos_th5*al5_2);
    const double bs4_4 = b4_4 - (cos_th5*al5_4 - sin_th5*al5_5);
    const double bs4_5 = b4_5 + al5_6;
    const double bs4_6 = b4_6 - (sin_th5*al5_4 + cos_th5*al5_5);
    const double H4 = IA4 + Js4_66;
    const double Hinv4 = 1.0/H4;
    const double UH4_1 = Js4_16*Hinv4;
    const double UH4_2 = Js4_26*Hinv4;
    const double UH4_3 = Js4_36*Hinv4;
    const double UH4_4 = Js4_46*Hinv4;
    const double UH4_5 = Js4_56*Hinv4;
    const double UH4_6 = Js4_66*Hinv4;
    const double rho4 = IA4*Hinv4;
    const double K4_16 = Js4_16*rho4;
    const double K4_26 = Js4_26*rho4;
    const double K4_36 = Js4_36*rho4;
    const double K4_46 = Js4_46*rho4;
    const double K4_56 = Js4_56*rho4;
    const double K4_66 = Js4_66*rho4;
    const double K4_14 = Js4_14 - Js4_16*UH4_4;
    const double K4_11 = Js4_11 - Js4_16*UH4_1;
    const double K4_44 = Js4_44 - Js4_46*UH4_4;
    const double K4_15 = Js4_15 - Js4_16*UH4_5;
    const double K4_12 = Js4_12 - Js4_16*UH4_2;
    const double K4_45 = Js4_45 - Js4_46*UH4_5;
    const double K4_13 = Js4_13 - Js4_16*UH4_3;
    const double K4_24 = Js4_24 - Js4_26*UH4_4;
    const double K4_25 = K5_36 - Js4_26*UH4_5;
    const double K4_22 = Js4_22 - Js4_26*UH4_2;
    const double K4_55 = Js4_55 - Js4_56*UH4_5;
    const double K4_23 = Js4_23 - Js4_26*UH4_3;
    const double K4_34 = Js4_34 - Js4_36*UH4_4;
    const double K4_35 = Js4_35 - Js4_36*UH4_5;
    const double K4_33 = Js4_33 - Js4_36*UH4_3;
    const double Gb4 = tau4 + bs4_6;
    const double al4_1 = g4_1*K4_11 + g4_2*K4_12 + g4_3*K4_13 + g4_4*K4_14 + g4_5*K4_15 + UH4_1*Gb4 - bs4_1;
    const double al4_2 = g4_1*K4_12 + g4_2*K4_22 + g4_3*K4_23 + g4_4*K4_24 + g4_5*K4_25 + UH4_2*Gb4 - bs4_2;
    const double al4_3 = g4_1*K4_13 + g4_2*K4_23 + g4_3*K4_33 + g4_4*K4_34 + g4_5*K4_35 + UH4_3*Gb4 - bs4_3;
    const double al4_4 = g4_1*K4_14 + g4_2*K4_24 + g4_3*K4_34 + g4_4*K4_44 + g4_5*K4_45 + UH4_4*Gb4 - bs4_4;
    const double al4_5 = g4_1*K4_15 + g4_2*K4_25 + g4_3*K4_35 + g4_4*K4_45 + g4_5*K4_55 + UH4_5*Gb4 - bs4_5;
    const double al4_6 = g4_1*K4_16 + g4_2*K4_26 + g4_3*K4_36 + g4_4*K4_46 + g4_5*K4_56 + tau4*UH4_6 - bs4_6*rho4;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32]. */
    const double Js3_14a = -RL4*K4_12;
    const double Js3_14b = K4_14 + Js3_14a;
    const double Js3_14c = K4_15 + RL4*K4_11;
    const double Js3_14d = RL4*K4_22 - K4_24;
    const double Js3_14e = Js3_14a - K4_25;
    const double Js3_24a = K4_34 - RL4*K4_23;
    const double Js3_24b = -(K4_35 + RL4*K4_13);
    const double Js3_45a = K4_46 - RL4*K4_26;
    const double Js3_45b = K4_56 + RL4*K4_16;
    const double Js3_44a = K4_44 + RL4*(Js3_14d - K4_24);
    const double Js3_44b = K4_55 + RL4*(K4_15 + Js3_14c);
    const double Js3_44c = K4_45 + RL4*(K4_14 + Js3_14e);
    const double Js3_13a = sin_th4*(K4_11 - K4_22) + 2.0*K4_12*cos_th4;
    const double Js3_11a = sin_th4*Js3_13a;
    const double Js3_13 = K4_12 - cos_th4*Js3_13a;
    const double Js3_33a = K4_22 + Js3_11a;
    const double Js3_12 = cos_th4*K4_13 - sin_th4*K4_23;
    const double Js3_23 = -(sin_th4*K4_13 + cos_th4*K4_23);
    const double Js3_14f = sin_th4*(Js3_14b + Js3_14e) + cos_th4*(Js3_14c - Js3_14d);
    const double Js3_14g = sin_th4*Js3_14f;
    const double Js3_14 = Js3_14b - Js3_14g;
    const double Js3_16a = cos_th4*Js3_14f;
    const double Js3_34a = Js3_14c - Js3_16a;
    const double Js3_36a = Js3_14e - Js3_14g;
    const double Js3_35a = -(sin_th4*K4_16 + cos_th4*K4_26);
    const double Js3_24c = cos_th4*Js3_24a + sin_th4*Js3_24b;
    const double Js3_26a = sin_th4*Js3_24a - cos_th4*Js3_24b;
    const double Js3_44d = sin_th4*(Js3_44a - Js3_44b) + 2.0*Js3_44c*cos_th4;
    const double Js3_44e = sin_th4*Js3_44d;
    const double Js3_36b = D4*Js3_23;
    const double Js3_36 = Js3_36b - Js3_36a;
    const double Js3_35b = Js3_35a - D4*Js3_33a;
    const double Js3_26b = Js3_26a - D4*K4_33;
    const double Js3_25 = K4_36 - Js3_36b;
    const double Js3_11 = M3 + K4_11 - Js3_11a;
    const double Js3_22 = M3 + K4_33;
    const double Js3_33 = M3 + Js3_33a;
    const double Js3_15 = MZ3 - (sin_th4*K4_26 - cos_th4*K4_16 + D4*Js3_13);
    const double Js3_16 = -(MY3 + Js3_14d + Js3_16a - D4*Js3_12);
    const double Js3_24 = Js3_24c - MZ3;
    const double Js3_26 = MX3 - Js3_26b;
    const double Js3_34 = MY3 + Js3_34a;
    const double Js3_35 = Js3_35b - MX3;
    const double Js3_44 = XX3 + Js3_44a - Js3_44e;
    const double Js3_45 = XY3 + cos_th4*Js3_45a - sin_th4*Js3_45b - D4*Js3_34a;
    const double Js3_46 = XZ3 + Js3_44c - cos_th4*Js3_44d + D4*Js3_24c;
    const double Js3_55 = YY3 + K4_66 - D4*(Js3_35a + Js3_35b);
    const double Js3_56 = YZ3 - (sin_th4*Js3_45a + cos_th4*Js3_45b - D4*(Js3_36a + Js3_25));
    const double Js3_66 = ZZ3 + Js3_44b + Js3_44e - D4*(Js3_26a + Js3_26b);
    const double bs3_4a = al4_4 - RL4*al4_2;
    const double bs3_4b = -(al4_5 + RL4*al4_1);
    const double bs3_3a = -(sin_th4*al4_1 + cos_th4*al4_2);
    const double bs3_1 = b3_1 + sin_th4*al4_2 - cos_th4*al4_1;
    const double bs3_2 = b3_2 - al4_3;
    const double bs3_3 = b3_3 - bs3_3a;
    const double bs3_4 = b3_4 - (cos_th4*bs3_4a + sin_th4*bs3_4b);
    const double bs3_5 = b3_5 - (al4_6 - D4*bs3_3a);
    const double bs3_6 = b3_6 + sin_th4*bs3_4a - cos_th4*bs3_4b - D4*al4_3;
    const double H3 = IA3 + Js3_66;
    const double Hinv3 = 1.0/H3;
    const double UH3_1 = Js3_16*Hinv3;
    const double UH3_2 = Js3_26*Hinv3;
    const double UH3_3 = Js3_36*Hinv3;
    const double UH3_4 = Js3_46*Hinv3;
    const double UH3_5 = Js3_56*Hinv3;
    const double UH3_6 = Js3_66*Hinv3;
    const double rho3 = IA3*Hinv3;
    const double K3_16 = Js3_16*rho3;
    const double K3_26 = Js3_26*rho3;
    const double K3_36 = Js3_36*rho3;
    const double K3_46 = Js3_46*rho3;
    const double K3_56 = Js3_56*rho3;
    const double K3_66 = Js3_66*rho3;
    const double K3_14 = Js3_14 - Js3_16*UH3_4;
    const double K3_11 = Js3_11 - Js3_16*UH3_1;
    const double K3_44 = Js3_44 - Js3_46*UH3_4;
    const double K3_15 = Js3_15 - Js3_16*UH3_5;
    const double K3_12 = Js3_12 - Js3_16*UH3_2;
    const double K3_45 = Js3_45 - Js3_46*UH3_5;
    const double K3_13 = Js3_13 - Js3_16*UH3_3;
    const double K3_24 = Js3_24 - Js3_26*UH3_4;
    const double K3_25 = Js3_25 - Js3_26*UH3_5;
    const double K3_22 = Js3_22 - Js3_26*UH3_2;
    const double K3_55 = Js3_55 - Js3_56*UH3_5;
    const double K3_23 = Js3_23 - Js3_26*UH3_3;
    const double K3_34 = Js3_34 - Js3_36*UH3_4;
    const double K3_35 = Js3_35 - Js3_36*UH3_5;
    const double K3_33 = Js3_33 - Js3_36*UH3_3;
    const double Gb3 = tau3 + bs3_6;
    const double al3_1 = g3_1*K3_11 + g3_2*K3_12 + g3_3*K3_13 + g3_4*K3_14 + g3_5*K3_15 + UH3_1*Gb3 - bs3_1;
    const double al3_2 = g3_1*K3_12 + g3_2*K3_22 + g3_3*K3_23 + g3_4*K3_24 + g3_5*K3_25 + UH3_2*Gb3 - bs3_2;
    const double al3_3 = g3_1*K3_13 + g3_2*K3_23 + g3_3*K3_33 + g3_4*K3_34 + g3_5*K3_35 + UH3_3*Gb3 - bs3_3;
    const double al3_4 = g3_1*K3_14 + g3_2*K3_24 + g3_3*K3_34 + g3_4*K3_44 + g3_5*K3_45 + UH3_4*Gb3 - bs3_4;
    const double al3_5 = g3_1*K3_15 + g3_2*K3_25 + g3_3*K3_35 + g3_4*K3_45 + g3_5*K3_55 + UH3_5*Gb3 - bs3_5;
    const double al3_6 = g3_1*K3_16 + g3_2*K3_26 + g3_3*K3_36 + g3_4*K3_46 + g3_5*K3_56 + tau3*UH3_6 - bs3_6*rho3;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32]. */
    const double Js2_14a = -R3*K3_12;
    const double Js2_14b = K3_14 + Js2_14a;
    const double Js2_14c = K3_15 + R3*K3_11;
    const double Js2_14d = R3*K3_22 - K3_24;
    const double Js2_14e = Js2_14a - K3_25;
    const double Js2_34a = K3_34 - R3*K3_23;
    const double Js2_34b = -(K3_35 + R3*K3_13);
    const double Js2_46a = K3_46 - R3*K3_26;
    const double Js2_46b = K3_56 + R3*K3_16;
    const double Js2_44a = K3_44 + R3*(Js2_14d - K3_24);
    const double Js2_44b = K3_55 + R3*(K3_15 + Js2_14c);
    const double Js2_44c = K3_45 + R3*(K3_14 + Js2_14e);
    const double Js2_12a = sin_th3*(K3_11 - K3_22) + 2.0*K3_12*cos_th3;
    const double Js2_11a = sin_th3*Js2_12a;
    const double Js2_12 = cos_th3*Js2_12a - K3_12;
    const double Js2_22a = K3_22 + Js2_11a;
    const double Js2_13 = cos_th3*K3_13 - sin_th3*K3_23;
    const double Js2_23 = sin_th3*K3_13 + cos_th3*K3_23;
    const double Js2_14f = sin_th3*(Js2_14b + Js2_14e) + cos_th3*(Js2_14c - Js2_14d);
    const double Js2_14g = sin_th3*Js2_14f;
    const double Js2_14 = Js2_14b - Js2_14g;
    const double Js2_15a = cos_th3*Js2_14f;
    const double Js2_24a = Js2_14c - Js2_15a;
    const double Js2_25a = Js2_14e - Js2_14g;
    const double Js2_26a = -(sin_th3*K3_16 + cos_th3*K3_26);
    const double Js2_34c = cos_th3*Js2_34a + sin_th3*Js2_34b;
    const double Js2_35a = sin_th3*Js2_34a - cos_th3*Js2_34b;
    const double Js2_44d = sin_th3*(Js2_44a - Js2_44b) + 2.0*Js2_44c*cos_th3;
    const double Js2_44e = sin_th3*Js2_44d;
    const double Js2_25b = -D3*Js2_23;
    const double Js2_25 = Js2_25b - Js2_25a;
    const double Js2_26b = Js2_26a - D3*Js2_22a;
    const double Js2_35b = Js2_35a - D3*K3_33;
    const double Js2_36 = K3_36 - Js2_25b;
    const double Js2_11 = M2 + K3_11 - Js2_11a;
    const double Js2_22 = M2 + Js2_22a;
    const double Js2_15 = MZ2 + Js2_14d + Js2_15a - D3*Js2_13;
    const double Js2_16 = -(MY2 + sin_th3*K3_26 - cos_th3*K3_16 - D3*Js2_12);
    const double Js2_24 = -(MZ2 + Js2_24a);
    const double Js2_26 = MX2 - Js2_26b;
    const double Js2_34 = MY2 + Js2_34c;
    const double Js2_35 = Js2_35b - MX2;
    const double Js2_44 = XX2 + Js2_44a - Js2_44e;
    const double Js2_45 = XY2 - (Js2_44c - cos_th3*Js2_44d + D3*Js2_34c);
    const double Js2_46 = XZ2 + cos_th3*Js2_46a - sin_th3*Js2_46b - D3*Js2_24a;
    const double Js2_55 = YY2 + Js2_44b + Js2_44e - D3*(Js2_35a + Js2_35b);
    const double Js2_56 = YZ2 + sin_th3*Js2_46a + cos_th3*Js2_46b - D3*(Js2_25a + Js2_36);
    const double Js2_66 = ZZ2 + K3_66 - D3*(Js2_26a + Js2_26b);
    const double bs2_4a = al3_4 - R3*al3_2;
    const double bs2_4b = -(al3_5 + R3*al3_1);
    const double bs2_2a = -(sin_th3*al3_1 + cos_th3*al3_2);
    const double bs2_1 = b2_1 + sin_th3*al3_2 - cos_th3*al3_1;
    const double bs2_2 = b2_2 + bs2_2a;
    const double bs2_4 = b2_4 - (cos_th3*bs2_4a + sin_th3*bs2_4b);
    const double bs2_5 = b2_5 - (sin_th3*bs2_4a - cos_th3*bs2_4b - D3*al3_3);
    const double bs2_6 = b2_6 - (al3_6 - D3*bs2_2a);
    const double H2 = IA2 + Js2_66;
    const double Hinv2 = 1.0/H2;
    const double UH2_1 = Js2_16*Hinv2;
    const double UH2_2 = Js2_26*Hinv2;
    const double UH2_3 = Js2_36*Hinv2;
    const double UH2_4 = Js2_46*Hinv2;
    const double UH2_5 = Js2_56*Hinv2;
    const double K2_14 = Js2_14 - Js2_16*UH2_4;
    const double K2_11 = Js2_11 - Js2_16*UH2_1;
    const double K2_44 = Js2_44 - Js2_46*UH2_4;
    const double K2_15 = Js2_15 - Js2_16*UH2_5;
    const double K2_12 = Js2_12 - Js2_16*UH2_2;
    const double K2_45 = Js2_45 - Js2_46*UH2_5;
    const double K2_13 = Js2_13 - Js2_16*UH2_3;
    const double K2_24 = Js2_24 - Js2_26*UH2_4;
    const double K2_25 = Js2_25 - Js2_26*UH2_5;
    const double K2_22 = Js2_22 - Js2_26*UH2_2;
    const double K2_55 = Js2_55 - Js2_56*UH2_5;
    const double K2_23 = Js2_23 - Js2_26*UH2_3;
    const double K2_34 = Js2_34 - Js2_36*UH2_4;
    const double K2_35 = Js2_35 - Js2_36*UH2_5;
    const double Gb2 = tau2 + bs2_6;
    const double al2_1 = g2_3*K2_13 - (ww2_xz*K2_15 - ww2_yz*K2_14) + UH2_1*Gb2 - bs2_1;
    const double al2_2 = g2_3*K2_23 + ww2_yz*K2_24 - ww2_xz*K2_25 + UH2_2*Gb2 - bs2_2;
    const double al2_4 = -(bs2_4 + ww2_xz*K2_45 - ww2_yz*K2_44 - g2_3*K2_34 - UH2_4*Gb2);
    const double al2_5 = g2_3*K2_35 - (ww2_xz*K2_55 - ww2_yz*K2_45) + UH2_5*Gb2 - bs2_5;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32]. */
    const double Js1_36a = R2*K2_12;
    const double Js1_36b = K2_15 + R2*K2_11;
    const double Js1_36c = R2*K2_22 - K2_24;
    const double Js1_36d = -(K2_25 + Js1_36a);
    const double Js1_66a = K2_55 + R2*(K2_15 + Js1_36b);
    const double Js1_36 = sin_th2*(sin_th2*(K2_14 - Js1_36a + Js1_36d) + cos_th2*(Js1_36b - Js1_36c)) - Js1_36d;
    const double Js1_66 = ZZ1 + Js1_66a + sin_th2*(sin_th2*(K2_44 + R2*(Js1_36c - K2_24) - Js1_66a)
        + cos_th2*((K2_45 + R2*(K2_14 + Js1_36d))*2.0));
    const double bs1_6 = sin_th2*(al2_4 - R2*al2_2) + cos_th2*(al2_5 + R2*al2_1);
    const double H1 = IA1 + Js1_66;
    const double Hinv1 = 1.0/H1;
    const double Gb1 = tau1 + bs1_6;

    /* Forward recursion: accelerations and torques, joint 1 (j1) [33]-[36]. */
    const double qdd1 = Hinv1*(Gb1 + G3*Js1_36);

    /* Forward recursion: accelerations and torques, joint 2 (j2) [33]-[36]. */
    const double vd2_ya = sin_th2*qdd1;
    const double vd2_xa = cos_th2*qdd1;
    const double vd2_x = G3*sin_th2 - R2*vd2_xa;
    const double vd2_y = G3*cos_th2 + R2*vd2_ya;
    const double wd2_x = ww2_yz - vd2_ya;
    const double wd2_y = -(ww2_xz + vd2_xa);
    const double qdd2 = Hinv2*(Gb2 - (Js2_16*vd2_x + Js2_26*vd2_y + g2_3*Js2_36) - (Js2_46*wd2_x + Js2_56*wd2_y));

    /* Forward recursion: accelerations and torques, joint 3 (j3) [33]-[36]. */
    const double vd3_xa = vd2_y + D3*qdd2;
    const double vd3_ya = -(cos_th3*wd2_x + sin_th3*wd2_y);
    const double vd3_xb = cos_th3*wd2_y - sin_th3*wd2_x;
    const double vd3_x = g3_1 + cos_th3*vd2_x + sin_th3*vd3_xa + R3*vd3_xb;
    const double vd3_y = g3_2 - (sin_th3*vd2_x - cos_th3*vd3_xa - R3*vd3_ya);
    const double vd3_z = g3_3 - (D3*wd2_y - g2_3);
    const double wd3_x = g3_4 - vd3_ya;
    const double wd3_y = g3_5 + vd3_xb;
    const double qdd3 = Hinv3*(Gb3 - (Js3_16*vd3_x + Js3_26*vd3_y + Js3_36*vd3_z)
        - (Js3_46*wd3_x + Js3_56*wd3_y + Js3_66*qdd2));
    const double wd3_z = qdd2 + qdd3;

    /* Forward recursion: accelerations and torques, joint 4 (j4) [33]-[36]. */
    const double vd4_xa = D4*wd3_y - vd3_z;
    const double vd4_ya = cos_th4*wd3_x - sin_th4*wd3_z;
    const double vd4_xb = sin_th4*wd3_x + cos_th4*wd3_z;
    const double vd4_x = g4_1 - (RL4*vd4_xb - (cos_th4*vd3_x + sin_th4*vd4_xa));
    const double vd4_y = g4_2 + cos_th4*vd4_xa - sin_th4*vd3_x - RL4*vd4_ya;
    const double vd4_z = g4_3 + vd3_y + D4*wd3_z;
    const double wd4_x = g4_4 + vd4_ya;
    const double wd4_y = g4_5 - vd4_xb;
    const double qdd4 = Hinv4*(Gb4 - (Js4_16*vd4_x + Js4_26*vd4_y + Js4_36*vd4_z)
        - (Js4_46*wd4_x + Js4_56*wd4_y + Js4_66*wd3_y));
    const double wd4_z = wd3_y + qdd4;

    /* Forward recursion: accelerations and torques, joint 5 (j5) [33]-[36]. */
    const double vd5_x = cos_th5*vd4_x + sin_th5*vd4_z;
    const double vd5_y = cos_th5*vd4_z - sin_th5*vd4_x;
    const double wd5_x = g5_4 + cos_th5*wd4_x + sin_th5*wd4_z;
    const double wd5_y = g5_5 - (sin_th5*wd4_x - cos_th5*wd4_z);
    const double qdd5 = Hinv5*(Gb5 - (Js5_16*vd5_x + Js5_26*vd5_y - Js5_36*vd4_y)
        - (Js5_46*wd5_x + Js5_56*wd5_y - Js5_66*wd4_y));
    const double wd5_z = qdd5 - wd4_y;

    /* Forward recursion: accelerations and torques, joint 6 (j6) [33]-[36]. */
    const double vd6_x = cos_th6*vd5_x + sin_th6*vd4_y;
    const double vd6_y = cos_th6*vd4_y - sin_th6*vd5_x;
    const double wd6_x = g6_4 + cos_th6*wd5_x - sin_th6*wd5_z;
    const double wd6_y = g6_5 - (sin_th6*wd5_x + cos_th6*wd5_z);
    const double qdd6 = Hinv6*(Gb6 - (MX6*vd6_y - MY6*vd6_x) - (XZ6*wd6_x + YZ6*wd6_y + ZZ6*wd5_y));

    /* Results. */
    qdd[0] = qdd1;
    qdd[1] = qdd2;
    qdd[2] = qdd3;
    qdd[3] = qdd4;
    qdd[4] = qdd5;
    qdd[5] = qdd6;
}

void puma560_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[PUMA560_DIRECT_DYNAMICS_CONSTANTS];
    puma560_direct_dynamics_prepare(p, c);
    puma560_direct_dynamics_prepared(q, qd, tau, p, c, qdd);
}

void puma560_inverse_dynamics_prepare(const double *p, double *c)
{
    const double XX2 = p[PUMA560_P_XX2];
    const double YY2 = p[PUMA560_P_YY2];
    const double ZZ2 = p[PUMA560_P_ZZ2];
    const double XX3 = p[PUMA560_P_XX3];
    const double YY3 = p[PUMA560_P_YY3];
    const double ZZ3 = p[PUMA560_P_ZZ3];
    const double XX4 = p[PUMA560_P_XX4];
    const double YY4 = p[PUMA560_P_YY4];
    const double ZZ4 = p[PUMA560_P_ZZ4];
    const double XX5 = p[PUMA560_P_XX5];
    const double YY5 = p[PUMA560_P_YY5];
    const double ZZ5 = p[PUMA560_P_ZZ5];
    const double XX6 = p[PUMA560_P_XX6];
    const double YY6 = p[PUMA560_P_YY6];
    const double ZZ6 = p[PUMA560_P_ZZ6];

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

void puma560_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    const double th2 = q[1];
    const double th3 = q[2];
    const double th4 = q[3];
    const double th5 = q[4];
    const double th6 = q[5];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double qd3 = qd[2];
    const double qd4 = qd[3];
    const double qd5 = qd[4];
    const double qd6 = qd[5];
    const double qdd1 = qdd_motor[0];
    const double qdd2 = qdd_motor[1];
    const double qdd3 = qdd_motor[2];
    const double qdd4 = qdd_motor[3];
    const double qdd5 = qdd_motor[4];
    const double qdd6 = qdd_motor[5];
    const double ZZ1 = p[PUMA560_P_ZZ1];
    const double IA1 = p[PUMA560_P_IA1];
    const double R2 = p[PUMA560_P_R2];
    const double XX2 = p[PUMA560_P_XX2];
    const double XY2 = p[PUMA560_P_XY2];
    const double XZ2 = p[PUMA560_P_XZ2];
    const double YY2 = p[PUMA560_P_YY2];
    const double YZ2 = p[PUMA560_P_YZ2];
    const double ZZ2 = p[PUMA560_P_ZZ2];
    const double MX2 = p[PUMA560_P_MX2];
    const double MY2 = p[PUMA560_P_MY2];
    const double MZ2 = p[PUMA560_P_MZ2];
    const double M2 = p[PUMA560_P_M2];
    const double IA2 = p[PUMA560_P_IA2];
    const double D3 = p[PUMA560_P_D3];
    const double R3 = p[PUMA560_P_R3];
    const double XX3 = p[PUMA560_P_XX3];
    const double XY3 = p[PUMA560_P_XY3];
    const double XZ3 = p[PUMA560_P_XZ3];
    const double YY3 = p[PUMA560_P_YY3];
    const double YZ3 = p[PUMA560_P_YZ3];
    const double ZZ3 = p[PUMA560_P_ZZ3];
    const double MX3 = p[PUMA560_P_MX3];
    const double MY3 = p[PUMA560_P_MY3];
    const double MZ3 = p[PUMA560_P_MZ3];
    const double M3 = p[PUMA560_P_M3];
    const double IA3 = p[PUMA560_P_IA3];
    const double D4 = p[PUMA560_P_D4];
    const double RL4 = p[PUMA560_P_RL4];
    const double XX4 = p[PUMA560_P_XX4];
    const double XY4 = p[PUMA560_P_XY4];
    const double XZ4 = p[PUMA560_P_XZ4];
    const double YY4 = p[PUMA560_P_YY4];
    const double YZ4 = p[PUMA560_P_YZ4];
    const double ZZ4 = p[PUMA560_P_ZZ4];
    const double MX4 = p[PUMA560_P_MX4];
    const double MY4 = p[PUMA560_P_MY4];
    const double MZ4 = p[PUMA560_P_MZ4];
    const double M4 = p[PUMA560_P_M4];
    const double IA4 = p[PUMA560_P_IA4];
    const double XX5 = p[PUMA560_P_XX5];
    const double XY5 = p[PUMA560_P_XY5];
    const double XZ5 = p[PUMA560_P_XZ5];
    const double YY5 = p[PUMA560_P_YY5];
    const double YZ5 = p[PUMA560_P_YZ5];
    const double ZZ5 = p[PUMA560_P_ZZ5];
    const double MX5 = p[PUMA560_P_MX5];
    const double MY5 = p[PUMA560_P_MY5];
    const double MZ5 = p[PUMA560_P_MZ5];
    const double M5 = p[PUMA560_P_M5];
    const double IA5 = p[PUMA560_P_IA5];
    const double XX6 = p[PUMA560_P_XX6];
    const double XY6 = p[PUMA560_P_XY6];
    const double XZ6 = p[PUMA560_P_XZ6];
    const double YY6 = p[PUMA560_P_YY6];
    const double YZ6 = p[PUMA560_P_YZ6];
    const double ZZ6 = p[PUMA560_P_ZZ6];
    const double MX6 = p[PUMA560_P_MX6];
    const double MY6 = p[PUMA560_P_MY6];
    const double MZ6 = p[PUMA560_P_MZ6];
    const double M6 = p[PUMA560_P_M6];
    const double IA6 = p[PUMA560_P_IA6];
    const double G3 = p[PUMA560_P_G3];
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
    const double sin_th2 = sin(th2);
    const double cos_th2 = cos(th2);
    const double w2_x = -qd1*sin_th2;
    const double w2_y = -qd1*cos_th2;
    const double ww2_xx = w2_x*w2_x;
    const double ww2_yy = w2_y*w2_y;
    const double ww2_zz = qd2*qd2;
    const double ww2_xy = w2_x*w2_y;
    const double ww2_xz = qd2*w2_x;
    const double ww2_yz = qd2*w2_y;
    const double vd2_z = -R2*ww1_zz;
    const double wd2_x = ww2_yz - qdd1*sin_th2;
    const double wd2_y = -(ww2_xz + qdd1*cos_th2);
    const double vd2_xa = R2*qdd1;
    const double vd2_x = G3*sin_th2 - cos_th2*vd2_xa;
    const double vd2_y = sin_th2*vd2_xa + G3*cos_th2;

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const double sin_th3 = sin(th3);
    const double cos_th3 = cos(th3);
    const double w3_x = cos_th3*w2_x + sin_th3*w2_y;
    const double w3_y = cos_th3*w2_y - sin_th3*w2_x;
    const double w3_z = qd2 + qd3;
    const double vd3_xa = ww2_yy + ww2_zz;
    const double ww3_xx = w3_x*w3_x;
    const double ww3_yy = w3_y*w3_y;
    const double ww3_zz = w3_z*w3_z;
    const double ww3_xy = w3_x*w3_y;
    const double ww3_xz = w3_x*w3_z;
    const double ww3_yz = w3_y*w3_z;
    const double vd3_xb = -(ww2_xz + wd2_y);
    const double vd3_xc = qdd2 + ww2_xy;
    const double vd3_xd = wd2_x - ww2_yz;
    const double vd3_za = wd2_y - ww2_xz;
    const double wd3_x = qd3*w3_y + cos_th3*wd2_x + sin_th3*wd2_y;
    const double wd3_y = cos_th3*wd2_y - sin_th3*wd2_x - qd3*w3_x;
    const double wd3_z = qdd2 + qdd3;
    const double vd3_xe = D3*vd3_xa + R3*vd3_xb - vd2_x;
    const double vd3_xf = vd2_y + D3*vd3_xc - R3*vd3_xd;
    const double vd3_z = vd2_z - (R3*(ww2_xx + ww2_yy) + D3*vd3_za);
    const double vd3_x = sin_th3*vd3_xf - cos_th3*vd3_xe;
    const double vd3_y = sin_th3*vd3_xe + cos_th3*vd3_xf;

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const double sin_th4 = sin(th4);
    const double cos_th4 = cos(th4);
    const double w4_x = cos_th4*w3_x - sin_th4*w3_z;
    const double w4_y = -(sin_th4*w3_x + cos_th4*w3_z);
    const double w4_z = qd4 + w3_y;
    const double vd4_xa = ww3_yy + ww3_zz;
    const double vd4_za = ww3_xx + ww3_zz;
    const double ww4_xx = w4_x*w4_x;
    const double ww4_yy = w4_y*w4_y;
    const double ww4_zz = w4_z*w4_z;
    const double ww4_xy = w4_x*w4_y;
    const double ww4_xz = w4_x*w4_z;
    const double ww4_yz = w4_y*w4_z;
    const double vd4_xb = wd3_z - ww3_xy;
    const double vd4_zb = -(ww3_xy + wd3_z);
    const double vd4_xc = wd3_y - ww3_xz;
    const double vd4_xd = ww3_yz + wd3_x;
    const double wd4_x = qd4*w4_y + cos_th4*wd3_x - sin_th4*wd3_z;
    const double wd4_y = -(qd4*w4_x + sin_th4*wd3_x + cos_th4*wd3_z);
    const double wd4_z = qdd4 + wd3_y;
    const double vd4_xe = D4*vd4_xa + RL4*vd4_xb - vd3_x;
    const double vd4_z = vd3_y - (RL4*vd4_za + D4*vd4_zb);
    const double vd4_xf = D4*vd4_xc - RL4*vd4_xd - vd3_z;
    const double vd4_x = sin_th4*vd4_xf - cos_th4*vd4_xe;
    const double vd4_y = sin_th4*vd4_xe + cos_th4*vd4_xf;

    /* Forward recursion: velocities, joint 5 (j5) [1], [3], [7], [14]. */
    const double sin_th5 = sin(th5);
    const double cos_th5 = cos(th5);
    const double w5_x = cos_th5*w4_x + sin_th5*w4_z;
    const double w5_y = cos_th5*w4_z - sin_th5*w4_x;
    const double w5_z = qd5 - w4_y;
    const double ww5_xx = w5_x*w5_x;
    const double ww5_yy = w5_y*w5_y;
    const double ww5_zz = w5_z*w5_z;
    const double ww5_xy = w5_x*w5_y;
    const double ww5_xz = w5_x*w5_z;
    const double ww5_yz = w5_y*w5_z;
    const double wd5_x = qd5*w5_y + cos_th5*wd4_x + sin_th5*wd4_z;
    const double wd5_y = -(qd5*w5_x + sin_th5*wd4_x - cos_th5*wd4_z);
    const double wd5_z = qdd5 - wd4_y;
    const double vd5_x = cos_th5*vd4_x + sin_th5*vd4_z;
    const double vd5_y = cos_th5*vd4_z - sin_th5*vd4_x;

    /* Forward recursion: velocities, joint 6 (j6) [1], [3], [7], [14]. */
    const double sin_th6 = sin(th6);
    const double cos_th6 = cos(th6);
    const double w6_x = cos_th6*w5_x - sin_th6*w5_z;
    const double w6_y = -(sin_th6*w5_x + cos_th6*w5_z);
    const double w6_z = qd6 + w5_y;
    const double ww6_xx = w6_x*w6_x;
    const double ww6_yy = w6_y*w6_y;
    const double ww6_zz = w6_z*w6_z;
    const double ww6_xy = w6_x*w6_y;
    const double ww6_xz = w6_x*w6_z;
    const double ww6_yz = w6_y*w6_z;
    const double wd6_x = qd6*w6_y + cos_th6*wd5_x - sin_th6*wd5_z;
    const double wd6_y = -(qd6*w6_x + sin_th6*wd5_x + cos_th6*wd5_z);
    const double wd6_z = qdd6 + wd5_y;
    const double vd6_x = cos_th6*vd5_x + sin_th6*vd4_y;
    const double vd6_y = cos_th6*vd4_y - sin_th6*vd5_x;

    /* Backward recursion: articulated inertias and wrenches, joint 6 (j6) [50]-[56]. */
    const double f6_1a = wd6_z - ww6_xy;
    const double f6_1b = -(ww6_xz + wd6_y);
    const double f6_2a = -(ww6_xy + wd6_z);
    const double f6_2b = ww6_yz - wd6_x;
    const double f6_3a = wd6_y - ww6_xz;
    const double f6_3b = ww6_yz + wd6_x;
    const double f6_1 = M6*vd6_x - (MX6*(ww6_yy + ww6_zz) + MY6*f6_1a + MZ6*f6_1b);
    const double f6_2 = M6*vd6_y - (MX6*f6_2a + MY6*(ww6_xx + ww6_zz) - MZ6*f6_2b);
    const double f6_3 = M6*vd5_y - (MX6*f6_3a - MY6*f6_3b + MZ6*(ww6_xx + ww6_yy));
    const double f6_4 = YZ6*(ww6_yy - ww6_zz) - ww6_yz*dJ6_yz - XZ6*f6_2a + XY6*f6_3a + XX6*wd6_x + MY6*vd5_y - MZ6*vd6_y;
    const double f6_5 = -(XZ6*(ww6_xx - ww6_zz) - ww6_xz*dJ6_xz - YZ6*f6_1a - XY6*f6_3b - YY6*wd6_y + MX6*vd5_y
        - MZ6*vd6_x);
    const double f6_6 = XY6*(ww6_xx - ww6_yy) - ww6_xy*dJ6_xy - YZ6*f6_1b - XZ6*f6_2b + ZZ6*wd6_z + MX6*vd6_y - MY6*vd6_x;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (j5) [50]-[56]. */
    const double f5_1a = wd5_z - ww5_xy;
    const double f5_1b = -(ww5_xz + wd5_y);
    const double f5_2a = -(ww5_xy + wd5_z);
    const double f5_2b = ww5_yz - wd5_x;
    const double f5_3a = wd5_y - ww5_xz;
    const double f5_3b = ww5_yz + wd5_x;
    const double f5_1 = -(MX5*(ww5_yy + ww5_zz) + MY5*f5_1a + MZ5*f5_1b - M5*vd5_x + sin_th6*f6_2 - cos_th6*f6_1);
    const double f5_2 = M5*vd5_y - (MX5*f5_2a + MY5*(ww5_xx + ww5_zz) - MZ5*f5_2b) + f6_3;
    const double f5_3 = -(M5*vd4_y + MX5*f5_3a - MY5*f5_3b + MZ5*(ww5_xx + ww5_yy) + sin_th6*f6_1 + cos_th6*f6_2);
    const double f5_4 = YZ5*(ww5_yy - ww5_zz) - ww5_yz*dJ5_yz - XZ5*f5_2a + XY5*f5_3a + XX5*wd5_x - (MY5*vd4_y
        + MZ5*vd5_y) + cos_th6*f6_4 - sin_th6*f6_5;
    const double f5_5 = f6_6 - (XZ5*(ww5_xx - ww5_zz) - ww5_xz*dJ5_xz - YZ5*f5_1a - XY5*f5_3b - YY5*wd5_y
        - (MZ5*vd5_x + MX5*vd4_y));
    const double f5_6 = XY5*(ww5_xx - ww5_yy) - ww5_xy*dJ5_xy - YZ5*f5_1b - XZ5*f5_2b + ZZ5*wd5_z + MX5*vd5_y
        - MY5*vd5_x - (sin_th6*f6_4 + cos_th6*f6_5);

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [50]-[56]. */
    const double f4_1a = wd4_z - ww4_xy;
    const double f4_1b = -(ww4_xz + wd4_y);
    const double f4_2a = -(ww4_xy + wd4_z);
    const double f4_2b = ww4_yz - wd4_x;
    const double f4_3a = wd4_y - ww4_xz;
    const double f4_3b = ww4_yz + wd4_x;
    const double f4_1 = -(MX4*(ww4_yy + ww4_zz) + MY4*f4_1a + MZ4*f4_1b - M4*vd4_x + sin_th5*f5_2 - cos_th5*f5_1);
    const double f4_2 = M4*vd4_y - (MX4*f4_2a + MY4*(ww4_xx + ww4_zz) - MZ4*f4_2b) - f5_3;
    const double f4_3 = M4*vd4_z - (MX4*f4_3a - MY4*f4_3b + MZ4*(ww4_xx + ww4_yy)) + sin_th5*f5_1 + cos_th5*f5_2;
    const double f4_4 = YZ4*(ww4_yy - ww4_zz) - ww4_yz*dJ4_yz - XZ4*f4_2a + XY4*f4_3a + XX4*wd4_x + MY4*vd4_z
        - MZ4*vd4_y + cos_th5*f5_4 - sin_th5*f5_5;
    const double f4_5 = -(XZ4*(ww4_xx - ww4_zz) - ww4_xz*dJ4_xz - YZ4*f4_1a - XY4*f4_3b - YY4*wd4_y + MX4*vd4_z
        - MZ4*vd4_x + f5_6);
    const double f4_6 = XY4*(ww4_xx - ww4_yy) - ww4_xy*dJ4_xy - YZ4*f4_1b - XZ4*f4_2b + ZZ4*wd4_z + MX4*vd4_y
        - MY4*vd4_x + sin_th5*f5_4 + cos_th5*f5_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [50]-[56]. */
    const double f3_1a = -(ww3_xz + wd3_y);
    const double f3_2a = ww3_yz - wd3_x;
    const double f3_4a = f4_4 - RL4*f4_2;
    const double f3_4b = -(f4_5 + RL4*f4_1);
    const double f3_3a = -(sin_th4*f4_1 + cos_th4*f4_2);
    const double f3_1 = -(MX3*vd4_xa + MY3*vd4_xb + MZ3*f3_1a - M3*vd3_x + sin_th4*f4_2 - cos_th4*f4_1);
    const double f3_2 = M3*vd3_y - (MX3*vd4_zb + MY3*vd4_za - MZ3*f3_2a) + f4_3;
    const double f3_3 = f3_3a - (MX3*vd4_xc - MY3*vd4_xd + MZ3*(ww3_xx + ww3_yy) - M3*vd3_z);
    const double f3_4 = YZ3*(ww3_yy - ww3_zz) - ww3_yz*dJ3_yz - XZ3*vd4_zb + XY3*vd4_xc + XX3*wd3_x - (MZ3*vd3_y
        - MY3*vd3_z) + cos_th4*f3_4a + sin_th4*f3_4b;
    const double f3_5 = f4_6 - D4*f3_3a - (XZ3*(ww3_xx - ww3_zz) - ww3_xz*dJ3_xz - YZ3*vd4_xb - XY3*vd4_xd
        - YY3*wd3_y + MX3*vd3_z - MZ3*vd3_x);
    const double f3_6 = XY3*(ww3_xx - ww3_yy) - ww3_xy*dJ3_xy - YZ3*f3_1a - XZ3*f3_2a + ZZ3*wd3_z + MX3*vd3_y
        - MY3*vd3_x - (sin_th4*f3_4a - cos_th4*f3_4b - D4*f4_3);

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [50]-[56]. */
    const double f2_1a = qdd2 - ww2_xy;
    const double f2_4a = f3_4 - R3*f3_2;
    const double f2_4b = -(f3_5 + R3*f3_1);
    const double f2_2a = -(sin_th3*f3_1 + cos_th3*f3_2);
    const double f2_1 = -(MX2*vd3_xa + MY2*f2_1a + MZ2*vd3_xb - M2*vd2_x + sin_th3*f3_2 - cos_th3*f3_1);
    const double f2_2 = M2*vd2_y + MX2*vd3_xc - MY2*(ww2_xx + ww2_zz) - MZ2*vd3_xd - f2_2a;
    const double f2_4 = YZ2*(ww2_yy - ww2_zz) - ww2_yz*dJ2_yz + XZ2*vd3_xc + XY2*vd3_za + XX2*wd2_x - (MZ2*vd2_y
        - MY2*vd2_z) + cos_th3*f2_4a + sin_th3*f2_4b;
    const double f2_5 = sin_th3*f2_4a - cos_th3*f2_4b - D3*f3_3 - (XZ2*(ww2_xx - ww2_zz) - ww2_xz*dJ2_xz
        - YZ2*f2_1a - XY2*(ww2_yz + wd2_x) - YY2*wd2_y + MX2*vd2_z - MZ2*vd2_x);
    const double f2_6 = XY2*(ww2_xx - ww2_yy) - ww2_xy*dJ2_xy - YZ2*vd3_xb + XZ2*vd3_xd + ZZ2*qdd2 + MX2*vd2_y
        - MY2*vd2_x + f3_6 - D3*f2_2a;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [50]-[56]. */
    const double f1_6 = ZZ1*qdd1 - (sin_th2*(f2_4 - R2*f2_2) + cos_th2*(f2_5 + R2*f2_1));

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
    tau[0] = Gamma1;
    tau[1] = Gamma2;
    tau[2] = Gamma3;
    tau[3] = Gamma4;
    tau[4] = Gamma5;
    tau[5] = Gamma6;
    qdd[0] = qdd1;
    qdd[1] = qdd2;
    qdd[2] = qdd3;
    qdd[3] = qdd4;
    qdd[4] = qdd5;
    qdd[5] = qdd6;
}

void puma560_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[PUMA560_INVERSE_DYNAMICS_CONSTANTS];
    puma560_inverse_dynamics_prepare(p, c);
    puma560_inverse_dynamics_prepared(q, qd, qdd_motor, p, c, tau, qdd);
}
