"""Damaged result files and malformed case files: each is rejected, or loads to what was saved.

A file passes if it loads to exactly what was saved, or is rejected by one InvalidProblem with one
line for each fault.  Everything else is a finding: a different result, any other exception, a line
that does not fit on a screen, more than ten seconds of processor time.  The seed determines the
file.
"""

from __future__ import annotations

import dataclasses
import io
import json
import os
import time
import warnings
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
import xarray

import woundon as wo
from woundon.io import result_files
from woundon.io.case_files import template
from woundon.quantities import outputs, value_of

SECONDS = 10.0
LONGEST = 1005  # characters of a line of an error
MOST = 51  # lines

Random = np.random.Generator


class Outcome(NamedTuple):
    """Outcome of one file; ``finding`` is empty if it passes."""

    damage: str
    ending: str
    finding: str
    seconds: float
    text: str = ""


# ---- results ------------------------------------------------------------------------------------


@cache
def results() -> tuple[Any, ...]:
    """Return one result of each sort."""
    nip, pair = wo.NipProblem.example().replace(roll_wrap=0.0), wo.RollerProblem.example()
    return (
        wo.solve(nip, nodes=25),
        wo.solve(nip, rtol=1e-3),
        wo.solve(nip.replace(roll_wrap=np.pi, drum_wrap=1.0), nodes=17),
        wo.solve(pair, nodes=25),
        wo.solve(pair.replace(motion="static"), nodes=25),
    )


@cache
def saved(which: int, format: str) -> bytes:
    """Return the content of the file of a result."""
    return result_files.writer_for(f"a.{format}")(results()[which])


def cut(content: bytes, random: Random) -> bytes:
    return content[: random.integers(len(content))]


def flipped_byte(content: bytes, random: Random) -> bytes:
    out = bytearray(content)
    out[random.integers(len(out))] ^= int(random.integers(1, 256))
    return bytes(out)


def flipped_bit(content: bytes, random: Random) -> bytes:
    out = bytearray(content)
    out[random.integers(len(out))] ^= 1 << int(random.integers(8))
    return bytes(out)


def swapped_blocks(content: bytes, random: Random) -> bytes:
    size = int(2 ** random.uniform(0, 9))
    one, two = sorted(int(k) for k in random.integers(0, len(content) - size, 2))
    two = max(two, one + size)
    return (content[:one] + content[two : two + size] + content[one + size : two]
            + content[one : one + size] + content[two + size :])  # fmt: skip


def blanked(content: bytes, random: Random) -> bytes:
    size = int(2 ** random.uniform(0, 12))
    start = int(random.integers(len(content)))
    return content[:start] + bytes(min(size, len(content) - start)) + content[start + size :]


def bytes_put_in(content: bytes, random: Random) -> bytes:
    start = int(random.integers(len(content)))
    return content[:start] + random.bytes(int(random.integers(1, 20))) + content[start:]


def bytes_left_out(content: bytes, random: Random) -> bytes:
    start = int(random.integers(len(content)))
    return content[:start] + content[start + int(random.integers(1, 20)) :]


def longer(content: bytes, random: Random) -> bytes:
    return content + (content if random.random() < 0.5 else random.bytes(100))


BYTES = (
    cut, flipped_byte, flipped_bit, swapped_blocks, blanked, bytes_put_in, bytes_left_out, longer,
)  # fmt: skip

# ---- edits of what a file says ------------------------------------------------------------------

Leaf = tuple[Any, Any]  # a container, and where in it


def leaves(part: Any, wanted: Callable[[Any], bool]) -> list[Leaf]:
    """Return where in a record values stand that are wanted."""
    found: list[Leaf] = []
    items = part.items() if isinstance(part, dict) else enumerate(part)
    for key, value in items:
        if wanted(value):
            found.append((part, key))
        if isinstance(value, (dict, list)):
            found += leaves(value, wanted)
    return found


def chosen(random: Random, found: list[Leaf]) -> Leaf:
    return found[random.integers(len(found))]


def is_number(value: Any) -> bool:
    return isinstance(value, (int, float)) and not isinstance(value, bool)


def another_number(record: dict[str, Any], random: Random) -> None:
    part, key = chosen(random, leaves(record, is_number))
    value = part[key]
    near = value * (1 + 10 ** random.uniform(-12, 0)) if value else 1e-9
    part[key] = [near, -value - 1, 9999, value + 1, 0.5, 1e300][random.integers(6)]


def no_number(record: dict[str, Any], random: Random) -> None:
    part, key = chosen(random, leaves(record, is_number))
    part[key] = [None, "1", True, [], {}, float("nan"), float("inf"), 10**400, "x" * 10**4][
        random.integers(9)
    ]


