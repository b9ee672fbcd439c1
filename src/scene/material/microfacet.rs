//! Microfacet distributions for the rough materials: how the normals of a surface's tiny mirrors are spread.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `distribution` | `beckmann` (Gaussian slopes) or `ggx` (longer tails) | – | `beckmann` |
//! | `alpha` | roughness: the root mean square slope, for Beckmann | ≥ 0.0001 | 0.1 |
//! | `alpha_u`, `alpha_v` | roughness along and across the tangent instead of `alpha` | ≥ 0.0001 | – |
//! | `sample_visible` | accepted and changes nothing: visible normals are sampled | – | – |
//!
//! D and Smith's G as a product of two G1 are those of [Walter et al. 2007]: eq. 25 and 27 (Beckmann, with their rational
//! G1), eq. 33 and 34 (GGX), with anisotropic α [Heitz 2014]. Visible normals: for GGX by spherical caps
//! [Dupuy & Benyoub 2023], the density of [Heitz 2018]; for Beckmann by inverting the distribution of slopes
//! [Heitz & d'Eon 2014]. Their density needs the exact G1, which for Beckmann differs from the rational one by up to 0.4 %.
//!
//! Where a roughness is textured, values below 0.0001 count as 0.0001, and whether the lobe is wide or narrow follows from
//! the mean of both roughnesses over a grid of 16×16 places in [0, 1]², one answer for the whole surface.

use std::f32::consts::{FRAC_1_PI, PI};

use super::{Lobes, fresnel};
use crate::math::trigonometry::sin_cos_turn;
use crate::math::{Vec2, Vec3};
use crate::scene::error::{SceneError, nearest_name, shown_number};
use crate::scene::fields::Fields;
use crate::scene::geometry::TexturePoint;
use crate::scene::texture::{Texture, TextureReader};

/// The least roughness, that of Mitsuba.
pub(crate) const LEAST_ALPHA: f32 = 1e-4;

/// The shape of a distribution.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Shape {
    /// Gaussian slopes.
    Beckmann,
    /// Trowbridge and Reitz's, with longer tails.
    Ggx,
}

/// The distribution of microfacet normals at one place.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Microfacets {
    shape: Shape,
    alpha_u: f32,
    alpha_v: f32,
}

impl Microfacets {
    /// A distribution with roughness `alpha_u` along x and `alpha_v` along y, each raised to [`LEAST_ALPHA`].
    pub(crate) fn new(shape: Shape, alpha_u: f32, alpha_v: f32) -> Self {
        Self { shape, alpha_u: alpha_u.max(LEAST_ALPHA), alpha_v: alpha_v.max(LEAST_ALPHA) }
    }

    /// D(m): area of microfacets with unit normal `normal` (z ≥ 0) per surface area and solid angle, 1/sr.
    #[inline]
    pub(crate) fn density(&self, normal: Vec3) -> f32 {
        if normal.z <= 0.0 {
            return 0.0;
        }
        let slope = (normal.x / self.alpha_u).powi(2) + (normal.y / self.alpha_v).powi(2);
        let area = PI * self.alpha_u * self.alpha_v;
        let cosine_squared = normal.z * normal.z;
        match self.shape {
            Shape::Beckmann => libm::expf(-slope / cosine_squared) / (area * cosine_squared * cosine_squared),
            Shape::Ggx => 1.0 / (area * (slope + cosine_squared).powi(2)),
        }
    }

    /// 1/(α·tan θ) of a direction, α being that along its azimuth.
    #[inline]
    fn inverse_slope(&self, direction: Vec3) -> f32 {
        direction.z.abs() / libm::hypotf(self.alpha_u * direction.x, self.alpha_v * direction.y)
    }

    /// Smith's G1: share of the microfacets with normal `normal` that `direction` sees.
    #[inline]
    pub(crate) fn visible_share(&self, direction: Vec3, normal: Vec3) -> f32 {
        if direction.dot(normal) * direction.z <= 0.0 {
            return 0.0;
        }
        let a = self.inverse_slope(direction);
        match self.shape {
            Shape::Beckmann if a < 1.6 => (3.535 * a + 2.181 * a * a) / (1.0 + 2.276 * a + 2.577 * a * a),
            Shape::Beckmann => 1.0,
            Shape::Ggx => ggx_share(a),
        }
    }

    /// G: share of the microfacets with normal `normal` that both directions see.
    #[inline]
    pub(crate) fn shadowing(&self, outgoing: Vec3, incident: Vec3, normal: Vec3) -> f32 {
        self.visible_share(outgoing, normal) * self.visible_share(incident, normal)
    }

