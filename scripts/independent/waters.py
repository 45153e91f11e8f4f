"""Distances from land and shoals on the plane of a planned trial, measured apart from the planner."""

from __future__ import annotations

import json
import math
from pathlib import Path
from typing import Any

import numpy as np
from scipy.ndimage import distance_transform_edt
from scipy.spatial import cKDTree

from .voyage import Voyage


class Plane:
    """Longitude and latitude as north and east: the track says how, to second order."""

    def __init__(self, voyage: Voyage) -> None:
        track = voyage.track
        self.longitude, self.latitude = float(np.mean(track["longitude"])), float(np.mean(track["latitude"]))
        places = np.column_stack([track["x"], track["y"]])
        self.fit, *_ = np.linalg.lstsq(self.rows(track["longitude"], track["latitude"]), places, rcond=None)

    def rows(self, longitude: np.ndarray, latitude: np.ndarray) -> np.ndarray:
        a, b = (longitude - self.longitude) * 20.0, (latitude - self.latitude) * 20.0
        return np.column_stack([np.ones_like(a), a, b, a * a, a * b, b * b])

    def flat(self, ring: np.ndarray) -> np.ndarray:
        return self.rows(ring[:, 0], ring[:, 1]) @ self.fit


class Land:
    """Distances from land, on the plane of a voyage's track."""

    SPACING_M, CELL_M, SIGHT_M, BEYOND_M, EXACT_M = 2.0, 10.0, 550.0, 1500.0, 300.0

    def __init__(self, voyage: Voyage, files: list[Path]) -> None:
        plane = Plane(voyage)
        rings = [plane.flat(np.array(ring)) for file in files for ring in rings_of(json.loads(file.read_text()))]
        low = np.array([min(voyage.track["x"]), min(voyage.track["y"])]) - self.BEYOND_M
        high = np.array([max(voyage.track["x"]), max(voyage.track["y"])]) + self.BEYOND_M
        self.low, self.shape = low, tuple(np.ceil((high - low) / self.CELL_M).astype(int))
        points = np.concatenate([densified(ring, self.SPACING_M, low - 600.0, high + 600.0) for ring in rings])
        self.tree = cKDTree(points)
        centres = np.stack(np.meshgrid(*(low[k] + self.CELL_M * (np.arange(self.shape[k]) + 0.5) for k in (0, 1)), indexing="ij"), -1)
        far, _ = self.tree.query(centres.reshape(-1, 2), distance_upper_bound=self.SIGHT_M)
        self.far = np.minimum(far, self.SIGHT_M).reshape(self.shape)
        self.far[self.inside(rings, centres)] = 0.0

    def inside(self, rings: list[np.ndarray], centres: np.ndarray) -> np.ndarray:
        """Cells within an odd number of rings."""
        odd = np.zeros(self.shape, dtype=bool)
        norths, easts = centres[:, 0, 0], centres[0, :, 1]
        for ring in rings:
            for (n0, e0), (n1, e1) in zip(ring, np.roll(ring, -1, axis=0)):
                rows = np.flatnonzero((norths >= min(n0, n1)) & (norths < max(n0, n1)))
                if len(rows) and max(e0, e1) > easts[0]:
                    cross = e0 + (norths[rows] - n0) / (n1 - n0) * (e1 - e0)
                    odd[rows] ^= easts[None, :] < cross[:, None]
                elif len(rows):
                    continue
        return odd

    def clearance(self, pose: np.ndarray, outline: np.ndarray) -> np.ndarray:
        """The distance of the hull's outline from land, per vessel: exact within `EXACT_M`, beyond it less by up to the hull and a
        cell's diagonal."""
        cells = np.clip(((pose[:2].T - self.low) / self.CELL_M).astype(int), 0, np.array(self.shape) - 1)
        coarse = self.far[cells[:, 0], cells[:, 1]]
        own = coarse - float(np.hypot(*outline.T).max()) - self.CELL_M
        near = np.flatnonzero(own < self.EXACT_M)
        if len(near):
            exact, _ = self.tree.query(placed(pose[:, near], outline), distance_upper_bound=self.SIGHT_M)
            own[near] = np.where(coarse[near] == 0.0, 0.0, np.minimum(exact.min(axis=1), self.SIGHT_M))
        return own


