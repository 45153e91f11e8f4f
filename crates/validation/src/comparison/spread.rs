use numerics::statistics::Z;
use regression::pooled::Part;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::bands::{Bands, Inside};

/// How far the models of an average are apart.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Spread {
    /// Their number.
    pub models: u64,
    /// Root mean square over all samples of their standard deviation in u.
    pub spread_u: f64,
    /// In v.
    pub spread_v: f64,
    /// In r.
    pub spread_r: f64,
    /// Shares of the measured samples within 1.96 of these standard deviations of the average, sample by sample: small where
    /// models agree on what they all get wrong.
    pub inside_u: f64,
    /// Of v.
    pub inside_v: f64,
    /// Of r.
    pub inside_r: f64,
}

impl Spread {
    /// In words.
    pub fn statement(&self) -> String {
        let Self { models, spread_u, spread_v, spread_r, inside_u, inside_v, inside_r } = self;
        let [u, v, r] = [inside_u, inside_v, inside_r].map(|share| 100.0 * share);
        format!(
            "{models} models are averaged, which differ by a standard deviation of {spread_u:.3e} m/s in u, {spread_v:.3e} m/s in \
             v, {spread_r:.3e} rad/s in r; inside 1.96 of it alone: u {u:.1} %, v {v:.1} %, r {r:.1} % of the samples"
        )
    }
}

/// The bands of an average: from the spread of its models, and its errors on the recordings that they were fitted to.
pub(super) struct Spreads {
    models: usize,
    rmse: Option<[f64; 3]>,
    squares: [f64; 3],
    alone: Inside,
    together: Inside,
}

impl Spreads {
    /// The spreads of this number of `models`, whose average had errors of `rmse`.
    pub fn new(models: usize, rmse: Option<[f64; 3]>) -> Self {
        Self { models, rmse, squares: [0.0; 3], alone: Inside::default(), together: Inside::default() }
    }

    /// Half-widths of the bands over `window`, where `states` are the average and `spread` the models' standard
    /// deviations; `None` if the errors are not known.
    pub fn add(&mut self, window: &Part, states: &[f64], spread: &[f64]) -> Option<Vec<[f64; 3]>> {
        let rows = spread.as_chunks::<3>().0;
        for row in rows.iter().skip(1) {
            (0..3).for_each(|d| self.squares[d] += row[d] * row[d]);
        }
        let alone: Vec<[f64; 3]> = rows.iter().map(|row| row.map(|std| Z * std)).collect();
        self.alone.add(window, states, &alone);
        let rmse = self.rmse?;
        let with = |row: &[f64; 3]| [0, 1, 2].map(|d| Z * (row[d] * row[d] + rmse[d] * rmse[d]).sqrt());
        let bands: Vec<[f64; 3]> = rows.iter().map(with).collect();
        self.together.add(window, states, &bands);
        Some(bands)
    }

    /// The spread over all windows; `None` without samples.
    pub fn spread(&self) -> Option<Spread> {
        let [inside_u, inside_v, inside_r] = self.alone.shares()?;
        let [spread_u, spread_v, spread_r] =
            self.squares.map(|sum| (sum / self.alone.samples() as f64).sqrt());
        let models = self.models as u64;
        Some(Spread { models, spread_u, spread_v, spread_r, inside_u, inside_v, inside_r })
    }

    /// Shares inside the bands.
    pub fn bands(&self) -> Option<Bands> {
        self.together.shares().map(Bands::of)
    }
}
