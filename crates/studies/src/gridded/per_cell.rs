//! One value for each cell of a space.

use std::ops::Index;

use design_space::Cell;

/// One value for each cell of a space, found by the cell: the only place that knows that they lie in a row.
#[derive(Clone, Debug)]
pub(crate) struct PerCell<T>(Vec<T>);

impl<T> PerCell<T> {
    /// Each value with its cell.
    pub(crate) fn iter(&self) -> impl Iterator<Item = (Cell, &T)> {
        (0..).map(Cell::new).zip(&self.0)
    }

    /// Another value for each cell, made of its own.
    pub(crate) fn map<U>(&self, of: impl Fn(&T) -> U) -> PerCell<U> {
        self.0.iter().map(of).collect()
    }

    /// Another value for each cell, made of its own and that of another row over the same space.
    pub(crate) fn with<U, V>(&self, other: &PerCell<U>, of: impl Fn(&T, &U) -> V) -> PerCell<V> {
        self.0.iter().zip(&other.0).map(|(own, other)| of(own, other)).collect()
    }
}

impl<T: Copy> PerCell<T> {
    /// The values of some cells, in their order.
    pub(crate) fn over(&self, cells: &[Cell]) -> Vec<T> {
        cells.iter().map(|cell| self[*cell]).collect()
    }
}

impl<T> FromIterator<T> for PerCell<T> {
    /// The value of the first cell comes first.
    fn from_iter<I: IntoIterator<Item = T>>(values: I) -> Self {
        Self(values.into_iter().collect())
    }
}

impl<T> Index<Cell> for PerCell<T> {
    type Output = T;

    fn index(&self, cell: Cell) -> &T {
        &self.0[cell.index() as usize]
    }
}
