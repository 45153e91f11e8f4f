"""Vessels on a planned trial: their model, actuators, autopilot and noisy sensors. Vessels are lanes of numpy's arrays."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from .orders import Helmsmen, program_of
from .study import STATES, Vessel
from .tracking import Motion
from .voyage import ARC, HOLD, LINE, MANEUVER, Phase, Voyage, wrap

# How the autopilot is tuned, in parts of the response time, and limits of what it does within a sample.
COURSE, SPEED, YAW_RATE, MEMORY, AT_ONCE, BELIEVED = 4.0, 4.0, 8.0, 8.0, 0.5, 0.3
# Over what part of the response time noisy measurements are smoothed.
SMOOTHED = 0.25
# Newton's steps per sample, and increments and slopes that count as none.
STEPS, SMALL, NO_EFFECT = 5, 1e-9, 1e-15


class Fleet:
    """Vessels of one structure, each with parameters and a current (north, east) of its own."""

    def __init__(self, vessel: Vessel, voyage: Voyage) -> None:
        if vessel.follows:
            raise SystemExit("a vessel whose inputs follow others, which this script does not steer")
        count = len(vessel.inputs)
        if count not in (2, 3):
            raise SystemExit(f"a vessel with {count} inputs: this script steers those with 2 or 3")
        self.vessel, self.voyage = vessel, voyage
        self.nominal = [np.array(row)[None, :] for row in vessel.nominal]
        # Two inputs command surge and yaw, and leave sway to the drift of the turn.
        self.commanded = [0, 1, 2] if count == 3 else [0, 2]
        ranges = [own.range or (-np.inf, np.inf) for own in vessel.actuators]
        self.low, self.high = (np.array(ends) for ends in zip(*ranges))
        self.lag = np.array([own.lag_s for own in vessel.actuators])
        self.rate = np.array([own.rate_per_s or np.inf for own in vessel.actuators])
        self.settle_maneuvers()

    def values(self, state: np.ndarray, inputs: np.ndarray) -> dict[str, np.ndarray]:
        return dict(zip(STATES, state)) | dict(zip(self.vessel.inputs, inputs.T))

    def increments(
        self, parameters: list[np.ndarray], state: np.ndarray, inputs: np.ndarray, water: np.ndarray | None = None
    ) -> np.ndarray:
        """Changes of u, v, r in a sample; of terms per sample they do not depend on the `water`'s own motion."""
        values = self.values(state, inputs)
        rows = [[p * t.value(values) for p, t in zip(row.T, terms)] for row, terms in zip(parameters, self.vessel.terms)]
        return np.array([np.broadcast_to(sum(row), state.shape[1]) for row in rows])

    def slopes(self, state: np.ndarray, inputs: np.ndarray) -> np.ndarray:
        """Changes of the nominal increments by the inputs: vessels × 3 × inputs."""
        values = self.values(state, inputs)
        slopes = np.zeros((state.shape[1], 3, len(self.vessel.inputs)))
        for degree, (row, terms) in enumerate(zip(self.vessel.nominal, self.vessel.terms)):
            for parameter, term in zip(row, terms):
                for index, name in enumerate(self.vessel.inputs):
                    slopes[:, degree, index] += parameter * term.slope(name, values)
        return slopes

    def inputs_for(self, wanted: np.ndarray, state: np.ndarray, start: np.ndarray) -> np.ndarray:
        """Inputs within their ranges by which the nominal model has the increments `wanted`, by Newton's method from `start`."""
        inputs, lanes = start.copy(), np.arange(state.shape[1])
        for _ in range(STEPS):
            missing = (wanted - self.increments(self.nominal, state, inputs))[self.commanded]
            lanes = lanes[np.abs(missing[:, lanes]).max(axis=0) > SMALL]
            if not len(lanes):
                break
            slopes = self.slopes(state[:, lanes], inputs[lanes])[:, self.commanded, :]
            after = np.clip(inputs[lanes] + solved(slopes, missing[:, lanes].T), self.low, self.high)
            moved = (np.abs(after - inputs[lanes]) > 1e-12 * np.abs(after)).any(axis=1)
            inputs[lanes] = after
            lanes = lanes[moved]
        return inputs

    def held(self, speed: float) -> np.ndarray:
        """Inputs by which the nominal vessel holds a speed on a straight course."""
        state = np.array([[speed], [0.0], [0.0]])
        return self.inputs_for(np.zeros((3, 1)), state, np.zeros((1, len(self.vessel.inputs))))[0]

    def begun(self, _: float) -> np.ndarray:
        """Inputs from which the autopilot's first ones are found, at a speed."""
        return np.zeros(len(self.vessel.inputs))

    def settle_maneuvers(self) -> None:
        """Gives maneuvers their programs, and recoveries the speed that the nominal vessel has after the maneuver: it begins
        the leg on its node, as when it was planned."""
        for number, phase in enumerate(self.voyage.phases):
            if phase.orders is not None:
                self.voyage.phases[number] = phase.with_program(program_of(phase, self))
        for number, phase in enumerate(self.voyage.phases):
            if phase.kind == MANEUVER:
                before = self.voyage.phases[number - 1 : number] if number else []
                approach = [own for own in before if own.leg == phase.leg]
                own = [*approach, self.voyage.phases[number]]
                after = self.voyage.phases[number + 1]
                if after.kind == LINE:
                    speed = max(self.speed_after(own), self.voyage.handling["crawl_m_s"])
                    self.voyage.phases[number + 1] = after.from_speed(speed)

    def speed_after(self, phases: list[Phase]) -> float:
        step = self.voyage.plan["steps"][phases[0].leg]
        north, east = self.voyage.node(step["from"])
        nominal = np.concatenate([row[0] for row in self.nominal])[None, :]
        begin = (north, east, self.voyage.heading(step["from"])), self.voyage.speed(step["from"])
        sailing = Sailing(self, phases, begin, nominal, np.zeros((1, 2)))
        sailing.to_the_end(lambda *_: None)
        return float(sailing.state[0, 0])

    def sail(self, parameters: np.ndarray, current: np.ndarray, watch: Any, noise: "Noise | None" = None) -> "Ends":
        """Sails the plan: `parameters` (vessels × all parameters, surge first), `current` (vessels × 2) [m/s]. Calls
        `watch(leg, pose, informative, under way)` at every sample. Sensors are exact without `noise`."""
        first = self.voyage.plan["steps"][0]["from"]
        track = self.voyage.track
        begin = tuple(float(track[name][0]) for name in ("x", "y", "psi")), self.voyage.speed(first)
        return Sailing(self, self.voyage.phases, begin, parameters, current, noise).to_the_end(watch)


