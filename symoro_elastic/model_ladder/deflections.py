"""How placements of frames change with the motion where static springs deflect by the reactions in it.

    dx = J_R dq_R + J_E dq_E,    dq_E = (dq_E/dq_R) dq_R + (dq_E/dv_R) dv_R + (dq_E/da_R) da_R

R are the joints that move, E those of the static springs; q_E(q_R, v_R, a_R) is the model `static_deflections`.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np

from symoro_elastic.array_types import Array
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.static_springs import with_free_springs
from symoro_elastic.model_ladder.samples import slopes
from symoro_elastic.numerics.implementations import numpy_model

Three = tuple[Array, Array, Array]
Deflections = Callable[[Array, Array, Array], Array]
"""q_E (N, s) of states q, v, a (N, n)."""


def placement_rows(machine: Machine, frames: Sequence[str], states: Three, deflections: Deflections) -> Three:
    """Return the derivatives (N, frames, 6, n) of placements by q, v, a of the joints that move; SI units, frame 0."""
    free = replace(with_free_springs(machine), static={})
    static = {joint.name for joint in machine.static.values()}
    names = [joint.name for joint in free.moving_joints]
    E = [k for k, name in enumerate(names) if name in static]
    R = [k for k, name in enumerate(names) if name not in static]
    q, v, a = states
    placed = np.zeros((len(q), len(names)))
    placed[:, R], placed[:, E] = q, deflections(q, v, a)
    J = numpy_model(free, ("jacobian",), {"jacobian": tuple(frames)}).jacobian(placed)
    by_q, by_v, by_a = (
        np.einsum("tfce,ten->tfcn", J[..., E], x)
        for x in (
            slopes(lambda q: deflections(q, v, a), q),
            slopes(lambda v: deflections(q, v, a), v),
            slopes(lambda a: deflections(q, v, a), a),
        )
    )
    return J[..., R] + by_q, by_v, by_a
