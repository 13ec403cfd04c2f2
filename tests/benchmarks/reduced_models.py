"""Whether models with terms left out keep what is said of them: errors, and the structure that `keep` promises.

    python -m tests.benchmarks.certificates --reduced [--held-out] [--states 100000] [--machines NAME ...] [--boxes ...]

Each machine, on a base at rest and without wrenches, has its inverse and direct model reduced within 1 % by each way of
`keep`, with confidence and with proof. A row says how many operations are left, and the worst error found, as a part
of the one that is said: at states that no search has seen, half of them at corners, and by climbing. A proof must hold
at all of them; a confident bound at drawn states, so climbing that gets above it is shown, but is no mistake. Where
positions are those of motors, three more numbers say how asymmetric the inertia matrix is, of the largest entry, what
its least eigenvalue is, of the largest, and what power is made from nothing, of the largest power, by complex steps.
`parameters` and `inertia` promise 1e-14, more than zero and 1e-12; the matrix of a direct model is found by inversion,
and may be off by its condition number times as much.
"""

from __future__ import annotations

import itertools
import math
import time
import warnings
from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from numpy.typing import NDArray

from symoro_elastic.foundation.errors import InputError
from symoro_elastic.generation.pipeline import programs
from symoro_elastic.generation.reduced_models.model import ReducedModel
from symoro_elastic.generation.reduced_models.search import reduced_models
from symoro_elastic.machine.described import DescribedMachine
from symoro_elastic.machine.joints import Wrench
from symoro_elastic.machine.machine import Base, Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.within import ALL_RESULTS, Evidence, Keep, Within
from symoro_elastic.machine.within import tolerance as tolerance_of
from symoro_elastic.numerics.evaluation.arrays import arithmetic
from symoro_elastic.numerics.guarantees.box import Box
from symoro_elastic.numerics.guarantees.running_error import ROUNDINGS
from symoro_elastic.symbolic.arithmetic import Arithmetic, evaluate, library
from symoro_elastic.symbolic.operations import ATAN2, COSPI, MAXIMUM, MINIMUM, PI, SIGN
from symoro_elastic.symbolic.program import Program
from tests.numerics.guarantees.attack import Attack, States
from tests.numerics.guarantees.boxes import limits_of_test

Array = NDArray[np.float64]
MODELS = ("inverse_dynamics", "direct_dynamics")
TOLERANCE = "1 %"
SEED = 4711
"""Not that of a search."""
ROUNDED = 1e-9
"""Of a stated error: what evaluation in double adds."""
STRUCTURES = 200
"""Positions at which eigenvalues and the balance of power are computed."""
STEP = 1e-30
SYMMETRIC, BALANCED = 1e-14, 1e-12
COMPLEX: Arithmetic[Any] = Arithmetic(
    lambda x: complex(float(x)),
    library(
        np,
        {
            ATAN2: lambda y, x: (
                np.arctan2(np.real(y), np.real(x))
                + 1j * (np.real(x) * np.imag(y) - np.real(y) * np.imag(x)) / (np.real(x) ** 2 + np.real(y) ** 2)
            ),
            SIGN: lambda x: np.sign(np.real(x)),
            PI: lambda: np.pi,
            COSPI: lambda x: np.cos(np.pi * x),
            MINIMUM: lambda x, y: np.where(np.real(x) < np.real(y), x, y),
            MAXIMUM: lambda x, y: np.where(np.real(x) < np.real(y), y, x),
        },
    ),
)
"""Complex numbers, whose imaginary parts are as small as a step."""


class AttackOfReduced(Attack):
    """Errors of a reduced program beside the whole one, over its box."""

    def __init__(self, whole: Program, reduced: Program, box: Box) -> None:
        super().__init__(entries_of(reduced), box, "double", SEED)
        self._whole = entries_of(whole)

    def errors(self, states: States) -> tuple[Array, Array]:
        """Errors and values, results x states."""
        count = len(next(iter(states.values())))
        with np.errstate(all="ignore"):
            both = [evaluate(roots, states, arithmetic(np.float64)) for roots in (self._whole, self.roots)]
            whole, left = (
                np.array([np.broadcast_to(value(x), count) for x in roots], float)
                for value, roots in zip(both, (self._whole, self.roots), strict=True)
            )
        off = np.abs(left - whole)
        return np.where(np.isnan(off), np.inf, off), whole


