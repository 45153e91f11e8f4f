use std::collections::BTreeSet;
use std::ops::Range;
use std::sync::Arc;

use design::apportion;
use maneuver::{Generator, Reacting, Realized};
use numerics::{GROUPS, LANES};
use rayon::prelude::*;
use ship::engine::{Helm, Segment, Streams, refuse_endless};
use ship::model::Vessel;

use super::Refusal;
use super::designed::{Designed, Parts, Plan, drawable, left_out, too_short};
use super::sea::{Group, OwnLoop, Sea, SimulatedRun, States, Wanted};
use super::together::{Experiment, Together, not_sailed, practice};

/// Channel of the random stream that draws a random design's maneuvers.
const MANEUVER_CHANNEL: u32 = 100;

/// Size and seed of a campaign.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// Duration of every run \[s\].
    pub duration_s: f64,
    /// Runs per design.
    pub realizations: u32,
    /// Segments of the random design, if there is one; then there is one of today's practice, too.
    pub random_segments: Option<u32>,
    /// Seed of all random numbers.
    pub seed: u64,
}

impl Settings {
    /// Samples of every run.
    ///
    /// # Errors
    /// Unbounded runs.
    pub fn samples(&self, vessel: &Vessel) -> Result<usize, Refusal> {
        let samples = vessel.samples(self.duration_s);
        refuse_endless("`duration_s`", samples).map_err(Refusal::Campaign)?;
        Ok(samples)
    }

    /// Runs of all designs, at most.
    pub fn runs(&self) -> f64 {
        f64::from(self.realizations) * if self.random_segments.is_some() { 3.0 } else { 1.0 }
    }
}

/// A campaign: many disturbed runs of each of its designs.
pub struct Campaign<'a> {
    sea: Sea<'a>,
    samples: usize,
    realizations: u32,
    designs: Vec<Design>,
    /// Every maneuver at every length that occurs.
    parts: Parts,
    names: Vec<String>,
    /// Statements about maneuvers with tables of inputs, and about designs that are left out.
    statements: Vec<String>,
    /// What the maneuvers react by.
    reacting: Reacting,
}

struct Design {
    name: &'static str,
    streams: Streams,
    rule: Rule,
    /// The common experiment of all runs, if there is one.
    all: Option<Arc<Experiment>>,
}

/// The rule for the runs of a design.
enum Rule {
    /// All the same.
    Fixed(Plan),
    /// One of `maneuvers` drawn for each of the lengths.
    Drawn { maneuvers: Vec<usize>, lengths: Vec<usize> },
}

/// Up to [`LANES`] runs of a design with their experiments.
struct Doing {
    numbers: Vec<u32>,
    experiments: Vec<Arc<Experiment>>,
}

impl Doing {
    fn group<'a>(&'a self, design: &'a Design) -> Group<'a> {
        Group {
            design: design.name,
            streams: &design.streams,
            runs: &self.numbers,
            initial: self.experiments.iter().map(|experiment| experiment.initial).collect(),
            exogenous: self.experiments.iter().map(|experiment| experiment.exogenous.as_slice()).collect(),
            helms: self.experiments.iter().filter_map(|experiment| experiment.helm.clone()).collect(),
        }
    }
}

impl Design {
    fn new(name: &'static str, seed: u64, rule: Rule) -> Self {
        Self { name, streams: Streams::new(seed, name), rule, all: None }
    }

    /// Plans that contain every maneuver at every length that occurs in `realizations` runs: the runs' own,
    /// unless all possible ones are fewer.
    fn occurring(&self, realizations: u32) -> Box<dyn Iterator<Item = Plan> + '_> {
        match &self.rule {
            Rule::Fixed(plan) => Box::new(std::iter::once(plan.clone())),
            Rule::Drawn { maneuvers, lengths } => {
                let different: BTreeSet<usize> = lengths.iter().copied().collect();
                if maneuvers.len() * different.len() > lengths.len().saturating_mul(realizations as usize) {
                    return Box::new((0..realizations).map(|run| self.plan(run)));
                }
                let of = move |length: usize| maneuvers.iter().map(move |q| (*q, length)).collect();
                Box::new(different.into_iter().map(of))
            }
        }
    }

    fn plan(&self, run: u32) -> Plan {
        match &self.rule {
            Rule::Fixed(plan) => plan.clone(),
            Rule::Drawn { maneuvers, lengths } => random_segments(&self.streams, run, maneuvers, lengths),
        }
    }
}

/// Any of `maneuvers`, drawn at random for each of the lengths of a run.
pub fn random_segments(streams: &Streams, run: u32, maneuvers: &[usize], lengths: &[usize]) -> Plan {
    let drawn = streams.choices(run, MANEUVER_CHANNEL, maneuvers.len() as u32, lengths.len());
    drawn.iter().zip(lengths).map(|(q, n)| (maneuvers[*q as usize], *n)).collect()
}