    /// A normal among those that `direction` (z > 0) sees.
    #[inline]
    pub(crate) fn visible_normal(&self, direction: Vec3, u: [f32; 2]) -> Vec3 {
        let stretched = Vec3::new(direction.x * self.alpha_u, direction.y * self.alpha_v, direction.z).normalize();
        let normal = match self.shape {
            Shape::Beckmann => beckmann_normal(stretched, u),
            Shape::Ggx => ggx_normal(stretched, u),
        };
        Vec3::new(normal.x * self.alpha_u, normal.y * self.alpha_v, normal.z.max(0.0)).normalize()
    }

    /// The density of [`Self::visible_normal`] over normals by solid angle.
    #[inline]
    pub(crate) fn visible_pdf(&self, direction: Vec3, normal: Vec3) -> f32 {
        let cosine = direction.dot(normal);
        if cosine <= 0.0 || direction.z <= 0.0 {
            return 0.0;
        }
        let a = self.inverse_slope(direction);
        let share = match self.shape {
            Shape::Beckmann => beckmann_share(a),
            Shape::Ggx => ggx_share(a),
        };
        share * cosine * self.density(normal) / direction.z
    }
}

#[inline]
fn ggx_share(a: f32) -> f32 {
    2.0 / (1.0 + (1.0 + 1.0 / (a * a)).sqrt())
}

/// G1 = 1/(1 + Λ), Λ = (erf a − 1)/2 + exp(−a²)/(2a√π).
fn beckmann_share(a: f32) -> f32 {
    if a > 6.0 {
        return 1.0;
    }
    let a = f64::from(a);
    let shadowed = 0.5 * (libm::exp(-a * a) / (a * std::f64::consts::PI.sqrt()) - libm::erfc(a));
    (1.0 / (1.0 + shadowed)) as f32
}

fn ggx_normal(direction: Vec3, u: [f32; 2]) -> Vec3 {
    let (sin, cos) = sin_cos_turn(u[0]);
    let z = (1.0 - u[1]) * (1.0 + direction.z) - direction.z;
    let sine = (1.0 - z * z).max(0.0).sqrt();
    Vec3::new(sine * cos, sine * sin, z) + direction
}

/// The slope against the direction has density ∝ max(0, cos θ − slope·sin θ)·exp(−slope²), the other exp(−slope²).
fn beckmann_normal(direction: Vec3, u: [f32; 2]) -> Vec3 {
    let sine = libm::hypotf(direction.x, direction.y);
    let along = slope(f64::from(direction.z), f64::from(sine), u[0]);
    let across = slope(1.0, 0.0, u[1]);
    let (cos, sin) = if sine > 0.0 { (direction.x / sine, direction.y / sine) } else { (1.0, 0.0) };
    Vec3::new(across * sin - along * cos, -along * sin - across * cos, 1.0)
}

/// The slope x up to which lies the share `u` of the density ∝ max(0, cosine − sine·x)·exp(−x²), by Newton's method kept
/// within a bracket by bisection.
fn slope(cosine: f64, sine: f64, u: f32) -> f32 {
    const FARTHEST: f64 = 6.0;
    const ROOT_PI: f64 = 1.772_453_850_905_516;
    let below = |x: f64| 0.5 * (cosine * libm::erfc(-x) + sine * libm::exp(-x * x) / ROOT_PI);
    let (mut low, mut high) = (-FARTHEST, if cosine < FARTHEST * sine { cosine / sine } else { FARTHEST });
    let wanted = f64::from(u) * below(high);
    let mut x = 0.5f64.min(high) * f64::from(2.0 * u - 1.0);
    for _ in 0..40 {
        let error = below(x) - wanted;
        if error > 0.0 {
            high = x
        } else {
            low = x
        }
        let next = x - error * ROOT_PI / ((cosine - sine * x) * libm::exp(-x * x));
        let next = if next > low && next < high { next } else { 0.5 * (low + high) };
        if (next - x).abs() < 1e-8 {
            return next as f32;
        }
        x = next;
    }
    x as f32
}

/// The mirror image of `direction` at a plane with unit normal `normal`.
#[inline]
pub(crate) fn reflect(direction: Vec3, normal: Vec3) -> Vec3 {
    2.0 * direction.dot(normal) * normal - direction
}

