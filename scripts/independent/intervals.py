"""Independent computation of 95 % intervals of shares and quantiles, for the `oracle_*` tests of `numerics`.

    python scripts/independent/intervals.py --out fixtures/oracle/intervals.json

Needs no package. Wilson's limits are found by bisection as the shares that a score test just does
not reject; the ranks of quantiles by exact rational sums over the binomial distribution.
"""

from __future__ import annotations

import argparse
import json
import math
import statistics
from fractions import Fraction
from pathlib import Path

Z = statistics.NormalDist().inv_cdf(0.975)
SHARES = [(0, 10), (1, 10), (5, 10), (10, 10), (1, 1), (49, 96), (96, 96), (4930, 5000), (3, 5000)]
QUANTILES = [(n, q) for n in (1, 5, 6, 8, 20, 96, 100, 500, 1000) for q in ("1/10", "1/2", "9/10", "99/100")]


def rejected(count: int, total: int, share: float) -> bool:
    """Whether a score test at 5 % rejects `share` after `count` successes in `total` trials."""
    return abs(count / total - share) > Z * math.sqrt(share * (1 - share) / total)


def limit(count: int, total: int, end: float) -> float:
    """The share farthest towards `end` that is not rejected."""
    kept = count / total
    if not rejected(count, total, end):
        return end
    for _ in range(200):
        middle = (kept + end) / 2
        if rejected(count, total, middle):
            end = middle
        else:
            kept = middle
    return kept


def ranks(n: int, q: Fraction) -> list[int | None]:
    """Ranks (from 1) of the values that enclose the quantile `q`, each end missing it with at most 2.5 %."""
    tail = Fraction(1, 40)
    masses = [math.comb(n, k) * q**k * (1 - q) ** (n - k) for k in range(n + 1)]
    # The value of rank l exceeds the quantile with the probability that fewer than l values lie below it.
    below = [sum(masses[:l], Fraction(0)) for l in range(n + 2)]
    low = max((l for l in range(1, n + 1) if below[l] <= tail), default=None)
    high = min((u for u in range(1, n + 1) if 1 - below[u] <= tail), default=None)
    return [low, high]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--out", type=Path, required=True, help="file to write")
    out: Path = parser.parse_args().out
    document = {
        "shares": [
            {"count": c, "total": t, "interval": [limit(c, t, 0.0), limit(c, t, 1.0)]} for c, t in SHARES
        ],
        "quantiles": [
            {"values": n, "quantile": float(Fraction(q)), "ranks": ranks(n, Fraction(q))} for n, q in QUANTILES
        ],
    }
    out.write_text(json.dumps(document, indent=1) + "\n")


if __name__ == "__main__":
    main()
