"""What needs pandas, polars, pyarrow and matplotlib."""

from __future__ import annotations

import json
import unittest
from importlib.util import find_spec

import seatrial

from .study import REPOSITORY, covariances, folder, model, results, study

MISSING = [name for name in ("pyarrow", "pandas", "polars", "matplotlib") if find_spec(name) is None]


def line(*places: tuple[float, float]) -> dict[str, list[float]]:
    """A line of a map."""
    return {"east_m": [east for east, _ in places], "north_m": [north for _, north in places]}


RASTER = {"west_m": 0.0, "south_m": 0.0, "cell_m": 10.0, "columns": 4, "rows": 2}
SQUARE = line((0, 0), (100, 0), (100, 100), (0, 100))
MAP = {
    "schema": "map/1",
    "producer": "plan 0.2.0",
    "seal": None,
    "inputs": {},
    "settings": {},
    "units": {"east_m": "m"},
    "data": {
        "safe": True,
        "statement": "a plan in words",
        "counts": {"turn": 1},
        "longitude_deg": 25.0,
        "latitude_deg": 60.0,
        "frame": {"west_m": -100.0, "south_m": -100.0, "east_m": 900.0, "north_m": 700.0},
        "uncharted_is_water": True,
        "depth_limits_m": [5.0],
        "cells": None,
        "areas": [{"class": "land", "rings": [SQUARE, line((10, 10), (20, 10), (20, 20))]}],
        "contours": [{"depth_m": 5.0, "line": line((0, 200), (300, 250))}],
        "margins": [],
        "spots": [],
        "names": [],
        "swept": {"vessels": 3, "raster": RASTER, "runs": [2, 1, 5]},
        "corridors": [line((200, 200), (300, 200), (300, 300))],
        "speed_limits": [],
        "tracks": [
            {"kind": "basic", "line": line((200, 200), (250, 250))},
            {"kind": "maneuver", "maneuver": "turn", "number": 1, "line": line((250, 250), (400, 260))},
        ],
        "hulls": [],
        "start": {"east_m": 200.0, "north_m": 200.0},
        "goal": {"east_m": 400.0, "north_m": 260.0},
        "meridians": [],
        "parallels": [],
    },
}


@unittest.skipIf(MISSING, f"found no {', '.join(MISSING)}")
class Frames(unittest.TestCase):
    def test_every_frame_has_the_same_values(self) -> None:
        path = results() / "campaign.parquet"
        arrow = seatrial.read(path, "arrow")
        pandas, polars = seatrial.read(path, "pandas"), seatrial.read(path, "polars")
        self.assertEqual(pandas.shape, arrow.shape)
        self.assertEqual(polars.shape, arrow.shape)
        for name in ("design", "run", "u", "t"):
            expected = arrow.column(name).to_pylist()
            self.assertEqual(pandas[name].tolist(), expected)
            self.assertEqual(polars[name].to_list(), expected)

    def test_units_stand_in_the_file_as_metadata_of_arrow(self) -> None:
        from pyarrow import parquet

        for path in results().glob("*.parquet"):
            schema, known = parquet.read_schema(path), seatrial.units(path)
            self.assertEqual({own.name: own.metadata[b"unit"].decode() for own in schema}, known)
            self.assertIn(b"seatrial", parquet.read_metadata(path).metadata)
            self.assertIn(b"seatrial", seatrial.read(path, "arrow").schema.metadata)

    def test_units_come_with_frames(self) -> None:
        path = results() / "estimates.parquet"
        known = seatrial.units(path)
        self.assertEqual(seatrial.read(path, "pandas").attrs["units"], known)
        self.assertEqual(seatrial.read(path, "pandas", ["run", "X_u"]).attrs["units"], {"run": "1", "X_u": known["X_u"]})
        self.assertEqual(seatrial.read(path, "arrow").schema.field("X_u").metadata, {b"unit": known["X_u"].encode()})

    @unittest.skipUnless((REPOSITORY / "fixtures").is_dir(), "not in the repository")
    def test_units_of_tables_of_older_releases_come_with_frames(self) -> None:
        table = seatrial.read(REPOSITORY / "fixtures" / "schema" / "trajectories-1.parquet", "arrow")
        self.assertEqual(table.schema.field("u").metadata[b"unit"], b"m/s")

    def test_covariances_are_lists_of_fixed_size(self) -> None:
        import polars
        import pyarrow

        path = covariances() / "covariances.parquet"
        errors = seatrial.read(covariances() / "estimates.parquet", "pandas")
        arrow, pandas, table = (seatrial.read(path, frame) for frame in ("arrow", "pandas", "polars"))
        names = pandas.attrs["parameters"]
        self.assertEqual(names, list(seatrial.Model.load(study() / "vessel.toml").parameters))
        self.assertEqual(arrow.schema.field("covariance").type, pyarrow.list_(pyarrow.float64(), len(names) ** 2))
        self.assertEqual(table.schema["covariance"], polars.Array(polars.Float64, len(names) ** 2))
        self.assertEqual(table["covariance"].to_list(), arrow.column("covariance").to_pylist())
        self.assertEqual(len(pandas), len(errors))
        for row, matrix in zip(errors.itertuples(), pandas.covariance):
            for i, name in enumerate(names):
                square = getattr(row, f"{name}_se") ** 2
                self.assertAlmostEqual(matrix[i * len(names) + i] / square, 1.0, places=9)
                for j in range(len(names)):
                    self.assertEqual(matrix[i * len(names) + j], matrix[j * len(names) + i])
        pair = seatrial.read(path, "pandas", ["run", "X_u X_uu"])
        self.assertEqual(pair["X_u X_uu"].tolist(), [matrix[1] for matrix in pandas.covariance])

    def test_a_column_that_is_not_there_is_refused(self) -> None:
        with self.assertRaisesRegex(seatrial.Refused, "columns: found design, .*, expected also speed"):
            seatrial.read(results() / "scores.parquet", "pandas", ["speed"])

    def test_a_table_that_cannot_be_decoded_is_refused(self) -> None:
        written = bytearray((results() / "scores.parquet").read_bytes())
        written[4:300] = bytes(296)
        path = folder() / "damaged.parquet"
        path.write_bytes(written)
        for frame in ("pandas", "polars", "arrow"):
            with self.subTest(frame=frame), self.assertRaisesRegex(seatrial.Refused, "contents: found "):
                seatrial.read(path, frame)


