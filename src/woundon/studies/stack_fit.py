r"""Fit the laws of a stack to a compression test: ``wo.fit_stack``.

The strain of a law is measured from an unknown origin eps_0, at which the pressure of the law
vanishes (toe correction):

    eps_i = eps_0 + F(P_i; theta) + e_i,        F(P) = int_0^P dP'/E_r(P'; theta)

The parameters theta and eps_0 minimise sum e_i^2.  With J = d eps/d(theta, eps_0), the leverages
h_i of J (J^T J)^-1 J^T and e_i the residuals, the covariance

    (J^T J)^-1 J^T diag(e_i^2/(1 - h_i)^2) J (J^T J)^-1

is valid where the scatter differs along the test (MacKinnon and White 1985, estimator HC3): a
scatter of the load is one of the strain that falls with the modulus.

The misfit is the standard deviation of the residuals, (sum e_i^2/(n - p))^(1/2), p with eps_0.
"""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING, Any, NamedTuple

import numpy as np

from ..arguments import check_type, whole_number
from ..errors import InvalidProblem
from ..io.compression import CompressionTest, read_compression_test, rising_means
from ..io.sheets import TableSource
from ..problems.messages import not_one_of
from ..problems.radial_laws import (
    Constant,
    Pfeiffer,
    Polynomial,
    PowerLaw,
    SolidLaw,
    StackTest,
    pfeiffer_line,
)
from ..quantities import Quantity, in_chosen_units, quantity_of, stress
from .outcome import Outcome

if TYPE_CHECKING:
    import pandas as pd

__all__ = ["LawFit", "StackFit", "fit_stack"]

Array = np.ndarray

MOST_ROWS = 1000  # of a fit; successive rows of longer tests are averaged
WORST = 1e3  # residual of parameters that are no law
DIFFERENCE = 1e-5  # step of the derivatives by an unknown, whose scale is 1
LEAST = 1e-8  # distance from a limit, relative to the scale, at which a parameter is at the limit
INSIDE = 0.05  # distance from a limit at which derivatives are computed, relative to the scale
SINGULAR = 1e-12  # of a scaled column that the others determine
ROUNDING = 1e-8  # of a misfit, relative to the range of the strain
EQUAL = 0.05  # relative difference of misfits that does not distinguish two laws
EXPONENTS = (0.4, 0.7, 1.0, 1.4)  # starts of the power law


class LawFit(NamedTuple):
    """A law fitted to a compression test.

    Attributes
    ----------
    name : str
        "constant", "pfeiffer", "power_law" or "polynomial".
    law : Constant, Pfeiffer, PowerLaw or Polynomial
    values, errors : dict of str to float
        Parameters and their standard errors by name, SI: K1 and K2 of Pfeiffer's law; nan for an
        error if the test does not distinguish the parameters.
    origin, origin_error : float
        Strain at which the pressure of the law vanishes, eps_0.
    misfit : float
        Standard deviation of the measured strains about the law [1].

    Examples
    --------
    >>> import woundon as wo
    >>> test = wo.StackTest(pressure=[1e3, 1e4, 5e4, 2e5], strain=[0.001, 0.01, 0.05, 0.2])
    >>> fit = wo.fit_stack(test).law("constant")
    >>> round(fit.values["youngs_modulus"])
    1000000
    """

    name: str
    law: SolidLaw
    values: dict[str, float]
    errors: dict[str, float]
    origin: float
    origin_error: float
    misfit: float


