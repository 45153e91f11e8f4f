//! The library's plan equals the program's.

use seatrial::{ChartedTrial, Generator, Search, Vessel, undisturbed};
use study::documents::PlanDocument;

use crate::planned::{small, small_planned};

#[test]
fn law_a_plan_in_memory_is_that_of_the_program() {
    let folder = small();
    let text = |name: &str| std::fs::read_to_string(folder.path().join(name)).unwrap();
    let vessel = Vessel::from_file(toml::from_str(&text("vessel.toml")).unwrap()).unwrap();
    let generator =
        Generator::without_tables(&vessel, &toml::from_str(&text("dictionary.toml")).unwrap()).unwrap();
    let dictionary = undisturbed(&vessel, &generator, vessel.best_known(), "dictionary").unwrap();
    let trial = ChartedTrial::read(&folder.path().join("plan.toml"), vessel, dictionary, None).unwrap();
    let planned = trial.plan(&Search::unlimited(), false).unwrap();
    let by_program: PlanDocument = serde_json::from_value(small_planned().plan.clone()).unwrap();
    assert_eq!(serde_json::to_value(&planned.document).unwrap(), serde_json::to_value(by_program).unwrap());
    let names: Vec<String> =
        planned.routes().unwrap().files("route").unwrap().into_iter().map(|(name, _)| name).collect();
    let usual = ["track.geojson", "route.rtz", "route.gpx", "route.plan", "aborts.gpx", "aborts.geojson"];
    assert_eq!(names[..6], usual);
    assert!(names[6..].iter().all(|name| name.starts_with("abort-") && name.ends_with(".rtz")));
    // Every route has the name of its file.
    let others = planned.routes().unwrap().files("other-route").unwrap();
    for (name, bytes) in others.iter().filter(|(name, _)| name.starts_with("abort-")) {
        let called = format!("routeName=\"other-{}\"", name.trim_end_matches(".rtz"));
        assert!(String::from_utf8_lossy(bytes).contains(&called), "{name}");
    }
}
