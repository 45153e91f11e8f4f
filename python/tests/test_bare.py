"""What needs no other library: programs, documents, units, models."""

from __future__ import annotations

import dataclasses
import io
import json
import math
import os
import re
import subprocess
import sys
import unittest
from contextlib import redirect_stderr
from importlib import metadata
from pathlib import Path
from unittest import mock

import seatrial
from seatrial import _program

from .study import REPOSITORY, coaster, folder, model, results, study


class Start(unittest.TestCase):
    def test_import_takes_less_than_a_third_of_a_second_and_loads_nothing(self) -> None:
        code = (
            "import time, sys; start = time.perf_counter(); import seatrial; took = time.perf_counter() - start;"
            "loaded = {'pyarrow', 'pandas', 'polars', 'matplotlib', 'numpy', 'subprocess', 'dataclasses'} & set(sys.modules);"
            "print(took, sorted(loaded))"
        )
        runs = [subprocess.run([sys.executable, "-c", code], capture_output=True, text=True, check=True) for _ in range(5)]
        took, loaded = min(run.stdout.strip().split(" ", 1) for run in runs)
        self.assertLess(float(took), 0.3)
        self.assertEqual(loaded, "[]")

    def test_its_version_is_that_of_the_package(self) -> None:
        try:
            installed = metadata.version("seatrial")
        except metadata.PackageNotFoundError:
            self.skipTest("not installed")
        self.assertEqual(seatrial.__version__, installed)

    def test_all_names_exist(self) -> None:
        for name in seatrial.__all__:
            self.assertIsNotNone(getattr(seatrial, name))
        with self.assertRaisesRegex(AttributeError, "nothing"):
            seatrial.nothing  # noqa: B018


class Run(unittest.TestCase):
    def test_flags_are_those_of_the_command_line(self) -> None:
        words = _program.command_line(
            {
                "segment_samples": 200,
                "shares": [0.5, -1],
                "covariance": True,
                "quiet": False,
                "out": Path("a"),
                "runs": None,
                "set": {"campaign.seed": 2, "campaign.name": "a b", "plan.free": True, "plan.list": [1, 2]},
            }
        )
        expected = "--segment-samples=200|--shares=0.5|--shares=-1|--covariance|--out=a|--set=campaign.seed=2"
        self.assertEqual("|".join(words), f"{expected}|--set=campaign.name=a b|--set=plan.free=true|--set=plan.list=[1, 2]")

    def test_a_stage_says_what_it_wrote(self) -> None:
        done = seatrial.run("design", moments=results() / "moments.json", out=folder() / "design.json")
        self.assertEqual(done.out, folder() / "design.json")
        self.assertIn("used", done.summary)
        self.assertEqual(type(done.read().data).__name__, "DesignDocument")

    def test_a_subcommand_that_prints_gives_its_lines(self) -> None:
        done = seatrial.run("verify", results())
        self.assertIn("whole and of one study", done.text)
        with self.assertRaises(seatrial.WrongUsage):
            done.read()

    def test_a_flag_may_be_called_stage(self) -> None:
        done = seatrial.run("run", study(), out=folder() / "first", stage="dictionary", quiet=True)
        self.assertEqual(done.summary["run"], ["dictionary"])

    def test_values_that_no_command_line_has_are_wrong_usage(self) -> None:
        deep: list[object] = []
        round_: list[object] = []
        round_.append(round_)
        for _ in range(100_000):
            deep = [deep]
        for flags in ({"out": "a\0b"}, {"out": "\ud800"}, {"set": {"x.y": round_}}, {"set": {"x.y": deep}}):
            with self.subTest(flag=next(iter(flags))), self.assertRaises(seatrial.WrongUsage):
                seatrial.run("design", **flags)

    def test_exceptions_are_named_by_the_exit_code(self) -> None:
        moments, merit = results() / "moments.json", folder() / "m.json"
        dictionary, ship = coaster() / "dictionary.toml", coaster() / "vessel.toml"
        cases = [
            (seatrial.Failed, 1, "expected an existing file", "design", {"moments": "nowhere.json", "out": merit}),
            (seatrial.WrongUsage, 2, "nonsense", "design", {"nonsense": 1}),
            (seatrial.WrongUsage, 2, "unrecognized subcommand", "no-stage", {}),
            (seatrial.Refused, 3, "expected moments/1", "design", {"moments": results() / "design.json", "out": merit}),
            (
                seatrial.NoAnswer,
                4,
                "log more often",
                "validate merit",
                {"vessel": ship, "dictionary": dictionary, "length_m": 7, "out": merit},
            ),
        ]
        self.assertTrue(moments.is_file())
        for kind, code, words, stage, flags in cases:
            with self.subTest(stage=stage, code=code), self.assertRaisesRegex(kind, words) as caught:
                seatrial.run(stage, **flags)
            self.assertEqual(caught.exception.exit_code, code)
            self.assertNotIn("\n", str(caught.exception))
            self.assertFalse(merit.exists())

    def test_a_signal_is_an_interruption(self) -> None:
        error = seatrial._errors.of_exit_code(-15, "ended", [])
        self.assertIsInstance(error, seatrial.Interrupted)
        self.assertEqual(error.exit_code, 143)

    def test_progress_passes_through_and_quiet_silences_it(self) -> None:
        for quiet, expected in ((False, True), (True, False)):
            said = io.StringIO()
            with redirect_stderr(said):
                seatrial.run("run", study(), out=results(), set={"campaign.realizations": 8}, quiet=quiet)
            self.assertEqual("up to date" in said.getvalue(), expected)

    def test_a_program_that_is_not_there_is_named(self) -> None:
        with mock.patch.dict(os.environ, {_program.VARIABLE: "/nowhere/seatrial"}):
            with self.assertRaisesRegex(seatrial.Failed, "/nowhere/seatrial, expected an installed one"):
                seatrial.run("design")


