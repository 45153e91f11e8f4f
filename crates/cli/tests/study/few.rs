//! Studies of too few runs for an interval: it is absent, with the reason.

use crate::support::*;

#[test]
fn three_runs_have_no_interval_of_a_median_and_say_so() {
    let folder = with(&["design.json"]);
    let line = "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --design design.json \
                --estimator ls,iv --realizations 3 --out validation.json";
    let said = run(&folder, line).succeeds().stdout;
    assert!(said.contains("too few pairs for a 95 % interval: 3, at least 6"), "{said}");
    let document = String::from_utf8(bytes(&folder, "validation.json")).unwrap();
    assert!(document.contains("too few pairs") && !document.contains("NaN"), "{document}");
    assert!(!said.contains("NaN"), "{said}");
}
