"""One side of a comparison in Python; contender.hpp describes the protocol."""

import json
import statistics
import sys
import time

import numpy


def read_boxes(path):
    """Boxes of a .npy or .csv file as float64, without degenerate ones."""
    boxes = numpy.load(path) if path.endswith(".npy") else numpy.loadtxt(path, delimiter=",", skiprows=1)
    boxes = boxes.astype(float)
    return boxes[(boxes[:, 3:] > boxes[:, :3]).all(axis=1)]


TURN = 0.25  # kTurn of bench/timing.hpp


def contend(version, compute, describe):
    """Answers every line of standard input. compute() is timed, describe(result) is not."""

    def say(line):
        print(json.dumps(line), flush=True)

    say({"version": version})
    for _ in sys.stdin:
        try:
            seconds = []
            while sum(seconds) < TURN:
                result = None
                start = time.perf_counter()
                result = compute()
                seconds.append(time.perf_counter() - start)
            answer = describe(result)
            result = None  # now, so that it does not take the other side's time
            say({"seconds": statistics.median(seconds), "answer": answer})
        except Exception as error:  # whatever a rival throws is its answer
            say({"error": f"{type(error).__name__}: {error}"})
