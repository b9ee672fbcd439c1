//! `to_uv`: the affine map that a texture applies to texture coordinates before it looks anything up.

use glam::{Affine2, DVec2, Mat2};

use crate::scene::error::SceneError;
use crate::scene::fields::Fields;

/// Reads `to_uv`, the identity by default. Of the three-dimensional transform the parts along z are left out, as in Mitsuba.
pub(super) fn read(fields: &mut Fields<'_>) -> Result<Affine2, SceneError> {
    let matrix = fields.transform("to_uv")?;
    let column = |index: usize| DVec2::new(matrix.col(index).x, matrix.col(index).y).as_vec2();
    let map = Affine2::from_mat2_translation(Mat2::from_cols(column(0), column(1)), column(3));
    if map.is_finite() {
        return Ok(map);
    }
    Err(fields.error("to_uv", "\"to_uv\" does not fit into single precision", "give smaller numbers"))
}
