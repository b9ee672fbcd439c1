//! Lights: one file per kind, one row in `lights!`.
//!
//! Conventions: `radiance` is W·sr⁻¹·m⁻², `flux` is W; densities name their measure. A light is sampled in two ways: towards a
//! given point (direct light), and outwards (photons).

pub(crate) mod area;
pub(crate) mod constant;
mod dark;
pub(crate) mod directional;
pub(crate) mod directional_area;
pub mod emission_guide;
pub(crate) mod environment_map;
pub(crate) mod groups;
pub(crate) mod ies;
pub mod importance;
pub mod importance_sampler;
pub(crate) mod point;
pub(crate) mod projector;
mod read;
pub(crate) mod spot;
pub(crate) mod sun_sky;
pub(crate) mod surroundings;
pub(crate) mod table;
pub mod visibility;
pub(crate) mod whereabouts;

use glam::DVec3;

use crate::math::discrete::ONE_MINUS_EPSILON;
use crate::math::{Rgb, Vec3};
use crate::scene::geometry::{Geometry, Interaction};

pub use area::AreaLight;
pub use constant::Constant;
pub use dark::Dark;
pub use directional::Directional;
pub use directional_area::DirectionalArea;
pub use environment_map::EnvironmentMap;
pub use groups::{GroupName, LightGroups};
pub use ies::Ies;
pub use importance::{LightImportance, Place};
pub use point::Point;
pub use projector::Projector;
pub use read::{check_sampling_weight, read};
pub use spot::Spot;
pub use sun_sky::SunSky;
pub use surroundings::Surroundings;
pub use table::{FoundLight, LightPick, LightTable};
pub use visibility::LightVisibility;
pub use whereabouts::Whereabouts;

/// Light that may arrive at a point, before anything in between is looked at.
#[derive(Clone, Copy, Debug)]
pub struct DirectSample {
    /// Unit direction towards the light.
    pub direction: Vec3,
    /// Distance to the light, m; infinite for lights without a place.
    pub distance: f32,
    /// What arrives over the sample's density: radiance/pdf, or intensity/distance² for lights without extent.
    pub weighted_radiance: Rgb,
    /// Density by solid angle; 0 marks a light that directions cannot hit by chance.
    pub pdf_solid_angle: f32,
    /// The density by area with which photons that leave this place of the light meet a surface at the point, over that of
    /// this sample, for a surface that faces the light; to be multiplied with its cosine.
    pub emission_ratio: f32,
}

/// A photon as it leaves a light.
#[derive(Clone, Copy, Debug)]
pub struct EmittedPhoton {
    /// Where it starts, m.
    pub origin: Vec3,
    /// Unit direction.
    pub direction: Vec3,
    /// Le·cos/pdf, W: the flux that one photon stands for when it is the only one.
    pub flux: Rgb,
    /// Density of place and direction together: by area and solid angle; without the area for lights that are points,
    /// without the solid angle for light of one direction.
    pub pdf: f32,
    /// What it leaves.
    pub origin_kind: Origin,
    /// Index in the light table; 0 until that sets it.
    pub light: u32,
}

/// What a photon leaves.
#[derive(Clone, Copy, Debug)]
pub enum Origin {
    /// A surface.
    Surface {
        /// Its primitive's tree index.
        primitive: u32,
        /// Unit normal on the side that emits.
        normal: Vec3,
    },
    /// A light without extent.
    Point,
    /// A place outside of the scene.
    Distant {
        /// The density by solid angle of sampling the light, over that of the photon by area across it and solid angle, m²;
        /// for light of one direction without the solid angle.
        sampling_ratio: f32,
    },
}

/// The densities of other ways to find the first segment of a photon path, over the photon's own by area at both ends
/// [Veach 1997, eq. 10.9].
#[derive(Clone, Copy, Debug)]
pub struct FirstSegment {
    /// Of sampling the light from the photon's first hit; to be divided by the hit's cosine.
    pub light_sampling: f32,
    /// Of a direction from the first hit that hits the light; to be multiplied with that direction's density by solid angle and
    /// the light's cosine, and divided by the hit's. 0 where directions cannot hit the light.
    pub light_hit: f32,
    /// Cosine at the light; 1 where it is no surface.
    pub light_cosine: f32,
}

/// A point of an emitting surface as another point sees it.
#[derive(Clone, Copy, Debug)]
pub struct SeenPoint {
    /// Tree index of its primitive.
    pub primitive: u32,
    /// Position, m.
    pub position: Vec3,
    /// Cosine between the surface's normal and the direction to the other point.
    pub cosine: f32,
}

impl SeenPoint {
    /// Where a ray hit.
    #[inline]
    pub fn of(hit: &Interaction) -> Self {
        let cosine = hit.geometric_normal.dot(hit.outgoing);
        Self { primitive: hit.primitive, position: hit.position, cosine }
    }
}