@unittest.skipIf(MISSING, f"found no {', '.join(MISSING)}")
class Simulated(unittest.TestCase):
    def test_oracle_a_model_simulates_what_the_stage_wrote(self) -> None:
        ship = seatrial.Model.load(study() / "vessel.toml")
        for frame in ("pandas", "polars", "arrow"):
            rows = seatrial.read(results() / "validation.parquet", frame)
            written = [list(map(float, seatrial._model._values(rows[name]))) for name in ship.states]
            initial = [column[0] for column in written]
            inputs = rows[:-1] if frame != "arrow" else rows.slice(0, rows.num_rows - 1)
            found = ship.simulate(inputs, initial, frame=frame)
            for name, expected in zip(ship.states, written):
                own = seatrial._model._values(found[name])
                self.assertLess(max(abs(x - y) for x, y in zip(own, expected)), 1e-9)
                self.assertEqual(len(own), len(expected))


@unittest.skipIf(MISSING, f"found no {', '.join(MISSING)}")
class Figures(unittest.TestCase):
    def test_tables_are_drawn_with_units(self) -> None:
        figure = seatrial.plot(results() / "campaign.parquet", design="random", run=1)
        self.assertEqual([axes.get_ylabel() for axes in figure.axes][-1], "yaw rate r [rad/s]")
        self.assertEqual(figure.axes[-1].get_xlabel(), "t [s]")
        self.assertEqual(len(figure.axes[0].lines[0].get_xdata()), 1001)
        scores = seatrial.plot(results() / "scores.parquet")
        self.assertEqual(len(scores.axes[0].lines), 3)
        path = folder() / "validation.json"
        seatrial.Model.load(model()).compare(results() / "campaign.parquet", out=path, runs=["random/3"])
        compared = seatrial.plot(path.with_name("compare.parquet"))
        self.assertEqual([line.get_label() for line in compared.axes[0].lines], ["measured", "simulated"])
        compared.savefig(folder() / "compared.svg")
        self.assertIn("<svg", (folder() / "compared.svg").read_text())

    def test_a_map_is_drawn(self) -> None:
        path = folder() / "map.json"
        path.write_text(json.dumps(MAP))
        axes = seatrial.plot(path).axes[0]
        # A contour, two parts of the track, start and goal; an area with a hole and a corridor; cells
        self.assertEqual((len(axes.lines), len(axes.patches), len(axes.images)), (5, 2, 1))
        self.assertEqual((axes.get_xlim(), axes.get_xlabel()), ((-100.0, 900.0), "east [m]"))
        # Two cells out, one in
        self.assertEqual(axes.images[0].get_array().compressed().tolist(), [1.0])
        self.assertFalse(axes.images[0].get_array().mask[0, 2])

    def test_what_cannot_be_drawn_is_refused(self) -> None:
        for name, words in (("estimates.parquet", "expected one of trajectories"), ("design.json", "expected map")):
            with self.assertRaisesRegex(seatrial.Refused, words):
                seatrial.plot(results() / name)
        with self.assertRaisesRegex(seatrial.Refused, "run: found no 99, expected one of 0, 1"):
            seatrial.plot(results() / "campaign.parquet", run=99)
        with self.assertRaisesRegex(TypeError, "found wrong, expected design, run"):
            seatrial.plot(results() / "campaign.parquet", wrong=1)


if __name__ == "__main__":
    unittest.main()
