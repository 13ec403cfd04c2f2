"""Plots of all kinds of results: whole, legible in grey and for colour-blind readers, with names that stay text."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from functools import cache
from itertools import combinations
from pathlib import Path
from subprocess import run
from typing import Any

import numpy as np
import pytest

import symoro_elastic as se
from symoro_elastic.api.options import Oscillating
from symoro_elastic.api.vibrations import modes_along
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.pictures import Figures, Plot, file_name, picture
from symoro_elastic.foundation.plot_style import DARK, LIGHT, bars, curve, curves, legend, logarithmic
from symoro_elastic.foundation.results import Result, _load, figures_of
from tests.api.test_pickling import MADE, classes, import_all

Figure = pytest.importorskip("matplotlib.figure").Figure
Text = pytest.importorskip("matplotlib.text").Text
SHOWN = ("Equations", "DescribedMachine", "LoadedModel", "Machine", "MachinePage", "MachinePicture", "Report")
QUICK = ("Modes", "Response", "FeedForward", "Verification", "Budget")
RESULTS = [
    pytest.param(name, marks=[pytest.mark.thorough] if name not in QUICK else []) for name in MADE if name not in SHOWN
]
NASTY = '</script> $x^2$ "q" \u202e $\\frac{1}{0}$ ' + "W" * 90
"""A name of a machine that is markup, a formula, text from right to left, and long."""


def texts(figure: Any) -> Iterator[tuple[str, Any]]:
    """Visible texts of a figure and their boxes in pixels."""
    figure.canvas.draw()
    hidden = {id(label) for axes in figure.axes for axis in (axes.xaxis, axes.yaxis) for label in beyond(axis)}
    for one in figure.findobj(Text):
        if one.get_visible() and one.get_text().strip() and id(one) not in hidden:
            yield one.get_text(), one.get_window_extent()


def beyond(axis: Any) -> Iterator[Any]:
    """Labels of ticks out of the range of an axis, which are not drawn."""
    low, high = sorted(axis.get_view_interval())
    for tick in (*axis.get_major_ticks(), *axis.get_minor_ticks()):
        if not low <= tick.get_loc() <= high:
            yield from (tick.label1, tick.label2)


def refuse_cut_text(plots: Figures) -> None:
    """Every plot has a title and units or words on its axes, and no text leaves it."""
    for name, plot in plots.all.items():
        if isinstance(plot, str):
            assert plot.strip()
            continue
        figure = plot.figure()
        assert plot.title and figure._suptitle.get_text().strip(), name
        assert any(axis.get_xlabel() for axis in figure.axes), name
        width, height = figure.bbox.width, figure.bbox.height
        assert not figure._localaxes or (width <= 1500 and height <= 1800), f"{name} is {width} x {height}"
        for text, box in texts(figure):
            assert "mathdefault" not in text, f"{name}: {text!r} is a formula that is not drawn as one"
            inside = box.x0 >= -1 and box.y0 >= -1 and box.x1 <= width + 1 and box.y1 <= height + 1
            assert inside, f"{name}: {text!r} is cut: {box} of {width} x {height}"


@pytest.mark.thorough
def test_every_result_has_a_plot() -> None:
    import_all()
    own = [each for each in classes(Result) if each.__module__.startswith("symoro_elastic.")]
    for each in own:
        _load(each, "plots")
    without = {x.__name__ for x in own if figures_of.dispatch(x) is figures_of.dispatch(object)}
    assert len(own) > 20 and not without


@pytest.mark.thorough
@pytest.mark.parametrize("name", RESULTS)
def test_plots_of_small_machines_are_whole(name: str, tmp_path: Path) -> None:
    made = MADE[name](tmp_path)
    plots = made.plots()
    assert len(plots) and isinstance(made.plot(), Figure)
    refuse_cut_text(plots)


@cache
def chain(count: int = 20, in_a_row: bool = True) -> dict[str, Any]:
    """A machine of `count` motors with long names, each with a spring behind it."""
    joints: list[dict[str, Any]] = []
    bodies, springs, before = {}, {}, 0
    for k in range(1, count + 1):
        motor, spring = f"motor_of_the_carriage_number_{k}", f"ball_screw_and_its_bearings_{k}"
        joints += [
            {"name": motor, "antecedent": before, "kind": "motor", "sigma": 1, "alpha": "pi/2", "r": f"q{2 * k - 1}"},
            {"name": spring, "antecedent": motor, "kind": "elastic", "sigma": 1, "r": f"q{2 * k}"},
        ]
        bodies |= {motor: {"mass": 3.0 + k}, spring: {"mass": 1.0 + 0.1 * k}}
        springs[spring] = {"stiffness": 1e5 * k, "damping": 10.0}
        before = spring if in_a_row else 0
    return {"name": "chain_of_many_carriages", "joints": joints, "bodies": bodies, "springs": springs}


def large() -> Iterator[Result]:
    """Results of a machine of 40 joints, in one chain, and for its feed-forward side by side."""
    machine = chain()
    motors = [joint["name"] for joint in machine["joints"] if joint["kind"] == "motor"]
    yield se.linearize(machine, hold=["all"])
    yield se.modes(machine, hold=["all"])
    yield se.response(machine, inputs=[f"{motors[0]}.tau"], band=(1, 1000, 40))
    yield modes_along(machine, {motors[0]: [0.0, 0.1, 0.2]}, Oscillating(hold=("all",)))
    yield se.feed_forward(chain(in_a_row=False), strokes=dict.fromkeys(motors, 0.1), duration=0.3, sample_rate=100)
    over: dict[str, Any] = {f"{machine['joints'][1]['name']}.stiffness": [1e4, 2e4, 4e4]}
    yield se.sweep(machine, over=over, hold=["all"])


@pytest.mark.thorough
def test_plots_of_40_joints_are_whole() -> None:
    for found in large():
        refuse_cut_text(found.plots())


@pytest.mark.thorough
def test_names_are_text(tmp_path: Path) -> None:
    """No formula is set, nothing warns, and SVG has no markup of the name."""

    def draw(axes: Any, below: Any) -> None:
        curves(axes, [1.0, 2.0], [[1.0, 2.0], [3.0, 4.0]], [NASTY, "$"])
        logarithmic(axes, "x", "y")
        axes.set_xlabel("x")
        legend(axes)
        bars(below, {NASTY: [1.0, 3.0]}, [NASTY, "$y"])

    plots = Figures({NASTY: Plot(f"{NASTY}: picture", draw, 2)})
    refuse_cut_text(plots)
    drawn = picture(plots[NASTY], "svg").decode("utf-8")
    assert "<script" not in drawn and "</script" not in drawn and "\u202e" not in drawn
    (path,) = plots.save(tmp_path, "svg")
    assert path.parent == tmp_path and file_name(NASTY)[:8] == "script_x"


def test_dollars_are_no_formula_in_axes_of_a_user() -> None:
    figure = Figure()
    axes = figure.subplots()
    plot = Plot("$x^{2$ $", lambda one: one.set_xlabel("$\\frac{$ $"))
    assert plot.into(axes) is axes
    figure.savefig("/dev/null", format="png")


def test_axes_of_a_user_are_drawn_into() -> None:
    response = MADE["Response"](Path())
    figure = Figure()
    axes = figure.subplots(2, 1)
    assert response.plot(axes=axes) is axes and all(axis.lines for axis in axes)
    with pytest.raises(InputError, match=r"axes: this plot needs 2, not 1: plt.subplots\(2, 1\)"):
        response.plot(axes=axes[0])
    with pytest.raises(InputError, match=r"plot: unknown 'bode': choose from bode_motor_tau"):
        response.plot("bode")
    one = Figure().subplots()
    modes = MADE["Modes"](Path())
    assert modes.plot("shapes", one) is one and one.get_title().startswith("drive: mode shapes")


@pytest.mark.thorough
def test_a_figure_shows_itself_in_a_notebook_on_both_papers() -> None:
    modes = MADE["Modes"](Path())
    light, dark = modes.plot("energies"), modes.plot("energies", dark=True)
    assert light._repr_png_().startswith(b"\x89PNG")
    assert (light.get_facecolor()[0], dark.get_facecolor()[0]) == (1.0, pytest.approx(int(DARK.paper[1:3], 16) / 255))
    svg = picture(modes.plot("energies"), "svg").decode()
    assert "prefers-color-scheme: dark" in svg and svg == picture(modes.plot("energies"), "svg").decode()
    assert all(f"fill: {colour}" in svg for colour in (LIGHT.ink, DARK.ink))


def luminance(colour: str) -> float:
    """Relative luminance of WCAG 2.2, of linear light."""
    return float(np.dot((0.2126, 0.7152, 0.0722), linear(colour)))


def linear(colour: str) -> Any:
    x = np.array([int(colour[k : k + 2], 16) / 255 for k in (1, 3, 5)])
    return np.where(x <= 0.04045, x / 12.92, ((x + 0.055) / 1.055) ** 2.4)


SIGHT = {
    "protan": [[0.152286, 1.052583, -0.204868], [0.114503, 0.786281, 0.099216], [-0.003882, -0.048116, 1.051998]],
    "deutan": [[0.367322, 0.860646, -0.227968], [0.280085, 0.672501, 0.047413], [-0.011820, 0.042940, 0.968881]],
    "tritan": [[1.255528, -0.076749, -0.178779], [-0.078411, 0.930809, 0.147602], [0.004733, 0.691367, 0.303900]],
}
"""Machado, Oliveira and Fernandes (2009), severity 1, of linear light."""


def lab(rgb: Any) -> Any:
    """CIE L*a*b* of linear light in sRGB, white D65."""
    to_xyz = [[0.4124564, 0.3575761, 0.1804375], [0.2126729, 0.7151522, 0.0721750], [0.0193339, 0.1191920, 0.9503041]]
    x = np.array(to_xyz) @ np.clip(rgb, 0, 1) / (0.95047, 1.0, 1.08883)
    f = np.where(x > 216 / 24389, np.cbrt(x), (24389 / 27 * x + 16) / 116)
    return np.array([116 * f[1] - 16, 500 * (f[0] - f[1]), 200 * (f[1] - f[2])])


@pytest.mark.parametrize("shades", [LIGHT, DARK], ids=["light", "dark"])
def test_colours_are_told_apart(shades: Any) -> None:
    """Texts have a contrast of 7, curves of 3; curves of one picture differ for colour-blind readers, too."""
    paper = luminance(shades.paper)

    def contrast(colour: str) -> float:
        return max(paper + 0.05, luminance(colour) + 0.05) / min(paper + 0.05, luminance(colour) + 0.05)

    assert contrast(shades.ink) >= 7
    assert all(contrast(colour) >= 3 for colour in (*shades.curves, shades.grey, shades.good, shades.bad))
    for matrix in (np.eye(3), *map(np.array, SIGHT.values())):
        seen = [lab(matrix @ linear(colour)) for colour in shades.curves]
        assert min(np.linalg.norm(x - y) for x, y in combinations(seen, 2)) >= 10


def test_curves_are_told_apart_in_grey() -> None:
    """The first six differ in dashes alone, all 36 in colour or dashes."""
    assert len({str(curve(k)["linestyle"]) for k in range(6)}) == 6
    assert len({str(curve(k)) for k in range(36)}) == 36


def test_import_takes_no_matplotlib() -> None:
    said = "import sys, symoro_elastic; print([x for x in sys.modules if x.split('.')[0] in ('matplotlib', 'numpy')])"
    assert run([sys.executable, "-c", said], capture_output=True, text=True, check=True).stdout == "[]\n"


def test_without_matplotlib_one_sentence_names_the_extra(monkeypatch: pytest.MonkeyPatch) -> None:
    plot = Plot("x", lambda axes: None)
    monkeypatch.setitem(sys.modules, "matplotlib", None)
    with pytest.raises(InputError, match=r"pip install 'symoro-elastic\[analysis\]'"):
        plot.figure()
