"""Properties of equations that depend on symbols alone: traced once, for all values of the parameters."""

from __future__ import annotations

from functools import cached_property
from typing import Any, TypeVar

T = TypeVar("T")


class traced_once(cached_property[T]):  # noqa: N801  (used as a decorator)
    """A cached property that copies of its owner share, in the dictionary `traced` of the owner."""

    def __get__(self, instance: Any, owner: type[Any] | None = None) -> Any:
        """Return the value, computed when it is first asked for."""
        if instance is None:
            return self
        if self.attrname not in instance.traced:
            instance.traced[self.attrname] = self.func(instance)
        return instance.traced[self.attrname]
