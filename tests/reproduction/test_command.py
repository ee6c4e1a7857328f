"""``woundon thesis``: what is written, what is said; and some figures with their verdicts."""

from __future__ import annotations

import pytest
from jorkama2001.frame import Figure, Outcome, Scheme

from jorkama2001 import registry
from jorkama2001.publication import publish
from woundon import cli

Capture = pytest.CaptureFixture[str]


def test_a_figure_is_drawn_and_judged(tmp_path, capsys: Capture):
    out = tmp_path / "made" / "here"
    assert cli.main(["thesis", "fig15", "--out", str(out)]) == 0
    said = capsys.readouterr().out
    assert "Fig. 15: " in said
    assert said.count("- holds: ") == said.count("\n- ")  # every statement of sec. 4.2
    assert sorted(path.name for path in out.iterdir()) == [
        "fig15.csv", "fig15.md", "fig15.png", "fig15.svg"
    ]  # fmt: skip
    assert (out / "fig15.png").read_bytes().startswith(b"\x89PNG")
    header, *rows = (out / "fig15.csv").read_text().splitlines()
    assert header.startswith("x [m],pressure [Pa],roll_traction [Pa]")
    assert len(rows) == 257
    assert (
        "- **holds**: before C it falls a little: **-4.77 N/m**" in (out / "fig15.md").read_text()
    )


def test_the_scheme_of_the_thesis_on_request(tmp_path, capsys: Capture):
    assert cli.main(["thesis", "fig15", "--scheme", "thesis", "--out", str(tmp_path)]) == 0
    assert "The thesis's scheme." in capsys.readouterr().out
    assert len((tmp_path / "fig15.csv").read_text().splitlines()) == 201  # M = 200 and the header


def test_two_processes_do_the_same(tmp_path, capsys: Capture):
    names = ["table4", "fig15"]
    for jobs in ("1", "2"):
        out = str(tmp_path / jobs)
        assert cli.main(["thesis", *names, "--jobs", jobs, "--out", out]) == 0
    first, second = (sorted((tmp_path / jobs).iterdir()) for jobs in ("1", "2"))
    assert [path.name for path in first] == [path.name for path in second]
    for one, other in zip(first, second, strict=True):
        assert one.read_bytes() == other.read_bytes()


def test_all_are_summed_up(tmp_path, capsys: Capture, monkeypatch):
    monkeypatch.setattr(registry, "NAMES", ("fig15", "table4"))
    assert cli.main(["thesis", "--all", "--jobs", "1", "--out", str(tmp_path)]) == 0
    said = capsys.readouterr().out
    assert "Table 4  5 statements: 5 hold" in said
    assert "2 figures and tables, 14 statements: 14 hold, 0 do not hold" in said
    assert "| [Table 4](table4.md) |" in (tmp_path / "index.md").read_text()


@pytest.mark.parametrize(
    ("args", "said"),
    [
        (["fgi15"], "error: fgi15: unknown; did you mean 'fig15'?"),
        ([], "error: name figures or tables, or ask for --all; there are fig"),
        (["fig15", "--all"], "error: name figures or tables, or ask for --all; there are fig"),
        (["fig15", "--scheme", "exact"], "error: Invalid value for '--scheme'"),
        (["fig15", "--jobs", "0"], "error: Invalid value for '--jobs'"),
    ],
)
def test_faults(args, said, tmp_path, monkeypatch, capsys: Capture):
    monkeypatch.chdir(tmp_path)
    assert cli.main(["thesis", *args]) == 2
    output = capsys.readouterr()
    assert output.err.startswith(said)
    assert list(tmp_path.iterdir()) == []


# statements that do not hold and that cannot be tested, of figures that take a second or two each;
# the documentation's build makes all of them
QUICK = {"table4": (0, 0), "fig5": (1, 0), "fig20": (0, 1), "fig30": (0, 0)}


@pytest.mark.parametrize("name", QUICK)
def test_as_many_statements_fail_as_are_known_to(name, tmp_path):
    (made,) = publish((name,), tmp_path, jobs=1)
    assert made.counts[1:] == QUICK[name], made.report


def test_a_false_statement_is_found_out(monkeypatch):
    """Fig. 15 with the wrong friction: the pattern that the text tells is not there."""
    from jorkama2001 import fig15

    base = fig15.paper_nip
    monkeypatch.setattr(fig15, "paper_nip", lambda **c: base(roll_friction=0.5, **c))

    def made(scheme: Scheme) -> Figure:
        return fig15.figures(scheme)[0]

    for scheme in ("graded", "thesis"):
        assert made(scheme).count(Outcome.FAILS) >= 2
