//! `mesh_attribute`: what a mesh file says of its vertices or faces, such as colors.
//!
//! | parameter | meaning | range | default |
//! |---|---|---|---|
//! | `name` | `vertex_…` (linear between vertices) or `face_…` (the same all over a face), as the shape's file names it | – | required |
//! | `scale` | factor | ≥ 0 | 1 |
//!
//! The values are those of the shape that the texture belongs to, one number or a color each. Integers stand for themselves: bytes
//! go up to 255.

use std::sync::Arc;

use super::TextureReader;
use crate::math::{Rgb, Vec2};
use crate::scene::error::{SceneError, nearest_name, shown_number};
use crate::scene::fields::Fields;
use crate::scene::geometry::TexturePoint;

/// Something that a mesh brings along for its vertices or faces.
#[derive(Clone, Debug)]
pub struct MeshAttribute {
    /// Starts with `vertex_` or `face_`.
    pub name: String,
    /// Of the vertices or faces; numbers are greys.
    pub values: Arc<[Rgb]>,
    /// Indices into `values` of the three corners of each triangle with area.
    pub corners: Arc<[[u32; 3]]>,
}

/// How PLY files name attributes.
const IN_PLY_FILES: &str = "in a PLY file, one property or three in a row are an attribute \"vertex_heat\": heat_0 to heat_2, heat_1 to \
    heat_3 or heat_x to heat_z";

/// An attribute of the shape that the texture belongs to.
#[derive(Clone, Debug)]
pub struct OfMesh {
    values: Arc<[Rgb]>,
    corners: Arc<[[u32; 3]]>,
    scale: f32,
    mean: Rgb,
}

impl OfMesh {
    /// Reads the parameters, and finds the attribute in the shape that is being read.
    pub fn read(fields: &mut Fields<'_>, textures: &mut TextureReader<'_>) -> Result<Self, SceneError> {
        let Some(name) = fields.string("name")? else {
            let problem = "\"mesh_attribute\" has no \"name\"";
            return Err(SceneError::new(
                fields.location(),
                problem,
                "name the attribute, for example \"vertex_color\"",
            ));
        };
        if !["vertex_", "face_"].iter().any(|kind| name.starts_with(kind)) {
            let problem = format!("\"{name}\" is not the name of an attribute");
            return Err(fields.error("name", problem, "names start with \"vertex_\" or \"face_\""));
        }
        let scale = fields.float("scale")?.unwrap_or(1.0);
        if scale < 0.0 {
            return Err(fields.error(
                "scale",
                format!("\"scale\" is {}", shown_number(scale)),
                "give a number of at least 0",
            ));
        }
        let scale = scale as f32;
        // A material that no shape uses is checked with a grey.
        let Some(attributes) = textures.ask_for_attributes() else {
            let values = Arc::from([Rgb::splat(0.5)]);
            return Ok(Self { values, corners: Arc::from([[0; 3]]), scale: 1.0, mean: Rgb::splat(0.5) });
        };
        let Some(attribute) = attributes.iter().find(|attribute| attribute.name == name) else {
            let problem = format!("the shape has no attribute \"{name}\"");
            let known: Vec<&str> = attributes.iter().map(|attribute| attribute.name.as_str()).collect();
            let remedy = match known.is_empty() {
                true => {
                    "its file names no attributes of vertices or faces; only \"ply\" and \"serialized\" files do".into()
                }
                false => nearest_name(name, &known),
            };
            return Err(fields.error("name", problem, format!("{remedy}; {IN_PLY_FILES}")));
        };
        let (values, corners) = (attribute.values.clone(), attribute.corners.clone());
        let sum: glam::DVec3 = values.iter().map(|value| value.as_dvec3()).sum();
        let mean = (sum / values.len().max(1) as f64).as_vec3() * scale;
        Ok(Self { values, corners, scale, mean })
    }

    /// The color at a place on the shape; the mean elsewhere.
    #[inline]
    pub fn color(&self, point: &TexturePoint) -> Rgb {
        let (triangle, [v, w]) = point.detail.place_on_mesh();
        let Some(corners) = self.corners.get(triangle) else { return self.mean };
        let [a, b, c] = corners.map(|corner| self.values[corner as usize]);
        // This form gives a face's own value where all three are the same.
        (a + (b - a) * v + (c - a) * w) * self.scale
    }

    /// 0: it is no function of texture coordinates.
    pub fn gradient(&self, _point: &TexturePoint) -> Vec2 {
        Vec2::ZERO
    }

    /// The mean of the values, each the same.
    pub fn mean(&self) -> Rgb {
        self.mean
    }

    /// That of the values.
    pub fn range(&self) -> [Rgb; 2] {
        let bounds =
            self.values.iter().fold([Rgb::MAX, Rgb::MIN], |[low, high], value| [low.min(*value), high.max(*value)]);
        bounds.map(|bound| bound * self.scale)
    }
}
