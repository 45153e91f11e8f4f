//! Starts of searches for the levels of a kind.

use super::kind::{Guess, NoiseKind};
use super::line::Line;

/// Statistics of runs before any search.
pub(super) struct Seen {
    /// Differences of neighbouring samples beyond steady change: u, v, r.
    pub rough: [f64; 3],
    /// Errors of free simulations.
    pub errors: [f64; 3],
    /// Root mean square of the measured states.
    pub motion: [f64; 3],
}

/// Times that are tried first \[s\].
const TIMES: [f64; 4] = [3.0, 12.0, 50.0, 300.0];

impl Seen {
    pub fn of(lines: &[Line]) -> Self {
        let (mut rough, mut errors, mut motion) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let (mut windows, mut samples) = (0.0, 0.0);
        for line in lines {
            let rows = line.run.measured.as_chunks::<3>().0;
            for row in rows.windows(3) {
                (0..3).for_each(|d| rough[d] += (row[2][d] - 2.0 * row[1][d] + row[0][d]).powi(2) / 6.0);
                windows += 1.0;
            }
            let own = line.errors();
            (0..3).for_each(|d| errors[d] += own[d] * own[d] * line.points.len() as f64);
            rows.iter().for_each(|row| (0..3).for_each(|d| motion[d] += row[d] * row[d]));
            samples += line.points.len() as f64;
        }
        let root = |sums: [f64; 3], count: f64| sums.map(|sum| (sum / f64::max(count, 1.0)).sqrt());
        Self { rough: root(rough, windows), errors: root(errors, samples), motion: root(motion, samples) }
    }

    /// Starts of a kind that does not begin at another one.
    pub fn starts(&self, kind: NoiseKind, rate_hz: f64) -> Vec<Guess> {
        let flow = libm::hypot(self.errors[0], self.errors[1]);
        let less = |share: f64| self.errors.map(|e| share * e);
        match kind {
            NoiseKind::White => {
                let noises = [self.rough, less(0.9)];
                each(&noises, &[0.03, 0.3, 1.0, 3.0], |noise, share| {
                    Guess::new(kind, &[&noise[..], &[share * flow]].concat())
                })
            }
            NoiseKind::Current => {
                let shares: Vec<[f64; 2]> =
                    TIMES.iter().flat_map(|time| [[0.3, *time], [1.2, *time]]).collect();
                each(&[self.rough, less(0.4)], &shares, |noise, [share, time]| {
                    Guess::new(kind, &[&noise[..], &[share * flow, time]].concat())
                })
            }
            NoiseKind::Forces | NoiseKind::ForcesEach => {
                // Errors that grow over a time are due to forces of about that time.
                let times = [0.5 / rate_hz, 2.0 / rate_hz, 2.0, 8.0, 30.0, 120.0];
                let shares: Vec<[f64; 2]> =
                    times.iter().flat_map(|time| [[0.02, *time], [0.1, *time]]).collect();
                each(&[self.rough, less(0.4)], &shares, |noise, [share, time]| {
                    Guess::new(kind, &[&noise[..], &less(share), &[time]].concat())
                })
            }
            NoiseKind::Sensors => {
                let shares: Vec<[f64; 2]> =
                    [1.0, 5.0, 20.0, 60.0, 200.0].iter().flat_map(|t| [[0.3, *t], [1.0, *t]]).collect();
                let noises = [self.rough, self.rough.map(|r| 0.3 * r)];
                each(&noises, &shares, |noise, [share, time]| {
                    Guess::new(kind, &[&noise[..], &less(share), &[time]].concat())
                })
            }
            NoiseKind::ForcesAndCurrent => Vec::new(),
        }
    }
}

fn each<T: Copy>(noises: &[[f64; 3]], others: &[T], guess: impl Fn([f64; 3], T) -> Guess) -> Vec<Guess> {
    noises.iter().flat_map(|noise| others.iter().map(|other| guess(*noise, *other))).collect()
}

/// Starts of a kind that begins at others, which were found before it.
pub(super) fn after(kind: NoiseKind, found: &[Guess]) -> Vec<Guess> {
    let of = |kind: NoiseKind| found.iter().find(|own| own.kind == kind);
    let forces = of(NoiseKind::Forces);
    let all = |guess: &Guess| (0..guess.kind.levels()).map(|i| guess.level(i)).collect::<Vec<f64>>();
    match (kind, forces, of(NoiseKind::Current)) {
        (NoiseKind::ForcesEach, Some(forces), _) => {
            let own = all(forces);
            let shares = [
                [1.0, 1.0, 1.0],
                [3.0, 1.0, 1.0],
                [1.0, 3.0, 1.0],
                [1.0, 1.0, 3.0],
                [0.3, 1.0, 1.0],
                [1.0, 0.3, 1.0],
                [1.0, 1.0, 0.3],
                [0.3, 1.0, 3.0],
            ];
            shares.map(|times| Guess::new(kind, &[&own[..6], &times.map(|t| t * own[6])].concat())).to_vec()
        }
        (NoiseKind::ForcesAndCurrent, Some(forces), Some(current)) => {
            let (f, c) = (all(forces), all(current));
            let noise = |i: usize| f[i].min(c[i]);
            let mixed = |force: f64, flow: f64, noise: [f64; 3]| {
                let pushed = [3, 4, 5].map(|i| force * f[i]);
                Guess::new(kind, &[&noise[..], &pushed, &[f[6], flow * c[3], c[4]]].concat())
            };
            let least = [0, 1, 2].map(noise);
            let [of_f, of_c] = [&f, &c].map(|own| [own[0], own[1], own[2]]);
            [
                mixed(1.0, 1.0, least),
                mixed(0.7, 0.7, least),
                mixed(1.0, 0.1, of_f),
                mixed(0.1, 1.0, of_c),
                mixed(0.5, 1.0, of_c),
                mixed(1.0, 0.5, of_f),
                mixed(0.3, 0.3, least),
                mixed(0.3, 0.7, least),
            ]
            .to_vec()
        }
        _ => Vec::new(),
    }
}
