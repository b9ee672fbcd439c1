//! Planes with a margin on all sides, so that windows and patches never leave them, and the tiles that are worked on one by one.

use wide::f32x8;

use super::{PATCH, WINDOW};

/// Pixels that are worked on at once.
pub(super) const LANES: usize = 8;
/// Size of a tile, pixels: what pixels of a tile know of each other stays in the cache.
pub(super) const TILE: [usize; 2] = [64, 16];
/// Groups of lanes in a tile.
pub(super) const GROUPS: usize = TILE[0] / LANES * TILE[1];
/// Lanes of a row of patches may reach beyond it.
const MARGIN: usize = WINDOW + PATCH + LANES;

/// Where pixels lie in planes with a margin.
#[derive(Clone, Copy, Debug)]
pub(super) struct Layout {
    width: usize,
    height: usize,
    tiles: [usize; 2],
    /// Values in a row.
    pub(super) stride: usize,
}

impl Layout {
    pub(super) fn new(width: usize, height: usize) -> Self {
        let tiles = [width.div_ceil(TILE[0]), height.div_ceil(TILE[1])];
        Self { width, height, tiles, stride: tiles[0] * TILE[0] + 2 * MARGIN }
    }

    pub(super) fn tile_count(&self) -> usize {
        self.tiles[0] * self.tiles[1]
    }

    /// Column and row of a tile's first pixel.
    pub(super) fn corner(&self, tile: usize) -> [usize; 2] {
        [tile % self.tiles[0] * TILE[0], tile / self.tiles[0] * TILE[1]]
    }

    /// Where a pixel lies.
    pub(super) fn place(&self, column: usize, row: usize) -> usize {
        (row + MARGIN) * self.stride + column + MARGIN
    }

    /// Where what lies so many rows and columns away from `place` lies.
    pub(super) fn shifted(&self, place: usize, [columns, rows]: [isize; 2]) -> usize {
        place.wrapping_add_signed(rows * self.stride as isize + columns)
    }

    /// A plane that goes on beyond the picture with the pixels at its edge.
    pub(super) fn plane(&self, values: &[f32]) -> Vec<f32> {
        self.filled(|column, row| {
            let inside = |place: isize, size: usize| place.clamp(0, size as isize - 1) as usize;
            values[inside(row, self.height) * self.width + inside(column, self.width)]
        })
    }

    /// 1 inside the picture, 0 beyond it.
    pub(super) fn inside(&self) -> Vec<f32> {
        let is_in = |place: isize, size: usize| (0..size as isize).contains(&place);
        self.filled(|column, row| if is_in(column, self.width) && is_in(row, self.height) { 1.0 } else { 0.0 })
    }

    fn filled(&self, value: impl Fn(isize, isize) -> f32) -> Vec<f32> {
        let rows = self.tiles[1] * TILE[1] + 2 * MARGIN;
        let place = |index: usize| {
            let [column, row] = [index % self.stride, index / self.stride].map(|place| place as isize);
            value(column - MARGIN as isize, row - MARGIN as isize)
        };
        (0..rows * self.stride).map(place).collect()
    }
}

/// The lanes from `place` on.
#[inline(always)]
pub(super) fn lanes(values: &[f32], place: usize) -> f32x8 {
    let mut lanes = [0.0; LANES];
    lanes.copy_from_slice(&values[place..place + LANES]);
    f32x8::from(lanes)
}

/// e^`values`, with the same bits on every system.
#[inline]
pub(super) fn exp(values: f32x8) -> f32x8 {
    f32x8::from(values.to_array().map(libm::expf))
}

/// The places of a window relative to its middle: columns and rows.
pub(super) fn window() -> Vec<[isize; 2]> {
    let reach = WINDOW as isize;
    (-reach..=reach).flat_map(|row| (-reach..=reach).map(move |column| [column, row])).collect()
}
