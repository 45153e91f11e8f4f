//! Figures of merit of standard maneuvers over many runs, or of a model with uncertain parameters.

mod summary;

use std::collections::BTreeMap;

use estimation::pooled::Uncertain;
use maneuver::merit::{Figure, Hull, Record, SailedFigures, figures};
use maneuver::{Generator, Standard};
use rayon::prelude::*;
use refusal::Invalid;
use ship::engine::{Run, Streams, check_runaway, simulate_command};
use ship::model::Vessel;

pub use summary::{FigureMerit, FigureSlopes, ManeuverMerit, ShipTrack};

/// The figures of one maneuver in one run.
#[derive(Clone, Debug, PartialEq)]
pub struct MeritRow {
    /// Its design.
    pub design: String,
    /// Its number.
    pub run: i32,
    /// The maneuver.
    pub maneuver: String,
    /// The figure.
    pub figure: Figure,
}

/// Why a maneuver is not simulated.
#[derive(Clone, Debug, PartialEq)]
pub enum Unsimulated {
    /// The dictionary's maneuver cannot be held.
    Unheld(Invalid),
    /// The ship diverges in it.
    Diverged(Invalid),
}

impl From<Unsimulated> for Invalid {
    fn from(unsimulated: Unsimulated) -> Self {
        let (Unsimulated::Unheld(invalid) | Unsimulated::Diverged(invalid)) = unsimulated;
        invalid
    }
}

/// How long before a maneuver its approach may begin, in times in which the ship covers her length.
const LEAD: f64 = 3.0;

/// Share of draws without figures up to which the others' interval counts.
const FAILED: f64 = 0.05;

/// Draws that are simulated before they are counted.
const TOGETHER: usize = 64;

/// A run, and its figures.
type SailedRun = (Record, Result<SailedFigures, Invalid>);

/// What is gathered of a maneuver.
#[derive(Default)]
struct Gathered {
    /// Its place in the dictionary; `None` where its log shows what it was.
    index: Option<usize>,
    name: String,
    kind: String,
    /// What was sailed, as the logs show it.
    sailed: String,
    /// The figures of every run that has them.
    figures: Vec<Vec<Figure>>,
    /// Runs that lack them, why the first does, and how many for each reason, by the words without their numbers.
    without: u64,
    reason: Option<Invalid>,
    reasons: BTreeMap<String, (u64, String)>,
    /// Those of them whose simulation diverges.
    diverged: u64,
    track: Option<ShipTrack>,
    /// The derivatives of the figures, or why the undisturbed ship has no figures; `None` where they were not computed.
    slopes: Option<Result<Vec<FigureSlopes>, Invalid>>,
    /// What is to be known of the figures and in how many runs, by the words without their numbers.
    remarks: BTreeMap<String, (u64, String)>,
}

impl Gathered {
    /// Counts a run without figures.
    fn lacks(&mut self, why: Invalid) {
        self.without += 1;
        let words = why.to_string();
        let kind = words.chars().filter(|c| !c.is_numeric()).collect();
        self.reasons.entry(kind).or_insert((0, words)).0 += 1;
        self.reason.get_or_insert(why);
    }

    /// Whether so few draws fail that the others' interval is that of all.
    fn is_interval_known(&self) -> bool {
        self.without as f64 <= FAILED * (self.figures.len() as f64 + self.without as f64)
    }

    /// Why runs lack figures: of several reasons each with the number of its runs.
    fn why(&self) -> Option<String> {
        let each = || self.reasons.values().map(|(runs, words)| format!("{runs} of them: {words}"));
        match self.reasons.len() {
            0 | 1 => self.reason.as_ref().map(ToString::to_string),
            _ => Some(each().collect::<Vec<_>>().join("; ")),
        }
    }
}

/// Refuses figures of which one is no number.
fn all_finite(sailed: SailedFigures) -> Result<SailedFigures, Invalid> {
    match sailed.figures.iter().find(|figure| !figure.value.is_finite()) {
        None => Ok(sailed),
        Some(figure) => Err(Invalid::new(
            figure.what,
            figure.value.to_string(),
            "a number",
            "run it longer, or with more helm",
        )),
    }
}

