//! `area`: a shape whose outside, or both of whose sides, emit the same radiance into every direction.
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | `radiance` | emitted radiance, also a texture | W·sr⁻¹·m⁻² | 1 |
//! | `two_sided` | whether the inside emits, too (boolean) | – | false |
//! | `light_group` | the [light group](super::groups) that it belongs to | – | `others` |
//! | `seen_only` | whether it lights nothing: the camera sees it, straight or by mirrors and glass, and nothing else does (boolean) | – | false |
//!
//! Of a textured light, triangles are picked by the power that a few points of each suggest, and points uniformly in them:
//! bright spots within a large rectangle or triangle are found by chance, which is right but noisy.

use std::f32::consts::{FRAC_1_PI, PI};

use super::groups::{self, GroupName};
use super::importance::{Aim, Lamp, LightImportance};
use super::{DirectSample, EmittedPhoton, Origin, SeenPoint};
use crate::math::color::luminance;
use crate::math::discrete::Discrete;
use crate::math::{Frame, Rgb, Vec2, Vec3, warp};
use crate::scene::error::SceneError;
use crate::scene::fields::Fields;
use crate::scene::geometry::ray::SurfacePoint;
use crate::scene::geometry::{Geometry, Interaction, Primitive};
use crate::scene::texture::{Texture, TextureReader};

/// What a shape emits.
#[derive(Clone, Debug)]
pub struct Emission {
    /// Emitted radiance, W·sr⁻¹·m⁻².
    pub radiance: Texture,
    /// Whether the inside emits, too.
    pub two_sided: bool,
    /// Whether it is seen and lights nothing.
    pub seen_only: bool,
    /// Whether it emits along the normal alone, as [`DirectionalArea`](super::DirectionalArea).
    pub along_normal: bool,
    /// The light group that it names.
    pub group: Option<GroupName>,
}

impl Emission {
    /// The radiance that leaves a hit back along the path.
    #[inline]
    pub fn at(&self, hit: &Interaction) -> Rgb {
        let is_shown = self.two_sided || hit.geometric_normal.dot(hit.outgoing) > 0.0;
        if is_shown { self.radiance.color(&hit.texture_point()) } else { Rgb::ZERO }
    }
}

/// An emitting shape.
#[derive(Clone, Debug)]
pub struct AreaLight {
    radiance: Texture,
    two_sided: bool,
    /// Tree indices of its primitives, ascending.
    primitives: Vec<u32>,
    /// Over `primitives`: by area, or by power where the radiance varies.
    picks: Discrete,
    area: f32,
    power: Rgb,
}

/// Points at which the power of a textured light is estimated, shared among its primitives.
const PROBES: usize = 1 << 16;
/// The share of picks that goes by area alone, so that no part that the probes missed is left out.
const PICKS_BY_AREA: f64 = 0.125;

/// Normals and places that differ so little, as a share, are those of one plane.
const ROUNDING: f32 = 1e-4;

/// Reads the parameters.
pub(crate) fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Emission, SceneError> {
    let radiance = textures.color(fields, "radiance")?.unwrap_or(Texture::grey(1.0));
    let mut flag = |name: &'static str| fields.boolean(name).map(|flag| flag.unwrap_or(false));
    let (two_sided, seen_only) = (flag("two_sided")?, flag("seen_only")?);
    Ok(Emission { radiance, two_sided, seen_only, along_normal: false, group: groups::read(fields)? })
}

/// Reads the parameters of `directionalarea`.
pub(crate) fn read_along_normal(
    fields: &mut Fields<'_>,
    textures: &mut TextureReader<'_>,
) -> Result<Emission, SceneError> {
    let radiance = textures.color(fields, "radiance")?.unwrap_or(Texture::grey(1.0));
    Ok(Emission { radiance, two_sided: false, seen_only: false, along_normal: true, group: groups::read(fields)? })
}

/// The mean radiance of a primitive at the points of a lattice [R₂ sequence, Roberts 2018].
fn probed_radiance(radiance: &Texture, primitive: u32, probes: usize, geometry: &Geometry) -> Rgb {
    let sum = (0..probes).map(|probe| {
        let u = [0.754_877_666, 0.569_840_291].map(|step: f64| (0.5 + step * probe as f64).fract() as f32);
        radiance.color(&geometry.sample_for_texture(primitive, u).1).as_dvec3()
    });
    (sum.sum::<glam::DVec3>() / probes as f64).as_vec3()
}

