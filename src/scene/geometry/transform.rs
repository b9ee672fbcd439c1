//! Reading `to_world` and applying it in double precision.

use glam::{DMat3, DMat4, DVec3, Vec3};

use crate::scene::error::SceneError;
use crate::scene::fields::Fields;

/// A checked affine map from a shape's own space to the world.
#[derive(Clone, Copy, Debug)]
pub(crate) struct ToWorld {
    matrix: DMat4,
    normal_matrix: DMat3,
}

impl ToWorld {
    /// Leaves everything where it is.
    pub(crate) const IDENTITY: Self = Self { matrix: DMat4::IDENTITY, normal_matrix: DMat3::IDENTITY };

    /// Reads `to_world`; the identity when it is not given.
    pub(crate) fn read(fields: &mut Fields<'_>) -> Result<Self, SceneError> {
        let matrix = fields.transform("to_world")?;
        if matrix.row(3) != glam::DVec4::W {
            let problem = "\"to_world\" is a perspective transform";
            return Err(fields.error("to_world", problem, "its last row must be 0 0 0 1"));
        }
        let normal_matrix = DMat3::from_mat4(matrix).inverse().transpose();
        Ok(Self { matrix, normal_matrix })
    }

    /// Maps a point.
    pub(crate) fn point(&self, point: DVec3) -> DVec3 {
        self.matrix.transform_point3(point)
    }

    /// Maps a vector.
    pub(crate) fn vector(&self, vector: DVec3) -> DVec3 {
        self.matrix.transform_vector3(vector)
    }

    /// Maps a normal to a unit normal.
    pub(crate) fn normal(&self, normal: DVec3) -> DVec3 {
        (self.normal_matrix * normal).normalize()
    }

    /// -1 when it mirrors, else 1.
    pub(crate) fn handedness(&self) -> f32 {
        if self.normal_matrix.determinant() < 0.0 { -1.0 } else { 1.0 }
    }

    /// Whether it turns the outside of a shape over that it mirrors: Mitsuba's spheres, and its meshes whose corners alone say what is outside. Other
    /// programs' shapes have `keep_outside`.
    pub(crate) fn turns_outside(&self, fields: &mut Fields<'_>) -> Result<bool, SceneError> {
        let keeps = fields.boolean("keep_outside")?.unwrap_or(false);
        Ok(!keeps && self.handedness() < 0.0)
    }

    /// Whether it scales all lengths by one factor.
    pub(crate) fn is_similarity(&self) -> bool {
        let columns = [DVec3::X, DVec3::Y, DVec3::Z].map(|axis| self.vector(axis));
        let scale = columns[0].length();
        let even = columns.iter().all(|column| (column.length() - scale).abs() <= 1e-4 * scale);
        let square = (0..3).all(|i| columns[i].dot(columns[(i + 1) % 3]).abs() <= 1e-4 * scale * scale);
        even && square
    }

    /// Fails at `to_world` when it is not a similarity.
    pub(crate) fn check_similarity(&self, fields: &Fields<'_>) -> Result<(), SceneError> {
        if self.is_similarity() {
            return Ok(());
        }
        let problem = format!("a {} cannot be sheared or scaled unevenly", fields.node().plugin);
        Err(fields.error("to_world", problem, "use a uniform scale"))
    }

    /// The factor by which it scales x, after its rotation is taken off. Of a similarity that of all lengths.
    pub(crate) fn scale(&self) -> f64 {
        if self.is_similarity() { self.vector(DVec3::X).length() } else { self.decomposed().1.x_axis.x.abs() }
    }

    /// The rotation and the stretch whose product is the linear part: its polar decomposition [Higham 1986].
    pub(crate) fn decomposed(&self) -> (DMat3, DMat3) {
        let linear = DMat3::from_mat4(self.matrix);
        let mut rotation = linear;
        for _ in 0..32 {
            rotation = (rotation + rotation.inverse().transpose()) * 0.5;
        }
        (rotation, rotation.transpose() * linear)
    }
}

/// To single precision; an error when the numbers do not fit.
pub(crate) fn to_single(point: DVec3, fields: &Fields<'_>) -> Result<Vec3, SceneError> {
    let single = point.as_vec3();
    if single.is_finite() {
        return Ok(single);
    }
    Err(SceneError::new(
        fields.location(),
        "the shape lies outside the range of single precision",
        "scale the scene down",
    ))
}
