//! Reading parameters that may be textures; images and textures that are used several times are kept once.

use std::collections::HashMap;
use std::sync::Arc;

use super::{MeshAttribute, Raster, Texture, image_file, number_of};
use crate::math::Rgb;
use crate::scene::bundle::Bundle;
use crate::scene::description::{Node, PluginClass};
use crate::scene::error::{SceneError, shown_numbers};
use crate::scene::fields::Fields;

/// The most memory that all images of a scene may take, bytes.
const MOST_BYTES: u64 = 2 << 30;

/// What of an image file is wanted.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub(super) struct ImageChoice {
    /// Integers stand for themselves, else they are sRGB.
    pub(super) raw: bool,
    /// One channel: 0 to 3 for red, green, blue, alpha; all colors when `None`.
    pub(super) channel: Option<usize>,
}

/// Reads parameters that may be textures, and keeps what several of them share.
pub struct TextureReader<'a> {
    /// The scene's files.
    bundle: &'a Bundle,
    images: HashMap<(String, ImageChoice), Arc<Raster>>,
    /// Textures by the address of their node, so that shared nodes become one texture.
    texture_of_node: HashMap<*const Node, Texture>,
    /// Memory of all images, bytes.
    bytes: u64,
    /// How often texture coordinates, or tangents along them, were asked for.
    coordinates_asked: usize,
    /// How often partial derivatives of places by texture coordinates were asked for.
    partials_asked: usize,
    /// Whether any material turns normals.
    normals_turned: bool,
    /// The attributes of the shape that is being read.
    attributes: Option<Vec<MeshAttribute>>,
    /// How often attributes of shapes were asked for.
    attributes_asked: usize,
}

impl<'a> TextureReader<'a> {
    /// A reader for a scene with these files.
    pub fn new(bundle: &'a Bundle) -> Self {
        let (images, texture_of_node) = (HashMap::new(), HashMap::new());
        Self {
            bundle,
            images,
            texture_of_node,
            bytes: 0,
            coordinates_asked: 0,
            partials_asked: 0,
            normals_turned: false,
            attributes: None,
            attributes_asked: 0,
        }
    }

    /// How often texture coordinates were asked for so far: what was read in between needs them when this has grown.
    pub fn coordinates_asked(&self) -> usize {
        self.coordinates_asked
    }

    /// Asks for a frame along ∂p/∂u, for materials that are not the same all round; textures ask by themselves.
    pub fn ask_for_tangents(&mut self) {
        self.coordinates_asked += 1;
    }

    /// How often partial derivatives were asked for so far, as [`TextureReader::coordinates_asked`].
    pub fn partials_asked(&self) -> usize {
        self.partials_asked
    }

    /// Asks for ∂p/∂u and ∂p/∂v, for displacements.
    pub fn ask_for_partials(&mut self) {
        self.partials_asked += 1;
    }

    /// Asks for a frame along ∂p/∂u, in which normals are turned.
    pub fn ask_for_turned_normals(&mut self) {
        self.ask_for_tangents();
        self.normals_turned = true;
    }

    /// Whether a material turns normals.
    pub fn turns_normals(&self) -> bool {
        self.normals_turned
    }

    /// Tells of the shape to which the next materials and textures belong, by its attributes; `None` for those of no shape.
    pub fn set_shape(&mut self, attributes: Option<Vec<MeshAttribute>>) {
        self.attributes = attributes;
    }

    /// Whether what is read belongs to a shape.
    pub fn is_in_shape(&self) -> bool {
        self.attributes.is_some()
    }

    /// The attributes of the shape; `None` where what is read belongs to no shape.
    pub(super) fn ask_for_attributes(&mut self) -> Option<&[MeshAttribute]> {
        self.attributes_asked += 1;
        self.attributes.as_deref()
    }

    /// How often attributes were asked for so far: what was read in between is of one shape alone when this has grown.
    pub fn attributes_asked(&self) -> usize {
        self.attributes_asked
    }

    /// A share of light within [0, 1] (more would make energy); `default` where it was not given.
    pub fn share(&mut self, fields: &mut Fields<'_>, name: &'static str, default: f32) -> Result<Texture, SceneError> {
        let texture = self.color(fields, name)?.unwrap_or(Texture::grey(default));
        let [_, largest] = texture.range();
        if largest.max_element() > 1.0 {
            let (what, remedy) = match texture {
                Texture::Constant(_) => ("is", "give numbers from 0 to 1"),
                _ => ("goes up to", "scale it to 0 to 1"),
            };
            let Rgb { x, y, z } = largest;
            let problem = format!("\"{name}\" {what} {}: it would reflect more than arrives", shown_numbers([x, y, z]));
            return Err(fields.error(name, problem, remedy));
        }
        Ok(texture)
    }

