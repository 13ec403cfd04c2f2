// A machine as text, read into a Pinocchio model: what the peers that rest on Pinocchio share.
#pragma once

#include <fstream>
#include <stdexcept>
#include <string>
#include <vector>

#include <pinocchio/multibody.hpp>

// Pinocchio's model of the bodies; the springs and motors, which it does not know, beside it.
struct Machine
{
    pinocchio::Model model;
    std::vector<double> stiffness, damping, neutral;
    std::vector<int> motor; // index into tau, or -1
};

inline Machine read_machine(const std::string &path)
{
    std::ifstream in(path);
    std::size_t joints;
    Eigen::Vector3d gravity;
    in >> joints >> gravity[0] >> gravity[1] >> gravity[2];
    Machine machine;
    machine.model.gravity = pinocchio::Motion(gravity, Eigen::Vector3d::Zero());
    std::vector<double> armature(joints);
    int motors = 0;
    for (std::size_t j = 0; j < joints; ++j) {
        std::size_t parent;
        int prismatic, motor;
        Eigen::Matrix<double, 3, 3, Eigen::RowMajor> rotation, inertia;
        Eigen::Vector3d origin, centre;
        double mass, stiffness, damping, neutral;
        in >> parent >> prismatic;
        for (int k = 0; k < 9; ++k) in >> rotation.data()[k];
        for (int k = 0; k < 3; ++k) in >> origin[k];
        in >> mass;
        for (int k = 0; k < 3; ++k) in >> centre[k];
        for (int k = 0; k < 9; ++k) in >> inertia.data()[k];
        in >> armature[j] >> stiffness >> damping >> neutral >> motor;
        pinocchio::JointModel joint;
        if (prismatic) joint = pinocchio::JointModelPZ();
        else joint = pinocchio::JointModelRZ();
        auto added = machine.model.addJoint(
            parent, joint, pinocchio::SE3(rotation, origin), "joint" + std::to_string(j + 1));
        machine.model.appendBodyToJoint(
            added, pinocchio::Inertia(mass, centre, inertia), pinocchio::SE3::Identity());
        machine.stiffness.push_back(stiffness);
        machine.damping.push_back(damping);
        machine.neutral.push_back(neutral);
        machine.motor.push_back(motor ? motors++ : -1);
    }
    if (!in) throw std::runtime_error("cannot read " + path);
    for (std::size_t j = 0; j < joints; ++j) machine.model.armature[Eigen::Index(j)] = armature[j];
    return machine;
}
