//! Figures of merit of logs, which show themselves when orders were given, and which.

use std::f64::consts::PI;

use maneuver::DictionaryFile;
use maneuver::merit::{Hull, Record, SailedFigures, figures};
use refusal::Invalid;
use ship::model::Vessel;

use crate::reference_ships::{Case, cases};

/// A log: u, v, r, north, east, heading and inputs of every sample.
#[derive(Clone)]
struct Log {
    case: usize,
    length_m: f64,
    rate_hz: f64,
    rows: Vec<Vec<f64>>,
    vessel: Vessel,
}

impl Log {
    /// That of a published ship, after `lengths` of a straight approach.
    fn of((number, case): (usize, &Case), lengths: f64) -> Self {
        let first = &case.record[0];
        let speed = first[0].hypot(first[1]);
        let count = (lengths * case.length_m / speed * case.rate_hz).round() as usize;
        let before = (0..count).map(|k| {
            let away = (k as f64 - count as f64) / case.rate_hz;
            let mut row = vec![first[0], first[1], 0.0, first[0] * away, first[1] * away, 0.0];
            // Before the order inputs are those of the approach; a step stands in the first sample after it.
            row.extend(
                case.inputs
                    .iter()
                    .zip(&first[6..])
                    .map(|(name, own)| if name == "delta" { 0.0 } else { *own }),
            );
            row
        });
        let rows = before.chain(case.record.iter().cloned()).collect();
        Self { case: number, length_m: case.length_m, rate_hz: case.rate_hz, rows, vessel: case.vessel() }
    }

    fn changed(mut self, change: impl Fn(usize, &mut Vec<f64>)) -> Self {
        self.rows.iter_mut().enumerate().for_each(|(k, row)| change(k, row));
        self
    }

    /// The ship as in a mirror.
    fn mirrored(self) -> Self {
        self.changed(|_, row| [1, 2, 4, 5, 6].into_iter().for_each(|i| row[i] = -row[i]))
    }

    /// With noise of these standard deviations in places, heading, speeds and helm.
    fn noisy(self, [place_m, heading, speed, helm]: [f64; 4]) -> Self {
        let mut seed = self.case as u64 + 1;
        let mut own = self;
        let rate = speed / own.length_m;
        for row in &mut own.rows {
            for (i, size) in [speed, speed, rate, place_m, place_m, heading, helm].into_iter().enumerate() {
                row[i] += size * crate::standard::normal(&mut seed);
            }
        }
        own
    }

    fn figures(&self, dictionary: Option<&str>) -> Result<SailedFigures, Invalid> {
        let states: Vec<f64> = self.rows.iter().flat_map(|row| row[..3].to_vec()).collect();
        let inputs = self.rows[..self.rows.len() - 1].iter().flat_map(|row| row[6..].to_vec()).collect();
        // A compass goes round.
        let poses: Vec<[f64; 3]> =
            self.rows.iter().map(|row| [row[3], row[4], (row[5] + 3.0).rem_euclid(2.0 * PI) - 3.0]).collect();
        let record = Record::of_states(&states, inputs, self.rate_hz).with_poses(&poses).logged(0);
        let hull = Hull { vessel: &self.vessel, length_m: self.length_m };
        let file: Option<DictionaryFile> = dictionary.map(|keys| {
            let text = format!("[[maneuver]]\nname = \"m\"\nduration_s = 500.0\n{keys}\n");
            text.parse().unwrap_or_else(|e| panic!("{text}: {e}"))
        });
        figures(file.as_ref().and_then(|file| file.maneuvers[0].kind.standard()), &record, &hull)
    }
}

fn value(found: &SailedFigures, name: &str) -> f64 {
    found.figures.iter().find(|own| own.name == name).unwrap_or_else(|| panic!("{name}: {found:?}")).value
}

/// The reference ships that are steered by a rudder, by their numbers.
fn steered(all: &[Case]) -> impl Iterator<Item = (usize, &Case)> {
    all.iter().enumerate().filter(|(_, case)| case.inputs[0] == "delta")
}

#[test]
fn oracle_figures_of_logs_are_those_in_continuous_time_after_any_approach_with_noise_and_to_either_side() {
    let all = cases();
    let mut compared = 0;
    for case in steered(&all) {
        for (lengths, is_mirrored) in [(0.0, false), (6.0, false), (6.0, true)] {
            let log = Log::of(case, lengths);
            let log = if is_mirrored { log.mirrored() } else { log };
            let noise = [0.003 * log.length_m, 0.001, 0.003 * case.1.record[0][0], 0.0004];
            let log = if lengths > 0.0 { log.noisy(noise) } else { log };
            let found = log.figures(None).unwrap();
            let wanted = case.1.maneuver.standard().unwrap();
            assert_eq!(found.kind, wanted.name());
            for (name, expected) in &case.1.figures {
                let own = found.figures.iter().find(|own| own.name == name).unwrap();
                let most = match own.unit.as_str() {
                    "L" => 0.02,
                    "deg" => 0.1,
                    "s" => 0.02 * log.length_m / case.1.record[0][0],
                    _ => 0.02,
                };
                let off = own.value - expected;
                assert!(
                    off.abs() < most,
                    "{} {wanted:?}, {lengths} L: {name} off by {off} {}",
                    case.1.ship,
                    own.unit
                );
                compared += 1;
            }
            let is_told =
                found.remarks.iter().any(|own| own.contains("the approach in the log is 0.0 ship lengths"));
            assert_eq!(is_told, lengths == 0.0, "{:?}", found.remarks);
        }
    }
    assert!(compared > 200, "{compared}");
}

