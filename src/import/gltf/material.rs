//! Materials: `principled` for all but MDL's thick glass, in `normalmap`, `twosided` and `mask` where they ask for it.

use std::collections::HashMap;
use std::rc::Rc;

use super::super::draft::Draft;
use super::entry::Entry;
use super::mesh::{self, Wish};
use super::texture::{Images, Meaning, Slot, Textures};
use super::transmission::{Transmission, interior, thin_wall};
use super::{Input, Output, extensions, specular_glossiness, unlit};
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::{Location, SceneError, shown_number};
use crate::scene::notice::Notice;

/// glTF's index of refraction, where a material gives none.
const DEFAULT_INDEX: f64 = 1.5;

/// A material as shapes use it.
pub(super) struct Material {
    /// The id of its bsdf.
    pub id: String,
    /// The area light of every shape that has it.
    pub emitter: Option<Draft>,
    /// The id of the medium inside of its shapes.
    pub interior: Option<String>,
    /// What its textures want of meshes.
    pub wish: Wish,
}

/// The materials that shapes have used so far.
#[derive(Default)]
pub(super) struct Materials {
    /// Their bsdfs, each with its id.
    pub plugins: Vec<Draft>,
    /// By the material's index, and whether vertices have colors.
    made: HashMap<(Option<usize>, bool), Rc<Material>>,
    images: Images,
}

impl Materials {
    /// The material of a primitive; glTF's default one if it names none.
    ///
    /// # Errors
    /// On references to nothing, and numbers that no material can have.
    pub(super) fn of<'a>(
        &mut self,
        primitive: &Entry<'a>,
        input: &Input<'a>,
        output: &mut Output,
    ) -> Result<Rc<Material>, SceneError> {
        let reference = primitive.reference("material", "materials")?;
        let colored = mesh::has_colors(primitive)?;
        let key = (reference.as_ref().map(|(index, _)| *index), colored);
        if let Some(known) = self.made.get(&key) {
            return Ok(known.clone());
        }
        let mut textures = Textures { input, output, images: &mut self.images, set: None, colored };
        let (mut bsdf, emitter, id) = match &reference {
            Some((index, entry)) if unlit::is_unlit(entry)? => {
                extensions::report_unread(entry, textures.output)?;
                let (black, emitter) = unlit::read(entry, &mut textures)?;
                (black, Some(emitter), format!("material_{index}"))
            }
            Some((index, entry)) => {
                (surface(entry, &mut textures)?, light(entry, &mut textures)?, format!("material_{index}"))
            }
            None => {
                let bsdf = Draft::new(PluginClass::Bsdf, "principled", &primitive.location());
                let base = Base::default().colored(&primitive.location(), &textures);
                (base.put(bsdf), None, "default_material".to_owned())
            }
        };
        let id = if colored { format!("{id}_colored") } else { id };
        bsdf.id.clone_from(&id);
        bsdf.name =
            reference.as_ref().map_or(Ok(None), |(_, entry)| entry.text("name"))?.unwrap_or_default().to_owned();
        let medium = reference.as_ref().map(|(_, entry)| interior(entry)).transpose()?.flatten();
        let interior = medium.map(|medium| {
            let id = format!("{id}_interior");
            self.plugins.push(Draft { id: id.clone(), ..medium });
            id
        });
        let has_normal_map = reference.as_ref().is_some_and(|(_, material)| material.has("normalTexture"));
        let wish = Wish { texture_coordinates: textures.set.unwrap_or(0), tangents: has_normal_map, colors: colored };
        let made = Rc::new(Material { id, emitter, interior, wish });
        self.plugins.push(bsdf);
        self.made.insert(key, made.clone());
        Ok(made)
    }
}

/// Color, metalness and roughness.
pub(super) struct Base {
    pub color: [f64; 3],
    pub color_texture: Option<Draft>,
    pub alpha: f64,
    pub alpha_texture: Option<Draft>,
    pub metallic: Slot,
    pub roughness: Slot,
}

