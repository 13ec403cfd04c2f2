"""JSON Schemas (draft 2020-12) of TOML files, for editors: made of the rows of the reader."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any

from symoro_elastic.formats.toml.key import DEFINITIONS, Schema
from symoro_elastic.formats.toml.keys import MACHINE, SCENE
from symoro_elastic.formats.toml.motion_keys import MOTIONS, WANTED
from symoro_elastic.formats.toml.vibration_tests import TESTS, TOP

DRAFT = "https://json-schema.org/draft/2020-12/schema"


def machine_schema(models: Collection[str]) -> dict[str, Any]:
    """JSON schema of a machine file; its scene may name `models`."""
    schema = dict(MACHINE.schema)
    scene = schema["properties"]["scene"]
    schema["properties"] = schema["properties"] | {"scene": _naming(scene, models)}
    return {"$schema": DRAFT, "title": "Machine of symoro-elastic", **schema, "$defs": DEFINITIONS}


def scene_schema(models: Collection[str]) -> dict[str, Any]:
    """JSON schema of a scene file, its keys under [scene] or at the top; it may name `models`."""
    scene = _naming(SCENE.schema, models)
    tables = {"scene": scene, "motion": MOTIONS.type.schema, "wanted": WANTED.schema}
    properties = {**scene["properties"], **tables}
    alone = {"scene": {"propertyNames": {"enum": list(tables)}}}
    return {
        **{"$schema": DRAFT, "title": "Scene of symoro-elastic", "type": "object"},
        **{"properties": properties, "additionalProperties": False, "dependentSchemas": alone, "$defs": DEFINITIONS},
    }


def tests_schema(_models: Collection[str]) -> dict[str, Any]:
    """JSON schema of a list of vibration tests, which names no models."""
    head = {"$schema": DRAFT, "title": "Vibration tests of symoro-elastic", "type": "object"}
    return {
        **head,
        "properties": {TOP: TESTS.schema},
        "required": [TOP],
        "additionalProperties": False,
        "$defs": DEFINITIONS,
    }


SCHEMAS = {"machine": machine_schema, "scene": scene_schema, "tests": tests_schema}
"""The schemas by what they describe."""


def _naming(scene: Schema, models: Collection[str]) -> dict[str, Any]:
    """JSON schema of a scene in which only `models` may be named."""
    name = {"enum": list(models)}
    properties = scene["properties"]
    return {
        **scene,
        "properties": {
            **properties,
            "models": {**properties["models"], "type": "array", "items": name},
            "outputs": {**properties["outputs"], "propertyNames": name},
        },
    }
