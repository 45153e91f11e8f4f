use super::bands::{Banded, Bands, Known};
use super::correlations::{ErrorCorrelations, error_correlations};
use super::covered::{Counter, Outside};
use super::simulated::{Contestant, Ship, Simulated, Trajectory};
use super::spread::{Spread, Spreads};
use super::standing::{ComparedModel, Difference};
use super::validity::{Magnitudes, Validity};
use super::verdict::{differences, verdict};
use crate::crossval::CrossError;
use identification::pooled::{Covered, deviations};
use regression::pooled::{Part, PooledRuns};

/// Options of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct CompareOptions<'a> {
    /// Length of the windows in samples; `None`: whole runs.
    pub window: Option<usize>,
    /// The estimated errors of the first model.
    pub known: Option<Known<'a>>,
    /// The ranges that the first model was fitted on.
    pub covered: &'a [Covered],
    /// The magnitudes of the motions that the first model was fitted to, if known.
    pub magnitudes: Option<&'a Magnitudes>,
    /// The sampling rate \[Hz\].
    pub rate_hz: f64,
}

/// The comparison of the models.
#[derive(Clone, Debug, PartialEq)]
pub struct Compared {
    /// Number of windows.
    pub windows: u64,
    /// Their samples.
    pub samples: u64,
    /// Standard deviations of the measured u, v, r over the windows.
    pub std: [f64; 3],
    /// One per contestant in their order, then the mean.
    pub models: Vec<ComparedModel>,
    /// The first model against the others.
    pub differences: Vec<Difference>,
    /// The spread of the models of an average; `None` for a single model.
    pub spread: Option<Spread>,
    /// Shares inside the bands; `None` if the model's errors are unknown.
    pub bands: Option<Bands>,
    /// Channels that leave the range that the model was fitted on.
    pub outside: Vec<Outside>,
    /// Correlations of the first model's errors with themselves and with inputs.
    pub correlations: Vec<ErrorCorrelations>,
    /// Stretches in which the ship moves less or more than in any that the model was fitted to; `None` if that is not
    /// known.
    pub validity: Option<Validity>,
    /// The verdict and remarks, in words.
    pub statements: Vec<String>,
    /// The first model over time.
    pub trace: Vec<Traced>,
}

/// A sample of the first model's simulation and of the measurement.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Traced {
    /// The run or recording.
    pub source: String,
    /// The window, from 0 in each recording.
    pub window: i32,
    /// Time in the window \[s\].
    pub t: f64,
    /// Measured u, v \[m/s\], r \[rad/s\].
    pub measured: [f64; 3],
    /// Simulated.
    pub simulated: [f64; 3],
    /// Half-width of the 95 % band, if known.
    pub half: [Option<f64>; 3],
}

/// Simulates all of `contestants` over `runs`; the first is the model under test.
///
/// # Errors
/// No run is as long as a window.
pub fn compare(
    contestants: &[Contestant],
    runs: &PooledRuns,
    options: &CompareOptions,
) -> Result<Compared, CrossError> {
    let mut sources: Vec<(String, Vec<Part>)> = runs.windows(options.window);
    sources.retain(|(_, windows)| !windows.is_empty());
    let windows = || sources.iter().flat_map(|(_, windows)| windows);
    let (Some(first), true) = (contestants.first(), windows().next().is_some()) else {
        return Err(CrossError::NoWindow);
    };
    let std = deviations(windows().map(|w| w.measured.as_slice()));
    let mut models: Vec<Simulated> = contestants.iter().map(|one| Simulated::of(one, &sources)).collect();
    models.push(Simulated::mean(&sources));
    let mut looked = Looked::new(first, options);
    looked.at(&sources, &models[0]);
    let compared: Vec<ComparedModel> = models.iter().map(|one| one.compared(&sources, std)).collect();
    let differences = differences(&compared, &models, std);
    let (bands, outside) = (looked.bands(), looked.counter.outside());
    let spread = looked.spreads.as_ref().and_then(Spreads::spread);
    let whole = runs.windows(None);
    let validity = options.magnitudes.and_then(|known| {
        let runs = whole.iter().flat_map(|(_, parts)| parts).map(Part::view);
        Validity::of(known, runs, options.rate_hz)
    });
    Ok(Compared {
        windows: windows().count() as u64,
        samples: windows().map(|w| w.samples() as u64).sum(),
        std,
        statements: verdict(
            &compared,
            &differences,
            (validity.as_ref(), &outside),
            (bands.as_ref(), spread.as_ref()),
        ),
        models: compared,
        differences,
        bands,
        spread,
        correlations: error_correlations(first, &sources, &models[0]),
        outside,
        validity,
        trace: looked.trace,
    })
}

/// The first model sample by sample.
struct Looked<'a> {
    banded: Option<Banded<'a>>,
    spreads: Option<Spreads>,
    counter: Counter<'a>,
    rate_hz: f64,
    trace: Vec<Traced>,
}

impl<'a> Looked<'a> {
    fn new(first: &Contestant, options: &CompareOptions<'a>) -> Self {
        let rmse = options.known.map(|known| known.rmse);
        let (banded, spreads) = match first.ships.as_slice() {
            [Ship { model, theta }] => (options.known.map(|known| Banded::new(model, theta, known)), None),
            several => (None, Some(Spreads::new(several.len(), rmse))),
        };
        let counter = Counter::new(options.covered);
        Self { banded, spreads, counter, rate_hz: options.rate_hz, trace: Vec::new() }
    }

    /// Shares of the samples inside the bands.
    fn bands(&self) -> Option<Bands> {
        self.banded.as_ref().and_then(Banded::shares).or_else(|| self.spreads.as_ref()?.bands())
    }

    fn at(&mut self, sources: &[(String, Vec<Part>)], found: &Simulated) {
        for ((source, windows), found) in sources.iter().zip(&found.windows) {
            for (i, (window, found)) in windows.iter().zip(found).enumerate() {
                let Some(Trajectory { states, spread }) = found else { continue };
                self.counter.add(&window.exogenous, states);
                let bands = match (&mut self.banded, &mut self.spreads) {
                    (Some(banded), _) => Some(banded.add(window, states)),
                    (None, Some(spreads)) => spreads.add(window, states, spread),
                    (None, None) => None,
                };
                let pairs = window.measured.as_chunks::<3>().0.iter().zip(states.as_chunks::<3>().0);
                self.trace.extend(pairs.enumerate().map(|(k, (measured, simulated))| Traced {
                    source: source.clone(),
                    window: i as i32,
                    t: k as f64 / self.rate_hz,
                    measured: *measured,
                    simulated: *simulated,
                    half: bands.as_ref().map_or([None; 3], |bands| bands[k].map(Some)),
                }));
            }
        }
    }
}
