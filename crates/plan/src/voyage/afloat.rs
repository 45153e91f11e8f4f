//! Positions of a ship on the chart.

use refusal::Invalid;

use super::error::VoyageError;
use super::follow::ShipPosition;
use super::task::Brief;

impl Brief {
    /// Why positions cannot be of the ship: the first that is on land, or in what a ship in transit keeps clear of, with the
    /// charted object; `None` where all are in water.
    ///
    /// # Errors
    /// Those of the area and its charts, as [`super::Prepared::new`] has them; the end of the time.
    pub fn aground(
        &self,
        positions: &[ShipPosition],
        keep_going: &dyn Fn() -> bool,
    ) -> Result<Option<Invalid>, VoyageError> {
        let drift_m = self.drift_m(&self.wanted()?);
        let (chart, _) = self.task.ground(&self.vessel, &self.layers, drift_m, keep_going)?;
        let places: Vec<[f64; 2]> = positions.iter().map(|own| own.place).collect();
        let dangers = chart.dangers(self.task.safety.transit_depth_m);
        let Some((first, called)) = dangers.first_inside(&places) else { return Ok(None) };
        let (longitude, latitude) = chart.plane().to_geographic(places[first]);
        let thing = format!("line {}", positions[first].line);
        let found = format!("longitude {longitude:.5}, latitude {latitude:.5} in `{called}`");
        let expected = "a position in water that the ship may pass";
        let remedy = "correct positions and chart: one of them is displaced";
        Ok(Some(Invalid::new(thing, found, expected, remedy)))
    }
}
