"""A flexible body of a machine: its modes, rows of the table, and their integrals over the mass."""

from __future__ import annotations

from dataclasses import dataclass
from typing import TypeAlias

Numbers: TypeAlias = tuple[float, ...]
Rows: TypeAlias = tuple[Numbers, ...]


@dataclass(frozen=True)
class FlexibleBody:
    """The body of a row that bends by m modes about the origin of its frame, at which they and their turns vanish.

    `modes` are names of elastic rows on it, whose variables are the deflections e, m. Mass, first moments and inertia
    of the undeformed body are cells of the row. The others are integrals over the mass, of modes phi_k and their
    foreshortening s_kl: Ct0 (m, 3) of phi_k, Ct1 (m, m, 3) of s_kl, T0 (m, 3, 3) of x phi_k^T,
    T1 (m, m, 3, 3) of phi_l phi_k^T + x s_kl^T, Mee (m, m) of phi_k . phi_l. Units kg, kg m.
    """

    joint: str
    modes: tuple[str, ...]
    Ct0: Rows
    Ct1: tuple[Rows, ...]
    T0: tuple[Rows, ...]
    T1: tuple[tuple[Rows, ...], ...]
    Mee: Rows
