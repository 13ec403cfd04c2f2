"""Two tables of one machine have one motion: cut elsewhere, rows in another order, coupled or closed by a loop."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.loops.plan import plan_of
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from tests.closed_chains.machines import Situation, in_order, machine, reordered, situations
from tests.closed_chains.test_references import worst
from tests.references.closed_chains import Chain, State
from tests.references.constraint_multipliers import Multipliers, free_tree

pytestmark = pytest.mark.sampled(5)

SAME = [
    ("press", "press_cut_at_crank"),
    ("parallelogram_loop", "parallelogram"),
    ("coaxial_geared", "coaxial_rigid"),
]  # fmt: skip
REORDERED = ("geared_6r", "coupled_wrist", "five_bar", "palletizer", "press")
CLOSED_AT_POINTS = ("delta", "spatial_four_bar", "five_bar", "sr400", "two_jack_arm")


def motion(described: Machine, like: Machine, situation: Situation) -> dict[str, Any]:
    """Accelerations by variable, with u, ud and tau in the order of another table of the machine."""
    chain, known = Chain(described), Chain(like)

    u, ud = (in_order(part, known.independent, chain.independent) for part in (situation.state.u, situation.state.ud))
    found = Multipliers(described, State(u, ud, situation.state.guess))
    direct = found.direct(in_order(situation.tau, known.motors, chain.motors))
    tau, inverse = found.inverse(in_order(situation.qdd_motor, known.motors, chain.motors))
    results = {f"direct {name}": value for name, value in zip(chain.own, direct, strict=True)}
    results |= {f"inverse {name}": value for name, value in zip(chain.own, inverse, strict=True)}
    return results | {f"tau {name}": value for name, value in zip(chain.motors, tau, strict=True)}


def assert_same(one: Machine, other: Machine, situation: Situation, guess: Any = None) -> None:
    state = State(situation.state.u, situation.state.ud, guess or situation.state.guess)
    a = motion(one, one, situation)
    b = motion(other, one, Situation(state, situation.tau, situation.qdd_motor))
    common = sorted(a.keys() & b.keys())
    assert len(common) >= 2 * len(Chain(one).independent)
    assert worst([a[name] for name in common], [b[name] for name in common]) < 1e-45


@pytest.mark.parametrize(("one", "other"), SAME)
def test_two_tables_of_one_machine(one: str, other: str) -> None:
    for k, situation in enumerate(situations(one)):
        guess = situations(other)[k].state.guess if one == "press" else None
        assert_same(machine(one), machine(other), situation, guess)


@pytest.mark.parametrize("name", REORDERED)
def test_rows_in_another_order(name: str) -> None:
    other = reordered(machine(name))
    assert [joint.name for joint in other.joints] != [joint.name for joint in machine(name).joints]
    assert_same(machine(name), other, situations(name)[0])


@pytest.mark.parametrize("name", CLOSED_AT_POINTS)
def test_against_pinocchio(name: str) -> None:
    """Loops that hold where two points meet, in space or in a plane; no cell of these holds other variables."""
    pytest.importorskip("pinocchio")
    from tests.references import pinocchio_model

    for situation in situations(name):
        found = Multipliers(machine(name), situation.state)
        chain = found.chain
        forces = found._passive_forces() + chain.spread_motors(situation.tau)
        met = [(loop.cut, loop.meets) for loop in chain.machine.loops]
        entries = [chain.articulated.index(j - 1) for j in chain.machine.with_variable]
        assert entries == list(range(len(chain.own)))
        state = (part.astype(float) for part in (found.z[found.coupled_entries], found.xd, forces))
        qdd = pinocchio_model.constraint_dynamics(free_tree(chain, cut_joints=False), met, *state)
        wanted = found.direct(situation.tau).astype(float)
        assert np.abs(qdd - wanted).max() < 1e-13 * np.abs(wanted).max()


def test_loops_that_need_each_other_are_closed_together() -> None:
    """A delta in coordinates of its motors, of which each leg names one slide of the platform: S = -W_d^-1 W_u."""
    delta = machine("delta")
    names = [(slide, f"cross_{k}", f"rod_{k}") for k, slide in enumerate(("along_x", "along_y", "platform"), start=1)]
    loops = [replace(loop, dependent=dependent) for loop, dependent in zip(delta.loops, names, strict=True)]
    described = replace(delta, loops=tuple(loops))
    bound, plan = Bound(described), plan_of(described)
    assert len(bound.coordinates.blocks) == 1
    _, W = plan.assembly.numbers(plan.positions[0])
    free, given = (
        [described.with_variable.index(j) for j in joints] for joints in (described.independent, described.dependent)
    )
    entries = [bound.coordinates.S_x[j].get(k, 0) for j in described.dependent for k in described.independent]
    value = evaluate(entries, plan.assembly.symbols(plan.positions[0]), FLOATS)
    slopes = np.array([float(value(x)) for x in entries]).reshape(len(given), len(free))
    np.testing.assert_allclose(slopes, -np.linalg.solve(W[:, given], W[:, free]), rtol=0, atol=1e-13)
