/* two_axis: generated models. Equation numbers are those of Khalil and Gautier. */
#include <math.h>

#include "two_axis.h"

const double two_axis_defaults[TWO_AXIS_PARAMETERS] = {
    0.35, /* D4 [m] */
    0.15, /* D12 [m] */
    0.25, /* L12 [m] */
    0.12 /* D13 [m] */
};

void two_axis_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd)
{
    const double q1 = q[0];
    const double q2 = q[1];
    const double q3 = q[2];
    const double q4 = q[3];
    const double q5 = q[4];
    const double q6 = q[5];
    const double q7 = q[6];
    const double q8 = q[7];
    const double q9 = q[8];
    const double q10 = q[9];
    const double q11 = q[10];
    const double q13 = q[11];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double qd3 = qd[2];
    const double qd4 = qd[3];
    const double qd5 = qd[4];
    const double qd6 = qd[5];
    const double qd7 = qd[6];
    const double qd8 = qd[7];
    const double qd9 = qd[8];
    const double qd10 = qd[9];
    const double qd11 = qd[10];
    const double qd13 = qd[11];
    const double tau5 = tau[0];
    const double tau9 = tau[1];
    const double D4 = p[TWO_AXIS_P_D4];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Forward recursion: velocities, joint 1 (bed_yaw) [1], [3], [7], [14]. */
    const double sin_q1 = sin(q1);
    const double cos_q1 = cos(q1);
    const double ww1_zz = qd1*qd1;

    /* Forward recursion: velocities, joint 2 (bed_y) [1], [3], [7], [14]. */
    const double g2_3 = -q2*ww1_zz;
    const double g2_2 = -2.0*qd2*qd1;

    /* Forward recursion: velocities, joint 3 (bed_x) [1], [3], [7], [14]. */
    const double g3_3 = -q3*ww1_zz;
    const double g3_1 = 2.0*qd3*qd1;
    const double b3_1 = -500.0*ww1_zz;

    /* Forward recursion: velocities, joint 4 (motor_secondary) [1], [3], [7], [14]. */
    const double g4_3 = -q4*ww1_zz;
    const double g4_1 = 2.0*qd4*qd1 - D4*ww1_zz;

    /* Forward recursion: velocities, joint 5 (motor_x) [1], [3], [7], [14]. */
    const double g5_3 = -q5*ww1_zz;
    const double g5_1 = 2.0*qd5*qd1;

    /* Forward recursion: velocities, joint 6 (cart_yaw) [1], [3], [7], [14]. */
    const double sin_q6 = sin(q6);
    const double cos_q6 = cos(q6);
    const double w6_z = qd1 + qd6;
    const double ww6_zz = w6_z*w6_z;

    /* Forward recursion: velocities, joint 7 (cart_x) [1], [3], [7], [14]. */
    const double g7_3 = -q7*ww6_zz;
    const double g7_2 = -2.0*qd7*w6_z;

    /* Forward recursion: velocities, joint 8 (cart_y) [1], [3], [7], [14]. */
    const double g8_3 = -q8*ww6_zz;
    const double g8_1 = -2.0*qd8*w6_z;
    const double b8_1 = 4.2*ww6_zz;
    const double b8_3 = 63.0*ww6_zz;

    /* Forward recursion: velocities, joint 9 (motor_y) [1], [3], [7], [14]. */
    const double g9_3 = -q9*ww6_zz;
    const double g9_1 = -2.0*qd9*w6_z;

    /* Forward recursion: velocities, joint 10 (y_chain_1) [1], [3], [7], [14]. */
    const double g10_3 = -q10*ww6_zz;
    const double g10_1 = -2.0*qd10*w6_z;

    /* Forward recursion: velocities, joint 11 (ram) [1], [3], [7], [14]. */
    const double g11_3 = -q11*ww6_zz;
    const double g11_1 = -2.0*qd11*w6_z;
    const double b11_3 = -14.25*ww6_zz;

    /* Forward recursion: velocities, joint 13 (sensor_head) [1], [3], [7], [14]. */
    const double g13_3 = -q13*ww1_zz;
    const double g13_1 = 2.0*qd13*qd1 - D13*ww1_zz;

    /* Backward recursion: articulated inertias and wrenches, joint 13 (sensor_head) [28]-[32]. */
    const double Gamma13 = -25000000.0*q13;
    const double al13_1 = 0.6*g13_1;

    /* Backward recursion: articulated inertias and wrenches, joint 11 (ram) [28]-[32]. */
    const double Gamma11 = -250000000.0*q11;
    const double al11_1 = 95.0*g11_1;
    const double al11_5 = -14.25*g11_1;
    const double Gb11 = Gamma11 + b11_3;

    /* Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [28]-[32]. */
    const double Gamma10 = -120000000.0*q10;
    const double Js10_15a = 95.0*q11;
    const double Js10_15 = Js10_15a - 14.25;
    const double Js10_55 = q11*(Js10_15a - 28.5) + 9.2375;
    const double bs10_5 = -(al11_5 + q11*al11_1);
    const double Gb10 = Gamma10 - Gamma11;
    const double al10_1 = al11_1 + 103.0*g10_1;
    const double al10_5 = g10_1*Js10_15 - bs10_5;

    /* Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [28]-[32]. */
    const double Js9_15 = Js10_15 + 103.0*q10;
    const double Js9_55 = Js10_55 + q10*(Js10_15 + Js9_15);
    const double bs9_5 = -(al10_5 + q10*al10_1);
    const double Gb9 = tau9 - Gamma10;
    const double al9_1 = al10_1 + 103.0*g9_1;
    const double al9_5 = g9_1*Js9_15 - bs9_5;

    /* Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [28]-[32]. */
    const double Gamma8 = -500000000.0*q8;
    const double Js8_15a = Js9_15 + 103.0*q9;
    const double Js8_15 = Js8_15a + 63.0;
    const double bs8_5 = -(al9_5 + q9*al9_1);
    const double bs8_1 = b8_1 - al9_1;
    const double bs8_3 = b8_3 - Gamma10;
    const double K8_55 = Js9_55 + q9*(Js9_15 + Js8_15a) + 34.9;
    const double Gb8 = Gamma8 + bs8_3;
    const double al8_1 = 313.0*g8_1 - bs8_1;
    const double al8_5 = -(bs8_5 + 0.02*Gb8 - g8_1*Js8_15);

    /* Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [28]-[32]. */
    const double Gamma7 = -350000000.0*q7;
    const double Js7_16 = Js8_15 + 313.0*q8;
    const double Js7_44 = K8_55 + q8*(Js8_15 + Js7_16);
    const double bs7_4 = al8_5 + q8*al8_1;
    const double UH7_4 = -0.003194888178913738*Js7_16;
    const double K7_44 = Js7_44 + Js7_16*UH7_4;
    const double Gb7 = Gamma7 - al8_1;
    const double al7_4 = UH7_4*Gb7 - bs7_4;

    /* Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [28]-[32]. */
    const double Gamma6 = -11000000.0*q6;
    const double bs6_6 = -(al7_4 + q7*Gamma8);
    const double Hinv6 = 1.0/K7_44;
    const double Gb6 = Gamma6 + bs6_6;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [28]-[32]. */
    const double Js5_15 = 0.6*q13;
    const double Js5_55 = q13*Js5_15 + 3.001;
    const double bs5_1 = -(al13_1 + cos_q6*Gamma8 + sin_q6*Gamma7);
    const double bs5_3 = -(Gamma13 + cos_q6*Gamma7 - sin_q6*Gamma8);
    const double bs5_5 = D13*Gamma13 - q13*al13_1 - Gamma6;
    const double Gb5 = tau5 + bs5_3;
    const double al5_1 = 45.6*g5_1 - bs5_1;
    const double al5_5 = g5_1*Js5_15 - bs5_5;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [28]-[32]. */
    const double Gamma4 = -600000000.0*q4;
    const double Js4_15 = Js5_15 + 45.6*q5;
    const double Js4_55 = Js5_55 + q5*(Js5_15 + Js4_15) + 12.0;
    const double bs4_5 = -(al5_5 + q5*al5_1);
    const double Gb4 = Gamma4 - tau5;
    const double al4_1 = al5_1 + 135.6*g4_1;
    const double al4_5 = g4_1*Js4_15 - bs4_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [28]-[32]. */
    const double Gamma3 = -100000000.0*q3;
    const double Js3_15 = Js4_15 + 135.6*q4;
    const double bs3_5 = D4*Gamma4 - (al4_5 + q4*al4_1);
    const double bs3_1 = b3_1 - al4_1;
    const double K3_55 = Js4_55 + q4*(Js4_15 + Js3_15) + 1100.0;
    const double Gb3 = Gamma3 - Gamma4;
    const double al3_1 = 2635.6*g3_1 - bs3_1;
    const double al3_5 = g3_1*Js3_15 + 0.2*Gb3 - bs3_5;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [28]-[32]. */
    const double Gamma2 = -150000000.0*q2;
    const double Js2_34 = Js3_15 + 2635.6*q3;
    const double Js2_44 = K3_55 + q3*(Js3_15 + Js2_34);
    const double bs2_4 = -(al3_5 + q3*al3_1);
    const double UH2_4 = 0.0003794202458643193*Js2_34;
    const double K2_44 = Js2_44 - Js2_34*UH2_4;
    const double Gb2 = Gamma2 - al3_1;
    const double al2_4 = UH2_4*Gb2 - bs2_4;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [28]-[32]. */
    const double Gamma1 = -40000000.0*q1;
    const double bs1_6 = q2*Gamma3 - al2_4;
    const double Hinv1 = 1.0/K2_44;
    const double Gb1 = Gamma1 + bs1_6;

    /* Forward recursion: accelerations and torques, joint 1 (bed_yaw) [33]-[36]. */
    const double vd1_x = 9.81*sin_q1;
    const double vd1_y = 9.81*cos_q1;
    const double qdd1 = Hinv1*Gb1;

    /* Forward recursion: accelerations and torques, joint 2 (bed_y) [33]-[36]. */
    const double vd2_y = g2_2 + vd1_x - q2*qdd1;
    const double qdd2a = -(g2_3 + vd1_y);
    const double qdd2 = -(Js2_34*qdd1 - (Gb2 + 2635.6*qdd2a))*0.0003794202458643193;
    const double vd2_z = qdd2 - qdd2a;

    /* Forward recursion: accelerations and torques, joint 3 (bed_x) [33]-[36]. */
    const double vd3_x = g3_1 + vd2_z + q3*qdd1;
    const double qdd3a = -(g3_3 + vd2_y);
    const double qdd3 = -(500.0*qdd1 - (Gb3 + 2500.0*qdd3a))*0.0004;
    const double vd3_z = qdd3 - qdd3a;

    /* Forward recursion: accelerations and torques, joint 4 (motor_secondary) [33]-[36]. */
    const double vd4_x = g4_1 + vd3_x + q4*qdd1;
    const double qdd4a = D4*qdd1 - vd3_z - g4_3;
    const double qdd4 = (Gb4 + 90.0*qdd4a)*0.011111111111111112;
    const double vd4_z = qdd4 - qdd4a;

    /* Forward recursion: accelerations and torques, joint 5 (motor_x) [33]-[36]. */
    const double vd5_x = g5_1 + vd4_x + q5*qdd1;
    const double qdd5a = -(g5_3 + vd4_z);
    const double qdd5 = (Gb5 + 45.0*qdd5a)*0.022222222222222223;
    const double vd5_z = qdd5 - qdd5a;

    /* Forward recursion: accelerations and torques, joint 6 (cart_yaw) [33]-[36]. */
    const double vd6_x = cos_q6*vd5_x - sin_q6*vd5_z;
    const double vd6_y = -(sin_q6*vd5_x + cos_q6*vd5_z);
    const double qdd6 = -Hinv6*(K7_44*qdd1 - Gb6);
    const double wd6_z = qdd1 + qdd6;

    /* Forward recursion: accelerations and torques, joint 7 (cart_x) [33]-[36]. */
    const double vd7_y = g7_2 - (vd6_x + q7*wd6_z);
    const double qdd7 = (Gb7 + (vd6_y - g7_3)*313.0 + Js7_16*wd6_z)*0.003194888178913738;

    /* Forward recursion: accelerations and torques, joint 8 (cart_y) [33]-[36]. */
    const double qdd8a = vd7_y - g8_3;
    const double qdd8 = -(4.2*wd6_z - (Gb8 + 210.0*qdd8a))*0.004761904761904762;
    const double vd8_z = qdd8 - qdd8a;

    /* Forward recursion: accelerations and torques, joint 9 (motor_y) [33]-[36]. */
    const double qdd9 = 0.005555555555555556*Gb9;
    const double vd9_z = g9_3 + vd8_z + qdd9;

    /* Forward recursion: accelerations and torques, joint 10 (y_chain_1) [33]-[36]. */
    const double qdd10a = -(g10_3 + vd9_z);
    const double qdd10 = (Gb10 + 8.0*qdd10a)*0.125;
    const double vd10_z = qdd10 - qdd10a;

    /* Forward recursion: accelerations and torques, joint 11 (ram) [33]-[36]. */
    const double qdd11 = -((g11_3 + vd10_z)*95.0 - Gb11)*0.010526315789473684;

    /* Forward recursion: accelerations and torques, joint 13 (sensor_head) [33]-[36]. */
    const double qdd13 = (Gamma13 + (D13*qdd1 - vd5_z - g13_3)*0.6)*1.6666666666666667;

    /* Results. */
    qdd[0] = qdd1;
    qdd[1] = qdd2;
    qdd[2] = qdd3;
    qdd[3] = qdd4;
    qdd[4] = qdd5;
    qdd[5] = qdd6;
    qdd[6] = qdd7;
    qdd[7] = qdd8;
    qdd[8] = qdd9;
    qdd[9] = qdd10;
    qdd[10] = qdd11;
    qdd[11] = qdd13;
}

