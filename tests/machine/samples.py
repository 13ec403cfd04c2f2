"""A small machine in both formats, for tests that damage it, and machines at random."""

from __future__ import annotations

from dataclasses import replace

from hypothesis import strategies as st

from symoro_elastic.machine.described import DescribedMachine, Origin, Request
from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.loops import Closing, Loop
from symoro_elastic.machine.machine import Base, Body, Friction, Joint, Kind, Parameter, Spring, Wrench
from symoro_elastic.machine.scene import ALL, Parts, Scene
from symoro_elastic.models.programs.catalogue import MODELS

TOML = """
name = "arm"
gravity = [0, 0, -9.81]
joints = [
  { name = "base_yaw", kind = "motor", sigma = 0, theta = "q1" },
  { name = "lift", kind = "elastic", sigma = 1, alpha = "pi/2", theta = 0, r = "q2 + L2" },
  { name = "tip", kind = "fixed", d = 0.1 },
]
[parameters]
L2 = 0.35
K2 = nan
[bodies]
lift = { mass = 2.5, center_of_mass = [0.1, 0, 0], inertia = [0.1, 0.2, 0.25] }
[springs]
lift = { stiffness = "K2", damping = 3 }
[motors]
base_yaw = { rotor_inertia = 0.5 }
[friction]
base_yaw = { viscous = 1, coulomb = 2 }
"""

COUPLED = """
gravity = [0, 0, 0]
name = "palletizer"
joints = [
  { name = "waist", antecedent = 0, kind = "motor", sigma = 0, theta = "q1" },
  { name = "rotor", antecedent = 0, kind = "coupled", sigma = 0, theta = "N1*q1" },
  { name = "arm", antecedent = "waist", kind = "motor", sigma = 0, alpha = "pi/2", theta = "q2" },
  { name = "forearm", antecedent = "arm", kind = "passive", sigma = 0, d = "L2", theta = "q3" },
  { name = "crank", antecedent = "waist", kind = "elastic", sigma = 0, alpha = "pi/2", theta = "qm/N1 + q4" },
  { name = "drive", antecedent = "waist", kind = "motor", sigma = 0, alpha = "pi/2", theta = "qm" },
  { name = "rod", antecedent = "crank", kind = "passive", sigma = 0, d = "L3", theta = "q5" },
  { name = "pin", antecedent = "rod", kind = "cut", sigma = 0, d = "L2", theta = "q6" },
  { name = "pin_end", antecedent = "forearm", kind = "fixed", d = "L3" },
  { name = "jaw", antecedent = "forearm", kind = "coupled", sigma = 1, r = "L3*sin(q3)" },
]
[loops.ring]
cut = "pin"
meets = "pin_end"
dependent = ["q3", "rod"]
start = { q2 = 1, q3 = 1.5, q4 = 0, qm = "2.5*N1", q5 = -1.5 }
[parameters]
L2 = 0.7
L3 = 0.2
N1 = 100
[bodies]
forearm = { mass = 9 }
[springs]
crank = { stiffness = "3e4/(1 + q2^2)" }
[motors]
arm = { rotor_inertia = 5e-4, ratio = "N1" }
[friction]
jaw = { viscous = 3 }
"""

PAR = """
NL = 3
NJ = 3
Type = 0
ant = {0, 1, 2}
sigma = {0, 1, 2}
alpha = {0, pi/2, 0}
d = {0, 0, 0.1}
theta = {q1, 0, 0}
r = {0, q2, 0}
M = {0, M2, 0}
eta = {0, 1, 0}
k = {0, K2, 0}
G = {0, 0, -9.81}
"""

PAR_LOOP = """
NL = 5
NJ = 6
NF = 7
Type = 2
ant = {0, 1, 2, 0, 0, 4, 3}
sigma = {0, 0, 0, 0, 0, 0, 2}
d = {0, 0, L1, L0, 0.1, L3, L2}
theta = {qm, d1, q3, q4, N5*qm, q6, 0}
gamma = {0, 0, 0, 0, 0, 0, pi/2}
mu = {1, 1, 0, 0, 0, 0, 0}
M = {1, 2, 3, 4, 5}
YY = {0.1, 0.2, 0.3, 0.4, 0}
ZZ = {0.1, 0.2, 0.3, 0.4, ZZ5}
IA = {0.5, 0, 0, 0, 0}
eta = {0, 1, 0, 0, 0, 0}
k = {0, K1*(2 + qm), 0, 0, 0, 0}
QP = {QP1, QP2, QP3, QP4, QP5, QP6}
G = {0, -9.81, 0}
(*! values = {L0 = 0.3, L1 = 0.1, L2 = 0.35, L3 = 0.2} *)
(*! start = {qm = 1.0, d1 = 0, q3 = -0.6, q4 = 1.4, q6 = pi/4} *)
"""
"""A four-bar linkage with an elastic crank and a geared rotor: a loop, a coupling, a stiffness that varies."""

