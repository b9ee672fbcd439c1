//! pbrt-v4 [Pharr, Jakob and Humphreys 2023].
//!
//! A file is a list of directives. Some change what is current (transform, material, area light), others make shapes and
//! lights of it. Meshes that stand in the text become meshes in memory. What is supported, approximated and refused
//! stands in `docs/SCENES.md`; whatever a scene loses is in its notices.

mod area_light;
mod attributes;
mod camera;
mod directives;
mod goniometric;
mod infinite;
mod light;
mod material;
mod medium;
mod mesh;
mod options;
mod output;
mod parameters;
mod placement;
mod shape;
mod spectrum;
mod text;
mod texture;

use std::collections::{BTreeMap, HashMap};

use glam::DMat4;

use super::compatibility;
use super::draft::{Draft, Reading};
use super::substitution::refuse_defines;
use super::values::shown;
use crate::scene::bundle::{Bundle, Generated};
use crate::scene::description::PluginClass;
use crate::scene::error::{Location, SceneError, nearest_name};
use attributes::{Attributes, inverse};
use material::Material;
use medium::Media;
use options::{Directive, Options};
use output::Output;
use parameters::Parameters;
use placement::Object;
use text::{Token, Tokens};
use texture::Textures;

pub(super) use directives::DIRECTIVES;

/// How deep files may include files.
const INCLUDE_DEPTH_LIMIT: usize = 32;
/// How many files may be included.
const INCLUDE_LIMIT: usize = 10_000;
/// How many bytes of text a scene may have, counted anew in every include.
const TEXT_LIMIT: usize = 256 << 20;
/// How many things a scene may name: materials, objects, coordinate systems.
const NAME_LIMIT: usize = 65_536;

/// Whether a file is pbrt's, by its name or by its first directive.
pub(super) fn is_pbrt(bytes: &[u8], name: &str) -> bool {
    if name.to_ascii_lowercase().ends_with(".pbrt") {
        return true;
    }
    let start = String::from_utf8_lossy(&bytes[..bytes.len().min(65_536)]);
    let first = Tokens::new(name, &start).next();
    matches!(first, Ok(Some(Token::Word(word))) if word == "WorldBegin" || compatibility::has(DIRECTIVES, word))
}

/// Reads a scene file and everything that it includes from `bundle`. pbrt has no parameters, so every define is an error.
///
/// # Errors
/// On malformed text, with file, line and directive; on what would make another picture if it were left out.
pub(super) fn read(
    bytes: &[u8],
    location: &Location,
    bundle: &Bundle,
    defines: &[(String, String)],
    moment: Option<f64>,
) -> Result<(Reading, Generated), SceneError> {
    refuse_defines(defines, location, "a pbrt scene has no parameters: write the value into it")?;
    let mut reader = Reader::new(bundle, moment);
    reader.follow_text(bytes, location)?;
    if reader.attributes.depth() > 0 {
        let problem = "the file ends before an AttributeBegin, TransformBegin or ObjectBegin does";
        return Err(SceneError::new(location, problem, "make sure that the file is complete"));
    }
    let Reader { mut output, options, objects, media, attributes, .. } = reader;
    let plugins = options.plugins(location, media.used, &mut output)?;
    for (name, Object { id, location, shapes }) in objects {
        let group = Draft { id, ..Draft::new(PluginClass::Shape, "shapegroup", &location).called(&name) };
        let group = shapes.into_iter().fold(group, |group, shape| group.with_child("", shape));
        if !group.children.is_empty() {
            output.plugins.push(group);
        }
    }
    output.drop_unused();
    let scene = Draft::new(PluginClass::Scene, "scene", location);
    let children = plugins.into_iter().chain(output.plugins);
    let root = children.fold(scene, |scene, plugin| scene.with_child("", plugin));
    let (includes, notices) = (output.includes, output.notices.into_list());
    let moves = attributes.moves.then_some(attributes.times);
    Ok((Reading { root, aliases: Vec::new(), includes, notices, moves }, output.made))
}

struct Reader<'a> {
    output: Output<'a>,
    options: Options,
    attributes: Attributes,
    /// Whether no moment of a motion was asked for.
    is_still: bool,
    textures: Textures,
    materials: HashMap<String, Material>,
    media: Media,
    systems: HashMap<String, [DMat4; 2]>,
    objects: BTreeMap<String, Object>,
    /// The object that is being made.
    object: Option<String>,
    in_world: bool,
    /// How many files are open, how many were, and the bytes of all their text.
    open: usize,
    included: usize,
    text_size: usize,
}

impl<'a> Reader<'a> {
    fn new(bundle: &'a Bundle, moment: Option<f64>) -> Self {
        Self {
            output: Output::new(bundle),
            options: Options::default(),
            attributes: Attributes::new(moment),
            is_still: moment.is_none(),
            textures: Textures::default(),
            materials: HashMap::new(),
            media: Media::default(),
            systems: HashMap::new(),
            objects: BTreeMap::new(),
            object: None,
            in_world: false,
            open: 0,
            included: 0,
            text_size: 0,
        }
    }

