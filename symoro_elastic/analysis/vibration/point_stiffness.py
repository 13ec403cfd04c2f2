"""How a frame gives way to a force on it: statically, and at the frequency where it moves most, and by which springs.

Static: K u = F. At a frequency: (K + s D + s^2 M) u = F with s = i omega, seen when the point is farthest away. The
springs that limit it are those with most of the strain energy of u.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from symoro_elastic.analysis.vibration.energies import GRAVITY_AND_LOADS, strain_shares
from symoro_elastic.analysis.vibration.linearization import Linearization
from symoro_elastic.analysis.vibration.modes import Modes, modes
from symoro_elastic.analysis.vibration.peaks import response_figures
from symoro_elastic.analysis.vibration.responses import Response, frequency_response
from symoro_elastic.foundation.array_types import AnyArray, Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.numerics.motion.signals import FrameSignal, inputs, outputs

LEAST_SHARE = 0.005


@dataclass(frozen=True)
class PointStiffness:
    """A point under a force along one direction: `static` compliance, `peak` of its response at `frequency`, Hz.

    SI units of `output` over `source`; NaN where motors are free, so that nothing holds the point. The peak is infinite
    where nothing damps it: `frequency` is that of the mode that moves the point most. `held_by` and `shaken_by` are
    shares of strain energy by spring, the largest first.
    """

    output: str
    source: str
    unit: str
    static: float
    held_by: dict[str, float]
    peak: float
    frequency: float
    shaken_by: dict[str, float]

    @property
    def stiffness(self) -> float:
        """The inverse of the static compliance."""
        return 1 / self.static if self.static else np.inf

    @property
    def stiffness_unit(self) -> str:
        """N/m, or N m/rad."""
        return "N/m" if self.unit.startswith("m ") else "N m/rad"

    @property
    def sentence(self) -> str:
        """Both compliances, with the springs that limit them."""
        said = f"{self.output} under {self.source}"
        if np.isfinite(self.static):
            said += f": {self.stiffness:.4g} {self.stiffness_unit} at rest{_first(self.held_by)}"
        if np.isinf(self.peak):
            return f"{said}; undamped resonance at {self.frequency:.4g} Hz{_first(self.shaken_by)}"
        if not self.frequency > 0:
            return said
        return f"{said}; largest at {self.frequency:.4g} Hz, {self.peak:.4g} {self.unit}{_first(self.shaken_by)}"


def _first(shares: dict[str, float]) -> str:
    return "".join(f", limited by {name} ({share:.0%} of the strain energy)" for name, share in [*shares.items()][:1])


def point_stiffnesses(linear: Linearization, found: Response) -> tuple[PointStiffness, ...]:
    """Return the stiffness of each frame that is pushed along a direction in which its displacement is seen."""
    machine = linear.motion.given
    forces, seen = inputs(machine, linear.inputs), outputs(machine, linear.outputs)
    pairs = [
        (i, j)
        for j, force in enumerate(forces)
        for i, moved in enumerate(seen)
        if isinstance(force, FrameSignal) and isinstance(moved, FrameSignal) and moved.order == 0
        if (force.number, force.component, force.at) == (moved.number, moved.component, moved.at)
    ]
    return tuple(_of_pair(linear, found, i, j) for i, j in pairs if linear.F[:, j].any())


def _of_pair(linear: Linearization, found: Response, i: int, j: int) -> PointStiffness:
    output, source = linear.outputs[i], linear.inputs[j]
    at_rest = frequency_response(linear, np.zeros(1)).values[0, i, j]
    figures = response_figures(linear)
    peak, f = (figures[f"{output} / {source}: {name}"] for name in ("peak", "peak_frequency"))
    f, shaken = _undamped(linear, i, j, f) if np.isinf(peak) else (f, _shaken(linear, i, j, f))
    held = _shares(linear, np.linalg.solve(linear.K, linear.F[:, j])) if np.isfinite(at_rest) else {}
    return PointStiffness(output, source, found.unit(output, source), float(abs(at_rest)), held, peak, f, shaken)


def _shaken(linear: Linearization, i: int, j: int, hertz: float) -> dict[str, float]:
    """Return the shares where the point is farthest away, at a frequency."""
    if not hertz > 0:
        return {}
    s = 2j * np.pi * hertz
    u = np.linalg.solve(s * s * linear.M + s * linear.D + linear.K, linear.F[:, j].astype(complex))
    y = linear.Cq[i] @ u
    return _shares(linear, (u * np.conj(y) / abs(y)).real) if abs(y) else {}


def _undamped(linear: Linearization, i: int, j: int, hertz: float) -> tuple[float, dict[str, float]]:
    """Return the frequency of the mode with the largest compliance C phi phi^T F / omega^2, and its shares.

    With one damping ratio in all modes its peak is the highest; a mode in which the point stands still has none.
    """
    try:
        modal = modes(linear)
    except InputError:
        return hertz, {}
    moved = np.abs((linear.Cq[i] @ modal.shapes) * (linear.F[:, j] @ modal.shapes))
    k = int(np.divide(moved, modal.eigenvalues, out=np.zeros_like(moved), where=modal.eigenvalues > 0).argmax())
    return float(modal.frequencies[k]), _shares(linear, modal.shapes[:, k])


def _shares(linear: Linearization, u: AnyArray) -> dict[str, float]:
    """Return the springs' shares of the strain energy of a deflection, the largest first."""
    one: Array = np.ones(1)
    found = strain_shares(Modes(linear, one, np.real(u)[:, None], one, np.zeros(0, dtype=complex))).by_name
    springs = {name: float(x[0]) for name, x in found.items() if name != GRAVITY_AND_LOADS and x[0] > LEAST_SHARE}
    return dict(sorted(springs.items(), key=lambda pair: -pair[1]))
