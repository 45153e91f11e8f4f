use refusal::nearest;

use super::error::CrossError;

/// How runs or recordings are left out.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum Folds {
    /// Each on its own.
    Each,
    /// Dealt in turn into this number of folds.
    Dealt(usize),
    /// Named groups together; those not named are in every estimate.
    Named(Vec<Vec<String>>),
}

/// One fold: the indices of its sources.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Fold {
    /// Left out of the estimate, and simulated over.
    pub left_out: Vec<usize>,
}

/// The folds of `sources`.
///
/// # Errors
/// A name that no source has, or that occurs twice.
pub(super) fn folds(sources: &[&str], how: &Folds) -> Result<Vec<Fold>, CrossError> {
    let all = sources.len();
    let dealt = |count: usize| {
        let count = count.min(all);
        (0..count).map(|i| Fold { left_out: (i..all).step_by(count.max(1)).collect() }).collect()
    };
    match how {
        Folds::Each => Ok(dealt(all)),
        Folds::Dealt(count) => Ok(dealt(*count)),
        Folds::Named(folds) => named(sources, folds),
    }
}

fn named(sources: &[&str], folds: &[Vec<String>]) -> Result<Vec<Fold>, CrossError> {
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
    let mut fold = |names: &Vec<String>| {
        let left_out = names.iter().map(&mut place).collect::<Result<_, _>>()?;
        Ok(Fold { left_out })
    };
    let folds: Vec<Fold> = folds.iter().map(&mut fold).collect::<Result<_, _>>()?;
    match folds.iter().any(|fold| fold.left_out.len() == sources.len()) {
        true => Err(CrossError::OneSource),
        false => Ok(folds),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const SOURCES: [&str; 5] = ["a", "b", "c", "d", "e"];

    #[test]
    fn law_every_source_is_left_out_once() {
        for (sources, how) in [(5, Folds::Each), (5, Folds::Dealt(2)), (3, Folds::Dealt(7))] {
            let folds = folds(&SOURCES[..sources], &how).unwrap();
            let mut all: Vec<usize> = folds.into_iter().flat_map(|f| f.left_out).collect();
            all.sort_unstable();
            assert_eq!(all, (0..sources).collect::<Vec<_>>());
        }
        assert_eq!(folds(&SOURCES, &Folds::Dealt(2)).unwrap()[1].left_out, [1, 3]);
    }

    #[test]
    fn named_folds_are_those_named() {
        let named = |folds: &[&[&str]]| {
            Folds::Named(
                folds.iter().map(|own| own.iter().map(|name| (*name).to_owned()).collect()).collect(),
            )
        };
        let found = folds(&SOURCES, &named(&[&["d", "a"], &["e"]])).unwrap();
        assert_eq!((&found[0].left_out, &found[1].left_out), (&vec![3, 0], &vec![4]));
        let twice = folds(&SOURCES, &named(&[&["a"], &["b", "a"]]));
        assert_eq!(twice, Err(CrossError::Twice("a".to_owned())));
        assert_eq!(folds(&SOURCES, &named(&[&SOURCES])), Err(CrossError::OneSource));
        assert!(matches!(folds(&SOURCES, &named(&[&["f"]])), Err(CrossError::Unknown { .. })));
    }
}
