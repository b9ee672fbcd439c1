//! `<Objects>` as shapes.

use std::collections::{HashMap, HashSet};

use glam::{DMat3, DMat4, DVec3};

use super::super::draft::Draft;
use super::super::notices::Notices;
use super::super::transform;
use super::super::values::shown;
use super::element::Element;
use super::material::Materials;
use super::mesh::{Vertices, unit_sphere};
use super::transformation::Transformations;
use crate::scene::bundle::Generated;
use crate::scene::description::PluginClass;
use crate::scene::error::{SceneError, nearest_name, shown_number};
use crate::scene::notice::Notice;

/// The most triangles that the scene file may make, without those in files of their own.
const TRIANGLE_LIMIT: usize = 4_000_000;
/// The most objects.
const OBJECT_LIMIT: usize = 200_000;

const OBJECTS: [&str; 6] = ["Mesh", "MeshInstance", "Triangle", "Sphere", "LightMesh", "LightSphere"];

/// A mesh that instances may repeat.
struct Base {
    /// The mesh without material and transform.
    shape: Draft,
    triangles: usize,
    to_world: DMat4,
    material: String,
}

/// Reads the objects of a scene.
pub(super) struct Objects<'a> {
    materials: &'a Materials,
    vertices: Vertices,
    transformations: Transformations,
    notices: &'a mut Notices,
    bases: HashMap<String, Base>,
    /// The ids of the shapegroups.
    groups: HashSet<String>,
    triangles: usize,
    /// The shapes so far.
    pub shapes: Vec<Draft>,
    /// The meshes that they refer to.
    pub made: Generated,
}

impl<'a> Objects<'a> {
    /// Reads what the objects of `scene` share.
    pub(super) fn new(
        scene: &Element<'_>,
        materials: &'a Materials,
        notices: &'a mut Notices,
    ) -> Result<Self, SceneError> {
        Ok(Self {
            materials,
            vertices: Vertices::read(scene)?,
            transformations: Transformations::read(scene, notices)?,
            notices,
            bases: HashMap::new(),
            groups: HashSet::new(),
            triangles: 0,
            shapes: Vec::new(),
            made: Generated::default(),
        })
    }

    /// Reads all objects of `scene`: meshes first, so that instances may stand before them.
    pub(super) fn read(&mut self, scene: &Element<'_>) -> Result<(), SceneError> {
        let objects = scene.required("Objects")?;
        objects.report_unknown(&OBJECTS, &[], self.notices);
        if let Some(first_too_many) = objects.elements().nth(OBJECT_LIMIT) {
            let problem = format!("the scene has more than {OBJECT_LIMIT} objects");
            return Err(first_too_many.error(problem, "merge meshes"));
        }
        for (index, mesh) in objects.all("Mesh").enumerate() {
            self.mesh(&mesh, index)?;
        }
        for object in objects.elements() {
            match object.tag() {
                "MeshInstance" => self.instance(&object)?,
                "Triangle" => self.triangle(&object)?,
                "Sphere" => self.sphere(&object)?,
                "LightMesh" => self.light_mesh(&object)?,
                "LightSphere" => self.light_sphere(&object)?,
                _ => {}
            }
        }
        Ok(())
    }

    fn mesh(&mut self, mesh: &Element<'_>, index: usize) -> Result<(), SceneError> {
        mesh.report_unknown(&["Material", "Faces", "Transformations"], &["shadingMode"], self.notices);
        let (shape, triangles) = self.faces(mesh)?;
        let (to_world, material) = (self.transformations.of(mesh)?, self.materials.of(mesh)?);
        self.shapes.push(
            shape.clone().keeping_outside(to_world).with_transform("to_world", to_world).with_reference(&material),
        );
        let id = mesh.attribute("id").map_or_else(|| (index + 1).to_string(), str::to_owned);
        if self.bases.insert(id, Base { shape, triangles, to_world, material }).is_some() {
            return Err(mesh.error("the id is given twice", "give every mesh an id of its own"));
        }
        Ok(())
    }

