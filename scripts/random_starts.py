"""Plans the trial of the 60 m coaster from random starts on a chart, and tells what becomes of each.

    python3 scripts/random_starts.py --chart ../shared/data/charts/turku_archipelago_land_gshhg_f.geojson --kind land \\
        --box 21.75 59.95 22.45 60.4 --starts 25 --seed 1 --out out/random-starts

Starts on an obstacle are drawn anew. For every other one: the exit code, time and memory of `seatrial plan`, and of a plan how
often it was searched, the proved and the sailed time, the largest part of a tolerance that the nominal vessel uses, ends of
legs beyond a tolerance by all vessels of the check, runs aground, the least clearance; of a refusal its line. Needs nothing but
Python. `--jobs` plans several at a time.
"""

import argparse
import concurrent.futures
import json
import math
import os
import pathlib
import random
import resource
import subprocess
import time

ROOT = pathlib.Path(__file__).resolve().parent.parent
SHIP = ROOT / "fixtures/ships/coaster60"
# As the coaster's README says.
PLAN = """
cell_m = 250.0
headings = 8

[hull]
length_m = 60.0
beam_m = 11.0

[safety]
margin_m = {margin}
unknown_current_m_s = 0.15
parameter_error = 0.15
{depths}

{handling}

[[speed_mode]]
name = "slow"
speed_m_s = 2.5

[[speed_mode]]
name = "fast"
speed_m_s = 4.0

[[maneuver]]
name = "zig-zag-fast"
count = 2

[[maneuver]]
name = "zig-zag-slow"
count = 2

[[maneuver]]
name = "circle"
count = 1

[[maneuver]]
name = "crash-slow"
count = 1

[goal]
kind = "home"

[cost]
primary = "seconds"
secondary = "turns"

[[chart]]
{chart}

[area]
west_deg = {west}
south_deg = {south}
east_deg = {east}
north_deg = {north}

[start]
longitude_deg = {longitude}
latitude_deg = {latitude}
heading_deg = {heading}
"""
HANDLING = """[handling]
turn_rate_rad_s = 0.012
crawl_m_s = 0.5
acceleration_m_s2 = 0.02
response_s = 40.0
lookahead_m = 160.0
"""


def plan(options, dictionary, number, start):
    """One plan from a start (longitude, latitude, heading): what it came to."""
    longitude, latitude, heading = start
    folder = options.out / f"{number:03}"
    folder.mkdir(parents=True, exist_ok=True)
    north = options.reach_km / 111.2
    east = north / math.cos(math.radians(latitude))
    kind = f'kind = "{options.kind}"' if options.kind else ""
    (folder / "plan.toml").write_text(
        PLAN.format(
            margin=options.margin,
            depths=f"transit_depth_m = {options.depth}\ntrial_depth_m = {options.depth}" if options.depth else "",
            handling="" if options.derived else HANDLING,
            chart=f'file = "{os.path.relpath(options.chart, folder)}"\n{kind}',
            west=longitude - east, east=longitude + east, south=latitude - north, north=latitude + north,
            longitude=longitude, latitude=latitude, heading=heading,
        )
    )
    command = [options.seatrial, "plan", "--vessel", SHIP / "vessel.toml", "--trajectories", dictionary,
               "--config", folder / "plan.toml", "--out", folder / "plan.json", "--time-limit-s", str(options.limit)]
    began = time.monotonic()
    ran = subprocess.run([str(part) for part in command], capture_output=True, text=True)
    seconds = time.monotonic() - began
    if ran.returncode != 0:
        line = ran.stderr.strip().splitlines()[-1] if ran.stderr.strip() else ""
        return ran.returncode, seconds, line.split("plan.toml: ")[-1], None
    return 0, seconds, "", json.loads((folder / "plan.json").read_text())["data"]


def row(number, start, result):
    """A line of the table."""
    code, seconds, line, planned = result
    place = f"{number:3} {start[0]:9.4f} {start[1]:8.4f} {start[2]:4.0f} {seconds:6.1f} s  exit {code}"
    if planned is None:
        return f"{place}  {line}"
    check = planned["voyage"]["check"]
    longer = 100.0 * (check["sailed_s"] / check["proved_s"] - 1.0)
    return (
        f"{place}  {planned['status']}, {check['rounds']} rounds, proved {check['proved_s']:.0f} s, sailed {longer:+.2f} %, "
        f"tolerance used {check['tolerance_used']:.2f}, {check['ends_astray']} of {check['ends']} ends astray, "
        f"{check['aground']} of {check['runs']} aground, clearance {check['clearance_quantiles_m'][0]:.0f} m"
    )


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--seatrial", default=ROOT / "target/release/seatrial")
    parser.add_argument("--chart", type=pathlib.Path, required=True)
    parser.add_argument("--kind", help="kind of the chart; left out for a cell of an electronic chart")
    parser.add_argument("--box", type=float, nargs=4, required=True, metavar=("WEST", "SOUTH", "EAST", "NORTH"))
    parser.add_argument("--reach-km", type=float, default=7.0, help="half of the area's side")
    parser.add_argument("--margin", type=float, default=150.0)
    parser.add_argument("--depth", type=float, help="least depth, for a chart with depths")
    parser.add_argument("--derived", action="store_true", help="leave [handling] out")
    parser.add_argument("--starts", type=int, default=25)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--limit", type=float, default=600.0, help="time limit of a plan [s]")
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", type=pathlib.Path, required=True)
    options = parser.parse_args()
    options.out.mkdir(parents=True, exist_ok=True)
    options.out, options.chart = options.out.resolve(), options.chart.resolve()
    dictionary = options.out / "dictionary.parquet"
    subprocess.run([str(options.seatrial), "simulate", "dictionary", "--vessel", str(SHIP / "vessel.toml"), "--dictionary",
                    str(SHIP / "dictionary.toml"), "--out", str(dictionary)], check=True, capture_output=True)
    drawn = random.Random(options.seed)
    west, south, east, north = options.box
    planned, refused, redrawn, number = 0, 0, 0, 0
    with concurrent.futures.ThreadPoolExecutor(options.jobs) as pool:
        while number < options.starts:
            starts = [(drawn.uniform(west, east), drawn.uniform(south, north), 45.0 * drawn.randrange(8))
                      for _ in range(options.jobs)]
            numbers = range(number, number + len(starts))
            for start, result in zip(starts, pool.map(lambda n, s: plan(options, dictionary, n, s), numbers, starts)):
                if result[0] == 4 and "`start`" in result[2]:
                    redrawn += 1
                    continue
                if number < options.starts:
                    planned, refused = planned + (result[0] == 0), refused + (result[0] != 0)
                    print(row(number, start, result), flush=True)
                number += 1
    memory = resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss / 1024
    print(f"{planned} planned, {refused} refused; {redrawn} starts on an obstacle drawn anew; seed {options.seed}; "
          f"at most {memory:.0f} MiB")


main()