def solved(slopes: np.ndarray, missing: np.ndarray) -> np.ndarray:
    """Changes of inputs, vessels × inputs: each input in turn makes up for the motion that it changes most. One that changes no
    motion besides those that others make up for is left where it is, such as a rudder at rest, which has drag alone."""
    rows, lanes, count = np.concatenate([slopes, missing[:, :, None]], axis=2), np.arange(len(slopes)), slopes.shape[2]
    is_free, made_up = np.ones(slopes.shape[:2], dtype=bool), np.zeros((len(slopes), count), dtype=int)
    acts = np.zeros((len(slopes), count), dtype=bool)
    for index in range(count):
        effects = np.where(is_free, np.abs(rows[:, :, index]), 0.0)
        best = effects.argmax(axis=1)
        acts[:, index], made_up[:, index] = effects[lanes, best] > NO_EFFECT, best
        own, row = lanes[acts[:, index]], best[acts[:, index]]
        is_free[own, row] = False
        parts = rows[own, :, index] / rows[own, row, index][:, None]
        parts[np.arange(len(own)), row] = 0.0
        rows[own] -= parts[:, :, None] * rows[own, row][:, None, :]
    slopes = np.where(acts, rows[lanes[:, None], made_up, np.arange(count)], 1.0)
    return np.where(acts, rows[lanes[:, None], made_up, count] / slopes, 0.0)


