//! `envmap`: light from all around, from an image of latitude and longitude.
//!
//! | parameter | meaning | unit, range | default |
//! |---|---|---|---|
//! | `filename` | the image, at least 2 × 2; its values are radiance | W·sr⁻¹·m⁻² | required |
//! | `scale` | factor on the image | ≥ 0 | 1 |
//! | `to_world` | a similarity; y is up | – | identity |
//!
//! The top row is the direction +y, the bottom row -y: row i of h lies at the polar angle π·i/(h - 1). Column j of w lies at
//! the turn (j + ½)/w from -z towards +x. Radiance is bilinear in both angles between them, as in Mitsuba.
//!
//! Sampling picks a cell between four texels by the power that comes from it, then a direction uniform by solid angle in it.

use std::f32::consts::FRAC_1_PI;
use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::{DirectSample, EmittedPhoton, LightImportance, Surroundings};
use crate::math::color::luminance;
use crate::math::grid_distribution::GridDistribution;
use crate::math::trigonometry::sin_cos_turn;
use crate::math::{Rgb, color};
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;
use crate::scene::geometry::transform::ToWorld;
use crate::scene::texture::{Raster, TextureReader};

/// An image of the surroundings.
#[derive(Clone, Debug)]
pub struct EnvironmentMap {
    raster: Arc<Raster>,
    scale: f32,
    /// The unit axes of the map's own space.
    axes: [Vec3; 3],
    bands: Vec<Band>,
    /// By luminance and solid angle; `None` when the map is black.
    cells: Option<GridDistribution>,
    /// What enters the box around the scene, W.
    power: Rgb,
    surroundings: Surroundings,
}

/// The directions between two rows of texels, at polar angles θ₀ and θ₁.
#[derive(Clone, Copy, Debug)]
struct Band {
    /// sin² θ/2 and cos² θ/2 at θ₀: in this form neither pole loses digits.
    start: [f32; 2],
    /// The same at θ₁.
    end: [f32; 2],
    /// Solid angle of one cell, sr.
    cell: f32,
    /// The parts of it that bilinear weights give to the upper and to the lower row, sr.
    shares: [f64; 2],
}

impl Band {
    fn new(row: usize, width: usize, height: usize) -> Self {
        let step = std::f64::consts::PI / (height - 1) as f64;
        let (first, last) = (step * row as f64, step * (row + 1) as f64);
        let halves = |angle: f64| [libm::sin(0.5 * angle), libm::cos(0.5 * angle)].map(|half| half * half);
        let (start, end) = (halves(first), halves(last));
        let column = std::f64::consts::TAU / width as f64;
        // Not a difference of cosines where it would cancel: cos θ₀ - cos θ₁ = 2 (sin² θ₁/2 - sin² θ₀/2).
        let whole = 2.0 * if row * 2 < height { end[0] - start[0] } else { start[1] - end[1] };
        // ∫ t sin θ dθ with t from 0 to 1.
        let lower = (libm::sin(last) - libm::sin(first)) / step - libm::cos(last);
        Self {
            start: start.map(|half| half as f32),
            end: end.map(|half| half as f32),
            cell: (whole * column) as f32,
            shares: [(whole - lower) * column, lower * column],
        }
    }
}

/// A place among the texels: the cell, and how far into it.
#[derive(Clone, Copy, Debug)]
struct Place {
    row: usize,
    column: usize,
    /// Towards the next row.
    down: f32,
    /// Towards the next column.
    along: f32,
}

