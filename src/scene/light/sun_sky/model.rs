//! Hosek & Wilkie's sky and sun, from their published tables.
//!
//! `hosek_wilkie.bin` holds little-endian f32 numbers of the datasets of Hosek & Wilkie (licence beside it) in the form that
//! Mitsuba 3.9.1 distributes: of 10 turbidities × 2 albedos (0, 1) × 6 control points of a Bézier curve over elevation × 3 channels
//! the nine coefficients and the radiance over 106.75, then of 10 turbidities × 30 elevations (2°, 5° … 89°) × 3 channels the sun's
//! irradiance in the same units.

use glam::{DVec3, Vec3};

use crate::math::Rgb;

const DATA: &[u8] = include_bytes!("hosek_wilkie.bin");

const CONTROL_POINTS: usize = 6;
const CHANNELS: usize = 3;
/// Nine coefficients and the radiance.
const NUMBERS: usize = 10;
const TURBIDITIES: usize = 10;
const ELEVATIONS: usize = 30;
const SKY_LENGTH: usize = TURBIDITIES * 2 * CONTROL_POINTS * CHANNELS * NUMBERS;
const _: () = assert!(DATA.len() == 4 * (SKY_LENGTH + TURBIDITIES * ELEVATIONS * CHANNELS));

fn number(index: usize) -> f64 {
    let bytes = [0, 1, 2, 3].map(|byte| DATA[4 * index + byte]);
    f64::from(f32::from_le_bytes(bytes))
}

/// The two whole turbidities around one, counted from 0, and the share of the second.
fn between_turbidities(turbidity: f64) -> ([usize; 2], f64) {
    let place = turbidity - 1.0;
    let first = (place as usize).min(TURBIDITIES - 1);
    ([first, (first + 1).min(TURBIDITIES - 1)], place - first as f64)
}

/// The sky of one sun.
#[derive(Clone, Debug)]
pub(super) struct Sky {
    /// A to I of each channel.
    coefficients: [[f32; 9]; CHANNELS],
    /// The factor on F; 0 with a sun at or below the horizon.
    scale: Rgb,
    /// Unit direction towards the sun, z up.
    sun: Vec3,
}

impl Sky {
    /// `sun` is a unit direction in the sky's own space.
    pub(super) fn new(turbidity: f64, albedo: [f64; CHANNELS], sun: DVec3, scale: f64) -> Self {
        let elevation = libm::asin(sun.z.clamp(-1.0, 1.0));
        let mut sky = Self { coefficients: [[0.0; 9]; CHANNELS], scale: Rgb::ZERO, sun: sun.as_vec3() };
        if elevation <= 0.0 {
            return sky;
        }
        // [Hosek & Wilkie 2012, section 5.3]: quintic Bézier curves over the cube root of the elevation.
        let along = libm::cbrt(elevation / std::f64::consts::FRAC_PI_2);
        for (channel, albedo) in albedo.into_iter().enumerate() {
            let value = |which| interpolated(turbidity, albedo, along, channel, which);
            sky.coefficients[channel] = std::array::from_fn(|which| value(which) as f32);
            sky.scale[channel] = (value(NUMBERS - 1) * scale) as f32;
        }
        sky
    }

    /// The radiance from a unit direction above the horizon, in the sky's own space.
    pub(super) fn radiance(&self, direction: Vec3) -> Rgb {
        let cosine = direction.dot(self.sun).clamp(-1.0, 1.0);
        let (angle, height) = (libm::acosf(cosine), direction.z.max(0.0));
        let factor = |[a, b, c, d, e, f, g, i, h]: [f32; 9]| {
            // χ of [Hosek & Wilkie 2012, eq. 9]; the tables have I before H.
            let base = 1.0 + h * h - 2.0 * h * cosine;
            let halo = (1.0 + cosine * cosine) / (base * base.sqrt());
            (1.0 + a * libm::expf(b / (height + 0.01)))
                * (c + d * libm::expf(e * angle) + f * cosine * cosine + g * halo + i * height.sqrt())
        };
        (Rgb::from_array(self.coefficients.map(factor)) * self.scale).max(Rgb::ZERO)
    }
}

/// One number of the table between turbidities, albedos and control points.
fn interpolated(turbidity: f64, albedo: f64, along: f64, channel: usize, which: usize) -> f64 {
    const BINOMIALS: [f64; CONTROL_POINTS] = [1.0, 5.0, 10.0, 10.0, 5.0, 1.0];
    let (turbidities, later) = between_turbidities(turbidity);
    let on_curve = |turbidity: usize, albedo: usize| -> f64 {
        let weight = |point: usize| {
            let (ahead, behind) = (point as i32, (CONTROL_POINTS - 1 - point) as i32);
            BINOMIALS[point] * along.powi(ahead) * (1.0 - along).powi(behind)
        };
        let index = |point: usize| (((turbidity * 2 + albedo) * CONTROL_POINTS + point) * CHANNELS + channel) * NUMBERS;
        (0..CONTROL_POINTS).map(|point| weight(point) * number(index(point) + which)).sum()
    };
    let [first, second] =
        turbidities.map(|turbidity| (1.0 - albedo) * on_curve(turbidity, 0) + albedo * on_curve(turbidity, 1));
    (1.0 - later) * first + later * second
}

/// The sun's irradiance on a surface that faces it, for the sine of its elevation; none at or below the horizon.
pub(super) fn sun_irradiance(turbidity: f64, sine: f64) -> DVec3 {
    const FIRST: f64 = 2.0;
    const STEP: f64 = 3.0;
    if sine <= 0.0 {
        return DVec3::ZERO;
    }
    let place = (libm::asin(sine.min(1.0)).to_degrees() - FIRST) / STEP;
    let place = place.clamp(0.0, (ELEVATIONS - 1) as f64);
    let row = (place as usize).min(ELEVATIONS - 2);
    let higher = place - row as f64;
    let (turbidities, later) = between_turbidities(turbidity);
    let [first, second] = turbidities.map(|turbidity| {
        let entry = |row: usize| {
            let index = SKY_LENGTH + (turbidity * ELEVATIONS + row) * CHANNELS;
            DVec3::new(number(index), number(index + 1), number(index + 2))
        };
        entry(row) * (1.0 - higher) + entry(row + 1) * higher
    });
    // Where the sun is low, its blue may lie outside of Rec. 709.
    (first * (1.0 - later) + second * later).max(DVec3::ZERO)
}
