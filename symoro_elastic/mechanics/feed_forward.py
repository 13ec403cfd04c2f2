"""Feed-forward through elastic joints: the chain as seen from its load side.

Where springs follow a motor about (or along) one axis, the pose of the body beyond them depends on the sum
y = q_motor + q_springs only. Each of these bodies is mounted on the antecedent of the motor, in parallel, with a
coordinate of its own:

    z_0 = q_motor,  z_i = z_(i-1) + s_i q_i,  y = z_last,

s_i being the sense of axis i. The inverse model of this tree gives torques Gamma'_i, and from the tip

    s_i Gamma_i = s_i Gamma'_i + s_(i+1) Gamma_(i+1),   Gamma_motor = Gamma'_0 + s_1 Gamma_1,

and a spring without damping gives its deflection, Gamma_i = -k_i (q_i - q0_i) [9]. So y determines z_(last-1) with two
more derivatives, that one the next, down to the motor (Buondonno and De Luca, 2015).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from itertools import pairwise

from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import EZ, AxialTransform, Axis, Transform, is_zero


@dataclass(frozen=True)
class Drive:
    """A motor, or another joint, and the springs that it drives on its axis; `senses` are +1 or -1 against it."""

    joints: tuple[int, ...]
    senses: tuple[int, ...]


def sense(mechanism: Mechanism, first: int, second: int) -> int:
    """1 or -1 where the motion of joint `first` can be added to that of joint `second` on its body, else 0.

    Slides need one direction, turns one line too; only what holds for all values of the parameters counts.
    """
    carrier, transform = _carrier(mechanism, second)
    axis = mechanism.link(second).axis
    if carrier != first or mechanism.link(first).axis is not axis:
        return 0
    x, y, z = transform.to_antecedent(EZ)
    across = transform.origin[:2] if axis is Axis.REVOLUTE else ()
    if not all(map(is_zero, (x, y, *across))):
        return 0
    return is_zero(z - 1) - is_zero(z + 1)


def _carrier(mechanism: Mechanism, j: int) -> tuple[int, Transform]:
    """The moving body (or base) that carries joint j, and the transform from it without the joint's own step."""
    link = mechanism.link(j)
    i, transform = link.antecedent, Transform(link.transform.steps[:-1])
    while i and mechanism.link(i).axis is Axis.NONE:
        i, transform = mechanism.link(i).antecedent, transform.after(mechanism.link(i).transform)
    return i, transform


def mounted_in_parallel(mechanism: Mechanism, found: Sequence[Drive], held: Mapping[int, AxialTransform]) -> Mechanism:
    """The mechanism in which every body of a drive is mounted on the antecedent of its first joint.

    `held[j]` is the last axial transform of joint j at zero of its variable; the variable of joint j becomes s_j z_j.
    """
    links = list(mechanism.links)
    for drive in found:
        first = links[drive.joints[0] - 1]
        antecedent, steps = first.antecedent, first.transform.steps[:-1]
        for before, j in pairwise(drive.joints):
            link = links[j - 1]
            steps = (*steps, held[before], *_carrier(mechanism, j)[1].steps)
            transform = Transform((*steps, link.transform.steps[-1]))
            links[j - 1] = replace(link, antecedent=antecedent, transform=transform)
    return replace(mechanism, links=tuple(links))
