//! The cells of a line of a table.

/// The cells of a line. Reused for every line, so that none is allocated.
#[derive(Default)]
pub(crate) struct Row {
    /// The line; for a line with quotes, the texts of its cells.
    text: String,
    /// Where each cell begins and ends.
    pub(crate) cells: Vec<[usize; 2]>,
}

impl Row {
    /// The separator is an ASCII character; a blank stands for any number of blanks.
    pub(crate) fn split(&mut self, line: &str, separator: char) {
        self.text.clear();
        self.cells.clear();
        if separator == ' ' {
            let place = |cell: &str| cell.as_ptr().addr() - line.as_ptr().addr();
            self.cells.extend(line.split_ascii_whitespace().map(|c| [place(c), place(c) + c.len()]));
        } else if line.contains('"') {
            return self.split_quoted(line, separator);
        } else {
            let mut start = 0;
            for (at, _) in line.bytes().enumerate().filter(|(_, byte)| char::from(*byte) == separator) {
                self.cells.push([start, at]);
                start = at + 1;
            }
            self.cells.push([start, line.len()]);
        }
        self.text.push_str(line);
    }

    /// A quoted cell may contain the separator, and doubled quotes.
    fn split_quoted(&mut self, line: &str, separator: char) {
        let (mut quoted, mut start) = (false, 0);
        let mut characters = line.chars().peekable();
        while let Some(c) = characters.next() {
            match c {
                '"' if quoted && characters.next_if_eq(&'"').is_some() => self.text.push('"'),
                '"' => quoted = !quoted,
                c if c == separator && !quoted => {
                    self.cells.push([start, self.text.len()]);
                    start = self.text.len();
                }
                c => self.text.push(c),
            }
        }
        self.cells.push([start, self.text.len()]);
    }

    pub(crate) fn cell(&self, place: usize) -> &str {
        let [start, end] = self.cells[place];
        &self.text[start..end]
    }

    pub(crate) fn cells(&self) -> impl Iterator<Item = &str> {
        (0..self.cells.len()).map(|place| self.cell(place))
    }
}

/// What the last cells of rows look like: a cut one has fewer decimals, or is shorter, than all before it.
pub(crate) struct Ends {
    decimals: usize,
    length: usize,
}

impl Default for Ends {
    fn default() -> Self {
        Self { decimals: usize::MAX, length: usize::MAX }
    }
}

impl Ends {
    fn of(row: &Row) -> Self {
        let cell = row.cells.last().map_or("", |[start, end]| row.text[*start..*end].trim());
        Self { decimals: cell.rfind(['.', ',']).map_or(0, |point| cell.len() - point), length: cell.len() }
    }

    pub(crate) fn see(&mut self, row: &Row) {
        let Self { decimals, length } = Self::of(row);
        (self.decimals, self.length) = (self.decimals.min(decimals), self.length.min(length));
    }

    pub(crate) fn is_cut(&self, row: &Row) -> bool {
        let own = Self::of(row);
        self.decimals != usize::MAX
            && (own.decimals < self.decimals || self.decimals == 0 && own.length < self.length)
    }
}