/// A turning circle of one and a half turns to starboard, and a zig-zag 10°/10°.
fn circle() -> Log {
    let all = cases();
    let own =
        steered(&all).find(|(_, case)| case.maneuver.standard().unwrap().name() == "turning-circle").unwrap();
    Log::of(own, 4.0)
}

fn zig_zag() -> Log {
    let all = cases();
    Log::of(steered(&all).next().unwrap(), 4.0)
}

#[test]
fn law_a_steady_current_changes_no_corrected_figure() {
    let still = circle().figures(None).unwrap();
    assert!(still.remarks.iter().all(|own| !own.contains("drift")), "{:?}", still.remarks);
    let [north, east] = [-0.4, 0.7];
    for over_ground in [false, true] {
        let log = circle();
        let rate = log.rate_hz;
        let log = log.changed(|k, row| {
            let seconds = k as f64 / rate;
            (row[3], row[4]) = (row[3] + north * seconds, row[4] + east * seconds);
            if over_ground {
                let (sin, cos) = row[5].sin_cos();
                (row[0], row[1]) = (row[0] + north * cos + east * sin, row[1] + east * cos - north * sin);
            }
        });
        let found = log.figures(None).unwrap();
        assert!(
            found.remarks.iter().any(|own| own.contains("drifts at 0.81 m/s to 120°")),
            "{:?}",
            found.remarks
        );
        for (own, known) in found.figures.iter().zip(&still.figures) {
            let off = own.corrected.unwrap() - known.value;
            assert!(off.abs() < 0.02 * known.value.abs().max(0.3), "{over_ground}: {own:?} {known:?}");
        }
        assert!((value(&found, "tactical_diameter") - value(&still, "tactical_diameter")).abs() > 0.2);
    }
    // Less than one and a half turns show a current by speeds through the water alone.
    let mut short = circle();
    short.rows.truncate(short.rows.len() * 2 / 3);
    let remarks = short.figures(None).unwrap().remarks;
    assert!(remarks.iter().any(|own| own.starts_with("not corrected for a current: 1.")), "{remarks:?}");
}

#[test]
fn law_nomotos_ship_is_found_again() {
    let (gain, time, rate) = (0.08, 12.0, 5.0);
    let mut log = zig_zag();
    let (mut r, mut psi, mut side, mut t) = (0.0, 0.0, 1.0, 0.0);
    log.rate_hz = rate;
    log.rows = (0..3000)
        .map(|k| {
            let delta: f64 = if k < 300 { 0.0 } else { 0.2 * side };
            let row = vec![7.0, 0.0, r, t * 7.0, 0.0, psi, delta];
            for _ in 0..20 {
                r += (gain * (delta + 0.01) - r) / time / rate / 20.0;
                psi += r / rate / 20.0;
            }
            if k < 300 {
                (r, psi) = (0.0, 0.0);
            }
            side = if side * psi > 0.2 { -side } else { side };
            t += 1.0 / rate;
            row
        })
        .collect();
    let found = log.figures(None).unwrap();
    let [own_gain, own_time] = ["nomoto_gain", "nomoto_time"].map(|name| value(&found, name));
    assert!(
        (own_gain / gain - 1.0).abs() < 0.02 && (own_time / time - 1.0).abs() < 0.04,
        "{own_gain} {own_time}"
    );
}

const CIRCLE: &str = "kind = \"turning-circle\"\nspeed_m_s = 7.7\nhelm = { delta = 0.610865 }";
const ZIG_ZAG: &str =
    "kind = \"zig-zag-test\"\nspeed_m_s = 7.7\nhelm = { delta = 0.1745 }\nheading_rad = 0.1745";

