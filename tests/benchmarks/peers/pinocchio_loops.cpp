// Pinocchio's dynamics of closed chains on doubles, over all states: x holds q, qd and the forces on the joints of each.
#include <chrono>
#include <cstddef>
#include <fstream>
#include <memory>
#include <stdexcept>
#include <string>
#include <vector>

#define PINOCCHIO_DISABLE_UNSUPPORTED_WARNINGS
#include <pinocchio/algorithm/constrained-dynamics.hpp>

#include "pinocchio_model.hpp"

namespace
{
using Vector = Eigen::VectorXd;

struct Loops
{
    Machine machine;
    pinocchio::Data data;
    std::vector<pinocchio::RigidConstraintModel> models;
    std::vector<pinocchio::RigidConstraintData> datas;
    pinocchio::ProximalSettings settings;
    Vector q, qd, forces;
};

std::unique_ptr<Loops> loops;

// A joint, and where on it.
pinocchio::JointIndex read_end(std::istream &in, pinocchio::SE3 &place)
{
    std::size_t joint;
    Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation;
    Eigen::Vector3d origin;
    in >> joint;
    for (int k = 0; k < 9; ++k) in >> rotation.data()[k];
    for (int k = 0; k < 3; ++k) in >> origin[k];
    place = pinocchio::SE3(rotation, origin);
    return joint;
}

std::vector<pinocchio::RigidConstraintModel> read_constraints(const pinocchio::Model &model, const std::string &path)
{
    std::ifstream in(path);
    std::size_t count;
    in >> count;
    std::vector<pinocchio::RigidConstraintModel> found;
    for (std::size_t k = 0; k < count; ++k) {
        pinocchio::SE3 place, other;
        const auto one = read_end(in, place), two = read_end(in, other);
        found.emplace_back(pinocchio::CONTACT_3D, model, one, place, two, other);
    }
    if (!in) throw std::runtime_error("cannot read " + path);
    return found;
}
} // namespace

extern "C" {
// A machine, and the points of it that meet.
void read_loops(const char *machine_path, const char *path)
{
    Machine machine = read_machine(machine_path);
    auto models = read_constraints(machine.model, path);
    pinocchio::Data data(machine.model);
    const auto n = machine.model.nv;
    loops.reset(new Loops{std::move(machine), std::move(data), std::move(models), {}, {}, Vector(n), Vector(n), Vector(n)});
    for (const auto &constraint : loops->models) loops->datas.push_back(constraint.createData());
    pinocchio::initConstraintDynamics(loops->machine.model, loops->data, loops->models, loops->datas);
}

// How the multipliers are found: mu, and steps until they change by less than the accuracy.
void settle(double accuracy, double mu, int steps) { loops->settings = pinocchio::ProximalSettings(accuracy, mu, steps); }

int steps_taken() { return loops->settings.iter; }

// Results stay in `data`, and are copied where they are asked for.
double constrained(long passes, std::size_t states, const double *x, double *y)
{
    auto &[machine, data, models, datas, settings, q, qd, forces] = *loops;
    const auto n = machine.model.nv;
    const auto start = std::chrono::steady_clock::now();
    for (long pass = 0; pass < passes; ++pass)
        for (std::size_t s = 0; s < states; ++s) {
            const double *row = x + s * std::size_t(3 * n);
            q = Eigen::Map<const Vector>(row, n);
            qd = Eigen::Map<const Vector>(row + n, n);
            forces = Eigen::Map<const Vector>(row + 2 * n, n);
            pinocchio::constraintDynamics(machine.model, data, q, qd, forces, models, datas, settings);
            if (y) Eigen::Map<Vector>(y + s * std::size_t(n), n) = data.ddq;
        }
    return std::chrono::duration<double, std::nano>(std::chrono::steady_clock::now() - start).count();
}
}
