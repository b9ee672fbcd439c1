//! `principled`: Disney's material of many uses: metal, plastic, glass and what lies between.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `base_color` | color of the matte and the metallic part; light that passes takes its square root | 0 to 1 | 0.5 |
//! | `roughness` | roughness of the main specular part; α = max(0.001, roughness²) | 0 to 1 | 0.5 |
//! | `anisotropic` | stretches highlights along the tangent | 0 to 1 | 0 |
//! | `metallic` | share of metal; the rest is dielectric | 0 to 1 | 0 |
//! | `spec_trans` | share of the dielectric part that is glass; the rest is matte | 0 to 1 | 0 |
//! | `eta` | index of refraction inside over outside; 1 counts as 1.001 where `spec_trans` is given | > 0 | from `specular` |
//! | `specular` | the same as `eta` = 2/(1 − √(0.08·specular)) − 1; 0 counts as 0.001 with `spec_trans` | 0 to 1 | 0.5 |
//! | `spec_tint` | how far the dielectric reflection takes the base's hue | 0 to 1 | 0 |
//! | `sheen`, `sheen_tint` | soft reflection at grazing angles as of cloth, and how far it takes the base's hue | 0 to 1 | 0 |
//! | `flatness` | how far the matte part looks as if light scattered below the surface | 0 to 1 | 0 |
//! | `clearcoat` | amount of a second, colorless coat | 0 to 1 | 0 |
//! | `clearcoat_gloss` | smoothness of that coat, from α = 0.1 to 0.001 | 0 to 1 | 0 |
//! | `diffuse_reflectance_sampling_rate`, `main_specular_sampling_rate`, `clearcoat_sampling_rate` | accepted and change nothing | – | – |
//!
//! The matte part, sheen and coat are on the front only; from behind there is only glass. The parts are those of
//! [Burley 2012, 5.3–5.6] and [Burley 2015, 5.1–5.4] as Mitsuba 3 combines them: GGX with exact Fresnel for dielectrics,
//! Schlick's for metals. Unlike Mitsuba's, metal still reflects where the index is exactly 1.
//!
//! This is an artist's model that can make energy: a white matte base returns 1.05 of the light at normal incidence and, at
//! roughness 1, 1.5 of it at grazing angles; `sheen` adds to that. A base color up to 0.8 at roughness 0.5 stays below 1.

use std::f32::consts::FRAC_1_PI;

use super::blend::read_share;
use super::lobe_choice::{LobeChoice, followed_share_of, mean};
use super::microfacet::{self, LongTail, Microfacets, Shape};
use super::rough_dielectric::{refract, refraction_scale};
use super::{Lobes, MaterialSample, SpecularLobes, View, flip, fresnel};
use crate::math::{Rgb, Vec3, color, warp};
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;
use crate::scene::geometry::TexturePoint;
use crate::scene::texture::{Texture, TextureReader};

/// Disney's material.
#[derive(Clone, Debug)]
pub struct Principled {
    /// Index inside over index outside.
    relative_index: f32,
    base_color: Texture,
    roughness: Texture,
    anisotropic: Texture,
    metallic: Texture,
    spec_trans: Texture,
    spec_tint: Texture,
    sheen: Texture,
    sheen_tint: Texture,
    flatness: Texture,
    clearcoat: Texture,
    clearcoat_gloss: Texture,
    /// The kinds of the matte part, the main specular part and the coat; none for parts that are nowhere.
    kinds: [Lobes; 3],
}

/// The material at one place, seen from one side.
struct Place {
    base_color: Rgb,
    microfacets: Microfacets,
    metallic: f32,
    /// Shares of the matte and the glass part.
    matte: f32,
    glass: f32,
    /// From the front, as if the material were its mirror image when it is seen from behind.
    outgoing: Vec3,
    /// Index behind over before.
    relative_index: f32,
    is_front: bool,
}

/// `sqrt(1 - 0.9·anisotropic)` stretches α [Burley 2012, 5.4].
pub(super) fn alphas(roughness: f32, anisotropic: f32) -> (f32, f32) {
    let aspect = (1.0 - 0.9 * anisotropic).max(0.0).sqrt();
    let alpha = roughness * roughness;
    ((alpha / aspect).max(0.001), (alpha * aspect).max(0.001))
}

/// A base color at luminance 1; white for black.
pub(super) fn hue(base_color: Rgb) -> Rgb {
    let luminance = color::luminance(base_color);
    if luminance > 0.0 { base_color / luminance } else { Rgb::ONE }
}

/// The color of sheen.
pub(super) fn sheen_color(base_color: Rgb, tint: f32) -> Rgb {
    Rgb::splat(1.0 - tint) + hue(base_color) * tint
}

