//! What an MGF file puts into the scene: one mesh and one bsdf for each material, analytic shapes, lights, a camera.

use std::collections::HashMap;

use glam::{DMat3, DMat4, DVec3};

use super::super::draft::Draft;
use super::super::transform;
use super::bsdf::{LUMENS_PER_WATT, Writer};
use super::material::{Key, Material};
use super::mesh::Mesh;
use super::polygon::{Failure, triangulate};
use super::text::Entity;
use crate::scene::bundle::Files;
use crate::scene::description::PluginClass;
use crate::scene::error::{Location, SceneError};
use crate::scene::notice::Notice;

/// The most triangles that a scene may become.
const TRIANGLE_LIMIT: usize = 4_000_000;
/// The most spheres, cylinders, disks and lights that a scene may become.
const SHAPE_LIMIT: usize = 200_000;
/// The most materials that surfaces may have.
const MATERIAL_LIMIT: usize = 65_536;
/// How many steps all of a scene's polygons may take to be cut into triangles.
const WORK_LIMIT: u64 = 300_000_000;
/// How wide the default camera sees, degrees along the shorter side of the picture.
const FIELD_OF_VIEW: f64 = 40.0;
/// Where the default camera looks from: in front, from the right and from above, for z upwards.
const VIEWPOINT: DVec3 = DVec3::new(0.5, -0.75, 0.45);

/// A corner of a polygon: position, and normal or zero.
#[derive(Clone, Copy, Debug)]
pub(super) struct Vertex {
    pub position: DVec3,
    pub normal: DVec3,
}

/// The transform in effect, which keeps shapes.
#[derive(Clone, Copy)]
pub(super) struct Placed {
    matrix: DMat4,
    /// Turns and mirrors.
    turn: DMat3,
    pub scale: f64,
    pub mirrored: bool,
}

impl Placed {
    /// The transform of `matrix`, unless it flattens or explodes.
    pub(super) fn new(matrix: DMat4) -> Option<Self> {
        let linear = DMat3::from_mat4(matrix);
        let scale = linear.x_axis.length();
        let usable = matrix.is_finite() && scale > 1e-30 && scale < 1e30;
        usable.then(|| Self { matrix, turn: linear * (1.0 / scale), scale, mirrored: linear.determinant() < 0.0 })
    }

    pub(super) fn matrix(&self) -> DMat4 {
        self.matrix
    }

    pub(super) fn point(&self, point: DVec3) -> DVec3 {
        self.matrix.transform_point3(point)
    }

    pub(super) fn direction(&self, direction: DVec3) -> DVec3 {
        (self.turn * direction).normalize_or_zero()
    }

    pub(super) fn vertex(&self, vertex: Vertex) -> Vertex {
        Vertex { position: self.point(vertex.position), normal: self.direction(vertex.normal) }
    }
}

/// One material that surfaces have.
struct Surface {
    id: String,
    bsdf: Draft,
    radiance: Option<[f64; 3]>,
    mesh: Mesh,
}

/// The scene so far.
pub(super) struct Stage {
    surfaces: Vec<Surface>,
    places: HashMap<Key, usize>,
    shapes: Vec<Draft>,
    triangles: usize,
    work: u64,
    least: DVec3,
    most: DVec3,
    pub notices: Vec<Notice>,
}

impl Stage {
    /// An empty scene.
    pub(super) fn new() -> Self {
        let (least, most) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
        let (surfaces, places, shapes, notices) = (Vec::new(), HashMap::new(), Vec::new(), Vec::new());
        Self { surfaces, places, shapes, triangles: 0, work: WORK_LIMIT, least, most, notices }
    }

    /// The place of `material`, whose name is `name`, among the surfaces.
    pub(super) fn surface(
        &mut self,
        material: &Material,
        name: Option<&str>,
        entity: &Entity<'_>,
    ) -> Result<usize, SceneError> {
        let key = material.key();
        if let Some(place) = self.places.get(&key) {
            return Ok(*place);
        }
        if self.surfaces.len() >= MATERIAL_LIMIT {
            let problem = format!("the scene has more than {MATERIAL_LIMIT} different materials");
            return Err(entity.error(problem, "use materials again"));
        }
        let place = self.surfaces.len();
        let location = entity.location();
        let name: String = name.unwrap_or("without a name").chars().take(80).collect();
        let mut writer = Writer { name: &name, location: &location, notices: &mut self.notices };
        let id = format!("{name}-{place}");
        let bsdf = Draft { id: id.clone(), ..writer.bsdf(material) };
        let radiance = self.radiance(material, &name, &location);
        self.surfaces.push(Surface { id, bsdf, radiance, mesh: Mesh::default() });
        self.places.insert(key, place);
        Ok(place)
    }