impl<'a> Campaign<'a> {
    /// Runs of `design` (`optimized`), of maneuvers drawn at random (`random`) and of the standard maneuvers one after
    /// another, as in today's practice (`practice`). A practice that the undisturbed ship cannot sail is left out, with a statement.
    ///
    /// # Errors
    /// A design of other maneuvers, a run shorter than its segments, a maneuver that the model cannot hold.
    pub fn new(
        sea: Sea<'a>,
        generator: &Generator,
        design: &Designed,
        settings: &Settings,
    ) -> Result<Self, Refusal> {
        let samples = settings.samples(sea.vessel())?;
        let names: Vec<String> = generator.maneuvers().iter().map(|m| m.name.clone()).collect();
        let tables = generator.tables();
        let optimized = design.plan(&names, tables, samples)?;
        let mut statements = design.said(&names, tables, &optimized);
        statements.extend(design.at_rest(generator, &optimized, sea.vessel().sample_rate_hz));
        let mut designs = vec![Design::new("optimized", settings.seed, Rule::Fixed(optimized))];
        if let Some(segments) = settings.random_segments {
            if segments as usize > samples {
                return Err(too_short(samples, "random.segments"));
            }
            // Generated maneuvers that exceed their limits are not part of any design.
            let known = |q: &usize| generator.limits(*q).is_none() || design.shares.contains_key(&names[*q]);
            let known: Vec<usize> = (0..names.len()).filter(known).collect();
            let lengths = even_lengths(segments as usize, samples);
            let maneuvers = drawable(&known, tables, &lengths);
            statements.extend(left_out(&known, &maneuvers, tables, &lengths));
            if !maneuvers.is_empty() {
                designs.push(Design::new("random", settings.seed, Rule::Drawn { maneuvers, lengths }));
            }
        }
        let mut parts = Parts::default();
        for plan in designs.iter().flat_map(|d| d.occurring(settings.realizations)) {
            parts.make(generator, &plan).map_err(Refusal::Dictionary)?;
        }
        let (realizations, reacting) = (settings.realizations, generator.reacting());
        let all = Self { sea, samples, realizations, designs, parts, names, statements, reacting }.prepared();
        Ok(if settings.random_segments.is_some() { all.practised(generator, settings.seed) } else { all })
    }

    /// Adds today's practice, or says why it is left out.
    fn practised(mut self, generator: &Generator, seed: u64) -> Self {
        // Parts of its own: by others' that react, these designs would react.
        let made = practice(generator, self.samples).and_then(|(plan, parts)| {
            let all = self.experiment(&parts, &plan);
            not_sailed(self.vessel(), &all).map_or(Ok((plan, all)), Err)
        });
        match made {
            Ok((plan, all)) => {
                let design = Design::new("practice", seed, Rule::Fixed(plan));
                self.designs.push(Design { all: Some(Arc::new(all)), ..design });
            }
            Err(why) => self.statements.push(format!("no practice trials, since {why}")),
        }
        self
    }

    /// Repeats `inputs` (N × inputs) from `initial`, open loop, as design `planned`.
    pub fn planned(
        sea: Sea<'a>,
        initial: [f64; 3],
        inputs: &[f64],
        segments: &[Segment],
        settings: &Settings,
    ) -> Self {
        let width = sea.vessel().model.inputs;
        let samples = inputs.len() / width;
        let ends = segments.iter().skip(1).map(|segment| segment.start).chain([samples]);
        let parts = segments.iter().zip(ends).enumerate();
        let plan: Plan = parts.map(|(i, (segment, end))| (i, end - segment.start)).collect();
        let realize = |(part, segment): (&(usize, usize), &Segment)| {
            let input = &inputs[segment.start * width..(segment.start + part.1) * width];
            (*part, Realized { initial, inputs: input.to_vec(), helm: None })
        };
        let parts = plan.iter().zip(segments).map(realize).collect();
        let names = segments.iter().map(|segment| segment.maneuver.clone()).collect();
        let designs = vec![Design::new("planned", settings.seed, Rule::Fixed(plan))];
        let (realizations, statements, reacting) = (settings.realizations, Vec::new(), Reacting::default());
        Self { sea, samples, realizations, designs, parts, names, statements, reacting }.prepared()
    }

    /// Prepares the common experiment of all runs of a design once.
    fn prepared(mut self) -> Self {
        let all = |design: &Design| match &design.rule {
            Rule::Fixed(plan) => Some(Arc::new(self.experiment(&self.parts, plan))),
            Rule::Drawn { .. } => None,
        };
        let all: Vec<_> = self.designs.iter().map(all).collect();
        self.designs.iter_mut().zip(all).for_each(|(design, all)| design.all = all);
        self
    }

    fn experiment(&self, parts: &Parts, plan: &[(usize, usize)]) -> Experiment {
        let (initial, inputs) = parts.joined(plan);
        let model = &self.sea.vessel().model;
        let exogenous = if model.exogenous() == model.inputs { inputs } else { model.undisturbed(&inputs) };
        let helms = parts.react().then(|| parts.helms(plan));
        let own_loop = helms.as_deref().and_then(|helms| OwnLoop::new(self.vessel(), initial, helms));
        let helm = helms.map(Helm::sequence);
        Experiment { segments: self.segments(plan), initial, exogenous, helm, own_loop }
    }

