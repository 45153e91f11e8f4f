use refusal::Invalid;
use ship::forces::{GRAVITY, MainDimensions, usual_froude};
use ship::model::{InputSpec, Vessel, VesselFile};
use study::ship_file::{Notes, vessel_text};

use super::Written;

/// Rudder angle to either side \[rad\]: 35°.
const RUDDER: f64 = 0.6109;
/// Rate of the rudder \[rad/s\]: 65° in 28 s, as SOLAS asks for.
const RUDDER_RATE: f64 = 0.0405;
/// Length of the ships whose rudder has that rate \[m\]; those of shorter ones are faster, as those of models are.
const FULL_SCALE_M: f64 = 100.0;
/// Samples per length sailed, at least.
const SAMPLES: f64 = 20.0;
/// Highest revolutions over those that hold the speed.
const MOST_REVOLUTIONS: f64 = 1.3;
/// Proportions of the ships that the formulas were made for: name, and between which they are.
const USUAL: [(&str, [f64; 2]); 3] =
    [("length over beam", [5.0, 8.5]), ("beam over draught", [2.0, 4.5]), ("block coefficient", [0.5, 0.87])];

/// A ship of these dimensions, with a prior for every free number and the source of each number as a comment.
///
/// # Errors
/// Dimensions that no ship has, or that contradict each other.
pub fn guessed(own: &MainDimensions) -> Result<Written, Invalid> {
    let guess = own.guess()?;
    let speed = guess.description.ship.speed_m_s;
    let revolutions = guess.revolutions;
    let mut unusual = unusual(own, speed);
    let file = VesselFile {
        name: Some(format!("Guessed ship of {} m", own.length_m)),
        sample_rate_hz: Some(rate(speed / own.length_m)),
        input: inputs(own.length_m, revolutions),
        ..VesselFile::of_forces(guess.description)
    };
    // Her dimensions were given: what is unusual of them is said, and passes.
    let (file, found) = file.accepting_unusual()?;
    unusual.extend(found.map(|own| format!("{}: {}", own.thing, own.found)));
    let vessel = Vessel::from_file(file.clone())?;
    let numbers = guess.sources.into_iter().map(|(name, source)| (name, source.to_owned())).collect();
    let notes = Notes { head: head(own, revolutions, &unusual), numbers };
    let mut said =
        format!("{speed:.4} m/s at {revolutions:.4} 1/s, {} free numbers with priors", vessel.nominal.len());
    if !unusual.is_empty() {
        said += &format!("; beyond the usual ships of the formulas: {}", unusual.join(", "));
    }
    Ok(Written { text: vessel_text(&file, &notes)?, said })
}

/// The lowest usual rate \[Hz\] with enough samples per length, where a second has `lengths` of them.
fn rate(lengths: f64) -> f64 {
    let decades = [0.1, 1.0, 10.0, 100.0].into_iter().flat_map(|own| [own, 2.0 * own, 5.0 * own]);
    decades.clone().find(|decade| *decade >= SAMPLES * lengths).unwrap_or(500.0)
}

fn inputs(length_m: f64, revolutions: f64) -> Vec<InputSpec> {
    let faster = (FULL_SCALE_M / length_m).max(1.0).sqrt();
    let rudder = InputSpec {
        name: "delta".to_owned(),
        unit: "rad".to_owned(),
        range: Some([-RUDDER, RUDDER]),
        rate_per_s: Some(digits(RUDDER_RATE * faster)),
        ..InputSpec::default()
    };
    let propeller = InputSpec {
        name: "n".to_owned(),
        unit: "1/s".to_owned(),
        range: Some([0.0, digits(MOST_REVOLUTIONS * revolutions)]),
        ..InputSpec::default()
    };
    vec![rudder, propeller]
}

/// With four digits.
fn digits(own: f64) -> f64 {
    format!("{own:.3e}").parse().unwrap_or(own)
}

/// Proportions that are none of the usual ships, with their values.
fn unusual(main_dimensions: &MainDimensions, speed: f64) -> Vec<String> {
    let froude = speed / (GRAVITY * main_dimensions.length_m).sqrt();
    let most = usual_froude(main_dimensions.block);
    let fast = (froude > most)
        .then(|| format!("Froude number {froude:.2} (at most {most:.2} at this block coefficient)"));
    let found = [
        main_dimensions.length_m / main_dimensions.beam_m,
        main_dimensions.beam_m / main_dimensions.draught_m,
        main_dimensions.block,
    ];
    let all = USUAL.into_iter().zip(found);
    all.filter(|((_, [low, high]), main_dimensions)| !(*low..=*high).contains(main_dimensions))
        .map(|((name, [low, high]), main_dimensions)| {
            format!("{name} {main_dimensions:.3} ({low} to {high})")
        })
        .chain(fast)
        .collect()
}

fn head(main_dimensions: &MainDimensions, revolutions: f64, unusual: &[String]) -> Vec<String> {
    let MainDimensions { length_m, beam_m, draught_m, block, .. } = main_dimensions;
    let mut all = vec![
        format!(
            "A ship of {length_m} m, beam {beam_m} m, draught {draught_m} m, block coefficient {block}, from textbook \
             formulas. Nothing in it was measured."
        ),
        "`prior` is the standard deviation of what is known: two of them to either side are the 95 % interval. Numbers \
         without one are not fitted, because free runs know forces over masses alone. Replace what you know better."
            .to_owned(),
        format!("She holds her speed at n = {revolutions:.4} revolutions per second."),
    ];
    if !unusual.is_empty() {
        all.push(format!("Beyond the usual ships that the formulas were made for: {}.", unusual.join(", ")));
    }
    all
}
