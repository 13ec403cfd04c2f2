/* MuJoCo's functions over all states: x holds q, qd, then qdd or tau of each state. */
#define _POSIX_C_SOURCE 199309L
#include <mujoco/mujoco.h>
#include <string.h>
#include <time.h>

static mjModel *m;
static mjData *d;
static const int *motors;
static int motor_count;

int read_model(const char *path, const int *dofs_of_motors, int count)
{
    if (d) mj_deleteData(d);
    if (m) mj_deleteModel(m);
    m = mj_loadModel(path, 0);
    d = m ? mj_makeData(m) : 0;
    motors = dofs_of_motors;
    motor_count = count;
    return d != 0;
}

static void inverse_state(const mjtNum *qdd)
{
    memcpy(d->qacc, qdd, (size_t)m->nv * sizeof *qdd);
    mj_kinematics(m, d);
    mj_comPos(m, d);
    mj_comVel(m, d);
    mj_rne(m, d, 1, d->qfrc_inverse);
    for (int k = 0; k < m->nv; ++k) d->qfrc_inverse[k] += m->dof_armature[k] * d->qacc[k];
}

static void direct_state(const mjtNum *tau)
{
    for (int k = 0; k < motor_count; ++k) d->qfrc_applied[motors[k]] = tau[k];
    mj_forward(m, d);
}

static double contest(
    long passes, size_t states, size_t inputs, const mjtNum *x, mjtNum *y, void (*compute)(const mjtNum *), const mjtNum *result)
{
    const size_t n = (size_t)m->nv;
    struct timespec start, end;
    clock_gettime(CLOCK_MONOTONIC, &start);
    for (long pass = 0; pass < passes; ++pass)
        for (size_t s = 0; s < states; ++s) {
            const mjtNum *row = x + s * inputs;
            memcpy(d->qpos, row, n * sizeof *row);
            memcpy(d->qvel, row + n, n * sizeof *row);
            compute(row + 2 * n);
            if (y) memcpy(y + s * n, result, n * sizeof *y);
        }
    clock_gettime(CLOCK_MONOTONIC, &end);
    return 1e9 * (double)(end.tv_sec - start.tv_sec) + (double)(end.tv_nsec - start.tv_nsec);
}

double inverse(long passes, size_t states, const mjtNum *x, mjtNum *y)
{
    return contest(passes, states, 3 * (size_t)m->nv, x, y, inverse_state, d->qfrc_inverse);
}

double direct(long passes, size_t states, const mjtNum *x, mjtNum *y)
{
    return contest(passes, states, 2 * (size_t)m->nv + (size_t)motor_count, x, y, direct_state, d->qacc);
}
