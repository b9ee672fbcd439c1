//! Description to prepared scene.

mod checks;
mod instancing;
mod lights;
mod materials;
mod media;

use std::collections::HashMap;
use std::sync::Arc;

use super::bundle::Bundle;
use super::camera::{self, Camera};
use super::description::{Node, PluginClass, SceneDescription};
use super::error::{SceneError, shown_number};
use super::fields::Fields;
use super::film::{self, Film};
use super::geometry::mesh::ShapeGeometry;
use super::geometry::primitive::{Primitive, SHAPES};
use super::geometry::surface::{NO_LIGHT, SEEN_ONLY};
use super::geometry::transform::ToWorld;
use super::geometry::{Geometry, Interaction, Ray, Shape};
use super::integrator::{self, Integrator};
use super::light::area::Emission;
use super::light::directional_area::is_flat;
use super::light::{LightTable, Place};
use super::material::{Lobes, Material};
use super::medium::{Medium, MediumIndex};
use super::notice::Notice;
use super::texture::TextureReader;
use super::unsupported::unknown_plugin;
use crate::math::Rgb;
use checks::{check_reach, check_view};
use instancing::Instancing;
use lights::{light_table, place_area_lights, read_area_light};
use materials::KnownMaterial;

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
    /// Whether some of them turn normals.
    pub turns_normals: bool,
    /// All participating media; shapes hold indices.
    pub media: Arc<[Medium]>,
    /// The media inside and outside of shapes that separate two; shapes hold indices.
    pub boundaries: Arc<[[MediumIndex; 2]]>,
    /// The medium that the camera stands in.
    pub camera_medium: MediumIndex,
    /// The medium around everything.
    pub outermost_medium: MediumIndex,
    /// All lights.
    pub lights: Arc<LightTable>,
    /// Whether the camera looks through shapes that emit and sees no environment: the integrator's `hide_emitters`.
    pub hides_lights: bool,
    /// The method that the scene's `<integrator>` asks for; `None` when there is none.
    pub integrator: Option<Integrator>,
    /// Things the user should know, one sentence each (for example a material that was approximated).
    pub notices: Vec<String>,
}

