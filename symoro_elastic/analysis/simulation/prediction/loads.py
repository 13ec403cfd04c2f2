"""Friction that rises with the torque through its joint, in the linear model along a motion.

    Gamma_f = (g(v) + mu |lambda|) s(v) + Fv v,    lambda = ID(q, v, a) - Ia a - spring - Gamma_f

lambda is what the joint passes on: its row of the inverse model without what acts on the joint itself. So it does not
depend on the friction, and its change is that of its row of M, D and K without rotor, spring, damper, friction:

    d Gamma_f = mu s sign(lambda) d lambda + mu |lambda| s'(v) d v
"""

from __future__ import annotations

from dataclasses import dataclass
from inspect import signature

import numpy as np

from symoro_elastic.analysis.simulation.compiled_steps import Trajectory
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.foundation.array_types import Array
from symoro_elastic.machine.joints import Joint, Kind
from symoro_elastic.numerics.implementations import numpy_model
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion


@dataclass(frozen=True)
class PassedLoad:
    """A joint whose friction rises with load along a motion: its entry k, what acts on it, its sense s and slope s'.

    `own` (N,) and `slope` (N,) are forces of its spring, damper and friction without load and their derivative by v,
    `share` mu, `rotor` Ia, `stiffness` that of its spring.
    """

    k: int
    own: Array
    slope: Array
    sense: Array
    rise: Array
    share: float
    rotor: float
    stiffness: float

    def passed(self, taken: Array, a: Array) -> Array:
        """Return lambda (N,) by the forces taken without load in friction, and accelerations (N, n)."""
        found: Array = taken[:, self.k] - self.own - self.rotor * a[:, self.k]
        return found

    def add(self, M: Array, D: Array, K: Array, taken: Array, a: Array) -> Array:
        """Add this friction to M, D, K (N, n, n) and to the forces taken (N, n); return its slope by v (N,)."""
        k, unit, passed = self.k, np.eye(a.shape[1])[self.k], self.passed(taken, a)
        at_load = self.share * np.sign(passed) * self.sense
        rise: Array = self.share * np.abs(passed) * self.rise
        taken[:, k] += self.share * np.abs(passed) * self.sense
        for matrix, of_joint in ((M, self.rotor), (D, self.slope[:, None]), (K, self.stiffness)):
            matrix[:, k] += at_load[:, None] * (matrix[:, k] - of_joint * unit)
        D[:, k, k] += rise
        return rise


def with_passed_loads(reference: Reference, found: Trajectory) -> Trajectory:
    """Return the motion of a machine all of whose joints are motors that follow exactly, with the loads of friction."""
    machine, order = reference.loaded, np.argsort(reference.machine.motor_entries)
    if not machine.loaded:
        return found
    given = {"qdd_motor": reference.at(found.t)[2], "load": np.zeros((len(found.t), len(machine.loaded)))}
    given["f_ext"], _ = reference.wrenches(found.t)
    model = numpy_model(machine, ("inverse_dynamics",)).inverse_dynamics
    tau = model(found.q, found.qd, **{name: x for name, x in given.items() if name in signature(model).parameters})
    a, taken = (x[:, order] for x in (given["qdd_motor"], tau[0] if isinstance(tau, tuple) else tau))
    each = passed_loads(EquationsOfMotion(machine), found.q, found.qd)
    return found.with_blocks(load=np.stack([one.passed(taken, a) for one in each], axis=1))


def passed_loads(motion: EquationsOfMotion, q: Array, v: Array) -> list[PassedLoad]:
    """Return the joints whose friction rises with load, at positions and velocities (N, n)."""
    rows, machine = motion.given.independent, motion.given
    return [_passed_load(motion, machine.joint(j), rows.index(j), q, v) for j in machine.loaded]


def _passed_load(motion: EquationsOfMotion, joint: Joint, k: int, q: Array, v: Array) -> PassedLoad:
    law, spring, v = joint.friction, joint.spring, v[:, k]
    cells = (law.viscous, law.coulomb, law.static, law.creep, law.stribeck, law.load, joint.reflected_inertia)
    viscous, coulomb, static, creep, stribeck, share, rotor = (x.value(motion.parameters) for x in cells)
    elastic = joint.kind is Kind.ELASTIC
    of_spring = (x.value(motion.parameters) * elastic for x in (spring.stiffness, spring.damping, spring.neutral))
    stiffness, damping, neutral = of_spring
    speed = np.hypot(v, creep)
    sense, rise = v / speed, creep**2 / speed**3
    falls = (static - coulomb) / (1 + (v / stribeck) ** 2) if static else 0.0 * v
    steeper = -2 * v / stribeck**2 * falls / (1 + (v / stribeck) ** 2) if static else 0.0
    own = stiffness * (q[:, k] - neutral) + (damping + viscous) * v + (coulomb + falls) * sense
    slope = damping + viscous + (coulomb + falls) * rise + steeper * sense
    return PassedLoad(k, own, slope, sense, rise, share, rotor, stiffness)
