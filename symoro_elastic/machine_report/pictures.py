"""Pictures of a machine at rest and in its modes."""

from __future__ import annotations

from collections.abc import Iterator

import numpy as np

from symoro_elastic.drawing.figure import figure_of
from symoro_elastic.drawing.placements import placements_of
from symoro_elastic.drawing.svg import picture_of, said, svg
from symoro_elastic.drawing.vibrations import full_shape
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine_report.section import image
from symoro_elastic.vibration.energies import strain_shares
from symoro_elastic.vibration.modes import Modes

MOST_PICTURES = 6


def machine_image(machine: Machine) -> str:
    """Return the picture of a machine where its joints are at zero and its springs neutral."""
    placements = placements_of(machine)
    figure = figure_of(placements, placements.start)
    return image(svg(picture_of(figure)), f"{machine.name}: {said(figure)}")


def mode_images(modal: Modes, machine: Machine) -> Iterator[str]:
    """Return a picture of each of the lowest modes, at full amplitude."""
    placements = placements_of(machine)
    q = modal.linear.state.q
    figure = figure_of(placements, q)
    strain = strain_shares(modal)
    vibrating = [int(k) for k in np.flatnonzero(modal.frequencies > 0)][:MOST_PICTURES]
    for k in vibrating:
        name, share = strain.largest(k)
        said_of = f"Mode {k + 1}: {modal.frequencies[k]:.4g} Hz, {share:.0%} of the strain energy in {name}"
        T = placements.at(q + full_shape(modal, k, figure.extent))
        yield image(svg(picture_of(figure, T)), said_of, said_of)