void two_axis_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd)
{
    const double q1 = q[0];
    const double q2 = q[1];
    const double q3 = q[2];
    const double q4 = q[3];
    const double q5 = q[4];
    const double q6 = q[5];
    const double q7 = q[6];
    const double q8 = q[7];
    const double q9 = q[8];
    const double q10 = q[9];
    const double q11 = q[10];
    const double q13 = q[11];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double qd3 = qd[2];
    const double qd4 = qd[3];
    const double qd5 = qd[4];
    const double qd6 = qd[5];
    const double qd7 = qd[6];
    const double qd8 = qd[7];
    const double qd9 = qd[8];
    const double qd10 = qd[9];
    const double qd11 = qd[10];
    const double qd13 = qd[11];
    const double qdd5 = qdd_motor[0];
    const double qdd9 = qdd_motor[1];
    const double D4 = p[TWO_AXIS_P_D4];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Forward recursion: velocities, joint 1 (bed_yaw) [1], [3], [7], [14]. */
    const double sin_q1 = sin(q1);
    const double cos_q1 = cos(q1);
    const double ww1_zz = qd1*qd1;

    /* Forward recursion: velocities, joint 2 (bed_y) [1], [3], [7], [14]. */
    const double g2_3 = -q2*ww1_zz;
    const double g2_2 = -2.0*qd2*qd1;

    /* Forward recursion: velocities, joint 3 (bed_x) [1], [3], [7], [14]. */
    const double g3_3 = -q3*ww1_zz;
    const double g3_1 = 2.0*qd3*qd1;
    const double b3_1 = -500.0*ww1_zz;

    /* Forward recursion: velocities, joint 4 (motor_secondary) [1], [3], [7], [14]. */
    const double g4_3 = -q4*ww1_zz;
    const double g4_1 = 2.0*qd4*qd1 - D4*ww1_zz;

    /* Forward recursion: velocities, joint 5 (motor_x) [1], [3], [7], [14]. */
    const double g5_3 = -q5*ww1_zz;
    const double g5_1 = 2.0*qd5*qd1;

    /* Forward recursion: velocities, joint 6 (cart_yaw) [1], [3], [7], [14]. */
    const double sin_q6 = sin(q6);
    const double cos_q6 = cos(q6);
    const double w6_z = qd1 + qd6;
    const double ww6_zz = w6_z*w6_z;

    /* Forward recursion: velocities, joint 7 (cart_x) [1], [3], [7], [14]. */
    const double g7_3 = -q7*ww6_zz;
    const double g7_2 = -2.0*qd7*w6_z;

    /* Forward recursion: velocities, joint 8 (cart_y) [1], [3], [7], [14]. */
    const double g8_3 = -q8*ww6_zz;
    const double g8_1 = -2.0*qd8*w6_z;
    const double b8_1 = 4.2*ww6_zz;
    const double b8_3 = 63.0*ww6_zz;

    /* Forward recursion: velocities, joint 9 (motor_y) [1], [3], [7], [14]. */
    const double g9_3 = -q9*ww6_zz;
    const double g9_1 = -2.0*qd9*w6_z;

    /* Forward recursion: velocities, joint 10 (y_chain_1) [1], [3], [7], [14]. */
    const double g10_3 = -q10*ww6_zz;
    const double g10_1 = -2.0*qd10*w6_z;

    /* Forward recursion: velocities, joint 11 (ram) [1], [3], [7], [14]. */
    const double g11_3 = -q11*ww6_zz;
    const double g11_1 = -2.0*qd11*w6_z;
    const double b11_3 = -14.25*ww6_zz;

    /* Forward recursion: velocities, joint 13 (sensor_head) [1], [3], [7], [14]. */
    const double g13_3 = -q13*ww1_zz;
    const double g13_1 = 2.0*qd13*qd1 - D13*ww1_zz;

    /* Backward recursion: articulated inertias and wrenches, joint 13 (sensor_head) [50]-[56]. */
    const double Gamma13 = -25000000.0*q13;
    const double al13_1 = 0.6*g13_1;

    /* Backward recursion: articulated inertias and wrenches, joint 11 (ram) [50]-[56]. */
    const double Gamma11 = -250000000.0*q11;
    const double al11_1 = 95.0*g11_1;
    const double al11_5 = -14.25*g11_1;
    const double Gb11 = Gamma11 + b11_3;

    /* Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [50]-[56]. */
    const double Gamma10 = -120000000.0*q10;
    const double Js10_15a = 95.0*q11;
    const double Js10_15 = Js10_15a - 14.25;
    const double Js10_55 = q11*(Js10_15a - 28.5) + 9.2375;
    const double bs10_5 = -(al11_5 + q11*al11_1);
    const double Gb10 = Gamma10 - Gamma11;
    const double al10_1 = al11_1 + 103.0*g10_1;
    const double al10_5 = g10_1*Js10_15 - bs10_5;

    /* Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [50]-[56]. */
    const double Js9_15 = Js10_15 + 103.0*q10;
    const double Js9_55 = Js10_55 + q10*(Js10_15 + Js9_15);
    const double bs9_5 = -(al10_5 + q10*al10_1);
    const double al9_1 = al10_1 + 103.0*g9_1;
    const double al9_5 = g9_1*Js9_15 - bs9_5;

    /* Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [50]-[56]. */
    const double Gamma8 = -500000000.0*q8;
    const double Js8_15a = Js9_15 + 103.0*q9;
    const double Js8_15 = Js8_15a + 63.0;
    const double bs8_5 = -(al9_5 + q9*al9_1);
    const double bs8_1 = b8_1 - al9_1;
    const double bs8_3 = b8_3 - Gamma10;
    const double K8_55 = Js9_55 + q9*(Js9_15 + Js8_15a) + 34.9;
    const double Gb8 = Gamma8 + bs8_3;
    const double al8_1 = 313.0*g8_1 - bs8_1;
    const double al8_5 = -(bs8_5 + 0.02*Gb8 - g8_1*Js8_15);

    /* Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [50]-[56]. */
    const double Gamma7 = -350000000.0*q7;
    const double Js7_16 = Js8_15 + 313.0*q8;
    const double Js7_44 = K8_55 + q8*(Js8_15 + Js7_16);
    const double bs7_4 = al8_5 + q8*al8_1;
    const double UH7_4 = -0.003194888178913738*Js7_16;
    const double K7_44 = Js7_44 + Js7_16*UH7_4;
    const double Gb7 = Gamma7 - al8_1;
    const double al7_4 = UH7_4*Gb7 - bs7_4;

    /* Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [50]-[56]. */
    const double Gamma6 = -11000000.0*q6;
    const double bs6_6 = -(al7_4 + q7*Gamma8);
    const double Hinv6 = 1.0/K7_44;
    const double Gb6 = Gamma6 + bs6_6;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [50]-[56]. */
    const double Js5_15 = 0.6*q13;
    const double Js5_55 = q13*Js5_15 + 3.001;
    const double bs5_1 = -(al13_1 + cos_q6*Gamma8 + sin_q6*Gamma7);
    const double bs5_3 = -(Gamma13 + cos_q6*Gamma7 - sin_q6*Gamma8);
    const double bs5_5 = D13*Gamma13 - q13*al13_1 - Gamma6;
    const double al5_1 = 45.6*g5_1 - bs5_1;
    const double al5_3 = 45.0*g5_3 + 45.0*qdd5 - bs5_3;
    const double al5_5 = g5_1*Js5_15 - bs5_5;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [50]-[56]. */
    const double Gamma4 = -600000000.0*q4;
    const double Js4_15 = Js5_15 + 45.6*q5;
    const double Js4_55 = Js5_55 + q5*(Js5_15 + Js4_15) + 12.0;
    const double bs4_5 = -(al5_5 + q5*al5_1);
    const double Gb4 = Gamma4 - al5_3;
    const double al4_1 = al5_1 + 135.6*g4_1;
    const double al4_5 = g4_1*Js4_15 - bs4_5;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [50]-[56]. */
    const double Gamma3 = -100000000.0*q3;
    const double Js3_15 = Js4_15 + 135.6*q4;
    const double bs3_5 = D4*Gamma4 - (al4_5 + q4*al4_1);
    const double bs3_1 = b3_1 - al4_1;
    const double K3_55 = Js4_55 + q4*(Js4_15 + Js3_15) + 1100.0;
    const double Gb3 = Gamma3 - Gamma4;
    const double al3_1 = 2635.6*g3_1 - bs3_1;
    const double al3_5 = g3_1*Js3_15 + 0.2*Gb3 - bs3_5;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [50]-[56]. */
    const double Gamma2 = -150000000.0*q2;
    const double Js2_34 = Js3_15 + 2635.6*q3;
    const double Js2_44 = K3_55 + q3*(Js3_15 + Js2_34);
    const double bs2_4 = -(al3_5 + q3*al3_1);
    const double UH2_4 = 0.0003794202458643193*Js2_34;
    const double K2_44 = Js2_44 - Js2_34*UH2_4;
    const double Gb2 = Gamma2 - al3_1;
    const double al2_4 = UH2_4*Gb2 - bs2_4;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [50]-[56]. */
    const double Gamma1 = -40000000.0*q1;
    const double bs1_6 = q2*Gamma3 - al2_4;
    const double Hinv1 = 1.0/K2_44;
    const double Gb1 = Gamma1 + bs1_6;

    /* Forward recursion: accelerations and torques, joint 1 (bed_yaw) [57]-[61]. */
    const double vd1_x = 9.81*sin_q1;
    const double vd1_y = 9.81*cos_q1;
    const double qdd1 = Hinv1*Gb1;

    /* Forward recursion: accelerations and torques, joint 2 (bed_y) [57]-[61]. */
    const double vd2_y = g2_2 + vd1_x - q2*qdd1;
    const double qdd2a = -(g2_3 + vd1_y);
    const double qdd2 = -(Js2_34*qdd1 - (Gb2 + 2635.6*qdd2a))*0.0003794202458643193;
    const double vd2_z = qdd2 - qdd2a;

    /* Forward recursion: accelerations and torques, joint 3 (bed_x) [57]-[61]. */
    const double vd3_x = g3_1 + vd2_z + q3*qdd1;
    const double qdd3a = -(g3_3 + vd2_y);
    const double qdd3 = -(500.0*qdd1 - (Gb3 + 2500.0*qdd3a))*0.0004;
    const double vd3_z = qdd3 - qdd3a;

    /* Forward recursion: accelerations and torques, joint 4 (motor_secondary) [57]-[61]. */
    const double vd4_x = g4_1 + vd3_x + q4*qdd1;
    const double qdd4a = D4*qdd1 - vd3_z - g4_3;
    const double qdd4 = (Gb4 + 135.0*qdd4a)*0.007407407407407408;
    const double vd4_z = qdd4 - qdd4a;

    /* Forward recursion: accelerations and torques, joint 5 (motor_x) [57]-[61]. */
    const double f5_3 = al5_3 + 45.0*vd4_z;
    const double vd5_x = g5_1 + vd4_x + q5*qdd1;
    const double vd5_z = qdd5 + g5_3 + vd4_z;

    /* Forward recursion: accelerations and torques, joint 6 (cart_yaw) [57]-[61]. */
    const double vd6_x = cos_q6*vd5_x - sin_q6*vd5_z;
    const double vd6_y = -(sin_q6*vd5_x + cos_q6*vd5_z);
    const double qdd6 = -Hinv6*(K7_44*qdd1 - Gb6);
    const double wd6_z = qdd1 + qdd6;

    /* Forward recursion: accelerations and torques, joint 7 (cart_x) [57]-[61]. */
    const double vd7_y = g7_2 - (vd6_x + q7*wd6_z);
    const double qdd7 = (Gb7 + (vd6_y - g7_3)*313.0 + Js7_16*wd6_z)*0.003194888178913738;

    /* Forward recursion: accelerations and torques, joint 8 (cart_y) [57]-[61]. */
    const double qdd8a = vd7_y - g8_3;
    const double qdd8 = -(4.2*wd6_z - (Gb8 + 210.0*qdd8a))*0.004761904761904762;
    const double vd8_z = qdd8 - qdd8a;

    /* Forward recursion: accelerations and torques, joint 9 (motor_y) [57]-[61]. */
    const double vd9_z = qdd9 + g9_3 + vd8_z;
    const double Gamma9 = Gamma10 + 180.0*qdd9;

    /* Forward recursion: accelerations and torques, joint 10 (y_chain_1) [57]-[61]. */
    const double qdd10a = -(g10_3 + vd9_z);
    const double qdd10 = (Gb10 + 8.0*qdd10a)*0.125;
    const double vd10_z = qdd10 - qdd10a;

    /* Forward recursion: accelerations and torques, joint 11 (ram) [57]-[61]. */
    const double qdd11 = -((g11_3 + vd10_z)*95.0 - Gb11)*0.010526315789473684;

    /* Forward recursion: accelerations and torques, joint 13 (sensor_head) [57]-[61]. */
    const double qdd13 = -((g13_3 + vd5_z - D13*qdd1)*0.6 - Gamma13)*1.6666666666666667;

    /* Results. */
    tau[0] = f5_3;
    tau[1] = Gamma9;
    qdd[0] = qdd1;
    qdd[1] = qdd2;
    qdd[2] = qdd3;
    qdd[3] = qdd4;
    qdd[4] = qdd5;
    qdd[5] = qdd6;
    qdd[6] = qdd7;
    qdd[7] = qdd8;
    qdd[8] = qdd9;
    qdd[9] = qdd10;
    qdd[10] = qdd11;
    qdd[11] = qdd13;
}

