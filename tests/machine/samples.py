"""A small machine in both formats, for tests that damage it, and machines at random."""

from __future__ import annotations

from hypothesis import strategies as st

from symoro_elastic.machine.formula import ZERO, Formula
from symoro_elastic.machine.machine import (
    Base,
    Body,
    Friction,
    Joint,
    Kind,
    Machine,
    Parameter,
    Spring,
    Wrench,
)
from symoro_elastic.machine.scene import ALL, Parts, Scene
from symoro_elastic.models.catalogue import MODELS

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
UNITS = ("", "m", "N m/rad", 'a "b" \\ *)', "kg*m", "{}", "é, =")

plain_numbers = st.one_of(
    st.integers(-(10**9), 10**9).map(str),
    st.decimals(-1000, 1000, allow_nan=False, places=4).map(str),
    st.sampled_from(["0.0", "-0", "-0.0", "1e-3", "2.5E+3", "4.0e7", "007", "+5", "1.", ".5", "0.1e-300"]),
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
def machines(draw: st.DrawFn) -> Machine:
    rows = tuple(draw(joints(j)) for j in range(1, draw(st.integers(1, 4)) + 1))
    values = st.one_of(st.none(), numbers, st.just(Formula.parse("pi/3")))
    moving = [joint.name for joint in rows if joint.sigma != 2]
    order = draw(st.permutations([*NAMES, "K2"]))
    extras = st.dictionaries(st.sampled_from(["QP", "Z", "k", "mu", "Type", "odd key", "x"]), texts, max_size=3)
    return Machine(
        name=draw(st.sampled_from(["arm", "two_axis"])),
        joints=rows,
        parameters=tuple(Parameter(name, draw(values), draw(st.sampled_from(UNITS))) for name in order),
        base=draw(st.builds(Base, vectors, vectors, vectors, vectors, vectors)),
        scene=draw(st.one_of(st.none(), scenes(moving))),
        notes=tuple(draw(st.lists(texts, max_size=3))),
        extras=draw(extras),
    )
