//! The tree of nodes: where meshes, cameras and lights stand in the world.

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use glam::{DMat4, DQuat, DVec3};

use super::super::draft::{Draft, Target};
use super::accessor::Accessor;
use super::animation::{Pose, Poses};
use super::camera::CameraNode;
use super::entry::{Document, Entry};
use super::material::{Material, Materials};
use super::mesh::{MeshFile, MeshFiles};
use super::{Input, Output, extensions, lights};
use crate::scene::bundle::Bundle;
use crate::scene::description::PluginClass;
use crate::scene::error::{Location, SceneError};
use crate::scene::notice::Notice;

/// The most shapes that a file may make, by nodes and by instances.
const SHAPE_LIMIT: usize = 200_000;

/// What the nodes of a scene hold, as plugins.
#[derive(Default)]
pub(super) struct Contents<'a> {
    /// In the order of their nodes.
    pub cameras: Vec<CameraNode<'a>>,
    pub shapes: Vec<Draft>,
    pub emitters: Vec<Draft>,
    /// Least and greatest coordinates of all shapes; `None` without shapes.
    pub bounds: Option<[DVec3; 2]>,
    files: MeshFiles,
    /// What nodes place, in their order.
    placements: Vec<Placement>,
    /// How many primitives were placed, with triangles or without.
    placed: usize,
}

/// A primitive where a node has it.
struct Placement {
    file: MeshFile,
    material: Rc<Material>,
    /// The node's, or the mesh's where the node has none.
    name: String,
    location: Location,
    to_world: DMat4,
}

/// Copies that are no more triangles than this, all together, are made; beyond that a mesh is placed as instances. Copies are
/// faster to trace, instances take neither memory nor time to prepare.
const MOST_COPIED: usize = 20_000;

/// Reads all nodes of the scene that the file shows.
///
/// # Errors
/// On nodes that are reached twice, and on whatever is wrong with what they hold.
pub(super) fn read<'a>(
    input: &Input<'a>,
    poses: &Poses,
    materials: &mut Materials,
    output: &mut Output,
) -> Result<Contents<'a>, SceneError> {
    let mut contents = Contents::default();
    let mut tree = Tree { reached: vec![false; input.document.count("nodes")], waiting: Vec::new() };
    tree.add(roots(input.document, output)?, DMat4::IDENTITY)?;
    while let Some((index, node, parent)) = tree.waiting.pop() {
        extensions::report_unread(&node, output)?;
        let to_world = parent * transform(&node, poses.of(index))?;
        contents.add_meshes(&node, to_world, input, materials, output)?;
        contents.add_camera(&node, to_world)?;
        contents.emitters.extend(lights::read(&node, to_world, input.document, output)?);
        tree.add(node.references("children", "nodes")?, to_world)?;
    }
    contents.place(output);
    Ok(contents)
}

/// The nodes that are still to be read, the next one last, each with the transform of its parent to the world.
struct Tree<'a> {
    reached: Vec<bool>,
    waiting: Vec<(usize, Entry<'a>, DMat4)>,
}

