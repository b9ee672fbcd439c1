//! Triangles of the file as meshes.

use std::collections::HashMap;
use std::f64::consts::PI;

use glam::{DVec3, Vec3};

use super::super::values::shown;
use super::element::Element;
use crate::scene::error::SceneError;
use crate::scene::geometry::TriangleMesh;

/// How many quadrilaterals go round a sphere that is scaled unevenly, and half as many from pole to pole.
const AROUND: u32 = 96;

/// The positions that a scene's meshes share, and how indices count them.
pub(super) struct Vertices {
    positions: Vec<Vec3>,
    /// What is added to indices where an element does not say: 0 when they begin with 1.
    default_offset: i64,
}

impl Vertices {
    /// Reads the scene's `<VertexData>`, if it has any.
    pub(super) fn read(scene: &Element<'_>) -> Result<Self, SceneError> {
        let default_offset = match scene.child("ZeroBasedIndexing")? {
            Some(element) => i64::from(element.word()? == "true"),
            None => 0,
        };
        let Some(data) = scene.child("VertexData")? else { return Ok(Self { positions: Vec::new(), default_offset }) };
        refuse_binary(&data)?;
        let mut numbers = Vec::new();
        data.each_word(|word| {
            let number = word.parse().ok().filter(|number: &f32| number.is_finite());
            let wrong =
                || (format!("{} is no coordinate", shown(word)), "write a finite number such as 0.5".to_owned());
            numbers.push(number.ok_or_else(wrong)?);
            Ok(())
        })?;
        if numbers.len() % 3 != 0 {
            let problem = format!("<VertexData> has {} numbers, which is no multiple of 3", numbers.len());
            return Err(data.error(problem, "write three for every vertex"));
        }
        let positions = numbers.chunks_exact(3).map(Vec3::from_slice).collect();
        Ok(Self { positions, default_offset })
    }

    /// The position that the one index in `element` names.
    pub(super) fn position(&self, element: &Element<'_>) -> Result<DVec3, SceneError> {
        let index = element.integer()? - 1;
        let position = usize::try_from(index).ok().and_then(|index| self.positions.get(index));
        position.map(|position| position.as_dvec3()).ok_or_else(|| {
            element.error(
                format!("there is no vertex {}", index + 1),
                format!("the scene has vertices 1 to {}", self.positions.len()),
            )
        })
    }

    /// The triangles whose indices stand in `element`, with the vertices that they use in the order of their first use.
    pub(super) fn triangles(&self, element: &Element<'_>) -> Result<TriangleMesh, SceneError> {
        refuse_binary(element)?;
        let offset = match element.attribute("vertexOffset") {
            Some(text) => text.parse::<i32>().map(i64::from).map_err(|_| {
                element.error(format!("the vertexOffset is {}", shown(text)), "write a whole number such as 1")
            })?,
            None => self.default_offset,
        };
        let mut place_of = HashMap::new();
        let (mut positions, mut corners) = (Vec::new(), Vec::new());
        element.each_word(|word| {
            let index = word.parse::<i32>().ok().and_then(|index| usize::try_from(i64::from(index) + offset - 1).ok());
            let found = index.and_then(|index| Some((index, self.positions.get(index)?)));
            let (index, position) = found.ok_or_else(|| {
                let remedy = format!("write numbers from {} to {}", 1 - offset, self.positions.len() as i64 - offset);
                (format!("there is no vertex {}", shown(word)), remedy)
            })?;
            corners.push(*place_of.entry(index).or_insert_with(|| {
                positions.push(position.to_array());
                positions.len() as u32 - 1
            }));
            Ok(())
        })?;
        if corners.is_empty() || corners.len() % 3 != 0 {
            let problem = format!("<{}> has {} indices", element.tag(), corners.len());
            return Err(element.error(problem, "write three for every triangle, and at least one triangle"));
        }
        let triangles = corners.chunks_exact(3).map(|corners| [corners[0], corners[1], corners[2]]).collect();
        Ok(TriangleMesh { positions, triangles, ..TriangleMesh::default() })
    }
}

fn refuse_binary(element: &Element<'_>) -> Result<(), SceneError> {
    match element.attribute("binaryFile") {
        Some(_) => Err(element.error("binary files are not supported", "write the numbers into the scene file")),
        None => Ok(()),
    }
}

/// A unit sphere.
pub(super) fn unit_sphere() -> TriangleMesh {
    let half = AROUND / 2;
    let corner = |row: u32, column: u32| {
        let (sine, cosine) = libm::sincos(PI * f64::from(row) / f64::from(half));
        let (y, x) = libm::sincos(2.0 * PI * f64::from(column % AROUND) / f64::from(AROUND));
        DVec3::new(sine * x, sine * y, cosine).as_vec3().to_array()
    };
    let corners = (0..=half).flat_map(|row| (0..=AROUND).map(move |column| (row, column)));
    let positions: Vec<[f32; 3]> = corners.map(|(row, column)| corner(row, column)).collect();
    let faces = (0..half).flat_map(|row| (0..AROUND).map(move |column| (row, row * (AROUND + 1) + column)));
    let mut triangles = Vec::new();
    for (row, above) in faces {
        let below = above + AROUND + 1;
        // At the poles quadrilaterals are triangles.
        if row + 1 < half {
            triangles.push([above, below, below + 1]);
        }
        if row > 0 {
            triangles.push([above, below + 1, above + 1]);
        }
    }
    TriangleMesh { normals: positions.clone(), positions, triangles, ..TriangleMesh::default() }
}
