//! `principledthin`: Disney's material of thin sheets, such as leaves, paper and panes.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `base_color` | color of matte light, and of light that passes clearly | 0 to 1 | 0.5 |
//! | `roughness` | roughness of clear reflection; light that passes has (0.65·`eta` − 0.35) of it | 0 to 1 | 0.5 |
//! | `anisotropic` | stretches highlights along the tangent | 0 to 1 | 0 |
//! | `spec_trans` | share that is a clear pane; the rest is matte | 0 to 1 | 0 |
//! | `eta` | index of refraction of the sheet over that around | > 0 | 1.5 |
//! | `spec_tint` | how far clear reflection takes the base's hue | 0 to 1 | 0 |
//! | `sheen`, `sheen_tint` | soft reflection at grazing angles as of cloth, and how far it takes the base's hue | 0 to 1 | 0 |
//! | `flatness` | how far the matte part looks as if light scattered below the surface | 0 to 1 | 0 |
//! | `diff_trans` | how much of the matte light passes: half of it at 1, all at 2 | 0 to 2 | 0 |
//! | `diffuse_reflectance_sampling_rate` and the other three such | accepted and change nothing | – | – |
//!
//! Both sides are alike, and light passes without being bent. The parts are those of [Burley 2015, 5.5] as Mitsuba 3 combines
//! them (its values, as measured with 3.9.1). Clear transmission is the mirror image of a reflection at visible normals; as in
//! Mitsuba it counts only where the way out lies behind the microfacet, which makes it differ between the two directions of a path.

use std::f32::consts::FRAC_1_PI;

use super::blend::read_share;
use super::lobe_choice::{LobeChoice, followed_share_of, mean};
use super::microfacet::{self, Microfacets, Shape};
use super::principled::{alphas, base_shape, hue, is_everywhere, sheen_color, tinted_reflection};
use super::{Lobes, MaterialSample, SpecularLobes, TransportMode, View, flip, fresnel};
use crate::math::{Rgb, Vec3, warp};
use crate::scene::error::{SceneError, shown_number};
use crate::scene::fields::Fields;
use crate::scene::texture::{Texture, TextureReader};

/// Disney's thin material.
#[derive(Clone, Debug)]
pub struct PrincipledThin {
    base_color: Texture,
    roughness: Texture,
    anisotropic: Texture,
    spec_trans: Texture,
    eta: Texture,
    spec_tint: Texture,
    sheen: Texture,
    sheen_tint: Texture,
    flatness: Texture,
    diff_trans: Texture,
    /// The kinds of matte reflection and transmission, clear reflection, and clear transmission; none for parts that are nowhere.
    kinds: [Lobes; 4],
}

/// The material at one place, seen from the front: both sides are alike.
struct Place {
    base_color: Rgb,
    clear: f32,
    eta: f32,
    spec_tint: f32,
    sheen: f32,
    /// The share of matte light that passes.
    passing: f32,
    roughness: f32,
    reflecting: Microfacets,
    transmitting: Microfacets,
    outgoing: Vec3,
}

const MATTE_REFLECTION: usize = 0;
const MATTE_TRANSMISSION: usize = 1;
const REFLECTION: usize = 2;
const TRANSMISSION: usize = 3;

/// The α along and across the tangent of light that passes.
fn transmission_alphas(roughness: f32, anisotropic: f32, eta: f32) -> (f32, f32) {
    alphas((0.65 * eta - 0.35) * roughness, anisotropic)
}

/// Reads a number that may be a texture and whose values are in `range`.
fn read_within(
    fields: &mut Fields<'_>,
    textures: &mut TextureReader<'_>,
    name: &'static str,
    is_allowed: fn(f32) -> bool,
    remedy: &str,
) -> Result<Option<Texture>, SceneError> {
    let texture = textures.number(fields, name)?;
    let bounds = texture.as_ref().map(Texture::range).map(|[low, high]| [low.min_element(), high.max_element()]);
    match bounds.into_iter().flatten().find(|value| !is_allowed(*value)) {
        Some(value) => Err(fields.error(name, format!("\"{name}\" is {}", shown_number(value)), remedy)),
        None => Ok(texture),
    }
}

