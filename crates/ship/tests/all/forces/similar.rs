//! Laws of similar ships, and of priors that are usual.

use ship::forces::{Channel, Description, Forces, Number, Similarity};

use crate::forces::ships::{ESSO_OSAKA, KVLCC2, MARINER, OTTER, channels, forces};

/// A ship, a motion of hers and a row of inputs.
const POINTS: [(&str, [f64; 3], &[f64]); 3] = [
    (MARINER, [7.0, 0.4, -0.006], &[0.2]),
    (KVLCC2, [1.1, -0.1, 0.03], &[0.3, 11.0]),
    (OTTER, [1.2, 0.1, 0.3], &[60.0, -30.0]),
];

/// The ship `ratio` times as long, in water 1.025 times as dense, with her channels' ranges.
fn similar(text: &str, ratio: f64) -> (Forces, Similarity) {
    let first = forces(text).unwrap();
    let own = first.description();
    let water = 1.025 * own.density_kg_m3;
    let by = Similarity::new(own, ratio * own.ship.length_m, Some(water)).unwrap();
    let channels = channels(text);
    (Forces::new(&own.similar(&by, &channels).unwrap(), &channels).unwrap(), by)
}

fn scaled(
    by: &Similarity,
    [u, v, r]: [f64; 3],
    channels: &[Channel],
    inputs: &[f64],
) -> ([f64; 3], Vec<f64>) {
    let speed = |own: f64| by.in_unit(own, "m/s").unwrap();
    let inputs = channels.iter().zip(inputs).map(|(own, value)| by.in_unit(*value, &own.unit).unwrap());
    ([speed(u), speed(v), by.in_unit(r, "rad/s").unwrap()], inputs.collect())
}

#[test]
fn law_a_similar_ship_has_the_accelerations_of_the_first_one() {
    for (text, state, inputs) in POINTS {
        let first = forces(text).unwrap();
        let expected = first.body(&first.nominal()).accelerations(state, inputs);
        for ratio in [32.0 / 7.0, 0.1, 4.0] {
            let (other, by) = similar(text, ratio);
            let (state, inputs) = scaled(&by, state, &channels(text), inputs);
            let found = other.body(&other.nominal()).accelerations(state, &inputs);
            for (d, scale) in [1.0, 1.0, ratio].into_iter().enumerate() {
                let off = (scale * found[d] - expected[d]).abs();
                assert!(off <= 1e-12 * expected[d].abs(), "{d} {ratio}: {found:?} {expected:?}");
            }
        }
    }
}

/// Positions in lengths, after every sample of a turn.
fn turn(forces: &Forces, start: [f64; 3], inputs: &[f64], sample_s: f64) -> Vec<[f64; 2]> {
    let (theta, length) = (forces.nominal(), forces.description().ship.length_m);
    let body = forces.body(&theta);
    let (mut state, mut heading, mut place) = (start, 0.0_f64, [0.0; 2]);
    let sample = |_| {
        let next = body.step_held(state, inputs, sample_s);
        let [u, v, r] = [0, 1, 2].map(|d: usize| 0.5 * (state[d] + next[d]));
        heading += r * sample_s;
        let (sine, cosine) = heading.sin_cos();
        place[0] += sample_s * (u * cosine - v * sine) / length;
        place[1] += sample_s * (u * sine + v * cosine) / length;
        state = next;
        place
    };
    (0..2000).map(sample).collect()
}

#[test]
fn law_a_similar_ship_turns_on_the_same_track_in_lengths() {
    for (text, ratio, start, inputs) in [
        (MARINER, 0.1, [7.7175, 0.0, 0.0], &[0.6109][..]),
        (KVLCC2, 320.0 / 7.0, [1.179, 0.0, 0.0], &[0.6109, 10.4]),
        (OTTER, 3.0, [1.2, 0.0, 0.0], &[60.0, 20.0]),
    ] {
        let (other, by) = similar(text, ratio);
        let first = turn(&forces(text).unwrap(), start, inputs, 0.1);
        let (start, inputs) = scaled(&by, start, &channels(text), inputs);
        let found = turn(&other, start, &inputs, by.seconds(0.1));
        let apart = first.iter().zip(&found).map(|(a, b)| (a[0] - b[0]).abs().max((a[1] - b[1]).abs()));
        let most = apart.fold(0.0, f64::max);
        assert!(most <= 1e-9, "{most}");
    }
}

