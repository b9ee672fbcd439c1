//! The tangents of meshes with a normal map, where the file gives none: those of MikkTSpace [Mikkelsen 2008, "Simulation of
//! wrinkled surfaces revisited", appendix], which glTF 2.0 (3.7.2.1) asks for.
//!
//! Corners of triangles belong together where they share position, normal and texture coordinates, are joined by edges, and
//! turn the same way in the image. Their tangents along u are averaged by the angles of the triangles, in the plane across
//! the normal. glTF's v grows downwards and its normal maps have +Y upwards: the sign of a bitangent is 1 where corners that
//! are counter-clockwise from outside are clockwise in (u, v).

use std::collections::HashMap;

use glam::{DVec2, DVec3};

use crate::scene::geometry::TriangleMesh;
use crate::scene::geometry::triangle_mesh::MeshValues;

/// The bits of a position, a normal and texture coordinates.
type Welded = ([u32; 3], [u32; 3], [u32; 2]);

/// The same mesh with tangents; a vertex becomes several where tangents differ on it. A mesh without normals is flat: its
/// triangles then share no vertices. Without texture coordinates nothing changes.
pub(super) fn with_tangents(mesh: TriangleMesh) -> TriangleMesh {
    if mesh.texture_coordinates.is_empty() {
        return mesh;
    }
    let faces: Vec<Face> = (0..mesh.triangles.len()).map(|face| Face::of(&mesh, face)).collect();
    let mut groups = Groups::of(&mesh, &faces);
    let mut sums = vec![DVec3::ZERO; 3 * faces.len()];
    for corner in 0..sums.len() {
        let face = &faces[corner / 3];
        sums[groups.root(corner)] += face.weighted_tangent(corner % 3);
    }
    let flat = mesh.normals.is_empty();
    let attributes: Vec<MeshValues> =
        mesh.attributes.iter().map(|values| MeshValues { numbers: Vec::new(), ..values.clone() }).collect();
    let mut made = TriangleMesh { face_normals: mesh.face_normals, attributes, ..TriangleMesh::default() };
    let mut vertices: HashMap<(u32, usize), u32> = HashMap::new();
    for (face, indices) in mesh.triangles.iter().enumerate() {
        made.triangles.push([0, 1, 2].map(|side| {
            let (vertex, root) = (indices[side], groups.root(3 * face + side));
            // Flat triangles have corners of their own.
            let key = if flat { (vertex, 3 * face + side) } else { (vertex, root) };
            *vertices.entry(key).or_insert_with(|| {
                let sign = if groups.turns_as_the_image(root, &faces) { 1.0 } else { -1.0 };
                let tangent = sums[root].normalize_or_zero().as_vec3();
                made.positions.push(mesh.positions[vertex as usize]);
                made.normals.extend(mesh.normals.get(vertex as usize));
                made.texture_coordinates.push(mesh.texture_coordinates[vertex as usize]);
                made.tangents.push(tangent.extend(sign).to_array());
                for (kept, given) in made.attributes.iter_mut().zip(&mesh.attributes) {
                    kept.numbers.extend_from_slice(given.of(vertex as usize));
                }
                made.positions.len() as u32 - 1
            })
        }));
    }
    made
}

/// How a triangle turns in the image, v downwards; `None` where its corners make no area there.
#[derive(Clone, Copy, PartialEq)]
enum Turn {
    AsTheImage,
    Mirrored,
}

/// What corners take from a triangle.
struct Face {
    corners: [DVec3; 3],
    normals: [DVec3; 3],
    /// ∂p/∂u, of length 1; zero where the image does not tell.
    along_u: DVec3,
    turn: Option<Turn>,
}

impl Face {
    fn of(mesh: &TriangleMesh, face: usize) -> Self {
        let indices = mesh.triangles[face].map(|index| index as usize);
        let vector = |numbers: [f32; 3]| DVec3::from_array(numbers.map(f64::from));
        let corners = indices.map(|index| vector(mesh.positions[index]));
        let [one, other] = [corners[1] - corners[0], corners[2] - corners[0]];
        let flat = one.cross(other).normalize_or_zero();
        let normals =
            indices.map(|index| mesh.normals.get(index).map_or(flat, |normal| vector(*normal).normalize_or_zero()));
        let [a, b, c] = indices.map(|index| DVec2::from_array(mesh.texture_coordinates[index].map(f64::from)));
        let [first, second] = [b - a, c - a];
        let area = first.perp_dot(second);
        let along_u = ((one * second.y - other * first.y) * area.signum()).normalize_or_zero();
        let turn = (area != 0.0 && flat != DVec3::ZERO && along_u != DVec3::ZERO).then_some(if area < 0.0 {
            Turn::AsTheImage
        } else {
            Turn::Mirrored
        });
        Self { corners, normals, along_u: if turn.is_some() { along_u } else { DVec3::ZERO }, turn }
    }

