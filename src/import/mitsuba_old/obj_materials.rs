//! The materials of OBJ files, which Mitsuba 0.6 takes from the `.mtl` files beside them, or from bsdfs of the shape that have
//! the materials' names.
//!
//! A shape with such materials becomes one for each of them, with `material`. A bsdf without a name is that of the whole shape.

use std::collections::{BTreeMap, BTreeSet};

use super::super::draft::{Draft, DraftChild, Reading, Target};
use crate::scene::bundle::Bundle;
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::Location;
use crate::scene::geometry::obj::{lines, material_name};
use crate::scene::notice::Notice;

/// The most materials that one file is split by.
const MOST_MATERIALS: usize = 10_000;

/// Splits the OBJ shapes of a scene by their materials.
pub(super) fn split(reading: &mut Reading, bundle: &Bundle) {
    let Reading { root, includes, notices, .. } = reading;
    split_in(root, &mut Splitter { bundle, includes, notices });
}

fn split_in(parent: &mut Draft, splitter: &mut Splitter<'_>) {
    for child in std::mem::take(&mut parent.children) {
        match child.target {
            Target::Plugin(mut shape) if shape.class == PluginClass::Shape => {
                split_in(&mut shape, splitter);
                // A shape that something refers to stays one.
                let parts = if shape.plugin == "obj" && shape.id.is_empty() { splitter.parts(&shape) } else { None };
                let keep = |shape: Draft| DraftChild {
                    name: child.name.clone(),
                    location: child.location.clone(),
                    target: Target::Plugin(shape),
                };
                parent.children.extend(parts.unwrap_or_else(|| vec![shape]).into_iter().map(keep));
            }
            _ => parent.children.push(child),
        }
    }
}

struct Splitter<'a> {
    bundle: &'a Bundle,
    includes: &'a mut Vec<(String, Location)>,
    notices: &'a mut Vec<Notice>,
}

/// What an OBJ file says of materials.
#[derive(Default)]
struct Used {
    libraries: Vec<String>,
    /// In the order of their first faces; the empty name is that of faces before any.
    materials: Vec<String>,
}

impl Splitter<'_> {
    /// The shapes that take the place of one; nothing where it stays as it is.
    fn parts(&mut self, shape: &Draft) -> Option<Vec<Draft>> {
        let is_material = |child: &DraftChild| match &child.target {
            Target::Plugin(plugin) => plugin.class == PluginClass::Bsdf,
            Target::Reference(_) => true,
        };
        if shape.children.iter().any(|child| is_material(child) && child.name.is_empty()) {
            return None;
        }
        let name = shape.parameters.iter().find_map(|parameter| match (&parameter.value, parameter.name.as_str()) {
            (Value::String(name), "filename") => Some(name.clone()),
            _ => None,
        })?;
        // What cannot be read is told where the mesh itself is read.
        let used = used(&self.bundle.read(&name, &shape.location).ok()?);
        let folder = name.rsplit_once('/').map_or(String::new(), |(folder, _)| format!("{folder}/"));
        let named: BTreeSet<&str> = shape.children.iter().map(|child| child.name.as_str()).collect();
        if used.materials.iter().all(|material| named.contains(material.as_str())) && used.materials.len() == 1 {
            return Some(vec![self.part(shape, None, &BTreeMap::new(), &used.materials[0])]);
        }
        let library = self.library(&used, &folder, shape);
        let is_known = |material: &String| library.contains_key(material) || named.contains(material.as_str());
        if !used.materials.iter().any(is_known) {
            return None;
        }
        Some(used.materials.iter().map(|material| self.part(shape, Some(material), &library, material)).collect())
    }

    /// The shape with the faces of one material, or all of its faces, and with that material.
    fn part(&self, shape: &Draft, only: Option<&String>, library: &BTreeMap<String, Draft>, material: &str) -> Draft {
        let is_own = |child: &DraftChild| !child.name.is_empty() && child.name == material;
        let mut part = shape.clone();
        part.children.retain(|child| child.name.is_empty() || is_own(child));
        part.children.iter_mut().for_each(|child| child.name.clear());
        if let Some(bsdf) = library.get(material).filter(|_| !shape.children.iter().any(is_own)) {
            part = part.with_child("", bsdf.clone());
        }
        match only {
            Some(name) => part.with_text("material", name),
            None => part,
        }
    }

    /// The materials of all libraries that a file names.
    fn library(&mut self, used: &Used, folder: &str, shape: &Draft) -> BTreeMap<String, Draft> {
        let mut library = BTreeMap::new();
        for name in &used.libraries {
            let path = format!("{folder}{name}");
            match self.bundle.read(&path, &shape.location) {
                Ok(content) => {
                    read_library(&content, folder, shape, &mut library);
                    self.includes.push((path, shape.location.clone()));
                }
                Err(_) => {
                    let subject = format!("the material library \"{}\"", name.chars().take(80).collect::<String>());
                    let explanation = "it is not there: its materials are left out";
                    self.notices.push(Notice::ignored(&shape.location, subject, explanation));
                }
            }
        }
        library
    }
}