def swapped_values(record: dict[str, Any], random: Random) -> None:
    (one, i), (two, j) = (chosen(random, leaves(record, is_number)) for _ in range(2))
    one[i], two[j] = two[j], one[i]


def swapped_arrays(record: dict[str, Any], random: Random) -> None:
    arrays = [(p, k) for p, k in leaves(record, lambda v: isinstance(v, list)) if len(p[k]) > 5]
    (one, i), (two, j) = (chosen(random, arrays) for _ in range(2))
    one[i], two[j] = two[j], one[i]


def another_unit(record: dict[str, Any], random: Random) -> None:
    key = list(record["units"])[random.integers(len(record["units"]))]
    record["units"][key] = ["mm", "kPa", "", None, 3, "N/mm"][random.integers(6)]


def renamed(record: dict[str, Any], random: Random) -> None:
    part, key = chosen(random, [leaf for leaf in leaves(record, lambda _: True)
                                if isinstance(leaf[0], dict)])  # fmt: skip
    part[f"{key}s"] = part.pop(key)


def left_out(record: dict[str, Any], random: Random) -> None:
    part, key = chosen(random, leaves(record, lambda _: True))
    del part[key]


def another_word(record: dict[str, Any], random: Random) -> None:
    part, key = chosen(random, leaves(record, lambda value: isinstance(value, str)))
    part[key] = ["", "nip", "rigid", "0" * 64, "\x00", "é\n"][random.integers(6)]


def nested(record: dict[str, Any], random: Random) -> None:
    part, key = chosen(random, leaves(record, lambda _: True))
    for _ in range(int(random.integers(1, 900))):
        part[key] = [part[key]]


EDITS = (
    another_number, no_number, swapped_values, swapped_arrays, another_unit, renamed, left_out,
    another_word, nested,
)  # fmt: skip


def edited_json(edit: Callable[..., None]) -> Callable[[bytes, Random], bytes]:
    def damage(content: bytes, random: Random) -> bytes:
        record = json.loads(content)
        edit(record, random)
        return json.dumps(record, indent=1).encode()

    return damage


def nc_another_number(data: xarray.Dataset, random: Random) -> xarray.Dataset:
    name = _any(data, random)
    values = np.array(data[name].values, copy=True)
    where = random.integers(values.size)
    near = values.flat[where] * (1 + 10 ** random.uniform(-10, 0))
    values.flat[where] = [near, 7, -1, 9999, np.nan if values.dtype.kind == "f" else 3][
        random.integers(5)
    ]
    return data.assign({name: (data[name].dims, values, data[name].attrs)})


def nc_another_type(data: xarray.Dataset, random: Random) -> xarray.Dataset:
    name, to = _any(data, random), ["int8", "int16", "int32", "float32"][random.integers(4)]
    with np.errstate(all="ignore"):
        return data.assign({name: data[name].astype(to)})


def nc_another_unit(data: xarray.Dataset, random: Random) -> xarray.Dataset:
    name = _any(data, random)
    units = ["mm", "kPa", "", "seconds", "days since 2000-01-01"][random.integers(5)]
    return data.assign({name: data[name].assign_attrs(units=units)})


def nc_renamed(data: xarray.Dataset, random: Random) -> xarray.Dataset:
    name = _any(data, random)
    return data.rename({name: f"{name}s"})


def nc_swapped(data: xarray.Dataset, random: Random) -> xarray.Dataset:
    one, two = (_any(data, random) for _ in range(2))
    if data[one].dims != data[two].dims:
        return nc_renamed(data, random)
    dims, values = data[one].dims, {name: data[name].values.copy() for name in (one, two)}
    return data.assign({
        one: (dims, values[two], data[one].attrs), two: (dims, values[one], data[two].attrs),
    })  # fmt: skip


def nc_left_out(data: xarray.Dataset, random: Random) -> xarray.Dataset:
    return data.drop_vars(_any(data, random))


def nc_attribute(data: xarray.Dataset, random: Random) -> xarray.Dataset:
    name = list(data.attrs)[random.integers(len(data.attrs))]
    if name == "problem":
        problem = json.loads(data.attrs[name])
        another_number(problem, random)
        return data.assign_attrs(problem=json.dumps(problem))
    return data.assign_attrs({name: ["", "nip", 3, 0.5, "[]", "{}", "null"][random.integers(7)]})


def _any(data: xarray.Dataset, random: Random) -> str:
    names = [str(name) for name in data.variables if name != "law"]
    return names[random.integers(len(names))]


NC_EDITS = (
    nc_another_number, nc_another_type, nc_another_unit, nc_renamed, nc_swapped, nc_left_out,
    nc_attribute,
)  # fmt: skip