    fn follow_text(&mut self, bytes: &[u8], location: &Location) -> Result<(), SceneError> {
        self.text_size = self.text_size.saturating_add(bytes.len());
        if self.text_size > TEXT_LIMIT {
            return Err(SceneError::new(location, "the scene has more than 256 MiB of text", "use PLY files"));
        }
        let text = String::from_utf8_lossy(bytes);
        let mut tokens = Tokens::new(&location.file, &text);
        loop {
            let mut place = tokens.place("");
            match tokens.next()? {
                None => return Ok(()),
                Some(Token::Word(directive)) => {
                    place.path = directive.chars().take(40).collect();
                    self.follow(directive, &mut tokens, place)?;
                }
                Some(other) => {
                    let problem = format!("{} stands where a directive is expected", other.shown());
                    return Err(SceneError::new(&place, problem, "check the lines before it"));
                }
            }
        }
    }

    fn follow(&mut self, directive: &str, tokens: &mut Tokens<'_>, place: Location) -> Result<(), SceneError> {
        if self.attributes.follow(directive, tokens, &place)? {
            return Ok(());
        }
        match directive {
            "WorldBegin" => {
                self.in_world = true;
                self.attributes.begin_world();
                self.systems.insert("world".to_owned(), [DMat4::IDENTITY; 2]);
                Ok(())
            }
            "Include" | "Import" => self.include(directive, tokens, &place),
            "CoordinateSystem" => {
                let name = string(tokens, &place)?;
                self.check_names(self.systems.len(), &place)?;
                self.systems.insert(name, self.attributes.transforms());
                Ok(())
            }
            "CoordSysTransform" => {
                let name = string(tokens, &place)?;
                let system = self.systems.get(&name).copied();
                // pbrt warns and goes on, which moves what follows.
                let unknown = || SceneError::new(&place, format!("there is no coordinate system {}", shown(&name)), "");
                self.attributes.set_transforms(system.ok_or_else(unknown)?);
                Ok(())
            }
            "TransformTimes" => {
                self.attributes.times = attributes::numbers(tokens, &place)?;
                if self.attributes.times[0] >= self.attributes.times[1] {
                    return Err(SceneError::new(&place, "the motion ends before it starts", "write start and end"));
                }
                if self.is_still {
                    let instead =
                        "everything stands where it is at the first; --time shows a moment between, --frames all";
                    self.output.approximated(&place, "the motion between two keyframes", instead);
                }
                Ok(())
            }
            "Camera" | "Film" | "PixelFilter" | "Integrator" => self.option(directive, tokens, place),
            "Sampler" | "Accelerator" | "Option" | "ColorSpace" => self.pass_over(directive, tokens, place),
            "Attribute" => {
                string(tokens, &place)?;
                self.output.ignored(&place, directive, "its parameters count at each directive only");
                Parameters::read(tokens, place).map(drop)
            }
            "MakeNamedMedium" => {
                let (name, parameters) = named(tokens, place)?;
                self.check_names(self.media.len(), &parameters.place)?;
                self.media.make(&name, &parameters, &mut self.output)
            }
            "MediumInterface" => {
                let inside = string(tokens, &place)?;
                let outside = tokens.next_if_quoted()?.unwrap_or_else(|| inside.clone());
                let media = [self.media.find(&inside, &place)?, self.media.find(&outside, &place)?];
                if self.options.has_method("sppm") && media != [None, None] {
                    self.output.ignored(&place, directive, "\"sppm\" passes through media");
                } else {
                    self.attributes.current.media = media;
                }
                Ok(())
            }
            "Material" | "MakeNamedMaterial" | "NamedMaterial" => self.material(directive, tokens, place),
            "Texture" => {
                let names = [string(tokens, &place)?, string(tokens, &place)?, string(tokens, &place)?];
                let parameters = Parameters::read(tokens, place)?;
                self.textures.define(names.each_ref().map(String::as_str), &parameters, &mut self.output)
            }
            "AreaLightSource" => {
                let (kind, parameters) = named(tokens, place)?;
                self.attributes.current.light = Some(light::area(&kind, &parameters, &mut self.output)?);
                Ok(())
            }
            "LightSource" => {
                let (kind, parameters) = named(tokens, place)?;
                light::other(&kind, &parameters, self.attributes.transform(), &mut self.output)
            }
            "Shape" => self.shape(tokens, place),
            "ObjectBegin" | "ObjectEnd" | "ObjectInstance" => self.object(directive, tokens, &place),
            _ => {
                let problem = format!("there is no directive {}", shown(directive));
                Err(SceneError::new(&place, problem, nearest_name(directive, &compatibility::names(DIRECTIVES))))
            }
        }
    }