impl Default for Base {
    fn default() -> Self {
        let one = || Slot::Value(Value::Float(1.0));
        Self {
            color: [1.0; 3],
            color_texture: None,
            alpha: 1.0,
            alpha_texture: None,
            metallic: one(),
            roughness: one(),
        }
    }
}

impl Base {
    /// Reads them.
    ///
    /// # Errors
    /// On factors out of range and textures that refer to nothing.
    pub(super) fn read<'a>(material: &Entry<'a>, textures: &mut Textures<'_, 'a>) -> Result<Self, SceneError> {
        if let Some(extension) = material.extension("KHR_materials_pbrSpecularGlossiness")? {
            return Ok(specular_glossiness::read(&extension, textures)?.colored(&material.location(), textures));
        }
        let Some(base) = material.child("pbrMetallicRoughness")? else {
            return Ok(Self::default().colored(&material.location(), textures));
        };
        let [red, green, blue, alpha] = base.numbers("baseColorFactor")?.unwrap_or([1.0; 4]);
        // The first texture decides which coordinates the material uses.
        let color_texture = textures.read(&base, "baseColorTexture", Meaning::Color)?;
        let mut factor = |key: &str, channel: &'static str| {
            let texture = textures.read(&base, "metallicRoughnessTexture", Meaning::Channel(channel))?;
            Ok::<Slot, SceneError>(Slot::product(texture, Value::Float(base.number_within(key, 1.0, 0.0, 1.0)?)))
        };
        let (metallic, roughness) = (factor("metallicFactor", "b")?, factor("roughnessFactor", "g")?);
        let alpha_texture = textures.read(&base, "baseColorTexture", Meaning::Channel("a"))?;
        let color = [red, green, blue];
        let base = Self { color, color_texture, alpha, alpha_texture, metallic, roughness };
        Ok(base.colored(&material.location(), textures))
    }

    /// With the colors of vertices, where the material is that of a primitive that has some.
    fn colored(self, location: &Location, textures: &Textures<'_, '_>) -> Self {
        if !textures.colored {
            return self;
        }
        let colors = Draft::new(PluginClass::Texture, "mesh_attribute", location).with_text("name", mesh::VERTEX_COLOR);
        let color_texture = match self.color_texture {
            Some(texture) => Draft::new(PluginClass::Texture, "scale", location)
                .with_child("scale", colors)
                .with_child("texture", texture),
            None => colors,
        };
        Self { color_texture: Some(color_texture), ..self }
    }

    /// Gives them to a `principled` bsdf. Mitsuba squares the roughness as glTF does.
    fn put(&self, bsdf: Draft) -> Draft {
        let bsdf = Slot::product(self.color_texture.clone(), Value::Rgb(self.color)).put(bsdf, "base_color");
        let bsdf = self.metallic.clone().put(bsdf, "metallic");
        self.roughness.clone().put(bsdf, "roughness")
    }
}

/// A bsdf of one side, and whether its material shows it on both.
pub(super) struct Sided {
    bsdf: Draft,
    both: bool,
}

impl Sided {
    /// The bsdf of both sides; that the back is black otherwise, is told.
    pub(super) fn told(self, material: &Entry<'_>, textures: &mut Textures<'_, '_>) -> Draft {
        if self.both {
            return Draft::new(PluginClass::Bsdf, "twosided", &material.location()).with_child("", self.bsdf);
        }
        let explanation = "its back is black where glTF draws nothing";
        textures.output.notices.add(Notice::approximated(&material.location(), "a single-sided material", explanation));
        self.bsdf
    }
}

