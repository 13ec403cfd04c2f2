"""An elastic arm from rest to rest with the smoothest torques, and a limit on the rates of its springs.

The models are CasADi functions, `se.load(machine, backend="casadi")`. One optimal control problem, minimum integral of
(dtau/dt)^2, goes to acados where that is installed, and to IPOPT otherwise: the same steps of RK4, the same optimum.
`python examples/optimal_arm.py [--solver acados | ipopt]` needs `pip install 'symoro-elastic[casadi]'`.
"""

import argparse
import sys
import tempfile
import warnings
from importlib.util import find_spec
from pathlib import Path
from typing import Any, NamedTuple

import casadi as ca
import numpy as np

import symoro_elastic as se

warnings.simplefilter("ignore", se.MachineWarning)  # the file names meshes, and rounds its quarter turns
ARM = se.read(
    Path(__file__).parent / "pendant_arm.urdf", snap=1e-9, elastic={"shoulder": (3e3, 0.5), "elbow": (1.5e3, 0.3)}
)
MODEL = se.load(ARM, "direct_dynamics", scene={"locked": {"waist": 0.0, "wrist": 0.0}}, backend="casadi")
MOTORS, SPRINGS, N = list(MODEL.MOTORS), list(MODEL.ELASTIC), len(MODEL.JOINTS)
START, GOAL, DURATION = [0.0, 0.8], [1.0, -0.4], 0.5  # rad, rad, s
INTERVALS, STEPS = 40, 4
MOST_TORQUE = [250.0, 120.0]  # N m


class Problem(NamedTuple):
    """State (q, qd, tau) at the ends, its bounds, and its rate for torque rates u, in 1e3 N m/s."""

    start: np.ndarray
    goal: np.ndarray
    bound: np.ndarray
    x: Any
    u: Any
    rate: Any


def at_rest(position: list[float]) -> np.ndarray:
    """State in which the motors hold a position: deflections and torques under gravity."""
    unknown = ca.SX.sym("unknown", len(SPRINGS) + len(MOTORS))
    q = ca.SX(N, 1)
    q[MOTORS], q[SPRINGS] = ca.DM(position), unknown[: len(SPRINGS)]
    tau = unknown[len(SPRINGS) :]
    balance = ca.rootfinder("balance", "newton", {"x": unknown, "g": MODEL.direct_dynamics(q, ca.SX(N, 1), tau)})
    found = balance(x0=ca.DM.zeros(unknown.shape))["x"]
    (q,) = ca.Function("q", [unknown], [q]).call([found])
    return np.concatenate([q.full().ravel(), np.zeros(N), found[len(SPRINGS) :].full().ravel()])


def problem(most_swing: float) -> Problem:
    """The positioning; rates of deflections stay within most_swing, rad/s."""
    q, qd, tau, u = (ca.SX.sym(name, size) for name, size in (("q", N), ("qd", N), ("tau", len(MOTORS)), ("u", 2)))
    bound = np.full(2 * N + len(MOTORS), 1e3)
    bound[[N + k for k in SPRINGS]] = most_swing
    bound[2 * N :] = MOST_TORQUE
    x = ca.vertcat(q, qd, tau)
    rate = ca.vertcat(qd, MODEL.direct_dynamics(q, qd, tau), 1e3 * u)
    return Problem(at_rest(START), at_rest(GOAL), bound, x, u, rate)


