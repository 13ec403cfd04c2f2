/* puma560: generated models.
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
#ifndef PUMA560_H
#define PUMA560_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PUMA560_JOINTS 6
#define PUMA560_MOTORS 6
#define PUMA560_FRAMES 6
#define PUMA560_PARAMETERS 72

/* Indices into p. */
enum {
    PUMA560_P_XX1,
    PUMA560_P_XY1,
    PUMA560_P_XZ1,
    PUMA560_P_YY1,
    PUMA560_P_YZ1,
    PUMA560_P_ZZ1,
    PUMA560_P_MX1,
    PUMA560_P_MY1,
    PUMA560_P_MZ1,
    PUMA560_P_M1,
    PUMA560_P_IA1,
    PUMA560_P_R2,
    PUMA560_P_XX2,
    PUMA560_P_XY2,
    PUMA560_P_XZ2,
    PUMA560_P_YY2,
    PUMA560_P_YZ2,
    PUMA560_P_ZZ2,
    PUMA560_P_MX2,
    PUMA560_P_MY2,
    PUMA560_P_MZ2,
    PUMA560_P_M2,
    PUMA560_P_IA2,
    PUMA560_P_D3,
    PUMA560_P_R3,
    PUMA560_P_XX3,
    PUMA560_P_XY3,
    PUMA560_P_XZ3,
    PUMA560_P_YY3,
    PUMA560_P_YZ3,
    PUMA560_P_ZZ3,
    PUMA560_P_MX3,
    PUMA560_P_MY3,
    PUMA560_P_MZ3,
    PUMA560_P_M3,
    PUMA560_P_IA3,
    PUMA560_P_D4,
    PUMA560_P_RL4,
    PUMA560_P_XX4,
    PUMA560_P_XY4,
    PUMA560_P_XZ4,
    PUMA560_P_YY4,
    PUMA560_P_YZ4,
    PUMA560_P_ZZ4,
    PUMA560_P_MX4,
    PUMA560_P_MY4,
    PUMA560_P_MZ4,
    PUMA560_P_M4,
    PUMA560_P_IA4,
    PUMA560_P_XX5,
    PUMA560_P_XY5,
    PUMA560_P_XZ5,
    PUMA560_P_YY5,
    PUMA560_P_YZ5,
    PUMA560_P_ZZ5,
    PUMA560_P_MX5,
    PUMA560_P_MY5,
    PUMA560_P_MZ5,
    PUMA560_P_M5,
    PUMA560_P_IA5,
    PUMA560_P_XX6,
    PUMA560_P_XY6,
    PUMA560_P_XZ6,
    PUMA560_P_YY6,
    PUMA560_P_YZ6,
    PUMA560_P_ZZ6,
    PUMA560_P_MX6,
    PUMA560_P_MY6,
    PUMA560_P_MZ6,
    PUMA560_P_M6,
    PUMA560_P_IA6,
    PUMA560_P_G3
};

/* Default values of p; NAN where the machine gives none. */
extern const double puma560_defaults[PUMA560_PARAMETERS];

/* Direct dynamic model [12]-[36].
 * 680x 596+, 10 sin/cos a call; 5x 4+, 0 sin/cos once for each parameter set.
 *   q (6): joint variables, rad or m
 *   qd (6): joint velocities, rad/s or m/s
 *   tau (6): motor torques or forces, N m or N
 *   -> qdd (6): joint accelerations, rad/s2 or m/s2
 *   accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
 */
void puma560_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd);
void puma560_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd);

/* The same in two steps: work that depends on p only, once for each parameter set, then the rest. */
#define PUMA560_DIRECT_DYNAMICS_CONSTANTS 7
void puma560_direct_dynamics_prepare(const double *p, double *c);
void puma560_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd);

/* Inverse dynamic model: motor torques and elastic accelerations [37]-[61].
 * 307x 290+, 10 sin/cos a call; 0x 15+, 0 sin/cos once for each parameter set.
 *   q (6): joint variables, rad or m
 *   qd (6): joint velocities, rad/s or m/s
 *   qdd_motor (6): motor accelerations, rad/s2 or m/s2
 *   -> tau (6): motor torques or forces, N m or N
 *   -> qdd (6): joint accelerations, rad/s2 or m/s2
 */
void puma560_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd);
void puma560_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd);

/* The same in two steps: work that depends on p only, once for each parameter set, then the rest. */
#define PUMA560_INVERSE_DYNAMICS_CONSTANTS 15
void puma560_inverse_dynamics_prepare(const double *p, double *c);
void puma560_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd);

#ifdef __cplusplus
}
#endif

#endif
