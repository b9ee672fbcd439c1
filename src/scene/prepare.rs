//! Description to prepared scene.

mod checks;
mod instancing;
mod lights;
mod materials;
mod media;
mod shapes;

use std::collections::HashMap;
use std::sync::Arc;

use super::bundle::Bundle;
use super::camera::{self, Camera};
use super::description::{Node, PluginClass, SceneDescription};
use super::error::SceneError;
use super::fields::Fields;
use super::film::{self, Film};
use super::geometry::mesh::ShapeGeometry;
use super::geometry::surface::NO_LIGHT;
use super::geometry::{Geometry, Interaction, Ray, Shape};
use super::integrator::{self, Integrator};
use super::light::area::Emission;
use super::light::{LightTable, Place};
use super::material::{Lobes, Material};
use super::medium::{Medium, MediumIndex};
use super::names::{Name, Names};
use super::notice::Notice;
use super::texture::TextureReader;
use checks::check_view;
use instancing::Instancing;
use lights::{AreaLightShape, PlacedLights, light_table, place_area_lights};
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
    /// Their lobes: asked at every hit.
    lobes: Arc<[Lobes]>,
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
    /// What its objects and materials are called.
    pub names: Arc<Names>,
    /// Things the user should know, one sentence each (for example a material that was approximated).
    pub notices: Vec<String>,
}

/// What is collected while the tree is read.
struct Builder<'a> {
    bundle: &'a Bundle,
    textures: TextureReader<'a>,
    shapes: Vec<(Shape, ShapeGeometry)>,
    /// What they are called.
    shape_names: Vec<Name>,
    area_lights: Vec<AreaLightShape>,
    /// What is seen and lights nothing.
    seen_only: Vec<Emission>,
    materials: Vec<Material>,
    /// What they are called.
    material_names: Vec<Name>,
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
        let (mut instancing, mut notices) = (builder.instancing, builder.notices);
        let objects = [builder.shape_names, instancing.take_names()].concat();
        let names = Arc::new(Names { objects, materials: builder.material_names });
        notices.extend(asked.notices.iter().map(ToString::to_string));
        let (geometry, members) = Geometry::build(shapes);
        let mut geometry = instancing.add_to(geometry);
        camera.stand_outside(geometry.bounding_sphere());
        let mut lights = PlacedLights::default();
        place_area_lights(&mut geometry, &members, area_lights, &mut lights);
        let lights = light_table(&geometry, (lights, seen_only), &emitters, sensor, &mut textures, description)?;
        check_view(&camera, &geometry, &materials, sensor)?;
        let Film { width, height, .. } = film;
        let (geometry, lights) = (Arc::new(geometry), Arc::new(lights));
        let lobes = materials.iter().map(Material::lobes).collect();
        let (materials, turns_normals) = (materials.into(), textures.turns_normals());
        let mut scene = Self {
            width,
            height,
            film,
            camera,
            geometry,
            materials,
            lobes,
            turns_normals,
            lights,
            hides_lights: asked.hides_lights,
            integrator: asked.integrator,
            names,
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

    /// The same scene with other picks of its lights.
    #[must_use]
    pub fn with_lights(&self, lights: LightTable) -> Self {
        Self { lights: Arc::new(lights), ..self.clone() }
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
    #[inline(always)]
    pub fn intersect(&self, ray: &Ray) -> Option<Interaction> {
        self.geometry.intersect(ray)
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
        Place::on(hit, self.lobes_at(hit.shape))
    }

    /// The kinds of lobes of a shape's material.
    #[inline]
    pub fn lobes_at(&self, shape: Shape) -> Lobes {
        self.lobes[shape.material as usize]
    }

    /// What any of its materials can do; decides what has to run.
    pub fn lobes(&self) -> Lobes {
        self.lobes.iter().fold(Lobes::NONE, |all, one| all | *one)
    }
}

impl<'a> Builder<'a> {
    fn new(description: &'a SceneDescription) -> Self {
        let bundle = &description.bundle;
        Self {
            bundle,
            textures: TextureReader::new(bundle),
            shapes: Vec::new(),
            shape_names: Vec::new(),
            area_lights: Vec::new(),
            seen_only: Vec::new(),
            materials: Vec::new(),
            material_names: Vec::new(),
            material_of_node: HashMap::new(),
            media: Vec::new(),
            boundaries: Vec::new(),
            medium_of_node: HashMap::new(),
            instancing: Instancing::default(),
            notices: description.notices.iter().map(ToString::to_string).collect(),
        }
    }
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
