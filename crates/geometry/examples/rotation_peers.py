"""Measures scipy and Eigen on the references of the rotation table: worst error and time of the six conversions, as CSV.

By hand, where Python has numpy, scipy and mpmath, and a compiler finds Eigen 3:

    g++ -O3 -march=native -I /usr/include/eigen3 crates/geometry/examples/rotation_peers.cpp -o rotation_peers
    python crates/geometry/examples/rotation_peers.py ../shared/oracles/rotations.json ./rotation_peers \\
        > crates/geometry/examples/rotation_peers.csv

and then the table: `cargo run --release -p geometry --example rotation_table crates/geometry/examples/rotation_peers.csv`.
Errors are in ulp of the right result's Euclidean norm, the sign free for quaternions and at half-turns, as in the table.
Times are ns per rotation: scipy's of one call on 100000 random ones, the least of 20; Eigen's of single calls.
"""

import json
import math
import subprocess
import sys
import time

import mpmath
import numpy as np
import scipy
from scipy.spatial.transform import Rotation

mpmath.mp.dps = 60
REGIMES = ["near0", "mid", "nearpi", "random"]


def scalar_first(rotation):
    return np.atleast_2d(rotation.as_quat())[:, [3, 0, 1, 2]]


def from_quaternion(q):
    return Rotation.from_quat(np.asarray(q)[..., [1, 2, 3, 0]])


def from_matrix(m):
    return Rotation.from_matrix(np.asarray(m).reshape(-1, 3, 3))


# Name, key of the input, key of the answer, the call on an array of inputs.
CONVERSIONS = [
    ("w -> q", "w", "q", lambda w: scalar_first(Rotation.from_rotvec(w))),
    ("w -> M", "w", "M", lambda w: Rotation.from_rotvec(w).as_matrix()),
    ("q -> w", "q_in", "w_from_q", lambda q: from_quaternion(q).as_rotvec()),
    ("q -> M", "q_in", "M_from_q", lambda q: from_quaternion(q).as_matrix()),
    ("M -> q", "M_in", "q_from_M", lambda m: scalar_first(from_matrix(m))),
    ("M -> w", "M_in", "w_from_M", lambda m: from_matrix(m).as_rotvec()),
]


def error(got, want, free):
    """The largest component's error in ulp of the norm of the right result."""
    norm = float(mpmath.norm(mpmath.matrix(want), 2))
    signs = (1, -1) if free else (1,)
    return min(max(abs(float(mpmath.mpf(float(g)) - s * w)) for g, w in zip(got, want)) for s in signs) / math.ulp(norm)


def worst(cases, source, answer, call, part=slice(None)):
    """The worst error per regime, and of all."""
    found = dict.fromkeys(REGIMES + ["all"], 0.0)
    for case in cases:
        got = call(np.array([[float.fromhex(x) for x in case[source]]])).ravel()[part]
        want = [mpmath.mpf(x) for x in case[answer]][part]
        half_turn = len(case[answer]) == 3 and math.pi - float(mpmath.norm(mpmath.matrix(want), 2)) < 1e-15
        e = error(got, want, half_turn or len(case[answer]) == 4)
        for column in {case["regime"], "all"} & found.keys():
            found[column] = max(found[column], e)
    return [found[column] for column in REGIMES + ["all"]]


def nanoseconds(source, call):
    rng = np.random.default_rng(1)
    rotation = Rotation.random(100_000, random_state=1)
    inputs = {
        "w": rotation.as_rotvec() * rng.uniform(0.5, 1.0, (100_000, 1)),
        "q_in": scalar_first(rotation),
        "M_in": rotation.as_matrix(),
    }[source]

    def once():
        start = time.perf_counter()
        call(inputs)
        return time.perf_counter() - start

    return min(once() for _ in range(20)) * 1e9 / len(inputs)


class Eigen:
    """The compiled program: conversions by way of its standard input."""

    def __init__(self, program):
        self.process = subprocess.Popen([program], stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True)
        self.times = {}
        self.ask("time")
        for _ in CONVERSIONS:
            name, ns = self.process.stdout.readline().split()
            self.times[name] = float(ns)

    def ask(self, line):
        self.process.stdin.write(line + "\n")
        self.process.stdin.flush()

    def call(self, name, numbers):
        self.ask(name + " " + " ".join(float(x).hex() for x in numbers.ravel()))
        return np.array([float.fromhex(x) for x in self.process.stdout.readline().split()])


def rows(cases, by, calls, ns):
    """One library's lines."""
    for name, source, answer, _ in CONVERSIONS:
        figures = worst(cases, source, answer, calls[name])
        print(f"{name},{by}," + ",".join(f"{e:.4g}" for e in figures) + f",{ns(name, source):.1f}")
        if answer.startswith("q"):
            figures = worst(cases, source, answer, calls[name], slice(1, None))
            print(f"{name} vector part,{by}," + ",".join(f"{e:.4g}" for e in figures) + ",")


def main(path, program=None):
    with open(path) as file:
        cases = json.load(file)["so3"]["f64"]
    print("conversion,by,near0,mid,nearpi,random,all,ns")
    calls = {name: call for name, _, _, call in CONVERSIONS}
    rows(cases, f"scipy {scipy.__version__}", calls, lambda name, source: nanoseconds(source, calls[name]))
    if program:
        eigen = Eigen(program)
        short = {name: name.replace(" -> ", ">") for name in calls}
        through = {name: lambda x, name=name: eigen.call(short[name], x) for name in calls}
        rows(cases, "Eigen 3.4", through, lambda name, _: eigen.times[short[name]])


if __name__ == "__main__":
    main(*sys.argv[1:])
