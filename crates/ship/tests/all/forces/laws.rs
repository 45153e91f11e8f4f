//! Laws of steps, tangents, lanes, the prime system and delays.

use numerics::{Arithmetic, LANES, Lane};
use ship::forces::{Body, Dual, Forces, Real};

use crate::forces::ships::{KVLCC2, MARINER, OTTER, forces};

/// A ship, a motion of hers and two rows of inputs.
type Point = (&'static str, [f64; 3], [&'static [f64]; 2]);

const POINTS: [Point; 3] = [
    (MARINER, [7.0, 0.4, -0.006], [&[0.2], &[-0.1]]),
    (KVLCC2, [1.1, -0.1, 0.03], [&[0.3, 11.0], &[0.25, 12.0]]),
    (OTTER, [1.2, 0.1, 0.3], [&[60.0, -30.0], &[70.0, 20.0]]),
];

/// By each of θ and of the state, the derivatives of a step of a second or less.
fn tangents(forces: &Forces, state: [f64; 3], [begin, end]: [&[f64]; 2], seconds: f64) -> Vec<[f64; 3]> {
    const AT_ONCE: usize = 5;
    let theta = forces.nominal();
    let all = theta.len() + 3;
    let columns = (0..all).step_by(AT_ONCE).flat_map(|first| {
        let own = |value: f64, i: usize| Dual::<f64, AT_ONCE>::unknown(value, i.wrapping_sub(first));
        let unknowns: Vec<_> = theta.iter().enumerate().map(|(i, value)| own(*value, i)).collect();
        let start = [0, 1, 2].map(|d: usize| own(state[d], theta.len() + d));
        let next = forces.body(&unknowns).step(start, begin, end, seconds);
        (0..AT_ONCE).map(move |i| next.map(|own| own.tangents[i]))
    });
    columns.take(all).collect()
}

#[test]
fn law_tangents_are_central_differences() {
    for (text, state, inputs) in POINTS {
        let forces = forces(text).unwrap();
        let (theta, seconds) = (forces.nominal(), 0.5);
        let found = tangents(&forces, state, inputs, seconds);
        for (i, found) in found.iter().enumerate() {
            let at = |sign: f64| {
                let (mut theta, mut state) = (theta.clone(), state);
                let own = if i < theta.len() { &mut theta[i] } else { &mut state[i - theta.len()] };
                let step = 1e-5 * own.abs().max(1e-2);
                *own += sign * step;
                (forces.body(&theta).step(state, inputs[0], inputs[1], seconds), step)
            };
            let ((above, step), (below, _)) = (at(1.0), at(-1.0));
            for d in 0..3 {
                let difference = (above[d] - below[d]) / (2.0 * step);
                let off = (difference - found[d]).abs();
                assert!(off <= 1e-6 * found[d].abs() + 1e-8, "{i} {d}: {} {difference}", found[d]);
            }
        }
    }
}

#[test]
fn law_lanes_are_runs_of_their_own_to_the_bit() {
    for (text, state, [begin, end]) in POINTS {
        let forces = forces(text).unwrap();
        let theta = forces.nominal();
        let of = |value: f64, lane: usize| value * (1.0 + 0.01 * lane as f64);
        let lanes = |values: &[f64]| -> Vec<Lane> {
            values.iter().map(|value| Lane(std::array::from_fn(|lane| of(*value, lane)))).collect()
        };
        let [start, begins, ends] = [&state[..], begin, end].map(lanes);
        let body = forces.body(&lanes(&theta));
        let found = body.step([start[0], start[1], start[2]], &begins, &ends, 0.5);
        for lane in 0..LANES {
            let own = |values: &[f64]| -> Vec<f64> { values.iter().map(|value| of(*value, lane)).collect() };
            let alone = forces.body(&own(&theta)).step(
                [of(state[0], lane), of(state[1], lane), of(state[2], lane)],
                &own(begin),
                &own(end),
                0.5,
            );
            assert_eq!(found.map(|own| own[lane]), alone);
        }
    }
}

