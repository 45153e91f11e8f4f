use numerics::{LANES, Lane, lanes};

use crate::fitting::Settings;

/// A recording, or a part of one without gaps: N samples.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Recording<'a> {
    /// Its name.
    pub name: &'a str,
    /// Inputs and measured disturbances, in the order of the ship's channels: N rows.
    pub inputs: &'a [f64],
    /// Measured u, v \[m/s\] and r \[rad/s\]: N + 1 rows.
    pub measured: &'a [f64],
}

impl Recording<'_> {
    /// Number of samples N.
    pub fn samples(&self) -> usize {
        (self.measured.len() / 3).saturating_sub(1)
    }
}

/// A part of a recording that is simulated by itself.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Window {
    pub recording: usize,
    pub first: usize,
    pub samples: usize,
}

/// All recordings in equal windows of at most the length that is set, longest first and otherwise in order.
pub(crate) fn windows(recordings: &[Recording], settings: &Settings) -> Vec<Window> {
    let most = settings.samples(settings.window_s);
    let mut all = Vec::new();
    for (recording, own) in recordings.iter().enumerate() {
        let samples = own.samples();
        let count = samples.div_ceil(most);
        for i in 0..count {
            let [first, end] = [i, i + 1].map(|i| i * samples / count);
            all.push(Window { recording, first, samples: end - first });
        }
    }
    all.sort_by_key(|window| std::cmp::Reverse(window.samples));
    all
}

/// Up to [`LANES`] windows side by side.
pub(crate) struct Group {
    /// Places of the windows, in order.
    pub windows: Vec<Window>,
    /// The longest of them.
    pub samples: usize,
    /// Rows of inputs before the first sample, for what follows them late.
    pub before: usize,
    /// Rows of inputs: `before`, then one for each sample, and the one after it.
    pub inputs: Vec<Lane>,
    /// Rows of measured states: one more than samples.
    pub measured: Vec<Lane>,
}

impl Group {
    /// Of `windows`, with rows of `width` inputs. Where a recording has no row, its nearest one counts.
    pub fn new(windows: &[Window], recordings: &[Recording], width: usize, before: usize) -> Self {
        let samples = windows.iter().map(|own| own.samples).max().unwrap_or(0);
        let lane = |of: &dyn Fn(&Window) -> f64| lanes::lane(windows.len(), |i| of(&windows[i]));
        let input = |k: usize, i: usize| {
            lane(&|own| {
                let recording = &recordings[own.recording];
                let row = (own.first + k).saturating_sub(before).min(recording.samples() - 1);
                recording.inputs[row * width + i]
            })
        };
        let state = |k: usize, d: usize| {
            lane(&|own| recordings[own.recording].measured[3 * (own.first + k.min(own.samples)) + d])
        };
        let rows = before + samples + 1;
        Self {
            samples,
            before,
            inputs: (0..rows * width).map(|at| input(at / width, at % width)).collect(),
            measured: (0..3 * (samples + 1)).map(|at| state(at / 3, at % 3)).collect(),
            windows: windows.to_vec(),
        }
    }

    /// All `windows` in groups.
    pub fn all(windows: &[Window], recordings: &[Recording], width: usize, before: usize) -> Vec<Self> {
        windows.chunks(LANES).map(|own| Self::new(own, recordings, width, before)).collect()
    }
}
