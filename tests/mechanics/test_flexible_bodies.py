"""Flexible bodies by modes: against mass points, energy, differential equations and published figures."""

from __future__ import annotations

import re
from dataclasses import replace
from functools import partial
from typing import Any

import numpy as np
import pytest
from scipy.integrate import solve_ivp

import symoro_elastic as se
from symoro_elastic.formats.toml.reading import read
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.formula import Formula
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import Scene
from tests.command_line import EXAMPLES, run
from tests.generated_code import rendered
from tests.references.mass_points import two_machines

MODELS = ("direct_dynamics", "inverse_dynamics", "energy")
OTHERS = (
    *("inertia_matrix", "bias_forces", "gravity_forces", "direct_dynamics_by_inertia_matrix", "coriolis_forces"),
    *("linearization", "inverse_dynamics_derivatives", "direct_dynamics_derivatives"),
)
SAME = 1e-14
"""Of the largest entry: some ten roundings of it."""
BEAM = """
name = "turning"
gravity = [0, 0, 0]
joints = [{ name = "hub", antecedent = 0, kind = "motor", sigma = 0, axis = "z", at = [0, 0, 0] }]
[beams]
hub = { along = "x", length = LENGTH, EI = EI0, mass_per_length = MASS, bends = ["KIND"], MORE }
"""


def beam(more: str, kind: str = "z", length: str = "1.0", EI: str = "1.0", mass: str = "1.0") -> DescribedMachine:
    cells = {"LENGTH": length, "EI0": EI, "MASS": mass, "KIND": kind, "MORE": more}
    text = BEAM
    for key, value in cells.items():
        text = text.replace(key, value)
    return read(text, "beam.toml")


def model(machine: DescribedMachine, name: str, *arguments: Array) -> tuple[Array, ...]:
    results = getattr(se.load(machine, name, fold=["all"]), name)(*arguments)
    return results if isinstance(results, tuple) else (results,)


def differences(
    first: DescribedMachine, second: DescribedMachine, names: tuple[str, ...], seed: int, size: float = 0.3
) -> dict[str, float]:
    """The largest difference of the results of models at a drawn state, of the largest entry; `size` of positions."""
    rng = np.random.default_rng(seed)
    n, m = len(first.independent), len(first.motors)
    drawn = {"q": size * rng.normal(size=n), "qd": rng.normal(size=n), "qdd": rng.normal(size=n)}
    drawn |= {"tau": rng.normal(size=m), "qdd_motor": rng.normal(size=m)}
    drawn |= {"Q0": np.array([0.5, 0.1, -0.7, 0.5]), "P0": rng.normal(size=3)}
    drawn |= {"V0": rng.normal(size=6), "f0": rng.normal(size=6)}
    apart = {}
    for name in names:
        function = se.load(second, name, fold=["all"]).package.functions[0]
        arguments = [drawn[argument.name] for argument in function.arguments]
        results = zip(model(first, name, *arguments), model(second, name, *arguments), strict=True)
        apart[name] = max(float(np.abs(a - b).max() / np.abs(a).max()) for a, b in results if a.shape == b.shape)
    return apart


@pytest.mark.parametrize(
    ("seed", "modes", "slides"), [(0, 1, False), pytest.param(1, 2, True, marks=pytest.mark.thorough)]
)
def test_modes_are_mass_points(seed: int, modes: int, slides: bool) -> None:
    points, modal = two_machines(seed, modes, slides)
    assert max(differences(points, modal, MODELS, seed).values()) < SAME


@pytest.mark.thorough
@pytest.mark.parametrize("seed", range(20))
def test_modes_are_mass_points_in_all_models(seed: int) -> None:
    points, modal = two_machines(100 + seed, 1 + seed % 3, bool(seed % 2))
    assert max(differences(points, modal, (*MODELS, *OTHERS), seed).values()) < SAME


