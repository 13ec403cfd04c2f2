"""Requests for a machine: scenes, motions and tolerances, from files, tables or arguments."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from symoro_elastic.api.checked_calls import COMMAND
from symoro_elastic.api.machines import the_machine
from symoro_elastic.api.options import Generating, Requested, RequestedModels, Trading
from symoro_elastic.api.rows import MachineLike, SceneLike
from symoro_elastic.formats.files import load_text
from symoro_elastic.formats.kinds_of_files import FileKind, read_as
from symoro_elastic.formats.toml.motions import motions_of, wanted_of
from symoro_elastic.formats.toml.reading import scene_in
from symoro_elastic.formats.toml.tables import Table, load, table_of
from symoro_elastic.foundation.errors import InputError, among, reported_places
from symoro_elastic.machine.described import DescribedMachine, Wanted
from symoro_elastic.machine.formula import FormulaError
from symoro_elastic.machine.prescribed_motion import PrescribedMotion
from symoro_elastic.machine.resolve import resolve
from symoro_elastic.machine.restrict import restrict
from symoro_elastic.machine.scene import ALL, FORMS, Scene
from symoro_elastic.machine.series_springs import condense
from symoro_elastic.machine.within import ALL_RESULTS, GUARANTEES, Evidence, Keep, Within, tolerance
from symoro_elastic.models.programs.catalogue import DEFAULT_MODELS, KINEMATIC_MODELS, MODELS, refuse_without_value

TYPED = {"scene, models": "--model", "scene, fold": "--fold", "scene, outputs": "--only"}
"""Options by the keys of a scene that they replace."""


def no_note(_line: str) -> None:
    """Discard a note."""


@dataclass(frozen=True)
class SceneRequest:
    """Models, constants and outputs in addition to the scene of a file.

    `outputs` are names of joints or frames by model, or columns of derivatives ("by M1, K2").
    """

    models: Sequence[str] = ()
    fold: Sequence[str] = ()
    outputs: Mapping[str, Sequence[str]] | None = None
    steps: Sequence[str] = ()

    def of(self, machine: DescribedMachine, scene: SceneLike, note: Callable[[str], None] = no_note) -> Scene:
        """Return the scene of a machine with these additions.

        Models replace those of the scene, and their outputs go with them. `note` is called with a line for springs in
        series that the scene condenses.
        """
        additions = Scene(
            models=tuple(dict.fromkeys(self.models)),
            outputs={model: tuple(names) for model, names in (self.outputs or {}).items()},
            fold=ALL if ALL in self.fold else tuple(self.fold),
        )
        with reported_places(TYPED):
            added = resolve(additions, machine, MODELS, machine.label).outputs
            refuse_without_value(machine, additions)
        requested = self._with_models(given_scene(machine, scene))
        if self.fold:
            everything = ALL in self.fold or requested.fold == ALL
            requested = replace(requested, fold=ALL if everything else (*requested.fold, *self.fold))
        merged = {m: (*requested.outputs.get(m, ()), *added.get(m, ())) for m in (*requested.outputs, *added)}
        steps = tuple(dict.fromkeys((*requested.steps, *self.steps)))
        requested = resolve(
            replace(requested, outputs=merged, steps=steps), machine, MODELS, requested.source or machine.source
        )
        for line in condense(machine).notes if requested.condense else ():
            note(line)
        return requested

    def _with_models(self, scene: Scene) -> Scene:
        if not self.models:
            return scene
        dropped = set(scene.models or DEFAULT_MODELS) - set(self.models)
        outputs = {model: names for model, names in scene.outputs.items() if model not in dropped}
        return replace(scene, models=tuple(dict.fromkeys(self.models)), outputs=outputs)


def scene_for(
    machine: DescribedMachine, options: Requested, steps: Sequence[str] = (), note: Callable[[str], None] = no_note
) -> Scene:
    """Return the scene of a machine with requested additions, and with the form of direct_dynamics."""
    models = options.models if isinstance(options, RequestedModels) else ()
    scene = SceneRequest(models, options.fold, options.only, steps).of(machine, options.scene, note)
    if not (scene.models or machine.has_inertia):
        note(f"without mass and inertia, the models are {' and '.join(KINEMATIC_MODELS)}")
        scene = replace(scene, models=KINEMATIC_MODELS)
    scene = in_tolerance(scene, options) if isinstance(options, Generating | Trading) else scene
    if isinstance(options, RequestedModels):
        among((options.form,), FORMS, "--form")
        scene = replace(scene, form=options.form)
    return scene


def in_tolerance(scene: Scene, options: Generating | Trading) -> Scene:
    """Return the scene with tolerances of options in place of its own; raises `InputError`."""
    keep, guaranteed = options.keep, options.guaranteed
    for value, choices, option in ((keep, Keep, "--keep"), (guaranteed, GUARANTEES, "--guaranteed")):
        if value:
            among((value,), list(choices), option)
    within = scene.within
    if options.within:
        try:
            tolerances = {name: tolerance(x, name) for name, x in by_name(options.within).items()}
        except FormulaError as error:
            raise InputError(COMMAND, "--within", str(error)) from None
        within = Within(tolerances)
    if (keep or guaranteed) and not within:
        place = "--keep" if keep else "--guaranteed"
        raise InputError(COMMAND, place, "belongs to a tolerance: add --within, or leave it out")
    within = replace(within, keep=Keep(keep)) if keep else within
    within = replace(within, guaranteed=Evidence(guaranteed)) if guaranteed else within
    return replace(scene, within=within)


def by_name(tolerance: str | float | Mapping[str, str | float]) -> Mapping[str, str | float]:
    """Return tolerances by name, an unnamed one for all results."""
    return tolerance if isinstance(tolerance, Mapping) else {ALL_RESULTS: tolerance}


def top_of(scene: str | Path | Mapping[str, Any]) -> Table:
    """Return the top table of a scene file, or of equivalent tables."""
    if isinstance(scene, Mapping):
        return table_of(scene, "scene")
    with read_as(FileKind.SCENE, scene):
        return load(load_text(scene), str(scene))


def given_scene(machine: DescribedMachine, scene: SceneLike) -> Scene:
    """Return the scene of a file, of tables, or of the machine."""
    if isinstance(scene, Scene):
        return scene
    if scene is None:
        return machine.asked.scene or Scene()
    with nullcontext() if isinstance(scene, Mapping) else read_as(FileKind.SCENE, scene):
        return scene_in(top_of(scene), machine, MODELS)


def kept_machine(machine: MachineLike, scene: SceneLike) -> DescribedMachine:
    """Return a machine with the joints of a scene locked."""
    full = the_machine(machine)
    return replace(restrict(full, SceneRequest().of(full, scene)), forces=())


@dataclass(frozen=True)
class Prescribed:
    """Motions of a scene, and the requirements on them; `source` is their file."""

    motions: tuple[PrescribedMotion, ...]
    wanted: Wanted | None
    source: str


def required_motions(machine: DescribedMachine, scene: SceneLike) -> Prescribed:
    """Return the motions of a scene, or those of the machine's file; raises `InputError` without a motion."""
    prescribed = motions_of_scene(machine, scene)
    if not prescribed.motions:
        what = "missing: write a table [motion] with duration and moves, or give a scene that has one"
        raise InputError(prescribed.source, "motion", what)
    return prescribed


def motions_of_scene(machine: DescribedMachine, scene: SceneLike) -> Prescribed:
    """Return the motions of a scene, or those of the machine's file, if any."""
    if scene is None or isinstance(scene, Scene):
        return Prescribed(machine.asked.motions, machine.asked.wanted, machine.label)
    top = top_of(scene)
    return Prescribed(motions_of(top, machine), wanted_of(top), top.source)