    /// The tangent at a corner times the angle there.
    fn weighted_tangent(&self, side: usize) -> DVec3 {
        let normal = self.normals[side];
        let across = |vector: DVec3| (vector - normal * normal.dot(vector)).normalize_or_zero();
        let edge = |to: usize| across(self.corners[(side + to) % 3] - self.corners[side]);
        across(self.along_u) * libm::acos(edge(1).dot(edge(2)).clamp(-1.0, 1.0))
    }
}

/// Corners that belong together, as a forest: corner `side` of triangle `face` is number `3·face + side`.
struct Groups {
    parents: Vec<usize>,
}

impl Groups {
    fn of(mesh: &TriangleMesh, faces: &[Face]) -> Self {
        let mut groups = Self { parents: (0..3 * faces.len()).collect() };
        let vertices = welded(mesh, faces);
        // Of each edge and turn the corners at its ends, in the order of the ends.
        let mut edges: HashMap<(usize, usize, bool), [usize; 2]> = HashMap::new();
        for (face, turn) in faces.iter().enumerate().filter_map(|(face, found)| Some((face, found.turn?))) {
            for side in 0..3 {
                let ends = [3 * face + side, 3 * face + (side + 1) % 3];
                let [from, to] = ends.map(|corner| vertices[corner]);
                let ends = if from <= to { ends } else { [ends[1], ends[0]] };
                let key = (from.min(to), from.max(to), turn == Turn::Mirrored);
                let known = *edges.entry(key).or_insert(ends);
                groups.join(known[0], ends[0]);
                groups.join(known[1], ends[1]);
            }
        }
        groups.adopt(&vertices, faces);
        groups
    }

    /// Triangles without an area in the image take the tangents of others at their corners.
    fn adopt(&mut self, vertices: &[usize], faces: &[Face]) {
        let has_turn = |corner: usize| faces[corner / 3].turn.is_some();
        let mut known: HashMap<usize, usize> = HashMap::new();
        for corner in (0..vertices.len()).filter(|corner| has_turn(*corner)) {
            known.entry(vertices[corner]).or_insert(corner);
        }
        for corner in (0..vertices.len()).filter(|corner| !has_turn(*corner)) {
            if let Some(other) = known.get(&vertices[corner]) {
                self.join(*other, corner);
            }
        }
    }

    fn root(&mut self, mut corner: usize) -> usize {
        while self.parents[corner] != corner {
            self.parents[corner] = self.parents[self.parents[corner]];
            corner = self.parents[corner];
        }
        corner
    }

    /// Puts the group of `other` below that of `corner`.
    fn join(&mut self, corner: usize, other: usize) {
        let (root, below) = (self.root(corner), self.root(other));
        self.parents[below] = root;
    }

    fn turns_as_the_image(&self, root: usize, faces: &[Face]) -> bool {
        faces[root / 3].turn == Some(Turn::AsTheImage)
    }
}

/// For each corner a number that corners with the same position, normal and texture coordinates share.
fn welded(mesh: &TriangleMesh, faces: &[Face]) -> Vec<usize> {
    // Zeros of both signs are one number.
    let bits = |number: f32| if number == 0.0 { 0 } else { number.to_bits() };
    let mut numbers: HashMap<Welded, usize> = HashMap::new();
    let corners = mesh.triangles.iter().flatten().enumerate();
    corners
        .map(|(corner, index)| {
            let position = mesh.positions[*index as usize].map(bits);
            let normal = faces[corner / 3].normals[corner % 3].as_vec3().to_array().map(bits);
            let coordinates = mesh.texture_coordinates[*index as usize].map(bits);
            let next = numbers.len();
            *numbers.entry((position, normal, coordinates)).or_insert(next)
        })
        .collect()
}
