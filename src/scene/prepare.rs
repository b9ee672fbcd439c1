//! Description to prepared scene.

mod instancing;

use std::collections::HashMap;
use std::sync::Arc;

use super::bundle::Bundle;
use super::camera::{self, Camera};
use super::description::{Node, PluginClass, SceneDescription, Value};
use super::error::{SceneError, nearest_name};
use super::fields::Fields;
use super::film::{self, Film};
use super::geometry::mesh::ShapeGeometry;
use super::geometry::primitive::{Primitive, SHAPES};
use super::geometry::surface::SEEN_ONLY;
use super::geometry::{Geometry, Interaction, Ray, Shape};
use super::light::area::{self, Emission};
use super::light::{self, AreaLight, Light, LightTable, Place, Surroundings};
use super::material::{self, Lobes, Material, TransportMode, View};
use super::relief::{self, Relief};
use super::texture::TextureReader;
use crate::math::{Rgb, Vec2, Vec3};
use instancing::Instancing;

/// A prepared scene: checked, with accelerator, light table and materials; immutable, shared by reference. A clone shares all that is
/// large.
#[derive(Clone)]
pub struct Scene {
    /// Picture width, pixels.
    pub width: u32,
    /// Picture height, pixels.
    pub height: u32,
    /// The film behind them.
    pub film: Film,
    /// The camera.
    pub camera: Camera,
    /// All surfaces.
    pub geometry: Arc<Geometry>,
    /// All materials; shapes hold indices.
    pub materials: Arc<[Material]>,
    /// Their reliefs, by the same indices; empty when there are none at all.
    pub reliefs: Arc<[Option<Relief>]>,
    /// All lights.
    pub lights: Arc<LightTable>,
    /// The method that the scene's `<integrator>` asks for; `None` when there is none.
    pub integrator: Option<Integrator>,
    /// Things the user should know, one sentence each (for example a material that was approximated).
    pub notices: Vec<String>,
}

/// The scene's `<integrator>`: plugin name and plain parameters.
#[derive(Clone, Debug, PartialEq, serde::Serialize, serde::Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Integrator {
    /// Plugin name, for example `sppm` or `path`.
    pub name: String,
    /// Parameters as JSON values.
    pub parameters: serde_json::Map<String, serde_json::Value>,
}

/// What is collected while the tree is read.
struct Builder<'a> {
    bundle: &'a Bundle,
    textures: TextureReader<'a>,
    shapes: Vec<(Shape, ShapeGeometry)>,
    /// Index of a shape and what it emits.
    area_lights: Vec<(usize, Emission)>,
    /// What is seen and lights nothing.
    seen_only: Vec<Emission>,
    materials: Vec<Material>,
    /// As many as materials.
    reliefs: Vec<Option<Relief>>,
    /// Materials by the address of their node, so that shared nodes become one material, and whether they need texture
    /// coordinates.
    material_of_node: HashMap<*const Node, (u32, bool)>,
    instancing: Instancing,
    notices: Vec<String>,
}

impl Scene {
    /// Checks a description and builds what methods need.
    pub fn prepare(description: &SceneDescription) -> Result<Self, SceneError> {
        let root = &description.root;
        let mut fields = Fields::new(root);
        let mut builder = Builder::new(description);
        for node in fields.children(PluginClass::Shape) {
            builder.add_shape(node)?;
        }
        // Materials that no shape uses are checked all the same.
        for node in fields.children(PluginClass::Bsdf) {
            builder.material(node)?;
        }
        for node in fields.children(PluginClass::Texture) {
            builder.textures.texture(node)?;
        }
        let sensor = fields.child(PluginClass::Sensor).ok_or_else(|| {
            SceneError::new(&root.location, "the scene has no sensor", "add <sensor type=\"perspective\">")
        })?;
        let (film, camera) = read_sensor(sensor)?;
        let integrator =
            fields.child(PluginClass::Integrator).map(|node| read_integrator(node.as_ref())).transpose()?;
        let emitters = fields.children(PluginClass::Emitter);
        fields.finish()?;
        if builder.shapes.is_empty() && builder.instancing.is_empty() {
            return Err(SceneError::new(&root.location, "the scene has no shapes", "add at least one <shape>"));
        }
        let Builder { mut textures, shapes, area_lights, seen_only, materials, .. } = builder;
        let (mut reliefs, instancing, notices) = (builder.reliefs, builder.instancing, builder.notices);
        if reliefs.iter().all(Option::is_none) {
            reliefs.clear();
        }
        let (geometry, members) = Geometry::build(shapes);
        let mut geometry = instancing.add_to(geometry);
        let mut lights = Vec::new();
        place_area_lights(&mut geometry, &members, area_lights, &mut lights);
        let lights = light_table(&geometry, lights, &emitters, &mut textures, description)?.with_seen_only(seen_only);
        check_view(&camera, &geometry, &materials, sensor)?;
        let Film { width, height, .. } = film;
        let (geometry, lights) = (Arc::new(geometry), Arc::new(lights));
        let (materials, reliefs) = (materials.into(), reliefs.into());
        Ok(Self { width, height, film, camera, geometry, materials, reliefs, lights, integrator, notices })
    }

