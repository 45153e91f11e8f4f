//! Floats as byte streams: the lowest bytes of all values, then the next ones and so on. They compress better than values do,
//! for the upper bytes of neighbours are alike.

use std::array::from_fn;

/// Bytes of a value, and values of a group: their bytes are a square that is transposed.
const SIDE: usize = 8;
/// Groups that are transposed side by side.
const GROUPS: usize = 4;
/// Values that are transposed at a time.
const BLOCK: usize = SIDE * GROUPS;

/// Eight rows of eight bytes, of some groups.
type Squares = [[u64; GROUPS]; SIDE];

/// Appends the byte streams of `values`.
pub(crate) fn split(values: &[f64], out: &mut Vec<u8>) {
    let (rows, start) = (values.len(), out.len());
    out.resize(start + SIDE * rows, 0);
    let bytes = &mut out[start..];
    let (blocks, rest) = values.as_chunks::<BLOCK>();
    for (i, block) in blocks.iter().enumerate() {
        let squares = transposed(from_fn(|j| from_fn(|group| block[SIDE * group + j].to_bits())));
        for (stream, row) in squares.iter().enumerate() {
            let at = stream * rows + i * BLOCK;
            let (eights, _) = bytes[at..at + BLOCK].as_chunks_mut::<SIDE>();
            eights.iter_mut().zip(row).for_each(|(to, bytes)| *to = bytes.to_le_bytes());
        }
    }
    for (i, value) in rest.iter().enumerate() {
        for (stream, byte) in value.to_le_bytes().into_iter().enumerate() {
            bytes[stream * rows + blocks.len() * BLOCK + i] = byte;
        }
    }
}

/// Appends the values whose byte streams `bytes` are; bytes that make no whole value are left out.
pub(crate) fn join(bytes: &[u8], out: &mut Vec<f64>) {
    let rows = bytes.len() / SIDE;
    let streams: [&[u8]; SIDE] = from_fn(|stream| &bytes[stream * rows..(stream + 1) * rows]);
    let blocks = streams.map(|stream| stream.as_chunks::<BLOCK>().0);
    for i in 0..rows / BLOCK {
        let squares = blocks.map(|stream| {
            let (eights, _) = stream[i].as_chunks::<SIDE>();
            from_fn(|group| u64::from_le_bytes(eights[group]))
        });
        let squares = transposed(squares);
        let values: [f64; BLOCK] = from_fn(|k| f64::from_bits(squares[k % SIDE][k / SIDE]));
        out.extend_from_slice(&values);
    }
    let value = |row: usize| f64::from_le_bytes(streams.map(|stream| stream[row]));
    out.extend((rows / BLOCK * BLOCK..rows).map(value));
}

/// Byte i of row j becomes byte j of row i: halves, quarters and eighths of the squares change places. Inlined, as the squares
/// then stay in registers.
#[inline(always)]
fn transposed(mut rows: Squares) -> Squares {
    const STEPS: [(usize, u64); 3] =
        [(4, 0x0000_0000_ffff_ffff), (2, 0x0000_ffff_0000_ffff), (1, 0x00ff_00ff_00ff_00ff)];
    for (apart, mask) in STEPS {
        for upper in (0..SIDE).filter(|row| row & apart == 0) {
            let shift = 8 * apart;
            let (one, other) = (rows[upper], rows[upper + apart]);
            let changed: [u64; GROUPS] = from_fn(|group| ((one[group] >> shift) ^ other[group]) & mask);
            rows[upper] = from_fn(|group| one[group] ^ (changed[group] << shift));
            rows[upper + apart] = from_fn(|group| other[group] ^ changed[group]);
        }
    }
    rows
}

#[cfg(test)]
mod tests {
    use super::*;

    fn values(rows: usize) -> Vec<f64> {
        (0..rows).map(|i| f64::from_bits((i as u64).wrapping_mul(0x9e37_79b9_7f4a_7c15))).collect()
    }

    #[test]
    fn law_a_stream_has_one_byte_of_every_value() {
        for rows in [0, 1, 31, 32, 33, 100] {
            let values = values(rows);
            let mut bytes = vec![7; 3];
            split(&values, &mut bytes);
            assert_eq!(bytes.len(), 3 + 8 * rows);
            for (stream, of_stream) in (0..8).zip(bytes[3..].chunks(rows.max(1))) {
                let expected: Vec<u8> = values.iter().map(|value| value.to_le_bytes()[stream]).collect();
                assert_eq!(of_stream, expected, "stream {stream} of {rows} values");
            }
        }
    }

    #[test]
    fn law_joined_streams_are_the_values() {
        for rows in [0, 1, 31, 32, 33, 1000] {
            let (values, mut bytes, mut joined) = (values(rows), Vec::new(), vec![0.5]);
            split(&values, &mut bytes);
            join(&bytes, &mut joined);
            let bits = |values: &[f64]| values.iter().map(|value| value.to_bits()).collect::<Vec<_>>();
            assert_eq!(bits(&joined[1..]), bits(&values));
        }
    }
}
