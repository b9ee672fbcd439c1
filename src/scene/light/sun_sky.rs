//! `sunsky`: the sky and the sun of a clear day, by Hosek & Wilkie's model.
//!
//! | parameter | meaning | unit, range | default |
//! |---|---|---|---|
//! | `turbidity` | haze: 2 is a very clear sky, 10 a hazy one | 1 to 10 | 3 |
//! | `albedo` | color of the ground, which lights the sky | 0 to 1 | 0.3 |
//! | `sun_direction` | towards the sun, in the world | – | from place and time |
//! | `latitude`, `longitude` | the place, north and east | degrees | 35.6894, 139.6917 |
//! | `timezone` | its hours before Greenwich | h | 9 |
//! | `year`, `month`, `day`, `hour`, `minute`, `second` | the time there | – | 2010, 7, 10, 15, 0, 0 |
//! | `sun_scale`, `sky_scale` | factors | 0 to 1e20 | 1 |
//! | `sun_aperture` | angle across the sun, which keeps its irradiance | degrees, 0.0001 to below 90 | 0.5358 |
//! | `to_world` | a similarity; z is up, x south, y west | – | identity |
//!
//! The sky's radiance is F(θ, γ)·L of [Hosek & Wilkie 2012, eq. 8 and 11] for each channel of linear Rec. 709, in units that
//! make it about 0.1, as in Mitsuba 3.9.1. The sun is a disc of one radiance (Mitsuba's `complex_sun` off) with the irradiance of
//! [Hosek & Wilkie 2013]. Below the horizon, and with a sun at or below it, everything is black.
//!
//! Directions are picked by a table of the sky's luminance and from the sun's cone; radiances are those of the formula.

mod average;
mod date;
mod model;
mod position;
pub(crate) mod timed;

use std::sync::Arc;

use glam::{DVec3, Vec3};

use super::{DirectSample, EmittedPhoton, EnvironmentMap, LightImportance, Surroundings};
use crate::math::color::luminance;
use crate::math::discrete::ONE_MINUS_EPSILON;
use crate::math::{Frame, Rgb, warp};
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;
use crate::scene::geometry::Geometry;
use crate::scene::geometry::transform::ToWorld;
use crate::scene::texture::Raster;
use model::Sky;

/// A clear day.
#[derive(Clone, Debug)]
pub struct SunSky {
    // Boxed, so that all lights stay as small as they are without days.
    sky: Box<Sky>,
    /// The unit axes of the sky's own space; the third is up.
    axes: [Vec3; 3],
    /// Picks directions by the sky's light.
    table: Box<EnvironmentMap>,
    sun: Disc,
    /// The share of directions that is picked from the sun's cone.
    sun_share: f32,
    /// What enters the box around the scene, W.
    power: Rgb,
    surroundings: Surroundings,
}

/// The sun.
#[derive(Clone, Copy, Debug)]
struct Disc {
    /// Unit direction towards its middle, in the world.
    direction: Vec3,
    /// Of half the angle across it.
    one_minus_cosine: f32,
    radiance: Rgb,
}

impl Disc {
    fn contains(&self, direction: Vec3) -> bool {
        // This form keeps narrow cones exact.
        0.5 * direction.distance_squared(self.direction) <= self.one_minus_cosine
    }
}

/// A factor, 1 by default. Radiances stay in the range of single numbers.
fn read_scale(fields: &mut Fields<'_>, name: &'static str) -> Result<f64, SceneError> {
    position::number(fields, name, 1.0, [0.0, 1e20])
}

/// What a sky looks like but for where its sun stands.
#[derive(Clone, Debug)]
struct Appearance {
    turbidity: f64,
    albedo: [f64; 3],
    /// Angle across the sun, rad.
    aperture: f64,
    sun_scale: f64,
    sky_scale: f64,
    /// The unit axes of the sky's own space; the third is up.
    axes: [DVec3; 3],
}

