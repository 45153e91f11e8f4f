"""The documents of a study as dataclasses: what `seatrial.read` gives for JSON files.

Written by scripts/python_documents.py from schemas/; do not edit. A name that is a keyword of Python ends with `_` here.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from typing import Any, Literal

#: Which relative standard error is meant.
AccuracyOf = Literal["overall", "figures"]
#: A way to spend the time of a trial.
Arm = Literal["sequential", "one-shot", "informed", "random"]
#: What a channel is to a search for terms.
ChannelRole = Literal["rudder", "propeller", "ahead", "astern", "thrust", "port", "starboard", "wind", "wind-from", "even", "odd"]
#: What estimators are compared by.
ComparedError = Literal["parameter_error", "simulation_error"]
#: What the cost of a plan counts.
CostUnit = Literal["basic-moves", "seconds", "cost"]
#: The criteria by name.
CriterionName = Literal["d-hessian", "d", "a", "a-relative", "v", "figures"]
#: What data are labelled as where they are not those of a real ship.
DataLabel = Literal["simulated logs"]
#: What is delivered of a search and of forces beside it.
DeliveredKind = Literal["average", "search", "forces"]
#: What is known of a design.
DesignStatus = Literal["optimal", "stationary", "stalled", "restricted", "refined"]
#: The BLAKE3 digest of a file's bytes, what `b3sum FILE` prints; as text `blake3:<64 hex digits>`.
Digest = str
#: What a model's errors are errors of.
ErrorKind = Literal["one-step residual", "free-run error"]
#: What states the errors of a vessel's parameters.
ErrorsFrom = Literal["covariance", "priors"]
#: What became of the estimate of a run, or of a degree of freedom.
EstimateStatus = Literal["identified", "identified, model rejected", "estimated, simulation diverges", "identified, errors approximate", "identified, waves: no errors", "identified, instruments by output error", "not identifiable", "not converged"]
#: How parameters are estimated.
Estimator = Literal["ls", "iv", "output-error", "prediction-error", "auto"]
#: A sum of numbers, each rounded to a multiple of 2⁻⁴⁰: whole numbers are added, so any order gives the same. Written
#: as that whole number, in decimal digits.
ExactSum = str
#: What is left to do of a plan.
FollowStatus = Literal["under-way", "maneuvers-done", "finished"]
#: What instruments are made of.
InstrumentKind = Literal["nominal", "regressors"]
#: What an area or a cell is.
MapClass = Literal["land", "no-go", "depth"]
#: What a margin is kept for.
MapPurpose = Literal["trial", "transit"]
#: Some cells of a raster, row by row from the south: lengths of runs of cells that are alternately out and in, out
#: first.
MapRuns = list[int]
#: How a charted point is drawn.
MapSymbol = Literal["sounding", "danger"]
#: What a part of the track is.
MapTrackKind = Literal["maneuver", "run-in", "basic"]
#: How the instruments' mean is removed: how many intercepts a degree of freedom has, none, one per segment or one.
MeanRemoval = Literal["none", "batch", "complete"]
#: How counts, or choices of candidates, were found.
Method = Literal["exhaustive", "exchange"]
#: Which model is made of all runs.
ModelStructure = Literal["own", "core", "library", "few", "average"]
#: What disturbs runs besides white noise of u, v and r.
NoiseKind = Literal["white", "current", "forces", "forces-each", "forces-and-current", "sensors"]
#: Where the model comes from that instruments are simulated with.
NominalSource = Literal["given", "least-squares", "estimate"]
#: What is known of a plan.
PlanStatus = Literal["optimal", "feasible"]
#: Where the unit of a chart comes from.
PlanUnitFrom = Literal["file", "plan.toml", "assumed"]
#: Why values of a channel were left out.
Reason = Literal["missing", "range", "motion", "frozen", "0 N 0 E", "quality", "incomplete", "time"]
#: What parameters are drawn from.
SampledFrom = Literal["nominal", "covariance"]
#: What became of a model that was to be simulated over validation data.
ScoreStatus = Literal["scored", "diverged", "not identifiable", "not converged"]
#: What is minimised among plans that are equal in that.
Secondary = Literal["seconds", "turns", "clearance"]
#: Part `index` of `count`, written `K/N` with 1 ≤ K ≤ N.
Shard = str
#: Which way a maneuver is run.
Side = Literal["as designed", "mirrored"]
#: Which of the two parameter sets is meant.
Source = Literal["value", "nominal"]
#: Who takes part in a comparison.
Standing = Literal["model", "average of models", "model of the average", "other model", "least squares", "mean of the data"]
#: A velocity.
State = Literal["u", "v", "r"]
#: What became of a step.
StepState = Literal["done", "missed", "spoiled", "under-way", "ahead"]
#: What a candidate is.
Suspect = Literal["term", "late", "current", "sign"]
#: A trial that a design is compared with.
TrialKind = Literal["arranged", "shares", "random", "practice"]
#: What becomes of a model that runs are asked about.
Verdict = Literal["not-rejected", "rejected", "none"]
#: Where a ship waits.
WaitingPlace = Literal["anchorage", "open-water"]
#: What is odd about a channel.
WarningKind = Literal["constant", "unit", "rate", "jump", "source", "clock", "lag", "gain", "bias"]


@dataclass(frozen=True, kw_only=True)
class Ability:
    """What the nominal vessel can do at the speeds of its modes under way."""

    #: Largest yaw rate that its actuators hold in every mode \[rad/s\]; null where no range bounds it.
    turn_rate_rad_s: float | None = None
    #: How fast it can begin to turn in every mode \[rad/s²\]; null where no range bounds it.
    turn_acceleration_rad_s2: float | None = None
    #: How fast it can gain speed in every mode \[m/s²\]; null where no range bounds it.
    acceleration_m_s2: float | None = None
    #: How fast it can lose speed in every mode \[m/s²\]; null where no range bounds it.
    braking_m_s2: float | None = None
    #: How fast it loses speed with all inputs as near to zero as their ranges allow, in its slowest mode \[m/s²\].
    coasting_m_s2: float
    #: Longest lag of its actuators, with the time for which they hold a command \[s\].
    lag_s: float


@dataclass(frozen=True, kw_only=True)
class AbortMove:
    """A move of an abort track, and the pose of the lattice where it ends."""

    #: Name of the basic move.
    action: str
    #: Column, eastward.
    i: int
    #: Row, northward.
    j: int
    #: Heading level, counter-clockwise from east.
    h: int
    #: Speed mode.
    mode: str


@dataclass(frozen=True, kw_only=True)
class AbortTrack:
    """From the end of a leg to the nearest place where she may wait: a charted anchorage if that takes at most ten
    minutes longer, else water with depth and room.
    """

    #: What the place is.
    kind: WaitingPlace
    #: Longitude of the place.
    longitude_deg: float
    #: Latitude of the place.
    latitude_deg: float
    #: The depth that is charted there; absent where none is \[m\].
    depth_m: float | None = None
    #: So far around it her hull keeps its margin \[m\].
    room_m: float
    #: True bearing of the place from where the leg ends; absent where it is the same.
    towards_deg: float | None = None
    #: Distance of the place from there \[m\].
    distance_m: float
    #: Time of the nominal vessel along the track \[s\].
    duration_s: float
    #: Basic moves; none where she waits at the end of the leg.
    moves: list[AbortMove]
    #: Vessels of the check that sailed it after the legs before: the nominal one, the searched ones, and as many of the
    #: drawn ones as exclude that one of a hundred runs aground, with 95 % confidence; 0 without moves.
    vessels: int
    #: Of which touched an obstacle on it.
    aground: int
    #: Least distance from an obstacle on it, of the nominal and the searched ones; absent without moves \[m\].
    clearance_m: float | None = None


@dataclass(frozen=True, kw_only=True)
class Absent:
    """Something that the model lacks or has wrong."""

    #: What it is; a term where this is absent.
    kind: Suspect = "term"
    #: A term, `lag of the inputs`, `delay of the inputs`, an input that acts late, `current`, or a sign in words.
    name: str
    #: `surge`, `sway` or `yaw`; null for what acts in all.
    degree: str | None = None
    #: Unit of the values.
    unit: str
    #: What it would be if it were added: one value, north and east of a current, seconds; of a sign how many times as
    #: the nominal values say the channel acts, and nothing where the ship was fitted again.
    value: list[float]
    #: Standard error of each.
    standard_error: list[float]
    #: The value in the prime system, where it has one.
    prime_value: float | None = None
    #: By which share the cost of a fit of forces would fall; below 0 where it rises.
    share: float | None = None
    #: The least that these runs would nearly always have shown; null of a sign.
    visible_from: float | None = None
    #: How probable it is under the model that anything that was looked for seems as likely.
    p_value: float
    #: −2 log of the probability of it alone.
    evidence: float
    #: Whether it may be what is missing: no other is likelier by far. Whether a sign is wrong.
    candidate: bool
    #: What to do if it is so.
    remedy: str | None = None


@dataclass(frozen=True, kw_only=True)
class Accuracy:
    """The shortest experiment of a wanted accuracy."""

    #: The wanted standard error, relative to the parameters; 1 where it is that of figures, relative to those wanted.
    wanted: float
    #: Which relative standard error.
    of: AccuracyOf
    #: Duration of the experiment \[s\].
    duration_s: float
    #: Its samples.
    samples: int
    #: The accuracy that it is predicted to have.
    reached: float
    #: The range to expect it in, as in `promise`: of `overall`, where the nominal parameters are a guess.
    range: tuple[float, float] | None = None
    #: From which duration on that prediction holds \[s\]: maneuvers that take four fifths of the time are then as long
    #: as in the dictionary, whose matrices the prediction adds up. Trials that are shorter consist of their beginnings,
    #: and err more.
    holds_from_s: float | None = None
    #: Predicted accuracy against time.
    curve: list[AccuracyPoint]
    #: The answer in words.
    statement: str


@dataclass(frozen=True, kw_only=True)
class AccuracyPoint:
    """Predicted accuracy after some time; none where a design excites not every parameter."""

    #: Duration of the experiment \[s\].
    duration_s: float
    #: Of this design.
    design: float
    #: Of equal shares.
    equal: float | None = None
    #: Of the shares that the paper's criterion has for the same maneuvers.
    paper: float | None = None
    #: Median of random designs.
    random: float | None = None


@dataclass(frozen=True, kw_only=True)
class Apart:
    """A recording whose own parameters are not those of the others."""

    #: Its name.
    recording: str
    #: How probable it is, if all are of one ship, that any of them differs as much.
    p_value: float


@dataclass(frozen=True, kw_only=True)
class ArmPoint:
    """An arm after some time, over the realizations; those without an estimate count as infinite errors."""

    #: Time at sea.
    time_s: float
    #: Median of the parameter error.
    median: float | None = None
    #: 95 % interval of that median; null at an end that there are too few realizations for, or that is infinite.
    median_interval: tuple[float | None, float | None] | None = None
    #: Its 90 % quantile.
    q90: float | None = None
    #: 95 % interval of that quantile.
    q90_interval: tuple[float | None, float | None] | None = None
    #: Median of the error that estimates predict of themselves.
    predicted: float | None = None
    #: Share of the realizations whose parameter error is within the accuracy.
    within: float
    #: 95 % interval of that share (Wilson's).
    within_interval: tuple[float, float] | None = None
    #: Realizations with a direction that is not excited.
    not_identifiable: int
    #: Realizations whose search for an estimate did not converge.
    not_converged: int
    #: Realizations in which the nominal model diverges.
    diverged: int
    #: Realizations whose model allowed no design for the last round: all maneuvers shared it.
    undesigned: int


@dataclass(frozen=True, kw_only=True)
class ArmSummary:
    """One way to spend the time of a trial."""

    #: Its name.
    name: Arm
    #: One per round.
    points: list[ArmPoint]


@dataclass(frozen=True, kw_only=True)
class AverageMember:
    """One of the models of an average."""

    #: Its weight in the mean trajectory; those of all add up to 1.
    weight: float
    #: The recordings that its structure was found on.
    found_on: list[str]
    #: The model of that structure, fitted to all recordings. It has no standard errors: the spread of the models takes
    #: their place.
    model: ModelDocument


@dataclass(frozen=True, kw_only=True)
class AverageSummary:
    """What the models of an average are made of."""

    #: Their number.
    models: int
    #: The seed of the draws of recordings.
    seed: int
    #: How many recordings each structure was found on.
    recordings_each: int
    #: Terms that some model has: surge, sway, yaw, those that most models have first.
    terms: list[AverageTerm]


@dataclass(frozen=True, kw_only=True)
class AverageTerm:
    """A term of some of the models."""

    #: `surge`, `sway` or `yaw`.
    degree: str
    #: Name of its parameter.
    name: str
    #: What the parameter multiplies.
    term: str
    #: Whether the structure that the search began with has it.
    base: bool
    #: In how many of the models.
    chosen: int
    #: Least value in these.
    lowest: float
    #: Mean value in these.
    mean: float
    #: Largest.
    highest: float


@dataclass(frozen=True, kw_only=True)
class Bands:
    """Shares of the measured samples inside the 95 % bands of a model: from its parameters' covariance, or how far the
    models of an average are apart, and the errors that its simulations had on what it was fitted to. Of a searched
    model: from its errors on what was left out of the search. Of an average of models that have bands of their own:
    the mean of these, which is wide enough however the models' errors correlate.
    """

    #: Of u.
    inside_u: float
    #: Of v.
    inside_v: float
    #: Of r.
    inside_r: float


@dataclass(frozen=True, kw_only=True)
class BegunPlan:
    """Where a ship was in the plan before, by her positions so far."""

    #: What is known, in words.
    statement: str
    #: What is left to do.
    status: FollowStatus
    #: When the plan began, in UTC; absent where neither the plan nor the positions say.
    departure: str | None = None
    #: When the last position was, in UTC; absent as above.
    at: str | None = None
    #: The same after the departure; after the first position where the plan has no departure and positions have times
    #: of day \[s\].
    at_s: float
    #: Number of positions.
    positions: int
    #: How many more were left out: without a fix, at 0 N 0 E, or where she cannot have come to and back from.
    left_out: int = 0
    #: What is odd about them, in words.
    doubts: list[str] = field(default_factory=list)
    #: Number of the step that the ship is at, from 1.
    step: int
    #: Distance of the ship from where the plan has her, the delay apart \[m\].
    deviation_m: float
    #: How much later she is there than planned; negative where she is earlier \[s\].
    delay_s: float
    #: All steps of the plan.
    steps: list[FollowedStep]
    #: How much of the information of the plan's maneuvers those have that are done.
    information: Gathered
    #: Where the ship continues.
    from_: RestartPoint


@dataclass(frozen=True, kw_only=True)
class BesideForces:
    """Forces of the ship that were fitted beside a search, and what is delivered of the two."""

    #: What `model.json` has.
    delivered: DeliveredKind
    #: How the forces may be fitted.
    tried: list[TriedFit]
    #: The forces alone on recordings that were left out of them; none where a fold lacks a fit, or a window diverged.
    errors: FreeRunErrors | None = None
    #: The same over windows of which one begins at every quarter of another.
    overlapping: FreeRunErrors | None = None


@dataclass(frozen=True, kw_only=True)
class Bounds:
    """Bounds under which an estimate counts as good."""

    #: On the parameter error: the 2-norm over the parameters of (θ̂ − θ)/θ, of θ̂ itself where θ is 0.
    parameter_error: float
    #: On the simulation error: the 2-norm of the RMSE in surge, sway and yaw.
    simulation_error: float


@dataclass(frozen=True, kw_only=True)
class Candidate:
    """One ridge."""

    #: Λ.
    ridge: float
    #: Mean fit of u, v, r over windows of the recordings when they were left out \[%\]; none where a fold was rejected.
    score: float | None = None
    #: Its standard error.
    standard_error: float | None = None
    #: Folds whose fit diverged, or whose model left every bound on what was left out, over windows or over what is
    #: scored.
    rejected: int


@dataclass(frozen=True, kw_only=True)
class CaptiveValue:
    """A value of captive tests beside an estimate."""

    #: The value, in the prime system where there is one, else in SI units.
    value: float
    #: Whether it lies within the estimate's 95 % interval; null where that has none.
    within: bool | None = None


@dataclass(frozen=True, kw_only=True)
class ChannelSummary:
    """One channel of a recording."""

    #: Its name.
    name: str
    #: Its unit.
    unit: str
    #: The inverse of the median step.
    rate_hz: float | None = None
    #: Rows without a value.
    missing: int
    #: Gaps longer than `max_gap_s`.
    gaps: int
    #: Robust standard deviation of what parabolas through 11 neighbours leave.
    noise: float | None = None
    #: Smallest value.
    min: float | None = None
    #: Largest value.
    max: float | None = None


@dataclass(frozen=True, kw_only=True)
class Check:
    """The plan simulated in continuous space."""

    #: Whether the hull keeps its margin and every leg its tolerance in every simulation, in the time that is proved.
    safe: bool
    #: What is broken, in words; empty for a safe plan.
    faults: list[str]
    #: Least distance of the hull from anything charted as an obstacle, nominal model, known current \[m\].
    clearance_m: float
    #: Whether the hull stays clear.
    clear: bool
    #: Distance that was asked for \[m\].
    margin_m: float
    #: By how much the nominal track falls short of that; 0 where it keeps it \[m\].
    shortfall_m: float
    #: Distances are measured as far as this \[m\].
    sight_m: float
    #: Bound on the unknown current \[m/s\].
    unknown_current_m_s: float
    #: Bound on the relative error of every parameter.
    parameter_error: float
    #: Bound on the errors of all parameters jointly, in standard errors of the model; absent where each is bounded
    #: alone.
    standard_errors: float | None = None
    #: What states those standard errors; absent with them.
    errors_from: ErrorsFrom | None = None
    #: Of the currents and parameters.
    seed: int
    #: Simulations of the whole plan, each with a constant current and a vessel of its own, whose parameters are even
    #: within that bound.
    runs: int
    #: Of which touched an obstacle, or went where the chart was not read.
    aground: int
    #: The share of them that this leaves possible, Wilson's 95 %.
    aground_interval: tuple[float, float]
    #: Going aground is less probable than this, 95 % confidence, for a vessel and a current drawn like these. None
    #: where a run went aground.
    aground_bound: float | None = None
    #: Runs that came nearer than the margin, those aground among them.
    below_margin: int
    #: Ends of legs in all runs.
    ends: int
    #: Of which lie beyond a tolerance.
    ends_astray: int
    #: The largest part of a tolerance that the nominal vessel uses at the end of any leg.
    tolerance_used: float
    #: Time that the proved plan takes, leg by leg, each from its node \[s\].
    proved_s: float
    #: Time that the nominal vessel takes for all of it \[s\].
    sailed_s: float
    #: Time that the runs take: least, median, most \[s\].
    sailed_quantiles_s: tuple[float, float, float]
    #: How often the plan was searched, with what earlier checks taught; every check draws anew.
    rounds: int
    #: Runs that left the lattice's area, which is no obstacle.
    left_area: int
    #: Least clearance of each run: smallest, 5 %, median \[m\].
    clearance_quantiles_m: tuple[float, float, float]
    #: The same runs without corrections between maneuvers (the autopilot reckons with the nominal track only).
    aground_open_loop: int
    #: The worst vessels and currents within those bounds that a search found, apart from the drawn ones; absent where
    #: only the nominal vessel in the known current is possible.
    worst: WorstVessels | None = None


@dataclass(frozen=True, kw_only=True)
class ChosenStructure:
    """A structure, and why it was taken."""

    #: Which one.
    chosen: ModelStructure
    #: Why, in words.
    statement: str


@dataclass(frozen=True, kw_only=True)
class Compared:
    """A model beside others on recordings that it was not fitted to."""

    #: Name of the vessel.
    vessel: str
    #: Length of the windows \[s\]; null: whole runs.
    window_s: float | None = None
    #: Number of windows that were simulated.
    windows: int
    #: Their samples.
    samples: int
    #: Standard deviations of the measured states over the windows.
    std_u: float
    #: Of sway speed.
    std_v: float
    #: Of yaw rate.
    std_r: float
    #: The verdict first, then what to know, in words.
    statements: list[str]
    #: The model, then what it is compared with.
    models: list[ComparedModel]
    #: The others against the model.
    differences: list[Difference]
    #: Shares of the samples inside the model's 95 % bands; null where its errors are not known.
    bands: Bands | None = None
    #: How far the models of an average are apart; absent for a single model.
    spread: Spread | None = None
    #: Channels that leave the range that the model was fitted on.
    outside: list[Outside]
    #: How the model's errors correlate with themselves and with inputs: where they do beyond chance, it lacks
    #: something.
    correlations: list[ErrorCorrelations]
    #: Where the ship moves less or more than in any stretch that the model was fitted to; null where that is not known.
    validity: Validity | None = None


@dataclass(frozen=True, kw_only=True)
class ComparedErrors:
    """Errors of one model over some windows. Null where a window diverged, or there is none."""

    #: Windows.
    windows: int
    #: Windows that diverged.
    diverged: int
    #: Samples that were simulated.
    samples: int
    #: Root mean square error of u.
    rmse_u: float | None = None
    #: Of v.
    rmse_v: float | None = None
    #: Of r.
    rmse_r: float | None = None
    #: 100 (1 − RMSE/std), 0 as good as the mean of the data; null where u does not vary.
    fit_u: float | None = None
    #: Of v.
    fit_v: float | None = None
    #: Of r.
    fit_r: float | None = None
    #: Mean of measured less simulated u.
    bias_u: float | None = None
    #: Of v.
    bias_v: float | None = None
    #: Of r.
    bias_r: float | None = None
    #: Norm of RMSE over the standard deviations of u, v, r in all recordings.
    error_norm: float | None = None


@dataclass(frozen=True, kw_only=True)
class ComparedModel:
    """One model over all windows."""

    #: Which.
    name: Standing
    #: Its place among the models that are averaged or compared, from 1, if it is one of several.
    place: int | None = None
    #: Over all windows.
    errors: ComparedErrors
    #: One entry per run or recording.
    recordings: list[ComparedRecording]


@dataclass(frozen=True, kw_only=True)
class ComparedRecording:
    """Those over one run or recording, against the standard deviations of its own states."""

    #: Its name.
    source: str
    #: Its errors.
    errors: ComparedErrors


@dataclass(frozen=True, kw_only=True)
class ConstrainedParameter:
    """A parameter that is not estimated by itself."""

    #: Its name.
    name: str
    #: Its term.
    term: str
    #: Its unit.
    unit: str
    #: Whether its value is known.
    fixed: bool
    #: Else the parameter that it equals …
    tied_to: str | None = None
    #: … times this factor.
    factor: float | None = None
    #: Its value; null where it follows from an estimate that there is not, or from one of each run.
    estimate: float | None = None
    #: Its standard error, where it follows from an estimate.
    standard_error: float | None = None


@dataclass(frozen=True, kw_only=True)
class Counted:
    """What became of the runs of one design by one estimator."""

    #: The design.
    design: str
    #: The estimator.
    estimator: Estimator
    #: Runs.
    runs: int
    #: Runs without an estimate: a direction was not excited.
    not_identifiable: int
    #: Runs without an estimate: a search ended nowhere.
    not_converged: int
    #: Runs whose model diverged.
    diverged: int
    #: Runs whose parameter error lies below its bound.
    parameter_errors_below: int
    #: Runs whose simulation error lies below its bound.
    simulation_errors_below: int
    #: Parameter errors.
    parameter_error: Errors
    #: Simulation errors.
    simulation_error: Errors
    #: RMSE in surge.
    rmse_u: Errors
    #: RMSE in sway.
    rmse_v: Errors
    #: RMSE in yaw rate.
    rmse_r: Errors


@dataclass(frozen=True, kw_only=True)
class CountedRuns:
    """What the realizations of a campaign say together, as counts that merge exactly."""

    #: The bounds that the shares below are counted against.
    bounds: Bounds
    #: Runs of every design that the campaign has.
    realizations: int
    #: Samples of a run.
    samples: int
    #: Samples of the validation runs together.
    validation_samples: int
    #: Seed of all random numbers.
    seed: int
    #: Relative error of the quantiles at most: they are read from histograms.
    quantile_error: float
    #: What became of the runs by each estimator.
    scores: list[EstimatorScores]
    #: Estimators against each other on the same runs.
    paired: list[PairedRatio]
    #: What it says, in words.
    statements: list[str]
    #: The counts that all of this is made of.
    tally: Tally


@dataclass(frozen=True, kw_only=True)
class Counts:
    """Whole segments that approximate the shares."""

    #: Number of segments.
    segments: int
    #: Samples per segment.
    segment_samples: int
    #: Efficiency of the counts against the shares.
    efficiency: float
    #: `exhaustive`: no other counts have a better criterion; `exchange`: no exchange of a segment improves it.
    method: Method | None = None
    #: The fraction of the experiment time that the counts waste at most against the best shares; see `statement`.
    gap: float | None = None
    #: What is known of the counts, in words.
    statement: str | None = None


@dataclass(frozen=True, kw_only=True)
class Covariance:
    """Covariance of estimates."""

    #: Whether those of different degrees of freedom were estimated together; else the entries between them are 0.
    joint: bool
    #: Names of the parameters; `surge constant` and the like where the constants are among them.
    names: list[str]
    #: As many rows as names, row-major.
    entries: list[float]
    #: Sub-experiments or pieces of recordings whose differences the errors come from; absent where they do not.
    parts: int | None = None


@dataclass(frozen=True, kw_only=True)
class CovarianceCriterion:
    """A criterion of the covariance of the instrumental-variable estimate, as `moments --campaign` predicts it."""

    #: Its name on the command line.
    name: CriterionName
    #: What is smallest at the shares, for an experiment of `samples`: Σ_d log det cov θ̂_d (d), Σ weight × variance (a,
    #: a-relative), the mean square of a free run's error (v), or Σ weight × variance/value² of figures of merit and
    #: 10⁻⁵ of that of parameters (figures).
    value: float
    #: Weight of every parameter's variance; with d whether it counts.
    weights: dict[str, float]
    #: Number of samples of the experiment that `value` and `standard_errors` are for; 1 where none was asked for.
    samples: int
    #: Predicted standard error of every parameter, in the parameter's unit; in proportion to 1/√samples.
    standard_errors: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class Covered:
    """The range of a channel in the data."""

    #: Its name.
    name: str
    #: Its unit.
    unit: str
    #: Least value.
    low: float
    #: Largest value.
    high: float


@dataclass(frozen=True, kw_only=True)
class Criticism:
    """What the runs say about the structure of a model: one of terms, whose errors are whitened, or one of forces."""

    #: Whether something is missing beyond chance.
    rejected: bool
    #: What becomes of the model.
    verdict: Verdict
    #: How probable it is under the model that anything looked for seems as likely to be missing; null where nothing
    #: could be looked for, and of forces where a sign is wrong.
    p_value: float | None = None
    #: Whether the noise was stated; else it was found by its likelihood.
    stated_noise: bool
    #: Noise of the measured u; absent where errors were not whitened, as for forces.
    noise_u: float | None = None
    #: Of v.
    noise_v: float | None = None
    #: Of r.
    noise_r: float | None = None
    #: Standard deviation of each component of the current.
    current_std: float | None = None
    #: Over which the current changes, 100,000 where it stays; null for one that is new at every sample.
    current_time_s: float | None = None
    #: Of what kind the noise is; absent where it was stated.
    noise: FoundNoise | None = None
    #: Errors over the noise: 1 where the noise explains them.
    error_ratio: float | None = None
    #: Windows or pieces of them that count as independent; absent where errors were whitened.
    units: int | None = None
    #: Whether the whitened errors of u, v, r are white.
    whiteness: list[Whiteness]
    #: Recordings that contradict the others, the farthest first, up to half of them.
    apart: list[Apart] = field(default_factory=list)
    #: An input that answers what was measured at the same sample; absent where none does.
    feedback: Feedback | None = None
    #: What was looked for: wrong signs, then the most likely first.
    absent: list[Absent]
    #: What could not be told from the terms that there are.
    hidden: list[str]
    #: The verdict and what follows, in words.
    statements: list[str]


@dataclass(frozen=True, kw_only=True)
class Degree:
    """One degree of freedom of a model."""

    #: `surge`, `sway` or `yaw`.
    name: str
    #: What each parameter multiplies, in order; the intercept, `1`, may follow.
    regressors: list[str]
    #: Parameters θ in order.
    parameters: list[str]


@dataclass(frozen=True, kw_only=True)
class DegreeMoments:
    """M = mean of φ̃ ζ̃ᵀ = \\[\\[X̄, Ȳ\\], \\[Z̄ᵀ, 1\\]\\] of one maneuver and degree of freedom."""

    #: `surge`, `sway` or `yaw`.
    name: str
    #: Rows and columns of `M`.
    shape: tuple[int, int]
    #: Row-major entries; row i belongs to regressor i, column j to instrument j.
    M: list[float]
    #: Largest change of an entry between the first and the second half of the maneuver, relative to the root mean
    #: squares of its regressor and instrument: 0 is stationary, 1 is not at all.
    nonstationarity: float
    #: Middle matrix of the estimate's covariance A⁻¹BA⁻ᵀ/N, A = Mᵀ: B = (1/N) Σ ζ̃ E\[εε\] ζ̃ᵀ, row-major, shape as
    #: `M`, rows and columns by instrument; in units of instrument i times instrument j times the state's variance.
    B: list[float] | None = None


@dataclass(frozen=True, kw_only=True)
class DegreeSummary:
    """How well one degree of freedom was excited."""

    #: `surge`, `sway` or `yaw`.
    name: str
    #: Median condition number of the scaled normal matrix over the runs.
    condition_median: float | None = None
    #: 95 % interval of that median; null at an end that there are too few runs for.
    condition_median_interval: tuple[float | None, float | None] | None = None
    #: Its largest value.
    condition_max: float | None = None
    #: The parameter that dominates the weakest direction most often.
    weakest_parameter: str
    #: Share of the runs in which it does.
    weakest_share: float
    #: 95 % interval of that share (Wilson's); absent without runs.
    weakest_share_interval: tuple[float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class DegreeTrust:
    """How far the estimate of one degree of freedom can be trusted."""

    #: `surge`, `sway` or `yaw`.
    name: str
    #: Whether there is an estimate.
    status: EstimateStatus
    #: Why it is not identifiable.
    reason: str | None = None
    #: What the estimate was made with: `auto` takes one for each degree of freedom.
    estimator: Estimator
    #: Condition number of the correlations between instruments and regressors; null where singular.
    condition: float | None = None
    #: Condition index of instruments and regressors with the intercept; from 30 on collinear. Null where singular.
    condition_index: float | None = None
    #: The direction that the data tell least about.
    weakest: str
    #: Its parameters.
    parameters: list[ParameterTrust]
    #: Correlations between the estimates: row-major, as many rows as parameters.
    correlation: list[float] | None = None
    #: Whether the residuals are white: Ljung and Box.
    whiteness: Whiteness | None = None
    #: The largest correlation of residuals with instruments at other times.
    instrument_residual: InstrumentResidual | None = None
    #: How well the instruments follow the measured state: 100 (1 − RMSE/std) over the sub-experiments.
    instrument_fit: float | None = None


@dataclass(frozen=True, kw_only=True)
class Departures:
    """Departures for which a plan holds, the planned one among them: the tide is no worse than what it counts with,
    and the slowest vessel of the check is back in the slot. All in UTC.
    """

    #: The earliest.
    earliest: str
    #: What closes it before.
    before: str
    #: The latest.
    latest: str
    #: What closes it after.
    after: str
    #: The one with most water under the keel, the earliest of equals; absent without a tide.
    best: str | None = None


@dataclass(frozen=True, kw_only=True)
class DerivedHandling:
    """How a vessel of these abilities is handled where nobody says otherwise."""

    #: Handling.
    handling: Handling
    #: What it follows from.
    ability: Ability


@dataclass(frozen=True, kw_only=True)
class DesignDocument:
    """`design.json`: how long to run each maneuver, and how good that is."""

    #: `D`: log|det| of the information matrix; `covariance D`, `A`, `relative A`, `V`, or `figures`: a criterion of the
    #: estimate's covariance, see `covariance`.
    criterion: Literal["D", "covariance D", "covariance A", "covariance relative A", "covariance V", "figures"]
    #: How the instruments' mean is removed, where there are instruments.
    mean_removal: MeanRemoval | None = None
    #: What is known of it.
    status: DesignStatus
    #: The certificate in words.
    statement: str
    #: Parameters that no maneuver excites apart from the others: they were held at their values, and the trial tells
    #: nothing of them.
    held: list[HeldParameter] = field(default_factory=list)
    #: Where its maneuvers leave what the logs of the model cover, in words.
    beyond: list[str] = field(default_factory=list)
    #: Where the parameters that it was designed with are a guess or an estimate: which of its maneuvers, executed by
    #: inputs, many ships with other parameters miss.
    unreached: Unreached | None = None
    #: Share of the experiment time per maneuver, in the dictionary's order; sums to 1.
    shares: dict[str, float]
    #: Maneuver names in the dictionary's order.
    order: list[str]
    #: How many maneuvers there were to choose from, where those without a share are not listed.
    candidates: int | None = None
    #: The criterion's derivative by every share, for `D` g_q = Σ_d tr(M_d(w)⁻¹ M_d,q): above `dimension` a maneuver is
    #: worth more time (above what the maneuvers between their bounds have, where `available` binds). Absent where
    #: inputs were refined instead of shares.
    sensitivities: dict[str, float] = field(default_factory=dict)
    #: p = Σ_q w_q g_q: the total dimension for `D`, the number of parameters for `covariance D`, 1 for A and V; with
    #: the sensitivities.
    dimension: int | None = None
    #: Kiefer–Wolfowitz gap max_q g_q − p; where `available` binds, max Σ g_q v_q − p over the shares v that it allows.
    gap: float | None = None
    #: The gap divided by p.
    relative_gap: float | None = None
    #: log|det| of the information matrix at the shares, whatever the criterion.
    log_det: float | None = None
    #: Efficiency of other shares of the same maneuvers against these.
    efficiency: Efficiency | None = None
    #: Whole segments, where `--segments` asked for them.
    counts: dict[str, int] | None = None
    #: About the counts.
    counted: Counts | None = None
    #: Largest share that every maneuver can have, where `--available` limits them.
    available: dict[str, float] | None = None
    #: About a criterion of the covariance.
    covariance: CovarianceCriterion | None = None
    #: What error of the parameters it promises, where the parameters that this was predicted with are a guess: nominal
    #: ones without true ones.
    promise: DesignPromise | None = None
    #: `output-error` where the covariance is that of an output-error estimate.
    estimator: Estimator | None = None
    #: What is known before contributes, by the priors of a ship's forces or the fit of her model.
    prior: DesignPrior | None = None
    #: About few or long maneuvers, where they were asked for.
    restricted: Restricted | None = None
    #: Standard errors of figures of merit, where `--figures` was given.
    figures: DesignFigures | None = None
    #: How long the experiment has to be, where an accuracy was asked for.
    accuracy: Accuracy | None = None
    #: Order and lengths of the maneuvers, where `--arrange` asked for them: the optimized experiment follows them.
    sequence: Sequence | None = None
    #: How its input signals were refined, where `--refine` asked for it.
    refined: RefinedDesign | None = None


@dataclass(frozen=True, kw_only=True)
class DesignFigure:
    """A figure of merit and its standard errors."""

    #: The maneuver.
    maneuver: str
    #: Its name.
    name: str
    #: What it is.
    what: str
    #: Unit of its value and errors.
    unit: str
    #: Its value for the model.
    value: float
    #: Its weight in the criterion `figures`.
    weight: float
    #: The standard error that was asked for.
    wanted: float | None = None
    #: Its standard error after this experiment.
    standard_error: float
    #: That after the D-optimal experiment of the same maneuvers and time: the one of `design` without `--criterion`.
    d_optimal: float | None = None
    #: The first over the second.
    ratio: float | None = None


@dataclass(frozen=True, kw_only=True)
class DesignFigures:
    """What the experiment leaves uncertain of figures of merit, where `--figures` was given."""

    #: Number of samples of the experiment that standard errors are for; 1 where none was asked for. They are in
    #: proportion to 1/√samples.
    samples: int
    #: All figures with slopes, those without a weight too.
    figures: list[DesignFigure]
    #: Which figures are left out or have no weight, and why.
    left_out: list[str] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class DesignPrior:
    """What priors contribute to the estimates that a design is for."""

    #: By parameter how much of its estimate is the prior's after the trial: 0 none, 1 all.
    shares: dict[str, float]
    #: Which are mostly the prior's, in words.
    statement: str


@dataclass(frozen=True, kw_only=True)
class DesignPromise:
    """The parameter error that a design promises, with a range: an error is relative to a parameter, and the nominal
    one may be off.
    """

    #: Root of Σ (standard error/nominal parameter)², as predicted.
    parameter_error: float
    #: The range that was measured where each nominal parameter was off by a factor e^(0.4 z), z standard normal: 90 %
    #: of trials in one experiment, 31 of 40 in another (docs/design.md).
    range: tuple[float, float]
    #: Both in words.
    statement: str


@dataclass(frozen=True, kw_only=True)
class DesignScores:
    """The errors of one design. A run without an estimate, or whose free simulation diverged, counts as above every
    bound and as infinite in the quantiles (written null).
    """

    #: Name of the design.
    design: str
    #: Number of runs.
    runs: int
    #: Runs without an estimate.
    not_identifiable: int
    #: Runs whose search for an estimate ended nowhere; absent for estimators that search for none.
    not_converged: int | None = None
    #: Runs whose free simulation diverged.
    diverged: int
    #: Share of all runs below the bound on the parameter error.
    parameter_error_share: float
    #: 95 % interval of that share (Wilson's); absent without runs.
    parameter_error_share_interval: tuple[float, float] | None = None
    #: Share of all runs below the bound on the simulation error.
    simulation_error_share: float
    #: 95 % interval of that share (Wilson's); absent without runs.
    simulation_error_share_interval: tuple[float, float] | None = None
    #: Share of all runs that have no estimate.
    without_estimate_share: float | None = None
    #: Of the parameter error.
    parameter_error: Quantiles
    #: Of the simulation error.
    simulation_error: Quantiles
    #: Of the RMSE in surge.
    rmse_u: Quantiles
    #: Of the RMSE in sway.
    rmse_v: Quantiles
    #: Of the RMSE in yaw rate.
    rmse_r: Quantiles


@dataclass(frozen=True, kw_only=True)
class DesignSummary:
    """The estimates of one design."""

    #: Name of the design: `optimized`, `random` …
    design: str
    #: Number of runs.
    runs: int
    #: Runs with an estimate.
    identified: int
    #: Runs whose search for an estimate ended nowhere; absent for estimators that search for none.
    not_converged: int | None = None
    #: Runs that reject the model: something is missing beyond chance; absent where no run was asked.
    rejected: int | None = None
    #: 2-norm of `relative_bias` over the parameters that have one.
    relative_bias: float | None = None
    #: 2-norm of `relative_spread` over the parameters that have one.
    relative_spread: float | None = None
    #: Root of the sum of their squares.
    relative_rms: float | None = None
    #: Least `se_ratio` of all parameters.
    se_ratio_min: float | None = None
    #: Largest `se_ratio` of all parameters.
    se_ratio_max: float | None = None
    #: One entry per parameter, over the identified runs.
    parameters: list[ParameterSummary]
    #: One entry per degree of freedom.
    degrees: list[DegreeSummary]


@dataclass(frozen=True, kw_only=True)
class Difference:
    """How far the error norm of another lies above the first model's, recording by recording, or window by window of
    one recording.
    """

    #: The other.
    name: Standing
    #: Its place among the models that are averaged or compared, from 1, if it is one of several.
    place: int | None = None
    #: Pairs that were compared.
    pairs: int
    #: The median difference; null where it is infinite.
    median: float | None = None
    #: 95 % interval of that median; null at an infinite end. An interval that contains 0 tells no difference.
    interval: tuple[float | None, float | None]


@dataclass(frozen=True, kw_only=True)
class DroppedMove:
    """A move that is not offered to the search."""

    #: Action.
    name: str
    #: Which way, for a maneuver.
    side: Side | None = None
    #: Heading level that it would begin from.
    h: int
    #: Speed mode that it would begin from.
    mode: str
    #: Of which tolerance how much is used at the end of the best that was tried.
    why: str


@dataclass(frozen=True, kw_only=True)
class Efficiency:
    """Efficiencies, for D |det Γ(w)/det Γ(w*)|^(1/n_θ): the fraction of the experiment time that the optimal shares
    would need for the same value of the criterion.
    """

    #: Of equal shares.
    equal_shares: float
    #: Of every maneuver on its own (0: some direction is not excited at all).
    single: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class ErrorCorrelations:
    """How errors of one state correlate with themselves and with inputs at other times. Means over all windows are
    taken out; no pairs across windows.
    """

    #: Of what.
    of: ErrorKind
    #: `u`, `v` or `r`.
    state: str
    #: Number of errors.
    samples: int
    #: 1.96/√samples: 95 % of the correlations of white errors lie within ± this.
    bound: float
    #: With themselves 1, 2, … samples before.
    own: list[float]
    #: With the inputs and measured disturbances that vary.
    inputs: list[InputCorrelations]


@dataclass(frozen=True, kw_only=True)
class Errors:
    """The errors of one kind."""

    #: Their histogram.
    histogram: Histogram
    #: Their sum, in multiples of 2^-40.
    sum: ExactSum
    #: How many are not in the sum: infinite, or too large for it.
    not_in_sum: int


@dataclass(frozen=True, kw_only=True)
class EstimateDocument:
    """`estimate.json`: what the estimates of all runs say together."""

    #: The estimator.
    estimator: Estimator
    #: How the instruments' mean is removed.
    mean_removal: MeanRemoval
    #: Seed of the campaign that the runs come from; absent for runs that were not simulated.
    seed: int | None = None
    #: How far `se_ratio` may be from 1 for standard errors to be trusted.
    trusted_within: float | None = None
    #: One entry per design, in the order of the trajectories.
    designs: list[DesignSummary]
    #: Every estimator on the same runs, where they were compared; `designs` then is that of `estimator`.
    compared: list[EstimatorSummary] | None = None
    #: Parameters that are fixed or tied to others.
    constrained: list[ConstrainedParameter] = field(default_factory=list)
    #: Which model was made of all runs, and why; absent where every run has its own estimate.
    structure: ChosenStructure | None = None
    #: How far the estimate of all runs can be trusted; absent of a ship with forces and of a structure that was
    #: searched for.
    trust: Trust | None = None
    #: How the structure was searched for.
    search: SearchSummary | None = None
    #: Estimators over runs or recordings that were left out, where that was asked for.
    left_out: LeftOutScores | None = None
    #: What a design promised beside what the estimate leaves uncertain.
    promise: PromiseUpdate | None = None


@dataclass(frozen=True, kw_only=True)
class EstimatorRecommendation:
    """Which estimator to use for one design."""

    #: Name of the design.
    design: str
    #: The error that is compared, run by run.
    error: ComparedError
    #: Number of runs.
    runs: int
    #: Estimators that leave a larger share of the runs without an estimate are not considered.
    most_without_estimate: float
    #: The estimator of least median error; null where the runs cannot tell it from another, or all are not considered.
    estimator: Estimator | None = None
    #: The estimator of least median error, and those that the runs cannot tell from it.
    candidates: list[Estimator]
    #: The other estimators that are considered, against that of least median error.
    others: list[PairedDifference]
    #: That in words.
    statement: str


@dataclass(frozen=True, kw_only=True)
class EstimatorScore:
    """One estimator over all folds."""

    #: The estimator.
    name: Estimator
    #: What became of its models.
    status: ScoreStatus
    #: Why there are no errors.
    reason: str | None = None
    #: Over all windows of all folds.
    errors: FreeRunErrors | None = None
    #: Norm of RMSE/std.
    error_norm: float | None = None
    #: Windows that diverged.
    diverged: int
    #: Folds in which surge, sway, yaw were estimated with simulated instruments.
    by_instruments: tuple[int, int, int]
    #: One entry per run or recording, when it was left out; against the standard deviations of its own states.
    sources: list[SourceScore]


@dataclass(frozen=True, kw_only=True)
class EstimatorScores:
    """The errors of one estimator."""

    #: The estimator.
    estimator: Estimator
    #: One entry per design.
    designs: list[DesignScores]


@dataclass(frozen=True, kw_only=True)
class EstimatorSummary:
    """The estimates of one estimator."""

    #: The estimator.
    estimator: Estimator
    #: One entry per design, in the order of the trajectories.
    designs: list[DesignSummary]


@dataclass(frozen=True, kw_only=True)
class Expected:
    """The disturbances that an estimate's covariance is predicted from, white per sample."""

    #: Standard deviation of the measured surge speed \[m/s\].
    std_u_m_s: float
    #: Standard deviation of the measured sway speed \[m/s\].
    std_v_m_s: float
    #: Standard deviation of the measured yaw rate \[rad/s\].
    std_r_rad_s: float
    #: Standard deviation of each component of the current in body axes \[m/s\].
    current_std_m_s: float
    #: Whether the campaign has a current that lasts, whose effect is not predicted.
    lasting_current_left_out: bool = False
    #: Which parameters the residual was linearised with.
    linearised_at: Source
    #: These parameters, in units of the state's increment per unit of the term.
    parameters: dict[str, float]
    #: The nominal parameters, in the same units.
    nominal: dict[str, float]
    #: Duration of a trial of the campaign \[s\].
    trial_s: float | None = None


