//! Intensity as a function of the direction, and sampling it.
//!
//! Directions are in the luminaire's photometric frame: +z at vertical angle θ = 0, +x at horizontal angle φ = 0, +y at 90°.

use std::f64::consts::{PI, TAU};

use super::lm63::Photometry;
use crate::math::Vec3;
use crate::math::discrete::Discrete;
use crate::math::trigonometry::sin_cos_turn;

/// The widest cell of the sampling density, radians: 2.5°.
const WIDEST: f64 = 2.5 * PI / 180.0;

/// Measured intensities over the whole sphere.
#[derive(Clone, Debug)]
pub(super) struct Profile {
    /// Vertical angles, radians, ascending.
    vertical: Vec<f32>,
    /// Horizontal angles, radians, ascending over a whole turn; only one when all are alike.
    horizontal: Vec<f32>,
    /// Candelas, by horizontal and then by vertical angle.
    candelas: Vec<f32>,
    /// Borders of the cells: cosines of vertical angles, descending, and shares of a turn, ascending.
    cosines: Vec<f32>,
    turns: Vec<f32>,
    /// Over cells, by turn and then by cosine.
    cells: Discrete,
}

/// A function that is linear between its values at ascending places.
fn interval(places: &[f32], at: f32) -> (usize, f32) {
    let above = places.partition_point(|place| *place <= at).clamp(1, places.len() - 1);
    let (low, high) = (places[above - 1], places[above]);
    (above - 1, ((at - low) / (high - low)).clamp(0.0, 1.0))
}

impl Profile {
    /// `None` when it emits nothing.
    pub(super) fn new(photometry: &Photometry) -> Option<Self> {
        let vertical: Vec<f64> = photometry.vertical.iter().map(|angle| angle.to_radians()).collect();
        let horizontal: Vec<f64> = photometry.horizontal.iter().map(|angle| angle.to_radians()).collect();
        let rows = refined(&vertical);
        let columns = if horizontal.len() == 1 { vec![0.0, TAU] } else { refined(&horizontal) };
        let value = |theta: f64, phi: f64| bilinear(&vertical, &horizontal, &photometry.candelas, theta, phi);
        let mut integrals = Vec::with_capacity((rows.len() - 1) * (columns.len() - 1));
        for phi in columns.windows(2) {
            // Linear in φ: the mean is that in the middle.
            let middle = 0.5 * (phi[0] + phi[1]);
            for theta in rows.windows(2) {
                let ends = [value(theta[0], middle), value(theta[1], middle)];
                integrals.push((phi[1] - phi[0]) * weighted_by_sine([theta[0], theta[1]], ends));
            }
        }
        let single = |numbers: &[f64]| numbers.iter().map(|number| *number as f32).collect::<Vec<f32>>();
        Some(Self {
            vertical: single(&vertical),
            horizontal: single(&horizontal),
            candelas: single(&photometry.candelas),
            cosines: rows.iter().map(|theta| libm::cos(*theta) as f32).collect(),
            turns: columns.iter().map(|phi| (phi / TAU) as f32).collect(),
            cells: Discrete::new(&integrals)?,
        })
    }

    /// The integral over all directions, lm.
    pub(super) fn flux(&self) -> f32 {
        self.cells.total() as f32
    }

    /// Candelas into a unit direction.
    #[inline]
    pub(super) fn candelas(&self, direction: Vec3) -> f32 {
        let theta = libm::acosf(direction.z.clamp(-1.0, 1.0));
        // Borders that are written as 90° stay inside after rounding.
        let slack = 1e-6;
        let (first, last) = (self.vertical[0], self.vertical[self.vertical.len() - 1]);
        if theta < first - slack || theta > last + slack {
            return 0.0;
        }
        let (row, down) = interval(&self.vertical, theta);
        let column = |index: usize| {
            let values = &self.candelas[index * self.vertical.len() + row..][..2];
            values[0] + (values[1] - values[0]) * down
        };
        if self.horizontal.len() == 1 {
            return column(0);
        }
        let angle = libm::atan2f(direction.y, direction.x);
        let phi = if angle < self.horizontal[0] { angle + TAU as f32 } else { angle };
        let (index, along) = interval(&self.horizontal, phi);
        let (here, next) = (column(index), column(index + 1));
        here + (next - here) * along
    }

