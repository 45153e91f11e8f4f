use std::collections::BTreeMap;

use artifact::Document;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// `design.json`: how long to run each maneuver, and how good that is.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignDocument {
    /// `D`: log|det| of the information matrix.
    pub criterion: String,
    /// How the instruments' mean is removed: `none`, `batch` or `complete`.
    pub mean_removal: String,
    /// `optimal` (proved global), `stationary` (first-order optimal, not proved global) or `stalled`.
    pub status: String,
    /// The certificate in words.
    pub statement: String,
    /// Share of the experiment time per maneuver, in the dictionary's order; sums to 1.
    pub shares: BTreeMap<String, f64>,
    /// Maneuver names in the dictionary's order.
    pub order: Vec<String>,
    /// g_q = Σ_d tr(M_d(w)⁻¹ M_d,q): above `dimension` a maneuver is worth more time.
    pub sensitivities: BTreeMap<String, f64>,
    /// Total dimension p = Σ_q w_q g_q.
    pub dimension: u64,
    /// Kiefer–Wolfowitz gap max_q g_q − p.
    pub gap: f64,
    /// The gap divided by p.
    pub relative_gap: f64,
    /// Value of the criterion at the shares.
    pub log_det: f64,
    /// Whether the problem is concave, so that the gap bounds the distance to the global optimum.
    pub proved_global: bool,
    /// Equal shares first, then the random starts.
    pub starts: Vec<Start>,
    /// D-efficiency of other experiments of the same length against this one.
    pub efficiency: Efficiency,
    /// Whole segments, where `--segments` asked for them.
    pub counts: Option<BTreeMap<String, u64>>,
    /// About the counts.
    pub counted: Option<Counts>,
}

/// One start of the solver.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Start {
    /// `equal` or `random N`.
    pub name: String,
    /// Value of the criterion that it reached.
    pub log_det: f64,
    /// Its relative Kiefer–Wolfowitz gap.
    pub relative_gap: f64,
    /// Iterations of the solver.
    pub iterations: u64,
    /// Whether it reached the value of the best start to 1e-8 relative.
    pub agrees: bool,
}

/// D-efficiencies |det Γ(w)/det Γ(w*)|^(1/n_θ): the fraction of the experiment time that the optimal shares would
/// need for the same information.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Efficiency {
    /// Of equal shares.
    pub equal_shares: f64,
    /// Of every maneuver on its own (0: some direction is not excited at all).
    pub single: BTreeMap<String, f64>,
}

/// Whole segments that approximate the shares.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Number of segments.
    pub segments: u64,
    /// Samples per segment.
    pub segment_samples: u64,
    /// D-efficiency of the counts against the shares.
    pub efficiency: f64,
}

impl Document for DesignDocument {
    const ID: &'static str = "design";
    const VERSION: u32 = 1;
    const UNITS: &'static [(&'static str, &'static str)] = &[
        ("shares", "1"),
        ("sensitivities", "1"),
        ("dimension", "1"),
        ("gap", "1"),
        ("relative_gap", "1"),
        ("log_det", "1"),
        ("iterations", "1"),
        ("equal_shares", "1"),
        ("single", "1"),
        ("counts", "1"),
        ("segments", "1"),
        ("segment_samples", "1"),
        ("efficiency", "1"),
    ];
}
