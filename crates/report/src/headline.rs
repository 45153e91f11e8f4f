use maud::{Markup, html};
use study::documents::{
    Arm, Check, DesignDocument, DesignScores, PlanDocument, RoundGain, ScoredEstimates, TrialsInRounds,
    Voyage, WorstVessels,
};

use crate::dictionary::used as is_used;
use crate::number::{exact, parameter_share, percent, percent_within, simulation_share, three};
use crate::parts::card;
use crate::study::Study;
use crate::trajectory::words::{clearance, cost, gap, minutes};

/// Name of the design that is today's practice.
const PRACTICE: &str = "practice";

/// What that design is.
const PRACTISED: &str = "Practice is today's practice: the maneuvers of the dictionary, one after another, repeated or shortened \
     alike to the same length (all that are written by hand, where none is of a standard).";

/// The kind of the page.
pub(super) fn kind(study: &Study) -> &'static str {
    match (&study.data, &study.measured) {
        (Some(_), _) => "Report on simulated logs",
        (None, Some(_)) => "Report on measured logs",
        (None, None) => "Experiment design report",
    }
}

/// Title, the answer in two sentences, and the key figures.
pub(super) fn headline(study: &Study) -> Markup {
    html! {
        header {
            p.kicker { (kind(study)) }
            h1 { (study.name) }
            @if let Some(vessel) = &study.vessel {
                p.about {
                    (vessel.name) ", " (vessel.model.parameters()) " parameters, sampled at "
                    (exact(vessel.sample_rate_hz)) "\u{a0}Hz"
                }
            }
            @if let Some(label) = &study.data {
                p.label { "Data: " b { (label) } ". No real ship was measured; the logs that everything here is made of were simulated." }
            }
            @if !study.mixed.is_empty() {
                p.label {
                    "Mixed: this page shows files of different studies. They were made with more than one "
                    (study.mixed.join(", ")) "."
                }
            }
            p.answer { (answer(study)) }
            @if study.scored().iter().any(|d| d.design == PRACTICE) { p.note { (PRACTISED) } }
            (cards(study))
        }
    }
}

fn answer(study: &Study) -> String {
    if let Some(measured) = &study.measured {
        return measured.answer(study.selection.as_ref());
    }
    if let (Some(rounds), None) = (&study.sequential, &study.design) {
        return in_rounds(rounds);
    }
    if let Some(plan) = plan(study) {
        return planned(plan);
    }
    match (&study.validation, &study.design) {
        (Some(validation), _) if !validation.designs.is_empty() => compared(study, validation),
        (_, Some(design)) => format!("{} {}", mix(design), waste_of_equal_shares(design)),
        _ => "Nothing has been designed or validated yet. The sections below say which files are missing."
            .to_owned(),
    }
}

/// The gain of designing in rounds.
fn in_rounds(found: &TrialsInRounds) -> String {
    let arm = |arm: Arm| found.stopping.iter().find(|s| s.arm == arm);
    let mut said = String::new();
    if let (Some(rounds), Some(once)) = (arm(Arm::Sequential), arm(Arm::OneShot)) {
        said += &format!(
            "Trials in rounds, stopped by their own estimates, take {:.0} s on average and {} of them end within the wanted \
             error of {}; trials designed once, sized beforehand by the crude model, {:.0} s and {}.",
            rounds.mean_time_s,
            percent(rounds.within),
            three(found.accuracy),
            once.mean_time_s,
            percent(once.within)
        );
    }
    if let Some(RoundGain { time_s, ratio: Some(ratio), low: Some(low), high: Some(high), .. }) =
        found.gains.last()
    {
        said += &format!(
            " After {time_s:.0} s the error in rounds is {ratio:.2} of that of designing once ({low:.2} to {high:.2})."
        );
    }
    said
}

/// The study's planned trajectory.
fn plan(study: &Study) -> Option<&PlanDocument> {
    study.trajectory.as_ref()?.main.as_ref().map(|main| &main.plan)
}

/// Both sentences about a planned trial.
fn planned(plan: &PlanDocument) -> String {
    let cost = self::cost(plan.cost, plan.cost_unit);
    let proof = gap(plan).map_or(", and no plan costs less".to_owned(), |gap| format!(", {gap}"));
    let uses: u64 = plan.counts.values().sum();
    let Some(voyage) = &plan.voyage else {
        return format!("The plan uses {uses} informative maneuvers and costs {cost}{proof}.");
    };
    let check = &voyage.check;
    let hull = if check.clear { format!("stays {}", clear(check)) } else { clear(check) };
    let worst = |WorstVessels { aground, searched, .. }: &WorstVessels| match aground {
        0 => format!(", nor does any of {searched} vessels that a search for the worst tried"),
        _ => format!(", and {aground} of {searched} vessels that a search for the worst tried"),
    };
    format!(
        "The planned trial of {} holds {uses} informative maneuvers and costs {cost}{proof}. In simulation the hull {hull}; \
         in unknown current of up to {}\u{a0}m/s, with parameters off by up to {}, {} of {} runs touch an obstacle{}.{}",
        minutes(voyage.duration_s),
        exact(check.unknown_current_m_s),
        errors(check),
        check.aground,
        check.runs,
        check.worst.as_ref().map_or(String::new(), worst),
        if check.safe { "" } else { " The plan is unsafe: it fails its own check." },
    )
}

/// The bound on the errors of the parameters.
fn errors(check: &Check) -> String {
    match check.standard_errors {
        Some(errors) => format!("{} {}", exact(errors), check.errors_of()),
        None => percent(check.parameter_error),
    }
}

/// The clearance of the simulated plan from obstacles.
fn clear(check: &Check) -> String {
    clearance(check).map_or("touches an obstacle".to_owned(), |distance| format!("{distance} clear"))
}

