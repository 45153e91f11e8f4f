use vessel::{Invalid, Pose, Vessel};

use crate::grid::{around, wrap};
use crate::{Autopilot, Grid, Handling, Leg, Phase, Piece, Purpose, Sailed, Ship, Side, sail};

/// What comes before and after an informative maneuver.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Approach {
    /// Steady approach at the maneuver's initial speed, with zero yaw rate \[s\].
    pub run_in_s: f64,
    /// Largest distance from the node at the end of a leg \[m\].
    pub tolerance_m: f64,
    /// Largest difference from the level's heading at the end of a leg \[rad\].
    pub tolerance_rad: f64,
}

/// Everything that legs are made from.
#[derive(Clone, Debug)]
pub struct Repertoire<'a> {
    /// The vessel; its nominal parameters count.
    pub vessel: &'a Vessel,
    /// The lattice.
    pub grid: &'a Grid,
    /// How the vessel is handled.
    pub handling: &'a Handling,
    /// What comes before and after a maneuver.
    pub approach: &'a Approach,
    /// Pieces of maneuvers.
    pub pieces: &'a [Piece],
    /// Signs of the inputs that run a piece to the other side, where the vessel has a mirror image.
    pub mirror: Option<&'a [f64]>,
    /// North and east components of the known mean current \[m/s\].
    pub mean_current_m_s: [f64; 2],
}

impl Repertoire<'_> {
    /// The legs of piece `index`, one per heading level and side: a steady approach, the piece open loop, a recovery onto
    /// the nearest node ahead; simulated in the mean current.
    ///
    /// # Errors
    /// A piece that starts at a speed that no mode has; no node within reach of the maneuver's end.
    pub fn informative(&self, index: usize) -> Result<Vec<Leg>, Invalid> {
        let search = Search { repertoire: self, index };
        let mode = search.mode_of(self.pieces[index].speed_m_s)?;
        let mirrored = (self.mirror.is_some() && !search.is_straight()).then_some(Side::Mirrored);
        let sides = [Side::AsDesigned].into_iter().chain(mirrored);
        let legs = sides.flat_map(|side| (0..self.grid.headings).map(move |level| (level, side)));
        legs.map(|(level, side)| search.leg(level, mode, side)).collect()
    }

    /// Carries out one leg from a node at the origin by the nominal model, as slow or fast as its mode says.
    ///
    /// # Errors
    /// As [`sail`].
    pub fn rehearse(&self, leg: &Leg) -> Result<(Sailed, Pose), Invalid> {
        self.rehearse_with(leg, &self.vessel.nominal, None)
    }

    /// [`Self::rehearse`] by a vessel with other `parameters` than the nominal ones, which the autopilot goes by, from where
    /// an earlier leg left it, off the node and off its speed: `start`.
    ///
    /// # Errors
    /// As [`sail`].
    pub fn rehearse_with(
        &self,
        leg: &Leg,
        parameters: &[f64],
        start: Option<&Astray>,
    ) -> Result<(Sailed, Pose), Invalid> {
        let (level, mode) = self.grid.level_and_mode(leg.from);
        let pose = Pose { x: 0.0, y: 0.0, psi: self.grid.heading_rad(level) };
        let mut ship = Ship::new(self.vessel, parameters, pose, self.grid.modes[mode].speed_m_s);
        if let Some(Astray { pose, state }) = start {
            (ship.pose, ship.state) = (*pose, *state);
        }
        ship.current_m_s = self.mean_current_m_s;
        let mut autopilot = Autopilot::new(self.vessel, &self.vessel.nominal, *self.handling);
        autopilot.known_current_m_s = self.mean_current_m_s;
        let legs = [([0.0, 0.0], leg)];
        let sailed = sail(legs, self.pieces, self.mirror.unwrap_or(&[]), &mut ship, &mut autopilot)?;
        Ok((sailed, ship.pose))
    }

    /// Where `sailed`, a rehearsal of `leg`, ends, seen from the node at which it should.
    pub fn astray(&self, leg: &Leg, sailed: &Sailed) -> Option<Astray> {
        let [north, east] = self.grid.displacement(leg.di, leg.dj);
        let (pose, state) = *sailed.ends.last()?;
        Some(Astray { pose: Pose { x: pose.x - north, y: pose.y - east, ..pose }, state })
    }
}

/// A vessel that is not quite at a node.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Astray {
    /// Where it is, from the node (north, east), and its heading.
    pub pose: Pose,
    /// u, v \[m/s\], r \[rad/s\].
    pub state: [f64; 3],
}

impl Astray {
    /// Distance from the node \[m\].
    pub fn distance_m(&self) -> f64 {
        libm::hypot(self.pose.x, self.pose.y)
    }
}

struct Search<'a> {
    repertoire: &'a Repertoire<'a>,
    index: usize,
}