impl<'a> Tree<'a> {
    /// Adds the children of a node, which are read before all others.
    fn add(&mut self, children: Vec<(usize, Entry<'a>)>, to_world: DMat4) -> Result<(), SceneError> {
        for (index, node) in children.into_iter().rev() {
            if std::mem::replace(&mut self.reached[index], true) {
                let problem = "the node is reached twice: it has two parents, or is below itself";
                return Err(node.error(problem, "give every node one parent"));
            }
            self.waiting.push((index, node, to_world));
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

/// A node's transform to its parent. Nodes with a matrix are not animated.
fn transform(node: &Entry<'_>, pose: Pose) -> Result<DMat4, SceneError> {
    if let Some(columns) = node.numbers::<16>("matrix")? {
        return Ok(DMat4::from_cols_array(&columns));
    }
    let scale = pose.scale.or(node.numbers("scale")?).unwrap_or([1.0; 3]);
    let rotation = pose.rotation.or(node.numbers("rotation")?).unwrap_or([0.0, 0.0, 0.0, 1.0]);
    let translation = pose.translation.or(node.numbers("translation")?).unwrap_or([0.0; 3]);
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

impl<'d> Contents<'d> {
    /// Whether anything in the scene emits: lights may be black. `files` are those of the scene.
    pub(super) fn emits(&self, files: &Bundle) -> bool {
        let children = self.shapes.iter().flat_map(|shape| &shape.children);
        let on_shapes = children.filter_map(|child| match &child.target {
            Target::Plugin(plugin) if plugin.class == PluginClass::Emitter => Some(plugin),
            _ => None,
        });
        // The shapes of a material have copies of one emitter, at one place.
        let emitters: BTreeMap<&str, &Draft> =
            self.emitters.iter().chain(on_shapes).map(|emitter| (emitter.location.path.as_str(), emitter)).collect();
        !emitters.values().all(|emitter| lights_nothing(emitter) || lights::is_black(emitter, files))
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
        let name = node.text("name")?.or(mesh.text("name")?).unwrap_or_default();
        for primitive in mesh.objects("primitives")? {
            let material = materials.of(&primitive, input, output)?;
            let file = self.files.file(&primitive, material.wish, input, output)?;
            for place in &places {
                self.placed += 1;
                if self.placed > SHAPE_LIMIT {
                    let problem = format!("from here on the scene has more than {SHAPE_LIMIT} shapes");
                    return Err(node.error(problem, "join meshes, or split the scene"));
                }
                let to_world = to_world * *place;
                let Some(file) = file.clone() else { break };
                let (material, location) = (material.clone(), node.location());
                self.include(file.bounds, to_world);
                self.placements.push(Placement { file, material, name: name.to_owned(), location, to_world });
            }
        }
        Ok(())
    }

    fn include(&mut self, bounds: [DVec3; 2], to_world: DMat4) {
        for corner in 0..8 {
            let side = |axis: usize| bounds[corner >> axis & 1][axis];
            let point = to_world.transform_point3(DVec3::new(side(0), side(1), side(2)));
            let [least, greatest] = self.bounds.unwrap_or([point; 2]);
            self.bounds = Some([least.min(point), greatest.max(point)]);
        }
    }

    /// Makes shapes of what nodes place: copies, or a group and its instances where copies would be many.
    fn place(&mut self, output: &mut Output) {
        let placements = std::mem::take(&mut self.placements);
        let mut uses: HashMap<(&str, &str), usize> = HashMap::new();
        for Placement { file, material, .. } in &placements {
            *uses.entry((&file.name, &material.id)).or_insert(0) += 1;
        }
        let mut groups: HashMap<(&str, &str), String> = HashMap::new();
        for placement in &placements {
            let Placement { file, material, name, location, to_world } = placement;
            let key = (file.name.as_str(), material.id.as_str());
            if (uses[&key] - 1) * file.triangles <= MOST_COPIED {
                self.shapes.push(placement.shape().keeping_outside(*to_world).with_place(*to_world));
            } else if material.emitter.as_ref().is_some_and(|emitter| !lights_nothing(emitter)) {
                let explanation = "each is a mesh of its own, which takes time and memory: instances cannot emit";
                let subject = "the instances of a mesh that shines";
                output.notices.add(Notice::approximated(location, subject, explanation));
                self.shapes.push(placement.shape().keeping_outside(*to_world).with_place(*to_world));
            } else {
                let next = format!("instanced_{}", groups.len());
                let id = groups.entry(key).or_insert_with(|| {
                    let group = Draft::new(PluginClass::Shape, "shapegroup", location);
                    self.shapes.push(Draft { id: next.clone(), ..group.with_child("", placement.shape()) });
                    next
                });
                let instance = Draft::new(PluginClass::Shape, "instance", location).called(name).with_reference(id);
                self.shapes.push(instance.with_place(*to_world));
            }
        }
    }

    fn add_camera(&mut self, node: &Entry<'d>, to_world: DMat4) -> Result<(), SceneError> {
        let Some((_, camera)) = node.reference("camera", "cameras")? else { return Ok(()) };
        let name = node.text("name")?.or(camera.text("name")?).unwrap_or_default();
        self.cameras.push(CameraNode { name, location: node.location(), camera, to_world });
        Ok(())
    }
}

/// Whether an emitter is only seen.
fn lights_nothing(emitter: &Draft) -> bool {
    emitter.parameters.iter().any(|parameter| parameter.name == "seen_only")
}

impl Placement {
    /// The shape in its own space.
    fn shape(&self) -> Draft {
        let shape = Draft::new(PluginClass::Shape, "ply", &self.location)
            .called(&self.name)
            .with_text("filename", &self.file.name);
        let shape = if self.file.flat { shape.with_flag("face_normals", true) } else { shape };
        let shape = shape.with_reference(&self.material.id);
        let shape = match &self.material.interior {
            Some(medium) => shape.with_named_reference("interior", medium),
            None => shape,
        };
        match &self.material.emitter {
            Some(emitter) => shape.with_child("", emitter.clone()),
            None => shape,
        }
    }
}

impl Draft {
    /// Where a shape stands, unless that is where it was made.
    fn with_place(self, to_world: DMat4) -> Self {
        if to_world == DMat4::IDENTITY { self } else { self.with_transform("to_world", to_world) }
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
