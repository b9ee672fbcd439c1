//! The tree of nodes: where meshes, cameras and lights stand in the world.

use std::collections::BTreeMap;

use glam::{DMat4, DQuat, DVec3};

use super::super::draft::{Draft, Target};
use super::accessor::Accessor;
use super::entry::{Document, Entry};
use super::material::Materials;
use super::mesh::MeshFiles;
use super::{Input, Output, camera, extensions, lights};
use crate::scene::bundle::Bundle;
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::SceneError;
use crate::scene::notice::Notice;

/// The most shapes that a file may make, by nodes and by instances.
const SHAPE_LIMIT: usize = 200_000;

/// What the nodes of a scene hold, as plugins.
#[derive(Default)]
pub(super) struct Contents {
    pub sensor: Option<Draft>,
    pub shapes: Vec<Draft>,
    pub emitters: Vec<Draft>,
    /// Least and greatest coordinates of all shapes; `None` without shapes.
    pub bounds: Option<[DVec3; 2]>,
    files: MeshFiles,
    /// How many primitives were placed, with triangles or without.
    placed: usize,
}

/// Reads all nodes of the scene that the file shows.
///
/// # Errors
/// On nodes that are reached twice, and on whatever is wrong with what they hold.
pub(super) fn read(input: &Input<'_>, materials: &mut Materials, output: &mut Output) -> Result<Contents, SceneError> {
    let mut contents = Contents::default();
    let mut tree = Tree { reached: vec![false; input.document.count("nodes")], waiting: Vec::new() };
    tree.add(roots(input.document, output)?, DMat4::IDENTITY)?;
    while let Some((node, parent)) = tree.waiting.pop() {
        extensions::report_unread(&node, output)?;
        let to_world = parent * transform(&node)?;
        contents.add_meshes(&node, to_world, input, materials, output)?;
        contents.add_camera(&node, to_world, output)?;
        contents.emitters.extend(lights::read(&node, to_world, input.document, output)?);
        tree.add(node.references("children", "nodes")?, to_world)?;
    }
    Ok(contents)
}

/// The nodes that are still to be read, the next one last, each with the transform of its parent to the world.
struct Tree<'a> {
    reached: Vec<bool>,
    waiting: Vec<(Entry<'a>, DMat4)>,
}

impl<'a> Tree<'a> {
    /// Adds the children of a node, which are read before all others.
    fn add(&mut self, children: Vec<(usize, Entry<'a>)>, to_world: DMat4) -> Result<(), SceneError> {
        for (index, node) in children.into_iter().rev() {
            if std::mem::replace(&mut self.reached[index], true) {
                let problem = "the node is reached twice: it has two parents, or is below itself";
                return Err(node.error(problem, "give every node one parent"));
            }
            self.waiting.push((node, to_world));
        }
        Ok(())
    }
}

/// The outermost nodes of the default scene; without one of the first; without scenes all nodes that have no parent.
fn roots<'a>(document: &'a Document, output: &mut Output) -> Result<Vec<(usize, Entry<'a>)>, SceneError> {
    let scene = match document.root().reference("scene", "scenes")? {
        Some((_, scene)) => Some(scene),
        None => document.item("scenes", 0)?,
    };
    if let Some(scene) = scene {
        extensions::report_unread(&scene, output)?;
        if document.count("scenes") > 1 {
            let explanation = format!("{} is rendered", scene.location().path);
            output.notices.add(Notice::ignored(
                &document.root().location(),
                "all scenes of the file but one",
                explanation,
            ));
        }
        return scene.references("nodes", "nodes");
    }
    let mut has_parent = vec![false; document.count("nodes")];
    let nodes = document.root().objects("nodes")?;
    for node in &nodes {
        for (child, _) in node.references("children", "nodes")? {
            has_parent[child] = true;
        }
    }
    Ok(nodes.into_iter().enumerate().filter(|(index, _)| !has_parent[*index]).collect())
}

/// A node's transform to its parent.
fn transform(node: &Entry<'_>) -> Result<DMat4, SceneError> {
    if let Some(columns) = node.numbers::<16>("matrix")? {
        return Ok(DMat4::from_cols_array(&columns));
    }
    let scale = node.numbers("scale")?.unwrap_or([1.0; 3]);
    let rotation = node.numbers("rotation")?.unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let translation = node.numbers("translation")?.unwrap_or([0.0; 3]);
    steps(scale, rotation, translation)
        .ok_or_else(|| node.error("the rotation is no quaternion", "export the scene again"))
}

/// Scale, then rotation by a quaternion (x, y, z, w), then translation; nothing when the quaternion has no length.
fn steps(scale: [f64; 3], rotation: [f64; 4], translation: [f64; 3]) -> Option<DMat4> {
    let rotation = DQuat::from_array(rotation);
    let length = rotation.length();
    (length > 0.0 && length.is_finite()).then(|| {
        let [scale, translation] = [scale, translation].map(DVec3::from_array);
        DMat4::from_scale_rotation_translation(scale, rotation / length, translation)
    })
}