def fit_stack(
    test: TableSource | StackTest,
    *,
    area: float | str | None = None,
    height: float | str | None = None,
    offset: float | str = 0.0,
    preload: float | str | None = None,
    branch: str | int = "loading",
    degree: int = 2,
    columns: Mapping[str, str | None] | None = None,
    sheet: str = "",
) -> StackFit:
    """Fit every law of a stack to a compression test, and rank the laws by their misfit.

    Parameters
    ----------
    test : path, mapping, pandas.DataFrame or StackTest
        CSV, Excel, ``.lvm`` or ``.tdms`` file, or columns by name, with their units: pressure (or
        stress) and strain, or load and deflection of the machine.  Other columns are ignored.
    area : float or str, optional
        Loaded area of the stack [m^2], 1e-6 to 10, for a load.
    height : float or str, optional
        Height of the stack without load [m], 1e-4 to 10, for a deflection.
    offset : float or str
        Load [N], or pressure [Pa], that the load cell shows without a stack.
    preload : float or str, optional
        Pressure [Pa] below which rows are left out; by default 1 % of the largest pressure, and 0
        of a table whose rows all rise.
    branch : "loading", "unloading" or int
        The rows between two reversals of the pressure that are used: the first that rises to the
        largest pressure, the first that falls from it, or the number of a branch, from 1.
    degree : int
        Of the polynomial, 2 to 5.
    columns : mapping
        Header -> pressure, strain, force or deflection, with or without a unit; None omits a
        column.
    sheet : str
        Sheet of an Excel file, segment or group of an instrument file.

    Returns
    -------
    StackFit

    Raises
    ------
    InvalidProblem
        For a table without the columns, area or height, a strain that is not < 1, or a branch that
        does not exist.

    Examples
    --------
    >>> import numpy as np
    >>> import woundon as wo
    >>> strain = np.linspace(0.0, 0.1, 40)
    >>> test = {"Load [N]": 100.0 * np.expm1(40 * strain), "Extension [mm]": 20 * strain}
    >>> found = wo.fit_stack(test, area="100 cm^2", height="20 mm")
    >>> {name: round(value, 3) for name, value in found.law("pfeiffer").values.items()}
    {'K1': 10000.0, 'K2': 40.0}
    """
    degree = whole_number("degree", degree, 2, 5)
    check_type("branch", branch, str, int)
    if isinstance(test, StackTest):
        test = {"pressure": test.pressure, "strain": test.strain}
    read = read_compression_test(
        test,
        area=area,
        height=height,
        offset=offset,
        preload=preload,
        branch=branch,
        columns=columns,
        sheet=sheet,
    )
    P, eps = _averaged(*read.used)
    K1, slope = pfeiffer_line(P, eps)
    if not slope > 0:
        raise InvalidProblem.at(read.where, "its strains do not rise with the pressure")
    fits = [_fitted(form, P, eps) for form in _forms(K1, 1 / slope, float(P.max()), degree)]
    # misfits of rounding errors are equal; then the law with fewer parameters comes first
    rounding = ROUNDING * float(np.ptp(eps))
    found = sorted(
        (each for each in fits if each is not None),
        key=lambda each: (max(each.misfit, rounding), len(each.values)),
    )
    return StackFit(test=read, laws=tuple(found))


def _averaged(P: Array, eps: Array) -> tuple[Array, Array]:
    """Return the rows P [Pa], eps of a test; of many the means of successive ones, at most 1000."""
    if P.size <= MOST_ROWS:
        return P, eps
    blocks = np.linspace(0, P.size, MOST_ROWS + 1).astype(int)[:-1]
    counts = np.diff(np.append(blocks, P.size))
    return np.add.reduceat(P, blocks) / counts, np.add.reduceat(eps, blocks) / counts


# ---- the laws as functions of their parameters --------------------------------------------------


class _Form(NamedTuple):
    """A law with p parameters and the search for them.

    Attributes
    ----------
    make : callable
        (p,) array of parameters -> law; raises InvalidProblem for parameters of no law.
    names : tuple of str
    scales : (p,) array
        Of the parameters in the search; 0 for one that is searched by its logarithm.
    starts : list of (p,) sequences
        Initial guesses.
    lowest : (p,) sequence
        Lower limits of the parameters.
    """

    make: Callable[[Array], SolidLaw]
    names: tuple[str, ...]
    scales: Array
    starts: list[Sequence[float]]
    lowest: Sequence[float]

    def unknowns(self, parameters: Sequence[float]) -> Array:
        """Return the unknowns of the search, (p,): logarithms, or parameters over their scales."""
        values, by_log = np.array(parameters, dtype=float), self.scales == 0
        with np.errstate(divide="ignore"):
            return np.where(
                by_log, np.log(np.maximum(values, 0)), values / np.where(by_log, 1, self.scales)
            )

    def parameters(self, x: Array) -> Array:
        """Return the parameters of the unknowns."""
        return np.where(self.scales == 0, np.exp(np.clip(x, -300, 300)), x * self.scales)

    def slopes(self, x: Array) -> Array:
        """Return the derivatives of the parameters by the unknowns, (p,)."""
        return np.where(self.scales == 0, self.parameters(x), self.scales)


