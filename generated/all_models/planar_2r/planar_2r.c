/* planar_2r: generated models. Equation numbers are those of Khalil and Gautier. */
#include <math.h>

#include "planar_2r.h"

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

void planar_2r_direct_dynamics_prepare(const double *p, double *c)
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

    /* Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32]. */
    const double Hinv2 = 1.0/J2_yy;
    const double UH2_2 = MS2_x*Hinv2;
    const double K2_22 = m2 - MS2_x*UH2_2;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32]. */
    const double Js1_12a = m2 - K2_22;

    c[0] = MS1_x;
    c[1] = J1_yy;
    c[2] = MS2_x;
    c[3] = J2_yy;
    c[4] = Hinv2;
    c[5] = UH2_2;
    c[6] = K2_22;
    c[7] = Js1_12a;
}

void planar_2r_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd)
{
    const double q1 = q[0];
    const double q2 = q[1];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double tau1 = tau[0];
    const double tau2 = tau[1];
    const double g0 = p[PLANAR_2R_P_g0];
    const double m2 = p[PLANAR_2R_P_m2];
    const double l1 = p[PLANAR_2R_P_l1];
    const double MS1_x = c[0];
    const double J1_yy = c[1];
    const double MS2_x = c[2];
    const double J2_yy = c[3];
    const double Hinv2 = c[4];
    const double UH2_2 = c[5];
    const double K2_22 = c[6];
    const double Js1_12a = c[7];

    /* Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14]. */
    const double sin_q1 = sin(q1);
    const double cos_q1 = cos(q1);
    const double ww1_zz = qd1*qd1;

    /* Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14]. */
    const double sin_q2 = sin(q2);
    const double cos_q2 = cos(q2);
    const double w2_z = qd1 + qd2;
    const double ww2_zz = w2_z*w2_z;
    const double g2_1a = l1*ww1_zz;
    const double g2_1 = -cos_q2*g2_1a;
    const double g2_2 = sin_q2*g2_1a;
    const double b2_1 = MS2_x*ww2_zz;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [28]-[32]. */
    const double al2_2 = g2_2*K2_22 + tau2*UH2_2;
    const double al2_1 = m2*g2_1 - b2_1;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [28]-[32]. */
    const double Js1_12b = sin_q2*Js1_12a;
    const double Js1_12 = cos_q2*Js1_12b;
    const double Js1_16 = l1*Js1_12;
    const double Js1_26a = l1*(K2_22 + sin_q2*Js1_12b);
    const double Js1_26 = MS1_x + Js1_26a;
    const double Js1_66 = J1_yy + l1*Js1_26a;
    const double bs1_2 = -(sin_q2*al2_1 + cos_q2*al2_2);
    const double bs1_6 = l1*bs1_2 - tau2;
    const double Hinv1 = 1.0/Js1_66;
    const double Gb1 = tau1 + bs1_6;

    /* Forward recursion: accelerations and torques, joint 1 (shoulder) [33]-[36]. */
    const double vd1_x = g0*sin_q1;
    const double vd1_y = g0*cos_q1;
    const double qdd1 = Hinv1*(Gb1 - (Js1_16*vd1_x + Js1_26*vd1_y));

    /* Forward recursion: accelerations and torques, joint 2 (elbow) [33]-[36]. */
    const double vd2_y = g2_2 - (sin_q2*vd1_x - cos_q2*(vd1_y + l1*qdd1));
    const double qdd2 = Hinv2*(tau2 - MS2_x*vd2_y - J2_yy*qdd1);

    /* Results. */
    qdd[0] = qdd1;
    qdd[1] = qdd2;
}

void planar_2r_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    double c[PLANAR_2R_DIRECT_DYNAMICS_CONSTANTS];
    planar_2r_direct_dynamics_prepare(p, c);
    planar_2r_direct_dynamics_prepared(q, qd, tau, p, c, qdd);
}

void planar_2r_inverse_dynamics_prepare(const double *p, double *c)
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

