//! Participating media: `homogeneous`, which absorbs and scatters the same everywhere.
//!
//! | parameter | meaning | unit, range | default |
//! |---|---|---|---|
//! | `sigma_t` | extinction | m⁻¹ | 1 |
//! | `albedo` | the share of extinct light that is scattered | 0 to 1 | 0.75 |
//! | `scale` | factor on the extinction | – | 1 |
//! | a nested `phase` | where light is scattered to: `isotropic`, `hg` (`g`, -1 to 1, 0.8), `rayleigh` | – | `isotropic` |
//!
//! Colors may also be `constvolume`s. References: [PH] Pharr, Jakob & Humphreys 2016, "Physically based rendering", chapters 11 and 15.

use std::f32::consts::FRAC_1_PI;

use super::description::{Node, PluginClass};
use super::error::{SceneError, nearest_name};
use super::fields::Fields;
use crate::math::{Frame, Rgb, Vec3, warp};

/// A medium by its index in the scene; none where there is nothing.
pub type MediumIndex = Option<u16>;

/// A medium.
#[derive(Clone, Copy, Debug)]
pub struct Medium {
    /// Extinction, m⁻¹.
    extinction: Rgb,
    /// Scattering, m⁻¹.
    scattering: Rgb,
    /// Where light is scattered to.
    pub phase: Phase,
}

/// A distribution of scattered directions; cosines are those between the directions in which light comes and goes.
#[derive(Clone, Copy, Debug)]
pub enum Phase {
    /// The same everywhere.
    Isotropic,
    /// Henyey and Greenstein's, with the mean cosine.
    HenyeyGreenstein(f32),
    /// That of particles much smaller than the wavelength.
    Rayleigh,
}

/// What becomes of a ray in a medium; the weights are throughputs over densities.
#[derive(Clone, Copy, Debug)]
pub enum Flight {
    /// It is scattered after a distance, m.
    Scattered(f32, Rgb),
    /// It arrives.
    Through(Rgb),
}

/// Reads a medium.
///
/// # Errors
/// Other kinds than `homogeneous`, and parameters out of range.
pub(super) fn read(node: &Node) -> Result<Medium, SceneError> {
    if node.plugin != "homogeneous" {
        let problem = format!("medium \"{}\" is not supported", node.plugin);
        return Err(SceneError::new(&node.location, problem, "only \"homogeneous\" media are rendered"));
    }
    let mut fields = Fields::new(node);
    let extinction = color(&mut fields, "sigma_t", 1.0)?;
    let albedo = color(&mut fields, "albedo", 0.75)?;
    let scale = fields.float("scale")?.unwrap_or(1.0);
    if scale < 0.0 || albedo.max_element() > 1.0 {
        let (name, problem) = match scale < 0.0 {
            true => ("scale", format!("\"scale\" is {scale}")),
            false => ("albedo", "\"albedo\" is above 1: it would scatter more than arrives".to_owned()),
        };
        return Err(fields.error(name, problem, "give a scale of at least 0, and an albedo from 0 to 1"));
    }
    // They choose how Mitsuba samples.
    fields.ignore(&["sample_emitters", "has_spectral_extinction"]);
    let phase = fields.child(PluginClass::Phase).map_or(Ok(Phase::Isotropic), |node| read_phase(node))?;
    fields.finish()?;
    let extinction = extinction * scale as f32;
    Ok(Medium { extinction, scattering: extinction * albedo, phase })
}

/// A color of at least 0, which may be a `constvolume`.
fn color(fields: &mut Fields<'_>, name: &'static str, default: f64) -> Result<Rgb, SceneError> {
    let rgb = match fields.named_child(PluginClass::Volume, name) {
        None => fields.rgb(name)?.unwrap_or([default; 3]),
        Some(volume) if volume.plugin == "constvolume" => {
            let mut inside = Fields::new(volume);
            let value = inside.rgb("value")?.unwrap_or([1.0; 3]);
            inside.finish()?;
            value
        }
        Some(volume) => {
            let problem = format!("volume \"{}\" is not supported", volume.plugin);
            return Err(SceneError::new(&volume.location, problem, "only \"constvolume\" can be read"));
        }
    };
    Ok(Rgb::from_array(rgb.map(|channel| channel as f32)))
}

