"""The quantities of a dynamic model, joint by joint, which its recursions fill."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field

from symoro_elastic.mechanics.base_body import Solution
from symoro_elastic.mechanics.clusters import Cluster, ClusterElimination, ClusterMotion
from symoro_elastic.mechanics.elastic_cells import CellElimination, ElasticCell
from symoro_elastic.mechanics.elimination import Elimination, Rule
from symoro_elastic.mechanics.flexible_inertia import ModalMotion
from symoro_elastic.mechanics.mechanism import Mechanism
from symoro_elastic.mechanics.spatial import ArticulatedInertia, Matrix, Scalar, Twist, Vector, Wrench

Rules = Sequence[Rule | Cluster | ElasticCell | None]


@dataclass(frozen=True)
class Dynamics:
    """All quantities of a dynamic model, by joint number; entry 0 is the base, where it is part of the machine.

    `mechanism` is the given one, its tips of unknown acceleration described in the frames before their joints'
    rotations. `bias` and `remainder` are the parts of V'_j; gamma_j is that of the remainder. `F` holds the wrenches
    [12] of bodies whose acceleration is known, `solved`, `reduced`, `moved` and `cells` solutions for
    the base, clusters and elastic cells. `flexible` are the motions of modes, by the number of each.
    """

    mechanism: Mechanism
    w: list[Vector]
    gamma: list[Twist]
    wd: dict[int, Vector] = field(default_factory=dict)
    vd: dict[int, Vector] = field(default_factory=dict)
    U: dict[int, Matrix] = field(default_factory=dict)
    bias: dict[int, Twist] = field(default_factory=dict)
    remainder: dict[int, Twist] = field(default_factory=dict)
    beta: dict[int, Wrench] = field(default_factory=dict)
    betas: dict[int, Wrench] = field(default_factory=dict)
    Js: dict[int, ArticulatedInertia] = field(default_factory=dict)
    eliminated: dict[int, Elimination] = field(default_factory=dict)
    F: dict[int, Wrench] = field(default_factory=dict)
    f: dict[int, Wrench] = field(default_factory=dict)
    qdd: dict[int, Scalar] = field(default_factory=dict)
    Gamma: dict[int, Scalar] = field(default_factory=dict)
    reduced: dict[int, ClusterElimination] = field(default_factory=dict)
    moved: dict[int, ClusterMotion] = field(default_factory=dict)
    solved: dict[int, Solution] = field(default_factory=dict)
    cells: dict[int, CellElimination] = field(default_factory=dict)
    flexible: dict[int, ModalMotion] = field(default_factory=dict)
