"""Tables of names, symbols and units, made from the program's own: they cannot go out of date."""

from __future__ import annotations

import re
from importlib import import_module
from typing import Any

from docutils import nodes
from sphinx.application import Sphinx
from sphinx.util.docutils import SphinxDirective

# symbol and sign of what the program names; the descriptions give name, unit and meaning
_SYMBOLS = {
    "thickness": "$2h$",
    "roll_friction": r"$\mu^+$",
    "drum_friction": r"$\mu^-$",
    "friction": r"$\mu$",
    "nip_load": "$P$",
    "load": "$P$",
    "winding_force": "$F$",
    "web_tension": r"$T_\mathrm{in}$",
    "tangential_load": "$Q$",
    "creepage": r"$\xi$",
    "radius": "$R$",
    "core_radius": "$R_0$",
    "radial": "$A_{rr}$",
    "tangential": "$A_{tt}$",
    "cross": "$A_{rt}$",
    "shear": "$G$",
    "youngs_modulus": "$E$",
    "poissons_ratio": r"$\nu$",
}
_SIGNS = {
    "nip_load": "> 0 presses",
    "load": "> 0 presses",
    "winding_force": "> 0 the drum brakes",
    "web_tension": "> 0 pulls",
    "nip_induced_tension": "> 0 tauter behind the nip",
    "wound_on_tension": "> 0 pulls",
    "approach": "> 0 closer",
    "offset": "> 0 along +x",
    "drum_creep": "> 0 unstrained web faster than drum",
    "pressure": "> 0 presses",
    "roll_traction": "> 0 drags the roll along +x",
    "drum_traction": "> 0 drags the drum along +x",
    "roll_slip": "> 0 web faster",
    "drum_slip": "> 0 web faster",
    "roll_zone": "+1 web faster",
    "drum_zone": "+1 web faster",
    "leading_roll": "> 0 web faster",
    "trailing_roll": "> 0 web faster",
    "dual": "> 0 web faster",
    "creepage": "> 0 lower surface faster",
    "tangential_load": "> 0 drags the upper roller along +x",
    "traction": "> 0 drags the upper roller along +x",
    "slip": "> 0 lower surface faster",
    "zone": "+1 lower surface faster",
}

_GREEK = "delta|Delta|xi|mu|theta|eta"


def _tex(symbol: str) -> str:
    """Return a plain symbol ("T_out", "xi-") as TeX; words stay words."""
    if not re.fullmatch(r"(2?[A-Za-z]|{0})(_\w+)?[+-]?|NIT".format(_GREEK), symbol):
        return symbol
    if symbol == "NIT":
        return r"$\mathrm{NIT}$"
    symbol = re.sub(rf"^({_GREEK})", r"\\\1", symbol)
    symbol = re.sub(r"_(\w+)", r"_{\\mathrm{\1}}", symbol)
    return "$" + re.sub(r"([+-])$", r"^{\1}", symbol) + "$"


def _table(header: tuple[str, ...], rows: list[tuple[str, ...]]) -> str:
    lines = [header, tuple("---" for _ in header), *rows]
    return "\n".join("| " + " | ".join(line) + " |" for line in lines)


def _unit(unit: str) -> str:
    return "" if unit in ("", "1") else unit


class Quantities(SphinxDirective):
    """``{quantities}``: the results' quantities, from woundon.quantities."""

    def run(self) -> list[nodes.Node]:
        table = import_module("woundon.quantities").QUANTITIES
        rows = [
            (_tex(q.symbol), f"`{name}`", _unit(q.unit), q.description, _SIGNS.get(name, ""))
            for name, q in table.items()
        ]
        header = ("symbol", "name", "SI unit", "meaning", "sign")
        return self.parse_text_to_nodes(_table(header, rows))


class Fields(SphinxDirective):
    """``{fields} woundon.problems.NipProblem``: a description's fields, units and ranges."""

    required_arguments = 1

    def run(self) -> list[nodes.Node]:
        module, _, name = self.arguments[0].rpartition(".")
        fields: dict[str, Any] = getattr(import_module(module), name).model_fields
        rows = []
        for field, info in fields.items():
            if field == "kind":
                continue
            extra = info.json_schema_extra if isinstance(info.json_schema_extra, dict) else {}
            default = "required" if info.is_required() else f"`{info.default}`"
            unit = _unit(str(extra.get("unit", "")))
            about = info.description or _type_name(info.annotation)
            sign = _SIGNS.get(field, "")
            rows.append((_SYMBOLS.get(field, ""), f"`{field}`", unit, about, sign, default))
        header = ("symbol", "name", "SI unit", "meaning", "sign", "default")
        return self.parse_text_to_nodes(_table(header, rows))


def _type_name(annotation: Any) -> str:
    found = re.findall(r"woundon\.\w+\.(\w+)", str(annotation))
    return ", ".join(dict.fromkeys(f"`{name}`" for name in found)) or "one of its kinds"


class Materials(SphinxDirective):
    """``{materials}``: the library of named materials and their sources."""

    def run(self) -> list[nodes.Node]:
        library = import_module("woundon.materials").MATERIALS
        rows = []
        for name, entry in library.items():
            numbers = entry.material.model_dump(exclude={"kind"})
            values = ", ".join(f"{key} {value:g}" for key, value in numbers.items())
            rows.append((f"`{name}`", values, entry.source))
        return self.parse_text_to_nodes(_table(("name", "values [SI]", "source"), rows))


def setup(app: Sphinx) -> dict[str, Any]:
    """Register the directives."""
    app.add_directive("quantities", Quantities)
    app.add_directive("fields", Fields)
    app.add_directive("materials", Materials)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
