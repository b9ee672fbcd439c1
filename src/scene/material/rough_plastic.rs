//! `roughplastic`: a matte base under a rough clear coat; one-sided, black from behind.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `diffuse_reflectance` | share of light that the base reflects | 0 to 1 | 0.5 |
//! | `specular_reflectance` | factor on the coat's reflection | 0 to 1 | 1 |
//! | `int_ior` | index of refraction of the coat, a number or a name | > 0 | `polypropylene` (1.49) |
//! | `ext_ior` | the same outside, not equal to `int_ior` | > 0 | `air` (1.000277) |
//! | `nonlinear` | whether light that bounces between base and coat takes the base's color each time | – | false |
//! | `distribution`, `alpha`, `sample_visible` | roughness of the coat, not textured | see `microfacet` | `beckmann`, 0.1 |
//!
//! As `plastic`, with the reflection of `roughconductor` under a dielectric's Fresnel factor for the coat, and for T(θ) and
//! F̄ what such a coat lets through and reflects: integrals over visible normals, tabulated at 64 cosines when the scene
//! is prepared, as in Mitsuba. Light that would bounce between microfacets is lost: a white base under a coat of α = 0.1
//! returns 0.97 (Beckmann) or 0.92 (GGX) of the light.

use super::lobe_choice::{LobeChoice, followed_share, mean};
use super::microfacet::{self, Microfacets, Roughness};
use super::plastic::CoatedBase;
use super::rough_dielectric::{read_relative_index, refract};
use super::{Lobes, MaterialSample, SpecularLobes, View, fresnel};
use crate::math::{Rgb, Vec3, warp};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::TexturePoint;
use crate::scene::texture::{Texture, TextureReader};

/// A matte base under a rough clear coat.
#[derive(Clone, Debug)]
pub struct RoughPlastic {
    base: CoatedBase,
    specular_reflectance: Texture,
    /// Index inside over index outside.
    relative_index: f32,
    roughness: Roughness,
    transmittance: [f32; COSINES],
}

/// How many cosines the coat's transmittance is tabulated at.
const COSINES: usize = 64;

impl RoughPlastic {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let relative_index = read_relative_index(fields, "polypropylene")?;
        let roughness = Roughness::read(fields, textures, false)?;
        if roughness.varies() {
            let problem = "the roughness of a \"roughplastic\" is a texture";
            return Err(fields.error("alpha", problem, "give a number, or blend two plastics with \"blendbsdf\""));
        }
        let microfacets = roughness.at(&TexturePoint::default());
        let inside = reflectances(&microfacets, 1.0 / relative_index);
        let sum: f32 = inside.iter().enumerate().map(|(index, reflected)| reflected * cosine(index)).sum();
        Ok(Self {
            base: CoatedBase::read(fields, textures, relative_index, 2.0 * sum / COSINES as f32)?,
            specular_reflectance: textures.share(fields, "specular_reflectance", 1.0)?,
            relative_index,
            roughness,
            transmittance: transmittances(&microfacets, relative_index),
        })
    }

    /// What the coat lets through from direction `cosine`.
    #[inline]
    fn passed(&self, cosine: f32) -> f32 {
        let place = cosine.clamp(0.0, 1.0) * (COSINES - 1) as f32;
        let index = (place as usize).min(COSINES - 2);
        let rest = place - index as f32;
        self.transmittance[index] * (1.0 - rest) + self.transmittance[index + 1] * rest
    }

    /// About how much light the coat and the base reflect, black outside of the lobes in view.
    fn shares(&self, view: &View) -> [f32; 2] {
        let passed = self.passed(view.outgoing.z);
        let coat = (1.0 - passed) * mean(self.specular_reflectance.color(&view.point));
        let base = passed * mean(self.base.reflectance.color(&view.point));
        [
            if view.lobes.any(self.roughness.lobes()) { coat } else { 0.0 },
            if view.lobes.any(Lobes::WIDE) { base } else { 0.0 },
        ]
    }

    /// Chooses the coat, mirroring at a visible normal, or the base by their shares.
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        if view.outgoing.z <= 0.0 {
            return None;
        }
        let direction = match LobeChoice::new(self.shares(view)).pick(u[2])?.0 {
            0 => {
                let normal = self.roughness.at(&view.point).visible_normal(view.outgoing, [u[0], u[1]]);
                microfacet::reflect(view.outgoing, normal)
            }
            _ => warp::cosine_hemisphere([u[0], u[1]]),
        };
        MaterialSample::weighted(direction, self.respond(view, direction), 1.0)
    }

    /// The BSDF and the density.
    fn respond(&self, view: &View, incident: Vec3) -> (Rgb, f32) {
        if view.outgoing.z <= 0.0 || incident.z <= 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let [coat, base] = LobeChoice::new(self.shares(view)).probabilities;
        let (mut value, mut pdf) = (Rgb::ZERO, 0.0);
        if view.lobes.any(self.roughness.lobes()) {
            let half = (view.outgoing + incident).normalize();
            let reflection = microfacet::reflection(&self.roughness.at(&view.point), view.outgoing, incident, half);
            let reflected = fresnel::dielectric(view.outgoing.dot(half).clamp(0.0, 1.0), self.relative_index).reflected;
            value += self.specular_reflectance.color(&view.point) * (reflected * reflection.0);
            pdf += coat * reflection.1;
        }
        if view.lobes.any(Lobes::WIDE) {
            value += self.base.value(view) * (self.passed(view.outgoing.z) * self.passed(incident.z));
            pdf += base * warp::cosine_hemisphere_pdf(incident.z);
        }
        (value, pdf)
    }

    /// The coat's reflection and the base seen through the coat.
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        self.respond(view, incident).0
    }

    /// That of mirroring at visible normals and of the cosine, by their shares.
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        self.respond(view, incident).1
    }

    /// A wide or narrow coat and a wide base.
    pub fn lobes(&self) -> Lobes {
        self.roughness.lobes() | Lobes::WIDE
    }

    /// The share of a narrow coat.
    pub fn followed_share(&self, view: &View) -> f32 {
        if view.outgoing.z <= 0.0 || !self.roughness.lobes().any(Lobes::FOLLOWED) {
            return 0.0;
        }
        let [coat, base] = self.shares(&view.of(Lobes::ALL));
        followed_share(coat, base)
    }

    /// None.
    pub fn specular_lobes(&self, _view: &View) -> SpecularLobes {
        SpecularLobes::default()
    }

    /// None: it varies.
    pub fn constant_value(&self, _view: &View) -> Option<Rgb> {
        None
    }
}

