//! Maneuvers that react to the ship, without support elsewhere.

use std::collections::{BTreeMap, BTreeSet};

use maneuver::{DictionaryFile, Generator};
use plan::{Purpose, Side, mirror};
use refusal::Invalid;
use ship::engine::{
    Axes, Command, Current, Disturbances, Helm, Measurement, Program, Seen, Wind, simulate_one, track,
};
use ship::model::{Actuator, Source, Vessel};
use trial::Piece;
use trial::campaign::{Campaign, Designed, Maneuvers, Sea, Settings, SimulatedRun, Wanted};

use crate::legs::{grid, others, repertoire, study};

/// Heading at which the helm goes over \[rad\].
const TRIGGER: f64 = 0.35;

const SENSORS: Measurement = Measurement { std_u_m_s: 0.02, std_v_m_s: 0.02, std_r_rad_s: 0.02 };

/// A zig-zag as crews sail it: the helm goes over where the heading is reached.
#[derive(Clone, Debug)]
struct ZigZag {
    /// Inputs to starboard and to port.
    rows: [Vec<f64>; 2],
}

impl Program for ZigZag {
    fn begin(&self) -> Box<dyn Command> {
        Box::new(Helmsman { program: self.clone(), side: 0 })
    }
}

struct Helmsman {
    program: ZigZag,
    side: usize,
}

impl Command for Helmsman {
    fn command(&mut self, seen: &Seen, inputs: &mut [f64]) {
        let reached = if self.side == 0 { seen.pose.psi >= TRIGGER } else { seen.pose.psi <= -TRIGGER };
        self.side ^= usize::from(reached);
        inputs.copy_from_slice(&self.program.rows[self.side]);
    }
}

/// The side that the helm is on in each sample, by the true headings.
fn sides(states: &[f64], samples: std::ops::Range<usize>, rate_hz: f64) -> Vec<usize> {
    let headings: Vec<f64> = track(states, rate_hz)[samples].iter().map(|pose| pose.psi).collect();
    let mut side = 0;
    let of = |psi: &f64| {
        let psi = psi - headings[0];
        side ^= usize::from(if side == 0 { psi >= TRIGGER } else { psi <= -TRIGGER });
        side
    };
    headings.iter().map(of).collect()
}

/// A ship's zig-zag as inputs, and her way ahead.
fn dictionary(vessel: &Vessel) -> Generator {
    let text = "[[maneuver]]\nname = \"zig-zag\"\nkind = \"zig-zag\"\nspeed_m_s = 0.6\n\
                yaw_rate_amplitude_rad_s = 0.1\nperiod_s = 20.0\nduration_s = 60.0\n\
                [[maneuver]]\nname = \"ahead\"\nkind = \"steady-turn\"\nspeed_m_s = 0.6\n\
                yaw_rate_rad_s = 0.0\nduration_s = 30.0\n";
    let dictionary: DictionaryFile = text.parse().unwrap();
    Generator::without_tables(vessel, &dictionary).unwrap()
}

/// The rows of `inputs` with the largest and the smallest last input.
fn extremes(inputs: &[f64], width: usize) -> [Vec<f64>; 2] {
    let by_last = |a: &&[f64], b: &&[f64]| a[width - 1].total_cmp(&b[width - 1]);
    let rows = || inputs.chunks_exact(width);
    [rows().max_by(by_last), rows().min_by(by_last)].map(|row| row.unwrap().to_vec())
}

/// The vessel, a zig-zag that reacts in the place of the first maneuver, and its two rows.
fn reacting() -> (Vessel, Generator, [Vec<f64>; 2]) {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let generator = dictionary(&vessel);
    let rows = extremes(&generator.realize(0, 480).unwrap().inputs, 3);
    let helm = Helm::new(ZigZag { rows: rows.clone() });
    (vessel, generator.commanded(0, helm), rows)
}

