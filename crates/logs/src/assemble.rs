use std::ops::Range;

use crate::prepare::{MOST_ROWS, prepare};
use crate::samples::Values;
use crate::{Channels, Conventions, Method, Samples, Series, Unassembled, body_velocity, euler};

/// A recording on one clock. All channels have `grid.rows` values, NaN where unknown.
#[derive(Clone, Debug, PartialEq)]
pub struct Assembled {
    /// The clock.
    pub grid: Grid,
    /// Surge, sway \[m/s\] and yaw rate \[rad/s\].
    pub measured: [Samples; 3],
    /// The requested inputs and measured disturbances.
    pub exogenous: Vec<Samples>,
    /// The requested further channels.
    pub further: Vec<Samples>,
    /// The sections in which all but the further channels are known.
    pub sections: Vec<Section>,
}

/// Puts measured channels on one clock: [`prepare`], velocities, averages, linear interpolation, sections.
/// The clock starts where the last of the needed channels does: `exogenous` are the inputs and measured
/// disturbances, `further` channels may be absent at some samples.
///
/// # Errors
/// See [`Unassembled`].
pub fn assemble(
    channels: Channels,
    conventions: &Conventions,
    exogenous: &[&str],
    further: &[&str],
) -> Result<Assembled, Unassembled> {
    on_one_clock(prepare(channels, conventions)?, conventions, [exogenous, further], MOST_ROWS)
}

/// [`assemble`] for prepared channels, on at most `most_rows` rows. Each channel is dropped once it is on the
/// common clock: a long recording does not fit into memory twice.
pub(crate) fn on_one_clock(
    channels: Channels,
    conventions: &Conventions,
    [exogenous, further]: [&[&str]; 2],
    most_rows: usize,
) -> Result<Assembled, Unassembled> {
    let needed = sources(&channels).into_iter().chain(exogenous.iter().copied());
    let grid = common_clock(&channels, needed, conventions.rate_hz)?;
    if grid.rows > most_rows {
        return Err(Unassembled::TooLong { rows: grid.rows, most: most_rows });
    }
    let mut on_grid = OnGrid { channels, conventions, grid };
    let measured = on_grid.velocities()?;
    on_grid.keep(|name| exogenous.contains(&name) || further.contains(&name));
    let exogenous = on_grid.all(exogenous, further)?;
    let further = on_grid.all(further, &[])?;
    let sections = sections(&measured, &exogenous);
    if sections.is_empty() {
        return Err(Unassembled::NoOverlap);
    }
    Ok(Assembled { grid, measured, exogenous, further, sections }.trimmed())
}

impl Assembled {
    /// How many gaps split it: between sections, and between these and isolated rows before the first or after the last.
    pub(crate) fn splits(&self) -> usize {
        let (Some(first), Some(last)) = (self.sections.first(), self.sections.last()) else { return 0 };
        let is_known = |channel: &Samples| channel.range(0..1).next().is_some_and(f64::is_finite);
        let before = first.start > 0 && self.measured.iter().chain(&self.exogenous).all(is_known);
        let after = last.start + last.samples + 1 < self.grid.rows;
        self.sections.len() - 1 + usize::from(before) + usize::from(after)
    }

    /// Without the last rows at which the states are not known.
    fn trimmed(mut self) -> Self {
        let mut values = all(&self.measured);
        let known = (0..self.measured[0].len()).filter(|_| next_known(&mut values));
        let rows = known.last().map_or(0, |row| row + 1);
        self.grid.rows = rows;
        let channels = self.measured.iter_mut().chain(&mut self.exogenous).chain(&mut self.further);
        channels.for_each(|channel| channel.truncate(rows));
        self
    }
}

/// The channels that surge, sway and yaw rate come from.
pub(crate) fn sources(channels: &Channels) -> Vec<&'static str> {
    let measured: Vec<&str> =
        ["y_u", "y_v", "y_r"].into_iter().filter(|name| channels.contains_key(*name)).collect();
    let positions: &[&str] = match measured.as_slice() {
        ["y_u", "y_v", "y_r"] => &[],
        ["y_u", "y_v"] => &["psi"],
        _ => &["x", "y", "psi"],
    };
    measured.into_iter().chain(positions.iter().copied()).collect()
}

fn common_clock<'a>(
    channels: &Channels,
    needed: impl Iterator<Item = &'a str>,
    rate_hz: f64,
) -> Result<Grid, Unassembled> {
    let (mut start, mut end) = (f64::NEG_INFINITY, f64::INFINITY);
    for name in needed {
        let t = &channels.get(name).ok_or_else(|| Unassembled::NoChannel(name.to_owned()))?.t;
        let (Some(first), Some(last)) = (t.first(), t.last()) else {
            return Err(Unassembled::Empty(name.to_owned()));
        };
        start = start.max(first);
        end = end.min(last);
    }
    // One row more, because the last state needs no inputs.
    Ok(Grid::new(start, end + 1.0 / rate_hz, rate_hz))
}

struct OnGrid<'a> {
    channels: Channels,
    conventions: &'a Conventions,
    grid: Grid,
}

