//! Materials: one file per kind, one row in `materials!`.
//!
//! Conventions, once for all: directions are unit vectors in the local frame whose z axis is the shading normal, and both
//! point away from the surface. `evaluate` is the BSDF value without any cosine (1/sr); a sample's weight is
//! `f·|cos θ_incident|/pdf`; densities are by solid angle. A material is black, not an error, where it does not scatter.

/// What a material of nothing but perfectly specular lobes answers.
macro_rules! purely_specular {
    ($kind:ident) => {
        impl $kind {
            /// Black: its lobes are specular.
            #[inline]
            pub fn evaluate(&self, _view: &super::View, _incident: crate::math::Vec3) -> crate::math::Rgb {
                crate::math::Rgb::ZERO
            }

            /// 0: its lobes are specular.
            #[inline]
            pub fn pdf(&self, _view: &super::View, _incident: crate::math::Vec3) -> f32 {
                0.0
            }

            /// 1: there is nothing to gather.
            #[inline]
            pub fn followed_share(&self, _view: &super::View) -> f32 {
                1.0
            }

            /// None: nothing is gathered here.
            #[inline]
            pub fn constant_value(&self, _view: &super::View) -> Option<crate::math::Rgb> {
                None
            }
        }
    };
}

pub(crate) mod blend;
pub(crate) mod bump_map;
pub(crate) mod conductor;
pub(crate) mod dielectric;
pub(crate) mod diffuse;
pub(crate) mod diffuse_transmitter;
pub(crate) mod fresnel;
pub(crate) mod lobe_choice;
pub(crate) mod mask;
pub(crate) mod measured_metals;
pub(crate) mod microfacet;
pub(crate) mod normal_map;
pub(crate) mod null;
pub(crate) mod plastic;
pub(crate) mod principled;
pub(crate) mod principled_thin;
pub(crate) mod refractive_indices;
pub(crate) mod rough_conductor;
pub(crate) mod rough_dielectric;
pub(crate) mod rough_plastic;
pub(crate) mod thin_dielectric;
pub(crate) mod turned_normal;
pub(crate) mod two_sided;
pub(crate) mod ward;

use crate::math::{Rgb, Vec2, Vec3};
use crate::scene::description::Node;
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::{Interaction, TexturePoint};
use crate::scene::texture::TextureReader;
use crate::scene::unsupported::unknown_plugin;

pub use blend::Blend;
pub use bump_map::BumpMap;
pub use conductor::Conductor;
pub use dielectric::Dielectric;
pub use diffuse::Diffuse;
pub use diffuse_transmitter::DiffuseTransmitter;
pub use mask::Mask;
pub use normal_map::NormalMap;
pub use null::Null;
pub use plastic::Plastic;
pub use principled::Principled;
pub use principled_thin::PrincipledThin;
pub use rough_conductor::RoughConductor;
pub use rough_dielectric::RoughDielectric;
pub use rough_plastic::RoughPlastic;
pub use thin_dielectric::ThinDielectric;
pub use two_sided::TwoSided;
pub use ward::Ward;

/// What a path carries: refraction scales radiance by the squared ratio of indices and leaves flux alone [Veach 1997, 5.2].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum TransportMode {
    /// A camera path.
    Radiance,
    /// A photon path.
    Flux,
}

/// A material seen from a direction: what a question about scattering is about.
#[derive(Clone, Copy, Debug)]
pub struct View {
    /// Where textures are looked up.
    pub point: TexturePoint,
    /// Local unit direction in which the path came, pointing away from the surface.
    pub outgoing: Vec3,
    /// What the path carries.
    pub mode: TransportMode,
    /// Only these lobes count.
    pub lobes: Lobes,
}

impl View {
    /// All lobes at `uv`, seen from `outgoing`.
    pub fn new(uv: Vec2, outgoing: Vec3, mode: TransportMode) -> Self {
        Self { point: uv.into(), outgoing, mode, lobes: Lobes::ALL }
    }

    /// The surface as the path that came to `hit` sees it, with all lobes.
    #[inline]
    pub fn at(hit: &Interaction, mode: TransportMode) -> Self {
        let outgoing = hit.frame.to_local(hit.outgoing);
        Self { point: hit.texture_point(), outgoing, mode, lobes: Lobes::ALL }
    }

    /// The same view of some lobes only.
    pub fn of(self, lobes: Lobes) -> Self {
        Self { lobes, ..self }
    }

