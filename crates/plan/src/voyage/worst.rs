//! The worst vessels and currents within the stated errors, searched for instead of drawn.
//!
//! Of every leg of a plan two things are made as bad as possible: how near the hull comes to a danger, and how far
//! off the leg ends. Runs with one coordinate at either end say which corner of the errors is the worst for each, if
//! the dependence were linear. For that, distances are interpolated between cells, and how far off a leg ends is split
//! into quantities with signs. From the worst of these runs the search goes on to their neighbours. A run simulates the
//! whole plan, so it counts for all legs.

use std::collections::{BTreeMap, BTreeSet};

use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::check_run::{CheckedRun, Checking, Vessel};
use super::clearance::compass_deg;
use super::error::{Search, VoyageError, in_words, numbers, parameters_in_words, percent_off};
use super::prepared::Prepared;
use crate::sampled_vessel::{Candidate, Doubt, goal_value, goals};
use crate::{SampledVessel, Used};

/// How many of the worst vessels by either quantity have their neighbours tried, and how often.
const FOLLOWED: usize = 6;
const SWEEPS: usize = 3;
/// Corners of quantities by which legs end off that are tried: so many of all, and the worst one of each leg.
const CORNERS: usize = 96;

/// The worst vessels and currents within the stated errors that were found.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorstVessels {
    /// How many vessels were tried, each in a current of its own over the whole plan.
    pub searched: u64,
    /// Of which touched an obstacle, or went where the chart was not read.
    pub aground: u64,
    /// Of which came nearer than the margin, those aground among them.
    pub below_margin: u64,
    /// Ends of their legs.
    pub ends: u64,
    /// Of which lie beyond a tolerance.
    pub ends_astray: u64,
    /// Least distance of any of them from an obstacle \[m\].
    pub clearance_m: f64,
    /// The one that comes so near.
    pub nearest: WorstVessel,
    /// Largest part of a tolerance that any of them uses at the end of a leg.
    pub tolerance_used: f64,
    /// The one that ends so far off.
    pub farthest: WorstVessel,
}

/// A vessel in a current, and where it is worst.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct WorstVessel {
    /// Step of the plan, from 1.
    pub step: u64,
    /// Its action.
    pub leg: String,
    /// Whether that is an informative maneuver.
    pub informative: bool,
    /// Difference of every parameter from the nominal one, relative to that \[%\]; of a ship with forces without those whose
    /// nominal value is 0.
    pub parameters_percent: BTreeMap<String, f64>,
    /// The numbers of a ship with forces, in the system that they are written in.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub numbers: BTreeMap<String, f64>,
    /// Speed of the unknown current \[m/s\].
    pub current_m_s: f64,
    /// Compass direction that it sets towards \[deg\].
    pub towards_deg: f64,
}

/// The runs of a search.
pub(super) struct Searched {
    runs: Vec<(Candidate, CheckedRun)>,
}

/// A quantity of a leg that is made as bad as possible.
#[derive(Clone, Copy)]
struct Target {
    step: usize,
    what: What,
}

#[derive(Clone, Copy, PartialEq)]
enum What {
    /// Nearness to a danger.
    Nearness,
    /// The used part of the tolerance at its end.
    Used,
}

/// The worst run for a leg.
#[derive(Clone, Copy)]
struct Worst {
    badness: f64,
    /// Index of the run.
    index: usize,
    step: usize,
}

impl Target {
    /// The greater, the worse; `None` of a leg that began beyond its tolerance, since another one is the cause.
    fn badness(self, run: &CheckedRun) -> Option<f64> {
        let Self { step, what } = self;
        run.began_well(step).then(|| match what {
            What::Nearness => -run.clearances_m[step],
            What::Used => run.used[step].part(),
        })
    }

    /// The same where the search compares runs: distances are interpolated between cells.
    fn compared(self, run: &CheckedRun) -> Option<f64> {
        match self.what {
            What::Nearness => run.began_well(self.step).then(|| -run.between_cells_m[self.step]),
            What::Used => self.badness(run),
        }
    }
}

