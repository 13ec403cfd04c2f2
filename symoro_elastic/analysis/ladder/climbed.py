"""The ladder of models of a machine: its rungs, the one that is chosen, and the budget where it was asked for."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path

from symoro_elastic.analysis.ladder.budget import Budget
from symoro_elastic.analysis.ladder.greedy import SpringFigures
from symoro_elastic.analysis.ladder.predicted_rungs import held_springs, zeros_of
from symoro_elastic.analysis.ladder.rung import Rung, Steps
from symoro_elastic.analysis.simulation.reference_motion import Reference
from symoro_elastic.formats.toml.kept_text import in_text_of
from symoro_elastic.formats.toml.motions import motions_of, wanted_of
from symoro_elastic.formats.toml.scenes import scene_in
from symoro_elastic.formats.toml.tables import load
from symoro_elastic.formats.toml.writing import write_scene
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.foundation.output_files import permission, write_text
from symoro_elastic.foundation.results import Result
from symoro_elastic.machine.described import Wanted
from symoro_elastic.machine.machine import Machine
from symoro_elastic.machine.scene import Scene
from symoro_elastic.machine.static_springs import held_positions
from symoro_elastic.models.catalogue import MODELS


@dataclass(frozen=True)
class Asked:
    """The machine as it was given, its scene, and what was wanted of it; `file` is that of the scene, if it has one."""

    machine: Machine
    scene: Scene
    wanted: Wanted | None
    file: str | Path | None = None


@dataclass(frozen=True, repr=False)
class Ladder(Result):
    """All rungs of a machine for its motions, the rung that is chosen, and the whole machine with RK4 to compare with.

    `chosen` is None where no rung fits the tolerances. `distrusted` are rungs whose prediction failed. `arithmetic` are
    errors by output that the chosen one has more where accelerations are in single precision; empty without one.
    `springs` are what is usually asked of each, `condensed` lines on springs in series that the machine has as one.
    `budget` is the path on which numbers, steps and precision share the tolerances with springs, where it is asked for.
    `asked` is what the scene asked of the whole machine, from which `write` makes the reduced one.
    """

    machine: Machine
    references: tuple[Reference, ...]
    tolerance: Mapping[str, float]
    rungs: tuple[Rung, ...]
    chosen: int | None
    full: Steps
    distrusted: tuple[int, ...] = ()
    arithmetic: Mapping[str, float] = field(default_factory=dict)
    springs: tuple[SpringFigures, ...] = ()
    condensed: tuple[str, ...] = ()
    budget: Budget | None = None
    asked: Asked | None = None

    @property
    def advised(self) -> Rung | None:
        """The model that is advised: the end of the budget, or the chosen rung; None where no rung fits."""
        if self.budget:
            return self.budget.advised.rung
        return None if self.chosen is None else self.rungs[self.chosen]

    @property
    def saving(self) -> float:
        """Operations of the whole machine with RK4 over those of the chosen rung."""
        rung = self.rungs[self.chosen or 0]
        return self.full.cost / rung.chosen.cost if rung.chosen else 1.0

    @property
    def headline(self) -> str:
        """Machine, rungs and the chosen one."""
        choice = "none fits" if self.chosen is None else f"{self.chosen} chosen, {self.saving:.3g} times less work"
        return f"Ladder of {self.machine.name}: {len(self.rungs)} rungs, {choice}"

    @property
    def worst_output(self) -> str:
        """The output whose error is the largest part of its tolerance, over all rungs."""
        return max(self.tolerance, key=lambda name: max(x.predicted[name] for x in self.rungs) / self.tolerance[name])

    def step_of(self, rung: Rung) -> float:
        """Return the shortest step of a rung that fits over all motions, s."""
        assert rung.chosen is not None
        return min(reference.duration for reference in self.references) / rung.chosen.steps

    def write(self, file: str | Path, *, force: bool = False) -> Path:
        """Write the scene of the advised model to a .toml file and return its path, as the command does by --save.

        Raises `InputError` for a file that exists unless `force`, and for a ladder that no scene asked for.
        """
        with permission(force=force):
            self.save(file)
        return Path(file)

    def save(self, file: str | Path) -> str:
        """Write the scene as `write` does, where files may be replaced as the command line says.

        It has the comments of the file of the scene; returned is a line on those that are lost.
        """
        if self.asked is None:
            raise InputError(self.machine.label, "ladder", "no scene asked for it: use se.ladder")
        motions = [reference.prescribed for reference in self.references]
        reduced = reduced_scene(self, self.asked.machine, self.asked.scene)
        said = (self.budget or self).as_json()["advice"]
        text, lost = in_text_of(self.asked.file, write_scene(reduced, motions, self.asked.wanted), self._normal)
        write_text(f"# {said}\n\n{text}", file, "--save")
        return lost

    def _normal(self, text: str) -> str:
        """Return the text of a scene in normal form."""
        assert self.asked is not None
        top, whole = load(text, str(self.asked.file)), self.asked.machine
        return write_scene(scene_in(top, whole, MODELS), motions_of(top, whole), wanted_of(top))


def reduced_scene(found: Ladder, whole: Machine, scene: Scene) -> Scene:
    """Return the scene of a whole machine with the method of the advised model, its springs held, numbers left out."""
    rung, reference = found.advised, found.references[0]
    if rung is None:
        return scene
    assert rung.chosen is not None
    held = held_springs(found.machine, reference, rung)
    steps = tuple(dict.fromkeys((*scene.steps, *filter(None, (rung.chosen.method,)))))
    forces = dict.fromkeys((*scene.forces, *(str(x) for one in found.references for x in one.loaded.forces)))
    zero = tuple(dict.fromkeys((*scene.zero, *zeros_of(rung, held))))
    condense = scene.condense or bool(found.condensed)
    scene = replace(scene, forces=tuple(forces), steps=steps, condense=condense, zero=zero)
    if rung.locked:
        return replace(scene, locked={**scene.locked, **held})
    return replace(scene, static={**held_positions(whole, scene.static), **held})
