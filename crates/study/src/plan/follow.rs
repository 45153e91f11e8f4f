//! A plan that is followed: its positions so far as a file, and what they say of it.

use std::collections::BTreeMap;
use std::io::{BufReader, Read};
use std::path::Path;

use chart::Plane;
use chart::route::Timestamp;
use files::{Digesting, Error, Provenance, open, read_document};
use logs::{Format, LogError, LoggedPositions, SNIFFED, Since, foreign_format, read_positions};
use plan::voyage::{
    Brief, FollowLimits, Followed, Gathered, Goal, ManeuverUse, Place, PlannedTrack, RestartPoint,
    ShipPosition, StepState, Task, TrackPoint, VoyageError,
};
use refusal::Invalid;

use crate::documents::{BegunPlan, FollowStatus, FollowedStep, PlanDocument, PlanStep, Voyage};
use crate::tables::track::planned_points;

/// The files of a plan that is followed.
#[derive(Clone, Copy, Debug)]
pub struct FollowFiles<'a> {
    /// `plan.json`.
    pub plan: &'a Path,
    /// The positions so far.
    pub positions: &'a Path,
}

/// The times of positions.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Clock {
    /// What positions count from, after the departure \[s\].
    origin_s: f64,
    /// The departure, or what stands for it, if known \[s since 1970, UTC\].
    departure: Option<f64>,
}

/// A plan that is followed.
#[derive(Clone, Debug)]
pub struct FollowedPlan {
    /// What is known of it.
    pub begun: BegunPlan,
    /// The positions, on the plane of the trial.
    pub positions: Vec<ShipPosition>,
}

/// A plan is elsewhere than positions that are so far from it \[m\].
const ELSEWHERE_M: f64 = 10_000.0;
/// Delays that are nearly a multiple of the first \[s\] are those of a clock in local time.
const ZONES_S: [f64; 2] = [1800.0, 60.0];
/// How far GPS time is ahead of UTC, since 2017, and how near a delay is to it \[s\].
const LEAP_S: [f64; 2] = [18.0, 1.5];

/// Reads the positions of a file called `.nmea` as sentences, and of any other as CSV, with the vessel's `inputs`.
fn read_so_far(path: &Path, inputs: &[&str], provenance: &mut Provenance) -> Result<LoggedPositions, Error> {
    let unreadable = |e| Error::io(path, "read", e);
    let name = path.file_name().and_then(|name| name.to_str()).unwrap_or_default();
    let format = Format::of(name);
    let mut head = Vec::new();
    open(path)?.take(SNIFFED as u64).read_to_end(&mut head).map_err(unreadable)?;
    if let Some(foreign) = foreign_format(&head, format, true) {
        return Err(crate::invalid(path, &foreign));
    }
    let mut source = Digesting::new(open(path)?);
    let positions = read_positions(BufReader::new(&mut source), format, inputs);
    let positions = positions.map_err(|error| match error {
        LogError::Unreadable(error) => unreadable(error),
        LogError::Invalid(invalid) => crate::invalid(path, &invalid),
    })?;
    provenance.written("positions", path, source.digest().map_err(unreadable)?)?;
    Ok(positions)
}

impl Clock {
    /// The clock of positions on a plan. Times of day count from its departure; from the first position where it has none.
    fn of(logged: &LoggedPositions, voyage: &Voyage) -> Self {
        let departure = voyage.passage.departure.as_deref();
        let departure = departure.and_then(|at| at.parse::<Timestamp>().ok()).map(|at| at.as_second() as f64);
        let first = logged.rows.first().map(|row| row.at_s);
        match logged.since {
            Since::Departure => Self { origin_s: 0.0, departure },
            Since::Epoch => {
                let departure = departure.or(first);
                Self { origin_s: departure.map_or(0.0, |at| -at), departure }
            }
        }
    }

    /// A time after the departure, in seconds since 1970, if the departure is known.
    fn second(&self, at_s: f64) -> Option<i64> {
        self.departure.map(|departure| (departure + at_s).floor() as i64)
    }

    /// The same in words.
    fn words(&self, at_s: f64) -> Option<String> {
        self.second(at_s).and_then(|second| Timestamp::from_second(second).ok()).map(|at| at.to_string())
    }

