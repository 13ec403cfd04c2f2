"""Derivatives of responses, poles and damping ratios by parameters against central differences in 50 digits.

M, D and K are there those of the traced model, velocities of signals those of unit rates, positions those of Newton's
method: what is tested is every derivative, and how they are put together.
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.analysis.vibration.linearization import (
    Linearization,
    linear_slopes,
    linearize,
    pole_slopes,
    ratio_slopes,
    response_slopes,
    with_motors,
)
from symoro_elastic.analysis.vibration.modes import damped_poles
from symoro_elastic.formats import read_machine
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision

EXAMPLES = Path(__file__).parents[3] / "examples"
FLOATING = "floating_arm.toml"
FILES = (
    "ball_screw.toml", "ball_screw_rigid.toml", "balanced_arm.xml", "four_bar.par", "gantry.toml", "linkage.toml",
    "palletizer.toml", "pendant_arm.urdf", "planar_2r.toml", "puma560_measured.toml", "sr400.par", "two_axis.toml",
    FLOATING,
)  # fmt: skip
FREQUENCIES = np.array([3.0, 41.0, 170.0])
DIGITS = 50


class ManyDigits:
    """Z, F and C of a linearization at other values of parameters, in many digits."""

    def __init__(self, linear: Linearization, outs: list[tuple[int, int]], ins: list[int]) -> None:
        self.linear, self.motion, self.outs, self.ins = linear, linear.motion, outs, ins
        self.arithmetic = multiprecision(DIGITS)

    def numbers(self, roots: list[Any], q: list[Any], values: dict[str, Any], qd: list[Any] | None = None) -> list[Any]:
        bound, rest = self.motion.bound, [mpmath.mpf(0)] * len(q)
        symbols = dict(values)
        for by_joint, x in ((bound.q, q), (bound.qd, qd or rest), (bound.qdd, rest), (bound.tau, rest)):
            symbols |= {symbol.operands[0]: y for symbol, y in zip(by_joint.values(), x, strict=False)}
        found = evaluate(roots, symbols, self.arithmetic)
        return [found(x) for x in roots]

    def matrix(self, name: str, q: list[Any], values: dict[str, Any]) -> Any:
        (entries,) = (output.entries for output in self.motion.linear_model.outputs if output.name == name)
        return mpmath.matrix(len(q), len(q)) + mpmath.matrix(
            np.array(self.numbers(list(entries), q, values), dtype=object).reshape(len(q), len(q)).tolist()
        )

    def position(self, values: dict[str, Any]) -> list[Any]:
        state = self.linear.state
        q, sought = [mpmath.mpf(x) for x in state.q], list(state.sought)
        for _ in range(5 if sought else 0):
            r = self.numbers(self.motion.residual, q, values)
            K = self.matrix("K", q, values)
            chosen = mpmath.matrix([[K[i, j] for j in sought] for i in sought])
            step = mpmath.lu_solve(chosen, mpmath.matrix([state.tau[i] - r[i] for i in sought]))
            for k, x in zip(sought, step, strict=True):
                q[k] += x
        return q

    def small_motions(self, changed: dict[str, Any]) -> tuple[list[Any], Any, Any]:
        """M, D, K with controllers; F; C without its power of s."""
        values = {name: mpmath.mpf(x) for name, x in self.motion.parameters.items()} | changed
        q = self.position(values)
        M, D, K = (self.matrix(name, q, values) for name in "MDK")
        J = self.columns(self.motion.frame_motions[0], q, values)
        S = self.columns(self.motion.joint_coordinate_rates[0], q, values)
        numbered = self.motion.machine.with_variable
        for m, (kp, kd) in zip(self.motion.machine.motors, self.linear.gains, strict=True):
            row = mpmath.matrix([S[numbered.index(m)]]) if m in numbered else mpmath.zeros(1, len(q))
            K, D = K + mpmath.mpf(kp) * row.T * row, D + mpmath.mpf(kd) * row.T * row
        F = mpmath.matrix([S[numbered.index(j)] for j in self.ins]).T
        return [M, D, K], F, mpmath.matrix([J[row] for row, _ in self.outs])

    def columns(self, roots: list[Any], q: list[Any], values: dict[str, Any]) -> list[list[Any]]:
        n = len(q)
        units = ([mpmath.mpf(j == k) for j in range(n)] for k in range(n))
        return [list(row) for row in zip(*(self.numbers(roots, q, values, unit) for unit in units), strict=True)]

    def poles(self, changed: dict[str, Any], start: Any) -> list[Any]:
        """Poles near those of `start`."""
        (M, D, K), _, _ = self.small_motions(changed)
        found = []
        for pole in start:
            lam = mpmath.mpc(pole)
            b = mpmath.matrix([mpmath.mpf(k % 3 + 1) for k in range(M.rows)])
            step = lam
            while abs(step) > mpmath.mpf("1e-30") * abs(lam):
                Z = lam * lam * M + lam * D + K
                with mpmath.workdps(3 * DIGITS):  # Z is singular to nearly all digits
                    x, y = mpmath.lu_solve(Z, b), mpmath.lu_solve(Z.T, b)
                step = (y.T * Z * x)[0] / (y.T * (2 * lam * M + D) * x)[0]
                lam = lam - step
            found.append(lam)
        return found

    def responses(self, changed: dict[str, Any]) -> list[Any]:
        (M, D, K), F, C = self.small_motions(changed)
        found = []
        for f in FREQUENCIES:
            s = 2j * mpmath.pi * mpmath.mpf(f)
            moved = mpmath.lu_solve(s * s * M + s * D + K, F)
            found += [s**order * (C * moved)[o] for o, (_, order) in enumerate(self.outs)]
        return found


def small_motions_of(name: str) -> ManyDigits:
    machine = read_machine(EXAMPLES / name)[0]
    outs = [f"{machine.joints[-1].name}.{x}" for x in ("y", "vx", "az")]
    motion = motion_of(machine, {}, (), outs)
    at = {motion.motor_names[0]: 0.1} if name not in (FLOATING, "four_bar.par") else {}
    gains = {motion.motor_names[-1]: (2e5, 3e3)}
    ins = [f"{motion.motor_names[0]}.tau"]
    linear = with_motors(linearize(motion, equilibrium(motion, at, None, name == FLOATING), ins, outs), gains=gains)
    names = [joint.name for joint in motion.machine.joints]
    row = motion.row_of(names.index(machine.joints[-1].name) + 1)
    return ManyDigits(linear, [(row + 1, 0), (row, 1), (row + 2, 2)], [motion.machine.motors[0]])


def slopes_in_many_digits(of: Callable[[dict[str, Any]], list[Any]], name: str, value: float) -> np.ndarray:
    """Central differences of a function of changed parameters."""
    p = mpmath.mpf(value)
    step = (abs(p) or 1) * mpmath.mpf("1e-14")
    up, down = (of({name: p + way * step}) for way in (1, -1))
    return np.array([complex((a - b) / (2 * step)) for a, b in zip(up, down, strict=True)])


@pytest.mark.thorough
@pytest.mark.parametrize("name", FILES)
def test_responses_of_the_examples_in_50_digits(name: str) -> None:
    """1e-8 of the largest; all orders of output, a motor under a controller, springs that sag."""
    exact = small_motions_of(name)
    slopes = linear_slopes(exact.linear)
    G, dG = response_slopes(slopes, FREQUENCIES)
    with mpmath.workdps(DIGITS):
        mine = np.array([complex(x) for x in exact.responses({})]).reshape(G.shape[:2])
        np.testing.assert_allclose(G[:, :, 0], mine, rtol=0, atol=1e-9 * np.abs(mine).max())
        for k in np.random.default_rng(len(slopes.names)).permutation(len(slopes.names))[:12]:
            value = exact.motion.parameters[slopes.names[k]]
            wanted = slopes_in_many_digits(exact.responses, slopes.names[k], value).reshape(mine.shape)
            rounding = 1e-9 * np.abs(mine).max(axis=0) / (abs(value) or 1)
            allowed = 1e-8 * np.maximum(np.abs(wanted).max(axis=0), rounding)
            assert (np.abs(dG[k, :, :, 0] - wanted) <= allowed).all(), slopes.names[k]


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["ball_screw.toml", "gantry.toml"])
def test_poles_and_damping_ratios_in_50_digits(name: str) -> None:
    """Poles are refined from those in double precision: Newton's method on Z(lambda) phi = 0 with phi of one size."""
    exact = small_motions_of(name)
    linear = exact.linear
    poles = damped_poles(linear)[0]
    poles = poles[poles.imag > 1.0]
    slopes = linear_slopes(linear)
    found = pole_slopes(slopes, poles)
    frequency, ratio = ratio_slopes(poles, found)
    with mpmath.workdps(DIGITS):
        for k in np.random.default_rng(7).permutation(len(slopes.names))[:8]:
            value = exact.motion.parameters[slopes.names[k]]
            wanted = slopes_in_many_digits(lambda x: exact.poles(x, poles), slopes.names[k], value)
            np.testing.assert_allclose(found[k], wanted, rtol=1e-8, atol=1e-8 * np.abs(wanted).max())
            size = np.abs(poles)
            own = (poles.conj() * wanted).real / size
            np.testing.assert_allclose(frequency[k], own / 2 / np.pi, rtol=1e-7, atol=1e-8 * np.abs(wanted).max())
            zeta = np.array(
                [-(x.real * s - y.real * g) / s**2 for x, y, s, g in zip(wanted, poles, size, own, strict=True)]
            )
            np.testing.assert_allclose(ratio[k], zeta, rtol=1e-7, atol=1e-8 * np.abs(wanted / size).max())


