"""Covariances of single estimates by regression, for the tests `oracle_*` of `estimate --covariance`.

    python scripts/independent/covariances.py --study pipelines/paper --out fixtures/oracle/covariances.json

Of the first runs of fixtures/oracle/runs.parquet, with the mean removed over the whole run: A⁻¹ ζᵀ Γ ζ A⁻ᵀ of each degree of
freedom, with explicit matrices. Needs numpy and scipy.
"""

from __future__ import annotations

import argparse
import sys
from pathlib import Path

sys.dont_write_bytecode = True
sys.path.insert(0, str(Path(__file__).resolve().parent.parent))

from independent.estimate import estimate  # noqa: E402
from independent.runs import draw_runs  # noqa: E402
from independent.study import read_study  # noqa: E402
from independent.text import pretty  # noqa: E402

RUNS = 4


def main() -> None:
    parser = argparse.ArgumentParser(description=(__doc__ or "").splitlines()[0])
    parser.add_argument("--study", type=Path, required=True, help="folder with vessel, dictionary and campaign")
    parser.add_argument("--out", type=Path, required=True, help="file to write")
    given = parser.parse_args()
    study = read_study(given.study)
    runs = draw_runs(study, RUNS)
    found = {
        estimator: [
            [block.ravel().tolist() for block in estimate(study.vessel, run, estimator, "complete").covariance] for run in runs
        ]
        for estimator in ("iv", "ls")
    }
    document = {
        "conventions": "estimator, run, degree of freedom: p × p, row-major, in the order of the vessel's parameters",
        **found,
    }
    given.out.write_text(pretty(document) + "\n")


if __name__ == "__main__":
    main()
