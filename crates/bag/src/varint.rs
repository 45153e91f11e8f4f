//! Numbers of one to nine bytes, as SQLite writes them: seven bits of each, of the ninth all eight.

/// Takes a number off the front of `rest`.
pub(crate) fn varint(rest: &mut &[u8]) -> Option<i64> {
    let mut number: u64 = 0;
    for place in 0..9 {
        let (byte, after) = rest.split_first()?;
        *rest = after;
        if place == 8 {
            return Some(((number << 8) | u64::from(*byte)) as i64);
        }
        number = (number << 7) | u64::from(byte & 0x7F);
        if byte & 0x80 == 0 {
            return Some(number as i64);
        }
    }
    None
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn numbers_end_where_the_first_bit_is_clear_or_after_nine_bytes() {
        for (bytes, number) in
            [(&[0x05][..], 5), (&[0x81, 0x00], 128), (&[0x82, 0x2C], 300), (&[0xFF; 9], -1)]
        {
            let mut rest = bytes;
            assert_eq!((varint(&mut rest), rest.len()), (Some(number), 0), "{bytes:?}");
        }
        assert_eq!(varint(&mut &[0x80, 0x80][..]), None);
    }
}
