//! Records in an octree, as each reaches so far \[WRC88\].

use super::IrradianceRecord;
use crate::math::{Rgb, Vec3};

/// Where irradiance is asked for.
#[derive(Clone, Copy, Debug)]
pub struct IrradianceQuery {
    /// x, m.
    pub position: Vec3,
    /// n, the normal on the side on which light arrives.
    pub normal: Vec3,
    /// Only records of this group count.
    pub group: u32,
}

/// Deeper cells would be smaller than rounding lets positions be.
const DEEPEST: u32 = 20;
/// A child that is not there; the root is nobody's child.
const NONE: u32 = 0;

/// A cube, its eight parts, and the records that reach into it and are as large as it is.
#[derive(Clone, Debug, Default)]
struct Cell {
    children: [u32; 8],
    records: Vec<u32>,
}

/// A cube's middle and half its side, m.
#[derive(Clone, Copy, Debug)]
struct Cube {
    middle: Vec3,
    half: f32,
}

impl Cube {
    /// The part that a point lies in; points outside belong to the nearest part.
    #[inline]
    fn part_of(&self, point: Vec3) -> usize {
        let above = point.cmpge(self.middle).bitmask();
        above as usize
    }

    /// Part `part`: its bits say along which axes it is the upper one.
    #[inline]
    fn part(&self, part: usize) -> Self {
        let half = 0.5 * self.half;
        let side = |axis: usize| if part >> axis & 1 == 1 { half } else { -half };
        Self { middle: self.middle + Vec3::new(side(0), side(1), side(2)), half }
    }

    /// Whether the box from `low` to `high` reaches into a part.
    fn part_overlaps(&self, part: usize, low: Vec3, high: Vec3) -> bool {
        (0..3).all(|axis| match part >> axis & 1 {
            1 => high[axis] >= self.middle[axis],
            _ => low[axis] < self.middle[axis],
        })
    }
}

/// Records by place. What it answers depends on the order in which they came.
#[derive(Clone, Debug)]
pub struct IrradianceCache {
    error: f32,
    whole: Cube,
    cells: Vec<Cell>,
    records: Vec<IrradianceRecord>,
}

impl IrradianceCache {
    /// An empty one for places between `low` and `high`; interpolation may have ε up to `error`, above 0.
    pub fn new(low: Vec3, high: Vec3, error: f32) -> Self {
        let half = (0.5 * (high - low)).max_element().max(f32::MIN_POSITIVE);
        let whole = Cube { middle: 0.5 * (low + high), half };
        Self { error, whole, cells: vec![Cell::default()], records: Vec::new() }
    }

    /// All records, in the order in which they came.
    pub fn records(&self) -> &[IrradianceRecord] {
        &self.records
    }

    /// Adds a record.
    pub fn insert(&mut self, record: IrradianceRecord) {
        let index = self.records.len() as u32;
        self.records.push(record);
        self.insert_below(0, self.whole, DEEPEST, index);
    }

    /// Puts record `index` into all cells of `cell` that it reaches into and that are two to four times as wide as it reaches.
    fn insert_below(&mut self, cell: u32, cube: Cube, depth_left: u32, index: u32) {
        let IrradianceRecord { position, radius, .. } = self.records[index as usize];
        let reach = self.error * radius;
        if depth_left == 0 || cube.half <= 2.0 * reach {
            self.cells[cell as usize].records.push(index);
            return;
        }
        let (low, high) = (position - reach, position + reach);
        for part in (0..8).filter(|part| cube.part_overlaps(*part, low, high)) {
            if self.cells[cell as usize].children[part] == NONE {
                self.cells[cell as usize].children[part] = self.cells.len() as u32;
                self.cells.push(Cell::default());
            }
            let child = self.cells[cell as usize].children[part];
            self.insert_below(child, cube.part(part), depth_left - 1, index);
        }
    }

    /// Shows every record that counts at a place to `visit`, with its weight.
    #[inline]
    fn visit(&self, query: &IrradianceQuery, mut visit: impl FnMut(&IrradianceRecord, f32)) {
        let (mut index, mut cube) = (0, self.whole);
        loop {
            let cell = &self.cells[index as usize];
            for record in &cell.records {
                let record = &self.records[*record as usize];
                if let Some(weight) = record.weight(query, self.error) {
                    visit(record, weight);
                }
            }
            let part = cube.part_of(query.position);
            (index, cube) = (cell.children[part], cube.part(part));
            if index == NONE {
                return;
            }
        }
    }

    /// Irradiance at a place, W·m⁻², never negative; `None` where no record counts.
    pub fn irradiance(&self, query: &IrradianceQuery) -> Option<Rgb> {
        let (mut sum, mut weights) = (Rgb::ZERO, 0.0);
        self.visit(query, |record, weight| {
            sum += record.extrapolated(query) * weight;
            weights += weight;
        });
        (weights > 0.0).then(|| (sum / weights).max(Rgb::ZERO))
    }
}
