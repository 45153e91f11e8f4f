use refusal::{names_in, nearest};

use super::error::CrossError;

/// How runs or recordings are left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Folds {
    /// Each on its own.
    Each,
    /// Dealt in turn into this number of folds.
    Dealt(usize),
    /// Named groups together, each a name or several with commas between; those not named are in every estimate.
    Named(Vec<Vec<String>>),
}

impl Folds {
    /// The indices of `sources` that each fold leaves out of the estimate, and simulates over.
    ///
    /// # Errors
    /// A name that no source has, or that occurs twice; a fold that leaves nothing to estimate from.
    pub fn left_out(&self, sources: &[&str]) -> Result<Vec<Vec<usize>>, CrossError> {
        let all = sources.len();
        let dealt = |count: usize| {
            let count = count.min(all);
            (0..count).map(|i| (i..all).step_by(count.max(1)).collect()).collect()
        };
        match self {
            Self::Each => Ok(dealt(all)),
            Self::Dealt(count) => Ok(dealt(*count)),
            Self::Named(folds) => named(sources, folds),
        }
    }
}

fn named(sources: &[&str], folds: &[Vec<String>]) -> Result<Vec<Vec<usize>>, CrossError> {
    let mut taken = vec![false; sources.len()];
    let mut place = |name: &String| {
        let Some(place) = sources.iter().position(|source| source == name) else {
            let nearest = nearest(name, sources.iter().copied()).unwrap_or_default().to_owned();
            return Err(CrossError::Unknown { name: name.clone(), nearest });
        };
        if std::mem::replace(&mut taken[place], true) {
            return Err(CrossError::Twice(name.clone()));
        }
        Ok(place)
    };
    let known = |name: &str| sources.contains(&name);
    let fold = |names: &Vec<String>| {
        names.iter().flat_map(|name| names_in(name, known)).map(|name| place(&name)).collect()
    };
    let folds: Vec<Vec<usize>> = folds.iter().map(fold).collect::<Result<_, _>>()?;
    match folds.iter().any(|left_out| left_out.len() == sources.len()) {
        true => Err(CrossError::OneSource),
        false => Ok(folds),
    }
}