impl Appearance {
    fn read(fields: &mut Fields<'_>) -> Result<Self, SceneError> {
        let to_world = ToWorld::read(fields)?;
        to_world.check_similarity(fields)?;
        let turbidity = position::number(fields, "turbidity", 3.0, [1.0, 10.0])?;
        let albedo = fields.rgb("albedo")?.unwrap_or([0.3; 3]);
        if albedo.iter().any(|share| *share > 1.0) {
            return Err(fields.error("albedo", "\"albedo\" is above 1", "give numbers from 0 to 1"));
        }
        let aperture = fields.float("sun_aperture")?.unwrap_or(0.5358);
        if !(1e-4..90.0).contains(&aperture) {
            let problem = format!("\"sun_aperture\" is {} degrees", shown_number(aperture));
            return Err(fields.error("sun_aperture", problem, "give an angle of at least 0.0001 and below 90 degrees"));
        }
        if fields.boolean("complex_sun")?.unwrap_or(false) {
            let problem = "\"complex_sun\" is not supported: the sun is as bright at its rim as in its middle";
            return Err(fields.error("complex_sun", problem, "leave it out"));
        }
        // Chooses how Mitsuba samples; it changes no picture.
        fields.ignore(&["sampling_weight"]);
        let axes = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| to_world.vector(axis).normalize());
        let (sun_scale, sky_scale) = (read_scale(fields, "sun_scale")?, read_scale(fields, "sky_scale")?);
        Ok(Self { turbidity, albedo, aperture: aperture.to_radians(), sun_scale, sky_scale, axes })
    }

    /// 1 − cos of half the angle across the sun.
    fn one_minus_cosine(&self) -> f64 {
        let half = libm::sin(0.25 * self.aperture);
        2.0 * half * half
    }

    /// Of the sun, sr.
    fn solid_angle(&self) -> f64 {
        std::f64::consts::TAU * self.one_minus_cosine()
    }
}