@dataclass(frozen=True, kw_only=True)
class Feedback:
    """An input that answers what was measured at the same sample."""

    #: The input.
    input: str
    #: The measured state, whose error by prediction it goes with: `u`, `v` or `r`.
    state: str
    #: Correlation of the input's news with that error.
    correlation: float
    #: Probability of a larger one, of any input and state, where inputs know nothing of the errors.
    p_value: float


@dataclass(frozen=True, kw_only=True)
class FigureMerit:
    """A figure of merit over all runs."""

    #: Its name.
    name: str
    #: What it is.
    what: str
    #: Unit of its numbers: `deg`, `deg/s`, `L` (ship lengths), `s`, or the input's.
    unit: str
    #: Its mean over the runs, as it was measured.
    value: float
    #: The mean without the current that the logs show; absent where they show none. The criterion is that of this
    #: value.
    corrected: float | None = None
    #: Its standard deviation; null of a single run.
    std: float | None = None
    #: Lower end of the 95 % interval: of the mean, or of 95 % of the models that the data leave possible; null of a
    #: single run, and where more than 5 % of these have no figures.
    low: float | None = None
    #: Upper end.
    high: float | None = None
    #: The greatest value that IMO MSC.137(76) allows; null where it says nothing of this test.
    most: float | None = None
    #: Whether it keeps to that; null without a criterion, and where the interval holds it.
    passes: bool | None = None
    #: Its derivative by every parameter of the model, in its unit per unit of the parameter, by central differences of
    #: the undisturbed ship; absent without `--slopes`, and where a ship with another parameter has no such figure.
    slopes: dict[str, float] | None = None
    #: Why it has no derivatives, where they were asked for.
    without_slopes: str | None = None


