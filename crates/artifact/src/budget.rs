//! What work may use: memory and disk. Work that would use more is refused before it begins.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use crate::error::{Error, Result};

/// Memory that a program takes before there is any work, about: its pages, and what it reads \[bytes\].
pub const PROGRAM_BYTES: u64 = 24 << 20;

/// What the work of a stage may use.
#[derive(Clone, Debug, PartialEq)]
pub struct Budget {
    /// Most bytes of memory, and who sets that bound; none where nobody says.
    memory: Option<(f64, &'static str)>,
}

/// Work that an input asks for, and how it is told where there is too much of it.
#[derive(Clone, Copy, Debug)]
pub struct Work<'a> {
    /// The file that asks for it.
    pub file: &'a Path,
    /// The key or column that says how much.
    pub thing: &'a str,
    /// What stands there, and what becomes of it.
    pub found: &'a str,
    /// How to ask for less.
    pub remedy: &'a str,
}

/// What this process may use: said once, as the number of threads is.
static BUDGET: OnceLock<Budget> = OnceLock::new();

/// What this process may use.
pub fn budget() -> &'static Budget {
    BUDGET.get_or_init(|| Budget::new(None))
}

/// Lets this process use at most `memory_mib`, or without it what the machine has; the first word counts.
pub fn set_budget(memory_mib: Option<u64>) {
    BUDGET.get_or_init(|| Budget::new(memory_mib));
}

impl Budget {
    /// At most `memory_mib`; without it what this process can have: of the machine, its control group, and its address space.
    pub fn new(memory_mib: Option<u64>) -> Self {
        let asked = memory_mib.map(|mib| (mib as f64 * 1_048_576.0, "--memory-mib"));
        let least = || granted().into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        Self { memory: asked.or_else(least) }
    }

    /// Bytes of memory that work may use.
    pub fn bytes(&self) -> f64 {
        self.memory.map_or(f64::INFINITY, |(bytes, _)| bytes)
    }

    /// Refuses `work` that takes `bytes` of memory at once.
    ///
    /// # Errors
    /// Says how much it takes, how much there is and who sets that bound.
    pub fn memory(&self, work: Work, bytes: f64) -> Result<()> {
        match self.memory.filter(|(most, _)| bytes > *most) {
            None => Ok(()),
            Some((most, whose)) => {
                let expected = format!("work that fits the {} of {whose}", amount(most));
                Err(work.refused(&format!("{} of memory", amount(bytes)), &expected))
            }
        }
    }

    /// Refuses `work` that writes `bytes` or more into `folder`, where there is no room for them.
    ///
    /// # Errors
    /// Says how much it takes and how much room there is.
    pub fn disk(&self, work: Work, folder: &Path, bytes: f64) -> Result<()> {
        match room(folder).filter(|room| bytes > *room) {
            None => Ok(()),
            Some(room) => {
                let expected = format!("work that fits the {} free there", amount(room));
                let folder = if folder == Path::new("") { Path::new(".") } else { folder };
                let takes = format!("at least {} of the disk of {}", amount(bytes), folder.display());
                Err(work.refused(&takes, &expected))
            }
        }
    }
}

impl Work<'_> {
    fn refused(&self, takes: &str, expected: &str) -> Error {
        let found = format!("{}, which takes {takes}", self.found);
        Error::refuse(self.file, self.thing, found, expected, self.remedy)
    }
}

/// Bytes in words: `3 MiB`, `1.4 TiB`.
fn amount(bytes: f64) -> String {
    const UNITS: [&str; 6] = ["B", "KiB", "MiB", "GiB", "TiB", "PiB"];
    let (mut value, mut thousands) = (bytes, 0);
    while value >= 1024.0 && thousands + 1 < UNITS.len() {
        value /= 1024.0;
        thousands += 1;
    }
    format!("{value:.*} {}", usize::from(value < 10.0 && thousands > 0), UNITS[thousands])
}

/// Bounds of this process's memory in bytes, as Linux tells them; elsewhere none is known.
fn granted() -> Vec<(f64, &'static str)> {
    let machine = number_after("/proc/meminfo", "MemTotal:").map(|kib| (1024.0 * kib, "this machine"));
    let space =
        number_after("/proc/self/limits", "Max address space").map(|b| (b, "the address space (ulimit -v)"));
    let group = groups().map(|bytes| (bytes, "this process's control group"));
    machine.into_iter().chain(space).chain(group).collect()
}

/// The number behind `key` in a file of the system's.
fn number_after(file: &str, key: &str) -> Option<f64> {
    let text = fs::read_to_string(file).ok()?;
    let rest = text.lines().find_map(|line| line.strip_prefix(key))?;
    rest.split_whitespace().next()?.parse().ok()
}

/// The bounds of the control group of this process and of those above it.
fn groups() -> impl Iterator<Item = f64> {
    let text = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let own = text.lines().find_map(|line| line.strip_prefix("0::/")).unwrap_or_default().to_owned();
    let files: Vec<_> =
        Path::new("/sys/fs/cgroup").join(own).ancestors().map(|at| at.join("memory.max")).collect();
    files.into_iter().filter_map(|file| fs::read_to_string(file).ok()?.trim().parse().ok())
}

/// Bytes that may still be written into `folder`, or where it will be made; none where nobody says.
#[cfg(unix)]
pub fn room(folder: &Path) -> Option<f64> {
    let known = folder.ancestors().map(|at| if at == Path::new("") { Path::new(".") } else { at });
    let disk = known.into_iter().find_map(|at| rustix::fs::statvfs(at).ok())?;
    Some(disk.f_bavail as f64 * disk.f_frsize as f64)
}

/// Bytes that may still be written into a folder: nobody says.
#[cfg(not(unix))]
pub fn room(_: &Path) -> Option<f64> {
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_are_told_in_the_unit_that_leaves_few_digits() {
        let told = [0.0, 1023.0, 1024.0, 15.0 * 1024.0, 1.5e12, 1e30].map(amount);
        assert_eq!(told[..5], ["0 B", "1023 B", "1.0 KiB", "15 KiB", "1.4 TiB"]);
        assert!(told[5].ends_with(" PiB"), "{}", told[5]);
    }
}
