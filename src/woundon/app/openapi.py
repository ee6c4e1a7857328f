"""The interface's own description: examples, refusals, and a page that people can read."""

from __future__ import annotations

import json
from html import escape
from typing import Any

from .refusals import MEDIA

__all__ = ["OF_CASE", "OF_CASES", "OF_DESIGN", "OF_STUDY", "OF_TOML", "described", "page_of"]

_NIP = {
    "web": {"thickness": "66 um", "material": "newsprint"},
    "roll": {"radius": 0.1, "core_radius": 0.0445, "material": "newsprint"},
    "drum": {"kind": "rigid", "radius": "76.2 mm"},
    "roll_friction": 0.19,
    "drum_friction": 0.2,
    "nip_load": "3.5 kN/m",
    "web_tension": 350,
}
_ROLLERS = {
    "upper": {"radius": 0.25, "material": "steel"},
    "lower": {"radius": 0.25, "material": "steel"},
    "load": 89e3,
    "friction": 0.5,
    "tangential_load": 8.4e3,
}
_WITHOUT_WRAPS = {**_NIP, "wrap": {"roll_wrap": 0}}
_WITH_AIR = {**_NIP, "web_speed": "15 m/s", "air": {"roughness": "3 um", "permeance": 1e-7}}
_ROLL = {
    "radius": 0.15,
    "core": {"radius": 0.0445, "stiffness": "1 GPa"},
    "stack": {
        "radial": {"kind": "pfeiffer", "K1": "10 kPa", "K2": 40},
        "tangential": "3.38 GPa", "poissons_ratio": 0.01, "shear": "10 MPa",
    },
    "web_thickness": "66 um",
    "wound_on_tension": 350,
}  # fmt: skip
_TOML = 'schema = 1\nload = "89 kN/m"\nfriction = 0.5\n[upper]\nradius = "0.25 m"\n'

_VALUE = {
    "description": "a number in SI, a text with its unit, or a table",
    "anyOf": [{"type": t} for t in ("number", "string", "object", "array", "null")],
}
_TABLES = {
    "type": "object",
    "description": "the tables of a case file; /api/catalogue tells all names",
    "additionalProperties": _VALUE,
}
_UNITS = {"type": "object", "additionalProperties": {"type": "string"}}
_CASES = {
    "type": "object",
    "required": ["cases"],
    "properties": {
        "cases": {
            "type": "array", "minItems": 1, "maxItems": 4,
            "items": {"type": "object", "required": ["case"],
                      "properties": {"label": {"type": "string"}, "case": _TABLES}},
        },
        "units": _UNITS,
        "title": {"type": "string"},
        "remarks": {"type": "string"},
    },
}  # fmt: skip
_STUDY = {
    "type": "object",
    "required": ["case", "over"],
    "properties": {
        "case": _TABLES,
        "over": {"type": "object", "additionalProperties": _VALUE},
        "outputs": {"type": "array", "items": {"type": "string"}},
        "solver": {"type": "object"},
        "tie": {"type": "object", "additionalProperties": {"type": "string"}},
        "design": {"type": "object"},
    },
}


def _body(schema: Any, **examples: Any) -> dict[str, Any]:
    told = {name: {"value": value} for name, value in examples.items()}
    content = {"application/json": {"schema": schema, "examples": told}}
    return {"requestBody": {"required": True, "content": content}}


OF_CASE = _body(_TABLES, nip=_NIP, without_wraps=_WITHOUT_WRAPS, with_air=_WITH_AIR,
                rollers=_ROLLERS)  # fmt: skip