@pytest.mark.thorough
def test_derivatives_and_linear_models_are_those_of_mass_points() -> None:
    points, modal = two_machines(3, 2, False)
    assert max(differences(points, modal, OTHERS[-3:], 3).values()) < SAME


@pytest.mark.thorough
def test_a_mode_that_is_held_is_a_shape() -> None:
    held = Scene(locked={"e1": Formula.parse("0.2")})
    points, modal = (restrict(machine, held) for machine in two_machines(4, 2, True))
    assert max(differences(points, modal, MODELS[:1], 4).values()) < SAME


@pytest.mark.thorough
def test_vibrations_are_those_of_mass_points() -> None:
    points, modal = (se.modes(machine, hold=["all"]) for machine in two_machines(5, 2, False))
    assert modal.frequencies == pytest.approx(points.frequencies, rel=1e-10)
    rows = [[row for row in result.parts() if not isinstance(row, str)][-1].rows for result in (points, modal)]
    assert [row[3] for row in rows[0]] == [row[3] for row in rows[1]], "strain energies"


CLAMPED = (3.5160152685, 22.0344915, 61.6972144)
"""Roots of cosh(sqrt(x)) cos(sqrt(x)) = -1."""
LEAST_EXACT = {2: (4.8e-3, 0.58), 3: (5e-4, 1e-2, 0.92), 4: (2e-6, 6e-3, 4e-2), 6: (1e-9, 2e-5, 5e-4)}
"""Largest relative errors of a Rayleigh quotient in the span of so many shapes."""


@pytest.mark.parametrize("modes", LEAST_EXACT)
def test_a_clamped_beam(modes: int) -> None:
    machine = beam(f"modes = {modes}")
    M, _, K = model(machine, "linearization", *np.zeros((3, modes + 1)))
    w = np.sqrt(np.linalg.eigvals(np.linalg.solve(M[1:, 1:], K[1:, 1:])).real)
    bounds = LEAST_EXACT[modes]
    for computed, exact, bound in zip(sorted(w), CLAMPED, bounds, strict=False):
        assert -1e-9 < computed / exact - 1 < bound, "from above, as Rayleigh's quotient"
    assert np.sum(1 / np.diag(K)[1:]) == pytest.approx(1 / 3, rel=1e-12), "tip compliance L^3/(3 EI)"


TURNING = {2.0: (4.1373, 22.6149, 62.2732), 6.0: (7.3604, 26.8091, 66.6839)}
"""Frequencies of flapping over sqrt(EI/(mass_per_length L^4)) at a speed of this unit (Wright et al. 1982)."""


@pytest.mark.parametrize("speed", TURNING)
def test_a_turning_beam_is_stiffer(speed: float) -> None:
    machine = beam("modes = 6, stiffening = true")
    qd = np.array([speed, 0, 0, 0, 0, 0, 0])
    M, _, K = model(machine, "linearization", np.zeros(7), qd, np.zeros(7))
    w = np.sqrt(np.linalg.eigvals(np.linalg.solve(M[1:, 1:], K[1:, 1:])).real)
    assert sorted(w)[:3] == pytest.approx(TURNING[speed], rel=4e-4)


def spin_up(modes: int, times: Array) -> Array:
    """The lag of the tip of a beam of 10 m, 14 kN m2 and 1.2 kg/m that reaches 6 rad/s in 15 s."""
    machine = beam(f"modes = {modes}, stiffening = true", "y", "10.0", "1.4e4", "1.2")
    inverse = se.load(machine, "inverse_dynamics", fold=["all"]).inverse_dynamics

    def rate(t: float, x: Array) -> Array:
        turns, s, c = 2 * np.pi / 15, np.sin(2 * np.pi * t / 15), np.cos(2 * np.pi * t / 15)
        hub = 0.4 * np.array([t**2 / 2 + (c - 1) / turns**2, t - s / turns, 1 - c])
        qdd = inverse(np.r_[hub[0], x[:modes]], np.r_[hub[1], x[modes:]], hub[2:])[1]
        return np.concatenate([x[modes:], qdd[1:]])

    solved = solve_ivp(rate, (0, times[-1]), np.zeros(2 * modes), method="LSODA", rtol=1e-7, t_eval=times)
    return np.asarray(solved.y[:modes].sum(axis=0))