    /// Positions on `plane`, timed after the departure.
    fn placed(&self, logged: &LoggedPositions, plane: &Plane) -> Vec<ShipPosition> {
        let placed = |row: &logs::LoggedPosition| ShipPosition {
            line: row.line,
            at_s: self.origin_s + row.at_s,
            place: plane.to_plane(row.longitude_deg, row.latitude_deg),
            heading_deg: row.heading_deg,
            speed_m_s: row.speed_m_s,
        };
        logged.rows.iter().map(placed).collect()
    }
}

impl FollowedPlan {
    /// Where the ship of `brief` is in `plan`, the contents of the file of that name. The task becomes that of the rest, if
    /// maneuvers are left.
    ///
    /// # Errors
    /// A plan without a track; positions that are refused; a task that does not fit the plan.
    pub fn read(
        files: &FollowFiles,
        plan: &PlanDocument,
        brief: &mut Brief,
        provenance: &mut Provenance,
    ) -> Result<Self, FollowError> {
        let names = brief.vessel.model.input_variables().iter().map(|input| input.name.as_str());
        let logged = read_so_far(files.positions, &names.collect::<Vec<_>>(), provenance)?;
        let (plane, _) = brief.sight()?;
        let (points, inputs) = planned_points(files.plan, &brief.vessel, &plane)?;
        check_order(&logged, &points, &plane).map_err(|e| Error::invalid(files.positions, e))?;
        // A plan with a track has a voyage.
        let voyage = plan.voyage.as_ref().ok_or_else(|| no_voyage(files.plan))?;
        let track = PlannedTrack::new(points, &voyage.legs, &voyage.primitives, &brief.task);
        let clock = Clock::of(&logged, voyage);
        let positions = clock.placed(&logged, &plane);
        let limits = FollowLimits::of(&brief.task, &track);
        let mut recorded = logged.inputs.clone();
        recorded.values_mut().flatten().for_each(|[at_s, _]| *at_s += clock.origin_s);
        let followed = track
            .follow(&positions, [&inputs, &recorded], &limits)
            .map_err(|e| Error::invalid(files.positions, e))?;
        let last = &logged.rows[logged.rows.len() - 1];
        let from = goes_on([last.longitude_deg, last.latitude_deg], &followed, voyage);
        let information = brief.gathered(&plan.counts, &uses(plan, &followed))?;
        let rest = rest_of(brief.task.clone(), plan, done(plan, &followed), place_of(&from));
        let status = match &rest {
            None if followed.finished => FollowStatus::Finished,
            None => FollowStatus::ManeuversDone,
            Some(_) => FollowStatus::UnderWay,
        };
        if let Some(rest) = rest {
            brief.task = match clock.second(followed.at_s) {
                Some(second) => rest.departing(second),
                None => rest,
            };
        }
        let begun = BegunPlan {
            statement: statement(plan, &followed, &information, status),
            doubts: doubts(plan, &followed),
            left_out: (followed.spikes + logged.left_out) as u64,
            status,
            departure: clock.words(0.0),
            at: clock.words(followed.at_s),
            at_s: followed.at_s,
            positions: followed.positions.len() as u64,
            step: followed.step as u64 + 1,
            deviation_m: followed.deviation_m,
            delay_s: followed.delay_s,
            steps: states(voyage, &track, &followed),
            information,
            from,
        };
        Ok(Self { begun, positions: followed.positions })
    }
}

/// Refuses positions that are far from the plan, and near it with their numbers exchanged, or with another sign.
fn check_order(logged: &LoggedPositions, points: &[TrackPoint], plane: &Plane) -> Result<(), Invalid> {
    let last = &logged.rows[logged.rows.len() - 1];
    let [east, north] = [last.longitude_deg, last.latitude_deg];
    let nearest_m = |[east, north]: [f64; 2]| {
        let place = plane.to_plane(east, north);
        points.iter().map(|point| point.away_m(place)).fold(f64::INFINITY, f64::min)
    };
    let away_m = nearest_m([east, north]);
    let others = [
        ("exchanged", "exchange", [north, east]),
        ("with the longitude's sign turned", "turn", [-east, north]),
        ("with the latitude's sign turned", "turn", [east, -north]),
    ];
    let near = others.into_iter().find(|other| nearest_m(other.2) < (0.1 * away_m).min(ELSEWHERE_M));
    let Some((how, remedy, _)) = near.filter(|_| away_m > ELSEWHERE_M) else { return Ok(()) };
    let given = format!(
        "longitude {east} and latitude {north}, {:.0} km from the plan; {how} they are near it",
        away_m / 1e3
    );
    let remedy = format!("{remedy} them in the file");
    Err(Invalid::new(format!("line {}", last.line), given, "a position near the plan", remedy))
}