impl PrincipledThin {
    /// Reads the parameters.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        fields.ignore(&[
            "diffuse_reflectance_sampling_rate",
            "diffuse_transmittance_sampling_rate",
            "specular_reflectance_sampling_rate",
            "specular_transmittance_sampling_rate",
        ]);
        let base_color = textures.share(fields, "base_color", 0.5)?;
        let eta = read_within(fields, textures, "eta", |eta| eta > 0.0, "give a number above 0, for example 1.5")?;
        let diff_trans = read_within(
            fields,
            textures,
            "diff_trans",
            |amount| (0.0..=2.0).contains(&amount),
            "give a number from 0 to 2: 1 lets half of the matte light through",
        )?;
        let mut number = |name: &'static str, default: f32| {
            read_share(fields, textures, name).map(|texture| texture.unwrap_or(Texture::grey(default)))
        };
        let mut material = Self {
            base_color,
            roughness: number("roughness", 0.5)?,
            anisotropic: number("anisotropic", 0.0)?,
            spec_trans: number("spec_trans", 0.0)?,
            eta: eta.unwrap_or(Texture::grey(1.5)),
            spec_tint: number("spec_tint", 0.0)?,
            sheen: number("sheen", 0.0)?,
            sheen_tint: number("sheen_tint", 0.0)?,
            flatness: number("flatness", 0.0)?,
            diff_trans: diff_trans.unwrap_or(Texture::grey(0.0)),
            kinds: [Lobes::NONE; 4],
        };
        material.kinds = material.find_kinds();
        if !is_everywhere(&material.anisotropic, 0.0) {
            textures.ask_for_tangents();
        }
        Ok(material)
    }

    fn find_kinds(&self) -> [Lobes; 4] {
        let varies = [&self.roughness, &self.anisotropic, &self.eta].iter().any(|texture| texture.varies());
        let kind = |alphas: fn(f32, f32, f32) -> (f32, f32)| {
            Lobes::of_roughness(microfacet::mean_over_grid(varies, |point| {
                let [roughness, anisotropic, eta] =
                    [&self.roughness, &self.anisotropic, &self.eta].map(|texture| texture.number(point));
                let (alpha_u, alpha_v) = alphas(roughness, anisotropic, eta);
                0.5 * (alpha_u + alpha_v)
            }))
        };
        let only = |is_there: bool, kind: Lobes| if is_there { kind } else { Lobes::NONE };
        let (is_clear, is_matte) = (!is_everywhere(&self.spec_trans, 0.0), !is_everywhere(&self.spec_trans, 1.0));
        [
            only(is_matte, Lobes::WIDE),
            only(is_matte && !is_everywhere(&self.diff_trans, 0.0), Lobes::WIDE),
            only(is_clear, kind(|roughness, anisotropic, _| alphas(roughness, anisotropic))),
            only(is_clear, kind(transmission_alphas)),
        ]
    }

    fn at(&self, view: &View) -> Place {
        let number = |texture: &Texture| texture.number(&view.point).clamp(0.0, 1.0);
        let (roughness, anisotropic) = (number(&self.roughness), number(&self.anisotropic));
        let eta = self.eta.number(&view.point);
        let (alpha_u, alpha_v) = alphas(roughness, anisotropic);
        let (passing_u, passing_v) = transmission_alphas(roughness, anisotropic, eta);
        Place {
            base_color: self.base_color.color(&view.point),
            clear: number(&self.spec_trans),
            eta,
            spec_tint: number(&self.spec_tint),
            sheen: number(&self.sheen),
            passing: 0.5 * self.diff_trans.number(&view.point).clamp(0.0, 2.0),
            roughness,
            reflecting: Microfacets::new(Shape::Ggx, alpha_u, alpha_v),
            transmitting: Microfacets::new(Shape::Ggx, passing_u, passing_v),
            outgoing: if view.outgoing.z >= 0.0 { view.outgoing } else { flip(view.outgoing) },
        }
    }

    /// About how much light each part scatters, 0 outside of the lobes in view.
    fn shares(&self, view: &View, place: &Place) -> [f32; 4] {
        /// Clear reflection is sampled at least so often: its share grows away from the mirror direction.
        const LEAST_REFLECTION: f32 = 0.02;
        let reflected = fresnel::dielectric(place.outgoing.z, place.eta).reflected;
        let (base, matte) = (mean(place.base_color), 1.0 - place.clear);
        let shares = [
            matte * (1.0 - place.passing) * (base + 0.1 * place.sheen),
            matte * place.passing * base,
            place.clear * reflected.max(LEAST_REFLECTION),
            place.clear * (1.0 - reflected) * base,
        ];
        std::array::from_fn(|part| if view.lobes.any(self.kinds[part]) { shares[part] } else { 0.0 })
    }

    /// Chooses a part by the shares.
    pub fn sample(&self, view: &View, u: [f32; 3]) -> Option<MaterialSample> {
        if view.outgoing.z == 0.0 {
            return None;
        }
        let place = self.at(view);
        let (part, _) = LobeChoice::new(self.shares(view, &place)).pick(u[2])?;
        let place_on_lobe = [u[0], u[1]];
        let mirrored = |microfacets: &Microfacets| {
            let normal = microfacets.visible_normal(place.outgoing, place_on_lobe);
            Some(microfacet::reflect(place.outgoing, normal)).filter(|direction| direction.z > 0.0)
        };
        let direction = match part {
            REFLECTION => mirrored(&place.reflecting)?,
            TRANSMISSION => {
                let direction = mirrored(&place.transmitting)?;
                let half = (place.outgoing + direction).normalize();
                Some(direction).filter(|direction| place.lets_through(view.mode, *direction, half))?
            }
            _ => warp::cosine_hemisphere(place_on_lobe),
        };
        let passes = part == MATTE_TRANSMISSION || part == TRANSMISSION;
        let direction = if passes != (view.outgoing.z < 0.0) { flip(direction) } else { direction };
        MaterialSample::weighted(direction, self.respond(view, direction), 1.0)
    }

    /// The BSDF and the density.
    fn respond(&self, view: &View, incident: Vec3) -> (Rgb, f32) {
        if view.outgoing.z == 0.0 || incident.z == 0.0 {
            return (Rgb::ZERO, 0.0);
        }
        let place = self.at(view);
        let chosen = LobeChoice::new(self.shares(view, &place)).probabilities;
        let passes = view.outgoing.z * incident.z < 0.0;
        let incident = if incident.z < 0.0 { flip(incident) } else { incident };
        let (matte, clear) = if passes { (MATTE_TRANSMISSION, TRANSMISSION) } else { (MATTE_REFLECTION, REFLECTION) };
        let half = (place.outgoing + incident).normalize();
        let mut value = Rgb::ZERO;
        if view.lobes.any(self.kinds[matte]) {
            value += match passes {
                true => place.base_color * (place.passing * (1.0 - place.clear) * FRAC_1_PI),
                false => self.matte_reflection(view, &place, incident, half),
            };
        }
        let (clear_value, clear_pdf) = match (view.lobes.any(self.kinds[clear]), passes) {
            (false, _) => (Rgb::ZERO, 0.0),
            (true, false) => place.reflection(incident, half),
            (true, true) => place.transmission(view.mode, incident, half),
        };
        let pdf = chosen[matte] * warp::cosine_hemisphere_pdf(incident.z) + chosen[clear] * clear_pdf;
        (value + clear_value, pdf)
    }

    /// Matte, retro-reflecting and sheen part.
    fn matte_reflection(&self, view: &View, place: &Place, incident: Vec3, half: Vec3) -> Rgb {
        let number = |texture: &Texture| texture.number(&view.point).clamp(0.0, 1.0);
        let cosine = half.dot(incident);
        let base = base_shape(place.roughness, number(&self.flatness), [incident.z, place.outgoing.z], cosine);
        let sheen = sheen_color(place.base_color, number(&self.sheen_tint));
        let sheen = sheen * (place.sheen * fresnel::schlick_weight(cosine.abs()));
        (place.base_color * (FRAC_1_PI * base) + sheen) * ((1.0 - place.passing) * (1.0 - place.clear))
    }

    /// All parts.
    pub fn evaluate(&self, view: &View, incident: Vec3) -> Rgb {
        self.respond(view, incident).0
    }

    /// That of all parts by their shares.
    pub fn pdf(&self, view: &View, incident: Vec3) -> f32 {
        self.respond(view, incident).1
    }

    /// Wide matte parts, and wide or narrow clear ones, as far as they are anywhere.
    pub fn lobes(&self) -> Lobes {
        let passes = self.kinds[MATTE_TRANSMISSION] | self.kinds[TRANSMISSION];
        let passes = if passes == Lobes::NONE { Lobes::NONE } else { Lobes::TRANSMISSIVE };
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
    /// Clear reflection and the density within it.
    fn reflection(&self, incident: Vec3, half: Vec3) -> (Rgb, f32) {
        let cosine = self.outgoing.dot(half).clamp(0.0, 1.0);
        let reflected = fresnel::dielectric(cosine, self.eta).reflected;
        let color = tinted_reflection(reflected, self.spec_tint, hue(self.base_color), cosine, self.eta);
        let (value, pdf) = microfacet::reflection(&self.reflecting, self.outgoing, incident, half);
        (color * (self.clear * value), pdf)
    }

    /// Whether the way towards the light lies behind the microfacet that mirrors the viewer's direction.
    fn lets_through(&self, mode: TransportMode, incident: Vec3, half: Vec3) -> bool {
        let light = match mode {
            TransportMode::Radiance => incident,
            TransportMode::Flux => self.outgoing,
        };
        flip(light).dot(half) < 0.0
    }

    /// Clear transmission to the mirror image of `incident`, and the density within it.
    fn transmission(&self, mode: TransportMode, incident: Vec3, half: Vec3) -> (Rgb, f32) {
        if !self.lets_through(mode, incident, half) {
            return (Rgb::ZERO, 0.0);
        }
        let reflected = fresnel::dielectric(self.outgoing.dot(half).clamp(0.0, 1.0), self.eta).reflected;
        let (value, pdf) = microfacet::reflection(&self.transmitting, self.outgoing, incident, half);
        (self.base_color * (self.clear * (1.0 - reflected) * value), pdf)
    }
}
