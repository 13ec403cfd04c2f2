/* flex4: generated models.
 *
 * SI units, radians. q, qd, qdd follow the joints in table order, tau and qdd_motor the motors.
 * Matrices are stored row by row. Functions called ..._batch compute many states, all with the same p:
 * entry k of state s is at [k*states + s]. No function allocates, keeps state or changes its inputs;
 * inputs and outputs must not overlap. NaN in the inputs a result depends on gives NaN.
 *
 *   q[0]  j1, motor, th1, rad
 *   q[1]  j2, elastic, th2, rad
 *   q[2]  j3, motor, th3, rad
 *   q[3]  j4, elastic, th4, rad
 */
#ifndef FLEX4_H
#define FLEX4_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define FLEX4_JOINTS 4
#define FLEX4_MOTORS 2
#define FLEX4_FRAMES 4
#define FLEX4_PARAMETERS 46

/* Indices into p. */
enum {
    FLEX4_P_XX1,
    FLEX4_P_XY1,
    FLEX4_P_XZ1,
    FLEX4_P_YY1,
    FLEX4_P_YZ1,
    FLEX4_P_ZZ1,
    FLEX4_P_MX1,
    FLEX4_P_MY1,
    FLEX4_P_MZ1,
    FLEX4_P_M1,
    FLEX4_P_IA1,
    FLEX4_P_XX2,
    FLEX4_P_XY2,
    FLEX4_P_XZ2,
    FLEX4_P_YY2,
    FLEX4_P_YZ2,
    FLEX4_P_ZZ2,
    FLEX4_P_MX2,
    FLEX4_P_MY2,
    FLEX4_P_MZ2,
    FLEX4_P_M2,
    FLEX4_P_k2,
    FLEX4_P_L2,
    FLEX4_P_XX3,
    FLEX4_P_XY3,
    FLEX4_P_XZ3,
    FLEX4_P_YY3,
    FLEX4_P_YZ3,
    FLEX4_P_ZZ3,
    FLEX4_P_MX3,
    FLEX4_P_MY3,
    FLEX4_P_MZ3,
    FLEX4_P_M3,
    FLEX4_P_IA3,
    FLEX4_P_XX4,
    FLEX4_P_XY4,
    FLEX4_P_XZ4,
    FLEX4_P_YY4,
    FLEX4_P_YZ4,
    FLEX4_P_ZZ4,
    FLEX4_P_MX4,
    FLEX4_P_MY4,
    FLEX4_P_MZ4,
    FLEX4_P_M4,
    FLEX4_P_k4,
    FLEX4_P_G3
};

/* Default values of p; NAN where the machine gives none. */
extern const double flex4_defaults[FLEX4_PARAMETERS];

/* Direct dynamic model [12]-[36].
 * 119x 97+, 4 sin/cos a call; 9x 4+, 0 sin/cos once for each parameter set.
 *   q (4): joint variables, rad or m
 *   qd (4): joint velocities, rad/s or m/s
 *   tau (2): motor torques or forces, N m or N
 *   -> qdd (4): joint accelerations, rad/s2 or m/s2
 *   accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
 */
void flex4_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd);
void flex4_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd);

/* The same in two steps: work that depends on p only, once for each parameter set, then the rest. */
#define FLEX4_DIRECT_DYNAMICS_CONSTANTS 11
void flex4_direct_dynamics_prepare(const double *p, double *c);
void flex4_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd);

/* Inverse dynamic model: motor torques and elastic accelerations [37]-[61].
 * 125x 98+, 4 sin/cos a call; 3x 2+, 0 sin/cos once for each parameter set.
 *   q (4): joint variables, rad or m
 *   qd (4): joint velocities, rad/s or m/s
 *   qdd_motor (2): motor accelerations, rad/s2 or m/s2
 *   -> tau (2): motor torques or forces, N m or N
 *   -> qdd (4): joint accelerations, rad/s2 or m/s2
 *   accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
 */
void flex4_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd);
void flex4_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd);

/* The same in two steps: work that depends on p only, once for each parameter set, then the rest. */
#define FLEX4_INVERSE_DYNAMICS_CONSTANTS 4
void flex4_inverse_dynamics_prepare(const double *p, double *c);
void flex4_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd);

#ifdef __cplusplus
}
#endif

#endif
