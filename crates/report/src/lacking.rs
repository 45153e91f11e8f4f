//! What a model lacks, and detection limits.

use maud::{Markup, html};
use study::documents::{Absent, Criticism, FoundNoise, Verdict};

use super::number::{probability, three, unit};
use super::parts::{Table, coded};

/// Number of candidates that are always shown.
const SHOWN: usize = 5;

/// The candidates, the likeliest first; those without evidence are folded.
pub(super) fn lacking(found: &Criticism) -> Markup {
    let likely = found.absent.iter().take_while(|a| found.rejected && a.candidate).count();
    let (first, others) = found.absent.split_at(likely.max(SHOWN).min(found.absent.len()));
    html! {
        h3 { "What the model lacks" }
        (candidates(found, first))
        @if !others.is_empty() {
            details {
                summary { (others.len()) " more candidates, for which these recordings speak less" }
                (candidates(found, others))
            }
        }
        p.note {
            "Score tests of whitened errors of what the model does not have, the likeliest first; values with standard errors as they \
             would be if it were added. p: how often any of all candidates would seem so likely in a right model. Seen from: the \
             least that these recordings would nearly always have shown."
        }
        @if !found.hidden.is_empty() {
            p.note { "Not to be told from the model's own terms: " (coded(&found.hidden.join(", "))) "." }
        }
        (noise(found))
    }
}

fn candidates<'a>(found: &Criticism, absent: &'a [Absent]) -> Table<&'a Absent> {
    Table::of(absent)
        .compact()
        .mark("main", |a| found.rejected && a.candidate)
        .name("Not in the model", |a| match a.degree {
            Some(_) => html! { code { (a.name) } },
            None => html! { (a.name) },
        })
        .text("Degree", |a| a.degree.as_deref().unwrap_or("all"))
        .number("If added", added)
        .text("Unit", |a| unit(&a.unit))
        .number("p", |a| probability(a.p_value))
        .number("Seen from", |a| three(a.visible_from))
}

/// `−0.400 ± 0.030`; north and east of a current.
fn added(absent: &Absent) -> String {
    let each = absent.value.iter().zip(&absent.standard_error);
    each.map(|(value, error)| format!("{} ± {}", three(*value), three(*error))).collect::<Vec<_>>().join(", ")
}

/// The noise that the errors were whitened with: its kind, its levels, and by how much others are less likely.
fn noise(found: &Criticism) -> Markup {
    html! {
        p.note {
            "Noise " (if found.stated_noise { "stated" } else { "found" })
            @if let Some(own) = &found.noise { ", " (own.kind.words()) }
            ": u " (three(found.noise_u)) " m/s, v "
            (three(found.noise_v)) " m/s, r " (three(found.noise_r)) " rad/s, current " (three(found.current_std)) " m/s"
            @if let Some(time) = found.current_time_s { " changing within " (three(time)) " s" }
            @for own in found.noise.iter().flat_map(|own| &own.drifts) {
                ", " (own.of) " " (own.state) " " (three(own.std)) " " (own.unit) " over " (three(own.time_s)) " s"
            }
            "."
            @if let Some(own) = &found.noise {
                " Noise and parameters were found in " (own.turns) " turns"
                @if !own.at_rest { ", without coming to rest" }
                "."
                @if !own.others.is_empty() { " Less likely, in twice the log-likelihood: " (others(own)) "." }
            }
        }
        @if found.verdict == Verdict::None {
            p.note {
                "No verdict: these errors follow no noise known here. What is missing, and standard errors, do not hold."
            }
        }
    }
}

fn others(noise: &FoundNoise) -> String {
    let each = noise.others.iter().map(|own| format!("{} by {}", own.kind.words(), three(own.below)));
    each.collect::<Vec<_>>().join(", ")
}
