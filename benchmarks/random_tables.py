"""Random table files: each is read rightly, or rejected in a few lines with the row and a remedy.

    python benchmarks/random_tables.py --files 300

A seed determines a file: its contents (measured values of a nip, a compression test, the log of a
winder), format (.csv, .xlsx, .lvm, .tdms), language, decimal sign, place of the units, blocks above
the table, further columns, missing cells, and one of the faults of :data:`FAULTS`, or none.  The
outcome of a file is

read         the values are those that were written, in SI
rejected     InvalidProblem in at most ten lines, which name the place and a remedy
unclear      InvalidProblem otherwise
wrong        other values, or a faulty file that is read
error        any other exception
"""

from __future__ import annotations

import argparse
import io
import re
import sys
import tempfile
import traceback
import warnings
from collections import Counter
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np

import woundon as wo
from woundon.io.compression import read_compression_test
from woundon.studies.column_names import columns_of, conversion_of, measurable_outputs
from woundon.studies.measured_tables import read_measured

__all__ = ["TableFile", "outcome", "random_file"]

NIP = wo.NipProblem.example().replace(width=2.5)
WINDING = wo.WindingProblem.example().replace(width=2.5)
CONTENTS = ("measured", "stack", "log")
FORMATS = ("csv ;", "csv tab", "csv ,", "xlsx", "lvm", "tdms")
LANGUAGES = ("English", "German", "Finnish", "French")
# what is wrong with a file; "" for none
FAULTS = (
    "", "", "", "", "", "wrong dimension", "no unit", "unknown header", "word in a cell",
    "short row", "thousands", "two tables", "no header",
)  # fmt: skip
HEADERS = {
    "nip_load": ("Nip load", "Linienlast", "Viivakuorma", "Charge linéique"),
    "web_tension": ("Web tension", "Bahnzug", "Rataveto", "Tension de la bande"),
    "wound_on_tension": ("WOT",) * 4,
    "force": ("Load", "Kraft", "Voima", "Charge"),
    "deflection": ("Extension", "Weg", "Siirtymä", "Déplacement"),
    "diameter": ("Roll diameter", "Durchmesser", "Halkaisija", "Diamètre"),
}
# name -> units with their size in SI, and the range of the values in SI
UNITS: dict[str, tuple[dict[str, float], tuple[float, float]]] = {
    "nip_load": ({"kN/m": 1e3, "N/m": 1.0, "N": 0.4}, (1e3, 5e3)),
    "web_tension": ({"N/m": 1.0, "N": 0.4, "kN/m": 1e3}, (200.0, 500.0)),
    "wound_on_tension": ({"N/m": 1.0, "kN/m": 1e3}, (300.0, 900.0)),
    "force": ({"N": 1.0, "kN": 1e3}, (10.0, 6000.0)),
    "deflection": ({"mm": 1e-3, "um": 1e-6}, (1e-4, 2e-3)),
    "diameter": ({"mm": 1e-3, "m": 1.0, "cm": 1e-2}, (0.1, 1.2)),
}
WRONG_UNITS = {"deflection": "kN", "diameter": "kPa", "force": "mm"}
REMEDY = re.compile(
    r"write|delete|assign|--column|must|name one|save|needs|give|did you mean|expected|export|copy"
)
PLACE = re.compile(r"rows? \d+|column|segment|group|sheet|--column")


@dataclass
class TableFile:
    """A file and what it contains.

    Attributes
    ----------
    path : Path
    contents : str
    fault : str
        What is wrong with it; empty if nothing is.
    expected : dict of str to list of float
        Values in SI by name.
    story : list of str
        How it was made.
    """

    path: Path
    contents: str
    fault: str
    expected: dict[str, list[float]]
    story: list[str] = field(default_factory=list)


