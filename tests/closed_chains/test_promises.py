"""Operation counts and work of generation, limits of stiff springs, loops cut elsewhere, SYMORO's SR400 as written."""

from __future__ import annotations

import re
from collections.abc import Mapping
from dataclasses import replace
from typing import Any

import numpy as np
import pytest

from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.machine import Friction, Joint, Kind, Machine, Spring
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.loops.plan import Form
from symoro_elastic.models.programs.catalogue import trace
from symoro_elastic.numerics.verification.implementations import numpy_model
from symoro_elastic.symbolic.arithmetic import FLOATS, evaluate
from symoro_elastic.symbolic.expression import Level, reachable
from symoro_elastic.symbolic.program import Section, count
from tests.closed_chains.machines import FILES, in_order, machine, situations
from tests.closed_chains.test_models import assert_near, computed, package_of, reference
from tests.counted_calls import calls_of
from tests.references.closed_chains import Chain

pytestmark = pytest.mark.sampled(6)

BY_INERTIA_MATRIX = "direct_dynamics_by_inertia_matrix"
RIGID_AXIS = """
gravity = [0, 0, -9.81]
joints = [
  { name = "motor", antecedent = 0, kind = "motor", sigma = 0, alpha = "pi/2", theta = "qm" },
  { name = "screw", antecedent = 0, kind = "coupled", sigma = 0, alpha = "pi/2", d = 0.1, theta = "Rm/Rv*qm" },
  { name = "nut", antecedent = 0, kind = "coupled", sigma = 1, alpha = "pi/2", d = 0.1, r = "pitch/(2*pi)*Rm/Rv*qm" },
  { name = "table", antecedent = "nut", kind = "elastic", sigma = 1, r = "d_table" },
  { name = "encoder", antecedent = "table", kind = "elastic", sigma = 1, r = "d_encoder" },
]
[parameters]
Rm = { value = 0.03 }
Rv = { value = 0.045 }
pitch = { value = 0.02 }
[bodies]
motor = { mass = 3.0, first_moments = [0, 0, 0], inertia_at_origin = [0.003, 0, 0, 0.003, 0, 0.0042] }
screw = { mass = 11.8, first_moments = [0, 0, 0], inertia_at_origin = [0, 0, 0, 0, 0, 0.0049] }
nut = { mass = 5, first_moments = [0, 0, 0], inertia_at_origin = [0, 0, 0, 0, 0, 0] }
table = { mass = 400, first_moments = [0, 0, 0], inertia_at_origin = [0, 0, 0, 0, 0, 0] }
encoder = { mass = 0.4, first_moments = [0, 0, 0], inertia_at_origin = [0, 0, 0, 0, 0, 0] }
[springs]
table = { stiffness = 400000000.0 }
encoder = { stiffness = 40000000.0 }
"""
"""The ball-screw axis with a rigid belt, screw and nut."""

# Operations


@pytest.mark.parametrize(
    ("name", "model", "products", "sums"),
    [
        ("sr400", BY_INERTIA_MATRIX, 562, 542),
        ("sr400", "inverse_dynamics", 371, 374),
        ("parallelogram_loop", BY_INERTIA_MATRIX, 300, 312),
        ("parallelogram_loop", "inverse_dynamics", 289, 281),
        ("five_bar", BY_INERTIA_MATRIX, 205, 164),
        ("delta", BY_INERTIA_MATRIX, 693, 448),
        ("delta", "dependent_coordinates", 86, 46),
        ("ball_screw", "direct_dynamics", 30, 23),
        ("rigid_axis", "direct_dynamics", 10, 6),
    ],
)
def test_operations_of_a_call(name: str, model: str, products: int, sums: int) -> None:
    """At most as many as those of a prototype of the equations; products and divisions together.

    The delta takes what it took while its legs were assembled (695, 447), the closed forms included.
    """
    described = toml.read(RIGID_AXIS, "rigid_axis.toml") if name == "rigid_axis" else machine(name)
    outputs = trace(described, model).program.outputs
    found = count(reachable(x for output in outputs for x in output.entries), Level.STATE)
    assert 0 < found.products <= products
    assert 0 < found.add <= sums


