//! The camera as the matrices by which other programs find places of the picture.

use glam::{DMat3, DMat4, DVec3, DVec4, Vec3};
use serde::{Deserialize, Serialize};

use super::{Camera, Projection};
use crate::scene::film::Film;

/// Matrices by rows, for row vectors: a point (x, y, z, 1) is multiplied from the left, as OpenEXR has it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraMatrices {
    /// From the world to the picture's right and up and the direction of view, m from where the camera stands.
    pub world_to_camera: [f32; 16],
    /// From the world to the picture, after division by the fourth number: (0, 0) is its upper left corner, (1, 1) its lower right one.
    /// A third number of 0 and 1 means the clip distances. `None` where straight lines do not stay straight.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub world_to_ndc: Option<[f32; 16]>,
}

impl Camera {
    /// The matrices of a camera whose picture is a window of `film`; a lens counts as its middle. `None` of a distant sensor, which stands nowhere.
    pub fn matrices(&self, film: &Film) -> Option<CameraMatrices> {
        if self.is_distant() {
            return None;
        }
        let [left, up, forward] = self.axes.map(Vec3::as_dvec3);
        let turn = DMat4::from_mat3(DMat3::from_cols(-left, up, forward).transpose());
        let world_to_camera = turn * DMat4::from_translation(-self.position.as_dvec3());
        let world_to_ndc = self.camera_to_film().map(|to_film| film_to_picture(film) * to_film * world_to_camera);
        Some(CameraMatrices {
            world_to_camera: by_rows(world_to_camera)?,
            world_to_ndc: world_to_ndc.and_then(by_rows),
        })
    }

    /// From camera coordinates to the whole film, (0, 0) top left to (1, 1) bottom right, the inverse of [`Camera::ray`].
    fn camera_to_film(&self) -> Option<DMat4> {
        let half = self.half_extent.as_dvec2();
        let middle = self.principal_point.as_dvec2() + 0.5;
        let (near, far) = (f64::from(self.near), f64::from(self.far));
        let (right, up) = (DVec4::new(0.5 / half.x, 0.0, 0.0, 0.0), DVec4::new(0.0, -0.5 / half.y, 0.0, 0.0));
        match self.projection {
            Projection::Perspective => {
                let per_depth = far / (far - near);
                let depth = DVec4::new(middle.x, middle.y, per_depth, 1.0);
                Some(DMat4::from_cols(right, up, depth, DVec4::new(0.0, 0.0, -per_depth * near, 0.0)))
            }
            Projection::Parallel => {
                let per_depth = 1.0 / (far - near);
                let depth = DVec4::new(0.0, 0.0, per_depth, 0.0);
                Some(DMat4::from_cols(right, up, depth, DVec4::new(middle.x, middle.y, -per_depth * near, 1.0)))
            }
            Projection::Spherical | Projection::Distant(_) => None,
        }
    }
}

/// From the whole film to its window.
fn film_to_picture(film: &Film) -> DMat4 {
    let axis =
        |whole: u32, offset: u32, size: u32| (f64::from(whole) / f64::from(size), -f64::from(offset) / f64::from(size));
    let (across, right) = axis(film.whole[0], film.offset[0], film.width);
    let (along, down) = axis(film.whole[1], film.offset[1], film.height);
    DMat4::from_translation(DVec3::new(right, down, 0.0)) * DMat4::from_scale(DVec3::new(across, along, 1.0))
}

/// The columns of a matrix for column vectors are the rows of the one for row vectors. `None` where a number is too large.
fn by_rows(matrix: DMat4) -> Option<[f32; 16]> {
    let numbers = matrix.to_cols_array().map(|number| number as f32);
    numbers.iter().all(|number| number.is_finite()).then_some(numbers)
}