/// The cosine of a tabulated direction.
fn cosine(index: usize) -> f32 {
    (index as f32 / (COSINES - 1) as f32).max(1e-6)
}

/// What a rough boundary of that relative index reflects from each tabulated direction: ∫ F·G1 over visible normals.
fn reflectances(microfacets: &Microfacets, relative_index: f32) -> [f32; COSINES] {
    // Many nodes: from inside, total reflection starts within the range.
    integrals(microfacets, 64, |outgoing, normal| {
        let incident = microfacet::reflect(outgoing, normal);
        let reflected = fresnel::dielectric(outgoing.dot(normal).clamp(0.0, 1.0), relative_index).reflected;
        if incident.z > 0.0 { reflected * microfacets.visible_share(incident, normal) } else { 0.0 }
    })
}

/// What it lets through: ∫ (1 − F)·G1 over visible normals.
fn transmittances(microfacets: &Microfacets, relative_index: f32) -> [f32; COSINES] {
    integrals(microfacets, 32, |outgoing, normal| {
        let boundary = fresnel::dielectric(outgoing.dot(normal).clamp(0.0, 1.0), relative_index);
        let incident = refract(outgoing, normal, boundary.cosine_refracted, relative_index);
        let passed = 1.0 - boundary.reflected;
        if incident.z < 0.0 { passed * microfacets.visible_share(incident, normal) } else { 0.0 }
    })
}

/// The mean of `share(outgoing, normal)` over the normals that each tabulated direction sees, by `count`² nodes.
fn integrals(microfacets: &Microfacets, count: usize, share: impl Fn(Vec3, Vec3) -> f32) -> [f32; COSINES] {
    let nodes = gauss_legendre(count);
    std::array::from_fn(|index| {
        let z = cosine(index);
        let outgoing = Vec3::new((1.0 - z * z).max(0.0).sqrt(), 0.0, z);
        let value = |u: f64, v: f64| share(outgoing, microfacets.visible_normal(outgoing, [u as f32, v as f32]));
        let row = |u: f64| -> f64 { nodes.iter().map(|(v, weight)| weight * f64::from(value(u, *v))).sum() };
        nodes.iter().map(|(u, weight)| weight * row(*u)).sum::<f64>() as f32
    })
}

/// Nodes in (0, 1) and weights of sum 1, by Newton's method on Legendre's polynomials [Press et al. 2007, 4.6].
fn gauss_legendre(count: usize) -> Vec<(f64, f64)> {
    let degree = count as f64;
    let node = |index: usize| {
        let mut x = libm::cos(std::f64::consts::PI * (index as f64 + 0.75) / (degree + 0.5));
        let mut slope = 1.0;
        for _ in 0..100 {
            let (mut value, mut before) = (1.0, 0.0);
            for n in 0..count {
                let n = n as f64;
                (value, before) = (((2.0 * n + 1.0) * x * value - n * before) / (n + 1.0), value);
            }
            slope = degree * (x * value - before) / (x * x - 1.0);
            let step = value / slope;
            x -= step;
            if step.abs() < 1e-15 {
                break;
            }
        }
        (0.5 * (1.0 - x), 1.0 / ((1.0 - x * x) * slope * slope))
    };
    (0..count).map(node).collect()
}
