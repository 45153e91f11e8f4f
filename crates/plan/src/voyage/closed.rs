//! What closes a lattice on which the ship has room nowhere, and the keys that would open it.

use chart::{Causes, Closing};

use super::prepared::Prepared;
use super::waters::Waters;

/// Nodes that are looked at, evenly spread, and kinds of dangers that are named.
const NODES: usize = 400;
const NAMED: usize = 3;

impl Prepared {
    /// What closes the nodes for a ship in transit, in words. `room_m` is the clearance of a node, without the hull.
    pub(super) fn closed_by(&self, waters: &Waters, room_m: impl Fn([f64; 2]) -> f64) -> String {
        let (grid, task) = (&self.grid, &self.brief.task);
        let place = |k: usize| {
            let at = grid.pose(k % grid.nx, k / grid.nx, 0);
            [at.y, at.x]
        };
        let all = grid.nx * grid.ny;
        let places: Vec<[f64; 2]> = (0..all).step_by(all.div_ceil(NODES)).map(place).collect();
        let percent = |closed: usize| 100.0 * closed as f64 / places.len() as f64;
        let reach_m = task.hull.outline().iter().map(|[x, y]| libm::hypot(*x, *y)).fold(0.0, f64::max);
        let dangers = self.chart.dangers(task.safety.transit_depth_m);
        let closing = dangers.closing(&places, task.safety.margin_m + reach_m);
        let mut said: Vec<String> =
            closing.iter().take(NAMED).map(|own| words(own, percent(own.places))).collect();
        if closing.len() > NAMED {
            said.push(format!("{} more kinds", closing.len() - NAMED));
        }
        let outside = places.iter().filter(|place| !waters.holds(**place)).count();
        if outside > 0 {
            said.push(format!("{:.0} % by the edge (`area`)", percent(outside)));
        }
        let clearest_m = places.iter().map(|place| room_m(*place)).fold(0.0, f64::max);
        if clearest_m > 0.0 {
            said.push(format!("{clearest_m:.0} m clear at most (`safety.margin_m`)"));
        }
        said.join(", ")
    }
}

/// A kind of dangers, how many nodes it closes, and what would open them.
fn words(closing: &Closing, percent: f64) -> String {
    let name = closing.called.name.as_ref().map_or_else(String::new, |name| format!(" {name}"));
    let deepest = closing.called.depth_m.map_or_else(String::new, |depth| format!(" of at most {depth} m"));
    let rule = closing.rule().map(|class| format!("`rules = {{ {class} = \"ignore\" }}`"));
    let keys = match closing.cause {
        Causes::SHOAL => Some("`safety.transit_depth_m`".to_owned()).into_iter().chain(rule).collect(),
        Causes::UNCHARTED => vec!["`uncharted`".to_owned()],
        _ => rule.into_iter().collect::<Vec<_>>(),
    };
    let keys = if keys.is_empty() { String::new() } else { format!(" ({})", keys.join(" or ")) };
    format!("{percent:.0} % by {}{name}{deepest}{keys}", closing.called.what)
}
