"""What the tests share: a small study, run once."""

from __future__ import annotations

import atexit
import shutil
from functools import lru_cache
from pathlib import Path
from tempfile import mkdtemp

import seatrial

#: The repository, where the tests stand in it.
REPOSITORY = Path(__file__).resolve().parents[2]


@lru_cache
def folder() -> Path:
    """A folder that is removed at the end."""
    found = Path(mkdtemp(prefix="seatrial-python-"))
    atexit.register(shutil.rmtree, found, ignore_errors=True)
    return found


@lru_cache
def study() -> Path:
    """The hand-written files of a model ship."""
    found = folder() / "study"
    seatrial.run("new", found, vessel="model-ship")
    return found


@lru_cache
def results() -> Path:
    """The results of a few trials of it."""
    out = folder() / "results"
    seatrial.run("run", study(), out=out, set={"campaign.realizations": 8}, quiet=True)
    return out


@lru_cache
def model() -> Path:
    """A model of three of these trials."""
    out = folder() / "pooled"
    out.mkdir()
    runs = ["optimized/0", "optimized/1", "optimized/2"]
    vessel, campaign = study() / "vessel.toml", results() / "campaign.parquet"
    seatrial.run("estimate", fit="together", vessel=vessel, trajectories=campaign, runs=runs, out=f"{out}/", quiet=True)
    return out / "model.json"


@lru_cache
def covariances() -> Path:
    """The estimates of the trials again, with covariances."""
    out = folder() / "covariances"
    out.mkdir()
    vessel, campaign = study() / "vessel.toml", results() / "campaign.parquet"
    seatrial.run("estimate", vessel=vessel, trajectories=campaign, keep="covariance", out=f"{out}/", quiet=True)
    return out


@lru_cache
def coaster() -> Path:
    """The hand-written files of a coaster with standard maneuvers."""
    found = folder() / "coaster"
    seatrial.run("new", found, vessel="coaster")
    return found