void planar_2r_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd)
{
    const double q1 = q[0];
    const double q2 = q[1];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double qdd1 = qdd_motor[0];
    const double qdd2 = qdd_motor[1];
    const double g0 = p[PLANAR_2R_P_g0];
    const double m2 = p[PLANAR_2R_P_m2];
    const double l1 = p[PLANAR_2R_P_l1];
    const double MS1_x = c[0];
    const double J1_yy = c[1];
    const double MS2_x = c[2];
    const double J2_yy = c[3];

    /* Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14]. */
    const double sin_q1 = sin(q1);
    const double cos_q1 = cos(q1);
    const double ww1_zz = qd1*qd1;
    const double vd1_x = g0*sin_q1;
    const double vd1_y = g0*cos_q1;

    /* Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14]. */
    const double sin_q2 = sin(q2);
    const double cos_q2 = cos(q2);
    const double w2_z = qd1 + qd2;
    const double ww2_zz = w2_z*w2_z;
    const double wd2_z = qdd1 + qdd2;
    const double vd2_xa = l1*ww1_zz - vd1_x;
    const double vd2_xb = vd1_y + l1*qdd1;
    const double vd2_x = sin_q2*vd2_xb - cos_q2*vd2_xa;
    const double vd2_y = sin_q2*vd2_xa + cos_q2*vd2_xb;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [50]-[56]. */
    const double f2_1 = m2*vd2_x - MS2_x*ww2_zz;
    const double f2_2 = m2*vd2_y + MS2_x*wd2_z;
    const double f2_6 = J2_yy*wd2_z + MS2_x*vd2_y;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [50]-[56]. */
    const double f1_6 = qdd1*J1_yy + MS1_x*vd1_y + f2_6 + l1*(sin_q2*f2_1 + cos_q2*f2_2);

    /* Results. */
    tau[0] = f1_6;
    tau[1] = f2_6;
    qdd[0] = qdd1;
    qdd[1] = qdd2;
}

void planar_2r_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    double c[PLANAR_2R_INVERSE_DYNAMICS_CONSTANTS];
    planar_2r_inverse_dynamics_prepare(p, c);
    planar_2r_inverse_dynamics_prepared(q, qd, qdd_motor, p, c, tau, qdd);
}

void planar_2r_inertia_matrix_prepare(const double *p, double *c)
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

void planar_2r_inertia_matrix_prepared(const double *q, const double *p, const double *c, double *A)
{
    const double q2 = q[1];
    const double l1 = p[PLANAR_2R_P_l1];
    const double J1_yy = c[0];
    const double MS2_x = c[1];
    const double J2_yy = c[2];
    const double J1_czza = c[3];

    /* Geometry, joint 2 (elbow) [1]. */
    const double cos_q2 = cos(q2);

    /* Composite inertias and inertia matrix, joint 2 (elbow) [8], [13]. */
    const double A1_2a = cos_q2*MS2_x;
    const double A1_2 = J2_yy + l1*A1_2a;

    /* Composite inertias and inertia matrix, joint 1 (shoulder) [8], [13]. */
    const double J1_czz = J1_yy + J2_yy + l1*(A1_2a + A1_2a + J1_czza);

    /* Results. */
    A[0] = J1_czz;
    A[1] = A1_2;
    A[2] = A1_2;
    A[3] = J2_yy;
}

void planar_2r_inertia_matrix(const double *q, const double *p, double *A)
{
    double c[PLANAR_2R_INERTIA_MATRIX_CONSTANTS];
    planar_2r_inertia_matrix_prepare(p, c);
    planar_2r_inertia_matrix_prepared(q, p, c, A);
}

void planar_2r_bias_forces_prepare(const double *p, double *c)
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

