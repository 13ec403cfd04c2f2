"""Free-flying elastic structures: six motions at exactly 0 Hz, the rest against other ways to the same figures."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import scipy.linalg
from click.testing import CliRunner

from symoro_elastic.analysis.vibration.linearization import Linearization, linearize, with_motors
from symoro_elastic.analysis.vibration.modes import kinetic_shares, modes, sensitivity
from symoro_elastic.analysis.vibration.responses import frequency_response
from symoro_elastic.cli import cli
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.frames import COORDINATES
from symoro_elastic.machine.machine import Base, Body, Floating, Joint, Kind, KnownOfBase, Machine
from symoro_elastic.numerics.motion.equations_of_motion import motion_of
from symoro_elastic.numerics.motion.equilibrium import equilibrium
from tests.analysis.vibration.machines import WEIGHT, machine_of, slide, spring
from tests.compiled_models import cell, vector
from tests.models.test_floating_base import on
from tests.references.random_machines import random_machine

pytestmark = pytest.mark.sampled(4)

M1, M2, K = 7.0, 3.0, 2e4


def pair(base: Base | None = None) -> Machine:
    """A body in space, and a mass on a spring along z of it."""
    load = slide("load", 0, Kind.ELASTIC, M2, spring=spring(K))
    body = Body(cell(M1), vector(0, 0, 0), (cell(2), cell(0), cell(0), cell(2), cell(0), cell(2)))
    return replace(machine_of("craft", load, base=base or Base()), floating=Floating(body=body))


def linear_of(machine: Machine, ins: tuple[str, ...] = (), outs: tuple[str, ...] = ()) -> Linearization:
    motion = motion_of(machine, {}, ins, outs)
    return linearize(motion, equilibrium(motion), ins, outs)


def test_two_masses_in_space() -> None:
    """omega^2 = k (1/m1 + 1/m2), and its slopes; all that moves as one body is exactly at rest."""
    found = modes(linear_of(pair()))
    assert found.rigid == 6 and (found.frequencies[:6] == 0).all()
    frequency = np.sqrt(K * (1 / M1 + 1 / M2)) / (2 * np.pi)
    assert found.frequencies[6:] == pytest.approx([frequency], rel=1e-14)
    slopes = sensitivity(found, ("load.stiffness", "base.mass", "load.mass"))
    relative = {name: x for name, x, _ in slopes.strongest(6, 3)}
    assert relative["load.stiffness"] == pytest.approx(0.5, rel=1e-12)
    assert relative["base.mass"] == pytest.approx(-0.5 * M2 / (M1 + M2), rel=1e-12)
    shares = kinetic_shares(found)
    assert shares.shares[shares.names.index("base"), 6] == pytest.approx(M2 / (M1 + M2), rel=1e-12)


def test_response_of_two_masses_in_space() -> None:
    """x1 / F1 = (k - m2 omega^2) / (omega^2 (m1 m2 omega^2 - k (m1 + m2)))."""
    linear = linear_of(pair(), ("base.fz", "load.fz"), ("base.z", "load.az"))
    f = np.array([1.0, 10.0, 30.0])
    square = (2 * np.pi * f) ** 2
    below = square * (M1 * M2 * square - K * (M1 + M2))
    values = frequency_response(linear, f).values
    np.testing.assert_allclose(values[:, 0, 0], (K - M2 * square) / below, rtol=1e-12)
    np.testing.assert_allclose(values[:, 0, 1], K / below, rtol=1e-12)
    np.testing.assert_allclose(values[:, 1, 0], -square * K / below, rtol=1e-12)


@pytest.mark.sampled(5)
@pytest.mark.parametrize("seed", range(4))
def test_random_trees_in_space(seed: int) -> None:
    """Pinocchio's inertia matrix on a free-flyer and the springs of the table, by scipy."""
    peer = pytest.importorskip("pinocchio") and pytest.importorskip("tests.references.pinocchio_model")
    tree = random_machine(seed, joints=4 + seed, kinds=("elastic", "fixed"), friction=False, wrenches=False)
    machine = replace(on(tree), base=Base())
    linear = linear_of(machine)
    n, q = len(machine.independent), linear.state.q[6:]
    assert linear.coordinates[:6] == COORDINATES and len(linear.coordinates) == 6 + n
    still = peer.BaseState(np.eye(3), np.zeros(6), np.zeros(6))
    _, A, _ = peer.floating_dynamics(machine, still, q, 0 * q, 0 * q)
    np.testing.assert_allclose(linear.M, A, rtol=0, atol=1e-12 * np.abs(A).max())
    stiffness = [machine.joints[j - 1].spring.stiffness.value() for j in machine.independent]
    wanted = scipy.linalg.eigh(np.diag([0.0] * 6 + stiffness), A, eigvals_only=True)
    found = modes(linear)
    assert found.rigid == 6
    np.testing.assert_allclose(found.eigenvalues[6:], wanted[6:], rtol=1e-9)


