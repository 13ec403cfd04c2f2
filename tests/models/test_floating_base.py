"""A base with six degrees of freedom, turned by a rotation matrix or a unit quaternion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace
from fractions import Fraction
from pathlib import Path
from typing import Any

import mpmath
import numpy as np
import pytest

from symoro_elastic.formats.par import reading as par
from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import zero_pivots
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.formula import ZERO
from symoro_elastic.machine.machine import Base, Body, Floating, Joint, Kind, KnownOfBase, Machine, Orientation
from symoro_elastic.machine.scene import Scene
from symoro_elastic.mechanics.base_body import rotation_of
from symoro_elastic.models.kinematics.geometric import STATIC_SPRINGS
from symoro_elastic.models.kinematics.inverse_kinematic import INVERSE_KINEMATIC
from symoro_elastic.models.programs.catalogue import MODELS, trace
from symoro_elastic.numerics.verification.verify import verify
from symoro_elastic.symbolic.arithmetic import evaluate, multiprecision
from tests.compiled_models import Array, Built, built, cell, vector, worst
from tests.references.random_machines import ALL_KINDS, chain, random_machine, random_state, two_children

TOLERANCE = 1e-12
XX, XY, XZ, YY, YZ, ZZ = (cell(x) for x in (0.9, 0.05, -0.1, 1.1, 0.07, 1.3))
HULL = Body(cell(7.5), vector(0.6, -0.4, 0.9), (XX, XY, XZ, YY, YZ, ZZ))
OFFERED = tuple(name for name, model in MODELS.items() if model.on_base is not None)
BOTH = (KnownOfBase.WRENCH, KnownOfBase.ACCELERATION)


def on(
    machine: Machine,
    known: KnownOfBase = KnownOfBase.WRENCH,
    body: Body = HULL,
    turned: Orientation = Orientation.ROTATION,
) -> Machine:
    """The machine on a floating base; the base of its file keeps its gravity."""
    return replace(machine, floating=Floating(turned, known, body), base=Base(machine.base.gravity))


def damped(machine: Machine) -> Machine:
    """The machine with dampers between its base and what is around it."""
    assert machine.floating
    floating = replace(machine.floating, linear_damping=cell(0.7), angular_damping=cell(0.4))
    return replace(machine, floating=floating)


def base_state(seed: int) -> dict[str, Array]:
    """R0, Q0, P0, V0, V0d, f0 at random."""
    rng = np.random.default_rng([seed, 6])
    quaternion = rng.normal(size=4)
    quaternion /= np.linalg.norm(quaternion)
    drawn = {name: rng.uniform(-2, 2, 6) for name in ("V0", "V0d", "f0")}
    return drawn | {"R0": np.ravel(rotation_of(quaternion)), "Q0": quaternion, "P0": rng.uniform(-2, 2, 3)}


def asked(state: dict[str, Any], *names: str) -> dict[str, Any]:
    """Some of the arguments."""
    return {name: state[name] for name in names}


def joint_state(machine: Machine, seed: int) -> dict[str, Array]:
    q, qd, u = map(np.array, random_state(machine, seed))
    return {"q": q, "qd": qd, "tau": u, "qdd_motor": u / 4}


def runs(code: Built) -> tuple[Callable[..., tuple[Array, ...]], ...]:
    return code.both()


# Against Pinocchio's free-flyer


@pytest.mark.sampled(5)
@pytest.mark.parametrize("seed", range(4))
def test_against_pinocchio(seed: int, tmp_path: Path) -> None:
    """Random trees of motors: `rnea`, `aba` and `crba` with a free-flyer that carries a body."""
    pinocchio = pytest.importorskip("pinocchio") and pytest.importorskip("tests.references.pinocchio_model")
    machine = random_machine(seed, joints=4 + 2 * seed, kinds=("motor", "fixed"), friction=False)
    turned = tuple(Orientation)[seed % 2]
    codes = {known: built(on(machine, known, turned=turned), tmp_path / known) for known in BOTH}
    base, state = base_state(seed), joint_state(machine, seed)
    R, moved = base["R0"].reshape(3, 3), (base["V0"], base["V0d"])
    forces, A, accelerations = pinocchio.floating_dynamics(
        codes and on(machine), pinocchio.BaseState(R, *moved), state["q"], state["qd"], state["qdd_motor"]
    )
    at = asked(state, "q", "qd") | asked(base, "V0", "Q0" if seed % 2 else "R0")
    for free, driven in zip(runs(codes[KnownOfBase.WRENCH]), runs(codes[KnownOfBase.ACCELERATION]), strict=True):
        assert worst(free("inertia_matrix", q=state["q"])[0], A) < TOLERANCE
        tau, _, f0 = driven("inverse_dynamics", **at, qdd_motor=state["qdd_motor"], V0d=base["V0d"])
        assert worst([*f0, *tau], forces) < TOLERANCE
        qdd, V0d = free("direct_dynamics", **at, tau=forces[6:], f0=forces[:6])
        assert worst([*V0d, *qdd], accelerations) < 1e3 * TOLERANCE  # that of `aba` in hard positions
        assert worst([*V0d, *qdd], [*base["V0d"], *state["qdd_motor"]]) < 1e3 * TOLERANCE
        assert worst(free("bias_forces", **at)[0], forces - A @ [*base["V0d"], *state["qdd_motor"]]) < 10 * TOLERANCE


# One model against another, motors, springs and passive joints


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(3))
def test_direct_and_inverse_models_agree(seed: int, tmp_path: Path) -> None:
    """Whatever is known of the base, and as the Lagrange form A (V'0, qdd) + H = (f0, Gamma) has it."""
    machine = random_machine(seed, joints=6, kinds=ALL_KINDS)
    codes = [built(on(machine, known), tmp_path / known) for known in BOTH]
    base, state = base_state(seed), joint_state(machine, seed)
    at = asked(state, "q", "qd") | asked(base, "R0", "V0")
    motors = codes[0].module.MOTORS
    for free, driven in zip(runs(codes[0]), runs(codes[1]), strict=True):
        qdd, V0d = free("direct_dynamics", **at, tau=state["tau"], f0=base["f0"])
        again = free("inverse_dynamics", **at, qdd_motor=qdd[list(motors)], f0=base["f0"])
        other = driven("inverse_dynamics", **at, qdd_motor=qdd[list(motors)], V0d=V0d)
        for found, wanted in zip(
            (*again, *other), (state["tau"], qdd, V0d, state["tau"], qdd, base["f0"]), strict=True
        ):
            assert worst(found, wanted) < 1e3 * TOLERANCE
        assert worst(driven("direct_dynamics", **at, tau=state["tau"], V0d=V0d)[0], qdd) < 1e3 * TOLERANCE
        balance = free("inertia_matrix", q=state["q"])[0] @ [*V0d, *qdd] + free("bias_forces", **at)[0]
        assert worst(balance[:6], base["f0"]) < 1e3 * TOLERANCE


@pytest.mark.thorough
def test_quaternion_and_rotation_agree(tmp_path: Path) -> None:
    machine, base = two_children(), base_state(1)
    state = joint_state(machine, 1)
    codes = {turned: built(on(machine, turned=turned), tmp_path / turned) for turned in Orientation}
    for name, known in (
        ("direct_dynamics", {"f0", "tau"}),
        ("inverse_dynamics", {"f0", "qdd_motor"}),
        ("bias_forces", ()),
    ):
        given = asked(state | base, "q", "qd", "V0", *known)
        for one, other in zip(runs(codes[Orientation.ROTATION]), runs(codes[Orientation.QUATERNION]), strict=True):
            for found, wanted in zip(
                one(name, **given, R0=base["R0"]), other(name, **given, Q0=base["Q0"]), strict=True
            ):
                assert worst(found, wanted) < TOLERANCE


@pytest.mark.thorough
def test_a_rotation_may_be_a_matrix(tmp_path: Path) -> None:
    """Single states and stacks, R0 as 3 x 3 and row by row."""
    machine, base = two_children(), base_state(1)
    code = built(on(machine), tmp_path).module
    given = asked(joint_state(machine, 1) | base, "q", "qd", "V0", "tau", "f0")
    R = base["R0"].reshape(3, 3)
    wanted = code.direct_dynamics(**given, R0=base["R0"])
    for found, stacked, want in zip(
        code.direct_dynamics(**given, R0=R), code.direct_dynamics(**given, R0=np.stack([R] * 3)), wanted, strict=True
    ):
        np.testing.assert_array_equal(found, want)
        np.testing.assert_array_equal(stacked, [want] * 3)
    with pytest.raises(ValueError, match=r"R0 has shape \(4, 4\)"):
        code.direct_dynamics(**given, R0=np.eye(4))


# Known motions


def test_a_single_body_obeys_newton_and_euler(tmp_path: Path) -> None:
    """f = M (a - g) and moment = J w' + w x (J w), of a body about its centre of mass."""
    J = np.array([[0.9, 0.05, -0.1], [0.05, 1.1, 0.07], [-0.1, 0.07, 1.3]])
    frame = Joint("tool", 0, Kind.FIXED, 2)
    alone = Machine("alone", (frame,), base=Base(gravity=vector(1, -2, -9.81)))
    base = base_state(2)
    R, w = base["R0"].reshape(3, 3), base["V0"][3:]
    a = base["f0"][:3] / 7.5 + R.T @ [1, -2, -9.81]
    wd = np.linalg.solve(J, base["f0"][3:] - np.cross(w, J @ w))
    code = built(on(alone, body=replace(HULL, moments=vector(0, 0, 0))), tmp_path)
    for run in code.both():
        _, V0d = run("direct_dynamics", q=[], qd=[], tau=[], **asked(base, "R0", "V0", "f0"))
        assert worst(V0d, [*a, *wd]) < TOLERANCE
        assert (
            worst(
                run("inertia_matrix", q=[])[0], np.block([[7.5 * np.eye(3), np.zeros((3, 3))], [np.zeros((3, 3)), J]])
            )
            == 0
        )


@pytest.mark.thorough
def test_a_base_that_is_held_is_fixed(tmp_path: Path) -> None:
    """At rest, not turned, its acceleration zero: the results of the fixed base to the last bits."""
    machine = random_machine(5, joints=7)
    state = joint_state(machine, 5)
    fixed = built(machine, tmp_path / "fixed")
    held = built(on(machine, KnownOfBase.ACCELERATION), tmp_path / "held")
    at = asked(state, "q", "qd") | {"R0": np.eye(3).ravel(), "V0": np.zeros(6), "V0d": np.zeros(6)}
    for name, known in (("direct_dynamics", "tau"), ("inverse_dynamics", "qdd_motor")):
        wanted = fixed.c(name, **asked(state, "q", "qd", known))
        for run in held.both():
            for x, y in zip(run(name, **at, **asked(state, known)), wanted, strict=False):
                assert worst(x, y) < TOLERANCE


@pytest.mark.thorough
def test_a_heavy_base_hardly_moves(tmp_path: Path) -> None:
    """The results of the fixed base, springs included, to one part in as many as the base is heavier."""
    machine = random_machine(3, joints=6)
    state = joint_state(machine, 3)
    weightless = replace(machine, base=Base())
    (wanted,) = built(weightless, tmp_path / "fixed").c("direct_dynamics", **asked(state, "q", "qd", "tau"))
    errors = []
    for mass in (1e4, 1e8):
        body = Body(cell(mass), vector(0, 0, 0), (cell(mass), ZERO, ZERO, cell(mass), ZERO, cell(mass)))
        code = built(on(weightless, body=body), tmp_path / f"{mass:g}")
        at = {"R0": np.eye(3).ravel(), "V0": np.zeros(6), "f0": np.zeros(6)}
        qdd, _ = code.c("direct_dynamics", **asked(state, "q", "qd", "tau"), **at)
        errors.append(worst(qdd, wanted))
    assert errors[0] < 0.1 and errors[1] < 2e-4 * errors[0]


@pytest.mark.thorough
def test_a_base_that_moves_as_the_file_says(tmp_path: Path) -> None:
    """The motion of a base is the same as arguments and as numbers of the table."""
    machine = random_machine(9, joints=6, moving_base=True)
    state = joint_state(machine, 9)
    given = {name: np.array([x.value() for x in getattr(machine.base, name)]) for name in vars(machine.base)}
    V0 = [*given["velocity"], *given["angular_velocity"]]
    V0d = [*given["acceleration"], *given["angular_acceleration"]]
    wanted = built(machine, tmp_path / "file").c("direct_dynamics", **asked(state, "q", "qd", "tau"))[0]
    code = built(on(machine, KnownOfBase.ACCELERATION), tmp_path / "arguments")
    for run in code.both():
        qdd = run("direct_dynamics", **asked(state, "q", "qd", "tau"), R0=np.eye(3).ravel(), V0=V0, V0d=V0d)[0]
        assert worst(qdd, wanted) < TOLERANCE


# Conservation, in 50 digits


class Exact:
    """A machine without parameters, its models in 50 digits."""

    def __init__(self, machine: Machine) -> None:
        self.machine, self.arithmetic = machine, multiprecision(50)
        self._traced: dict[str, Any] = {}

    def __call__(self, model: str, given: dict[str, Sequence[Any]]) -> list[list[Any]]:
        program = self._traced.setdefault(model, None) or trace(self.machine, model).program
        self._traced[model] = program
        symbols = {}
        for argument in program.inputs:
            symbols |= zip(argument.symbols, given[argument.name], strict=True)
        value = evaluate((x for o in program.outputs for x in o.entries), symbols, self.arithmetic)
        return [[value(x) for x in output.entries] for output in program.outputs]


def exact_state(machine: Machine, seed: int, **others: Sequence[float]) -> dict[str, list[Any]]:
    """A state in 50 digits whose rotation is one to all digits."""
    number = multiprecision(50).number
    floats = joint_state(machine, seed) | base_state(seed) | {name: np.array(x) for name, x in others.items()}
    state = {name: [number(Fraction(float(x))) for x in values] for name, values in floats.items()}
    length = mpmath.sqrt(sum(x * x for x in state["Q0"]))
    state["Q0"] = [x / length for x in state["Q0"]]
    return state


def moved(state: dict[str, list[Any]], qdd: list[Any], V0d: list[Any], h: Any) -> dict[str, list[Any]]:
    """The state a time h later, to second order in q, R and P, to first order in velocities."""
    v, w = np.array(state["V0"][:3]), np.array(state["V0"][3:])
    R, rate = np.array(rotation_of(state["Q0"])), np.array(V0d) - [*np.cross(w, v), 0, 0, 0]
    half = np.array([0, *(w * h / 2)])
    turned = np.array(state["Q0"]) + quaternion_product(state["Q0"], half)
    turned = turned / mpmath.sqrt(sum(turned**2))
    return state | {
        "q": list(np.array(state["q"]) + h * np.array(state["qd"])),
        "qd": list(np.array(state["qd"]) + h * np.array(qdd)),
        "V0": list(np.array(state["V0"]) + h * rate),
        "P0": list(np.array(state["P0"]) + h * (R @ v)),
        "Q0": list(turned),
    }


def quaternion_product(a: Sequence[Any], b: Sequence[Any]) -> Any:
    u, v = np.array(a[1:]), np.array(b[1:])
    return np.array([a[0] * b[0] - u @ v, *(a[0] * v + b[0] * u + np.cross(u, v))])


def derivative(of: Callable[[dict[str, list[Any]]], Any], exact: Exact, state: dict[str, list[Any]]) -> tuple[Any, Any]:
    """Value and time derivative along the motion of the direct model, by central differences."""
    h = mpmath.mpf(10) ** -16
    qdd, V0d = exact("direct_dynamics", state)
    after, before = (np.array(of(moved(state, qdd, V0d, sign * h))) for sign in (1, -1))
    return np.array(of(state)), (after - before) / (2 * h)


def momenta(exact: Exact, state: dict[str, list[Any]]) -> Any:
    """Linear and angular momentum about the origin of the world, in its axes."""
    n = len(state["qd"])
    rows = np.array(exact("inertia_matrix", state)[0]).reshape(6 + n, 6 + n)[:6]
    found = rows @ np.array([*state["V0"], *state["qd"]])
    R = np.array(rotation_of(state["Q0"]))
    p = R @ found[:3]
    return [*p, *(np.cross(np.array(state["P0"]), p) + R @ found[3:])]


@pytest.mark.parametrize("seed", range(2))
def test_momentum_is_conserved_in_free_flight(seed: int) -> None:
    """Nothing outside acts: both momenta in the axes of the world stay, whatever motors and springs do."""
    machine = replace(random_machine(seed, joints=5, wrenches=False), base=Base())
    with mpmath.workdps(50):
        exact = Exact(on(machine, turned=Orientation.QUATERNION))
        state = exact_state(machine, seed, f0=[0.0] * 6)
        value, rate = derivative(lambda s: momenta(exact, s), exact, state)
        assert max(map(abs, rate)) < 1e-26 * max(map(abs, value))


def test_energy_is_conserved(tmp_path: Path) -> None:
    """Falling, turning and swinging: kinetic, gravity and elastic energy together stay where nothing takes any."""
    machine = two_children(symbolic=False)
    undamped = tuple(replace(j, spring=replace(j.spring, damping=ZERO)) for j in machine.joints)
    machine = replace(machine, joints=undamped)
    with mpmath.workdps(50):
        exact = Exact(on(machine, turned=Orientation.QUATERNION))
        state = exact_state(machine, 1, f0=[0.0] * 6, tau=[0.0] * 3)
        values, rates = derivative(lambda s: exact("energy", s)[0], exact, state)
        assert max(map(abs, rates)) > 1e-3 * max(map(abs, values))
        assert abs(sum(rates)) < 1e-26 * max(map(abs, rates))


# The journey


@pytest.mark.thorough
@pytest.mark.parametrize("known", BOTH)
def test_every_model_is_checked(known: KnownOfBase) -> None:
    """Generated C and numpy against A and H solved in 50 digits."""
    machine = on(random_machine(1, joints=4), known, turned=tuple(Orientation)[known == KnownOfBase.WRENCH])
    rigid = {*OFFERED} - {model.name for model in (*STATIC_SPRINGS, *INVERSE_KINEMATIC)}
    models = tuple(name for name in OFFERED if name in rigid and not MODELS[name].columns)
    models = tuple(name for name in models if not {*"TP"} & {*MODELS[name].arguments})
    result = verify(machine, Scene(models=models), states=(2, 8))
    assert result.ok and {model.name for model in result.models} == set(models)


@pytest.mark.parametrize("turned", Orientation)
@pytest.mark.parametrize("known", BOTH)
def test_files_keep_the_base(known: KnownOfBase, turned: Orientation) -> None:
    machine = on(chain(3), known, replace(HULL, mass=cell("M2")), turned)
    for file_format in (toml, par):
        again = file_format.read(file_format.write(machine), machine.source)
        check(again)
        assert (again.floating, again.joints) == (machine.floating, machine.joints)


def test_a_par_of_symoro_with_a_floating_base() -> None:
    """Its lists of bodies begin with the base; the inertia that is not listed is zero."""
    text = "NL = 1\nis_floating = 1\nant = {0}\nsigma = {0}\ntheta = {q1}\nM = {M0, M1}\nZZ = {3, ZZ1}\n"
    found = par.read(text, "boat.par")
    assert found.floating == Floating(body=Body(cell("M0"), inertia=(*(ZERO,) * 5, cell(3))))
    assert found.joints[0].body.mass == cell("M1") and [p.name for p in found.parameters] == ["ZZ1", "M1", "M0"]
    assert par.read(text.replace("is_floating", "is_mobile"), "boat.par").floating == replace(
        found.floating, known=KnownOfBase.ACCELERATION
    )


HEAD = 'name = "a"\njoints = [{ name = "j1", kind = "motor", sigma = 0, theta = "q1" }]\n[base]\n'


@pytest.mark.parametrize(
    ("text", "place", "what"),
    [
        ('floating = "quaternions"', "base, floating", "did you mean 'quaternion'"),
        ('floating = "rotation"\nknown = "force"', "base, known", "no known 'force'"),
        ('known = "wrench"', "base, known", "only a floating base"),
        ("body = { mass = 1 }", "base, body", "only a floating base"),
        ('floating = "rotation"\nbody = { mas = 1 }', "base, body, mas", "did you mean 'mass'"),
        ('floating = "rotation"\nbody = { mass = -1 }', "base, mass", "negative"),
        ('floating = "rotation"\nbody = { mass = "m0" }', "base, mass", "not declared"),
        ('floating = "rotation"\nvelocity = [1, 0, 0]', "base, velocity", "leave it out"),
    ],
)
def test_bad_toml(text: str, place: str, what: str) -> None:
    with pytest.raises(InputError) as error:
        check(toml.read(HEAD + text, "a.toml"))
    assert error.value.place == place and what in str(error.value)


@pytest.mark.parametrize(
    ("text", "place", "what"),
    [
        ("is_floating = 1\nis_mobile = 1", "is_mobile", "one of the two"),
        ("is_mobile = maybe", "is_mobile", "0 or 1"),
        ("is_floating = 1\nFX = {1, 0}", "base, FX", "write 0"),
        ("is_floating = 1\nM = {1, 2, 3}", "M", "has 3 entries"),
        ("is_floating = 0\nM = {1, 2}", "M", "has 2 entries"),
        ("(*! orientation = rotation *)", "base, floating", "is_floating = 1"),
        ("is_floating = 1\n(*! orientation = euler *)", "base, floating", "quaternion"),
    ],
)
def test_bad_par(text: str, place: str, what: str) -> None:
    with pytest.raises(InputError) as error:
        par.read(f"NL = 1\nant = {{0}}\nsigma = {{0}}\ntheta = {{q1}}\n{text}\n", "a.par")
    assert error.value.place == place and what in str(error.value)


def test_a_base_that_meets_no_inertia_is_refused() -> None:
    """A massless base turns freely about the axis of a joint without rotor that stands on it."""
    machine = two_children()
    joints = (replace(machine.joints[0], rotor_inertia=ZERO), *machine.joints[1:])
    machine = on(replace(machine, joints=joints), body=Body())
    [(message, place)] = zero_pivots(machine, Scene())
    assert place == "base" and "give it a body" in message
    assert not zero_pivots(on(machine), Scene())
    assert not zero_pivots(on(machine, KnownOfBase.ACCELERATION, Body()), Scene())


@pytest.mark.parametrize("name", sorted(set(MODELS) - set(OFFERED)))
def test_what_is_not_offered_is_refused(name: str) -> None:
    with pytest.raises(InputError, match="not offered on a floating base"):
        trace(on(chain(2)), name)