    /// The same scene with a picture of about `most` pixels, if it has more.
    pub fn with_pixels(&self, most: u32) -> Self {
        let mut scene = self.clone();
        scene.film.shrink(most);
        (scene.width, scene.height) = (scene.film.width, scene.film.height);
        scene
    }

    /// How many pixels the picture has.
    pub fn pixel_count(&self) -> usize {
        self.width as usize * self.height as usize
    }

    /// The camera ray through a pixel for four numbers in [0, 1): two for its place, two for the lens. All rays count the same:
    /// a filter with negative lobes is replaced.
    #[inline]
    pub fn camera_ray(&self, pixel: [u32; 2], [x, y, lens_x, lens_y]: [f32; 4]) -> Ray {
        self.camera.ray(self.film.smooth_point(pixel, [x, y]), [lens_x, lens_y])
    }

    /// The same with the film's own filter, and what the ray counts, which may be negative.
    #[inline]
    pub fn filtered_camera_ray(&self, pixel: [u32; 2], [x, y, lens_x, lens_y]: [f32; 4]) -> (Ray, f32) {
        let (place, count) = self.film.point(pixel, [x, y]);
        (self.camera.ray(place, [lens_x, lens_y]), count)
    }

    /// The first surface along `ray`, with the shading normal that its relief gives it.
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray) -> Option<Interaction> {
        let mut hit = self.geometry.intersect(ray)?;
        if let Some(Some(relief)) = self.reliefs.get(hit.shape.material as usize) {
            relief.turn(&self.geometry, &mut hit);
        }
        Some(hit)
    }

    /// The material of a shape.
    #[inline]
    pub fn material(&self, shape: Shape) -> &Material {
        &self.materials[shape.material as usize]
    }

    /// A hit as a place that light may arrive at.
    #[inline]
    pub fn place(&self, hit: &Interaction) -> Place {
        Place::on(hit, self.material(hit.shape).lobes())
    }

    /// What any of its materials can do; decides what has to run.
    pub fn lobes(&self) -> Lobes {
        self.materials.iter().map(Material::lobes).fold(Lobes::NONE, |all, one| all | one)
    }
}

/// The farthest that surfaces may reach from the origin, m: squares of distances must fit into single precision.
const FARTHEST: f32 = 1e18;

/// Refuses boxes that single precision cannot reckon with.
fn check_reach(node: &Node, mut boxes: impl Iterator<Item = (Vec3, Vec3)>) -> Result<(), SceneError> {
    let near = |corner: Vec3| corner.abs().cmplt(Vec3::splat(FARTHEST)).all();
    if boxes.all(|(low, high)| near(low) && near(high)) {
        return Ok(());
    }
    let problem = format!("shape \"{}\" reaches farther than {FARTHEST:e} m from the origin", node.plugin);
    Err(SceneError::new(&node.location, problem, "check its size and its to_world"))
}

