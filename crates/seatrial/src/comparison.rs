//! A model on recordings that it was not fitted to.

use refusal::{Invalid, listed};
use regression::pooled::PooledRuns;
use ship::model::Vessel;
use study::Tried;
use study::documents::CompareDocument;
use validation::comparison::{CompareOptions, Contestant, EstimatedErrors, Ship, Standing, Traced, compare};
use validation::crossval::CrossError;

/// Compares a model with least squares of the same data, the mean of the recordings, and another model.
pub struct Comparison<'a> {
    /// The model, or several whose trajectories are averaged.
    pub model: &'a Tried,
    /// Single models whose trajectories are averaged with those of `model`, then a single one, too.
    pub averaged: &'a [Tried],
    /// Another model.
    pub other: Option<&'a Vessel>,
    /// Length of the simulated windows in samples; whole runs without it.
    pub window: Option<usize>,
}

/// The vessel whose channels runs are read with: the first one with the most.
pub fn widest<'a>(vessels: &[&'a Vessel]) -> Option<&'a Vessel> {
    vessels.iter().rev().copied().max_by_key(|vessel| vessel.model.exogenous())
}

/// Where the inputs and measured disturbances of `vessel` stand in the rows of `widest`.
///
/// # Errors
/// Another sampling rate; a channel that `widest` does not have, or computes otherwise.
pub fn channels_within(vessel: &Vessel, widest: &Vessel) -> Result<Vec<usize>, Invalid> {
    let rates = [vessel, widest].map(|own| own.sample_rate_hz);
    if rates[0] != rates[1] {
        let [found, expected] = rates.map(|own| format!("{own} Hz"));
        return Err(Invalid::new("sampling rate", found, expected, "compare models of the same logs"));
    }
    let formula = |of: &Vessel, place: usize| {
        of.model.derived.iter().find(|own| own.variable == place).map(|own| own.text.clone())
    };
    let all = &widest.model.variables;
    let column = |place: usize| {
        let own = &vessel.model.variables[place];
        let same = |i: &usize| {
            let texts = (formula(vessel, place), formula(widest, *i));
            let otherwise = matches!(texts, (Some(own), Some(other)) if own != other);
            all[*i].name == own.name && all[*i].unit == own.unit && !otherwise
        };
        (3..all.len()).find(same).map(|i| i - 3).ok_or_else(|| {
            let names: Vec<&str> = all[3..].iter().map(|own| own.name.as_str()).collect();
            Invalid::new(
                format!("channel `{}` in {}", own.name, own.unit),
                "a channel of this model alone",
                format!("those of the model with the most: {}", names.join(", ")),
                "compare models of the same logs",
            )
        })
    };
    (3..vessel.model.variables.len()).map(column).collect()
}

impl<'a> Comparison<'a> {
    /// Of `model` over whole runs, with nothing else that is averaged or compared.
    pub fn of(model: &'a Tried) -> Self {
        Self { model, averaged: &[], other: None, window: None }
    }

