//! Writing a FlatBuffer from front to back: tables, vectors and texts, each behind the place that points to it.
//!
//! A place is a word of four bytes with the distance to what it points to. Every slot of a table takes a word, too: a
//! smaller number is its first bytes. The list of a table's slots follows the table.

/// Bytes of a word.
const WORD: usize = 4;

/// A FlatBuffer being written; its length is always a multiple of a word.
pub(crate) struct Flat(Vec<u8>);

impl Flat {
    /// A buffer whose root, written next, is a table.
    pub fn new() -> Self {
        let mut flat = Self(vec![0; WORD]);
        flat.point(0);
        flat
    }

    /// Lets the word at `place` point to what is written next.
    pub fn point(&mut self, place: usize) {
        let distance = (self.0.len() - place) as u32;
        self.0[place..place + WORD].copy_from_slice(&distance.to_le_bytes());
    }

    /// A table with these numbers in its slots, `None` where a slot is absent. Returns the place of each slot.
    pub fn table<const N: usize>(&mut self, slots: [Option<u32>; N]) -> [usize; N] {
        let start = self.0.len();
        let mut places = [start; N];
        self.push(0);
        for (place, slot) in places.iter_mut().zip(slots) {
            *place = if slot.is_some() { self.0.len() } else { start };
            slot.into_iter().for_each(|number| self.push(number));
        }
        // The list follows, so its distance is negative.
        let (length, behind) = (self.0.len() - start, start as i32 - self.0.len() as i32);
        self.0[start..start + WORD].copy_from_slice(&behind.to_le_bytes());
        let offsets = places.iter().map(|place| place - start);
        for number in [WORD + 2 * N, length].into_iter().chain(offsets) {
            self.0.extend((number as u16).to_le_bytes());
        }
        self.fill(WORD);
        places
    }

    /// A vector of so many places, which are returned.
    pub fn vector(&mut self, count: usize) -> Vec<usize> {
        self.push(count as u32);
        let places = (0..count).map(|_| {
            self.push(0);
            self.0.len() - WORD
        });
        places.collect()
    }

    /// A text, with a zero behind it.
    pub fn text(&mut self, text: &str) {
        self.push(text.len() as u32);
        self.0.extend(text.bytes().chain([0]));
        self.fill(WORD);
    }

    /// The buffer, filled to a multiple of 8 bytes.
    pub fn finish(mut self) -> Vec<u8> {
        self.fill(2 * WORD);
        self.0
    }

    fn push(&mut self, word: u32) {
        self.0.extend(word.to_le_bytes());
    }

    fn fill(&mut self, multiple: usize) {
        self.0.resize(self.0.len().next_multiple_of(multiple), 0);
    }
}
