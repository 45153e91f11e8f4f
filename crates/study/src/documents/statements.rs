//! Statements about designs.

use std::collections::BTreeMap;

use design::{Accuracy, Criterion, Design, Method, Restricted, Status, Whole};
use ship::model::Source;
use trial::arranging::{Arranged, Foretold, Kept, Promised, TrialKind};
use trial::moments::{Promise, SampledFrom, SampledShips, UnreachedMotion};
use trial::refining::Refinement;

use super::design::DesignPromise;

/// About shares. `bound`: whether the available amounts limit them.
pub(super) fn certificate(design: &Design, criterion: &Criterion, bound: bool) -> String {
    let agreeing = design.starts.iter().filter(|start| design.agrees(start)).count();
    let starts = match design.starts.len() {
        1 => String::new(),
        all => format!("; {agreeing} of {all} starts reached this value"),
    };
    let gap = design.gap / criterion.degree();
    let within = if bound { " that are available" } else { "" };
    match (design.status, criterion) {
        (Status::Optimal, Criterion::Information(_)) => format!(
            "Globally optimal: the problem is concave, and no shares{within} have a criterion more than {:.1e} higher{starts}.",
            design.gap.max(0.0)
        ),
        (Status::Optimal, Criterion::Covariance(_)) => format!(
            "Globally optimal: the problem is convex, and no shares{within} save more than {:.1e} of the time{starts}.",
            gap.max(0.0)
        ),
        (Status::Stationary, _) => format!(
            "Stationary{} to a relative gap of {gap:.1e}, not proved global (the problem is not concave){starts}.",
            if bound { " within what is available" } else { "" }
        ),
        (Status::Stalled, _) => {
            format!("The search stalled at a relative gap of {gap:.1e}: not optimal{starts}.")
        }
    }
}

/// About the priors' `shares` of the estimates.
pub(super) fn prior(shares: &BTreeMap<String, f64>) -> String {
    let mostly = shares.iter().filter(|(_, share)| **share > 0.5);
    let names: Vec<String> = mostly.map(|(name, _)| format!("`{name}`")).collect();
    match names.is_empty() {
        true => "The trial contributes more than the prior to every parameter.".to_owned(),
        false => format!("More than half the prior's after the trial: {}.", names.join(", ")),
    }
}

/// About few maneuvers.
pub(super) fn restricted(found: &Restricted) -> String {
    let used = found.design.shares.iter().filter(|w| **w > 0.0).count();
    let searched = match found.method {
        Method::Exhaustive => format!("Best of all choices of maneuvers ({} tried)", found.tried),
        Method::Exchange => format!(
            "No exchange of one maneuver for another saves 0.1 % of the time ({} choices tried)",
            found.tried
        ),
    };
    let against = match found.design.status {
        Status::Optimal => "at most, proved: the problem without it is concave",
        Status::Stationary | Status::Stalled => {
            "against the best shares found without it, which are not proved global"
        }
    };
    format!(
        "{searched}: {used} maneuvers; the restriction costs {:.2} % of the time {against}.",
        100.0 * found.loss
    )
}

/// About whole segments of `design`.
pub(super) fn counts(design: &Design, whole: &Whole) -> String {
    let Some(best) = &whole.found else {
        return "So few segments excite not every parameter, whichever maneuvers they are.".into();
    };
    let searched = match best.method {
        Method::Exhaustive => format!("Best of all counts ({} tried)", best.tried),
        Method::Exchange => {
            format!("No exchange of one segment for another is better ({} counts tried)", best.tried)
        }
    };
    let against = match design.status {
        Status::Optimal => "at most, proved: the problem is concave",
        Status::Stationary | Status::Stalled => "against the best shares found, which are not proved global",
    };
    format!(
        "{searched}; whole segments cost {:.2} % of the time {against}; apportioned shares would be worth {:.2} % of these \
         counts.",
        100.0 * whole.loss,
        100.0 * whole.apportioned
    )
}

/// The parameter error that a design promises, and in words.
pub(super) fn promise(Promise { parameter_error, range }: Promise) -> DesignPromise {
    let statement = format!("Promised parameter error: {parameter_error:.2} {}.", expected(range));
    DesignPromise { parameter_error, range, statement }
}

/// `(1.3 to 3.7, as the nominal model may be off by some 40 %)`.
fn expected([low, high]: [f64; 2]) -> String {
    format!("({low:.2} to {high:.2}, as the nominal model may be off by some 40 %)")
}