/// Both sentences about the designs that were validated.
fn compared(study: &Study, validation: &ScoredEstimates) -> String {
    let scored = study.scored();
    let (bounds, first, others) = (validation.bounds, scored[0], &scored[1..]);
    let length = study.experiment_s.map_or(String::new(), |s| format!(" of {}\u{a0}s", three(s)));
    let seed = validation.seed.map_or(String::new(), |seed| format!(" (seed {seed})"));
    let same_length = if study.experiment_s.is_some() { " of the same length" } else { "" };
    let others_errors = |d: &&DesignScores| {
        format!("; {} experiments{same_length} do so in {}", d.design, parameter_share(d))
    };
    let counterparts: String = others.iter().map(others_errors).collect();
    let parameters = format!(
        "The {} experiment{length} keeps the parameter error below {} in {} of {} realizations{seed}{}.",
        first.design,
        exact(bounds.parameter_error),
        parameter_share(first),
        first.runs,
        counterparts,
    );
    let simulation = format!(
        "The error of the free simulation stays below {} in {}{}.",
        exact(bounds.simulation_error),
        simulation_share(first),
        against(others),
    );
    format!("{parameters} {simulation}")
}

/// Their errors in free simulation.
fn against(others: &[&DesignScores]) -> String {
    let sentence = |d: &&DesignScores| format!("{} ({})", simulation_share(d), d.design);
    match others.iter().map(sentence).collect::<Vec<_>>().as_slice() {
        [] => String::new(),
        each => format!(" of the realizations, against {}", each.join(" and ")),
    }
}

/// The first sentence about a design that has not been validated.
fn mix(design: &DesignDocument) -> String {
    let mut used: Vec<(&String, f64)> = design.shares.iter().map(|(name, share)| (name, *share)).collect();
    used.retain(|(name, _)| is_used(design, name));
    used.sort_by(|a, b| b.1.total_cmp(&a.1));
    let listed = used.iter().take(3).map(|(name, share)| format!("{name} {}", percent(*share)));
    let (listed, all) = (listed.collect::<Vec<_>>().join(", "), design.order.len());
    format!("The optimal experiment uses {} of {all} maneuvers, most of all {listed}.", used.len())
}

/// The time that equal shares waste.
fn waste_of_equal_shares(design: &DesignDocument) -> String {
    let Some(efficiency) = design.efficiency.as_ref().map(|e| e.equal_shares) else { return String::new() };
    if efficiency > 0.0 && efficiency.is_finite() {
        let part = percent(efficiency);
        return format!("It needs {part} of the time that equal shares would need for the same information.");
    }
    "Equal shares would leave some direction without excitation.".to_owned()
}

fn cards(study: &Study) -> Markup {
    let scored = study.scored();
    html! {
        div.cards {
            @if let Some(plan) = plan(study) { (plan_card(plan)) }
            @if let Some(measured) = &study.measured { (measured.cards(study.selection.as_ref())) }
            @if let (Some(validation), false) = (&study.validation, scored.is_empty()) {
                (share_card("Parameter error below", validation.bounds.parameter_error, &scored, |d| (d.parameter_error_share, d.parameter_error_share_interval)))
                (share_card("Simulation error below", validation.bounds.simulation_error, &scored, |d| (d.simulation_error_share, d.simulation_error_share_interval)))
            }
            @if let Some(design) = &study.design { (design_cards(design)) }
        }
    }
}

fn share_card(
    what: &str,
    bound: f64,
    scored: &[&DesignScores],
    share: impl Fn(&DesignScores) -> (f64, Option<[f64; 2]>),
) -> Markup {
    let (first, interval) = share(scored[0]);
    let own = interval.map(|[low, high]| format!("{} to {}", percent(low), percent(high)));
    let other = |design: &&DesignScores| {
        let (share, interval) = share(design);
        format!("{} {}", percent_within(share, interval), design.design)
    };
    let others: Vec<String> = own.into_iter().chain(scored[1..].iter().map(other)).collect();
    card(&format!("{what} {}", exact(bound)), percent(first), &scored[0].design, &others)
}

fn design_cards(design: &DesignDocument) -> Markup {
    let used = design.order.iter().filter(|name| is_used(design, name)).count();
    html! {
        @if let Some(efficiency) = &design.efficiency {
            div.card {
                p.what { "Efficiency of equal shares" }
                p.figure-line { span.big { (percent(efficiency.equal_shares)) } }
                p.other { (used) " of " (design.order.len()) " maneuvers are worth their time" }
            }
        }
        @if let Some(gap) = design.relative_gap {
            @let proof = if design.status == study::documents::DesignStatus::Optimal { "" } else { ", not proved global" };
            (card("Optimality", three(gap), "relative gap", &[format!("{}{proof}", design.status)]))
        }
    }
}

fn plan_card(plan: &PlanDocument) -> Markup {
    let cost = self::cost(plan.cost, plan.cost_unit);
    let (figure, unit) = cost.split_once([' ', '\u{a0}']).unwrap_or((&cost, "cost"));
    let sailed = |voyage: &Voyage| format!("{} at sea, {}", minutes(voyage.duration_s), clear(&voyage.check));
    let mut others: Vec<String> = plan.voyage.iter().map(sailed).collect();
    let failed = plan.voyage.as_ref().map(|voyage| &voyage.check).filter(|check| !check.safe);
    others.extend(failed.map(|check| format!("unsafe: {}", check.faults.join(", "))));
    let known = gap(plan).unwrap_or(plan.status.name().to_owned());
    card("Trajectory", figure, format!("{unit}, {known}"), &others)
}
