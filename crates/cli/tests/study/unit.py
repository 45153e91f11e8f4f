"""Runs a unit by FMPy: python unit.py UNIT INPUTS.csv STATES.csv U V R STEP_S."""

import csv
import sys

import numpy
from fmpy import read_model_description, simulate_fmu
from fmpy.validation import validate_fmu

unit, inputs, states = sys.argv[1:4]
initial = dict(zip(["initial_u", "initial_v", "initial_r"], map(float, sys.argv[4:7])))
step = float(sys.argv[7])
wrong = validate_fmu(unit)
assert not wrong, wrong
with open(inputs) as file:
    header, *rows = csv.reader(file)
rows = numpy.array(rows, dtype=float)
signals = numpy.zeros(len(rows), dtype=[(name, float) for name in ["time", *header]])
signals["time"] = step * numpy.arange(len(rows))
for i, name in enumerate(header):
    signals[name] = rows[:, i]
found = simulate_fmu(
    unit,
    stop_time=step * len(rows),
    step_size=step,
    output_interval=step,
    input=signals,
    start_values=initial,
    output=["u", "v", "r"],
)
variables = {own.name: own for own in read_model_description(unit).modelVariables}
assert variables["n"].unit == "1/s" and variables["n"].causality == "input"
try:
    simulate_fmu(unit, stop_time=1.0, step_size=0.3 * step, output_interval=0.3 * step)
    sys.exit("a step of another length is taken")
except Exception as refused:
    assert "fmi2DoStep" in str(refused), refused
with open(states, "w") as file:
    for row in found:
        file.write(",".join(repr(float(row[name])) for name in ["u", "v", "r"]) + "\n")
