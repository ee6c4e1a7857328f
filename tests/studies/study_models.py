"""Models with known answers for the study engine; in a module, so that workers can import them."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Mapping
from contextlib import closing, suppress
from dataclasses import dataclass
from math import exp, pi, sin
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
from process_tasks import crash_at_three

import woundon as wo
from woundon.quantities import Quantity, pure
from woundon.studies.model import Answer
from woundon.studies.observations import Observations

# a roll of 60 layers with full slip in the nip, so that no nip is solved
BOARD = wo.WindingProblem.example().replace(
    stack=wo.Stack(radial=27e6, tangential=3.38e9, poissons_ratio=0.01, shear=10e6), radius=0.08,
    tension_law="friction", limits=wo.Limits(blocking_pressure="200 kPa"),
    **{"web.thickness": "500 um"},
)  # fmt: skip


@dataclass(frozen=True)
class LinearModel:
    """y = f(inputs), without gradients; ``state`` counts the cases solved in a row."""

    outputs: tuple[str, ...] = ("y",)
    names: tuple[str, ...] = ("a", "b", "x")

    def value(self, inputs: Mapping[str, Any]) -> float:
        """y = 2 a + b."""
        return 2 * inputs["a"] + inputs.get("b", 0.0)

    def run(self, inputs: Mapping[str, Any], start: Any | None) -> Answer:
        return Answer((self.value(inputs),), "", (start or 0) + 1)

    def quantity(self, name: str) -> Quantity | None:
        return pure(name, name)

    def record(self) -> dict[str, Any]:
        return {"model": type(self).__name__}


@dataclass(frozen=True)
class SlowModel(LinearModel):
    """Takes its time."""

    seconds: float = 0.02

    def run(self, inputs: Mapping[str, Any], start: Any | None) -> Answer:
        time.sleep(self.seconds)
        return super().run(inputs, start)


@dataclass(frozen=True)
class CrashingModel(LinearModel):
    """Kills its process at a = 3: the first time only if ``once`` names a file, else always."""

    once: str = ""

    def run(self, inputs: Mapping[str, Any], start: Any | None) -> Answer:
        crash_at_three(inputs["a"], self.once)
        return super().run(inputs, start)


@dataclass(frozen=True)
class FailingModel(LinearModel):
    """Fails at a = 3."""

    def run(self, inputs: Mapping[str, Any], start: Any | None) -> Answer:
        if inputs["a"] == 3:
            raise ZeroDivisionError("a is 3")
        return super().run(inputs, start)


@dataclass(frozen=True)
class IshigamiModel(LinearModel):
    """y = sin a + 7 sin^2 b + 0.1 x^4 sin a on [-pi, pi]^3, whose indices are known."""

    def value(self, inputs: Mapping[str, Any]) -> float:
        a, b, x = (inputs[name] for name in self.names)
        return sin(a) + 7 * sin(b) ** 2 + 0.1 * x**4 * sin(a)

    @staticmethod
    def indices() -> tuple[list[float], list[float]]:
        """Return first and total order in closed form (Ishigami and Homma 1990)."""
        first = [0.5 * (1 + 0.1 * pi**4 / 5) ** 2, 49 / 8, 0.0]
        mixed = 0.1**2 * pi**8 * (1 / 18 - 1 / 50)
        whole = sum(first) + mixed
        total = [first[0] + mixed, first[1], mixed]
        return [v / whole for v in first], [v / whole for v in total]


@dataclass(frozen=True)
class ClosedForm:
    """The value y of a curve model, with the exact derivatives of the model if it has any."""

    y: float
    model: CurveModel
    inputs: Mapping[str, float]

    def __getattr__(self, name: str) -> Any:
        if name != "sensitivity" or type(self.model).slopes is CurveModel.slopes:
            raise AttributeError(name)
        return self._sensitivity

    def _sensitivity(self, *names: str, outputs: tuple[str, ...]) -> Any:
        by_name = self.model.slopes(**self.inputs)
        slopes = np.array([[by_name[name] for name in names]])
        return SimpleNamespace(parameters=names, derivatives=slopes)


@dataclass(frozen=True)
class CurveModel:
    """y = f(a, b, x) for a fit of a and b; derivatives by differences."""

    def followers(self, name: str) -> list[str]:
        return []

    def variant(self, inputs: Mapping[str, float]) -> Mapping[str, float]:
        return inputs

    def solve(self, inputs: Mapping[str, float], start: Any) -> ClosedForm:
        return ClosedForm(self.y(**inputs), self, inputs)

    def y(self, x: float, a: float, b: float = 0.0) -> float:
        raise NotImplementedError

    def slopes(self, x: float, a: float, b: float) -> dict[str, float]:
        raise NotImplementedError


class LineModel(CurveModel):
    """y = a + b x with its exact derivatives."""

    def y(self, x: float, a: float, b: float = 0.0) -> float:
        return a + b * x

    def slopes(self, x: float, a: float, b: float) -> dict[str, float]:
        return {"a": 1.0, "b": x}


class ProductModel(CurveModel):
    """y = a b x: the data tell the product only."""

    def y(self, x: float, a: float, b: float = 0.0) -> float:
        return a * b * x

    def slopes(self, x: float, a: float, b: float) -> dict[str, float]:
        return {"a": b * x, "b": a * x}


class DampedSineModel(CurveModel):
    """y = exp(-a x) sin(b x): valleys next to valleys, bent ones."""

    def y(self, x: float, a: float, b: float = 0.0) -> float:
        return exp(-a * x) * sin(b * x)


class SaturationModel(CurveModel):
    """y = a (1 - exp(-b x)): a curved valley, exact derivatives."""

    def y(self, x: float, a: float, b: float = 0.0) -> float:
        return a * (1 - exp(-b * x))

    def slopes(self, x: float, a: float, b: float) -> dict[str, float]:
        return {"a": 1 - exp(-b * x), "b": a * x * exp(-b * x)}


class WaveModel(CurveModel):
    """y = x + sin(3 a) + a/4: least squares on it has several minima."""

    def y(self, x: float, a: float, b: float = 0.0) -> float:
        return x + sin(3 * a) + a / 4


def curve_data(x: np.ndarray, y: np.ndarray, deviation: float = np.nan) -> Observations:
    """Return measured values of a curve."""
    m = y.size
    return Observations(
        rows=np.arange(m), numbers=tuple(range(1, m + 1)), names=("y",) * m,
        position=np.full(m, np.nan), measured=y, deviation=np.full(m, deviation),
        common=np.zeros(m), inputs={"x": x[:m]}, quantities={}, where="measured",
    )  # fmt: skip


def stored(out: Path) -> dict[int, bytes]:
    """Return the outputs of the chunks that a study has written so far."""
    if not (out / "study.sqlite").exists():
        return {}
    with (
        suppress(sqlite3.OperationalError),  # no tables yet
        closing(sqlite3.connect(out / "study.sqlite")) as connection,
    ):
        return dict(connection.execute("SELECT number, outputs FROM chunk"))
    return {}


def table_of(problem: Any, over: Any, outputs: Any = None, **how: Any) -> Any:
    """Return the table of a sweep, solved here."""
    from woundon.studies.api import study_of
    from woundon.studies.run import Workers, run_study

    return run_study(*study_of(problem, over, outputs, **how), Workers(1))
