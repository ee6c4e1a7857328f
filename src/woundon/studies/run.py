"""Run a study: its cases are solved by workers, stored chunk by chunk, and returned as a table.

    Cases --> chunks --> Workers: this process, processes, a Dask cluster --> store --> Table

A study uses a :class:`~.model.Model` only: names in, numbers out.
"""

from __future__ import annotations

import json
import re
import time
from collections import deque
from collections.abc import Callable, Generator, Mapping, Sequence
from concurrent.futures import FIRST_COMPLETED, Future, wait
from contextlib import closing, nullcontext
from dataclasses import dataclass, field
from functools import partial
from math import inf
from os import PathLike
from pathlib import Path
from typing import TYPE_CHECKING, Any, TypeVar

import numpy as np

from .. import __version__
from ..arguments import check_arguments, whole_number
from ..errors import InvalidProblem, NoSteadyState, NotConverged
from ..parallel import WorkerDied, in_processes, stoppable, usable_cores
from ..parallel import progress as report_progress
from ..quantities import Quantity
from ..results import Presented
from .cases import Cases, Chunk, Solved, as_labels
from .model import Model, quantities_of
from .progress import Progress, progress_reporter
from .store import open_store

if TYPE_CHECKING:
    import pandas as pd
    import xarray
    from distributed import Client
    from matplotlib.axes import Axes
    from matplotlib.figure import Figure

__all__ = ["Table", "Workers", "failures", "run_study", "solve_chunk"]

Array = np.ndarray
Item = TypeVar("Item")
Answer = TypeVar("Answer")

WORTH_PROCESSES = 3.0  # seconds of remaining work; starting the processes takes about one
MOST_PROCESSES = 10_000
CONNECTING = 10.0  # seconds until a scheduler is out of reach
MOST_REASONS = 5  # of failures that are named
QUEUED = 4  # items sent to a worker of a cluster at a time, so that it never waits
FINISHING = "finishing the chunks under way; press Ctrl-C again to stop at once"
DIED = "the worker process died while it solved this chunk, twice"
TEXTS = {
    "failure": "reason of the failure; empty if the case was solved",
    "warnings": "warnings about the validity of the model",
}
# how the reasons of cases begin that were rejected before they were solved
_REJECTIONS = tuple(f"{kind.__name__}: " for kind in (InvalidProblem, NoSteadyState))


def run_study(
    model: Model,
    cases: Cases,
    workers: Workers,
    *,
    out: str | Path | None = None,
    resume: bool = False,
    chunk: int | None = None,
    progress: bool | Progress = False,
) -> Table:
    """Solve all cases of a study.

    Parameters
    ----------
    model : Model
    cases : Cases
    workers : Workers
    out : path, optional
        Folder of the file to which chunks are added as they are solved.
    resume : bool
        Continue the study in ``out``; the cases that it holds are not solved again.
    chunk : int, optional
        Cases in a chunk.
    progress : bool or callable
        Show rate and remaining time, or call with (cases done, all cases).

    Raises
    ------
    InvalidProblem
        For an unknown name, a folder that contains another study, or a damaged file in it.
    OSError
        If ``out`` cannot be written; chunks in the file remain valid.
    KeyboardInterrupt
        After Ctrl-C; finished chunks are in ``out``.

    Examples
    --------
    >>> import woundon as wo
    >>> from woundon.studies.api import study_of
    >>> model, cases = study_of(
    ...     wo.RollerProblem.example(), {"load": [5e4, 1e5]}, ["half_width"], options={"nodes": 17}
    ... )
    >>> run_study(model, cases, Workers(1)).failed.size
    0
    """
    check_arguments(out=out, resume=resume, progress=progress)
    if resume and out is None:
        raise InvalidProblem.at("resume", "needs out, the folder of the study to resume")
    for name in set(cases.names) & set(model.outputs):
        raise InvalidProblem.at(name, "is varied, so it cannot be an output")
    quantities = quantities_of(model, (*cases.names, *model.outputs))
    settings = model.record()
    chunks = cases.chunks(chunk)
    storing: Any = nullcontext()
    if out is not None:
        record = {
            "version": __version__,
            "design": cases.record(),
            "outputs": list(model.outputs),
            "chunk": chunk,
            **settings,
        }
        storing = open_store(out, record, len(chunks), resume=resume)
    with storing as store:
        solved = {} if store is None else dict(store.kept)
        remaining = [part for part in chunks if part.number not in solved]
        done = len(cases) - sum(len(part.cases) for part in remaining)
        results = workers.map(
            partial(solve_chunk, model),
            remaining,
            finishing=FINISHING,
            died=lambda part: unsolved(part, len(model.outputs), DIED),
        )
        reporting = progress_reporter(progress, "solving", unit="cases/s", done=done)
        # closing ends the workers here, not when the garbage is collected
        with reporting as report, closing(results):
            for part, results_of_part in results:
                if store is not None:
                    store.write(part.number, results_of_part)
                solved[part.number] = results_of_part
                done += len(part.cases)
                report(done, len(cases))
    pairs = [(part, solved[part.number]) for part in chunks]
    return Table.of(cases, model.outputs, pairs, quantities, settings)


