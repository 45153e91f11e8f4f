//! `scale` and `guess`: ships before their first trial.

use std::path::PathBuf;

use crate::pipeline::ships::{MainDimensions, Size, Written, guessed, scaled};
use clap::Parser;
use files::{Staged, commit};
use serde_json::json;
use study::ship_file::read_ship;

use crate::cli::{Common, none_given};
use crate::failure::Failure;
use crate::stage::{Summary, Task};

/// What the file is usually called.
const MAIN: &str = "vessel.toml";

/// Writes the geometrically similar ship of another length, with a prior for every free number
#[derive(Parser)]
#[command(
    name = "scale",
    after_help = "Example:\n  scale --vessel kvlcc2-l7 --length 320 --density 1025 --out vessel.toml"
)]
pub struct Scale {
    /// The ship with forces: a file, the model of a fit, or a preset
    #[arg(long, value_name = "vessel.toml|model.json|PRESET")]
    vessel: PathBuf,
    /// Length between perpendiculars of the similar ship [m]
    #[arg(long, value_name = "M")]
    length: f64,
    /// Density of her water [kg/m³] [default: that of the ship]
    #[arg(long, value_name = "KG_M3")]
    density: Option<f64>,
    /// Her draught [m], to be compared with the similar one
    #[arg(long, value_name = "M")]
    draught: Option<f64>,
    /// Refused: a similar ship has the ship's beam over length
    #[arg(long, value_name = "M", hide = true)]
    beam: Option<f64>,
    /// Refused: a similar ship has the ship's block coefficient
    #[arg(long, value_name = "C_B", hide = true)]
    block: Option<f64>,
}

impl Task for Scale {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let form = [("--beam", self.beam.is_some()), ("--block", self.block.is_some())];
        let expected = "the hull form of --vessel; write a ship of other proportions by `seatrial guess`";
        none_given(form, "a hull form", expected)?;
        let size = Size { length_m: self.length, density_kg_m3: self.density, draught_m: self.draught };
        let ship = read_ship(&self.vessel, &mut common.provenance("scale"))?;
        let written = scaled(&ship, &size).map_err(|e| Failure::invalid(&self.vessel, &e))?;
        write(common, &written, Some(&self.vessel))
    }
}

/// Writes a ship from her main dimensions by textbook formulas, with a prior for every free number
#[derive(Parser)]
#[command(
    name = "guess",
    after_help = "Example:\n  guess --length 320 --beam 58 --draught 20.8 --block 0.81 --speed 7.97 --out vessel.toml"
)]
pub struct Guess {
    /// Length between perpendiculars [m]
    #[arg(long, value_name = "M")]
    length: f64,
    /// Moulded breadth [m]
    #[arg(long, value_name = "M")]
    beam: f64,
    /// Draught [m]
    #[arg(long, value_name = "M")]
    draught: f64,
    /// Block coefficient: displaced volume over length, beam and draught
    #[arg(long, value_name = "C_B")]
    block: f64,
    /// Density of the water [kg/m³]
    #[arg(long, value_name = "KG_M3", default_value_t = 1025.0)]
    density: f64,
    /// Service speed [m/s] [default: of usual ships of this block coefficient]
    #[arg(long, value_name = "M_S")]
    speed: Option<f64>,
    /// Mass [kg] [default: of the displaced water]
    #[arg(long, value_name = "KG")]
    mass: Option<f64>,
    /// Diameter of the propeller [m] [default: 0.6 draughts]
    #[arg(long, value_name = "M")]
    propeller_diameter: Option<f64>,
    /// Area of the rudder [m²] [default: by a classification rule]
    #[arg(long, value_name = "M2")]
    rudder_area: Option<f64>,
    /// Height of the rudder [m] [default: 0.75 draughts]
    #[arg(long, value_name = "M")]
    rudder_height: Option<f64>,
}

impl Task for Guess {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let main_dimensions = MainDimensions {
            length_m: self.length,
            beam_m: self.beam,
            draught_m: self.draught,
            block: self.block,
            density_kg_m3: self.density,
            speed_m_s: self.speed,
            mass_kg: self.mass,
            propeller_diameter_m: self.propeller_diameter,
            rudder_area_m2: self.rudder_area,
            rudder_height_m: self.rudder_height,
        };
        let written = guessed(&main_dimensions).map_err(|e| Failure::Usage(format!("guess: {e}")))?;
        write(common, &written, None)
    }
}

/// Writes a ship, not over the file that she was read from.
fn write(common: &Common, written: &Written, read: Option<&PathBuf>) -> Result<Summary, Failure> {
    let out = common.main_output(MAIN, read)?;
    commit(vec![Staged::bytes(&out, written.text.as_bytes())?])?;
    Ok(Summary::of(&out, &written.said, json!({"vessel": written.said})))
}