def test_what_closes_a_loop_has_sections_and_names_of_its_own() -> None:
    program = trace(machine("five_bar"), "direct_dynamics").program
    positions, rates = (
        {one.name for one in program.statements if one.section == Section(f"Closed loop: {what}", 7, equations)}
        for what, equations in (("positions", "(L12)"), ("rates", "(L10), (L11)"))
    )
    assert {"root7_loop", "cos3_theta", "sin6_theta"} <= positions
    assert {"W7_inverse", "S3_1", "S6_4", "phi7_1", "gam3_x", "rate6_x"} <= rates
    newton = trace(machine("ring"), "assemble").program.statements
    assert {one.section.title for one in newton} == {f"Newton's method (L18), step {k}" for k in range(1, 6)} | {
        "Results"
    }


@pytest.mark.sampled(12)
@pytest.mark.parametrize("name", FILES)
def test_direct_and_inverse_models_are_traced_in_few_calls(name: str) -> None:
    """Loops are planned again, for the copy is a machine of its own."""
    fresh = replace(machine(name))

    def work() -> None:
        trace(fresh, "direct_dynamics")
        trace(fresh, "inverse_dynamics")

    assert calls_of(work) < 2_000_000


# One machine, two tables


@pytest.mark.sampled(12)
@pytest.mark.parametrize(
    ("one", "other"),
    [("press", "press_cut_at_crank"), ("parallelogram", "parallelogram_loop"), ("coaxial_rigid", "coaxial_geared")],
)
@pytest.mark.parametrize("model", ["direct_dynamics", BY_INERTIA_MATRIX, "inverse_dynamics"])
def test_programs_of_two_tables_of_one_machine(one: str, other: str, model: str) -> None:
    """Cut elsewhere, closed by a loop or by a coupling, geared one to one or rigid: to 1e-12."""
    for k in range(2):
        wanted = by_variable(one, k, computed(one, k, model))
        chain, known = reference(other, k).chain, reference(one, k).chain
        situation = situations(one)[k]
        more = {
            "q": in_order(situation.state.u, known.independent, chain.independent),
            "qd": in_order(situation.state.ud, known.independent, chain.independent),
            "tau": in_order(situation.tau, known.motors, chain.motors),
            "qdd_motor": in_order(situation.qdd_motor, known.motors, chain.motors),
        }
        found = by_variable(other, k, computed(other, k, model, **more))
        assert found.keys() == wanted.keys()
        largest = {result: max(abs(x) for key, x in wanted.items() if key[0] == result) for result, _ in wanted}
        for key, x in wanted.items():
            assert abs(found[key] - x) < 1e-12 * largest[key[0]], key


def by_variable(name: str, k: int, results: Mapping[str, Any]) -> dict[tuple[str, str], float]:
    chain = reference(name, k).chain
    names = {"qdd": chain.independent, "tau": chain.motors}
    return {
        (result, variable): float(x)
        for result, entries in results.items()
        for variable, x in zip(names[result], entries, strict=True)
    }


@pytest.mark.parametrize(
    ("name", "dependent"),
    [
        ("four_bar", ("crank", "coupler")),
        ("four_bar", ("crank", "rocker")),
        ("sr400", ("b2", "b3")),
        ("sr400", ("b3", "b7")),
        ("sr400", ("b7", "b8")),
    ],
)
def test_other_joints_of_a_loop_may_depend(name: str, dependent: tuple[str, str]) -> None:
    """Motors too: accelerations of all independent variables in the same state, under the same torques."""
    whole, known, situation = machine(name), reference(name, 0), situations(name)[0]
    other = replace(whole, loops=(replace(whole.loops[0], dependent=dependent),))
    chain, rates = Chain(other), dict(zip(known.chain.own, known.xd, strict=True))
    q, qd = ([float(x[variable]) for variable in chain.independent] for x in (known.at, rates))
    found = package_of(other, "direct_dynamics")[0].direct_dynamics(q, qd, situation.tau)
    wanted = dict(zip(known.chain.own, known.direct(situation.tau), strict=True))
    assert chain.motors == known.chain.motors
    assert_near(name, found, [wanted[variable] for variable in chain.independent])


# Stiff springs


def stiff_gear(stiffness: float | None) -> Machine:
    """The coupled wrist; its elastic gear is this stiff, or rigid."""

    def changed(joint: Joint) -> Joint:
        if joint.name != "link_2":
            return joint
        if stiffness is None:
            rigid = Formula.parse("qm2/N2")
            return replace(joint, kind=Kind.COUPLED, theta=rigid, variable=None, spring=Spring(), friction=Friction())
        return replace(joint, spring=Spring(Formula.parse(stiffness)), friction=Friction())

    described = machine("coupled_wrist")
    return replace(described, joints=tuple(map(changed, described.joints)))


