use std::collections::BTreeMap;

use maneuver::merit::Figure;
use maneuver::{Generator, ManeuverKind as Kind};
use refusal::Invalid;

use super::{Merit, undisturbed};

/// The derivatives of a figure by the parameters, in its unit per unit of the parameter, by the parameter's name; or why it
/// has none.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureSlopes {
    /// Name of the figure.
    pub figure: &'static str,
    /// Its derivatives.
    pub slopes: Result<BTreeMap<String, f64>, Invalid>,
}

/// The figures of the undisturbed ship, or why it has none.
type Found = Result<Vec<Figure>, Invalid>;

/// Parts of a sample by which the helm of a zig-zag goes over later: figures are means over them. What a coarse model does
/// depends on where within a sample orders fall, and that jumps with the parameters.
const PHASES: u32 = 8;

impl Merit<'_> {
    /// Computes the derivatives of every figure at `parameters`: central differences of undisturbed ships, one parameter of
    /// each off by `step` of itself. Orders stay those of the dictionary, as in [`Merit::simulate_drawn`].
    ///
    /// # Errors
    /// A parameter of 0, which no step is relative to; a maneuver that the model cannot hold.
    pub fn differentiate(&mut self, parameters: &[f64], step: f64) -> Result<(), Invalid> {
        let names: Vec<&str> = self.hull.vessel.model.parameter_names().collect();
        if let Some((name, _)) = names.iter().zip(parameters).find(|(_, value)| **value == 0.0) {
            let remedy = "give it a value, or take the term out";
            return Err(Invalid::new(
                format!("parameter `{name}`"),
                "0",
                "a value that a step is relative to",
                remedy,
            ));
        }
        let sample_s = 1.0 / self.hull.vessel.sample_rate_hz;
        let later = |phase| (f64::from(phase) + 0.5) / f64::from(PHASES) * sample_s;
        let phases: Vec<Generator> =
            (0..PHASES).filter_map(|phase| Some(self.generator?.clone().later(later(phase)))).collect();
        for place in 0..self.gathered.len() {
            let Some(index) = self.gathered[place].index else { continue };
            let found = |parameters: &[f64]| self.found(&phases, index, parameters);
            let base = found(parameters);
            let mut ends = Vec::with_capacity(names.len());
            for (i, name) in names.iter().enumerate() {
                let off = |sign: f64| {
                    let mut moved = parameters.to_vec();
                    moved[i] *= 1.0 + sign * step;
                    found(&moved)
                };
                ends.push((*name, 2.0 * step * parameters[i], [off(-1.0), off(1.0)]));
            }
            self.gathered[place].slopes = Some(base.map(|figures| slopes(&figures, &ends)));
        }
        Ok(())
    }

    /// The figures of the undisturbed ship with `parameters`, means over the phases in which there is each.
    fn found(&self, phases: &[Generator], index: usize, parameters: &[f64]) -> Found {
        let is_phased = matches!(phases[0].maneuvers()[index].kind, Kind::ZigZagTest(_));
        let phases = if is_phased { phases } else { &phases[..1] };
        let mut mean: Vec<Figure> = Vec::new();
        for (number, phase) in phases.iter().enumerate() {
            let (standard, record) = undisturbed(self.hull.vessel, phase, index, parameters)?;
            let own = maneuver::merit::figures(Some(standard), &record, &self.hull)?.figures;
            let own: Vec<Figure> = own.into_iter().filter(|own| !own.is_aside).collect();
            let part = 1.0 / phases.len() as f64;
            if number == 0 {
                mean = own.iter().map(|figure| Figure { value: 0.0, ..figure.clone() }).collect();
            }
            mean.retain(|known| own.iter().any(|figure| figure.name == known.name));
            for known in &mut mean {
                let value = own.iter().find(|figure| figure.name == known.name).map(|figure| figure.value);
                known.value += part * value.unwrap_or(f64::NAN);
            }
        }
        Ok(mean)
    }
}

/// The slopes of all `figures` from those at both ends of every parameter's step, which has a name and a width.
fn slopes(figures: &[Figure], ends: &[(&str, f64, [Found; 2])]) -> Vec<FigureSlopes> {
    let one = |figure: &Figure| {
        let own = ends.iter().map(|(name, width, ends)| {
            slope(figure, name, *width, ends).map(|slope| ((*name).to_owned(), slope))
        });
        FigureSlopes { figure: figure.name, slopes: own.collect() }
    };
    figures.iter().map(one).collect()
}

/// The derivative of `figure` by the parameter `name` from the figures at both ends of its step, which are `width` apart.
fn slope(figure: &Figure, name: &str, width: f64, ends: &[Found; 2]) -> Result<f64, Invalid> {
    let thing = || format!("{} with another `{name}`", figure.what);
    let of = |end: &Found| {
        let own =
            end.as_ref().map_err(|e| Invalid { thing: format!("{}: {}", thing(), e.thing), ..e.clone() })?;
        let own = own.iter().find(|own| own.name == figure.name).map(|own| own.value);
        own.filter(|value| value.is_finite()).ok_or_else(|| {
            Invalid::new(thing(), "none", "one on both sides of the parameter", "run the maneuver longer")
        })
    };
    Ok((of(&ends[1])? - of(&ends[0])?) / width)
}
