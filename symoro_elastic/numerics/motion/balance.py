"""Equilibrium positions: springs deflect under loads; unsupported loads are reported."""

from __future__ import annotations

import numpy as np

from symoro_elastic.foundation.array_types import Array
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.packages import for_vibrations
from symoro_elastic.machine.frames import COORDINATES
from symoro_elastic.numerics.motion.equations_of_motion import EquationsOfMotion

RESIDUAL = 1e-10  # of the largest force
NEWTON_STEPS = 5
QUICK = 0.1  # of the forces, that a Newton step near an equilibrium leaves at most
MOST_STEPS = 200
DIRECT_STEPS = 50  # Levenberg-Marquardt near an equilibrium takes fewer; on long soft chains it may creep for 1000
POSITION_ROUNDING = 10 * float(np.finfo(float).eps)  # of a position, of order 1 rad or 1 m
NUDGE = 0.01  # rad or m, off a place where the energy curves downwards
FARTHEST_SLIDE = 10.0  # m, that a slide may be from where the search began
LOST_SLIDE = 100 * FARTHEST_SLIDE  # m, from where no search comes back: the slide falls
SHARE = 0.1  # of the largest unbalanced force, for a joint to be named


class _LostError(Exception):
    """A search in which a slide falls without end."""


def balance(motion: EquationsOfMotion, start: Array, tau: Array, sought: list[int], placed: bool) -> Array:
    """Return a position at rest where r of the `sought` coordinates is tau; raises `InputError` with the loaded joints.

    It is near the start, or else a minimum of energy. An unstable equilibrium is kept where the user `placed` some of
    these joints, or no stable one is found.
    """
    motion.refuse_open(start)
    _refuse_unsupported(motion, start, tau, sought)
    q = _newton(motion, start, tau, sought, None if placed else DIRECT_STEPS)
    is_balanced = _unbalanced_forces(motion, q, tau, sought) is None
    if is_balanced and (placed or _is_stable(motion, q, sought)):
        _refuse_far(motion, q, start)
        return q
    minimum = _energy_minimum(motion, start, tau, sought)
    if minimum is not None:
        settled = _newton(motion, minimum, tau, sought)
        if _unbalanced_forces(motion, settled, tau, sought) is None and not _far(motion, settled, start):
            return settled
    if not (is_balanced or placed):
        q = _newton(motion, start, tau, sought)
    unbalanced = _unbalanced_forces(motion, q, tau, sought)
    if unbalanced is not None:
        raise _no_support(motion, unbalanced, sought, "none was found from here")
    _refuse_far(motion, q, start)
    return q


def _unbalanced_forces(motion: EquationsOfMotion, q: Array, tau: Array, sought: list[int]) -> Array | None:
    """Return the unbalanced forces; None where they are rounding."""
    forces, stiffness = motion.forces_and_stiffness(q)
    unbalanced = forces - tau
    rounding = POSITION_ROUNDING * (np.abs(stiffness) @ (1 + np.abs(q)))
    is_small = np.abs(unbalanced) <= np.maximum(rounding, RESIDUAL * _largest_force(motion, q, tau))
    return None if is_small[sought].all() else unbalanced


def _is_stable(motion: EquationsOfMotion, q: Array, sought: list[int]) -> bool:
    """Return whether no direction has a negative stiffness beyond rounding."""
    stiffness = motion.forces_and_stiffness(q)[1][np.ix_(sought, sought)]
    values = np.linalg.eigvalsh((stiffness + stiffness.T) / 2)
    return bool(np.min(values, initial=0.0) >= -1e-12 * np.max(np.abs(values), initial=0.0))


def _energy_minimum(motion: EquationsOfMotion, start: Array, tau: Array, sought: list[int]) -> Array | None:
    """Return a minimum of potential energy less the work of torques, by Newton's method in a trust region.

    None where a slide falls without end.
    """
    chosen = np.ix_(sought, sought)
    stiff = np.abs(np.diag(motion.forces_and_stiffness(start)[1]))[sought]
    scale = 1 / np.sqrt(np.maximum(stiff, 1e-6 * stiff.max() or 1.0))

    def place(y: Array) -> Array:
        q = start.copy()
        q[sought] += scale * y
        return q

    def energy(y: Array) -> tuple[float, Array]:
        q = place(y)
        slope = (motion.forces_and_stiffness(q)[0] - tau)[sought]
        return motion.potential_energy(q) - float(tau @ q), scale * slope

    def curvature(y: Array) -> Array:
        stiffness = motion.forces_and_stiffness(place(y))[1][chosen]
        return np.outer(scale, scale) * (stiffness + stiffness.T) / 2

    def refuse_lost(y: Array) -> None:
        if _far(motion, place(y), start, LOST_SLIDE):
            raise _LostError

    values, vectors = np.linalg.eigh(curvature(np.zeros(len(sought))))
    downhill = NUDGE * vectors[:, 0] / np.max(np.abs(scale * vectors[:, 0])) * (values[0] < 0)
    try:
        minimum = for_vibrations("scipy.optimize").minimize(
            energy, downhill, jac=True, hess=curvature, method="trust-exact", callback=refuse_lost,
            options={"maxiter": MOST_STEPS},
        )  # fmt: skip
    except _LostError:
        return None
    return place(minimum.x)