fn used(bytes: &[u8]) -> Used {
    let mut used = Used::default();
    let (mut current, mut seen) = (String::new(), BTreeSet::new());
    for (_, line) in lines(bytes) {
        let mut words = line.split(u8::is_ascii_whitespace).filter(|word| !word.is_empty());
        match words.next() {
            Some(b"usemtl") => current = material_name(&line),
            Some(b"mtllib") => used.libraries.push(material_name(&line).replace('\\', "/")),
            Some(b"f" | b"fo") if seen.len() < MOST_MATERIALS && !seen.contains(&current) => {
                seen.insert(current.clone());
                used.materials.push(current.clone());
            }
            _ => {}
        }
    }
    used
}

/// One material as the file gives it.
#[derive(Default)]
struct Entry {
    diffuse: Option<[f64; 3]>,
    diffuse_map: Option<String>,
    specular: [f64; 3],
    exponent: f64,
    opacity: Option<f64>,
    bump_map: Option<String>,
    model: i64,
}

/// Adds the materials of a library as bsdfs of Mitsuba 0.6.
fn read_library(bytes: &[u8], folder: &str, shape: &Draft, library: &mut BTreeMap<String, Draft>) {
    let (mut name, mut entry) = (None, Entry::default());
    let mut finish = |name: &mut Option<String>, entry: &mut Entry| {
        if let Some(name) = name.take() {
            library.insert(name, std::mem::take(entry).bsdf(&shape.location));
        }
    };
    for (_, line) in lines(bytes) {
        let text = String::from_utf8_lossy(&line);
        let words: Vec<&str> = text.split_whitespace().collect();
        let [keyword, rest @ ..] = words.as_slice() else { continue };
        let number = || rest.first().and_then(|word| word.parse::<f64>().ok()).filter(|number| number.is_finite());
        let color = || {
            let numbers: Vec<f64> = rest.iter().map_while(|word| word.parse().ok()).collect();
            match numbers[..] {
                [grey] => Some([grey; 3]),
                [red, green, blue, ..] => Some([red, green, blue]),
                _ => None,
            }
        };
        let share = || color().map(|color: [f64; 3]| color.map(|channel| channel.clamp(0.0, 1.0)));
        // Options stand before the name.
        let file = || rest.last().map(|name| format!("{folder}{}", name.replace('\\', "/")));
        match *keyword {
            "newmtl" => {
                finish(&mut name, &mut entry);
                name = Some(material_name(&line));
            }
            "Kd" => entry.diffuse = share(),
            "Ks" => entry.specular = share().unwrap_or_default(),
            "Ns" => entry.exponent = number().unwrap_or_default(),
            "d" => entry.opacity = number(),
            "Tr" => entry.opacity = number().map(|transparency| 1.0 - transparency),
            "illum" => entry.model = number().unwrap_or_default() as i64,
            "map_Kd" => entry.diffuse_map = file(),
            "bump" | "map_bump" | "map_Bump" => entry.bump_map = file(),
            _ => {}
        }
    }
    finish(&mut name, &mut entry);
}

impl Entry {
    fn bsdf(self, location: &Location) -> Draft {
        let plugin = |name: &str| Draft::new(PluginClass::Bsdf, name, location);
        let image = |name: &str| Draft::new(PluginClass::Texture, "bitmap", location).with_text("filename", name);
        let colored = |draft: Draft, slot: &str| match &self.diffuse_map {
            Some(name) => draft.with_child(slot, image(name)),
            None => draft.with_rgb(slot, self.diffuse.unwrap_or([0.5; 3])),
        };
        let is_glossy = self.specular != [0.0; 3] && self.exponent > 0.0;
        let bsdf = match self.model {
            2 if is_glossy => colored(plugin("phong"), "diffuseReflectance")
                .with_rgb("specularReflectance", self.specular)
                .with_float("exponent", self.exponent),
            4 | 6 | 7 | 9 => plugin("dielectric"),
            5 | 8 => plugin("conductor"),
            _ => colored(plugin("diffuse"), "reflectance"),
        };
        let bsdf = match &self.bump_map {
            Some(name) => plugin("bumpmap").with_child("", image(name)).with_child("", bsdf),
            None => bsdf,
        };
        match self.opacity.map(|opacity| opacity.clamp(0.0, 1.0)) {
            Some(opacity) if opacity < 1.0 => plugin("mask").with_float("opacity", opacity).with_child("", bsdf),
            _ => bsdf,
        }
    }
}
