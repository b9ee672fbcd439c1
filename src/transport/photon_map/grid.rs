//! The grid over a scene: cells are numbered along x, then y, then z, so neighbours along x are one run of photons.

use crate::math::Vec3;

/// A dense grid of cubic cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Grid {
    low: Vec3,
    inverse_cell: f32,
    size: [u32; 3],
}

impl Grid {
    /// A grid from `low` to `high` with cells of side `cell`, made larger until there are at most `max_cells`.
    pub fn new(low: Vec3, high: Vec3, cell: f32, max_cells: u64) -> Self {
        let extent = (high - low).max(Vec3::ZERO);
        let mut cell = f64::from(cell.max(f32::MIN_POSITIVE)).max(f64::from(extent.max_element()) / 65_535.0);
        loop {
            // One cell more than fits, so that points on the upper border have one.
            let size = extent.to_array().map(|side| (f64::from(side) / cell) as u64 + 1);
            if size.iter().product::<u64>() <= max_cells.max(1) {
                return Self { low, inverse_cell: (1.0 / cell) as f32, size: size.map(|side| side as u32) };
            }
            cell *= 1.1;
        }
    }

    /// How many cells there are.
    pub fn cell_count(&self) -> usize {
        self.size.iter().map(|side| *side as usize).product()
    }

    /// The side of a cell, m.
    pub fn cell_side(&self) -> f32 {
        1.0 / self.inverse_cell
    }

    /// Cell coordinates; points outside belong to the nearest border cell, for storing and for looking up alike.
    #[inline]
    pub fn coordinates(&self, point: Vec3) -> [u32; 3] {
        let relative = (point - self.low) * self.inverse_cell;
        // Float-to-integer casts saturate: negative becomes 0.
        [
            (relative.x as u32).min(self.size[0] - 1),
            (relative.y as u32).min(self.size[1] - 1),
            (relative.z as u32).min(self.size[2] - 1),
        ]
    }

    /// The numbers of the cell with these coordinates and of those around it, at most 27.
    pub fn around(&self, coordinates: [u32; 3]) -> impl Iterator<Item = usize> {
        let [x, y, z] = [0, 1, 2]
            .map(|axis| coordinates[axis].saturating_sub(1)..=(coordinates[axis] + 1).min(self.size[axis] - 1));
        let grid = *self;
        z.flat_map(move |z| {
            let x = x.clone();
            y.clone().flat_map(move |y| x.clone().map(move |x| grid.cell([x, y, z])))
        })
    }

    /// The number of a cell.
    #[inline]
    pub fn cell(&self, [x, y, z]: [u32; 3]) -> usize {
        ((z * self.size[1] + y) * self.size[0] + x) as usize
    }
}