/// Figures of the standard maneuvers of a dictionary, or of those that logs show.
pub struct Merit<'a> {
    generator: Option<&'a Generator>,
    hull: Hull<'a>,
    gathered: Vec<Gathered>,
    rows: Vec<MeritRow>,
}

impl<'a> Merit<'a> {
    /// None so far, for a ship of this length \[m\]; without a dictionary logs show what was sailed.
    ///
    /// # Errors
    /// A dictionary without standard maneuvers.
    pub fn new(vessel: &'a Vessel, generator: Option<&'a Generator>, length_m: f64) -> Result<Self, Invalid> {
        let all = generator.map_or(&[][..], |generator| generator.maneuvers());
        let standard = |(index, one): (usize, &maneuver::ManeuverSpec)| {
            let (name, kind) = (one.name.clone(), one.kind.standard()?.name().to_owned());
            Some(Gathered { index: Some(index), name, kind, ..Gathered::default() })
        };
        let gathered: Vec<Gathered> = all.iter().enumerate().filter_map(standard).collect();
        if generator.is_some() && gathered.is_empty() {
            return Err(Invalid::new(
                "[[maneuver]]",
                "no standard maneuver",
                "one of kind `zig-zag-test`, `turning-circle`, `pull-out`, `spiral-test`, `reverse-spiral` or `stop`",
                "add one",
            ));
        }
        Ok(Self { generator, hull: Hull { vessel, length_m }, gathered, rows: Vec::new() })
    }

    /// Adds a recorded run; `poses` are its north, east \[m\] and heading \[rad\] at every sample, where they were recorded, else
    /// they are reckoned from its states. What `is_logged` shows itself when orders were given, and which.
    pub fn add(&mut self, run: &Run, poses: Option<&[[f64; 3]]>, is_logged: bool) {
        let vessel = self.hull.vessel;
        let width = vessel.model.exogenous();
        let ends = run.segments.iter().skip(1).map(|next| next.start).chain([run.samples()]);
        for (segment, end) in run.segments.iter().zip(ends) {
            let is_it = |one: &Gathered| one.index.is_some() && one.name == segment.maneuver;
            let place = self.gathered.iter().position(is_it);
            if self.generator.is_some() && place.is_none() {
                continue;
            }
            let speed = libm::hypot(run.measured[3 * segment.start], run.measured[3 * segment.start + 1]);
            let lead = (LEAD * self.hull.length_m / speed.max(1e-3) * vessel.sample_rate_hz) as usize;
            let lead = if is_logged { lead.min(segment.start) } else { 0 };
            let samples = segment.start - lead..end;
            let states = &run.measured[3 * samples.start..3 * (samples.end + 1)];
            let inputs = vessel.model.inputs_of(&run.exogenous[width * samples.start..width * samples.end]);
            let record = Record::of_states(states, inputs, vessel.sample_rate_hz);
            let record = match poses {
                Some(poses) => record.with_poses(&poses[samples.start..=samples.end]),
                None => record,
            };
            let record = if is_logged { record.logged(lead) } else { record };
            let standard = place.and_then(|place| self.standard(place));
            let sailed = figures(standard, &record, &self.hull);
            let place = place.unwrap_or_else(|| self.recognised(&segment.maneuver, sailed.as_ref().ok()));
            self.note(place, &run.design, run.run, &record, sailed);
        }
    }

