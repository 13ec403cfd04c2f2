// Pinocchio's algorithms run on CasADi's expressions: usage `program MACHINE MODEL NAME`, writes NAME.c.
#include <stdexcept>

#include <casadi/casadi.hpp>

#include <pinocchio/autodiff/casadi.hpp>

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include "pinocchio_model.hpp"

using casadi::SX;
using Vector = Eigen::Matrix<SX, Eigen::Dynamic, 1>;

struct Expressions
{
    std::vector<SX> arguments, results;
};

static Vector entries(const SX &symbols)
{
    Vector vector(symbols.size1());
    for (casadi_int k = 0; k < symbols.size1(); ++k) vector[k] = symbols(k);
    return vector;
}

template<class Derived>
static SX matrix(const Eigen::MatrixBase<Derived> &from)
{
    SX to = SX::zeros(from.rows(), from.cols());
    for (Eigen::Index i = 0; i < from.rows(); ++i)
        for (Eigen::Index j = 0; j < from.cols(); ++j) to(i, j) = from(i, j);
    return to;
}

// Motor torques, and the law of the springs where there is no motor.
static Vector joint_forces(const Machine &machine, const SX &q, const SX &qd, const SX &tau)
{
    Vector forces(q.size1());
    for (Eigen::Index j = 0; j < forces.size(); ++j) {
        const auto k = std::size_t(j);
        SX spring = 0;
        if (machine.stiffness[k] != 0) spring = spring - machine.stiffness[k] * (q(j) - machine.neutral[k]);
        if (machine.damping[k] != 0) spring = spring - machine.damping[k] * qd(j);
        forces[j] = machine.motor[k] >= 0 ? SX(tau(machine.motor[k])) : spring;
    }
    return forces;
}

static Expressions expressions(const Machine &machine, const std::string &name)
{
    const auto n = machine.model.nv;
    const pinocchio::ModelTpl<SX> model = machine.model.cast<SX>();
    pinocchio::DataTpl<SX> data(model);
    casadi_int motors = 0;
    for (int motor : machine.motor) motors += motor >= 0;
    const SX q = SX::sym("q", n), qd = SX::sym("qd", n), qdd = SX::sym("qdd", n), tau = SX::sym("tau", motors);

    if (name == "inverse_dynamics") {
        pinocchio::rnea(model, data, entries(q), entries(qd), entries(qdd));
        return {{q, qd, qdd}, {matrix(data.tau)}};
    }
    if (name == "direct_dynamics") {
        const Vector forces = joint_forces(machine, q, qd, tau);
        pinocchio::aba(model, data, entries(q), entries(qd), forces, pinocchio::Convention::LOCAL);
        return {{q, qd, tau}, {matrix(data.ddq)}};
    }
    if (name == "inertia_matrix") {
        pinocchio::crba(model, data, entries(q), pinocchio::Convention::LOCAL);
        return {{q}, {SX::densify(SX::triu2symm(SX::triu(matrix(data.M))))}};
    }
    throw std::invalid_argument("no model " + name);
}

// Jacobians of the result by each argument, row by row.
static Expressions derivatives(const Expressions &of)
{
    Expressions by{of.arguments, {}};
    for (const SX &argument : of.arguments)
        by.results.push_back(SX::densify(SX::jacobian(of.results[0], argument)).T());
    return by;
}

int main(int, char **arguments)
{
    const std::string asked = arguments[2], ending = "_derivatives";
    const auto end = asked.rfind(ending);
    Expressions found = expressions(read_machine(arguments[1]), asked.substr(0, end));
    if (end != std::string::npos) found = derivatives(found);
    casadi::CodeGenerator code(arguments[3], {{"with_header", false}});
    code.add(casadi::Function("model", found.arguments, found.results, casadi::Dict{{"cse", true}}));
    code.generate();
}
