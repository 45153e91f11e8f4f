//! Instruments of runs that are steered by feedback.

use std::collections::BTreeMap;

use estimation::predictor::InitialState;
use estimation::runs::{AdditionalUnknowns, RunError, RunEstimators};
use estimation::{EstimateStatus, Estimator};
use maneuver::{DictionaryFile, Generator};
use regression::runs::RunInstruments;
use regression::{InstrumentKind, MeanRemoval, Outcome};
use ship::engine::{Current, Disturbances, Measurement, Run};
use ship::model::Vessel;
use trial::campaign::{Campaign, Designed, Sea, Settings};

/// Speeds of the approaches \[m/s\].
const SPEEDS: [f64; 5] = [0.3, 0.5, 0.7, 0.9, 1.1];

const STD: f64 = 0.158;

/// Zig-zags at five speeds, whose helm goes over where a compass shows that the heading is reached.
fn triggered(sensors: &str) -> String {
    let one = |u: &f64| {
        format!(
            "[[maneuver]]\nname = \"at-{u}\"\nkind = \"zig-zag-test\"\nspeed_m_s = {u}\n\
             helm = {{ tau3 = {} }}\nheading_rad = 0.35\nsensors = \"{sensors}\"\n",
            500.0 + 300.0 * u
        )
    };
    SPEEDS.iter().map(one).collect()
}

/// Motions in all of surge, sway and yaw at five speeds.
fn tracked(executed: &str) -> String {
    let one = |u: &f64| {
        format!(
            "[[maneuver]]\nname = \"at-{u}\"\nkind = \"combined\"\nexact = true\n\
             speed_m_s = {{ mean = {u}, shape = \"sine\", amplitude = 0.2, period_s = 12.5 }}\n\
             yaw_rate_rad_s = {{ shape = \"sine\", amplitude = 0.3, period_s = 8.3 }}\n\
             sway_m_s = {{ shape = \"sine\", amplitude = 0.15, period_s = 6.25 }}\n\
             {executed}\n"
        )
    };
    SPEEDS.iter().map(one).collect()
}

/// 400 runs of 125 s, with two seeds.
fn runs(vessel: &Vessel, maneuvers: &str) -> Vec<Run> {
    let text = format!("duration_s = 25.0\ninputs_from = \"nominal\"\n{maneuvers}");
    let dictionary: DictionaryFile = text.parse().unwrap();
    let generator = Generator::without_tables(vessel, &dictionary).unwrap();
    let names = generator.maneuvers().iter().map(|maneuver| maneuver.name.clone());
    let shares: BTreeMap<String, f64> = names.map(|name| (name, 1.0 / SPEEDS.len() as f64)).collect();
    let design = Designed { shares, order: None };
    let measurement = Measurement { std_u_m_s: STD, std_v_m_s: STD, std_r_rad_s: STD };
    let current = Current::White { std_m_s: STD };
    let of = |seed: u64| {
        let sea = Sea::new(vessel, Disturbances { current, measurement }, None).unwrap();
        let settings = Settings { duration_s: 125.0, realizations: 200, random_segments: None, seed };
        let campaign = Campaign::new(sea, &generator, &design, &settings).unwrap();
        campaign.simulate_all().unwrap().into_iter().map(|simulated| simulated.run)
    };
    of(1).chain(of(2)).collect()
}

/// Per parameter the share of runs whose 95 % interval has the truth \[%\], and the mean estimate over the truth.
fn covered(vessel: &Vessel, runs: &[Run]) -> Vec<(f64, f64)> {
    let truth = vessel.parameters(ship::model::Source::Value).unwrap();
    let instruments = RunInstruments::new(vessel, InstrumentKind::Nominal);
    let found = instruments.estimates(runs, MeanRemoval::Complete).unwrap();
    let mut all = vec![(0.0, 0.0); truth.len()];
    for (outcome, _) in found {
        let Outcome::Identified(own) = outcome else { panic!("{outcome:?}") };
        let each = own.parameters.iter().zip(&own.standard_errors).zip(&truth);
        for (((estimate, error), truth), (inside, mean)) in each.zip(&mut all) {
            *inside += f64::from((estimate - truth).abs() <= 1.96 * error) / runs.len() as f64 * 100.0;
            *mean += estimate / truth / runs.len() as f64;
        }
    }
    all
}

/// The mean and the least of these shares for nominal models whose parameters are off.
fn coverage(maneuvers: &str) -> [f64; 2] {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let inside: Vec<f64> = covered(&vessel, &runs(&vessel, maneuvers)).into_iter().map(|own| own.0).collect();
    [inside.iter().sum::<f64>() / inside.len() as f64, inside.into_iter().fold(100.0, f64::min)]
}