    /// Emittance in lm·m⁻² becomes radiance in W·sr⁻¹·m⁻².
    fn radiance(&mut self, material: &Material, name: &str, location: &Location) -> Option<[f64; 3]> {
        let emission = material.emission;
        if emission.amount == 0.0 {
            return None;
        }
        let (rgb, outside) = emission.color.rgb(emission.amount / (std::f64::consts::PI * LUMENS_PER_WATT));
        let mut approximated = |what: &str, instead: &str| {
            self.notices.push(Notice::approximated(location, format!("{what} of material {name}"), instead));
        };
        if outside {
            approximated(
                "an emitted color outside of Rec. 709",
                "the nearest color of the same luminance takes its place",
            );
        }
        if material.two_sided {
            approximated("the emission of the back", "only the front emits");
        }
        Some(rgb)
    }

    /// Adds a polygon with holes in the space of the world.
    pub(super) fn polygon(
        &mut self,
        surface: usize,
        loops: &[Vec<Vertex>],
        entity: &Entity<'_>,
    ) -> Result<(), SceneError> {
        let corners: Vec<Vertex> = loops.concat();
        self.include(corners.iter().map(|corner| corner.position), entity)?;
        let outlines: Vec<Vec<DVec3>> =
            loops.iter().map(|outline| outline.iter().map(|vertex| vertex.position).collect()).collect();
        let cut = match triangulate(&outlines, &mut self.work) {
            Ok(cut) => cut,
            Err(Failure::Flat) => {
                self.notices.push(Notice::ignored(&entity.location(), "a polygon without area", ""));
                return self.count_notices(entity);
            }
            Err(Failure::Costly) => {
                let problem = "the scene's concave polygons have too many corners to be cut into triangles";
                return Err(entity.error(problem, "split them into smaller ones"));
            }
        };
        if cut.crossing {
            let notice = Notice::approximated(&entity.location(), "a polygon whose outline crosses itself", "");
            self.notices.push(notice);
            self.count_notices(entity)?;
        }
        self.count_triangles(cut.triangles.len(), entity)?;
        let mesh = &mut self.surfaces[surface].mesh;
        let normal = |corner: &Vertex| if corner.normal == DVec3::ZERO { cut.normal } else { corner.normal };
        let indices: Vec<u32> = corners.iter().map(|corner| mesh.vertex(corner.position, normal(corner))).collect();
        cut.triangles.iter().for_each(|triangle| mesh.triangle(triangle.map(|corner| indices[corner])));
        Ok(())
    }

    /// A grid of `columns` × `rows` quadrilaterals, counter-clockwise from outside along columns and then rows; `vertex` gives
    /// position and unit normal at (column, row). `inside_out` turns it.
    pub(super) fn grid(
        &mut self,
        surface: usize,
        size: [u32; 2],
        inside_out: bool,
        entity: &Entity<'_>,
        vertex: impl Fn(u32, u32) -> Vertex,
    ) -> Result<(), SceneError> {
        let [columns, rows] = size;
        self.count_triangles(2 * columns as usize * rows as usize, entity)?;
        let corners = (0..=rows).flat_map(|row| (0..=columns).map(move |column| (column, row)));
        let corners: Vec<Vertex> = corners.map(|(column, row)| vertex(column, row)).collect();
        self.include(corners.iter().map(|corner| corner.position), entity)?;
        let mesh = &mut self.surfaces[surface].mesh;
        let sign = if inside_out { -1.0 } else { 1.0 };
        let indices: Vec<u32> =
            corners.iter().map(|corner| mesh.vertex(corner.position, corner.normal * sign)).collect();
        for at in (0..rows).flat_map(|row| (0..columns).map(move |column| (row * (columns + 1) + column) as usize)) {
            let above = at + columns as usize + 1;
            let [a, b, c, d] = [at, at + 1, above + 1, above].map(|place| indices[place]);
            let pair = if inside_out { [[a, c, b], [a, d, c]] } else { [[a, b, c], [a, c, d]] };
            pair.into_iter().for_each(|triangle| mesh.triangle(triangle));
        }
        Ok(())
    }

