/* planar_2r: generated models.
 *
 * SI units, radians. q, qd, qdd follow the joints in table order, tau and qdd_motor the motors.
 * Matrices are stored row by row. Functions called ..._batch compute many states, all with the same p:
 * entry k of state s is at [k*states + s]. No function allocates, keeps state or changes its inputs;
 * inputs and outputs must not overlap. NaN in the inputs a result depends on gives NaN.
 *
 *   q[0]  shoulder, motor, q1, rad
 *   q[1]  elbow, motor, q2, rad
 */
#ifndef PLANAR_2R_H
#define PLANAR_2R_H

#include <stddef.h>

#ifdef __cplusplus
extern "C" {
#endif

#define PLANAR_2R_JOINTS 2
#define PLANAR_2R_MOTORS 2
#define PLANAR_2R_FRAMES 3
#define PLANAR_2R_PARAMETERS 9

/* Indices into p. */
enum {
    PLANAR_2R_P_g0,
    PLANAR_2R_P_m1,
    PLANAR_2R_P_m2,
    PLANAR_2R_P_l1,
    PLANAR_2R_P_l2,
    PLANAR_2R_P_lc1,
    PLANAR_2R_P_lc2,
    PLANAR_2R_P_I1,
    PLANAR_2R_P_I2
};

/* Default values of p; NAN where the machine gives none. */
extern const double planar_2r_defaults[PLANAR_2R_PARAMETERS];

/* Direct dynamic model [12]-[36].
 * 26x 15+, 4 sin/cos a call; 8x 4+, 0 sin/cos once for each parameter set.
 *   q (2): joint variables, rad or m
 *   qd (2): joint velocities, rad/s or m/s
 *   tau (2): motor torques or forces, N m or N
 *   -> qdd (2): joint accelerations, rad/s2 or m/s2
 *   accelerations are inf or NaN, or large without meaning, where the inertia matrix is singular
 */
void planar_2r_direct_dynamics(const double *q, const double *qd, const double *tau, const double *p, double *qdd);
void planar_2r_direct_dynamics_batch(size_t states, const double *q, const double *qd, const double *tau, const double *p, double *qdd);

/* The same in two steps: work that depends on p only, once for each parameter set, then the rest. */
#define PLANAR_2R_DIRECT_DYNAMICS_CONSTANTS 8
void planar_2r_direct_dynamics_prepare(const double *p, double *c);
void planar_2r_direct_dynamics_prepared(const double *q, const double *qd, const double *tau, const double *p, const double *c, double *qdd);

/* Inverse dynamic model: motor torques and elastic accelerations [37]-[61].
 * 21x 13+, 4 sin/cos a call; 4x 2+, 0 sin/cos once for each parameter set.
 *   q (2): joint variables, rad or m
 *   qd (2): joint velocities, rad/s or m/s
 *   qdd_motor (2): motor accelerations, rad/s2 or m/s2
 *   -> tau (2): motor torques or forces, N m or N
 *   -> qdd (2): joint accelerations, rad/s2 or m/s2
 */
void planar_2r_inverse_dynamics(const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd);
void planar_2r_inverse_dynamics_batch(size_t states, const double *q, const double *qd, const double *qdd_motor, const double *p, double *tau, double *qdd);

/* The same in two steps: work that depends on p only, once for each parameter set, then the rest. */
#define PLANAR_2R_INVERSE_DYNAMICS_CONSTANTS 4
void planar_2r_inverse_dynamics_prepare(const double *p, double *c);
void planar_2r_inverse_dynamics_prepared(const double *q, const double *qd, const double *qdd_motor, const double *p, const double *c, double *tau, double *qdd);

/* Inertia matrix [8].
 * 3x 5+, 1 sin/cos a call; 5x 2+, 0 sin/cos once for each parameter set.
 *   q (2): joint variables, rad or m
 *   -> A (2 x 2): inertia matrix, kg m2, kg m or kg
 */
void planar_2r_inertia_matrix(const double *q, const double *p, double *A);
void planar_2r_inertia_matrix_batch(size_t states, const double *q, const double *p, double *A);

/* The same in two steps: work that depends on p only, once for each parameter set, then the rest. */
#define PLANAR_2R_INERTIA_MATRIX_CONSTANTS 4
void planar_2r_inertia_matrix_prepare(const double *p, double *c);
void planar_2r_inertia_matrix_prepared(const double *q, const double *p, const double *c, double *A);

/* Forces at zero joint acceleration [8].
 * 17x 8+, 4 sin/cos a call; 2x 0+, 0 sin/cos once for each parameter set.
 *   q (2): joint variables, rad or m
 *   qd (2): joint velocities, rad/s or m/s
 *   -> H (2): Coriolis, centrifugal, gravity and friction forces, N m or N
 */
void planar_2r_bias_forces(const double *q, const double *qd, const double *p, double *H);
void planar_2r_bias_forces_batch(size_t states, const double *q, const double *qd, const double *p, double *H);

/* The same in two steps: work that depends on p only, once for each parameter set, then the rest. */
#define PLANAR_2R_BIAS_FORCES_CONSTANTS 2
void planar_2r_bias_forces_prepare(const double *p, double *c);
void planar_2r_bias_forces_prepared(const double *q, const double *qd, const double *p, const double *c, double *H);

/* Placement of frames [1], [2].
 * 8x 4+, 4 sin/cos a call.
 *   q (2): joint variables, rad or m
 *   -> T (3 x 4 x 4): placement of each frame, row by row, lengths in m
 */
void planar_2r_geometric_model(const double *q, const double *p, double *T);
void planar_2r_geometric_model_batch(size_t states, const double *q, const double *p, double *T);

#ifdef __cplusplus
}
#endif

#endif
