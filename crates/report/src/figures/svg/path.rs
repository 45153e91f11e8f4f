use super::units::{Point, units};

/// The `d` of a path: whole units of the sheet, relative steps, in their shortest form.
#[derive(Default)]
pub(crate) struct Path(String);

impl Path {
    /// A polyline; nothing with less than two points.
    pub(crate) fn line(&mut self, points: &[Point]) {
        if points.len() > 1 {
            self.steps(points);
        }
    }

    /// A closed ring; one too small for the sheet becomes a dot.
    pub(crate) fn ring(&mut self, points: &[Point]) {
        if !points.is_empty() {
            self.steps(points);
            self.0.push('z');
        }
    }

    pub(crate) fn data(&self) -> &str {
        &self.0
    }

    fn steps(&mut self, points: &[Point]) {
        let mut last: Option<(i64, i64)> = None;
        let mut relative = false;
        for point in points {
            let now = (units(point.0), units(point.1));
            match last {
                None => self.0.push_str(&format!("M{} {}", now.0, now.1)),
                Some(before) if before == now => continue,
                Some(before) => {
                    self.0.push_str(if relative { "" } else { "l" });
                    self.step(now.0 - before.0, relative);
                    self.step(now.1 - before.1, true);
                    relative = true;
                }
            }
            last = Some(now);
        }
        if !relative {
            self.0.push_str("h1");
        }
    }

    fn step(&mut self, by: i64, apart: bool) {
        let space = if apart && by >= 0 { " " } else { "" };
        self.0.push_str(&format!("{space}{by}"));
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steps_are_relative_and_short() {
        let mut path = Path::default();
        path.line(&[(1.0, 2.0), (1.5, 1.0), (1.5, 1.0), (0.0, 3.0)]);
        path.ring(&[(7.0, 7.0), (7.01, 7.01)]);
        path.line(&[(9.0, 9.0)]);
        assert_eq!(path.data(), "M10 20l5-10-15 20M70 70h1z");
    }
}
