/// Vertex of a grid: columns from the west, rows from the south.
pub(crate) type Vertex = (usize, usize);

/// Directions in the order of left turns.
const EAST: u8 = 0;
const NORTH: u8 = 1;
const WEST: u8 = 2;
const SOUTH: u8 = 3;

/// Borders of the cells of an `nx` × `ny` grid that are `inside`, as closed rings of corners with the cells at their
/// left: outer rings counter-clockwise, holes clockwise. Cells that touch at a corner only are apart.
pub(crate) fn outlines(nx: usize, ny: usize, inside: impl Fn(usize, usize) -> bool) -> Vec<Vec<Vertex>> {
    let mut borders = Borders::new(nx, ny, inside);
    let mut rings = Vec::new();
    for start in 0..borders.leaving.len() {
        while borders.leaving[start] != 0 {
            rings.push(borders.ring(start));
        }
    }
    rings
}

/// Per vertex, one bit for each direction in which a border leaves it.
struct Borders {
    wide: usize,
    leaving: Vec<u8>,
}

impl Borders {
    fn new(nx: usize, ny: usize, inside: impl Fn(usize, usize) -> bool) -> Self {
        let wide = nx + 1;
        let mut leaving = vec![0; wide * (ny + 1)];
        for j in 0..ny {
            for i in (0..nx).filter(|&i| inside(i, j)) {
                let at = j * wide + i;
                let sides = [
                    (j == 0 || !inside(i, j - 1), at, EAST),
                    (i + 1 == nx || !inside(i + 1, j), at + 1, NORTH),
                    (j + 1 == ny || !inside(i, j + 1), at + wide + 1, WEST),
                    (i == 0 || !inside(i - 1, j), at + wide, SOUTH),
                ];
                for (_, vertex, direction) in sides.into_iter().filter(|side| side.0) {
                    leaving[vertex] |= 1 << direction;
                }
            }
        }
        Self { wide, leaving }
    }

    /// Follows one border from `start` until it closes, and removes it.
    fn ring(&mut self, start: usize) -> Vec<Vertex> {
        let mut corners = Vec::new();
        let (mut at, mut direction) = (start, None);
        while let Some(next) = self.turn(at, direction) {
            if direction != Some(next) {
                corners.push((at % self.wide, at / self.wide));
            }
            self.leaving[at] &= !(1 << next);
            at = match next {
                EAST => at + 1,
                NORTH => at + self.wide,
                WEST => at - 1,
                _ => at - self.wide,
            };
            direction = Some(next);
            if at == start {
                break;
            }
        }
        corners
    }

    /// Where a border goes on: to the left if it can, else straight on, else to the right.
    fn turn(&self, at: usize, direction: Option<u8>) -> Option<u8> {
        let came = direction.unwrap_or(EAST);
        let choices = [came + 1, came, came + 3, came + 2].map(|turned| turned % 4);
        choices.into_iter().find(|choice| self.leaving[at] & (1 << choice) != 0)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Twice the signed area, and the length, of all rings.
    fn measures(rings: &[Vec<Vertex>]) -> (i64, i64) {
        let (mut area, mut length) = (0, 0);
        for ring in rings {
            for (a, b) in ring.iter().zip(ring.iter().cycle().skip(1)) {
                let [ax, ay, bx, by] = [a.0, a.1, b.0, b.1].map(|v| i64::try_from(v).unwrap());
                area += ax * by - bx * ay;
                length += (ax - bx).abs() + (ay - by).abs();
            }
        }
        (area, length)
    }

    #[test]
    fn a_block_with_a_hole_has_two_rings_of_four_corners() {
        let rings = outlines(3, 3, |i, j| (i, j) != (1, 1));
        assert_eq!(rings.iter().map(Vec::len).collect::<Vec<_>>(), [4, 4]);
        assert_eq!(measures(&rings), (16, 16));
    }

    #[test]
    fn law_rings_enclose_the_cells_and_run_along_every_border_once() {
        let (nx, ny) = (37, 23);
        let mut state = 12345_u64;
        let cells: Vec<bool> = std::iter::repeat_with(|| {
            state = state.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            state >> 62 != 0
        })
        .take(nx * ny)
        .collect();
        let at = |i: usize, j: usize| i < nx && j < ny && cells[j * nx + i];
        let rings = outlines(nx, ny, at);
        let count = cells.iter().filter(|&&cell| cell).count();
        let mut borders = 0;
        for j in 0..=ny {
            for i in 0..=nx {
                borders += i64::from(at(i, j) != (i > 0 && at(i - 1, j)));
                borders += i64::from(at(i, j) != (j > 0 && at(i, j - 1)));
            }
        }
        assert_eq!(measures(&rings), (2 * i64::try_from(count).unwrap(), borders));
    }
}
