/// What is known of a parameter before the fit, in its own system.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Prior {
    /// Its most probable value.
    pub mean: f64,
    /// Its standard deviation.
    pub deviation: f64,
}

/// Where the simulation of a window starts.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Starts {
    /// At a state of its own that is found with θ; the first measured sample then is one of many.
    #[default]
    Unknown,
    /// At the first measured sample, which counts as exact.
    Measured,
}

/// What inputs do between samples.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Inputs {
    /// Those of logs: they are linear between samples, and thrusters follow them late.
    #[default]
    Linear,
    /// Those of simulated runs: each row acts during its whole sample, as it is.
    Held,
}

/// How force models are fitted.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Settings {
    /// From one sample to the next \[s\].
    pub sample_s: f64,
    /// Longest window \[s\]; recordings are cut into equal ones.
    pub window_s: f64,
    /// RMS error of a window, in standard deviations, from which on it counts by its modulus, not its square.
    pub knee: f64,
    /// Weight of the priors: 1 as if half the measured numbers at 1 Hz were one.
    pub prior_weight: f64,
    /// Where windows start.
    pub starts: Starts,
    /// What inputs do between samples.
    pub inputs: Inputs,
    /// Length of the pieces that count as independent where standard errors are computed \[s\].
    pub piece_s: f64,
    /// Most steps of the search.
    pub most_steps: usize,
}

impl Settings {
    /// The usual ones for samples `sample_s` seconds apart.
    pub fn new(sample_s: f64) -> Self {
        Self {
            sample_s,
            window_s: 100.0,
            knee: 0.2,
            prior_weight: 1.0,
            starts: Starts::Unknown,
            inputs: Inputs::Linear,
            piece_s: 25.0,
            most_steps: 60,
        }
    }

    /// The number of samples in `seconds`, at least one.
    pub(crate) fn samples(&self, seconds: f64) -> usize {
        (seconds / self.sample_s).round().max(1.0) as usize
    }
}