    /// A color of at least 0; `None` where it was not given.
    pub fn color(&mut self, fields: &mut Fields<'_>, name: &'static str) -> Result<Option<Texture>, SceneError> {
        let Some(texture) = self.nested(fields, name)? else {
            let rgb = fields.rgb(name)?;
            return Ok(rgb.map(|rgb| Texture::Constant(Rgb::from_array(rgb.map(|channel| channel as f32)))));
        };
        let [smallest, _] = texture.range();
        if smallest.min_element() < 0.0 {
            let Rgb { x, y, z } = smallest;
            let problem = format!("\"{name}\" goes down to {}", shown_numbers([x, y, z]));
            return Err(fields.error(name, problem, "replace the image's negative values"));
        }
        Ok(Some(texture))
    }

    /// A number, or the luminance of a color; `None` where it was not given. Its range ([`Texture::range`]) is for the caller
    /// to check.
    pub fn number(&mut self, fields: &mut Fields<'_>, name: &'static str) -> Result<Option<Texture>, SceneError> {
        match self.nested(fields, name)? {
            Some(texture) => Ok(Some(texture)),
            None if fields.is_rgb(name) => {
                let rgb = fields.rgb(name)?.map(|rgb| Rgb::from_array(rgb.map(|channel| channel as f32)));
                Ok(rgb.map(|rgb| Texture::grey(number_of(rgb))))
            }
            None => Ok(fields.float(name)?.map(|number| Texture::grey(number as f32))),
        }
    }

    /// The texture that is nested in slot `name`.
    fn nested(&mut self, fields: &mut Fields<'_>, name: &'static str) -> Result<Option<Texture>, SceneError> {
        let Some(node) = fields.named_child(PluginClass::Texture, name) else { return Ok(None) };
        if fields.has(name) {
            let problem = format!("\"{name}\" is given as a value and as a texture");
            return Err(fields.error(name, problem, "remove one of them"));
        }
        self.texture(node).map(Some)
    }

    /// Reads a texture node.
    pub fn texture(&mut self, node: &Arc<Node>) -> Result<Texture, SceneError> {
        let address = Arc::as_ptr(node);
        let texture = match self.texture_of_node.get(&address) {
            Some(texture) => texture.clone(),
            None => {
                let asked = self.attributes_asked;
                let mut fields = Fields::new(node);
                let texture = super::read_plugin(&mut fields, self)?;
                fields.finish()?;
                if self.attributes_asked == asked {
                    self.texture_of_node.insert(address, texture.clone());
                }
                texture
            }
        };
        self.coordinates_asked += usize::from(texture.varies());
        Ok(texture)
    }

    /// The image that the plugin's `filename` names.
    pub(super) fn image(&mut self, fields: &mut Fields<'_>, choice: ImageChoice) -> Result<Arc<Raster>, SceneError> {
        let Some(name) = fields.string("filename")? else {
            let problem = format!("\"{}\" has no \"filename\"", fields.node().plugin);
            return Err(SceneError::new(fields.location(), problem, "name the image file"));
        };
        let key = (name.to_owned(), choice);
        if let Some(raster) = self.images.get(&key) {
            return Ok(raster.clone());
        }
        let bytes = self.bundle.read(name, fields.location_of("filename"))?;
        let raster = image_file::decode(&bytes, name, choice)
            .map_err(|(problem, remedy)| fields.error("filename", format!("image \"{name}\": {problem}"), remedy))?;
        self.bytes += raster.bytes();
        if self.bytes > MOST_BYTES {
            let problem = format!("the scene's images take more than {} GiB of memory", MOST_BYTES >> 30);
            return Err(fields.error("filename", problem, "make some of them smaller"));
        }
        let raster = Arc::new(raster);
        self.images.insert(key, raster.clone());
        Ok(raster)
    }

    /// The colors of the image that the plugin's `filename` names, none of them negative.
    pub fn colors(&mut self, fields: &mut Fields<'_>) -> Result<Arc<Raster>, SceneError> {
        let raster = self.image(fields, ImageChoice { raw: false, channel: None })?;
        match raster.range()[0].min_element() < 0.0 {
            false => Ok(raster),
            true => {
                let problem = "the image has negative values";
                Err(fields.error("filename", problem, "replace them: light cannot be negative"))
            }
        }
    }
}