def entries_of(program: Program) -> list:  # type: ignore[type-arg]
    """All entries of the results of a program."""
    return [x for output in program.outputs for x in output.entries]


@dataclass(frozen=True)
class Structure:
    """Of a reduced model: asymmetry, least eigenvalue and power from nothing, each of the largest."""

    asymmetry: float
    least: float
    power: float
    is_inverted: bool = False

    @property
    def is_kept(self) -> bool:
        """As `parameters` and `inertia` promise, but for rounding of a matrix that is inverted."""
        condition = 1 / self.least if self.is_inverted and self.least > 0 else 1.0
        return self.asymmetry <= SYMMETRIC * condition and self.least > 0 and self.power <= BALANCED


class _Motion:
    """Derivatives of a program by its arguments, at states, by complex steps."""

    def __init__(self, program: Program, states: Mapping[str, Array]) -> None:
        self.inputs = {argument.name: argument.symbols for argument in program.inputs}
        self._roots, self._states = program.outputs[0].entries, states

    def argument(self, name: str) -> Array:
        """An argument, (entries, states)."""
        return np.array([self._states[symbol] for symbol in self.inputs[name]])

    def value(self, **arguments: NDArray[np.complex128]) -> NDArray[np.complex128]:
        """The result where these arguments are others."""
        own = {s: x for name, rows in arguments.items() for s, x in zip(self.inputs[name], rows, strict=True)}
        states = {name: np.asarray(x, complex) for name, x in {**self._states, **own}.items()}
        found = evaluate(self._roots, states, COMPLEX)
        return np.array([np.broadcast_to(found(x), STRUCTURES) for x in self._roots], complex)

    def matrix(self, of: str, q: NDArray[np.complex128], qd: Array) -> NDArray[np.complex128]:
        """The derivative of the result by an argument that it is linear in, (rows, columns, states)."""
        count = len(self.inputs[of])
        still = np.zeros((count, STRUCTURES), complex)
        rest = self.value(q=q, qd=qd.astype(complex), **{of: still})
        columns = []
        for k in range(count):
            single = still.copy()
            single[k] = 1.0
            columns.append(self.value(q=q, qd=qd.astype(complex), **{of: single}) - rest)
        return np.array(columns).transpose(1, 0, 2)


def structure_of(one: ReducedModel, box: Box) -> Structure | None:
    """What a model keeps, whose positions are those of motors; None where it has other arguments, too."""
    reduced, whole = one.reduction.reduced, one.reduction.program
    moved = {"inverse_dynamics": "qdd_motor", "direct_dynamics": "tau"}[one.model]
    inputs = {argument.name: argument.symbols for argument in whole.inputs}
    if {*inputs} != {"q", "qd", moved} or len({len(x) for x in inputs.values()}) != 1:
        return None
    names = [name for symbols in inputs.values() for name in symbols]
    states = {name: np.zeros(STRUCTURES) for name in names} | box.states(STRUCTURES, np.random.default_rng(SEED))
    motion, exact = (_Motion(program, states) for program in (reduced, whole))
    first, second = (_balance(each, moved) for each in (motion, exact))
    A = _inertia(motion, moved, motion.argument("q").astype(complex)).real
    eigenvalues = np.linalg.eigvalsh(A.transpose(2, 0, 1))
    largest = np.abs(exact.argument("qd") * _forces(exact, moved, exact.argument("qd"))).sum(axis=0).max()
    return Structure(
        float(np.abs(A - A.transpose(1, 0, 2)).max() / np.abs(A).max()),
        float(eigenvalues.min() / eigenvalues.max()),
        float(np.abs(first - second).max() / max(largest, 1e-300)),
        moved == "tau",
    )


def _inertia(motion: _Motion, moved: str, q: NDArray[np.complex128]) -> NDArray[np.complex128]:
    """A at complex positions, (joints, joints, states)."""
    found = motion.matrix(moved, q, np.zeros_like(motion.argument("qd")))
    if moved == "tau":
        found = np.linalg.inv(found.transpose(2, 0, 1)).transpose(1, 2, 0).astype(complex)
    return found


