//! The average of many skies and suns, as an environment map.

use std::f64::consts::{FRAC_PI_2, PI, TAU};
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::timed::Span;
use super::{Appearance, Sky, model};
use crate::scene::light::{EnvironmentMap, Surroundings};
use crate::scene::texture::Raster;

/// Of the environment map; an odd number of rows has one at the horizon.
const COLUMNS: usize = 2048;
const ROWS: usize = 1025;
/// The rows down to the horizon.
const UPPER_ROWS: usize = ROWS / 2 + 1;
/// The sky is reckoned at every eighth row and column: its brightest part, around the sun, is tens of degrees wide.
const STEP: usize = 8;
const SKY_COLUMNS: usize = COLUMNS / STEP;
const SKY_ROWS: usize = UPPER_ROWS / STEP + 1;
/// Kinds of skies by the sun's elevation.
const ELEVATIONS: usize = 180;
/// Instants. As they are primes, those of one day fall between those of the others, however many days there are.
const INSTANTS: u32 = 131_071;
/// Of suns that are at least [`WIDE`]: drawing them takes time, and they hide where others stood.
const INSTANTS_OF_WIDE: u32 = 8191;
/// rad.
const WIDE: f64 = 0.1;

/// Where the sun stood.
struct Suns {
    /// Unit vectors of the instants at which it was up.
    up: Vec<DVec3>,
    /// All instants.
    instants: f64,
}

/// The average between two parts of a span, in the world.
pub(super) fn environment(
    appearance: &Appearance,
    span: &Span,
    parts: [f64; 2],
    surroundings: Surroundings,
) -> EnvironmentMap {
    let instants = if appearance.aperture < WIDE { INSTANTS } else { INSTANTS_OF_WIDE };
    let part = |instant: u32| (f64::from(instant) + 0.5) / f64::from(instants);
    let sun = |instant| span.sun(parts[0] + (parts[1] - parts[0]) * part(instant));
    let up = (0..instants).map(sun).filter(|sun| sun.z > 0.0).collect();
    let suns = Suns { up, instants: f64::from(instants) };
    let sky = average_sky(appearance, &suns);
    let mut texels = average_sun(appearance, &suns);
    for (index, texel) in texels.iter_mut().enumerate() {
        let sky = interpolated(&sky, index / COLUMNS, index % COLUMNS);
        *texel = [0, 1, 2].map(|channel| texel[channel] + sky[channel]);
    }
    texels.resize(COLUMNS * ROWS, [0.0; 3]);
    let [x, y, z] = appearance.axes.map(|axis| axis.as_vec3());
    // The map's own space has y up.
    EnvironmentMap::new(Arc::new(Raster::of_numbers(COLUMNS, ROWS, texels)), 1.0, [x, z, -y], surroundings)
}

/// How far around the vertical a direction stands, in turns from +y towards +x: 0 to 1.
fn turn(direction: DVec3) -> f64 {
    (libm::atan2(direction.x, direction.y) / TAU).rem_euclid(1.0)
}

/// Suns of about the same elevation.
#[derive(Clone, Debug)]
struct Ring {
    /// How many suns stand at each column of the sky; what stands between two counts for both.
    counts: [f64; SKY_COLUMNS],
    /// Sum of their elevations, rad.
    elevations: f64,
    suns: f64,
}

fn rings(suns: &[DVec3]) -> Vec<Ring> {
    let mut rings = vec![Ring { counts: [0.0; SKY_COLUMNS], elevations: 0.0, suns: 0.0 }; ELEVATIONS];
    for sun in suns {
        let elevation = libm::asin(sun.z.min(1.0));
        let ring = &mut rings[((elevation / FRAC_PI_2 * ELEVATIONS as f64) as usize).min(ELEVATIONS - 1)];
        let column = turn(*sun) * SKY_COLUMNS as f64 - 0.5;
        let next = column - column.floor();
        let first = column.floor().rem_euclid(SKY_COLUMNS as f64) as usize;
        ring.counts[first] += 1.0 - next;
        ring.counts[(first + 1) % SKY_COLUMNS] += next;
        ring.elevations += elevation;
        ring.suns += 1.0;
    }
    rings
}

/// The mean radiance of all instants' skies, by rows of columns.
fn average_sky(appearance: &Appearance, suns: &Suns) -> Vec<[f32; 3]> {
    let mut sum = vec![[0.0; 3]; SKY_COLUMNS * SKY_ROWS];
    for ring in rings(&suns.up).iter().filter(|ring| ring.suns > 0.0) {
        let elevation = ring.elevations / ring.suns;
        let sun = DVec3::new(0.0, libm::cos(elevation), libm::sin(elevation));
        let sky = Sky::new(appearance.turbidity, appearance.albedo, sun, appearance.sky_scale);
        for row in 0..SKY_ROWS {
            let profile = profile(&sky, row);
            let sum = &mut sum[row * SKY_COLUMNS..][..SKY_COLUMNS];
            for (column, count) in ring.counts.iter().enumerate().filter(|(_, count)| **count > 0.0) {
                let weight = (*count / suns.instants) as f32;
                let (before, from) = sum.split_at_mut(column);
                let (near, far) = profile.split_at(SKY_COLUMNS - column);
                add(from, near, weight);
                add(before, far, weight);
            }
        }
    }
    sum
}