impl AreaLight {
    /// A light over the primitives at tree indices `primitives`, ascending; `None` when they have no area.
    pub fn new(emission: Emission, primitives: Vec<u32>, geometry: &Geometry) -> Option<Self> {
        let Emission { radiance, two_sided, .. } = emission;
        let sides = if two_sided { 2.0 } else { 1.0 };
        let areas: Vec<f64> = primitives.iter().map(|index| f64::from(geometry.primitive(*index).area())).collect();
        let by_area = Discrete::new(&areas)?;
        let area = by_area.total() as f32;
        if let Texture::Constant(color) = radiance {
            let power = color * (PI * area * sides);
            return Some(Self { radiance, two_sided, primitives, picks: by_area, area, power });
        }
        let probes = (PROBES / primitives.len()).clamp(1, 4096);
        let means: Vec<Rgb> =
            primitives.iter().map(|index| probed_radiance(&radiance, *index, probes, geometry)).collect();
        let flux: Rgb = means.iter().zip(&areas).map(|(mean, area)| *mean * *area as f32).sum();
        // Where every probe found black, the texture's own mean stands for it: some of it may be lit after all.
        let found = luminance(flux) > 0.0;
        let power = PI * if found { flux } else { radiance.mean().max(Rgb::splat(f32::MIN_POSITIVE)) * area };
        let brightness = f64::from(luminance(power)) / by_area.total();
        let weight = |(mean, area): (&Rgb, &f64)| {
            let probed = if found { PI * luminance(*mean) } else { 0.0 };
            area * (f64::from(probed) * (1.0 - PICKS_BY_AREA) + brightness * PICKS_BY_AREA)
        };
        let weights: Vec<f64> = means.iter().zip(&areas).map(weight).collect();
        let picks = Discrete::new(&weights)?;
        Some(Self { radiance, two_sided, primitives, picks, area, power: power * sides })
    }

    /// Tree indices of its primitives.
    pub fn primitives(&self) -> &[u32] {
        &self.primitives
    }

    /// π·A·L for every side that emits; of a textured light an estimate.
    pub fn power(&self) -> Rgb {
        self.power
    }

    /// The radiance, where a side that emits is seen.
    #[inline]
    pub fn emitted(&self, hit: &Interaction) -> Rgb {
        let shines = self.cosine(hit.geometric_normal.dot(hit.outgoing)) > 0.0;
        if shines { self.radiance.color(&hit.texture_point()) } else { Rgb::ZERO }
    }

    /// The cosine against the normal on the side that emits, from that against the outside's.
    #[inline]
    fn cosine(&self, outside: f32) -> f32 {
        if self.two_sided { outside.abs() } else { outside }
    }

    /// A point of the light, its primitive, its radiance there and one over the density by area, m².
    #[inline]
    fn sample_point(&self, geometry: &Geometry, u: [f32; 2]) -> (SurfacePoint, u32, Rgb, f32) {
        let (pick, rest) = self.picks.pick(u[0]);
        let primitive = self.primitives[pick];
        if let Texture::Constant(radiance) = self.radiance {
            return (geometry.sample(primitive, [rest, u[1]]), primitive, radiance, self.area);
        }
        let (point, place) = geometry.sample_for_texture(primitive, [rest, u[1]]);
        let area = geometry.primitive(primitive).area() / self.picks.probability(pick);
        (point, primitive, self.radiance.color(&place), area)
    }

    /// One over the density by area of [`AreaLight::sample_point`] on the primitive at a tree index, m².
    #[inline]
    fn area_per_pick(&self, geometry: &Geometry, primitive: u32) -> f32 {
        if !self.radiance.varies() {
            return self.area;
        }
        match self.primitives.binary_search(&primitive) {
            Ok(pick) => geometry.primitive(primitive).area() / self.picks.probability(pick),
            Err(_) => f32::INFINITY,
        }
    }

    /// From one side of a plane, or from what shines to all sides alike.
    pub fn importance(&self, geometry: &Geometry) -> LightImportance {
        let primitives = || self.primitives.iter().map(|index| (geometry.primitive(*index), *index));
        let middle = |index: u32| geometry.sample(index, [0.5; 2]);
        let center = primitives().map(|(one, index)| middle(index).position * (one.area() / self.area)).sum::<Vec3>();
        let corners = primitives()
            .map(|(one, _)| one.bounds())
            .map(|(low, high)| (center - low).abs().max((high - center).abs()));
        let radius = corners.map(Vec3::length).fold(0.0, f32::max);
        let first = primitives().next().map(|(_, index)| middle(index));
        let normal = first.map(|point| point.normal).filter(|normal| {
            !self.two_sided
                && primitives().all(|(one, index)| {
                    let point = middle(index);
                    let is_on_plane = (point.position - center).dot(*normal).abs() <= ROUNDING * radius;
                    one.is_flat() && point.normal.dot(*normal) >= 1.0 - ROUNDING && is_on_plane
                })
        });
        let power = luminance(self.power);
        let (intensity, aim) = match normal {
            Some(normal) => (power * FRAC_1_PI, Aim::Side(normal)),
            None => (power * warp::SPHERE_PDF, Aim::Everywhere),
        };
        LightImportance::Near(Lamp { center, radius, intensity, aim })
    }