    /// The place of what a log called `name` was found to be.
    fn recognised(&mut self, name: &str, maneuver: Option<&SailedFigures>) -> usize {
        let (kind, sailed) = maneuver.map_or(("", ""), |sailed| (sailed.kind, sailed.sailed.as_str()));
        let is_rest = |rest: &str| rest.is_empty() || rest.starts_with(": ");
        let is_it = |one: &Gathered| one.sailed == sailed && one.name.strip_prefix(name).is_some_and(is_rest);
        self.gathered.iter().position(is_it).unwrap_or_else(|| {
            // The same name may stand for different maneuvers.
            let is_known = self.gathered.iter().any(|gathered| gathered.name == name);
            let name = if is_known { format!("{name}: {sailed}") } else { name.to_owned() };
            let (kind, sailed) = (kind.to_owned(), sailed.to_owned());
            self.gathered.push(Gathered { name, kind, sailed, ..Gathered::default() });
            self.gathered.len() - 1
        })
    }

    fn standard(&self, place: usize) -> Option<Standard<'a>> {
        self.generator?.maneuvers()[self.gathered[place].index?].kind.standard()
    }

    /// Simulates every standard maneuver undisturbed, with `parameters`, as run `run`.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold, or in which it diverges.
    pub fn simulate(&mut self, parameters: &[f64], run: i32) -> Result<(), Unsimulated> {
        (0..self.gathered.len()).try_for_each(|place| self.simulate_one(place, parameters, run))
    }

    fn simulate_one(&mut self, place: usize, parameters: &[f64], run: i32) -> Result<(), Unsimulated> {
        let Some(sailed) = self.sailed(place, parameters) else { return Ok(()) };
        let (record, merit) = sailed?;
        self.note(place, "model", run, &record, merit);
        Ok(())
    }

    /// What the undisturbed ship with `parameters` does in a maneuver, and its figures; none without a dictionary.
    fn sailed(&self, place: usize, parameters: &[f64]) -> Option<Result<SailedRun, Unsimulated>> {
        let (generator, index) = self.generator.zip(self.gathered[place].index)?;
        let sailed = undisturbed(self.hull.vessel, generator, index, parameters);
        Some(sailed.map(|(standard, record)| {
            let merit = figures(Some(standard), &record, &self.hull);
            (record, merit)
        }))
    }

    /// Simulates them with parameters that are drawn `draws` times from what an estimate leaves uncertain. Draws that diverge or
    /// cannot hold a maneuver are counted as runs without figures.
    pub fn simulate_drawn(&mut self, uncertain: &Uncertain, draws: u32, seed: u64) {
        let streams = Streams::new(seed, "merit");
        for first in (0..draws).step_by(TOGETHER) {
            let some = first..draws.min(first + TOGETHER as u32);
            let sailed = some.clone().into_par_iter().map(|draw| {
                let parameters = uncertain.drawn(&streams, draw);
                (0..self.gathered.len()).map(|place| self.sailed(place, &parameters)).collect::<Vec<_>>()
            });
            let sailed: Vec<Vec<_>> = sailed.collect();
            for (draw, places) in some.zip(sailed) {
                for (place, sailed) in places.into_iter().enumerate() {
                    match sailed {
                        None => {}
                        Some(Ok((record, merit))) => self.note(place, "model", draw as i32, &record, merit),
                        Some(Err(why)) => {
                            self.gathered[place].diverged +=
                                u64::from(matches!(why, Unsimulated::Diverged(_)));
                            self.gathered[place].lacks(why.into());
                        }
                    }
                }
            }
        }
    }

    fn note(
        &mut self,
        place: usize,
        design: &str,
        run: i32,
        record: &Record,
        merit: Result<SailedFigures, Invalid>,
    ) {
        let gathered = &mut self.gathered[place];
        match merit.and_then(all_finite) {
            Ok(sailed) => {
                self.rows.extend(sailed.figures.iter().map(|figure| MeritRow {
                    design: design.to_owned(),
                    run,
                    maneuver: gathered.name.clone(),
                    figure: figure.clone(),
                }));
                for remark in sailed.remarks {
                    let words = remark.chars().filter(|c| !c.is_numeric()).collect();
                    gathered.remarks.entry(words).or_insert((0, remark)).0 += 1;
                }
                if !record.is_held && gathered.sailed.is_empty() {
                    gathered.sailed = sailed.sailed;
                }
                gathered.track.get_or_insert_with(|| ShipTrack::of(record, self.hull.length_m));
                gathered.figures.push(sailed.figures);
            }
            Err(invalid) => gathered.lacks(invalid),
        }
    }

    /// A row for every figure of every run.
    pub fn rows(&self) -> &[MeritRow] {
        &self.rows
    }

    /// Every maneuver that was run. `of_parameters`: runs are draws of parameters, so that intervals hold 95 % of them; else
    /// intervals are those of the mean.
    ///
    /// # Errors
    /// Maneuvers that have no figures in any run; no maneuver that was run.
    pub fn summary(&self, of_parameters: bool) -> Result<Vec<ManeuverMerit>, Invalid> {
        let ran = |maneuver: &&Gathered| maneuver.without > 0 || !maneuver.figures.is_empty();
        let all: Vec<&Gathered> = self.gathered.iter().filter(ran).collect();
        if all.is_empty() {
            let names = self.gathered.iter().map(|maneuver| maneuver.name.as_str());
            return Err(Invalid::new(
                "maneuvers",
                "no run of a standard maneuver of the dictionary",
                format!("one of `{}`", names.collect::<Vec<_>>().join("`, `")),
                "name the maneuvers in the dictionary as in the trajectories",
            ));
        }
        let reasons = || all.iter().filter_map(|maneuver| Some((maneuver, maneuver.reason.as_ref()?)));
        // What logs without a dictionary are is said of each of them.
        let is_none = self.generator.is_some() && all.iter().all(|maneuver| maneuver.figures.is_empty());
        if let (true, Some((maneuver, reason))) = (is_none, reasons().next()) {
            let thing = format!("maneuver `{}`, {}", maneuver.name, reason.thing);
            return Err(Invalid { thing, ..reason.clone() });
        }
        let merit = |one: &Gathered| {
            let merit = ManeuverMerit {
                name: one.name.clone(),
                kind: one.kind.clone(),
                sailed: Some(one.sailed.clone()).filter(|sailed| !sailed.is_empty()),
                runs: one.figures.len() as u64,
                without: one.without,
                diverged: one.diverged,
                reason: one.why(),
                figures: FigureMerit::all(&one.figures, (of_parameters, one.is_interval_known())),
                remarks: one.remarks.values().map(|remark| counted(remark, one.figures.len())).collect(),
                track: one.track.clone().unwrap_or_default(),
            };
            merit.with_slopes(one.slopes.as_ref())
        };
        Ok(all.into_iter().map(merit).collect())
    }
}