#[test]
fn law_prime_and_si_numbers_say_the_same_ship() {
    let forces = forces(KVLCC2).unwrap();
    let mut table: toml::Table = KVLCC2.parse().unwrap();
    for parameter in forces.parameters().iter().filter(|own| own.unit == "1" && own.scale != 1.0) {
        for degree in ["surge", "sway", "yaw"] {
            for term in table[degree].as_array_mut().unwrap() {
                let term = term.as_table_mut().unwrap();
                if term["parameter"].as_str() == Some(&parameter.name) {
                    for key in ["prime", "value", "prior"] {
                        term.remove(key);
                    }
                    term.insert("nominal".to_owned(), (parameter.nominal * parameter.scale).into());
                }
            }
        }
    }
    let si = crate::forces::ships::forces(&table.to_string()).unwrap();
    assert_eq!(si.parameters().len(), forces.parameters().len());
    assert!(si.parameters()[5].unit.starts_with("N per (m/s × m/s"), "{}", si.parameters()[5].unit);
    let (state, inputs) = ([1.0, 0.2, -0.05], [0.1, 11.0]);
    let [one, other] = [&forces, &si].map(|own| own.body(&own.nominal()).accelerations(state, &inputs));
    for d in 0..3 {
        assert!((one[d] - other[d]).abs() <= 1e-13 * one[d].abs(), "{one:?} {other:?}");
    }
}

/// The state after `steps` steps in 4 s, with inputs that change linearly.
fn after(body: &Body<f64>, state: [f64; 3], [begin, end]: [&[f64]; 2], steps: usize) -> [f64; 3] {
    let at = |share: f64| -> Vec<f64> { begin.iter().zip(end).map(|(a, b)| a + (b - a) * share).collect() };
    (0..steps).fold(state, |state, i| {
        let [from, to] = [i, i + 1].map(|k| at(k as f64 / steps as f64));
        body.step(state, &from, &to, 4.0 / steps as f64)
    })
}

#[test]
fn law_steps_are_of_order_4() {
    // Otter's propellers do not reverse, so that no kink lies on her way.
    let otter = (OTTER, [1.2, 0.1, 0.3], [[60.0, 30.0].as_slice(), [70.0, 40.0].as_slice()]);
    for ((text, state, inputs), steps) in [(POINTS[0], 8), (POINTS[1], 8), (otter, 80)] {
        let forces = forces(text).unwrap();
        let body = forces.body(&forces.nominal());
        let exact = after(&body, state, inputs, 4096);
        let error = |steps: usize| {
            let found = after(&body, state, inputs, steps);
            (0..3).map(|d| (found[d] - exact[d]).powi(2)).sum::<f64>().sqrt()
        };
        let ratio = error(steps) / error(2 * steps);
        assert!((11.0..23.0).contains(&ratio), "{ratio}: {} {}", error(steps), error(2 * steps));
    }
}

#[test]
fn law_short_steps_within_a_sample_are_samples_of_their_own() {
    let text = OTTER.replace("density_kg_m3 = 1025.0", "density_kg_m3 = 1025.0\nstep_s = 0.1");
    let [whole, short] = [OTTER, &text].map(|text| forces(text).unwrap());
    let (state, inputs) = ([1.2, 0.1, 0.3], [60.0, -30.0]);
    let found = short.body(&short.nominal()).step_held(state, &inputs, 0.5);
    let body = whole.body(&whole.nominal());
    let expected = (0..5).fold(state, |state, _| body.step_held(state, &inputs, 0.1));
    for d in 0..3 {
        assert!((found[d] - expected[d]).abs() < 1e-14, "{found:?} {expected:?}");
    }
}