@dataclass
class Ends:
    """Pose and motion at the end of every leg: legs × vessels × (x, y, psi, u, v, r); vessels that did not complete a maneuver."""

    at: np.ndarray
    unfinished: np.ndarray


class Noise:
    """Noise of sensors, independent from sample to sample, and how far it is smoothed."""

    def __init__(self, sensors: dict[str, float], voyage: Voyage, sample_s: float, random: np.random.Generator) -> None:
        position, speed = sensors.get("position_m", 0.0), sensors.get("speed_m_s", 0.0)
        heading = np.radians(sensors.get("heading_deg", 0.0))
        self.deviations = np.array([position, position, heading, speed, speed, sensors.get("yaw_rate_rad_s", 0.0)])
        self.gain = 1.0 / max(SMOOTHED * voyage.handling["response_s"] / sample_s, 1.0)
        self.random = random
        # What is left of it in an estimate.
        self.left = self.deviations * np.sqrt(self.gain / (2.0 - self.gain))

    def estimate(self, truth: np.ndarray, predicted: np.ndarray) -> np.ndarray:
        """From a measurement and what was predicted, quantities × vessels."""
        off = truth + self.deviations[:, None] * self.random.standard_normal(truth.shape) - predicted
        off[2] = wrap(off[2])
        return predicted + np.where(self.deviations > 0.0, self.gain, 1.0)[:, None] * off


