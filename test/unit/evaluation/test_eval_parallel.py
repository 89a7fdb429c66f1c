"""Jobs: the same results whoever does them."""

import os
import sys
import types

import pytest
import safe_passage.evaluation.parallel as parallel
from eval_jobs import die, fail_at_three, square
from safe_passage.core.errors import InputError, ParameterError
from safe_passage.evaluation.parallel import Workers, batches, run_jobs


@pytest.mark.parametrize("processes", [1, 2, 3])
def test_results_are_in_the_order_of_jobs(processes):
    jobs = list(range(7))
    assert run_jobs(square, jobs, Workers(processes), "squares") == [n * n for n in jobs]


def test_no_jobs_no_results():
    assert run_jobs(square, [], Workers(), "nothing") == []


@pytest.mark.parametrize("processes", [1, 2])
def test_what_a_job_raises_is_passed_on(processes):
    with pytest.raises(ParameterError, match="three"):
        run_jobs(fail_at_three, list(range(6)), Workers(processes), "jobs")


def test_a_worker_that_dies_is_said():
    with pytest.raises(InputError, match="worker process died"):
        run_jobs(die, [1, 2], Workers(2), "jobs")


@pytest.mark.parametrize("count", [0, 1, 7, 8, 9, 250, 1000])
def test_batches_hold_every_number_once(count):
    parts = batches(500, count)
    assert [n for part in parts for n in part] == list(range(500, 500 + count))
    assert all(0 < len(part) <= 100 for part in parts)
    assert len(parts) >= min(count, 4)


class FakeFuture:
    def __init__(self, value):
        self._value = value

    def result(self):
        return self._value


class FakeClient:
    """A cluster of workers as `threads` says, that finishes its jobs in reverse order."""

    threads = types.MappingProxyType({"tcp://a": 1, "tcp://b": 1})

    def __init__(self, address, timeout):
        if address == "tcp://nowhere:1":
            raise OSError("connection refused")

    def __enter__(self):
        return self

    def __exit__(self, *args):
        return None

    def nthreads(self):
        return dict(self.threads)

    def map(self, function, jobs, pure):
        assert pure is False
        return [FakeFuture(function(job)) for job in jobs]


@pytest.fixture
def cluster(monkeypatch):
    distributed = types.ModuleType("dask.distributed")
    distributed.Client, distributed.as_completed = FakeClient, lambda futures: futures[::-1]
    package = types.ModuleType("dask")
    package.distributed = distributed
    monkeypatch.setitem(sys.modules, "dask", package)
    monkeypatch.setitem(sys.modules, "dask.distributed", distributed)


def test_a_cluster_does_the_same(cluster):
    assert run_jobs(square, [3, 1, 2], Workers(dask="tcp://host:8786"), "squares") == [9, 1, 4]


def test_no_cluster_there(cluster):
    with pytest.raises(InputError, match="tcp://nowhere:1: no Dask scheduler"):
        run_jobs(square, [1], Workers(dask="tcp://nowhere:1"), "squares")


@pytest.mark.parametrize("threads", [{}, {"tcp://a": 4}])
def test_workers_of_several_threads_are_refused(cluster, monkeypatch, threads):
    monkeypatch.setattr(FakeClient, "threads", threads)
    with pytest.raises(InputError, match="one thread"):
        run_jobs(square, [1], Workers(dask="tcp://host:8786"), "squares")


def test_without_dask_it_is_said(monkeypatch):
    monkeypatch.setitem(sys.modules, "dask", None)
    with pytest.raises(InputError, match="package distributed"):
        run_jobs(square, [1], Workers(dask="tcp://host:8786"), "squares")


def test_workers_keep_to_one_core(monkeypatch):
    before = parallel.cv2.getNumThreads()
    monkeypatch.setenv("LP_NUM_THREADS", "8")
    try:
        parallel.use_one_core()
        assert parallel.cv2.getNumThreads() == 1
        assert os.environ["LP_NUM_THREADS"] == "1"
    finally:
        parallel.cv2.setNumThreads(before)
