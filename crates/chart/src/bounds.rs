use crate::Invalid;

/// An axis-aligned box in the plane, x east and y north \[m\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Bounds {
    /// The south-western corner.
    pub min: [f64; 2],
    /// The north-eastern corner.
    pub max: [f64; 2],
}

impl Bounds {
    /// The box between two corners.
    ///
    /// # Errors
    /// A corner that is not finite, or a box without area.
    pub fn new(min: [f64; 2], max: [f64; 2]) -> Result<Self, Invalid> {
        let finite = min.iter().chain(&max).all(|v| v.is_finite());
        if finite && min[0] < max[0] && min[1] < max[1] {
            return Ok(Self { min, max });
        }
        Err(Invalid::new(
            "box",
            format!("corners {min:?} and {max:?}"),
            "finite corners, the first south-west of the second",
            "correct the corners",
        ))
    }

    /// The box with its sides moved outwards by `by_m`.
    pub fn grown(&self, by_m: f64) -> Self {
        Self { min: self.min.map(|v| v - by_m), max: self.max.map(|v| v + by_m) }
    }

    /// Whether the boxes have a point in common.
    pub fn meets(&self, other: &Self) -> bool {
        (0..2).all(|k| self.min[k] <= other.max[k] && other.min[k] <= self.max[k])
    }

    /// Whether the point is inside or on the edge.
    pub fn contains(&self, point: [f64; 2]) -> bool {
        (0..2).all(|k| self.min[k] <= point[k] && point[k] <= self.max[k])
    }

    /// The smallest box that contains points; `None` without points.
    pub fn enclosing<'a>(points: impl IntoIterator<Item = &'a [f64; 2]>) -> Option<Self> {
        let grow = |b: Option<Self>, p: &[f64; 2]| match b {
            None => Some(Self { min: *p, max: *p }),
            Some(b) => Some(Self {
                min: [b.min[0].min(p[0]), b.min[1].min(p[1])],
                max: [b.max[0].max(p[0]), b.max[1].max(p[1])],
            }),
        };
        points.into_iter().fold(None, grow)
    }

    /// Points on the edge, `per_side` to a side, counter-clockwise from the south-western corner.
    pub(crate) fn edge(&self, per_side: usize) -> Vec<[f64; 2]> {
        let Self { min: [x0, y0], max: [x1, y1] } = *self;
        let corners = [[x0, y0], [x1, y0], [x1, y1], [x0, y1], [x0, y0]];
        let at = |k: usize, i: usize| {
            let t = i as f64 / per_side as f64;
            [0, 1].map(|d: usize| corners[k][d] + t * (corners[k + 1][d] - corners[k][d]))
        };
        (0..4).flat_map(|k| (0..per_side).map(move |i| at(k, i))).collect()
    }
}
