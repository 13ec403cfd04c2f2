"""Equilibrium: found where springs sag far, stable where there is a choice, refused where nothing supports a load."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from symoro_elastic.analysis.vibration.linearization import linearize
from symoro_elastic.analysis.vibration.modes import modes
from symoro_elastic.formats import read_machine
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.machine import Base, Body, Joint, Kind, Machine
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion, State
from symoro_elastic.numerics.motion.equilibrium import equilibrium, given_state
from tests.analysis.vibration.machines import NO_WEIGHT, WEIGHT, machine_of, modes_of, slide, spring
from tests.compiled_models import cell, vector
from tests.references.random_machines import chain, random_machine
from tests.references.small_motions import as_floats, differences

pytestmark = pytest.mark.sampled(4)
EXAMPLES = Path(__file__).parents[3] / "examples"


def pendulum(up: float = 0.0) -> Machine:
    """2 kg at 0.7 m on a passive joint, hanging (or, turned by pi, standing) at q = 0."""
    ball = Body(cell(2), vector(0, -1.4, 0), (cell(0.98), cell(0), cell(0), cell(0), cell(0), cell(0.98)))
    arm = Joint("arm", 0, Kind.PASSIVE, 0, "q1", alpha=cell("pi/2"), theta=cell(up), body=ball)
    return machine_of("pendulum", arm, base=WEIGHT)


def stiffness(motion: EquationsOfMotion, state: State) -> np.ndarray:
    sought = list(state.sought)
    return np.linalg.eigvalsh(motion.forces_and_stiffness(state.q)[1][np.ix_(sought, sought)])


def test_a_standing_pendulum_falls_unless_it_is_placed() -> None:
    motion = EquationsOfMotion(pendulum(np.pi))
    fallen = equilibrium(motion)
    assert abs(np.cos(fallen.q[0]) + 1) < 1e-14 and (stiffness(motion, fallen) > 0).all()
    standing = equilibrium(motion, {"arm": 0.0})
    assert abs(standing.q[0]) < 1e-14 and (stiffness(motion, standing) < 0).all()


def test_a_given_state_may_be_no_equilibrium() -> None:
    motion = EquationsOfMotion(pendulum())
    state = given_state(motion, {"arm": 0.5}, {"arm": 1.0})
    assert state.qdd[0] == pytest.approx(-9.81 / 0.7 * np.sin(0.5), rel=1e-12)
    above = modes(linearize(motion, given_state(motion, {"arm": np.pi})))
    assert above.frequencies[0] == 0.0 and above.growth[0] == pytest.approx(np.sqrt(9.81 / 0.7), rel=1e-12)
    assert modes_of(pendulum()).frequencies[0] == pytest.approx(np.sqrt(9.81 / 0.7) / (2 * np.pi), rel=1e-12)


@pytest.mark.thorough
def test_springs_that_sag_far() -> None:
    """Soft joints that carry 30 bodies: least squares alone end elsewhere, the potential energy leads on."""
    machine = random_machine(3, joints=30, kinds=("motor", "elastic", "fixed"), wrenches=False, friction=False)
    motion = EquationsOfMotion(machine)
    state = equilibrium(motion)
    turned = [abs(state.q[k]) for k in state.sought if motion.joints[k].sigma == 0]
    assert max(turned) > 0.5
    assert state.residual < 1e-10 * np.abs(state.tau).max()
    assert (stiffness(motion, state) > 0).all()


@pytest.mark.parametrize("seed", range(3))
def test_forces_are_the_slope_of_the_energy(seed: int) -> None:
    machine = random_machine(seed, joints=4, wrenches=False, friction=False)
    motion = EquationsOfMotion(machine)
    q = np.random.default_rng(seed).uniform(-1, 1, len(motion.joints))
    found = motion.forces(q, 0 * q, 0 * q)
    h = 1e-5
    slopes = [
        (motion.potential_energy(q + h * e) - motion.potential_energy(q - h * e)) / (2 * h) for e in np.eye(len(q))
    ]
    np.testing.assert_allclose(found, slopes, rtol=1e-7, atol=1e-6 * np.abs(found).max())
    assert as_floats(differences(lambda x: [y * y for y in x], [3.0])) == pytest.approx(6.0)


def test_torques_given_instead_of_positions() -> None:
    """A hanging load: gravity and a motor's force meet where the spring to the base lets them."""
    base = slide("base", 0, Kind.ELASTIC, 2, spring=spring(1e3))
    machine = machine_of("hanging", base, slide("motor", 1, Kind.MOTOR, 3), base=Base(gravity=vector(0, 0, -10)))
    state = equilibrium(EquationsOfMotion(machine), {"motor": 0.2}, {"motor": 30.0})
    np.testing.assert_allclose(state.q, [-0.05, 0.2], atol=1e-15)
    held = equilibrium(EquationsOfMotion(machine), {"motor": 0.2})
    np.testing.assert_allclose(held.tau, [0.0, 30.0], atol=1e-13)
    assert held.residual < 1e-13