/// The matte and retro-reflecting part times π, 1 about normal incidence [Burley 2012, 5.3; Burley 2015, 5.3]. `cosines` are
/// those of the two directions, `cosine` that between them and their half vector.
pub(super) fn base_shape(roughness: f32, flatness: f32, cosines: [f32; 2], cosine: f32) -> f32 {
    let [from, to] = cosines.map(fresnel::schlick_weight);
    let back = 2.0 * roughness * cosine * cosine;
    let matte = (1.0 - 0.5 * from) * (1.0 - 0.5 * to);
    let retro = back * (from + to + from * to * (back - 1.0));
    let flatten = |weight: f32| 1.0 + (0.5 * back - 1.0) * weight;
    let below = flatten(from) * flatten(to) * (1.0 / (cosines[0] + cosines[1]) - 0.5) + 0.5;
    (1.0 - flatness) * (matte + retro) + flatness * 1.25 * below
}

/// A dielectric's reflection `reflected`, so far tinted with a hue [Burley 2015, 5.1].
pub(super) fn tinted_reflection(reflected: f32, tint: f32, hue: Rgb, cosine: f32, relative_index: f32) -> Rgb {
    let normal = ((relative_index - 1.0) / (relative_index + 1.0)).powi(2);
    let tinted = fresnel::schlick(hue * normal, cosine, relative_index);
    Rgb::splat((1.0 - tint) * reflected) + tint * tinted
}

fn read_index(fields: &mut Fields<'_>, lets_light_through: bool) -> Result<f32, SceneError> {
    let (eta, specular) = (fields.float("eta")?, fields.float("specular")?);
    match (eta, specular) {
        (Some(_), Some(_)) => {
            Err(fields.error("specular", "both \"eta\" and \"specular\" are given", "give one of them"))
        }
        (Some(eta), None) if eta > 0.0 => Ok(if lets_light_through && eta == 1.0 { 1.001 } else { eta as f32 }),
        (Some(eta), None) => Err(fields.error(
            "eta",
            format!("\"eta\" is {}", shown_number(eta)),
            "give a number above 0, for example 1.5",
        )),
        (None, specular) => {
            let specular = specular.unwrap_or(0.5);
            if !(0.0..=1.0).contains(&specular) {
                return Err(fields.error(
                    "specular",
                    format!("\"specular\" is {}", shown_number(specular)),
                    "give a number from 0 to 1",
                ));
            }
            let specular = if lets_light_through && specular == 0.0 { 1e-3 } else { specular };
            Ok((2.0 / (1.0 - (0.08 * specular).sqrt()) - 1.0) as f32)
        }
    }
}

/// Whether a texture is `value` everywhere.
pub(super) fn is_everywhere(texture: &Texture, value: f32) -> bool {
    !texture.varies() && texture.number(&TexturePoint::default()) == value
}