def settled(direct: Any, given: dict[str, Any], entry: int, stiffness: float) -> Any:
    """Accelerations where the deflection at this entry has none: found by its equation, which is all but linear."""
    q, other = np.array(given["q"]), 1e3 / stiffness
    q[entry] = 0.0
    first = direct(**{**given, "q": q})[entry]
    for _ in range(4):
        at = q.copy()
        at[entry] += other
        second = direct(**{**given, "q": at})[entry]
        if second == first:
            break
        q, first, other = at, second, -other * second / (second - first)
    return direct(**{**given, "q": q})


def test_a_stiff_gear_tends_to_a_rigid_one() -> None:
    """Where the deflection stays, the error of the other accelerations falls as 1/k, down to rounding."""
    situation, chain = situations("coupled_wrist")[0], Chain(machine("coupled_wrist"))
    entry = chain.independent.index("q2")
    others = [k for k in range(len(chain.independent)) if k != entry]
    u, ud = np.array(situation.state.u), np.array(situation.state.ud)
    ud[entry] = 0.0
    rigid = package_of(stiff_gear(None), "direct_dynamics")[0].direct_dynamics(u[others], ud[others], situation.tau)
    errors = {}
    for stiffness in (1e6, 1e8, 1e10, 1e12):
        direct = package_of(stiff_gear(stiffness), "direct_dynamics")[0].direct_dynamics
        qdd = settled(direct, {"q": u, "qd": ud, "tau": situation.tau}, entry, stiffness)
        errors[stiffness] = np.abs(qdd[others] - rigid).max() / np.abs(rigid).max()
    assert 0 < errors[1e6] < 1e-6
    for stiffness in (1e8, 1e10, 1e12):
        assert abs(errors[stiffness] * stiffness - errors[1e6] * 1e6) < 1e-3 * errors[1e6] * 1e6


# SYMORO's SR400


SR400 = par.write(machine("sr400"))
START, DEPENDENT = r", start = \{[^}]*\}", r', dependent = \["b3", "b8"\]'
VALUES = r"^\(\*toml (?:\[parameters\]|\w+ *= [\d.]+) \*\)\n"


@pytest.mark.parametrize("without", [(START,), (START, DEPENDENT), (START, DEPENDENT, VALUES)])
def test_the_sr400_of_symoro_closes_as_a_parallelogram(without: tuple[str, ...]) -> None:
    """Without a start, without names of the joints that depend, and without values of its lengths."""
    text = SR400
    for words in without:
        text, changes = re.subn(words, "", text, flags=re.MULTILINE)
        assert changes == (6 if words == VALUES else 1)
    bound = Bound(par.read(text, "sr400.par"))
    assert [loop.form for loop in bound.loops] == [Form.MAP]
    assert [bound.machine.joint(j).name for j in bound.machine.dependent] == ["b3", "b8"]
    for th2, th7 in ((-1.0, 0.3), (0.4, 0.4), (-2.6, 1.5)):
        value = evaluate([bound.variables[j] for j in bound.machine.dependent], {"th2": th2, "th7": th7}, FLOATS)
        th3, th8 = (value(bound.variables[j]) for j in bound.machine.dependent)
        assert abs(th3 - (th7 - th2 - np.pi / 2)) < 1e-15 * 8
        assert abs(th8 - (th2 - th7)) < 1e-15 * 8


@pytest.mark.parametrize("turned", [2.1, -4.2, 8.4])
def test_angles_of_dependent_joints_go_on_across_half_a_turn(turned: float) -> None:
    """A rocker whose angle is counted from elsewhere: its own variable is the same, through odd half turns too."""
    described = machine("four_bar")
    counted = {"rocker": {"theta": Formula.parse(turned)}, "pin_end": {"gamma": Formula.parse(-turned)}}
    rows = (replace(row, **counted.get(row.name, {})) for row in described.joints)
    crank = np.linspace(0.3, 1.6, 27)
    q = np.stack([crank, 0 * crank], axis=1)
    usual, other = (
        numpy_model(one, ("dependent_coordinates",)).dependent_coordinates(q)
        for one in (described, replace(described, joints=tuple(rows)))
    )
    np.testing.assert_allclose(other, usual, rtol=0, atol=1e-13)
    angles = usual[:, described.with_variable.index(3)] + turned
    assert len({*np.round(angles / (2 * np.pi))}) == 2
