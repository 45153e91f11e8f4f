//! One sentence: address, fields, checksum.

/// A sentence whose checksum is right.
pub(super) struct Sentence<'a> {
    /// Talker and kind: `GPRMC`.
    pub(super) address: &'a str,
    /// What follows the address.
    fields: Vec<&'a str>,
}

impl Sentence<'_> {
    /// Field `i`, from 0; empty where there is none.
    pub(super) fn field(&self, i: usize) -> &str {
        self.fields.get(i).copied().unwrap_or_default()
    }
}

/// The sentence in `text`, which begins with `$`; none where the checksum is missing or wrong.
pub(super) fn sentence(text: &str) -> Option<Sentence<'_>> {
    let (body, checksum) = text.strip_prefix('$')?.split_once('*')?;
    let stated = u8::from_str_radix(checksum.get(..2)?, 16).ok()?;
    if body.bytes().fold(0, |sum, byte| sum ^ byte) != stated {
        return None;
    }
    let mut cells = body.split(',').map(str::trim);
    Some(Sentence { address: cells.next()?, fields: cells.collect() })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn published_sentences_have_right_checksums() {
        // Of the documentation of gpsd.
        for text in [
            "$GPGGA,123519,4807.038,N,01131.324,E,1,08,0.9,545.4,M,46.9,M, , *42",
            "$GPRMC,225446,A,4916.45,N,12311.12,W,000.5,054.7,191194,020.3,E*68",
            "$GPVTG,220.86,T,,M,2.550,N,4.724,K,A*34",
        ] {
            assert!(sentence(text).is_some_and(|found| found.address.len() == 5), "{text}");
            assert!(sentence(&text.replacen('2', "3", 1)).is_none(), "{text}");
        }
        assert!(sentence("$GPVTG,220.86,T,,M").is_none());
    }
}