/// A sea with all disturbances.
fn sea(vessel: &Vessel) -> Sea<'_> {
    let current = Current::GaussMarkov { std_m_s: 0.1, time_constant_s: 20.0, axes: Axes::Earth };
    let wind =
        Wind { std_surge_m_s2: 0.02, std_sway_m_s2: 0.02, std_yaw_rad_s2: 0.02, time_constant_s: Some(8.0) };
    Sea::new(vessel, Disturbances { current, measurement: SENSORS }, Some(wind)).unwrap()
}

fn rows_of(run: &SimulatedRun, samples: std::ops::Range<usize>) -> Vec<Vec<f64>> {
    run.run.exogenous.chunks_exact(3).map(<[f64]>::to_vec).skip(samples.start).take(samples.len()).collect()
}

#[test]
fn law_a_heading_trigger_runs_in_dictionaries() {
    let (vessel, generator, rows) = reacting();
    for source in [Source::Value, Source::Nominal] {
        let maneuvers = Maneuvers::new(&vessel, &generator, source, "dictionary").unwrap();
        let (runs, _) = maneuvers.simulate(0..2).unwrap();
        let run = &runs[0];
        assert_eq!(run.run.samples(), 480);
        let sides = sides(&run.states, 0..480, vessel.sample_rate_hz);
        let went_over = sides.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!(went_over >= 3, "{source:?}: the helm went over {went_over} times");
        let wanted: Vec<Vec<f64>> = sides.into_iter().map(|side| rows[side].clone()).collect();
        assert_eq!(rows_of(run, 0..480), wanted, "{source:?}");
    }
}

#[test]
fn law_a_heading_trigger_runs_in_campaigns() {
    let (vessel, generator, rows) = reacting();
    let settings = Settings { duration_s: 90.0, realizations: 11, random_segments: None, seed: 3 };
    let order = vec![("ahead".to_owned(), 240), ("zig-zag".to_owned(), 480)];
    let shares = order.iter().map(|(name, samples)| (name.clone(), *samples as f64 / 720.0)).collect();
    let design = Designed { shares, order: Some(order) };
    let campaign = Campaign::new(sea(&vessel), &generator, &design, &settings).unwrap();
    let runs = campaign.simulate_all().unwrap();
    assert_eq!(runs.len(), 11);
    for run in &runs {
        let sides = sides(&run.states, 240..720, vessel.sample_rate_hz);
        let wanted: Vec<Vec<f64>> = sides.into_iter().map(|side| rows[side].clone()).collect();
        assert_eq!(rows_of(run, 240..720), wanted, "run {}", run.run.run);
    }
    assert!(rows_of(&runs[0], 240..720) != rows_of(&runs[1], 240..720), "each changes sides in its own time");
    assert_eq!(campaign.simulate(0, 8..11, Wanted::Truth).unwrap(), runs[8..]);
    assert!(campaign.experiment_of_all(0).is_none(), "their experiments differ");
}

#[test]
fn a_stop_whose_share_is_one_long_piece_is_named() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let text = "[[maneuver]]\nname = \"stop\"\nkind = \"stop\"\nspeed_m_s = 0.6\ninputs = { tau1 = -30.0 }\n\
                duration_s = 20.0\n";
    let generator = Generator::without_tables(&vessel, &text.parse().unwrap()).unwrap();
    let said = |duration_s: f64, order: Option<Vec<(String, usize)>>| {
        let settings = Settings { duration_s, realizations: 1, random_segments: None, seed: 3 };
        let design = Designed { shares: BTreeMap::from([("stop".to_owned(), 1.0)]), order };
        Campaign::new(sea(&vessel), &generator, &design, &settings).unwrap().statements().to_vec()
    };
    let expected = "stop has its share in one piece of 60 s, though it takes 20 s at most: `seatrial design --arrange` cuts \
                    it into several";
    assert_eq!(said(60.0, None), [expected]);
    assert!(said(20.0, None).is_empty());
    assert!(said(60.0, Some(vec![("stop".to_owned(), 480)])).is_empty());
}

