/// Vertex of a grid: columns from the west, rows from the south.
pub(crate) type Vertex = (usize, usize);

/// Directions in the order of left turns.
const EAST: u8 = 0;
const NORTH: u8 = 1;
const WEST: u8 = 2;
const SOUTH: u8 = 3;

/// Borders of the cells of an `nx` × `ny` grid that are `inside`, as closed rings of corners with the cells at their
/// left: outer rings counter-clockwise, holes clockwise. Cells that touch only at a corner are separate.
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

    /// The next direction of a border: left if possible, else straight on, else right.
    fn turn(&self, at: usize, direction: Option<u8>) -> Option<u8> {
        let came = direction.unwrap_or(EAST);
        let choices = [came + 1, came, came + 3, came + 2].map(|turned| turned % 4);
        choices.into_iter().find(|choice| self.leaving[at] & (1 << choice) != 0)
    }
}