/// A camera that sees nothing but the black backs of one-sided surfaces stands inside a solid.
fn check_view(camera: &Camera, geometry: &Geometry, materials: &[Material], sensor: &Node) -> Result<(), SceneError> {
    const SIDE: usize = 16;
    let sees_black_back = |index: usize| {
        let place = Vec2::new((index % SIDE) as f32 + 0.5, (index / SIDE) as f32 + 0.5) / SIDE as f32;
        let hit = geometry.intersect(&camera.ray(place, [0.5; 2]));
        hit.is_some_and(|hit| {
            let outgoing = hit.frame.to_local(hit.outgoing);
            let material = &materials[hit.shape.material as usize];
            outgoing.z < 0.0
                && material.sample(&View::new(hit.uv, outgoing, TransportMode::Radiance), [0.5; 3]).is_none()
        })
    };
    if !(0..SIDE * SIDE).all(sees_black_back) {
        return Ok(());
    }
    let problem = "the camera sees only the black backs of one-sided surfaces: it seems to stand inside a solid";
    Err(SceneError::new(&sensor.location, problem, "move it out, or make those surfaces \"twosided\""))
}

impl<'a> Builder<'a> {
    fn new(description: &'a SceneDescription) -> Self {
        let bundle = &description.bundle;
        Self {
            bundle,
            textures: TextureReader::new(bundle),
            shapes: Vec::new(),
            area_lights: Vec::new(),
            seen_only: Vec::new(),
            materials: Vec::new(),
            reliefs: Vec::new(),
            material_of_node: HashMap::new(),
            instancing: Instancing::default(),
            notices: description.notices.iter().map(ToString::to_string).collect(),
        }
    }

    fn add_shape(&mut self, node: &Arc<Node>) -> Result<(), SceneError> {
        if instancing::PLUGINS.contains(&node.plugin.as_str()) {
            return self.add_instancing(node);
        }
        let (shape, geometry, emission) = self.read_shape(node)?;
        if let Some(emission) = emission {
            self.area_lights.push((self.shapes.len(), emission));
        }
        self.shapes.push((shape, geometry));
        Ok(())
    }

    /// A shape that is made of primitives, and what it emits.
    fn read_shape(&mut self, node: &Node) -> Result<(Shape, ShapeGeometry, Option<Emission>), SceneError> {
        let Some((_, read)) = SHAPES.iter().find(|(name, _)| *name == node.plugin) else {
            let known: Vec<&str> = SHAPES.iter().map(|(name, _)| *name).chain(instancing::PLUGINS).collect();
            let problem = format!("there is no shape \"{}\"", node.plugin);
            return Err(SceneError::new(&node.location, problem, nearest_name(&node.plugin, &known)));
        };
        let mut fields = Fields::new(node);
        let geometry = read(&mut fields, self.bundle)?;
        let emitter = fields.child(PluginClass::Emitter);
        let (material, needs_uv) = match fields.child(PluginClass::Bsdf) {
            Some(node) => self.material(node)?,
            None => (self.default_material(emitter.is_some()), false),
        };
        let emitter = emitter.map(|node| read_area_light(node, &mut self.textures)).transpose()?;
        fields.finish()?;
        self.check_extent(node, &geometry)?;
        let emitter = emitter.filter(|emission| emission.radiance.range()[1] != Rgb::ZERO);
        let needs_uv = needs_uv || emitter.as_ref().is_some_and(|emission| emission.radiance.varies());
        let mut shape = Shape { needs_uv, ..Shape::new(material) };
        if let Some(shown) = emitter.as_ref().filter(|emission| emission.seen_only) {
            shape.light = SEEN_ONLY + self.seen_only.len() as u32;
            self.seen_only.push(shown.clone());
            return Ok((shape, geometry, None));
        }
        Ok((shape, geometry, emitter))
    }

    /// A shape must have area, in numbers that single precision can hold.
    fn check_extent(&mut self, node: &Node, geometry: &ShapeGeometry) -> Result<(), SceneError> {
        let area: f64 = geometry.primitives.iter().map(|primitive| f64::from(primitive.area())).sum();
        if !(area > 0.0 && area.is_finite()) {
            let problem = format!("shape \"{}\" has an area of {area} m²", node.plugin);
            return Err(SceneError::new(&node.location, problem, "check its size and its to_world"));
        }
        check_reach(node, geometry.primitives.iter().map(Primitive::bounds))?;
        self.notices.extend(geometry.notices.iter().map(|notice| format!("{}: {notice}", node.location)));
        if geometry.degenerate > 0 {
            self.notices
                .push(format!("{}: {} triangles without area are left out", node.location, geometry.degenerate));
        }
        Ok(())
    }

