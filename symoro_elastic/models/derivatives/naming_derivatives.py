"""Names of the quantities in derivatives of dynamic models."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from symoro_elastic.mechanics.base_body import DEGREES
from symoro_elastic.mechanics.derivatives.torques import Composite, Entries, TorqueDerivatives
from symoro_elastic.mechanics.spatial import Vector
from symoro_elastic.models.bound.bind import Bound
from symoro_elastic.models.bound.naming import AXES, name_composite
from symoro_elastic.symbolic.differentiation import Tangents
from symoro_elastic.symbolic.program import Names, Section

COMPOSITES = "Backward recursion: composite bodies"
ROWS = "Derivatives of torques by accelerations"
TORQUES = "Derivatives of torques"
ACCELERATIONS = "Derivatives of accelerations"
BY_ARGUMENT = {"tau": "qddt", "q": "qddq", "qd": "qddv"}
BY = "by_"


def name_by_accelerations(bound: Bound, partials: TorqueDerivatives, title: str = ROWS) -> None:
    """Name composite bodies, the rows of joints at each link, and the inertia matrix, in sections with a title."""
    for j in sorted(partials.composites, reverse=True):
        _name_composite(bound.names, partials.composites[j], j, Section(COMPOSITES, j, "[8], [13]"))
    for j, _ in bound.mechanism.from_tips():
        here = Section(title, j, "[15]")
        for i, row in ((i, row) for (of, i), row in partials.rows.items() if of == j):
            _name_parts(bound.names, (("Fa", row.of_acceleration), ("Fh", (row.of_theta,))), (j, i), here)
    _name_entries(bound.names, "A", partials.by_qdd, title, "[15]")


def name_torque_derivatives(bound: Bound, partials: TorqueDerivatives) -> None:
    """Name the derivatives of torques: rows, and columns by link."""
    name_by_accelerations(bound, partials, TORQUES)
    for j, _ in bound.mechanism.from_tips():
        here = Section(TORQUES, j, "[15]")
        for i, (by_q, by_qd) in ((i, column) for (of, i), column in partials.columns.items() if of == j):
            _name_parts(bound.names, (("Fq", by_q), ("Fv", by_qd)), (j, i), here)
    _name_entries(bound.names, "Gq", partials.by_q, TORQUES, "[15]")
    _name_entries(bound.names, "Gv", partials.by_qd, TORQUES, "[15]")


def _name_entries(names: Names, quantity: str, entries: Entries, title: str, equations: str) -> None:
    for (i, j), x in entries.items():
        names.give(x, f"{quantity}{_place(i)}_{_place(j)}", Section(title, max(i, j, 0), equations))


def _place(number: int) -> str:
    """The number of a joint, or `0_k` for component k of the base."""
    return str(number) if number > 0 else f"0_{DEGREES.index(number) + 1}"


def _name_composite(names: Names, composite: Composite, j: int, section: Section) -> None:
    name_composite(names, composite.inertia, j, section)
    for m in range(3):
        names.give(composite.p[m], f"Pc{j}_{AXES[m]}", section)
        for n in range(3):
            names.give(composite.Q[m][n], f"Qc{j}_{m + 1}{n + 1}", section)


def _name_parts(
    names: Names, quantities: Iterable[tuple[str, Iterable[Vector]]], of: tuple[int, int], section: Section
) -> None:
    """Name the components of quantities of joint j at link i, given as `of` = (j, i)."""
    j, i = of
    for quantity, parts in quantities:
        for k, x in enumerate((x for part in parts for x in part), start=1):
            names.give(x, f"{quantity}{j}_{k}_{i}", section)


def name_acceleration_derivatives(bound: Bound, derivatives: Mapping[tuple[str, str], Entries]) -> None:
    """Name the entries of derivatives of accelerations: `qddq3_2` is that of joint 3 by q_2."""
    for argument, quantity in BY_ARGUMENT.items():
        for (i, j), x in derivatives.get(("qdd", argument), {}).items():
            bound.names.give(x, f"{quantity}{i}_{j}", Section(ACCELERATIONS, j, "[8]"))


def name_tangents(bound: Bound, tangents: Mapping[str, Tangents]) -> None:
    """Name the derivatives of named quantities: `by_q2_f3_6` is that of `f3_6` by q2."""
    labels = list(bound.names.labels.items())
    for variable, derivatives in tangents.items():
        for number, (label, negative) in labels:
            x = derivatives.of_nodes.get(number, 0)
            bound.names.give(-x if negative else x, f"{BY}{variable}_{label.name}", label.section)
