use std::cell::Cell;
use std::collections::{BTreeMap, BTreeSet};
use std::convert::Infallible;

use numerics::lanes::lane;
use numerics::least_squares::{Ended, Ending, Expansion, Linearization, Minimum, Residuals, minimize};
use numerics::{LANES, Lane, Watch, congruence, times};
use regression::jackknife;
use ship::engine::{RunView, SideBySide};
use ship::model::Model;

use super::linear::{ENDING, Linear, Unknown, Weighting, disturbed_scores, inverse, without};
use super::{EstimateErrors, FoundSpread, RunFit, Spread, fit};
use crate::sensitivity::{NoiseModel, Recordings, Sensitivities, groups, of_one_length, with_states};

/// Floor of the variances of output errors, as a share of the measured state's mean square, for data without noise.
const EXACT: f64 = 1e-12;

/// Steps after which unfinished searches are repacked into lanes, so that none waits for its neighbours.
const BRIEF: usize = 24;

/// Estimates every run by the errors of free simulations: minimises Σ_d N log Σ e_d², the likelihood of white errors
/// with separate variances in u, v and r, over the model's parameters (with or without intercepts) and, if requested,
/// the initial state and a current. With a current, standard errors use blocks, regardless of `spread`. Per run
/// `starts` holds starting parameters; if the first ones diverge or lead to no minimum, the next are used.
pub fn output_error(
    model: &Model,
    runs: &[RunView],
    starts: &[Vec<Vec<f64>>],
    unknown: impl Into<Unknown>,
    spread: Spread,
) -> Vec<RunFit> {
    let unknown = unknown.into();
    let best = vec![None; runs.len()];
    let mut searches = Searches { model, runs, unknown, best, workspace: WORKSPACE.take() };
    let from = |weighting: fn(&RunView) -> Weighting| {
        move |run: usize, i: usize| {
            Some(Try { run, weighting: weighting(&runs[run]), point: starts[run].get(i)?.clone() })
        }
    };
    let (likely, eased) = (from(likelihood), from(fixed));
    searches.attempt(BRIEF, |run, _| likely(run, 0));
    searches.attempt(ENDING.steps, |run, best| Try::likely(runs, run, best?));
    // Few runs are left, so all remedies are tried in lanes at once: their other starts, and fixed weights at first,
    // for runs in which one state is predicted so much better than the others that its weight blocks the search.
    let attempts = starts.iter().map(Vec::len).max().unwrap_or(0);
    let others = searches.open().flat_map(|run| (1..attempts).filter_map(move |i| likely(run, i)));
    let easier = searches.open().flat_map(|run| (0..attempts).filter_map(move |i| eased(run, i)));
    let (others, easier): (Vec<Try>, Vec<Try>) = (others.collect(), easier.collect());
    let mut minima = searches.minima(others.iter().chain(&easier), ENDING.steps);
    let begun = minima.split_off(others.len());
    searches.keep(&others, minima);
    let open: Vec<usize> = searches.open().collect();
    let begun = easier.iter().zip(begun).filter(|(start, _)| open.contains(&start.run));
    let after: Vec<Try> = begun.filter_map(|(from, at)| Try::likely(runs, from.run, &at)).collect();
    let minima = searches.minima(after.iter(), ENDING.steps);
    searches.keep(&after, minima);
    let fits = searches.fits(spread);
    WORKSPACE.set(searches.workspace);
    fits
}

/// Runs per search: enough to fill the lanes to the end, few enough for the processor's caches.
const TOGETHER: usize = 8 * LANES;

struct Try {
    run: usize,
    weighting: Weighting,
    point: Vec<f64>,
}

impl Try {
    fn likely(runs: &[RunView], run: usize, at: &Minimum<Linear>) -> Option<Self> {
        Some(Self { run, weighting: likelihood(&runs[run]), point: at.point.clone() })
    }
}

struct Searches<'a> {
    model: &'a Model,
    runs: &'a [RunView<'a>],
    unknown: Unknown,
    best: Vec<Option<Minimum<Linear>>>,
    workspace: Workspace,
}

