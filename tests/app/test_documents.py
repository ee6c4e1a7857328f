"""Case files, scripts, result files, pictures and reports over HTTP."""

import subprocess
import sys

import pytest
from slow_cases import slow_case

import woundon as wo
from woundon import kinds, plugins
from woundon.cli import commands as cli
from woundon.io.case_files import load_case
from woundon.io.case_texts import template

KINDS = [kind.name for kind in kinds.every()]


@pytest.mark.parametrize("name", KINDS)
def test_a_case_goes_out_as_a_file_of_the_command_line_and_comes_back(
    client, cases, name, tmp_path
):
    text = client.post("/api/case/write", json=cases[name]).text
    path = tmp_path / "case.toml"
    path.write_text(text)
    assert load_case(path) == kinds.named(name).example()
    back = client.post("/api/case/read", json={"toml": text}).json()
    assert back == {"kind": name, "problem": cases[name]}


@pytest.mark.parametrize("name", KINDS)
def test_the_script_computes_the_very_same_problem(client, cases, name):
    text = client.post("/api/python", json=cases[name]).text
    head, _, tail = text.partition("result = ")
    assert tail == "wo.solve(problem)\nprint(result)\n"
    names = {}
    exec(head, names)
    assert names["problem"] == kinds.named(name).example()


@pytest.mark.parametrize(
    "text",
    ["", "schema = 1", "nip_load = 3 kN/m", "a = " + "[" * 3000, "\0", "schema = 1\nnip_load = -1",
     "a." * 5000 + "a = 1", "schema = 1\nload = 1" + "0" * 6000],
)  # fmt: skip
def test_a_file_that_is_no_case_is_rejected(client, text):
    answer = client.post("/api/case/read", json={"toml": text})
    assert answer.status_code == 422
    assert answer.json()["detail"]


def test_a_file_that_names_another_is_rejected_and_that_is_not_opened(client, cases, tmp_path):
    rows = "10,0.9\n25,1.6\n50,2.2\n100,2.8\n"
    (tmp_path / "test.csv").write_text(f"pressure [kPa], strain [%]\n{rows}")
    text = client.post("/api/case/write", json=cases["roll"]).text
    first, _, rest = text.partition("[stack.radial]")
    assert "\n[" not in rest  # or what follows would have to stay
    text = f'{first}[stack.radial]\ncsv = "{tmp_path}/test.csv"\n'
    (tmp_path / "case.toml").write_text(text)
    load_case(tmp_path / "case.toml")  # the command line reads it
    answer = client.post("/api/case/read", json={"toml": text})
    assert answer.json()["errors"][0]["field"].endswith("csv")


SAVES = """
import woundon as wo
result = wo.solve(wo.NipProblem.example())
for ending in {endings}:
    result.save(f"result.{{ending}}")
"""


def test_a_result_file_is_the_one_that_save_writes(client, cases, tmp_path):
    endings = ["csv", "json", "nc"]
    # in a process of its own: tests give results outputs that no worker knows of
    command = [sys.executable, "-c", SAVES.format(endings=endings)]
    subprocess.run(command, check=True, cwd=tmp_path)
    for ending in endings:
        answer = client.post("/api/file", params={"format": ending}, json=cases["nip"])
        assert answer.content == (tmp_path / f"result.{ending}").read_bytes(), ending
        assert f"result.{ending}" in answer.headers["content-disposition"]


@pytest.mark.parametrize(
    ("ending", "head", "panels"),
    [
        ("svg", b"<?xml", ""),
        slow_case("png", b"\x89PNG", "tractions"),
        slow_case("pdf", b"%PDF", "tractions"),
    ],
)
def test_a_picture_of_two_cases(client, cases, ending, head, panels):
    other = cases["nip"] | {"nip_load": 5e3}
    body = {"cases": [{"case": cases["nip"]}, {"label": "more load", "case": other}]}
    asked = {"format": ending, "panels": panels}
    answer = client.post("/api/figure", params=asked, json=body)
    assert answer.status_code == 200
    assert answer.content.startswith(head)


# ---- reports ----------------------------------------------------------------------------------


def test_a_report_tells_inputs_results_and_comparison_and_stands_alone(client, cases):
    """In the units chosen; markup in names is text."""
    evil = '<script>alert(1)</script><img src="http://evil.example/x">'
    other = cases["nip"] | {"nip_load": "40 pli"}
    body = {
        "cases": [{"label": f"before{evil}", "case": cases["nip"]}, {"label": "b", "case": other}],
        "units": {"nip_load": "pli"}, "title": f"Winder 7{evil}", "remarks": f"Seen.{evil}",
    }  # fmt: skip
    answer = client.post("/api/report", json=body)
    assert answer.headers["content-type"].startswith("text/html")
    page, result = answer.text, wo.solve(wo.NipProblem.example())
    for text in ("<h1>Winder 7&lt;script&gt;", "Seen.&lt;script&gt;", "40 pli", "before",
                 "Jorkama 2001, Table 2", "Certificate: all", wo.__version__, "<svg",
                 f"{result.nip_induced_tension:.5g}"):  # fmt: skip
        assert text in page, text
    for marker in ("<script", "<img", 'href="http', "@import", "url(http"):
        assert marker not in page, marker
    assert "src=" not in page.replace("src=&quot;", "")