def _newton(motion: EquationsOfMotion, q: Array, tau: Array, sought: list[int], most_steps: int | None = None) -> Array:
    """Return a root of r - tau: by Newton steps where they converge fast, else Levenberg-Marquardt and Newton steps.

    Both allow singular directions.
    """
    if not sought:
        return q
    chosen = np.ix_(sought, sought)

    def balance(x: Array) -> tuple[Array, Array]:
        trial = q.copy()
        trial[sought] = x
        forces, stiffness = motion.forces_and_stiffness(trial)
        return (forces - tau)[sought], stiffness[chosen]

    def newton_steps(x: Array, least: float) -> tuple[Array, bool]:
        """Return x after Newton steps that each leave less than `least` of the forces, and whether they converged."""
        unbalanced, stiffness = balance(x)
        first = np.linalg.norm(unbalanced)
        for _ in range(NEWTON_STEPS):
            better = x - np.linalg.lstsq(stiffness, unbalanced, rcond=None)[0]
            next_unbalanced, next_stiffness = balance(better)
            if not np.linalg.norm(next_unbalanced) < least * np.linalg.norm(unbalanced):
                break
            x, unbalanced, stiffness = better, next_unbalanced, next_stiffness
        return x, bool(np.linalg.norm(unbalanced) <= RESIDUAL * first)

    x, is_found = newton_steps(q[sought], QUICK)
    if not is_found:
        options = {"xtol": 1e-12, "maxiter": most_steps or 0}  # 0: 100 (n + 1)
        x = for_vibrations("scipy.optimize").root(balance, q[sought], jac=True, method="lm", options=options).x
        x = newton_steps(x, 1.0)[0]
    solved: Array = q.copy()
    solved[sought] = x
    return solved


def _largest_force(motion: EquationsOfMotion, q: Array, tau: Array) -> float:
    """Return the largest of the forces that balance each other, N or N m."""
    springs = np.abs(motion.spring_forces(q))
    largest = float(np.max(springs, initial=0.0))
    loads = np.abs(motion.forces(q)) + largest
    return float(max(np.max(block, initial=np.finfo(float).tiny) for block in (springs, loads, np.abs(tau))))


def _refuse_unsupported(motion: EquationsOfMotion, q: Array, tau: Array, sought: list[int]) -> None:
    """Raise `InputError` for loads on coordinates that no force depends on: at q, and a little further along them.

    A pendulum that stands out level has no stiffness there, and some close to it.
    """
    free = _without_stiffness(motion, q, sought, sought)
    shifted = q.copy()
    shifted[free] += NUDGE
    free = _without_stiffness(motion, shifted, free, sought) if free else []
    loaded = np.zeros_like(q)
    loaded[free] = (motion.forces_and_stiffness(q)[0] - tau)[free]
    if np.max(np.abs(loaded), initial=0.0) > RESIDUAL * _largest_force(motion, q, tau):
        raise _no_support(motion, loaded, sought, "there is none")


def _without_stiffness(motion: EquationsOfMotion, q: Array, among: list[int], sought: list[int]) -> list[int]:
    """Return the coordinates of `among` whose rows and columns of stiffness, among those sought, are zero at q."""
    stiffness = motion.forces_and_stiffness(q)[1] if among else np.zeros((0, 0))
    return [k for k in among if not stiffness[k, sought].any() and not stiffness[sought, k].any()]


def _refuse_far(motion: EquationsOfMotion, q: Array, start: Array) -> None:
    """Raise `InputError` for an equilibrium out of reach of the machine."""
    far = _far(motion, q, start)
    if far:
        places = ", ".join(f"{motion.names[k]} = {q[k]:.4g} m" for k in far)
        what = f"there is none nearby: {places} would balance; give a spring, or the torque that holds a motor"
        raise InputError(motion.source, "equilibrium", what)


def _far(motion: EquationsOfMotion, q: Array, start: Array, limit: float = FARTHEST_SLIDE) -> list[int]:
    """Return the slides that are farther than a limit from where the search began."""
    return [k for k, joint in enumerate(motion.joints) if joint.sigma == 1 and abs(q[k] - start[k]) > limit]


def _no_support(motion: EquationsOfMotion, unbalanced: Array, sought: list[int], found: str) -> InputError:
    """Return the error that names the loaded joints; `found` begins its message."""
    force = np.abs(unbalanced[sought])
    if not np.isfinite(force).all():
        return InputError(motion.source, "equilibrium", "not found: the search diverged; begin elsewhere (--at)")
    named = [k for k, f in zip(sought, force, strict=True) if f > SHARE * force.max(initial=0.0)]
    loads = ", ".join(f"{motion.names[k]} ({abs(unbalanced[k]):.4g} {motion.joints[k].force_unit})" for k in named)
    if any(motion.names[k] in COORDINATES for k in named):
        what = f"there is none: nothing supports {loads}, so a free base falls; support it (--hover, or "
        what += "--thrust FRAME.fz for one that turns with the frame), or leave out gravity and what loads it"
        return InputError(motion.source, "equilibrium", what)
    what = "give a spring, take the torque that holds a motor, begin elsewhere (--at), or linearize as given"
    return InputError(motion.source, "equilibrium", f"{found}: nothing supports {loads}; {what} (--as-given)")