OF_CASES = _body(_CASES, two={"cases": [
    {"label": "A", "case": _NIP}, {"label": "B", "case": {**_NIP, "nip_load": "5 kN/m"}},
], "units": {"nip_load": "pli"}})  # fmt: skip
OF_STUDY = _body(_STUDY, loads={
    "case": _NIP, "over": {"nip_load": {"from": "1 kN/m", "to": "5 kN/m", "count": 5}},
    "outputs": ["nip_induced_tension", "nip_width"],
})  # fmt: skip
_DESIGN = {
    "type": "object",
    "required": ["case", "pressure"],
    "properties": {
        "case": _TABLES,
        "pressure": {**_VALUE, "description": "wanted between the laps: a number in Pa, a text "
                     "with its unit, or a table of radius and value from core to surface"},
        "rtol": {"type": "number", "minimum": 1e-6, "maximum": 1e-2},
    },
}  # fmt: skip
OF_DESIGN = _body(
    _DESIGN, constant={"case": _ROLL, "pressure": "200 kPa"},
    falling={"case": _ROLL, "rtol": 1e-3, "pressure": {
        "radius": ["44.5 mm", "90 mm", "150 mm"], "value": ["250 kPa", "180 kPa", 0],
    }},
)  # fmt: skip
OF_TOML = _body(
    {"type": "object", "required": ["toml"], "properties": {"toml": {"type": "string"}}},
    text={"toml": _TOML},
)

_PROBLEM = {
    "type": "object",
    "properties": {
        "type": {"type": "string"}, "title": {"type": "string"}, "status": {"type": "integer"},
        "detail": {"type": "string"},
        "errors": {"type": "array", "items": {"type": "object", "properties": {
            "field": {"type": "string"}, "message": {"type": "string"},
            "range": {"type": "object"}, "unit": {"type": "string"},
        }}},
    },
}  # fmt: skip
_REFUSALS = {
    "400": "the body is not JSON", "401": "a token is needed", "403": "another site's request",
    "408": "the body came too slowly", "409": "a newer request took its place",
    "413": "larger than is served", "415": "the body is not called JSON",
    "422": "the case is not admissible, or not solved",
    "503": "busy, or a worker died; send it again", "504": "it took too long",
}  # fmt: skip


def described(document: dict[str, Any]) -> dict[str, Any]:
    """Return the OpenAPI document with what every route may refuse."""
    document.setdefault("components", {}).setdefault("schemas", {})["Problem"] = _PROBLEM
    content = {MEDIA: {"schema": {"$ref": "#/components/schemas/Problem"}}}
    for path in document["paths"].values():
        for route in path.values():
            answers = route["responses"]
            for status, about in _REFUSALS.items():
                answers[status] = {"description": about, "content": content}
            answers["200"] = {"description": "done"}
    return document


def page_of(document: dict[str, Any]) -> str:
    """Return the document as a page: routes, what they say, and an example of each."""
    info = document["info"]
    parts = [f"<h1>{escape(info['title'])} {escape(info['version'])}</h1>",
             f"<p>{escape(info['description'])} The same as a document: "
             '<a href="/openapi.json">openapi.json</a>; names, units and ranges of all fields: '
             '<a href="/api/catalogue">catalogue</a>.</p>']  # fmt: skip
    for path, routes in document["paths"].items():
        for method, route in routes.items():
            parts.append(f"<h2><code>{method.upper()} {escape(path)}</code></h2>")
            parts.append(f"<p>{escape(route.get('description', ''))}</p>")
            parts += [_argument(argument) for argument in route.get("parameters", ())]
            parts += _examples(route)
    told = "".join(f"<li>{status}: {escape(about)}</li>" for status, about in _REFUSALS.items())
    parts.append("<h2>Refusals</h2><p>problem+json (RFC 9457), with field, message and range</p>"
                 f"<ul>{told}</ul>")  # fmt: skip
    head = f'<!doctype html><html lang="en"><meta charset="utf-8"><title>{escape(info["title"])}'
    return f"{head}: HTTP interface</title><body>{''.join(parts)}</body></html>"


def _argument(argument: dict[str, Any]) -> str:
    limits = {k: v for k, v in argument["schema"].items() if k not in ("title", "anyOf")}
    return f"<p><code>?{escape(argument['name'])}=</code> {escape(json.dumps(limits))}</p>"


def _examples(route: dict[str, Any]) -> list[str]:
    content = route.get("requestBody", {}).get("content", {}).get("application/json", {})
    return [
        f"<details><summary>{escape(name)}</summary><pre>"
        f"{escape(json.dumps(example['value'], indent=1))}</pre></details>"
        for name, example in content.get("examples", {}).items()
    ]
