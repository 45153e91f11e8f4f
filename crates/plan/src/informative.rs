use refusal::Invalid;
use ship::engine::Pose;

use crate::leg::{around, wrap};
use crate::repertoire::{Best, Farthest, Outcome, Settled, Unsettled};
use crate::sampled_vessel::{Crew, Failed, Underway};
use crate::{Leg, Phase, Purpose, Repertoire, Sailed, SampledVessel, Side};
use trial::Piece;

/// How often a run-in is lengthened, and by which factor, before a maneuver is given up.
const RUN_INS: i32 = 7;
const LONGER: f64 = 1.5;
/// Nodes that are tried for a recovery: the nearest ones, then as many sampled from the others.
const NEAREST: usize = 40;
const FARTHER: usize = 20;
/// Most recoveries that are offered of a maneuver besides the first one, and nodes that are tried for each.
const FURTHER: usize = 12;
const TRIED: usize = 6;

impl Repertoire<'_> {
    /// The legs of piece `index` from a heading level, to either side: a steady approach until all `others` are
    /// settled, the piece, a recovery onto the first node ahead where all of them settle. Further legs recover onto
    /// other lines of the lattice near the end of the piece.
    ///
    /// # Errors
    /// A piece that starts at a speed that no mode has; as [`crate::simulate_legs`].
    pub fn informative(
        &self,
        index: usize,
        level: usize,
        others: &[SampledVessel],
    ) -> Result<Vec<Outcome>, Invalid> {
        let from = self.grid.layer(level, self.mode_of(index)?);
        let search = ManeuverSearch { repertoire: self, index, from };
        let mirrored = (self.mirror.is_some() && !search.is_straight()).then_some(Side::Mirrored);
        let sides = [Side::AsDesigned].into_iter().chain(mirrored);
        let legs = sides.map(|side| search.legs(side, others)).collect::<Result<Vec<_>, _>>()?;
        Ok(legs.into_iter().flatten().collect())
    }

    /// The mode that piece `index` begins in.
    ///
    /// # Errors
    /// No mode has the piece's speed.
    pub fn mode_of(&self, index: usize) -> Result<usize, Invalid> {
        let Piece { maneuver, speed_m_s: speed, .. } = &self.pieces[index];
        let off = |m: usize| (self.grid.modes[m].speed_m_s - speed).abs();
        match self.grid.nearest_mode(*speed) {
            Some(mode) if off(mode) <= 0.05 * speed + 1e-9 => Ok(mode),
            _ => {
                let names = self.grid.modes.iter().map(|m| format!("`{}` {} m/s", m.name, m.speed_m_s));
                Err(Invalid::new(
                    format!("maneuver `{maneuver}`"),
                    format!("a start at {speed} m/s"),
                    format!("the speed of a mode: {}", names.collect::<Vec<_>>().join(", ")),
                    "add a [[speed_mode]] with that speed",
                ))
            }
        }
    }
}

struct ManeuverSearch<'a> {
    repertoire: &'a Repertoire<'a>,
    /// Index of the piece.
    index: usize,
    /// Layer at the beginning.
    from: usize,
}

/// A maneuver that all vessels have run, before its recovery.
struct ManeuverRun<'a> {
    leg: Leg,
    sailed: Sailed,
    crew: Crew<'a>,
    tracks: Vec<Vec<Pose>>,
}

impl ManeuverRun<'_> {
    /// The leg with the recoveries of all vessels.
    fn with(&self, recovered: Settled) -> Settled {
        let (mut leg, mut sailed, mut tracks) = (self.leg.clone(), self.sailed.clone(), self.tracks.clone());
        let Settled { leg: Leg { di, dj, to, phases, .. }, sailed: last, tracks: rest, farthest } = recovered;
        sailed.samples.extend(last.samples);
        sailed.ends = last.ends;
        tracks.iter_mut().zip(rest).for_each(|(track, last)| track.extend(last));
        leg.phases.extend(phases);
        Settled { leg: Leg { di, dj, to, ..leg }, sailed, tracks, farthest }
    }
}

