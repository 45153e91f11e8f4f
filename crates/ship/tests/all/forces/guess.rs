//! Ships from main dimensions: formulas, and maneuvers that ships do.

use ship::engine::Streams;
use ship::forces::{Channel, Forces, Guess, MainDimensions};

fn dimensions(length_m: f64, beam_m: f64, draught_m: f64, block: f64) -> MainDimensions {
    MainDimensions {
        length_m,
        beam_m,
        draught_m,
        block,
        density_kg_m3: 1025.0,
        speed_m_s: None,
        mass_kg: None,
        propeller_diameter_m: None,
        rudder_area_m2: None,
        rudder_height_m: None,
        rudder_rate_deg_s: None,
        x_g_m: None,
    }
}

/// KVLCC2 at full scale, at 15.5 knots.
fn tanker() -> MainDimensions {
    MainDimensions { speed_m_s: Some(7.97), ..dimensions(320.0, 58.0, 20.8, 0.81) }
}

/// The Mariner at 15 knots.
fn cargo() -> MainDimensions {
    MainDimensions { speed_m_s: Some(7.7175), ..dimensions(160.93, 23.17, 8.23, 0.6) }
}

fn channels() -> Vec<Channel> {
    let channel =
        |name: &str, unit: &str, range| Channel { name: name.into(), unit: unit.into(), range: Some(range) };
    vec![channel("delta", "rad", [-0.62, 0.62]), channel("n", "1/s", [0.0, 50.0])]
}

/// States and headings after each of many small steps, under a helm that is a function of the heading and its rate.
fn sailed(own: &MainDimensions, lengths: f64, helm: impl FnMut(f64, f64) -> f64) -> Vec<([f64; 3], f64)> {
    let guess = own.guess().unwrap();
    let forces = Forces::new(&guess.description, &channels()).unwrap();
    sailed_with(own, (&guess, &forces, &forces.nominal()), lengths, helm)
}

/// The same with the parameters `theta`.
fn sailed_with(
    own: &MainDimensions,
    (guess, forces, theta): (&Guess, &Forces, &[f64]),
    lengths: f64,
    mut helm: impl FnMut(f64, f64) -> f64,
) -> Vec<([f64; 3], f64)> {
    let speed = guess.description.ship.speed_m_s;
    let body = forces.body(theta);
    let step = 0.005 * own.length_m / speed;
    let rate = own.rudder_rate_deg_s.unwrap_or(2.32).to_radians() * step;
    let (mut state, mut heading, mut rudder) = ([speed, 0.0, 0.0], 0.0, 0.0_f64);
    let one = |_| {
        rudder += (helm(heading, state[2]) - rudder).clamp(-rate, rate);
        let next = body.step_held(state, &[rudder, guess.revolutions], step);
        heading += 0.5 * step * (state[2] + next[2]);
        state = next;
        (state, heading)
    };
    (0..(lengths / 0.005) as usize).map(one).collect()
}

/// Advance and tactical diameter of a turn with 35° of rudder, in lengths, and speed at its end over that before.
fn turn(own: &MainDimensions) -> [f64; 3] {
    let all = sailed(own, 20.0, |_, _| 35.0_f64.to_radians());
    let speed = own.guess().unwrap().description.ship.speed_m_s;
    let step = 0.005 / speed;
    let (mut place, mut advance, mut diameter) = ([0.0; 2], None, None);
    for ([u, v, _], heading) in &all {
        let (sine, cosine) = heading.sin_cos();
        place[0] += step * (u * cosine - v * sine);
        place[1] += step * (u * sine + v * cosine);
        if *heading >= 90.0_f64.to_radians() {
            advance = advance.or(Some(place[0]));
        }
        if *heading >= 180.0_f64.to_radians() {
            diameter = diameter.or(Some(place[1]));
        }
    }
    [advance.unwrap(), diameter.unwrap(), all.last().unwrap().0[0] / speed]
}

/// First and second overshoot of a zig-zag \[°\].
fn zigzag(own: &MainDimensions, degrees: f64) -> [f64; 2] {
    let angle = degrees.to_radians();
    let (mut side, mut overshoots, mut most) = (1.0, Vec::new(), 0.0_f64);
    sailed(own, 40.0, |heading, _| {
        most = most.max(-side * heading);
        if side * heading >= angle {
            overshoots.push(most.to_degrees() - degrees);
            (side, most) = (-side, 0.0);
        }
        side * angle
    });
    [overshoots[1], overshoots[2]]
}