def _forces(motion: _Motion, moved: str, qd: Array) -> Array:
    """c + g + friction at a velocity."""
    q = motion.argument("q").astype(complex)
    still = np.zeros_like(q)
    at_rest = motion.value(q=q, qd=qd.astype(complex), **{moved: still})
    if moved == "tau":
        at_rest = -np.einsum("iks,ks->is", _inertia(motion, moved, q), at_rest)
    return at_rest.real


def _balance(motion: _Motion, moved: str) -> Array:
    """qd' c - 1/2 qd' Ad qd, with the power of friction."""
    qd = motion.argument("qd")
    c = _forces(motion, moved, qd) - _forces(motion, moved, np.zeros_like(qd))
    rate = _inertia(motion, moved, motion.argument("q") + 1j * STEP * qd).imag / STEP
    balance: Array = (qd * c).sum(axis=0) - np.einsum("is,iks,ks->s", qd, rate, qd) / 2
    return balance


def conservative(machine: Machine) -> Machine:
    """The machine on a base at rest, without wrenches on its bodies."""
    joints = tuple(replace(joint, wrench=Wrench()) for joint in machine.joints)
    return replace(machine, joints=joints, base=Base(machine.base.gravity))


def attack_reduced(machines: Iterator[tuple[str, Machine]], chosen: Sequence[str], scale: float, states: int) -> int:
    """Print a row for each machine, model, way to keep and guarantee; return how many break what is said."""
    print("machine, model, keep, guarantee | operations | drawn / said | climbed / said | structure | s")
    broken = 0
    for name, whole in machines:
        if chosen and name not in chosen:
            continue
        alone = conservative(whole)
        machine = replace(DescribedMachine.of(alone), limits=limits_of_test(alone, scale))
        for model, keep, guaranteed in itertools.product(MODELS, Keep, Evidence):
            began = time.process_time()
            said = f"{name}, {model}, {keep}, {guaranteed}"
            within = Within({ALL_RESULTS: tolerance_of(TOLERANCE)}, keep, guaranteed)
            try:
                with warnings.catch_warnings():
                    warnings.simplefilter("ignore")
                    _, (one,) = reduced_models(machine, Scene((model,), within=within), programs, [ROUNDINGS["double"]])
            except InputError as error:
                print(f"{said}: {error}", flush=True)
                continue
            is_measured = alone.moves_by_motors and one.reduction.left_out
            kept = structure_of(one, one.certificates[0].box) if is_measured else None
            broken += _print_row(said, one, keep, guaranteed, states, kept, time.process_time() - began)
    return broken


def _print_row(
    said: str, one: ReducedModel, keep: Keep, guaranteed: Evidence, states: int, kept: Structure | None, took: float
) -> bool:
    """Print what was found of a model; return whether it breaks what is said of it."""
    (certificate,) = one.certificates
    attack = AttackOfReduced(one.reduction.program, one.reduction.reduced, certificate.box)
    drawn = np.zeros(len(certificate.entries))
    for _ in range(max(1, states // 20_000)):
        drawn = np.maximum(drawn, attack.errors(certificate.box.states(20_000, attack.rng))[0].max(axis=1))
    climbed = np.maximum(drawn, attack.run(20_000).error)
    key = "error" if guaranteed is Evidence.PROVEN else "likely"
    stated = np.array([getattr(entry, key) for entry in certificate.entries])
    sizes = np.array([entry.magnitude for entry in certificate.entries])
    parts = [_most(found, stated, sizes) for found in (drawn, climbed)]
    whole, left = one.operations
    is_broken = parts[guaranteed is Evidence.PROVEN] > 1 + ROUNDED
    is_broken |= kept is not None and keep is not Keep.TERMS and not kept.is_kept
    shown = f"{kept.asymmetry:.1g}, {kept.least:.1g}, {kept.power:.1g}" if kept else "-"
    row = f"{said} | {left} of {whole} | {parts[0]:.3g} | {parts[1]:.3g} | {shown} | {took:.1f}"
    print(f"{'BROKEN: ' if is_broken else ''}{row}", flush=True)
    return bool(is_broken)


def _most(found: Array, stated: Array, sizes: Array) -> float:
    """The largest part of a stated error that was found, but for rounding."""
    with np.errstate(all="ignore"):
        off = np.where(found <= 1e-12 * np.where(np.isfinite(sizes), sizes, 1.0), 0.0, found / stated)
    return float(np.nan_to_num(off, nan=math.inf).max(initial=0.0))
