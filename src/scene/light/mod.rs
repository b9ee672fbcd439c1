//! Lights: one file per kind, one row in `lights!`.
//!
//! Conventions: `radiance` is W·sr⁻¹·m⁻², `flux` is W; densities name their measure. A light is sampled in two ways: towards a
//! given point (direct light), and outwards (photons).

pub mod area;
pub mod constant;
pub mod directional;
pub mod environment_map;
pub mod point;
pub mod spot;
pub mod table;

use crate::math::{Rgb, Vec3};
use crate::scene::geometry::{Geometry, Interaction};

pub use area::AreaLight;
pub use constant::Constant;
pub use directional::Directional;
pub use environment_map::EnvironmentMap;
pub use point::Point;
pub use spot::Spot;
pub use table::LightTable;

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
}

/// Centre and radius of the sphere around the scene; distant lights emit from its disc.
#[derive(Clone, Copy, Debug)]
pub struct Surroundings {
    /// Centre, m.
    pub center: Vec3,
    /// Radius, m.
    pub radius: f32,
}

macro_rules! lights {
    ($($kind:ident),+) => {
        /// A checked light.
        #[derive(Clone, Debug)]
        pub enum Light {
            $(#[doc = concat!("See [`", stringify!($kind), "`].")] $kind($kind)),+
        }

        impl Light {
            /// Total emitted flux, W, for choosing among lights.
            pub fn power(&self) -> Rgb {
                match self { $(Self::$kind(light) => light.power()),+ }
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

lights!(AreaLight, Point, Spot, Directional, Constant, EnvironmentMap);

impl Light {
    /// Radiance that leaves a hit of this light's surface back along the path.
    #[inline]
    pub fn emitted(&self, hit: &Interaction) -> Rgb {
        match self {
            Self::AreaLight(light) => light.emitted(hit),
            _ => Rgb::ZERO,
        }
    }

    /// The density by solid angle with which [`Light::sample_direct`] from `point` finds the surface point `hit`.
    #[inline]
    pub fn direct_pdf(&self, geometry: &Geometry, point: Vec3, hit: &Interaction) -> f32 {
        match self {
            Self::AreaLight(light) => light.direct_pdf(geometry, point, hit),
            _ => 0.0,
        }
    }

    /// Whether directions can hit it by chance.
    pub fn has_extent(&self) -> bool {
        matches!(self, Self::AreaLight(_)) || self.is_environment()
    }

    /// Whether light comes from it along every ray that leaves the scene.
    pub fn is_environment(&self) -> bool {
        matches!(self, Self::Constant(_) | Self::EnvironmentMap(_))
    }

    /// The radiance from `direction` outside of the scene, and the density by solid angle with which
    /// [`Light::sample_direct`] takes it; `None` for lights that are inside.
    #[inline]
    pub fn environment(&self, direction: Vec3) -> Option<(Rgb, f32)> {
        match self {
            Self::Constant(light) => Some((light.radiance(), light.direct_pdf())),
            Self::EnvironmentMap(light) => Some(light.arriving(direction)),
            _ => None,
        }
    }
}