impl Contents {
    /// Whether nothing in the scene emits, also where it has lights: they may be black. `files` are those of the scene.
    pub(super) fn is_dark(&self, files: &Bundle) -> bool {
        let children = self.shapes.iter().flat_map(|shape| &shape.children);
        let on_shapes = children.filter_map(|child| match &child.target {
            Target::Plugin(plugin) if plugin.class == PluginClass::Emitter => Some(plugin),
            _ => None,
        });
        // The shapes of a material have copies of one emitter, at one place.
        let emitters: BTreeMap<&str, &Draft> =
            self.emitters.iter().chain(on_shapes).map(|emitter| (emitter.location.path.as_str(), emitter)).collect();
        emitters.values().all(|emitter| lights::is_black(emitter, files))
    }

    fn add_meshes<'a>(
        &mut self,
        node: &Entry<'a>,
        to_world: DMat4,
        input: &Input<'a>,
        materials: &mut Materials,
        output: &mut Output,
    ) -> Result<(), SceneError> {
        let Some((_, mesh)) = node.reference("mesh", "meshes")? else { return Ok(()) };
        let skinned = node.has("skin");
        if skinned {
            let explanation = "the mesh has the pose in which it was bound to its joints";
            output.notices.add(Notice::ignored(&node.location(), "the skin of a node", explanation));
        }
        // Joints, not the node, place a skinned mesh.
        let to_world = if skinned { DMat4::IDENTITY } else { to_world };
        let places = instances(node, input)?.unwrap_or_else(|| vec![DMat4::IDENTITY]);
        extensions::report_unread(&mesh, output)?;
        for primitive in mesh.objects("primitives")? {
            let material = materials.of(&primitive, input, output)?;
            for place in &places {
                self.placed += 1;
                if self.placed > SHAPE_LIMIT {
                    let problem = format!("from here on the scene has more than {SHAPE_LIMIT} shapes");
                    return Err(node.error(problem, "join meshes, or split the scene"));
                }
                let to_world = to_world * *place;
                let Some(file) = self.files.file(&primitive, material.texture_coordinates, input, output)? else {
                    break;
                };
                let mut shape = Draft::new(PluginClass::Shape, "ply", &node.location())
                    .with("filename", Value::String(file.name.clone()));
                if file.flat {
                    shape = shape.with("face_normals", Value::Boolean(true));
                }
                if to_world != DMat4::IDENTITY {
                    shape = shape.with("to_world", Value::Transform(to_world));
                }
                shape = shape.with_reference(&material.id);
                if let Some(emitter) = &material.emitter {
                    shape = shape.with_child("", emitter.clone());
                }
                self.add_shape(shape, file.bounds, to_world);
            }
        }
        Ok(())
    }

    fn add_shape(&mut self, shape: Draft, bounds: [DVec3; 2], to_world: DMat4) {
        self.shapes.push(shape);
        for corner in 0..8 {
            let side = |axis: usize| bounds[corner >> axis & 1][axis];
            let point = to_world.transform_point3(DVec3::new(side(0), side(1), side(2)));
            let [least, greatest] = self.bounds.unwrap_or([point; 2]);
            self.bounds = Some([least.min(point), greatest.max(point)]);
        }
    }

    fn add_camera(&mut self, node: &Entry<'_>, to_world: DMat4, output: &mut Output) -> Result<(), SceneError> {
        let Some((_, camera)) = node.reference("camera", "cameras")? else { return Ok(()) };
        if self.sensor.is_some() {
            output.notices.add(Notice::ignored(&node.location(), "a camera", "the first camera of the scene is used"));
            return Ok(());
        }
        self.sensor = camera::read(&camera, to_world, output)?;
        Ok(())
    }
}

/// Where the instances of EXT_mesh_gpu_instancing stand below their node; nothing for a node without it.
fn instances(node: &Entry<'_>, input: &Input<'_>) -> Result<Option<Vec<DMat4>>, SceneError> {
    let Some(extension) = node.extension("EXT_mesh_gpu_instancing")? else { return Ok(None) };
    let Some(attributes) = extension.child("attributes")? else { return Ok(None) };
    let open = |key: &str, kind: &str| match attributes.reference(key, "accessors")? {
        Some((_, accessor)) => Accessor::open(input.buffers, &accessor, kind).map(Some),
        None => Ok(None),
    };
    let [translation, scale] = [open("TRANSLATION", "VEC3")?, open("SCALE", "VEC3")?];
    let rotation = open("ROTATION", "VEC4")?;
    let counts: Vec<usize> = [&translation, &scale, &rotation].into_iter().flatten().map(Accessor::count).collect();
    let Some(count) = counts.first().copied() else { return Ok(None) };
    if counts.iter().any(|other| *other != count) || count > SHAPE_LIMIT {
        return Err(attributes.error("the attributes have different counts, or too many", "export the scene again"));
    }
    let place = |index: usize| {
        let scale = scale.as_ref().map_or([1.0; 3], |scale| scale.vector(index));
        let rotation = rotation.as_ref().map_or([0.0, 0.0, 0.0, 1.0], |rotation| rotation.vector(index));
        let translation = translation.as_ref().map_or([0.0; 3], |translation| translation.vector(index));
        let place = steps(scale, rotation, translation).filter(|place| place.is_finite());
        place.ok_or_else(|| attributes.error(format!("instance {index} has no place"), "export the scene again"))
    };
    (0..count).map(place).collect::<Result<_, _>>().map(Some)
}