def edited_netcdf(edit: Callable[..., xarray.Dataset]) -> Callable[[bytes, Random], bytes]:
    def damage(content: bytes, random: Random) -> bytes:
        with xarray.open_dataset(io.BytesIO(content), engine="scipy", decode_times=False) as data:
            for _ in range(20):
                changed = edit(data.load(), random)
                try:
                    return bytes(changed.to_netcdf(engine="scipy"))
                except (TypeError, ValueError):  # xarray itself refuses to write that
                    continue
        raise AssertionError(f"{edit.__name__} gives nothing that can be written")

    return damage


def damaged_result(seed: int, folder: Path) -> Outcome:
    """Load one damaged result file."""
    random = np.random.default_rng(seed)
    which, ending = int(random.integers(len(results()))), ("nc", "json")[random.integers(2)]
    content = saved(which, ending)
    edits: tuple[Any, ...] = NC_EDITS if ending == "nc" else EDITS
    chosen = (*BYTES, *edits)[random.integers(len(BYTES) + len(edits))]
    damage = chosen
    if chosen in edits:
        damage = (edited_netcdf if ending == "nc" else edited_json)(chosen)
    path = folder / f"result.{ending}"
    path.write_bytes(damage(content, random))

    def same(loaded: Any) -> str:
        return difference(loaded, results()[which])

    name = chosen.__name__.removeprefix("nc_").replace("_", " ")
    return judged(name, ending, lambda: wo.load_result(path), same, str(path))


def difference(loaded: Any, result: Any) -> str:
    """Return the fields in which a loaded result differs."""
    if loaded != result:
        fields = [part.name for part in dataclasses.fields(result) if part.compare and repr(
            getattr(loaded, part.name)) != repr(getattr(result, part.name))]  # fmt: skip
        return ", ".join(fields) or "unequal"
    for place in outputs(result):
        one, two = value_of(loaded, place.path), value_of(result, place.path)
        if not np.array_equal(one, two, equal_nan=np.asarray(one).dtype.kind == "f"):
            return place.path
    return ""


def judged(
    damage: str, ending: str, load: Callable[[], Any], same: Callable[[Any], str], path: str
) -> Outcome:
    """Load a file and judge the outcome."""
    start, finding, text = time.process_time(), "", ""
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            loaded = load()
        differs = same(loaded)
        finding = f"accepted, differs in {differs}" if differs else ""
        text = "loaded"
    except UserWarning as warning:
        text = str(warning)
    except wo.InvalidProblem as fault:
        text = str(fault).replace(path, "FILE")
        lines = text.splitlines()
        if len(lines) != min(len(fault.faults), MOST):
            finding = "a fault in several lines"
        elif max(map(len, lines)) > LONGEST:
            finding = f"a line of {max(map(len, lines))} characters"
        elif not all(line.isprintable() for line in lines):
            finding = "a line that cannot be printed"
    except BaseException as fault:
        if isinstance(fault, KeyboardInterrupt):
            raise
        finding, text = f"{type(fault).__name__}", str(fault)
    seconds = time.process_time() - start
    if not finding and seconds > SECONDS:
        finding = "takes long"
    return Outcome(damage, ending, finding, seconds, text)


# ---- cases --------------------------------------------------------------------------------------

WORDS: tuple[str, ...] = (
    "9" * 5000, "-" + "9" * 5000, "0x" + "f" * 5000, "1e400", "-1e400", "inf", "nan", "1e-400",
    "true", "[]", "{}", "[[[[[]]]]]", "[1, 2]", '""', "''", '"\\u0000"', '"\\n"', '"\\u202e"',
    "1979-05-27T07:32:00Z", "07:32:00", "1979-05-27", '"1e400 N/m"', '"9**9**9**9 m"',
    '"__import__(\'os\').getpid() m"', f'"{"9" * 5000} N/m"', f'"1 {"m*" * 3000}m"',
    f'"1 {"(" * 3000}m"', f'"{"x" * 100_000}"', '"1 furlong"', '"３ mm"', '"1 mm mm"', '"1 m^400"',
    '"1 m^-1e9"', '"1 m**m"', '"1 µm"', '"1,5 mm"', '"0x10 mm"', '"1_000 mm"', '"+-1 mm"', '"mm"',
    '"nan m"', '"inf m"', "1_0.0_1", "{ a = 1 }", "[{ radius = 1 }]", '"../../etc/passwd"',
    f"[{'1,' * 100_000}]", f"{'[' * 900}{']' * 900}", f"{'[' * 50_000}{']' * 50_000}",
    f"{'{a=' * 300}1{'}' * 300}", '"""\na\nb\n"""', "'''\r\n'''",
)  # fmt: skip
KEYS: tuple[str, ...] = (
    '""', '"\\n"', '"\\u0000"', '"\\u202e"', '"\\u001b[31m"', '"a.b"', "x" * 100_000, "schema",
    "kind", "nip_laod", "web.thickness.x", ".".join("a" * 900), ".".join("a" * 50_000), "__class__",
    "__init__", "model_fields", "0", "-", "é", "wrap", "web", "roll.material.kind",
    '"' + "\\n" * 1000 + '"',
)  # fmt: skip