def test_a_torque_that_holds_a_load_leaves_it_where_it_is() -> None:
    """A free motor that no spring holds: its weight tilts springs, so that its own stiffness is nearly zero."""
    motion = EquationsOfMotion(read_machine(EXAMPLES / "two_axis.toml")[0])
    held = equilibrium(motion)
    free = equilibrium(motion, {}, {"motor_y": float(held.tau[motion.index("motor_y", "")])})
    np.testing.assert_allclose(free.q, held.q, atol=1e-9)


def test_an_equilibrium_out_of_reach_is_refused() -> None:
    machine = machine_of("soft", slide("hanger", 0, Kind.ELASTIC, 3, spring=spring(0.1)), base=WEIGHT)
    with pytest.raises(InputError, match=r"there is none nearby: hanger = -294\.3 m would balance; give a spring"):
        equilibrium(EquationsOfMotion(machine))


def unsupported(kind: Kind, base: Base = WEIGHT) -> Machine:
    return machine_of("loose", slide("hanger", 0, kind, 3, spring=spring(0)), base=base)


@pytest.mark.parametrize("kind", [Kind.PASSIVE, Kind.ELASTIC])
def test_an_unsupported_load_is_named(kind: Kind) -> None:
    with pytest.raises(InputError) as error:
        equilibrium(EquationsOfMotion(unsupported(kind)))
    assert str(error.value).startswith("loose.toml: equilibrium: there is none: nothing supports hanger (29.43 N); ")
    assert list(modes_of(unsupported(kind, NO_WEIGHT)).eigenvalues) == [0.0]


def test_a_level_pendulum_hangs_where_it_is_balanced() -> None:
    """Its weight has no slope where it stands out level: r = m g l cos q, K = 0 at q = 0."""
    body = Body(cell(2), vector(0.6, 0, 0))
    swing = Joint("swing", 0, Kind.PASSIVE, 0, "q1", body=body)
    machine = machine_of("level", swing, base=Base(gravity=vector(0, -9.81, 0)))
    state = equilibrium(EquationsOfMotion(machine))
    np.testing.assert_allclose(state.q, [-np.pi / 2], atol=1e-12)


def test_a_load_on_a_slide_that_only_tilts() -> None:
    """A passive turn with a slide on it and no spring at all."""
    turn = Joint("turn", 0, Kind.PASSIVE, 0, "q1", alpha=cell("pi/2"))
    machine = machine_of("tilting", turn, slide("weight", 1, Kind.PASSIVE, 2, alpha=cell("pi/2")), base=WEIGHT)
    with pytest.raises(
        InputError, match=r"tilting\.toml: equilibrium: none was found from here: nothing supports weight"
    ):
        equilibrium(EquationsOfMotion(machine))


def test_a_machine_without_moving_joints() -> None:
    bolted = machine_of("bolted", Joint("plate", 0, Kind.FIXED, 2, body=Body(cell(2))))
    assert len(modes_of(bolted).eigenvalues) == 0


@pytest.fixture
def evaluated(monkeypatch: pytest.MonkeyPatch) -> list[np.ndarray]:
    """Positions at which forces and stiffness were computed: what a search costs."""
    positions: list[np.ndarray] = []
    compute = EquationsOfMotion.forces_and_stiffness

    def counted(motion: EquationsOfMotion, q: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        positions.append(q)
        return compute(motion, q)

    monkeypatch.setattr(EquationsOfMotion, "forces_and_stiffness", counted)
    return positions


@pytest.mark.thorough
def test_a_long_soft_chain_takes_few_evaluations(evaluated: list[np.ndarray]) -> None:
    motion = EquationsOfMotion(chain(60, elastic=tuple(range(2, 61, 2))))
    state = equilibrium(motion)
    assert len(evaluated) < 100
    assert (stiffness(motion, state) > 0).all()


@pytest.mark.thorough
def test_a_slide_that_falls_is_given_up_early(evaluated: list[np.ndarray]) -> None:
    machine = random_machine(3, joints=30, symbolic=True, friction=False, wrenches=False)
    with pytest.raises(InputError, match=r"none was found from here: nothing supports joint2 .*, joint7"):
        equilibrium(EquationsOfMotion(machine))
    assert len(evaluated) < 200
