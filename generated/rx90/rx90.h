/* rx90: generated models.
 *
 * SI units, radians. q, qd, qdd follow the joints in table order, tau and qdd_motor the motors.
 * Matrices are stored row by row. Functions called ..._batch compute many states, all with the same p:
 * entry k of state s is at [k*states + s]. No function allocates, keeps state or changes its inputs;
 * inputs and outputs must not overlap. NaN in the inputs a result depends on gives NaN.
 *
 *   q[0]  j1, motor, th1, rad
 *   q[1]  j2, motor, th2, rad
 *   q[2]  j3, motor, th3, rad
 *   q[3]  j4, motor, th4, rad
 *   q[4]  j5, motor, th5, rad
 *   q[5]  j6, motor, th6, rad
 */
#ifndef RX90_H
#define RX90_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define RX90_JOINTS 6
#define RX90_MOTORS 6
#define RX90_FRAMES 6
#define RX90_PARAMETERS 69

/* Indices into p. */
enum {
    RX90_P_XX1,
    RX90_P_XY1,
    RX90_P_XZ1,
    RX90_P_YY1,
    RX90_P_YZ1,
    RX90_P_ZZ1,
    RX90_P_MX1,
    RX90_P_MY1,
    RX90_P_MZ1,
    RX90_P_M1,
    RX90_P_IA1,
    RX90_P_XX2,
    RX90_P_XY2,
    RX90_P_XZ2,
    RX90_P_YY2,
    RX90_P_YZ2,
    RX90_P_ZZ2,
    RX90_P_MX2,
    RX90_P_MY2,
    RX90_P_MZ2,
    RX90_P_M2,
    RX90_P_IA2,
    RX90_P_D3,
    RX90_P_XX3,
    RX90_P_XY3,
    RX90_P_XZ3,
    RX90_P_YY3,
    RX90_P_YZ3,
    RX90_P_ZZ3,
    RX90_P_MX3,
    RX90_P_MY3,
    RX90_P_MZ3,
    RX90_P_M3,
    RX90_P_IA3,
    RX90_P_RL4,
    RX90_P_XX4,
    RX90_P_XY4,
    RX90_P_XZ4,
    RX90_P_YY4,
    RX90_P_YZ4,
    RX90_P_ZZ4,
    RX90_P_MX4,
    RX90_P_MY4,
    RX90_P_MZ4,
    RX90_P_M4,
    RX90_P_IA4,
    RX90_P_XX5,
    RX90_P_XY5,
    RX90_P_XZ5,
    RX90_P_YY5,
    RX90_P_YZ5,
    RX90_P_ZZ5,
    RX90_P_MX5,
    RX90_P_MY5,
    RX90_P_MZ5,
    RX90_P_M5,
    RX90_P_IA5,
    RX90_P_XX6,
    RX90_P_XY6,
    RX90_P_XZ6,
    RX90_P_YY6,
    RX90_P_YZ6,
    RX90_P_ZZ6,
    RX90_P_MX6,
    RX90_P_MY6,
    RX90_P_MZ6,
    RX90_P_M6,
    RX90_P_IA6,
    RX90_P_G3
};

/* Default values of p; NAN where the machine gives none. */
extern const double rx90_defaults[RX90_PARAMETERS];

/* Direct dynamic model [12]-[36].
 * 586x 496+, 10 sin/cos a call; 5x 4+, 0 sin/cos once for each parameter set.
 *   q (6): joint variables, rad or m
 *   qd (6): joint velocities, rad/s or m/s
 *   tau (6): motor torques or forces, N m or N
 *   -> qdd (6): joint accelerations, rad/s2 or m/s2
 *   accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
 */
void rx90_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd);
void rx90_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd);

/* The same in two steps: work that depends on p only, once for each parameter set, then the rest. */
#define RX90_DIRECT_DYNAMICS_CONSTANTS 7
void rx90_direct_dynamics_prepare(const double *p, double *c);
void rx90_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd);

/* Inverse dynamic model: motor torques and elastic accelerations [37]-[61].
 * 280x 264+, 10 sin/cos a call; 0x 15+, 0 sin/cos once for each parameter set.
 *   q (6): joint variables, rad or m
 *   qd (6): joint velocities, rad/s or m/s
 *   qdd_motor (6): motor accelerations, rad/s2 or m/s2
 *   -> tau (6): motor torques or forces, N m or N
 *   -> qdd (6): joint accelerations, rad/s2 or m/s2
 */
void rx90_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd);
void rx90_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd);

/* The same in two steps: work that depends on p only, once for each parameter set, then the rest. */
#define RX90_INVERSE_DYNAMICS_CONSTANTS 15
void rx90_inverse_dynamics_prepare(const double *p, double *c);
void rx90_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd);

#ifdef __cplusplus
}
#endif

#endif
