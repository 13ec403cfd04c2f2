"""Springs in series with massless bodies between: one spring is exactly what a mass that vanishes leaves of two."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import mpmath
import pytest

from symoro_elastic.formats import read_machine
from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import generate, zero_pivots
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.machine import Body, Friction, Joint, Kind, Machine
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.series_springs import condense, springs_in_series
from symoro_elastic.models.checks.degenerate import degeneracies
from symoro_elastic.numerics.verification.verify import verify
from tests.command_line import ended
from tests.compiled_models import cell as f
from tests.references import multiprecision as reference

EXAMPLES = Path(__file__).parents[2] / "examples"
CONDENSE = Scene(condense=True)
STIFF, SOFT = 700, 300

TEXT = """
name = "series"
gravity = [1.0, -9.81, 2.0]
joints = [
  {{ name = "lift",  kind = "motor",   sigma = 1, alpha = 0.3, r = "q1" }},
  {{ name = "first", kind = "elastic", sigma = {sigma}, gamma = 0.4, alpha = 1.1, d = 0.2, {cell} = "q2 + 0.2" }},
  {{ name = "plate", kind = "fixed",   gamma = 0.7, b = 0.05, alpha = "{plate}", d = {d}, theta = 0.3, r = 0.2 }},
  {{ name = "last",  kind = "elastic", sigma = {sigma}, gamma = 0.2, b = 0.3, alpha = "{alpha}", {cell} = "q3 - 0.1" }},
  {{ name = "hand",  kind = "passive", sigma = 0, alpha = 0.9, d = 0.3, theta = "q4" }},
]
[bodies]
lift = {{ mass = 3 }}
last = {{ mass = 2, center_of_mass = [0.1, 0.2, 0.3], inertia = [0.1, 0.2, 0.3] }}
hand = {{ mass = 1, center_of_mass = [0.2, 0.1, 0], inertia = [0.02, 0.03, 0.04] }}
[springs]
first = {{ stiffness = 700, damping = {damping}, neutral = 0.03 }}
last  = {{ stiffness = 300, damping = {other}, neutral = -0.05 }}
"""
CASES = {
    "revolute": {"sigma": 0},
    "revolute, turned over": {"sigma": 0, "alpha": "pi"},
    "revolute, turned over twice": {"sigma": 0, "alpha": "-pi", "plate": "pi"},
    "prismatic, apart": {"sigma": 1, "d": 0.4},
    "prismatic, turned over": {"sigma": 1, "d": 0.4, "plate": "pi"},
    "damped": {"sigma": 0, "damping": 7, "other": 3},
    "prismatic, damped": {"sigma": 1, "alpha": "pi", "damping": 7, "other": 3},
}


def series(**cells: object) -> Machine:
    given = {"alpha": "0", "plate": "0", "d": 0, "damping": 0, "other": 0, **cells}
    return toml.read(TEXT.format(cell="theta" if given["sigma"] == 0 else "r", **given), "series.toml")


@pytest.mark.parametrize("case", CASES)
def test_one_spring_moves_as_two_do(case: str) -> None:
    """In 50 digits: the massless body splits x so that both springs, and dampers, exert the same force.

    With q_j, qd_j of that split, A qdd + H = Gamma of the whole machine holds on the tool side for the condensed qdd,
    and the force on the massless body is zero.
    """
    whole = series(**CASES[case])
    one = condense(whole).machine
    ((sign, first, last),) = [(s.sign, s.first, s.last) for s in springs_in_series(whole)]
    kept, j, k = one.independent.index(last), whole.independent.index(first), whole.independent.index(last)
    q, qd, tau = [0.2, 0.11, -0.4], [0.5, -0.3, 0.8], [4.0]
    with mpmath.workdps(50):
        qdd = [mpmath.mpf(x) for x in reference.direct_dynamics(one, q, qd, tau)]
        split = _both(q[kept], "0.03", "-0.05", sign), _both(qd[kept], "0", "0", sign), _both(qdd[kept], "0", "0", sign)
        rows = [[*x[:kept], *pair, *x[kept + 1 :]] for x, pair in zip((q, qd, qdd), split, strict=True)]
        needed = reference.generalized_forces(whole, *rows)
        laws = [
            -stiffness * (rows[0][i] - mpmath.mpf(neutral)) - damping * rows[1][i]
            for i, stiffness, neutral, damping in (
                (j, STIFF, "0.03", CASES[case].get("damping", 0)),
                (k, SOFT, "-0.05", CASES[case].get("other", 0)),
            )
        ]
        assert (j, k) == (kept, kept + 1)
        wanted = [tau[0], *laws, 0]
        scale = max(map(abs, wanted))
        assert max(abs(a - b) for a, b in zip(needed, wanted, strict=True)) < scale * mpmath.mpf(10) ** -40
        assert min(map(abs, laws)) > 1e-3


def _both(x: float, first: str, last: str, sign: int) -> tuple[mpmath.mpf, mpmath.mpf]:
    """q_j and q_k with q_k + s q_j = x and k_j (q_j - n_j) = s k_k (q_k - n_k)."""
    n_j, n_k = mpmath.mpf(first), mpmath.mpf(last)
    stretch = mpmath.mpf(x) - n_k - sign * n_j
    return n_j + sign * stretch * SOFT / (STIFF + SOFT), n_k + stretch * STIFF / (STIFF + SOFT)


@pytest.mark.parametrize("case", list(CASES)[:5])
def test_frames_are_those_of_the_sum(case: str) -> None:
    whole = series(**CASES[case])
    ((sign, first, _),) = [(s.sign, s.first, s.last) for s in springs_in_series(whole)]
    wanted = reference.geometric_model(whole, [0.2, 0.25, -0.125, 0.5])
    found = reference.geometric_model(condense(whole).machine, [0.2, sign * 0.25 - 0.125, 0.5])
    beyond = range(3, len(whole.joints))
    assert first == 2
    assert max(abs(found[i][m][n] - wanted[i][m][n]) for i in beyond for m in range(4) for n in range(4)) < 1e-40


def test_a_small_mass_between_approaches_the_condensed_machine() -> None:
    """Accelerations averaged over the split: with mass m between, A qdd + H - Gamma beyond it changes as m."""
    whole = series(sigma=1, d=0.4)
    assert zero_pivots(whole, Scene()) and not zero_pivots(whole, CONDENSE)
    one = condense(whole).machine
    q, qd, tau = [0.2, 0.11, -0.4], [0.5, -0.3, 0.8], [4.0]
    x, v = _both(q[1], "0.03", "-0.05", 1), _both(qd[1], "0", "0", 1)
    wanted = reference.direct_dynamics(one, q, qd, tau)
    errors = []
    for mass in ("1e-6", "1e-9"):
        joints = [replace(r, body=Body(f(mass))) if r.name == "first" else r for r in whole.joints]
        heavy = replace(whole, joints=tuple(joints))
        found = reference.direct_dynamics(heavy, [q[0], *x, q[2]], [qd[0], *v, qd[2]], tau)
        sums = [found[0], found[1] + found[2], found[3]]
        errors.append(max(abs(a - b) for a, b in zip(sums, wanted, strict=True)))
    assert errors[1] < 2e-3 * errors[0] < 1e-6


def test_three_springs_become_one() -> None:
    whole = series(sigma=0)
    third = replace(whole.joints[1], name="second", antecedent=2, variable="q9", alpha=f(0), d=f(0))
    rows = [*whole.joints[:2], third, *(replace(r, antecedent=r.antecedent + 1) for r in whole.joints[2:])]
    machine = replace(whole, joints=tuple(rows))
    found = condense(machine)
    spring = next(joint for joint in found.machine.joints if joint.name == "last").spring
    assert spring.stiffness.value() == pytest.approx(1 / (1 / 700 + 1 / 700 + 1 / 300), rel=1e-15)
    assert spring.neutral.value() == pytest.approx(0.01, rel=1e-13)
    assert len(found.notes) == 2 and degeneracies(found.machine, False) == []


def test_symbols_stay_and_code_is_within_rounding() -> None:
    """The printed table of the paper, if its axes are meant to be parallel."""
    machine, _ = read_machine(EXAMPLES / "two_axis_printed.par")
    found = condense(machine)
    assert found.notes == (
        "bed_y and bed_x are in series: bed_x is bed_x + bed_y with k1 k2/(k1 + k2), bed_y is fixed",
        "cart_x and cart_y are in series: cart_y is cart_y + cart_x with k1 k2/(k1 + k2), cart_x is fixed",
    )
    springs = {joint.name: joint.spring.stiffness for joint in found.machine.joints}
    assert springs["bed_x"].value({"k2": 3.0, "k3": 6.0}) == 2.0
    assert verify(machine, CONDENSE, states=(4, 4)).ok


def test_generated_code_says_what_was_condensed(tmp_path: Path) -> None:
    machine = series(sigma=0, alpha="pi")
    generate(machine, CONDENSE, ["c", "numpy"], tmp_path)
    for file in ("series.h", "__init__.py"):
        said = " ".join((tmp_path / "series" / file).read_text().replace(" * ", " ").split())
        assert "first and last are in series: last is last - first with k1 k2/(k1 + k2), first is fixed" in said


def test_commands_say_what_was_condensed(tmp_path: Path) -> None:
    (tmp_path / "scene.toml").write_text("condense = true\n")
    for command in (("generate", "--out", tmp_path / "made"), ("show",)):
        name, *options = command
        done = ended(name, EXAMPLES / "two_axis_printed.par", "--scene", tmp_path / "scene.toml", *options)
        said = [line for line in done.err.splitlines() if line.startswith("note: ")]
        assert done.code == 0 and [line.split()[1] for line in said] == ["bed_y", "cart_x"]
    assert "no degenerate joints" in done.out


def changed(machine: Machine, name: str, **cells: object) -> Machine:
    joints = tuple(replace(joint, **cells) if joint.name == name else joint for joint in machine.joints)
    return replace(machine, joints=joints)


def hanging(machine: Machine) -> Machine:
    extra = Joint("probe", 2, Kind.FIXED, 2)
    return replace(machine, joints=(*machine.joints, extra))


OTHERS = {
    "axes that are not parallel": series(sigma=0, alpha="0.3"),
    "revolute axes apart": series(sigma=0, d=0.1),
    "a mass between": changed(series(sigma=0), "plate", body=Body(f(1))),
    "a rotor": changed(series(sigma=0), "last", rotor_inertia=f("0.1")),
    "something else on the body between": hanging(series(sigma=0)),
    "a passive joint": changed(series(sigma=0), "last", kind=Kind.PASSIVE),
}


@pytest.mark.parametrize("case", OTHERS)
def test_what_is_no_series_is_left_alone(case: str) -> None:
    machine = OTHERS[case]
    assert condense(machine).machine == machine and list(springs_in_series(machine)) == []


INEXACT = {
    "not the same at first and at last": series(sigma=0, damping=7, other=4),
    "friction acts on last": changed(series(sigma=0), "last", friction=Friction(viscous=f(1))),
    "the spring of first has no stiffness": changed(
        series(sigma=0), "first", spring=replace(series(sigma=0).joints[1].spring, stiffness=f(0))
    ),
    "the cells of joint 5 (hand) hold q2": changed(series(sigma=0), "hand", theta=f("0.5*q2")),
}


@pytest.mark.parametrize("reason", INEXACT)
def test_what_is_not_exact_is_refused_with_the_reason(reason: str) -> None:
    machine = INEXACT[reason]
    assert condense(machine).machine == machine
    ((message, _),) = zero_pivots(machine, CONDENSE)
    assert reason in message and "\n" not in message


def test_the_refusal_offers_it() -> None:
    ((message, joints),) = zero_pivots(series(sigma=0), Scene())
    assert joints == "joint 2, joint 4" and "k1 k2/(k1 + k2) (condense = true in a scene does it)" in message


@pytest.mark.parametrize("format_", [toml, par], ids=["toml", "par"])
def test_scenes_survive_writing(format_) -> None:
    for static in ({"first": None, "last": None}, {"first": f("1e-6"), "last": f("-2*pi")}):
        machine = DescribedMachine.of(series(sigma=0))
        machine = machine.asking(scene=Scene(static=static, condense=True, source="series.toml"))
        again = format_.read(format_.write(machine), "series.toml").asked.scene
        assert again.static == static and again.condense


def test_a_condensed_joint_cannot_be_static() -> None:
    scene = Scene(static={"first": None}, condense=True)
    with pytest.raises(InputError, match="scene, static, first: the joint is fixed"):
        restrict(series(sigma=0), scene)
    kept = restrict(series(sigma=0), replace(scene, static={"last": None}))
    assert [joint.name for joint in kept.static.values()] == ["last"]
