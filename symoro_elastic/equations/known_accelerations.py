"""What is known of the accelerations of bodies before the backward recursion finds them.

V'_j = known_j + rest_j: the known part comes of gravity and of velocities. The rest obeys [6] with what is then
left of g_j, and b_j takes - JJ_j known_j. The fewer entries g_j has, the fewer products with K_j.
"""

from __future__ import annotations

from dataclasses import replace

from symoro_elastic.equations.mechanism import Axis, Mechanism
from symoro_elastic.equations.spatial import NOTHING, ZERO, Pair, add, to_child, turn_back

REACH = 4
"""Bodies in a row that pass on what is known of their accelerations: sums over more bodies would lose digits."""


def with_unturned_tips(mechanism: Mechanism, released: set[int]) -> Mechanism:
    """Released bodies that carry none are seen from frames that lack the last turn.

    Such a body turns with fewer operations than its articulated inertia, its wrench and its motion.
    """
    tips = released - {link.antecedent for link in mechanism.links}
    links = tuple(link.seen_unturned() if j in tips else link for j, link in mechanism.numbered())
    return replace(mechanism, links=links)


def anticipate(mechanism: Mechanism, released: set[int], g: list[Pair], known: dict[int, Pair]) -> None:
    """Part of V'_j that is known of each released body, and g_j [7] without it.

    A revolute joint passes linear accelerations on; a prismatic one, and every fourth body, leave them to g_j.
    Where nothing follows, all of g_j is known.
    """
    carrying = {link.antecedent for link in mechanism.links}
    row = [0]
    for j, link in mechanism.numbered():
        row.append(row[link.antecedent] + 1)
        if j not in released:
            continue
        linear, angular = g[j]
        linear = add(linear, to_child(link.unturned, known[link.antecedent][0]))
        if j not in carrying:
            known[j], g[j] = (linear, angular), NOTHING
        elif link.axis is Axis.REVOLUTE and row[j] % REACH:
            known[j], g[j] = (turn_back(link.last_turn, linear), ZERO), (ZERO, angular)
        else:
            known[j], g[j] = NOTHING, (linear, angular)
