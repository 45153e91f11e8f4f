use maud::{Markup, html};

use super::parts::{Section, Table, entry};
use super::study::Study;

/// The notation.
pub(super) fn notation(study: &Study) -> Section {
    let body = if study.measured.is_some() { of_logs() } else { of_trials() };
    let states = entry(
        "u, v, r",
        "Surge and sway speed [m/s] and yaw rate [rad/s]; axes x forward, y starboard, z down.",
    );
    Section::new("notation", "Notation", "Notation", html! { dl.names { (body) (states) } })
}

fn of_trials() -> Markup {
    html! {
        (entry("Share", html! { var { "w" sub { "q" } } " = " var { "N" sub { "q" } } "/" var { "N" } ": part of the experiment's samples that maneuver " var { "q" } " gets." }))
        (entry("Sensitivity", html! { var { "g" sub { "q" } } " = Σ" sub { "d" } " tr(" var { "M" sub { "d" } } "(" var { "w" } ")⁻¹ " var { "M" sub { "d,q" } } "), summed over the degrees of freedom. At the optimum no maneuver exceeds " var { "p" } ", the total dimension." }))
        (entry("Gap", html! { "max" sub { "q" } " " var { "g" sub { "q" } } " − " var { "p" } ", after Kiefer and Wolfowitz; relative gap: divided by " var { "p" } "." }))
        (entry("Efficiency", html! { "|det Γ(" var { "w" } ")/det Γ(" var { "w" } "*)|" sup { "1/n" } " with n parameters: the fraction of the experiment time that the optimal shares would need for the same information." }))
        (entry("Parameter error", "2-norm over the parameters of (estimate − truth)/truth, one value per run."))
        (entry("Simulation error", "2-norm of the root mean square errors in surge [m/s], sway [m/s] and yaw rate [rad/s] of the freely simulated model against the true one."))
        (entry("Run, realization", "One experiment, simulated with its own disturbances and estimated on its own."))
    }
}

fn of_logs() -> Markup {
    html! {
        (entry("Fit", "100 (1 − RMSE/std) in percent, of a free simulation that starts at a measured state: 100 is perfect, 0 as good as the mean of the data."))
        (entry("Error norm", "2-norm over surge, sway and yaw rate of RMSE/std; √3 is as bad as the mean of the data."))
        (entry("Recording, sub-experiment", "What was logged in one go, and what it was cut into. Recordings are left out whole."))
        (entry("Condition index", "Square root of the condition number of the normal matrix with the intercept, columns scaled, means left in; from 30 on collinear (Belsley, Kuh and Welsch)."))
        (entry("Standard error", "Sandwich covariance with autocorrelation (Newey and West); of output-error by how much the estimate changes where a sub-experiment is left out (jackknife)."))
        (entry("Partial R²", "How much of a term its instruments tell beyond what they tell of the others (Shea): 1 least squares, near 0 lost."))
        (entry("Whiteness", "Ljung and Box's test: probability of a larger statistic if the residuals were white."))
    }
}

/// The sources of the numbers.
pub(super) fn files(study: &Study) -> Section {
    let body = html! {
        @if study.files.is_empty() {
            p.missing { "No file was read." }
        } @else {
            (Table::of(&study.files)
                .compact()
                .name("File", |(name, ..)| name)
                .with(html! { th scope="col" { "What it is" } }, |(_, what, _)| html! { td.wrap { (what) } })
                .with(html! { th scope="col" { "Digest" } }, |(.., digest)| html! { td.digest { (digest) } }))
        }
    };
    Section::new("files", "Files", "Files", body)
}