void two_axis_inertia_matrix_prepare(const double *p, double *c)
{
    const double D4 = p[TWO_AXIS_P_D4];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Composite inertias and inertia matrix, joint 13 (sensor_head) [8], [13]. */
    const double A1_13a = 0.6*D13;
    const double A1_13b = A1_13a + 0.6*D4;

    /* Composite inertias and inertia matrix, joint 5 (motor_x) [8], [13]. */
    const double J5_cyyb = D13*A1_13a;
    const double A1_5a = 358.6*D4;

    /* Composite inertias and inertia matrix, joint 4 (motor_secondary) [8], [13]. */
    const double A1_4a = 448.6*D4;

    c[0] = A1_13a;
    c[1] = A1_13b;
    c[2] = J5_cyyb;
    c[3] = A1_5a;
    c[4] = A1_4a;
}

void two_axis_inertia_matrix_prepared(const double *q, const double *p, const double *c, double *A)
{
    const double q2 = q[1];
    const double q3 = q[2];
    const double q4 = q[3];
    const double q5 = q[4];
    const double q6 = q[5];
    const double q7 = q[6];
    const double q8 = q[7];
    const double q9 = q[8];
    const double q10 = q[9];
    const double q11 = q[10];
    const double q13 = q[11];
    const double D4 = p[TWO_AXIS_P_D4];
    const double A1_13a = c[0];
    const double A1_13b = c[1];
    const double J5_cyyb = c[2];
    const double A1_5a = c[3];
    const double A1_4a = c[4];

    /* Geometry, joint 6 (cart_yaw) [1]. */
    const double sin_q6 = sin(q6);
    const double cos_q6 = cos(q6);

    /* Composite inertias and inertia matrix, joint 13 (sensor_head) [8], [13]. */
    const double A1_13 = -(A1_13b + 0.6*q2);

    /* Composite inertias and inertia matrix, joint 11 (ram) [8], [13]. */
    const double A6_11 = 95.0*q7;
    const double A2_11 = 95.0*cos_q6;
    const double A3_11 = -95.0*sin_q6;
    const double A1_11 = A6_11 + q5*A2_11 + q4*A2_11 - D4*A3_11 + q3*A2_11 - q2*A3_11;

    /* Composite inertias and inertia matrix, joint 10 (y_chain_1) [8], [13]. */
    const double MS10_c_za = 95.0*q11;
    const double MS10_c_z = MS10_c_za - 14.25;
    const double J10_cyy = q11*(MS10_c_za - 28.5) + 9.2375;
    const double A6_10 = 103.0*q7;
    const double A2_10 = 103.0*cos_q6;
    const double A3_10 = -103.0*sin_q6;
    const double A1_10 = A6_10 + q5*A2_10 + q4*A2_10 - D4*A3_10 + q3*A2_10 - q2*A3_10;

    /* Composite inertias and inertia matrix, joint 9 (motor_y) [8], [13]. */
    const double MS9_c_z = MS10_c_z + 103.0*q10;
    const double J9_cyy = J10_cyy + q10*(MS10_c_z + MS9_c_z);

    /* Composite inertias and inertia matrix, joint 8 (cart_y) [8], [13]. */
    const double J8_cyya = MS9_c_z + 103.0*q9;
    const double J8_cyy = J9_cyy + q9*(MS9_c_z + J8_cyya) + 34.984;
    const double MS8_c_z = J8_cyya + 63.0;
    const double A6_8a = 313.0*q7;
    const double A6_8 = A6_8a + 4.2;
    const double A2_8 = 313.0*cos_q6;
    const double A3_8 = -313.0*sin_q6;
    const double A1_8 = A6_8 + q5*A2_8 + q4*A2_8 - D4*A3_8 + q3*A2_8 - q2*A3_8;

    /* Composite inertias and inertia matrix, joint 7 (cart_x) [8], [13]. */
    const double MS7_c_y = -(MS8_c_z + 313.0*q8);
    const double J7_cxx = J8_cyy + q8*(MS8_c_z - MS7_c_y);
    const double A1_7 = -(q5*A3_8 - MS7_c_y + q4*A3_8 + D4*A2_8 + q3*A3_8 + q2*A2_8);

    /* Composite inertias and inertia matrix, joint 6 (cart_yaw) [8], [13]. */
    const double J6_czz = J7_cxx + q7*(A6_8a + 8.4);
    const double A3_6 = cos_q6*MS7_c_y - sin_q6*A6_8;
    const double A2_6 = sin_q6*MS7_c_y + cos_q6*A6_8;
    const double A1_6 = J6_czz + q5*A2_6 + q4*A2_6 - D4*A3_6 + q3*A2_6 - q2*A3_6;

    /* Composite inertias and inertia matrix, joint 5 (motor_x) [8], [13]. */
    const double J5_cyya = 0.6*q13;
    const double J5_cyy = q13*J5_cyya + 0.001 + J5_cyyb + 3.0 + J6_czz;
    const double MS5_c_x = A1_13a - A3_6;
    const double MS5_c_z = J5_cyya + A2_6;
    const double A1_5 = -(MS5_c_x + A1_5a + 358.6*q2);

    /* Composite inertias and inertia matrix, joint 4 (motor_secondary) [8], [13]. */
    const double MS4_c_z = MS5_c_z + 358.6*q5;
    const double J4_cyy = J5_cyy + q5*(MS5_c_z + MS4_c_z) + 12.0;
    const double A1_4b = MS5_c_x + A1_4a;
    const double A1_4 = -(A1_4b + 448.6*q2);

    /* Composite inertias and inertia matrix, joint 3 (bed_x) [8], [13]. */
    const double MS3_c_z = MS4_c_z + 448.6*q4;
    const double J3_cyy = J4_cyy + q4*(MS4_c_z + MS3_c_z) + D4*(MS5_c_x + A1_4b) + 1200.0;
    const double MS3_c_x = A1_4b - 500.0;
    const double A1_3 = -(MS3_c_x + 2948.6*q2);

    /* Composite inertias and inertia matrix, joint 2 (bed_y) [8], [13]. */
    const double MS2_c_y = MS3_c_z + 2948.6*q3;
    const double J2_cxx = J3_cyy + q3*(MS3_c_z + MS2_c_y);

    /* Composite inertias and inertia matrix, joint 1 (bed_yaw) [8], [13]. */
    const double J1_czz = J2_cxx + q2*(MS3_c_x - A1_3);

    /* Results. */
    A[0] = J1_czz;
    A[1] = MS2_c_y;
    A[2] = A1_3;
    A[3] = A1_4;
    A[4] = A1_5;
    A[5] = A1_6;
    A[6] = A1_7;
    A[7] = A1_8;
    A[8] = A1_10;
    A[9] = A1_10;
    A[10] = A1_11;
    A[11] = A1_13;
    A[12] = MS2_c_y;
    A[13] = 2948.6;
    A[14] = 0.0;
    A[15] = 0.0;
    A[16] = 0.0;
    A[17] = A2_6;
    A[18] = -A3_8;
    A[19] = A2_8;
    A[20] = A2_10;
    A[21] = A2_10;
    A[22] = A2_11;
    A[23] = 0.0;
    A[24] = A1_3;
    A[25] = 0.0;
    A[26] = 2948.6;
    A[27] = 448.6;
    A[28] = 358.6;
    A[29] = A3_6;
    A[30] = A2_8;
    A[31] = A3_8;
    A[32] = A3_10;
    A[33] = A3_10;
    A[34] = A3_11;
    A[35] = 0.6;
    A[36] = A1_4;
    A[37] = 0.0;
    A[38] = 448.6;
    A[39] = 448.6;
    A[40] = 358.6;
    A[41] = A3_6;
    A[42] = A2_8;
    A[43] = A3_8;
    A[44] = A3_10;
    A[45] = A3_10;
    A[46] = A3_11;
    A[47] = 0.6;
    A[48] = A1_5;
    A[49] = 0.0;
    A[50] = 358.6;
    A[51] = 358.6;
    A[52] = 358.6;
    A[53] = A3_6;
    A[54] = A2_8;
    A[55] = A3_8;
    A[56] = A3_10;
    A[57] = A3_10;
    A[58] = A3_11;
    A[59] = 0.6;
    A[60] = A1_6;
    A[61] = A2_6;
    A[62] = A3_6;
    A[63] = A3_6;
    A[64] = A3_6;
    A[65] = J6_czz;
    A[66] = MS7_c_y;
    A[67] = A6_8;
    A[68] = A6_10;
    A[69] = A6_10;
    A[70] = A6_11;
    A[71] = 0.0;
    A[72] = A1_7;
    A[73] = -A3_8;
    A[74] = A2_8;
    A[75] = A2_8;
    A[76] = A2_8;
    A[77] = MS7_c_y;
    A[78] = 313.0;
    A[79] = 0.0;
    A[80] = 0.0;
    A[81] = 0.0;
    A[82] = 0.0;
    A[83] = 0.0;
    A[84] = A1_8;
    A[85] = A2_8;
    A[86] = A3_8;
    A[87] = A3_8;
    A[88] = A3_8;
    A[89] = A6_8;
    A[90] = 0.0;
    A[91] = 313.0;
    A[92] = 103.0;
    A[93] = 103.0;
    A[94] = 95.0;
    A[95] = 0.0;
    A[96] = A1_10;
    A[97] = A2_10;
    A[98] = A3_10;
    A[99] = A3_10;
    A[100] = A3_10;
    A[101] = A6_10;
    A[102] = 0.0;
    A[103] = 103.0;
    A[104] = 283.0;
    A[105] = 103.0;
    A[106] = 95.0;
    A[107] = 0.0;
    A[108] = A1_10;
    A[109] = A2_10;
    A[110] = A3_10;
    A[111] = A3_10;
    A[112] = A3_10;
    A[113] = A6_10;
    A[114] = 0.0;
    A[115] = 103.0;
    A[116] = 103.0;
    A[117] = 103.0;
    A[118] = 95.0;
    A[119] = 0.0;
    A[120] = A1_11;
    A[121] = A2_11;
    A[122] = A3_11;
    A[123] = A3_11;
    A[124] = A3_11;
    A[125] = A6_11;
    A[126] = 0.0;
    A[127] = 95.0;
    A[128] = 95.0;
    A[129] = 95.0;
    A[130] = 95.0;
    A[131] = 0.0;
    A[132] = A1_13;
    A[133] = 0.0;
    A[134] = 0.6;
    A[135] = 0.6;
    A[136] = 0.6;
    A[137] = 0.0;
    A[138] = 0.0;
    A[139] = 0.0;
    A[140] = 0.0;
    A[141] = 0.0;
    A[142] = 0.0;
    A[143] = 0.6;
}