impl Searches<'_> {
    fn open(&self) -> impl Iterator<Item = usize> + '_ {
        let is_open = |run: &usize| self.best[*run].as_ref().is_none_or(|b| b.status != Ended::Converged);
        (0..self.runs.len()).filter(is_open)
    }

    fn attempt(&mut self, steps: usize, start: impl Fn(usize, Option<&Minimum<Linear>>) -> Option<Try>) {
        let tries: Vec<Try> = self.open().filter_map(|run| start(run, self.best[run].as_ref())).collect();
        let minima = self.minima(tries.iter(), steps);
        self.keep(&tries, minima);
    }

    fn keep(&mut self, tries: &[Try], minima: Vec<Minimum<Linear>>) {
        for (start, minimum) in tries.iter().zip(minima) {
            let best = &mut self.best[start.run];
            *best = Some(match best.take() {
                Some(before) => better(before, minimum),
                None => minimum,
            });
        }
    }

    fn minima<'t>(&mut self, tries: impl Iterator<Item = &'t Try>, steps: usize) -> Vec<Minimum<Linear>> {
        let tries: Vec<&Try> = tries.collect();
        let runs: Vec<RunView> = tries.iter().map(|start| self.runs[start.run]).collect();
        let mut by_try = BTreeMap::new();
        for together in of_one_length(&runs, 0..runs.len(), TOGETHER) {
            let workspace = std::mem::take(&mut self.workspace);
            let mut search = LaneSearch {
                model: self.model,
                runs: together.iter().map(|i| runs[*i]).collect(),
                weighting: together.iter().map(|i| tries[*i].weighting).collect(),
                free: self.unknown.free(self.model),
                unknown: self.unknown,
                all: 0,
                some: 0,
                workspace,
            };
            let from = |i: &usize| {
                let mut point = tries[*i].point.clone();
                point.resize(search.free.len(), 0.0);
                point
            };
            let starts = together.iter().map(from).collect();
            let Ok(minima) = minimize(&mut search, starts, Ending { steps, ..ENDING }, &Watch::default());
            self.workspace = search.workspace;
            by_try.extend(together.into_iter().zip(minima));
        }
        by_try.into_values().collect()
    }

    /// The outcomes of the runs.
    fn fits(&mut self, spread: Spread) -> Vec<RunFit> {
        let mut fits = vec![RunFit::NotConverged(0); self.runs.len()];
        let mut kept = std::mem::take(&mut self.workspace.kept);
        let spread = if self.unknown.current.is_some() { Spread::Blocks } else { spread };
        let searched: Vec<usize> = (0..self.runs.len()).filter(|run| self.best[*run].is_some()).collect();
        for (group, runs) in groups(self.runs, searched.into_iter()) {
            let recordings = Recordings::of(self.model, &runs);
            let free = self.unknown.free(self.model);
            let minima: Vec<Minimum<Linear>> =
                group.iter().filter_map(|run| self.best[*run].take()).collect();
            let points: Vec<&Vec<f64>> = minima.iter().map(|minimum| &minimum.point).collect();
            let unknowns = side_by_side(&points, &free, recordings.unknowns());
            let problem = Simulations { recordings, unknowns, free, unknown: self.unknown };
            let weighting: Vec<Weighting> = group.iter().map(|run| likelihood(&self.runs[*run])).collect();
            if !matches!(spread, Spread::Blocks) {
                let Simulations { recordings, unknowns, free, unknown } = &problem;
                kept.follow(recordings, unknowns, free, unknown.start_counts());
            }
            let errors = problem.standard_errors(&group, &minima, &weighting, spread, &kept);
            for ((run, minimum), errors) in group.into_iter().zip(minima).zip(errors) {
                fits[run] = fit(&problem.recordings, &minimum, errors, self.unknown);
            }
        }
        self.workspace.kept = kept;
        fits
    }
}

/// Mean squares of the measured u, v, r, which errors are weighed by.
fn mean_squares(run: &RunView) -> [f64; 3] {
    [0, 1, 2].map(|d: usize| {
        let sum: f64 = run.measured.iter().skip(d).step_by(3).map(|y| y * y).sum();
        (sum / (run.samples() + 1) as f64).max(1e-12)
    })
}

fn likelihood(run: &RunView) -> Weighting {
    Weighting::Likelihood(mean_squares(run).map(|square| EXACT * square))
}

fn fixed(run: &RunView) -> Weighting {
    Weighting::Fixed(mean_squares(run).map(f64::recip))
}

pub(super) fn better(a: Minimum<Linear>, b: Minimum<Linear>) -> Minimum<Linear> {
    let rank = |m: &Minimum<Linear>| match m.status {
        Ended::Converged => 3,
        Ended::Stalled => 2,
        Ended::Singular(_) => 1,
        Ended::Diverged => 0,
    };
    if rank(&b) > rank(&a) { b } else { a }
}

