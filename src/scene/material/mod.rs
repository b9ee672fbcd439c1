//! Materials: one file per kind, one row in `materials!`.
//!
//! Conventions, once for all: directions are unit vectors in the local frame whose z axis is the shading normal, and both
//! point away from the surface. `evaluate` is the BSDF value without any cosine (1/sr); a sample's weight is
//! `f·|cos θ_incident|/pdf`; densities are by solid angle. A material is black, not an error, where it does not scatter.

pub mod conductor;
pub mod dielectric;
pub mod diffuse;
pub mod fresnel;
pub mod measured_metals;
pub mod refractive_indices;
pub mod two_sided;

use crate::math::{Rgb, Vec3};
use crate::scene::description::Node;
use crate::scene::error::{SceneError, nearest_name};
use crate::scene::fields::Fields;

pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use two_sided::TwoSided;

/// What a path carries: refraction scales radiance by the squared ratio of indices and leaves flux alone [Veach 1997, 5.2].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportMode {
    /// A camera path.
    Radiance,
    /// A photon path.
    Flux,
}

/// A sampled direction.
#[derive(Clone, Copy, Debug)]
pub struct MaterialSample {
    /// Local unit direction in which the path goes on.
    pub direction: Vec3,
    /// `f·|cos|/pdf`, with the mode's factor.
    pub weight: Rgb,
    /// Density by solid angle; 0 marks a direction that no other way of sampling can find (mirror, glass).
    pub pdf: f32,
    /// Refractive index behind over index before the surface along the path; 1 for reflection.
    pub relative_index: f32,
}

impl MaterialSample {
    /// Whether the direction comes from a perfectly specular lobe.
    pub fn is_specular(&self) -> bool {
        self.pdf == 0.0
    }
}

/// What a material's lobes are like; decides where photons are stored and where camera paths gather.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lobes {
    /// It has lobes with a density: photons are stored here.
    pub smooth: bool,
    /// It has perfectly specular lobes.
    pub specular: bool,
    /// Light passes through it.
    pub transmissive: bool,
}

/// Reads the parameters of a material plugin.
type ReadMaterial = fn(&mut Fields<'_>) -> Result<Material, SceneError>;

macro_rules! materials {
    ($($kind:ident = $name:literal),+ $(,)?) => {
        /// A checked material.
        #[derive(Clone, Debug)]
        pub enum Material {
            $(#[doc = concat!("`", $name, "`.")] $kind($kind)),+
        }

        /// Material plugins by name.
        const MATERIALS: &[(&str, ReadMaterial)] = &[$(($name, |fields| Ok(Material::$kind($kind::read(fields)?)))),+];

        impl Material {
            /// Samples a direction with three numbers in [0, 1); `None` when the path ends here.
            #[inline]
            pub fn sample(&self, outgoing: Vec3, mode: TransportMode, u: [f32; 3]) -> Option<MaterialSample> {
                match self { $(Self::$kind(material) => material.sample(outgoing, mode, u)),+ }
            }

            /// The BSDF without cosine, 1/sr; specular lobes do not count.
            #[inline]
            pub fn evaluate(&self, outgoing: Vec3, incident: Vec3) -> Rgb {
                match self { $(Self::$kind(material) => material.evaluate(outgoing, incident)),+ }
            }

            /// The density of [`Material::sample`] by solid angle; specular lobes do not count.
            #[inline]
            pub fn pdf(&self, outgoing: Vec3, incident: Vec3) -> f32 {
                match self { $(Self::$kind(material) => material.pdf(outgoing, incident)),+ }
            }

            /// What its lobes are like.
            #[inline]
            pub fn lobes(&self) -> Lobes {
                match self { $(Self::$kind(material) => material.lobes()),+ }
            }

            /// The perfectly specular directions, each with its full weight, for methods that follow all of them.
            pub fn specular_lobes(&self, outgoing: Vec3, mode: TransportMode) -> [Option<MaterialSample>; 2] {
                match self { $(Self::$kind(material) => material.specular_lobes(outgoing, mode)),+ }
            }

            /// The BSDF seen from `outgoing` where it is the same for all incident directions on that side, 1/sr.
            #[inline]
            pub fn constant_value(&self, outgoing: Vec3) -> Option<Rgb> {
                match self { $(Self::$kind(material) => material.constant_value(outgoing)),+ }
            }
        }
    };
}

materials! {
    Diffuse = "diffuse",
    Conductor = "conductor",
    Dielectric = "dielectric",
    TwoSided = "twosided",
}

/// Reads a material node.
pub fn read(node: &Node) -> Result<Material, SceneError> {
    let Some((_, read)) = MATERIALS.iter().find(|(name, _)| *name == node.plugin) else {
        let known: Vec<&str> = MATERIALS.iter().map(|(name, _)| *name).collect();
        let problem = format!("there is no bsdf \"{}\"", node.plugin);
        return Err(SceneError::new(&node.location, problem, nearest_name(&node.plugin, &known)));
    };
    let mut fields = Fields::new(node);
    let material = read(&mut fields)?;
    fields.finish()?;
    Ok(material)
}

/// Reads a reflectance-like colour within [0, 1], since more would make energy.
fn read_share(fields: &mut Fields<'_>, name: &'static str, default: f32) -> Result<Rgb, SceneError> {
    let Some(rgb) = fields.rgb(name)? else { return Ok(Rgb::splat(default)) };
    if rgb.iter().any(|channel| *channel > 1.0) {
        let problem = format!("\"{name}\" is {}, {}, {}: it would reflect more than arrives", rgb[0], rgb[1], rgb[2]);
        return Err(fields.error(name, problem, "give numbers from 0 to 1"));
    }
    Ok(Rgb::new(rgb[0] as f32, rgb[1] as f32, rgb[2] as f32))
}

impl Material {
    /// What a shape without a bsdf is made of: a two-sided matte grey of reflectance 0.5, as in Mitsuba.
    pub fn default_grey() -> Self {
        Self::TwoSided(TwoSided::matte(0.5))
    }
}