/// What is odd about the log, and does not leave the ship's place in doubt; a sentence each.
fn doubts(plan: &PlanDocument, followed: &Followed) -> Vec<String> {
    let late_s = followed.usual_delay_s;
    let zones = (late_s / ZONES_S[0]).round();
    let mut said: Vec<String> = Vec::new();
    if zones != 0.0 && (late_s - zones * ZONES_S[0]).abs() <= ZONES_S[1] {
        let hours = zones * ZONES_S[0] / 3600.0;
        said.push(format!(
            "she is {hours} h late, as by a clock in local time: write times in UTC, or with their offset, unless she departed then"
        ));
    }
    if (late_s - LEAP_S[0]).abs() <= LEAP_S[1] && (followed.delay_s - LEAP_S[0]).abs() <= LEAP_S[1] {
        said.push("she is always 18 s late, as by a clock in GPS time".to_owned());
    }
    said.extend(followed.odd.iter().cloned());
    let behind = &followed.states[..followed.step];
    if behind.len() > 1 && !behind.contains(&StepState::Done) {
        said.push("none of the steps behind her is done: this may be the log of another plan".to_owned());
    }
    let spoiled = plan.steps.iter().zip(&followed.why).enumerate();
    said.extend(spoiled.filter_map(|(k, (step, why))| {
        Some(format!(
            "`{}` of step {} was not sailed as planned, and counts as not done: {}",
            step.action,
            k + 1,
            why.as_ref()?
        ))
    }));
    said
}

/// The steps that are done.
fn done<'a>(plan: &'a PlanDocument, followed: &'a Followed) -> impl Iterator<Item = &'a PlanStep> {
    let all = plan.steps.iter().zip(&followed.states);
    all.filter(|(_, state)| **state == StepState::Done).map(|(step, _)| step)
}

/// Uses of every action among the steps that are done.
fn uses(plan: &PlanDocument, followed: &Followed) -> BTreeMap<String, u64> {
    let mut uses: BTreeMap<String, u64> = BTreeMap::new();
    done(plan, followed).for_each(|step| *uses.entry(step.action.clone()).or_default() += 1);
    uses
}

fn place_of(from: &RestartPoint) -> Place {
    Place {
        longitude_deg: from.longitude_deg,
        latitude_deg: from.latitude_deg,
        heading_deg: from.heading_deg,
        mode: Some(from.mode.clone()),
    }
}

/// A plan that was begun.
#[derive(Clone, Copy, Debug)]
pub struct Begun<'a> {
    /// `plan.json`.
    pub plan: &'a Path,
    /// What is known of it so far.
    pub so_far: SoFar<'a>,
}

/// What is known of a plan that was begun.
#[derive(Clone, Copy, Debug)]
pub enum SoFar<'a> {
    /// How many of its steps are done, and where the ship goes on.
    Steps(usize, &'a Place),
    /// The ship's positions.
    Positions(FollowFiles<'a>),
}

impl<'a> Begun<'a> {
    /// The files that it is known from.
    pub fn files(&self) -> impl Iterator<Item = &'a Path> {
        let positions = match self.so_far {
            SoFar::Steps(..) => None,
            SoFar::Positions(files) => Some(files.positions),
        };
        std::iter::once(self.plan).chain(positions)
    }

    /// `task` of a stated place in `plan`; that of the whole plan where the place follows from positions.
    ///
    /// # Errors
    /// See [`resumed`]; a plan of a lattice problem, which no ship sails.
    pub fn task(&self, plan: &PlanDocument, task: Task) -> Result<Task, Error> {
        match self.so_far {
            SoFar::Steps(done, from) => {
                resumed(task, plan, done, from.clone()).map_err(|e| Error::invalid(self.plan, e))
            }
            SoFar::Positions(_) if plan.voyage.is_none() => Err(no_voyage(self.plan)),
            SoFar::Positions(_) => {
                let counts = plan.counts.iter().map(|(name, count)| (name.as_str(), *count));
                Ok(Task { maneuvers: maneuvers(&task, counts), ..task })
            }
        }
    }

    /// Where the ship is in `plan` by her positions, if those are what is known: see [`FollowedPlan::read`].
    ///
    /// # Errors
    /// As there.
    pub fn followed(
        &self,
        plan: &PlanDocument,
        brief: &mut Brief,
        provenance: &mut Provenance,
    ) -> Result<Option<FollowedPlan>, FollowError> {
        let SoFar::Positions(files) = &self.so_far else { return Ok(None) };
        FollowedPlan::read(files, plan, brief, provenance).map(Some)
    }
}

