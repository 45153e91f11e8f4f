use std::f64::consts::{FRAC_PI_2, TAU};

use schemars::JsonSchema;
use serde::Deserialize;
use ship::engine::Pose;

/// The lattice at sea: nodes, heading levels, and the speeds that a vessel may have at a node.
#[derive(Clone, Debug, PartialEq)]
pub struct Grid {
    /// Nodes eastward.
    pub nx: usize,
    /// Nodes northward.
    pub ny: usize,
    /// Heading levels H; level h points h · 360°/H counter-clockwise from east.
    pub headings: usize,
    /// Distance of neighbouring nodes \[m\].
    pub cell_m: f64,
    /// East and north of node (0, 0) \[m\].
    pub origin_m: [f64; 2],
    /// Speed modes, slowest first.
    pub modes: Vec<Mode>,
}

/// A speed that the vessel holds at a node.
#[derive(Clone, Debug, PartialEq, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Mode {
    /// Its name.
    pub name: String,
    /// Surge speed over the ground \[m/s\]; 0: at rest.
    pub speed_m_s: f64,
}

impl Grid {
    /// Number of layers: heading levels of every mode.
    pub fn layers(&self) -> usize {
        self.headings * self.modes.len()
    }

    /// The layer of a heading level in a mode.
    pub fn layer(&self, level: usize, mode: usize) -> usize {
        mode * self.headings + level
    }

    /// Heading level and mode of a layer.
    pub fn level_and_mode(&self, layer: usize) -> (usize, usize) {
        (layer % self.headings, layer / self.headings)
    }

    /// The layer that results from `layer` by quarter turns to port.
    pub(crate) fn turned(&self, layer: usize, quarters: usize) -> usize {
        let (level, mode) = self.level_and_mode(layer);
        self.layer((level + quarters * self.headings / 4) % self.headings, mode)
    }

    /// Compass heading of a level \[rad\], in (−π, π].
    pub fn heading_rad(&self, level: usize) -> f64 {
        wrap(FRAC_PI_2 - TAU * level as f64 / self.headings as f64)
    }

    /// The level nearest to a compass heading \[rad\].
    pub fn nearest_level(&self, heading_rad: f64) -> usize {
        let turns = (FRAC_PI_2 - heading_rad) / TAU;
        (turns * self.headings as f64).round().rem_euclid(self.headings as f64) as usize
    }

    /// The mode whose speed is nearest to `speed_m_s`; `None` without modes.
    pub fn nearest_mode(&self, speed_m_s: f64) -> Option<usize> {
        let off = |m: &usize| (self.modes[*m].speed_m_s - speed_m_s).abs();
        (0..self.modes.len()).min_by(|a, b| off(a).total_cmp(&off(b)))
    }

    /// North and east of a node displaced by (di, dj) \[m\].
    pub fn displacement(&self, di: i32, dj: i32) -> [f64; 2] {
        [self.cell_m * f64::from(dj), self.cell_m * f64::from(di)]
    }

    /// The pose at a node.
    pub fn pose(&self, i: usize, j: usize, level: usize) -> Pose {
        Pose {
            x: self.origin_m[1] + self.cell_m * j as f64,
            y: self.origin_m[0] + self.cell_m * i as f64,
            psi: self.heading_rad(level),
        }
    }

    /// The shortest step from node to node that points along a level, to within a quarter of the levels' spacing.
    pub fn step_along(&self, level: usize) -> (i32, i32) {
        let (sin, cos) = libm::sincos(TAU * level as f64 / self.headings as f64);
        let off = |(di, dj): (i32, i32)| {
            let angle = libm::atan2(f64::from(dj), f64::from(di));
            wrap(angle - libm::atan2(sin, cos)).abs()
        };
        let tolerance = TAU / self.headings as f64 / 4.0;
        (1..=8)
            .find_map(|reach| {
                ring(reach).filter(|s| off(*s) <= tolerance).min_by(|a, b| off(*a).total_cmp(&off(*b)))
            })
            .unwrap_or((1, 0))
    }
}

/// Displacements that differ from (i, j) by no more than `reach` in either component.
pub(crate) fn around(i: i32, j: i32, reach: i32) -> impl Iterator<Item = (i32, i32)> {
    (i - reach..=i + reach).flat_map(move |di| (j - reach..=j + reach).map(move |dj| (di, dj)))
}

/// Displacements whose larger component is `reach`.
fn ring(reach: i32) -> impl Iterator<Item = (i32, i32)> {
    around(0, 0, reach).filter(move |(di, dj)| di.abs().max(dj.abs()) == reach)
}

/// An angle in (−π, π].
pub(crate) fn wrap(angle: f64) -> f64 {
    let turned = angle.rem_euclid(TAU);
    if turned > TAU / 2.0 { turned - TAU } else { turned }
}