fn add(sum: &mut [[f32; 3]], values: &[[f32; 3]], weight: f32) {
    for (sum, value) in sum.as_flattened_mut().iter_mut().zip(values.as_flattened()) {
        *sum += weight * value;
    }
}

/// A row of a sky, by columns from the sun's.
fn profile(sky: &Sky, row: usize) -> [[f32; 3]; SKY_COLUMNS] {
    let polar = FRAC_PI_2 * row as f64 / (SKY_ROWS - 1) as f64;
    let [across, up] = [libm::sin(polar), libm::cos(polar)];
    let mut profile = [[0.0; 3]; SKY_COLUMNS];
    // Both sides of the sun are alike.
    for column in 0..=SKY_COLUMNS / 2 {
        let turn = TAU * column as f64 / SKY_COLUMNS as f64;
        let direction = DVec3::new(across * libm::sin(turn), across * libm::cos(turn), up.max(0.0)).as_vec3();
        profile[column] = sky.radiance(direction).to_array();
        profile[(SKY_COLUMNS - column) % SKY_COLUMNS] = profile[column];
    }
    profile
}

/// The radiance at a texel between the sky's rows and columns.
fn interpolated(sky: &[[f32; 3]], row: usize, column: usize) -> Vec3 {
    let place = |index: f32| (index.floor(), index - index.floor());
    let (upper, down) = place(row as f32 / STEP as f32);
    let (left, along) = place((column as f32 + 0.5) / STEP as f32 - 0.5);
    let left = left.rem_euclid(SKY_COLUMNS as f32) as usize;
    let texel =
        |row: usize, column: usize| Vec3::from_array(sky[row.min(SKY_ROWS - 1) * SKY_COLUMNS + column % SKY_COLUMNS]);
    let across = |row| texel(row, left).lerp(texel(row, left + 1), along);
    across(upper as usize).lerp(across(upper as usize + 1), down)
}

/// The mean radiance of all instants' suns, by rows of columns down to the horizon.
fn average_sun(appearance: &Appearance, suns: &Suns) -> Vec<[f32; 3]> {
    let mut changes = vec![DVec3::ZERO; COLUMNS * UPPER_ROWS];
    if appearance.sun_scale > 0.0 {
        for sun in &suns.up {
            let irradiance = model::sun_irradiance(appearance.turbidity, sun.z) * appearance.sun_scale;
            let radiance = irradiance / (appearance.solid_angle() * suns.instants);
            draw_disc(&mut changes, *sun, 0.5 * appearance.aperture, radiance);
        }
    }
    let mut texels = Vec::with_capacity(COLUMNS * ROWS);
    for row in changes.chunks(COLUMNS) {
        let mut sum = DVec3::ZERO;
        texels.extend(row.iter().map(|change| {
            sum += change;
            sum.max(DVec3::ZERO).as_vec3().to_array()
        }));
    }
    texels
}

/// Adds a disc to rows of differences between columns: by thin lines, of which each covers its part of every texel.
fn draw_disc(changes: &mut [DVec3], sun: DVec3, radius: f64, radiance: DVec3) {
    /// Lines to a row.
    const LINES: usize = 4;
    let spacing = PI / ((ROWS - 1) * LINES) as f64;
    let polar = libm::acos(sun.z.min(1.0));
    let [sin, cos] = [libm::sin(polar), libm::cos(polar)];
    let middle = turn(sun) * COLUMNS as f64 - 0.5;
    let [first, last] = [polar - radius, (polar + radius).min(FRAC_PI_2)].map(|angle| angle / spacing - 0.5);
    for line in first.ceil().max(0.0) as usize..=last.max(0.0) as usize {
        let line_polar = (line as f64 + 0.5) * spacing;
        // [Law of cosines on the sphere] for the turn at which a line leaves the disc.
        let cosine = (libm::cos(radius) - libm::cos(line_polar) * cos) / (libm::sin(line_polar) * sin);
        if cosine > 1.0 {
            continue;
        }
        let half = libm::acos(cosine.max(-1.0)) / TAU * COLUMNS as f64;
        let row = ((line_polar * (ROWS - 1) as f64 / PI).round() as usize).min(UPPER_ROWS - 1);
        // Half a row stands over the pole, and half a one over the horizon.
        let lines = if row == 0 || row == UPPER_ROWS - 1 { LINES / 2 } else { LINES };
        cover(&mut changes[row * COLUMNS..][..COLUMNS], middle - half, 2.0 * half, radiance / lines as f64);
    }
}

/// Adds `value` from column `start` on over `length` columns, with whole columns around whole numbers.
fn cover(row: &mut [DVec3], start: f64, length: f64, value: DVec3) {
    let width = row.len() as f64;
    let start = start.rem_euclid(width);
    let mut step = |place: f64, value: DVec3| {
        // A step within a column counts there by what is behind it.
        let place = place + 0.5;
        let (column, before) = (place.floor(), place - place.floor());
        for (column, value) in [(column, value * (1.0 - before)), (column + 1.0, value * before)] {
            // What begins in a later turn is not there before.
            let around = (column / width).floor();
            row[0] -= value * around;
            row[(column - around * width) as usize] += value;
        }
    };
    step(start, value);
    step(start + length, -value);
}