macro_rules! lights {
    ($($kind:ident),+) => {
        /// A checked light.
        #[derive(Clone, Debug)]
        pub enum Light {
            $(#[doc = concat!("See [`", stringify!($kind), "`].")] $kind($kind)),+
        }

        impl Light {
            /// Total emitted flux, W, for choosing lights to emit from.
            pub fn power(&self) -> Rgb {
                match self { $(Self::$kind(light) => light.power()),+ }
            }

            /// What its importance at a place is computed from, for choosing among lights.
            pub fn importance(&self, geometry: &Geometry) -> LightImportance {
                match self { $(Self::$kind(light) => light.importance(geometry)),+ }
            }

            /// Samples light that may arrive at `point`.
            #[inline]
            pub fn sample_direct(&self, geometry: &Geometry, point: Vec3, u: [f32; 2]) -> Option<DirectSample> {
                match self { $(Self::$kind(light) => light.sample_direct(geometry, point, u)),+ }
            }

            /// Samples a photon with two numbers for its place and two for its direction.
            #[inline]
            pub fn emit(&self, geometry: &Geometry, place: [f32; 2], direction: [f32; 2]) -> Option<EmittedPhoton> {
                match self { $(Self::$kind(light) => light.emit(geometry, place, direction)),+ }
            }
        }
    };
}

lights!(AreaLight, DirectionalArea, Point, Spot, Ies, Projector, Directional, Constant, EnvironmentMap, SunSky, Dark);

/// The mean flux of photons from outside over an even set of random numbers (Hammersley's): ∫ L·silhouette dω.
fn mean_flux(surroundings: &Surroundings, sample: impl Fn([f32; 2]) -> Option<DirectSample>) -> Rgb {
    const PHOTONS: u32 = 1 << 13;
    let flux = |photon: u32| {
        let u = [(photon as f32 + 0.5) / PHOTONS as f32, photon.reverse_bits() as f32 / (1u64 << 32) as f32];
        let sample = sample(u.map(|u| u.min(ONE_MINUS_EPSILON)))?;
        Some((sample.weighted_radiance * surroundings.silhouette(sample.direction)).as_dvec3())
    };
    (0..PHOTONS).filter_map(flux).sum::<DVec3>().as_vec3() / PHOTONS as f32
}

impl EmittedPhoton {
    /// A photon of a light without extent, for a density of directions by solid angle.
    fn from_point(origin: Vec3, direction: Vec3, flux: Rgb, pdf: f32) -> Self {
        Self { origin, direction, flux, pdf, origin_kind: Origin::Point, light: 0 }
    }
}

impl Light {
    /// Whether its light comes from outside of the scene.
    pub fn is_distant(&self) -> bool {
        self.is_environment() || matches!(self, Self::Directional(_))
    }

    /// Radiance that leaves a hit of this light's surface back along the path.
    #[inline]
    pub fn emitted(&self, hit: &Interaction) -> Rgb {
        match self {
            Self::AreaLight(light) => light.emitted(hit),
            _ => Rgb::ZERO,
        }
    }

    /// The density by solid angle with which [`Light::sample_direct`] from `point` finds the surface point `seen`.
    #[inline]
    pub fn direct_pdf(&self, geometry: &Geometry, point: Vec3, seen: &SeenPoint) -> f32 {
        match self {
            Self::AreaLight(light) => light.direct_pdf(geometry, point, seen),
            _ => 0.0,
        }
    }

    /// The density by area and solid angle with which [`Light::emit`] leaves the surface point `seen` at its cosine.
    #[inline]
    pub fn emission_pdf(&self, geometry: &Geometry, seen: &SeenPoint) -> f32 {
        match self {
            Self::AreaLight(light) => light.emission_pdf(geometry, seen),
            _ => 0.0,
        }
    }

    /// Over the density of [`Light::environment`]: that of a photon which comes from `direction` through a given point across
    /// it, m⁻²; 0 for lights that are inside.
    #[inline]
    pub fn environment_emission_ratio(&self, direction: Vec3) -> f32 {
        match self {
            Self::Constant(light) => light.emission_ratio(),
            Self::EnvironmentMap(light) => light.emission_ratio(direction),
            Self::SunSky(light) => light.emission_ratio(direction),
            _ => 0.0,
        }
    }

    /// Whether it stands for a light of another group.
    pub fn is_dark(&self) -> bool {
        matches!(self, Self::Dark(_))
    }

    /// Whether directions can hit it by chance.
    pub fn has_extent(&self) -> bool {
        matches!(self, Self::AreaLight(_)) || self.is_environment()
    }

    /// Whether light comes from it along every ray that leaves the scene.
    pub fn is_environment(&self) -> bool {
        matches!(self, Self::Constant(_) | Self::EnvironmentMap(_) | Self::SunSky(_))
    }

    /// The radiance from `direction` outside of the scene, and the density by solid angle with which
    /// [`Light::sample_direct`] takes it; `None` for lights that are inside.
    #[inline]
    pub fn environment(&self, direction: Vec3) -> Option<(Rgb, f32)> {
        match self {
            Self::Constant(light) => Some((light.radiance(), light.direct_pdf())),
            Self::EnvironmentMap(light) => Some(light.arriving(direction)),
            Self::SunSky(light) => Some(light.arriving(direction)),
            _ => None,
        }
    }
}
