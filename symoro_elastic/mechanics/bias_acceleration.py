"""The part of a body's acceleration that is known before the backward recursion.

    V'_j = bias_j + remainder_j

The bias comes from gravity and velocities. With it, [6] holds for the remainders with what is left of gamma_j,

    remainder_j = jTi remainder_i + qdd_j a_j + gamma_j,   gamma_j = jTi bias_i + gamma_j [7] - bias_j,

and Newton-Euler [12] with beta_j = beta_j [14] - JJ_j bias_j. The recursion then is the printed one, with fewer
products: where gamma_j = 0, or has no linear part, K_j gamma_j in [30] costs less or nothing.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import replace

from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import AT_REST, ZERO, Axis, Twist

REACH = 4
"""Links in a row that pass their bias on; sums over more links would lose digits."""


def with_tips_in_frames_before(mechanism: Mechanism, unknown: Collection[int]) -> Mechanism:
    """The mechanism with its tips of unknown acceleration described in the frames before their joints' rotations.

    Rotating the body once needs fewer operations than rotating its articulated inertia, wrench and motion.
    """
    tips = set(unknown) - mechanism.carriers
    links = tuple(link.in_frame_before() if j in tips else link for j, link in mechanism.from_base())
    return replace(mechanism, links=links)


def bias_accelerations(
    mechanism: Mechanism, unknown: Collection[int], known: Mapping[int, Twist], gamma: Sequence[Twist]
) -> tuple[dict[int, Twist], list[Twist]]:
    """Biases of links, and the remainder of their gamma [7]; `known` are those of links before the unknown ones.

    A revolute joint passes linear accelerations on; a prismatic one, and every fourth link, leave them to gamma. At a
    tip all of gamma is bias.
    """
    bias, left = dict(known), list(gamma)
    row, carriers = [0], mechanism.carriers
    for j, link in mechanism.from_base():
        row.append(row[link.antecedent] + 1)
        if j not in unknown:
            continue
        linear, angular = gamma[j]
        linear = linear + link.before.to_child(bias[link.antecedent].linear)
        if j not in carriers:
            bias[j], left[j] = Twist(linear, angular), AT_REST
        elif link.axis is Axis.REVOLUTE and row[j] % REACH:
            bias[j], left[j] = link.joint_rotation * Twist(linear, ZERO), Twist(ZERO, angular)
        else:
            bias[j], left[j] = AT_REST, Twist(linear, angular)
    return bias, left