    fn single_sphere(&self, geometry: &Geometry) -> Option<crate::scene::geometry::sphere::Sphere> {
        match (self.primitives.as_slice(), geometry.primitive(self.primitives[0])) {
            ([_], Primitive::Sphere(sphere)) => Some(*sphere),
            _ => None,
        }
    }

    /// A point by area and power, or in the cone that a sphere fills.
    #[inline]
    pub fn sample_direct(&self, geometry: &Geometry, point: Vec3, u: [f32; 2]) -> Option<DirectSample> {
        let in_cone = self.single_sphere(geometry).and_then(|sphere| sphere.sample_cone(point, u));
        let (mut target, primitive, radiance, cone_or_area) = match in_cone {
            Some((target, pdf)) => {
                let uv = match self.radiance.varies() {
                    true => geometry.uv_at(self.primitives[0], target.position, [0.0; 2]),
                    false => Vec2::ZERO,
                };
                (target, self.primitives[0], self.radiance.color(&uv.into()), Ok(pdf))
            }
            None => {
                let (target, primitive, radiance, area) = self.sample_point(geometry, u);
                (target, primitive, radiance, Err(area))
            }
        };
        if self.two_sided && target.normal.dot(point - target.position) < 0.0 {
            target.normal = -target.normal;
        }
        // The target is kept off its own surface so that rounding cannot hide it.
        let to_light = target.position + target.normal * target.error - point;
        let distance = to_light.length();
        let direction = to_light / distance;
        let cosine = -direction.dot(target.normal);
        if !(cosine > 0.0 && distance > 0.0) {
            return None;
        }
        let pdf_solid_angle = cone_or_area.unwrap_or_else(|area| distance * distance / (cosine * area));
        let seen = SeenPoint { primitive, position: target.position, cosine };
        let emission_ratio = self.emission_pdf(geometry, &seen) / (pdf_solid_angle * cosine);
        let weighted_radiance = radiance / pdf_solid_angle;
        Some(DirectSample { direction, distance, weighted_radiance, pdf_solid_angle, emission_ratio })
    }

    /// The density of [`AreaLight::sample_direct`].
    #[inline]
    pub fn direct_pdf(&self, geometry: &Geometry, point: Vec3, seen: &SeenPoint) -> f32 {
        if let Some(pdf) = self.single_sphere(geometry).and_then(|sphere| sphere.cone_pdf(point)) {
            return pdf;
        }
        let cosine = self.cosine(seen.cosine);
        if cosine <= 0.0 {
            return 0.0;
        }
        seen.position.distance_squared(point) / (cosine * self.area_per_pick(geometry, seen.primitive))
    }

    /// The density of [`AreaLight::emit`].
    #[inline]
    pub fn emission_pdf(&self, geometry: &Geometry, seen: &SeenPoint) -> f32 {
        let pdf = self.cosine(seen.cosine).max(0.0) * FRAC_1_PI / self.area_per_pick(geometry, seen.primitive);
        if self.two_sided { 0.5 * pdf } else { pdf }
    }

    /// A point by area and power, one of the sides, and a direction by the cosine.
    #[inline]
    pub fn emit(&self, geometry: &Geometry, place: [f32; 2], direction: [f32; 2]) -> Option<EmittedPhoton> {
        let (point, primitive, radiance, area) = self.sample_point(geometry, place);
        let (normal, direction, area) = match self.two_sided {
            false => (point.normal, direction, area),
            true => {
                let side = if direction[0] < 0.5 { 1.0 } else { -1.0 };
                let rest = (2.0 * direction[0]).fract();
                (point.normal * side, [rest, direction[1]], 2.0 * area)
            }
        };
        let local = warp::cosine_hemisphere(direction);
        Some(EmittedPhoton {
            origin: point.position + normal * point.error,
            direction: Frame::from_normal(normal).to_world(local),
            flux: radiance * (PI * area),
            pdf: local.z * FRAC_1_PI / area,
            origin_kind: Origin::Surface { primitive, normal },
            light: 0,
        })
    }
}
