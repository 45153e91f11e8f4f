//! Laws of what tests say is wrong with a fitted ship.

use estimation::criticism::{Absent, Criticism, Suspect};
use estimation::fitting::{Channels, Problem, Settings};
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
    problem.criticise(&fit, Channels { all: &channels, inputs: channels.len() }).unwrap()
}

/// What is said of one kind of candidates, in order.
fn of(found: &Criticism, kind: Suspect) -> Vec<&Absent> {
    found.absent.iter().filter(|absent| absent.kind == kind).collect()
}

fn has_wrong_sign(found: &Criticism) -> bool {
    found.wrong_signs().next().is_some()
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
        let first = &found.absent[0];
        println!("{term}: {first:?}");
        assert!(found.rejected && !has_wrong_sign(&found), "{term}: {:?}", found.statements);
        assert!(first.label() == format!("`{term}` in yaw") && first.candidate, "{term}: {first:?}");
        let off = 1.0 - prime / first.prime_value.unwrap();
        assert!((off * first.value[0]).abs() < 4.0 * first.standard_error[0], "{term}: {off} {first:?}");
        assert!(found.statements[0].contains("most likely missing: `"), "{:?}", found.statements);
    }
}

#[test]
fn law_a_right_ship_is_rejected_no_more_often_than_stated() {
    let truth = forces(KVLCC2);
    let mut rejected = 0;
    for seed in 1..=8 {
        let recorded = trial(&truth, &truth.nominal(), 1.0, NOISE, seed);
        let found = criticised(KVLCC2, &recorded, Settings::new(1.0));
        let terms = of(&found, Suspect::Term).len() + found.hidden.len();
        assert!(!has_wrong_sign(&found) && terms > 200, "{:?}", found.statements);
        rejected += usize::from(found.rejected);
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
    for (kind, dead, lag) in [("dead time", 2.5, 0.0), ("lag", 0.0, 3.0)] {
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
        let first = &found.absent[0];
        println!("{first:?}");
        assert!(first.kind == Suspect::Late && first.name == "delta" && first.p_value < 0.01, "{first:?}");
        let best = first.remedy.as_ref().unwrap().split("; ").nth(1).unwrap();
        let seconds = best.split(' ').find_map(|word| word.parse::<f64>().ok()).unwrap();
        let is_best = best.starts_with(&format!("as a {kind} of "));
        assert!(is_best && (seconds / (dead + lag) - 1.0).abs() < 0.4, "{first:?}");
        let said = &found.statements[0];
        assert!(said.contains("`delta` acts ") && said.contains("later than the model has it"), "{said}");
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
    println!("{:?}", found.statements);
    assert!(has_wrong_sign(&found) && found.rejected && found.p_value.is_none());
    assert_eq!(found.absent[0].name, "`delta` acts with the opposite sign, the angle of `rudder`");
    assert_eq!(of(&found, Suspect::Sign).len(), found.absent.len());
    assert!(found.statements[0].contains("`sign = -1`"), "{:?}", found.statements);
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
    let signs = of(&right, Suspect::Sign);
    assert!(!has_wrong_sign(&right) && signs.len() == 5, "{signs:?}");
    let mut exchanged = otter();
    for own in &mut exchanged {
        own.inputs.chunks_exact_mut(2).for_each(|row| row.swap(0, 1));
    }
    let found = criticised(&otter_text, &exchanged, settings);
    let first = &found.absent[0];
    assert!(
        first.candidate && first.name == "`n1` and `n2` are exchanged, the inputs of `port` and `starboard`",
        "{first:?}"
    );
    assert_eq!(of(&found, Suspect::Sign).len(), found.absent.len());
    let one = criticised(&otter_text.replace("y_m = -0.395", "y_m = 0.395"), &otter(), settings);
    let first = &one.absent[0];
    assert!(first.candidate && first.name == "`port` is on the other side of the ship", "{first:?}");
    // Without priors there is no end of the search, and the sign is named all the same.
    let (forces, (_, channels)) = (forces(OTTER), parts(OTTER));
    let problem =
        Problem::new(&forces, exchanged.iter().map(Recorded::recording).collect(), 2, settings).unwrap();
    let theta = forces.nominal();
    let error = problem.fit_from(&theta).unwrap_err();
    let said = problem.explained(error, &theta, Channels { all: &channels, inputs: 2 }).to_string();
    assert!(said.contains("`n1` and `n2` are exchanged"), "{said}");
}