class Depths:
    """Distances from what is too shoal in charts of depth areas and land, on the plane of a voyage's track, by a raster."""

    CELL_M, SIGHT_M, BEYOND_M = 2.0, 400.0, 500.0
    RASTER_M = CELL_M

    def __init__(self, voyage: Voyage, charts: list[tuple[Path, dict[str, Any]]], depth: float) -> None:
        self.lay(voyage)
        shape, plane = self.shape, Plane(voyage)
        deep, closed = np.zeros(shape, dtype=bool), np.zeros(shape, dtype=bool)
        for file, chart in charts:
            only = chart.get("only")
            for feature in json.loads(file.read_text())["features"]:
                own = feature["properties"]
                if only and own.get(only["property"]) not in only["values"]:
                    continue
                rings = [plane.flat(np.array(ring)) for ring in rings_of(feature)]
                least = own.get(chart.get("least", "DRVAL1"))
                shoal = chart["kind"] != "depth" or least in (None, "") or float(least) < depth
                self.fill(rings, closed if shoal else deep)
        self.far = np.minimum(distance_transform_edt(deep & ~closed) * self.CELL_M, self.SIGHT_M)

    def lay(self, voyage: Voyage) -> None:
        """Lays the raster around a track."""
        low = np.array([min(voyage.track["x"]), min(voyage.track["y"])]) - self.BEYOND_M
        high = np.array([max(voyage.track["x"]), max(voyage.track["y"])]) + self.BEYOND_M
        self.low, self.shape = low, tuple(np.ceil((high - low) / self.CELL_M).astype(int))

    def fill(self, rings: list[np.ndarray], onto: np.ndarray) -> None:
        """Sets the cells whose centres are within an odd number of rings."""
        shape, cells = onto.shape, [(ring - self.low) / self.CELL_M - 0.5 for ring in rings]
        every = np.concatenate(cells)
        low = np.clip(np.ceil(every.min(axis=0)).astype(int), 0, shape)
        high = np.clip(np.ceil(every.max(axis=0)).astype(int), 0, shape)
        if (low >= high).any():
            return
        odd = np.zeros(tuple(high - low), dtype=bool)
        for ring in cells:
            after = np.roll(ring, -1, axis=0)
            first = np.maximum(np.ceil(np.minimum(ring[:, 0], after[:, 0])).astype(int), low[0])
            last = np.minimum(np.ceil(np.maximum(ring[:, 0], after[:, 0])).astype(int), high[0])
            for k in np.flatnonzero(first < last):
                rows = np.arange(first[k], last[k])
                cross = ring[k, 1] + (rows - ring[k, 0]) / (after[k, 0] - ring[k, 0]) * (after[k, 1] - ring[k, 1])
                ends = np.clip(np.ceil(cross).astype(int) - low[1], 0, odd.shape[1])
                for row, end in zip(rows - low[0], ends):
                    odd[row, :end] ^= True
        onto[low[0] : high[0], low[1] : high[1]] |= odd

    def clearance(self, pose: np.ndarray, outline: np.ndarray) -> np.ndarray:
        """The distance of the hull's outline from what is too shoal, per vessel, to a cell's diagonal."""
        cells = ((placed(pose, outline) - self.low) / self.CELL_M).astype(int)
        cells = np.clip(cells, 0, np.array(self.far.shape) - 1)
        return self.far[cells[..., 0], cells[..., 1]].min(axis=1)


def placed(pose: np.ndarray, outline: np.ndarray) -> np.ndarray:
    """The points of a hull's outline on the plane: vessels × points × (north, east)."""
    sin, cos = np.sin(pose[2])[:, None], np.cos(pose[2])[:, None]
    return np.stack([
        pose[0][:, None] + outline[:, 0] * cos - outline[:, 1] * sin,
        pose[1][:, None] + outline[:, 0] * sin + outline[:, 1] * cos,
    ], -1)


def densified(ring: np.ndarray, spacing: float, low: np.ndarray, high: np.ndarray, closed: bool = True) -> np.ndarray:
    """Points along a ring's edges within a box, or along an open line's."""
    points = [np.empty((0, 2))] if closed else [ring[-1:]]
    edges = list(zip(ring, np.roll(ring, -1, axis=0)))
    for a, b in edges if closed else edges[:-1]:
        if (np.maximum(a, b) >= low).all() and (np.minimum(a, b) <= high).all():
            count = max(int(math.ceil(np.hypot(*(b - a)) / spacing)), 1)
            points.append(a + (b - a) * (np.arange(count) / count)[:, None])
    return np.concatenate(points)


def rings_of(document: dict[str, Any]) -> list[Any]:
    if document["type"] == "FeatureCollection":
        return [ring for feature in document["features"] for ring in rings_of(feature["geometry"])]
    if document["type"] == "Feature":
        return rings_of(document["geometry"])
    if document["type"] == "Polygon":
        return document["coordinates"]
    return [ring for polygon in document["coordinates"] for ring in polygon]