impl Principled {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        fields.ignore(&["diffuse_reflectance_sampling_rate", "main_specular_sampling_rate", "clearcoat_sampling_rate"]);
        let base_color = textures.share(fields, "base_color", 0.5)?;
        let mut number = |name: &'static str, default: f32| -> Result<Texture, SceneError> {
            Ok(read_share(fields, textures, name)?.unwrap_or(Texture::grey(default)))
        };
        let mut material = Self {
            relative_index: 1.0,
            base_color,
            roughness: number("roughness", 0.5)?,
            anisotropic: number("anisotropic", 0.0)?,
            metallic: number("metallic", 0.0)?,
            spec_trans: number("spec_trans", 0.0)?,
            spec_tint: number("spec_tint", 0.0)?,
            sheen: number("sheen", 0.0)?,
            sheen_tint: number("sheen_tint", 0.0)?,
            flatness: number("flatness", 0.0)?,
            clearcoat: number("clearcoat", 0.0)?,
            clearcoat_gloss: number("clearcoat_gloss", 0.0)?,
            kinds: [Lobes::NONE; 3],
        };
        material.relative_index = read_index(fields, !is_everywhere(&material.spec_trans, 0.0))?;
        material.kinds = material.find_kinds();
        if !is_everywhere(&material.anisotropic, 0.0) {
            textures.ask_for_tangents();
        }
        Ok(material)
    }

    fn find_kinds(&self) -> [Lobes; 3] {
        let has_matte = !is_everywhere(&self.metallic, 1.0) && !is_everywhere(&self.spec_trans, 1.0);
        let varies = self.roughness.varies() || self.anisotropic.varies();
        let alpha = microfacet::mean_over_grid(varies, |point| {
            let (alpha_u, alpha_v) = alphas(self.roughness.number(point), self.anisotropic.number(point));
            0.5 * (alpha_u + alpha_v)
        });
        [
            if has_matte { Lobes::WIDE } else { Lobes::NONE },
            Lobes::of_roughness(alpha),
            if is_everywhere(&self.clearcoat, 0.0) { Lobes::NONE } else { Lobes::NARROW },
        ]
    }

    fn at(&self, view: &View) -> Place {
        let number = |texture: &Texture| texture.number(&view.point).clamp(0.0, 1.0);
        let (metallic, spec_trans) = (number(&self.metallic), number(&self.spec_trans));
        let (alpha_u, alpha_v) = alphas(number(&self.roughness), number(&self.anisotropic));
        let is_front = view.outgoing.z >= 0.0;
        Place {
            base_color: self.base_color.color(&view.point),
            microfacets: Microfacets::new(Shape::Ggx, alpha_u, alpha_v),
            metallic,
            matte: (1.0 - metallic) * (1.0 - spec_trans),
            glass: (1.0 - metallic) * spec_trans,
            outgoing: if is_front { view.outgoing } else { flip(view.outgoing) },
            relative_index: if is_front { self.relative_index } else { 1.0 / self.relative_index },
            is_front,
        }
    }

    /// About how much light the matte part, the main specular part and the coat scatter, 0 outside of the lobes in view.
    fn shares(&self, view: &View, place: &Place) -> [f32; 3] {
        /// Main specular parts are sampled at least so often: their share grows away from the mirror direction.
        const LEAST_MAIN: f32 = 0.02;
        let number = |texture: &Texture| texture.number(&view.point).clamp(0.0, 1.0);
        let seen = |part: usize, share: f32| if view.lobes.any(self.kinds[part]) { share } else { 0.0 };
        if !place.is_front {
            return [0.0, seen(1, place.glass), 0.0];
        }
        let weight = fresnel::schlick_weight(place.outgoing.z);
        let reflected = fresnel::dielectric(place.outgoing.z, place.relative_index).reflected;
        let metal = mean(place.base_color) * (1.0 - weight) + weight;
        let main = place.metallic * metal + (1.0 - place.metallic) * reflected + place.glass * (1.0 - reflected);
        [
            seen(0, place.matte * (mean(place.base_color) + 0.1 * number(&self.sheen))),
            seen(1, main.max(LEAST_MAIN)),
            seen(2, 0.25 * number(&self.clearcoat) * (0.04 + 0.96 * weight)),
        ]
    }

    /// Chooses a part by the shares.
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        if view.outgoing.z == 0.0 {
            return None;
        }
        let place = self.at(view);
        let (part, rest) = LobeChoice::new(self.shares(view, &place)).pick(u[2])?;
        let (direction, relative_index) = match part {
            0 => (warp::cosine_hemisphere([u[0], u[1]]), 1.0),
            1 => place.sample_main([u[0], u[1], rest])?,
            _ => (microfacet::reflect(place.outgoing, self.coat(view).normal([u[0], u[1]])), 1.0),
        };
        let direction = if place.is_front { direction } else { flip(direction) };
        MaterialSample::weighted(direction, self.respond(view, direction), relative_index)
    }

    fn coat(&self, view: &View) -> LongTail {
        LongTail::new(0.1 - 0.099 * self.clearcoat_gloss.number(&view.point).clamp(0.0, 1.0))
    }

    /// The BSDF and the density.
    fn respond(&self, view: &View, incident: Vec3) -> (Rgb, f32) {
        if view.outgoing.z == 0.0 || incident.z == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let place = self.at(view);
        let incident = if place.is_front { incident } else { flip(incident) };
        let chosen = LobeChoice::new(self.shares(view, &place)).probabilities;
        if incident.z < 0.0 {
            if !view.lobes.any(self.kinds[1]) || place.glass == 0.0 {
                return (Rgb::ZERO, 0.0);
            }
            let (value, pdf) = place.refraction(incident);
            return (value * refraction_scale(view.mode, place.relative_index), chosen[1] * pdf);
        }
        let half = (place.outgoing + incident).normalize();
        let (mut value, mut pdf) = (Rgb::ZERO, chosen[0] * warp::cosine_hemisphere_pdf(incident.z));
        if view.lobes.any(self.kinds[0]) && place.is_front && place.matte > 0.0 {
            value += self.matte_value(view, &place, incident, half);
        }
        if view.lobes.any(self.kinds[1]) {
            let (reflection, density) = self.main_reflection(view, &place, incident, half);
            value += reflection;
            pdf += chosen[1] * density;
        }
        if view.lobes.any(self.kinds[2]) && place.is_front {
            let (reflection, density) = self.coat_reflection(view, &place, incident, half);
            value += Rgb::splat(reflection);
            pdf += chosen[2] * density;
        }
        (value, pdf)
    }

    /// Matte, retro-reflecting and sheen part [Burley 2012, 5.3; Burley 2015, 5.3].
    fn matte_value(&self, view: &View, place: &Place, incident: Vec3, half: Vec3) -> Rgb {
        let number = |texture: &Texture| texture.number(&view.point).clamp(0.0, 1.0);
        let cosine = half.dot(incident);
        let cosines = [incident.z, place.outgoing.z];
        let base = base_shape(number(&self.roughness), number(&self.flatness), cosines, cosine);
        let hue = sheen_color(place.base_color, number(&self.sheen_tint));
        let sheen = number(&self.sheen) * (1.0 - place.metallic) * fresnel::schlick_weight(cosine.abs());
        place.base_color * (place.matte * FRAC_1_PI * base) + hue * sheen
    }

    /// Metal and dielectric reflection, and the density within the main part.
    fn main_reflection(&self, view: &View, place: &Place, incident: Vec3, half: Vec3) -> (Rgb, f32) {
        let cosine = place.outgoing.dot(half).clamp(0.0, 1.0);
        let reflected = fresnel::dielectric(cosine, place.relative_index).reflected;
        let (value, pdf) = microfacet::reflection(&place.microfacets, place.outgoing, incident, half);
        let pdf = pdf * (1.0 - place.passing(reflected));
        if !place.is_front {
            return (Rgb::splat(place.glass * reflected * value), pdf);
        }
        let mut color = place.metallic * fresnel::schlick(place.base_color, cosine, place.relative_index);
        if reflected > 0.0 {
            let tint = self.spec_tint.number(&view.point).clamp(0.0, 1.0);
            let tinted = tinted_reflection(reflected, tint, hue(place.base_color), cosine, place.relative_index);
            color += (1.0 - place.metallic) * tinted;
        }
        (color * value, pdf)
    }

    /// The coat's reflection and the density within it [Burley 2012, 5.4].
    fn coat_reflection(&self, view: &View, place: &Place, incident: Vec3, half: Vec3) -> (f32, f32) {
        let cosine = place.outgoing.dot(half).clamp(0.0, 1.0);
        let density = self.coat(view).density(half);
        let shadowing = Microfacets::new(Shape::Ggx, 0.25, 0.25).shadowing(place.outgoing, incident, half);
        let reflected = fresnel::schlick(Rgb::splat(0.04), cosine, place.relative_index).x;
        let amount = 0.25 * self.clearcoat.number(&view.point).clamp(0.0, 1.0);
        (amount * reflected * density * shadowing, density * half.z / (4.0 * cosine))
    }

    /// All parts.
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        self.respond(view, incident).0
    }

    /// That of all parts by their shares.
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        self.respond(view, incident).1
    }

    /// A wide matte part, a wide or narrow main specular one and a narrow coat, as far as they are anywhere.
    pub fn lobes(&self) -> Lobes {
        let passes = if is_everywhere(&self.spec_trans, 0.0) { Lobes::NONE } else { Lobes::TRANSMISSIVE };
        self.kinds.into_iter().fold(passes, |all, kind| all | kind)
    }

    /// The share of the narrow parts.
    pub fn followed_share(&self, view: &View) -> f32 {
        followed_share_of(self.kinds, self.shares(&view.of(Lobes::ALL), &self.at(view)))
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

impl Place {
    /// With what probability the main part refracts at a microfacet that reflects the share `reflected`.
    fn passing(&self, reflected: f32) -> f32 {
        (1.0 - reflected) * if self.is_front { self.glass } else { 1.0 }
    }

    /// Reflects or refracts at a visible normal; the direction, as seen from the front, and the relative index.
    fn sample_main(&self, u: [f32; 3]) -> Option<(Vec3, f32)> {
        let normal = self.microfacets.visible_normal(self.outgoing, [u[0], u[1]]);
        let boundary = fresnel::dielectric(self.outgoing.dot(normal).clamp(0.0, 1.0), self.relative_index);
        if u[2] < self.passing(boundary.reflected) {
            let direction = refract(self.outgoing, normal, boundary.cosine_refracted, self.relative_index);
            return (direction.z < 0.0).then_some((direction, self.relative_index));
        }
        let direction = microfacet::reflect(self.outgoing, normal);
        (direction.z > 0.0).then_some((direction, 1.0))
    }

    /// The glass part's refraction of flux, and the density within the main part.
    fn refraction(&self, incident: Vec3) -> (Rgb, f32) {
        match microfacet::refraction(&self.microfacets, self.outgoing, incident, self.relative_index) {
            Some(found) => {
                let color = self.base_color.map(f32::sqrt) * (self.glass * (1.0 - found.reflected));
                (color * found.flux_value, found.pdf * self.passing(found.reflected))
            }
            None => (Rgb::ZERO, 0.0),
        }
    }
}
