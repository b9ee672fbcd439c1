//! Reflection at smooth boundaries.

use crate::math::Rgb;

/// What happens to light at a smooth boundary between two transparent media.
#[derive(Clone, Copy, Debug)]
pub(crate) struct DielectricBoundary {
    /// Share of unpolarised light that is reflected, 0 to 1.
    pub reflected: f32,
    /// Cosine of the refracted direction against the normal on its own side, at least 0.
    pub cosine_refracted: f32,
}

/// Fresnel's equations for unpolarised light. `cosine` ≥ 0 on the side where light arrives, `relative_index` is the index
/// behind the boundary over the index before it.
#[inline]
pub(crate) fn dielectric(cosine: f32, relative_index: f32) -> DielectricBoundary {
    let sine_squared = (1.0 - cosine * cosine).max(0.0) / (relative_index * relative_index);
    if sine_squared >= 1.0 {
        return DielectricBoundary { reflected: 1.0, cosine_refracted: 0.0 };
    }
    let refracted = (1.0 - sine_squared).sqrt();
    let parallel = (relative_index * cosine - refracted) / (relative_index * cosine + refracted);
    let perpendicular = (cosine - relative_index * refracted) / (cosine + relative_index * refracted);
    let reflected = 0.5 * (parallel * parallel + perpendicular * perpendicular);
    DielectricBoundary { reflected: if relative_index == 1.0 { 0.0 } else { reflected }, cosine_refracted: refracted }
}

/// Fresnel reflectance of a metal with complex index `eta + i·k` seen from air, per channel.
#[inline]
pub(crate) fn conductor(cosine: f32, eta: Rgb, k: Rgb) -> Rgb {
    let cosine_squared = cosine * cosine;
    let sine_squared = 1.0 - cosine_squared;
    let (eta_squared, k_squared) = (eta * eta, k * k);
    let t0 = eta_squared - k_squared - Rgb::splat(sine_squared);
    let a_squared_plus_b_squared = (t0 * t0 + 4.0 * eta_squared * k_squared).map(f32::sqrt);
    let a = (0.5 * (a_squared_plus_b_squared + t0)).max(Rgb::ZERO).map(f32::sqrt);
    let t1 = a_squared_plus_b_squared + Rgb::splat(cosine_squared);
    let t2 = 2.0 * cosine * a;
    let perpendicular = (t1 - t2) / (t1 + t2);
    let t3 = cosine_squared * a_squared_plus_b_squared + Rgb::splat(sine_squared * sine_squared);
    let t4 = t2 * sine_squared;
    let parallel = perpendicular * (t3 - t4) / (t3 + t4);
    0.5 * (parallel + perpendicular)
}

/// The mean reflectance of a smooth boundary for light from all directions, by the fits that Mitsuba uses: [Egan &
/// Hilgeman 1973] below 1 (error up to 0.1 % down to 1/1.5, 0.6 % down to 1/2, 10 % at 1/5) and [d'Eon & Irving 2011]
/// above (0.2 %). `relative_index` is the index behind the boundary over the index before it.
pub(crate) fn mean_reflectance(relative_index: f32) -> f32 {
    let inverse = 1.0 / relative_index;
    if relative_index < 1.0 {
        return -1.4399 * relative_index * relative_index + 0.7099 * relative_index + 0.6681 + 0.0636 * inverse;
    }
    let series = [-1.36881, 4.98554, -7.80989, 6.75335, -3.4793, 0.919317f32];
    series.into_iter().fold(0.0, |sum, coefficient| sum * inverse + coefficient)
}

/// Schlick's approximation from `normal_reflectance` at normal incidence; inside the denser medium it takes the refracted
/// cosine. `cosine` and `relative_index` as for [`dielectric`].
#[inline]
pub(crate) fn schlick(normal_reflectance: Rgb, cosine: f32, relative_index: f32) -> Rgb {
    let thinner = if relative_index > 1.0 { cosine } else { dielectric(cosine, relative_index).cosine_refracted };
    normal_reflectance + (Rgb::ONE - normal_reflectance) * schlick_weight(thinner)
}

/// (1 − cosine)⁵.
#[inline]
pub(crate) fn schlick_weight(cosine: f32) -> f32 {
    (1.0 - cosine).clamp(0.0, 1.0).powi(5)
}
