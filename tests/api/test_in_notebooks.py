"""In the cell of a notebook: how far long calls are, and figures that are moved after `%matplotlib widget`."""

from __future__ import annotations

import sys
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import pytest

import symoro_elastic as se
from symoro_elastic.api import checked_calls
from tests.api.test_pickling import MADE
from tests.command_line import EXAMPLES


class Cell:
    """What a notebook is asked to show."""

    def __init__(self) -> None:
        self.shown: list[dict[str, str]] = []

    def display(self, data: dict[str, str], *, raw: bool, display_id: Any) -> Any:
        self.shown.append(data)
        return SimpleNamespace(display_id="first")


@pytest.fixture
def cell(monkeypatch: pytest.MonkeyPatch) -> Cell:
    """Of a kernel that shows what is asked of it at once."""
    found = Cell()
    module = SimpleNamespace(display=found.display, update_display=found.display)
    kernel = SimpleNamespace(get_ipython=lambda: SimpleNamespace(kernel=object()))
    monkeypatch.setitem(sys.modules, "IPython", kernel)
    monkeypatch.setitem(sys.modules, "IPython.display", module)
    monkeypatch.setattr(checked_calls, "SHOWN_AFTER", 0.0)
    monkeypatch.setattr(checked_calls, "AT_LEAST_BETWEEN", 0.0)
    return found


def sweep(**more: Any) -> Any:
    return se.sweep(EXAMPLES / "ball_screw.toml", over={"nut.stiffness": [1e8, 2e8]}, hold=["all"], **more)


def test_a_long_call_shows_how_far_it_is_and_leaves_nothing(cell: Cell) -> None:
    sweep()
    assert any("sweep" in one["text/plain"] and "2 of 2" in one["text/plain"] for one in cell.shown)
    assert any('<progress max="2" value="1"' in one["text/html"] for one in cell.shown)
    assert cell.shown[-1] == {"text/plain": "", "text/html": ""}


def test_nothing_is_shown_in_the_first_second_and_beside_callbacks_of_the_user(
    cell: Cell, monkeypatch: pytest.MonkeyPatch
) -> None:
    counted: list[int] = []
    sweep(progress=lambda done, total: counted.append(done))
    assert counted[-1] == 2 and not any("<progress" in one["text/html"] for one in cell.shown)
    cell.shown.clear()
    monkeypatch.setattr(checked_calls, "SHOWN_AFTER", 100.0)
    sweep()
    assert cell.shown == []


def test_nothing_is_shown_in_a_program(monkeypatch: pytest.MonkeyPatch) -> None:
    terminal = SimpleNamespace(get_ipython=SimpleNamespace)
    monkeypatch.setitem(sys.modules, "IPython", terminal)
    with checked_calls.progress_callbacks("sweep", {"progress": None}, {}) as callbacks:
        assert callbacks == {}


def test_steps_are_text() -> None:
    cell = Cell()
    shown = checked_calls._Shown("check", cell.display, cell.display)
    shown._next = 0.0
    shown.announce("</script><b>bold</b>")
    assert cell.shown == [
        {"text/plain": "check, </script><b>bold</b>", "text/html": "check, &lt;/script&gt;&lt;b&gt;bold&lt;/b&gt;"}
    ]


@pytest.mark.thorough
def test_a_figure_is_moved_where_the_notebook_has_widgets(monkeypatch: pytest.MonkeyPatch) -> None:
    """A drag with the tool for moving shifts the axes by as much; without `%matplotlib widget` nothing changes."""
    widgets = pytest.importorskip("ipympl.backend_nbagg")
    import matplotlib

    figure = MADE["Modes"](Path()).plot("energies")
    monkeypatch.setattr(matplotlib, "get_backend", lambda: "agg")
    assert figure._repr_mimebundle_() == {}
    monkeypatch.setattr(matplotlib, "get_backend", lambda: f"module://{widgets.__name__}")
    bundle = figure._repr_mimebundle_()
    assert "application/vnd.jupyter.widget-view+json" in bundle and figure.canvas.figure is figure
    assert figure._repr_mimebundle_().keys() == bundle.keys()
    axes = figure.axes[0]
    figure.canvas.draw()
    before, scale = axes.get_ylim(), axes.get_window_extent().height
    x, y = map(int, axes.get_window_extent().get_points().mean(axis=0))  # events are in whole pixels
    far = int(scale / 4)
    figure.canvas.toolbar.pan()
    from matplotlib.backend_bases import MouseEvent

    for kind, at, held in (("press", y, None), ("motion", y - far, [1]), ("release", y - far, None)):
        name = "motion_notify_event" if held else f"button_{kind}_event"
        figure.canvas.callbacks.process(name, MouseEvent(name, figure.canvas, x, at, 1, buttons=held))
    assert axes.get_ylim()[0] - before[0] == pytest.approx((before[1] - before[0]) * far / scale, rel=1e-9)