/// KVLCC2's model of 7 m, as her free runs were sailed.
fn model() -> MainDimensions {
    // The rate is that of a ship of 320 m, at the model's scale.
    let own = dimensions(7.0, 1.2688, 0.455, 0.81);
    MainDimensions { speed_m_s: Some(1.179), density_kg_m3: 1000.0, rudder_rate_deg_s: Some(15.7), ..own }
}

/// Another simulation of the same formulas, and what was measured of the model: of her the guess has less overshoot.
#[test]
fn oracle_figures_of_kvlcc2s_model() {
    let [advance, diameter, speed] = turn(&model());
    assert!((advance - 3.05).abs() < 0.1 && (diameter - 2.93).abs() < 0.15, "{advance} {diameter}");
    assert!((advance / 3.05 - 1.0).abs() < 0.3 && (diameter / 3.20 - 1.0).abs() < 0.3, "measured");
    let [[first, second], [third, fourth]] = [10.0, 20.0].map(|degrees| zigzag(&model(), degrees));
    let off = [first - 5.0, second - 7.9, third - 10.9, fourth - 12.9];
    assert!(off.iter().all(|off| off.abs() < 1.0), "{first} {second} {third} {fourth}; {speed}");
}

#[test]
fn law_a_guessed_ship_turns_and_checks_as_ships_do() {
    for own in [tanker(), cargo()] {
        let [advance, diameter, speed] = turn(&own);
        // IMO MSC.137(76): 4.5 and 5 lengths, and overshoots of 25° at most.
        let found = [advance, diameter, speed];
        assert!(advance < 4.5 && diameter < 5.0 && (0.2..0.7).contains(&speed), "{found:?}");
        let overshoots = zigzag(&own, 20.0);
        assert!(overshoots.iter().all(|own| (3.0..25.0).contains(own)), "{overshoots:?}");
    }
}

/// Ships of many proportions whose parameters are drawn from their priors: all turn, and none runs away.
#[test]
fn law_draws_of_guessed_ships_can_be_steered() {
    let streams = Streams::new(1, "guessed ships");
    let (mut draws, mut dead) = (0, Vec::new());
    for ship in 0..40 {
        let mut unit =
            streams.choices(ship, 0, 1 << 20, 4).into_iter().map(|draw| f64::from(draw) / 1048576.0);
        let mut between = |low: f64, high: f64| low + (high - low) * unit.next().unwrap();
        let length = 5.0 * (80.0_f64).powf(between(0.0, 1.0));
        let beam = length / between(3.2, 9.5);
        let own = dimensions(length, beam, beam / between(2.0, 4.0), between(0.4, 0.85));
        let guess = own.guess().unwrap();
        let forces = Forces::new(&guess.description, &channels()).unwrap();
        let speed = guess.description.ship.speed_m_s;
        for draw in 0..10 {
            let mut normals = vec![0.0; forces.parameters().len()];
            streams.normals(ship, 100 + draw, &mut normals);
            let drawn = forces.parameters().iter().zip(normals).map(|(parameter, normal)| {
                let [low, high] = parameter.bounds;
                (parameter.nominal + parameter.prior.unwrap_or(0.0) * normal).clamp(low, high)
            });
            let theta: Vec<f64> = drawn.collect();
            let all = sailed_with(&own, (&guess, &forces, &theta), 25.0, |_, _| 35.0_f64.to_radians());
            let is_held = |([u, v, r], _): &([f64; 3], f64)| {
                u.abs() < 3.0 * speed && v.abs() < 3.0 * speed && r.abs() < 6.0 * speed / length
            };
            let has_turned = all.iter().any(|(_, heading)| *heading > std::f64::consts::PI);
            draws += 1;
            if !(all.iter().all(is_held) && has_turned) {
                dead.push(format!("{own:?}"));
            }
        }
    }
    assert!(dead.len() * 100 <= draws, "{} of {draws}: {dead:#?}", dead.len());
}