def test_spin_up_of_a_beam() -> None:
    """Kane, Ryan and Banerjee 1987; Simo and Vu-Quoc 1987: the tip lags by up to 0.572 m at 6.75 s."""
    times = np.linspace(0, 8, 401)
    lag = spin_up(2, times)
    assert lag.min() == pytest.approx(-0.572, rel=5e-3) and times[lag.argmin()] == pytest.approx(6.75, abs=0.05)


@pytest.mark.thorough
def test_spin_up_by_exudyn() -> None:
    pytest.importorskip("exudyn")
    from tests.references.exudyn_spin_up import lag_of_tip

    turns = 2 * np.pi / 15
    times, lag = lag_of_tip(lambda t: 0.4 * (t**2 / 2 + (np.cos(turns * t) - 1) / turns**2), 10, 1.4e4, 2.8e7, 1.2, 8)
    ours = np.interp(times, (t := np.linspace(0, 8, 801)), spin_up(3, t))
    assert np.abs(ours - lag).max() < 5e-3 * np.abs(lag).max()


IN_A_PLANE = """
name = "in_a_plane"
gravity = [0, 0, 0]
joints = [
  { name = "shoulder", antecedent = 0, kind = "motor", sigma = 0, axis = "z", at = [0, 0, 0] },
  { name = "elbow", antecedent = "shoulder", kind = "motor", sigma = 0, axis = "z", at = [0.8, 0, 0] },
  { name = "tool", antecedent = "elbow", kind = "fixed" },
]
bodies = { elbow = { mass = 2 }, tool = { mass = 1 } }
[beams]
shoulder = { along = "x", length = 0.8, EI = 1e3, mass_per_length = 5, bends = ["y"], modes = 3, stiffening = true }
elbow = { along = "x", length = 0.6, EI = 300, mass_per_length = 3, bends = ["y"], modes = 3, stiffening = true }
"""


@pytest.mark.thorough
def test_two_links_by_exudyn() -> None:
    """Under torques the tool moves by 0.5 m, and links bend by 5.6 and 2.5 mm: the paths are 0.02 mm apart."""
    pytest.importorskip("exudyn")
    from tests.references.exudyn_two_link import path_of_tool

    def torque(largest: float, t: float) -> float:
        return largest * np.sin(2 * np.pi * t / 0.4) if t < 0.4 else 0.0

    machine, end = read(IN_A_PLANE, "in_a_plane.toml"), 0.6
    n, largest = len(machine.independent), (30.0, -6.0)
    links = (0.8, 1e3, 7e6, 5.0), (0.6, 300.0, 5e6, 3.0)
    times, path = path_of_tool(links, (2.0, 1.0), [partial(torque, x) for x in largest], end, 1500)
    direct = se.load(machine, "direct_dynamics", fold=["all"]).direct_dynamics

    def rate(t: float, x: Array) -> Array:
        return np.concatenate([x[n:], direct(x[:n], x[n:], np.array([torque(x, t) for x in largest]))])

    x = solve_ivp(rate, (0, end), np.zeros(2 * n), "LSODA", times, rtol=1e-7, atol=1e-9).y[:n].T
    T = se.load(machine, "geometric_model", fold=["all"], only={"geometric_model": ["tool"]}).geometric_model(x)
    assert np.abs(T[:, 0, :2, 3] - path).max() < 5e-5
    assert np.ptp(path[:, 0]) > 0.4 and np.abs(x[:, 1]).max() > 5e-3, "it moves, and bends"