    /// The mesh of an object without material and transform, and how many triangles it has in the scene file.
    fn faces(&mut self, object: &Element<'_>) -> Result<(Draft, usize), SceneError> {
        let flat = match object.attribute("shadingMode") {
            None | Some("flat") => true,
            Some("smooth") => false,
            Some(other) => {
                return Err(object.error(format!("the shadingMode is {}", shown(other)), "write flat or smooth"));
            }
        };
        let faces = object.required("Faces")?;
        faces.report_unknown(&[], &["vertexOffset", "textureOffset", "plyFile", "binaryFile"], self.notices);
        if let Some(name) = faces.attribute("plyFile") {
            let shape = Draft::new(PluginClass::Shape, "ply", &object.location()).with_text("filename", name);
            return Ok((shape.with_flag("face_normals", flat), 0));
        }
        let (shape, triangles) = self.generated(object, &faces)?;
        Ok((shape.with_flag("face_normals", flat), triangles))
    }

    /// The triangles whose indices stand in `indices` as a mesh of their own.
    fn generated(&mut self, object: &Element<'_>, indices: &Element<'_>) -> Result<(Draft, usize), SceneError> {
        let triangles = self.vertices.triangles(indices)?;
        let count = triangles.triangles.len();
        self.count(count, object)?;
        let name = format!("generated/mesh-{}.ply", self.made.meshes.len());
        self.made.meshes.insert(name.clone(), triangles.into());
        let shape = Draft::new(PluginClass::Shape, "ply", &object.location()).with_text("filename", &name);
        Ok((shape, count))
    }

    fn count(&mut self, triangles: usize, object: &Element<'_>) -> Result<(), SceneError> {
        self.triangles += triangles;
        if self.triangles <= TRIANGLE_LIMIT {
            return Ok(());
        }
        let problem = format!("the scene has more than {TRIANGLE_LIMIT} triangles");
        Err(object.error(problem, "keep meshes in PLY files, and repeat them with the same material"))
    }

    /// A mesh again, in another place: one group for each mesh and material, and an instance of it.
    fn instance(&mut self, instance: &Element<'_>) -> Result<(), SceneError> {
        instance.report_unknown(&["Material", "Transformations"], &["baseMeshId", "resetTransform"], self.notices);
        let Some(id) = instance.attribute("baseMeshId") else {
            return Err(instance.error("the instance has no baseMeshId", "write baseMeshId=\"…\""));
        };
        let own = self.transformations.of(instance)?;
        let material = instance.child("Material")?.map(|_| self.materials.of(instance)).transpose()?;
        let Some(base) = self.bases.get(id) else {
            let mut known: Vec<&str> = self.bases.keys().map(String::as_str).collect();
            known.sort_unstable();
            return Err(instance.error(format!("there is no mesh {}", shown(id)), nearest_name(id, &known)));
        };
        let to_world = if instance.flag("resetTransform")? { own } else { own * base.to_world };
        let material = material.unwrap_or_else(|| base.material.clone());
        let (shape, triangles) = (base.shape.clone(), base.triangles);
        let group = format!("group-{id}-{material}");
        if self.groups.insert(group.clone()) {
            self.count(triangles, instance)?;
            let member = shape.with_reference(&material);
            let location = instance.location();
            let draft = Draft::new(PluginClass::Shape, "shapegroup", &location).with_child("", member);
            self.shapes.push(Draft { id: group.clone(), ..draft });
        }
        let shape = Draft::new(PluginClass::Shape, "instance", &instance.location());
        self.shapes.push(shape.with_transform("to_world", to_world).with_reference(&group));
        Ok(())
    }

    fn triangle(&mut self, triangle: &Element<'_>) -> Result<(), SceneError> {
        triangle.report_unknown(&["Material", "Indices", "Transformations"], &[], self.notices);
        let indices = triangle.required("Indices")?;
        indices.report_unknown(&[], &["vertexOffset", "textureOffset"], self.notices);
        let (shape, _) = self.generated(triangle, &indices)?;
        let to_world = self.transformations.of(triangle)?;
        let shape = shape.keeping_outside(to_world).with_transform("to_world", to_world);
        self.shapes.push(shape.with_reference(&self.materials.of(triangle)?));
        Ok(())
    }