impl Checking<'_> {
    /// Searches the worst vessels. A search that finds counter-examples ends there, except in the last round.
    pub(super) fn worst(&self, search: &Search) -> Result<Searched, VoyageError> {
        let doubt = self.prepared().brief.doubt();
        let mut searched = Searched { runs: Vec::new() };
        if doubt.is_none() {
            return Ok(searched);
        }
        let axes = doubt.axes();
        let count = axes.len();
        searched.add(self, &doubt, (axes, true), search)?;
        let outer = [searched.nearest(self, &doubt, count), searched.farthest(self, &doubt, count)].concat();
        searched.add(self, &doubt, (outer, false), search)?;
        for _ in 0..SWEEPS {
            if !self.is_last && searched.fails(self) {
                break;
            }
            let neighbours = searched.followed(self).flat_map(|who| doubt.neighbours(who)).collect();
            if !searched.add(self, &doubt, (neighbours, false), search)? {
                break;
            }
        }
        Ok(searched)
    }

    fn targets(&self) -> impl Iterator<Item = Target> {
        let what = [What::Nearness, What::Used];
        (0..self.legs.len()).flat_map(move |step| what.map(|what| Target { step, what }))
    }
}

impl Searched {
    /// Simulates those of `candidates` that are new; returns whether there are any. Where they are `compared`, all have the same
    /// noise, and differ in their parameters and currents alone.
    fn add(
        &mut self,
        checking: &Checking,
        doubt: &Doubt,
        (candidates, compared): (Vec<Candidate>, bool),
        search: &Search,
    ) -> Result<bool, VoyageError> {
        let mut known: BTreeSet<Vec<u64>> = self.runs.iter().map(|(who, _)| key(who)).collect();
        let new: Vec<Candidate> = candidates.into_iter().filter(|who| known.insert(key(who))).collect();
        let vessel = |(who, number): (&Candidate, u32)| Vessel {
            parameters: doubt.parameters(who),
            unknown_m_s: doubt.current(who),
            is_drawn: false,
            noise: if compared { 0 } else { number },
            is_searched: true,
            aborts: true,
        };
        let runs = checking.all(new.iter().zip(self.runs.len() as u32..).map(vessel).collect(), search)?;
        let any = !new.is_empty();
        self.runs.extend(new.into_iter().zip(runs));
        Ok(any)
    }

    /// The corners where legs come nearest to a danger, by the first `axes` runs.
    fn nearest(&self, checking: &Checking, doubt: &Doubt, axes: usize) -> Vec<Candidate> {
        let value = |target: Target, run: &CheckedRun| target.compared(run).unwrap_or(0.0);
        let corner = |target: Target| {
            let values: Vec<f64> = self.runs[..axes].iter().map(|(_, run)| value(target, run)).collect();
            doubt.extreme(&values)
        };
        checking.targets().filter(|target| target.what == What::Nearness).map(corner).collect()
    }

    /// The corners where legs end farthest off by one of their quantities: the worst one of each leg, and the worst of all.
    fn farthest(&self, checking: &Checking, doubt: &Doubt, axes: usize) -> Vec<Candidate> {
        let corner = |off: &[[f64; 6]], goal: &[f64; 6]| {
            let values: Vec<f64> = off.iter().map(|end| goal_value(goal, end)).collect();
            let who = doubt.extreme(&values);
            (doubt.predicted(&values, &who), who)
        };
        let (goals, mut corners) = (goals(), Vec::new());
        for step in 0..checking.legs.len() {
            let off = |run: &CheckedRun| run.began_well(step).then(|| checking.off(step, run.ends[step]));
            let off: Vec<_> = self.runs[..axes].iter().map(|(_, run)| off(run).unwrap_or_default()).collect();
            corners.extend(goals.iter().map(|goal| (step, corner(&off, goal))));
        }
        corners.sort_by(|(_, a), (_, b)| b.0.total_cmp(&a.0));
        let mut steps = BTreeSet::new();
        let mut is_kept = |rank: usize, step: usize| steps.insert(step) || rank < CORNERS;
        let ranked = corners.into_iter().enumerate();
        ranked.filter_map(|(rank, (step, (_, who)))| is_kept(rank, step).then_some(who)).collect()
    }

    /// The worst candidate of a target.
    fn worst(&self, target: Target, badness: fn(Target, &CheckedRun) -> Option<f64>) -> Option<Worst> {
        let measured = |(index, (_, run)): (usize, &(Candidate, CheckedRun))| {
            badness(target, run).map(|badness| Worst { badness, index, step: target.step })
        };
        // The first of equals.
        self.runs
            .iter()
            .enumerate()
            .filter_map(measured)
            .reduce(|best, other| if other.badness > best.badness { other } else { best })
    }

