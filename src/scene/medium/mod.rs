//! Participating media: `homogeneous` ones are the same everywhere, `heterogeneous` ones vary.
//!
//! | parameter | meaning | unit, range | default |
//! |---|---|---|---|
//! | `sigma_t` | extinction | m⁻¹, at least 0 | 1 |
//! | `albedo` | the share of extinct light that is scattered | 0 to 1 | 0.75 |
//! | `scale` | factor on the extinction | –, at least 0 | 1 |
//! | a nested `phase` | where light is scattered to: `isotropic`, `hg` (`g`, -1 to 1, 0.8), `rayleigh` | – | `isotropic` |
//!
//! Colors may also be volumes; only `heterogeneous` media take grids, and they end where the box of their `sigma_t` does: the unit cube
//! under its `to_world`, also of a constant one.

mod heterogeneous;
mod homogeneous;
mod phase;
mod volume;

pub(crate) use heterogeneous::Heterogeneous;
pub(crate) use homogeneous::Homogeneous;
pub(crate) use phase::Phase;

use super::bundle::Bundle;
use super::description::{Node, PluginClass};
use super::error::{SceneError, shown_number};
use super::fields::Fields;
use super::geometry::Ray;
use crate::math::Rgb;
use crate::math::random::PathRandom;

/// A medium by its index in the scene; none where there is nothing.
pub type MediumIndex = Option<u16>;

/// A medium.
#[derive(Clone, Debug)]
pub struct Medium {
    kind: Kind,
    /// Where light is scattered to.
    pub phase: Phase,
}

#[derive(Clone, Debug)]
enum Kind {
    Homogeneous(Homogeneous),
    Heterogeneous(Box<Heterogeneous>),
}

/// What becomes of a ray in a medium.
#[derive(Clone, Copy, Debug)]
pub struct Flight {
    /// After what distance it is scattered, m; `None` where it arrives.
    pub scattered: Option<f32>,
    /// Throughput over density.
    pub weight: Rgb,
}

/// Random numbers of a flight.
#[derive(Clone, Copy, Debug)]
pub struct FlightNumbers {
    /// One in [0, 1) that may be spread evenly.
    pub first: f32,
    /// As many more as it takes.
    pub more: PathRandom,
}

/// Reads a medium.
///
/// # Errors
/// Other kinds, and parameters out of range.
pub(super) fn read(node: &Node, bundle: &Bundle) -> Result<Medium, SceneError> {
    let varies = match node.plugin.as_str() {
        "homogeneous" => false,
        "heterogeneous" => true,
        other => {
            let problem = format!("medium \"{other}\" is not supported");
            return Err(SceneError::new(&node.location, problem, "use \"homogeneous\" or \"heterogeneous\""));
        }
    };
    let mut fields = Fields::new(node);
    let box_of_extinction = fields.named_child(PluginClass::Volume, "sigma_t").map(|node| &**node);
    let mut extinction = volume::read(&mut fields, "sigma_t", 1.0, f64::INFINITY, bundle)?;
    if varies {
        extinction = volume::boxed(extinction, box_of_extinction)?;
    }
    let albedo = volume::read(&mut fields, "albedo", 0.75, 1.0, bundle)?;
    let scale = fields.float("scale")?.unwrap_or(1.0);
    if scale < 0.0 {
        return Err(fields.error(
            "scale",
            format!("\"scale\" is {}", shown_number(scale)),
            "give a scale of at least 0",
        ));
    }
    // They choose how Mitsuba samples.
    fields.ignore(&["sample_emitters", "has_spectral_extinction"]);
    let phase = fields.child(PluginClass::Phase).map_or(Ok(Phase::Isotropic), |node| phase::read(node))?;
    fields.finish()?;
    let scale = scale as f32;
    check_extinction(node, extinction.largest() * scale, extinction.size(), albedo.largest() > 0.0)?;
    let kind = match (extinction.constant(), albedo.constant()) {
        (Some(extinction), Some(albedo)) if !varies => Kind::Homogeneous(Homogeneous::new(extinction * scale, albedo)),
        _ if varies => Kind::Heterogeneous(Box::new(Heterogeneous::new(extinction, albedo, scale))),
        _ => {
            let problem = "medium \"homogeneous\" has a grid, which varies";
            return Err(SceneError::new(&node.location, problem, "make it \"heterogeneous\""));
        }
    };
    Ok(Medium { kind, phase })
}

/// The densest medium that scatters, m⁻¹: single precision cannot follow shorter flights.
const DENSEST: f32 = 1e6;
/// The most mean free paths across a grid: each is a collision to look at.
const MOST_FREE_PATHS: f32 = 1e4;

/// Refuses extinctions, at most `largest`, m⁻¹, that flights cannot be sampled for; a grid's `size` is in m.
fn check_extinction(node: &Node, largest: f32, size: Option<f32>, scatters: bool) -> Result<(), SceneError> {
    let refused = |problem: String| {
        Err(SceneError::new(
            &node.location,
            problem,
            "make it thinner: give a smaller \"sigma_t\", or \"sigma_a\" and \"sigma_s\", or \"scale\"",
        ))
    };
    if !largest.is_finite() {
        return refused("the extinction of the medium does not fit into single precision".to_owned());
    }
    if scatters && largest > DENSEST {
        return refused(format!("the medium scatters with an extinction of {largest:e} m⁻¹, above {DENSEST:e}"));
    }
    match size.map(|size| size * largest).filter(|paths| *paths > MOST_FREE_PATHS) {
        Some(paths) => refused(format!(
            "the grid is {paths:e} mean free paths wide where it is densest, above {MOST_FREE_PATHS:e}"
        )),
        None => Ok(()),
    }
}

impl Medium {
    /// Whether all that it does is to absorb, by a share that depends on the distance alone: what every method renders.
    pub fn only_absorbs(&self) -> bool {
        matches!(&self.kind, Kind::Homogeneous(medium) if !medium.scatters())
    }

    /// The share of light that passes the ray's length, exact in homogeneous media and else an estimate.
    #[inline]
    pub fn transmittance(&self, ray: &Ray, numbers: impl FnOnce() -> PathRandom) -> Rgb {
        match &self.kind {
            Kind::Homogeneous(medium) => medium.transmittance(ray.length),
            Kind::Heterogeneous(medium) => medium.transmittance(ray, &numbers()),
        }
    }

    /// Samples how far a ray gets within its length.
    pub fn fly(&self, ray: &Ray, numbers: impl FnOnce() -> FlightNumbers) -> Flight {
        let (scattered, weight) = match &self.kind {
            Kind::Homogeneous(medium) if !medium.scatters() => (None, medium.transmittance(ray.length)),
            Kind::Homogeneous(medium) => medium.fly(ray.length, numbers().first),
            Kind::Heterogeneous(medium) => medium.fly(ray, &numbers().more),
        };
        Flight { scattered, weight }
    }
}
