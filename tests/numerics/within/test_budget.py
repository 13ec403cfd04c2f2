"""One greedy loop: items by gain, what adds nothing by what it saves, nothing that is not accepted."""

from __future__ import annotations

from itertools import combinations

from hypothesis import given
from hypothesis import strategies as st

from symoro_elastic.numerics.within.budget import NEGLIGIBLE, ErrorBudget, Item, by_gain, spend

ITEMS = st.lists(st.tuples(st.integers(1, 50), st.floats(0, 1)), min_size=1, max_size=8)


def test_items_are_ranked_by_gain_and_free_ones_by_what_they_save() -> None:
    items = [Item("a", 10, 0.5), Item("b", 9, 0.1), Item("free", 1, 0.0), Item("freer", 2, NEGLIGIBLE / 2)]
    assert [item.what for item in by_gain(items)] == ["freer", "free", "b", "a"]


def test_equal_gains_begin_with_the_smaller_error() -> None:
    assert [item.what for item in by_gain([Item("a", 4, 0.4), Item("b", 2, 0.2)])] == ["b", "a"]


@given(ITEMS)
def test_a_greedy_path_stays_within_the_budget_and_ends_where_nothing_fits(drawn: list[tuple[int, float]]) -> None:
    """Whatever the items; and it saves at least half of what the best set does, with the best single item."""

    def items(taken: frozenset[int]) -> list[Item[int]]:
        return [Item(k, *pair) for k, pair in enumerate(drawn) if k not in taken]

    def error(taken: frozenset[int]) -> float:
        return sum(drawn[k][1] for k in sorted(taken))

    def accept(taken: frozenset[int], k: int) -> frozenset[int] | None:
        return taken | {k} if error(taken | {k}) <= 1 else None

    *_, end = frozenset[int](), *spend(frozenset[int](), items, accept)
    assert error(end) <= 1
    assert not [k for k in range(len(drawn)) if k not in end and error(end | {k}) <= 1]
    sets = [set_ for n in range(len(drawn) + 1) for set_ in combinations(range(len(drawn)), n)]
    best = max(sum(drawn[k][0] for k in set_) for set_ in sets if error(frozenset(set_)) <= 1)
    saved, single = sum(drawn[k][0] for k in end), max(pair[0] for pair in drawn)
    assert saved + single >= best - 1e-9


def test_slack_is_what_errors_leave_of_the_fraction() -> None:
    budget = ErrorBudget({"x": 2.0, "y": 1.0}, 0.5)
    assert budget.slack({"x": 0.25}) == {"x": 0.75, "y": 0.5}
    assert budget.used_fraction({"x": -1.0, "y": 0.25}) == 0.5
    assert budget.fits({"x": 0.5}, {"x": 0.5, "y": 0.5}) and not budget.fits({"x": 0.5}, {"x": 0.51})
