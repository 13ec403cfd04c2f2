"""Columns of files of motions and measurements, a row each: what the reference says of them."""

from __future__ import annotations

from dataclasses import dataclass

from symoro_elastic.time_series.columns import COLUMN_UNITS, per_second


@dataclass(frozen=True)
class NamedColumn:
    """One kind of column: its name, in which `<joint>` or `<motor>` stands for one, and the kinds of its units."""

    name: str
    meaning: str
    kinds: tuple[str, ...]
    order: int = 0
    """How often it is derived by time."""

    @property
    def units(self) -> tuple[str, ...]:
        """The units that may follow its name in brackets, SI first for each kind."""
        ending = per_second(self.order)[0]
        return tuple(unit + ending for kind in self.kinds for unit, (of, _) in COLUMN_UNITS.items() if of == kind)

    @property
    def example(self) -> str:
        """The name with a unit that is not SI."""
        joint = self.name.replace("<joint>", "elbow").replace("<motor>", "shoulder")
        return f"{joint} [{self.units[-1]}]"


POSITIONS, FORCES = ("slide", "turn"), ("force", "torque")
NAMED_COLUMNS = (
    NamedColumn("t", "time; evenly spaced", ("t",)),
    NamedColumn("q_<joint>", "measured position of a joint", POSITIONS),
    NamedColumn("qd_<joint>", "its velocity", POSITIONS, 1),
    NamedColumn("qdd_<joint>", "its acceleration", POSITIONS, 2),
    NamedColumn("tau_<motor>", "torque or force of a motor", FORCES),
    NamedColumn("y_<motor>", "wanted position of a motor's axis, with the springs behind it", POSITIONS),
    NamedColumn("yd_<motor>", "its velocity; ydd, yddd ... are further derivatives by time", POSITIONS, 1),
)