# ---- woundon report ---------------------------------------------------------------------------


@pytest.mark.slow
def test_the_command_writes_a_report_of_cases(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "base.toml").write_text(template("nip"))
    (tmp_path / "more.toml").write_text(template("nip").replace("3502 N/m", "5 kN/m"))
    assert cli.main(["report", "base.toml", "more.toml", "--out", "both.html"]) == 0
    assert capsys.readouterr() == ("written: both.html\n", "")
    page = (tmp_path / "both.html").read_text()
    assert "from base.toml, more.toml" in page
    assert "Comparison" in page


@pytest.mark.parametrize(
    ("args", "message"),
    [(["no.toml"], "no.toml"), (["case.toml", "--out", "a.pdf"], "a.pdf: the ending '.pdf'"),
     (["case.toml", "--set", "nip_load=-1"], "nip_load: -1 is out of range")],
)  # fmt: skip
def test_the_command_rejects_in_one_line(tmp_path, monkeypatch, capsys, args, message):
    monkeypatch.chdir(tmp_path)
    (tmp_path / "case.toml").write_text(template("nip"))
    assert cli.main(["report", *args]) == 2
    said = capsys.readouterr().err
    assert message in said
    assert len(said.splitlines()) == 1


# ---- figures of plug-ins ----------------------------------------------------------------------


@pytest.mark.slow
def test_a_figure_of_the_thesis_is_drawn():
    from woundon.app import documents
    from woundon.jorkama2001 import catalogue, plugin  # noqa: F401  registers the figures

    computed = {figure["name"]: figure for group in plugins.figures() for figure in group.list()}
    assert set(computed) == {name for name in catalogue.NAMES if name.startswith("fig")}
    assert computed["fig15"]["label"] == "Fig. 15"
    assert computed["fig15"]["title"].startswith("Tractions, slips and web tension in the nip")
    assert b"<svg" in documents.exhibit("fig5")
    with pytest.raises(wo.InvalidProblem, match="did you mean 'fig15'"):
        documents.exhibit("fig151")


# ---- the catalogue ----------------------------------------------------------------------------


def test_the_catalogue_has_every_field_and_output():
    from woundon.app.input_forms import catalogue as made
    from woundon.quantities import outputs, walk

    catalogue = made.__wrapped__()  # other tests may have given results more outputs
    for kind in catalogue["kinds"]:
        own = kinds.named(kind["name"])
        paths = set(_paths(catalogue, kind["form"]))
        assert {place.path for place in walk(own.problem)} <= paths
        assert {o["name"] for o in kind["outputs"]} == {p.path for p in outputs(own.result)}


def test_a_list_of_numbers_that_may_be_left_out_is_no_list_of_pairs(catalogue):
    fields = {field["name"]: field for field in catalogue["forms"]["DynamicTest"]["fields"]}
    for name in ("frequency", "loss_modulus", "tan_delta", "frequency_range"):
        assert fields[name]["type"] == "numbers", name


def _paths(catalogue, form, prefix=""):
    for field in catalogue["forms"][form]["fields"]:
        path = prefix + field["name"]
        yield path
        for member in field.get("members", ()):
            below = f"{path}.*." if field["type"] == "members" else f"{path}."
            yield from _paths(catalogue, member["form"], below)


def test_every_shown_unit_is_among_those_that_a_field_may_be_reported_in(catalogue):
    from woundon.problems.units import parse

    fields = [f for form in catalogue["forms"].values() for f in form["fields"]]
    outputs = [o for kind in catalogue["kinds"] for o in kind["outputs"]]
    for field in fields + outputs:
        if field["unit"] in ("", "holder"):
            continue
        units = {u["name"]: u["factor"] for u in catalogue["units"][field["unit"]]}
        assert field["shown_unit"] in units
        for name, factor in units.items() if field in fields else ():
            text = f"2 {name}" if name else "2"
            assert parse(text, field["unit"]) == pytest.approx(2 * factor, rel=1e-14)


EXAMPLES = ("Cases", "DesignRequest", "FindRequest", "Study")


@pytest.mark.slow
def test_the_interface_is_described_with_examples_that_work(client):
    document = client.get("/openapi.json").json()
    page = client.get("/api").text
    schemas = document["components"]["schemas"]
    tried = set()
    for path, routes in document["paths"].items():
        assert path in page
        for route in routes.values():
            assert {"422", "503"} <= set(route["responses"])
            content = route.get("requestBody", {}).get("content", {}).get("application/json", {})
            name = content.get("schema", {}).get("$ref", "").rpartition("/")[2]
            examples = [one["value"] for one in content.get("examples", {}).values()]
            if name in EXAMPLES:  # whose fields have examples
                fields = schemas[name]["properties"].items()
                examples = [
                    {field: one["examples"][0] for field, one in fields if "examples" in one}
                ]
            for example in examples:
                field = "load" if "load" in example else "nip_load"
                params = {"field": field} if path == "/api/curve" else {}
                answer = client.post(path, json=example, params=params)
                assert answer.status_code == 200, (path, answer.text[:300])
                tried.add(path)
    assert {"/api/solve", "/api/design", "/api/find", "/api/sweep", "/api/report"} <= tried
