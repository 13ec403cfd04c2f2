"""Torques that pass through the transmissions of joints, of motors and springs less friction and rotors.

Friction that rises with load needs them: lambda = Gamma_m - Gamma_f(lambda) - Ia qdd(lambda), which generated models
are given. As its share of lambda is below 0.9 and rotors take but a part of a torque, lambda is found by substitution.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

from symoro_elastic.foundation.scalar import sum_of
from symoro_elastic.machine.machine import Machine
from symoro_elastic.models.bind import Bound
from symoro_elastic.models.catalogue import with_friction_states
from symoro_elastic.models.implicit_steps import FAMILY
from symoro_elastic.models.model import Model, Result, Results, TracedModel
from symoro_elastic.models.state import position_blocks
from symoro_elastic.models.tracing import Trace, prune, schedule
from symoro_elastic.quantities import quantity
from symoro_elastic.symbolic.functions import amount
from symoro_elastic.symbolic.program import Input

PASSED_TORQUES, PASSED, TERMS = "passed_torques", "load_passed", "load_terms"


def passed_torques(machine: Machine, folded: Sequence[str] = ()) -> TracedModel:
    """Return the model of lambda (l,), by the torques of motors, accelerations, and the lambda in friction.

    A second result (l,) are the sums of the amounts of its terms, with which rounding grows.
    """
    return schedule(prune(passed_trace(Bound(machine, folded))))


def passed_trace(bound: Bound) -> Trace:
    """Return the same as expressions."""
    results = _results(bound)
    model = Model(
        PASSED_TORQUES,
        "torques through transmissions",
        "[12]",
        (*position_blocks(bound.machine), "qd", "qdd", "tau"),
        tuple(results),
        lambda other, _: _results(other),
        FAMILY,
        own=(
            replace(quantity("load"), name=PASSED),
            replace(quantity("load"), name=TERMS, meaning="sum of the amounts of the terms of the load"),
        ),
    )
    model = with_friction_states(model, bound, results)
    entries = bound.arguments()
    inputs = tuple(Input(name, entries[name]) for name in model.arguments)
    return Trace(model, inputs, results, bound.graph, bound.names, True, ())


def _results(bound: Bound) -> Results:
    qdd, loaded = bound.given_accelerations(), bound.machine.loaded
    links = bound.mechanism.links
    of_rotors = {j: links[j - 1].rotor_inertia * qdd[j] for j in loaded}
    passed = tuple(bound.exerted_torque(j) - of_rotors[j] for j in loaded)
    terms = ((bound.exerted_torque(j) + bound.friction(j), bound.friction(j), of_rotors[j]) for j in loaded)
    sizes = tuple(sum_of(amount(bound.graph, x) for x in of_joint) for of_joint in terms)
    return {PASSED: Result(loaded, passed), TERMS: Result(loaded, sizes)}
