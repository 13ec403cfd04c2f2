// Pinocchio's algorithms run on CasADi's expressions: usage `program MACHINE NAME`, writes NAME.c.
#include <iostream>

#include <casadi/casadi.hpp>

#include <pinocchio/autodiff/casadi.hpp>

#include <pinocchio/algorithm/aba.hpp>
#include <pinocchio/algorithm/crba.hpp>
#include <pinocchio/algorithm/rnea.hpp>

#include "pinocchio_model.hpp"

using casadi::SX;
using Vector = Eigen::Matrix<SX, Eigen::Dynamic, 1>;

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

int main(int, char **arguments)
{
    const Machine machine = read_machine(arguments[1]);
    const auto n = machine.model.nv;
    const pinocchio::ModelTpl<SX> model = machine.model.cast<SX>();
    pinocchio::DataTpl<SX> data(model);
    casadi_int motors = 0;
    for (int motor : machine.motor) motors += motor >= 0;
    const SX q = SX::sym("q", n), qd = SX::sym("qd", n), qdd = SX::sym("qdd", n), tau = SX::sym("tau", motors);

    Vector forces(n);
    for (Eigen::Index j = 0; j < n; ++j) {
        const auto k = std::size_t(j);
        SX spring = 0;
        if (machine.stiffness[k] != 0) spring = spring - machine.stiffness[k] * (q(j) - machine.neutral[k]);
        if (machine.damping[k] != 0) spring = spring - machine.damping[k] * qd(j);
        forces[j] = machine.motor[k] >= 0 ? SX(tau(machine.motor[k])) : spring;
    }
    pinocchio::rnea(model, data, entries(q), entries(qd), entries(qdd));
    const SX torques = matrix(data.tau);
    pinocchio::aba(model, data, entries(q), entries(qd), forces, pinocchio::Convention::LOCAL);
    const SX accelerations = matrix(data.ddq);
    pinocchio::crba(model, data, entries(q), pinocchio::Convention::LOCAL);
    SX inertia = matrix(data.M);
    for (casadi_int i = 0; i < n; ++i)
        for (casadi_int j = 0; j < i; ++j) inertia(i, j) = inertia(j, i);

    casadi::Dict options;
    options["with_header"] = false;
    casadi::CodeGenerator code(arguments[2], options);
    const casadi::Dict shared{{"cse", true}};
    const casadi::Function functions[] = {
        casadi::Function("inverse", {q, qd, qdd}, {torques}, shared),
        casadi::Function("direct", {q, qd, tau}, {accelerations}, shared),
        casadi::Function("inertia_matrix", {q}, {SX::vec(inertia)}, shared),
    };
    for (const auto &function : functions) {
        code.add(function);
        std::cout << function.name() << " " << function.n_instructions() << "\n";
    }
    code.generate();
}