class Sailing:
    """A fleet on its way along phases."""

    def __init__(
        self,
        fleet: Fleet,
        phases: list[Phase],
        begin: tuple[tuple[float, ...], float],
        parameters: np.ndarray,
        current: np.ndarray,
        noise: Noise | None = None,
    ) -> None:
        self.fleet, self.voyage, self.phases, self.noise = fleet, fleet.voyage, phases, noise
        self.dt = 1.0 / fleet.vessel.rate_hz
        counts = np.cumsum([len(row) for row in fleet.vessel.names])[:-1]
        self.parameters = np.split(parameters, counts, axis=1)
        self.current = current.T
        lanes, inputs = len(parameters), len(fleet.vessel.inputs)
        # Ordered by quantity: x, y, psi; u, v, r.
        place, speed = begin
        self.pose = np.array([np.full(lanes, of) for of in place])
        self.state = np.array([np.full(lanes, speed), np.zeros(lanes), np.zeros(lanes)])
        # As the autopilot sees them.
        self.seen_pose, self.seen_state = self.pose.copy(), self.state.copy()
        self.measure(self.pose, self.state)
        self.unexplained, self.commanded = np.zeros((3, lanes)), np.tile(fleet.begun(speed), (lanes, 1))
        self.setting = np.full((lanes, inputs), np.nan)
        self.phase, self.number = np.zeros(lanes, dtype=int), np.arange(lanes)
        self.start, self.elapsed = self.seen_pose.copy(), np.zeros(lanes)
        self.helm, self.given_up = Helmsmen(lanes), np.zeros(lanes, dtype=bool)
        self.lay_out(phases, inputs)
        h = self.voyage.handling
        self.response, self.lookahead, self.crawl = h["response_s"], h["lookahead_m"], h["crawl_m_s"]
        self.turn_rate = h["turn_rate_rad_s"]
        believed = min(1.0 / (self.response / MEMORY * fleet.vessel.rate_hz), BELIEVED)
        self.believed = np.full((3, 1), believed)
        self.unsure = np.zeros(6)
        if noise is not None:
            noisy = (noise.deviations[3:] > 0.0)[:, None]
            self.believed = np.where(noisy, min(believed, noise.gain), believed)
            self.unsure = noise.left
        self.ends = np.full((len(self.voyage.legs), lanes, 6), np.nan)
        self.begin_maneuvers(np.ones(lanes, dtype=bool))

    def lay_out(self, phases: list[Phase], inputs: int) -> None:
        """Phases as arrays, with one more for vessels at the end."""
        take = lambda of: np.array([of(phase) for phase in phases] + [of(phases[-1])])  # noqa: E731
        self.kind, self.leg = take(lambda p: p.kind), take(lambda p: p.leg)
        self.to = np.array([take(lambda p: p.to[0]), take(lambda p: p.to[1])])
        self.heading, self.radius, self.side = (take(lambda p: p.heading), take(lambda p: p.radius), take(lambda p: p.side))
        self.v0, self.v1 = take(lambda p: p.speeds[0]), take(lambda p: p.speeds[1])
        self.reacts = take(lambda p: p.program is not None)
        self.length = take(lambda p: 0 if p.inputs is None else len(p.inputs))
        self.most = int(self.length.max(initial=0))
        self.table = np.zeros((len(self.kind), max(self.most, 1), inputs))
        for index, phase in enumerate(phases):
            if phase.inputs is not None:
                self.table[index, : len(phase.inputs)] = phase.inputs

    def to_the_end(self, watch: Any) -> Ends:
        longest = 20 * len(self.voyage.track["t"])
        for _ in range(longest):
            self.complete()
            under_way = self.under_way()
            if not under_way.any():
                return Ends(self.ends, self.given_up)
            maneuver = self.kind[self.phase] == MANEUVER
            watch(self.leg[self.phase], self.pose, maneuver, under_way)
            self.advance(self.inputs(maneuver, under_way), under_way)
        raise SystemExit("a vessel does not arrive")

    def under_way(self) -> np.ndarray:
        return self.phase < len(self.phases)

    def inputs(self, maneuver: np.ndarray, under_way: np.ndarray) -> np.ndarray:
        """Settings of the actuators during the next sample."""
        row = np.minimum((self.elapsed / self.dt + 0.5).astype(int), max(self.most - 1, 0))
        orders = np.where(maneuver[:, None], self.table[self.phase, row], 0.0)
        for number in np.unique(self.phase[self.reacts[self.phase] & under_way]):
            lanes = np.flatnonzero((self.phase == number) & under_way)
            program, state = self.phases[number].program, self.seen_state[:, lanes]
            if isinstance(program, Motion):
                orders[lanes] = self.helm.track(program, lanes, state, (self.fleet.low, self.fleet.high))
            else:
                orders[lanes] = self.helm.command(program, lanes, self.seen_pose[2, lanes], state)
        steered = np.flatnonzero(~maneuver & under_way)
        orders[steered] = self.steer(steered)
        return self.reached(orders, maneuver)

    def reached(self, orders: np.ndarray, maneuver: np.ndarray) -> np.ndarray:
        """Where the actuators are: those of the autopilot as near as they come, those of maneuvers by their lag and rate. The
        first setting is reached at once."""
        fleet, first = self.fleet, np.isnan(self.setting)
        before = np.where(first, orders, self.setting)
        with np.errstate(divide="ignore"):
            part = np.where(fleet.lag > 0.0, -np.expm1(-self.dt / np.where(fleet.lag > 0.0, fleet.lag, 1.0)), 1.0)
        lagging = lambda end: before + part * (end - before)  # noqa: E731
        low, high = (np.where(np.isfinite(end), lagging(np.where(np.isfinite(end), end, 0.0)), end) for end in (fleet.low, fleet.high))
        setting = np.where(maneuver[:, None], lagging(orders), np.clip(orders, low, high))
        most = fleet.rate * self.dt
        return np.where(first, orders, np.clip(setting, before - most, before + most))

    def complete(self) -> None:
        """Moves vessels on that have completed their phase."""
        while True:
            under_way = self.under_way()
            done = self.is_done() & under_way
            if not done.any():
                return
            before = self.leg[self.phase]
            self.phase[done] += 1
            finished = done & ((self.phase >= len(self.phases)) | (self.leg[self.phase] != before))
            lanes = np.flatnonzero(finished)
            self.ends[before[lanes], lanes, :3] = self.pose[:, lanes].T
            self.ends[before[lanes], lanes, 3:] = self.state[:, lanes].T
            self.start[:, done], self.elapsed[done] = self.seen_pose[:, done], 0.0
            self.begin_maneuvers(done)

    def begin_maneuvers(self, begun: np.ndarray) -> None:
        for number in np.unique(self.phase[begun & self.reacts[self.phase] & self.under_way()]):
            lanes = np.flatnonzero(begun & (self.phase == number))
            self.helm.begin(self.phases[number].program, lanes, self.seen_pose[2, lanes])

    def offset(self, pose: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
        return self.to[0, self.phase] - pose[0], self.to[1, self.phase] - pose[1]

    def course(self) -> np.ndarray:
        """Of an arc, abeam of the vessel."""
        north, east = self.offset(self.seen_pose)
        return wrap(np.arctan2(east, north) - self.side[self.phase] * np.pi / 2)

    def is_done(self) -> np.ndarray:
        p, kind = self.phase, self.kind[self.phase]
        pose, state, unsure = self.seen_pose, self.seen_state, self.unsure
        north, east = self.offset(pose)
        sin, cos = np.sin(self.heading[p]), np.cos(self.heading[p])
        late = self.elapsed > self.patience()
        line = north * cos + east * sin <= np.maximum(state[0] * self.dt / 2.0, 0.0)
        arc = self.side[p] * wrap(self.heading[p] - self.course()) <= 0.0
        there = np.hypot(north, east) <= self.crawl * self.response / 20.0 + unsure[0]
        turned = np.abs(wrap(self.heading[p] - pose[2])) <= 0.01 + unsure[2]
        still = np.hypot(*state[:2]) <= 0.1 * self.crawl + unsure[3]
        still &= np.abs(state[2]) <= 0.1 * self.turn_rate + unsure[5]
        maneuver = (self.elapsed >= (self.length[p] - 0.5) * self.dt) & ~self.reacts[p]
        for number in np.unique(p[self.reacts[p] & self.under_way()]):
            lanes = np.flatnonzero(p == number)
            over, unfinished = self.helm.is_over(self.phases[number].program, lanes)
            maneuver[lanes], self.given_up[lanes] = over, self.given_up[lanes] | unfinished
        return np.select(
            [kind == LINE, kind == ARC, kind == HOLD], [line | late, arc | late, (there & turned & still) | late], maneuver
        )

    def patience(self) -> np.ndarray:
        p, kind, more = self.phase, self.kind[self.phase], 5.0 * self.response
        way = np.hypot(*self.offset(self.start))
        line = 2.0 * way / np.maximum((self.v0[p] + self.v1[p]) / 2.0, self.crawl)
        arc = 2.0 * np.pi * self.radius[p] / np.maximum(self.v0[p], self.crawl)
        hold = way / self.crawl + np.abs(wrap(self.heading[p] - self.start[2])) / self.turn_rate
        return np.select([kind == LINE, kind == ARC], [line, arc], hold) + more

    def steer(self, lanes: np.ndarray) -> np.ndarray:
        """Inputs of these vessels: line of sight over the ground, and inversion of the nominal model with what it does not
        explain."""
        p, pose, start = self.phase[lanes], self.seen_pose[:, lanes], self.start[:, lanes]
        kind, (u, v, r) = self.kind[p], self.seen_state[:, lanes]
        north, east = self.to[:, p] - pose[:2]
        whole_north, whole_east = self.to[:, p] - start[:2]
        sin, cos = np.sin(self.heading[p]), np.cos(self.heading[p])
        whole, left = whole_north * cos + whole_east * sin, north * cos + east * sin
        ahead = whole > 0.0
        part = np.where(ahead, np.clip(1.0 - left / np.where(ahead, whole, 1.0), 0.0, 1.0), 1.0)
        squares = self.v1[p] ** 2 - self.v0[p] ** 2
        line_speed = np.maximum(np.sqrt(np.maximum(self.v0[p] ** 2 + part * squares, 0.0)), self.crawl)
        gained = np.where(ahead & (kind == LINE), squares / (2.0 * np.where(ahead, whole, 1.0)), 0.0)
        line_aim = self.heading[p] - np.arctan((north * sin - east * cos) / self.lookahead)
        astray = self.side[p] * (self.radius[p] - np.hypot(north, east))
        arc_aim = wrap(np.arctan2(east, north) - self.side[p] * np.pi / 2) - np.arctan(astray / self.lookahead)
        track = pose[2] + np.arctan2(v, np.maximum(u, self.crawl))
        turning = np.where(kind == ARC, self.side[p] * self.v0[p] / self.radius[p], 0.0)
        off = np.where(kind == HOLD, wrap(self.heading[p] - pose[2]), wrap(np.where(kind == ARC, arc_aim, line_aim) - track))
        limit = np.maximum(self.turn_rate, 1.2 * np.abs(turning))
        yaw = np.clip(turning + COURSE * off / self.response, -limit, limit)
        own_sin, own_cos = np.sin(pose[2]), np.cos(pose[2])
        slow = lambda x: np.clip(x / self.response, -self.crawl, self.crawl)  # noqa: E731
        hold = kind == HOLD
        surge = np.select([hold, kind == ARC], [slow(north * own_cos + east * own_sin), self.v0[p]], line_speed)
        sway = np.where(hold, slow(east * own_cos - north * own_sin), 0.0)
        gain = lambda of: min(of * self.dt / self.response, AT_ONCE)  # noqa: E731
        wanted = np.array([gained * self.dt + gain(SPEED) * (surge - u), gain(SPEED) * (sway - v), gain(YAW_RATE) * (yaw - r)])
        wanted = wanted - self.unexplained[:, lanes]
        inputs = self.fleet.inputs_for(wanted, self.seen_state[:, lanes], self.commanded[lanes])
        self.commanded[lanes] = inputs
        return inputs

    def advance(self, inputs: np.ndarray, under_way: np.ndarray) -> None:
        self.setting = np.where(under_way[:, None], inputs, self.setting)
        sin, cos = np.sin(self.pose[2]), np.cos(self.pose[2])
        north, east = self.current
        water = np.array([north * cos + east * sin, east * cos - north * sin, np.zeros_like(north)])
        seen_pose, seen_state = self.seen_pose, self.seen_state
        after = self.state + self.fleet.increments(self.parameters, self.state - water, inputs, water)
        self.pose = np.where(under_way, moved(self.pose, self.state, self.dt), self.pose)
        self.state = np.where(under_way, after, self.state)
        expected = seen_state + self.fleet.increments(self.fleet.nominal, seen_state, inputs) + self.unexplained
        self.measure(moved(seen_pose, seen_state, self.dt), expected)
        learnt = self.believed * (self.seen_state - expected)
        self.unexplained = np.where(under_way, self.unexplained + learnt, self.unexplained)
        self.elapsed = self.elapsed + self.dt

    def measure(self, pose: np.ndarray, state: np.ndarray) -> None:
        """What is seen after a pose and a motion were expected."""
        if self.noise is None:
            self.seen_pose, self.seen_state = self.pose, self.state
        else:
            seen = self.noise.estimate(np.concatenate([self.pose, self.state]), np.concatenate([pose, state]))
            self.seen_pose, self.seen_state = seen[:3], seen[3:]


def moved(pose: np.ndarray, state: np.ndarray, seconds: float) -> np.ndarray:
    """A pose a sample later."""
    (u, v, r), sin, cos = state, np.sin(pose[2]), np.cos(pose[2])
    return pose + seconds * np.array([u * cos - v * sin, u * sin + v * cos, r])