/// 95 % intervals have the truth as often as they say.
#[track_caller]
fn assert_intervals_cover(maneuvers: &str) {
    let [mean, least] = coverage(maneuvers);
    assert!((92.0..=98.0).contains(&mean) && least >= 85.0, "mean {mean}, least {least}");
}

#[test]
fn law_recorded_inputs_are_instruments_where_a_compass_triggers() {
    assert_intervals_cover(&triggered("own"));
}

#[test]
fn law_recorded_inputs_are_instruments_where_the_logged_sensors_trigger() {
    assert_intervals_cover(&triggered("logged"));
}

#[test]
fn law_the_nominal_loop_gives_instruments_of_motions_that_are_tracked_by_own_sensors() {
    assert_intervals_cover(&tracked("executed = \"feedback\""));
}

#[test]
fn law_the_nominal_loop_gives_instruments_of_motions_that_are_tracked_by_the_logged_sensors() {
    assert_intervals_cover(&tracked("executed = \"feedback\"\nfeedback = { sensors = \"logged\" }"));
}

#[test]
fn law_recorded_inputs_are_no_instruments_where_logged_sensors_are_tracked() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let mut runs = runs(&vessel, &tracked("executed = \"feedback\"\nfeedback = { sensors = \"logged\" }"));
    runs.iter_mut().for_each(|run| run.instrument_exogenous.clear());
    let covered = covered(&vessel, &runs);
    // Yaw's linear damping, which the controller's gain seems to add to.
    let names: Vec<&str> = vessel.model.parameter_names().collect();
    let damping = names.iter().position(|name| *name == "N_r").unwrap();
    let (inside, mean) = covered[damping];
    assert!(inside < 20.0 && mean > 1.3, "{names:?} {covered:?}");
}

/// The paper's ship, whose nominal model speeds up without bounds.
fn diverging() -> Vessel {
    let mut vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let names: Vec<&str> = vessel.model.parameter_names().collect();
    let drag = names.iter().position(|name| *name == "X_u").unwrap();
    vessel.nominal[drag] = 2.5;
    vessel
}

fn estimators(vessel: &Vessel) -> RunEstimators<'_> {
    RunEstimators {
        vessel,
        estimators: vec![Estimator::Iv],
        removal: MeanRemoval::Complete,
        initial: InitialState::Known,
        additional: AdditionalUnknowns::default(),
        levels: None,
    }
}

#[test]
fn law_instruments_by_output_error_serve_where_the_nominal_model_diverges() {
    let (vessel, truth) = (diverging(), Vessel::preset("ljungberg-model-ship").unwrap());
    let mut runs = runs(&truth, &triggered("own"));
    runs.truncate(160);
    let nominal = RunInstruments::new(&vessel, InstrumentKind::Nominal);
    assert!(nominal.estimates(&runs[..1], MeanRemoval::Complete).is_err());
    let truth = truth.parameters(ship::model::Source::Value).unwrap();
    let found = estimators(&vessel).estimates(&runs).unwrap();
    assert_eq!(found.len(), runs.len());
    let mut inside = vec![0.0; truth.len()];
    for own in found {
        assert_eq!(own.status, EstimateStatus::OwnInstruments);
        let (theta, errors) = own.estimate.unwrap();
        for (((theta, error), truth), inside) in theta.iter().zip(errors).zip(&truth).zip(&mut inside) {
            *inside += f64::from((theta - truth).abs() <= 1.96 * error) / runs.len() as f64 * 100.0;
        }
    }
    let mean = inside.iter().sum::<f64>() / inside.len() as f64;
    let least = inside.iter().copied().fold(100.0, f64::min);
    assert!((92.0..=98.0).contains(&mean) && least >= 85.0, "mean {mean}, least {least}: {inside:?}");
}

#[test]
fn a_run_without_a_model_of_its_own_is_refused_where_the_nominal_model_diverges() {
    let vessel = diverging();
    let mut runs = runs(&Vessel::preset("ljungberg-model-ship").unwrap(), &triggered("own"));
    runs.truncate(1);
    runs[0].exogenous.fill(0.0);
    runs[0].measured.chunks_exact_mut(3).for_each(|state| state.copy_from_slice(&[0.5, 0.0, 0.0]));
    let error = estimators(&vessel).estimates(&runs).unwrap_err();
    assert!(matches!(error, RunError::Diverged(_)), "{error:?}");
}
