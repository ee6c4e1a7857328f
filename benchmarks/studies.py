"""How many nips a study solves per second, what the engine costs, how two workers share the work.

    python benchmarks/studies.py                  a sample of a grid of 100 000 cases, a minute
    python benchmarks/studies.py --chunks 1000    all of it
    python benchmarks/studies.py --nodes 65       one grid for all, in place of "0.1 % estimated"

The problem is that of the thesis's Table 1; nip load, winding force, friction and shear modulus are
varied.  Chunks of 100 neighbours are taken evenly from the whole grid.  Rates are given by the
clock and by processor time: on a busy machine only the latter means something.
"""

from __future__ import annotations

import os

os.environ.setdefault("OMP_NUM_THREADS", "1")
os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")

import argparse
import tempfile
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

import woundon as wo
from jorkama2001.cases import paper_nip
from woundon.studies.design import Design, make_design
from woundon.studies.evaluate import Block, Chunk
from woundon.studies.kind_model import KindModel, model_of
from woundon.studies.runners import Here, Pool
from woundon.studies.store import opened

OUTPUTS = ("nip_induced_tension", "nip_induced_tension_error")
OVER = {
    "nip_load": np.linspace(1000.0, 5000.0, 50),
    "winding_force": np.linspace(-100.0, 200.0, 20),
    "roll_friction": np.linspace(0.15, 0.3, 10),
    "roll.material.shear": np.linspace(6e6, 15e6, 10),
}


def sample(design: Design, count: int) -> list[Chunk]:
    """Return chunks taken evenly from the whole grid."""
    chunks = design.chunks()
    places = np.unique(np.linspace(0, len(chunks) - 1, count).round().astype(int))
    return [Chunk(int(k), chunks[k], design.inputs(chunks[k])) for k in places]


def timed(run: Callable[[], Any]) -> tuple[Any, float, float]:
    """Return the outcome, seconds by the clock, and seconds of this process and its children."""
    wall, before = time.perf_counter(), os.times()
    out = run()
    after = os.times()
    cpu = sum(after[:4]) - sum(before[:4])
    return out, time.perf_counter() - wall, cpu


def accuracy(model: KindModel, chunks: list[Chunk], blocks: list[Block], count: int) -> str:
    """Compare cases drawn from the blocks with fine solutions."""
    rng, solved = np.random.default_rng(0), {b.number: b for b in blocks}
    errors, stated = [], []
    for _ in range(count):
        chunk = chunks[rng.integers(len(chunks))]
        row = int(rng.integers(len(chunk.cases)))
        problem = model.variant(list(chunk.rows())[row])
        fine = wo.solve_nip(problem, rtol=1e-4).nip_induced_tension
        scale = max(abs(fine), 0.01 * problem.roll_friction * problem.nip_load)
        value, error = solved[chunk.number].values[row]
        errors.append(abs(value - fine) / scale)
        stated.append(abs(value - fine) / error)
    within = np.mean(np.array(errors) <= 1e-3)
    return (
        f"error of NIT in {count} of them: median {np.median(errors):.3%}, 95 % below "
        f"{np.quantile(errors, 0.95):.3%}, {within:.0%} within 0.1 %; 95 % within "
        f"{np.quantile(stated, 0.95):.2g} stated errors"
    )


def overhead(model: KindModel, chunks: list[Chunk]) -> tuple[float, float]:
    """Return processor seconds a case: of a stored study, and of the solver alone.

    The solver is called with ready-made problems, each from the result before; the study makes the
    problems, takes the outputs, and writes a part for every chunk.
    """
    cases = sum(len(c.cases) for c in chunks)
    rows = [[model.variant(row) for row in chunk.rows()] for chunk in chunks]

    def alone() -> None:
        for problems in rows:
            state = None
            for problem in problems:
                state = wo.solve_nip(problem, start=state, **model.options)

    def stored() -> None:
        with tempfile.TemporaryDirectory() as folder:
            design = make_design(OVER)
            study = design, design.chunks(), model.outputs, model.record()
            with opened(Path(folder) / "study", *study, resume=False) as store:
                for block in Here().solved(model, chunks):
                    store.write(block)

    # by turns, the better of three: others use the machine too
    spent = [(timed(stored)[2], timed(alone)[2]) for _ in range(3)]
    whole, bare = np.min(spent, axis=0) / cases
    return float(whole), float(bare)


def main() -> None:
    """Print rates, shares and errors."""
    options = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    options.add_argument("--chunks", type=int, default=20)
    options.add_argument("--nodes", type=int)
    options.add_argument("--check", type=int, default=100)
    given = options.parse_args()
    design = make_design(OVER)
    chunks = sample(design, given.chunks)
    cases = sum(len(c.cases) for c in chunks)
    model = model_of(paper_nip(), OUTPUTS, {"web.material": "roll.material"}, vars_of(given))
    print(f"{cases} of {design.size} cases, {model.options or 'default accuracy, 0.1 %'}")
    model.run({}, None)
    blocks, wall, cpu = timed(lambda: list(Here().solved(model, chunks)))
    failed = sum(np.count_nonzero(b.failure != "") for b in blocks)
    print(
        f"1 process: {cases / wall:.0f} nips/s by the clock, {cases / cpu:.0f} by processor time, "
        f"{failed} failed"
    )
    whole, bare = overhead(model, chunks[:: max(1, len(chunks) // 5)])
    print(
        f"study {1e3 * whole:.2f} ms a nip, solver alone {1e3 * bare:.2f}: {whole / bare - 1:+.1%}"
    )
    first = [Chunk(0, chunks[0].cases[:1], {k: v[:1] for k, v in chunks[0].inputs.items()})]
    for workers in (1, 2):
        _, start, begun = timed(lambda w=workers: list(Pool(w).solved(model, first)))
        _, both, share = timed(lambda w=workers: list(Pool(w).solved(model, chunks)))
        print(
            f"pool of {workers}: {cases / (both - start):.0f} nips/s by the clock after "
            f"{start:.1f} s of starting; {workers * cases / (share - begun):.0f} "
            "if every worker had a core to itself"
        )
    print(accuracy(model, chunks, blocks, given.check))


def vars_of(given: argparse.Namespace) -> dict[str, Any]:
    """Return the solver's options."""
    return {"nodes": given.nodes} if given.nodes else {}


if __name__ == "__main__":
    main()