@dataclass(frozen=True, kw_only=True)
class FittedForces:
    """Forces that were fitted to recordings: the ship as written before the fit, and her free numbers after it."""

    #: The ship as a `vessel.toml` has her, with her numbers before the fit and their priors.
    description: str
    #: The free numbers.
    parameters: list[FittedParameter]
    #: Covariance of the free numbers, in the systems that they were written in; 0 at bounds.
    covariance: Covariance
    #: Square root of the largest over the smallest eigenvalue of what the recordings tell, in correlations; null where
    #: they leave a direction open.
    condition: float | None = None
    #: Length of the windows \[s\].
    window_s: float
    #: Number of windows.
    windows: int
    #: Pieces of the windows that count as independent in standard errors.
    pieces: int
    #: Whether every window has a start of its own, or starts at its first measured sample.
    unknown_starts: bool
    #: Whether each row of inputs acted during its whole sample, as in simulated runs; those of logs are linear between
    #: samples.
    held_inputs: bool = False
    #: Weight of the priors.
    prior_weight: float
    #: The mean of Huber's function of the windows' RMS errors in standard deviations, with what the priors add.
    cost: float
    #: Steps of the search.
    steps: int
    #: What the recordings know of sway and yaw: sums of terms along what was sailed; null where nothing was turned.
    sailed: SailedSums | None = None
    #: The publication of captive values, if they were given.
    captive_source: str | None = None
    #: What is wrong with the ship by these recordings; null where that was not asked.
    criticism: Criticism | None = None


