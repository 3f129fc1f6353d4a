#!/usr/bin/python3
"""The peer of `tandem bench analysis`: the sixteen maps of Figs 5.1-5.4 in batched numpy.

Subsystem resampling of all 10^4 points at once, delay by augmentation with whole packets, the
translation eliminated exactly, numpy.linalg.eigvals on the batch. One thread. Prints JSON: seconds
and count of stable points for every map, and a boundary by bisection to several tolerances.
"""
import json
import os
import time

for name in ("OPENBLAS_NUM_THREADS", "OMP_NUM_THREADS", "MKL_NUM_THREADS"):
    os.environ[name] = "1"
import numpy as np  # noqa: E402

T, N = 1.0 / 1024.0, 8
MH, MO, B = 0.1, 0.4, 10.0
C = (np.arange(100) + 0.5)


def masses(ms, t):
    n = 2 * len(ms)
    a, b = np.eye(n), np.zeros((n, len(ms)))
    for i, m in enumerate(ms):
        a[2 * i, 2 * i + 1] = t
        b[2 * i, i], b[2 * i + 1, i] = t * t / (2 * m), t / m
    return a, b


def resample(a, b):
    power, total = np.broadcast_to(np.eye(a.shape[-1]), a.shape), np.zeros_like(a)
    for _ in range(N):
        total = total + power
        power = power @ a
    return power, total @ b


def radius(m, t):
    r = m[:, 1:, 1:] - t[None, 1:, None] * m[:, :1, 1:]
    return np.abs(np.linalg.eigvals(r)).max(axis=1)


def central(k1, k2, d):
    n = len(k1)
    a0, f = masses([MH, MO], T)
    state, held = np.zeros((n, 2, 4)), np.zeros((n, 2, 2))
    state[:, 0] = np.stack([-k1, -B + 0 * k1, k1, B + 0 * k1], -1)
    state[:, 1] = np.stack([k1, B + 0 * k1, -k1 - k2, -2 * B + 0 * k1], -1)
    held[:, 1] = np.stack([k2, B + 0 * k2], -1)
    a, b = resample(a0 + f @ state, f @ held)
    ar, br = masses([MH], N * T)
    size = 6 + 2 * d  # the object's state in flight
    m = np.zeros((n, size, size))
    m[:, :4, :4], m[:, :4, 4:6] = a, b
    own, other = np.zeros((n, 1, 2)), np.zeros((n, 1, 2))
    own[:, 0] = np.stack([-k2, -B + 0 * k2], -1)
    other[:, 0] = np.stack([k2, B + 0 * k2], -1)
    if d == 0:
        m[:, 4:6, 4:6] = ar + br @ own
        m[:, 4:6, 2:4] = br @ other
        t = np.array([1.0, 0, 1, 0, 1, 0])
    else:
        # The force as it was d periods ago: one number in flight, written as pairs with a zero.
        m[:, 4:6, 4:6] = ar
        m[:, 4:6, 6 + 2 * (d - 1)] = np.broadcast_to(br[:, 0], (n, 2))
        m[:, 6, 2], m[:, 6, 3], m[:, 6, 4], m[:, 6, 5] = k2, B, -k2, -B
        for i in range(1, d):
            m[:, 6 + 2 * i, 4 + 2 * i] = 1.0
        t = np.concatenate([[1.0, 0, 1, 0, 1, 0], np.zeros(2 * d)])
    return radius(m, t)


def distributed(k11, k12, ko, d):
    n = len(k11)
    one = np.full(n, B)
    a0, f = masses([MH, MO], T)
    state, held = np.zeros((n, 2, 4)), np.zeros((n, 2, 4))
    state[:, 0] = np.stack([-k11, -one, k11, one], -1)
    state[:, 1] = np.stack([k11, one, -k11 - k12 - ko, -3 * one], -1)
    held[:, 1] = np.stack([k12, one, ko, one], -1)
    a, b = resample(a0 + f @ state, f @ held)
    size = 8 + 4 * d
    m = np.zeros((n, size, size))
    m[:, :4, :4], m[:, 4:8, 4:8], m[:, :4, 4:8] = a, a, b
    if d == 0:
        m[:, 4:8, :4] = b
    else:
        m[:, 4:8, 8 + 4 * (d - 1):8 + 4 * d] = b
        m[:, 8:12, :4] = np.eye(4)
        for i in range(1, d):
            m[:, 8 + 4 * i:12 + 4 * i, 4 + 4 * i:8 + 4 * i] = np.eye(4)
    return radius(m, np.tile([1.0, 0.0], size // 2))


def line():
    """Fig 5.4, d = 1: the boundary in k12 of 100 columns by bisection, all columns at once."""
    ko, own = C * 60.0, np.full(100, 2000.0)
    runs = []
    for tolerance in (1e-2, 1e-4, 1e-6, 1e-9):
        start = time.process_time()
        low, high = np.full(100, 0.6), np.full(100, 6000.0)
        while ((high - low) > tolerance * low).any():
            middle = 0.5 * (low + high)
            stable = distributed(own, middle, ko, 1) < 1.0
            low, high = np.where(stable, middle, low), np.where(stable, high, middle)
        runs.append({"tolerance": tolerance, "seconds": time.process_time() - start,
                     "found": (0.5 * (low + high)).tolist()})
    return runs


def main():
    maps = {
        "fig5.1": (250.0, 40.0, lambda x, y, d: central(x, y, d)),
        "fig5.2": (60.0, 250.0, lambda x, y, d: distributed(y, x, np.full_like(x, 1000.0), d)),
        "fig5.3": (250.0, 60.0, lambda x, y, d: distributed(x, np.full_like(x, 300.0), y, d)),
        "fig5.4": (60.0, 60.0, lambda x, y, d: distributed(np.full_like(x, 2000.0), y, x, d)),
    }
    out = {"numpy": np.__version__, "maps": []}
    for figure, (dx, dy, f) in maps.items():
        x, y = [g.ravel() for g in np.meshgrid(C * dx, C * dy)]
        for d in range(4):
            f(x[:100], y[:100], d)
            start = time.process_time()
            stable = int((f(x, y, d) < 1.0).sum())
            out["maps"].append({"figure": figure, "d": d, "stable": stable,
                                "seconds": time.process_time() - start})
    out["line"] = line()
    print(json.dumps(out))


if __name__ == "__main__":
    main()
