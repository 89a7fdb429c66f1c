"""Many independent jobs: here, in processes of this machine, or on a Dask cluster."""

from __future__ import annotations

import multiprocessing
import os
from concurrent.futures import ProcessPoolExecutor, as_completed
from concurrent.futures.process import BrokenProcessPool
from dataclasses import dataclass
from typing import Any, Callable, Iterable, Sequence, TypeVar

import cv2

from safe_passage.core.errors import InputError
from safe_passage.core.progress import Progress

CONNECT = 5.0  # [s] for a scheduler to answer
Job = TypeVar("Job")
Result = TypeVar("Result")


@dataclass(frozen=True)
class Workers:
    """Who does the jobs. With the defaults: this process."""

    processes: int = 1
    dask: str = ""  # address of a scheduler, such as tcp://host:8786; empty: none


def run_jobs(
    function: Callable[[Job], Result], jobs: Sequence[Job], workers: Workers, what: str
) -> list[Result]:
    """`function` of each job, in the jobs' order, whoever does them and whenever.

    Args:
        function: at a module's top level, so that other processes find it; what it returns must
            depend on its job alone.
        what: is done, for the progress that is shown.

    Raises:
        InputError: a worker was lost, or there is no such cluster. What a job raises is passed on.
    """
    progress = Progress(what, len(jobs))
    if workers.dask:
        return _on_cluster(function, jobs, workers.dask, progress)
    if workers.processes <= 1:
        results = []
        for job in jobs:
            results.append(function(job))
            progress.show(len(results))
        return results
    spawn = multiprocessing.get_context("spawn")  # drawing contexts do not survive a fork
    with ProcessPoolExecutor(workers.processes, spawn, use_one_core) as pool:
        futures = [pool.submit(function, job) for job in jobs]
        try:
            return _gathered(futures, as_completed(futures), progress)
        except BrokenProcessPool:
            raise InputError("a worker process died; was there memory for so many?") from None
        finally:
            for future in futures:
                future.cancel()


def batches(first: int, count: int, most: int = 100) -> list[range]:
    """The numbers from `first` on in pieces of like size: eight or more, of `most` at most."""
    size = min(most, max(1, -(-count // 8)))
    return [range(at, min(at + size, first + count)) for at in range(first, first + count, size)]


def use_one_core() -> None:
    """For a worker beside others: more threads than cores only get in each other's way."""
    os.environ["LP_NUM_THREADS"] = "1"  # Mesa's software drawing
    cv2.setNumThreads(1)


def _on_cluster(
    function: Callable[[Job], Result], jobs: Sequence[Job], address: str, progress: Progress
) -> list[Result]:
    try:
        from dask import distributed
    except ImportError:
        raise InputError("a cluster needs the python package distributed") from None
    try:
        client = distributed.Client(address, timeout=CONNECT)
    except (OSError, ValueError) as error:
        raise InputError(f"{address}: no Dask scheduler there ({error})") from None
    with client:
        threads = client.nthreads()
        if not threads or any(count != 1 for count in threads.values()):
            raise InputError(f"{address}: needs workers of one thread (dask worker --nthreads 1)")
        futures = client.map(function, jobs, pure=False)
        return _gathered(futures, distributed.as_completed(futures), progress)


def _gathered(futures: Sequence[Any], finished: Iterable[Any], progress: Progress) -> list[Any]:
    for done, future in enumerate(finished, 1):
        future.result()  # raises what the job raised, as soon as it did
        progress.show(done)
    return [future.result() for future in futures]