/// About maneuvers by inputs that many ships miss; `None` where there are none.
pub(super) fn unreached(motions: &[UnreachedMotion], sampled: &SampledShips) -> Option<String> {
    let worst = motions.iter().max_by(|a, b| a.missed.share.total_cmp(&b.missed.share))?;
    let parameters = match sampled.from {
        SampledFrom::Nominal => "nominal parameters that are off by some 40 %",
        SampledFrom::Covariance => "parameters off by what the model's covariance leaves open",
    };
    let [low, high] = worst.missed.interval.unwrap_or([0.0, 1.0]).map(|end| 100.0 * end);
    let others = match motions.len() - 1 {
        0 => String::new(),
        1 => "; one more maneuver is missed by a quarter or more".to_owned(),
        others => format!("; {others} more maneuvers are missed by a quarter or more"),
    };
    Some(format!(
        "Inputs of the nominal model do not make the motions that they are for: with {parameters}, {:.0} % ({low:.0} to \
         {high:.0}) of {} ships miss `{}` ({}){others}. Hold such motions with `executed = \"feedback\"`.",
        100.0 * worst.missed.share,
        sampled.ships,
        worst.maneuver,
        worst.what,
    ))
}

/// About the time for an accuracy, with the range to expect it in.
pub(super) fn accuracy(accuracy: &Accuracy, range: Option<[f64; 2]>) -> String {
    let needed = |what: &str, seconds: Option<f64>| {
        seconds.map_or(String::new(), |seconds| format!("; {what} need {seconds:.1} s"))
    };
    let too_short = match accuracy.duration_s < accuracy.holds_from_s {
        true => ". A trial as short as this errs more than predicted: let `monte-carlo` say how much",
        false => "",
    };
    format!(
        "{:.1} s reach a {} of {}{}{}{}{}. This adds up what maneuvers tell at their whole lengths, and holds from {:.1} s on: \
         there maneuvers that take four fifths of the time are whole{too_short}.",
        accuracy.duration_s,
        accuracy.wanted.of,
        accuracy.wanted.accuracy,
        range.map_or(String::new(), |range| format!(" {}", expected(range))),
        needed("the shares of the paper's criterion", accuracy.paper_s),
        needed("equal shares", accuracy.equal_s),
        needed(
            &format!("random designs of {} segments (median)", accuracy.random_segments),
            accuracy.random_s
        ),
        accuracy.holds_from_s,
    )
}

/// About a sequence of maneuvers.
pub(super) fn sequence(arranged: &Arranged) -> String {
    let limits = match &arranged.limits {
        Kept::Unlimited => String::new(),
        Kept::Within => "; it keeps the limits of the generated maneuvers".into(),
        Kept::Beyond(e) => {
            format!("; between maneuvers it reaches {:.3} where {} allows {}", e.found, e.limit, e.allowed)
        }
    };
    let taken = match arranged.promised.first().map(|promised| promised.trial) {
        None | Some(TrialKind::Arranged) => String::new(),
        Some(other) => format!("{}, which promises less error than what was found. ", capital(named(other))),
    };
    let also: Vec<String> = arranged.promised.iter().skip(1).filter_map(promised).collect();
    let also = if also.is_empty() { String::new() } else { format!(" Others: {}.", also.join("; ")) };
    format!(
        "{taken}The best of {} sequences that a local search judged with the state carried over: worth {:.1} % more time than \
         the same shares in the dictionary's order; not proved best{limits}.{}{also}",
        arranged.tried,
        100.0 * arranged.gain,
        arranged.foretold.map_or(String::new(), |foretold| format!(" Foretold: {}.", in_words(&foretold)))
    )
}

fn named(trial: TrialKind) -> &'static str {
    match trial {
        TrialKind::Arranged => "what the search found",
        TrialKind::Shares => "the shares in the dictionary's order",
        TrialKind::Random => "the best of 100 random trials",
        TrialKind::Practice => "today's practice",
    }
}

fn capital(text: &str) -> String {
    text[..1].to_uppercase() + &text[1..]
}

/// What another trial promises.
fn promised(one: &Promised) -> Option<String> {
    Some(format!("{}, {}", named(one.trial), in_words(&one.errors?)))
}

fn in_words(foretold: &Foretold) -> String {
    let simulation = foretold.simulation_error;
    let simulation = simulation.map_or(String::new(), |e| format!(", a median simulation error of {e:.3}"));
    format!("a median parameter error of {:.3}{simulation}", foretold.parameter_error)
}

/// About refined inputs.
pub(super) fn refinement(found: &Refinement) -> String {
    let slowed = found.start.slowed.join(", ");
    let slowed = match slowed.is_empty() {
        true => String::new(),
        false => format!(" The start is the design's experiment with {slowed} as fast as their rates allow."),
    };
    if found.unchanged() {
        return format!("Nothing better was found within the limits: the inputs are the start's.{slowed}");
    }
    let refined = &found.refined;
    let ended = if refined.settled { "settled" } else { "stopped at its limit of iterations" };
    format!(
        "Predicted parameter error {:.3} instead of {:.3}, worth {:.0} % more time; a local search that {ended} after {} \
         iterations, not proved best; the simulation with {} parameters and without disturbances keeps every limit.{slowed}",
        refined.after.parameter_error(),
        refined.before.parameter_error(),
        100.0 * (found.efficiency() - 1.0),
        refined.iterations,
        match found.start.source {
            Source::Value => "true",
            Source::Nominal => "nominal",
        }
    )
}