TWO_LINKS = """
name = "two_links"
gravity = [0.5, -9.81, 0.3]
joints = [
  { name = "shoulder", antecedent = 0, kind = "motor", sigma = 0, axis = "z", at = [0, 0, 0] },
  { name = "elbow", antecedent = "shoulder", kind = "motor", sigma = 0, axis = "y", at = [1, 0, 0] },
]
[beams]
shoulder = { along = "x", length = 1, section = { bar = [0.02, 0.06] }, E = 7e10, density = 2700, modes = 2, MORE }
elbow = { along = "-z", length = 0.8, section = { tube = [0.05, 0.04] }, E = 7e10, density = 2700, modes = 1, MORE }
"""


SOFT = "7e5"
"""Pa: vibrations are so slow that differences of the energy are exact."""


@pytest.mark.thorough
@pytest.mark.parametrize("more", ["stiffening = true", "bends = ['y', 'torsion']"])
def test_power_changes_the_energy(more: str) -> None:
    machine = read(TWO_LINKS.replace("MORE", more).replace("7e10", SOFT), "two_links.toml")
    rng = np.random.default_rng(0)
    n, h = len(machine.independent), 1e-5
    q, qd, tau = 0.05 * rng.normal(size=n), rng.normal(size=n), rng.normal(size=2)
    (qdd,) = model(machine, "direct_dynamics", q, qd, tau)
    energy = [model(machine, "energy", q + s * h * qd + h * h / 2 * qdd, qd + s * h * qdd)[0].sum() for s in (1, -1)]
    power = float(tau @ qd[list(machine.motor_entries)])
    assert (energy[0] - energy[1]) / (2 * h) == pytest.approx(power, abs=1e-6 * abs(energy[0]))


BRIDGE = """
name = "bridge"
gravity = [0.4, 0.3, -9.81]
joints = [
  { name = "column", antecedent = 0, kind = "motor", sigma = 0, axis = "z", at = [0, 0, 1] },
  { name = "cart", kind = "motor", sigma = 1, along = "column", from = 0.25 },
  { name = "ram", kind = "motor", sigma = 1, axis = "z", at = [0.3, 0.1, 1] },
]
[beams]
column = { along = "x", length = 1.5, section = { bar = [0.02, 0.01] }, E = E0, density = 7850, modes = 2 }
[bodies]
cart = { mass = 3, center_of_mass = [0, 0.05, 0.02] }
ram = { mass = 2, center_of_mass = [0, 0, -0.2], inertia = [0.05, 0.05, 0.01] }
"""


def test_a_slide_moves_along_a_beam() -> None:
    """The energy changes by the power while the place changes; a mass at the tip moves by each mode as the tip does."""
    machine = read(BRIDGE.replace("E0", '"1 MPa"'), "bridge.toml")
    rng, n, h = np.random.default_rng(2), len(machine.independent), 1e-5
    q, qd, tau = 0.05 * rng.normal(size=n), rng.normal(size=n), rng.normal(size=3)
    (qdd,) = model(machine, "direct_dynamics", q, qd, tau)
    energy = [model(machine, "energy", q + s * h * qd + h * h / 2 * qdd, qd + s * h * qdd)[0].sum() for s in (1, -1)]
    power = float(tau @ qd[list(machine.motor_entries)])
    assert (energy[0] - energy[1]) / (2 * h) == pytest.approx(power, abs=1e-6 * abs(energy[0]))

    names = [joint.name for joint in machine.independent_joints]
    modes = [names.index(f"column_y{k}") for k in (1, 2)]
    for place, moved in ((1.25, 1.0), (-0.25, 0.0)):
        at = np.where(np.array(names) == "cart", place, 0.0)
        text = BRIDGE.replace("E0", "1e6").replace(", center_of_mass = [0, 0.05, 0.02]", "")
        light, heavy = (
            model(read(text.replace("mass = 3", mass), "bridge.toml"), "inertia_matrix", at)[0]
            for mass in ("mass = 3", "mass = 8")
        )
        assert (heavy - light)[np.ix_(modes, modes)] == pytest.approx(np.full((2, 2), 5 * moved), abs=1e-9)