@dataclass(frozen=True, kw_only=True)
class FittedParameter:
    """A free number after the fit."""

    #: Its name.
    name: str
    #: Its unit as written; `1` in the prime system.
    unit: str
    #: The estimate.
    value: float
    #: Its standard error; null at a bound.
    standard_error: float | None = None
    #: Its value before the fit.
    prior: float
    #: Standard deviation of its prior; null without one.
    prior_deviation: float | None = None
    #: How much of the estimate is the prior's: 0 none, 1 all.
    prior_share: float
    #: By what the recordings' standard error grows because other parameters are unknown; null where they leave a
    #: direction open.
    inflation: float | None = None
    #: Whether recordings hardly tell it from others: then sums of terms are known, this number alone is not.
    entangled: bool
    #: The estimate in SI units.
    si_value: float
    #: Its SI unit.
    si_unit: str
    #: Its 95 % interval in SI units; null at a bound.
    si_interval: tuple[float, float] | None = None
    #: The estimate in the prime system; null where it has none.
    prime_value: float | None = None
    #: Its 95 % interval in the prime system.
    prime_interval: tuple[float, float] | None = None
    #: The value of captive tests, where it was given.
    captive: CaptiveValue | None = None
    #: Its true value, where the logs were simulated.
    truth: float | None = None


@dataclass(frozen=True, kw_only=True)
class FollowedStep:
    """A step of a plan, and what became of it."""

    #: Name of its action.
    action: str
    #: Whether it is an informative maneuver.
    informative: bool
    #: What became of it.
    state: StepState
    #: The greatest distance of the ship from its track, where she came along it; absent where she did not \[m\].
    deviation_m: float | None = None
    #: Within which it counts as done \[m\].
    within_m: float
    #: Why its maneuver is spoiled; absent where it is not.
    why: str | None = None


@dataclass(frozen=True, kw_only=True)
class Foretold:
    """Errors that estimates of many trials of the same experiment have: medians over estimates drawn from their
    predicted distribution, to first order in their errors. Where the true parameters are known, priors pull every
    estimate the same way.
    """

    #: Median parameter error, as validations define it.
    parameter_error: float
    #: Median simulation error over the validation maneuvers; null without some.
    simulation_error: float | None = None
    #: How many estimates were drawn.
    draws: int


@dataclass(frozen=True, kw_only=True)
class FoundDrift:
    """A force or an error of a sensor that drifts, as a Gauss–Markov process."""

    #: `force` for what is added to the state in a sample, `sensor` for what is added to its measurement.
    of: str
    #: The state: `u`, `v` or `r`.
    state: str
    #: Its standard deviation.
    std: float
    #: The unit of that.
    unit: str
    #: Over which time it drifts, 100,000 where it stays.
    time_s: float


@dataclass(frozen=True, kw_only=True)
class FoundNoise:
    """Noise that was found by its likelihood."""

    #: What there is besides white noise of the sensors.
    kind: NoiseKind
    #: Forces or errors of sensors that drift.
    drifts: list[FoundDrift]
    #: The other kinds, the likeliest first.
    others: list[OtherNoise]
    #: How often noise and parameters were found in turns.
    turns: int
    #: Whether the parameters came to rest.
    at_rest: bool


@dataclass(frozen=True, kw_only=True)
class FoundUnknown:
    """An unknown beside the parameters."""

    #: What it is: `current along` and the like.
    name: str
    #: Its unit.
    unit: str
    #: The estimate.
    value: float
    #: Its standard error; null where it has none, as where it makes no difference.
    standard_error: float | None = None


@dataclass(frozen=True, kw_only=True)
class FreeRunErrors:
    """Errors of free simulations. Fit: 100 (1 − RMSE/std), 0 as good as the mean of the data."""

    #: Of surge speed.
    rmse_u: float
    #: Of sway speed.
    rmse_v: float
    #: Of yaw rate.
    rmse_r: float
    #: Of surge speed; null where it does not vary.
    fit_u: float | None = None
    #: Of sway speed.
    fit_v: float | None = None
    #: Of yaw rate.
    fit_r: float | None = None


@dataclass(frozen=True, kw_only=True)
class FreeRunModel:
    """The model whose free simulation the information of an output-error estimate is about."""

    #: Which parameters it has.
    simulated_with: Source
    #: These parameters, in units of the state's increment per unit of the term.
    parameters: dict[str, float]
    #: Rows and columns of the matrices: the parameters of surge, `intercept (surge)`, then sway and yaw; of a ship with
    #: forces the free numbers alone.
    rows: list[str]
    #: Mean of SᵀS over the validation maneuvers, row-major, S = ∂x/∂θ̃ summed over the states: the variance of a free
    #: run's error is tr(cov G).
    G: list[float] | None = None


@dataclass(frozen=True, kw_only=True)
class FrontPoint:
    """Counts with what they cost and tell."""

    #: Uses of every maneuver.
    counts: dict[str, int]
    #: Cost of the best plan with them.
    cost: float
    #: Time in informative legs \[s\].
    informative_s: float
    #: log|det| of their information.
    log_det: float


@dataclass(frozen=True, kw_only=True)
class Gathered:
    """The planned information of the maneuvers that are done, of that of all in the plan, by the D-criterion."""

    #: Σ of the shares of what is done: 1 where all is, whatever priors know. Absent where the whole plan leaves a
    #: direction unexcited.
    share: float | None = None
    #: exp((log|det| of what is done − that of the plan)/p): 0 until every direction is excited, 1 where all is done.
    efficiency: float | None = None
    #: p.
    dimension: int
    #: Every maneuver of the plan.
    maneuvers: list[GatheredManeuver]


@dataclass(frozen=True, kw_only=True)
class GatheredManeuver:
    """A maneuver of a plan."""

    #: Its name.
    name: str
    #: Its uses in the plan.
    planned: int
    #: Those that are done.
    done: int
    #: tr(M⁻¹ M_q)/p of all its uses in the plan, with the information M of all maneuvers: what the D-criterion grows
    #: by, to first order. With priors, which M then has, p is tr(M⁻¹ M_q) summed over the maneuvers. Absent as above.
    share: float | None = None


@dataclass(frozen=True, kw_only=True)
class Handling:
    """How the vessel is handled between informative maneuvers."""

    #: Largest yaw rate under autopilot \[rad/s\].
    turn_rate_rad_s: float
    #: Speed of repositioning at rest, in surge and sway \[m/s\].
    crawl_m_s: float
    #: Acceleration along a leg that changes speed \[m/s²\].
    acceleration_m_s2: float
    #: Time constant of keeping position, speed and heading \[s\].
    response_s: float
    #: Distance ahead at which a line is aimed at \[m\].
    lookahead_m: float


@dataclass(frozen=True, kw_only=True)
class HeldParameter:
    """A parameter that is held at its value, since no maneuver excites it apart from the others."""

    #: Its name.
    parameter: str
    #: `surge`, `sway` or `yaw`.
    degree: str
    #: Its term.
    term: str