def _forms(K1: float, K2: float, P_max: float, degree: int) -> list[_Form]:
    """Return the laws that are fitted, with guesses from Pfeiffer's law.

    Parameters
    ----------
    K1, K2 : float
        Of Pfeiffer's law.
    P_max : float
        Largest pressure [Pa].
    degree : int
        Of the polynomial.
    """
    E0 = K1 * K2  # the modulus at zero pressure
    mean = E0 * (P_max / K1) / np.log1p(P_max / K1)  # P_max over the strain of Pfeiffer's law
    # E_r = E0 + k (P/100 kPa)^m with the modulus of Pfeiffer's law at the largest pressure
    rise = K2 * P_max
    powers = [(E0, rise * (P_max / 1e5) ** -m, m) for m in EXPONENTS]
    scales = [0.0, *((E0 + rise) / P_max**j for j in range(1, degree + 1))]
    return [
        _Form(
            lambda x: Constant(youngs_modulus=x[0]),
            ("youngs_modulus",),
            np.zeros(1),
            [[mean]],
            [0.0],
        ),
        _Form(
            lambda x: Pfeiffer(K1=x[0], K2=x[1]), ("K1", "K2"), np.zeros(2), [[K1, K2]], [0.0, 0.0]
        ),
        _Form(
            lambda x: PowerLaw(E0=x[0], k=x[1], m=x[2]),
            ("E0", "k", "m"),
            np.array([E0, 0.0, 1.0]),
            list(powers),
            [0.0, 0.0, 0.1],
        ),
        _Form(
            lambda x: Polynomial(coefficients=x.tolist()),
            tuple(f"c{j}" for j in range(degree + 1)),
            np.array(scales),
            [[E0, K2, *np.zeros(degree - 1)]],
            [0.0, *(-np.inf for _ in range(degree))],
        ),
    ]


def _fitted(form: _Form, P: Array, eps: Array) -> LawFit | None:
    """Return the law with the smallest residuals; None if none was found or it is not identified.

    Parameters
    ----------
    form : _Form
    P, eps : (n,) arrays
    """
    from scipy.optimize import least_squares

    count = len(form.names) + 1  # with the origin
    if P.size <= count:
        return None

    def strain(x: Array) -> Array:
        """Return the strain F of the law at the measured pressures; nan for no law."""
        try:
            law = form.make(form.parameters(x))
        except InvalidProblem:
            return np.full(P.size, np.nan)
        if law.max_pressure < P.max():
            return np.full(P.size, np.nan)
        return np.asarray(law.strain_at(P))

    def residuals(x: Array) -> Array:
        """Return the residuals with the origin that minimises them."""
        difference = eps - strain(x)
        if not np.isfinite(difference).all():
            return np.full(P.size, WORST)
        return np.asarray(difference - difference.mean())

    lowest = form.unknowns(form.lowest)
    size = np.ptp(eps)

    def scaled(x: Array) -> Array:
        """Return the residuals relative to the range of the strain."""
        return residuals(x) / size

    searches = [
        least_squares(
            scaled,
            form.unknowns(start),
            bounds=(lowest, np.inf),
            xtol=1e-12,
            ftol=1e-12,
            gtol=1e-12,
        )
        for start in form.starts
    ]
    best = min(searches, key=lambda search: float(search.cost))
    x, residual = best.x, residuals(best.x)
    if not np.all(np.abs(residual) < WORST):
        return None
    # a parameter that the search has pressed against its lower limit has the value of the limit
    at_limit = (form.scales > 0) & (x - lowest < LEAST)
    x = np.where(at_limit, lowest, x)
    law = form.make(form.parameters(x))
    # the derivatives by a parameter at its limit are those a little above it
    inside = np.where(at_limit, lowest + INSIDE, x)
    errors = _standard_errors(strain, inside, residuals(x)) * np.append(form.slopes(x), 1.0)
    origin = float(np.mean(eps - law.strain_at(P)))
    misfit = float(np.sqrt(residual @ residual / (P.size - count)))
    values = dict(zip(form.names, form.parameters(x).tolist(), strict=True))
    named = dict(zip(form.names, errors[:-1].tolist(), strict=True))
    return LawFit(law.member_name(), law, values, named, origin, float(errors[-1]), misfit)


def _standard_errors(strain: Callable[[Array], Array], x: Array, residual: Array) -> Array:
    """Return the standard errors of p unknowns and of the origin, (p + 1,), by the estimator HC3.

    They are nan if the test does not distinguish the unknowns, or a law next to ``x`` is none.

    Parameters
    ----------
    strain : callable
        F, (p,) -> (n,), without the origin; nan for no law.
    x : (p,) array
        The point of the derivatives.
    residual : (n,) array
        Of the estimates.
    """
    steps = DIFFERENCE * np.eye(x.size)
    columns = [(strain(x + step) - strain(x - step)) / (2 * DIFFERENCE) for step in steps]
    J = np.column_stack([*columns, np.ones(residual.size)])  # of eps_0 + F
    if not np.isfinite(J).all():
        return np.full(x.size + 1, np.nan)
    scales = np.linalg.norm(J, axis=0)
    Q, R = np.linalg.qr(J / np.where(scales > 0, scales, 1.0))
    if np.abs(np.diag(R)).min() < SINGULAR:
        return np.full(x.size + 1, np.nan)
    leverage = np.clip(np.sum(Q * Q, axis=1), 0.0, 1 - 1e-9)
    weighted = np.linalg.solve(R, Q.T) * (residual / (1 - leverage))
    return np.asarray(np.sqrt(np.sum(weighted**2, axis=1)) / scales)


