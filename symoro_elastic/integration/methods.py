"""The methods that time steps are generated for, by name."""

from __future__ import annotations

from typing import TypeAlias

from symoro_elastic.integration.midpoint import MIDPOINT, Midpoint
from symoro_elastic.integration.rosenbrock import RODAS4, Rosenbrock
from symoro_elastic.integration.tableaus import RK4, Tableau
from symoro_elastic.integration.w_methods import W2, W3, WMethod

Method: TypeAlias = Tableau | WMethod | Rosenbrock | Midpoint
METHODS: dict[str, Method] = {method.name: method for method in (W3, W2, RK4, RODAS4, MIDPOINT)}