NAMES = ("L1", "L2", "m_arm", "Kx", "angle", "b7")
UNITS = ("", "m", "N m/rad", "N·m·s/rad", "kg*m²", "1/s", "m^-1")

plain_numbers = st.one_of(
    st.integers(-(10**9), 10**9).map(str),
    st.decimals(-1000, 1000, allow_nan=False, places=4).map(str),
    st.sampled_from(["0.0", "-0", "-0.0", "1e-3", "2.5E+3", "4.0e7", "007", "+5", "1.", ".5", "0.1e-90"]),
)
names = st.sampled_from(NAMES)
compound = st.builds(
    str.format,
    st.sampled_from(
        [
            "{0}",
            "-{0}",
            "{0} + {1}",
            "{0}*({1} - 2)",
            "atan2({0}, 1 + {1}^2)",
            "pi/2",
            "-Pi/2",
            "sqrt(2)*{0}",
            "(-{0})/3",
        ]
    ),
    names,
    names,
)
formulas = st.one_of(st.just(ZERO), st.one_of(plain_numbers, compound).map(Formula.parse))
numbers = plain_numbers.map(Formula.parse)
vectors = st.one_of(st.just((ZERO,) * 3), st.tuples(formulas, formulas, formulas))
# Short expressions, no tiny numbers: the inertia of a central body must have a text about the origin.
small_texts = st.one_of(plain_numbers, names).filter(lambda text: "e-300" not in text)
small = st.one_of(st.just(ZERO), small_texts.map(Formula.parse))
small_vectors = st.tuples(small, small, small)
bodies = st.one_of(
    st.just(Body()),
    st.builds(Body, formulas, vectors, st.tuples(*[formulas] * 6), st.just(False)),
    st.builds(Body, small, small_vectors, st.tuples(*[small] * 6), st.just(True)),
)
texts = st.text(st.characters(exclude_categories=["Cs"]), max_size=12)


@st.composite
def joints(draw: st.DrawFn, j: int) -> Joint:
    sigma = draw(st.sampled_from([0, 1, 2]))
    kind = Kind.FIXED if sigma == 2 else draw(st.sampled_from([Kind.MOTOR, Kind.ELASTIC, Kind.PASSIVE]))
    stiffness = draw(st.sampled_from(["K2", "1e7", "2*Kx"])) if kind == Kind.ELASTIC else "0"
    return Joint(
        name=draw(st.sampled_from([f"j{j}", f"axis_{j}"])),
        antecedent=draw(st.integers(0, j - 1)),
        kind=kind,
        sigma=sigma,
        variable=None if sigma == 2 else f"x{j}",
        body=draw(bodies),
        spring=Spring(Formula.parse(stiffness), draw(formulas), draw(formulas)) if kind == Kind.ELASTIC else Spring(),
        friction=draw(st.builds(Friction, formulas, formulas)),
        rotor_inertia=draw(formulas),
        wrench=draw(st.builds(Wrench, vectors, vectors)),
        **{cell: draw(formulas) for cell in ("gamma", "b", "alpha", "d", "theta", "r")},
    )


@st.composite
def scenes(draw: st.DrawFn, moving: list[str]) -> Scene:
    some = st.lists(st.sampled_from(moving), unique=True) if moving else st.just([])
    divided = st.sampled_from([name for name, model in MODELS.items() if model.parts is not Parts.WHOLE])
    outputs = {model: tuple(draw(some)) for model in draw(st.lists(divided, unique=True, max_size=2))}
    return Scene(
        models=tuple(draw(st.lists(st.sampled_from(tuple(MODELS)), unique=True, max_size=3))),
        outputs=outputs,
        locked={joint: draw(numbers) for joint in draw(some)},
        fold=draw(st.sampled_from([(), ALL, ("Kx",), ("L2", "L1")])),
        gravity=draw(st.booleans()),
    )


