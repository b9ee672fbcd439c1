//! The steps of a `to_world` transform.

use glam::{DMat4, DVec3, DVec4};

/// Moves by `offset`.
pub(super) fn translate(offset: [f64; 3]) -> DMat4 {
    DMat4::from_translation(DVec3::from_array(offset))
}

/// Stretches by a factor for each axis.
pub(super) fn scale(factors: [f64; 3]) -> DMat4 {
    DMat4::from_scale(DVec3::from_array(factors))
}

/// Turns counter-clockwise about `axis`, by an angle in degrees.
///
/// # Errors
/// When the axis has no direction.
pub(super) fn rotate(axis: [f64; 3], degrees: f64) -> Result<DMat4, String> {
    let Some(axis) = DVec3::from_array(axis).try_normalize() else {
        return Err("the axis of the rotation has no direction".to_owned());
    };
    // Rodrigues' formula with libm: every worker must get the same bits, and the system's sine may differ.
    let (sine, cosine) = libm::sincos(degrees.to_radians());
    let turn = |vector: DVec3| vector * cosine + axis.cross(vector) * sine + axis * (axis.dot(vector) * (1.0 - cosine));
    let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|unit| turn(unit).extend(0.0));
    Ok(DMat4::from_cols(columns[0], columns[1], columns[2], DVec4::W))
}

/// Puts a sensor at `origin`, looking along its +z towards `target`, with +y near `up` and +x to its left.
///
/// # Errors
/// When origin and target coincide, or `up` is parallel to the view direction.
pub(super) fn look_at(origin: [f64; 3], target: [f64; 3], up: [f64; 3]) -> Result<DMat4, String> {
    let [origin, target, up] = [origin, target, up].map(DVec3::from_array);
    let Some(direction) = (target - origin).try_normalize() else {
        return Err("origin and target of the lookat give no direction".to_owned());
    };
    let Some(left) = up.cross(direction).try_normalize() else {
        return Err("up is parallel to the view direction of the lookat".to_owned());
    };
    let up = direction.cross(left);
    Ok(DMat4::from_cols(left.extend(0.0), up.extend(0.0), direction.extend(0.0), origin.extend(1.0)))
}

/// Some direction across the view from `origin` to `target`, for a view whose turn about its own axis is left open.
pub(super) fn any_up(origin: [f64; 3], target: [f64; 3]) -> [f64; 3] {
    let direction = DVec3::from_array(target) - DVec3::from_array(origin);
    direction.try_normalize().map_or(DVec3::Y, DVec3::any_orthonormal_vector).to_array()
}

/// A matrix of 16 numbers row by row, or of 9 for its upper left part.
///
/// # Errors
/// When there is another count of numbers.
pub(super) fn matrix(rows: &[f64]) -> Result<DMat4, String> {
    if let Ok(all) = <[f64; 16]>::try_from(rows) {
        return Ok(DMat4::from_cols_array(&all).transpose());
    }
    match <[f64; 9]>::try_from(rows) {
        Ok(upper) => Ok(DMat4::from_mat3(glam::DMat3::from_cols_array(&upper).transpose())),
        Err(_) => Err(format!("a matrix of {} numbers", rows.len())),
    }
}
