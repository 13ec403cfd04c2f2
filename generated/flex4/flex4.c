/* flex4: generated models. Equation numbers are those of Khalil and Gautier. */
#include <math.h>

#include "flex4.h"

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

void flex4_direct_dynamics_prepare(const double *p, double *c)
{
    const double ZZ1 = p[FLEX4_P_ZZ1];
    const double IA1 = p[FLEX4_P_IA1];
    const double L2 = p[FLEX4_P_L2];
    const double XX3 = p[FLEX4_P_XX3];
    const double XZ3 = p[FLEX4_P_XZ3];
    const double YY3 = p[FLEX4_P_YY3];
    const double YZ3 = p[FLEX4_P_YZ3];
    const double ZZ3 = p[FLEX4_P_ZZ3];
    const double MX3 = p[FLEX4_P_MX3];
    const double MY3 = p[FLEX4_P_MY3];
    const double M3 = p[FLEX4_P_M3];
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
    const double M4 = p[FLEX4_P_M4];

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const double dJ3_yz = YY3 - ZZ3;
    const double dJ3_xz = XX3 - ZZ3;
    const double dJ3_xy = XX3 - YY3;

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const double dJ4_yz = YY4 - ZZ4;
    const double dJ4_xz = XX4 - ZZ4;
    const double dJ4_xy = XX4 - YY4;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32]. */
    const double Hinv4 = 1.0/ZZ4;
    const double UH4_4 = XZ4*Hinv4;
    const double UH4_5 = YZ4*Hinv4;
    const double K4_14 = MY4*UH4_4;
    const double K4_44 = XX4 - XZ4*UH4_4;
    const double K4_15 = MZ4 + MY4*UH4_5;
    const double K4_45 = XY4 - XZ4*UH4_5;
    const double K4_24 = -(MZ4 + MX4*UH4_4);
    const double K4_25 = -MX4*UH4_5;
    const double K4_55 = YY4 - YZ4*UH4_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32]. */
    const double Js3_14a = K4_14 - K4_25;
    const double Js3_14b = K4_15 + K4_24;
    const double Js3_44a = K4_44 - K4_55;
    const double Js3_44b = 2.0*K4_45;
    const double Js3_33 = M3 + M4;
    const double H3 = ZZ3 + IA3;
    const double Hinv3 = 1.0/H3;
    const double UH3_4 = XZ3*Hinv3;
    const double UH3_5 = YZ3*Hinv3;
    const double K3_14a = MY3*UH3_4;
    const double K3_44a = XZ3*UH3_4;
    const double K3_15a = MY3*UH3_5;
    const double K3_45a = XZ3*UH3_5;
    const double K3_24a = MX3*UH3_4;
    const double K3_25a = MX3*UH3_5;
    const double K3_55a = YZ3*UH3_5;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32]. */
    const double Js2_66b = L2*Js3_33;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32]. */
    const double H1 = ZZ1 + IA1;
    const double Hinv1 = 1.0/H1;

    c[0] = dJ3_yz;
    c[1] = dJ3_xz;
    c[2] = dJ3_xy;
    c[3] = dJ4_yz;
    c[4] = dJ4_xz;
    c[5] = dJ4_xy;
    c[6] = Hinv4;
    c[7] = UH4_4;
    c[8] = UH4_5;
    c[9] = K4_14;
    c[10] = K4_44;
    c[11] = K4_15;
    c[12] = K4_45;
    c[13] = K4_24;
    c[14] = K4_25;
    c[15] = K4_55;
    c[16] = Js3_14a;
    c[17] = Js3_14b;
    c[18] = Js3_44a;
    c[19] = Js3_44b;
    c[20] = Hinv3;
    c[21] = UH3_4;
    c[22] = UH3_5;
    c[23] = K3_14a;
    c[24] = K3_44a;
    c[25] = K3_15a;
    c[26] = K3_45a;
    c[27] = K3_24a;
    c[28] = K3_25a;
    c[29] = K3_55a;
    c[30] = Js2_66b;
    c[31] = Hinv1;
}

