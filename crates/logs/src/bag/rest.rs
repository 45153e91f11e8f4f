//! Unread bytes of a record, least significant first. Lengths in them are not trusted.

/// Most pairs in a record.
const MOST_PAIRS: usize = 1 << 12;

/// Unread bytes.
pub(crate) struct Rest<'a>(pub(crate) &'a [u8]);

impl<'a> Rest<'a> {
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        let (taken, rest) = self.0.split_first_chunk()?;
        self.0 = rest;
        Some(*taken)
    }

    pub(crate) fn u8(&mut self) -> Option<u8> {
        self.take().map(u8::from_le_bytes)
    }

    pub(crate) fn u16(&mut self) -> Option<u16> {
        self.take().map(u16::from_le_bytes)
    }

    pub(crate) fn u32(&mut self) -> Option<u32> {
        self.take().map(u32::from_le_bytes)
    }

    pub(crate) fn u64(&mut self) -> Option<u64> {
        self.take().map(u64::from_le_bytes)
    }

    pub(crate) fn bytes(&mut self, length: u64) -> Option<&'a [u8]> {
        let (taken, rest) = self.0.split_at_checked(usize::try_from(length).ok()?)?;
        self.0 = rest;
        Some(taken)
    }

    /// Text after its length.
    pub(crate) fn text(&mut self) -> Option<&'a str> {
        let length = self.u32()?;
        std::str::from_utf8(self.bytes(u64::from(length))?).ok()
    }

    /// Pairs of texts after the length of all; `None` where there are more than channels have.
    pub(crate) fn pairs(&mut self) -> Option<Vec<(&'a str, &'a str)>> {
        let length = self.u32()?;
        let mut own = Rest(self.bytes(u64::from(length))?);
        let mut pairs = Vec::new();
        while !own.0.is_empty() && pairs.len() <= MOST_PAIRS {
            pairs.push((own.text()?, own.text()?));
        }
        own.0.is_empty().then_some(pairs)
    }
}
