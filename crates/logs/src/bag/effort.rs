//! What a bag may cost, whatever it announces: memory by what there is, work by the bytes that were read. One counter for
//! every format, and for every way to look at a bag.

use std::cell::Cell;

use refusal::Invalid;

/// Most bytes of a record, a chunk or a message in memory, and least ones that are allowed with little memory.
const LARGEST: f64 = (1 << 27) as f64;
const LEAST: f64 = (1 << 23) as f64;

/// Share of the memory that one record may take: it may be in memory compressed, decompressed and on its way.
const SHARE: f64 = 0.25;

/// Most times that chunks or messages may expand, beyond a fixed minimum: messages do not compress further.
const EXPANSION: u64 = 200;
const IN_ANY_CASE: u64 = 1 << 28;

/// Steps that no byte of a message pays for: beyond them, every message pays for as many as it has bytes, and some more.
const UNPAID: u64 = 1 << 24;
const PER_MESSAGE: u64 = 16;

/// Bytes of a text that are read in one step.
const TEXT: usize = 16;

/// The counter of a pass through a bag.
pub(crate) struct Effort {
    /// Most bytes of a record, a chunk or a message.
    pub(crate) largest: usize,
    /// Bytes of chunks and messages so far, compressed and decompressed.
    packed: Cell<u64>,
    unpacked: Cell<u64>,
    /// Bytes that may still be kept to the end.
    room: Cell<usize>,
    /// Steps that are left.
    steps: Cell<u64>,
}

impl Effort {
    /// No effort yet, with `memory` bytes.
    pub(crate) fn new(memory: f64) -> Self {
        let largest = (SHARE * memory).clamp(LEAST, LARGEST) as usize;
        let [packed, unpacked] = [0, 0].map(Cell::new);
        Self { largest, packed, unpacked, room: Cell::new(2 * largest), steps: Cell::new(UNPAID) }
    }

    /// Counts `packed` bytes that become `unpacked` ones.
    pub(crate) fn unpack(&self, packed: usize, unpacked: u64) -> Result<(), Invalid> {
        if unpacked > self.largest as u64 {
            let (found, expected) = (format!("{unpacked} bytes"), format!("at most {}", self.largest));
            let remedy = "record in smaller chunks, or raise --memory-mib";
            return Err(Invalid::new("chunk", found, expected, remedy));
        }
        self.packed.set(self.packed.get() + packed as u64);
        self.unpacked.set(self.unpacked.get() + unpacked);
        let [packed, unpacked] = [&self.packed, &self.unpacked].map(Cell::get);
        if unpacked > EXPANSION * packed + IN_ANY_CASE {
            let found = format!("{unpacked} bytes, of {packed} in the file");
            let expected = format!("at most {EXPANSION} times as many");
            let remedy = "record again: these hold nothing, or are damaged";
            return Err(Invalid::new("chunks", found, expected, remedy));
        }
        Ok(())
    }

    /// Counts `bytes` that are kept to the end.
    pub(crate) fn keep(&self, bytes: usize) -> Result<(), Invalid> {
        self.room.set(self.room.get().checked_sub(bytes).ok_or_else(|| {
            let expected = format!("at most {} bytes", 2 * self.largest);
            let remedy = "record fewer topics, or raise --memory-mib: the bag may be damaged";
            Invalid::new("definitions", "more than fit in memory", expected, remedy)
        })?);
        Ok(())
    }

    /// Counts `bytes` that are kept to the end if there is plenty of room; says whether there is.
    pub(crate) fn may_keep(&self, bytes: usize) -> bool {
        let left = self.room.get().checked_sub(bytes).filter(|left| *left >= self.largest);
        left.map(|left| self.room.set(left)).is_some()
    }

    /// A message of `bytes` bytes pays for its steps.
    pub(crate) fn earn(&self, bytes: usize) {
        self.steps.set(self.steps.get().saturating_add(bytes as u64 + PER_MESSAGE));
    }

    /// One step: an element that takes no bytes. `None` where no step is left.
    pub(crate) fn step(&self) -> Option<()> {
        self.steps.set(self.steps.get().checked_sub(1)?);
        Some(())
    }

    /// Counts a text of `bytes` bytes that is read or made.
    pub(crate) fn text(&self, bytes: usize) -> Result<(), Invalid> {
        let left = self.steps.get().checked_sub((1 + bytes / TEXT) as u64);
        self.steps.set(left.ok_or_else(Self::endless)?);
        Ok(())
    }

    /// Whether no step is left.
    pub(crate) fn is_spent(&self) -> bool {
        self.steps.get() == 0
    }

    fn endless() -> Invalid {
        let found = "definitions of more elements than the bag has bytes";
        let remedy = "record again: the bag is damaged, or was made to keep its readers busy";
        Invalid::new("definitions", found, "elements that take bytes", remedy)
    }
}
