"""The JSON Schemas accept what the reader reads, and refuse mistakes of keys, types, lengths and names."""

from __future__ import annotations

import tomllib
from pathlib import Path
from typing import Any

import jsonschema
import pytest

from symoro_elastic.formats.toml import reading as toml
from symoro_elastic.formats.toml.schema import SCHEMAS, machine_schema, scene_schema
from symoro_elastic.foundation.errors import InputError
from symoro_elastic.machine.checks import check
from symoro_elastic.models.programs.catalogue import MODELS
from tests.formats.test_bad_toml import BAD
from tests.machine.samples import COUPLED, TOML

EXAMPLES = sorted((Path(__file__).parents[2] / "examples").glob("*.toml"))
MACHINE, SCENE = (jsonschema.Draft202012Validator(schema(MODELS)) for schema in (machine_schema, scene_schema))
# Reasons of the reader that only the reader can give: they need arithmetic, other rows, or the value of a number.
BEYOND = (
    *("needs arithmetic", "not arithmetic", "exponent", "there are sin", "ends too early"),
    *("out of the range", "no value", "division by zero", "terms and signs", "deeper", "bits", "digits", "not finite"),
    *("holds names", "did you mean 'lift'", "closed loops", "taken by", "joint variable", "keyword", "generated code"),
    *(
        "is in r",
        "not declared",
        "both new",
        "plus a constant",
        "variable of joint",
        "needs a stiffness",
        "only an elastic",
        "the motor has no spring",
    ),
    *("intermediate", "out of range", "would hide", "a device", "5002 characters", "5000 characters"),
    *("must be below", "give both", "with bristle", "no coulomb", "keep one"),
)


def refusals(validator: Any, text: str) -> list[str]:
    return [error.message for error in validator.iter_errors(tomllib.loads(text))]


def test_the_schemas_are_schemas() -> None:
    jsonschema.Draft202012Validator.check_schema(MACHINE.schema)
    jsonschema.Draft202012Validator.check_schema(SCENE.schema)


@pytest.mark.parametrize("path", EXAMPLES, ids=[path.name for path in EXAMPLES])
def test_every_example_is_accepted(path: Path) -> None:
    assert refusals(MACHINE, path.read_text(encoding="utf-8")) == []


def test_the_sample_is_accepted() -> None:
    assert refusals(MACHINE, TOML) == []


AS_WRITTEN = ('d = "10^10^10"', "sigma = 1.0", f"sigma = {'1' * 100}", 'mass = "L2 - 1"')
WRONG = [case for case in BAD if case[1] not in AS_WRITTEN and not any(reason in case[3] for reason in BEYOND)]


@pytest.mark.parametrize(("old", "new", "place", "reason"), WRONG, ids=[new[:30] for _, new, _, _ in WRONG])
def test_what_the_reader_refuses_of_keys_types_and_lengths_is_refused(
    old: str, new: str, place: str, reason: str
) -> None:
    text = TOML.replace(old, new, 1)
    with pytest.raises(InputError):
        check(toml.read(text, "arm.toml"))
    assert refusals(MACHINE, text) != []


def test_many_wrong_files_are_compared() -> None:
    assert len(WRONG) >= 35


@pytest.mark.parametrize(
    "text",
    [
        (Path(__file__).parents[2] / "examples" / "scenes" / "two_axis_move.toml").read_text(encoding="utf-8"),
        "gravity = false\n[[motion]]\nduration = 1\n[[motion]]\nduration = 2",
        'steps = ["w3"]\nstatic = ["gear"]\n[wanted]\ntolerance = 1e-6',
        'models = ["jacobian"]',
        "[scene]\ngravity = false",
        'outputs = { jacobian = ["tool at (0.1, 0, 0)"] }',
        "",
    ],
)
def test_scenes_are_accepted(text: str) -> None:
    assert refusals(SCENE, text) == []


@pytest.mark.parametrize(
    "text",
    [
        'models = ["jacobean"]',
        'model = ["jacobian"]',
        "gravity = 0",
        'fold = "none"',
        "locked = { elbow = true }",
        "[scene]\ngravity = 1",
        'fold = "all"\n[scene]\ngravity = false',
        'steps = ["rk5"]',
        "[motion]",
        "[motion]\nduration = 1\nmoves = [{ motor = 3, by = 1, in = 1 }]",
        "[motion]\nduration = 1\nservo = { drive = { kp = 1, damping = 1 } }",
        "[motion]\nduration = 1\nservo = { drive = { kp = 1 } }",
        '[wanted]\ntolerance = ["tool.x"]',
    ],
)
def test_wrong_scenes_are_refused(text: str) -> None:
    assert refusals(SCENE, text) != []


TESTS = jsonschema.Draft202012Validator(SCHEMAS["tests"](MODELS))
LISTS = sorted((Path(__file__).parents[2] / "examples").glob("*/tests.toml"))


@pytest.mark.parametrize("path", LISTS, ids=[path.parent.name for path in LISTS])
def test_lists_of_tests_are_accepted(path: Path) -> None:
    assert refusals(TESTS, path.read_text(encoding="utf-8")) == []


@pytest.mark.parametrize(
    "text",
    [
        "",
        "[tests]",
        "[[tests]]\nat = { x = 1 }",
        '[[tests]]\nfile = "m.csv"\nheld = ["x"]',
        '[[tests]]\nfile = "m.csv"\nhold = "all"',
        '[[tests]]\nfile = "m.csv"\npd = { x = [1] }',
        '[[tests]]\nfile = "m.csv"\npd = { x = "none" }',
        '[[tests]]\nfile = "m.csv"\nband = [1, 2, 3]',
        '[[tests]]\nfile = "m.csv"\naverages = 1.5',
        '[[tests]]\nfile = "m.csv"\nrename = { a = 1 }',
    ],
)
def test_wrong_lists_of_tests_are_refused(text: str) -> None:
    assert refusals(TESTS, text) != []


# What is replaced in the sample of couplings and loops, and by what: keys, types and words that the schema knows.
COUPLED_WRONG = [
    ('theta = "N1*q1"', 'theta = "N1*q1", variable = "q1"'),
    ('kind = "fixed", d', 'kind = "fixed", variable = "q1", d'),
    ('kind = "coupled", sigma = 0', 'kind = "coupled"'),
    ('kind = "coupled", sigma = 0', 'kind = "coupled", sigma = 2'),
    ('kind = "cut", sigma = 0', 'kind = "cut"'),
    ('kind = "cut", sigma = 0', 'kind = "cut", sigma = 3'),
    ('meets = "pin_end"\n', ""),
    ('meets = "pin_end"', "meets = 9"),
    ('meets = "pin_end"', 'meets = "pin_end"\ncloses = "line"'),
    ("start = {", "starts = {"),
    ("q3 = 1.5", "q3 = true"),
    ('["q3", "rod"]', '"q3"'),
]


def test_the_sample_of_couplings_and_loops_is_accepted() -> None:
    assert refusals(MACHINE, COUPLED) == []
    welded = COUPLED.replace('sigma = 0, d = "L2", theta = "q6"', 'sigma = 2, d = "L2"')
    assert refusals(MACHINE, welded) == [] and check(toml.read(welded, "arm.toml")) == []


@pytest.mark.parametrize(("old", "new"), COUPLED_WRONG, ids=[new[:40] for _, new in COUPLED_WRONG])
def test_mistakes_in_couplings_and_loops_are_refused(old: str, new: str) -> None:
    assert old in COUPLED
    text = COUPLED.replace(old, new, 1)
    with pytest.raises(InputError):
        check(toml.read(text, "arm.toml"))
    assert refusals(MACHINE, text) != []
