//! Shapes with what is current, and the objects that they make.

use super::super::draft::Draft;
use super::super::values::shown;
use super::attributes::Surface;
use super::light::AreaSource;
use super::shape::{self, Setting};
use super::text::Tokens;
use super::texture::ColorOrTexture;
use super::{Reader, material, named, string};
use crate::scene::description::PluginClass;
use crate::scene::error::{Location, SceneError, nearest_defined_name};

/// What stands between `ObjectBegin` and `ObjectEnd`.
pub(super) struct Object {
    pub id: String,
    pub location: Location,
    pub shapes: Vec<Draft>,
}

impl Reader<'_> {
    /// Follows `Shape`.
    pub(super) fn shape(&mut self, tokens: &mut Tokens<'_>, place: Location) -> Result<(), SceneError> {
        let (kind, parameters) = named(tokens, place)?;
        let place = &parameters.place;
        let Surface { material, light, reverse, media, .. } = self.attributes.current.clone();
        let opacity = self.textures.number(&parameters, "alpha")?;
        let textured = material.as_ref().is_some_and(|material| material.textured);
        let textured = textured || opacity.as_ref().is_some_and(ColorOrTexture::is_texture);
        let light = light.filter(|light| !light.is_black());
        let textured = textured || light.as_ref().is_some_and(AreaSource::is_textured);
        let setting = Setting { to_world: self.attributes.transform(), reverse, textured };
        let Some(mut shape) = shape::read(&kind, &parameters, &setting, &mut self.output)? else { return Ok(()) };
        shape = match (opacity.filter(|opacity| !opacity.is_one()), material) {
            (None, None) => shape,
            (None, Some(material)) => shape.with_reference(&material.id),
            (Some(opacity), material) => {
                let mask = opacity.put_number(Draft::new(PluginClass::Bsdf, "mask", place), "opacity");
                let mask = match material {
                    Some(material) => mask.with_reference(&material.id),
                    None => mask.with_child("", material::default(place)),
                };
                shape.with_child("", mask)
            }
        };
        shape = self.media.between(shape, &media);
        let object = self.object.as_ref().and_then(|name| self.objects.get_mut(name));
        match (light, object) {
            (Some(_), Some(object)) => {
                self.output.ignored(place, "an area light within an object", "its shape does not emit");
                object.shapes.push(shape);
            }
            (None, Some(object)) => object.shapes.push(shape),
            (None, None) => return self.output.add(shape),
            (Some(light), None) => {
                let emitter = light.on(&shape, &kind, &parameters, &mut self.output)?;
                return self.output.add(shape.with_child("", emitter));
            }
        }
        self.output.count_plugin(place).map(drop)
    }

    /// Follows the directives of objects.
    pub(super) fn object(
        &mut self,
        directive: &str,
        tokens: &mut Tokens<'_>,
        place: &Location,
    ) -> Result<(), SceneError> {
        let error = |problem: &str| Err(SceneError::new(place, problem, "end one object before the next begins"));
        if directive == "ObjectEnd" {
            return match self.object.take() {
                Some(_) => self.attributes.pop(place, directive),
                None => error("no object is open"),
            };
        }
        let name = string(tokens, place)?;
        if self.object.is_some() {
            return error("it stands within an object");
        }
        if directive == "ObjectInstance" {
            return self.instance(&name, place);
        }
        self.check_names(self.objects.len(), place)?;
        let id = format!("object-{}-{}", self.objects.len(), name.chars().take(80).collect::<String>());
        let object = Object { id, location: place.clone(), shapes: Vec::new() };
        if self.objects.insert(name.clone(), object).is_some() {
            return error(&format!("there are two objects {}", shown(&name)));
        }
        self.object = Some(name);
        self.attributes.push(place, "ObjectEnd")
    }

    fn instance(&mut self, name: &str, place: &Location) -> Result<(), SceneError> {
        let Some(object) = self.objects.get(name) else {
            let known: Vec<&str> = self.objects.keys().map(String::as_str).filter(|name| name.len() < 80).collect();
            let problem = format!("there is no object {}", shown(name));
            let remedy = nearest_defined_name(name, &known, "define it between ObjectBegin and ObjectEnd first");
            return Err(SceneError::new(place, problem, remedy));
        };
        if object.shapes.is_empty() {
            return Ok(());
        }
        let instance = Draft::new(PluginClass::Shape, "instance", place).with_reference(&object.id);
        self.output.add(instance.with_transform("to_world", self.attributes.transform()))
    }
}