def random_file(seed: int, folder: Path) -> TableFile:
    """Write the file of a seed to a folder."""
    rng = np.random.default_rng(seed)
    contents, kind = (str(rng.choice(choices)) for choices in (CONTENTS, FORMATS))
    fault, language = str(rng.choice(FAULTS)), int(rng.integers(4))
    names = {
        "measured": ["nip_load", "web_tension", "wound_on_tension"],
        "stack": ["force", "deflection"],
        "log": ["diameter", "web_tension", "nip_load"],
    }[contents]
    is_channels = kind in ("lvm", "tdms")
    if is_channels and fault not in ("", "wrong dimension", "unknown header"):
        fault = ""
    # in an Excel file a short row has empty cells, and numbers have no thousands
    if (kind, fault) in (("xlsx", "short row"), ("xlsx", "thousands"), ("csv ,", "thousands")):
        fault = "word in a cell"
    count = int(rng.integers(6, 40)) if contents != "log" else int(rng.integers(40, 400))
    chosen = {name: str(rng.choice(list(UNITS[name][0]))) for name in names}
    columns: dict[str, np.ndarray] = {}
    for name in names:
        low, high = UNITS[name][1]
        values = rng.uniform(low, high, count)
        if name in ("diameter", "force", "deflection"):
            values = np.sort(values)
        columns[name] = np.round(values / UNITS[name][0][chosen[name]], 6)
    expected = {name: (columns[name] * UNITS[name][0][chosen[name]]).tolist() for name in names}
    headers = {name: HEADERS[name][language] for name in names}
    victim = str(rng.choice(names))
    if fault == "wrong dimension":
        chosen[victim] = WRONG_UNITS.get(victim, "kPa" if victim == "nip_load" else "mm")
    if fault == "no unit":
        chosen[victim] = ""
    if fault == "unknown header":
        victim = names[0] if contents == "log" else victim
        headers[victim] = "Signal 7"
    story = [contents, kind, LANGUAGES[language], fault or "no fault"]
    made = TableFile(folder / f"file_{seed}", contents, fault, expected, story)
    if is_channels:
        if kind == "lvm":
            made.path = _write_lvm(made.path, columns, headers, chosen, rng)
        else:
            made.path = _write_tdms(made.path, columns, headers, chosen)
        return made
    sign = "," if kind in ("csv ;", "csv tab") and rng.random() < 0.6 else "."
    rows = _rows(columns, headers, chosen, sign, rng, made, victim)
    made.path = _write_rows(made.path, rows, kind)
    return made


def _rows(
    columns: dict[str, np.ndarray],
    headers: dict[str, str],
    units: dict[str, str],
    sign: str,
    rng: np.random.Generator,
    made: TableFile,
    victim: str,
) -> list[list[Any]]:
    """Return the rows of a text or Excel file: blocks above, header, units, values."""
    order = [str(name) for name in rng.permutation(list(columns))]
    has_extra = bool(rng.random() < 0.5)  # a column that is not used
    style = str(rng.choice(["[{}]", "({})", ", {}", "row", "row ()"]))
    made.story += [f"units {style}", f"sign {sign}", *(["extra column"] if has_extra else [])]
    in_row = style.startswith("row")
    head: list[Any] = [
        headers[name] + ("" if in_row or not units[name] else " " + style.format(units[name]))
        for name in order
    ]
    head = [text.replace(" ,", ",") for text in head]
    table: list[list[Any]] = [head]
    if in_row:
        form = "({})" if style == "row ()" else "{}"
        table.append([form.format(units[name]) if units[name] else "-" for name in order])
    for k in range(len(columns[order[0]])):
        table.append([_number(float(columns[name][k]), sign) for name in order])
    first = len(table) - len(columns[order[0]])  # index of the first row of values
    if has_extra:
        extra = ["Remark", *(["C"] if in_row else [])] + ["ok"] * (len(table) - first)
        table = [[*row, cell] for row, cell in zip(table, extra, strict=True)]
    if made.fault == "" and made.contents == "measured" and rng.random() < 0.5:
        gap = int(rng.integers(first + 1, len(table)))  # an output that was not measured
        table[gap][order.index("wound_on_tension")] = ""
        made.expected["wound_on_tension"][gap - first] = float("nan")
        made.story.append("missing cell")
    bad = int(rng.integers(first + 1, len(table) - 1))
    if made.fault == "word in a cell":
        table[bad][order.index(victim)] = "bad"
    if made.fault == "thousands":
        table[bad][order.index(victim)] = "1.234,5"
        table[bad - 1][order.index(victim)] = "0,5"
    if made.fault == "short row":
        table[bad] = table[bad][:1]
    if made.fault == "two tables":
        table = [*table, [], *table]
    if made.fault == "no header":
        return table[first:]
    blocks: list[list[Any]] = []
    if rng.random() < 0.4:
        blocks += [["Machine 5"], ["Operator", "N. N."], []]
    if rng.random() < 0.3:
        blocks += [["Results"], ["Peak", _number(12.5, sign), "kN"], ["Cycles", "3"], []]
    made.story += [f"{len(blocks)} rows above"]
    return [*blocks, *table]


def _number(value: float, sign: str) -> str:
    """Return a number as text with the decimal sign."""
    return f"{value:.6f}".replace(".", sign)


