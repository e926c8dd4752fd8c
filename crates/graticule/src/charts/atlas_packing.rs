//! Rectangles of whole cells put into square tiles.

use glam::DVec2;

use crate::tolerance::WHOLE_LENGTH;

/// A rectangle of cells.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub(super) struct Cell {
    width: u32,
    height: u32,
}

impl Cell {
    /// The whole numbers nearest to a size, at least 1.
    pub(super) fn near(size: DVec2) -> Self {
        Self::of(size.round())
    }

    /// The whole numbers not below a size.
    pub(super) fn around(size: DVec2) -> Self {
        // What a size misses a whole number by is rounding.
        Self::of((size - WHOLE_LENGTH).ceil())
    }

    #[allow(clippy::cast_sign_loss, reason = "at least 1")]
    fn of(size: DVec2) -> Self {
        let [width, height] = size.max(DVec2::ONE).to_array().map(|side| side as u32);
        Self { width, height }
    }

    pub(super) fn size(self) -> DVec2 {
        DVec2::new(f64::from(self.width), f64::from(self.height))
    }

    pub(super) fn area(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    pub(super) fn longest(self) -> u32 {
        self.width.max(self.height)
    }

    /// The longest side of any.
    pub(super) fn longest_side(cells: &[Self]) -> u32 {
        cells.iter().map(|cell| cell.longest()).max().unwrap_or(1)
    }

    /// The side of the smallest square that could hold all.
    #[allow(clippy::cast_sign_loss, reason = "a root")]
    pub(super) fn least_side(cells: &[Self]) -> u32 {
        let area: u64 = cells.iter().map(|cell| cell.area()).sum();
        Self::longest_side(cells).max((area as f64).sqrt().ceil() as u32)
    }
}

/// The place of each rectangle and its tile, largest first, each in the lowest free place of the first
/// tile that has one; `None` if more than `most_tiles` were needed, or a rectangle is too large.
pub(super) fn pack_cells(
    cells: &[Cell],
    side: u32,
    most_tiles: u32,
) -> Option<Vec<([u32; 2], u32)>> {
    let mut order: Vec<usize> = (0..cells.len()).collect();
    let key = |index: usize| {
        (
            cells[index].longest(),
            cells[index].area(),
            cells[index].height,
        )
    };
    order.sort_by(|&a, &b| key(b).cmp(&key(a)).then(a.cmp(&b)));
    let mut places = vec![([0; 2], 0); cells.len()];
    let mut tiles: Vec<Free> = Vec::new();
    let mut from = (0, [0; 2]);
    for (step, &index) in order.iter().enumerate() {
        let cell = cells[index];
        // Free cells only become fewer: a rectangle of the same size need not look further back.
        if step == 0 || cells[order[step - 1]] != cell {
            from = (0, [0; 2]);
        }
        loop {
            if from.0 == tiles.len() {
                if tiles.len() as u32 == most_tiles || cell.longest() > side {
                    return None;
                }
                tiles.push(Free::new(side));
            }
            if let Some(place) = tiles[from.0].place(cell, from.1) {
                tiles[from.0].take(cell, place);
                places[index] = (place, from.0 as u32);
                from.1 = place;
                break;
            }
            from = (from.0 + 1, [0; 2]);
        }
    }
    Some(places)
}

/// The free cells of a tile.
struct Free {
    side: u32,
    taken: Vec<bool>,
}

impl Free {
    fn new(side: u32) -> Self {
        let taken = vec![false; side as usize * side as usize];
        Self { side, taken }
    }

    fn is_taken(&self, x: u32, y: u32) -> bool {
        self.taken[y as usize * self.side as usize + x as usize]
    }

    /// The first place, row by row from one on, where a rectangle is free.
    fn place(&self, cell: Cell, [first_x, first_y]: [u32; 2]) -> Option<[u32; 2]> {
        let columns = self.side.checked_sub(cell.width)?;
        let rows = self.side.checked_sub(cell.height)?;
        for y in first_y..=rows {
            let mut x = if y == first_y { first_x } else { 0 };
            while x <= columns {
                let in_the_way = (0..cell.height)
                    .filter_map(|row| {
                        (0..cell.width)
                            .rev()
                            .find(|column| self.is_taken(x + column, y + row))
                    })
                    .max();
                match in_the_way {
                    None => return Some([x, y]),
                    Some(column) => x += column + 1,
                }
            }
        }
        None
    }

    fn take(&mut self, cell: Cell, [x, y]: [u32; 2]) {
        for row in y..y + cell.height {
            for column in x..x + cell.width {
                self.taken[row as usize * self.side as usize + column as usize] = true;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn cell(width: u32, height: u32) -> Cell {
        Cell { width, height }
    }

    #[test]
    fn squares_fill_a_square_and_the_next_one_needs_another_tile() {
        let nine = [cell(1, 1); 9];
        assert!(pack_cells(&nine, 3, 1).is_some());
        let ten = [cell(1, 1); 10];
        assert_eq!(pack_cells(&ten, 3, 1), None);
        let places = pack_cells(&ten, 3, 2).unwrap();
        assert_eq!(places[9], ([0, 0], 1));
    }

    #[test]
    fn rectangles_of_several_sizes_do_not_overlap() {
        let cells = [
            cell(2, 1),
            cell(1, 2),
            cell(3, 3),
            cell(1, 1),
            cell(2, 2),
            cell(1, 1),
        ];
        let side = 5;
        let places = pack_cells(&cells, side, 1).unwrap();
        let mut cover = [0; 25];
        for (cell, ([x, y], tile)) in cells.iter().zip(places) {
            assert_eq!(tile, 0);
            for row in y..y + cell.height {
                for column in x..x + cell.width {
                    cover[(row * side + column) as usize] += 1;
                }
            }
        }
        assert_eq!(cover.iter().max(), Some(&1));
        assert_eq!(cover.iter().sum::<i32>(), 2 + 2 + 9 + 1 + 4 + 1);
    }

    #[test]
    fn what_is_larger_than_a_tile_is_refused() {
        assert_eq!(pack_cells(&[cell(4, 1)], 3, 9), None);
        assert_eq!(Cell::least_side(&[cell(4, 1)]), 4);
        assert_eq!(Cell::near(DVec2::new(0.2, 2.6)), cell(1, 3));
        assert_eq!(Cell::around(DVec2::new(1.000_000_01, 2.1)), cell(1, 3));
    }
}
