"""What pyproject.toml promises of packages: lower bounds that are tested, extras that name one another, one home."""

from __future__ import annotations

import re
import tomllib
from typing import Any

import pytest

from tests import lowest
from tests.golden import ROOT

PROJECT: dict[str, Any] = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
EXTRAS: dict[str, list[str]] = PROJECT["optional-dependencies"]
OF_CONTRIBUTORS = {"dev", "dev-all", "docs", "benchmarks"}
COPYLEFT = {"step"}
"""Extras whose packages have the GPL: users who ask for all do not get them."""
BOUNDED_ABOVE: dict[str, str] = {}
"""Packages whose next major version is known to break what needs them."""
PYTHONS = ("3.11", "3.12", "3.13")
NAMED = re.compile(r"symoro-elastic\[([a-z,-]+)\]")


def names(extra: str) -> set[str]:
    """The packages of an extra, without versions."""
    return {re.split(r"[\[><=; ]", one)[0] for one in lowest.requirements(extra)}


def test_the_constraints_are_the_lower_bounds() -> None:
    assert lowest.CONSTRAINTS.read_text(encoding="utf-8") == lowest.text(), "python -m tests.lowest --write"


def test_the_core_is_there() -> None:
    assert all((ROOT / path).exists() for path in lowest.CORE)


def test_every_dependency_has_a_lower_bound_and_hardly_any_an_upper_one() -> None:
    for one in [*PROJECT["dependencies"], *(line for lines in EXTRAS.values() for line in lines)]:
        if NAMED.fullmatch(one):
            continue
        name, bound = re.fullmatch(r"([\w-]+)(?:\[\w+\])?>=([\d.,<]+)(?:; sys_platform == 'linux')?", one).groups()  # type: ignore[union-attr]
        _, _, above = bound.partition(",<")
        assert above == BOUNDED_ABOVE.get(name, ""), one


def test_a_package_has_one_bound() -> None:
    every = {*PROJECT["dependencies"], *(line for lines in EXTRAS.values() for line in lines if not NAMED.match(line))}
    by_name: dict[str, set[str]] = {}
    for line in every:
        by_name.setdefault(re.split(r"[\[><=]", line)[0], set()).add(line)
    assert {name: lines for name, lines in by_name.items() if len(lines) > 1} == {"pin": {"pin>=2.7", "pin>=3"}}


def test_extras_name_one_another() -> None:
    assert names("identify") == names("analysis") == {"scipy", "matplotlib", "tomlkit"}
    users = set(EXTRAS) - OF_CONTRIBUTORS - {"all", *COPYLEFT}
    assert names("all") == set().union(*map(names, users))
    assert names("dev") < names("dev-all") and names("docs") | names("all") < names("dev-all")
    assert not names("dev") & {"jax", "casadi", "mujoco", "pin", "cmake", "zensical"}, "light for a beginning"


def test_messages_name_extras_that_there_are() -> None:
    said = {
        extra
        for path in (ROOT / "symoro_elastic").rglob("*.py")
        for extra in re.findall(r"import_optional\([^)]*\"([a-z]+)\"\)", path.read_text(encoding="utf-8"))
    }
    assert len(said) > 5 and said <= set(EXTRAS)
    page = (ROOT / "README.md").read_text(encoding="utf-8")
    assert set(re.findall(r"'\.\[([a-z-]+)\]'", page)) <= set(EXTRAS)


def test_versions_of_python_are_classified_and_run() -> None:
    listed = {one.rpartition(" ")[2] for one in PROJECT["classifiers"] if re.search(r"Python :: 3\.\d+$", one)}
    assert listed == {*PYTHONS} and PROJECT["requires-python"] == f">={PYTHONS[0]}"
    workflow = (ROOT / ".github" / "workflows" / "dependencies.yml").read_text(encoding="utf-8")
    assert all(f'"{version}"' in workflow for version in PYTHONS) and "tests.lowest --run" in workflow


def test_licences_of_what_is_shipped_are_listed() -> None:
    """The licence of three.js stands in its file, and in the folder that wheels take licences from."""
    head = (ROOT / "templates" / "view" / "vendor" / "three.min.js").read_text(encoding="utf-8")
    assert (ROOT / "LICENSES" / "three.js.txt").read_text(encoding="utf-8").strip() in head
    assert PROJECT["license-files"] == ["LICENSE", "LICENSES/*"]


@pytest.mark.parametrize("page", ["CODE_OF_CONDUCT.md", "SECURITY.md"])
def test_pages_of_the_community_are_there(page: str) -> None:
    assert len((ROOT / page).read_text(encoding="utf-8").split()) > 100


def test_the_wheel_has_links_once_it_is_released() -> None:
    """The address of the repository is known where it is released: the workflow writes the links before it builds."""
    workflow = (ROOT / ".github" / "workflows" / "release.yml").read_text(encoding="utf-8")
    links = workflow.index("[project.urls]")
    assert links < workflow.index("-m build") and "GITHUB_REPOSITORY" in workflow