void flex4_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    const double th2 = q[1];
    const double th3 = q[2];
    const double th4 = q[3];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double qd3 = qd[2];
    const double qd4 = qd[3];
    const double tau1 = tau[0];
    const double tau3 = tau[1];
    const double ZZ2 = p[FLEX4_P_ZZ2];
    const double k2 = p[FLEX4_P_k2];
    const double L2 = p[FLEX4_P_L2];
    const double XX3 = p[FLEX4_P_XX3];
    const double XY3 = p[FLEX4_P_XY3];
    const double XZ3 = p[FLEX4_P_XZ3];
    const double YY3 = p[FLEX4_P_YY3];
    const double YZ3 = p[FLEX4_P_YZ3];
    const double MX3 = p[FLEX4_P_MX3];
    const double MY3 = p[FLEX4_P_MY3];
    const double MZ3 = p[FLEX4_P_MZ3];
    const double XY4 = p[FLEX4_P_XY4];
    const double XZ4 = p[FLEX4_P_XZ4];
    const double YZ4 = p[FLEX4_P_YZ4];
    const double ZZ4 = p[FLEX4_P_ZZ4];
    const double MX4 = p[FLEX4_P_MX4];
    const double MY4 = p[FLEX4_P_MY4];
    const double MZ4 = p[FLEX4_P_MZ4];
    const double k4 = p[FLEX4_P_k4];
    const double G3 = p[FLEX4_P_G3];
    const double dJ3_yz = c[0];
    const double dJ3_xz = c[1];
    const double dJ3_xy = c[2];
    const double dJ4_yz = c[3];
    const double dJ4_xz = c[4];
    const double dJ4_xy = c[5];
    const double Hinv4 = c[6];
    const double UH4_4 = c[7];
    const double UH4_5 = c[8];
    const double K4_14 = c[9];
    const double K4_44 = c[10];
    const double K4_15 = c[11];
    const double K4_45 = c[12];
    const double K4_24 = c[13];
    const double K4_25 = c[14];
    const double K4_55 = c[15];
    const double Js3_14a = c[16];
    const double Js3_14b = c[17];
    const double Js3_44a = c[18];
    const double Js3_44b = c[19];
    const double Hinv3 = c[20];
    const double UH3_4 = c[21];
    const double UH3_5 = c[22];
    const double K3_14a = c[23];
    const double K3_44a = c[24];
    const double K3_15a = c[25];
    const double K3_45a = c[26];
    const double K3_24a = c[27];
    const double K3_25a = c[28];
    const double K3_55a = c[29];
    const double Js2_66b = c[30];
    const double Hinv1 = c[31];

    /* Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14]. */
    const double w2_z = qd1 + qd2;
    const double ww2_zz = w2_z*w2_z;

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const double sin_th3 = sin(th3);
    const double cos_th3 = cos(th3);
    const double w3_x = sin_th3*w2_z;
    const double w3_y = cos_th3*w2_z;
    const double ww3_xx = w3_x*w3_x;
    const double ww3_yy = w3_y*w3_y;
    const double ww3_zz = qd3*qd3;
    const double ww3_xy = w3_x*w3_y;
    const double ww3_xz = qd3*w3_x;
    const double ww3_yz = qd3*w3_y;
    const double g3_1a = L2*ww2_zz;
    const double g3_1 = -cos_th3*g3_1a;
    const double g3_2 = sin_th3*g3_1a;
    const double b3_3 = MZ3*(ww3_xx + ww3_yy) - (MX3*ww3_xz + MY3*ww3_yz);
    const double b3_4 = XY3*ww3_xz - (YZ3*(ww3_yy - ww3_zz) - ww3_yz*dJ3_yz + XZ3*ww3_xy);
    const double b3_5 = XZ3*(ww3_xx - ww3_zz) - ww3_xz*dJ3_xz + YZ3*ww3_xy - XY3*ww3_yz;
    const double b3_6 = XZ3*ww3_yz - (XY3*(ww3_xx - ww3_yy) - ww3_xy*dJ3_xy + YZ3*ww3_xz);

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const double sin_th4 = sin(th4);
    const double cos_th4 = cos(th4);
    const double w4_x = cos_th4*w3_x + sin_th4*w3_y;
    const double w4_y = cos_th4*w3_y - sin_th4*w3_x;
    const double w4_z = qd3 + qd4;
    const double ww4_xx = w4_x*w4_x;
    const double ww4_yy = w4_y*w4_y;
    const double ww4_zz = w4_z*w4_z;
    const double ww4_xy = w4_x*w4_y;
    const double ww4_xz = w4_x*w4_z;
    const double ww4_yz = w4_y*w4_z;
    const double g4_4 = qd4*w4_y;
    const double g4_5 = -qd4*w4_x;
    const double b4_3 = MZ4*(ww4_xx + ww4_yy) - (MX4*ww4_xz + MY4*ww4_yz);
    const double b4_4 = XY4*ww4_xz - (YZ4*(ww4_yy - ww4_zz) - ww4_yz*dJ4_yz + XZ4*ww4_xy);
    const double b4_5 = XZ4*(ww4_xx - ww4_zz) - ww4_xz*dJ4_xz + YZ4*ww4_xy - XY4*ww4_yz;
    const double b4_6 = XZ4*ww4_yz - (XY4*(ww4_xx - ww4_yy) - ww4_xy*dJ4_xy + YZ4*ww4_xz);

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [28]-[32]. */
    const double Gamma4 = -k4*th4;
    const double Gb4 = Gamma4 + b4_6;
    const double al4_3 = -(b4_3 + MX4*g4_5 - MY4*g4_4);
    const double al4_4 = g4_4*K4_44 + g4_5*K4_45 + UH4_4*Gb4 - b4_4;
    const double al4_5 = g4_4*K4_45 + g4_5*K4_55 + UH4_5*Gb4 - b4_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [28]-[32]. */
    const double Js3_14c = sin_th4*Js3_14a + cos_th4*Js3_14b;
    const double Js3_14d = sin_th4*Js3_14c;
    const double Js3_14 = K4_14 - Js3_14d;
    const double Js3_15a = cos_th4*Js3_14c;
    const double Js3_25 = K4_25 + Js3_14d;
    const double Js3_44c = sin_th4*Js3_44a + cos_th4*Js3_44b;
    const double Js3_44d = sin_th4*Js3_44c;
    const double Js3_15 = MZ3 + Js3_15a - K4_24;
    const double Js3_24 = -(MZ3 + K4_15 - Js3_15a);
    const double Js3_34 = MY3 + MY4*cos_th4 + MX4*sin_th4;
    const double Js3_35 = MY4*sin_th4 - MX4*cos_th4 - MX3;
    const double Js3_44 = XX3 + K4_44 - Js3_44d;
    const double Js3_45 = XY3 - (K4_45 - cos_th4*Js3_44c);
    const double Js3_55 = YY3 + K4_55 + Js3_44d;
    const double bs3_3 = b3_3 - al4_3;
    const double bs3_4 = b3_4 - (cos_th4*al4_4 - sin_th4*al4_5);
    const double bs3_5 = b3_5 - (sin_th4*al4_4 + cos_th4*al4_5);
    const double bs3_6 = b3_6 - Gamma4;
    const double K3_14 = Js3_14 + K3_14a;
    const double K3_44 = Js3_44 - K3_44a;
    const double K3_15 = Js3_15 + K3_15a;
    const double K3_45 = Js3_45 - K3_45a;
    const double K3_24 = Js3_24 - K3_24a;
    const double K3_25 = Js3_25 - K3_25a;
    const double K3_55 = Js3_55 - K3_55a;
    const double Gb3 = tau3 + bs3_6;
    const double al3_3 = ww3_yz*Js3_34 - ww3_xz*Js3_35 - bs3_3;
    const double al3_4 = g3_1*K3_14 + g3_2*K3_24 + ww3_yz*K3_44 - ww3_xz*K3_45 + UH3_4*Gb3 - bs3_4;
    const double al3_5 = g3_1*K3_15 + g3_2*K3_25 + ww3_yz*K3_45 - ww3_xz*K3_55 + UH3_5*Gb3 - bs3_5;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [28]-[32]. */
    const double Gamma2 = -k2*th2;
    const double Js2_36 = K3_25 + sin_th3*(sin_th3*(K3_14 - K3_25) + cos_th3*(K3_15 + K3_24));
    const double Js2_66a = sin_th3*Js3_34 + cos_th3*Js3_35;
    const double Js2_66 = ZZ2 + K3_55 + sin_th3*(sin_th3*(K3_44 - K3_55) + 2.0*K3_45*cos_th3) - L2*(Js2_66a
        + Js2_66a - Js2_66b);
    const double bs2_6 = L2*al3_3 - (sin_th3*al3_4 + cos_th3*al3_5);
    const double Hinv2 = 1.0/Js2_66;
    const double Gb2 = Gamma2 + bs2_6;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [28]-[32]. */
    const double Gb1 = tau1 - Gamma2;

    /* Forward recursion: accelerations and torques, joint 1 (j1) [33]-[36]. */
    const double qdd1 = Hinv1*Gb1;

    /* Forward recursion: accelerations and torques, joint 2 (j2) [33]-[36]. */
    const double qdd2 = -Hinv2*(Js2_66*qdd1 - (Gb2 + G3*Js2_36));
    const double wd2_z = qdd1 + qdd2;

    /* Forward recursion: accelerations and torques, joint 3 (j3) [33]-[36]. */
    const double vd3_x = g3_1 - G3*sin_th3;
    const double vd3_y = g3_2 - G3*cos_th3;
    const double wd3_x = ww3_yz + sin_th3*wd2_z;
    const double wd3_y = cos_th3*wd2_z - ww3_xz;
    const double qdd3 = Hinv3*(Gb3 - (MX3*vd3_y - MY3*vd3_x) - (XZ3*wd3_x + YZ3*wd3_y));

    /* Forward recursion: accelerations and torques, joint 4 (j4) [33]-[36]. */
    const double vd4_x = cos_th4*vd3_x + sin_th4*vd3_y;
    const double vd4_y = cos_th4*vd3_y - sin_th4*vd3_x;
    const double wd4_x = g4_4 + cos_th4*wd3_x + sin_th4*wd3_y;
    const double wd4_y = g4_5 - (sin_th4*wd3_x - cos_th4*wd3_y);
    const double qdd4 = -Hinv4*(MX4*vd4_y - MY4*vd4_x - Gb4 + XZ4*wd4_x + YZ4*wd4_y + ZZ4*qdd3);

    /* Results. */
    qdd[0] = qdd1;
    qdd[1] = qdd2;
    qdd[2] = qdd3;
    qdd[3] = qdd4;
}