class Read(unittest.TestCase):
    def test_every_document_of_a_study_is_read(self) -> None:
        kinds = {path.name: type(seatrial.read(path).data).__name__ for path in results().glob("*.json")}
        expected = {"moments.json": "MomentsDocument", "design.json": "DesignDocument", "run.json": "RunDocument"}
        self.assertLessEqual(expected.items(), kinds.items())
        self.assertEqual(type(seatrial.read(model()).data).__name__, "ModelDocument")

    def test_a_document_has_what_its_file_has(self) -> None:
        path = results() / "moments.json"
        written, found = json.loads(path.read_text())["data"], seatrial.read(path).data
        self.assertEqual(plain(found), json.loads(json.dumps(written), parse_int=float))

    def test_documents_of_older_releases_are_read(self) -> None:
        for path in (REPOSITORY / "fixtures" / "schema").glob("*.json"):
            self.assertEqual(seatrial.read(path).schema, f"{path.stem.replace('-', '/')}")

    def test_wrong_documents_are_refused_by_file_place_and_remedy(self) -> None:
        good = json.loads((results() / "design.json").read_text())
        name = next(iter(good["data"]["shares"]))
        cases = [
            (lambda d: d.update(schema="design/99"), "schema: found design/99, expected design/2; upgrade seatrial"),
            (lambda d: d.update(schema="strange/1"), "schema: found strange/1, expected one of design, "),
            (lambda d: d["data"].update(wrong=1), "data.wrong: found an unknown key, expected one of "),
            (lambda d: d["data"].pop("shares"), "data.shares: found no such key, expected a value"),
            (lambda d: d["data"].update(gap="1"), 'data.gap: found "1", expected a number'),
            (lambda d: d["data"]["shares"].update({name: True}), f"data.shares.{name}: found true, expected a number"),
            (lambda d: d["data"].update(status="odd"), 'data.status: found "odd", expected one of optimal, '),
        ]
        path = folder() / "wrong.json"
        for change, words in cases:
            wrong = json.loads(json.dumps(good))
            change(wrong)
            path.write_text(json.dumps(wrong))
            with self.subTest(words=words), self.assertRaises(seatrial.Refused) as caught:
                seatrial.read(path)
            self.assertTrue(str(caught.exception).startswith(f"{path}: {words}"), str(caught.exception))

    def test_files_that_are_none_are_refused(self) -> None:
        here = folder()
        (here / "cut.json").write_text('{"schema": "design/2"')
        (here / "list.json").write_text("[]")
        (here / "twice.json").write_text('{"schema": "design/2", "schema": "design/2"}')
        (here / "cut.parquet").write_bytes((results() / "scores.parquet").read_bytes()[:-9])
        (here / "odd.txt").write_text("")
        (here / "deep.json").write_text("[" * 200_000 + "]" * 200_000)
        (here / "nan.json").write_text('{"schema": "design/2", "data": NaN}')
        design = json.loads((results() / "design.json").read_text())
        design["data"]["gap"] = 10**400
        (here / "large.json").write_text(json.dumps(design))
        cases = {
            "cut.json": "text: found .*, expected JSON",
            "list.json": "schema: found no object",
            "twice.json": "a key twice",
            "cut.parquet": "no Parquet header or footer",
            "deep.json": "text: found maximum recursion depth exceeded.*, expected JSON",
            "nan.json": "text: found NaN, which is no number, expected JSON",
            "large.json": r"data.gap: found 10+\.\.\., expected a number below 1e308",
            "a\0b.json": "path: found embedded null",
            "a\0b.parquet": "path: found embedded null",
            "odd.txt": r"ending: found .txt, expected .parquet or .json",
        }
        for name, words in cases.items():
            with self.subTest(name=name), self.assertRaisesRegex(seatrial.Refused, words):
                seatrial.units(here / name)
        with self.assertRaisesRegex(seatrial.Failed, "nowhere.json: read: found No such file"):
            seatrial.read("nowhere.json")

    def test_units_are_those_of_the_file(self) -> None:
        found = seatrial.units(results() / "campaign.parquet")
        self.assertEqual((found["t"], found["u"], found["psi"], found["design"]), ("s", "m/s", "rad", "1"))
        self.assertEqual(seatrial.units(results() / "estimates.parquet")["X_u_se"], "m/s per (m/s)")
        self.assertEqual(seatrial.units(results() / "design.json")["gap"], "1")

    def test_a_table_of_another_version_is_refused(self) -> None:
        written = (results() / "scores.parquet").read_bytes()
        path = folder() / "newer.parquet"
        path.write_bytes(written.replace(b'"schema":"scores/1"', b'"schema":"scores/9"'))
        with self.assertRaisesRegex(seatrial.Refused, "schema: found scores/9, expected scores/1; upgrade"):
            seatrial.read(path)

    def test_frames_without_libraries_say_what_to_install(self) -> None:
        absent = {"pandas": None, "polars": None, "pyarrow": None}
        with mock.patch.dict(sys.modules, absent):
            for frame in ("pandas", "polars", "arrow", None):
                with self.assertRaisesRegex(seatrial.MissingLibrary, r"pip install 'seatrial\[\w+\]'") as caught:
                    seatrial.read(results() / "scores.parquet", frame)
                self.assertIsInstance(caught.exception, ImportError)
        with mock.patch.dict(sys.modules, {"matplotlib": None, "matplotlib.figure": None}):
            with self.assertRaisesRegex(seatrial.MissingLibrary, r"seatrial\[plot\]"):
                seatrial.plot(results() / "scores.parquet")
        with self.assertRaisesRegex(seatrial.WrongUsage, "frame: found excel, expected one of pandas"):
            seatrial.read(results() / "scores.parquet", "excel")