/// One lane per unknown, up to the largest of the `free` ones, whose values are in the lanes' points.
pub(super) fn side_by_side(points: &[impl AsRef<[f64]>], free: &[usize], all: usize) -> Vec<Lane> {
    let mut unknowns = vec![Lane::ZERO; free.last().map_or(all, |last| all.max(last + 1))];
    for (place, unknown) in free.iter().enumerate() {
        unknowns[*unknown] =
            lane(points.len(), |run| points[run].as_ref().get(place).copied().unwrap_or(0.0));
    }
    unknowns
}

/// Runs of one length in one search: [`LANES`] of them at once, and lanes of finished runs are reused.
struct LaneSearch<'a> {
    model: &'a Model,
    runs: Vec<RunView<'a>>,
    weighting: Vec<Weighting>,
    free: Vec<usize>,
    unknown: Unknown,
    /// The number of groups of all runs, and of those with the last requested runs only; 0 if not packed yet.
    all: usize,
    some: usize,
    workspace: Workspace,
}

#[derive(Default)]
struct Workspace {
    all: Vec<Packed>,
    some: Vec<Packed>,
    kept: Sensitivities<Lane>,
}

thread_local! {
    static WORKSPACE: Cell<Workspace> = Cell::default();
}

#[derive(Default)]
struct Packed {
    runs: Vec<usize>,
    data: SideBySide,
}

impl LaneSearch<'_> {
    /// All groups, or, if these would leave many lanes empty, groups of the last requested runs.
    fn packed(&mut self, asked: &[Linearization]) -> &[Packed] {
        let wanted = asked.len().div_ceil(LANES);
        let enough = |packed: usize| 3 * wanted > 2 * packed;
        if self.all == 0 {
            self.all = pack(&self.runs, &(0..self.runs.len()).collect::<Vec<_>>(), &mut self.workspace.all);
        }
        if enough(self.all) {
            return &self.workspace.all[..self.all];
        }
        let there: BTreeSet<usize> =
            self.workspace.some[..self.some].iter().flat_map(|packed| packed.runs.iter().copied()).collect();
        if !enough(self.some) || !asked.iter().all(|request| there.contains(&request.problem)) {
            let wanted: Vec<usize> = asked.iter().map(|request| request.problem).collect();
            self.some = pack(&self.runs, &wanted, &mut self.workspace.some);
        }
        &self.workspace.some[..self.some]
    }
}

fn pack(runs: &[RunView], wanted: &[usize], workspace: &mut Vec<Packed>) -> usize {
    let count = wanted.len().div_ceil(LANES);
    workspace.resize_with(count.max(workspace.len()), Packed::default);
    for (chunk, packed) in wanted.chunks(LANES).zip(workspace) {
        packed.runs = chunk.to_vec();
        packed.data.fill(&chunk.iter().map(|run| runs[*run]).collect::<Vec<_>>());
    }
    count
}

impl Residuals<Linear> for LaneSearch<'_> {
    fn linearize(&mut self, asked: &[Linearization]) -> Result<Vec<(Expansion, Linear)>, Infallible> {
        let (model, unknown, free) = (self.model, self.unknown, self.free.clone());
        let by_run: BTreeMap<usize, &Linearization> = asked.iter().map(|r| (r.problem, r)).collect();
        let mut linears = BTreeMap::new();
        for Packed { runs, data } in self.packed(asked) {
            let Some(any) = runs.iter().find_map(|run| by_run.get(run)) else { continue };
            let recordings = Recordings::of(model, data);
            // Idle lanes repeat another lane's point.
            let points: Vec<&[f64]> =
                runs.iter().map(|run| by_run.get(run).unwrap_or(any).point.as_slice()).collect();
            let unknowns = side_by_side(&points, &free, recordings.unknowns());
            let by_lane = unknown.linearize(&recordings, &unknowns, &free);
            linears.extend(runs.iter().copied().zip(by_lane).filter(|(run, _)| by_run.contains_key(run)));
        }
        // Requests are in ascending order of problems, as is the map.
        Ok(linears.into_iter().map(|(run, linear)| self.weighting[run].expansion(linear)).collect())
    }

    fn bounds(&self) -> Vec<[f64; 2]> {
        self.model.bounds().unwrap_or_default()
    }
}

struct Simulations<'a> {
    recordings: Recordings<'a>,
    unknowns: Vec<Lane>,
    free: Vec<usize>,
    unknown: Unknown,
}

