"""Kernels on several threads: every element once, the same bits for any number,
errors and interrupts passed on.
"""

import multiprocessing
import os
import signal
import threading
import time
from types import SimpleNamespace

import numpy as np
import pytest
import scipy.linalg  # its BLAS is another one than numpy's
from numba import njit
from small_scenes import STEADY
from threadpoolctl import ThreadpoolController, threadpool_limits

from contbed.compiled import blas, threads
from contbed.errors import SceneError
from contbed.loading import loads


@njit(nogil=True)
def count_up(begin, end, out):
    for k in range(begin, end):
        out[k] += k


@pytest.mark.parametrize("n", [0, 1, 63, 64, 1000, 10_001])
@pytest.mark.parametrize("number", [1, 2, 3, 7])
def test_every_element_once(n, number):
    out = np.zeros(n)
    with threads.using(number):
        threads.parallel(count_up, n, out, least=1)
    assert (out == np.arange(n)).all()


@njit(nogil=True)
def spread(begin, end, place, x, out):
    for k in range(begin, end):
        out[0, place[k]] += x[k]
        out[1, place[k]] -= x[k]


@pytest.mark.parametrize("n", [0, 5, 999, 20_003])
def test_scattered_sums_do_not_depend_on_the_number_of_threads(n):
    """Round-off beside NumPy's sum, which has another order; parts of 100 elements
    are at most SCATTERED.
    """
    rng = np.random.default_rng(1)
    place, x, found = rng.integers(7, size=n), rng.normal(size=n), []
    for number in (1, 2, 5):
        with threads.using(number):
            found.append(threads.scattered(spread, n, (2, 7), place, x, least=100))
    assert found[0].tobytes() == found[1].tobytes() == found[2].tobytes()
    assert found[0][0] == pytest.approx(np.bincount(place, x, 7), rel=1e-12, abs=1e-12)
    assert (found[0][1] == -found[0][0]).all()


def test_calls_run_at_the_same_time():
    """Each waits for the other, which calls one after the other would do for ever."""
    meet = threading.Barrier(2, timeout=60.0)
    assert threads.together([(meet.wait, ()), (meet.wait, ())]) in ([0, 1], [1, 0])


def test_calls_within_calls_are_made_one_after_the_other():
    def outer(k):
        return threads.together([(int, (10 * k,)), (int, (10 * k + 1,))])

    assert threads.together([(outer, (0,)), (outer, (1,))]) == [[0, 1], [10, 11]]


def test_an_error_comes_after_all_have_ended():
    ended = []

    def fails():
        raise ValueError("the second")

    def slow():
        time.sleep(0.05)
        ended.append(True)

    with pytest.raises(ValueError, match="the second"):
        threads.together([(int, (1,)), (fails, ()), (slow, ())])
    assert ended
    assert threads.together([(int, (1,)), (int, (2,)), (int, (3,))]) == [1, 2, 3]


def test_an_interrupt_waits_for_all_parts():
    ended = []

    def slow():
        time.sleep(0.3)
        ended.append(True)

    before = signal.signal(signal.SIGINT, signal.default_int_handler)
    timer = threading.Timer(0.05, os.kill, (os.getpid(), signal.SIGINT))
    try:
        timer.start()
        with pytest.raises(KeyboardInterrupt):
            threads.together([(slow, ()), (slow, ())])
    finally:
        timer.join()
        signal.signal(signal.SIGINT, before)
    assert len(ended) == 2


def test_number_of_threads(monkeypatch):
    monkeypatch.setenv("OMP_NUM_THREADS", "1")
    assert threads.available() == threads.count() == 1
    monkeypatch.setenv("OMP_NUM_THREADS", "")
    monkeypatch.delenv("NUMBA_NUM_THREADS", raising=False)
    assert threads.available() == len(os.sched_getaffinity(0))
    with threads.using(4):
        assert threads.count() == 4
        assert [threads.count(n, 100) for n in (0, 199, 200, 10**6)] == [1, 1, 2, 4]
        with threads.using(None):
            assert threads.count() == 4
    assert threads.count() == threads.available()
    with pytest.raises(SceneError, match="at least 1 is needed"), threads.using(0):
        pass


@pytest.fixture
def four_cores(monkeypatch):
    monkeypatch.setattr(threads, "available", lambda: 4)


def test_runs_in_several_threads_have_their_own_number(four_cores):
    """Blocks that overlap in time do not leave their number behind."""
    within, found = threading.Barrier(2, timeout=60.0), []

    def run(number):
        with threads.using(number):
            within.wait()
            found.append(threads.count() == number)
        within.wait()
        found.append(threads.count() == 4)

    both = [threading.Thread(target=run, args=(number,)) for number in (1, 3)]
    for one in both:
        one.start()
    for one in both:
        one.join()
    assert found == 4 * [True]


def _in_child(queue):
    queue.put(threads.together([(int, (1,)), (int, (2,))]))


@pytest.mark.skipif(not hasattr(os, "fork"), reason="processes are not forked here")
@pytest.mark.filterwarnings("ignore:.*fork.*:DeprecationWarning")
def test_a_forked_process_starts_threads_of_its_own():
    threads.together([(int, (1,)), (int, (2,))])
    context = multiprocessing.get_context("fork")
    queue = context.SimpleQueue()
    process = context.Process(target=_in_child, args=(queue,))
    process.start()
    process.join(60.0)
    assert process.exitcode == 0
    assert queue.get() == [1, 2]


def test_a_run_is_allowed_its_threads(monkeypatch):
    from contbed import runner

    seen = []
    monkeypatch.setattr(runner, "_run", lambda *_: seen.append(threads.count()))
    runner.run(SimpleNamespace(kind="packed_bed"), threads=3)
    assert seen == [3]


def threads_of_blas():
    return [
        library["num_threads"]
        for library in ThreadpoolController().info()
        if library["user_api"] == "blas"
    ]


@pytest.fixture
def several_for_blas(monkeypatch):
    """Both libraries compute on two threads, as they do by default on two cores;
    others that are loaded may on one.
    """
    for name in blas.VARIABLES:
        monkeypatch.delenv(name, raising=False)
    with threadpool_limits(2, "blas"):
        assert scipy.linalg.lapack.dgbtrf is not None
        before = threads_of_blas()
        assert 2 in before
        yield before
        assert threads_of_blas() == before


def test_blas_computes_on_one_thread_in_a_block(several_for_blas):
    with pytest.raises(RuntimeError, match="stops"), blas.single_blas():
        assert set(threads_of_blas()) == {1}
        raise RuntimeError("stops")
    assert threads_of_blas() == several_for_blas


def test_what_the_environment_says_of_blas_stays(several_for_blas, monkeypatch):
    monkeypatch.setenv("OPENBLAS_NUM_THREADS", "2")
    with blas.single_blas():
        assert threads_of_blas() == several_for_blas


def test_runs_and_gradients_take_one_thread_of_blas(several_for_blas, monkeypatch):
    seen = []

    def watched(place):
        function = getattr(*place)

        def counted(*arguments, **options):
            seen.append(set(threads_of_blas()))
            return function(*arguments, **options)

        monkeypatch.setattr(*place, counted)

    from contbed.many.derivatives import tangent
    from contbed.many.derivatives.gradients import gradient
    from contbed.packed_bed import run

    watched((run, "run"))
    watched((tangent, "slope"))
    scene = loads(STEADY)
    gradient(scene, ["T_fluid_out_K"], ["packed_bed.porosity"])
    assert seen == [{1}] * 2