/// The bsdf of a material.
fn surface<'a>(material: &Entry<'a>, textures: &mut Textures<'_, 'a>) -> Result<Draft, SceneError> {
    extensions::report_unread(material, textures.output)?;
    if let Some(glass) = thick_glass(material, textures)? {
        return Ok(glass);
    }
    let mut base = Base::read(material, textures)?;
    if material.has("occlusionTexture") {
        let explanation = "occlusion follows from the light itself";
        textures.output.notices.add(Notice::ignored(&material.location(), "an occlusion texture", explanation));
    }
    let opacity = opacity(material, &mut base, textures)?;
    let mut bsdf = base.put(Draft::new(PluginClass::Bsdf, "principled", &material.location()));
    let transmission = Transmission::read(material, &base, textures)?;
    let both = material.flag("doubleSided")?;
    bsdf = match transmission {
        Transmission::None => {
            bsdf = interface(material, bsdf, false, textures)?;
            bsdf = clearcoat(material, bsdf, textures)?;
            Sided { bsdf: bumps(material, bsdf, textures)?, both }.told(material, textures)
        }
        Transmission::Solid(share) => {
            bsdf = interface(material, share.put(bsdf, "spec_trans"), true, textures)?;
            bsdf = clearcoat(material, bsdf, textures)?;
            bumps(material, bsdf, textures)?
        }
        Transmission::Thin(share) => {
            bsdf = interface(material, bsdf, false, textures)?;
            bsdf = clearcoat(material, bsdf, textures)?;
            let wall = thin_wall(material, share, &base, Sided { bsdf, both }, textures)?;
            bumps(material, wall, textures)?
        }
    };
    Ok(match opacity {
        Some(opacity) => {
            let mask = Draft::new(PluginClass::Bsdf, "mask", &material.location());
            opacity.put(mask, "opacity").with_child("", bsdf)
        }
        None => bsdf,
    })
}

/// How much of a surface is there, when not all of it.
fn opacity(material: &Entry<'_>, base: &mut Base, textures: &mut Textures<'_, '_>) -> Result<Option<Slot>, SceneError> {
    let texture = base.alpha_texture.take();
    let opacity = match material.text("alphaMode")?.unwrap_or("OPAQUE") {
        "OPAQUE" => return Ok(None),
        "BLEND" => Slot::product(texture, Value::Float(base.alpha)),
        "MASK" if texture.is_some() => {
            let explanation = "alpha itself is taken as opacity";
            let notice = Notice::approximated(&material.location(), "the alphaCutoff of a mask", explanation);
            textures.output.notices.add(notice);
            Slot::product(texture, Value::Float(base.alpha))
        }
        "MASK" => {
            let cutoff = material.number_within("alphaCutoff", 0.5, 0.0, f64::INFINITY)?;
            Slot::Value(Value::Float(if base.alpha < cutoff { 0.0 } else { 1.0 }))
        }
        other => {
            let problem = format!("there is no alphaMode {other:?}");
            return Err(material.error(problem, "give \"OPAQUE\", \"MASK\" or \"BLEND\""));
        }
    };
    Ok(match opacity {
        Slot::Value(Value::Float(1.0)) => None,
        partial => Some(partial),
    })
}

