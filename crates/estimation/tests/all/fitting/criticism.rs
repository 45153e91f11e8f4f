//! Laws of what tests say is wrong with a fitted ship.

use estimation::fitting::{Channels, Criticism, Lateness, Problem, Settings, Turn};
use ship::forces::Forces;

use crate::fitting::ship::{KVLCC2, Normals, Recorded, forces, parts, trial};

const NOISE: [f64; 3] = [0.005, 0.005, 0.0005];
const OTTER: &str = include_str!("../../../../ship/presets/otter.toml");

/// What is said of the ship `model` after a fit to `recorded`.
fn criticised(model: &str, recorded: &[Recorded], settings: Settings) -> Criticism {
    let forces = forces(model);
    let (_, channels) = parts(model);
    let recordings = recorded.iter().map(Recorded::recording).collect();
    let problem = Problem::new(&forces, recordings, channels.len(), settings).unwrap();
    let fit = problem.fit().unwrap();
    problem.criticise(&fit, Channels { all: &channels, inputs: channels.len(), listed: None }).unwrap()
}

/// KVLCC2 with another term of yaw.
fn with_yaw(term: &str, prime: f64) -> String {
    let more =
        format!("yaw = [\n  {{ parameter = \"N_more\", term = \"{term}\", prime = {prime}, fixed = true }},");
    KVLCC2.replace("yaw = [", &more)
}

#[test]
fn law_a_term_that_the_ship_lacks_is_named_first() {
    for (seed, (term, prime)) in
        [("r |r|", -0.03), ("v |v|", -0.1), ("u v delta", 0.2)].into_iter().enumerate()
    {
        let truth = forces(&with_yaw(term, prime));
        let recorded = trial(&truth, &truth.nominal(), 1.0, NOISE, seed as u64 + 1);
        let found = criticised(KVLCC2, &recorded, Settings::new(1.0));
        let first = &found.terms[0];
        println!("{term}: {first:?}");
        assert!(found.rejects() && !found.has_wrong_sign(), "{term}: {:?} {:?}", found.p_value, found.signs);
        assert!(first.degree == 2 && first.term == term && first.candidate, "{term}: {first:?}");
        let off = first.value / first.prime.unwrap() - prime;
        assert!(off.abs() < 4.0 * first.standard_error / first.prime.unwrap(), "{term}: {off} {first:?}");
    }
}

#[test]
fn law_listed_terms_alone_are_tested_each_once() {
    let truth = forces(&with_yaw("r |r|", -0.03));
    let recorded = trial(&truth, &truth.nominal(), 1.0, NOISE, 1);
    let (ship, (_, channels)) = (forces(KVLCC2), parts(KVLCC2));
    let recordings = recorded.iter().map(Recorded::recording).collect();
    let problem = Problem::new(&ship, recordings, channels.len(), Settings::new(1.0)).unwrap();
    let fit = problem.fit().unwrap();
    let tested = |yaw: &[&str]| {
        let lists = [Vec::new(), vec!["v |v|".to_owned()], yaw.iter().map(|own| (*own).to_owned()).collect()];
        problem.criticise(&fit, Channels { all: &channels, inputs: channels.len(), listed: Some(&lists) })
    };
    // The ship has the last one.
    let found = tested(&["u v delta", "r |r|", "|r| r", "r^2 v / U"]).unwrap();
    let terms: Vec<&str> = found.terms.iter().map(|own| own.term.as_str()).collect();
    assert!(terms.len() == 3 && terms[0] == "r |r|" && found.rejects(), "{terms:?}");
    let refused = tested(&["u w"]).unwrap_err().invalid();
    assert!(refused.thing == "`yaw`: term `u w`" && refused.found.contains('w'), "{refused}");
}

#[test]
fn law_a_right_ship_is_rejected_no_more_often_than_stated() {
    let truth = forces(KVLCC2);
    let mut rejected = 0;
    for seed in 1..=8 {
        let recorded = trial(&truth, &truth.nominal(), 1.0, NOISE, seed);
        let found = criticised(KVLCC2, &recorded, Settings::new(1.0));
        assert!(!found.has_wrong_sign() && found.terms.len() + found.hidden.len() > 200, "{:?}", found.signs);
        rejected += usize::from(found.rejects());
    }
    println!("{rejected} of 8 rejected");
    assert!(rejected <= 1, "{rejected}");
}

/// Follows `inputs` with white noise, where `acting` are the inputs that act.
fn followed(
    forces: &Forces,
    inputs: Vec<f64>,
    acting: &[f64],
    start: [f64; 3],
    (sample_s, seed): (f64, u64),
) -> Recorded {
    let (body, mut state) = (forces.body::<f64>(&forces.nominal()), start);
    let rows: Vec<&[f64]> = acting.chunks_exact(2).collect();
    let mut normals = Normals::new(seed);
    let mut states = vec![state];
    for k in 0..rows.len() {
        state = body.step(state, rows[k], rows[(k + 1).min(rows.len() - 1)], sample_s);
        states.push(state);
    }
    let measured =
        states.iter().flat_map(|own| [0, 1, 2].map(|d| own[d] + NOISE[d] * normals.next())).collect();
    Recorded { name: format!("recording {seed}"), inputs, measured }
}