def test_a_base_whose_motion_is_given_is_held() -> None:
    driven = replace(pair(), floating=Floating(known=KnownOfBase.ACCELERATION, body=Body(cell(M1))))
    held = modes(linear_of(driven))
    assert held.rigid == 0 and held.frequencies == pytest.approx([np.sqrt(K / M2) / (2 * np.pi)], rel=1e-14)


def test_a_free_base_falls() -> None:
    with pytest.raises(InputError, match=r"nothing supports base\.z \(98\.1 N\), so a free base falls") as refused:
        linear_of(pair(WEIGHT))
    assert "\n" not in str(refused.value)


def test_the_name_of_the_base_is_its_own() -> None:
    """A joint may be called base: the row of the base's body has another name then, and motions are the same."""
    machine = pair()
    named = replace(machine, joints=(replace(machine.joints[0], name="base"), *machine.joints[1:]))
    assert modes(linear_of(named)).frequencies == pytest.approx(modes(linear_of(machine)).frequencies, rel=1e-14)


def test_commands(tmp_path: Path) -> None:
    file = tmp_path / "craft.toml"
    file.write_text(toml.write(pair()))
    text = CliRunner().invoke(cli, ["modes", str(file)], catch_exceptions=False).stdout
    assert "15.5" in text and "limited by load" in text
    words = ["linearize", str(file), "--input", "base.fx", "--output", "base.ax"]
    assert "base.x, base.y, base.z, base.rx" in CliRunner().invoke(cli, words, catch_exceptions=False).stdout
    words = ["response", str(file), "--input", "base.fz", "--output", "load.z"]
    assert "15.5" in CliRunner().invoke(cli, words, catch_exceptions=False).stdout
    with pytest.raises(InputError, match="not offered on a floating base"):
        CliRunner().invoke(cli, ["compare", str(file)], catch_exceptions=False)


def test_modes_over_positions(tmp_path: Path) -> None:
    """The arm that a motor turns carries the spring: the figures of a base that is free at each of its angles."""
    body = Body(cell(1), vector(0.5, 0, 0), (cell(0), cell(0), cell(0), cell(0.3), cell(0), cell(0.3)))
    motor = Joint("arm", 0, Kind.MOTOR, 0, "q_arm", d=cell(1), body=body)
    load = slide("load", 1, Kind.ELASTIC, M2, alpha=cell("pi/2"), spring=spring(K))
    machine = replace(pair(), joints=(motor, load))
    motion = motion_of(machine)
    states = [equilibrium(motion, {"arm": x}) for x in (0.0, 1.0)]
    wanted = [modes(with_motors(linearize(motion, state), held=["arm"])).frequencies for state in states]
    file = tmp_path / "craft.toml"
    file.write_text(toml.write(machine))
    words = ["modes", str(file), "--along", "arm=0:1:2", "--json", "--hold", "arm"]
    found = json.loads(CliRunner().invoke(cli, words, catch_exceptions=False).stdout)["frequencies"]
    for here, there in zip(found, wanted, strict=True):
        assert here[:6] == [0.0] * 6 and here == pytest.approx(there, rel=1e-12)
    assert abs(found[0][6] / found[1][6] - 1) > 0.1