impl Simulations<'_> {
    /// Standard errors, and whether they are approximate. Unless they use blocks, sensitivities were `kept`.
    fn standard_errors(
        &self,
        group: &[usize],
        minima: &[Minimum<Linear>],
        weighting: &[Weighting],
        spread: Spread,
        kept: &Sensitivities<Lane>,
    ) -> Vec<Option<EstimateErrors>> {
        let pairs = minima.iter().zip(weighting);
        let weights: Vec<[f64; 3]> = pairs
            .map(|(minimum, weighting)| weighting.weights(minimum.sums.squares, minimum.sums.samples))
            .collect();
        let mut blocks = None;
        let mut of_blocks = |lane: usize, minimum: &Minimum<Linear>| {
            let Self { recordings, unknowns, free, unknown } = self;
            let blocks = blocks.get_or_insert_with(|| unknown.blocks(recordings, unknowns, free));
            let inverse = inverse(minimum, weights[lane]).ok()?;
            // Without a block that alone determines a parameter there is no estimate: it is treated as hardly
            // informative.
            let left_out = |block: &Linear| {
                let (_, gradient) = block.weighted(weights[lane]);
                Some(without(minimum, block, weights[lane]).unwrap_or_else(|_| times(&inverse, &gradient)))
            };
            jackknife(blocks.iter().map(|block| &block[lane]), left_out)
        };
        let parameters = self.recordings.model.parameters();
        let mut meats = BTreeMap::new();
        let errors = |(lane, minimum): (usize, &Minimum<Linear>)| match spread {
            Spread::Blocks => of_blocks(lane, minimum).map(EstimateErrors::of),
            Spread::Stated(levels) => {
                let meat = meats.entry(0).or_insert_with(|| self.meats(&weights, levels, kept));
                self.of_levels(minimum, weights[lane], meat, lane, levels)
            }
            Spread::Found(of) if minimum.status == Ended::Converged => {
                let FoundSpread { levels, factor, waves } = of(group[lane], &minimum.point[..parameters]);
                if waves {
                    let each = vec![f64::NAN; self.free.len()];
                    return Some(EstimateErrors { each, covariance: None, approximate: true });
                }
                let of_one = |levels: &NoiseModel| {
                    let meat = self.meats(&weights, levels, kept);
                    self.of_levels(minimum, weights[lane], &meat, lane, levels)
                };
                let all: Option<Vec<EstimateErrors>> = levels.iter().map(of_one).collect();
                match all?.into_iter().reduce(EstimateErrors::largest) {
                    Some(errors) => Some(errors.times(factor)),
                    None => of_blocks(lane, minimum)
                        .map(|errors| EstimateErrors { approximate: true, ..EstimateErrors::of(errors) }),
                }
            }
            Spread::Found(_) => None,
        };
        minima.iter().enumerate().map(errors).collect()
    }

    /// The contribution of `levels` to the covariance of the scores, by lane, see [`disturbed_scores`].
    fn meats(&self, weights: &[[f64; 3]], levels: &NoiseModel, kept: &Sensitivities<Lane>) -> Vec<Lane> {
        let weights = [0, 1, 2].map(|d: usize| lane(weights.len(), |run| weights[run][d]));
        let Self { recordings, unknowns, .. } = self;
        with_states!(levels.states(), disturbed_scores(recordings, unknowns, kept, weights, levels))
    }

    /// H⁻¹ B H⁻¹, H = Σ sᵀWs, B the covariance of the scores Σ sᵀWe: that of the measurements and the `meat`.
    fn of_levels(
        &self,
        minimum: &Minimum<Linear>,
        weights: [f64; 3],
        meat: &[Lane],
        lane: usize,
        levels: &NoiseModel,
    ) -> Option<EstimateErrors> {
        let inverse = inverse(minimum, weights).ok()?;
        let mut meat: Vec<f64> = meat.iter().map(|m| m[lane]).collect();
        let noise = [0, 1, 2].map(|d: usize| (weights[d] * levels.measurement[d]).powi(2));
        let (measured, _) = minimum.sums.weighted(noise);
        meat.iter_mut().zip(measured).for_each(|(all, entry)| *all += entry);
        let error = |row: &[f64]| numerics::quadratic(row, &meat).max(0.0).sqrt();
        let each: Vec<f64> = inverse.chunks_exact(self.free.len()).map(error).collect();
        let covariance = Some(congruence(self.free.len(), &inverse, &meat));
        each.iter().all(|e| e.is_finite()).then_some(EstimateErrors { each, covariance, approximate: false })
    }
}