/// A remark, and of how many of all runs it is.
fn counted((runs, words): &(u64, String), all: usize) -> String {
    if all < 2 { words.clone() } else { format!("{runs} of {all} runs, such as: {words}") }
}

/// A maneuver, and what the undisturbed ship with `parameters` does in it.
fn undisturbed<'a>(
    vessel: &Vessel,
    generator: &'a Generator,
    index: usize,
    parameters: &[f64],
) -> Result<(Standard<'a>, Record), Unsimulated> {
    let made = generator.samples(index).and_then(|samples| Ok((samples, generator.realize(index, samples)?)));
    let (samples, realized) = made.map_err(Unsimulated::Unheld)?;
    let maneuver = &generator.maneuvers()[index];
    let (Some(standard), Some(helm)) = (maneuver.kind.standard(), &realized.helm) else {
        let e = Invalid::new("maneuver", "no orders", "those of a standard maneuver", "remove it");
        return Err(Unsimulated::Unheld(e));
    };
    let (model, rate_hz) = (&vessel.model, vessel.sample_rate_hz);
    let run = simulate_command(model, parameters, realized.initial, samples, rate_hz, helm);
    if let Some(at) = check_runaway(&run.states, standard.speed_m_s()) {
        let what = format!("model in maneuver `{}`", maneuver.name);
        return Err(Unsimulated::Diverged(at.invalid(what, rate_hz)));
    }
    Ok((standard, Record::of_states(&run.states, model.inputs_of(&run.exogenous), rate_hz)))
}