#[test]
fn law_lanes_and_single_runs_follow_the_same_actuators_to_the_bit() {
    let mut vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    vessel.actuators[2] =
        Actuator { lag_s: 0.4, rate_per_s: Some(900.0), dead_band: 40.0, hold_s: 0.5, ..vessel.actuators[2] };
    let text = "[[maneuver]]\nname = \"zig-zag\"\nkind = \"zig-zag-test\"\nspeed_m_s = 0.6\n\
                helm = { tau3 = 600.0 }\nheading_rad = 0.35\nduration_s = 60.0\n";
    let generator = Generator::without_tables(&vessel, &text.parse().unwrap()).unwrap();
    assert_eq!(generator.reacting().followed, [2]);
    let maneuvers = Maneuvers::new(&vessel, &generator, Source::Value, "dictionary").unwrap();
    let alone = maneuvers.simulate(0..1).unwrap().0.remove(0);
    let settings = Settings { duration_s: 60.0, realizations: 9, random_segments: None, seed: 3 };
    let design = Designed { shares: BTreeMap::from([("zig-zag".to_owned(), 1.0)]), order: None };
    let still = Disturbances { current: Current::None, measurement: SENSORS };
    let campaign =
        Campaign::new(Sea::new(&vessel, still, None).unwrap(), &generator, &design, &settings).unwrap();
    let all = campaign.simulate(0, 0..9, Wanted::Commands).unwrap();
    assert_eq!(all.len(), 9);
    for run in &all {
        assert_eq!(run.run.exogenous, alone.run.exogenous);
        assert_eq!(run.commands, alone.commands);
        assert_eq!(run.states, alone.states);
    }
    assert_ne!(alone.commands, vessel.model.inputs_of(&alone.run.exogenous));
    // Commands are kept only where they are written.
    let measured = campaign.simulate(0, 0..9, Wanted::Truth).unwrap();
    assert!(measured.iter().all(|run| run.commands.is_empty() && run.run == all[run.run.run as usize].run));
}

#[test]
fn law_what_was_commanded_moves_the_model_as_it_moved_the_ship() {
    let (vessel, generator, _) = reacting();
    let settings = Settings { duration_s: 60.0, realizations: 9, random_segments: None, seed: 3 };
    let design = Designed { shares: BTreeMap::from([("zig-zag".to_owned(), 1.0)]), order: None };
    let still =
        Sea::new(&vessel, Disturbances { current: Current::None, measurement: SENSORS }, None).unwrap();
    let truth = vessel.parameters(Source::Value).unwrap();
    for SimulatedRun { run, states, .. } in
        Campaign::new(still, &generator, &design, &settings).unwrap().simulate_all().unwrap()
    {
        assert_eq!(simulate_one(&vessel.model, &truth, run.initial, &run.exogenous), states);
    }
}

#[test]
fn law_a_table_by_command_is_the_table() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let generator = dictionary(&vessel);
    let settings = Settings { duration_s: 333.0 / 8.0, realizations: 9, random_segments: None, seed: 3 };
    let design = Designed { shares: BTreeMap::from([("zig-zag".to_owned(), 1.0)]), order: None };
    let runs = |generator: &Generator| {
        Campaign::new(sea(&vessel), generator, &design, &settings).unwrap().simulate_all().unwrap()
    };
    let by_table = runs(&generator);
    let helm = Helm::table(&generator.realize(0, 333).unwrap().inputs);
    assert_eq!(runs(&generator.commanded(0, helm)), by_table);
}

