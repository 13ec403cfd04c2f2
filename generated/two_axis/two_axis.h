/* two_axis: generated models.
 *
 * SI units, radians. q, qd, qdd follow the joints in table order, tau and qdd_motor the motors.
 * Matrices are stored row by row. Functions called ..._batch compute many states, all with the same p:
 * entry k of state s is at [k*states + s]. No function allocates, keeps state or changes its inputs;
 * inputs and outputs must not overlap. NaN in the inputs a result depends on gives NaN.
 *
 *   q[0]  bed_yaw, elastic, q1, rad
 *   q[1]  bed_y, elastic, q2, m
 *   q[2]  bed_x, elastic, q3, m
 *   q[3]  motor_secondary, elastic, q4, m
 *   q[4]  motor_x, motor, q5, m
 *   q[5]  cart_yaw, elastic, q6, rad
 *   q[6]  cart_x, elastic, q7, m
 *   q[7]  cart_y, elastic, q8, m
 *   q[8]  motor_y, motor, q9, m
 *   q[9]  y_chain_1, elastic, q10, m
 *   q[10]  ram, elastic, q11, m
 *   q[11]  sensor_head, elastic, q13, m
 */
#ifndef TWO_AXIS_H
#define TWO_AXIS_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define TWO_AXIS_JOINTS 12
#define TWO_AXIS_MOTORS 2
#define TWO_AXIS_FRAMES 13
#define TWO_AXIS_PARAMETERS 4

/* Indices into p. */
enum {
    TWO_AXIS_P_D4,
    TWO_AXIS_P_D12,
    TWO_AXIS_P_L12,
    TWO_AXIS_P_D13
};

/* Default values of p; NAN where the machine gives none. */
extern const double two_axis_defaults[TWO_AXIS_PARAMETERS];

/* Direct dynamic model [12]-[36].
 * 124x 116+, 4 sin/cos a call.
 *   q (12): joint variables, rad or m
 *   qd (12): joint velocities, rad/s or m/s
 *   tau (2): motor torques or forces, N m or N
 *   -> qdd (12): joint accelerations, rad/s2 or m/s2
 *   accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
 */
void two_axis_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd);
void two_axis_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd);

/* Inverse dynamic model: motor torques and elastic accelerations [37]-[61].
 * 125x 118+, 4 sin/cos a call.
 *   q (12): joint variables, rad or m
 *   qd (12): joint velocities, rad/s or m/s
 *   qdd_motor (2): motor accelerations, rad/s2 or m/s2
 *   -> tau (2): motor torques or forces, N m or N
 *   -> qdd (12): joint accelerations, rad/s2 or m/s2
 *   accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
 */
void two_axis_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd);
void two_axis_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd);

#ifdef __cplusplus
}
#endif

#endif