# ---- one chunk ----------------------------------------------------------------------------------


def solve_chunk(model: Model, chunk: Chunk) -> Solved:
    """Solve the cases of a chunk in their order, each from the state of the last solved one.

    This is the function that runs in worker processes.  If a case raises an exception, this is the
    reason of its failure.
    """
    solved = unsolved(chunk, len(model.outputs), "")
    state = None
    for row, inputs in enumerate(chunk.inputs):
        report_progress(row / len(chunk.inputs))
        try:
            answer = model.run(inputs, state)
        except Exception as fault:
            # an exception of a solver or of an output of a plug-in must not end the study
            solved.failure[row] = f"{type(fault).__name__}: {fault}".replace("\n", "; ")
            continue
        solved.values[row], solved.warnings[row] = answer.values, answer.warnings
        state = answer.state
    return solved


def unsolved(chunk: Chunk, outputs: int, reason: str) -> Solved:
    """Return the results of a chunk of which no case is solved."""
    k = len(chunk.inputs)
    return Solved(np.full((k, outputs), np.nan), [reason] * k, [""] * k)


# ---- workers ------------------------------------------------------------------------------------


@dataclass(frozen=True)
class Workers:
    """The processes that do the work of a study: this one, several, or a Dask cluster.

    Parameters
    ----------
    processes : int, optional
        Number of processes of this machine.  By default this process works alone, and one process
        for each core continues if much work remains.
    scheduler : str, optional
        Address of a Dask scheduler, "tcp://...", whose workers do the work.

    Raises
    ------
    InvalidProblem
        For a number of processes below one, or one that is given together with a scheduler.

    Examples
    --------
    >>> list(Workers(1).map(abs, [-2, 3]))
    [(-2, 2), (3, 3)]
    """

    processes: int | None = None
    scheduler: str | None = None

    def __post_init__(self) -> None:
        check_arguments(scheduler=self.scheduler)
        count = self.processes
        if self.scheduler is not None and count is not None:
            text = "cannot be combined with a scheduler, which has its own workers"
            raise InvalidProblem.at("workers", text)
        if count is not None:
            whole_number("workers", count, 1, MOST_PROCESSES)

    @property
    def count(self) -> int:
        """Number of processes of this machine: by default one for each core."""
        return self.processes or usable_cores()

    def map(
        self,
        work: Callable[[Item], Answer],
        items: Sequence[Item],
        *,
        finishing: str = "",
        died: Callable[[Item], Answer] | None = None,
    ) -> Generator[tuple[Item, Answer], None, None]:
        """Yield every item with ``work(item)`` as soon as it is done.

        Parameters
        ----------
        work : callable
            It is pickled, as are items and answers.
        items : sequence
        finishing : str, optional
            Message at the first Ctrl-C, after which the work in progress is finished and yielded;
            the second one stops at once, as the first does without this.
        died : callable, optional
            Item -> answer for an item during which two processes, or several workers of a cluster,
            died.

        Raises
        ------
        InvalidProblem
            If the scheduler cannot be reached, or its workers have another version of woundon.
        KeyboardInterrupt
            After Ctrl-C.
        WorkerDied
            If processes died during an item and ``died`` is not given.
        Exception
            An exception of ``work``.
        """
        if self.scheduler is not None:
            yield from _on_cluster(self.scheduler, work, items, finishing, died)
            return
        count, done = self.count, 0
        if self.processes is None or count == 1:
            # the time that the remaining items may take in this process
            limit = inf if count == 1 else WORTH_PROCESSES
            began = time.perf_counter()
            with stoppable(finishing) as stopped:
                while done < len(items) and not stopped():
                    pace = (time.perf_counter() - began) / max(done, 1)
                    if pace * (len(items) - done) > limit:
                        break
                    yield items[done], work(items[done])
                    done += 1
        if done < len(items):
            yield from in_processes(work, items[done:], count, finishing=finishing, died=died)


