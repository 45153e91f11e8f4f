//! What a chain of instruments logs, and that `assemble` gets the motion back from it.

use logs::chain::{
    Actuator, Chain, Commanded, Compass, Drift, Gnss, Hull, Key, Logged, Recording, Weather, Wind,
};
use logs::{Channels, Conventions, Law, Method, Propulsor, Series, assemble, body_velocity};
use maneuver::Generator;
use ship::engine::Helm;
use ship::model::{Source, Vessel, VesselFile};

use crate::declared;

const RATE_HZ: f64 = 8.0;

fn ship() -> Vessel {
    let file: VesselFile = toml::from_str("preset = \"ljungberg-model-ship\"").unwrap();
    Vessel::from_file(file).unwrap()
}

fn actuator(y: f64) -> Actuator {
    Actuator {
        position_m: [-0.4, y],
        coefficient: 1.44,
        law: Law::Quadratic,
        speed_limit_rps: None,
        speed_rate_limit_rps_s: None,
        angle_rate_limit_rad_s: None,
        speed_std_rps: 0.0,
        speed_resolution_rps: 0.0,
        angle_std_rad: 0.0,
        angle_resolution_rad: 0.0,
        logged: Logged::Setting,
    }
}

/// A slalom: forces in the model's units.
fn slalom(rows: usize) -> Vec<[f64; 3]> {
    let force = |k: usize| {
        let turn = 250.0 * (0.08 * k as f64).sin();
        [4000.0 + 10.0 * k as f64, -2.5 * turn + 100.0, turn]
    };
    (0..rows).map(force).collect()
}

struct Setup {
    vessel: Vessel,
    parameters: Vec<f64>,
    actuators: Vec<Actuator>,
    position_std_m: f64,
    heading_std_rad: f64,
}

impl Setup {
    fn new(position_std_m: f64, heading_std_rad: f64) -> Self {
        let vessel = ship();
        let parameters = vessel.parameters(Source::Value).unwrap();
        let actuators = vec![actuator(-0.1), actuator(0.1)];
        Self { vessel, parameters, actuators, position_std_m, heading_std_rad }
    }

    fn record(&self, key: Key, weather: &Weather) -> Recording {
        let helm = Helm::table(&slalom(200).concat());
        let commanded = Commanded { helm, is_mirrored: false, initial: [0.8, 0.0, 0.0], samples: 200 };
        self.sail(key, &commanded, weather)
    }

    fn sail(&self, key: Key, commanded: &Commanded, weather: &Weather) -> Recording {
        let chain = Chain {
            model: &self.vessel.model,
            parameters: &self.parameters,
            rate_hz: RATE_HZ,
            units: [1.0; 3],
            actuators: &self.actuators,
            gnss: Gnss {
                rate_hz: 8.0,
                white_std_m: self.position_std_m,
                wander_std_m: 0.0,
                wander_time_s: None,
                resolution_m: 0.0,
            },
            compass: Compass {
                white_std_rad: self.heading_std_rad,
                wander_std_rad: 0.0,
                wander_time_s: None,
                resolution_rad: 0.0,
            },
            hull: Some(Hull {
                frontal_area_m2: 0.5,
                lateral_area_m2: 1.0,
                length_m: 1.0,
                c_x: 0.7,
                c_y: 0.8,
                c_n: 0.1,
            }),
            scatter_std: 0.0,
            course_rad: None,
        };
        chain.record(key, commanded, weather, 0).unwrap()
    }
}

const KEY: Key = Key { seed: 4, maneuver: "slalom", repeat: 2 };

fn weather() -> Weather {
    Weather {
        current: Drift { north_m_s: 0.1, east_m_s: -0.05, std_m_s: 0.03, time_s: Some(2.0) },
        wind: Some(Wind { speed_m_s: 4.0, from_rad: 1.0, gust_std_m_s: 0.5, gust_time_s: Some(3.0) }),
    }
}