def case_text() -> str:
    return template("nip")


def bad_value(random: Random, folder: Path) -> bytes:
    lines = case_text().splitlines()
    places = [k for k, line in enumerate(lines) if " = " in line and not line.startswith("#")]
    k = places[random.integers(len(places))]
    key = lines[k].partition(" = ")[0]
    lines[k] = f"{key} = {WORDS[random.integers(len(WORDS))]}"
    return "\n".join(lines).encode()


def bad_key(random: Random, folder: Path) -> bytes:
    lines = case_text().splitlines()
    key, word = KEYS[random.integers(len(KEYS))], WORDS[random.integers(len(WORDS))]
    lines.insert(int(random.integers(len(lines))), f"{key} = {word}")
    return "\n".join(lines).encode()


def bad_table(random: Random, folder: Path) -> bytes:
    key = KEYS[random.integers(len(KEYS))]
    head = (f"[{key}]", f"[[{key}]]", f"[{'.'.join(['a'] * 900)}]", "[web]", "[[web]]", "[a.b.c]")
    return f"{case_text()}\n{head[random.integers(len(head))]}\nx = 1\n".encode()


def many(random: Random, folder: Path) -> bytes:
    count = int(10 ** random.uniform(2, 5))
    rows = (
        lambda k: f"k{k} = {k}",
        lambda k: f"[t{k}]\nx = 1",
        lambda k: "[[drum.layers]]\nthickness = 1",
        lambda k: f"web_thicknes{k} = 'x'",
    )
    row = rows[random.integers(len(rows))]
    many_rows = "\n".join(row(k) for k in range(count))
    return (f"{many_rows}\n{case_text()}" if random.random() < 0.5
            else f"{case_text()}\n{many_rows}").encode()  # fmt: skip


def too_large(random: Random, folder: Path) -> bytes:
    return case_text().encode() + b"# " + b"x" * int(random.uniform(1.0e7, 2e7))


def wrong_encoding(random: Random, folder: Path) -> bytes:
    name = ("utf-16", "utf-32", "utf-16-be", "latin-1", "cp500")[random.integers(5)]
    return case_text().replace("#", "# é ü", 3).encode(name, "replace")


def zero_bytes(random: Random, folder: Path) -> bytes:
    content = case_text().encode()
    k = int(random.integers(len(content)))
    return content[:k] + b"\0" * int(random.integers(1, 50)) + content[k:]


def binary(random: Random, folder: Path) -> bytes:
    head = (b"", b"\x7fELF", b"PK\x03\x04", b"\x1f\x8b", b"schema = 1\n")[random.integers(5)]
    return head + random.bytes(int(10 ** random.uniform(0, 5)))


def control_characters(random: Random, folder: Path) -> bytes:
    content = case_text()
    k = int(random.integers(len(content)))
    marks = "\x1b[2J\r\x0b\x0c\x85\u2028\u2029\u202e\ufeff\x07\ufffe"
    return (content[:k] + marks[random.integers(len(marks))] * 3 + content[k:]).encode()


def damaged(random: Random, folder: Path) -> bytes:
    return BYTES[random.integers(len(BYTES))](case_text().encode(), random)


def no_file(random: Random, folder: Path) -> Path:
    pipe, link = folder / "pipe", folder / "link"
    if not pipe.exists():
        os.mkfifo(pipe)
        link.symlink_to("link")
    odd = ("/dev/zero", "/dev/null", "/dev/random", "/proc/self/mem", folder, pipe, link,
           folder / "none", folder / ("x" * 5000), folder / "a\0b", "", "/proc/self/fd/0",
           "/sys/kernel/notes")  # fmt: skip
    return Path(odd[random.integers(len(odd))])


HOSTILE = (
    bad_value, bad_key, bad_table, bad_value, bad_key, many, too_large, wrong_encoding, zero_bytes,
    binary, control_characters, damaged, no_file,
)  # fmt: skip


def hostile_case(seed: int, folder: Path) -> Outcome:
    """Load one malformed case file; a problem that loads must survive writing and reading."""
    random = np.random.default_rng(seed)
    make = HOSTILE[random.integers(len(HOSTILE))]
    made = make(random, folder)
    path = made if isinstance(made, Path) else folder / "case.toml"
    if isinstance(made, bytes):
        path.write_bytes(made)

    def same(problem: Any) -> str:
        return "" if problem == type(problem)(**problem.model_dump()) else "what it holds"

    name = make.__name__.replace("_", " ")
    return judged(name, "toml", lambda: wo.load_case(path), same, str(path))