/// D·G/(4·cos θo·cos θi) at a half vector of two directions on the front, without Fresnel's factor, and the density of
/// mirroring `outgoing` at visible normals, both 1/sr [Walter et al. 2007, eq. 20 and 14].
#[inline]
pub(crate) fn reflection(microfacets: &Microfacets, outgoing: Vec3, incident: Vec3, half: Vec3) -> (f32, f32) {
    let density = microfacets.density(half);
    let value = density * microfacets.shadowing(outgoing, incident, half) / (4.0 * outgoing.z * incident.z);
    let pdf = microfacets.visible_pdf(outgoing, half) / (4.0 * outgoing.dot(half));
    if value.is_finite() && pdf.is_finite() { (value, pdf) } else { (0.0, 0.0) }
}

/// Refraction at a microfacet, without its transmittance.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Refraction {
    /// Share of the light that the microfacet reflects instead.
    pub reflected: f32,
    /// The BSDF for flux, 1/sr; that for radiance is this over the squared relative index.
    pub flux_value: f32,
    /// Density of refracting the outgoing direction at visible normals, 1/sr.
    pub pdf: f32,
}

/// Refraction between `outgoing` on the front and `incident` behind [Walter et al. 2007, eq. 16, 17 and 21]; `None` where
/// no microfacet does it. `relative_index` is the index behind over that before.
#[inline]
pub(crate) fn refraction(
    microfacets: &Microfacets,
    outgoing: Vec3,
    incident: Vec3,
    relative_index: f32,
) -> Option<Refraction> {
    let half = outgoing + relative_index * incident;
    let half = if half.z < 0.0 { -half.normalize() } else { half.normalize() };
    let (before, behind) = (outgoing.dot(half), incident.dot(half));
    if !(before > 0.0 && behind < 0.0) {
        return None;
    }
    let jacobian = relative_index * relative_index * -behind / (before + relative_index * behind).powi(2);
    let density = microfacets.density(half) * microfacets.shadowing(outgoing, incident, half);
    let flux_value = density * jacobian * before / (outgoing.z * -incident.z);
    let pdf = microfacets.visible_pdf(outgoing, half) * jacobian;
    let reflected = fresnel::dielectric(before.min(1.0), relative_index).reflected;
    (flux_value.is_finite() && pdf.is_finite()).then_some(Refraction { reflected, flux_value, pdf })
}

/// The `distribution` and roughness parameters.
#[derive(Clone, Debug)]
pub(crate) struct Roughness {
    shape: Shape,
    alpha_u: Texture,
    alpha_v: Texture,
    lobes: Lobes,
}

impl Roughness {
    /// Reads the parameters, isotropic ones only where `anisotropic` is false.
    pub(crate) fn read(
        fields: &mut Fields<'_>,
        textures: &mut TextureReader<'_>,
        anisotropic: bool,
    ) -> Result<Self, SceneError> {
        let shape = read_shape(fields)?;
        fields.ignore(&["sample_visible"]);
        let [alpha_u, alpha_v] = read_alphas(fields, textures, anisotropic)?;
        Ok(Self { shape, lobes: Lobes::of_roughness(mean_alpha(&alpha_u, &alpha_v)), alpha_u, alpha_v })
    }

    /// The distribution at `point`.
    #[inline]
    pub(crate) fn at(&self, point: &TexturePoint) -> Microfacets {
        Microfacets::new(self.shape, self.alpha_u.number(point), self.alpha_v.number(point))
    }

    /// Whether it is textured.
    pub(crate) fn varies(&self) -> bool {
        self.alpha_u.varies() || self.alpha_v.varies()
    }

    /// Wide or narrow.
    #[inline]
    pub(crate) fn lobes(&self) -> Lobes {
        self.lobes
    }
}

fn read_shape(fields: &mut Fields<'_>) -> Result<Shape, SceneError> {
    match fields.string("distribution")? {
        None | Some("beckmann") => Ok(Shape::Beckmann),
        Some("ggx") => Ok(Shape::Ggx),
        Some(other) => {
            let problem = format!("there is no microfacet distribution \"{other}\"");
            Err(fields.error("distribution", problem, nearest_name(other, &["beckmann", "ggx"])))
        }
    }
}

