//! Today's practice: the maneuvers of a dictionary, one after another.

use design::apportion;
use maneuver::Generator;
use ship::engine::{check_diverged, simulate_command, simulate_one};
use ship::model::{Source, Vessel};

use super::designed::Parts;
use super::plays::{Plan, Tables};
use super::together::Experiment;

/// Experiments of `samples` samples of today's practice, with their parts; or why there are none, for users.
///
/// A round has the maneuvers that are written by hand, in the dictionary's order and at their own lengths. Rounds are repeated and the
/// last one is cut; a round longer than the experiment is shortened, all its maneuvers alike. Tables of inputs are played whole or left
/// out.
pub(super) fn practice(generator: &Generator, samples: usize) -> Result<(Plan, Parts), String> {
    let own = 0..generator.written();
    if own.len() < 2 {
        let has = generator.maneuvers()[own]
            .first()
            .map_or("none".to_owned(), |own| format!("only `{}`", own.name));
        return Err(format!("they take two hand-written maneuvers or more, and the dictionary has {has}"));
    }
    let lengths = own.into_iter().map(|q| generator.samples(q).map(|n| (q, n)));
    let round: Plan = lengths.collect::<Result<_, _>>().map_err(|e| e.to_string())?;
    let plan = repeated(&round, generator.tables(), samples)
        .ok_or("whole plays of the dictionary's tables do not fill them")?;
    let mut parts = Parts::default();
    parts.make(generator, &plan).map_err(|e| e.to_string())?;
    Ok((plan, parts))
}

/// `round` in turn in `samples` samples; `None` if tables leave samples that nothing fills.
fn repeated(round: &[(usize, usize)], tables: &Tables, samples: usize) -> Option<Plan> {
    let length = |round: &[(usize, usize)]| round.iter().map(|(_, n)| n).sum::<usize>();
    let is_cut = |(q, _): &&(usize, usize)| !tables.contains_key(q);
    if length(round) > samples {
        let round: Plan = round.iter().filter(is_cut).copied().collect();
        let whole = length(&round);
        if whole > samples {
            let shares: Vec<f64> = round.iter().map(|(_, n)| *n as f64 / whole as f64).collect();
            let counts = apportion(&shares, samples as u64).into_iter().map(|n| n as usize);
            return Some(round.iter().map(|(q, _)| *q).zip(counts).filter(|(_, n)| *n > 0).collect());
        }
    }
    let (mut plan, mut rest) = (Plan::new(), samples);
    while rest > 0 {
        let before = rest;
        for (q, n) in round {
            let own = if *n > rest && tables.contains_key(q) { 0 } else { rest.min(*n) };
            plan.extend((own > 0).then_some((*q, own)));
            rest -= own;
        }
        if rest == before {
            return None;
        }
    }
    Some(plan)
}

/// Why the undisturbed ship cannot sail `own`, for users: the maneuver in which she diverges.
pub(super) fn not_sailed(vessel: &Vessel, experiment: &Experiment) -> Option<String> {
    let (model, rate_hz) = (&vessel.model, vessel.sample_rate_hz);
    let truth = vessel.parameters(Source::Value).ok()?;
    let states = match &experiment.helm {
        None => simulate_one(model, &truth, experiment.initial, &experiment.exogenous),
        Some(helm) => {
            let samples = experiment.exogenous.len() / model.exogenous().max(1);
            simulate_command(model, &truth, experiment.initial, samples, rate_hz, helm).states
        }
    };
    let at = check_diverged(states.into_iter())?;
    let segment = experiment.segments.iter().rev().find(|segment| segment.start < at.sample.max(1))?;
    let after_s = at.sample as f64 / rate_hz;
    Some(format!("the ship diverges in maneuver `{}`, {after_s:.1} s after their start", segment.maneuver))
}