/// Why a plan is not followed.
#[derive(Debug)]
pub enum FollowError {
    /// A file is refused.
    File(Error),
    /// The trial does not fit.
    Voyage(VoyageError),
}

impl From<Error> for FollowError {
    fn from(error: Error) -> Self {
        Self::File(error)
    }
}

impl From<VoyageError> for FollowError {
    fn from(error: VoyageError) -> Self {
        Self::Voyage(error)
    }
}

fn no_voyage(plan: &Path) -> Error {
    let remedy = "plan on a chart, with --vessel, --trajectories and --config";
    Error::invalid(plan, Invalid::new("`data.voyage`", "none", "a plan on a chart", remedy))
}

/// Where the ship goes on, at longitude and latitude `place`.
fn goes_on([longitude_deg, latitude_deg]: [f64; 2], followed: &Followed, voyage: &Voyage) -> RestartPoint {
    let [heading_deg, speed_m_s] = followed.motion;
    let off = |mode: &(&String, &f64)| (mode.1 - speed_m_s).abs();
    let modes = voyage.lattice.modes.iter();
    let mode = modes.min_by(|a, b| off(a).total_cmp(&off(b))).map_or(String::new(), |mode| mode.0.clone());
    RestartPoint { longitude_deg, latitude_deg, heading_deg, speed_m_s, mode }
}

fn states(voyage: &Voyage, track: &PlannedTrack, followed: &Followed) -> Vec<FollowedStep> {
    let steps = voyage.legs.iter().zip(&track.steps);
    let results = followed.states.iter().zip(followed.deviations_m.iter().zip(&followed.why));
    let all = steps.zip(results);
    all.map(|((leg, step), (state, (deviation_m, why)))| FollowedStep {
        action: step.name.clone(),
        informative: leg.informative,
        state: *state,
        deviation_m: *deviation_m,
        within_m: step.within_m,
        why: why.clone(),
    })
    .collect()
}

/// The same in words.
fn statement(
    plan: &PlanDocument,
    followed: &Followed,
    information: &Gathered,
    status: FollowStatus,
) -> String {
    let step = &plan.steps[followed.step];
    let (number, count) = (followed.step + 1, plan.steps.len());
    let mut said = match status {
        FollowStatus::Finished => "The plan is done.".to_owned(),
        FollowStatus::ManeuversDone => {
            format!(
                "All maneuvers are done; the ship is at step {number} of {count}. Sail the plan to its end."
            )
        }
        FollowStatus::UnderWay if followed.finished => {
            "The ship is at the end of the plan, with maneuvers left to do.".to_owned()
        }
        FollowStatus::UnderWay => {
            let unfinished = ", whose maneuver is under way and counts as not done";
            let unfinished = if followed.in_maneuver { unfinished } else { "" };
            format!("The ship is at step {number} of {count}, `{}`{unfinished}.", step.action)
        }
    };
    let late = if followed.delay_s < 0.0 { "early" } else { "late" };
    let (deviation_m, delay_s) = (followed.deviation_m, followed.delay_s.abs());
    said += &format!(" She is {deviation_m:.0} m off the plan, and {delay_s:.0} s {late}.");
    if let Some(percent) = information.share.map(|share| 100.0 * share) {
        said += &format!(" What is done has {percent:.0} % of the planned information (D-criterion).");
    }
    let missed = |(k, (step, state)): (usize, (&PlanStep, &StepState))| {
        (*state == StepState::Missed).then(|| format!("{} (`{}`)", k + 1, step.action))
    };
    let steps = plan.steps.iter().zip(&followed.states).enumerate();
    let missed: Vec<String> = steps.filter_map(missed).collect();
    if !missed.is_empty() {
        said += &format!(" She did not come along all of step {}.", missed.join(", "));
    }
    for doubt in doubts(plan, followed) {
        said += &format!(" Note: {doubt}.");
    }
    if followed.spikes > 0 {
        said += &format!(" Spikes left out: {}.", followed.spikes);
    }
    for k in &followed.unknown {
        let name = &plan.steps[*k].action;
        said += &format!(
            " Positions do not say how `{name}` of step {} was sailed: its track is nearly straight.",
            k + 1
        );
    }
    said
}