/// The recording as `ingest` would put it on one clock, with Euler differences and the azimuth map.
fn back(recording: &Recording, actuators: &[Actuator]) -> logs::Assembled {
    let t: Vec<f64> = (0..recording.heading.len()).map(|k| k as f64 / RATE_HZ).collect();
    let series = |values: Vec<f64>| Series::new(&t, &values, 0.5);
    let mut channels = Channels::new();
    let coordinate = |i: usize| recording.fixes.iter().map(|fix| fix.unwrap()[i]).collect::<Vec<_>>();
    channels.insert("x".into(), series(coordinate(0)));
    channels.insert("y".into(), series(coordinate(1)));
    channels.insert("psi".into(), series(recording.heading.clone()).unwrapped());
    let mut thrusters = Vec::new();
    for (i, actuator) in actuators.iter().enumerate() {
        let of = |f: &dyn Fn(logs::Setting) -> f64| recording.settings.iter().map(|s| f(s[i])).collect();
        channels.insert(format!("n{i}"), series(of(&|s| s.n)));
        channels.insert(format!("alpha{i}"), series(of(&|s| s.alpha)).unwrapped());
        let (speed, angle) = (format!("n{i}"), Some(format!("alpha{i}")));
        thrusters.push(Propulsor { thruster: actuator.thruster(), speed, angle, table: None });
    }
    let conventions = Conventions { thrusters, ..declared::conventions(Method::Euler, RATE_HZ) };
    assemble(channels, &conventions, &["tau1", "tau2", "tau3"], &[]).unwrap()
}

#[test]
fn law_a_log_of_commands_runs_ahead_of_the_settings_of_a_slow_thruster_of_the_same_motion() {
    /// Slower than the slalom needs.
    const RATE: f64 = 0.02;
    let mut setup = Setup::new(0.0, 0.0);
    setup.actuators.iter_mut().for_each(|own| own.speed_rate_limit_rps_s = Some(RATE));
    let settings = setup.record(KEY, &weather());
    setup.actuators.iter_mut().for_each(|own| own.logged = Logged::Command);
    let commands = setup.record(KEY, &weather());
    assert_eq!((&settings.truth, &settings.heading), (&commands.truth, &commands.heading));
    assert!(settings.hits.iter().all(|hits| hits.speed_rate > 20), "{:?}", settings.hits);
    let mut late = 0;
    for (thruster, _) in setup.actuators.iter().enumerate() {
        for k in 0..settings.settings.len() {
            let reached = settings.settings[k][thruster].n;
            assert!((reached - settings.truth.settings[k][thruster].n).abs() < 1e-12);
            let wanted = commands.settings[k][thruster].n;
            let before = if k == 0 { wanted } else { settings.settings[k - 1][thruster].n };
            // From where it was towards the command, by as much as it can in a sample.
            let step = (wanted - before).clamp(-RATE / RATE_HZ, RATE / RATE_HZ);
            assert!((before + step - reached).abs() < 1e-9, "{k}: {before}, {wanted}, {reached}");
            late += usize::from((wanted - reached).abs() > 1e-9);
        }
    }
    assert!(late > 20, "{late}");
}

#[test]
fn law_without_noise_the_logs_give_forces_and_velocities_back() {
    let setup = Setup::new(0.0, 0.0);
    let recording = setup.record(KEY, &weather());
    let made = back(&recording, &setup.actuators);
    let exogenous: Vec<Vec<f64>> = made.exogenous.iter().map(|channel| channel.to_vec()).collect();
    let measured = made.measured.each_ref().map(|channel| channel.to_vec());
    let truth = &recording.truth;
    let dt = 1.0 / RATE_HZ;
    for k in 0..made.grid.rows - 1 {
        for (d, force) in exogenous.iter().enumerate() {
            let wanted = slalom(200)[k][d];
            assert!((force[k] - wanted).abs() < 1e-9 * 5000.0, "force {d} at {k}");
        }
        // An Euler difference is the mean over the step: with even change, half of what the step adds, seen from the heading
        // at its start; what is left is of second order in the step.
        let [now, next] = [truth.states[k], truth.states[k + 1]];
        let turned = body_velocity([now[0], now[1]], -0.5 * now[2] * dt);
        let mean = [
            turned[0] + 0.5 * (next[0] - now[0]),
            turned[1] + 0.5 * (next[1] - now[1]),
            0.5 * (now[2] + next[2]),
        ];
        for d in 0..3 {
            let error = (measured[d][k] - mean[d]).abs();
            assert!(error < 2e-3, "state {d} at {k}: {error}");
            let euler = (measured[d][k] - now[d]).abs();
            let bound = (0..3).map(|d| (next[d] - now[d]).abs()).sum::<f64>() + 1.3 * now[2].abs() * dt;
            assert!(euler <= bound + 1e-9, "state {d} at {k}: {euler} above {bound}");
        }
    }
}