fn read_phase(node: &Node) -> Result<Phase, SceneError> {
    let mut fields = Fields::new(node);
    let phase = match node.plugin.as_str() {
        "isotropic" => Phase::Isotropic,
        "rayleigh" => Phase::Rayleigh,
        "hg" => {
            let mean = fields.float("g")?.unwrap_or(0.8);
            if !(mean > -1.0 && mean < 1.0) {
                return Err(fields.error("g", format!("\"g\" is {mean}"), "give a number above -1 and below 1"));
            }
            Phase::HenyeyGreenstein(mean as f32)
        }
        other => {
            let problem = format!("phase function \"{other}\" is not supported");
            let remedy = nearest_name(other, &["isotropic", "hg", "rayleigh"]);
            return Err(SceneError::new(&node.location, problem, remedy));
        }
    };
    fields.finish()?;
    Ok(phase)
}

impl Medium {
    /// The share of light that passes `distance`, m.
    #[inline]
    pub fn transmittance(&self, distance: f32) -> Rgb {
        // Nothing times an infinite distance is nothing.
        let depth = |extinction: f32| if extinction == 0.0 { 0.0 } else { extinction * distance };
        Rgb::from_array(self.extinction.to_array().map(|extinction| libm::expf(-depth(extinction))))
    }

    /// Samples how far a ray of length `distance`, m, gets, by the extinction of one channel: their mean is the density [PH, 15.2.1].
    pub fn fly(&self, distance: f32, u: f32) -> Flight {
        let channel = ((3.0 * u) as usize).min(2);
        let rest = (3.0 * u - channel as f32).clamp(0.0, 1.0 - f32::EPSILON);
        let mean = |rgb: Rgb| (rgb.x + rgb.y + rgb.z) / 3.0;
        let reached = match self.extinction[channel] {
            0.0 => f32::INFINITY,
            extinction => -libm::log1pf(-rest) / extinction,
        };
        let passing = self.transmittance(reached.min(distance));
        let weighted = |value: Rgb, density: f32| if density > 0.0 { value / density } else { Rgb::ZERO };
        if reached < distance {
            let density = mean(self.extinction * passing);
            Flight::Scattered(reached, weighted(self.scattering * passing, density))
        } else {
            Flight::Through(weighted(passing, mean(passing)))
        }
    }
}

impl Phase {
    /// The value, sr⁻¹, which is the density of [`Phase::sample`], for the unit directions in which light goes before and after.
    #[inline]
    pub fn value(self, before: Vec3, after: Vec3) -> f32 {
        let cosine = before.dot(after);
        match self {
            Self::Isotropic => warp::SPHERE_PDF,
            Self::HenyeyGreenstein(mean) => {
                let below = (1.0 + mean * mean - 2.0 * mean * cosine).max(f32::MIN_POSITIVE);
                warp::SPHERE_PDF * (1.0 - mean * mean) / (below * below.sqrt())
            }
            Self::Rayleigh => 3.0 / 16.0 * FRAC_1_PI * (1.0 + cosine * cosine),
        }
    }

    /// A direction after scattering, and its density by solid angle [PH, 15.2.3].
    #[inline]
    pub fn sample(self, before: Vec3, u: [f32; 2]) -> (Vec3, f32) {
        let after = match self {
            Self::Isotropic => warp::sphere(u),
            Self::HenyeyGreenstein(mean) if mean.abs() < 1e-3 => warp::sphere(u),
            Self::HenyeyGreenstein(mean) => {
                let ratio = (1.0 - mean * mean) / (1.0 - mean + 2.0 * mean * u[0]);
                around(before, (1.0 + mean * mean - ratio * ratio) / (2.0 * mean), u[1])
            }
            Self::Rayleigh => {
                // The root of z³ + 3z = 8u - 4.
                let half = 4.0 * u[0] - 2.0;
                let root = libm::cbrtf(half + (1.0 + half * half).sqrt());
                around(before, root - 1.0 / root, u[1])
            }
        };
        (after, self.value(before, after))
    }
}

/// The direction at a cosine against `axis`.
fn around(axis: Vec3, cosine: f32, u: f32) -> Vec3 {
    let cosine = cosine.clamp(-1.0, 1.0);
    let sine = (1.0 - cosine * cosine).sqrt();
    let (sin, cos) = crate::math::trigonometry::sin_cos_turn(u);
    Frame::from_normal(axis).to_world(Vec3::new(sine * cos, sine * sin, cosine)).normalize()
}
