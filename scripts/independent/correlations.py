"""Independent computation of correlations of errors within windows, for the `oracle_*` tests of `validation`.

    python scripts/independent/correlations.py --out fixtures/oracle/correlations.json

Needs numpy. All windows stand in one long row with gaps of zeros between them that are longer than any lag, so that one
call of `numpy.correlate` over the whole row has no pairs across windows.
"""

from __future__ import annotations

import argparse
import json
from pathlib import Path

import numpy as np


def row(windows: list[np.ndarray], gap: int) -> np.ndarray:
    """The windows without their common mean, behind each other with gaps of zeros."""
    mean = np.concatenate(windows).mean()
    return np.concatenate([np.concatenate([window - mean, np.zeros(gap)]) for window in windows])


def case(errors: list[np.ndarray], inputs: list[np.ndarray], lags: int) -> dict:
    most = min(lags, max(map(len, errors)) - 1)
    e, x = row(errors, lags + 1), row(inputs, lags + 1)
    middle = len(e) - 1
    own = np.correlate(e, e, mode="full") / (e @ e)
    crossed = np.correlate(e, x, mode="full") / np.sqrt((e @ e) * (x @ x))
    return {
        "errors": [window.tolist() for window in errors],
        "inputs": [window.tolist() for window in inputs],
        "lags": lags,
        "own": own[middle + 1 : middle + 1 + most].tolist(),
        "crossed": crossed[middle - most : middle + most + 1].tolist(),
    }


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--out", type=Path, required=True, help="file to write")
    out = parser.parse_args().out
    random = np.random.default_rng(13)
    cases = []
    for lengths, lags in [([30], 8), ([25, 7, 40], 12), ([3, 4], 10)]:
        inputs = [np.round(np.cumsum(random.standard_normal(n)), 6) for n in lengths]
        errors = [np.round(0.4 * x + random.standard_normal(len(x)) + 0.7, 6) for x in inputs]
        cases.append(case(errors, inputs, lags))
    out.write_text(json.dumps({"cases": cases}, indent=1) + "\n")


if __name__ == "__main__":
    main()
