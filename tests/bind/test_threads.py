"""Tests threads that share one object: no sample is lost, no result is wrong, and no thread blocks forever."""
import threading
import unittest

import numpy

import package  # noqa: F401, which finds the bindings
from toliman import Frame, Periodogram, StateError, Tracker

GRID = (0.01, 0.0005, 20000)
THREADS, SAMPLES = 4, 150


def in_threads(work):
    raised = []

    def run(number):
        try:
            work(number)
        except BaseException as error:  # noqa: B902
            raised.append(error)

    threads = [threading.Thread(target=run, args=(number,)) for number in range(THREADS)]
    for thread in threads:
        thread.start()
    for thread in threads:
        thread.join(60)
    if any(thread.is_alive() for thread in threads):
        raise AssertionError("a thread is blocked")
    if raised:
        raise raised[0]


class Threads(unittest.TestCase):
    # promise: calls-need-exclusive-use
    def test_pushes_equal_those_of_one_thread(self):
        t = numpy.arange(THREADS * SAMPLES, dtype=float)
        y = numpy.sin(t)
        for _ in range(6):
            with Periodogram(*GRID) as shared, Periodogram(*GRID) as alone:
                def push(number, shared=shared):
                    for k in range(number, len(t), THREADS):
                        shared.push(t[k], y[k])
                        if k % 40 == 0:
                            self.assertGreater(shared.info.count, 0)

                in_threads(push)
                alone.push_many(t, y)
                self.assertEqual(shared.info.count, len(t))
                self.assertEqual(shared.to_bytes(), alone.to_bytes())

    def test_mutual_merges_do_not_deadlock(self):
        with Periodogram(0.1, 0.1, 2000) as a, Periodogram(0.1, 0.1, 2000) as b:
            def merge(number):
                for _ in range(10):
                    (a if number % 2 else b).merge(b if number % 2 else a)

            in_threads(merge)

    def test_callbacks_cannot_use_the_object_in_use(self):
        seen = []

        def estimate(image):
            for ask in (lambda: tracker.info, lambda: tracker.period.info):
                with self.assertRaises(StateError) as caught:
                    ask()
                seen.append(caught.exception.field)
            return float(image[0, 0])

        tracker = Tracker(estimate, 0.1, 0.1, 5, sigma=1, rows=4, cols=4, allow_zero_runs=True, estimator_id=1, threads=2)
        frames = [Frame(numpy.full((4, 4), k + 1, numpy.uint16), k, k * 10**9) for k in range(4)]
        outcomes = tracker.push_many(frames)
        self.assertEqual([outcome.verdict for outcome in outcomes], ["accepted"] * 4)
        self.assertEqual(len(seen), 8)
        self.assertEqual(tracker.info.accepted, 4)


if __name__ == "__main__":
    unittest.main()