    /// The index of a material, and whether it needs texture coordinates.
    fn material(&mut self, node: &Arc<Node>) -> Result<(u32, bool), SceneError> {
        let address = Arc::as_ptr(node);
        if let Some(known) = self.material_of_node.get(&address) {
            return Ok(*known);
        }
        let asked = self.textures.coordinates_asked();
        let (plain, relief) = relief::take_off(node, &mut self.textures)?;
        self.materials.push(material::read(&plain, &mut self.textures)?);
        let needs_uv = relief.is_some() || self.textures.coordinates_asked() > asked;
        self.reliefs.push(relief);
        let read = (self.materials.len() as u32 - 1, needs_uv);
        self.material_of_node.insert(address, read);
        Ok(read)
    }

    /// Mitsuba gives shapes without a bsdf a two-sided grey of reflectance 0.5, but black to those that emit.
    fn default_material(&mut self, emits: bool) -> u32 {
        self.materials.push(if emits { Material::black() } else { Material::default_grey() });
        self.reliefs.push(None);
        self.materials.len() as u32 - 1
    }
}

fn read_area_light(node: &Node, textures: &mut TextureReader<'_>) -> Result<Emission, SceneError> {
    if node.plugin != "area" {
        let problem = format!("a shape cannot carry emitter \"{}\"", node.plugin);
        return Err(SceneError::new(
            &node.location,
            problem,
            "only \"area\" stands in a shape; put others in the scene",
        ));
    }
    let mut fields = Fields::new(node);
    let emission = area::read(&mut fields, textures)?;
    fields.finish()?;
    Ok(emission)
}

/// Turns the shapes that emit into lights.
fn place_area_lights(
    geometry: &mut Geometry,
    members: &[Vec<u32>],
    area_lights: Vec<(usize, Emission)>,
    lights: &mut Vec<Light>,
) {
    for (shape, emission) in area_lights {
        if let Some(light) = AreaLight::new(emission, members[shape].clone(), geometry) {
            geometry.set_light(shape, lights.len() as u32);
            lights.push(Light::AreaLight(light));
        }
    }
}

fn light_table(
    geometry: &Geometry,
    mut lights: Vec<Light>,
    emitters: &[&Arc<Node>],
    textures: &mut TextureReader<'_>,
    description: &SceneDescription,
) -> Result<LightTable, SceneError> {
    let surroundings = Surroundings::new(geometry.bounds());
    for node in emitters {
        let light = light::read(node, surroundings, textures, &description.bundle)?;
        if light.is_environment() && lights.iter().any(Light::is_environment) {
            return Err(SceneError::new(&node.location, "the scene has two environments", "remove one of them"));
        }
        lights.push(light);
    }
    LightTable::new(lights, geometry).ok_or_else(|| {
        SceneError::new(
            &description.root.location,
            "nothing in the scene emits light",
            "add an emitter with a radiance above 0",
        )
    })
}

fn read_sensor(node: &Node) -> Result<(Film, Camera), SceneError> {
    let mut fields = Fields::new(node);
    let film = match fields.child(PluginClass::Film) {
        Some(film) => film::read(film)?,
        None => Film::default(),
    };
    // Mitsuba's random number source: read and not used.
    fields.child(PluginClass::Sampler);
    let camera = camera::read(&mut fields, film.whole)?;
    fields.finish()?;
    Ok((film, camera))
}

fn read_integrator(node: &Node) -> Result<Integrator, SceneError> {
    let mut parameters = serde_json::Map::new();
    for parameter in &node.parameters {
        let value = match &parameter.value {
            Value::Integer(number) => (*number).into(),
            Value::Float(number) => (*number).into(),
            Value::Boolean(flag) => (*flag).into(),
            Value::String(text) => text.as_str().into(),
            other => {
                let problem = format!("an integrator has no {} parameters", other.type_name());
                return Err(SceneError::new(&parameter.location, problem, "give a number, a boolean or a string"));
            }
        };
        parameters.insert(parameter.name.clone(), value);
    }
    Ok(Integrator { name: node.plugin.clone(), parameters })
}