/// The index of refraction, and KHR_materials_specular as one.
fn interface<'a>(
    material: &Entry<'a>,
    bsdf: Draft,
    transmissive: bool,
    textures: &mut Textures<'_, 'a>,
) -> Result<Draft, SceneError> {
    let index = index_of_refraction(material, textures)?;
    let mut report = |notice: Notice| textures.output.notices.add(notice);
    let Some(extension) = material.extension("KHR_materials_specular")? else {
        return Ok(bsdf.with("eta", Value::Float(index)));
    };
    let [red, green, blue] = extension.color("specularColorFactor", [1.0; 3])?;
    let strength = extension.number_within("specularFactor", 1.0, 0.0, 1.0)?;
    let strength = strength * (0.2126 * red + 0.7152 * green + 0.0722 * blue);
    if extension.has("specularTexture") || extension.has("specularColorTexture") {
        let explanation = "the factors are used alone";
        report(Notice::ignored(&extension.location(), "a texture of the specular strength or color", explanation));
    }
    if transmissive {
        let explanation = "the index of refraction alone decides what a transmissive surface reflects";
        report(Notice::ignored(&extension.location(), "the specular strength", explanation));
        return Ok(bsdf.with("eta", Value::Float(index)));
    }
    let explanation = "the index of refraction is changed so that as much is reflected head-on, without color";
    report(Notice::approximated(&extension.location(), "the specular strength", explanation));
    let root = (index - 1.0) / (index + 1.0);
    // Mitsuba's `specular` is the head-on reflectance over 0.08.
    let specular = root * root * strength / 0.08;
    if specular <= 1.0 {
        return Ok(bsdf.with("specular", Value::Float(specular)));
    }
    let root = (root * strength.sqrt()).min(0.95);
    Ok(bsdf.with("eta", Value::Float((1.0 + root) / (1.0 - root))))
}

/// KHR_materials_ior.
///
/// # Errors
/// On an index that is negative or no number.
pub(super) fn index_of_refraction(material: &Entry<'_>, textures: &mut Textures<'_, '_>) -> Result<f64, SceneError> {
    let Some(extension) = material.extension("KHR_materials_ior")? else { return Ok(DEFAULT_INDEX) };
    let index = extension.number_within("ior", DEFAULT_INDEX, 0.0, f64::INFINITY)?;
    if index >= 1.0 {
        return Ok(index);
    }
    let explanation = format!("{DEFAULT_INDEX} is used");
    let notice = Notice::approximated(&material.location(), "an index of refraction below 1", explanation);
    textures.output.notices.add(notice);
    Ok(DEFAULT_INDEX)
}

fn clearcoat<'a>(material: &Entry<'a>, bsdf: Draft, textures: &mut Textures<'_, 'a>) -> Result<Draft, SceneError> {
    let Some(extension) = material.extension("KHR_materials_clearcoat")? else { return Ok(bsdf) };
    let factor = extension.number_within("clearcoatFactor", 0.0, 0.0, 1.0)?;
    if factor == 0.0 {
        return Ok(bsdf);
    }
    let texture = textures.read(&extension, "clearcoatTexture", Meaning::Channel("r"))?;
    let roughness = extension.number_within("clearcoatRoughnessFactor", 0.0, 0.0, 1.0)?;
    let mut report = |notice: Notice| textures.output.notices.add(notice);
    let explanation = "it reflects a quarter as much, and its roughness (squared) lies between 0.001 and 0.1";
    report(Notice::approximated(&extension.location(), "a clear coat", explanation));
    if extension.has("clearcoatRoughnessTexture") || extension.has("clearcoatNormalTexture") {
        let explanation = "the factors are used alone";
        report(Notice::ignored(
            &extension.location(),
            "a texture of the clear coat's roughness or normals",
            explanation,
        ));
    }
    // Mitsuba's coat has an alpha from 0.1 (gloss 0) to 0.001 (gloss 1).
    let gloss = ((0.1 - roughness * roughness) / 0.099).clamp(0.0, 1.0);
    let bsdf = Slot::product(texture, Value::Float(factor)).put(bsdf, "clearcoat");
    Ok(bsdf.with("clearcoat_gloss", Value::Float(gloss)))
}