impl SunSky {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, surroundings: Surroundings) -> Result<Self, SceneError> {
        let appearance = Appearance::read(fields)?;
        let sun = position::read(fields)?.local(appearance.axes);
        Ok(Self::at(&appearance, sun, surroundings))
    }

    /// The day with its sun at a unit vector of the sky's own space.
    fn at(appearance: &Appearance, sun: DVec3, surroundings: Surroundings) -> Self {
        let axes = appearance.axes;
        let sky = Sky::new(appearance.turbidity, appearance.albedo, sun, appearance.sky_scale);
        let irradiance = model::sun_irradiance(appearance.turbidity, sun.z) * appearance.sun_scale;
        let disc = Disc {
            direction: (axes[0] * sun.x + axes[1] * sun.y + axes[2] * sun.z).normalize().as_vec3(),
            one_minus_cosine: appearance.one_minus_cosine() as f32,
            radiance: (irradiance / appearance.solid_angle()).as_vec3(),
        };
        Self::new(sky, disc, luminance(irradiance.as_vec3()), axes.map(|axis| axis.as_vec3()), surroundings)
    }

    /// How high the sun stands over the horizon, degrees.
    pub fn elevation(&self) -> f32 {
        libm::asinf(self.axes[2].dot(self.sun.direction).clamp(-1.0, 1.0)).to_degrees()
    }

    /// `sun_light` is the luminance of the sun's irradiance.
    fn new(sky: Sky, sun: Disc, sun_light: f32, axes: [Vec3; 3], surroundings: Surroundings) -> Self {
        let (raster, sky_light) = tabulate(&sky);
        // Those of the table have y up.
        let table = EnvironmentMap::new(Arc::new(raster), 1.0, [axes[0], axes[2], -axes[1]], surroundings);
        let sun_share = match (sun_light > 0.0, sky_light > 0.0) {
            (false, _) => 0.0,
            (true, false) => 1.0,
            (true, true) => (sun_light / (sun_light + sky_light)).clamp(0.1, 0.9),
        };
        let (sky, table) = (Box::new(sky), Box::new(table));
        let mut light = Self { sky, axes, table, sun, sun_share, power: Rgb::ZERO, surroundings };
        light.power = super::mean_flux(&surroundings, |u| light.sample(u));
        light
    }

    fn radiance(&self, direction: Vec3, sees_sun: bool) -> Rgb {
        let [x, y, z] = self.axes.map(|axis| axis.dot(direction));
        if z < 0.0 {
            return Rgb::ZERO;
        }
        let sky = self.sky.radiance(Vec3::new(x, y, z));
        if sees_sun { sky + self.sun.radiance } else { sky }
    }

    /// The radiance from `direction`, and the density by solid angle with which [`SunSky::sample_direct`] takes it.
    #[inline]
    pub fn arriving(&self, direction: Vec3) -> (Rgb, f32) {
        let sees_sun = self.sun_share > 0.0 && self.sun.contains(direction);
        let by_sun = if sees_sun { self.sun_share * warp::cone_pdf(self.sun.one_minus_cosine) } else { 0.0 };
        let by_sky = if self.sun_share < 1.0 { (1.0 - self.sun_share) * self.table.pdf(direction) } else { 0.0 };
        (self.radiance(direction, sees_sun), by_sun + by_sky)
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

    fn sample(&self, u: [f32; 2]) -> Option<DirectSample> {
        let direction = if u[0] < self.sun_share {
            let local = warp::cone(self.sun.one_minus_cosine, [u[0] / self.sun_share, u[1]]);
            Frame::from_normal(self.sun.direction).to_world(local).normalize()
        } else {
            let rest = ((u[0] - self.sun_share) / (1.0 - self.sun_share)).min(ONE_MINUS_EPSILON);
            self.table.sample([rest, u[1]])?.direction
        };
        let (radiance, pdf_solid_angle) = self.arriving(direction);
        (pdf_solid_angle > 0.0).then(|| DirectSample {
            direction,
            distance: f32::INFINITY,
            weighted_radiance: radiance / pdf_solid_angle,
            pdf_solid_angle,
            emission_ratio: self.emission_ratio(direction),
        })
    }

    /// A direction by the light that comes from it, and a place uniform over the silhouette of the box around the scene.
    #[inline]
    pub fn emit(&self, _geometry: &Geometry, place: [f32; 2], direction: [f32; 2]) -> Option<EmittedPhoton> {
        let sample = self.sample(direction)?;
        Some(self.surroundings.photon(-sample.direction, place, sample.weighted_radiance, sample.pdf_solid_angle))
    }
}

/// The sky as an image of latitude and longitude with y up, and the luminance that all of it sends, W·m⁻².
fn tabulate(sky: &Sky) -> (Raster, f32) {
    /// An odd number of rows has one at the horizon.
    const SIZE: [usize; 2] = [256, 129];
    let [width, height] = SIZE;
    let mut light = 0.0;
    let texel = |index: usize| {
        let (column, row) = (index % width, index / width);
        let polar = std::f64::consts::PI * row as f64 / (height - 1) as f64;
        let turn = std::f64::consts::TAU * (column as f64 + 0.5) / width as f64;
        let across = libm::sin(polar);
        // -z of the image is y of the sky.
        let direction = DVec3::new(across * libm::sin(turn), across * libm::cos(turn), libm::cos(polar)).as_vec3();
        let radiance = if 2 * row < height { sky.radiance(direction.with_z(direction.z.max(0.0))) } else { Rgb::ZERO };
        let solid_angle = std::f64::consts::TAU / width as f64 * std::f64::consts::PI / (height - 1) as f64 * across;
        light += f64::from(luminance(radiance)) * solid_angle;
        radiance.to_array()
    };
    (Raster::of_numbers(width, height, (0..width * height).map(texel).collect()), light as f32)
}
