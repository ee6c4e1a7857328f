"""Random problems up to the limits of all fields end in a certificate, or in what to change."""

from __future__ import annotations

import re
import warnings

import pytest
from random_problems import RANDOM, ending, estimate_ratio, random_roll

import woundon as wo

ENDINGS = (
    "solved",
    # a load that no contact carries
    r"InvalidProblem: (nip_)?load: .* is out of range; must be <= .* \[N/m\], about: ",
    # a layer whose response is not resolved
    "InvalidProblem: (roll|drum|upper|lower): .* the layer must be thicker, or the stiffnesses",
    # webs
    "NoSteadyState: web_tension: .* more is needed, about ",
    "InvalidProblem: roll_wrap: .* must be 0 or >= ",
    # solvers that do not converge name the reason
    "NotConverged: .*this is far outside the model: .*; take ",
    r"NotConverged: contact conditions are not satisfied to 1e-8: .*\(limit .*%\)",
    "NotConverged: stick and slip not found .*; another number of nodes may do$",
)


def assert_expected_ending(kind: str, seed: int) -> str:
    text = ending(lambda: RANDOM[kind](seed))
    assert any(re.match(pattern, text) for pattern in ENDINGS), (seed, text)
    return text


@pytest.mark.parametrize(
    ("kind", "seed"),
    # seeds above 5 once ended in another way
    [*(("nip", seed) for seed in (0, 1, 191, 194, 199)),
     *(("wrapped-nip", seed) for seed in (0, 22, 128)),
     *(("rollers", seed) for seed in range(4)),
     *(pytest.param(*case, marks=pytest.mark.slow)
       for case in (("nip", 41), ("nip", 250), ("wrapped-nip", 184)))],
)  # fmt: skip
def test_every_ending_is_a_certificate_or_states_what_to_change(kind: str, seed: int) -> None:
    text = assert_expected_ending(kind, seed)
    if (kind, seed) in (("nip", 250), ("wrapped-nip", 184), ("nip", 41), ("nip", 199)):
        assert text == "solved"


@pytest.mark.campaign
@pytest.mark.parametrize("kind", ["nip", "wrapped-nip", "rollers"])
def test_a_thousand_random_problems(kind: str) -> None:
    for seed in range(1000):
        assert_expected_ending(kind, seed)


# of the first ten, all laws; the seventh, a kinked power law, takes 1258 stages and 20 s
ROLLS = (0, 1, 3, 4, 5, 8, 9)


def test_random_rolls_are_certified_or_rejected() -> None:
    endings = [ending(lambda k=k: random_roll(1, k)) for k in ROLLS]
    assert endings.count("solved") == 5
    assert sum(text.startswith("NotConverged: the layers separate") for text in endings) == 1
    assert sum("beyond the range of the stack law" in text for text in endings) == 1


@pytest.mark.slow
def test_error_estimates_of_random_rolls() -> None:
    """The estimate is on the safe side: errors are half of it in the median, at most 0.97."""
    assert max(estimate_ratio(random_roll(1, k)) for k in (0, 9)) < 1.2


@pytest.mark.campaign
@pytest.mark.filterwarnings("ignore")
def test_two_hundred_random_rolls() -> None:
    for k in range(200):
        text = ending(lambda k=k: random_roll(0, k))
        assert text.startswith(("solved", "InvalidProblem: ", "NotConverged: ")), (k, text)


def random_winding_ending(seed: int) -> str:
    with warnings.catch_warnings():
        warnings.simplefilter("ignore")
        return ending(lambda: RANDOM["winding"](seed), nodes=33, rtol=1e-2)


@pytest.mark.parametrize(
    "seeds",
    [range(1, 2), pytest.param(range(2, 3), marks=pytest.mark.slow),
     pytest.param(range(1000, 1050), marks=pytest.mark.campaign)],
)  # fmt: skip
def test_random_windings_are_certified_or_rejected(seeds: range) -> None:
    for seed in seeds:
        text = random_winding_ending(seed)
        expected = ("solved", "InvalidProblem: ", "NoSteadyState: ", "NotConverged: ")
        assert text.startswith(expected), (seed, text)


def test_an_unexpected_ending_is_recognised(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(wo, "solve", lambda problem: 1 / 0)
    assert ending(lambda: random_roll(1, 0)).startswith("ZeroDivisionError")