void two_axis_inertia_matrix(const double *q, const double *p, double *A)
{
    double c[TWO_AXIS_INERTIA_MATRIX_CONSTANTS];
    two_axis_inertia_matrix_prepare(p, c);
    two_axis_inertia_matrix_prepared(q, p, c, A);
}

void two_axis_bias_forces(const double *q, const double *qd, const double *p, double *H)
{
    const double q1 = q[0];
    const double q2 = q[1];
    const double q3 = q[2];
    const double q4 = q[3];
    const double q5 = q[4];
    const double q6 = q[5];
    const double q7 = q[6];
    const double q8 = q[7];
    const double q9 = q[8];
    const double q10 = q[9];
    const double q11 = q[10];
    const double q13 = q[11];
    const double qd1 = qd[0];
    const double qd2 = qd[1];
    const double qd3 = qd[2];
    const double qd4 = qd[3];
    const double qd5 = qd[4];
    const double qd6 = qd[5];
    const double qd7 = qd[6];
    const double qd8 = qd[7];
    const double qd9 = qd[8];
    const double qd10 = qd[9];
    const double qd11 = qd[10];
    const double qd13 = qd[11];
    const double D4 = p[TWO_AXIS_P_D4];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Forward recursion: velocities, joint 1 (bed_yaw) [1], [3], [7], [14]. */
    const double sin_q1 = sin(q1);
    const double cos_q1 = cos(q1);
    const double ww1_zz = qd1*qd1;
    const double vd1_x = 9.81*sin_q1;
    const double vd1_y = 9.81*cos_q1;

    /* Forward recursion: velocities, joint 2 (bed_y) [1], [3], [7], [14]. */
    const double vd2_z = vd1_y - q2*ww1_zz;
    const double vd2_y = vd1_x - 2.0*qd2*qd1;

    /* Forward recursion: velocities, joint 3 (bed_x) [1], [3], [7], [14]. */
    const double vd3_z = vd2_y - q3*ww1_zz;
    const double vd3_x = 2.0*qd3*qd1 + vd2_z;

    /* Forward recursion: velocities, joint 4 (motor_secondary) [1], [3], [7], [14]. */
    const double vd4_z = vd3_z - q4*ww1_zz;
    const double vd4_x = 2.0*qd4*qd1 - (D4*ww1_zz - vd3_x);

    /* Forward recursion: velocities, joint 5 (motor_x) [1], [3], [7], [14]. */
    const double vd5_z = vd4_z - q5*ww1_zz;
    const double vd5_x = 2.0*qd5*qd1 + vd4_x;

    /* Forward recursion: velocities, joint 6 (cart_yaw) [1], [3], [7], [14]. */
    const double sin_q6 = sin(q6);
    const double cos_q6 = cos(q6);
    const double w6_z = qd1 + qd6;
    const double ww6_zz = w6_z*w6_z;
    const double vd6_x = cos_q6*vd5_x - sin_q6*vd5_z;
    const double vd6_y = -(sin_q6*vd5_x + cos_q6*vd5_z);

    /* Forward recursion: velocities, joint 7 (cart_x) [1], [3], [7], [14]. */
    const double vd7_z = -(q7*ww6_zz + vd6_y);
    const double vd7_y = -(2.0*qd7*w6_z + vd6_x);

    /* Forward recursion: velocities, joint 8 (cart_y) [1], [3], [7], [14]. */
    const double vd8_z = -(q8*ww6_zz + vd7_y);
    const double vd8_x = vd7_z - 2.0*qd8*w6_z;

    /* Forward recursion: velocities, joint 9 (motor_y) [1], [3], [7], [14]. */
    const double vd9_z = vd8_z - q9*ww6_zz;
    const double vd9_x = vd8_x - 2.0*qd9*w6_z;

    /* Forward recursion: velocities, joint 10 (y_chain_1) [1], [3], [7], [14]. */
    const double vd10_z = vd9_z - q10*ww6_zz;
    const double vd10_x = vd9_x - 2.0*qd10*w6_z;

    /* Forward recursion: velocities, joint 11 (ram) [1], [3], [7], [14]. */
    const double vd11_z = vd10_z - q11*ww6_zz;
    const double vd11_x = vd10_x - 2.0*qd11*w6_z;

    /* Forward recursion: velocities, joint 13 (sensor_head) [1], [3], [7], [14]. */
    const double vd13_z = vd5_z - q13*ww1_zz;
    const double vd13_x = 2.0*qd13*qd1 - (D13*ww1_zz - vd5_x);

    /* Backward recursion: articulated inertias and wrenches, joint 13 (sensor_head) [15]. */
    const double f13_1 = 0.6*vd13_x;
    const double f13_3 = 0.6*vd13_z;

    /* Backward recursion: articulated inertias and wrenches, joint 11 (ram) [15]. */
    const double f11_1 = 95.0*vd11_x;
    const double f11_3 = 95.0*vd11_z + 14.25*ww6_zz;
    const double f11_5 = -14.25*vd11_x;

    /* Backward recursion: articulated inertias and wrenches, joint 10 (y_chain_1) [15]. */
    const double f10_5 = f11_5 + q11*f11_1;
    const double f10_1 = 8.0*vd10_x + f11_1;
    const double f10_3 = 8.0*vd10_z + f11_3;

    /* Backward recursion: articulated inertias and wrenches, joint 9 (motor_y) [15]. */
    const double f9_5 = f10_5 + q10*f10_1;

    /* Backward recursion: articulated inertias and wrenches, joint 8 (cart_y) [15]. */
    const double f8_1 = f10_1 - (4.2*ww6_zz - 210.0*vd8_x);
    const double f8_3 = f10_3 - (63.0*ww6_zz - 210.0*vd8_z);
    const double f8_5 = f9_5 + q9*f10_1 - (4.2*vd8_z - 63.0*vd8_x);

    /* Backward recursion: articulated inertias and wrenches, joint 7 (cart_x) [15]. */
    const double f7_4 = -(f8_5 + q8*f8_1);

    /* Backward recursion: articulated inertias and wrenches, joint 6 (cart_yaw) [15]. */
    const double f6_6 = f7_4 + q7*f8_3;

    /* Backward recursion: articulated inertias and wrenches, joint 5 (motor_x) [15]. */
    const double f5_1 = 45.0*vd5_x + f13_1 + cos_q6*f8_3 + sin_q6*f8_1;
    const double f5_3 = 45.0*vd5_z + f13_3 + cos_q6*f8_1 - sin_q6*f8_3;
    const double f5_5 = q13*f13_1 - D13*f13_3 + f6_6;

    /* Backward recursion: articulated inertias and wrenches, joint 4 (motor_secondary) [15]. */
    const double f4_5 = f5_5 + q5*f5_1;
    const double f4_1 = 90.0*vd4_x + f5_1;
    const double f4_3 = 90.0*vd4_z + f5_3;

    /* Backward recursion: articulated inertias and wrenches, joint 3 (bed_x) [15]. */
    const double f3_1 = 2500.0*vd3_x + 500.0*ww1_zz + f4_1;
    const double f3_3 = 2500.0*vd3_z + f4_3;
    const double f3_5 = 500.0*vd3_z + f4_5 + q4*f4_1 - D4*f4_3;

    /* Backward recursion: articulated inertias and wrenches, joint 2 (bed_y) [15]. */
    const double f2_4 = f3_5 + q3*f3_1;

    /* Backward recursion: articulated inertias and wrenches, joint 1 (bed_yaw) [15]. */
    const double f1_6 = f2_4 - q2*f3_3;

    /* Results. */
    H[0] = f1_6;
    H[1] = f3_1;
    H[2] = f3_3;
    H[3] = f4_3;
    H[4] = f5_3;
    H[5] = f6_6;
    H[6] = f8_1;
    H[7] = f8_3;
    H[8] = f10_3;
    H[9] = f10_3;
    H[10] = f11_3;
    H[11] = f13_3;
}