/// A parameter of Mitsuba's shapes that steers how it finds derivatives.
const OF_DERIVATIVES: &str = "silhouette_sampling_weight";

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
    /// Materials by the address of their node, so that shared nodes become one material, as shapes without light.
    material_of_node: HashMap<*const Node, KnownMaterial>,
    /// Media, and their indices by the address of their node.
    media: Vec<Medium>,
    boundaries: Vec<[MediumIndex; 2]>,
    medium_of_node: HashMap<*const Node, u16>,
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
        let (film, mut camera, around) = read_sensor(sensor)?;
        let mut camera_medium = around.map(|node| builder.medium(node)).transpose()?;
        let asked = fields.child(PluginClass::Integrator).map(|node| integrator::read(node)).transpose()?;
        let asked = asked.unwrap_or_default();
        if asked.ignores_media {
            camera_medium = None;
            builder.leave_out_media(&root.location);
        }
        let (ownerless, emitters): (Vec<_>, Vec<_>) =
            fields.children(PluginClass::Emitter).into_iter().partition(|node| node.plugin == "area");
        for node in ownerless {
            let notice =
                Notice::ignored(&node.location, "emitter \"area\"", "it stands outside a shape, where nothing emits");
            builder.notices.push(notice.to_string());
        }
        for other in fields.children(PluginClass::Sensor) {
            let notice = Notice::ignored(&other.location, "another sensor", "the scene's first one counts");
            builder.notices.push(notice.to_string());
        }
        // Mitsuba passes over these where nothing asks for them.
        let passed_over = [PluginClass::Sampler, PluginClass::Film, PluginClass::ReconstructionFilter];
        for class in passed_over.into_iter().chain([PluginClass::Medium, PluginClass::Phase, PluginClass::Volume]) {
            fields.children(class);
        }
        fields.finish()?;
        let Builder { mut textures, shapes, area_lights, seen_only, materials, media, boundaries, .. } = builder;
        let (instancing, mut notices) = (builder.instancing, builder.notices);
        notices.extend(asked.notices.iter().map(ToString::to_string));
        let (geometry, members) = Geometry::build(shapes);
        let mut geometry = instancing.add_to(geometry);
        camera.stand_outside(geometry.bounding_sphere());
        let mut lights = Vec::new();
        place_area_lights(&mut geometry, &members, area_lights, &mut lights);
        let lights =
            light_table(&geometry, lights, &emitters, sensor, &mut textures, description)?.with_seen_only(seen_only);
        check_view(&camera, &geometry, &materials, sensor)?;
        let Film { width, height, .. } = film;
        let (geometry, lights) = (Arc::new(geometry), Arc::new(lights));
        let (materials, turns_normals) = (materials.into(), textures.turns_normals());
        let mut scene = Self {
            width,
            height,
            film,
            camera,
            geometry,
            materials,
            turns_normals,
            lights,
            hides_lights: asked.hides_lights,
            integrator: asked.integrator,
            notices,
            media: media.into(),
            boundaries: boundaries.into(),
            camera_medium,
            outermost_medium: camera_medium,
        };
        scene.outermost_medium = scene.medium_outside();
        scene.notices.extend(scene.notices_of_media(&sensor.location));
        Ok(scene)
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

    /// The first surface along `ray`, with all that its material needs.
    // A call of its own that holds all of the search, and changes what it found in place: else every hit is copied once more.
    #[inline(never)]
    pub fn intersect(&self, ray: &Ray) -> Option<Interaction> {
        let mut found = self.geometry.intersect(ray);
        if let Some(hit) = &mut found
            && hit.shape.needs_partials
        {
            hit.detail = self.geometry.partials_in_frame(hit);
        }
        found
    }

    /// The first surface that a camera ray meets.
    #[inline(always)]
    pub fn intersect_from_camera(&self, ray: &Ray) -> Option<Interaction> {
        let mut found = self.intersect(ray);
        if self.hides_lights {
            self.pass_lights(ray, &mut found);
        }
        found
    }

    /// Goes on along `ray` to the first surface that does not emit.
    #[cold]
    #[inline(never)]
    fn pass_lights(&self, ray: &Ray, found: &mut Option<Interaction>) {
        let mut passed = 0.0;
        while let Some(hit) = found.as_ref().filter(|hit| hit.shape.light != NO_LIGHT) {
            passed += hit.distance;
            let rest = Ray { length: ray.length - passed, ..hit.ray_to(ray.direction) };
            *found = self.intersect(&rest);
        }
        if let Some(hit) = found {
            hit.distance += passed;
        }
    }

    /// Whether anything that the camera sees is between a ray's origin and its length.
    #[inline]
    pub fn is_hidden_from_camera(&self, ray: &Ray) -> bool {
        let blocked = self.geometry.is_blocked(ray);
        blocked && (!self.hides_lights || self.intersect_from_camera(ray).is_some())
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
            material_of_node: HashMap::new(),
            media: Vec::new(),
            boundaries: Vec::new(),
            medium_of_node: HashMap::new(),
            instancing: Instancing::default(),
            notices: description.notices.iter().map(ToString::to_string).collect(),
        }
    }

    fn add_shape(&mut self, node: &Arc<Node>) -> Result<(), SceneError> {
        if instancing::PLUGINS.contains(&node.plugin.as_str()) {
            return self.add_instancing(node);
        }
        if node.plugin == MERGE {
            return members(node)?.into_iter().try_for_each(|member| self.add_shape(member));
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
            let known: Vec<&str> =
                SHAPES.iter().map(|(name, _)| *name).chain(instancing::PLUGINS).chain([MERGE]).collect();
            return Err(unknown_plugin(node, &known));
        };
        let mut fields = Fields::new(node);
        let mut geometry = read(&mut fields, self.bundle)?;
        fields.ignore(&[OF_DERIVATIVES]);
        self.textures.set_shape(Some(std::mem::take(&mut geometry.attributes)));
        let asked = self.textures.attributes_asked();
        if node.plugin == "sphere" && !ToWorld::read(&mut fields)?.is_similarity() {
            let explanation = "it stays a sphere, with the scale along x";
            let notice = Notice::approximated(&node.location, "a sphere that is scaled unevenly", explanation);
            self.notices.push(notice.to_string());
        }
        let emitter = fields.child(PluginClass::Emitter);
        let shape = match fields.child(PluginClass::Bsdf) {
            Some(node) => self.material(node)?,
            None => Shape::new(self.default_material(emitter.is_some())),
        };
        let shape = Shape { boundary: self.boundary_of(&mut fields, &node.location)?, ..shape };
        let emitter = emitter.map(|node| read_area_light(node, &mut self.textures)).transpose()?;
        fields.finish()?;
        geometry.needs_places = self.textures.attributes_asked() > asked;
        self.textures.set_shape(None);
        if geometry.needs_places && shape.needs_partials {
            let problem = "a shape with a bumpmap reads a mesh_attribute";
            return Err(SceneError::new(
                &node.location,
                problem,
                "take one of them off, or make the bumpmap a normalmap",
            ));
        }
        self.check_extent(node, &geometry)?;
        let emitter = emitter.filter(|emission| emission.radiance.range()[1] != Rgb::ZERO);
        if emitter.as_ref().is_some_and(|emission| emission.along_normal && !is_flat(&geometry.primitives)) {
            let problem = format!("\"directionalarea\" stands in a \"{}\" that is not flat", node.plugin);
            return Err(SceneError::new(
                &node.location,
                problem,
                "use flat shapes that face one way, each with its own",
            ));
        }
        let needs_uv = shape.needs_uv || emitter.as_ref().is_some_and(|emission| emission.radiance.varies());
        let mut shape = Shape { needs_uv, ..shape };
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
            let problem = format!("shape \"{}\" has an area of {} m²", node.plugin, shown_number(area));
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
}

/// `merge`: Mitsuba makes one mesh of those of its members that have the same bsdf; here they stay what they are, which looks the same.
const MERGE: &str = "merge";

/// The shapes that a `merge` holds.
fn members(merge: &Node) -> Result<Vec<&Arc<Node>>, SceneError> {
    let mut fields = Fields::new(merge);
    let members = fields.children(PluginClass::Shape);
    fields.ignore(&[OF_DERIVATIVES]);
    fields.finish()?;
    Ok(members)
}

fn read_sensor(node: &Node) -> Result<(Film, Camera, Option<&Arc<Node>>), SceneError> {
    let mut fields = Fields::new(node);
    let mut film = match fields.child(PluginClass::Film) {
        Some(film) => film::read(film)?,
        None => Film::default(),
    };
    // Mitsuba's random number source: read and not used.
    fields.child(PluginClass::Sampler);
    let camera = camera::read(&mut fields, film.whole)?;
    // Beyond the edges of one pixel is nothing else to see.
    film.samples_border &= !camera.is_distant();
    let medium = fields.child(PluginClass::Medium);
    fields.finish()?;
    Ok((film, camera, medium))
}