void flex4_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[FLEX4_DIRECT_DYNAMICS_CONSTANTS];
    flex4_direct_dynamics_prepare(p, c);
    flex4_direct_dynamics_prepared(q, qd, tau, p, c, qdd);
}

void flex4_inverse_dynamics_prepare(const double *p, double *c)
{
    const double L2 = p[FLEX4_P_L2];
    const double XX3 = p[FLEX4_P_XX3];
    const double YY3 = p[FLEX4_P_YY3];
    const double ZZ3 = p[FLEX4_P_ZZ3];
    const double M3 = p[FLEX4_P_M3];
    const double XX4 = p[FLEX4_P_XX4];
    const double XY4 = p[FLEX4_P_XY4];
    const double XZ4 = p[FLEX4_P_XZ4];
    const double YY4 = p[FLEX4_P_YY4];
    const double YZ4 = p[FLEX4_P_YZ4];
    const double ZZ4 = p[FLEX4_P_ZZ4];
    const double MX4 = p[FLEX4_P_MX4];
    const double MY4 = p[FLEX4_P_MY4];
    const double MZ4 = p[FLEX4_P_MZ4];
    const double M4 = p[FLEX4_P_M4];

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const double dJ3_yz = YY3 - ZZ3;
    const double dJ3_xz = XX3 - ZZ3;
    const double dJ3_xy = XX3 - YY3;

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const double dJ4_yz = YY4 - ZZ4;
    const double dJ4_xz = XX4 - ZZ4;
    const double dJ4_xy = XX4 - YY4;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [50]-[56]. */
    const double Hinv4 = 1.0/ZZ4;
    const double UH4_4 = XZ4*Hinv4;
    const double UH4_5 = YZ4*Hinv4;
    const double K4_14 = MY4*UH4_4;
    const double K4_44 = XX4 - XZ4*UH4_4;
    const double K4_15 = MZ4 + MY4*UH4_5;
    const double K4_45 = XY4 - XZ4*UH4_5;
    const double K4_24 = -(MZ4 + MX4*UH4_4);
    const double K4_25 = -MX4*UH4_5;
    const double K4_55 = YY4 - YZ4*UH4_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [50]-[56]. */
    const double Js3_14a = K4_14 - K4_25;
    const double Js3_14b = K4_15 + K4_24;
    const double Js3_44a = K4_44 - K4_55;
    const double Js3_44b = 2.0*K4_45;
    const double Js3_33 = M3 + M4;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [50]-[56]. */
    const double Js2_66b = L2*Js3_33;

    c[0] = dJ3_yz;
    c[1] = dJ3_xz;
    c[2] = dJ3_xy;
    c[3] = dJ4_yz;
    c[4] = dJ4_xz;
    c[5] = dJ4_xy;
    c[6] = Hinv4;
    c[7] = UH4_4;
    c[8] = UH4_5;
    c[9] = K4_14;
    c[10] = K4_44;
    c[11] = K4_15;
    c[12] = K4_45;
    c[13] = K4_24;
    c[14] = K4_25;
    c[15] = K4_55;
    c[16] = Js3_14a;
    c[17] = Js3_14b;
    c[18] = Js3_44a;
    c[19] = Js3_44b;
    c[20] = Js2_66b;
}