def test_ratios_of_one_oscillator() -> None:
    """zeta = d/(2 sqrt(k m)): its derivatives by hand, and those of the response k/(k + s d + s^2 m)."""
    m, d, k = 3.0, 5.0, 1200.0
    tables = {
        "joints": [{"name": "mass", "kind": "elastic", "sigma": 1, "r": "x"}],
        "bodies": {"mass": {"mass": m}},
        "springs": {"mass": {"stiffness": k, "damping": d}},
    }
    modal = se.modes(tables)
    found, zeta = modal.damping_sensitivity, d / (2 * np.sqrt(k * m))
    by = dict(zip(found.parameters, found.slopes[:, 0], strict=True))
    assert modal.damping_ratios[0] == pytest.approx(zeta, rel=1e-13)
    wanted = {"mass.mass": -zeta / (2 * m), "mass.damping": zeta / d, "mass.stiffness": -zeta / (2 * k)}
    assert by == pytest.approx(wanted, rel=1e-12)
    answer = se.response(tables, inputs=["mass.fz"], outputs=["mass.z"], frequencies=[1.0, 4.0])
    s = 2j * np.pi * answer.frequencies
    slopes = dict(zip(answer.sensitivity.parameters, answer.sensitivity.slopes[:, :, 0, 0], strict=True))
    Z = k + s * d + s * s * m
    for name, change in (("mass.mass", s * s), ("mass.damping", s), ("mass.stiffness", 1)):
        np.testing.assert_allclose(slopes[name], -change / Z**2, rtol=1e-12)


