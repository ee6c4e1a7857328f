"""Bodies of requests; the OpenAPI document is generated from these models."""

from __future__ import annotations

from typing import Annotated, Any, Literal

from fastapi import Body
from pydantic import BaseModel, ConfigDict, Field

from .limits import LIMITS

__all__ = [
    "Case",
    "CaseText",
    "Cases",
    "CurveQuery",
    "DesignRequest",
    "FileQuery",
    "FindRequest",
    "FitRequest",
    "GradeRequest",
    "LabelledCase",
    "SolveQuery",
    "SolverQuery",
    "Study",
    "WindowRequest",
]

NIP = {
    "web": {"thickness": "66 um", "material": "newsprint"},
    "roll": {"radius": 0.1, "core_radius": 0.0445, "material": "newsprint"},
    "drum": {"kind": "rigid", "radius": "76.2 mm"},
    "roll_friction": 0.19,
    "drum_friction": 0.2,
    "nip_load": "3.5 kN/m",
    "web_tension": 350,
}
ROLLERS = {
    "upper": {"radius": 0.25, "material": "steel"},
    "lower": {"radius": 0.25, "material": "steel"},
    "load": 89e3,
    "friction": 0.5,
    "tangential_load": 8.4e3,
}
AIR = {"web_speed": "15 m/s", "air": {"roughness": "3 um", "permeance": 1e-7}}
ROLL = {
    "radius": 0.15,
    "core": {"radius": 0.0445, "stiffness": "1 GPa"},
    "stack": {
        "radial": {"kind": "pfeiffer", "K1": "10 kPa", "K2": 40},
        "tangential": "3.38 GPa",
        "poissons_ratio": 0.01,
        "shear": "10 MPa",
    },
    "web_thickness": "66 um",
    "wound_on_tension": 350,
}
PRESSURE = {"radius": ["44.5 mm", "90 mm", "150 mm"], "value": ["250 kPa", "180 kPa", 0]}
MEASURED = "nip_load [kN/m], wound_on_tension [N/m]\n2, 520\n3, 620\n4, 705\n"
LOADS = {"nip_load": {"from": "1 kN/m", "to": "5 kN/m", "count": 5}}
TOML = 'schema = 1\nload = "89 kN/m"\nfriction = 0.5\n[upper]\nradius = "0.25 m"\n'

Number = float | str
Tables = Annotated[
    dict[str, Any], Field(description="the tables of a case file; /api/catalogue lists all names")
]
Case = Annotated[
    Tables,
    Body(
        openapi_examples={
            "nip": {"value": NIP},
            "without_wraps": {"value": NIP | {"wrap": {"roll_wrap": 0}}},
            "with_air": {"value": NIP | AIR},
            "rollers": {"value": ROLLERS},
        }
    ),
]


class _Request(BaseModel):
    model_config = ConfigDict(extra="forbid")


class SolverQuery(BaseModel):
    """A query whose other fields are options of the solver: ``?nodes=129``."""

    model_config = ConfigDict(extra="allow")

    @property
    def options(self) -> dict[str, Any]:
        """The options of the solver, as texts."""
        others = self.model_extra or {}  # the token gives access, and is no option
        return {name: text for name, text in others.items() if name != "token"}


class SolveQuery(SolverQuery):
    """Start from the session's last state; add the report; return panels in place of arrays."""

    warm: bool = False
    report: bool = False
    drawn: bool = False


class FileQuery(SolverQuery):
    """The format of a result file."""

    format: str = Field("csv", pattern="^(csv|json|nc)$")


class CurveQuery(SolverQuery):
    """The varied field of a curve, its ends and number of points, and outputs with commas."""

    field: str
    points: int = Field(11, ge=2, le=LIMITS["curve_points"])
    low: float | None = Field(None, allow_inf_nan=False)
    high: float | None = Field(None, allow_inf_nan=False)
    outputs: str = ""


class DesignRequest(_Request):
    """A wound roll and the pressure that it is to keep."""

    case: Tables = Field(examples=[ROLL])
    pressure: Number | dict[str, Any] = Field(
        description="a number in Pa, a text with its unit, or radius and value, core to surface",
        examples=[PRESSURE],
    )
    rtol: float = Field(1e-3, ge=1e-6, le=1e-2)


class GradeRequest(_Request):
    """A case and the grade whose values it is to have."""

    case: Tables = Field(examples=[NIP])
    grade: str = Field(description="name of a grade of the catalogue", examples=["lwc"])


class FindRequest(_Request):
    """A case, the field to find, and the target of an output."""

    case: Tables = Field(examples=[NIP])
    field: str = Field(examples=["nip_load"])
    output: str = Field(examples=["wound_on_tension"])
    target: Number = Field(
        description="a number in SI or a text with its unit", examples=["600 N/m"]
    )
    between: tuple[Number, Number] | None = None


class FitRequest(_Request):
    """A case, a table of measured values, and the fields to fit with their bounds."""

    case: Tables = Field(examples=[NIP])
    table: str = Field(
        description="text with commas, semicolons or tabs, units in the header; or a file",
        examples=[MEASURED],
    )
    file: str = Field(
        "table.csv",
        description="name of the file, whose ending is its format: .csv, .lvm; .xlsx and .tdms in "
        "base64; a sheet, segment or group may be named behind a #",
        max_length=300,
    )
    vary: dict[str, tuple[Number, Number] | None] = Field(
        description="null: a tenth to ten times the value",
        min_length=1,
        max_length=LIMITS["fit_unknowns"],
        examples=[{"roll_friction": [0.05, 0.6]}],
    )


class WindowRequest(_Request):
    """A winding and the ranges of two or three set points, of schedules at the core."""

    case: Tables
    web_tension: tuple[Number, Number] | None = Field(None, examples=[["200 N/m", "500 N/m"]])
    nip_load: tuple[Number, Number] | None = Field(None, examples=[["1 kN/m", "4 kN/m"]])
    rider_load: tuple[Number, Number] | None = Field(
        None, description="of a two-drum winder, in place of nip_load"
    )
    torque_split: tuple[Number, Number] | None = Field(None, examples=[[0.0, 0.5]])
    vary: dict[str, tuple[Number, Number]] = Field(
        default_factory=dict,
        description="range of any other field",
        examples=[{"oscillation": ["0 mm", "200 mm"]}],
    )
    uncertain: dict[str, Number] | str = Field(
        description="relative standard deviation by field, or the grade that has them",
        examples=["newsprint"],
    )


class Study(_Request):
    """The tables of a study file."""

    case: Tables = Field(examples=[NIP])
    over: dict[str, Any] = Field(examples=[LOADS])
    outputs: list[str] | None = Field(None, examples=[["nip_induced_tension", "nip_width"]])
    solver: dict[str, Any] | None = None
    tie: dict[str, str] | None = None
    design: dict[str, Any] | None = None


class LabelledCase(_Request):
    """A case with the name that a figure or a report gives it."""

    label: str | None = Field(None, max_length=80)
    case: Tables


class Cases(_Request):
    """Cases to compare, with the units to show."""

    cases: list[LabelledCase] = Field(
        min_length=1,
        max_length=LIMITS["compare"],
        examples=[
            [{"label": "A", "case": NIP}, {"label": "B", "case": NIP | {"nip_load": "5 kN/m"}}]
        ],
    )
    units: dict[str, str] | Literal["SI", "mill"] = Field(
        {}, examples=["mill", {"nip_load": "pli"}]
    )
    title: str = ""
    remarks: str = ""


class CaseText(_Request):
    """The text of a case file."""

    toml: str = Field(examples=[TOML])