class Models(unittest.TestCase):
    def test_a_vessel_steps_and_simulates(self) -> None:
        ship = seatrial.Model.load(study() / "vessel.toml")
        self.assertEqual(ship.states, ("u", "v", "r"))
        self.assertEqual(ship.inputs, ("tau1", "tau2", "tau3"))
        self.assertEqual(ship.units["X_u"], "m/s per (m/s)")
        row, state = [1000.0, 0.0, 10.0], (1.0, 0.1, 0.05)
        states = ship.simulate([row, row], state)
        self.assertEqual(states[0], state)
        self.assertEqual(states[2], ship.step(ship.step(state, row), row))
        held = ship.step(state, row, {"X_tau": 0.0})
        self.assertLess(held[0], states[1][0])
        columns = {"tau3": [10.0, 10.0], "tau1": [1000.0, 1000.0], "tau2": [0.0, 0.0]}
        self.assertEqual(ship.simulate(columns, state), states)

    def test_a_model_has_errors_and_ranges(self) -> None:
        ship = seatrial.Model.load(model())
        self.assertGreater(ship.standard_errors["X_u"] or 0.0, 0.0)
        low, high = ship.ranges["u"]
        self.assertEqual(ship.outside((high + 1.0, 0.0, 0.0), [0.0, 0.0, 0.0]), ["u"])
        self.assertLess(low, high)

    def test_a_fit_finds_the_parameters_of_the_frame_and_names_what_it_lacks(self) -> None:
        vessel = REPOSITORY / "pipelines" / "smoke" / "vessel.toml"
        ship = seatrial.Model.load(vessel)
        inputs = [(800.0 if k // 80 % 2 else -240.0, 100 * math.sin(k / 30), 40 * math.sin(k / 17)) for k in range(2000)]
        states = ship.simulate(inputs, (1.0, 0.0, 0.0))[:-1]
        frame = {"t": [k * ship.step_s for k in range(2000)], **dict(zip("uvr", zip(*states))), **dict(zip(ship.inputs, zip(*inputs)))}
        fitted = seatrial.fit(frame, vessel=vessel)
        for name, value in ship.parameters.items():
            self.assertAlmostEqual(fitted.parameters[name] / value, 1.0, places=6)
        with self.assertRaisesRegex(seatrial.WrongUsage, "no column r"):
            seatrial.fit({name: column for name, column in frame.items() if name != "r"}, vessel=vessel)
        with self.assertRaisesRegex(seatrial.WrongUsage, "frame: found columns of 2000, 1999"):
            seatrial.fit({**frame, "u": frame["u"][1:]}, vessel=vessel)
        with self.assertRaisesRegex(seatrial.WrongUsage, "frame: found list"):
            seatrial.fit(inputs, vessel=vessel)
        with self.assertRaisesRegex(seatrial.WrongUsage, "no time that passes"):
            seatrial.fit({**frame, "t": [0.0] * 2000}, vessel=vessel)
        with self.assertRaisesRegex(seatrial.NoAnswer, "identifiable"):
            seatrial.fit({name: [0.0] * 2000 if name != "t" else frame["t"] for name in frame}, vessel=vessel)

    def test_wrong_inputs_and_parameters_are_refused(self) -> None:
        ship = seatrial.Model.load(study() / "vessel.toml")
        with self.assertRaisesRegex(seatrial.WrongUsage, "found 1 values, expected one of each of tau1"):
            ship.step((0.0, 0.0, 0.0), [1.0])
        with self.assertRaisesRegex(seatrial.WrongUsage, "found no column tau2, tau3"):
            ship.simulate({"tau1": [1.0]})
        with self.assertRaisesRegex(seatrial.WrongUsage, "parameters: found X_uuu"):
            ship.step((0.0, 0.0, 0.0), [0.0] * 3, {"X_uuu": 1.0})
        with self.assertRaisesRegex(seatrial.WrongUsage, "state: found 2 values, expected u, v and r"):
            ship.step((0.0, 0.0), [0.0] * 3)
        with self.assertRaisesRegex(seatrial.WrongUsage, "columns of 2, 1, 1 rows"):
            ship.simulate({"tau1": [1.0, 2.0], "tau2": [1.0], "tau3": [1.0]})
        with self.assertRaisesRegex(seatrial.NoAnswer, "step: found .*, expected numbers that stay finite"):
            ship.step((10**400, 0.5, 0.0), [0.0] * 3)
        with self.assertRaisesRegex(seatrial.WrongUsage, "model: found another one"):
            ship.compare(results() / "campaign.parquet", model="other.json")
        with self.assertRaises(seatrial.Failed):
            seatrial.Model.load("nowhere.json")

    def test_compare_and_merit_are_those_of_the_stages(self) -> None:
        ship = seatrial.Model.load(model())
        compared = ship.compare(results() / "campaign.parquet", out=folder() / "validation.json", runs=["optimized/5"])
        self.assertEqual(compared.schema, "validation/2")
        self.assertTrue((folder() / "compare.parquet").is_file())
        coasting = seatrial.Model.load(coaster() / "vessel.toml")
        merit = coasting.merit(coaster() / "dictionary.toml", 100)
        self.assertEqual(type(merit.data).__name__, "MeritDocument")
        with self.assertRaisesRegex(seatrial.NoAnswer, "log more often"):
            coasting.merit(coaster() / "dictionary.toml", 7)


@unittest.skipUnless((REPOSITORY / "schemas").is_dir(), "not in the repository")
class Repository(unittest.TestCase):
    def test_the_classes_are_those_of_the_schemas(self) -> None:
        script = REPOSITORY / "scripts" / "python_documents.py"
        done = subprocess.run([sys.executable, script, "--check"], capture_output=True, text=True, check=False)
        self.assertEqual(done.returncode, 0, done.stderr)

    def test_the_notebook_has_no_outputs(self) -> None:
        for path in (REPOSITORY / "python" / "notebook").glob("*.ipynb"):
            cells = json.loads(path.read_text(encoding="utf-8"))["cells"]
            self.assertEqual([cell["id"] for cell in cells if cell.get("outputs") or cell.get("execution_count")], [])

    def test_the_tables_are_those_of_the_sources(self) -> None:
        found: dict[str, int] = {}
        for path in (REPOSITORY / "crates" / "study" / "src").rglob("*.rs"):
            text = path.read_text(encoding="utf-8")
            known = re.findall(r'pub const (?:ID|TRACK): &str = "([^"]+)";', text)
            versions = re.findall(r"pub const (?:VERSION|TRACK_VERSION): u32 = (\d+);", text)
            found |= {name: int(version) for name, version in zip(known, versions)}
            found |= {name: int(version) for name, version in re.findall(r'>::new\("([^"]+)", (\d+)\)', text)}
        self.assertEqual(found, seatrial._envelope.TABLES)


def plain(value: object) -> object:
    """A document as its JSON: without the fields that stand for absent keys."""
    if dataclasses.is_dataclass(value):
        said = [field for field in dataclasses.fields(value) if not (field.default is False and getattr(value, field.name) is False)]
        pairs = {field.name.removesuffix("_"): plain(getattr(value, field.name)) for field in said}
        return {key: own for key, own in pairs.items() if own is not None and own != []}
    if isinstance(value, (list, tuple)):
        return [plain(own) for own in value]
    if isinstance(value, dict):
        return {key: plain(own) for key, own in value.items()}
    return float(value) if isinstance(value, int) and not isinstance(value, bool) else value


if __name__ == "__main__":
    unittest.main()
