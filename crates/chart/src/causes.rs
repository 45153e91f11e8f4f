/// Why a cell is blocked: any of four reasons.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub struct Causes(u8);

impl Causes {
    /// Free.
    pub const NONE: Self = Self(0);
    /// Part of it is land.
    pub const LAND: Self = Self(1);
    /// Part of it is no-go.
    pub const NO_GO: Self = Self(2);
    /// Part of it is shoaler than the least depth, or of unknown depth.
    pub const SHOAL: Self = Self(4);
    /// Part of it is not charted, or outside the chart's area.
    pub const UNCHARTED: Self = Self(8);

    /// Whether there is any cause.
    pub fn any(self) -> bool {
        self.0 != 0
    }

    /// Whether `cause` is among them.
    pub fn has(self, cause: Self) -> bool {
        self.0 & cause.0 != 0
    }

    /// The cause, if no other is set.
    pub(crate) fn only(self, cause: Self) -> Self {
        Self(self.0 & cause.0)
    }

    /// A number of its own for every set of causes.
    pub(crate) fn bits(self) -> u8 {
        self.0
    }

    pub(crate) fn with(self, cause: Self) -> Self {
        Self(self.0 | cause.0)
    }
}