    /// The vessel.
    pub fn vessel(&self) -> &'a Vessel {
        self.sea.vessel()
    }

    /// Statements about maneuvers with tables of inputs, and about designs that are left out, one line each.
    pub fn statements(&self) -> &[String] {
        &self.statements
    }

    /// What the maneuvers react by.
    pub fn reacting(&self) -> &Reacting {
        &self.reacting
    }

    /// Number of designs.
    pub fn designs(&self) -> usize {
        self.designs.len()
    }

    /// Their names.
    pub fn names(&self) -> Vec<&'static str> {
        self.designs.iter().map(|design| design.name).collect()
    }

    /// Runs per design.
    pub fn realizations(&self) -> usize {
        self.realizations as usize
    }

    /// Number of runs of all designs.
    pub fn runs(&self) -> usize {
        self.designs.len() * self.realizations()
    }

    /// Samples per run.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Simulates all runs, design by design.
    ///
    /// # Errors
    /// A simulation that diverges.
    pub fn simulate_all(&self) -> Result<Vec<SimulatedRun>, Refusal> {
        let groups = self.realizations().div_ceil(LANES);
        let group = |i: usize| {
            let (design, first) = (i / groups, i % groups * LANES);
            self.simulate(design, first..self.realizations().min(first + LANES), Wanted::Truth)
        };
        let all: Vec<_> = (0..self.designs.len() * groups).into_par_iter().map(group).collect();
        Ok(all.into_iter().collect::<Result<Vec<_>, _>>()?.into_iter().flatten().collect())
    }

    /// Simulates some runs of one design, with what is `wanted` of them.
    ///
    /// # Errors
    /// A simulation that diverges.
    pub fn simulate(
        &self,
        design: usize,
        runs: Range<usize>,
        wanted: Wanted,
    ) -> Result<Vec<SimulatedRun>, Refusal> {
        let mut all = Vec::with_capacity(runs.len());
        for some in groups(runs, GROUPS * LANES) {
            for together in self.together(design, some, wanted)? {
                all.extend((0..together.runs()).map(|lane| together.run(lane)));
            }
        }
        Ok(all)
    }

    /// The common experiment of all runs of a design, if it does not depend on disturbances.
    pub fn experiment_of_all(&self, design: usize) -> Option<&Arc<Experiment>> {
        self.designs[design].all.as_ref().filter(|all| all.helm.is_none())
    }

    /// Simulates up to [`GROUPS`] times [`LANES`] runs of one design in lanes, with what is `wanted` of them.
    ///
    /// # Errors
    /// A simulation that diverges.
    pub fn together(
        &self,
        design: usize,
        runs: Range<usize>,
        wanted: Wanted,
    ) -> Result<Vec<Together<'a>>, Refusal> {
        let design = &self.designs[design];
        let all: Vec<Doing> = groups(runs, LANES).map(|group| self.doing(design, group)).collect();
        let groups: Vec<Group> = all.iter().map(|doing| doing.group(design)).collect();
        let mut states = Vec::with_capacity(groups.len());
        match <&[Group; GROUPS]>::try_from(groups.as_slice()) {
            Ok(groups) => states.extend(self.sea.simulate_groups(groups.each_ref(), wanted)?),
            Err(_) => {
                for group in &groups {
                    states.extend(self.sea.simulate_groups([group], wanted)?);
                }
            }
        }
        let model = &self.vessel().model;
        let together = |(doing, states): (Doing, States)| Together {
            model,
            design: design.name,
            first: doing.numbers.first().copied().unwrap_or(0),
            experiments: doing.experiments,
            states,
        };
        Ok(all.into_iter().zip(states).map(together).collect())
    }

    fn doing(&self, design: &Design, runs: Range<usize>) -> Doing {
        let numbers: Vec<u32> = runs.map(|run| run as u32).collect();
        let experiment = |run: &u32| match &design.all {
            Some(all) => Arc::clone(all),
            None => Arc::new(self.experiment(&self.parts, &design.plan(*run))),
        };
        Doing { experiments: numbers.iter().map(experiment).collect(), numbers }
    }

    fn segments(&self, plan: &[(usize, usize)]) -> Vec<Segment> {
        let mut start = 0;
        let begin = |(maneuver, samples): &(usize, usize)| {
            start += samples;
            Segment { maneuver: self.names[*maneuver].clone(), start: start - samples }
        };
        plan.iter().map(begin).collect()
    }
}

/// `runs` in groups of `many`.
fn groups(runs: Range<usize>, many: usize) -> impl Iterator<Item = Range<usize>> {
    let end = runs.end;
    runs.step_by(many).map(move |first| first..end.min(first + many))
}

/// Lengths of `segments` equally long segments of a run.
pub(crate) fn even_lengths(segments: usize, samples: usize) -> Vec<usize> {
    let even = vec![1.0 / segments as f64; segments];
    apportion(&even, samples as u64).into_iter().map(|n| n as usize).collect()
}