    /// The candidates that are the worst for any leg, the very worst of either quantity.
    fn followed(&self, checking: &Checking) -> impl Iterator<Item = &Candidate> {
        let mut indices = Vec::new();
        for what in [What::Nearness, What::Used] {
            let targets = checking.targets().filter(|target| target.what == what);
            let mut worst: Vec<Worst> = targets.filter_map(|one| self.worst(one, Target::compared)).collect();
            worst.sort_by(|a, b| b.badness.total_cmp(&a.badness));
            let mut some: Vec<usize> = Vec::new();
            for Worst { index, .. } in worst {
                if some.len() < FOLLOWED && !some.contains(&index) {
                    some.push(index);
                }
            }
            indices.extend(some);
        }
        indices.into_iter().map(|index| &self.runs[index].0)
    }

    /// All of them.
    pub(super) fn runs(&self) -> impl Iterator<Item = &CheckedRun> {
        self.runs.iter().map(|(_, run)| run)
    }

    fn fails(&self, checking: &Checking) -> bool {
        let margin_m = checking.prepared().brief.task.safety.margin_m;
        self.runs.iter().any(|(_, run)| run.passage.clearance_m < margin_m) || self.ends_astray(checking)
    }

    /// Whether too many ends of legs are beyond a tolerance.
    fn ends_astray(&self, checking: &Checking) -> bool {
        checking.are_too_many_astray(&self.runs.iter().map(|(_, run)| run).collect::<Vec<_>>())
    }

    /// The worst vessel of every leg that violates its margin or its tolerance.
    pub(super) fn counter_examples(&self, checking: &Checking) -> Vec<(usize, SampledVessel)> {
        let margin_m = checking.prepared().brief.task.safety.margin_m;
        let if_astray = self.ends_astray(checking);
        let targets = checking.targets().filter(|target| if_astray || target.what == What::Nearness);
        let failing = targets.filter_map(|target| {
            let Worst { badness, index, .. } = self.worst(target, Target::badness)?;
            let bound = if target.what == What::Nearness { -margin_m } else { 1.0 };
            (badness > bound).then(|| (target.step, self.runs[index].1.sampled_vessel(checking, target.step)))
        });
        failing.collect()
    }

    /// The largest used fractions of any of them.
    pub(super) fn most_used(&self) -> Used {
        self.runs.iter().map(|(_, run)| run.most_used()).fold(Used::NONE, Used::or_more)
    }

    /// What was found; `None` without a search.
    pub(super) fn summary(&self, checking: &Checking) -> Option<WorstVessels> {
        let (near, far) = (self.worst_of(checking, What::Nearness)?, self.worst_of(checking, What::Used)?);
        let margin_m = checking.prepared().brief.task.safety.margin_m;
        let count =
            |is: &dyn Fn(&CheckedRun) -> bool| self.runs.iter().filter(|(_, run)| is(run)).count() as u64;
        Some(WorstVessels {
            searched: self.runs.len() as u64,
            aground: count(&|run| run.passage.clearance_m <= 0.0),
            below_margin: count(&|run| run.passage.clearance_m < margin_m),
            ends: self.runs.iter().map(|(_, run)| run.ends.len() as u64).sum(),
            ends_astray: self.runs.iter().map(|(_, run)| run.ends_astray()).sum(),
            clearance_m: -near.badness,
            nearest: self.named(checking, near),
            tolerance_used: far.badness,
            farthest: self.named(checking, far),
        })
    }

    /// The worst of all legs.
    fn worst_of(&self, checking: &Checking, what: What) -> Option<Worst> {
        let targets = checking.targets().filter(|target| target.what == what);
        let all = targets.filter_map(|target| self.worst(target, Target::badness));
        all.reduce(|best, other| if other.badness > best.badness { other } else { best })
    }

    fn named(&self, checking: &Checking, Worst { index, step, .. }: Worst) -> WorstVessel {
        let (prepared, Vessel { parameters, unknown_m_s: [north, east], .. }) =
            (checking.prepared(), &self.runs[index].1.vessel);
        let leg = &prepared.legs[checking.legs[step]];
        WorstVessel {
            step: step as u64 + 1,
            leg: leg.name.clone(),
            informative: leg.is_informative(),
            parameters_percent: percent_off(&prepared.brief.vessel, parameters),
            numbers: numbers(&prepared.brief.vessel, parameters),
            current_m_s: libm::hypot(*north, *east),
            towards_deg: compass_deg(libm::atan2(*east, *north)),
        }
    }
}

/// A candidate's numbers, to tell it from others.
fn key(who: &Candidate) -> Vec<u64> {
    who.at.iter().chain(&who.current).map(|x| (x + 0.0).to_bits()).collect()
}