def _write_rows(path: Path, rows: list[list[Any]], kind: str) -> Path:
    """Write rows as a text or Excel file; return its path."""
    if kind == "xlsx":
        import openpyxl

        book = openpyxl.Workbook()
        for row in rows:
            cells = [
                float(cell) if re.fullmatch(r"-?\d+\.\d+", str(cell)) else (cell or None)
                for cell in row
            ]
            book.active.append(cells)
        path = path.with_suffix(".xlsx")
        book.save(path)
        return path
    separator = {"csv ;": ";", "csv tab": "\t", "csv ,": ","}[kind]
    path = path.with_suffix(".csv")
    quoted = [[f'"{c}"' if separator in str(c) else str(c) for c in row] for row in rows]
    width = max(map(len, rows))
    # blank rows of spreadsheets have separators
    lines = [separator.join(row or [""] * width) for row in quoted]
    path.write_text("\n".join(lines) + "\n", encoding="utf-8")
    return path


def _write_lvm(
    path: Path,
    columns: dict[str, np.ndarray],
    headers: dict[str, str],
    units: dict[str, str],
    rng: np.random.Generator,
) -> Path:
    """Write a LabVIEW file; return its path."""
    import lvmio

    channels = [
        lvmio.Channel(headers[name], values.tolist(), unit=units[name], delta_x=0.1)
        for name, values in columns.items()
    ]
    sign = str(rng.choice([".", ","]))
    file = lvmio.LvmFile(
        [lvmio.Segment(channels)],
        decimal_separator=sign,
        x_columns=str(rng.choice(["One", "No", "Multi"])),
    )
    path = path.with_suffix(".lvm")
    path.write_text(lvmio.format_lvm(file), encoding="utf-8")
    return path


def _write_tdms(
    path: Path, columns: dict[str, np.ndarray], headers: dict[str, str], units: dict[str, str]
) -> Path:
    """Write a TDMS file; return its path."""
    import nptdms

    content = io.BytesIO()
    with nptdms.TdmsWriter(content) as writer:
        writer.write_segment(
            [
                nptdms.ChannelObject(
                    "rig",
                    headers[name],
                    values,
                    {"unit_string": units[name], "wf_increment": 0.1, "wf_start_offset": 0.0},
                )
                for name, values in columns.items()
            ]
        )
    path = path.with_suffix(".tdms")
    path.write_bytes(content.getvalue())
    return path


def _values(made: TableFile) -> dict[str, np.ndarray]:
    """Read a file and return its values in SI by name."""
    others = {"*": None}
    if made.contents == "measured":
        read = read_measured(
            made.path,
            columns_of(NIP),
            measurable_outputs(NIP),
            others,
            conversion=conversion_of(NIP),
        )
        return {**read.inputs, **read.outputs}
    if made.contents == "stack":
        test = read_compression_test(made.path, area=0.01, height=0.02, preload=0.0)
        P, eps = test.pressure, test.strain
        return {"force": 0.01 * P, "deflection": 0.02 * eps}
    log = wo.read_log(made.path, WINDING).bins
    values = dict(zip(log.names, log.raw, strict=True))
    return {**values, "diameter": 2 * log.raw_radius}


def outcome(made: TableFile) -> tuple[str, str]:
    """Return the outcome of a file and its reason."""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("ignore", wo.InputWarning)
            values = _values(made)
    except wo.InvalidProblem as fault:
        text = str(fault)
        is_clear = len(text.splitlines()) <= 10 and PLACE.search(text) and REMEDY.search(text)
        return ("rejected" if is_clear else "unclear"), text
    except Exception:
        return "error", traceback.format_exc()
    # a column that is not used, of a file with an unknown header, is no fault of the others
    missing = [name for name in made.expected if name not in values]
    for name in set(made.expected) - set(missing):
        found, exact = values[name], np.array(made.expected[name])
        # six decimals are written, and lengths and areas are multiplied and divided again
        if found.shape != exact.shape or not np.allclose(found, exact, 1e-9, 1e-15, equal_nan=True):
            return "wrong", f"{name}: {found[:3]} in place of {exact[:3]}"
    if made.fault not in ("", "unknown header") or (missing and not made.fault):
        return "wrong", f"is read: {sorted(values)}"
    return "read", ""


def main() -> int:
    """Read random files, print the outcomes; return 1 if one is wrong."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--files", type=int, default=300)
    parser.add_argument("--first", type=int, default=0, help="first seed")
    parser.add_argument("--show", action="store_true", help="print the reasons of rejections")
    arguments = parser.parse_args()
    counts: Counter[tuple[str, str]] = Counter()
    failed = 0
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(arguments.first, arguments.first + arguments.files):
            made = random_file(seed, Path(folder))
            result, reason = outcome(made)
            counts["faulty" if made.fault else "good", result] += 1
            is_failure = result in ("wrong", "error", "unclear")
            failed += is_failure
            if is_failure or (not made.fault and result != "read") or arguments.show:
                print(f"seed {seed}: {result}: {', '.join(made.story)}\n    {reason}")
    for (group, result), count in sorted(counts.items()):
        print(f"{count:5d} {group} files: {result}")
    return int(failed > 0)


if __name__ == "__main__":
    sys.exit(main())
