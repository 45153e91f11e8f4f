//! Designs with few candidates.

use crate::certificate::largest;
use crate::design::{from_points, loss};
use crate::{Bounds, Design, Error, Method, Objective, Options};

/// Restricted shares.
#[derive(Clone, Debug, PartialEq)]
pub struct Selected {
    /// Shares of all candidates.
    pub shares: Vec<f64>,
    /// Φ of them.
    pub value: f64,
    /// g_q of every candidate.
    pub sensitivities: Vec<f64>,
    /// Upper bound on the ascent in any feasible direction without the restriction.
    pub gap: f64,
    /// Whether every choice of candidates was tried, so that none is better.
    pub exhaustive: bool,
    /// Number of choices that were tried.
    pub tried: usize,
}

impl Selected {
    /// An upper bound on the loss of these shares, as a fraction of the experiment's time, against any within the gap
    /// of `relaxed`, the design without restriction: proved if that is proved global. `degree`: the criterion's gain
    /// per log of time.
    pub fn loss_bound(&self, relaxed: &Design, degree: f64) -> f64 {
        loss(self.value, relaxed, degree)
    }
}

/// Shares under a restriction, and its cost.
#[derive(Clone, Debug, PartialEq)]
pub struct Restricted {
    /// The shares, as a design.
    pub design: Design,
    /// How they were found.
    pub method: Method,
    /// Choices of maneuvers that were tried.
    pub tried: usize,
    /// Upper bound on the fraction of the experiment's time that the restriction costs; proved if the design without
    /// it is proved optimal.
    pub loss: f64,
}

/// All choices are tried if there are no more than this.
const EXHAUSTIVE: f64 = 2000.0;
/// Number of the smallest shares that are tried for dropping.
const DROPPED: usize = 6;
/// Maximum number of exchanges.
const EXCHANGES: usize = 20;
/// An exchange has to save more than this fraction of the time.
const WORTHWHILE: f64 = 1e-3;
/// Relative gap for comparing choices; the selected one is solved to the options' tolerance.
const ROUGH: f64 = 1e-5;
/// Unused candidates that are tried in an exchange, the most sensitive.
const INCOMING: usize = 12;

/// The best shares found of at most `most` candidates: these are dropped from the support of `relaxed` one at a time,
/// each time the one that costs least, then exchanged for others while that improves. All choices are tried if they
/// are few.
///
/// # Errors
/// [`Error::Infeasible`] if no shares satisfy the bounds; [`Error::Solver`] if so few candidates do not excite every direction.
pub fn select<O: Objective>(
    objective: &O,
    relaxed: &Design,
    bounds: &Bounds,
    most: usize,
    options: &Options,
) -> Result<Selected, Error> {
    let rough = Options { tolerance: options.tolerance.max(ROUGH), ..*options };
    let most = most.min(objective.len());
    let mut search = ChoiceSearch { objective, bounds, options: &rough, most, tried: 0 };
    if choices(objective.len(), most) <= EXHAUSTIVE {
        search.options = options;
        let best = search.all();
        return search.selected(best, true);
    }
    let used: Vec<usize> = (0..objective.len()).filter(|q| relaxed.shares[*q] > 0.0).collect();
    let mut now = search.solve(&used);
    while now.as_ref().is_some_and(|current| current.members.len() > most) {
        now = now.as_ref().and_then(|current| search.drop_one(current));
    }
    for _ in 0..EXCHANGES {
        let Some(better) = now.as_ref().and_then(|current| search.exchange(current)) else { break };
        now = Some(better);
    }
    search.options = options;
    let polished = now.as_ref().and_then(|choice| search.solve(&choice.members));
    search.selected(polished.or(now), false)
}

/// Number of sets of `k` out of `n`.
fn choices(n: usize, k: usize) -> f64 {
    (0..k).map(|i| (n - i) as f64 / (k - i) as f64).product()
}

/// Shares of a choice of candidates: those of the members are positive.
struct Choice {
    members: Vec<usize>,
    shares: Vec<f64>,
    value: f64,
    sensitivities: Vec<f64>,
}

struct ChoiceSearch<'a, O> {
    objective: &'a O,
    bounds: &'a Bounds,
    options: &'a Options,
    most: usize,
    tried: usize,
}