impl EnvironmentMap {
    /// Reads the parameters.
    pub fn read(
        fields: &mut Fields<'_>,
        textures: &mut TextureReader<'_>,
        surroundings: Surroundings,
    ) -> Result<Self, SceneError> {
        let raster = textures.colors(fields)?;
        let (width, height) = (raster.width(), raster.height());
        if width < 2 || height < 2 {
            let problem = format!("the environment map has {width} × {height} pixels");
            return Err(fields.error("filename", problem, "give an image of at least 2 × 2"));
        }
        let scale = fields.float("scale")?.unwrap_or(1.0);
        if scale < 0.0 {
            return Err(fields.error(
                "scale",
                format!("\"scale\" is {}", shown_number(scale)),
                "give a number of at least 0",
            ));
        }
        let to_world = ToWorld::read(fields)?;
        to_world.check_similarity(fields)?;
        // Chooses how Mitsuba samples; it changes no picture.
        fields.ignore(&["mis_compensation"]);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_world.vector(axis).normalize().as_vec3());
        Ok(Self::new(raster, scale as f32, axes, surroundings))
    }

    pub(super) fn new(raster: Arc<Raster>, scale: f32, axes: [Vec3; 3], surroundings: Surroundings) -> Self {
        let (width, height) = (raster.width(), raster.height());
        let bands: Vec<Band> = (0..height - 1).map(|row| Band::new(row, width, height)).collect();
        let mut weights = Vec::with_capacity(width * bands.len());
        for (row, band) in bands.iter().enumerate() {
            for column in 0..width {
                let pair = |row| (raster.texel(column, row) + raster.texel((column + 1) % width, row)).as_dvec3() * 0.5;
                let arriving = pair(row) * band.shares[0] + pair(row + 1) * band.shares[1];
                weights.push(f64::from(color::luminance(arriving.as_vec3())));
            }
        }
        let cells = (scale > 0.0).then(|| GridDistribution::new(&weights, width)).flatten();
        let power = Rgb::ZERO;
        let mut map = Self { raster, scale, axes, bands, cells, power, surroundings };
        map.power = super::mean_flux(&surroundings, |u| map.sample(u));
        map
    }

    fn place(&self, direction: Vec3) -> Place {
        let [x, y, z] = self.axes.map(|axis| direction.dot(axis));
        let turn = libm::atan2f(x, -z) * (0.5 * FRAC_1_PI);
        let (width, rows) = (self.raster.width(), self.bands.len());
        let across = (turn - turn.floor()) * width as f32 - 0.5;
        let down = libm::atan2f(libm::sqrtf(x * x + z * z), y) * FRAC_1_PI * rows as f32;
        let (left, row) = (across.floor(), (down as usize).min(rows - 1));
        let column = if left < 0.0 { width - 1 } else { (left as usize).min(width - 1) };
        Place { row, column, down: (down - row as f32).min(1.0), along: across - left }
    }

    fn radiance_at(&self, place: &Place) -> Rgb {
        let next = if place.column + 1 == self.raster.width() { 0 } else { place.column + 1 };
        let row = |row| self.raster.texel(place.column, row).lerp(self.raster.texel(next, row), place.along);
        row(place.row).lerp(row(place.row + 1), place.down) * self.scale
    }

    /// The radiance from `direction`, and the density by solid angle with which [`EnvironmentMap::sample_direct`] takes it.
    #[inline]
    pub fn arriving(&self, direction: Vec3) -> (Rgb, f32) {
        let place = self.place(direction);
        (self.radiance_at(&place), self.density(&place))
    }

    /// The density of [`EnvironmentMap::arriving`] alone.
    pub(super) fn pdf(&self, direction: Vec3) -> f32 {
        self.density(&self.place(direction))
    }

    #[inline]
    fn density(&self, place: &Place) -> f32 {
        let probability = self.cells.as_ref().map_or(0.0, |cells| cells.probability(place.row, place.column));
        probability / self.bands[place.row].cell
    }

    /// See [`DirectSample::emission_ratio`], m⁻².
    #[inline]
    pub fn emission_ratio(&self, direction: Vec3) -> f32 {
        1.0 / self.surroundings.silhouette(direction)
    }

    /// What enters the box around the scene.
    pub fn power(&self) -> Rgb {
        self.power
    }

    /// Its mean on the box around the scene.
    pub fn importance(&self, _geometry: &Geometry) -> LightImportance {
        LightImportance::Far { irradiance: luminance(self.power) / self.surroundings.surface() }
    }

    /// A direction by the light that comes from it.
    #[inline]
    pub fn sample_direct(&self, _geometry: &Geometry, _point: Vec3, u: [f32; 2]) -> Option<DirectSample> {
        self.sample(u)
    }

    #[inline]
    pub(super) fn sample(&self, u: [f32; 2]) -> Option<DirectSample> {
        let cells = self.cells.as_ref()?;
        let ([row, column], [down, along]) = cells.pick(u);
        let band = &self.bands[row];
        let [sine, cosine] = [0, 1].map(|half| band.start[half] + (band.end[half] - band.start[half]) * down);
        let turn = (column as f32 + 0.5 + along) / self.raster.width() as f32;
        let (sin, cos) = sin_cos_turn(if turn >= 1.0 { turn - 1.0 } else { turn });
        let across = 2.0 * (sine * cosine).sqrt();
        let [x, y, z] = self.axes;
        let direction = (x * (sin * across) + y * (cosine - sine) - z * (cos * across)).normalize();
        let polar = libm::atan2f(sine.sqrt(), cosine.sqrt()) * (2.0 * FRAC_1_PI) * self.bands.len() as f32;
        let place = Place { row, column, down: (polar - row as f32).clamp(0.0, 1.0), along };
        let pdf_solid_angle = cells.probability(row, column) / band.cell;
        let weighted_radiance = self.radiance_at(&place) / pdf_solid_angle;
        let emission_ratio = self.emission_ratio(direction);
        Some(DirectSample { direction, distance: f32::INFINITY, weighted_radiance, pdf_solid_angle, emission_ratio })
    }

    /// A direction by the light that comes from it, and a place uniform over the silhouette of the box around the scene.
    #[inline]
    pub fn emit(&self, _geometry: &Geometry, place: [f32; 2], direction: [f32; 2]) -> Option<EmittedPhoton> {
        let sample = self.sample(direction)?;
        Some(self.surroundings.photon(-sample.direction, place, sample.weighted_radiance, sample.pdf_solid_angle))
    }
}
