use vessel::{DegreeOfFreedom, Run, Vessel};

use crate::MeanRemoval;
use crate::pooled::{COLLINEAR, Part, Regression, collinear, diagnose, first_named};

/// Name of the design of runs whose truth nobody knows.
const MEASURED: &str = "measured";

/// A direction in which instrumental variables would answer one measured run with noise.
#[derive(Clone, Debug, PartialEq)]
pub struct CollinearRun {
    /// 0 surge, 1 sway, 2 yaw: the first that has one.
    pub degree: usize,
    /// The parameter it is about, within the degree of freedom.
    pub parameter: usize,
    /// All degrees of freedom that have one, in words.
    pub words: String,
}

/// Looks for collinear instruments and regressors in a measured run: a condition index above [`COLLINEAR`], as in a pooled
/// estimate. Simulated runs are answered whatever it is: how far off those estimates are is what their study shows. `None`
/// also where the nominal simulation diverges.
pub(super) fn collinear_run(vessel: &Vessel, run: &Run, removal: MeanRemoval) -> Option<CollinearRun> {
    if run.design != MEASURED {
        return None;
    }
    let label = &run.segments.first()?.maneuver;
    let mut parts = [Part::new(label, "", run.view())];
    Part::instrument(&mut parts, &vessel.model, &vessel.nominal).ok()?;
    let sums = Regression::of(&vessel.model, &parts[0]).sums();
    let mut found: Option<CollinearRun> = None;
    for d in DegreeOfFreedom::ALL {
        let degree = &vessel.model.degrees[d as usize];
        let diagnosis = diagnose(&[&sums], removal, d as usize);
        if diagnosis.index <= COLLINEAR {
            continue;
        }
        let own = collinear(d, degree, &diagnosis, &[]);
        match &mut found {
            Some(found) => found.words = format!("{}; {own}", found.words),
            None => {
                let parameter = first_named(degree, &diagnosis);
                found = Some(CollinearRun { degree: d as usize, parameter, words: own });
            }
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use vessel::Segment;

    /// A zig-zag of the tanker, `thrust(k)` its thrust.
    fn zig_zag(vessel: &Vessel, design: &str, thrust: impl Fn(usize) -> f64) -> Run {
        let rudder = |k: usize| if (k / 25).is_multiple_of(2) { 0.35 } else { -0.35 };
        let exogenous: Vec<f64> = (0..400).flat_map(|k| [thrust(k), rudder(k)]).collect();
        let initial = [1.0, 0.0, 0.0];
        Run {
            design: design.to_owned(),
            run: 0,
            segments: vec![Segment { maneuver: "zig-zag".to_owned(), start: 0 }],
            measured: vessel::simulate_one(&vessel.model, &vessel.nominal, initial, &exogenous),
            exogenous,
            initial,
        }
    }

    #[test]
    fn a_measured_run_at_steady_thrust_is_not_answered_and_a_simulated_one_is() {
        let file = include_str!("../../../../pipelines/kvlcc2/vessel.toml");
        let vessel = Vessel::from_file(toml::from_str(file).unwrap()).unwrap();
        let judged = |design: &str, thrust: &dyn Fn(usize) -> f64| {
            collinear_run(&vessel, &zig_zag(&vessel, design, thrust), MeanRemoval::Complete)
        };
        let steady = |k: usize| 45.0 + (k as f64 / 9.0).sin();
        let found = judged("measured", &steady).unwrap();
        assert_eq!(
            (found.degree, vessel.model.degrees[0].parameters[found.parameter].as_str()),
            (0, "X_thrust")
        );
        assert!(found.words.starts_with("surge: `thrust` (hardly varies, by 1.6 %)"), "{}", found.words);
        assert!(found.words.contains("cannot be told from the intercept"), "{}", found.words);
        assert_eq!(judged("random", &steady), None);
        let found = judged("measured", &|k| if (k / 60).is_multiple_of(3) { 5.0 } else { 60.0 });
        assert!(found.is_none_or(|found| !found.words.contains("`thrust` (hardly")));
    }
}
