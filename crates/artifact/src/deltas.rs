//! Integers by their differences, as Parquet's encoding `DELTA_BINARY_PACKED` has them: numbers that count up take hardly any bits.

use parquet::errors::Result as ParquetResult;

use crate::bits::{broken, pack, put_varint, take, take_varint, unpack, width_of};

/// Differences of a block, which share their smallest.
const BLOCK: usize = 128;
/// Parts of a block, each with as many bits as its own differences need.
const PARTS: usize = 4;
const PART: usize = BLOCK / PARTS;

/// Appends `values`.
pub(crate) fn put(values: &[i32], out: &mut Vec<u8>) {
    put_varint(out, BLOCK as u64);
    put_varint(out, PARTS as u64);
    put_varint(out, values.len() as u64);
    put_varint(out, zigzag(values.first().copied().unwrap_or_default()));
    let later = values.get(1..).unwrap_or_default();
    for (block, before) in later.chunks(BLOCK).zip(values.chunks(BLOCK)) {
        let mut differences = [0; BLOCK];
        for ((difference, value), before) in differences.iter_mut().zip(block).zip(before) {
            *difference = value.wrapping_sub(*before);
        }
        put_block(&differences[..block.len()], out);
    }
}

fn put_block(differences: &[i32], out: &mut Vec<u8>) {
    let least = differences.iter().copied().min().unwrap_or_default();
    let mut above = [0; BLOCK];
    for (above, difference) in above.iter_mut().zip(differences) {
        *above = difference.wrapping_sub(least) as u32;
    }
    put_varint(out, zigzag(least));
    let (parts, _) = above.as_chunks::<PART>();
    let widths: [u32; PARTS] =
        std::array::from_fn(|part| width_of(parts[part].iter().fold(0, |bits, above| bits | above)));
    out.extend(widths.map(|width| width as u8));
    // A part without differences has no bits.
    for (part, width) in parts.iter().zip(widths) {
        pack(part, width, out);
    }
}

/// Appends the `count` values that stand in `bytes`.
pub(crate) fn take_all(mut bytes: &[u8], count: usize, out: &mut Vec<i32>) -> ParquetResult<()> {
    let bytes = &mut bytes;
    let block = take_varint(bytes)?;
    let parts = take_varint(bytes)?;
    if block == 0 || block % 128 != 0 || parts == 0 || block % (32 * parts) != 0 || block > 1 << 20 {
        return Err(broken("blocks of a strange size"));
    }
    let (part, parts) = ((block / parts) as usize, parts as usize);
    if take_varint(bytes)? != count as u64 {
        return Err(broken("another number of values than its page has"));
    }
    let mut value = unzigzag(take_varint(bytes)?);
    out.extend((count > 0).then_some(value));
    let mut left = count.saturating_sub(1);
    while left > 0 {
        let least = unzigzag(take_varint(bytes)?);
        let widths = take(bytes, parts)?;
        for width in widths.iter().map(|width| u32::from(*width)) {
            let some = left.min(part);
            if some == 0 {
                break;
            }
            if width > u32::BITS {
                return Err(broken("numbers of more than 32 bits"));
            }
            let packed = take(bytes, part * width as usize / 8)?;
            let each = |above: u32| {
                value = value.wrapping_add(least).wrapping_add(above as i32);
                out.push(value);
            };
            if width == 0 {
                (0..some).map(|_| 0).for_each(each)
            } else {
                unpack(packed, width, some, each)
            }
            left -= some;
        }
    }
    Ok(())
}

/// Small numbers of either sign as small ones without.
fn zigzag(number: i32) -> u64 {
    u64::from(((number << 1) ^ (number >> 31)) as u32)
}

fn unzigzag(number: u64) -> i32 {
    ((number >> 1) as i64 ^ -((number & 1) as i64)) as i32
}

#[cfg(test)]
mod tests {
    use super::*;

    fn encoded(values: &[i32]) -> Vec<u8> {
        let mut out = Vec::new();
        put(values, &mut out);
        out
    }

    #[test]
    fn oracle_the_examples_of_the_format() {
        // From the format's description: 1 to 5, and 7 5 3 1 2 3 4 5.
        let mut counting = vec![128, 1, 4, 5, 2, 2];
        counting.extend([0; 4]);
        assert_eq!(encoded(&[1, 2, 3, 4, 5]), counting);
        let mut back_and_forth = vec![128, 1, 4, 8, 14, 3, 2, 0, 0, 0, 0b1100_0000, 0b0011_1111];
        back_and_forth.extend([0; 6]);
        assert_eq!(encoded(&[7, 5, 3, 1, 2, 3, 4, 5]), back_and_forth);
    }

    #[test]
    fn law_what_is_written_is_read_back() {
        let wild = |i: i32| i.wrapping_mul(0x79b9_7f4a_u32 as i32);
        for rows in [0, 1, 2, 33, 128, 129, 130, 1000] {
            for values in [(0..rows).map(wild).collect::<Vec<_>>(), (0..rows).map(|i| i % 77).collect()] {
                let mut read = vec![9];
                take_all(&encoded(&values), values.len(), &mut read).unwrap();
                assert_eq!(read[1..], values);
            }
        }
        let edges = [i32::MIN, i32::MAX, 0, i32::MAX, i32::MIN, -1];
        let mut read = Vec::new();
        take_all(&encoded(&edges), edges.len(), &mut read).unwrap();
        assert_eq!(read, edges);
    }

    #[test]
    fn what_ends_early_or_claims_too_much_is_refused() {
        let values: Vec<i32> = (0..200).map(|i| i * i).collect();
        let bytes = encoded(&values);
        for length in 0..bytes.len() {
            assert!(take_all(&bytes[..length], 200, &mut Vec::new()).is_err(), "{length} bytes");
        }
        assert!(take_all(&bytes, 201, &mut Vec::new()).is_err());
        assert!(take_all(&[1, 1, 200, 1, 0], 200, &mut Vec::new()).is_err());
    }
}
