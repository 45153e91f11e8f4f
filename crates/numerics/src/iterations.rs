//! Searches that go step by step: argmin's executor takes the steps, counts them and tells one observer of each.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use argmin::core::observers::{Observe, ObserverMode};
use argmin::core::{Error, Executor, IterState, KV, Problem, Solver, TerminationReason, TerminationStatus};

/// Watches searches: is called after every iteration, to report progress and to end the search, because its time is over or nobody
/// waits for it any more. The default one lets all go on.
#[derive(Clone, Default)]
pub struct Watch(Option<Arc<Asked>>);

struct Asked {
    goes_on: Box<dyn Fn() -> bool + Send + Sync>,
    ended: AtomicBool,
}

impl Watch {
    /// Searches go on for as long as `goes_on` says so.
    pub fn new(goes_on: impl Fn() -> bool + Send + Sync + 'static) -> Self {
        Self(Some(Arc::new(Asked { goes_on: Box::new(goes_on), ended: AtomicBool::new(false) })))
    }

    /// Whether it has ended a search.
    pub fn ended(&self) -> bool {
        self.0.as_ref().is_some_and(|asked| asked.ended.load(Ordering::Relaxed))
    }
}

impl<I> Observe<I> for Watch {
    fn observe_iter(&mut self, _state: &I, _kv: &KV) -> Result<(), Error> {
        match &self.0 {
            Some(asked) if !(asked.goes_on)() => {
                asked.ended.store(true, Ordering::Relaxed);
                Err(Error::msg("ended by its watch"))
            }
            _ => Ok(()),
        }
    }
}

/// What argmin keeps of a search that keeps its own state: the number of iterations.
type Counted = IterState<(), (), (), (), (), f64>;

/// The solver whose iteration is a call of the problem.
struct Steps {
    name: &'static str,
    ended: bool,
}

impl<F: FnMut() -> Option<()>> Solver<F, Counted> for Steps {
    fn name(&self) -> &str {
        self.name
    }

    fn next_iter(
        &mut self,
        problem: &mut Problem<F>,
        state: Counted,
    ) -> Result<(Counted, Option<KV>), Error> {
        self.ended = problem.problem.as_mut().and_then(|step| step()).is_none();
        Ok((state, None))
    }

    fn terminate(&mut self, _state: &Counted) -> TerminationStatus {
        match self.ended {
            true => TerminationStatus::Terminated(TerminationReason::SolverConverged),
            false => TerminationStatus::NotTerminated,
        }
    }
}

/// Takes steps of the search that is called `name`: at most `most`, until one says `None` or `watch` ends it.
pub fn iterate(name: &'static str, most: usize, watch: &Watch, step: impl FnMut() -> Option<()>) {
    let executor = Executor::new(step, Steps { name, ended: false })
        .configure(|state: Counted| state.max_iters(most as u64))
        .timer(false);
    let observed = match watch.0 {
        None => executor,
        Some(_) => executor.add_observer(watch.clone(), ObserverMode::Always),
    };
    // The search keeps what it has found; its steps do not fail, so an error says that the watch has ended it.
    let _ = observed.run();
}