@pytest.mark.thorough
def test_the_frame_of_a_slide_is_that_of_its_body() -> None:
    """Forces and outputs at its name follow the deflection; its row, which does not, is `row cart`."""
    machine = read(BRIDGE.replace("E0", "2e11"), "bridge.toml")
    of_name, of_body, of_row = (
        se.stiffness(machine, frame=frame, at={"cart": 0.4}).compliance for frame in ("cart", "cart_body", "row cart")
    )
    assert of_name == pytest.approx(of_body, rel=1e-12) and of_name[1, 1] > 1e-7
    assert np.abs(of_row).max() < 1e-9 * of_name[1, 1]


def test_a_stiff_beam_has_the_inertia_of_a_rigid_one() -> None:
    machine = read(TWO_LINKS.replace(", MORE", ""), "two_links.toml")
    n = len(machine.independent)
    held = Scene(locked={joint.name: Formula.parse("0") for joint in machine.joints if joint.kind == "elastic"})
    motors = list(machine.motor_entries)
    (A,), (rigid,) = (model(x, "inertia_matrix", np.zeros(k)) for x, k in ((machine, n), (restrict(machine, held), 2)))
    assert A[np.ix_(motors, motors)] == pytest.approx(rigid, rel=1e-12)


@pytest.mark.parametrize(
    ("more", "what"),
    [
        ("modes = 2, joints = 4", "beam hub, joints: belongs to a beam by joints: leave it out, or modes"),
        ("modes = 7", "beam hub, modes: 7 is not from 1 to 6"),
        ("modes = 0", "beam hub, modes: 0 is not from 1 to 6"),
        ("stiffening = true", "beam hub, stiffening: belongs to a beam by modes: joints follow large deflections by"),
    ],
)
def test_refused(more: str, what: str) -> None:
    with pytest.raises(InputError) as error:
        beam(more)
    assert f"beam.toml: {what}" in str(error.value)


def test_names_are_refused() -> None:
    with pytest.raises(
        InputError, match="modes are numbers of the file, and 'L' is a name: write its value, or joints"
    ):
        read("parameters = { L = 2.0 }\n" + BEAM.replace("LENGTH", '"L"').replace("EI0", "1").replace("MASS", "1")
             .replace("KIND", "y").replace("MORE", "modes = 2"), "beam.toml")  # fmt: skip


@pytest.mark.parametrize("name", ["regressor", "energy_regressor", "base_parameters"])
def test_inertial_parameters_of_flexible_bodies_are_refused(name: str) -> None:
    with pytest.raises(InputError, match=r"flexible body hub_root: .* does not know the integrals of its modes"):
        se.load(replace(beam("modes = 2")), name)


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ("modes = 2", "joints = 2", "along: 'column' is no beam by modes and no rail of a body: write modes"),
        ("modes = 2", "modes = 2, stiffening = true", "along: 'column' has stiffening, which is not offered"),
        ('along = "column"', 'along = "colum"', "no rail of a body; did you mean 'column'?: write modes"),
        ("from = 0.25", "at = [0, 0, 1]", "at: follows from column: leave it out; from is the distance"),
        ('"cart", kind = "motor", sigma = 1', '"cart", kind = "motor", sigma = 0', "sigma: a row along a body slides"),
    ],
)
def test_slides_that_are_refused(old: str, new: str, what: str) -> None:
    with pytest.raises(InputError) as error:
        read(BRIDGE.replace("E0", "1e6").replace(old, new, 1), "bridge.toml")
    assert "bridge.toml: joint 2 (cart), " in str(error.value) and what in str(error.value)