void planar_2r_bias_forces_prepared(const double *q, const double *qd, const double *p, const double *c, double *H)
{
    const double q1 = q[0];
    const double q2 = q[1];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double g0 = p[PLANAR_2R_P_g0];
    const double m2 = p[PLANAR_2R_P_m2];
    const double l1 = p[PLANAR_2R_P_l1];
    const double MS1_x = c[0];
    const double MS2_x = c[1];

    /* Forward recursion: velocities, joint 1 (shoulder) [1], [3], [7], [14]. */
    const double sin_q1 = sin(q1);
    const double cos_q1 = cos(q1);
    const double ww1_zz = qd1*qd1;
    const double vd1_x = g0*sin_q1;
    const double vd1_y = g0*cos_q1;

    /* Forward recursion: velocities, joint 2 (elbow) [1], [3], [7], [14]. */
    const double sin_q2 = sin(q2);
    const double cos_q2 = cos(q2);
    const double w2_z = qd1 + qd2;
    const double ww2_zz = w2_z*w2_z;
    const double vd2_xa = l1*ww1_zz - vd1_x;
    const double vd2_x = sin_q2*vd1_y - cos_q2*vd2_xa;
    const double vd2_y = sin_q2*vd2_xa + cos_q2*vd1_y;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (elbow) [15]. */
    const double f2_2 = m2*vd2_y;
    const double f2_1 = m2*vd2_x - MS2_x*ww2_zz;
    const double f2_6 = MS2_x*vd2_y;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (shoulder) [15]. */
    const double f1_6 = MS1_x*vd1_y + f2_6 + l1*(sin_q2*f2_1 + cos_q2*f2_2);

    /* Results. */
    H[0] = f1_6;
    H[1] = f2_6;
}

void planar_2r_bias_forces(const double *q, const double *qd, const double *p, double *H)
{
    double c[PLANAR_2R_BIAS_FORCES_CONSTANTS];
    planar_2r_bias_forces_prepare(p, c);
    planar_2r_bias_forces_prepared(q, qd, p, c, H);
}

void planar_2r_geometric_model(const double *q, const double *p, double *T)
{
    const double q1 = q[0];
    const double q2 = q[1];
    const double l1 = p[PLANAR_2R_P_l1];
    const double l2 = p[PLANAR_2R_P_l2];

    /* Geometry, joint 1 (shoulder) [1], [2]. */
    const double sin_q1 = sin(q1);
    const double cos_q1 = cos(q1);

    /* Geometry, joint 2 (elbow) [1], [2]. */
    const double sin_q2 = sin(q2);
    const double cos_q2 = cos(q2);
    const double P2_x = l1*cos_q1;
    const double P2_y = l1*sin_q1;
    const double A2_11 = cos_q1*cos_q2 - sin_q1*sin_q2;
    const double A2_12 = -(cos_q1*sin_q2 + sin_q1*cos_q2);

    /* Geometry, joint 3 (tip) [1], [2]. */
    const double P3_x = P2_x + l2*A2_11;
    const double P3_y = P2_y - l2*A2_12;

    /* Results. */
    T[0] = cos_q1;
    T[1] = -sin_q1;
    T[2] = 0.0;
    T[3] = 0.0;
    T[4] = sin_q1;
    T[5] = cos_q1;
    T[6] = 0.0;
    T[7] = 0.0;
    T[8] = 0.0;
    T[9] = 0.0;
    T[10] = 1.0;
    T[11] = 0.0;
    T[12] = 0.0;
    T[13] = 0.0;
    T[14] = 0.0;
    T[15] = 1.0;
    T[16] = A2_11;
    T[17] = A2_12;
    T[18] = 0.0;
    T[19] = P2_x;
    T[20] = -A2_12;
    T[21] = A2_11;
    T[22] = 0.0;
    T[23] = P2_y;
    T[24] = 0.0;
    T[25] = 0.0;
    T[26] = 1.0;
    T[27] = 0.0;
    T[28] = 0.0;
    T[29] = 0.0;
    T[30] = 0.0;
    T[31] = 1.0;
    T[32] = A2_11;
    T[33] = A2_12;
    T[34] = 0.0;
    T[35] = P3_x;
    T[36] = -A2_12;
    T[37] = A2_11;
    T[38] = 0.0;
    T[39] = P3_y;
    T[40] = 0.0;
    T[41] = 0.0;
    T[42] = 1.0;
    T[43] = 0.0;
    T[44] = 0.0;
    T[45] = 0.0;
    T[46] = 0.0;
    T[47] = 1.0;
}
