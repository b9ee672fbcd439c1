//! What an MGF file puts into the scene: one mesh and one bsdf for each material, analytic shapes, lights, a camera.

use std::collections::HashMap;

use glam::{DMat3, DMat4, DVec3};

use super::super::draft::Draft;
use super::bsdf::{LUMENS_PER_WATT, Writer};
use super::material::{Key, Material};
use super::mesh::Mesh;
use super::polygon::{Failure, triangulate};
use super::text::Entity;
use crate::scene::bundle::Generated;
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
pub(super) struct Surface {
    id: String,
    bsdf: Draft,
    pub radiance: Option<[f64; 3]>,
    two_sided: bool,
    pub mesh: Mesh,
}

/// The scene so far.
pub(super) struct Stage {
    pub surfaces: Vec<Surface>,
    places: HashMap<Key, usize>,
    pub shapes: Vec<Draft>,
    /// Meshes of arrays.
    pub made: Generated,
    /// How many arrays are instances.
    pub arrays: usize,
    /// Whether only what emits is added.
    pub only_lights: bool,
    triangles: usize,
    work: u64,
    /// Least and greatest coordinates.
    pub bounds: [DVec3; 2],
    pub notices: Vec<Notice>,
}

impl Stage {
    /// An empty scene.
    pub(super) fn new() -> Self {
        Self {
            surfaces: Vec::new(),
            places: HashMap::new(),
            shapes: Vec::new(),
            made: Generated::default(),
            arrays: 0,
            only_lights: false,
            triangles: 0,
            work: WORK_LIMIT,
            bounds: [DVec3::INFINITY, DVec3::NEG_INFINITY],
            notices: Vec::new(),
        }
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
        let bsdf = Draft { id: id.clone(), ..writer.bsdf(material) }.called(&name);
        let radiance = self.radiance(material, &name, &location);
        let two_sided = material.two_sided;
        self.surfaces.push(Surface { id, bsdf, radiance, two_sided, mesh: Mesh::default() });
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
        if outside {
            let subject = format!("an emitted color outside of Rec. 709 of material {name}");
            let instead = "the nearest color of the same luminance takes its place";
            self.notices.push(Notice::approximated(location, subject, instead));
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
        if self.passes_over(surface) {
            return Ok(());
        }
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
        if self.passes_over(surface) {
            return Ok(());
        }
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
        if self.passes_over(surface) {
            return Ok(());
        }
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

    /// Whether a surface was placed before and only what emits is added.
    fn passes_over(&self, surface: usize) -> bool {
        self.only_lights && self.surfaces[surface].radiance.is_none()
    }

    pub(super) fn finished(&self, shape: Draft, surface: &Surface) -> Draft {
        let location = shape.location.clone();
        let shape = shape.with_reference(&surface.id);
        match surface.radiance {
            None => shape,
            Some(rgb) => {
                let light = Draft::new(PluginClass::Emitter, "area", &location).with_rgb("radiance", rgb);
                shape.with_child("", if surface.two_sided { light.with_flag("two_sided", true) } else { light })
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
    pub(super) fn include(
        &mut self,
        points: impl Iterator<Item = DVec3>,
        entity: &Entity<'_>,
    ) -> Result<(), SceneError> {
        for point in points {
            if !point.as_vec3().is_finite() {
                return Err(entity.error("the shape is too large or too far away", "check its size and transforms"));
            }
            self.bounds = [self.bounds[0].min(point), self.bounds[1].max(point)];
        }
        Ok(())
    }

    /// The whole scene without a camera, the meshes that it refers to, and its bounds. `place` is the scene file.
    pub(super) fn finish(mut self, place: &Location) -> (Draft, Generated, [DVec3; 2], Vec<Notice>) {
        let mut scene = Draft::new(PluginClass::Scene, "scene", place);
        let mut made = std::mem::take(&mut self.made);
        let mut surfaces = std::mem::take(&mut self.surfaces);
        for (index, surface) in surfaces.iter_mut().enumerate().filter(|(_, surface)| surface.mesh.lengths()[1] > 0) {
            let name = format!("mgf-{index}.ply");
            made.meshes.insert(name.clone(), std::mem::take(&mut surface.mesh).into_triangles().into());
            let shape = Draft::new(PluginClass::Shape, "ply", &surface.bsdf.location).with_text("filename", &name);
            scene = scene.with_child("", self.finished(shape, surface));
        }
        for draft in surfaces.into_iter().map(|surface| surface.bsdf).chain(self.shapes) {
            scene = scene.with_child("", draft);
        }
        (scene, made, self.bounds, self.notices)
    }
}