    fn sphere(&mut self, sphere: &Element<'_>) -> Result<(), SceneError> {
        sphere.report_unknown(&["Material", "Center", "Radius", "Transformations"], &[], self.notices);
        let shape = self.ball(sphere)?.with_reference(&self.materials.of(sphere)?);
        self.shapes.push(shape);
        Ok(())
    }

    /// A sphere or an ellipsoid, without a material.
    fn ball(&mut self, object: &Element<'_>) -> Result<Draft, SceneError> {
        let center = self.vertices.position(&object.required("Center")?)?;
        let radius = object.required("Radius")?.number()?;
        let to_world = self.transformations.of(object)?;
        let location = object.location();
        if is_similarity(to_world) {
            let sphere = Draft::new(PluginClass::Shape, "sphere", &location).with_point("center", center);
            return Ok(sphere
                .with_float("radius", radius)
                .keeping_outside(to_world)
                .with_transform("to_world", to_world));
        }
        if radius <= 0.0 {
            return Err(object.error(format!("the radius is {}", shown_number(radius)), "write a number above 0"));
        }
        let sphere = unit_sphere();
        let triangles = sphere.triangles.len();
        self.count(triangles, object)?;
        let explanation = format!("a mesh of {triangles} triangles with smooth normals takes its place");
        self.notices.add(Notice::approximated(&location, "an ellipsoid", explanation));
        let name = "generated/unit-sphere.ply";
        self.made.meshes.entry(name.to_owned()).or_insert_with(|| sphere.into());
        let placed = to_world * transform::translate(center.to_array()) * transform::scale([radius; 3]);
        let mesh = Draft::new(PluginClass::Shape, "ply", &location).with_text("filename", name);
        Ok(mesh.keeping_outside(placed).with_transform("to_world", placed))
    }

    fn light_mesh(&mut self, light: &Element<'_>) -> Result<(), SceneError> {
        light.report_unknown(&["Material", "Radiance", "Faces", "Transformations"], &["shadingMode"], self.notices);
        let to_world = self.transformations.of(light)?;
        let shape = self.faces(light)?.0.keeping_outside(to_world).with_transform("to_world", to_world);
        self.emitting(light, shape)
    }

    fn light_sphere(&mut self, light: &Element<'_>) -> Result<(), SceneError> {
        light.report_unknown(&["Material", "Radiance", "Center", "Radius", "Transformations"], &[], self.notices);
        let shape = self.ball(light)?;
        self.emitting(light, shape)
    }

    /// Objects that emit reflect nothing, whatever their material.
    fn emitting(&mut self, light: &Element<'_>, shape: Draft) -> Result<(), SceneError> {
        if light.child("Material")?.is_some() {
            self.materials.of(light)?;
        }
        let radiance = light.required("Radiance")?.color()?.map(|channel| channel * self.materials.light_scale);
        let location = light.location();
        let black = Draft::new(PluginClass::Bsdf, "diffuse", &location).with_rgb("reflectance", [0.0; 3]);
        let emitter = Draft::new(PluginClass::Emitter, "area", &location).with_rgb("radiance", radiance);
        self.shapes.push(shape.with_child("", black).with_child("", emitter));
        Ok(())
    }
}

/// Whether a transform keeps spheres.
fn is_similarity(matrix: DMat4) -> bool {
    const TOLERANCE: f64 = 1e-5;
    let DMat3 { x_axis: x, y_axis: y, z_axis: z } = DMat3::from_mat4(matrix);
    let squares = DVec3::new(x.length_squared(), y.length_squared(), z.length_squared());
    let products = DVec3::new(x.dot(y), y.dot(z), z.dot(x));
    let most = TOLERANCE * squares.x;
    (squares - squares.x).abs().max_element() <= most && products.abs().max_element() <= most
}