    /// All vessels that are simulated.
    pub fn vessels(&self) -> Vec<&'a Vessel> {
        let Self { model, averaged, other, .. } = *self;
        model.vessels().iter().chain(averaged.iter().map(Tried::vessel)).chain(other).collect()
    }

    /// The verdict of `runs`, which have the channels of [`widest`], and the model's simulation of them sample by sample.
    ///
    /// # Errors
    /// Channels that are not those of the runs; no run as long as a window.
    pub fn over(&self, runs: &PooledRuns) -> Result<(CompareDocument, Vec<Traced>), ComparisonError> {
        let vessels = self.vessels();
        let lead = widest(&vessels).unwrap_or_else(|| self.model.vessel());
        let columns =
            vessels.iter().map(|vessel| channels_within(vessel, lead)).collect::<Result<Vec<_>, _>>()?;
        let contestants = self.contestants(lead, &columns);
        let tried: Vec<&Tried> = std::iter::once(self.model).chain(self.averaged).collect();
        let known: Option<Vec<EstimatedErrors>> = tried.iter().map(|own| own.known()).collect();
        let known = known.unwrap_or_default();
        let fitted = tried.iter().rev().max_by_key(|own| own.vessel().model.exogenous());
        let (covered, magnitudes) =
            fitted.map_or((&[][..], None), |fitted| (fitted.covered(), fitted.magnitudes()));
        let (window, rate_hz) = (self.window, lead.sample_rate_hz);
        let options = CompareOptions { window, known: &known, covered, magnitudes, rate_hz };
        let mut found = compare(&contestants, runs, &options)?;
        let unknown = tried.iter().position(|own| own.known().is_none());
        found.statements.extend(unknown.filter(|_| !self.averaged.is_empty()).map(|place| {
            format!("no bands: the errors of model {} of the average are not known", place + 1)
        }));
        let short: Vec<String> = runs
            .windows(window)
            .into_iter()
            .filter(|(_, own)| own.is_empty())
            .map(|(name, _)| name)
            .collect();
        if !short.is_empty() {
            found.statements.push(format!("shorter than a window and not compared: {}", listed(&short)));
        }
        let window_s = window.map(|samples| samples as f64 / rate_hz);
        Ok((CompareDocument::new(&self.model.vessel().name, window_s, &found), found.trace))
    }

    /// The model or the average, its models alone, and what it is compared with. `columns` are those of all vessels.
    fn contestants<'b>(&self, lead: &Vessel, columns: &'b [Vec<usize>]) -> Vec<Contestant<'b>>
    where
        'a: 'b,
    {
        let Self { model, averaged, .. } = *self;
        let whole = |columns: &[usize]| columns.iter().copied().eq(0..lead.model.exogenous());
        let of = |own: &'b Vec<usize>| Some(own.as_slice()).filter(|own| !whole(own));
        let all: Vec<Ship<'b>> =
            self.vessels().into_iter().zip(columns).map(|(own, from)| ship(own, of(from))).collect();
        let (several, others) = all.split_at(model.vessels().len() + averaged.len());
        let one = |standing, ships: &[Ship<'b>]| Contestant { standing, place: None, ships: ships.to_vec() };
        let standing = if averaged.is_empty() { model.standing() } else { Standing::Average };
        let mut contestants = vec![one(standing, several)];
        // Models of several kinds, not of one search
        let kinds = several.len() > 1 && several.iter().any(|ship| ship.model.forces.is_some());
        let alone = several.iter().enumerate().filter(|_| kinds || !averaged.is_empty());
        contestants.extend(alone.map(|(i, ship)| Contestant {
            place: Some(i as u64 + 1),
            ..one(Standing::Averaged, std::slice::from_ref(ship))
        }));
        contestants.extend(others.iter().map(|ship| one(Standing::Other, std::slice::from_ref(ship))));
        let by_least_squares = model.by_least_squares().filter(|_| averaged.is_empty());
        let same = by_least_squares.map(|own| ship(own, columns.first().and_then(of)));
        contestants.extend(same.map(|ship| one(Standing::LeastSquares, &[ship])));
        contestants
    }
}

fn ship<'b>(vessel: &'b Vessel, columns: Option<&'b [usize]>) -> Ship<'b> {
    Ship { model: &vessel.model, theta: &vessel.nominal, columns }
}

/// Why models were not compared.
#[derive(Debug, thiserror::Error)]
pub enum ComparisonError {
    /// Channels that do not belong together.
    #[error("{0}")]
    Channels(#[from] Invalid),
    /// Nothing can be simulated.
    #[error("{0}")]
    Windows(#[from] CrossError),
}

impl ComparisonError {
    /// What is invalid.
    pub fn invalid(&self) -> Invalid {
        match self {
            Self::Channels(own) => own.clone(),
            Self::Windows(own) => own.invalid(),
        }
    }
}