#[test]
fn law_a_guessed_ship_holds_her_speed() {
    for own in
        [tanker(), cargo(), MainDimensions { speed_m_s: Some(1.179), ..dimensions(7.0, 1.27, 0.455, 0.81) }]
    {
        let guess = own.guess().unwrap();
        let forces = Forces::new(&guess.description, &channels()).unwrap();
        let speed = guess.description.ship.speed_m_s;
        let theta = forces.nominal();
        let found = forces.body(&theta).accelerations([speed, 0.0, 0.0], &[0.0, guess.revolutions]);
        assert!(found.iter().all(|own| own.abs() < 1e-12), "{found:?}");
    }
}

/// Those of KVLCC2's bare hull in the prime system of ½ρLd: Y_v, Y_r, N_v, N_r.
#[test]
fn oracle_published_derivatives_lie_within_the_intervals() {
    let description = tanker().guess().unwrap().description;
    let terms = [&description.sway[1], &description.sway[2], &description.yaw[1], &description.yaw[2]];
    for (term, published) in terms.into_iter().zip([-0.315, 0.083, -0.137, -0.049]) {
        let (found, deviation) = (term.prime.unwrap(), term.prior.unwrap());
        let off = (found - published).abs();
        assert!(off < 2.0 * deviation, "{}: {found} {published}", term.parameter);
    }
}

#[test]
fn oracle_linear_terms_at_kvlcc2() {
    // Means by hand of the three regressions, with B/d = 2.7885, B/L = 0.18125, d/L = 0.065.
    let description = tanker().guess().unwrap().description;
    let terms = [&description.sway[1], &description.sway[2], &description.yaw[1], &description.yaw[2]];
    let expected = [
        (-0.388_70 - 0.409_73 - 0.307_68) / 3.0,
        (0.086_25 + 0.093_41 + 0.090_77) / 3.0,
        (-0.133_96 - 0.13 - 0.139_23) / 3.0,
        (-0.052_53 - 0.053_3 - 0.043_38) / 3.0,
    ];
    for (term, expected) in terms.into_iter().zip(expected) {
        let found = term.prime.unwrap();
        assert!((found - expected).abs() < 3e-4, "{}: {found} {expected}", term.parameter);
    }
}

#[test]
fn dimensions_that_no_ship_has_are_refused_by_name() {
    let good = tanker();
    for (own, words) in [
        (MainDimensions { block: 1.2, ..good }, "block coefficient"),
        (MainDimensions { beam_m: 400.0, ..good }, "beam"),
        (MainDimensions { beam_m: f64::NAN, ..good }, "beam"),
        (MainDimensions { draught_m: 60.0, ..good }, "draught"),
        (MainDimensions { length_m: -1.0, ..good }, "length"),
        (MainDimensions { speed_m_s: Some(40.0), ..good }, "speed"),
        (MainDimensions { mass_kg: Some(1e8), ..good }, "mass"),
        (MainDimensions { propeller_diameter_m: Some(30.0), ..good }, "propeller"),
        (MainDimensions { rudder_area_m2: Some(1.0), ..good }, "rudder's area"),
        (MainDimensions { density_kg_m3: 1.0, ..good }, "density"),
    ] {
        let refused = own.guess().unwrap_err();
        assert!(refused.thing.contains(words), "{refused}");
    }
}

#[test]
fn law_guessed_ships_are_ships_and_those_of_usual_proportions_are_usual() {
    let mut guessed = 0;
    for length in [0.3, 7.0, 100.0, 600.0] {
        for [by_beam, by_draught] in
            [[2.6, 1.3], [5.0, 2.0], [6.0, 2.5], [8.5, 4.4], [11.9, 1.3], [11.9, 7.9]]
        {
            for block in [0.31, 0.5, 0.65, 0.84, 0.94] {
                let beam = length / by_beam;
                let Ok(guess) = dimensions(length, beam, beam / by_draught, block).guess() else { continue };
                let forces = Forces::new(&guess.description, &channels()).unwrap();
                let gate = |accepted| forces.gate(&forces.nominal(), accepted);
                gate(true).unwrap_or_else(|e| panic!("{length} {by_beam} {by_draught} {block}: {e}"));
                let is_usual = (5.0..=8.5).contains(&by_beam) && (0.5..0.9).contains(&block);
                if is_usual && by_draught < 4.0 {
                    gate(false).unwrap_or_else(|e| panic!("{length} {by_beam} {by_draught} {block}: {e}"));
                }
                guessed += 1;
            }
        }
    }
    assert!(guessed > 70, "{guessed}");
}