@pytest.mark.thorough
@pytest.mark.parametrize(
    "more", [{"base_slides": True}, {"floats": True}, {"shortens": 0.8}], ids=["slide", "floating", "short"]
)
def test_two_bodies_on_carriers_are_mass_points(more: dict[str, Any]) -> None:
    """At rest in e foreshortening is exact for all rates; at a drawn position the others are."""
    points, modal = two_machines(11, 1, True, **more)
    size = 0.0 if "shortens" in more else 0.3
    assert max(differences(points, modal, (*MODELS, "bias_forces"), 11, size).values()) < SAME


def test_foreshortening_is_of_the_second_order() -> None:
    points, modal = two_machines(12, 1, False, shortens=0.8)
    full, half = (differences(points, modal, ("inertia_matrix",), 12, size)["inertia_matrix"] for size in (0.1, 0.05))
    assert 3.5 < full / half < 4.5


@pytest.mark.parametrize("kind", ["y", "torsion"])
def test_a_beam_that_is_held_bent_is_one_that_stays_bent(kind: str) -> None:
    """A torsion mode is held at an angle, a bending mode at a length: both deform the body."""
    own = "1e3, GJ = 50, inertia_per_length = 0.4"
    machine = beam("modes = 1", kind, EI=own)
    held = restrict(machine, Scene(locked={f"hub_{kind}1": Formula.parse("0.2")}))
    (bent,), (A,) = (model(x, "inertia_matrix", q) for x, q in ((held, np.zeros(1)), (machine, np.array([0, 0.2]))))
    assert bent[0, 0] == pytest.approx(A[0, 0], rel=1e-14)
    (straight,) = model(machine, "inertia_matrix", np.zeros(2))
    assert abs(A[0, 0] / straight[0, 0] - 1) > 1e-4, "0.2 is a deflection that matters"


WITH_TOOL = BEAM.replace("at = [0, 0, 0] }]", "at = [0, 0, 0] }, ROW]").replace("LENGTH", "1").replace("EI0", "1")
WITH_TOOL = WITH_TOOL.replace("MASS", "1").replace("KIND", "y").replace("MORE", "modes = 1")
TOOL = '{ name = "tool", antecedent = "hub_end", kind = "fixed" }'


@pytest.mark.parametrize(
    ("row", "more", "what"),
    [
        ("", "[bodies]\nhub_y1 = { mass = 1 }", "mode 'hub_y1': it has mass, which a mode has not"),
        ("", "[motors]\nhub_y1 = { rotor_inertia = 1 }", "mode 'hub_y1': it has rotor_inertia, which a mode has not"),
        ("", "[wrenches]\nhub_y1 = { force = [1, 0, 0] }", "mode 'hub_y1': it has force x, which a mode has not"),
        ("", '[frames]\nspot = { on = "hub_y1" }', "mode 'hub_y1': its row carries 'spot', but has no place"),
        (TOOL.replace("_end", "_y1"), "", "mode 'hub_y1': its row carries 'tool', but has no place"),
        ("", "[bodies]\nhub_root = { mass = 1 }", "hub_root has the inertia of a body by modes: leave it out"),
    ],
)
def test_rows_of_modes_are_bare(row: str, more: str, what: str) -> None:
    with pytest.raises(InputError) as error:
        check(read(WITH_TOOL.replace("ROW", row or TOOL.replace("_end", "")) + more, "beam.toml"))
    assert what in str(error.value)


WRITTEN = """
name = "plate"
gravity = [0, 0, -9.81]
joints = [
  { name = "hub", antecedent = 0, kind = "motor", sigma = 0, axis = "z", at = [0, 0, 0] },
  { name = "e1", antecedent = "hub", kind = "elastic", sigma = 1, r = "e1" },
  { name = "other", antecedent = 0, kind = "elastic", sigma = 1, r = "e2" },
]
bodies = { hub = { mass = 1, inertia = [1, 1, 1] }, other = { mass = 1 } }
springs = { e1 = { stiffness = 5 }, other = { stiffness = 5 } }
[flexible.hub]
modes = ["e1"]
Ct0 = [[0, 0.5, 0]]
Ct1 = [[[0, 0, 0]]]
T0 = [[[0, 0.2, 0], [0, 0, 0], [0, 0, 0]]]
T1 = [[[[0, 0, 0], [0, 0.3, 0], [0, 0, 0]]]]
Mee = [[0.3]]
"""


