"""Runs on the cores of this machine, or on a Dask cluster: each is handed over as it ends."""

import time
from collections.abc import Callable, Iterator, Sequence
from dataclasses import dataclass

import joblib

from benchmarks.engine.experiment import Figures, Run, Settings
from benchmarks.engine.provenance import fingerprint
from benchmarks.engine.run_store import StoredRun


class OtherCodeError(RuntimeError):
    """A worker has other code or libraries than the process that asks it."""


@dataclass(frozen=True)
class Job:
    """A run to be made.

    Attributes
    ----------
    function : `run` of an experiment.
    seed, settings : What it is called with.
    fingerprint : What it must be made with (see `benchmarks.engine.provenance`).
    """

    function: Callable[..., Figures]
    seed: int
    settings: Settings
    fingerprint: str

    def __call__(self) -> StoredRun:
        """Make the run.

        Raises
        ------
        OtherCodeError
            If this process would make another one.
        """
        if self.fingerprint != fingerprint(self.function.__module__):
            raise OtherCodeError(
                "a worker has other code or libraries than this process: start the workers from "
                "this checkout, with the same Python environment"
            )
        start = time.perf_counter()
        figures = self.function(self.seed, **self.settings)
        return StoredRun(Run(self.seed, self.settings, figures), time.perf_counter() - start)


def on_this_machine(jobs: Sequence[Job], processes: int) -> Iterator[StoredRun]:
    """Make runs on cores of this machine, and give each as it ends.

    Parameters
    ----------
    jobs : sequence of Job
        The runs.
    processes : int
        How many at once; -1 for as many as there are cores.
    """
    parallel = joblib.Parallel(n_jobs=processes, batch_size=1, return_as="generator_unordered")
    yield from parallel(joblib.delayed(_call)(job) for job in jobs)


def on_a_cluster(jobs: Sequence[Job], address: str) -> Iterator[StoredRun]:
    """Make runs on a running Dask cluster, and give each as it ends.

    Parameters
    ----------
    jobs : sequence of Job
        The runs.
    address : str
        Address of the scheduler, such as "tcp://10.0.0.1:8786". Its workers run this checkout.
    """
    from dask.distributed import Client, as_completed  # takes seconds, and few need it

    with Client(address) as client:
        futures = client.map(_call, jobs, pure=False)
        try:
            for _, stored in as_completed(futures, with_results=True):
                yield stored
        finally:
            client.cancel(futures)


def _call(job: Job) -> StoredRun:
    return job()