#[test]
fn law_a_heading_trigger_runs_in_the_legs_of_a_plan() {
    let (vessel, pieces) = study();
    let signs = mirror(&vessel).unwrap();
    let plain = &pieces[1];
    let rows = extremes(&plain.inputs, vessel.model.inputs);
    let piece = Piece { helm: Some(Helm::new(ZigZag { rows: rows.clone() })), ..plain.clone() };
    let grid = grid(8);
    let repertoire = repertoire(&vessel, &grid, std::slice::from_ref(&piece), Some(&signs), [0.0; 2]);
    let outcomes = repertoire.informative(0, 0, &others(&vessel)).unwrap();
    let mut sides = BTreeSet::new();
    for outcome in outcomes {
        let settled = outcome.unwrap_or_else(|unsettled| panic!("{unsettled:?}"));
        let Purpose::Informative { side, .. } = settled.leg.purpose else { panic!("{:?}", settled.leg) };
        sides.insert(side == Side::Mirrored);
        let sailed: Vec<_> = settled.sailed.samples.iter().filter(|sample| sample.informative).collect();
        assert_eq!(sailed.len(), plain.samples);
        let (from, mirrored) = (sailed[0].pose.psi, side == Side::Mirrored);
        let mut over = 0;
        for sample in &sailed {
            let psi = (sample.pose.psi - from) * if mirrored { -1.0 } else { 1.0 };
            if (over % 2 == 0 && psi >= TRIGGER) || (over % 2 == 1 && psi <= -TRIGGER) {
                over += 1;
            }
            let sign = |i: usize| if mirrored { signs[i] } else { 1.0 };
            let wanted: Vec<f64> = rows[over % 2].iter().enumerate().map(|(i, u)| sign(i) * u).collect();
            assert_eq!(sample.inputs, wanted, "{side:?}: after the helm went over {over} times");
        }
        assert!(over >= 2, "{side:?}: {over}");
    }
    assert_eq!(sides.len(), 2);
}

/// A standard maneuver of the vessel of Helsinki, as it is planned.
fn planned(keys: &str, speed_m_s: f64, seconds: usize) -> Result<(Vessel, Piece), Invalid> {
    let (vessel, _) = study();
    let text =
        format!("[[maneuver]]\nname = \"m\"\nspeed_m_s = {speed_m_s:.1}\nduration_s = {seconds}.0\n{keys}\n");
    let dictionary: DictionaryFile = text.parse().unwrap();
    let generator = Generator::without_tables(&vessel, &dictionary).unwrap();
    let inputs = generator.realize(0, seconds).unwrap().inputs;
    let helm = generator.program(0, seconds).unwrap();
    let piece =
        Piece { maneuver: "m".to_owned(), speed_m_s, inputs, samples: seconds, longest: seconds, helm };
    let piece = piece.timed(&vessel)?;
    Ok((vessel, piece))
}

#[test]
fn law_a_circle_of_a_plan_ends_where_each_vessel_has_turned() {
    let circle = "kind = \"turning-circle\"\nhelm = { tau3 = 200.0 }\nturn_rad = 7.0";
    let (vessel, piece) = planned(circle, 1.5, 400).unwrap();
    assert!(piece.samples < piece.longest && piece.inputs.len() == 3 * piece.samples);
    let (signs, grid) = (mirror(&vessel).unwrap(), grid(8));
    let repertoire = repertoire(&vessel, &grid, std::slice::from_ref(&piece), Some(&signs), [0.0; 2]);
    let all = others(&vessel);
    for outcome in repertoire.informative(0, 0, &all).unwrap() {
        let settled = outcome.unwrap_or_else(|unsettled| panic!("{unsettled:?}"));
        let own: Vec<_> = settled.sailed.samples.iter().filter(|sample| sample.informative).collect();
        assert_eq!(own.len(), piece.samples);
        let after =
            settled.sailed.samples.iter().skip_while(|sample| !sample.informative).nth(own.len()).unwrap();
        let turned = (after.pose.psi - own[0].pose.psi).abs();
        assert!((turned - 7.0).abs() < 0.1, "{turned}");
        // The others need other times for it.
        let lengths: BTreeSet<usize> = settled.tracks.iter().map(Vec::len).collect();
        assert!(lengths.len() > 2, "{lengths:?}");
    }
}

#[test]
fn a_program_that_the_nominal_vessel_does_not_come_to_the_end_of_is_refused() {
    let circle = "kind = \"turning-circle\"\nhelm = { tau3 = 200.0 }";
    let refused = planned(circle, 1.5, 60).unwrap_err().to_string();
    assert!(
        refused.contains("maneuver `m`: found its change of heading not reached after 60 s"),
        "{refused}"
    );
}