def _on_cluster(
    address: str,
    work: Callable[[Item], Answer],
    items: Sequence[Item],
    finishing: str,
    died: Callable[[Item], Answer] | None,
) -> Generator[tuple[Item, Answer], None, None]:
    """Yield items with their answers from the workers of a Dask scheduler.

    Dask replaces workers that die.  Parameters as of :meth:`Workers.map`.
    """
    try:
        from distributed import Client, KilledWorker
    except ImportError:
        raise InvalidProblem.at("scheduler", "needs Dask: pip install 'woundon[dask]'") from None
    try:
        client = Client(address, timeout=CONNECTING, set_as_default=False)
    except (OSError, ValueError) as fault:
        raise InvalidProblem.at("scheduler", f"{address!r} cannot be reached: {fault}") from None
    _check_installed(client)
    waiting, running = deque(items), dict[Future[tuple[str, Answer]], Item]()
    limit = QUEUED * max(1, sum(client.nthreads().values()))
    with stoppable(finishing) as stopped, client, client.get_executor(pure=False) as cluster:
        while running or (waiting and not stopped()):
            while waiting and len(running) < limit and not stopped():
                item = waiting.popleft()
                running[cluster.submit(_with_version, work, item)] = item
            for future in wait(running, return_when=FIRST_COMPLETED).done:
                item = running.pop(future)
                try:
                    version, answer = future.result()
                except KilledWorker as fault:  # several workers died during this item
                    if died is None:
                        raise WorkerDied("several workers of the cluster died") from fault
                    version, answer = __version__, died(item)
                if version != __version__:  # of a worker that has joined since
                    text = f"a worker runs woundon {version}, not {__version__}"
                    raise InvalidProblem.at("scheduler", text)
                yield item, answer


def _check_installed(client: Client) -> None:
    """Reject a cluster that does not have the client's version of the program everywhere.

    The scheduler and the workers unpickle the work.  A worker that cannot import it leaves the
    cluster without an answer.
    """
    installed: Any = client.get_versions(packages=["woundon"])
    expected = installed["client"]["packages"]["woundon"]
    for name, machine in {"the scheduler": installed["scheduler"], **installed["workers"]}.items():
        if (version := machine["packages"]["woundon"]) != expected:
            present = f"woundon {version}" if version else "no woundon"
            text = f"{name} has {present}; install version {expected} on all machines"
            raise InvalidProblem.at("scheduler", text)


def _with_version(work: Callable[[Item], Answer], item: Item) -> tuple[str, Answer]:
    """Return the version of the program at a worker, and the answer for an item."""
    return __version__, work(item)


# ---- the solved cases ---------------------------------------------------------------------------


