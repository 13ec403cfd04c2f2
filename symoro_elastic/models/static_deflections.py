"""Models of springs that are left out of the motion: their deflections, and the frames where these are put in.

The joints E of static springs stand still, v_E = a_E = 0, at the positions where the scene holds them. The reaction
there follows from the rigid inverse model in the motion of the other joints,
    Gamma_E = a . f,    q_E = q0_E - Gamma_E / k_E.
What is left out is second order in the deflections, and the inertia that resists their change.
"""

from __future__ import annotations

from symoro_elastic.foundation.scalar import Scalar
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Parts
from symoro_elastic.machine.static_springs import with_free_springs
from symoro_elastic.mechanics.dynamics import Dynamics, dynamics
from symoro_elastic.mechanics.spatial import Axis
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.geometric import geometric_model
from symoro_elastic.models.model import ORIENTATION, Joints, Model, Result, Results
from symoro_elastic.models.naming import name_dynamics
from symoro_elastic.models.rules import given_rules
from symoro_elastic.models.state import position_blocks

DEFLECTIONS = "static_deflections"
PLACED = "geometric_model_with_deflections"


def _static_deflections(bound: Bound, _: Joints) -> Results:
    machine = bound.machine
    _refuse_without_static_springs(machine, DEFLECTIONS)
    found = dynamics(bound.mechanism, bound.rates(), given_rules(bound))
    name_dynamics(bound, found, "[15]", "[61]")
    entries: list[Scalar] = []
    for j, joint in machine.static.items():
        neutral, stiffness = bound.cell(joint.spring.neutral), bound.cell(joint.spring.stiffness)
        entries.append(neutral - _reaction(found, j, Axis(joint.sigma)) / stiffness)  # (9)
    return {"q_static": Result(tuple(machine.static), tuple(entries))}


def _reaction(found: Dynamics, j: int, axis: Axis) -> Scalar:
    """Force that the motion asks of joint j, which is held: that of its rotor too where it follows other joints."""
    return found.Gamma[j] if j in found.Gamma else axis.T * found.f[j]  # (17), (61)


def _placed(machine: Machine) -> Machine:
    _refuse_without_static_springs(machine, PLACED)
    return with_free_springs(machine)


def _arguments(bound: Bound, _: Results) -> dict[str, tuple[str, ...]]:
    """q of the joints that stay in the motion, then the variables of the static ones."""
    names = bound.arguments()
    static, position = names["q_static"], {name: names[name] for name in position_blocks(bound.machine)}
    return position | {"q": tuple(name for name in names["q"] if name not in static), "q_static": static}


def _refuse_without_static_springs(machine: Machine, model: str) -> None:
    if not machine.static:
        what = 'no spring is static: name those to be left out of the motion in a scene, static = ["name"]'
        raise machine.error(model, what)


FAMILY = "static springs"
STATIC_SPRINGS = (
    Model(
        DEFLECTIONS,
        "variables of static joints from the reactions there",
        "[9], [15], [35], [58]",
        ("q", "qd", "qdd"),
        ("q_static",),
        _static_deflections,
        FAMILY,
        Parts.WHOLE,
        on_base=(ORIENTATION, "V0", "V0d"),
    ),
    Model(
        PLACED,
        "placement of frames with static springs deflected",
        "[1], [2]",
        ("q", "q_static"),
        ("T",),
        geometric_model,
        FAMILY,
        Parts.POINTS,
        own_arguments=_arguments,
        on_base=(),
        binds=_placed,
    ),
)
