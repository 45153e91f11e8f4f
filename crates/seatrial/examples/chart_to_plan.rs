//! A chart to a plan: four maneuvers off Helsinki as one walk, proved to be the cheapest, checked at sea, and as a route.

use std::error::Error;
use std::path::Path;

use seatrial::{ChartedTrial, DictionaryFile, Generator, Search, Vessel, undisturbed};

fn main() -> Result<(), Box<dyn Error>> {
    let vessel = Vessel::from_file(include_str!("../../../pipelines/helsinki/vessel.toml").parse()?)?;
    let maneuvers: DictionaryFile = include_str!("../../../pipelines/helsinki/dictionary.toml").parse()?;
    let generator = Generator::without_tables(&vessel, &maneuvers)?;
    let dictionary = undisturbed(&vessel, &generator, vessel.best_known(), "dictionary")?;

    let config = Path::new(concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines/helsinki/plan.toml"));
    let mut trial = ChartedTrial::read(config, vessel, dictionary, None)?;
    // What depends on the ship is sailed by commands.
    for (index, maneuver) in generator.maneuvers().iter().enumerate() {
        let commands = generator.program(index, generator.samples(index)?)?;
        trial.brief.programs.extend(commands.map(|own| (maneuver.name.clone(), own)));
    }
    // For a quick example: each maneuver once, and a check with few currents.
    trial.brief.task.maneuvers.iter_mut().for_each(|maneuver| maneuver.count = Some(1));
    trial.brief.task.safety.runs = Some(48);

    let planned = trial.plan(&Search::unlimited(), false)?;
    println!("{}", planned.document.statement);
    let check = &planned.sailing.check;
    println!(
        "{:.0} s at sea, {:.0} m clear, {} of {} runs aground",
        check.sailed_s, check.clearance_m, check.aground, check.runs
    );
    for leg in planned.document.voyage.iter().flat_map(|voyage| &voyage.legs) {
        println!("{:6.0} s  {}", leg.start_s, leg.name);
    }
    let routes = planned.routes().ok_or("a plan without a part at sea")?;
    for (name, content) in routes.files("route").map_err(|(name, invalid)| format!("{name}: {invalid}"))? {
        println!("{name}: {} bytes", content.len());
    }
    Ok(())
}