fn bumps<'a>(material: &Entry<'a>, bsdf: Draft, textures: &mut Textures<'_, 'a>) -> Result<Draft, SceneError> {
    let Some(texture) = textures.read(material, "normalTexture", Meaning::Vectors)? else { return Ok(bsdf) };
    let scale = material.child("normalTexture")?.map(|info| info.number("scale")).transpose()?.flatten();
    let texture = match scale.unwrap_or(1.0) {
        1.0 => texture,
        scale if (0.0..1.0).contains(&scale) => {
            // x and y of the normal, of which the image holds (1 + x)/2, are scaled.
            let middle = 0.5 * (1.0 - scale);
            let scaled = Draft::new(PluginClass::Texture, "scale", &texture.location);
            let scaled = scaled.with_rgb("scale", [scale, scale, 1.0]).with_rgb("offset", [middle, middle, 0.0]);
            scaled.with_child("texture", texture)
        }
        scale if scale > 1.0 => {
            // The same direction: z is divided instead.
            let (share, middle) = (1.0 / scale, 0.5 * (1.0 - 1.0 / scale));
            let scaled = Draft::new(PluginClass::Texture, "scale", &texture.location);
            let scaled = scaled.with_rgb("scale", [1.0, 1.0, share]).with_rgb("offset", [0.0, 0.0, middle]);
            scaled.with_child("texture", texture)
        }
        _ => {
            let explanation = "the normals are used as they are";
            let subject = "the negative scale of a normal texture";
            textures.output.notices.add(Notice::ignored(&texture.location, subject, explanation));
            texture
        }
    };
    let map = Draft::new(PluginClass::Bsdf, "normalmap", &texture.location);
    Ok(map.with_child("normalmap", texture).with_child("", bsdf))
}

/// The `area` emitter of a material that shines.
fn light<'a>(material: &Entry<'a>, textures: &mut Textures<'_, 'a>) -> Result<Option<Draft>, SceneError> {
    let color = material.color("emissiveFactor", [0.0; 3])?;
    let strength = match material.extension("KHR_materials_emissive_strength")? {
        Some(extension) => extension.number_within("emissiveStrength", 1.0, 0.0, f64::INFINITY)?,
        None => 1.0,
    };
    let radiance = color.map(|channel| channel * strength);
    if radiance == [0.0; 3] {
        return Ok(None);
    }
    let texture = textures.read(material, "emissiveTexture", Meaning::Color)?;
    let emitter = Draft::new(PluginClass::Emitter, "area", &material.location());
    let emitter = if material.flag("doubleSided")? { emitter.with_flag("two_sided", true) } else { emitter };
    let emitter = Slot::product(texture, Value::Rgb(radiance)).put(emitter, "radiance");
    Ok(Some(emitter.in_light_group(super::lights::light_group(material)?)))
}

/// The `dielectric` of a material that is MDL's `thick_glass` (NV_materials_mdl). The parameters beside it are those of
/// a stand-in: transparent by alpha, without refraction.
fn thick_glass<'a>(material: &Entry<'a>, textures: &mut Textures<'_, 'a>) -> Result<Option<Draft>, SceneError> {
    let Some(extension) = material.extension("NV_materials_mdl")? else { return Ok(None) };
    let Some(shaders) = textures.input.document.root().extension("NV_materials_mdl")? else { return Ok(None) };
    let shaders = shaders.objects("shaders")?;
    let Some(shader) = extension.integer("mdl_shader")?.and_then(|index| shaders.get(index)) else { return Ok(None) };
    let definition = shader.text("definition")?.unwrap_or_default();
    let name = definition.rsplit("::").next().unwrap_or_default();
    if name.split('(').next() != Some("thick_glass") {
        if name != "gltf_material" {
            let notice = Notice::ignored(&material.location(), "an MDL shader", "the parameters of glTF are used");
            textures.output.notices.add(notice);
        }
        return Ok(None);
    }
    let index = shader.child("arguments")?.map_or(Ok(None), |arguments| arguments.number("ior"))?;
    let index = index.unwrap_or(DEFAULT_INDEX);
    let explanation = format!("a smooth clear dielectric of index {} takes its place", shown_number(index));
    textures.output.notices.add(Notice::approximated(&material.location(), "MDL's thick_glass", explanation));
    let glass = Draft::new(PluginClass::Bsdf, "dielectric", &material.location());
    Ok(Some(glass.with("int_ior", Value::Float(index))))
}