@dataclass(frozen=True, kw_only=True)
class Histogram:
    """How many numbers from 0 fell into each of bins of equal relative width, 256 to an octave. A bin is a number's
    sign, exponent and first bits, so that no rounding decides.
    """

    #: Where each bin that has any begins; it ends 1/256 of its octave further.
    from_: list[float]
    #: How many are in each of these.
    count: list[int]
    #: How many are infinite: there was nothing to be measured.
    beyond: int
    #: The smallest and the largest finite number.
    ends: tuple[float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class Information:
    """log|det| of the information, per the nominal model; none where a direction is not excited at all."""

    #: Promised by the counts: each use adds the moments of its piece.
    predicted_log_det: float | None = None
    #: Of the informative parts of the trajectory actually sailed.
    realised_log_det: float | None = None
    #: The same, with everything between them. None of a ship with forces: simulated without her autopilot for minutes,
    #: an unstable one would seem to tell of her numbers without bound.
    whole_log_det: float | None = None
    #: exp((realised − predicted)/p).
    efficiency: float | None = None
    #: exp((predicted − optimum)/p) for the design's shares over the same time, where a design was given.
    design_efficiency: float | None = None
    #: p.
    dimension: int


@dataclass(frozen=True, kw_only=True)
class IngestDocument:
    """`ingest.json`: what log files became, and how good their data are."""

    #: Name of the vessel that the channels were chosen for, if one was named.
    vessel: str | None = None
    #: Name of the design that the runs belong to.
    design: str
    #: What the logs are where they are not those of a real ship.
    data: DataLabel | None = None
    #: What positions and velocities are those of.
    reference_point: str | None = None
    #: The common rate \[Hz\].
    sample_rate_hz: float
    #: Number of runs.
    runs: int
    #: Samples of all runs.
    samples: int
    #: The maneuvers, in the order of appearance.
    maneuvers: list[ManeuverCount]
    #: One entry per recording, in the order of names.
    recordings: list[RecordingSummary]


@dataclass(frozen=True, kw_only=True)
class InputCorrelations:
    """How errors correlate with one input."""

    #: Its name.
    name: str
    #: With the input −n … n samples before the step that the error ends; below 0 after it. As many on both sides.
    crossed: list[float]


@dataclass(frozen=True, kw_only=True)
class InstrumentResidual:
    """A correlation of residuals with an instrument."""

    #: The instrument's term.
    instrument: str
    #: Samples by which the instrument comes earlier; below 0 later.
    lag: int
    #: The correlation.
    strongest: float
    #: Probability of a larger one, of all lags and instruments tried, under independence.
    p_value: float


@dataclass(frozen=True, kw_only=True)
class LeftOutScores:
    """Free simulation over runs or recordings that were left out of the estimate."""

    #: How the instruments' mean is removed.
    mean_removal: MeanRemoval
    #: Where the instruments' nominal model comes from.
    nominal: NominalSource
    #: Strength of the pull towards it; of forces the weight of their priors.
    prior: float
    #: Whether forces were fitted, which have no instruments.
    forces: bool = False
    #: Whether the estimated intercepts were simulated too.
    intercepts: bool
    #: Length of the windows \[s\]; null: whole runs.
    window_s: float | None = None
    #: Number of windows that were simulated.
    windows: int
    #: Their samples.
    samples: int
    #: Number of folds.
    folds: int
    #: Standard deviations of the measured states over the windows.
    std_u: float
    #: Of sway speed.
    std_v: float
    #: Of yaw rate.
    std_r: float
    #: The estimator with the least median norm of RMSE/std over the recordings; null where they cannot tell it from
    #: another, or none could be simulated over all.
    recommended: Estimator | None = None
    #: That of least median norm, and those that the recordings cannot tell from it.
    candidates: list[Estimator]
    #: The other estimators against that of least median norm, recording by recording.
    differences: list[PairedDifference]
    #: That, and what went wrong, in words.
    statements: list[str]
    #: One entry per estimator.
    estimators: list[EstimatorScore]


@dataclass(frozen=True, kw_only=True)
class LegDrift:
    """With her engine stopped and her rudder amidships, somewhere on a leg: the nominal vessel, and the sampled ones
    in gusts and in the strongest unknown current, each towards another direction.
    """

    #: For how long they drift \[s\].
    lasts_s: float
    #: Vessels, each from several moments of the leg.
    drifted: int
    #: Of which touch an obstacle.
    aground: int
    #: Least distance of any of them from an obstacle; 0 aground \[m\].
    clearance_m: float
    #: When the worst of them is that near, after the engine stops: of those aground the first \[s\].
    nearest_s: float
    #: When in the trial its engine stops \[s\].
    stopped_s: float


@dataclass(frozen=True, kw_only=True)
class Magnitudes:
    """How large the channels were: the range of their root mean squares over stretches of the data, side by side in
    each run. A model holds for motions as large as those that it was fitted to, and as small: a zig-zag of one
    degree stays inside the ranges of all channels. Of n stretches that are like each other and a new one, the new
    one is the least or the largest with probability 2/(n + 1) in each channel.
    """

    #: Length of a stretch \[s\].
    stretch_s: float
    #: Their number.
    stretches: int
    #: Least and largest root mean square: states, inputs, measured disturbances in the model's order. Any of a
    #: direction.
    channels: list[Covered]


@dataclass(frozen=True, kw_only=True)
class ManeuverCount:
    """How much there is of a maneuver."""

    #: Its name.
    name: str
    #: Number of segments.
    segments: int
    #: Their samples.
    samples: int


@dataclass(frozen=True, kw_only=True)
class ManeuverMerit:
    """The figures of merit of a standard maneuver."""

    #: Its name in the dictionary.
    name: str
    #: Its kind; empty where a log shows none.
    kind: str
    #: What was sailed, as the log of the first run shows it; absent where it was simulated.
    sailed: str | None = None
    #: Runs that have the figures.
    runs: int
    #: Runs that lack them.
    without: int
    #: Those of them, draws of a model's parameters, whose simulation diverges.
    diverged: int = 0
    #: Why the first that lacks them does.
    reason: str | None = None
    #: The figures.
    figures: list[FigureMerit]
    #: What is to be known of them: an approach that was not steady, a current, what differs from the dictionary.
    remarks: list[str] = field(default_factory=list)
    #: What the ship did in the first run that has them.
    track: ShipTrack


@dataclass(frozen=True, kw_only=True)
class ManeuverMoments:
    """The moments of one maneuver."""

    #: Name in the dictionary.
    name: str
    #: Number of regression pairs N.
    samples: int
    #: One matrix per degree of freedom; none of a ship with forces.
    degrees: list[DegreeMoments] = field(default_factory=list)
    #: For an output-error estimate.
    output_error: OutputErrorMoments | None = None


@dataclass(frozen=True, kw_only=True)
class MapArea:
    """A polygon."""

    #: What it is.
    class_: MapClass
    #: Its least depth, negative where it dries; of water alone.
    least_m: float | None = None
    #: The outer ring, then the holes.
    rings: list[MapLine]


@dataclass(frozen=True, kw_only=True)
class MapCellClass:
    """Cells of one class."""

    #: What they are.
    class_: MapClass
    #: The least depth of any of them; of water alone.
    least_m: float | None = None
    #: Which they are.
    runs: MapRuns


@dataclass(frozen=True, kw_only=True)
class MapCells:
    """Cells of gridded charts."""

    #: Where the cells are.
    raster: MapRaster
    #: Land, and water of each shade; a cell of none is on no grid.
    classes: list[MapCellClass]


@dataclass(frozen=True, kw_only=True)
class MapContour:
    """A line of one depth."""

    #: Its depth, where it is known.
    depth_m: float | None = None
    #: The line.
    line: MapLine


@dataclass(frozen=True, kw_only=True)
class MapDocument:
    """`map.json`: a planned trial on its chart, for whoever draws it again. Places are metres east and north of an
    origin, on the plane on which directions and distances from the origin are true (azimuthal equidistant, WGS84).
    What comes later in lists lies above.
    """

    #: Whether the plan passes its own check.
    safe: bool
    #: The plan in words.
    statement: str
    #: Uses of every informative maneuver.
    counts: dict[str, int]
    #: Longitude of the origin.
    longitude_deg: float
    #: Latitude of the origin.
    latitude_deg: float
    #: What part of the plane is shown.
    frame: MapFrame
    #: Whether water is where nothing is charted; else such places are an obstacle.
    uncharted_is_water: bool
    #: Limits between shades of depth \[m\], increasing; none where no depth is charted.
    depth_limits_m: list[float]
    #: Cells of gridded charts, below all areas.
    cells: MapCells | None = None
    #: Areas of the chart, cut to the frame.
    areas: list[MapArea]
    #: Lines of one depth.
    contours: list[MapContour]
    #: Cells that are blocked by their depth or by the margin alone.
    margins: list[MapMargin]
    #: Charted points.
    spots: list[MapSpot]
    #: Names of areas, the largest first.
    names: list[MapName]
    #: What hulls sweep in the runs of the check that are kept; absent without any.
    swept: MapSwept | None = None
    #: The corridor of each leg of the passage, as wide as its cross-track distances; rings.
    corridors: list[MapLine]
    #: The area that the hull is kept in, a ring; absent where that is the frame.
    edge: MapLine | None = None
    #: Where speed is limited, rings.
    speed_limits: list[MapLine]
    #: The nominal track in parts.
    tracks: list[MapTrack]
    #: Abort tracks from the ends of legs.
    aborts: list[MapLine] = field(default_factory=list)
    #: The outline of the hull where maneuvers begin, rings.
    hulls: list[MapLine]
    #: Where the trial begins.
    start: MapPlace | None = None
    #: Where it ends.
    goal: MapPlace | None = None
    #: Longitudes of the graticule with their places.
    meridians: list[MapMeridian]
    #: Latitudes of the graticule with their places.
    parallels: list[MapParallel]


@dataclass(frozen=True, kw_only=True)
class MapFrame:
    """A rectangle."""

    #: Its western side.
    west_m: float
    #: Its southern side.
    south_m: float
    #: Its eastern side.
    east_m: float
    #: Its northern side.
    north_m: float


@dataclass(frozen=True, kw_only=True)
class MapLine:
    """Places in their order; the last of a ring is joined with the first."""

    #: East of the origin.
    east_m: list[float]
    #: North of the origin, as many.
    north_m: list[float]


@dataclass(frozen=True, kw_only=True)
class MapMargin:
    """Cells that are blocked by their depth or by the margin alone."""

    #: For what.
    purpose: MapPurpose
    #: Where the cells are.
    raster: MapRaster
    #: Which are blocked.
    runs: MapRuns


@dataclass(frozen=True, kw_only=True)
class MapMeridian:
    """A longitude of the graticule."""

    #: The longitude.
    longitude_deg: float
    #: Where it is, half-way up the frame.
    east_m: float


@dataclass(frozen=True, kw_only=True)
class MapName:
    """A name."""

    #: Where it stands.
    place: MapPlace
    #: The name.
    name: str


@dataclass(frozen=True, kw_only=True)
class MapParallel:
    """A latitude of the graticule."""

    #: The latitude.
    latitude_deg: float
    #: Where it is, half-way across the frame.
    north_m: float


@dataclass(frozen=True, kw_only=True)
class MapPlace:
    """A place."""

    #: East of the origin.
    east_m: float
    #: North of the origin.
    north_m: float


@dataclass(frozen=True, kw_only=True)
class MapRaster:
    """Square cells: columns from west to east, rows from south to north."""

    #: Western side of the first column.
    west_m: float
    #: Southern side of the first row.
    south_m: float
    #: Side of a cell.
    cell_m: float
    #: Columns.
    columns: int
    #: Rows.
    rows: int


@dataclass(frozen=True, kw_only=True)
class MapSpot:
    """A charted point."""

    #: Where it is.
    place: MapPlace
    #: How it is drawn.
    symbol: MapSymbol
    #: Depth over it, where it is known.
    depth_m: float | None = None
    #: What it is, with its name and depth.
    title: str


@dataclass(frozen=True, kw_only=True)
class MapSwept:
    """Cells that hulls sweep."""

    #: Vessels that sail.
    vessels: int
    #: Where the cells are.
    raster: MapRaster
    #: Which are swept.
    runs: MapRuns


@dataclass(frozen=True, kw_only=True)
class MapTrack:
    """A part of the nominal track."""

    #: What it is.
    kind: MapTrackKind
    #: Name of the maneuver that is run, or run in to.
    maneuver: str | None = None
    #: Number of a maneuver among all that are run, from 1.
    number: int | None = None
    #: Up to where the next part begins.
    line: MapLine


@dataclass(frozen=True, kw_only=True)
class Margin:
    """How far one norm of RMSE/std lies above another, recording by recording: the base structure's above the found
    models', where nothing else is said.
    """

    #: Recordings that were compared.
    pairs: int
    #: The median difference; null where it is infinite.
    median: float | None = None
    #: 95 % interval of that median; null at an infinite end. An interval that contains 0 tells no difference.
    interval: tuple[float | None, float | None]


@dataclass(frozen=True, kw_only=True)
class MeritDocument:
    """`merit.json`: figures of merit of standard maneuvers."""

    #: Name of the vessel.
    vessel: str
    #: Its length between perpendiculars.
    length_m: float
    #: Of what the intervals are: `runs`, or the `parameters` of a model.
    intervals: str
    #: Every figure in words.
    statements: list[str]
    #: The maneuvers, in the order of the dictionary.
    maneuvers: list[ManeuverMerit]
    #: Where the figures' slopes were computed; absent without `--slopes`.
    slopes_at: SlopesAt | None = None


@dataclass(frozen=True, kw_only=True)
class MissedAim:
    """Something that is wanted of a motion."""

    #: What it is, in words: `change of heading`.
    what: str
    #: How many ships miss it beyond a quarter.
    ships: int


@dataclass(frozen=True, kw_only=True)
class ModelChannel:
    """A measured disturbance."""

    #: Name as used in terms and as a column.
    name: str
    #: Its unit.
    unit: str
    #: What it is wherever a trial is simulated, in its unit.
    simulated: float | None = None
    #: What it is to a search for terms; found by unit and name without it.
    role: ChannelRole | None = None


@dataclass(frozen=True, kw_only=True)
class ModelDegree:
    """The equation of one degree of freedom; its numbers are per sample, in the unit of its state."""

    #: `surge`, `sway` or `yaw`.
    name: str
    #: The state that gains: `u`, `v` or `r`.
    state: str
    #: Its unit.
    unit: str
    #: Its terms.
    parameters: list[ModelParameter]
    #: What the state gains in a sample whatever the vessel does.
    constant: float
    #: The same by least squares, with `least_squares` of the parameters.
    constant_least_squares: float | None = None
    #: Standard deviation of what terms and constant leave of the measured increments.
    increment_std: float
    #: RMSE of free simulations over the recordings that were fitted; null where one diverges.
    output_rmse: float | None = None


@dataclass(frozen=True, kw_only=True)
class ModelDerived:
    """A channel that is computed from others."""

    #: Name as used in terms and as a column.
    name: str
    #: Its unit.
    unit: str
    #: What it is.
    formula: str
    #: What it is to a search for terms; found by unit and name without it.
    role: ChannelRole | None = None


@dataclass(frozen=True, kw_only=True)
class ModelDocument:
    """`model.json`: a model as it was estimated, with all that it takes to simulate it. Every stage that takes a
    `vessel.toml` takes it instead. The state x = (u, v, r) goes from sample to sample by x(k+1) = x(k) + Σ value ·
    term + constant, the terms at sample k.
    """

    #: Name of the vessel.
    vessel: str
    #: The sampling rate that the values hold for.
    sample_rate_hz: float
    #: Inputs, in order.
    inputs: list[ModelInput]
    #: Measured disturbances, in order.
    measured: list[ModelChannel]
    #: Channels that are computed from inputs, measured disturbances and each other.
    derived: list[ModelDerived] = field(default_factory=list)
    #: Surge, sway, yaw; without terms where the model is made of forces.
    degrees: list[ModelDegree]
    #: Forces that the model is made of, in place of terms per sample.
    forces: FittedForces | None = None
    #: Covariance of the values that were estimated by themselves, 0 at bounds; null where some have no standard error,
    #: for the estimate of a single run, and where the structure was searched for: a ridge or a choice of terms leaves
    #: none that hold.
    covariance: Covariance | None = None
    #: The estimator.
    estimator: Estimator
    #: How the instruments' mean is removed.
    mean_removal: MeanRemoval
    #: Regression pairs.
    samples: int
    #: What each run or recording gains beside the terms.
    recordings: list[RecordingConstant]
    #: The current that was found with it, where one was unknown.
    surroundings: list[Surroundings] = field(default_factory=list)
    #: What the data covered: the model is known to hold within.
    covered: list[Covered]
    #: How large the motions were that it was fitted to; null where no run was long enough, and from sums of runs.
    magnitudes: Magnitudes | None = None
    #: Where the structure was searched for: RMSE of u, v \[m/s\], r \[rad/s\] of free simulations over recordings that
    #: were left out of the whole search, which bands of predictions come from; null where some diverged.
    left_out_rmse: tuple[float, float, float] | None = None
    #: Whether the data reject the structure; null where that could not be tried. Of a searched model: whether
    #: recordings that were left out of the whole search speak against it.
    rejected: bool | None = None
    #: What to know before using the model, in words.
    statements: list[str]
    #: Models whose trajectories are averaged for predictions, where an average was made; the others are this model
    #: alone.
    members: list[AverageMember] = field(default_factory=list)
    #: RMSE of u, v \[m/s\], r \[rad/s\] of that average over the recordings that were fitted; null where a model
    #: diverges.
    average_rmse: tuple[float, float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class ModelInput:
    """An input."""

    #: Name as used in terms and as a column.
    name: str
    #: Its unit.
    unit: str
    #: Another input that this one is coupled to …
    follows: str | None = None
    #: … by this factor.
    factor: float | None = None
    #: Between which the actuator can be set.
    range: tuple[float, float] | None = None
    #: Time constant with which the actuator follows a command \[s\].
    lag_s: float | None = None
    #: How much it changes in a second at most.
    rate_per_s: float | None = None
    #: How far a command has to be from the setting to move the actuator.
    dead_band: float | None = None
    #: How long the actuator follows a command before it takes the next one \[s\].
    hold_s: float | None = None
    #: What it is to a search for terms; found by unit and name without it.
    role: ChannelRole | None = None


@dataclass(frozen=True, kw_only=True)
class ModelParameter:
    """A term with its value."""

    #: Its name.
    name: str
    #: What it multiplies.
    term: str
    #: Its unit.
    unit: str
    #: The estimate.
    value: float
    #: Its standard error; null at a bound, and where the structure was searched for.
    standard_error: float | None = None
    #: Of a searched structure of few terms: 2.5 % of the searches over recordings that were drawn again found less.
    low: float | None = None
    #: 2.5 % found more.
    high: float | None = None
    #: Whether the value was known and not estimated.
    fixed: bool = False
    #: Another parameter that it equals …
    tied_to: str | None = None
    #: … times this factor.
    factor: float | None = None
    #: Between which estimates stay; null at an open end.
    bounds: tuple[float | None, float | None] | None = None
    #: Whether it lies at a bound.
    at_bound: bool = False
    #: The estimate by least squares of the same data, to be compared with.
    least_squares: float | None = None
    #: The true value, where the logs were simulated.
    truth: float | None = None


@dataclass(frozen=True, kw_only=True)
class MomentsDocument:
    """`moments.json`: the lifted moment matrices of every maneuver."""

    #: Name of the vessel.
    vessel: str
    #: Sampling rate \[Hz\].
    sample_rate_hz: float
    #: What the instruments are made of; a ship with forces has none.
    instruments: InstrumentKind | None = None
    #: What each row and column of the matrices stands for. Of a ship with forces one block of its free numbers, without
    #: intercepts.
    degrees: list[Degree]
    #: One entry per maneuver, in the dictionary's order.
    maneuvers: list[ManeuverMoments]
    #: Parameters that no maneuver excites apart from the others, which are held at their values.
    held: list[HeldParameter] = field(default_factory=list)
    #: Where the maneuvers leave what the logs of the model cover, in words.
    beyond: list[str] = field(default_factory=list)
    #: What the matrices `B` were computed from, where there are any.
    disturbances: Expected | None = None
    #: What the matrices `F` and `P` of an output-error estimate are about, where there are any.
    output_error: FreeRunModel | None = None
    #: What is known of the ship before the trial: by the fit of her model, or by the priors of her forces.
    prior: PriorInformation | None = None
    #: What ships with other parameters do, where the true ones are not known and the maneuvers were simulated.
    sampled: SampledShips | None = None


@dataclass(frozen=True, kw_only=True)
class MotionSummary:
    """A measured velocity beside the derivative of position or heading."""

    #: The velocity.
    state: State
    #: Root mean square of measured − derivative.
    rms: float
    #: Robust standard deviation of measured − derivative: where it is far below `rms`, a few jumps of the position make
    #: up most of that.
    robust_std: float
    #: Mean of measured − derivative.
    bias: float
    #: By how much the measured velocity is late; null where there is too little motion to tell. Where a filter and no
    #: pure delay is behind it, it depends on `velocities.window_s`.
    lag_s: float | None = None
    #: Slope of the line of measured over derivative, 1 where both are in the same unit and count alike; null where they
    #: are not correlated.
    gain: float | None = None


@dataclass(frozen=True, kw_only=True)
class NearestDanger:
    """Land, a shoal or another thing to keep clear of."""

    #: What it is and its name, as the chart has them.
    what: str
    #: How far it is, with the doubt about its place taken off \[m\].
    distance_m: float
    #: Its true bearing from the ship, where she comes nearest to it.
    bearing_deg: float


@dataclass(frozen=True, kw_only=True)
class NestedAverage:
    """The mean trajectory of several models on recordings that were left out of finding every one of them."""

    #: Over all recordings; none where a fold lacks a model, or a window diverged.
    errors: FreeRunErrors | None = None
    #: The same over windows of which one begins at every quarter of another.
    overlapping: FreeRunErrors | None = None
    #: Windows in which a model diverged.
    diverged: int
    #: How far the single model's norm of RMSE/std lies above, recording by recording.
    over_search: Margin | None = None
    #: How far the base structure's does.
    over_base: Margin | None = None


@dataclass(frozen=True, kw_only=True)
class NestedRecording:
    """One recording when it was left out."""

    #: Its name.
    source: str
    #: The fold it is in.
    fold: int
    #: Errors of the found model, against the standard deviations of its own states.
    search: FreeRunErrors | None = None
    #: Those of the base structure.
    base: FreeRunErrors | None = None
    #: Norm of RMSE over the standard deviations of all recordings' states.
    search_norm: float | None = None
    #: That of the base structure.
    base_norm: float | None = None
    #: Windows in which the found model diverged.
    search_diverged: int = 0
    #: Errors of the mean trajectory, where an average was asked for.
    average: FreeRunErrors | None = None
    #: Its norm.
    average_norm: float | None = None


@dataclass(frozen=True, kw_only=True)
class NestedScore:
    """The whole algorithm judged by recordings that it has not seen, beside the base structure."""

    #: The ridge that was chosen without each fold; none where no candidate was left. Empty for a ship with forces.
    ridges: list[float | None]
    #: Over all recordings; none where a fold has no model, or a window diverged.
    search: FreeRunErrors | None = None
    #: Those of the base structure.
    base: FreeRunErrors | None = None
    #: As `search`, over windows of which one begins at every quarter of another: where the first begins hardly counts.
    search_overlapping: FreeRunErrors | None = None
    #: Those of the base structure.
    base_overlapping: FreeRunErrors | None = None
    #: Windows in which the found models diverged.
    diverged: int
    #: Recording by recording.
    recordings: list[NestedRecording]
    #: Against the base structure.
    margin: Margin | None = None
    #: The mean trajectory of several models that were found so, where an average was asked for.
    average: NestedAverage | None = None


@dataclass(frozen=True, kw_only=True)
class Omission:
    """Values of a channel that were left out for one reason."""

    #: The channel, or the column where no channel was made of it.
    channel: str
    #: Why.
    reason: Reason
    #: How many.
    count: int


@dataclass(frozen=True, kw_only=True)
class OtherNoise:
    """A kind of noise that is less likely."""

    #: The kind.
    kind: NoiseKind
    #: By how much its twice restricted log-likelihood, less 2 for every level, is below that of the kind that was
    #: taken.
    below: float


@dataclass(frozen=True, kw_only=True)
class OutputErrorMoments:
    """What one maneuver tells an output-error estimate, per sample: matrices with `rows` of the model, row-major."""

    #: Mean of SᵀWS, W the channels' weights 1/variance: Fisher's information where only white measurement errors
    #: disturb.
    F: list[float]
    #: What measurement errors add to the middle matrix of the covariance F⁻¹(E + P)F⁻¹/N; F where there is none.
    E: list[float] | None = None
    #: What the current adds.
    P: list[float] | None = None


@dataclass(frozen=True, kw_only=True)
class Outside:
    """How often a channel leaves the range that the model was fitted on."""

    #: The channel: a state as simulated, an input or measured disturbance as logged.
    name: str
    #: Its unit.
    unit: str
    #: Least value that the model was fitted on.
    low: float
    #: Largest.
    high: float
    #: Samples outside.
    samples: int
    #: Their share.
    share: float


@dataclass(frozen=True, kw_only=True)
class PairCounts:
    """Two estimators on the same runs of one design."""

    #: The design.
    design: str
    #: The one.
    one: Estimator
    #: The other.
    other: Estimator
    #: Runs whose parameter error lies below its bound by the one alone.
    only_one_below: int
    #: Runs whose parameter error lies below its bound by the other alone.
    only_other_below: int
    #: Parameter error of the other over that of the one, run by run; 1 where neither has one.
    ratio: Histogram


@dataclass(frozen=True, kw_only=True)
class PairedDifference:
    """The error of one estimator less that of another on the same runs or recordings."""

    #: Which.
    estimator: Estimator
    #: The median difference; null where it is infinite.
    median: float | None = None
    #: 95 % interval of that median; null at an infinite end. An interval that contains 0 tells no difference.
    interval: tuple[float | None, float | None]


@dataclass(frozen=True, kw_only=True)
class PairedRatio:
    """Two estimators on the same runs."""

    #: The design.
    design: str
    #: The one.
    one: Estimator
    #: The other.
    other: Estimator
    #: Median over the runs of the other's parameter error over the one's; null where it is infinite.
    median_ratio: float | None = None
    #: 95 % interval of that median. One that contains 1 tells no difference.
    median_ratio_interval: tuple[float | None, float | None]
    #: Share of the runs in which the one alone lies below its bound.
    only_one_below: Share
    #: Share of the runs in which the other alone does.
    only_other_below: Share


@dataclass(frozen=True, kw_only=True)
class ParameterSummary:
    """One parameter over the runs of one design. The unit stands beside it."""

    #: Name as in `vessel.toml`.
    name: str
    #: Its unit.
    unit: str
    #: True value, where `vessel.toml` has one.
    truth: float | None = None
    #: Nominal value.
    nominal: float
    #: Mean estimate (null without identified runs).
    mean: float | None = None
    #: Standard deviation of the estimates over the runs (null below two runs).
    spread: float | None = None
    #: Median of the predicted standard errors, 0 at a bound.
    predicted_se: float | None = None
    #: Runs whose estimate lies at a bound; absent without bounds.
    at_bound: int | None = None
    #: (mean − truth)/|truth|; absent where the truth is not known or 0.
    relative_bias: float | None = None
    #: spread/|truth|; absent as well.
    relative_spread: float | None = None
    #: Predicted standard error over the spread: near 1 where standard errors can be trusted.
    se_ratio: float | None = None
    #: Whether it is within `trusted_within` of 1.
    se_trusted: bool | None = None


@dataclass(frozen=True, kw_only=True)
class ParameterTrust:
    """How far the estimate of one parameter can be trusted."""

    #: Name as in `vessel.toml`.
    name: str
    #: Its term.
    term: str
    #: Its unit.
    unit: str
    #: The estimate.
    estimate: float | None = None
    #: Its standard error: sandwich with autocorrelation; of `output-error` with any correlation within a sub-
    #: experiment. None at a bound, and where there is only one.
    standard_error: float | None = None
    #: Whether it lies at a bound beyond which the data pull it.
    at_bound: bool = False
    #: Its standard deviation over the resamples.
    bootstrap_std: float | None = None
    #: 2.5 % of the resamples are below.
    bootstrap_low: float | None = None
    #: 2.5 % are above.
    bootstrap_high: float | None = None
    #: Size of the term without its mean over its size: 0 for a constant.
    variation: float
    #: Shea's partial R² of the instruments: 1 least squares, near 0 instruments that have lost the motion.
    instrument_strength: float | None = None


@dataclass(frozen=True, kw_only=True)
class Passage:
    """The voyage as a bridge plans it: courses from waypoint to waypoint. Straight moves on one course are one leg; a
    turn under way is a waypoint where its two courses cross.
    """

    #: When the trial begins, in UTC; absent where `plan.toml` does not say.
    departure: str | None = None
    #: The tide that the plan counts with; absent without a table.
    tide: Tide | None = None
    #: Departures for which the same plan holds; absent where nothing says when it may be.
    departures: Departures | None = None
    #: Longitude of the first waypoint.
    longitude_deg: float
    #: Latitude of the first waypoint.
    latitude_deg: float
    #: What is done at the first waypoint before going on.
    before: list[str]
    #: When she goes on from there, after the departure \[s\].
    leave_s: float
    #: In the order of sailing.
    legs: list[PassageLeg]


@dataclass(frozen=True, kw_only=True)
class PassageLeg:
    """A leg of the passage."""

    #: What is done on it.
    what: str
    #: Whether an informative maneuver is run on it.
    informative: bool
    #: Longitude of the waypoint where it ends.
    longitude_deg: float
    #: Latitude of that waypoint.
    latitude_deg: float
    #: Course along the loxodrome, true.
    course_deg: float
    #: Distance between the waypoints \[m\].
    distance_m: float
    #: Mean speed over ground along the simulated track \[m/s\].
    speed_m_s: float
    #: When the ship is at its waypoint, after the departure \[s\].
    end_s: float
    #: When she goes on from there, after what is done there \[s\].
    leave_s: float
    #: Radius of the ship's turn onto the next leg \[m\]; absent where it does not turn under way.
    turn_radius_m: float | None = None
    #: Cross-track distance to port of the line between the waypoints \[m\]: as far as the nominal track and those of
    #: the check that are kept come, at least 10 m and what positions and the hull are uncertain by, and no farther than
    #: the water is clear, unless the nominal track comes there.
    xtd_port_m: float
    #: The same to starboard \[m\].
    xtd_starboard_m: float
    #: Least charted depth between its cross-track distances, at the chart's datum; absent where none is charted \[m\].
    least_depth_m: float | None = None
    #: How much deeper she is at the speed of this leg; absent without `hull.block_coefficient` \[m\].
    squat_m: float | None = None
    #: What remains under the keel at the tide's least level; absent without `hull.draught_m`, too \[m\].
    under_keel_m: float | None = None
    #: The danger nearest to the nominal track of the reference point.
    nearest: NearestDanger | None = None
    #: Charted things near the nominal track that a bridge knows of: whom to call, what lies on the ground, where others
    #: meet.
    passes: list[str] = field(default_factory=list)
    #: What is done at its waypoint before going on, such as a turn on the spot.
    then: list[str]


@dataclass(frozen=True, kw_only=True)
class PlanChart:
    """A chart with objects or depths that the plan was made on."""

    #: Name of its file.
    file: str
    #: Edition of a cell.
    edition: str | None = None
    #: Its last update.
    update: int | None = None
    #: When that was issued, as YYYYMMDD.
    issued: str | None = None
    #: Its compilation scale: 1 to this.
    scale: int | None = None
    #: What its depths are measured from.
    sounding_datum: str | None = None
    #: What its heights and clearances are measured from.
    vertical_datum: str | None = None
    #: What is to be said of its files: updates that are not there or not applied, checksums.
    notes: list[str] = field(default_factory=list)
    #: What became of its objects, by class.
    classes: dict[str, PlanChartClass]
    #: What its depths are measured in.
    depths: PlanDepths | None = None


@dataclass(frozen=True, kw_only=True)
class PlanChartClass:
    """What became of the objects of one class."""

    #: Objects of the class on the whole chart.
    objects: int
    #: Of which the ship keeps clear, or which it judges by their depth.
    avoided: int
    #: Of which only informative maneuvers keep clear.
    maneuvers_avoid: int
    #: Of which without effect.
    ignored: int
    #: Why they are, with their numbers.
    reasons: dict[str, int] = field(default_factory=dict)


@dataclass(frozen=True, kw_only=True)
class PlanDepths:
    """What the depths, or heights, of a chart are measured in, and from."""

    #: Their unit, as in `plan.toml`: m, dm, cm, mm, km, ft, us-ft or fathom.
    unit: str
    #: Where that comes from.
    unit_from: PlanUnitFrom
    #: The file's numbers were multiplied by this.
    scale: float
    #: This was added then, in the unit.
    offset: float
    #: The vertical datum; absent where the file does not state one.
    datum: str | None = None
    #: Cells outside of a range that the file calls valid: none, since no format that is read has one.
    invalid: int


@dataclass(frozen=True, kw_only=True)
class PlanDocument:
    """`plan.json`: a walk over the lattice that uses every maneuver as often as asked, and what becomes of it at sea.
    """

    #: Whether the plan is proved to be the best.
    status: PlanStatus
    #: The status in words.
    statement: str
    #: What the cost counts.
    cost_unit: CostUnit
    #: Cost of the plan.
    cost: float
    #: No plan costs less.
    lower_bound: float
    #: By how much another plan might cost less; 0 where the status is `optimal`.
    gap: float
    #: What breaks ties, and its value; minimal among the cheapest plans where the status is `optimal`.
    secondary: SecondaryCost | None = None
    #: Uses of every informative maneuver.
    counts: dict[str, int]
    #: The plan.
    steps: list[PlanStep]
    #: The plan at sea; absent for a problem file.
    voyage: Voyage | None = None
    #: What became of the objects of electronic charts, and what depths are measured in.
    charts: list[PlanChart] = field(default_factory=list)
    #: Where its maneuvers leave what the logs of the model cover, in words.
    beyond: list[str] = field(default_factory=list)
    #: Of the rest of a plan that was begun, by positions: what is done of it. With nothing left to plan there are no
    #: steps.
    begun: BegunPlan | None = None


@dataclass(frozen=True, kw_only=True)
class PlanHandling:
    """How the vessel is handled between maneuvers."""

    #: As planned: what `plan.toml` states, else what follows from the vessel.
    used: Handling
    #: What follows from the vessel.
    derived: DerivedHandling


@dataclass(frozen=True, kw_only=True)
class PlanLattice:
    """The lattice of a voyage."""

    #: Nodes eastward.
    nx: int
    #: Nodes northward.
    ny: int
    #: Heading levels.
    headings: int
    #: Distance of neighbouring nodes \[m\].
    cell_m: float
    #: Longitude of node (0, 0).
    longitude_deg: float
    #: Latitude of node (0, 0).
    latitude_deg: float
    #: Speeds of the modes \[m/s\].
    modes: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class PlanPose:
    """A pose of the lattice."""

    #: Column, eastward.
    i: int
    #: Row, northward.
    j: int
    #: Heading level, counter-clockwise from east.
    h: int
    #: Speed mode, where there are any.
    mode: str | None = None


@dataclass(frozen=True, kw_only=True)
class PlanStep:
    """One move."""

    #: Name of the action.
    action: str
    #: Index among the action's moves from this heading (and speed mode).
    variant: int
    #: Where it begins.
    from_: PlanPose
    #: Where it ends.
    to: PlanPose
    #: What it costs.
    cost: float


@dataclass(frozen=True, kw_only=True)
class PlayedMotion:
    """A maneuver by inputs, and what other ships do with these."""

    #: Its name.
    maneuver: str
    #: By what is wanted of the motion, in words, how many ships miss it.
    missed: list[MissedAim]


@dataclass(frozen=True, kw_only=True)
class Primitive:
    """A maneuver as a move of the lattice."""

    #: Name of the maneuver.
    maneuver: str
    #: Which way.
    side: Side
    #: Heading level at its start.
    h: int
    #: Displacement in nodes, east.
    di: int
    #: Displacement in nodes, north.
    dj: int
    #: Heading level at its end.
    to_h: int
    #: The maneuver \[s\].
    maneuver_s: float
    #: With approach and recovery \[s\].
    leg_s: float
    #: Distance from the node at its end, under the nominal model \[m\].
    residual_m: float
    #: Difference from the level's heading at its end \[deg\].
    residual_deg: float
    #: Largest distance from the nominal vessel of those who rehearsed it, before the recovery \[m\].
    spread_m: float
    #: Nodes of the lattice at which it fits on the chart.
    fits: int


@dataclass(frozen=True, kw_only=True)
class PriorInformation:
    """What is known of parameters before the trial: it counts once for the whole trial, as `F` times samples does."""

    #: The parameters that something is known of.
    parameters: list[str]
    #: The inverse of their covariance, row-major: that of a fit, or 1/σ² of each by its prior, σ its standard
    #: deviation.
    information: list[float]


@dataclass(frozen=True, kw_only=True)
class PromiseUpdate:
    """What a design promised, and what an estimate of its trial leaves uncertain."""

    #: The update in words.
    statement: str
    #: The estimator of the estimate.
    estimator: Estimator
    #: Samples of the trial.
    samples: int
    #: Its duration \[s\]. All promises are for this length.
    duration_s: float
    #: Every parameter, in order.
    parameters: list[UpdatedParameter]
    #: Root of Σ (standard error/scale)², with the fixed scales of `parameters`; absent where one is zero.
    parameter_error: UpdatedError | None = None
    #: The criterion of the design, where parameters alone tell it.
    criterion: UpdatedCriterion | None = None
    #: Figures of merit, where they were given.
    figures: list[UpdatedFigure] = field(default_factory=list)
    #: Root of Σ (standard error/scale)² after one more trial of the same design and length.
    after_another: float | None = None
    #: How much longer trials of the same design have to be, where an accuracy was asked for.
    accuracy: UpdatedAccuracy | None = None
    #: What to know before using it, in words.
    statements: list[str] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class Promised:
    """What a trial promises."""

    #: Which trial.
    trial: TrialKind
    #: Its errors; null where it does not tell every parameter.
    errors: Foretold | None = None


@dataclass(frozen=True, kw_only=True)
class PublishedLimits:
    """Errors at which the figures of a published study end."""

    #: Norm of the RMSE as numbers.
    rmse_norm: float
    #: RMSE in surge.
    rmse_u: float
    #: RMSE in sway.
    rmse_v: float
    #: RMSE in yaw rate.
    rmse_r: float


@dataclass(frozen=True, kw_only=True)
class Quantiles:
    """Quantiles over the runs; null where the quantile falls among runs without a value."""

    #: The smallest.
    min: float | None = None
    #: 10 %.
    q10: float | None = None
    #: 50 %.
    median: float | None = None
    #: 95 % interval of the median: two of the values, by their ranks; null at an end that there are too few values for
    #: or that falls among runs without a value.
    median_interval: tuple[float | None, float | None] | None = None
    #: 90 %.
    q90: float | None = None
    #: The same of the 90 % quantile.
    q90_interval: tuple[float | None, float | None] | None = None
    #: 99 %.
    q99: float | None = None
    #: The largest.
    max: float | None = None


@dataclass(frozen=True, kw_only=True)
class RecordingConstant:
    """What the increments of one recording gain on the terms: a steady force, current or sensor error of that day."""

    #: Its name.
    source: str
    #: Regression pairs.
    samples: int
    #: Mean of Δu − φᵀθ̂ per sample.
    constant_u: float
    #: Of sway speed.
    constant_v: float
    #: Of yaw rate.
    constant_r: float


@dataclass(frozen=True, kw_only=True)
class RecordingSummary:
    """The files that were recorded together."""

    #: Its name.
    name: str
    #: Its files, relative to the folder of the logs.
    files: list[str]
    #: Numbers of the runs made of it.
    runs: list[int]
    #: From the moment at which all needed channels have begun to the end of the first that ends, in whole samples
    #: \[s\].
    duration_s: float
    #: Samples of its runs.
    samples: int
    #: Segments of its runs.
    segments: int
    #: Gaps that split it.
    splits: int
    #: Segments that were left out for being too short.
    short_segments: int
    #: What is known of it and in none of its runs: outside of segments, or in those that were too short \[s\].
    left_out_s: float = 0.0
    #: Rows of its files.
    rows: RowSummary
    #: Values that were left out, by channel and reason.
    omitted: list[Omission] = field(default_factory=list)
    #: Its channels, measured and computed, on their own clocks.
    channels: list[ChannelSummary]
    #: Measured velocities beside the derivatives of position and heading, where there are both.
    motion: list[MotionSummary]
    #: What is odd about its channels.
    warnings: list[WarningSummary] = field(default_factory=list)
    #: Why no estimate is made of it unless asked, in words.
    doubtful: list[str] = field(default_factory=list)
    #: How it contradicts the other recordings, in words; it is used like these unless it is left out.
    contradicts: str | None = None
    #: Why it cannot be judged whether it contradicts the others, in words.
    unjudged: str | None = None


@dataclass(frozen=True, kw_only=True)
class RefinedDesign:
    """An experiment whose input signals were refined, against the one that it began as."""

    #: The parameters that the experiment was simulated with, and that errors are relative to.
    simulated_with: Source
    #: The design's experiment.
    before: RefinedExperiment
    #: The refined one.
    after: RefinedExperiment
    #: Value before over value after: how many times the time the start would need for the same errors.
    worth: float
    #: Inputs that changed faster in the design's experiment than their rates allow: `before` is of one in which they
    #: follow it as fast as they may.
    slowed: list[str] = field(default_factory=list)
    #: Every limit with what was reached.
    limits: list[RefinedLimit]
    #: Time between the knots of a correction \[s\].
    knot_s: float
    #: Iterations of the search.
    iterations: int
    #: Simulations of the search.
    simulations: int
    #: Whether the search ended by itself, before its iterations did.
    settled: bool


@dataclass(frozen=True, kw_only=True)
class RefinedExperiment:
    """What is predicted of an experiment."""

    #: The criterion, with measurement errors and current.
    value: float
    #: Its part by measurement errors alone.
    measurement_value: float
    #: Root of the value: the root-mean-square parameter error that is predicted.
    parameter_error: float
    #: Predicted standard error of every parameter, in the parameter's unit.
    standard_errors: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class RefinedLimit:
    """A limit of motion, of an input or of an input's rate."""

    #: As in the table `limits` of `dictionary.toml`: `u_m_s`, `inputs.tau1`, `rates.tau1`.
    limit: str
    #: The largest modulus allowed, in the unit of the state, the input or the input per second; none where there is no
    #: limit.
    allowed: float | None = None
    #: The largest modulus at the start.
    before: float
    #: The largest modulus of the refined experiment.
    after: float


@dataclass(frozen=True, kw_only=True)
class Resamples:
    """Searches over recordings that were drawn again, with replacement."""

    #: The seed of the draws.
    seed: int
    #: Searches that found a model.
    searches: int
    #: Those that found none.
    failed: int


@dataclass(frozen=True, kw_only=True)
class RestartPoint:
    """Where the ship goes on."""

    #: Longitude of the last position.
    longitude_deg: float
    #: Its latitude.
    latitude_deg: float
    #: True heading there: as logged, else as planned where the ship is on the plan, else her course.
    heading_deg: float
    #: Speed over the ground there, by the same rule \[m/s\].
    speed_m_s: float
    #: The speed mode that is nearest to it.
    mode: str


@dataclass(frozen=True, kw_only=True)
class Restricted:
    """Shares of few maneuvers."""

    #: At most so many maneuvers.
    most_maneuvers: int
    #: `exhaustive`: every choice of maneuvers was tried; `exchange`: no exchange of one maneuver improves the
    #: criterion.
    method: Method
    #: The fraction of the experiment time that the restriction costs at most; see `statement`.
    gap: float
    #: What is known of it, in words.
    statement: str


@dataclass(frozen=True, kw_only=True)
class RoundGain:
    """Errors of the trial in rounds over those of the one-shot trial after the same time in the same realization."""

    #: Time at sea.
    time_s: float
    #: Realizations in which both have an estimate.
    pairs: int
    #: Geometric mean of the ratio; below 1 rounds are better.
    ratio: float | None = None
    #: Lower end of its 95 % interval.
    low: float | None = None
    #: Upper end.
    high: float | None = None


@dataclass(frozen=True, kw_only=True)
class RowSummary:
    """Rows that were read, and left out."""

    #: All rows.
    read: int
    #: Left out: no value at all.
    empty: int
    #: Left out: cut short at the end of the file.
    cut: int
    #: Left out: no time.
    without_time: int
    #: Left out: the time of an earlier row.
    repeated: int
    #: Earlier than a row before: left out or put in order, as `non_monotonic` says.
    backwards: int
    #: Rows that had the time of the row before and were spread until the next.
    spread: int = 0
    #: Left out: sentences with a wrong checksum.
    wrong_checksums: int = 0
    #: Sentences of the clock that came late: they told no time.
    late: int = 0
    #: Sentences that neither a channel nor the clock takes, and lines without a sentence.
    unused: int = 0
    #: Of those that went backwards, put in order.
    sorted: int = 0
    #: Left out: before the clock was set.
    unset: int = 0
    #: Times at which the clock began anew and was counted on: midnight without a date, weeks, counters of so many bits.
    rollovers: int = 0
    #: Files with a second 60, which is a second of its own: what comes later is a second later than its clock showed.
    leap_seconds: int = 0
    #: Rows whose decimals of the time are a whole number of nano-, micro- or milliseconds without leading zeros.
    unpadded: int = 0


@dataclass(frozen=True, kw_only=True)
class RunDocument:
    """`run.json`: the stages that a study's results were made by, each with what it read and wrote."""

    #: Digest of the way from the results to the study's folder, by which results of another study are known.
    study: Digest | None = None
    #: The stages by their names in `run --stage`.
    stages: dict[str, RunStage]


@dataclass(frozen=True, kw_only=True)
class RunStage:
    """A stage as it ran. `{study}` and `{out}` stand for the study's folder and its results; a brace of a name is
    written twice.
    """

    #: The program and its version.
    program: str
    #: Digest of the program's file.
    digest: Digest | None = None
    #: Its command line.
    command: list[str]
    #: Digests of what it read: files; names that fit a pattern in a folder (`names *.csv in {study}/logs`; a digit is
    #: `#`); the path of a folder without links (`place of {study}/cells`). None where there was no such file or folder.
    inputs: dict[str, Digest | None]
    #: Digests of the files that it wrote.
    outputs: dict[str, Digest]


@dataclass(frozen=True, kw_only=True)
class SailedSum:
    """A sum of the terms of one order along what was sailed."""

    #: `sway` or `yaw`.
    degree: str
    #: 1 for linear terms, 3 for cubic ones.
    order: int
    #: The free numbers in it.
    terms: list[str]
    #: The sum.
    value: float
    #: Its standard error, from the covariance of the numbers.
    standard_error: float
    #: Its 95 % interval.
    interval: tuple[float, float]
    #: Its standard deviation by the priors alone; null where a number has none.
    prior_deviation: float | None = None
    #: The sum of captive values, where all of them were given.
    captive: CaptiveValue | None = None


@dataclass(frozen=True, kw_only=True)
class SailedSums:
    """Sums of terms of sway and yaw where v is a multiple of r L, in the prime system, with a yaw rate of 1 there."""

    #: v over r L as sailed, by least squares over all samples.
    drift: float
    #: The sums.
    sums: list[SailedSum]


@dataclass(frozen=True, kw_only=True)
class SampledShips:
    """What is known of ships with other parameters than those of the moments."""

    #: What they are drawn from.
    from_: SampledFrom
    #: How many were simulated.
    ships: int
    #: The maneuvers that are executed by inputs, in order.
    by_inputs: list[PlayedMotion]


@dataclass(frozen=True, kw_only=True)
class ScoredEstimates:
    """The errors of estimates of simulated runs."""

    #: The bounds that the shares below are counted against.
    bounds: Bounds
    #: Samples of the validation trajectory.
    samples: int
    #: Seed of the campaign that the runs come from; absent for runs that were not simulated.
    seed: int | None = None
    #: One entry per design.
    designs: list[DesignScores]
    #: Which estimator to use for each design, where several were compared.
    recommendations: list[EstimatorRecommendation] | None = None
    #: Every estimator on the same runs, where they were compared; `designs` then is that of `iv`.
    compared: list[EstimatorScores] | None = None


@dataclass(frozen=True, kw_only=True)
class SearchSummary:
    """How a model's structure was searched for in recordings, and how far the search can be trusted."""

    #: Name of the vessel.
    vessel: str
    #: Length of the windows that were fitted \[s\].
    fitted_window_s: float
    #: From the start of one to that of the next \[s\].
    every_s: float
    #: Length of the windows that models were scored on \[s\]; null: whole runs.
    window_s: float | None = None
    #: Number of those.
    windows: int
    #: Samples that the model was fitted to.
    samples: int
    #: Number of folds that whole recordings were dealt into.
    folds: int
    #: Standard deviations of the measured states over the windows.
    std_u: float
    #: Of sway speed.
    std_v: float
    #: Of yaw rate.
    std_r: float
    #: The ridge Λ that was chosen; null where none was found.
    ridge: float | None = None
    #: Ridges in the order that they were tried in.
    candidates: list[Candidate]
    #: Numbers of terms in the order of additions, where few terms were asked for.
    sizes: list[SizeScore]
    #: The whole search on recordings that were left out of it, beside the base structure.
    nested: NestedScore
    #: How often recordings were drawn again and searched anew, where few terms were asked for.
    resamples: Resamples | None = None
    #: The terms that were found.
    terms: list[SearchTerm]
    #: What the models of an average are made of, where an average was asked for.
    average: AverageSummary | None = None
    #: The forces that were fitted beside, where the search began with a core for a ship with forces.
    beside: BesideForces | None = None
    #: What was found, in words.
    statements: list[str]


@dataclass(frozen=True, kw_only=True)
class SearchTerm:
    """A term with its value."""

    #: `surge`, `sway` or `yaw`.
    degree: str
    #: Name of its parameter.
    name: str
    #: What the parameter multiplies.
    term: str
    #: Whether the structure that the search began with has it.
    base: bool
    #: The estimate.
    value: float
    #: 2.5 % of the searches over recordings that were drawn again found less, where few terms were asked for: 0 without
    #: the term.
    low: float | None = None
    #: 2.5 % found more.
    high: float | None = None
    #: In how many of these it was chosen.
    chosen_by_resamples: int | None = None
    #: In how many of the searches without a fold it was chosen too; null where all terms are kept.
    chosen_by_folds: int | None = None


@dataclass(frozen=True, kw_only=True)
class SecondaryCost:
    """What breaks ties between plans of the same cost."""

    #: What it counts.
    name: Secondary
    #: Its value.
    value: float


@dataclass(frozen=True, kw_only=True)
class Selection:
    """Models from sub-experiments picked by a design, against random picks of the same number."""

    #: The estimator.
    estimator: Estimator
    #: How the instruments' mean is removed.
    mean_removal: MeanRemoval
    #: Sub-experiments per realization.
    picks: int
    #: Seed of the picks.
    seed: int
    #: Of each maneuver in the optimized selection.
    counts: dict[str, int]
    #: Sub-experiments there are of each maneuver.
    available: dict[str, int]
    #: Number of sub-experiments, all of which every model is simulated over.
    parts: int
    #: Their samples.
    samples: int
    #: Standard deviations of the measured states over them.
    std_u: float
    #: Of sway speed.
    std_v: float
    #: Of yaw rate.
    std_r: float
    #: Norm of RMSE/std from which a model counts as degenerate; √3 is as bad as the mean of the data.
    degenerate_from: float
    #: Errors at which the figures of a published study end; absent where there is none to compare with.
    published_limits: PublishedLimits | None = None
    #: 90 % quantile of the optimized error norm over that of the random one; null where either is infinite.
    ratio_q90: float | None = None
    #: The result, and what went wrong, in words.
    statements: list[str]
    #: How well the instruments follow the measured u, v, r over the sub-experiments: 100 (1 − RMSE/std).
    instrument_fit: tuple[float, float, float] | None = None
    #: `optimized` and `random`.
    designs: list[SelectionScores]


@dataclass(frozen=True, kw_only=True)
class SelectionErrors:
    """Quantiles over the realizations."""

    #: Norm of RMSE/std.
    error_norm: Quantiles
    #: Norm of the RMSE as numbers: the paper's.
    rmse_norm: Quantiles
    #: Of surge speed.
    rmse_u: Quantiles
    #: Of sway speed.
    rmse_v: Quantiles
    #: Of yaw rate.
    rmse_r: Quantiles


@dataclass(frozen=True, kw_only=True)
class SelectionScores:
    """The realizations of one design. One without model, or whose simulation diverged, counts as infinite (null)."""

    #: `optimized` or `random`.
    design: str
    #: Number of realizations.
    realizations: int
    #: Realizations without model.
    not_identifiable: int
    #: Realizations whose simulation diverged.
    diverged: int
    #: Share of the realizations that are degenerate.
    degenerate_share: float
    #: 95 % interval of that share (Wilson's); absent without realizations.
    degenerate_share_interval: tuple[float, float] | None = None
    #: Shares of the realizations at or above `published_limits`, over all sub-experiments; one without model, or whose
    #: simulation diverged, is above all of them.
    beyond_published: SharesBeyond | None = None
    #: Over all sub-experiments, those picked included: the paper's protocol.
    overlapping: SelectionErrors
    #: Over those that were not picked.
    left_out: SelectionErrors


@dataclass(frozen=True, kw_only=True)
class Sequence:
    """Maneuvers one after the other."""

    #: In order; a maneuver may occur more than once.
    parts: list[SequencePart]
    #: Samples of all.
    samples: int
    #: Value of the criterion with the state carried over, as `starts` have it.
    value: float
    #: How it was found, in words.
    statement: str
    #: The errors that its estimate is to have, where that is by output error.
    foretold: Foretold | None = None
    #: What each trial that it was compared with promises, by its own sequence: the one that was taken first.
    promised: list[Promised] = field(default_factory=list)


@dataclass(frozen=True, kw_only=True)
class SequencePart:
    """One maneuver of a sequence."""

    #: Name in the dictionary.
    maneuver: str
    #: Its samples.
    samples: int


@dataclass(frozen=True, kw_only=True)
class Share:
    """A share of runs or realizations."""

    #: The share.
    share: float
    #: Its 95 % interval (Wilson's); null of nothing.
    interval: tuple[float, float] | None = None


@dataclass(frozen=True, kw_only=True)
class SharesBeyond:
    """Shares of the realizations that are at or above [`PublishedLimits`]."""

    #: By the norm of the RMSE as numbers.
    norm: Share
    #: In surge.
    surge: Share
    #: In sway.
    sway: Share
    #: In yaw rate.
    yaw: Share


@dataclass(frozen=True, kw_only=True)
class ShipTrack:
    """The track of a ship, from where the maneuver begins."""

    #: Times.
    t_s: list[float]
    #: Changes of heading, to starboard.
    heading_deg: list[float]
    #: Ship lengths along the course of the approach.
    ahead: list[float]
    #: Ship lengths to starboard of it.
    abeam: list[float]
    #: Surge speeds.
    surge_m_s: list[float]
    #: Yaw rates.
    yaw_rate_deg_s: list[float]


@dataclass(frozen=True, kw_only=True)
class SimulatedLogsDocument:
    """`simulated.json`: seals a folder of simulated logs, and labels them as what they are."""

    #: As everything that is made of them is labelled.
    label: DataLabel
    #: Name of the vessel.
    vessel: str
    #: Rows per second.
    sample_rate_hz: float
    #: Samples per sub-experiment that velocities from differences have; two rows more are logged.
    samples: int
    #: One per file.
    recordings: list[SimulatedRecording]
    #: Limits that were hit, in words.
    statements: list[str]


@dataclass(frozen=True, kw_only=True)
class SimulatedRecording:
    """One simulated log."""

    #: Its file, beside this document.
    file: str
    #: BLAKE3 of the file.
    digest: Digest
    #: Its maneuver.
    maneuver: str
    #: Its number among the maneuver's, from 1.
    repeat: int
    #: Whether it is run to the other side.
    mirrored: bool
    #: The day.
    day: str
    #: Heading at the start of the log.
    heading: float
    #: Share of the samples at which each thruster could not follow its command.
    limited: list[float]


@dataclass(frozen=True, kw_only=True)
class SizeScore:
    """A number of terms and how folds that are left out are followed with that many."""

    #: Number of terms, constants among them.
    terms: int
    #: The term that was added last.
    added: str
    #: Mean loss of the folds left out, by a quadratic model of the errors.
    loss: float
    #: How far it lies above the least.
    excess: float
    #: Standard error of that, by fold.
    standard_error: float


@dataclass(frozen=True, kw_only=True)
class SlopesAt:
    """Where the slopes of figures were computed."""

    #: The parameters of the model, in units of the state's increment per unit of the term.
    parameters: dict[str, float]
    #: Step of the central differences, as a part of the parameter.
    step: float


@dataclass(frozen=True, kw_only=True)
class SourceErrors:
    """Free simulation over one run or recording."""

    #: Its name.
    source: str
    #: Samples simulated.
    samples: int
    #: Simulations that diverged.
    diverged: int
    #: Root mean square errors and fits; null where a simulation diverged or there is no model.
    errors: FreeRunErrors | None = None


@dataclass(frozen=True, kw_only=True)
class SourceScore:
    """One estimator on one run or recording that was left out."""

    #: Its name.
    source: str
    #: Windows of it.
    windows: int
    #: Windows that diverged.
    diverged: int
    #: Null where one diverged, there is no window, or no model.
    errors: FreeRunErrors | None = None
    #: Norm of RMSE over the standard deviations of the states in all recordings, by which estimators are compared.
    error_norm: float | None = None


@dataclass(frozen=True, kw_only=True)
class Spread:
    """How far the models of an average are apart."""

    #: Their number.
    models: int
    #: Root mean square over all samples of their standard deviation in u.
    spread_u: float
    #: In v.
    spread_v: float
    #: In r.
    spread_r: float
    #: Shares of the measured samples within 1.96 of these standard deviations of the average, sample by sample: small
    #: where models agree on what they all get wrong.
    inside_u: float
    #: Of v.
    inside_v: float
    #: Of r.
    inside_r: float


@dataclass(frozen=True, kw_only=True)
class Stopping:
    """Trials that end with the first round after which the error is said to be within the accuracy, or else after the
    whole time: in rounds by the estimate's own word, one-shot by the crude model's, beforehand.
    """

    #: `sequential` or `one-shot`.
    arm: Arm
    #: Trials that end because the accuracy is promised.
    stopped: int
    #: Mean time at sea of all trials.
    mean_time_s: float
    #: 95 % interval of that mean.
    mean_time_interval_s: tuple[float, float] | None = None
    #: Median parameter error of all trials at their end.
    median_error: float | None = None
    #: 95 % interval of that median; null at an end that there are too few trials for, or that is infinite.
    median_error_interval: tuple[float | None, float | None] | None = None
    #: Share of all trials whose error at their end is within the accuracy.
    within: float
    #: 95 % interval of that share (Wilson's).
    within_interval: tuple[float, float] | None = None
    #: The same of those that were promised it.
    within_stopped: float | None = None
    #: 95 % interval of that share (Wilson's).
    within_stopped_interval: tuple[float, float] | None = None
    #: Root mean square error over accuracy of those that were promised it: at most 1 where promises are kept.
    rms_over_accuracy: float | None = None
    #: 95 % interval of it, from that of the mean square.
    rms_over_accuracy_interval: tuple[float, float] | None = None
    #: Of those that were promised it, how many have no estimate and are in no mean square.
    without_estimate: int


@dataclass(frozen=True, kw_only=True)
class Surroundings:
    """A current over ground that was found with a model in one run, or in a part of one."""

    #: The run or recording.
    source: str
    #: Which of the parts that simulations start anew with, from 0.
    part: int
    #: What was found, along and across the vessel as she heads where the part starts.
    found: list[FoundUnknown]


@dataclass(frozen=True, kw_only=True)
class Tally:
    """What all runs say together."""

    #: Design by design, by every estimator.
    counted: list[Counted]
    #: Design by design, every estimator after the first against those before it.
    pairs: list[PairCounts]


@dataclass(frozen=True, kw_only=True)
class Tide:
    """What the tide is at worst from the departure until the trial has to be over."""

    #: When the trial has to be over, after its departure \[s\].
    slot_s: float
    #: Least height of the water over the chart's datum \[m\]: charted depths count with it.
    level_m: float
    #: Middle of the stream, north and east \[m/s\]: it joins the known current.
    stream_m_s: tuple[float, float]
    #: Farthest that the stream is from its middle \[m/s\]: it joins the unknown current.
    spread_m_s: float


@dataclass(frozen=True, kw_only=True)
class TrialsInRounds:
    """Trials designed in rounds against trials designed once."""

    #: Realizations per arm.
    realizations: int
    #: Rounds.
    rounds: int
    #: Sea time in all.
    duration_s: float
    #: What crude models are drawn about.
    crude_about: Source
    #: Standard deviation of the logarithm of crude over these parameters.
    nominal_spread: float
    #: Predicted error at which a trial may stop.
    accuracy: float
    #: Maneuvers to design with.
    maneuvers: int
    #: The result in words.
    statements: list[str]
    #: In the order `sequential`, `one-shot`, `informed`, `random`.
    arms: list[ArmSummary]
    #: The trial in rounds over the one-shot trial, at the end of every round.
    gains: list[RoundGain]
    #: `sequential`, `one-shot`.
    stopping: list[Stopping]


@dataclass(frozen=True, kw_only=True)
class TriedFit:
    """A way to fit forces."""

    #: The longest windows that are fitted \[s\].
    window_s: float
    #: Whether windows start at their first measured sample.
    measured_starts: bool
    #: Mean fit of u, v, r of recordings that were left out of it \[%\]; null where a fold lacks a fit, or a window
    #: diverged.
    score: float | None = None
    #: Whether it is the delivered one.
    chosen: bool


@dataclass(frozen=True, kw_only=True)
class Trust:
    """How far one pooled estimate can be trusted."""

    #: The estimator.
    estimator: Estimator
    #: How the instruments' mean is removed.
    mean_removal: MeanRemoval
    #: Where the instruments' nominal model comes from.
    nominal: NominalSource
    #: Strength of the pull towards the nominal model.
    prior: float
    #: Number of sub-experiments.
    parts: int
    #: Number of runs or recordings they were cut from.
    sources: int
    #: Regression pairs.
    samples: int
    #: Lags of Bartlett's weights in the standard errors.
    bandwidth: int
    #: Resamples of the bootstrap over sub-experiments.
    replicates: int
    #: What to know before using the estimate, in words.
    statements: list[str]
    #: Surge, sway, yaw.
    degrees: list[DegreeTrust]
    #: Parameters that are fixed or tied to others.
    constrained: list[ConstrainedParameter] = field(default_factory=list)
    #: Free simulation over every run or recording.
    runs: list[SourceErrors]
    #: What the model lacks; absent where the model diverges or has no estimate.
    criticism: Criticism | None = None


@dataclass(frozen=True, kw_only=True)
class Unlike:
    """A channel whose root mean square over a stretch leaves the range of those that the model was fitted to."""

    #: The channel.
    name: str
    #: Its unit.
    unit: str
    #: Least root mean square that the model was fitted to.
    low: float
    #: Largest.
    high: float
    #: Stretches below.
    below: int
    #: Stretches above.
    above: int


@dataclass(frozen=True, kw_only=True)
class Unreached:
    """Maneuvers by inputs that many ships miss."""

    #: What the ships' parameters were drawn from.
    from_: SampledFrom
    #: How many ships were simulated.
    ships: int
    #: The maneuvers.
    motions: list[UnreachedMotion]
    #: The warning in words, with a remedy.
    statement: str


@dataclass(frozen=True, kw_only=True)
class UnreachedMotion:
    """A motion that many ships miss."""

    #: The maneuver.
    maneuver: str
    #: What is missed, in words.
    what: str
    #: Share of the sampled ships that miss it by more than a quarter.
    missed: Share


@dataclass(frozen=True, kw_only=True)
class UpdatedAccuracy:
    """The time that an accuracy takes, from the covariance after the trial."""

    #: The standard error that the design was asked for.
    wanted: float
    #: Which one.
    of: AccuracyOf
    #: What the trial reached.
    reached: float
    #: Time of this design in all \[s\].
    needed_s: float
    #: What is left of it; 0 where the accuracy is reached \[s\].
    remaining_s: float


@dataclass(frozen=True, kw_only=True)
class UpdatedCriterion:
    """The criterion of a design as an error."""

    #: Its name on the command line.
    name: CriterionName
    #: a, a-relative: root of Σ weight × variance, with the weights of the design; d: |covariance|^(1/(2 × parameters)),
    #: by degree of freedom where each is estimated by itself.
    error: UpdatedError


@dataclass(frozen=True, kw_only=True)
class UpdatedError:
    """An error as it was promised, and as it is now."""

    #: Before the trial, for its length.
    promised: float
    #: From the covariance at the estimate.
    now: float
    #: The first over the second; absent where the second is zero.
    ratio: float | None = None


@dataclass(frozen=True, kw_only=True)
class UpdatedFigure:
    """A figure of merit, in its unit."""

    #: The maneuver.
    maneuver: str
    #: Its name.
    name: str
    #: Its unit.
    unit: str
    #: Its standard error.
    standard_error: UpdatedError


@dataclass(frozen=True, kw_only=True)
class UpdatedParameter:
    """A parameter, in its unit."""

    #: Its name.
    name: str
    #: The estimate.
    estimate: float
    #: What its error is relative to, before and after the trial: the modulus of the value that the design had.
    scale: float | None = None
    #: Its standard error.
    standard_error: UpdatedError


@dataclass(frozen=True, kw_only=True)
class ValidationDocument:
    """`validation.json`: how good models are, by what was asked for."""

    #: Of `validate --estimates` and `monte-carlo --keep scores`: the errors of estimates of simulated runs.
    scored: ScoredEstimates | None = None
    #: Of `monte-carlo`: the errors of realizations in memory.
    counted: CountedRuns | None = None
    #: Of `validate --model`: models on recordings that they were not fitted to.
    recordings: Compared | None = None
    #: Of `validate --design`: models from picked sub-experiments.
    picks: Selection | None = None
    #: Of `monte-carlo` without a design: trials in rounds beside trials that are designed once.
    rounds: TrialsInRounds | None = None


@dataclass(frozen=True, kw_only=True)
class Validity:
    """Stretches of recordings in which the ship moves less or more than in any that the model was fitted to."""

    #: Length of a stretch \[s\].
    stretch_s: float
    #: Number of stretches.
    stretches: int
    #: Those that are outside in some channel.
    outside: int
    #: The channels that are outside at all.
    channels: list[Unlike]


@dataclass(frozen=True, kw_only=True)
class Voyage:
    """A plan at sea."""

    #: The lattice.
    lattice: PlanLattice
    #: One per step.
    legs: list[VoyageLeg]
    #: How the maneuvers became moves, one per heading and side.
    primitives: list[Primitive]
    #: Moves that are not offered to the search, since not all who rehearsed them end settled.
    dropped: list[DroppedMove]
    #: How the vessel is handled, and what it can do.
    handling: PlanHandling
    #: Time from start to end \[s\].
    duration_s: float
    #: Of which in informative maneuvers \[s\].
    informative_s: float
    #: The simulated plan against the chart.
    check: Check
    #: The part of the area that no chart shows, from 0 to 1.
    uncharted_share: float
    #: Whether that counts as water; else it is an obstacle.
    uncharted_is_water: bool
    #: The same from waypoint to waypoint.
    passage: Passage
    #: Information of what is sailed against what the counts promise.
    information: Information
    #: Fewer uses for less time: the counts that no others beat, cheapest first. Empty where the search was not
    #: exhaustive.
    front: list[FrontPoint]


@dataclass(frozen=True, kw_only=True)
class VoyageLeg:
    """One step at sea, as simulated."""

    #: Action, and side of a maneuver.
    name: str
    #: Whether it is an informative maneuver.
    informative: bool
    #: Which way, for an informative maneuver.
    side: Side | None = None
    #: When it begins \[s\].
    start_s: float
    #: How long it takes \[s\].
    duration_s: float
    #: When its maneuver begins \[s\]; after the steady approach.
    maneuver_start_s: float | None = None
    #: How long the maneuver takes \[s\].
    maneuver_s: float | None = None
    #: Longitude of its first node.
    longitude_deg: float
    #: Latitude of its first node.
    latitude_deg: float
    #: True heading at its first node.
    heading_deg: float
    #: Speed at its first node \[m/s\].
    speed_m_s: float
    #: Distance from the end node when it is over \[m\].
    end_error_m: float
    #: Largest modulus of every input, in its unit.
    largest_inputs: dict[str, float]
    #: What the bridge is told of a maneuver; absent of a move.
    order: str | None = None
    #: Where the nominal vessel's inputs change in a maneuver; none where they change all the time.
    wheel_over: list[WheelOver] = field(default_factory=list)
    #: If it fails: her way to the nearest place where she may wait, from the end of this leg; absent where there is
    #: none.
    abort: AbortTrack | None = None
    #: Why there is none; absent where there is one.
    no_abort: str | None = None
    #: How she drifts with her engine stopped.
    drift: LegDrift | None = None


@dataclass(frozen=True, kw_only=True)
class WarningSummary:
    """Something odd about a channel that does not hinder its use."""

    #: What is odd.
    kind: WarningKind
    #: The channel.
    channel: str
    #: How often.
    count: int
    #: In words.
    text: str


@dataclass(frozen=True, kw_only=True)
class WheelOver:
    """An order of a maneuver: when and where the nominal vessel carries it out."""

    #: When \[s\].
    start_s: float
    #: Longitude.
    longitude_deg: float
    #: Latitude.
    latitude_deg: float
    #: True heading.
    heading_deg: float
    #: The inputs from there on, in their units.
    inputs: dict[str, float]


@dataclass(frozen=True, kw_only=True)
class Whiteness:
    """Ljung and Box's test: whether residuals are white."""

    #: Q = N (N + 2) Σ ρ_l²/(N_l), l = 1 … lags, N_l being the pairs of lag l within sub-experiments.
    statistic: float
    #: Number of lags, and degrees of freedom.
    lags: int
    #: Probability of a larger Q of white residuals.
    p_value: float
    #: Autocorrelation ρ_1 of neighbours.
    first_autocorrelation: float


@dataclass(frozen=True, kw_only=True)
class WorstVessel:
    """A vessel in a current, and where it is worst."""

    #: Step of the plan, from 1.
    step: int
    #: Its action.
    leg: str
    #: Whether that is an informative maneuver.
    informative: bool
    #: Difference of every parameter from the nominal one, relative to that \[%\]; of a ship with forces without those
    #: whose nominal value is 0.
    parameters_percent: dict[str, float]
    #: The numbers of a ship with forces, in the system that they are written in.
    numbers: dict[str, float] = field(default_factory=dict)
    #: Speed of the unknown current \[m/s\].
    current_m_s: float
    #: Compass direction that it sets towards \[deg\].
    towards_deg: float


@dataclass(frozen=True, kw_only=True)
class WorstVessels:
    """The worst vessels and currents within the stated errors that were found."""

    #: How many vessels were tried, each in a current of its own over the whole plan.
    searched: int
    #: Of which touched an obstacle, or went where the chart was not read.
    aground: int
    #: Of which came nearer than the margin, those aground among them.
    below_margin: int
    #: Ends of their legs.
    ends: int
    #: Of which lie beyond a tolerance.
    ends_astray: int
    #: Least distance of any of them from an obstacle \[m\].
    clearance_m: float
    #: The one that comes so near.
    nearest: WorstVessel
    #: Largest part of a tolerance that any of them uses at the end of a leg.
    tolerance_used: float
    #: The one that ends so far off.
    farthest: WorstVessel


#: The class of the contents of each kind of document.
KINDS = {
    "design/2": "DesignDocument",
    "estimate/2": "EstimateDocument",
    "ingest/1": "IngestDocument",
    "map/1": "MapDocument",
    "merit/1": "MeritDocument",
    "model/2": "ModelDocument",
    "moments/1": "MomentsDocument",
    "plan/2": "PlanDocument",
    "run/2": "RunDocument",
    "simulated-logs/1": "SimulatedLogsDocument",
    "validation/2": "ValidationDocument",
}
