/* Steps of MuJoCo along a motion: servos are springs and dampers of the motors, their positions given at each step. */
#define _POSIX_C_SOURCE 199309L
#include <mujoco/mujoco.h>
#include <string.h>
#include <time.h>

/* rows: position of each motor, then its torque, a row a step; record: q and qd after each step. Seconds, < 0: no model. */
double carry_out(
    const char *path, int integrator, double h, int steps, int motors, const int *dofs, const double *kp, const double *kd,
    const double *q, const double *rows, double *record)
{
    mjModel *m = mj_loadModel(path, 0);
    if (!m) return -1;
    m->opt.timestep = h;
    m->opt.integrator = integrator;
    for (int k = 0; k < motors; ++k) {
        m->jnt_stiffness[m->dof_jntid[dofs[k]]] = kp[k];
        m->dof_damping[dofs[k]] = kd[k];
    }
    mjData *d = mj_makeData(m);
    memcpy(d->qpos, q, (size_t)m->nq * sizeof *q);
    struct timespec start, end;
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (int s = 0; s < steps; ++s) {
        for (int k = 0; k < motors; ++k) {
            m->qpos_spring[m->jnt_qposadr[m->dof_jntid[dofs[k]]]] = *rows++;
            d->qfrc_applied[dofs[k]] = *rows++;
        }
        mj_step(m, d);
        memcpy(record, d->qpos, (size_t)m->nq * sizeof *record);
        memcpy(record + m->nq, d->qvel, (size_t)m->nv * sizeof *record);
        record += m->nq + m->nv;
    }
    clock_gettime(CLOCK_MONOTONIC, &end);
    mj_deleteData(d);
    mj_deleteModel(m);
    return (double)(end.tv_sec - start.tv_sec) + 1e-9 * (double)(end.tv_nsec - start.tv_nsec);
}
