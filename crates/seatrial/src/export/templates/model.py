{{header}}
"""A ship's manoeuvring model. It needs Python alone.

    import {{base}} as ship
    x = (2.0, 0.0, 0.0)                     # u, v [m/s], r [rad/s]
    x = ship.step(x, row)                   # STEP_S later, with one value of each of INPUTS held meanwhile
    states = ship.simulate(rows, x)         # as many states as rows, and the first
    ship.within_ranges(x, row)              # whether the model is known to hold there

{{arrays}}
On a command line: python3 {{base}}.py U V R < inputs.csv > states.csv
"""

from math import {{imports}}

VESSEL = {{vessel}}
MADE_FROM = {{made_from}}

# {{rate_holds}}
SAMPLE_RATE_HZ = {{rate}}
STEP_S = 1.0 / SAMPLE_RATE_HZ

STATES = (
{{states}})
# In this order in every row of inputs.
INPUTS = (
{{inputs}})

PARAMETERS = {
{{parameters}}}
# None where it is not known.
STANDARD_ERRORS = {
{{standard_errors}}}
UNITS = {
{{units}}}
# How the model's file calls what cannot be called so here.
NAMES = {
{{names}}}
# Least and largest value: {{ranges_are}}.
RANGES = {
{{ranges}}}


{{functions}}def simulate(inputs, initial, parameters=PARAMETERS):
    """The states from `initial` on, one more than rows of `inputs`."""
    states = [tuple(initial)]
    for row in inputs:
        states.append(step(states[-1], row, parameters))
    return states


def outside(state, inputs):
    """The names of states and inputs that are outside the range of validity."""
    values = dict(zip(STATES + INPUTS, (*state, *inputs)))
    return [name for name, (low, high) in RANGES.items() if not low <= values[name] <= high]


def within_ranges(state, inputs):
    """Whether state and inputs are within the range of validity."""
    return not outside(state, inputs)


def main():
    """Inputs on stdin, a column each by name, to states on stdout; the initial state as arguments."""
    import csv
    import sys

    reader = csv.reader(sys.stdin)
    header = [name.strip().lstrip("\ufeff") for name in next(reader, [])]
    missing = [name for name in INPUTS if name not in header]
    if missing:
        sys.exit(f"stdin: found no column {missing[0]}, expected {', '.join(INPUTS)}; add it")
    places = [header.index(name) for name in INPUTS]
    table = [row for row in reader if row]
    rows = ([float(row[place]) for place in places] for row in table)
    others = [name for name in header if name not in INPUTS]
    starts = ("time", "stamp", "second", "t [", "t (")
    named = [name for name in others if name.lower().startswith(starts) or name in ("T", "t_s", "t_ms", "t_us", "t_ns")]
    if named and "t" not in others:
        sys.exit(f"stdin: found column {named[0]}, expected times as `t`, in seconds, or none; rename or remove it")
    if "t" in others:
        times = [float(row[header.index("t")]) for row in table]
        for k, time in enumerate(times):
            expected = times[0] + k * STEP_S
            if not abs(time - expected) <= 1e-3 * STEP_S:
                sys.exit(
                    f"stdin: row {k + 1}: found t = {time:g} s, expected {expected:g} s, rows {STEP_S:g} s apart as the "
                    "model steps; resample the table, or export the model by --rate for its step"
                )
    initial = [float(word) for word in sys.argv[1:4]]
    writer = csv.writer(sys.stdout)
    writer.writerow(["t", *STATES])
    for k, state in enumerate(simulate(rows, initial + [0.0] * (3 - len(initial)))):
        writer.writerow([repr(k * STEP_S), *map(repr, state)])


if __name__ == "__main__":
    main()
