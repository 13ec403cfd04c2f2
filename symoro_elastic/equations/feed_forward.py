"""Feed-forward through elastic joints: the chain as its outboard side sees it.

Where springs follow a motor about (or along) one axis, the place of the body beyond them depends on the
sum y = q_motor + q_springs only. Each of these bodies is hung on the antecedent of the motor, side by
side, with a coordinate of its own:

    z_0 = q_motor,  z_i = z_(i-1) + s_i q_i,  y = z_last,

s_i being the sense of axis i. Newton and Euler's torques Gamma'_i of this tree give, from the tip,

    s_i Gamma_i = s_i Gamma'_i + s_(i+1) Gamma_(i+1),   Gamma_motor = Gamma'_0 + s_1 Gamma_1,

and a spring without damping gives its deflection, Gamma_i = -k_i (q_i - q0_i) [9]. So y fixes z_(last-1)
with two more derivatives, that one the next, down to the motor (Buondonno and De Luca, 2015).
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from symoro_elastic.equations.mechanism import Axis, Mechanism
from symoro_elastic.equations.spatial import Placement, Screw, Vector, is_zero, origin, to_antecedent

ALONG: Vector = (0, 0, 1)


@dataclass(frozen=True)
class Drive:
    """A motor and the springs behind it on its axis, from the motor outwards; `senses` are +1 or -1 against it."""

    joints: tuple[int, ...]
    senses: tuple[int, ...]

    @property
    def motor(self) -> int:
        """Number of the motor."""
        return self.joints[0]


def drives(mechanism: Mechanism, motors: Collection[int], elastic: Collection[int]) -> list[Drive]:
    """Every motor with the springs behind it, as long as there is one spring on its axis and no more."""
    found = []
    for motor in motors:
        joints, senses = [motor], [1]
        while True:
            behind = [(j, s) for j in sorted(elastic) if (s := _sense(mechanism, joints[-1], j))]
            if len(behind) != 1:
                break
            joints.append(behind[0][0])
            senses.append(senses[-1] * behind[0][1])
        found.append(Drive(tuple(joints), tuple(senses)))
    return found


def _sense(mechanism: Mechanism, first: int, second: int) -> int:
    """1 or -1 where the motion of joint `first` can be added to that of joint `second` on its body, else 0.

    Slides need one direction, turns one line too; only what holds for all values of the parameters counts.
    """
    carrier, placement = _carried(mechanism, second)
    axis = mechanism.links[second - 1].axis
    if carrier != first or mechanism.links[first - 1].axis is not axis:
        return 0
    x, y, z = to_antecedent(placement, ALONG)
    across = origin(placement)[:2] if axis is Axis.REVOLUTE else ()
    if not all(map(is_zero, (x, y, *across))):
        return 0
    return is_zero(z - 1) - is_zero(z + 1)


def _carried(mechanism: Mechanism, j: int) -> tuple[int, Placement]:
    """The moving body (or base) that carries joint j, and its placement there without the last screw."""
    i, placement = mechanism.links[j - 1].antecedent, mechanism.links[j - 1].placement[:-1]
    while i and mechanism.links[i - 1].axis is Axis.NONE:
        i, placement = mechanism.links[i - 1].antecedent, mechanism.links[i - 1].placement + placement
    return i, placement


def hung_side_by_side(mechanism: Mechanism, found: Sequence[Drive], held: Mapping[int, Screw]) -> Mechanism:
    """The mechanism in which every body of a drive hangs on the antecedent of its motor.

    `held[j]` is the last screw of joint j at zero of its variable; the variable of joint j becomes s_j z_j.
    """
    links = list(mechanism.links)
    for drive in found:
        antecedent, place = links[drive.motor - 1].antecedent, links[drive.motor - 1].placement[:-1]
        for before, j in pairwise(drive.joints):
            place = (*place, held[before], *_carried(mechanism, j)[1])
            links[j - 1] = replace(links[j - 1], antecedent=antecedent, placement=(*place, links[j - 1].placement[-1]))
    return replace(mechanism, links=tuple(links))