#[test]
fn law_lag_and_dead_time_delay_a_ramp() {
    let lag = "lag_s = { nominal = 0.5, prior = 0.1 }\ndead_time_s = { nominal = 0.75, prior = 0.1 }\n";
    let text = OTTER.replace("input = \"n1\"\n", &format!("input = \"n1\"\n{lag}"));
    let forces = forces(&text).unwrap();
    let theta = forces.nominal();
    let first = theta.len() - 2;
    let unknown = |(i, value): (usize, &f64)| Dual::<f64, 2>::unknown(*value, i.wrapping_sub(first));
    let unknowns: Vec<_> = theta.iter().enumerate().map(unknown).collect();
    let rows: Vec<f64> = (0..200).flat_map(|k| [0.1 * f64::from(k), 7.0]).collect();
    let found = forces.body(&unknowns).acting(&rows, 2, 0.1);
    // Long after its beginning, a ramp of 1 per second comes late by lag and dead time together.
    let last = found[2 * 199];
    assert!((last.value - (19.9 - 1.25)).abs() < 1e-9, "{last:?}");
    assert!(last.tangents.iter().all(|own| (own + 1.0).abs() < 1e-9), "{last:?}");
    assert_eq!(found[2 * 199 + 1].value, 7.0);
    assert_eq!(found[2 * 7].value, 0.0);
}

#[test]
fn law_angles_take_the_shorter_way_around() {
    let text = "density_kg_m3 = 1000.0\n[ship]\nlength_m = 10.0\ndraught_m = 1.0\nspeed_m_s = 2.0\nmass_kg = 1e4\n\
         gyration_m = 2.5\nadded_mass = { surge = 0.1, sway = 0.2, yaw = 0.01 }\n\
         [[input]]\nname = \"force\"\nunit = \"kN\"\n[[input]]\nname = \"azimuth\"\nunit = \"deg\"\n\
         [[thruster]]\nname = \"pod\"\ninput = \"force\"\nangle = \"azimuth\"\nx_m = -4.0\ncurve = \"force\"\n";
    let forces = forces(text).unwrap();
    let body = forces.body::<f64>(&[]);
    let [around, straight] = [[175.0, -175.0], [175.0, 185.0]]
        .map(|[from, to]| body.step([1.0, 0.0, 0.0], &[2.0, from], &[2.0, to], 1.0));
    for d in 0..3 {
        assert!((around[d] - straight[d]).abs() < 1e-12, "{around:?} {straight:?}");
    }
    let force = body.force([0.0; 3], &|i: usize| [2.0, 90.0][i]);
    assert!((force[1] - 2000.0).abs() < 1e-9 && (force[2] + 8000.0).abs() < 1e-9, "{force:?}");
}

#[test]
fn law_a_ship_at_rest_has_finite_forces_and_tangents() {
    for (text, _, [inputs, _]) in POINTS {
        let forces = forces(text).unwrap();
        for at in [[0.0; 3], [-0.5, 0.0, 0.0], [0.0, 0.1, 0.0]] {
            for row in [vec![0.0; inputs.len()], inputs.to_vec()] {
                let found = tangents(&forces, at, [&row, &row], 0.1);
                let flat: Vec<f64> = found.into_iter().flatten().collect();
                assert!(flat.iter().all(|own| own.is_finite()), "{at:?} {row:?} {flat:?}");
            }
        }
    }
}

#[test]
fn law_elementary_functions_have_their_tangents() {
    let x = Dual::<f64, 1>::unknown(0.7, 0);
    let (sine, cosine) = x.sine_and_cosine();
    let pairs = [
        (x.exponential(), libm::exp(0.7)),
        (sine, libm::cos(0.7)),
        (cosine, -libm::sin(0.7)),
        (x.root(), 0.5 / 0.7_f64.sqrt()),
        (x.angle(Dual::from(2.0)), 2.0 / (0.49 + 4.0)),
        (Dual::from(2.0).over(x), -2.0 / 0.49),
        (x.negated().modulus(), 1.0),
    ];
    for (found, slope) in pairs {
        assert!((found.tangents[0] - slope).abs() < 1e-15, "{found:?} {slope}");
    }
}