impl<O: Objective> ChoiceSearch<'_, O> {
    fn selected(&self, best: Option<Choice>, exhaustive: bool) -> Result<Selected, Error> {
        let best = best.ok_or_else(|| Error::Solver("every choice was singular".into()))?;
        let mut shares = vec![0.0; self.objective.len()];
        best.members.iter().zip(&best.shares).for_each(|(q, w)| shares[*q] = *w);
        let gap = self.bounds.gap(&best.sensitivities, &shares, self.objective.degree());
        let (value, sensitivities) = (best.value, best.sensitivities);
        Ok(Selected { shares, value, sensitivities, gap, exhaustive, tried: self.tried })
    }

    /// The best shares of `members`; `None` if they are singular or infeasible.
    fn solve(&mut self, members: &[usize]) -> Option<Choice> {
        self.tried += 1;
        let upper: Vec<f64> = members.iter().map(|q| self.bounds.upper(*q)).collect();
        let bounds = Bounds::new(&upper).ok()?;
        let subset = Subset { objective: self.objective, members: members.to_vec() };
        let mut start = vec![1.0 / members.len() as f64; members.len()];
        bounds.fill(&mut start);
        let design = from_points(&subset, &bounds, self.options, false, vec![start]).ok()?;
        let kept: Vec<usize> = (0..members.len()).filter(|i| design.shares[*i] > 0.0).collect();
        let whole = subset.whole(&design.shares);
        let mut at = O::Point::default();
        let value = self.objective.evaluate(&whole, &mut at)?;
        let sensitivities = self.objective.sensitivities(&at);
        Some(Choice {
            members: kept.iter().map(|i| members[*i]).collect(),
            shares: kept.iter().map(|i| design.shares[*i]).collect(),
            value,
            sensitivities,
        })
    }

    /// Drops the member that costs least.
    fn drop_one(&mut self, from: &Choice) -> Option<Choice> {
        let mut order: Vec<usize> = (0..from.members.len()).collect();
        order.sort_by(|a, b| from.shares[*a].total_cmp(&from.shares[*b]));
        let mut best: Option<Choice> = None;
        for (place, out) in order.iter().enumerate() {
            if place >= DROPPED && best.is_some() {
                break;
            }
            let left: Vec<usize> =
                from.members.iter().enumerate().filter(|(i, _)| i != out).map(|(_, q)| *q).collect();
            let selected = if left.is_empty() { None } else { self.solve(&left) };
            if let Some(better) = selected.filter(|f| best.as_ref().is_none_or(|b| f.value > b.value)) {
                best = Some(better);
            }
        }
        best
    }

    /// The best improving exchange of a member for an unused candidate, or the best addition if the number of members
    /// allows one.
    fn exchange(&mut self, from: &Choice) -> Option<Choice> {
        let unused = (0..self.objective.len()).filter(|q| !from.members.contains(q));
        let mut best: Option<Choice> = None;
        for new in largest(unused, &from.sensitivities, INCOMING) {
            let can_add = from.members.len() < self.most;
            for out in (0..from.members.len()).map(Some).chain(can_add.then_some(None)) {
                let kept = from.members.iter().enumerate().filter(|(i, _)| Some(*i) != out).map(|(_, q)| *q);
                let mut members: Vec<usize> = kept.chain([new]).collect();
                members.sort_unstable();
                let worthwhile = from.value + WORTHWHILE * self.objective.degree();
                let better = best.as_ref().map_or(worthwhile, |b| b.value);
                let grown = self.solve(&members).filter(|f| f.value > better);
                best = grown.or(best);
            }
        }
        best
    }

    /// The best of all choices of the most candidates.
    fn all(&mut self) -> Option<Choice> {
        let most = self.most;
        let mut members: Vec<usize> = (0..most).collect();
        let mut best: Option<Choice> = None;
        loop {
            if let Some(shrunk) =
                self.solve(&members).filter(|f| best.as_ref().is_none_or(|b| f.value > b.value))
            {
                best = Some(shrunk);
            }
            // The next combination in lexicographic order.
            let last = self.objective.len() - most;
            let Some(place) = (0..most).rev().find(|i| members[*i] < last + i) else { return best };
            members[place] += 1;
            for i in place + 1..most {
                members[i] = members[i - 1] + 1;
            }
        }
    }
}

/// An [`Objective`] over some of its candidates; the others have no share.
struct Subset<'a, O> {
    objective: &'a O,
    members: Vec<usize>,
}

impl<O: Objective> Subset<'_, O> {
    /// Shares of all candidates.
    fn whole(&self, shares: &[f64]) -> Vec<f64> {
        let mut whole = vec![0.0; self.objective.len()];
        self.members.iter().zip(shares).for_each(|(q, w)| whole[*q] = *w);
        whole
    }
}

impl<O: Objective> Objective for Subset<'_, O> {
    type Point = O::Point;

    fn len(&self) -> usize {
        self.members.len()
    }

    fn degree(&self) -> f64 {
        self.objective.degree()
    }

    fn size(&self) -> usize {
        self.objective.size()
    }

    fn exponent(&self) -> f64 {
        self.objective.exponent()
    }

    fn evaluate(&self, shares: &[f64], at: &mut O::Point) -> Option<f64> {
        self.objective.evaluate(&self.whole(shares), at)
    }

    fn value(&self, shares: &[f64], at: &mut O::Point) -> Option<f64> {
        self.objective.value(&self.whole(shares), at)
    }

    fn sensitivity(&self, q: usize, at: &O::Point) -> f64 {
        self.objective.sensitivity(self.members[q], at)
    }

    fn curvature(&self, members: &[usize], at: &O::Point) -> Vec<f64> {
        let mapped: Vec<usize> = members.iter().map(|q| self.members[*q]).collect();
        self.objective.curvature(&mapped, at)
    }
}
