//! The limits of memory and disk. Work that would exceed them is refused before it begins.

use std::fs;
use std::path::Path;
use std::sync::OnceLock;

use crate::error::{Error, Result};

/// Approximate memory of a program without any work: its pages, and its input \[bytes\].
pub const PROGRAM_BYTES: u64 = 24 << 20;

/// MiB of memory for work that needs `bytes`, including the program itself.
pub fn mib_with_program(bytes: u128) -> u128 {
    bytes.saturating_add(PROGRAM_BYTES.into()).div_ceil(1 << 20)
}

/// The limits of a stage's work.
#[derive(Clone, Debug, PartialEq)]
pub struct Budget {
    /// Most bytes of memory, and the origin of that bound; `None` if there is none.
    memory: Option<(f64, &'static str)>,
}

/// Work that an input requests, and the parts of its refusal.
#[derive(Clone, Copy, Debug)]
pub struct Work<'a> {
    /// The file that requests it.
    pub file: &'a Path,
    /// The key or column that determines its amount.
    pub thing: &'a str,
    /// The value, and what it leads to.
    pub found: &'a str,
    /// How to request less.
    pub remedy: &'a str,
}

/// The limits of this process, set once like its number of threads.
static BUDGET: OnceLock<Budget> = OnceLock::new();

/// The limits of this process.
pub fn budget() -> &'static Budget {
    BUDGET.get_or_init(|| Budget::new(None))
}

/// Limits this process to `memory_mib`, or by default to what the machine has; only the first call counts.
pub fn set_budget(memory_mib: Option<u64>) {
    BUDGET.get_or_init(|| Budget::new(memory_mib));
}

impl Budget {
    /// At most `memory_mib`; by default what is available to this process: on the machine, in its control
    /// group, and in its address space.
    pub fn new(memory_mib: Option<u64>) -> Self {
        let requested = memory_mib.map(|mib| (mib as f64 * 1_048_576.0, "--memory-mib"));
        let least = || granted().into_iter().min_by(|a, b| a.0.total_cmp(&b.0));
        Self { memory: requested.or_else(least) }
    }

    /// Bytes of memory available for work.
    pub fn bytes(&self) -> f64 {
        self.memory.map_or(f64::INFINITY, |(bytes, _)| bytes)
    }

    /// Refuses `work` that needs `bytes` of memory at once.
    ///
    /// # Errors
    /// States the need, the bound and its origin.
    pub fn memory(&self, work: Work, bytes: f64) -> Result<()> {
        match self.memory.filter(|(most, _)| bytes > *most) {
            None => Ok(()),
            Some((most, whose)) => {
                let expected = format!("work that fits the {} of {whose}", amount(most));
                Err(work.refused(&format!("{} of memory", amount(bytes)), &expected))
            }
        }
    }

    /// Refuses `work` that writes `bytes` or more into `folder` if that exceeds the free space.
    ///
    /// # Errors
    /// States the need and the free space.
    pub fn disk(&self, work: Work, folder: &Path, bytes: f64) -> Result<()> {
        match free_bytes(folder).filter(|free| bytes > *free) {
            None => Ok(()),
            Some(free) => {
                let expected = format!("work that fits the {} free there", amount(free));
                let folder = if folder == Path::new("") { Path::new(".") } else { folder };
                let takes = format!("at least {} of the disk of {}", amount(bytes), folder.display());
                Err(work.refused(&takes, &expected))
            }
        }
    }
}

impl Work<'_> {
    fn refused(&self, takes: &str, expected: &str) -> Error {
        let request = format!("{}, which takes {takes}", self.found);
        Error::refuse(self.file, self.thing, request, expected, self.remedy)
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

/// Bounds of this process's memory in bytes, as Linux reports them; unknown on other systems.
fn granted() -> Vec<(f64, &'static str)> {
    let machine = number_after("/proc/meminfo", "MemTotal:").map(|kib| (1024.0 * kib, "this machine"));
    let space =
        number_after("/proc/self/limits", "Max address space").map(|b| (b, "the address space (ulimit -v)"));
    let group = groups().map(|bytes| (bytes, "this process's control group"));
    machine.into_iter().chain(space).chain(group).collect()
}

/// The number after `key` in a system file.
fn number_after(file: &str, key: &str) -> Option<f64> {
    let text = fs::read_to_string(file).ok()?;
    let rest = text.lines().find_map(|line| line.strip_prefix(key))?;
    rest.split_whitespace().next()?.parse().ok()
}

/// The bounds of the control group of this process and of those above it.
fn groups() -> impl Iterator<Item = f64> {
    let text = fs::read_to_string("/proc/self/cgroup").unwrap_or_default();
    let group = text.lines().find_map(|line| line.strip_prefix("0::/")).unwrap_or_default().to_owned();
    let files: Vec<_> =
        Path::new("/sys/fs/cgroup").join(group).ancestors().map(|at| at.join("memory.max")).collect();
    files.into_iter().filter_map(|file| fs::read_to_string(file).ok()?.trim().parse().ok())
}

/// Free bytes for `folder`, or where it will be created; `None` if unknown.
pub fn free_bytes(folder: &Path) -> Option<f64> {
    let mut known = folder.ancestors().map(|at| if at == Path::new("") { Path::new(".") } else { at });
    known.find_map(|at| fs4::available_space(at).ok()).map(|bytes| bytes as f64)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn amounts_use_the_unit_with_the_fewest_digits() {
        let amounts = [0.0, 1023.0, 1024.0, 15.0 * 1024.0, 1.5e12, 1e30].map(amount);
        assert_eq!(amounts[..5], ["0 B", "1023 B", "1.0 KiB", "15 KiB", "1.4 TiB"]);
        assert!(amounts[5].ends_with(" PiB"), "{}", amounts[5]);
    }
}