void flex4_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    const double th2 = q[1];
    const double th3 = q[2];
    const double th4 = q[3];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double qd3 = qd[2];
    const double qd4 = qd[3];
    const double qdd1 = qdd_motor[0];
    const double qdd3 = qdd_motor[1];
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
    const double XY4 = p[FLEX4_P_XY4];
    const double XZ4 = p[FLEX4_P_XZ4];
    const double YZ4 = p[FLEX4_P_YZ4];
    const double ZZ4 = p[FLEX4_P_ZZ4];
    const double MX4 = p[FLEX4_P_MX4];
    const double MY4 = p[FLEX4_P_MY4];
    const double MZ4 = p[FLEX4_P_MZ4];
    const double k4 = p[FLEX4_P_k4];
    const double G3 = p[FLEX4_P_G3];
    const double dJ3_yz = c[0];
    const double dJ3_xz = c[1];
    const double dJ3_xy = c[2];
    const double dJ4_yz = c[3];
    const double dJ4_xz = c[4];
    const double dJ4_xy = c[5];
    const double Hinv4 = c[6];
    const double UH4_4 = c[7];
    const double UH4_5 = c[8];
    const double K4_14 = c[9];
    const double K4_44 = c[10];
    const double K4_15 = c[11];
    const double K4_45 = c[12];
    const double K4_24 = c[13];
    const double K4_25 = c[14];
    const double K4_55 = c[15];
    const double Js3_14a = c[16];
    const double Js3_14b = c[17];
    const double Js3_44a = c[18];
    const double Js3_44b = c[19];
    const double Js2_66b = c[20];

    /* Forward recursion: velocities, joint 2 (j2) [1], [3], [7], [14]. */
    const double w2_z = qd1 + qd2;
    const double ww2_zz = w2_z*w2_z;

    /* Forward recursion: velocities, joint 3 (j3) [1], [3], [7], [14]. */
    const double sin_th3 = sin(th3);
    const double cos_th3 = cos(th3);
    const double w3_x = sin_th3*w2_z;
    const double w3_y = cos_th3*w2_z;
    const double ww3_xx = w3_x*w3_x;
    const double ww3_yy = w3_y*w3_y;
    const double ww3_zz = qd3*qd3;
    const double ww3_xy = w3_x*w3_y;
    const double ww3_xz = qd3*w3_x;
    const double ww3_yz = qd3*w3_y;
    const double g3_1a = L2*ww2_zz;
    const double g3_1 = -cos_th3*g3_1a;
    const double g3_2 = sin_th3*g3_1a;
    const double b3_3 = MZ3*(ww3_xx + ww3_yy) - (MX3*ww3_xz + MY3*ww3_yz);
    const double b3_4 = XY3*ww3_xz - (YZ3*(ww3_yy - ww3_zz) - ww3_yz*dJ3_yz + XZ3*ww3_xy);
    const double b3_5 = XZ3*(ww3_xx - ww3_zz) - ww3_xz*dJ3_xz + YZ3*ww3_xy - XY3*ww3_yz;
    const double b3_6a = YZ3*ww3_xz;
    const double b3_6b = XZ3*ww3_yz;
    const double b3_6 = b3_6b - (XY3*(ww3_xx - ww3_yy) - ww3_xy*dJ3_xy + b3_6a);

    /* Forward recursion: velocities, joint 4 (j4) [1], [3], [7], [14]. */
    const double sin_th4 = sin(th4);
    const double cos_th4 = cos(th4);
    const double w4_x = cos_th4*w3_x + sin_th4*w3_y;
    const double w4_y = cos_th4*w3_y - sin_th4*w3_x;
    const double w4_z = qd3 + qd4;
    const double ww4_xx = w4_x*w4_x;
    const double ww4_yy = w4_y*w4_y;
    const double ww4_zz = w4_z*w4_z;
    const double ww4_xy = w4_x*w4_y;
    const double ww4_xz = w4_x*w4_z;
    const double ww4_yz = w4_y*w4_z;
    const double g4_4 = qd4*w4_y;
    const double g4_5 = -qd4*w4_x;
    const double b4_3 = MZ4*(ww4_xx + ww4_yy) - (MX4*ww4_xz + MY4*ww4_yz);
    const double b4_4 = XY4*ww4_xz - (YZ4*(ww4_yy - ww4_zz) - ww4_yz*dJ4_yz + XZ4*ww4_xy);
    const double b4_5 = XZ4*(ww4_xx - ww4_zz) - ww4_xz*dJ4_xz + YZ4*ww4_xy - XY4*ww4_yz;
    const double b4_6 = XZ4*ww4_yz - (XY4*(ww4_xx - ww4_yy) - ww4_xy*dJ4_xy + YZ4*ww4_xz);

    /* Backward recursion: articulated inertias and wrenches, joint 4 (j4) [50]-[56]. */
    const double Gamma4 = -k4*th4;
    const double Gb4 = Gamma4 + b4_6;
    const double al4_3 = -(b4_3 + MX4*g4_5 - MY4*g4_4);
    const double al4_4 = g4_4*K4_44 + g4_5*K4_45 + UH4_4*Gb4 - b4_4;
    const double al4_5 = g4_4*K4_45 + g4_5*K4_55 + UH4_5*Gb4 - b4_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (j3) [50]-[56]. */
    const double Js3_14c = sin_th4*Js3_14a + cos_th4*Js3_14b;
    const double Js3_14d = sin_th4*Js3_14c;
    const double Js3_14 = K4_14 - Js3_14d;
    const double Js3_15a = cos_th4*Js3_14c;
    const double Js3_25 = K4_25 + Js3_14d;
    const double Js3_44c = sin_th4*Js3_44a + cos_th4*Js3_44b;
    const double Js3_44d = sin_th4*Js3_44c;
    const double Js3_15 = MZ3 + Js3_15a - K4_24;
    const double Js3_24 = -(MZ3 + K4_15 - Js3_15a);
    const double Js3_34 = MY3 + MY4*cos_th4 + MX4*sin_th4;
    const double Js3_35 = MY4*sin_th4 - MX4*cos_th4 - MX3;
    const double Js3_44 = XX3 + K4_44 - Js3_44d;
    const double Js3_45 = XY3 - (K4_45 - cos_th4*Js3_44c);
    const double Js3_55 = YY3 + K4_55 + Js3_44d;
    const double bs3_3 = b3_3 - al4_3;
    const double bs3_4 = b3_4 - (cos_th4*al4_4 - sin_th4*al4_5);
    const double bs3_5 = b3_5 - (sin_th4*al4_4 + cos_th4*al4_5);
    const double bs3_6 = b3_6 - Gamma4;
    const double al3_3 = ww3_yz*Js3_34 - ww3_xz*Js3_35 - bs3_3;
    const double al3_4 = g3_1*Js3_14 + g3_2*Js3_24 + ww3_yz*Js3_44 - ww3_xz*Js3_45 + XZ3*qdd3 - bs3_4;
    const double al3_5 = g3_1*Js3_15 + g3_2*Js3_25 + ww3_yz*Js3_45 - ww3_xz*Js3_55 + YZ3*qdd3 - bs3_5;
    const double al3_6 = MX3*g3_2 - MY3*g3_1 - (b3_6a - b3_6b) + ZZ3*qdd3 - bs3_6;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (j2) [50]-[56]. */
    const double Gamma2 = -k2*th2;
    const double Js2_36 = Js3_25 + sin_th3*(sin_th3*(Js3_14 - Js3_25) + cos_th3*(Js3_15 + Js3_24));
    const double Js2_66a = sin_th3*Js3_34 + cos_th3*Js3_35;
    const double Js2_66 = ZZ2 + Js3_55 + sin_th3*(sin_th3*(Js3_44 - Js3_55) + 2.0*Js3_45*cos_th3) - L2*(Js2_66a
        + Js2_66a - Js2_66b);
    const double bs2_6 = L2*al3_3 - (sin_th3*al3_4 + cos_th3*al3_5);
    const double Hinv2 = 1.0/Js2_66;
    const double Gb2 = Gamma2 + bs2_6;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (j1) [50]-[56]. */
    const double f1_6 = Gamma2 + ZZ1*qdd1;

    /* Forward recursion: accelerations and torques, joint 1 (j1) [57]-[61]. */
    const double Gamma1 = f1_6 + IA1*qdd1;

    /* Forward recursion: accelerations and torques, joint 2 (j2) [57]-[61]. */
    const double qdd2 = -Hinv2*(qdd1*Js2_66 - (Gb2 + G3*Js2_36));
    const double wd2_z = qdd1 + qdd2;

    /* Forward recursion: accelerations and torques, joint 3 (j3) [57]-[61]. */
    const double f3_6a = G3*sin_th3;
    const double f3_6b = G3*cos_th3;
    const double f3_6c = sin_th3*wd2_z;
    const double f3_6d = cos_th3*wd2_z;
    const double f3_6 = al3_6 + MY3*f3_6a - MX3*f3_6b + XZ3*f3_6c + YZ3*f3_6d;
    const double vd3_x = g3_1 - f3_6a;
    const double vd3_y = g3_2 - f3_6b;
    const double wd3_x = ww3_yz + f3_6c;
    const double wd3_y = f3_6d - ww3_xz;
    const double Gamma3 = f3_6 + IA3*qdd3;

    /* Forward recursion: accelerations and torques, joint 4 (j4) [57]-[61]. */
    const double vd4_x = cos_th4*vd3_x + sin_th4*vd3_y;
    const double vd4_y = cos_th4*vd3_y - sin_th4*vd3_x;
    const double wd4_x = g4_4 + cos_th4*wd3_x + sin_th4*wd3_y;
    const double wd4_y = g4_5 - (sin_th4*wd3_x - cos_th4*wd3_y);
    const double qdd4 = -Hinv4*(MX4*vd4_y - MY4*vd4_x - Gb4 + XZ4*wd4_x + YZ4*wd4_y + ZZ4*qdd3);

    /* Results. */
    tau[0] = Gamma1;
    tau[1] = Gamma3;
    qdd[0] = qdd1;
    qdd[1] = qdd2;
    qdd[2] = qdd3;
    qdd[3] = qdd4;
}

void flex4_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[FLEX4_INVERSE_DYNAMICS_CONSTANTS];
    flex4_inverse_dynamics_prepare(p, c);
    flex4_inverse_dynamics_prepared(q, qd, qdd_motor, p, c, tau, qdd);
}
