use maud::{Markup, html};

use super::study::Study;

/// What the words mean.
pub(super) fn notation() -> Markup {
    html! {
        section #notation {
            h2 { "Notation" }
            dl.names {
                (entry("Share", html! { var { "w" sub { "q" } } " = " var { "N" sub { "q" } } "/" var { "N" } ": part of the experiment's samples that maneuver " var { "q" } " gets." }))
                (entry("Sensitivity", html! { var { "g" sub { "q" } } " = Σ" sub { "d" } " tr(" var { "M" sub { "d" } } "(" var { "w" } ")⁻¹ " var { "M" sub { "d,q" } } "), summed over the degrees of freedom. At the optimum no maneuver exceeds " var { "p" } ", the total dimension." }))
                (entry("Gap", html! { "max" sub { "q" } " " var { "g" sub { "q" } } " − " var { "p" } ", after Kiefer and Wolfowitz; relative gap: divided by " var { "p" } "." }))
                (entry("Efficiency", html! { "|det Γ(" var { "w" } ")/det Γ(" var { "w" } "*)|" sup { "1/n" } " with n parameters: the fraction of the experiment time that the optimal shares would need for the same information." }))
                (entry("Parameter error", html! { "2-norm over the parameters of (estimate − truth)/truth, one value per run." }))
                (entry("Simulation error", html! { "2-norm of the root mean square errors in surge [m/s], sway [m/s] and yaw rate [rad/s] of the freely simulated model against the true one." }))
                (entry("Run, realization", html! { "One experiment, simulated with its own disturbances and estimated on its own." }))
                (entry("u, v, r", html! { "Surge and sway speed [m/s] and yaw rate [rad/s]; axes x forward, y starboard, z down." }))
            }
        }
    }
}

fn entry(term: &str, meaning: Markup) -> Markup {
    html! { div { dt { (term) } dd { (meaning) } } }
}

/// Where the numbers come from.
pub(super) fn files(study: &Study) -> Markup {
    html! {
        section #files {
            h2 { "Files" }
            @if study.files.is_empty() {
                p.missing { "No file was read." }
            } @else {
                div.scroll { table.compact {
                    thead { tr { th scope="col" { "File" } th scope="col" { "What it is" } th scope="col" { "Digest" } } }
                    tbody { @for (name, what, digest) in &study.files {
                        tr { th scope="row" { (name) } td.wrap { (what) } td.digest { (digest) } }
                    } }
                } }
            }
        }
    }
}