// The rest of a plan, from the ship's position.

/// `LONGITUDE,LATITUDE,HEADING` or `LONGITUDE,LATITUDE,HEADING,MODE`, in degrees.
///
/// # Errors
/// Another text, in words.
pub fn stated_place(text: &str) -> Result<Place, String> {
    let cells: Vec<&str> = text.split(',').map(str::trim).collect();
    let number = |cell: &str| cell.parse::<f64>().ok().filter(|value| value.is_finite());
    let refused = || {
        format!(
            "found `{text}`, expected LONGITUDE,LATITUDE,HEADING[,MODE] in degrees, such as 24.95,60.15,45,half"
        )
    };
    let (numbers, mode) = match cells.len() {
        3 => (&cells[..], None),
        4 => (&cells[..3], Some(cells[3].to_owned())),
        _ => return Err(refused()),
    };
    let numbers: Option<Vec<f64>> = numbers.iter().map(|cell| number(cell)).collect();
    let numbers = numbers.ok_or_else(refused)?;
    Ok(Place { longitude_deg: numbers[0], latitude_deg: numbers[1], heading_deg: numbers[2], mode })
}

/// Reads the plan at `path`, which was begun. With a model in the vessel's place (`of_model`), it may be a plan for another
/// vessel: for the one of before the trial.
///
/// # Errors
/// A file that is refused.
pub fn read_begun(path: &Path, of_model: bool, provenance: &mut Provenance) -> Result<PlanDocument, Error> {
    let loaded = read_document::<PlanDocument>(path)?;
    match of_model {
        true => provenance.written("plan", path, loaded.digest)?,
        false => provenance.made("plan", path, loaded.digest, &loaded.provenance)?,
    }
    Ok(loaded.data)
}

/// The rest of `task` after the first `done` steps of its `plan`, with the ship at `from`, which becomes a node of
/// the lattice. Home stays the start of the whole trial.
///
/// # Errors
/// More steps than the plan has; a finished plan.
pub fn resumed(task: Task, plan: &PlanDocument, done: usize, from: Place) -> Result<Task, Invalid> {
    if done > plan.steps.len() {
        let expected = format!("at most {}, the steps of the plan", plan.steps.len());
        return Err(Invalid::new("`--done`", done.to_string(), expected, "count the steps that are done"));
    }
    rest_of(task, plan, &plan.steps[..done], from).ok_or_else(|| {
        let given = format!("every maneuver among the first {done} steps");
        let remedy = "sail the plan to its end, or count the steps again";
        Invalid::new("`--done`", given, "a maneuver that is left to do", remedy)
    })
}

/// The rest of `task` after the `done` steps of its `plan`, as [`resumed`] has it; `None` where no maneuver is left.
fn rest_of<'a>(
    mut task: Task,
    plan: &PlanDocument,
    done: impl IntoIterator<Item = &'a PlanStep>,
    from: Place,
) -> Option<Task> {
    let mut left: BTreeMap<&str, u64> = plan.counts.iter().map(|(name, c)| (name.as_str(), *c)).collect();
    for step in done {
        if let Some(count) = left.get_mut(step.action.as_str()) {
            *count = count.saturating_sub(1);
        }
    }
    left.retain(|_, count| *count > 0);
    if left.is_empty() {
        return None;
    }
    task.maneuvers = maneuvers(&task, left);
    if matches!(task.goal, Goal::Home {}) {
        task.goal = Goal::Places { places: vec![task.start] };
    }
    task.on_node = true;
    task.start = from;
    Some(task)
}

/// Uses of maneuvers, in pieces as `task` has them.
fn maneuvers<'a>(task: &Task, counts: impl IntoIterator<Item = (&'a str, u64)>) -> Vec<ManeuverUse> {
    let of = |(name, count): (&str, u64)| {
        let known = task.maneuvers.iter().find(|maneuver| maneuver.name == name);
        ManeuverUse {
            name: name.to_owned(),
            count: Some(count.min(u64::from(u32::MAX)) as u32),
            piece_s: known.and_then(|maneuver| maneuver.piece_s),
        }
    };
    counts.into_iter().map(of).collect()
}
