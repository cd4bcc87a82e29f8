//! Filled regions and iso-lines of values on a rectangular grid, by straight lines within each cell.

/// Values at the crossings of columns and rows; NaN where there is none.
#[derive(Clone, Copy, Debug)]
pub(super) struct Grid<'a> {
    /// Where the columns are, in pixels.
    pub(super) x: &'a [f64],
    /// Where the rows are, in pixels.
    pub(super) y: &'a [f64],
    /// `z[row][column]`.
    pub(super) z: &'a [Vec<f64>],
}

/// A corner of a cell: its place and its value.
type Corner = ((f64, f64), f64);

/// A straight piece of an iso-line.
pub(super) type Segment = ((f64, f64), (f64, f64));

impl Grid<'_> {
    /// The corners of a cell, in order around it; none when a value is missing.
    fn cell(&self, row: usize, column: usize) -> Option<[Corner; 4]> {
        let corner = |row: usize, column: usize| ((self.x[column], self.y[row]), self.z[row][column]);
        let corners =
            [corner(row, column), corner(row, column + 1), corner(row + 1, column + 1), corner(row + 1, column)];
        corners.iter().all(|corner| corner.1.is_finite()).then_some(corners)
    }

    fn rows(&self) -> usize {
        self.y.len().saturating_sub(1)
    }

    fn columns(&self) -> usize {
        self.x.len().saturating_sub(1)
    }

    /// The region where the value is at least `level`, as the data of an SVG path.
    ///
    /// Cells that lie in it whole are joined along their row, which keeps the text short.
    pub(super) fn at_least(&self, level: f64) -> String {
        let mut d = String::new();
        for row in 0..self.rows() {
            let mut whole: Option<(usize, usize)> = None;
            for column in 0..self.columns() {
                let cell = self.cell(row, column);
                if cell.is_some_and(|cell| cell.iter().all(|corner| corner.1 >= level)) {
                    whole = Some((whole.map_or(column, |(first, _)| first), column + 1));
                    continue;
                }
                self.push_run(&mut d, row, whole.take());
                if let Some(cell) = cell {
                    push_polygon(&mut d, &part_at_least(&cell, level));
                }
            }
            self.push_run(&mut d, row, whole);
        }
        d
    }

    fn push_run(&self, d: &mut String, row: usize, run: Option<(usize, usize)>) {
        if let Some((first, end)) = run {
            let (left, right, top, bottom) = (self.x[first], self.x[end], self.y[row], self.y[row + 1]);
            push_polygon(d, &[(left, top), (right, top), (right, bottom), (left, bottom)]);
        }
    }

    /// The pieces of the line where the value is `level`.
    pub(super) fn iso_line(&self, level: f64) -> Vec<Segment> {
        let mut segments = Vec::new();
        for row in 0..self.rows() {
            for column in 0..self.columns() {
                if let Some(cell) = self.cell(row, column) {
                    segments.extend(cell_line(&cell, level));
                }
            }
        }
        segments
    }
}

/// The part of a cell where the value is at least `level`.
fn part_at_least(cell: &[Corner; 4], level: f64) -> Vec<(f64, f64)> {
    let mut part = Vec::new();
    for side in 0..4 {
        let (from, to) = (cell[side], cell[(side + 1) % 4]);
        if from.1 >= level {
            part.push(from.0);
        }
        part.extend(crossing(from, to, level));
    }
    part
}

/// The pieces of the line in one cell: one, or two across a saddle.
fn cell_line(cell: &[Corner; 4], level: f64) -> Vec<Segment> {
    let crossings: Vec<(f64, f64)> =
        (0..4).filter_map(|side| crossing(cell[side], cell[(side + 1) % 4], level)).collect();
    match *crossings.as_slice() {
        [a, b] => vec![(a, b)],
        // The filled part joins its two corners across the cell, so the lines cut off the other two.
        [a, b, c, d] if cell[0].1 >= level => vec![(a, b), (c, d)],
        [a, b, c, d] => vec![(d, a), (b, c)],
        _ => Vec::new(),
    }
}

/// Where the line crosses a side.
fn crossing(from: Corner, to: Corner, level: f64) -> Option<(f64, f64)> {
    ((from.1 >= level) != (to.1 >= level)).then(|| {
        let share = (level - from.1) / (to.1 - from.1);
        (from.0.0 + share * (to.0.0 - from.0.0), from.0.1 + share * (to.0.1 - from.0.1))
    })
}

fn push_polygon(d: &mut String, corners: &[(f64, f64)]) {
    if corners.len() < 3 {
        return;
    }
    for (number, (x, y)) in corners.iter().enumerate() {
        let command = if number == 0 { 'M' } else { 'L' };
        d.push_str(&format!("{command}{x:.1} {y:.1}"));
    }
    d.push('Z');
}

#[cfg(test)]
mod tests {
    use super::*;

    const X: [f64; 3] = [0.0, 10.0, 20.0];
    const Y: [f64; 2] = [10.0, 0.0];

    #[test]
    fn line_of_a_plane_is_where_the_plane_says() {
        let z = vec![vec![0.0, 1.0, 2.0]; 2];
        let grid = Grid { x: &X, y: &Y, z: &z };
        assert_eq!(grid.iso_line(1.5), [((15.0, 10.0), (15.0, 0.0))]);
        assert_eq!(grid.at_least(1.5), "M15.0 10.0L20.0 10.0L20.0 0.0L15.0 0.0Z");
    }

    #[test]
    fn whole_cells_are_joined() {
        let z = vec![vec![1.0; 3]; 2];
        let grid = Grid { x: &X, y: &Y, z: &z };
        assert_eq!(grid.at_least(0.5), "M0.0 10.0L20.0 10.0L20.0 0.0L0.0 0.0Z");
        assert_eq!(grid.at_least(1.5), "");
    }

    #[test]
    fn missing_values_leave_their_cells_blank() {
        let z = vec![vec![1.0, 1.0, f64::NAN], vec![1.0; 3]];
        let grid = Grid { x: &X, y: &Y, z: &z };
        assert_eq!(grid.at_least(0.5), "M0.0 10.0L10.0 10.0L10.0 0.0L0.0 0.0Z");
        assert!(grid.iso_line(0.5).is_empty(), "no line along a gap");
    }

    #[test]
    fn saddle_has_two_pieces_that_bound_the_filled_part() {
        let z = vec![vec![1.0, 0.0], vec![0.0, 1.0]];
        let grid = Grid { x: &X[..2], y: &Y, z: &z };
        let lines = grid.iso_line(0.5);
        assert_eq!(lines, [((5.0, 10.0), (10.0, 5.0)), ((5.0, 0.0), (0.0, 5.0))]);
        assert_eq!(grid.at_least(0.5), "M0.0 10.0L5.0 10.0L10.0 5.0L10.0 0.0L5.0 0.0L0.0 5.0Z");
    }
}
