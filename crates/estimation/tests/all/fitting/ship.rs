//! The tanker KVLCC2, and simulated recordings of hers.

use estimation::fitting::RecordingView;
use rand::SeedableRng;
use rand_xoshiro::Xoshiro256PlusPlus;
use ship::forces::{Channel, Description, Forces};

pub const KVLCC2: &str = include_str!("../../../../ship/presets/kvlcc2-l7.toml");

/// The forces of a `vessel.toml`.
pub fn forces(text: &str) -> Forces {
    let (description, channels) = parts(text);
    Forces::new(&description, &channels).unwrap()
}

/// The ship of a `vessel.toml`, and her inputs.
pub fn parts(text: &str) -> (Description, Vec<Channel>) {
    let mut table: toml::Table = text.parse().unwrap();
    let inputs = table.remove("input").unwrap();
    for key in ["name", "model", "sample_rate_hz"] {
        table.remove(key);
    }
    let channel = |own: &toml::Value| {
        let text = |key: &str| own[key].as_str().unwrap().to_owned();
        let range = own.get("range").map(|range| [0, 1].map(|i: usize| range[i].as_float().unwrap()));
        Channel { name: text("name"), unit: text("unit"), range }
    };
    let channels: Vec<Channel> = inputs.as_array().unwrap().iter().map(channel).collect();
    (table.try_into().unwrap(), channels)
}

/// A recording that owns its rows of rudder and revolutions, and of u, v, r.
pub struct Recorded {
    pub name: String,
    pub inputs: Vec<f64>,
    pub measured: Vec<f64>,
}

impl Recorded {
    pub fn recording(&self) -> RecordingView<'_> {
        RecordingView { name: &self.name, inputs: &self.inputs, measured: &self.measured }
    }
}

/// Numbers of mean 0 and variance 1.
pub struct Normals(Xoshiro256PlusPlus);

impl Normals {
    pub fn new(seed: u64) -> Self {
        Self(Xoshiro256PlusPlus::seed_from_u64(seed))
    }

    pub fn next(&mut self) -> f64 {
        let mut uniform = || rand::RngExt::random::<f64>(&mut self.0);
        (0..12).map(|_| uniform()).sum::<f64>() - 6.0
    }
}

/// A zig-zag of `seconds` with rudder and heading of `angle` \[rad\], sampled every `sample_s`, whose states have white noise
/// of these standard deviations.
pub fn zigzag(
    forces: &Forces,
    theta: &[f64],
    (angle, speed): (f64, f64),
    (seconds, sample_s): (f64, f64),
    noise: [f64; 3],
    normals: &mut Normals,
) -> Recorded {
    let body = forces.body::<f64>(theta);
    let (mut state, mut heading, mut side, mut rudder) = ([speed, 0.0, 0.0], 0.0, 1.0, 0.0);
    let (mut inputs, mut states) = (Vec::new(), vec![state]);
    let count = (seconds / sample_s).round() as usize;
    let row = |rudder: f64, k: usize| {
        let slow = (0.05 * k as f64 * sample_s).sin();
        [rudder, 11.85 * (speed / 1.179) * (1.0 + 0.1 * slow)]
    };
    let mut rows = Vec::new();
    for k in 0..=count {
        if side * heading > angle {
            side = -side;
        }
        let most = 0.2757 * sample_s;
        rudder += (side * angle - rudder).clamp(-most, most);
        rows.push(row(rudder, k));
        // The rudder's next angle is not known yet: headings are only to turn it.
        state = body.step(state, &rows[k], &rows[k], sample_s);
        heading += state[2] * sample_s;
    }
    state = states[0];
    for k in 0..count {
        inputs.extend(rows[k]);
        let end = if k + 1 < count { rows[k + 1] } else { rows[k] };
        state = body.step(state, &rows[k], &end, sample_s);
        states.push(state);
    }
    let measured = states.iter().flat_map(|own| [0, 1, 2].map(|d| own[d] + noise[d] * normals.next()));
    Recorded { name: format!("zigzag_{:.0}", angle.to_degrees()), inputs, measured: measured.collect() }
}

/// Eight zig-zags.
pub fn trial(forces: &Forces, theta: &[f64], sample_s: f64, noise: [f64; 3], seed: u64) -> Vec<Recorded> {
    let mut normals = Normals::new(seed);
    let angles = [5.0, 10.0, 15.0, 20.0, 25.0, 30.0, 35.0, 12.0_f64];
    let of = |(i, angle): (usize, &f64)| {
        let speed = [1.179, 0.9][i % 2];
        zigzag(forces, theta, (angle.to_radians(), speed), (200.0, sample_s), noise, &mut normals)
    };
    angles.iter().enumerate().map(of).collect()
}