@dataclass(frozen=True, eq=False, repr=False)
class Table(Presented):
    """The solved cases of a study.

    Attributes
    ----------
    cases : Cases
    outputs : mapping of str to (cases,) float array
        nan where the case failed.
    failure, warnings : (cases,) object arrays of str
    quantities : mapping of str to Quantity
        Of inputs and outputs; bodies, materials and words have none.
    record : mapping
        All that the results depend on: base problem, settings, version.
    """

    cases: Cases
    outputs: Mapping[str, Array]
    failure: Array
    warnings: Array
    quantities: Mapping[str, Quantity] = field(default_factory=dict)
    record: Mapping[str, Any] = field(default_factory=dict)

    @classmethod
    def of(
        cls,
        cases: Cases,
        outputs: Sequence[str],
        solved: Sequence[tuple[Chunk, Solved]],
        quantities: Mapping[str, Quantity],
        record: Mapping[str, Any],
    ) -> Table:
        """Return the table of solved chunks, which contain every case once."""
        values = np.empty((len(cases), len(outputs)))
        failure, warnings = (np.empty(len(cases), dtype=object) for _ in range(2))
        for chunk, results in solved:
            values[chunk.cases] = results.values
            failure[chunk.cases] = results.failure
            warnings[chunk.cases] = results.warnings
        columns = dict(zip(outputs, values.T.copy(), strict=True))
        return cls(cases, columns, failure, warnings, quantities, record)

    @property
    def failed(self) -> Array:
        """Numbers of the failed cases."""
        return np.nonzero(self.failure != "")[0]

    def check_any_solved(self) -> Table:
        """Return the table itself if a case was solved.

        Raises
        ------
        InvalidProblem, NotConverged
            If no case was solved, with the most frequent reasons; InvalidProblem if all cases were
            rejected before they were solved.
        """
        count = len(self.cases)
        if self.failed.size < count:
            return self
        reasons = failures(self.failure)
        others = count - sum(number for _, number in reasons)
        texts = [f"{number} x {reason}" for reason, number in reasons]
        texts += [f"{others} x others"] if others else []
        text = f"none of the {count} cases was solved: {'; '.join(texts)}"
        if all(reason.startswith(_REJECTIONS) for reason in self.failure):
            raise InvalidProblem.at("over", text)
        raise NotConverged(text, self.to_dataset())

    def to_dataframe(self) -> pd.DataFrame:
        """Return a row for each case: its number, inputs, outputs [SI], failure and warnings."""
        import pandas as pd

        inputs = {name: as_labels(v.to_numpy()) for name, v in self.cases.frame.items()}
        texts = {"failure": self.failure, "warnings": self.warnings}
        return pd.DataFrame({"case": np.arange(len(self.cases)), **inputs, **self.outputs, **texts})

    def __repr__(self) -> str:
        return (
            f"Table({len(self.cases)} cases of {', '.join(self.cases.names)}; "
            f"{', '.join(self.outputs)}; {self.failed.size} failed)"
        )

    def to_dataset(self) -> xarray.Dataset:
        """Return an xarray Dataset: a dimension for each axis of a grid, or ``case``.

        Inputs are coordinates.  Every variable has ``units``, ``long_name`` and ``symbol``; the
        attributes hold the base problem, the settings and the version.
        """
        import xarray

        cases, shape = self.cases, self.cases.shape
        dims = cases.names if cases.axes else ("case",)
        coordinates: dict[str, Any] = {
            name: (name if cases.axes else "case", as_labels(values), self._attributes(name))
            for name, values in cases.columns.items()
        }
        if not cases.axes:
            coordinates["case"] = np.arange(len(cases))
        variables: dict[str, Any] = {
            name: (dims, values.reshape(shape), self._attributes(name))
            for name, values in self.outputs.items()
        }
        for name, meaning in TEXTS.items():
            variables[name] = (dims, getattr(self, name).reshape(shape), {"long_name": meaning})
        record = {k: v if isinstance(v, str) else json.dumps(v) for k, v in self.record.items()}
        return xarray.Dataset(variables, coordinates, {"design": cases.design, **record})

    def _attributes(self, name: str) -> dict[str, str]:
        """Return unit, name and symbol of an input or output for xarray."""
        quantity = self.quantities.get(name)
        return quantity.attributes if quantity else {}

    def plot(self, output: str, path: str | PathLike[str] | None = None) -> Figure | Axes:
        """Draw one output over the inputs."""
        return self._figure(output, path)


def failures(reasons: Array) -> list[tuple[str, int]]:
    """Return the most frequent reasons of failure with their counts, ignoring numbers in them.

    >>> failures(np.array(["load 1 N", "load 2 N", ""], dtype=object))
    [('load 1 N', 2)]
    """
    kinds: dict[str, list[Any]] = {}
    for reason in reasons[reasons != ""]:
        kinds.setdefault(re.sub(r"[-+]?\d[\d.eE+-]*", "#", reason), []).append(reason)
    ranked = sorted(kinds.values(), key=len, reverse=True)
    return [(group[0], len(group)) for group in ranked[:MOST_REASONS]]
