use files::{Columns, Document, Units};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::DegreeOfFreedom;
use validation::comparison::{
    Bands, Compared, ComparedModel, Difference, ErrorCorrelations, Outside, Spread, Traced, Validity,
};

/// `compare.json`: a model beside others on recordings that it was not fitted to.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CompareDocument {
    /// Name of the vessel.
    pub vessel: String,
    /// Length of the windows \[s\]; null: whole runs.
    pub window_s: Option<f64>,
    /// Number of windows that were simulated.
    pub windows: u64,
    /// Their samples.
    pub samples: u64,
    /// Standard deviations of the measured states over the windows.
    pub std_u: f64,
    /// Of sway speed.
    pub std_v: f64,
    /// Of yaw rate.
    pub std_r: f64,
    /// The verdict first, then what to know, in words.
    pub statements: Vec<String>,
    /// The model, then what it is compared with.
    pub models: Vec<ComparedModel>,
    /// The others against the model.
    pub differences: Vec<Difference>,
    /// Shares of the samples inside the model's 95 % bands; null where its errors are not known.
    pub bands: Option<Bands>,
    /// How far the models of an average are apart; absent for a single model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<Spread>,
    /// Channels that leave the range that the model was fitted on.
    pub outside: Vec<Outside>,
    /// How the model's errors correlate with themselves and with inputs: where they do beyond chance, it lacks something.
    pub correlations: Vec<ErrorCorrelations>,
    /// Where the ship moves less or more than in any stretch that the model was fitted to; null where that is not known.
    #[serde(default)]
    pub validity: Option<Validity>,
}

impl CompareDocument {
    /// The result over windows of `window_s` seconds.
    pub fn new(vessel: &str, window_s: Option<f64>, found: &Compared) -> Self {
        let [std_u, std_v, std_r] = found.std;
        Self {
            vessel: vessel.to_owned(),
            window_s,
            windows: found.windows,
            samples: found.samples,
            std_u,
            std_v,
            std_r,
            statements: found.statements.clone(),
            models: found.models.clone(),
            differences: found.differences.clone(),
            bands: found.bands,
            spread: found.spread,
            outside: found.outside.clone(),
            correlations: found.correlations.clone(),
            validity: found.validity.clone(),
        }
    }
}

impl Document for CompareDocument {
    const ID: &'static str = "compare";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        (
            "1",
            "windows diverged samples error_norm pairs median interval share stretches below above inside_u inside_v inside_r",
        ),
        ("1", "bound own crossed models"),
        ("s", "window_s stretch_s"),
        ("m/s", "std_u std_v rmse_u rmse_v bias_u bias_v spread_u spread_v"),
        ("rad/s", "std_r rmse_r bias_r spread_r"),
        ("%", "fit_u fit_v fit_r"),
        ("the channel's unit", "low high"),
    ];
}

/// The table of the model over time: one row per sample of a window.
pub fn traces() -> Columns<Traced> {
    let columns = Columns::<Traced>::new("compare", 1)
        .text("source", |r| &r.source, |r, source| r.source = source.to_owned())
        .integer("window", "1", |r| r.window, |r, window| r.window = window)
        .number("t", "s", |r| r.t, |r, t| r.t = t);
    let state = |columns: Columns<Traced>, degree: DegreeOfFreedom| {
        let (d, state, unit) = (degree as usize, degree.state(), degree.unit());
        columns
            .number(format!("y_{state}"), unit, move |r| r.measured[d], move |r, y| r.measured[d] = y)
            .number(state, unit, move |r| r.simulated[d], move |r, x| r.simulated[d] = x)
            .optional(format!("half_{state}"), unit, move |r| r.half[d], move |r, half| r.half[d] = half)
    };
    DegreeOfFreedom::ALL.into_iter().fold(columns, state)
}