void two_axis_geometric_model(const double *q, const double *p, double *T)
{
    const double q1 = q[0];
    const double q2 = q[1];
    const double q3 = q[2];
    const double q4 = q[3];
    const double q5 = q[4];
    const double q6 = q[5];
    const double q7 = q[6];
    const double q8 = q[7];
    const double q9 = q[8];
    const double q10 = q[9];
    const double q11 = q[10];
    const double q13 = q[11];
    const double D4 = p[TWO_AXIS_P_D4];
    const double D12 = p[TWO_AXIS_P_D12];
    const double L12 = p[TWO_AXIS_P_L12];
    const double D13 = p[TWO_AXIS_P_D13];

    /* Geometry, joint 1 (bed_yaw) [1], [2]. */
    const double sin_q1 = sin(q1);
    const double cos_q1 = cos(q1);

    /* Geometry, joint 2 (bed_y) [1], [2]. */
    const double P2_x = -q2*sin_q1;
    const double P2_y = q2*cos_q1;

    /* Geometry, joint 3 (bed_x) [1], [2]. */
    const double P3_x = P2_x + q3*cos_q1;
    const double P3_y = P2_y + q3*sin_q1;

    /* Geometry, joint 4 (motor_secondary) [1], [2]. */
    const double P4_x = q4*cos_q1 - (D4*sin_q1 - P3_x);
    const double P4_y = P3_y + D4*cos_q1 + q4*sin_q1;

    /* Geometry, joint 5 (motor_x) [1], [2]. */
    const double P5_x = P4_x + q5*cos_q1;
    const double P5_y = P4_y + q5*sin_q1;

    /* Geometry, joint 6 (cart_yaw) [1], [2]. */
    const double sin_q6 = sin(q6);
    const double cos_q6 = cos(q6);
    const double A6_11 = -(sin_q1*cos_q6 + cos_q1*sin_q6);
    const double A6_12 = sin_q1*sin_q6 - cos_q1*cos_q6;

    /* Geometry, joint 7 (cart_x) [1], [2]. */
    const double P7_x = P5_x - q7*A6_12;
    const double P7_y = P5_y - q7*A6_11;

    /* Geometry, joint 8 (cart_y) [1], [2]. */
    const double P8_x = P7_x + q8*A6_11;
    const double P8_y = P7_y - q8*A6_12;

    /* Geometry, joint 9 (motor_y) [1], [2]. */
    const double P9_x = P8_x + q9*A6_11;
    const double P9_y = P8_y - q9*A6_12;

    /* Geometry, joint 10 (y_chain_1) [1], [2]. */
    const double P10_x = P9_x + q10*A6_11;
    const double P10_y = P9_y - q10*A6_12;

    /* Geometry, joint 11 (ram) [1], [2]. */
    const double P11_x = P10_x + q11*A6_11;
    const double P11_y = P10_y - q11*A6_12;

    /* Geometry, joint 12 (tool) [1], [2]. */
    const double P12_x = L12*A6_11 - (D12*A6_12 - P11_x);
    const double P12_y = P11_y - D12*A6_11 - L12*A6_12;

    /* Geometry, joint 13 (sensor_head) [1], [2]. */
    const double P13_x = q13*cos_q1 - (D13*sin_q1 - P5_x);
    const double P13_y = P5_y + D13*cos_q1 + q13*sin_q1;

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
    T[16] = 0.0;
    T[17] = cos_q1;
    T[18] = -sin_q1;
    T[19] = P2_x;
    T[20] = 0.0;
    T[21] = sin_q1;
    T[22] = cos_q1;
    T[23] = P2_y;
    T[24] = 1.0;
    T[25] = 0.0;
    T[26] = 0.0;
    T[27] = 0.0;
    T[28] = 0.0;
    T[29] = 0.0;
    T[30] = 0.0;
    T[31] = 1.0;
    T[32] = -sin_q1;
    T[33] = 0.0;
    T[34] = cos_q1;
    T[35] = P3_x;
    T[36] = cos_q1;
    T[37] = 0.0;
    T[38] = sin_q1;
    T[39] = P3_y;
    T[40] = 0.0;
    T[41] = 1.0;
    T[42] = 0.0;
    T[43] = 0.0;
    T[44] = 0.0;
    T[45] = 0.0;
    T[46] = 0.0;
    T[47] = 1.0;
    T[48] = -sin_q1;
    T[49] = 0.0;
    T[50] = cos_q1;
    T[51] = P4_x;
    T[52] = cos_q1;
    T[53] = 0.0;
    T[54] = sin_q1;
    T[55] = P4_y;
    T[56] = 0.0;
    T[57] = 1.0;
    T[58] = 0.0;
    T[59] = 0.0;
    T[60] = 0.0;
    T[61] = 0.0;
    T[62] = 0.0;
    T[63] = 1.0;
    T[64] = -sin_q1;
    T[65] = 0.0;
    T[66] = cos_q1;
    T[67] = P5_x;
    T[68] = cos_q1;
    T[69] = 0.0;
    T[70] = sin_q1;
    T[71] = P5_y;
    T[72] = 0.0;
    T[73] = 1.0;
    T[74] = 0.0;
    T[75] = 0.0;
    T[76] = 0.0;
    T[77] = 0.0;
    T[78] = 0.0;
    T[79] = 1.0;
    T[80] = A6_11;
    T[81] = A6_12;
    T[82] = 0.0;
    T[83] = P5_x;
    T[84] = -A6_12;
    T[85] = A6_11;
    T[86] = 0.0;
    T[87] = P5_y;
    T[88] = 0.0;
    T[89] = 0.0;
    T[90] = 1.0;
    T[91] = 0.0;
    T[92] = 0.0;
    T[93] = 0.0;
    T[94] = 0.0;
    T[95] = 1.0;
    T[96] = 0.0;
    T[97] = -A6_11;
    T[98] = -A6_12;
    T[99] = P7_x;
    T[100] = 0.0;
    T[101] = A6_12;
    T[102] = -A6_11;
    T[103] = P7_y;
    T[104] = 1.0;
    T[105] = 0.0;
    T[106] = 0.0;
    T[107] = 0.0;
    T[108] = 0.0;
    T[109] = 0.0;
    T[110] = 0.0;
    T[111] = 1.0;
    T[112] = -A6_12;
    T[113] = 0.0;
    T[114] = A6_11;
    T[115] = P8_x;
    T[116] = -A6_11;
    T[117] = 0.0;
    T[118] = -A6_12;
    T[119] = P8_y;
    T[120] = 0.0;
    T[121] = -1.0;
    T[122] = 0.0;
    T[123] = 0.0;
    T[124] = 0.0;
    T[125] = 0.0;
    T[126] = 0.0;
    T[127] = 1.0;
    T[128] = -A6_12;
    T[129] = 0.0;
    T[130] = A6_11;
    T[131] = P9_x;
    T[132] = -A6_11;
    T[133] = 0.0;
    T[134] = -A6_12;
    T[135] = P9_y;
    T[136] = 0.0;
    T[137] = -1.0;
    T[138] = 0.0;
    T[139] = 0.0;
    T[140] = 0.0;
    T[141] = 0.0;
    T[142] = 0.0;
    T[143] = 1.0;
    T[144] = -A6_12;
    T[145] = 0.0;
    T[146] = A6_11;
    T[147] = P10_x;
    T[148] = -A6_11;
    T[149] = 0.0;
    T[150] = -A6_12;
    T[151] = P10_y;
    T[152] = 0.0;
    T[153] = -1.0;
    T[154] = 0.0;
    T[155] = 0.0;
    T[156] = 0.0;
    T[157] = 0.0;
    T[158] = 0.0;
    T[159] = 1.0;
    T[160] = -A6_12;
    T[161] = 0.0;
    T[162] = A6_11;
    T[163] = P11_x;
    T[164] = -A6_11;
    T[165] = 0.0;
    T[166] = -A6_12;
    T[167] = P11_y;
    T[168] = 0.0;
    T[169] = -1.0;
    T[170] = 0.0;
    T[171] = 0.0;
    T[172] = 0.0;
    T[173] = 0.0;
    T[174] = 0.0;
    T[175] = 1.0;
    T[176] = -A6_12;
    T[177] = 0.0;
    T[178] = A6_11;
    T[179] = P12_x;
    T[180] = -A6_11;
    T[181] = 0.0;
    T[182] = -A6_12;
    T[183] = P12_y;
    T[184] = 0.0;
    T[185] = -1.0;
    T[186] = 0.0;
    T[187] = 0.0;
    T[188] = 0.0;
    T[189] = 0.0;
    T[190] = 0.0;
    T[191] = 1.0;
    T[192] = -sin_q1;
    T[193] = 0.0;
    T[194] = cos_q1;
    T[195] = P13_x;
    T[196] = cos_q1;
    T[197] = 0.0;
    T[198] = sin_q1;
    T[199] = P13_y;
    T[200] = 0.0;
    T[201] = 1.0;
    T[202] = 0.0;
    T[203] = 0.0;
    T[204] = 0.0;
    T[205] = 0.0;
    T[206] = 0.0;
    T[207] = 1.0;
}