    fn check_names(&self, count: usize, place: &Location) -> Result<(), SceneError> {
        if count < NAME_LIMIT {
            return Ok(());
        }
        Err(SceneError::new(place, format!("the scene names more than {NAME_LIMIT} of these"), "use them again"))
    }

    /// File names are relative to the main file, wherever they stand.
    fn include(&mut self, directive: &str, tokens: &mut Tokens<'_>, place: &Location) -> Result<(), SceneError> {
        let name = string(tokens, place)?;
        self.included += 1;
        if self.open >= INCLUDE_DEPTH_LIMIT || self.included > INCLUDE_LIMIT {
            let problem = format!(
                "files include files more than {INCLUDE_DEPTH_LIMIT} deep, or more than {INCLUDE_LIMIT} of them"
            );
            return Err(SceneError::new(place, problem, "make sure that no file includes itself"));
        }
        let content = self.output.read(&name, place)?;
        if !self.output.includes.iter().any(|(known, _)| *known == name) {
            self.output.includes.push((name.clone(), place.clone()));
        }
        let outside = self.attributes.current.clone();
        self.open += 1;
        self.follow_text(&content, &Location { file: name, ..Location::default() })?;
        self.open -= 1;
        if directive == "Import" {
            self.attributes.current = outside;
        }
        Ok(())
    }

    fn option(&mut self, directive: &str, tokens: &mut Tokens<'_>, place: Location) -> Result<(), SceneError> {
        let (name, parameters) = named(tokens, place)?;
        if self.in_world {
            return Err(SceneError::new(&parameters.place, "it stands after WorldBegin", "move it before WorldBegin"));
        }
        let transforms = self.attributes.transforms();
        let option = Some(Directive { name, parameters });
        match directive {
            "Film" => self.options.film = option,
            "PixelFilter" => self.options.filter = option,
            "Integrator" => self.options.integrator = option,
            _ => {
                self.systems.insert("camera".to_owned(), transforms.map(inverse));
                let transform = self.attributes.camera_transform();
                self.options.camera = option.map(|camera| (camera, transform));
                self.options.camera_medium = self.attributes.current.media[1].clone();
            }
        }
        Ok(())
    }

    /// Directives that choose how pbrt computes.
    fn pass_over(&mut self, directive: &str, tokens: &mut Tokens<'_>, place: Location) -> Result<(), SceneError> {
        if directive == "ColorSpace" {
            let space = string(tokens, &place)?;
            if space != "srgb" {
                self.output.approximated(&place, format!("the color space {}", shown(&space)), "rgb is linear sRGB");
            }
            return Ok(());
        }
        string(tokens, &place)?;
        if directive == "Option" {
            return self.pass_over_value(tokens, &place);
        }
        Parameters::read(tokens, place).map(drop)
    }

    /// The value of an option: one token, or several in brackets.
    fn pass_over_value(&mut self, tokens: &mut Tokens<'_>, place: &Location) -> Result<(), SceneError> {
        let missing = || SceneError::new(place, "the option has no value", "write a name and a value");
        if !tokens.next_if_open() {
            return tokens.next()?.map(drop).ok_or_else(missing);
        }
        while tokens.next()?.ok_or_else(missing)? != Token::Close {}
        Ok(())
    }

    fn material(&mut self, directive: &str, tokens: &mut Tokens<'_>, place: Location) -> Result<(), SceneError> {
        let (name, parameters) = named(tokens, place)?;
        let Self { textures, materials, output, .. } = self;
        match directive {
            "NamedMaterial" => {
                let material = material::find(materials, &name, &parameters)?;
                self.attributes.current.material = Some(material.clone());
            }
            "Material" => {
                let material = material::read(&name, &name, &parameters, textures, materials, output)?;
                self.attributes.current.material = Some(material);
            }
            _ => {
                let Some(kind) = parameters.text("type")? else {
                    return Err(SceneError::new(
                        &parameters.place,
                        "the material has no \"type\"",
                        "add \"string type\"",
                    ));
                };
                let material = material::read(kind, &name, &parameters, textures, materials, output)?;
                if materials.insert(name.clone(), material).is_some() {
                    let problem = format!("there are two materials {}", shown(&name));
                    return Err(SceneError::new(&parameters.place, problem, "give each a name of its own"));
                }
            }
        }
        Ok(())
    }
}

/// The string that must come next.
fn string(tokens: &mut Tokens<'_>, place: &Location) -> Result<String, SceneError> {
    tokens.next_if_quoted()?.ok_or_else(|| SceneError::new(place, "a string is missing", "write a name in quotes"))
}

/// A string and the parameters after it.
fn named(tokens: &mut Tokens<'_>, place: Location) -> Result<(String, Parameters), SceneError> {
    Ok((string(tokens, &place)?, Parameters::read(tokens, place)?))
}