    /// Adds an analytic shape inside of the ball round `center`.
    pub(super) fn shape(
        &mut self,
        surface: usize,
        shape: Draft,
        (center, radius): (DVec3, f64),
        entity: &Entity<'_>,
    ) -> Result<(), SceneError> {
        self.include([center - radius, center + radius].into_iter(), entity)?;
        let shape = self.finished(shape, &self.surfaces[surface]);
        self.add(shape, entity)
    }

    /// Adds a light.
    pub(super) fn add(&mut self, draft: Draft, entity: &Entity<'_>) -> Result<(), SceneError> {
        if self.shapes.len() >= SHAPE_LIMIT {
            let problem = format!("the scene has more than {SHAPE_LIMIT} spheres, cylinders, disks and lights");
            return Err(entity.error(problem, "make smaller arrays"));
        }
        self.shapes.push(draft);
        Ok(())
    }

    fn finished(&self, shape: Draft, surface: &Surface) -> Draft {
        let location = shape.location.clone();
        let shape = shape.with_reference(&surface.id);
        match surface.radiance {
            None => shape,
            Some(rgb) => {
                shape.with_child("", Draft::new(PluginClass::Emitter, "area", &location).with_rgb("radiance", rgb))
            }
        }
    }

    fn count_triangles(&mut self, count: usize, entity: &Entity<'_>) -> Result<(), SceneError> {
        self.triangles += count;
        if self.triangles <= TRIANGLE_LIMIT {
            return Ok(());
        }
        let problem = format!("the scene has more than {TRIANGLE_LIMIT} triangles");
        Err(entity.error(problem, "make smaller arrays"))
    }

    fn count_notices(&self, entity: &Entity<'_>) -> Result<(), SceneError> {
        if self.notices.len() <= 2 * MATERIAL_LIMIT {
            return Ok(());
        }
        Err(entity.error("too much of the scene cannot be represented", "repair its polygons"))
    }

    /// Makes room for points in the camera's view; they must fit into single precision.
    fn include(&mut self, points: impl Iterator<Item = DVec3>, entity: &Entity<'_>) -> Result<(), SceneError> {
        for point in points {
            if !point.as_vec3().is_finite() {
                return Err(entity.error("the shape is too large or too far away", "check its size and transforms"));
            }
            (self.least, self.most) = (self.least.min(point), self.most.max(point));
        }
        Ok(())
    }

    /// The whole scene, and the mesh files that it refers to. `place` is the scene file.
    pub(super) fn finish(mut self, place: &Location) -> (Draft, Files, Vec<Notice>) {
        let mut scene = Draft::new(PluginClass::Scene, "scene", place).with_child("", self.sensor(place));
        let mut files = Files::new();
        let surfaces = std::mem::take(&mut self.surfaces);
        for (index, surface) in surfaces.iter().enumerate().filter(|(_, surface)| surface.mesh.size() > 0) {
            let name = format!("mgf-{index}.ply");
            files.insert(name.clone(), surface.mesh.ply().into());
            let shape = Draft::new(PluginClass::Shape, "ply", &surface.bsdf.location).with_text("filename", &name);
            scene = scene.with_child("", self.finished(shape, surface));
        }
        for draft in surfaces.into_iter().map(|surface| surface.bsdf).chain(self.shapes) {
            scene = scene.with_child("", draft);
        }
        (scene, files, self.notices)
    }

    /// MGF has no camera: one that sees everything from outside.
    fn sensor(&mut self, place: &Location) -> Draft {
        let instead = "a perspective camera sees everything from outside, from the right and above with +z upwards";
        self.notices.push(Notice::approximated(place, "the view (MGF has no camera)", instead));
        let empty = self.least.x > self.most.x;
        let (least, most) = if empty { (DVec3::NEG_ONE, DVec3::ONE) } else { (self.least, self.most) };
        let (target, radius) = (0.5 * (least + most), (0.5 * (most - least).length()).max(1e-6));
        let distance = radius / libm::sin(0.5 * FIELD_OF_VIEW.to_radians());
        let origin = target + distance * VIEWPOINT.normalize();
        let [from, to, up] = [origin, target, DVec3::Z].map(|vector| vector.to_array());
        let to_world = transform::look_at(from, to, up).unwrap_or(DMat4::IDENTITY);
        Draft::new(PluginClass::Sensor, "perspective", place)
            .with_float("fov", FIELD_OF_VIEW)
            .with_text("fov_axis", "smaller")
            .with_float("near_clip", 1e-3 * distance)
            .with_float("far_clip", 10.0 * distance)
            .with_transform("to_world", to_world)
    }
}