/// Reads `alpha`, or `alpha_u` and `alpha_v`.
pub(crate) fn read_alphas(
    fields: &mut Fields<'_>,
    textures: &mut TextureReader<'_>,
    anisotropic: bool,
) -> Result<[Texture; 2], SceneError> {
    let alpha = read_alpha(fields, textures, "alpha")?;
    if !anisotropic {
        let alpha = alpha.unwrap_or(Texture::grey(0.1));
        return Ok([alpha.clone(), alpha]);
    }
    let both = [read_alpha(fields, textures, "alpha_u")?, read_alpha(fields, textures, "alpha_v")?];
    match (alpha, both) {
        (alpha, [None, None]) => {
            let alpha = alpha.unwrap_or(Texture::grey(0.1));
            Ok([alpha.clone(), alpha])
        }
        (None, [Some(alpha_u), Some(alpha_v)]) => {
            textures.ask_for_tangents();
            Ok([alpha_u, alpha_v])
        }
        (None, _) => Err(fields.error("alpha_u", "one of \"alpha_u\" and \"alpha_v\" is missing", "give both")),
        (Some(_), _) => {
            let problem = "both \"alpha\" and \"alpha_u\" or \"alpha_v\" are given";
            Err(fields.error("alpha", problem, "give \"alpha\", or \"alpha_u\" and \"alpha_v\""))
        }
    }
}

fn read_alpha(
    fields: &mut Fields<'_>,
    textures: &mut TextureReader<'_>,
    name: &'static str,
) -> Result<Option<Texture>, SceneError> {
    let alpha = textures.number(fields, name)?;
    match alpha.as_ref().filter(|alpha| !alpha.varies()).map(|alpha| alpha.number(&TexturePoint::default())) {
        Some(number) if number < LEAST_ALPHA => {
            let problem = format!("\"{name}\" is {}: rough surfaces start at {LEAST_ALPHA}", shown_number(number));
            Err(fields.error(name, problem, format!("give at least {LEAST_ALPHA}, or use the smooth material")))
        }
        _ => Ok(alpha),
    }
}

/// The mean of two roughnesses over texture coordinates.
pub(crate) fn mean_alpha(alpha_u: &Texture, alpha_v: &Texture) -> f32 {
    let varies = alpha_u.varies() || alpha_v.varies();
    mean_over_grid(varies, |point| 0.5 * (alpha_u.number(point) + alpha_v.number(point)))
}

/// The mean of `value` over a grid of texture coordinates, or its only value where it does not vary.
pub(crate) fn mean_over_grid(varies: bool, value: impl Fn(&TexturePoint) -> f32) -> f32 {
    const SIDE: usize = 16;
    if !varies {
        return value(&TexturePoint::default());
    }
    let place = |index: usize| Vec2::new((index % SIDE) as f32 + 0.5, (index / SIDE) as f32 + 0.5) / SIDE as f32;
    (0..SIDE * SIDE).map(|index| value(&place(index).into())).sum::<f32>() / (SIDE * SIDE) as f32
}

/// D of [`Shape::Beckmann`] sampled over all normals instead of visible ones, by its cosine [Walter et al. 2007, eq. 28].
#[inline]
pub(crate) fn gaussian_normal(alpha_u: f32, alpha_v: f32, u: [f32; 2]) -> Vec3 {
    let radius = (-libm::logf(1.0 - u[0])).sqrt();
    let (sin, cos) = sin_cos_turn(u[1]);
    Vec3::new(alpha_u * radius * cos, alpha_v * radius * sin, 1.0).normalize()
}

/// Burley's GTR1 with roughness `alpha` < 1, isotropic: density and sampling by its cosine [Burley 2012, appendix B].
#[derive(Clone, Copy, Debug)]
pub(crate) struct LongTail {
    alpha_squared: f32,
}

impl LongTail {
    /// A distribution of roughness `alpha`, above 0 and below 1.
    pub(crate) fn new(alpha: f32) -> Self {
        Self { alpha_squared: alpha * alpha }
    }

    /// D(m), 1/sr.
    pub(crate) fn density(&self, normal: Vec3) -> f32 {
        let below_one = self.alpha_squared - 1.0;
        let sine_squared = normal.x * normal.x + normal.y * normal.y;
        // 1 + (α² − 1)·cos², without cancellation near the pole.
        let spread = self.alpha_squared * normal.z * normal.z + sine_squared;
        below_one * FRAC_1_PI / (libm::logf(self.alpha_squared) * spread)
    }

    /// A normal with density D·cos θ.
    pub(crate) fn normal(&self, u: [f32; 2]) -> Vec3 {
        let power = libm::powf(self.alpha_squared, 1.0 - u[0]);
        let sine_squared = ((power - self.alpha_squared) / (1.0 - self.alpha_squared)).clamp(0.0, 1.0);
        let (sin, cos) = sin_cos_turn(u[1]);
        let sine = sine_squared.sqrt();
        Vec3::new(sine * cos, sine * sin, (1.0 - sine_squared).sqrt())
    }
}