#[test]
fn law_noise_of_positions_is_that_of_the_receiver() {
    let (quiet, noisy) = (Setup::new(0.0, 0.0), Setup::new(0.02, 0.01));
    let (without, with) = (quiet.record(KEY, &weather()), noisy.record(KEY, &weather()));
    assert_eq!(without.truth, with.truth);
    let errors: Vec<f64> = (0..200)
        .flat_map(|k| [0, 1].map(|i| with.fixes[k].unwrap()[i] - without.fixes[k].unwrap()[i]))
        .collect();
    let std = (errors.iter().map(|e| e * e).sum::<f64>() / 400.0).sqrt();
    assert!((std / 0.02 - 1.0).abs() < 0.15, "{std}");
}

#[test]
fn law_a_recording_depends_on_its_own_key_alone() {
    let setup = Setup::new(0.01, 0.005);
    let of = |key: Key| setup.record(key, &weather());
    let found = of(KEY);
    assert_eq!(found, of(KEY));
    for key in [Key { seed: 5, ..KEY }, Key { repeat: 1, ..KEY }, Key { maneuver: "slalom2", ..KEY }] {
        let other = of(key);
        assert_ne!(other.fixes, found.fixes, "{key:?}");
        assert_ne!(other.truth.states, found.truth.states, "{key:?}");
    }
    // Another sensor's noise leaves the others' alone, and so does other weather.
    let more = Setup::new(0.01, 0.02).record(KEY, &weather());
    assert_eq!(more.fixes, found.fixes);
    assert_ne!(more.heading, found.heading);
    let calm = setup.record(KEY, &Weather::default());
    let noise = |r: &Recording, k: usize| r.fixes[k].unwrap()[0] - r.truth.poses[k].x;
    for k in 0..200 {
        assert!((noise(&calm, k) - noise(&found, k)).abs() < 1e-12);
    }
}

#[test]
fn law_logged_zig_zags_go_over_where_the_heading_is_reached_to_either_side() {
    let setup = Setup::new(0.0, 0.0);
    let text = "[[maneuver]]\nname = \"zig-zag\"\nkind = \"zig-zag-test\"\nspeed_m_s = 0.8\nduration_s = 60.0\n\
                helm = { tau3 = 600.0 }\nheading_rad = 0.35\n";
    let generator = Generator::without_tables(&setup.vessel, &toml::from_str(text).unwrap()).unwrap();
    let realized = generator.realize(0, 480).unwrap();
    for is_mirrored in [false, true] {
        let helm = realized.helm.clone().unwrap();
        let commanded = Commanded { helm, is_mirrored, initial: realized.initial, samples: 480 };
        let truth = setup.sail(KEY, &commanded, &weather()).truth;
        let side = if is_mirrored { -1.0 } else { 1.0 };
        let heading = |k: usize| side * (truth.poses[k].psi - truth.poses[0].psi);
        let torque = |k: usize| side * truth.forces[k][2];
        assert!(torque(0) > 599.0, "{}", torque(0));
        let over: Vec<usize> = (1..480).filter(|k| torque(k - 1) > 0.0 && torque(*k) < 0.0).collect();
        assert!(over.len() >= 2, "{over:?}");
        // Within the sample before it; the current turns the ship, too.
        over.iter().for_each(|k| assert!((heading(*k) - 0.35).abs() < 0.1, "{k}: {}", heading(*k)));
    }
}