impl WorstVessel {
    /// The vessel and its current, in words.
    pub fn words(&self) -> String {
        let Self { parameters_percent, numbers, current_m_s, towards_deg, .. } = self;
        let who = in_words(parameters_percent, numbers);
        match *current_m_s > 0.0 {
            true => format!("{who} in {current_m_s:.2} m/s towards {towards_deg:.0}°"),
            false => who,
        }
    }

    /// The leg, in words, and the keys that matter for it.
    fn place(&self, key: &str) -> String {
        let Self { step, leg, informative, .. } = self;
        let other = if *informative { ", or its `piece_s`" } else { " or `safety.unknown_current_m_s`" };
        let remedy = format!("lower `{key}`{other}");
        format!("step {step} `{leg}`: {remedy}")
    }
}

impl WorstVessels {
    /// What is broken, in words; a share of the ends of legs may be astray. `key` bounds the parameters.
    pub(super) fn faults(&self, astray: f64, key: &str) -> Vec<String> {
        let Self {
            searched, aground, below_margin, ends, ends_astray, clearance_m, nearest, farthest, ..
        } = self;
        let mut faults = Vec::new();
        if *aground > 0 {
            faults.push(format!(
                "of {searched} vessels searched one ({}) runs aground on {}",
                nearest.words(),
                nearest.place(key)
            ));
        } else if *below_margin > 0 {
            faults.push(format!(
                "of {searched} vessels searched one ({}) comes as near as {clearance_m:.0} m on {}",
                nearest.words(),
                nearest.place(key)
            ));
        }
        if *ends_astray as f64 > astray * *ends as f64 {
            faults.push(format!(
                "of {searched} vessels searched one ({}) ends {:.1} times its tolerance off on {}",
                farthest.words(),
                self.tolerance_used,
                farthest.place(key)
            ));
        }
        faults
    }
}

/// For how many response times a vessel is steered.
const RESPONSES: f64 = 10.0;

impl Prepared {
    /// Refuses errors within which a vessel does not come to hold its course and speed in some mode: the vessels at
    /// either end of a parameter, and the worst corner by these.
    pub(super) fn check_steered(&self) -> Result<(), Invalid> {
        let doubt = self.brief.doubt();
        if doubt.deviations.is_none() {
            return Ok(());
        }
        for mode in 0..self.grid.modes.len() {
            let layer = self.grid.layer(0, mode);
            let mut tried: Vec<(f64, Candidate)> = Vec::new();
            for who in doubt.axes() {
                tried.push((self.held(layer, &who)?.part(), who));
            }
            let parts: Vec<f64> = tried.iter().map(|(part, _)| part.min(LOST)).collect();
            let corner = doubt.extreme(&parts);
            tried.push((self.held(layer, &corner)?.part(), corner));
            if let Some((_, who)) = tried.iter().find(|(part, _)| *part > 1.0) {
                return Err(self.cannot_be_steered(mode, who, self.held(layer, who)?));
            }
        }
        Ok(())
    }

    /// The used part of the tolerance of a settled motion, after being steered along a line for a while.
    fn held(&self, layer: usize, who: &Candidate) -> Result<Used, Invalid> {
        let (doubt, repertoire) = (self.brief.doubt(), self.repertoire());
        let (level, mode) = self.grid.level_and_mode(layer);
        let (heading, speed) = (self.grid.heading_rad(level), self.grid.modes[mode].speed_m_s);
        let mut underway = repertoire.underway(layer, Some(&doubt.on_node(who)), None)?;
        underway.hold(heading, speed, RESPONSES * repertoire.handling.response_s)?;
        let tolerance = repertoire.approach.tolerance;
        let [u, v, r] = underway.ship.state;
        Ok(if [u, v, r].iter().all(|x| x.is_finite()) {
            tolerance.used_in_motion([u, v, r], speed)
        } else {
            Used::Lost
        })
    }

    fn cannot_be_steered(&self, mode: usize, who: &Candidate, used: Used) -> Invalid {
        let doubt = self.brief.doubt();
        let words = parameters_in_words(&self.brief.vessel, &doubt.parameters(who));
        let (mode, s) = (&self.grid.modes[mode].name, RESPONSES * self.brief.task.handling.response_s);
        Invalid::new(
            format!("`{}`", self.brief.task.safety.key()),
            format!("a vessel with {words} that cannot be steered: in mode `{mode}` after {s:.0} s {used}"),
            "errors within which every vessel holds its course and speed",
            "lower it, or leave the mode out",
        )
    }
}

/// Parts of a tolerance beyond this are all the same.
const LOST: f64 = 1e6;