def by_ipopt(of: Problem) -> np.ndarray:
    """The states of the optimum at the ends of all intervals, by IPOPT."""
    rate = ca.Function("rate", [of.x, of.u], [of.rate])
    h, x = DURATION / INTERVALS / STEPS, of.x
    for _ in range(STEPS):
        k1 = rate(x, of.u)
        k2 = rate(x + h / 2 * k1, of.u)
        k3 = rate(x + h / 2 * k2, of.u)
        x = x + h / 6 * (k1 + 2 * k2 + 2 * k3 + rate(x + h * k3, of.u))
    after = ca.Function("after", [of.x, of.u], [x])
    states, inputs = ca.MX.sym("states", x.numel(), INTERVALS + 1), ca.MX.sym("inputs", 2, INTERVALS)
    gaps = states[:, 1:] - after.map(INTERVALS)(states[:, :-1], inputs)
    nlp = {"x": ca.veccat(states, inputs), "f": ca.sumsqr(inputs) * DURATION / INTERVALS, "g": ca.vec(gaps)}
    quiet = {"print_time": False, "ipopt": {"print_level": 0, "sb": "yes", "tol": 1e-10}}
    most = np.column_stack([of.start, *[of.bound] * (INTERVALS - 1), of.goal])
    least = np.column_stack([of.start, *[-of.bound] * (INTERVALS - 1), of.goal])
    free = np.full(inputs.numel(), np.inf)
    solve = ca.nlpsol("solve", "ipopt", nlp, quiet)
    found = solve(
        x0=np.concatenate([guess(of).ravel("F"), np.zeros(inputs.numel())]),
        lbx=np.concatenate([least.ravel("F"), -free]),
        ubx=np.concatenate([most.ravel("F"), free]),
        lbg=0,
        ubg=0,
    )
    if not solve.stats()["success"]:
        raise RuntimeError(f"IPOPT: {solve.stats()['return_status']}")
    return found["x"][: states.numel()].full().reshape(states.shape, order="F")


def by_acados(of: Problem) -> np.ndarray:
    """The same by acados: SQP, with HPIPM for the quadratic programs."""
    from acados_template import AcadosModel, AcadosOcp, AcadosOcpSolver  # noqa: PLC0415

    ocp = AcadosOcp()
    ocp.model = AcadosModel()
    ocp.model.name, ocp.model.x, ocp.model.u, ocp.model.f_expl_expr = "optimal_arm", of.x, of.u, of.rate
    states, inputs = of.x.numel(), of.u.numel()
    ocp.cost.cost_type, ocp.cost.W, ocp.cost.yref = "LINEAR_LS", 2 * np.eye(inputs), np.zeros(inputs)
    ocp.cost.Vx, ocp.cost.Vu = np.zeros((inputs, states)), np.eye(inputs)
    ocp.constraints.x0 = of.start
    ocp.constraints.idxbx, ocp.constraints.lbx, ocp.constraints.ubx = np.arange(states), -of.bound, of.bound
    ocp.constraints.idxbx_e, ocp.constraints.lbx_e, ocp.constraints.ubx_e = np.arange(states), of.goal, of.goal
    options = ocp.solver_options
    options.tf, options.integrator_type, options.sim_method_num_steps = DURATION, "ERK", STEPS
    options.nlp_solver_type, options.nlp_solver_max_iter, options.tol = "SQP", 100, 1e-8
    ocp.dims.N = options.N_horizon = INTERVALS  # the first was its place until 2024
    with tempfile.TemporaryDirectory() as folder:
        ocp.code_export_directory = f"{folder}/code"
        solver = AcadosOcpSolver(ocp, json_file=f"{folder}/ocp.json", verbose=False)
        for k, x in enumerate(guess(of).T):
            solver.set(k, "x", x)
        if solver.solve():
            raise RuntimeError(f"acados: status {solver.get_status()}")
        return np.column_stack([solver.get(k, "x") for k in range(INTERVALS + 1)])


def guess(of: Problem) -> np.ndarray:
    """States on the straight line between the ends."""
    return np.linspace(of.start, of.goal, INTERVALS + 1, axis=1)


def main() -> int:
    installed = "acados" if find_spec("acados_template") else "ipopt"
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--solver", choices=("acados", "ipopt"), default=installed)
    solver = parser.parse_args().solver
    if solver == "acados" and installed != "acados":
        parser.error("acados is missing: https://docs.acados.org/installation, or --solver ipopt")
    if solver == "ipopt" and not ca.has_nlpsol("ipopt"):
        parser.error("this CasADi has no IPOPT: pip install --force-reinstall --no-deps casadi")
    solve = by_acados if solver == "acados" else by_ipopt
    print(f"from rest to rest in {DURATION} s; peaks of torques and of spring rates")
    print("limit rad/s   shoulder N m   elbow N m   shoulder rad/s   elbow rad/s")
    for most_swing in (9.0, 0.4, 0.3):
        x = solve(problem(most_swing))
        torques = np.abs(x[2 * N :]).max(axis=1)
        swings = np.abs(x[N : 2 * N][SPRINGS]).max(axis=1)
        print(f"{most_swing:11.2f} {torques[0]:14.2f} {torques[1]:11.2f} {swings[0]:16.4f} {swings[1]:13.4f}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