@pytest.mark.parametrize(
    ("old", "new", "what"),
    [
        ('["e1"]', '["other"]', "mode 'other': its antecedent is not the row of the body"),
        ('["e1"]', '["hub"]', "mode 'hub': the row is motor: a mode is elastic"),
        ("[[0.3]]", "[[0]]", "Mee: is not positive definite"),
        ('r = "e1"', 'r = "e1 + 0.1"', "mode 'e1': it has r = 0.1, which a mode has not"),
    ],
)
def test_integrals_that_no_body_has(old: str, new: str, what: str) -> None:
    assert not check(read(WRITTEN, "plate.toml"))
    with pytest.raises(InputError) as error:
        check(read(WRITTEN.replace(old, new), "plate.toml"))
    assert f"plate.toml: flexible body hub, {what}" in str(error.value)


def test_the_body_of_a_mode_is_not_left_out() -> None:
    machine = read(WRITTEN, "plate.toml")
    with pytest.raises(InputError, match=r"no rigid body, rotor or drive has a number 'hub\.mass'"):
        se.load(machine, "energy", scene={"zero": ["hub.mass"]})


def test_the_body_of_modes_is_not_swept() -> None:
    machine = read(WITH_TOOL.replace("ROW", TOOL), "beam.toml")
    with pytest.raises(InputError, match="its body bends by modes, whose integrals do not follow"):
        se.sweep(machine, over={"hub_root.mass": (1, 2, 3)})


def test_a_mode_has_no_frame() -> None:
    machine = read(WITH_TOOL.replace("ROW", TOOL), "beam.toml")
    with pytest.raises(InputError, match=r"'hub_y1': it is a mode of hub_root, which has no frame: name an interface"):
        se.load(machine, "jacobian", only={"jacobian": ["hub_y1"]})
    with pytest.raises(InputError, match=r"it is a mode of hub_root, which has no frame"):
        se.response(machine, inputs=["hub"], outputs=["hub_y1.x"])


@pytest.mark.parametrize(
    ("more", "cells", "what"),
    [
        ("modes = 1", {"mass": "0"}, "mass_per_length: is 0, and modes have mass"),
        ("modes = 1", {"length": "1e300"}, "numbers or formulas that are too large or too small"),
        ("modes = 1", {"length": "1e-300"}, "numbers or formulas that are too large or too small"),
    ],
)
def test_beams_of_odd_numbers(more: str, cells: dict[str, str], what: str) -> None:
    with pytest.raises(InputError, match=what):
        beam(more, **cells)
    with pytest.raises(InputError, match="bends: names no deflection"):
        read(WITH_TOOL.replace("ROW", TOOL).replace('["y"]', "[]"), "beam.toml")


def test_modal_quantities_have_names() -> None:
    machine = read(TWO_LINKS.replace("MORE", "stiffening = true"), "two_links.toml")
    files = rendered(machine, Scene(models=("direct_dynamics",), fold="all"), ["c"])
    (text,) = (text for name, text in files.items() if name.endswith(".c"))
    assert "Um3_" in text and "Rm3_" in text and "fm3" in text and "(L50)-(L54)" in text
    assert not re.search(r"\b\d\.\d+e-(1[89]|2\d)\b", text), "sums that cancel are zero, no rounding"


@pytest.mark.thorough
def test_base_parameters_are_not_offered() -> None:
    shown = run("show", EXAMPLES / "flexible_arm.toml")
    assert "base inertial parameters: not offered for bodies that bend by modes" in shown.output
    assert "shoulder   x       0.8         1.728      modes" in shown.output
