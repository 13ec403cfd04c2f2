// Pinocchio's algorithms on doubles, over all states: x holds q, qd, then qdd or tau of each state.
#include <chrono>
#include <cstddef>
#include <memory>

#include <pinocchio/algorithm/aba-derivatives.hpp>
#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea-derivatives.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include "pinocchio_model.hpp"

namespace
{
using Vector = Eigen::VectorXd;
using RowMajor = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

std::unique_ptr<Machine> machine;
std::unique_ptr<pinocchio::Data> data;
Vector q, qd, u;
Eigen::Index n;

// Motor torques and the law of the springs; where every joint has a motor and no spring, u itself.
void joint_forces(const double *tau)
{
    for (Eigen::Index j = 0; j < n; ++j) {
        const auto k = std::size_t(j);
        u[j] = machine->motor[k] >= 0 ? tau[machine->motor[k]]
                                      : -machine->stiffness[k] * (q[j] - machine->neutral[k]) - machine->damping[k] * qd[j];
    }
}

void take(const double *row)
{
    q = Eigen::Map<const Vector>(row, n);
    qd = Eigen::Map<const Vector>(row + n, n);
}

// `compute` on every state; results stay in `data`, and `give` copies them where they are asked for.
template<class Compute, class Give>
double contest(long passes, std::size_t states, std::size_t inputs, const double *x, double *y, Compute compute, Give give)
{
    const auto start = std::chrono::steady_clock::now();
    for (long pass = 0; pass < passes; ++pass)
        for (std::size_t s = 0; s < states; ++s) {
            take(x + s * inputs);
            compute(x + s * inputs + 2 * n);
            if (y) give(y, s);
        }
    return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
}

std::size_t inputs_with(std::size_t more) { return std::size_t(2 * n) + more; }

std::size_t motors()
{
    std::size_t count = 0;
    for (int motor : machine->motor) count += motor >= 0;
    return count;
}

void give_vector(const Vector &vector, double *y, std::size_t s) { Eigen::Map<Vector>(y + s * std::size_t(n), n) = vector; }

template<class... Matrices>
void give_matrices(double *y, std::size_t s, const Matrices &...matrices)
{
    y += s * sizeof...(matrices) * std::size_t(n * n);
    ((Eigen::Map<RowMajor>(y, n, n) = matrices, y += n * n), ...);
}

Eigen::MatrixXd symmetric(const Eigen::MatrixXd &upper) { return upper.selfadjointView<Eigen::Upper>(); }
} // namespace

extern "C" {
void read_model(const char *path)
{
    machine = std::make_unique<Machine>(read_machine(path));
    data = std::make_unique<pinocchio::Data>(machine->model);
    n = machine->model.nv;
    q.resize(n), qd.resize(n), u.resize(n);
}

double inverse(long passes, std::size_t states, const double *x, double *y)
{
    return contest(
        passes, states, inputs_with(std::size_t(n)), x, y,
        [](const double *qdd) {
            u = Eigen::Map<const Vector>(qdd, n);
            pinocchio::rnea(machine->model, *data, q, qd, u);
        },
        [](double *to, std::size_t s) { give_vector(data->tau, to, s); });
}

double direct(long passes, std::size_t states, const double *x, double *y)
{
    return contest(
        passes, states, inputs_with(motors()), x, y,
        [](const double *tau) {
            joint_forces(tau);
            pinocchio::aba(machine->model, *data, q, qd, u, pinocchio::Convention::WORLD);
        },
        [](double *to, std::size_t s) { give_vector(data->ddq, to, s); });
}

double inertia_matrix(long passes, std::size_t states, const double *x, double *y)
{
    return contest(
        passes, states, inputs_with(0), x, y,
        [](const double *) { pinocchio::crba(machine->model, *data, q, pinocchio::Convention::LOCAL); },
        [](double *to, std::size_t s) { give_matrices(to, s, symmetric(data->M)); });
}

// Derivatives by q, qd and qdd.
double inverse_derivatives(long passes, std::size_t states, const double *x, double *y)
{
    return contest(
        passes, states, inputs_with(std::size_t(n)), x, y,
        [](const double *qdd) {
            u = Eigen::Map<const Vector>(qdd, n);
            pinocchio::computeRNEADerivatives(machine->model, *data, q, qd, u);
        },
        [](double *to, std::size_t s) { give_matrices(to, s, data->dtau_dq, data->dtau_dv, symmetric(data->M)); });
}

// Derivatives by q, qd and tau.
double direct_derivatives(long passes, std::size_t states, const double *x, double *y)
{
    return contest(
        passes, states, inputs_with(motors()), x, y,
        [](const double *tau) {
            joint_forces(tau);
            pinocchio::computeABADerivatives(machine->model, *data, q, qd, u);
        },
        [](double *to, std::size_t s) { give_matrices(to, s, data->ddq_dq, data->ddq_dv, symmetric(data->Minv)); });
}
}
