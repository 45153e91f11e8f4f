use artifact::{Document, Units};
use identification::{Estimator, Share};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use validation::tally::{Bounds, Counted, QUANTILE_ERROR, ShareDifference, Tally};

use super::cells::{CellsDocument, SweepAxis, SweepCell, SweepLine};
use super::tally::TallyDocument;

/// `sweep.json`: what the cells of a grid say, side by side.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweepDocument {
    /// Folder of the study, seen from that of sweep.toml.
    pub study: String,
    /// What is varied.
    pub axes: Vec<SweepAxis>,
    /// The line that others are compared with; null where no cell was counted.
    pub baseline: Option<SweepLine>,
    /// Relative error of the medians at most: they are read from histograms.
    pub quantile_error: f64,
    /// The cells that were counted.
    pub cells: Vec<SweptCell>,
    /// The cells that were refused.
    pub refused: Vec<RefusedCell>,
    /// What it says, in words.
    pub statements: Vec<String>,
}

/// What a cell says.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweptCell {
    /// Name of the cell.
    pub cell: String,
    /// The place of its value on each axis, from 0.
    pub at: Vec<usize>,
    /// The bounds that shares are counted against.
    pub bounds: Bounds,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Line by line.
    pub lines: Vec<SweptLine>,
}

/// What a cell says of one design by one estimator.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SweptLine {
    /// The design.
    pub design: String,
    /// The estimator.
    pub estimator: Estimator,
    /// Runs.
    pub runs: u64,
    /// Share of the runs whose parameter error lies below its bound.
    pub parameter_error_share: Share,
    /// Share of the runs whose simulation error lies below its bound.
    pub simulation_error_share: Share,
    /// Share of the runs without an estimate.
    pub without_estimate_share: Share,
    /// Median of the parameter error; null where it is infinite.
    pub parameter_error_median: Option<f64>,
    /// 95 % interval of that median; null at an end that the runs do not bound.
    pub parameter_error_median_interval: [Option<f64>; 2],
    /// The share of the parameter error less that of the baseline in the same cell; null of the baseline itself.
    pub difference: Option<ShareDifference>,
}

/// A cell that was refused.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefusedCell {
    /// Name of the cell.
    pub cell: String,
    /// The place of its value on each axis, from 0.
    pub at: Vec<usize>,
    /// The refusal, in one line.
    pub refusal: String,
}

impl RefusedCell {
    /// A refused `cell`.
    pub fn new(cell: &SweepCell, refusal: String) -> Self {
        Self { cell: cell.name.clone(), at: cell.at.clone(), refusal }
    }
}

impl SweptCell {
    /// The result `tally` of `cell`, compared with `baseline`.
    pub fn new(cell: &SweepCell, tally: &TallyDocument, baseline: &SweepLine) -> Self {
        let line = |counted: &Counted| SweptLine::new(counted, &tally.tally, baseline);
        Self {
            cell: cell.name.clone(),
            at: cell.at.clone(),
            bounds: tally.bounds,
            seed: tally.seed,
            lines: tally.tally.counted.iter().map(line).collect(),
        }
    }
}

impl SweptLine {
    fn new(counted: &Counted, tally: &Tally, baseline: &SweepLine) -> Self {
        let share = |count: u64| Share::of(count as usize, counted.runs as usize);
        let median = &counted.parameter_error.histogram;
        Self {
            design: counted.design.clone(),
            estimator: counted.estimator,
            runs: counted.runs,
            parameter_error_share: share(counted.parameter_errors_below),
            simulation_error_share: share(counted.simulation_errors_below),
            without_estimate_share: share(counted.not_identifiable + counted.not_converged),
            parameter_error_median: median.quantile(0.5),
            parameter_error_median_interval: median.quantile_interval(0.5),
            difference: tally.difference(counted, (&baseline.design, baseline.estimator)),
        }
    }
}

impl SweepDocument {
    /// The sweep over the grid of `grid`, with its counted and refused cells.
    pub fn new(
        grid: &CellsDocument,
        baseline: Option<SweepLine>,
        cells: Vec<SweptCell>,
        refused: Vec<RefusedCell>,
    ) -> Self {
        let statements = statements(&cells, refused.len(), baseline.as_ref());
        Self {
            study: grid.study.clone(),
            axes: grid.axes.clone(),
            baseline,
            quantile_error: QUANTILE_ERROR,
            cells,
            refused,
            statements,
        }
    }

    /// Design and estimator of every line, in the order of the first cell that has it.
    pub fn lines(&self) -> Vec<SweepLine> {
        let mut lines: Vec<SweepLine> = Vec::new();
        for SweptLine { design, estimator, .. } in self.cells.iter().flat_map(|cell| &cell.lines) {
            let line = SweepLine { design: design.clone(), estimator: *estimator };
            if !lines.contains(&line) {
                lines.push(line);
            }
        }
        lines
    }
}

impl SweptCell {
    /// The result of `line`.
    pub fn line(&self, line: &SweepLine) -> Option<&SweptLine> {
        self.lines.iter().find(|own| own.design == line.design && own.estimator == line.estimator)
    }
}

fn statements(cells: &[SweptCell], refused: usize, baseline: Option<&SweepLine>) -> Vec<String> {
    let mut said = vec![format!("{} cells counted, {refused} refused.", cells.len())];
    let Some(baseline) = baseline else { return said };
    let mut seen: Vec<(&str, Estimator)> = Vec::new();
    for line in cells.iter().flat_map(|cell| &cell.lines).filter(|line| line.difference.is_some()) {
        if seen.contains(&(&line.design, line.estimator)) {
            continue;
        }
        seen.push((&line.design, line.estimator));
        let same = |other: &&SweptLine| other.design == line.design && other.estimator == line.estimator;
        let all = cells.iter().flat_map(|cell| cell.lines.iter().filter(same));
        let intervals: Vec<[f64; 2]> = all.filter_map(|line| Some(line.difference?.interval)).collect();
        let count = |holds: fn(&[f64; 2]) -> bool| intervals.iter().filter(|ends| holds(ends)).count();
        let (above, below) = (count(|[low, _]| *low > 0.0), count(|[_, high]| *high < 0.0));
        said.push(format!(
            "{}, {}: parameter error below its bound in more runs than {}, {} in {above} cells, in fewer in {below}, not to \
             be told apart in {}.",
            line.design,
            line.estimator,
            baseline.design,
            baseline.estimator,
            intervals.len() - above - below
        ));
    }
    said
}

impl Document for SweepDocument {
    const ID: &'static str = "sweep";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("1", "quantile_error at bounds.parameter_error seed runs share interval parameter_error_median"),
        ("1", "parameter_error_median_interval"),
        ("m/s, m/s and rad/s as numbers", "bounds.simulation_error"),
        ("that of the key", "values"),
    ];
}
