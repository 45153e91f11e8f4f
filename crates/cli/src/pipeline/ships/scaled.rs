use refusal::Invalid;
use ship::model::{Vessel, VesselFile};
use study::ship_file::ShipFile;
use study::ship_file::{Notes, vessel_text};

use super::Written;

/// Standard deviation of a prior from a fit, at least, over that with which the fit was made: a sister's fit as prior
/// predicts best with about this weight.
const FLOOR: f64 = 0.3;
/// The largest share by which the similar draught may differ from the stated one.
const ROUNDING: f64 = 0.005;

/// The size of a similar ship.
#[derive(Clone, Copy, Debug)]
pub struct Size {
    /// Length \[m\].
    pub length_m: f64,
    /// Density of her water \[kg/m³\]; that of the first ship's without it.
    pub density_kg_m3: Option<f64>,
    /// Draught \[m\], if one is expected.
    pub draught_m: Option<f64>,
}

/// The ship similar to `ship`, of another size.
///
/// # Errors
/// A ship without forces; a size that no ship has, or another hull form; a number that no rule scales.
pub fn scaled(ship: &ShipFile, size: &Size) -> Result<Written, Invalid> {
    let fitted = ship.fitted.is_some();
    let file = ship.file.clone().completed()?;
    let file = if fitted { file.without_truth()? } else { file };
    let own_length = file.ship.as_ref().map_or(0.0, |own| own.length_m);
    let deviations = deviations(ship, &file)?;
    let (file, usual) = file.with_usual_priors(&deviations)?;
    let mut file = file.similar(size.length_m, size.density_kg_m3)?;
    check_form(&file, size)?;
    let name = named(file.name.as_deref().unwrap_or_default(), size.length_m);
    file.name = Some(name.clone());
    let rate = file.sample_rate_hz.unwrap_or_default();
    let speed = file.ship.as_ref().map_or(0.0, |own| own.speed_m_s);
    let mut notes = Notes { head: head(&name, own_length, fitted), ..Notes::default() };
    notes.head.extend(usual_priors(&usual));
    file.fitted = false;
    let (file, unusual) = file.accepting_unusual()?;
    let mut said = format!("{name}: {speed:.4} m/s, {rate:.4} Hz, {} usual priors", usual.len());
    if let Some(own) = unusual {
        said += &format!("; unusual: {}: {}", own.thing, own.found);
        notes.head.push(format!("Unusual of ships: {}: {}.", own.thing, own.found));
    }
    Ok(Written { text: vessel_text(&file, &notes)?, said })
}

/// Standard deviations of priors from a fit: its standard errors, not below a share of its priors.
fn deviations(ship: &ShipFile, file: &VesselFile) -> Result<Vec<(String, f64)>, Invalid> {
    let Some(fitted) = &ship.fitted else { return Ok(Vec::new()) };
    let (with, _) = file.clone().with_usual_priors(&[])?;
    let vessel = Vessel::from_file(with)?;
    let Some(moved) = &vessel.model.forces else { return Ok(Vec::new()) };
    let known = moved.forces.parameters().iter();
    let one = |fitted_parameter: &study::documents::FittedParameter| {
        let prior =
            known.clone().find(|known| known.name == fitted_parameter.name).and_then(|known| known.prior)?;
        let deviation = fitted_parameter.standard_error.map_or(prior, |error| error.max(FLOOR * prior));
        Some((fitted_parameter.name.clone(), deviation))
    };
    Ok(fitted.iter().filter_map(one).collect())
}

/// Refuses a draught of another hull form.
fn check_form(file: &VesselFile, size: &Size) -> Result<(), Invalid> {
    let similar = file.ship.as_ref().map_or(0.0, |own| own.draught_m);
    match size.draught_m {
        Some(draught) if ((draught - similar) / similar).abs() > ROUNDING || !draught.is_finite() => {
            let expected = format!("{similar:.4} m: a similar ship has the same hull form");
            let remedy = "leave it out, or write a ship of these dimensions by `seatrial guess`";
            Err(Invalid::new("the draught", format!("{draught} m"), expected, remedy))
        }
        _ => Ok(()),
    }
}

/// The name of a similar ship.
fn named(name: &str, length_m: f64) -> String {
    let plain = match name.rsplit_once(" at ") {
        Some((plain, size)) if size.strip_suffix(" m").is_some_and(|own| own.parse::<f64>().is_ok()) => plain,
        _ => name,
    };
    format!("{plain} at {length_m} m")
}

fn head(name: &str, own_length: f64, fitted: bool) -> Vec<String> {
    let origin = if fitted { "of which a model was fitted" } else { "that this file was written from" };
    let mut all = vec![
        format!("{name}: geometrically similar to the ship of {own_length} m {origin}, at the same Froude number."),
        "Numbers of the prime system, angles and pure numbers are hers. Speeds and times are scaled by the root of the \
         length, revolutions by its inverse, areas by its square, masses and forces by its cube. The sampling rate has as \
         many samples per length sailed; any other is right, too."
            .to_owned(),
        "Friction is not similar: in the prime system the longer ship has less resistance, and a weaker wake.".to_owned(),
    ];
    if fitted {
        all.push(format!(
            "Priors: the standard error of the fit, at least {FLOOR} of the standard deviation that it began with."
        ));
    }
    all
}

/// Which priors are none of the first ship's.
fn usual_priors(usual: &[String]) -> Option<String> {
    let names = usual.join(", ");
    (!usual.is_empty())
        .then(|| format!("Priors that are usual of such numbers, and not this ship's own: {names}."))
}
