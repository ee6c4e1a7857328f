"""Models with known answers for the study engine; in a module, so that workers can import them."""

from __future__ import annotations

import sqlite3
import time
from collections.abc import Mapping
from contextlib import closing, suppress
from dataclasses import dataclass
from math import exp, pi, sin
from pathlib import Path
from typing import Any

import numpy as np
from process_tasks import crash_at_three

from woundon.quantities import Quantity, pure
from woundon.studies.model import Answer


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

    def gradient(self, state: Any, names: tuple[str, ...]) -> np.ndarray | None:
        return None

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
class LineModel(LinearModel):
    """y = a + b x with its exact gradient."""

    def value(self, inputs: Mapping[str, Any]) -> float:
        return inputs["a"] + inputs["b"] * inputs["x"]

    def run(self, inputs: Mapping[str, Any], start: Any | None) -> Answer:
        return Answer((self.value(inputs),), "", dict(inputs))

    def gradient(self, state: Any, names: tuple[str, ...]) -> np.ndarray | None:
        by = {"a": 1.0, "b": state["x"]}
        return np.array([[by[name] for name in names]])


@dataclass(frozen=True)
class ProductModel(LineModel):
    """y = a b x: the data tell the product only."""

    def value(self, inputs: Mapping[str, Any]) -> float:
        return inputs["a"] * inputs["b"] * inputs["x"]

    def gradient(self, state: Any, names: tuple[str, ...]) -> np.ndarray | None:
        a, b, x = (state[name] for name in self.names)
        by = {"a": b * x, "b": a * x}
        return np.array([[by[name] for name in names]])


@dataclass(frozen=True)
class DampedSineModel(LinearModel):
    """y = exp(-a x) sin(b x): valleys next to valleys, bent ones; derivatives by differences."""

    def value(self, inputs: Mapping[str, Any]) -> float:
        return exp(-inputs["a"] * inputs["x"]) * sin(inputs["b"] * inputs["x"])


@dataclass(frozen=True)
class SaturationModel(LineModel):
    """y = a (1 - exp(-b x)): a curved valley, exact derivatives."""

    def value(self, inputs: Mapping[str, Any]) -> float:
        return float(inputs["a"] * (1 - np.exp(-inputs["b"] * inputs["x"])))

    def gradient(self, state: Any, names: tuple[str, ...]) -> np.ndarray | None:
        a, b, x = (state[name] for name in ("a", "b", "x"))
        by = {"a": 1 - np.exp(-b * x), "b": a * x * np.exp(-b * x)}
        return np.array([[by[name] for name in names]])


@dataclass(frozen=True)
class WaveModel(LinearModel):
    """y = x + sin(3 a) + a/4: least squares on it has several minima."""

    def value(self, inputs: Mapping[str, Any]) -> float:
        return inputs["x"] + sin(3 * inputs["a"]) + inputs["a"] / 4


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