impl Search<'_> {
    fn piece(&self) -> &Piece {
        &self.repertoire.pieces[self.index]
    }

    /// The mode with the piece's initial speed.
    fn mode_of(&self, speed: f64) -> Result<usize, Invalid> {
        let grid = self.repertoire.grid;
        let off = |m: usize| (grid.modes[m].speed_m_s - speed).abs();
        match grid.nearest_mode(speed) {
            Some(mode) if off(mode) <= 0.05 * speed + 1e-9 => Ok(mode),
            _ => {
                let names = grid.modes.iter().map(|m| format!("`{}` {} m/s", m.name, m.speed_m_s));
                Err(Invalid::new(
                    format!("maneuver `{}`", self.piece().maneuver),
                    format!("a start at {speed} m/s"),
                    format!("the speed of a mode: {}", names.collect::<Vec<_>>().join(", ")),
                    "add a [[speed_mode]] with that speed",
                ))
            }
        }
    }

    /// Whether mirroring the piece leaves it as it is.
    fn is_straight(&self) -> bool {
        let signs = self.repertoire.mirror.unwrap_or(&[]);
        let rows = self.piece().inputs.chunks_exact(signs.len().max(1));
        rows.flat_map(|row| row.iter().zip(signs)).all(|(u, s)| *s > 0.0 || *u == 0.0)
    }

    fn leg(&self, level: usize, mode: usize, side: Side) -> Result<Leg, Invalid> {
        let heading = self.repertoire.grid.heading_rad(level);
        let speed = self.piece().speed_m_s;
        let run_in = speed * self.repertoire.approach.run_in_s;
        let mut leg = Leg {
            purpose: Purpose::Informative { piece: self.index, side },
            from: self.repertoire.grid.layer(level, mode),
            di: 0,
            dj: 0,
            to: 0,
            phases: Vec::new(),
        };
        if run_in > 0.0 {
            let to = [run_in * libm::cos(heading), run_in * libm::sin(heading)];
            leg.phases.push(Phase::Line { to, heading_rad: heading, from_m_s: speed, to_m_s: speed });
        }
        leg.phases.push(Phase::Maneuver);
        let (end, speed) = self.simulate(&leg)?;
        let mut ends = self.ends(end, speed);
        ends.sort_by(|a, b| a.0.total_cmp(&b.0));
        for (_, di, dj, layer) in ends {
            let candidate =
                Leg { di, dj, to: layer, phases: self.recovered(&leg, di, dj, layer, speed), ..leg.clone() };
            let (end, _) = self.simulate(&candidate)?;
            if self.is_at_node(end, &candidate) {
                return Ok(candidate);
            }
        }
        Err(Invalid::new(
            format!("maneuver `{}` at heading level {level}", self.piece().maneuver),
            format!("no node that the vessel recovers to within {} m", self.repertoire.approach.tolerance_m),
            "a node ahead of its end",
            "raise `approach.tolerance_cells` or `approach.tolerance_deg`, or take another `cell_m` or more headings",
        ))
    }

    /// Pose and surge speed at the end of a leg from the origin.
    fn simulate(&self, leg: &Leg) -> Result<(Pose, f64), Invalid> {
        let (sailed, end) = self.repertoire.rehearse(leg)?;
        Ok((end, sailed.ends.last().map_or(0.0, |(_, state)| state[0])))
    }

    /// Nodes to recover to from `end`, with what each costs: distance, and twice what lies across.
    fn ends(&self, end: Pose, speed: f64) -> Vec<(f64, i32, i32, usize)> {
        let Repertoire { grid, handling, .. } = self.repertoire;
        let Some(mode) = grid.nearest_mode(speed) else { return Vec::new() };
        let at_rest = grid.modes[mode].speed_m_s == 0.0;
        let (nearest, h) = (grid.nearest_level(end.psi), grid.headings);
        let mut levels = vec![nearest, (nearest + 1) % h, (nearest + h - 1) % h];
        levels.dedup();
        let cell = grid.cell_m;
        let far = (4.0 + (4.0 * handling.lookahead_m / cell).ceil()).min(grid.nx.max(grid.ny) as f64) as i32;
        let reach = if at_rest { 1 } else { far };
        let [i, j] = [(end.y / cell).round() as i32, (end.x / cell).round() as i32];
        let mut found = Vec::new();
        for level in levels {
            let heading = grid.heading_rad(level);
            let swing = wrap(heading - end.psi).abs() * handling.lookahead_m;
            for (di, dj) in around(i, j, reach) {
                let [north, east] = grid.displacement(di, dj);
                let [north, east] = [north - end.x, east - end.y];
                let ahead = north * libm::cos(heading) + east * libm::sin(heading);
                let across = (north * libm::sin(heading) - east * libm::cos(heading)).abs();
                if at_rest || (ahead > 0.0 && across <= 1.5 * cell) {
                    found.push((ahead.abs() + 2.0 * across + swing, di, dj, grid.layer(level, mode)));
                }
            }
        }
        found
    }

    fn recovered(&self, leg: &Leg, di: i32, dj: i32, layer: usize, speed: f64) -> Vec<Phase> {
        let Repertoire { grid, handling, .. } = self.repertoire;
        let (level, mode) = grid.level_and_mode(layer);
        let (to, heading_rad) = (grid.displacement(di, dj), grid.heading_rad(level));
        let from_m_s = speed.max(handling.crawl_m_s);
        let mut phases = leg.phases.clone();
        phases.push(match grid.modes[mode].speed_m_s {
            0.0 => Phase::Hold { at: to, heading_rad },
            to_m_s => Phase::Line { to, heading_rad, from_m_s, to_m_s },
        });
        phases
    }

    fn is_at_node(&self, end: Pose, leg: &Leg) -> bool {
        let Repertoire { grid, approach, .. } = self.repertoire;
        let [north, east] = grid.displacement(leg.di, leg.dj);
        let (level, _) = grid.level_and_mode(leg.to);
        let off = libm::hypot(end.x - north, end.y - east);
        let turned = wrap(end.psi - grid.heading_rad(level)).abs();
        off <= approach.tolerance_m && turned <= approach.tolerance_rad
    }
}