@st.composite
def machines(draw: st.DrawFn) -> DescribedMachine:
    rows = tuple(draw(joints(j)) for j in range(1, draw(st.integers(1, 4)) + 1))
    values = st.one_of(st.none(), numbers, st.just(Formula.parse("pi/3")))
    moving = [joint.name for joint in rows if joint.sigma != 2]
    order = draw(st.permutations([*NAMES, "K2"]))
    extras = st.dictionaries(st.sampled_from(["QP", "Z", "k", "mu", "Type", "odd key", "x"]), texts, max_size=3)
    return DescribedMachine(
        name=draw(st.sampled_from(["arm", "two_axis"])),
        joints=rows,
        parameters=tuple(Parameter(name, draw(values), draw(st.sampled_from(UNITS))) for name in order),
        base=draw(st.builds(Base, vectors, vectors, vectors, vectors, vectors)),
        asked=Request(draw(st.one_of(st.none(), scenes(moving)))),
        origin=Origin(notes=tuple(draw(st.lists(texts, max_size=3))), extras=draw(extras)),
    )


@st.composite
def coupled_machines(draw: st.DrawFn) -> DescribedMachine:
    """A machine whose cells hold variables of other joints, of rows above and below, without a cycle; its loops."""
    machine = draw(machines())
    order = draw(st.permutations(range(1, len(machine.joints) + 1)))
    rows = list(machine.joints)
    for place, j in enumerate(order):
        leaders = [str(rows[k - 1].variable) for k in order[:place] if rows[k - 1].variable]
        if rows[j - 1].sigma != 2 and leaders:
            rows[j - 1] = draw(_following(rows[j - 1], leaders))
    ends = (
        Joint("pin", draw(st.integers(0, len(rows))), Kind.CUT, 0, "x_pin", theta=draw(formulas)),
        Joint("pin_end", draw(st.integers(0, len(rows))), Kind.FIXED, 2, d=draw(formulas)),
    )
    loops = draw(st.sampled_from([(), _loops(draw, rows)]))
    return replace(machine, joints=(*rows, *ends) if loops else tuple(rows), loops=loops).asking(scene=None)


@st.composite
def _following(draw: st.DrawFn, joint: Joint, leaders: list[str]) -> Joint:
    """The joint as it is, with a formula of others' variables added to its own, or with that formula only."""
    first, second = draw(st.sampled_from(leaders)), draw(st.sampled_from(leaders))
    written = ["L1*{0}", "-Kx*{0} + {1}/L2", "({0} + {1})/2", "sin({0})*{1} - pi/2", "-({0} - {1})"]
    text = draw(st.sampled_from(written))
    cell = Formula.parse(text.format(first, second))
    way = draw(st.integers(0, 2))
    if way == 0:
        return joint
    if way == 1:
        return joint.with_selected(cell)
    return replace(joint, kind=Kind.COUPLED, variable=None, spring=Spring()).with_selected(cell)


def _loops(draw: st.DrawFn, rows: list[Joint]) -> tuple[Loop, ...]:
    own = [joint for joint in rows if joint.variable]
    dependent = tuple(joint.name for joint in own if draw(st.booleans()))
    start = {str(joint.variable): draw(formulas) for joint in own} if draw(st.booleans()) else {}
    closes = draw(st.sampled_from([Closing.FRAME, Closing.POINT]))
    return (Loop("ring", len(rows) + 1, len(rows) + 2, closes, dependent, start),)


BY_AXIS = """joints = [
  { name = "a", kind = "motor", sigma = 0, axis = "z", at = ["L", 0, 0] },
  { name = "b", kind = "motor", sigma = 1, axis = [0, 0.6, 0.8], at = [0, 0, 1], in = "a" },
  { name = "c", antecedent = "a", kind = "coupled", sigma = 0, axis = "x", theta = "2*q1" },
  { name = "t", kind = "fixed", axis = "-x" },
]
gravity = [0, 0, -9.81]
[parameters]
L = 0.3
[bodies]
b = { mass = 1, center_of_mass = [0, 0, 0.1], inertia = [1, 2, 3] }
[frames]
eye = { on = "b", at = [0, 0, 0], rpy = [0, 0, 0.1] }
"""
"""Rows by axis and point."""