#[test]
fn law_there_and_back_is_the_same_ship() {
    let both = |text: &str, ratio: f64| {
        let (first, channels) = (forces(text).unwrap(), channels(text));
        let own = first.description().clone();
        let there = Similarity::new(&own, ratio * own.ship.length_m, Some(1030.0)).unwrap();
        let other = own.similar(&there, &channels).unwrap();
        assert_ne!(other, own);
        let back = Similarity::new(&other, own.ship.length_m, Some(own.density_kg_m3)).unwrap();
        (own, other.similar(&back, &channels).unwrap())
    };
    for text in [MARINER, KVLCC2] {
        for ratio in [32.0 / 7.0, 0.3, 4.0] {
            let (own, back) = both(text, ratio);
            assert_eq!(own, back, "{ratio}");
        }
    }
    // Her numbers have 16 digits: two roundings may show in the last.
    let (own, back) = both(OTTER, 0.3);
    let numbers = |own: &Description| match (&own.ship.inertia_kg_m2, &own.surge[0].nominal) {
        (Some(Number::Plain(inertia)), Some(drag)) => [*inertia, *drag],
        _ => panic!("{own:?}"),
    };
    for (own, back) in numbers(&own).into_iter().zip(numbers(&back)) {
        assert!((own - back).abs() <= 1e-14 * own.abs(), "{own} {back}");
    }
}

#[test]
fn law_the_gate_judges_a_ship_at_any_size_alike() {
    let wide = KVLCC2.replace("x_m = { prime = -0.5, fixed = true }", "x_m = -0.5");
    for text in [MARINER, KVLCC2, OTTER, ESSO_OSAKA, &wide] {
        let (first, channels) = (forces(text).unwrap(), channels(text));
        let own = first.description();
        let judged = |ship: &Forces| ship.gate(&ship.nominal(), false).map_err(|e| e.thing);
        assert_eq!(judged(&first).is_ok(), text != wide);
        for length in [0.5, 3.0, 70.0, 400.0] {
            let by = Similarity::new(own, length, None).unwrap();
            let other = Forces::new(&own.similar(&by, &channels).unwrap(), &channels).unwrap();
            assert_eq!(judged(&first), judged(&other), "{length} m");
        }
    }
}

#[test]
fn law_every_free_number_gets_a_prior_and_keeps_its_own() {
    for text in [MARINER, KVLCC2, OTTER] {
        let (first, channels) = (forces(text).unwrap(), channels(text));
        let (own, usual) = first.description().with_usual_priors(&channels).unwrap();
        let own = Forces::new(&own, &channels).unwrap();
        for (before, after) in first.parameters().iter().zip(own.parameters()) {
            assert_eq!(before.name, after.name);
            assert!(after.prior.is_some_and(|own| own > 0.0), "{}", after.name);
            assert_eq!(before.prior.is_none(), usual.contains(&after.name));
            assert!(before.prior.is_none() || before.prior == after.prior);
        }
    }
    // By ½ρL² a derivative is smaller by the draught over the length.
    let (own, _) = forces(MARINER).unwrap().description().with_usual_priors(&channels(MARINER)).unwrap();
    let found = own.sway[0].prior.unwrap();
    assert!((found - 0.3 * 8.0 / 160.93).abs() < 1e-15, "{found}");
}

#[test]
fn a_number_of_a_channel_whose_unit_no_rule_scales_is_refused_by_name() {
    let text = OTTER.replacen("unit = \"rad/s\"", "unit = \"notches\"", 1);
    let (first, channels) = (forces(&text).unwrap(), channels(&text));
    let by = Similarity::new(first.description(), 4.0, None).unwrap();
    let refused = first.description().similar(&by, &channels).unwrap_err().to_string();
    assert!(refused.contains("`port.ahead`") && refused.contains("`notches`"), "{refused}");
    for (length, water) in [(0.0, None), (f64::NAN, None), (2000.0, None), (4.0, Some(500.0))] {
        assert!(Similarity::new(first.description(), length, water).is_err());
    }
}