# ---- the result ---------------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, repr=False)
class StackFit(Outcome):
    """Laws fitted to a compression test, the one with the smallest misfit first.

    Attributes
    ----------
    test : CompressionTest
        Pressures and strains of all rows, those that are used, and an account of the others.
    laws : tuple of LawFit

    Examples
    --------
    >>> import woundon as wo
    >>> test = wo.StackTest(pressure=[1e3, 1e4, 5e4, 2e5, 5e5],
    ...                     strain=[0.0024, 0.0173, 0.0448, 0.0761, 0.0983])
    >>> wo.fit_stack(test).best.name
    'pfeiffer'
    """

    test: CompressionTest
    laws: tuple[LawFit, ...]

    @property
    def best(self) -> LawFit:
        """The law with the smallest misfit."""
        return self.laws[0]

    def law(self, name: str) -> LawFit:
        """Return the fit of a law by its name.

        Raises
        ------
        InvalidProblem
            If no such law was fitted.
        """
        for each in self.laws:
            if each.name == name:
                return each
        raise InvalidProblem.at("name", not_one_of(name, [each.name for each in self.laws]))

    @property
    def stack_test(self) -> StackTest:
        """The rows that are used as a law, interpolated; noisy rows are averaged."""
        P, eps = rising_means(*self.test.used)
        return StackTest(pressure=P, strain=eps)

    def answer(self) -> list[str]:
        """Return the ranking of the laws, with parameters and standard errors."""
        P, eps = self.test.used
        unit, size = _PRESSURE.display, float(_PRESSURE.shown(1.0))
        low, high = f"{P.min() * size:.4g}", f"{P.max() * size:.4g}"
        lines = [f"{P.size} rows from {low} to {high} {unit}; laws by misfit:"]
        for each in self.laws:
            parameters = [
                f"{name} = {_quantity(each.law, name).text(value, '.5g', error=each.errors[name])}"
                for name, value in each.values.items()
            ]
            share = f"{each.misfit / np.ptp(eps):.2%}"
            lines.append(
                f"{each.name}: {', '.join(parameters)}; misfit {each.misfit:.2e} ({share} of the "
                "strain)"
            )
        return lines

    def remarks(self) -> list[str]:
        """Return which rows are used, and laws that follow the test as well as the best one."""
        texts = [in_chosen_units(text) for text in self.test.account]
        limit = (1 + EQUAL) * self.best.misfit
        equal = [each.name for each in self.laws[1:] if each.misfit <= limit]
        if equal:
            text = (
                f"{', '.join(equal)} follows" if len(equal) == 1 else f"{', '.join(equal)} follow"
            )
            texts.append(f"{text} the test as well as {self.best.name}")
        return texts

    def toml(self) -> str:
        """Return the best law as the table of a case file.

        >>> import woundon as wo
        >>> test = wo.StackTest(pressure=[1e3, 1e4, 5e4, 2e5], strain=[0.01, 0.02, 0.06, 0.21])
        >>> print(wo.fit_stack(test).toml().splitlines()[0])
        [stack.radial]
        """
        fields = self.best.law.model_dump(mode="json")
        return "\n".join(["[stack.radial]", *(f"{k} = {json.dumps(v)}" for k, v in fields.items())])

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each parameter of each law: value, standard error, misfit; SI units."""
        import pandas as pd

        rows = [
            (each.name, name, each.values[name], each.errors[name], each.misfit)
            for each in self.laws
            for name in each.values
        ]
        names = ["law", "parameter", "value", "standard_error", "misfit"]
        return pd.DataFrame(rows, columns=names)

    def _record(self) -> Mapping[str, Any]:
        """Return the laws, the account of the rows, and the rows that are used."""
        P, eps = self.test.used
        laws = [each._asdict() | {"law": each.law.model_dump(mode="json")} for each in self.laws]
        return {"laws": laws, "account": self.test.account, "pressure": P, "strain": eps}


_PRESSURE = stress("P", "pressure on the stack")


def _quantity(law: SolidLaw, name: str) -> Quantity:
    """Return the quantity of a parameter; of a coefficient one with the unit of its power."""
    if name in type(law).model_fields:
        quantity = quantity_of(type(law).model_fields[name])
        assert quantity is not None
        return quantity
    unit = {"c0": "Pa", "c1": "1"}.get(name, f"1/Pa^{int(name[1:]) - 1}".removesuffix("^1"))
    return Quantity(name, unit, "coefficient of the modulus")
