"""Units of quantities, by the kinds of joints that an entry belongs to."""

from __future__ import annotations

from dataclasses import dataclass

from symoro_elastic.quantities.unit_reader import product, readings, unit_text


@dataclass(frozen=True)
class Unit:
    """Unit of an entry that belongs to one joint, or to one component of a screw or wrench.

    `angular` holds for revolute joints and components 4 to 6, `linear` for prismatic joints and components 1 to 3. A
    number without dimension has the unit "".
    """

    angular: str
    linear: str

    def of(self, sigma: int) -> str:
        """The unit for a revolute (0) or a prismatic joint (1)."""
        return self.linear if sigma else self.angular

    @property
    def text(self) -> str:
        """The unit for any joint, `rad/s or m/s`; one unit where both are the same."""
        return " or ".join(dict.fromkeys((self.angular, self.linear)))

    @property
    def screw(self) -> str:
        """The units of a screw in the order of its components, linear ones first: `m/s and rad/s`."""
        return f"{self.linear} and {self.angular}"

    def __truediv__(self, other: Unit) -> PairUnit:
        rows, columns = (self.angular, self.linear), (other.angular, other.linear)
        a, b, c, d = (quotient(row, column) for row in rows for column in columns)
        return PairUnit(a, b, c, d)


@dataclass(frozen=True)
class PairUnit:
    """Unit of an entry that belongs to two joints or components, that of its row and that of its column."""

    angular_angular: str
    angular_linear: str
    linear_angular: str
    linear_linear: str

    def of(self, row: int, column: int) -> str:
        """The unit for rows and columns of revolute (0) or prismatic joints (1)."""
        return self._all[2 * row + column]

    @property
    def _all(self) -> tuple[str, str, str, str]:
        return self.angular_angular, self.angular_linear, self.linear_angular, self.linear_linear

    @property
    def text(self) -> str:
        """The different units of the entries in words: `kg m2, kg m or kg`."""
        *first, last = dict.fromkeys(self._all)
        return f"{', '.join(first)} or {last}" if first else last


def same(unit: str) -> Unit:
    """One unit for all kinds of joints."""
    return Unit(unit, unit)


def quotient(over: str, under: str) -> str:
    """Quotient of two units: `N m s/rad` for `N m` over `rad/s`."""
    above, below = (readings(unit)[0].si if unit else {} for unit in (over, under))
    return unit_text(product((above, 1), (below, -1)))


NUMBER = same("")
POSITION = Unit("rad", "m")
VELOCITY = Unit("rad/s", "m/s")
ACCELERATION = Unit("rad/s2", "m/s2")
FORCE = Unit("N m", "N")
MASS = Unit("kg m2", "kg")
"""Inertia that a joint moves."""
INVERSE_MASS = Unit("1/(kg m2)", "1/kg")
COMPLIANCE = Unit("rad/(N m)", "m/N")
MICRO = 1e6
"""um in a metre, urad in a radian: compliances are printed by these."""


def in_micro(unit: str) -> tuple[float, str]:
    """Return the factor and the unit in which a response is shown: um / N for compliances, else the unit itself."""
    over, _, under = unit.partition(" / ")
    is_compliance = over in ("m", "rad") and under.strip("()") in ("N", "N m")
    return (MICRO, f"u{unit}") if is_compliance else (1.0, unit)


PLACEMENT = Unit("", "m")
"""Entries of a 4 x 4 matrix: direction cosines, and lengths in its last column."""
INERTIA = PairUnit("kg m2", "kg m", "kg m", "kg")
IMPULSE = PairUnit("N m s", "N s", "N m s", "N s")
"""Forces of a joint, its column, over velocities of rotation."""
DAMPING = PairUnit("N m s/rad", "N s", "N s", "N s/m")
STIFFNESS = PairUnit("N m/rad", "N", "N", "N/m")