@pytest.mark.thorough
def test_modal_damping_and_resonances() -> None:
    """An added damping ratio moves with M and K; lines on an undamped resonance are NaN."""
    path, at = EXAMPLES / "two_axis.toml", {"motor_x": 0.3}

    def answer(**values: float) -> se.Response:
        return se.response(
            path, at=at, values=values, inputs=["tool.fx"], outputs=["tool.ax"], damping=0.02, frequencies=[30.0, 90.0]
        )

    found = answer().sensitivity
    for name in ("ram.stiffness", "cart_y.mass"):
        value = found.values[found.parameters.index(name)]
        up, down = (answer(**{name: value * (1 + x)}).values for x in (1e-5, -1e-5))
        wanted = (up - down) / (2e-5 * value)
        np.testing.assert_allclose(
            found.slopes[found.parameters.index(name)], wanted, rtol=0, atol=1e-6 * np.abs(wanted).max()
        )
    undamped = se.modes(path, at=at).frequencies[-1]
    skipped = se.response(path, at=at, inputs=["tool.fx"], outputs=["tool.ax"], frequencies=[30.0, undamped])
    assert np.isnan(skipped.sensitivity.slopes[:, 1]).all() and np.isfinite(skipped.sensitivity.slopes[:, 0]).all()


def test_a_state_that_moves_has_no_slopes() -> None:
    falling = se.response(
        EXAMPLES / FLOATING, as_given=True, inputs=["base.fx"], outputs=["base.ax"], frequencies=[3.0]
    )
    with pytest.raises(se.InputError, match="derivatives by parameters are those of equilibria"):
        _ = falling.sensitivity