    /// The same view from the other side of the surface.
    pub fn from_behind(self) -> Self {
        Self { outgoing: flip(self.outgoing), ..self }
    }
}

/// The mirror image of a local direction on the other side of the surface.
#[inline]
pub fn flip(direction: Vec3) -> Vec3 {
    Vec3::new(direction.x, direction.y, -direction.z)
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

/// The perfectly specular directions at a place, each with its full weight.
pub type SpecularLobes = [Option<MaterialSample>; 4];

impl MaterialSample {
    /// A sample in `direction` of the BSDF value and density in `response`; `None` where they are 0 or not finite.
    #[inline]
    pub fn weighted(direction: Vec3, response: (Rgb, f32), relative_index: f32) -> Option<Self> {
        let (value, pdf) = response;
        let weight = value * (direction.z.abs() / pdf);
        (pdf > 0.0 && pdf.is_finite() && weight.is_finite()).then_some(Self { direction, weight, pdf, relative_index })
    }

    /// The mirrored direction.
    #[inline]
    pub fn mirrored(outgoing: Vec3, weight: Rgb) -> Self {
        let direction = Vec3::new(-outgoing.x, -outgoing.y, outgoing.z);
        Self { direction, weight, pdf: 0.0, relative_index: 1.0 }
    }

    /// Straight on through the surface.
    #[inline]
    pub fn straight(outgoing: Vec3, weight: Rgb) -> Self {
        Self { direction: -outgoing, weight, pdf: 0.0, relative_index: 1.0 }
    }

    /// The same with `factor` times the weight.
    #[inline]
    pub fn scaled(self, factor: f32) -> Self {
        Self { weight: self.weight * factor, ..self }
    }

    /// Whether the direction comes from a perfectly specular lobe.
    pub fn is_specular(&self) -> bool {
        self.pdf == 0.0
    }

    /// The sample as seen from the other side of the surface.
    pub fn from_behind(self) -> Self {
        Self { direction: flip(self.direction), ..self }
    }
}

/// A set of kinds of lobes; decides where photons are stored, where camera paths gather and where they go on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Lobes(u8);

impl Lobes {
    /// None.
    pub const NONE: Self = Self(0);
    /// Lobes so wide that gathering photons resolves them: matte ones, and glossy ones of a roughness of at least
    /// [`Lobes::WIDE_ROUGHNESS`].
    pub const WIDE: Self = Self(1);
    /// Glossy lobes that camera paths rather follow, since few photons fall into them.
    pub const NARROW: Self = Self(2);
    /// Perfectly specular lobes.
    pub const SPECULAR: Self = Self(4);
    /// Light passes through the surface.
    pub const TRANSMISSIVE: Self = Self(8);
    /// Lobes with a density.
    pub const SMOOTH: Self = Self(1 | 2);
    /// Lobes that camera paths follow.
    pub const FOLLOWED: Self = Self(2 | 4);
    /// All kinds.
    pub const ALL: Self = Self(15);
    /// The microfacet roughness α from which on a lobe is wide.
    pub const WIDE_ROUGHNESS: f32 = 0.3;

    /// The kind of a microfacet lobe of roughness `alpha`.
    pub fn of_roughness(alpha: f32) -> Self {
        if alpha >= Self::WIDE_ROUGHNESS { Self::WIDE } else { Self::NARROW }
    }

    /// The set without the mark [`Lobes::TRANSMISSIVE`], which is no kind of its own.
    #[inline]
    pub fn kinds(self) -> Self {
        Self(self.0 & (Self::SMOOTH.0 | Self::SPECULAR.0))
    }

    /// Whether some of `other` are in the set.
    #[inline]
    pub fn any(self, other: Self) -> bool {
        self.0 & other.0 != 0
    }
}

impl std::ops::BitOr for Lobes {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

impl std::ops::BitAnd for Lobes {
    type Output = Self;

    fn bitand(self, other: Self) -> Self {
        Self(self.0 & other.0)
    }
}

/// Reads the parameters of a material plugin.
type ReadMaterial = fn(&mut Fields<'_>, &mut TextureReader<'_>) -> Result<Material, SceneError>;

macro_rules! materials {
    ($($kind:ident($holder:ty) = $name:literal),+ $(,)?) => {
        /// A checked material.
        #[derive(Clone, Debug)]
        pub enum Material {
            $(#[doc = concat!("`", $name, "`.")] $kind($holder)),+
        }

        /// Material plugins by name.
        const MATERIALS: &[(&str, ReadMaterial)] =
            &[$(($name, |fields, textures| Ok(Material::$kind(<$holder>::from($kind::read(fields, textures)?))))),+];

        impl Material {
            /// Samples a direction among the lobes in view with three numbers in [0, 1); `None` when the path ends here.
            #[inline]
            pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
                match self { $(Self::$kind(material) => material.sample(view, u)),+ }
            }

            /// The BSDF without cosine, 1/sr, of the lobes in view; specular lobes do not count. In [`TransportMode::Flux`]
            /// the roles are exchanged: `incident` is where the photon goes.
            #[inline]
            pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
                match self { $(Self::$kind(material) => material.evaluate(view, incident)),+ }
            }

            /// The density of [`Material::sample`] by solid angle; specular lobes do not count.
            #[inline]
            pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
                match self { $(Self::$kind(material) => material.pdf(view, incident)),+ }
            }

            /// The kinds of lobes that it has anywhere, on any side.
            #[inline]
            pub fn lobes(&self) -> Lobes {
                match self { $(Self::$kind(material) => material.lobes()),+ }
            }

            /// With what probability a camera path goes on by [`Lobes::FOLLOWED`] instead of gathering in [`Lobes::WIDE`]:
            /// 0 and 1 when there is only one of the two, else about their share of the light, never 0 or 1.
            #[inline]
            pub fn followed_share(&self, view: &View) -> f32 {
                match self { $(Self::$kind(material) => material.followed_share(view)),+ }
            }

            /// The perfectly specular directions, each with its full weight, for methods that follow all of them.
            pub fn specular_lobes(&self, view: &View) -> SpecularLobes {
                match self { $(Self::$kind(material) => material.specular_lobes(view)),+ }
            }

            /// The BSDF in view where it is the same for all incident directions on that side and none on the other, 1/sr.
            #[inline]
            pub fn constant_value(&self, view: &View) -> Option<Rgb> {
                match self { $(Self::$kind(material) => material.constant_value(view)),+ }
            }
        }
    };
}

