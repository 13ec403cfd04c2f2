"""Compliance of a frame to a force: static, and at the resonance of largest motion, and the responsible springs.

Static: K u = F. At a frequency: (K + s D + s^2 M) u = F with s = i omega, seen when the point is farthest away. The
springs that limit it are those with most of the strain energy of u.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.modes import GRAVITY_AND_LOADS, Modes, modes, strain_shares
from symoro_elastic.analysis.vibration.peaks import response_figures
from symoro_elastic.analysis.vibration.responses import PointStiffness, Response, frequency_response
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.motion.signals import FrameSignal, inputs, outputs

LEAST_SHARE = 0.005


def point_stiffnesses(linear: Linearization, response: Response) -> tuple[PointStiffness, ...]:
    """Return the stiffness of the frames with a force input and a displacement output in its direction."""
    machine = linear.motion.given
    forces, displacements = inputs(machine, linear.inputs), outputs(machine, linear.outputs)
    pairs = [
        (i, j)
        for j, force in enumerate(forces)
        for i, moved in enumerate(displacements)
        if isinstance(force, FrameSignal) and isinstance(moved, FrameSignal) and moved.order == 0
        if (force.number, force.component, force.at) == (moved.number, moved.component, moved.at)
    ]
    moving = [(i, j) for i, j in pairs if linear.F[:, j].any()]
    if not moving:
        return ()
    figures, at_rest = response_figures(linear), frequency_response(linear, np.zeros(1)).values[0]  # NaN of free ones
    return tuple(_of_pair(linear, response, figures, at_rest[i, j], i, j) for i, j in moving)


def _of_pair(
    linear: Linearization, response: Response, figures: Mapping[str, float], at_rest: complex, i: int, j: int
) -> PointStiffness:
    output, source = linear.outputs[i], linear.inputs[j]
    peak, f = (figures[f"{output} / {source}: {name}"] for name in ("peak", "peak_frequency"))
    f, shaken = _undamped_resonance(linear, i, j, f) if np.isinf(peak) else (f, _shaken(linear, i, j, f))
    static = spring_shares(linear, np.linalg.solve(linear.K, linear.F[:, j])) if np.isfinite(at_rest) else {}
    return PointStiffness(output, source, response.unit(output, source), float(abs(at_rest)), static, peak, f, shaken)


def _shaken(linear: Linearization, i: int, j: int, hertz: float) -> dict[str, float]:
    """Return the springs' shares of strain energy at a frequency, when the point's displacement is largest."""
    if not hertz > 0:
        return {}
    u = linear.displacements(np.array([2j * np.pi * hertz]), linear.F[:, [j]])[0, :, 0]
    y = linear.Cq[i] @ u
    return spring_shares(linear, (u * np.conj(y) / abs(y)).real) if abs(y) else {}


def _undamped_resonance(linear: Linearization, i: int, j: int, hertz: float) -> tuple[float, dict[str, float]]:
    """Return the frequency of the mode with the largest compliance C phi phi^T F / omega^2, and its shares.

    With one damping ratio in all modes its peak is the highest; a mode in which the point stands still has none.
    """
    try:
        modal = modes(linear)
    except InputError:
        return hertz, {}
    moved = np.abs((linear.Cq[i] @ modal.shapes) * (linear.F[:, j] @ modal.shapes))
    k = int(np.divide(moved, modal.eigenvalues, out=np.zeros_like(moved), where=modal.eigenvalues > 0).argmax())
    return float(modal.frequencies[k]), spring_shares(linear, modal.shapes[:, k])


def spring_shares(linear: Linearization, u: AnyArray) -> dict[str, float]:
    """Return the springs' shares of the strain energy of a deflection, the largest first."""
    unit_mass: Array = np.ones(1)
    bent = Modes(linear, unit_mass, np.real(u)[:, None], unit_mass, np.zeros(0, dtype=complex), np.full(1, -1))
    by_spring = strain_shares(bent).by_name
    springs = {name: float(x[0]) for name, x in by_spring.items() if name != GRAVITY_AND_LOADS and x[0] > LEAST_SHARE}
    return dict(sorted(springs.items(), key=lambda pair: -pair[1]))
