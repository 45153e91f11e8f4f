//! What closes the water: the traffic's directions, chart classes, the area's edge.

use std::collections::BTreeSet;

use chart::{Causes, Class, Closing, Footprint, Obstacles, Traffic};
use refusal::Invalid;
use ship::engine::Pose;

use super::prepared::Prepared;
use super::settled_legs::SettledLeg;
use super::waters::Waters;

/// Distance of places on a track between which its course is found, in raster cells.
const APART: f64 = 0.5;

impl Prepared {
    /// The directions of the traffic, each once.
    pub(super) fn directions(&self) -> Vec<Traffic> {
        let mut all: Vec<Traffic> = Vec::new();
        for (traffic, _) in self.chart.traffic() {
            if !all.contains(&traffic) {
                all.push(traffic);
            }
        }
        all
    }

    /// What the hull of the nominal vessel sweeps on courses over ground that each of these directions does not admit: their
    /// indices, and the cells.
    pub(super) fn against(
        &self,
        settled: &SettledLeg,
        directions: &[Traffic],
        cell_m: f64,
    ) -> Result<Vec<(usize, Footprint)>, Invalid> {
        if directions.is_empty() {
            return Ok(Vec::new());
        }
        let poses = settled.sailed.samples.iter().map(|s| s.pose).chain([settled.end]);
        // On the spot she has no course.
        let mut track: Vec<Pose> = Vec::new();
        for pose in poses {
            let moved = |last: &Pose| libm::hypot(pose.x - last.x, pose.y - last.y);
            if track.last().is_none_or(|last| moved(last) >= APART * cell_m) {
                track.push(pose);
            }
        }
        let (hull, crossing_rad) = (self.brief.task.hull.outline(), self.brief.task.crossing_rad);
        let mut against = Vec::new();
        for (index, traffic) in directions.iter().enumerate() {
            let mut swept: Option<Footprint> = None;
            for pair in track.windows(2) {
                let [from, to] = [pair[0], pair[1]];
                if traffic.admits(libm::atan2(to.y - from.y, to.x - from.x), crossing_rad) {
                    continue;
                }
                let part = Footprint::swept(&hull, &[from, to].map(|p| (p.y, p.x, p.psi)), cell_m)?;
                swept = Some(swept.map_or_else(|| part.clone(), |so_far| so_far.union(&part)));
            }
            against.extend(swept.map(|swept| (index, swept)));
        }
        Ok(against)
    }
}

/// Classes that are tried one by one.
const TRIED: usize = 8;

impl Prepared {
    /// How many moves of every maneuver have room, with and without the classes of the chart that close it, in words; empty where
    /// no class does.
    pub(super) fn room_by_class(&self, waters: &Waters) -> Result<String, Invalid> {
        let is_class = |what: &str| chart::enc::class(what).is_some();
        let closing = self.chart.polygons().iter();
        let closing = closing.filter(|p| matches!(p.class, Class::TransitOnly | Class::NoGo));
        let classes: BTreeSet<&str> = closing.map(|p| p.called.what).filter(|what| is_class(what)).collect();
        let classes = Vec::from_iter(classes);
        let named = |all: &[&str]| all.join(" and ");
        let counted = |open: &[&str]| self.moves_without(open, waters);
        let now = counted(&[])?;
        let mut tried = Vec::new();
        for one in classes.iter().take(TRIED) {
            tried.push((vec![*one], counted(&[*one])?));
        }
        if classes.len() > 1 {
            tried.push((classes.clone(), counted(&classes)?));
        }
        let (mut text, mut remedy) = (String::new(), None);
        for (maneuver, wanted) in self.wanted.iter().enumerate() {
            let more = tried.iter().filter(|(_, moves)| moves[maneuver] > now[maneuver]);
            remedy = remedy.or_else(|| more.clone().next()?.0.first());
            let more = more.map(|(open, moves)| format!("without {} {}", named(open), moves[maneuver]));
            let more: Vec<String> = more.collect();
            if !more.is_empty() {
                let (name, now, more) = (&wanted.piece.maneuver, now[maneuver], more.join(", "));
                text += &format!("; `{name}` has room for {now} moves, {more}");
            }
        }
        if let Some(class) = remedy {
            text += &format!(" (`rules`, such as `rules = {{ {class} = \"ignore\" }}`)");
        }
        Ok(text)
    }

    /// How many moves of every maneuver have room if ships may be in the areas of some classes.
    fn moves_without(&self, open: &[&str], waters: &Waters) -> Result<Vec<usize>, Invalid> {
        let (task, chart) = (&self.brief.task, self.chart.without(open));
        let raster = task.raster(&self.grid);
        let obstacles = Obstacles::new(&chart, raster, task.safety.trial_depth_m, task.safety.margin_m)?;
        let mut moves = vec![0; self.wanted.len()];
        for (index, leg) in self.legs.iter().enumerate() {
            if let Some(piece) = leg.leg.purpose.piece() {
                moves[piece] += waters.count_among(index, &obstacles, open.is_empty());
            }
        }
        Ok(moves)
    }
}

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
            closing.iter().take(NAMED).map(|cause| words(cause, percent(cause.places))).collect();
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