// Large ones are boxed, so that the small ones stay close together in memory.
materials! {
    Diffuse(Diffuse) = "diffuse",
    Conductor(Conductor) = "conductor",
    Dielectric(Dielectric) = "dielectric",
    TwoSided(TwoSided) = "twosided",
    RoughConductor(Box<RoughConductor>) = "roughconductor",
    RoughDielectric(Box<RoughDielectric>) = "roughdielectric",
    Plastic(Box<Plastic>) = "plastic",
    RoughPlastic(Box<RoughPlastic>) = "roughplastic",
    ThinDielectric(Box<ThinDielectric>) = "thindielectric",
    Ward(Box<Ward>) = "ward",
    Blend(Box<Blend>) = "blendbsdf",
    Mask(Box<Mask>) = "mask",
    Null(Null) = "null",
    Principled(Box<Principled>) = "principled",
    PrincipledThin(Box<PrincipledThin>) = "principledthin",
    DiffuseTransmitter(DiffuseTransmitter) = "difftrans",
    NormalMap(Box<NormalMap>) = "normalmap",
    BumpMap(Box<BumpMap>) = "bumpmap",
}

/// Reads a material node.
pub fn read(node: &Node, textures: &mut TextureReader<'_>) -> Result<Material, SceneError> {
    let Some((_, read)) = MATERIALS.iter().find(|(name, _)| *name == node.plugin) else {
        let known: Vec<&str> = MATERIALS.iter().map(|(name, _)| *name).collect();
        return Err(unknown_plugin(node, &known));
    };
    let mut fields = Fields::new(node);
    let material = read(&mut fields, textures)?;
    fields.finish()?;
    Ok(material)
}

impl Material {
    /// What a shape without a bsdf is made of: a two-sided matte grey of reflectance 0.5, as in Mitsuba.
    pub fn default_grey() -> Self {
        Self::TwoSided(TwoSided::matte(0.5))
    }

    /// What a shape without a bsdf is made of when it emits, as in Mitsuba.
    pub fn black() -> Self {
        Self::TwoSided(TwoSided::matte(0.0))
    }

    /// The normal in the shading frame that a normal or bump map of it turns; +z where there is none, or several.
    pub fn turned_normal(&self, view: &View) -> Vec3 {
        match self {
            Self::NormalMap(map) => map.normal(view),
            Self::BumpMap(map) => map.normal(view),
            Self::TwoSided(sides) => sides.turned_normal(view),
            Self::Mask(mask) => mask.turned_normal(view),
            _ => Vec3::Z,
        }
    }
}
