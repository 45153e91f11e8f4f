use ship::engine::Run;
use ship::model::{DegreeOfFreedom, Vessel};

use crate::MeanRemoval;
use crate::pooled::{COLLINEAR, PartView, Regression, collinear, diagnose, first_named};

/// Name of the design of measured runs, whose true parameters are unknown.
const MEASURED: &str = "measured";

/// A direction in which the instrumental-variable estimate of a measured run would be noise.
#[derive(Clone, Debug, PartialEq)]
pub struct CollinearRun {
    /// 0 surge, 1 sway, 2 yaw: the first that has one.
    pub degree: usize,
    /// The dominant parameter, within the degree of freedom.
    pub parameter: usize,
    /// All degrees of freedom that have one, in words.
    pub words: String,
}

/// Looks for collinear instruments and regressors in a measured run: a condition index above [`COLLINEAR`], as in a
/// pooled estimate. Simulated runs are always estimated: their study shows the errors of those estimates. `None` also
/// if the nominal simulation diverges.
pub fn collinear_run(vessel: &Vessel, run: &Run, removal: MeanRemoval) -> Option<CollinearRun> {
    if run.design != MEASURED {
        return None;
    }
    let label = &run.segments.first()?.maneuver;
    let part = PartView { label, source: "", run: run.view().part(0..run.samples()) };
    let states = part.simulated(&vessel.model, &vessel.nominal).ok()?;
    let sums = Regression::with(&vessel.model, &part, &states).sums();
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