    /// A unit direction, its candelas over the density by solid angle with which it was found, and that density.
    #[inline]
    pub(super) fn sample(&self, cell: f32, u: [f32; 2]) -> (Vec3, f32, f32) {
        let (cell, _) = self.cells.pick(cell);
        let rows = self.cosines.len() - 1;
        let (column, row) = (cell / rows, cell % rows);
        let (upper, lower) = (self.cosines[row], self.cosines[row + 1]);
        let (start, end) = (self.turns[column], self.turns[column + 1]);
        let z = upper + (lower - upper) * u[0];
        let turn = start + (end - start) * u[1];
        let (sine, cosine) = sin_cos_turn(turn - turn.floor());
        let radius = (1.0 - z * z).max(0.0).sqrt();
        let direction = Vec3::new(radius * cosine, radius * sine, z);
        let solid_angle = (upper - lower) * (end - start) * TAU as f32;
        let pdf = self.cells.probability(cell) / solid_angle;
        (direction, self.candelas(direction) / pdf, pdf)
    }

    /// The density of [`Profile::sample`].
    #[inline]
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        let turn = libm::atan2f(direction.y, direction.x) / TAU as f32;
        let turn = if turn < self.turns[0] { turn + 1.0 } else { turn };
        let row = self.cosines.partition_point(|cosine| *cosine >= direction.z);
        let column = self.turns.partition_point(|start| *start <= turn);
        if row == 0 || row == self.cosines.len() || column == 0 || column == self.turns.len() {
            return 0.0;
        }
        let solid_angle =
            (self.cosines[row - 1] - self.cosines[row]) * (self.turns[column] - self.turns[column - 1]) * TAU as f32;
        self.cells.probability((column - 1) * (self.cosines.len() - 1) + row - 1) / solid_angle
    }
}

/// `angles` with more of them between those that are too far apart.
fn refined(angles: &[f64]) -> Vec<f64> {
    let mut refined = vec![angles[0]];
    for pair in angles.windows(2) {
        let parts = ((pair[1] - pair[0]) / WIDEST - 1e-6).ceil().max(1.0) as usize;
        refined.extend((1..=parts).map(|part| pair[0] + (pair[1] - pair[0]) * part as f64 / parts as f64));
    }
    refined
}

/// ∫ I sin θ dθ for an I that is linear between its values at two angles.
fn weighted_by_sine([from, to]: [f64; 2], [first, last]: [f64; 2]) -> f64 {
    let slope = (last - first) / (to - from);
    first * libm::cos(from) - last * libm::cos(to) + slope * (libm::sin(to) - libm::sin(from))
}

/// As [`Profile::candelas`], by angles and in double precision.
fn bilinear(vertical: &[f64], horizontal: &[f64], candelas: &[f64], theta: f64, phi: f64) -> f64 {
    let interval = |places: &[f64], at: f64| {
        let above = places.partition_point(|place| *place <= at).clamp(1, places.len() - 1);
        (above - 1, ((at - places[above - 1]) / (places[above] - places[above - 1])).clamp(0.0, 1.0))
    };
    let (row, down) = interval(vertical, theta);
    let column = |index: usize| {
        let values = &candelas[index * vertical.len() + row..][..2];
        values[0] + (values[1] - values[0]) * down
    };
    if horizontal.len() == 1 {
        return column(0);
    }
    let (index, along) = interval(horizontal, phi);
    column(index) * (1.0 - along) + column(index + 1) * along
}
