//! Small numbers as bits, packed from the lowest bit on: runs and packed groups in turn, as Parquet has levels and labels.

use parquet::errors::{ParquetError, Result as ParquetResult};

/// Values of a group: packed values come in whole groups.
const GROUP: usize = 8;

/// Most bits of a value.
const MOST_BITS: u32 = 32;

/// Bits of numbers up to `most`.
pub(crate) fn width_of(most: u32) -> u32 {
    u32::BITS - most.leading_zeros()
}

/// Appends a number in groups of seven bits, the lowest first.
pub(crate) fn put_varint(out: &mut Vec<u8>, mut number: u64) {
    while number >= 0x80 {
        out.push(number as u8 | 0x80);
        number >>= 7;
    }
    out.push(number as u8);
}

/// Takes such a number off the front of `bytes`.
pub(crate) fn take_varint(bytes: &mut &[u8]) -> ParquetResult<u64> {
    let mut number = 0;
    for shift in (0..64).step_by(7) {
        let byte = take(bytes, 1)?[0];
        number |= u64::from(byte & 0x7f) << shift;
        if byte & 0x80 == 0 {
            return Ok(number);
        }
    }
    Err(broken("a number of more than 64 bits"))
}

/// Takes so many bytes off the front of `bytes`.
pub(crate) fn take<'a>(bytes: &mut &'a [u8], count: usize) -> ParquetResult<&'a [u8]> {
    bytes.split_off(..count).ok_or_else(|| broken("a page that ends early"))
}

/// What is wrong with a page.
pub(crate) fn broken(what: &str) -> ParquetError {
    ParquetError::General(what.to_owned())
}

/// Appends `values` of `width` bits each.
pub(crate) fn pack(values: &[u32], width: u32, out: &mut Vec<u8>) {
    let (mut held, mut bits) = (0_u64, 0);
    for &value in values {
        held |= u64::from(value) << bits;
        bits += width;
        while bits >= 8 {
            out.push(held as u8);
            held >>= 8;
            bits -= 8;
        }
    }
    if bits > 0 {
        out.push(held as u8);
    }
}

/// Gives `each` so many values of `width` bits; there are bytes enough for them.
pub(crate) fn unpack(bytes: &[u8], width: u32, count: usize, mut each: impl FnMut(u32)) {
    let mask = (1_u64 << width) - 1;
    let (mut held, mut bits) = (0_u64, 0);
    let mut bytes = bytes.iter();
    for _ in 0..count {
        while bits < width {
            held |= u64::from(bytes.next().copied().unwrap_or_default()) << bits;
            bits += 8;
        }
        each((held & mask) as u32);
        held >>= width;
        bits -= width;
    }
}

/// Writes numbers: those that repeat as runs, the others packed.
pub(crate) struct Runs<'a> {
    out: &'a mut Vec<u8>,
    width: u32,
    /// Values that wait to be packed.
    waiting: Vec<u32>,
}

impl<'a> Runs<'a> {
    /// Numbers of `width` bits, appended to `out`.
    pub fn new(out: &'a mut Vec<u8>, width: u32) -> Self {
        Self { out, width, waiting: Vec::new() }
    }

    /// Appends `value`, so many times.
    pub fn push(&mut self, value: u32, mut times: usize) {
        // What is packed comes in whole groups: a run gives of its own to fill the last one.
        let filling = (self.waiting.len().next_multiple_of(GROUP) - self.waiting.len()).min(times);
        self.waiting.extend(std::iter::repeat_n(value, filling));
        times -= filling;
        if times < GROUP {
            self.waiting.extend(std::iter::repeat_n(value, times));
            return;
        }
        self.pack_waiting();
        put_varint(self.out, (times as u64) << 1);
        self.out.extend(&value.to_le_bytes()[..self.width.div_ceil(8) as usize]);
    }

    /// Appends the last values.
    pub fn finish(mut self) {
        self.waiting.resize(self.waiting.len().next_multiple_of(GROUP), 0);
        self.pack_waiting();
    }

    fn pack_waiting(&mut self) {
        if !self.waiting.is_empty() {
            put_varint(self.out, ((self.waiting.len() / GROUP) << 1 | 1) as u64);
            pack(&self.waiting, self.width, self.out);
            self.waiting.clear();
        }
    }
}

/// Gives `each` the first `count` numbers of what [`Runs`] wrote: a value, and how many times it comes.
pub(crate) fn each_run(
    mut bytes: &[u8],
    width: u32,
    count: usize,
    mut each: impl FnMut(u32, usize) -> ParquetResult<()>,
) -> ParquetResult<()> {
    if width > MOST_BITS {
        return Err(broken("numbers of more than 32 bits"));
    }
    let mut left = count;
    while left > 0 {
        let header = take_varint(&mut bytes)?;
        let length = usize::try_from(header >> 1).unwrap_or(usize::MAX);
        if header & 1 == 0 {
            let mut value = [0; 4];
            let given = take(&mut bytes, width.div_ceil(8) as usize)?;
            value[..given.len()].copy_from_slice(given);
            let times = length.min(left);
            each(u32::from_le_bytes(value), times)?;
            left -= times;
        } else {
            // The last group may be cut off where its values are: not all writers fill it.
            let values = length.saturating_mul(GROUP).min(left);
            let packed = (values * width as usize).div_ceil(8);
            let whole = length.saturating_mul(width as usize).min(bytes.len()).max(packed);
            let packed = take(&mut bytes, whole)?;
            let mut told = Ok(());
            unpack(packed, width, values, |value| {
                if told.is_ok() {
                    told = each(value, 1);
                }
            });
            told?;
            left -= values;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn written(values: &[(u32, usize)], width: u32) -> Vec<u8> {
        let mut out = Vec::new();
        let mut runs = Runs::new(&mut out, width);
        values.iter().for_each(|(value, times)| runs.push(*value, *times));
        runs.finish();
        out
    }

    #[test]
    fn oracle_the_examples_of_the_format() {
        // From the format's description: 0 to 7 of three bits each.
        let mut out = Vec::new();
        pack(&[0, 1, 2, 3, 4, 5, 6, 7], 3, &mut out);
        assert_eq!(out, [0b1000_1000, 0b1100_0110, 0b1111_1010]);
        assert_eq!(written(&[(5, 1000)], 3), [0b1101_0000, 0b0000_1111, 5]);
    }

    #[test]
    fn law_what_is_written_is_read_back() {
        for width in 1..=MOST_BITS {
            let most = u32::MAX >> (MOST_BITS - width);
            let runs: Vec<(u32, usize)> =
                (0..300_u32).map(|i| (i.wrapping_mul(0x9e37_79b9) & most, (i as usize * 7) % 23)).collect();
            let expected: Vec<u32> =
                runs.iter().flat_map(|(value, times)| std::iter::repeat_n(*value, *times)).collect();
            let mut read = Vec::new();
            let bytes = written(&runs, width);
            let each = |value, times| {
                read.extend(std::iter::repeat_n(value, times));
                Ok(())
            };
            each_run(&bytes, width, expected.len(), each).unwrap();
            assert_eq!(read, expected, "{width} bits");
        }
    }

    #[test]
    fn what_ends_early_is_refused() {
        let bytes = written(&[(1, 3), (0, 100), (1, 5)], 1);
        for length in 0..bytes.len() {
            assert!(each_run(&bytes[..length], 1, 108, |_, _| Ok(())).is_err(), "{length} bytes");
        }
        assert!(each_run(&[0xff; 20], 1, 1 << 40, |_, _| Ok(())).is_err());
        assert!(each_run(&bytes, 33, 1, |_, _| Ok(())).is_err());
    }
}