impl OnGrid<'_> {
    fn series(&self, name: &str) -> Result<&Series, Unassembled> {
        self.channels.get(name).ok_or_else(|| Unassembled::NoChannel(name.to_owned()))
    }

    fn resampled(&self, series: &Series) -> Samples {
        let on_grid = |series: &Series| series.values.made(series.at(self.grid.times()));
        match self.conventions.average_s {
            Some(width_s) => on_grid(&series.averaged(width_s)),
            None => on_grid(series),
        }
    }

    fn named(&self, name: &str) -> Result<Samples, Unassembled> {
        self.series(name).map(|series| self.resampled(series))
    }

    fn keep(&mut self, wanted: impl Fn(&str) -> bool) {
        self.channels.retain(|name, _| wanted(name));
    }

    /// The channels called `names`; those that are not in `later` are moved out.
    fn all(&mut self, names: &[&str], later: &[&str]) -> Result<Vec<Samples>, Unassembled> {
        let mut all = Vec::with_capacity(names.len());
        for name in names {
            all.push(self.named(name)?);
            self.keep(|known| known != *name || later.contains(&known));
        }
        Ok(all)
    }

    /// Surge, sway and yaw rate: measured, or else derived from positions.
    fn velocities(&self) -> Result<[Samples; 3], Unassembled> {
        let names = ["y_u", "y_v", "y_r"];
        let absent = names.map(|name| !self.channels.contains_key(name));
        let mut made = match self.conventions.method {
            _ if absent == [false; 3] => Default::default(),
            Method::Euler => self.euler(absent[0] || absent[1])?,
            Method::Smoother => self.slopes(absent[0] || absent[1])?,
        };
        for (velocity, name) in made.iter_mut().zip(names) {
            if self.channels.contains_key(name) {
                *velocity = self.named(name)?;
            }
        }
        Ok(made)
    }

    fn euler(&self, positions: bool) -> Result<[Samples; 3], Unassembled> {
        let psi = self.named("psi")?;
        let still = || psi.made(self.grid.times().map(|_| 0.0));
        let (x, y) = if positions { (self.named("x")?, self.named("y")?) } else { (still(), still()) };
        let poses = x.iter().zip(y.iter()).zip(psi.iter()).map(|((x, y), psi)| [x, y, psi]);
        let mut made = [psi.none(), psi.none(), psi.none()];
        for velocity in euler(poses, 1.0 / self.conventions.rate_hz) {
            made.iter_mut().zip(velocity).for_each(|(channel, value)| channel.push(value));
        }
        Ok(made)
    }

    fn slopes(&self, positions: bool) -> Result<[Samples; 3], Unassembled> {
        let window_s = self.conventions.window_s;
        let (psi, r) = self.series("psi")?.smoothed(window_s);
        let r = self.resampled(&r);
        if !positions {
            return Ok([Samples::default(), Samples::default(), r]);
        }
        let psi = self.resampled(&psi);
        let rates = |name: &str| Ok(self.resampled(&self.series(name)?.smoothed(window_s).1));
        let (north, east) = (rates("x")?, rates("y")?);
        let [mut u, mut v] = [psi.none(), psi.none()];
        for ((north, east), psi) in north.iter().zip(east.iter()).zip(psi.iter()) {
            let [surge, sway] = body_velocity([north, east], psi);
            u.push(surge);
            v.push(sway);
        }
        Ok([u, v, r])
    }
}

/// The common clock of a recording.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    /// Time of row 0 on the recording's clock \[s\].
    pub start_s: f64,
    /// Rows per second.
    pub rate_hz: f64,
    /// Number of rows.
    pub rows: usize,
}

impl Grid {
    /// Slack in units of a step for times that should fall on a row.
    const SLACK: f64 = 1e-4;

    /// Rows from `start_s` to no later than `end_s`.
    pub fn new(start_s: f64, end_s: f64, rate_hz: f64) -> Self {
        let steps = ((end_s - start_s) * rate_hz + Self::SLACK).floor();
        Self { start_s, rate_hz, rows: if steps >= 0.0 { steps as usize + 1 } else { 0 } }
    }

    /// Times of all rows \[s\].
    pub fn times(&self) -> impl Iterator<Item = f64> + use<> {
        let Self { start_s, rate_hz, rows } = *self;
        (0..rows).map(move |k| start_s + k as f64 / rate_hz)
    }

    /// The rows from `from_s` to `to_s`, both included, as first row and one past the last.
    pub fn rows_within(&self, from_s: f64, to_s: f64) -> Range<usize> {
        let place = |time: f64| (time - self.start_s) * self.rate_hz;
        let first = (place(from_s) - Self::SLACK).ceil().max(0.0) as usize;
        let end = ((place(to_s) + Self::SLACK).floor() + 1.0).max(0.0) as usize;
        first..end.min(self.rows).max(first)
    }
}

/// A gap-free section of rows that can be one run: N samples with inputs, and the state after the last of them.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Section {
    /// First row.
    pub start: usize,
    /// Number of samples N; rows `start..=start + samples`.
    pub samples: usize,
}

/// The longest sections of at least one sample in which every state (`measured`) and every input (`exogenous`) is known;
/// after the last sample only the states. Channels have equally many rows, NaN where unknown.
pub fn sections(measured: &[Samples; 3], exogenous: &[Samples]) -> Vec<Section> {
    let (mut states, mut inputs) = (all(measured), all(exogenous));
    let (mut out, mut start) = (Vec::new(), None);
    for row in 0..=measured[0].len() {
        let known = [&mut states, &mut inputs].map(|channels| next_known(channels));
        let inside = row < measured[0].len();
        match start {
            None if inside && known == [true; 2] => start = Some(row),
            Some(first) if !inside || known != [true; 2] => {
                let last = if inside && known[0] { row } else { row - 1 };
                if last > first {
                    out.push(Section { start: first, samples: last - first });
                }
                start = None;
            }
            _ => {}
        }
    }
    out
}

fn all(channels: &[Samples]) -> Vec<Values<'_>> {
    channels.iter().map(Samples::iter).collect()
}

/// Whether the next values of all `channels` are known. Every iterator advances.
fn next_known(channels: &mut [Values]) -> bool {
    channels.iter_mut().fold(true, |known, values| known & values.next().is_some_and(f64::is_finite))
}