/// A node to recover to.
#[derive(Clone, Copy, Debug)]
struct Node {
    /// Distance from the nominal vessel \[mm\], with the component across counted twice. Then what decides between equal ones,
    /// as seen by the vessel and thus in any quarter: how far ahead and across \[mm\], and which heading.
    order: [i64; 4],
    di: i32,
    dj: i32,
    layer: usize,
}

/// A line of nodes along a heading level: which of the parallel ones.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Lane {
    level: usize,
    across: i32,
}

impl ManeuverSearch<'_> {
    fn piece(&self) -> &Piece {
        &self.repertoire.pieces[self.index]
    }

    /// Whether the piece is its own mirror image.
    fn is_straight(&self) -> bool {
        let signs = self.repertoire.mirror.unwrap_or(&[]);
        let rows = self.piece().inputs.chunks_exact(signs.len().max(1));
        rows.flat_map(|row| row.iter().zip(signs)).all(|(u, s)| *s > 0.0 || *u == 0.0)
    }

    fn legs(&self, side: Side, others: &[SampledVessel]) -> Result<Vec<Outcome>, Invalid> {
        let (from, purpose) = (self.from, Purpose::Informative { piece: self.index, side });
        let mut all = others.to_vec();
        all.extend(self.farthest(&purpose)?);
        let unsettled = |when: &str, failed| {
            Ok(vec![Err(Unsettled::of((from, purpose.clone()), when.to_owned(), failed, &all))])
        };
        let mut crew = self.repertoire.crew(from, &all)?;
        let run = match self.run_in(&purpose, &mut crew)? {
            Ok(run_in) => self.run(run_in, &mut crew)?,
            Err(failed) => return unsettled("before the maneuver ", failed),
        };
        let recovered = match run {
            Ok(run) => self.recovered(run)?,
            Err(failed) => Err(failed),
        };
        let with_farthest = |settled| Ok(Settled { farthest: farthest(&settled, &all), ..settled });
        match recovered {
            Ok(legs) => Ok(legs.into_iter().map(with_farthest).collect()),
            Err(failed) => unsettled("", failed),
        }
    }

    /// The vessels that end the maneuver farthest off, after its shortest approach.
    fn farthest(&self, purpose: &Purpose) -> Result<Vec<SampledVessel>, Invalid> {
        let (mut approached, _) = self.approach(purpose, self.repertoire.approach.run_in_s);
        approached.phases.push(Phase::Maneuver);
        self.repertoire.farthest(&approached)
    }

    /// A steady approach of so many seconds, at rest a hold, and where it ends.
    fn approach(&self, purpose: &Purpose, seconds: f64) -> (Leg, [f64; 2]) {
        let (level, _) = self.repertoire.grid.level_and_mode(self.from);
        let heading_rad = self.repertoire.grid.heading_rad(level);
        let speed = self.piece().speed_m_s;
        let way = speed * seconds;
        let to = [way * libm::cos(heading_rad), way * libm::sin(heading_rad)];
        let phases = match (speed, way) {
            (0.0, _) => vec![Phase::Hold { at: [0.0; 2], heading_rad }],
            (_, 0.0) => Vec::new(),
            _ => vec![Phase::Line { to, heading_rad, from_m_s: speed, to_m_s: speed }],
        };
        let purpose = purpose.clone();
        (Leg { purpose, from: self.from, di: 0, dj: 0, to: self.from, phases }, to)
    }

    /// The shortest steady approach after which all are settled.
    fn run_in(&self, purpose: &Purpose, crew: &mut Crew) -> Result<Result<Leg, Failed>, Invalid> {
        let (least, response) = (self.repertoire.approach.run_in_s, self.repertoire.handling.response_s);
        let tries = if self.piece().speed_m_s == 0.0 { 1 } else { RUN_INS };
        let mut best = Failed::LOST;
        for longer in 0..tries {
            let seconds = if longer == 0 { least } else { least.max(response) * LONGER.powi(longer) };
            let (leg, to) = self.approach(purpose, seconds);
            match self.approached(&leg, to, crew)? {
                Ok(()) => return Ok(Ok(leg)),
                Err(failed) => best = best.or(failed),
            }
        }
        Ok(Err(best))
    }

    /// Whether all are settled at `place` after an approach.
    fn approached(&self, leg: &Leg, place: [f64; 2], crew: &mut Crew) -> Result<Result<(), Failed>, Invalid> {
        let tolerance = self.repertoire.approach.tolerance.ended();
        let settled = |end| {
            let used = self.repertoire.used_at(&tolerance, leg.from, place, end);
            if used.part() > 1.0 { Err(used) } else { Ok(()) }
        };
        let (_, end) = self.repertoire.track(leg, &mut crew.nominal.clone())?;
        Ok(settled(end).map_err(Failed::from).and_then(|()| {
            let others = crew.each(|mut underway| {
                let (_, end) = self.repertoire.track(leg, &mut underway)?;
                settled(end)
            });
            others.map(|_| ())
        }))
    }

    /// Approach and maneuver, by all vessels.
    fn run<'a>(&self, mut leg: Leg, crew: &mut Crew<'a>) -> Result<Result<ManeuverRun<'a>, Failed>, Invalid> {
        leg.phases.push(Phase::Maneuver);
        let mut nominal = crew.nominal.clone();
        let sailed = self.repertoire.simulated(&leg, &mut nominal)?;
        let others = crew.each(|mut underway| {
            let (mut poses, _) = self.repertoire.track(&leg, &mut underway)?;
            // The recovery begins at the last pose.
            poses.pop();
            Ok((poses, underway))
        });
        Ok(others.map(|others| {
            let (tracks, ends) = others.into_iter().unzip();
            ManeuverRun { leg, sailed, crew: Crew::new(nominal, ends), tracks }
        }))
    }

    /// Legs with recoveries on which all of them settle: onto the first such node, and onto the first such node of the
    /// nearest other lanes. From these the search for a plan chooses.
    fn recovered(&self, mut run: ManeuverRun) -> Result<Result<Vec<Settled>, Failed>, Invalid> {
        let speed = run.crew.nominal.ship.state[0];
        let nodes = self.nodes(&run.crew, speed);
        let step = nodes.len().saturating_sub(NEAREST).div_ceil(FARTHER).max(1);
        let some = nodes.iter().take(NEAREST).chain(nodes.iter().skip(NEAREST).step_by(step));
        let (node, first) = match self.first_settled(&mut run, some, speed)? {
            Ok(ends) => ends,
            Err(best) => return Ok(Err(best.failed(self.repertoire, &run.crew))),
        };
        let (mut legs, straight) = (vec![first], self.lane(node));
        for lane in self.lanes(&nodes).into_iter().filter(|lane| *lane != straight).take(FURTHER) {
            let some = nodes.iter().filter(|node| self.lane(**node) == lane).take(TRIED);
            legs.extend(self.first_settled(&mut run, some, speed)?.ok().map(|(_, leg)| leg));
        }
        Ok(Ok(legs))
    }

    /// The first of `nodes` where all of them settle, and the leg with that recovery.
    fn first_settled<'n>(
        &self,
        run: &mut ManeuverRun,
        nodes: impl Iterator<Item = &'n Node>,
        speed: f64,
    ) -> Result<Result<(Node, Settled), Best>, Invalid> {
        let mut best = Best::NONE;
        for node in nodes {
            let recovery = self.recovery(&run.leg, *node, speed);
            match self.repertoire.all_settle(&recovery, &mut run.crew)? {
                Ok(recovered) => return Ok(Ok((*node, run.with(recovered)))),
                Err(failed) => best = best.or(failed, recovery),
            }
        }
        Ok(Err(best))
    }

    /// The lane of a node on its heading.
    fn lane(&self, node: Node) -> Lane {
        let (level, _) = self.repertoire.grid.level_and_mode(node.layer);
        let (di, dj) = self.repertoire.grid.step_along(level);
        Lane { level, across: node.di * dj - node.dj * di }
    }

    /// The lanes of these nodes, in their order.
    fn lanes(&self, nodes: &[Node]) -> Vec<Lane> {
        let mut lanes = Vec::new();
        for lane in nodes.iter().map(|node| self.lane(*node)) {
            if !lanes.contains(&lane) {
                lanes.push(lane);
            }
        }
        lanes
    }

    /// The recovery of `leg` onto a node, as a leg of its own.
    fn recovery(&self, leg: &Leg, node: Node, speed: f64) -> Leg {
        let Repertoire { grid, handling, .. } = self.repertoire;
        let Node { di, dj, layer, .. } = node;
        let (level, mode) = grid.level_and_mode(layer);
        let (to, heading_rad) = (grid.displacement(di, dj), grid.heading_rad(level));
        let phase = match grid.modes[mode].speed_m_s {
            0.0 => Phase::Hold { at: to, heading_rad },
            to_m_s => Phase::Line { to, heading_rad, from_m_s: speed.max(handling.crawl_m_s), to_m_s },
        };
        Leg { di, dj, to: layer, phases: vec![phase], ..leg.clone() }
    }

    /// Nodes that all of them can recover to, cheapest first.
    fn nodes(&self, crew: &Crew, speed: f64) -> Vec<Node> {
        let Repertoire { grid, handling, .. } = self.repertoire;
        let Some(mode) = grid.nearest_mode(speed) else { return Vec::new() };
        let at_rest = grid.modes[mode].speed_m_s == 0.0;
        let end = crew.nominal.ship.pose;
        let (nearest, h) = (grid.nearest_level(end.psi), grid.headings);
        let mut levels = vec![nearest, (nearest + 1) % h, (nearest + h - 1) % h];
        levels.dedup();
        let cell = grid.cell_m;
        let off = crew.others.iter().map(|one| libm::hypot(one.ship.pose.x - end.x, one.ship.pose.y - end.y));
        let spread = off.fold(0.0, f64::max);
        let lookahead = if at_rest { 0.0 } else { 6.0 * handling.lookahead_m };
        let far = (2.0 + ((spread + lookahead) / cell).ceil()).min(grid.nx.max(grid.ny) as f64) as i32;
        let [i, j] = [(end.y / cell).round() as i32, (end.x / cell).round() as i32];
        let all = || [&crew.nominal].into_iter().chain(&crew.others);
        let mut nodes = Vec::new();
        for (turn, level) in levels.into_iter().enumerate() {
            let heading = grid.heading_rad(level);
            let swing = wrap(heading - end.psi).abs() * handling.lookahead_m;
            for (di, dj) in around(i, j, far) {
                let place = grid.displacement(di, dj);
                let [ahead, across] = seen(end, place, heading);
                let cost = ahead.abs() + 2.0 * across.abs() + swing;
                let reached = |one: &Underway| {
                    let [ahead, across] = seen(one.ship.pose, place, heading);
                    ahead > 0.5 * across.abs()
                };
                if at_rest || (across.abs() <= 1.5 * cell && all().all(reached)) {
                    let [cost, ahead, across] = [cost, ahead, across].map(|m| (1e3 * m).round() as i64);
                    let order = [cost, ahead, across, turn as i64];
                    nodes.push(Node { order, di, dj, layer: grid.layer(level, mode) });
                }
            }
        }
        nodes.sort_by_key(|node| node.order);
        nodes
    }
}

/// The one of `others`, whose tracks these are, that is farthest from the nominal vessel at the end of its maneuver.
fn farthest(Settled { sailed, tracks, .. }: &Settled, others: &[SampledVessel]) -> Option<Farthest> {
    let open = sailed.samples.iter().rposition(|s| s.informative)?;
    let open_end = sailed.samples[open].pose;
    let off = |(track, who): (&Vec<Pose>, &SampledVessel)| {
        let pose = track.get(open)?;
        let distance_m = libm::hypot(pose.x - open_end.x, pose.y - open_end.y);
        Some(Farthest { distance_m, parameters: who.parameters.clone() })
    };
    let all = tracks.iter().zip(others).filter_map(off);
    all.reduce(|most, astray| if astray.distance_m > most.distance_m { astray } else { most })
}

/// The displacement of a place from a vessel on `heading`, ahead and across.
fn seen(from: Pose, [north, east]: [f64; 2], heading: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(heading);
    let [north, east] = [north - from.x, east - from.y];
    [north * cos + east * sin, north * sin - east * cos]
}