#[test]
fn law_an_input_that_acts_late_is_named_with_its_time() {
    let truth = forces(KVLCC2);
    for (kind, dead, lag) in [(Lateness::DeadTime, 2.5, 0.0), (Lateness::Lag, 0.0, 3.0)] {
        let late = |(seed, own): (usize, Recorded)| {
            let rudder: Vec<f64> = own.inputs.iter().step_by(2).copied().collect();
            let follows = ship::forces::late(&rudder, dead, lag, 1.0);
            let mut acting = own.inputs.clone();
            acting.iter_mut().step_by(2).zip(follows).for_each(|(own, new)| *own = new);
            let start = [0, 1, 2].map(|d: usize| own.measured[d]);
            followed(&truth, own.inputs, &acting, start, (1.0, seed as u64))
        };
        let recorded = trial(&truth, &truth.nominal(), 1.0, [0.0; 3], 1);
        let recorded: Vec<Recorded> = recorded.into_iter().enumerate().map(late).collect();
        let found = criticised(KVLCC2, &recorded, Settings::new(1.0));
        let first = &found.late[0];
        println!("{first:?}\n{:?}", found.terms[0]);
        assert!(found.rejects() && first.input == "delta" && first.p_value < 0.01, "{first:?}");
        assert!(first.share > found.terms[0].share, "{first:?} {:?}", found.terms[0]);
        let (best, seconds, share) = first.best.unwrap();
        assert!(best == kind && (seconds / (dead + lag) - 1.0).abs() < 0.4, "{first:?}");
        assert!(share > first.other.unwrap(), "{first:?}");
    }
}

#[test]
fn law_a_rudder_logged_with_the_other_sign_is_named_before_anything_else() {
    let truth = forces(KVLCC2);
    let mut recorded = trial(&truth, &truth.nominal(), 1.0, NOISE, 1);
    for own in &mut recorded {
        own.inputs.iter_mut().step_by(2).for_each(|angle| *angle = -*angle);
    }
    let found = criticised(KVLCC2, &recorded, Settings::new(1.0));
    println!("{:?}", found.signs);
    assert!(found.has_wrong_sign() && found.rejects() && found.p_value.is_none());
    assert_eq!(found.signs[0].turn, Turn::Angle("rudder".to_owned(), "delta".to_owned()));
    assert!(found.late.is_empty() && found.terms.is_empty());
}

/// Four runs of Otter whose propellers change independently, 0.2 s a sample.
fn otter() -> Vec<Recorded> {
    let truth = forces(OTTER);
    let run = |seed: u64| {
        let mut normals = Normals::new(seed);
        let mut rows = [60.0, 60.0];
        let inputs: Vec<f64> = (0..300)
            .flat_map(|k| {
                if k % 25 == 0 {
                    rows = [0, 1].map(|_| (55.0 + 25.0 * normals.next()).clamp(-20.0, 100.0));
                }
                rows
            })
            .collect();
        followed(&truth, inputs.clone(), &inputs, [1.2, 0.0, 0.0], (0.2, seed))
    };
    (1..=4).map(run).collect()
}

/// Otter with numbers that are known to a third.
fn known_otter() -> String {
    let lines = OTTER.lines().map(|line| match line.split_once(", value = -") {
        Some((begin, value)) => {
            let number: f64 = value.split(' ').next().unwrap().parse().unwrap();
            format!("{begin}, prior = {} }},", number / 3.0)
        }
        None => line.to_owned(),
    });
    lines.collect::<Vec<_>>().join("\n")
}

#[test]
fn law_exchanged_thrusters_and_one_on_the_wrong_side_are_named() {
    let settings = Settings { window_s: 15.0, piece_s: 5.0, ..Settings::new(0.2) };
    let otter_text = known_otter();
    let right = criticised(&otter_text, &otter(), settings);
    println!("{:?} {:?}", right.signs, right.p_value);
    assert!(!right.has_wrong_sign() && right.signs.len() == 5, "{:?}", right.signs);
    let mut exchanged = otter();
    for own in &mut exchanged {
        own.inputs.chunks_exact_mut(2).for_each(|row| row.swap(0, 1));
    }
    let found = criticised(&otter_text, &exchanged, settings);
    println!("{:?}", found.signs);
    let pair = |one: &str, other: &str| [one.to_owned(), other.to_owned()];
    let turn = Turn::Exchanged(pair("port", "starboard"), pair("n1", "n2"));
    assert!(found.signs[0].turn == turn && found.signs[0].wrong, "{:?}", found.signs);
    assert!(found.terms.is_empty() && found.late.is_empty());
    let one = criticised(&otter_text.replace("y_m = -0.395", "y_m = 0.395"), &otter(), settings);
    println!("{:?}", one.signs);
    assert!(one.signs[0].turn == Turn::Side("port".to_owned()) && one.signs[0].wrong, "{:?}", one.signs);
    // Without priors there is no end of the search, and the sign is named all the same.
    let (forces, (_, channels)) = (forces(OTTER), parts(OTTER));
    let problem =
        Problem::new(&forces, exchanged.iter().map(Recorded::recording).collect(), 2, settings).unwrap();
    let theta = forces.nominal();
    let error = problem.fit_from(&theta).unwrap_err();
    let said =
        problem.explained(error, &theta, Channels { all: &channels, inputs: 2, listed: None }).to_string();
    assert!(said.contains("`n1` and `n2` exchanged"), "{said}");
}
