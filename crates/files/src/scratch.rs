//! A temporary store of numbers that do not fit in memory while a file is made.

use std::fs::File;
use std::io;
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};

use crate::error::{Error, Result};
use crate::staged::{fault, folder_of};

/// Slots of equal length: the first in memory, the others in an unnamed file that disappears with the
/// process. A failure is recorded for [`Scratch::check`]: until then, numbers that could not be stored read
/// as zeros.
#[derive(Debug)]
pub struct Scratch {
    /// The path beside which the unnamed file is created.
    target: PathBuf,
    /// Numbers of a slot.
    length: usize,
    /// Slots in memory.
    held: usize,
    slots: Mutex<Slots>,
}

#[derive(Debug, Default)]
struct Slots {
    /// Those in memory.
    held: Vec<Vec<f64>>,
    /// All, in memory or not.
    count: usize,
    free: Vec<usize>,
    file: Option<std::sync::Arc<File>>,
    failure: Option<io::Error>,
}

impl Scratch {
    /// Slots of `length` numbers, in memory up to `bytes`, then in a file in the folder of `target`.
    pub fn new(target: &Path, length: usize, bytes: f64) -> Self {
        let held = (bytes / (8 * length) as f64) as usize;
        Self { target: target.to_owned(), length, held, slots: Mutex::default() }
    }

    /// Numbers of a slot.
    pub fn length(&self) -> usize {
        self.length
    }

    /// Stores numbers, at most a slot of them; returns the slot.
    pub fn put(&self, numbers: &[f64]) -> u64 {
        let mut slots = self.slots();
        let slot = slots.free.pop().unwrap_or_else(|| {
            slots.count += 1;
            slots.count - 1
        });
        if slot < self.held {
            if slots.held.len() <= slot {
                slots.held.resize(slot + 1, Vec::new());
            }
            slots.held[slot] = numbers.to_vec();
            return slot as u64;
        }
        let file = self.file(&mut slots);
        drop(slots);
        if let Some(file) = file {
            let mut bytes = vec![0; 8 * numbers.len()];
            let places = bytes.as_chunks_mut().0.iter_mut();
            places.zip(numbers).for_each(|(place, number)| *place = number.to_le_bytes());
            let written = fault::point("put aside").and_then(|()| write_at(&file, &bytes, self.place(slot)));
            self.note(written);
        }
        slot as u64
    }

    /// Appends the numbers in `slot` to `numbers`.
    pub fn get(&self, slot: u64, numbers: &mut Vec<f64>) {
        let slots = self.slots();
        let slot = slot as usize;
        if let Some(held) = slots.held.get(slot) {
            return numbers.extend_from_slice(held);
        }
        let file = slots.file.clone();
        drop(slots);
        let mut bytes = vec![0; 8 * self.length];
        if let Some(file) = file {
            self.note(read_at(&file, &mut bytes, self.place(slot)));
        }
        let (all, _) = bytes.as_chunks();
        numbers.extend(all.iter().map(|bytes| f64::from_le_bytes(*bytes)));
    }

    /// Frees a slot.
    pub fn forget(&self, slot: u64) {
        let mut slots = self.slots();
        if let Some(held) = slots.held.get_mut(slot as usize) {
            *held = Vec::new();
        }
        slots.free.push(slot as usize);
    }

    /// Reports whether numbers could not be stored.
    ///
    /// # Errors
    /// [`Error::Io`] if the file could not be made, written or read.
    pub fn check(&self) -> Result<()> {
        match self.slots().failure.take() {
            Some(failure) => Err(Error::io(&self.target, "put channels aside", failure)),
            None => Ok(()),
        }
    }

    fn place(&self, slot: usize) -> u64 {
        8 * (self.length * (slot - self.held)) as u64
    }

    /// The file, created on first use.
    fn file(&self, slots: &mut Slots) -> Option<std::sync::Arc<File>> {
        if slots.file.is_none() && slots.failure.is_none() {
            match tempfile::tempfile_in(folder_of(&self.target)) {
                Ok(file) => slots.file = Some(file.into()),
                Err(failure) => slots.failure = Some(failure),
            }
        }
        slots.file.clone()
    }

    fn note(&self, done: io::Result<()>) {
        if let Err(failure) = done {
            self.slots().failure.get_or_insert(failure);
        }
    }

    fn slots(&self) -> MutexGuard<'_, Slots> {
        self.slots.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

#[cfg(unix)]
fn write_at(file: &File, bytes: &[u8], at: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::write_all_at(file, bytes, at)
}

#[cfg(unix)]
fn read_at(file: &File, bytes: &mut [u8], at: u64) -> io::Result<()> {
    std::os::unix::fs::FileExt::read_exact_at(file, bytes, at)
}

#[cfg(windows)]
fn write_at(file: &File, mut bytes: &[u8], mut at: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        let written = std::os::windows::fs::FileExt::seek_write(file, bytes, at)?;
        if written == 0 {
            return Err(io::ErrorKind::WriteZero.into());
        }
        (bytes, at) = (&bytes[written..], at + written as u64);
    }
    Ok(())
}

#[cfg(windows)]
fn read_at(file: &File, mut bytes: &mut [u8], mut at: u64) -> io::Result<()> {
    while !bytes.is_empty() {
        let read = std::os::windows::fs::FileExt::seek_read(file, bytes, at)?;
        if read == 0 {
            return Err(io::ErrorKind::UnexpectedEof.into());
        }
        (bytes, at) = (&mut bytes[read..], at + read as u64);
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn got(scratch: &Scratch, slot: u64) -> Vec<f64> {
        let mut numbers = Vec::new();
        scratch.get(slot, &mut numbers);
        numbers
    }

    #[test]
    fn numbers_come_back_from_memory_and_from_the_file_and_slots_are_used_again() {
        let folder = tempfile::tempdir().unwrap();
        let scratch = Scratch::new(&folder.path().join("out"), 3, 50.0);
        let slots: Vec<u64> = (0..5).map(|i| scratch.put(&[f64::from(i), -0.0, f64::NAN])).collect();
        assert_eq!(slots, [0, 1, 2, 3, 4]);
        for (i, slot) in slots.iter().enumerate() {
            let got = got(&scratch, *slot);
            assert!(got[0] == i as f64 && got[1].is_sign_negative() && got[2].is_nan(), "{got:?}");
        }
        [1, 3].into_iter().for_each(|slot| scratch.forget(slot));
        assert_eq!([scratch.put(&[7.0; 3]), scratch.put(&[8.0; 3])], [3, 1]);
        assert_eq!([got(&scratch, 3), got(&scratch, 1)], [[7.0; 3], [8.0; 3]]);
        assert_eq!(std::fs::read_dir(folder.path()).unwrap().count(), 0, "the file has no name");
        scratch.check().unwrap();
    }

    #[test]
    fn numbers_that_cannot_be_stored_read_as_zeros_and_are_reported() {
        let folder = tempfile::tempdir().unwrap();
        let scratch = Scratch::new(&folder.path().join("nowhere/out"), 2, 0.0);
        let slot = scratch.put(&[1.0, 2.0]);
        assert_eq!(got(&scratch, slot), [0.0, 0.0]);
        let message = scratch.check().unwrap_err().to_string();
        assert!(message.contains("nowhere/out") && message.contains("put channels aside"), "{message}");
        scratch.check().unwrap();
    }
}