#[test]
fn what_differs_from_the_dictionary_is_named() {
    let told = |log: &Log, keys: &str, words: &str| {
        let found = log.figures(Some(keys)).unwrap();
        assert!(found.remarks.iter().any(|own| own.contains(words)), "{words}: {:?}", found.remarks);
        found
    };
    let plain = circle().figures(Some(CIRCLE)).unwrap();
    assert_eq!(plain.remarks, Vec::<String>::new());
    assert!(plain.figures[0].most.is_some());
    let mirrored = circle().mirrored();
    let port = told(&mirrored, CIRCLE, "she turned to port first, the dictionary says starboard");
    assert!((value(&port, "advance") - value(&plain, "advance")).abs() < 1e-9);
    // A sensor that counts to port.
    let inverted = circle().changed(|_, row| row[6] = -row[6]);
    let other = told(&inverted, CIRCLE, "the log has the other sign of the helm");
    assert!((value(&other, "advance") - value(&plain, "advance")).abs() < 1e-9);
    told(&circle(), &CIRCLE.replace("0.610865", "0.3491"), "the helm was 35.0°, the dictionary says 20.0°");
    // With another helm the circle has no limit.
    let small = circle().changed(|_, row| row[6] *= 20.0 / 35.0);
    let small = told(&small, CIRCLE, "the helm was 20.0°, the dictionary says 35.0°");
    assert!(small.figures.iter().all(|own| own.most.is_none()));
    assert!(
        small.remarks.iter().any(|own| own.contains("IMO has limits for circles")),
        "{:?}",
        small.remarks
    );
    let twenty = ZIG_ZAG.replace("0.1745", "0.3491");
    let ten = told(&zig_zag(), &twenty, "the helm went over at 10.0°, the dictionary says 20.0°");
    assert!(
        ten.figures.iter().any(|own| own.name == "overshoot_1" && own.most.is_some_and(|most| most < 20.0))
    );
}

#[test]
fn an_approach_that_is_not_steady_is_named() {
    let steady = |log: Log| log.figures(None).unwrap().remarks.join("; ");
    let rate = circle().rate_hz;
    let slower = circle().changed(|k, row| row[0] *= 1.15 - 0.15 * (k as f64 / 40.0).min(1.0));
    assert!(steady(slower).contains("not steady: in 2.0 ship lengths her speed changed by"));
    let turning = circle().changed(|k, row| row[5] -= 0.004 * (40.0 - k as f64).max(0.0) / rate);
    assert!(steady(turning).contains("not steady: in 2.0 ship lengths she turned by"));
    let rough = circle().changed(|k, row| row[6] += if k < 40 && k / 5 % 2 == 0 { 0.1 } else { 0.0 });
    assert!(steady(rough).contains("the helm moved"));
}

#[test]
fn logs_of_no_standard_maneuver_and_those_without_their_beginning_are_refused() {
    let refused = |log: &Log, keys: Option<&str>, words: &[&str]| {
        let why = log.figures(keys).unwrap_err().to_string();
        assert!(words.iter().all(|own| why.contains(own)), "{why}");
    };
    refused(
        &zig_zag(),
        Some(CIRCLE),
        &["found a zig-zag 10°/10°, to starboard first", "expected a turning-circle"],
    );
    refused(
        &circle(),
        Some(ZIG_ZAG),
        &["found a turning circle with 35° to starboard", "expected a zig-zag-test"],
    );
    for keys in [None, Some(CIRCLE)] {
        let straight = circle().changed(|_, row| (row[2], row[5], row[6]) = (0.0, 0.0, 0.0));
        refused(
            &straight,
            keys,
            &["helm: found never more than 0.0° from 0.0°", "a straight run has no figures"],
        );
        let mut late = circle();
        late.rows.drain(..60);
        refused(&late, keys, &["over at 35.0° where the log begins", "log from before the order on"]);
    }
    let steps = circle().changed(|k, row| row[6] *= (0.2 * (5.0 - (k / 60) as f64)).max(-1.0));
    refused(&steps, None, &["steps of helm from"]);
    // Without a dictionary this is a pull-out.
    let early = circle();
    let begin = early.rows.iter().position(|row| row[5] > 1.0).unwrap();
    let early = early.changed(|k, row| {
        if k > begin {
            (row[2], row[5], row[6]) = (0.0, 1.1, 0.0);
        }
    });
    refused(&early, Some(CIRCLE), &["of turn"]);
    assert_eq!(early.figures(None).unwrap().kind, "pull-out");
}

#[test]
fn a_helm_that_is_taken_off_ends_the_steady_turn() {
    let whole = circle().figures(None).unwrap();
    assert!(whole.figures.iter().any(|own| own.name == "drift_angle"));
    let log = circle();
    let end = log.rows.iter().position(|row| row[5] > 1.45 * PI).unwrap();
    let log = log.changed(|k, row| row[6] = if k > end { 0.0 } else { row[6] });
    let found = log.figures(Some(CIRCLE)).unwrap();
    assert!(found.remarks.iter().any(|own| own.contains("taken off after 2")), "{:?}", found.remarks);
    assert!(found.figures.iter().all(|own| own.name != "steady_diameter"));
    assert!((value(&found, "tactical_diameter") - value(&whole, "tactical_diameter")).abs() < 1e-9);
}
