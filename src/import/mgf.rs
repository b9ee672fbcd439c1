//! MGF, the Materials and Geometry Format, version 2 [Ward et al. 1997].
//!
//! A file is a list of entities, one a line. Some change what is current (color, material, vertex, transform), others make
//! surfaces of it. Every different material becomes a bsdf and a mesh of all polygons that have it. Lengths are meters;
//! photometric units are divided by 179 lm·W⁻¹, as Radiance does, so that the results of both agree; +z is up.
//! Whatever cannot be represented is in the notices.

mod bsdf;
mod color;
mod context;
mod material;
mod mesh;
mod placement;
mod polygon;
mod solids;
mod stage;
mod text;

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use glam::{DMat4, DVec3};

use super::draft::{Draft, Reading};
use super::substitution::refuse_defines;
use super::values::shown;
use crate::scene::bundle::{Bundle, Files};
use crate::scene::description::PluginClass;
use crate::scene::error::{Location, SceneError, nearest_name};
use crate::scene::notice::Notice;
use color::{Color, GREY};
use context::Contexts;
use material::{BLACK, Material};
use placement::Placement;
use solids::Solid;
use stage::{Placed, Stage, Vertex};
use text::{Entity, Text};

/// How deep files may include files.
const INCLUDE_DEPTH_LIMIT: usize = 32;
/// How many bytes of text a scene may have in all of its files.
const TEXT_LIMIT: usize = 256 << 20;
/// How many entities may be followed, counted anew in every copy of an array and every include.
const ENTITY_LIMIT: u64 = 10_000_000;
/// How many copies all arrays may make, counted anew in every copy of an array round them. They are written out, so this many
/// are refused before any is made.
const COPY_LIMIT: u64 = 100_000;
/// How deep transforms may nest.
const TRANSFORM_LIMIT: usize = 64;

const ENTITIES: [&str; 28] = [
    "i", "ies", "o", "xf", "c", "cxy", "cspec", "cct", "cmix", "m", "sides", "rd", "td", "ed", "rs", "ts", "ir", "v",
    "p", "n", "f", "fh", "sph", "cyl", "cone", "ring", "torus", "prism",
];

/// Whether a file is MGF, by its name or by its first entities.
pub(super) fn is_mgf(bytes: &[u8], name: &str) -> bool {
    const LOOKED_AT: usize = 5;
    if name.to_ascii_lowercase().ends_with(".mgf") {
        return true;
    }
    let start = Text::new(name, &bytes[..bytes.len().min(16_384)]);
    let mut entities = (0..LOOKED_AT).map_while(|index| start.entity(index)).peekable();
    // Wavefront OBJ files begin with some of the same letters: vertices have names here and numbers there.
    let known = |entity: Entity<'_>| {
        let vertex_of_obj = entity.keyword == "v" && entity.number(0).is_ok();
        ENTITIES.contains(&entity.keyword) && !vertex_of_obj
    };
    entities.peek().is_some() && entities.all(known)
}

/// Reads a scene file and everything that it includes from `bundle`. MGF has no parameters, so every define is an error.
pub(super) fn read(
    bytes: &[u8],
    location: &Location,
    bundle: &Bundle,
    defines: &[(String, String)],
) -> Result<(Reading, Files), SceneError> {
    refuse_defines(defines, location, "an MGF scene has no parameters: write the value into it")?;
    let mut reader = Reader::new(bundle);
    let text = Rc::new(Text::new(&location.file, bytes));
    reader.text_size = text.size();
    reader.open.push(text.name.clone());
    reader.follow_all(&text)?;
    let Reader { mut stage, includes, unknown, .. } = reader;
    for (name, (location, count)) in unknown {
        let subject = format!("entity {} ({count} times)", shown(&name));
        stage.notices.push(Notice::ignored(&location, subject, nearest_name(&name, &ENTITIES)));
    }
    let (root, generated, notices) = stage.finish(location);
    Ok((Reading { root, aliases: Vec::new(), includes, notices }, generated))
}

/// A transform that is in effect, with those round it.
struct Frame {
    placement: Placement,
    placed: Placed,
    /// The first entity inside.
    body: usize,
    location: Location,
}

struct Reader<'a> {
    bundle: &'a Bundle,
    texts: HashMap<String, Rc<Text>>,
    text_size: usize,
    /// The names of the files that are being read, innermost last.
    open: Vec<String>,
    includes: Vec<(String, Location)>,
    frames: Vec<Frame>,
    objects: u64,
    colors: Contexts<Color>,
    materials: Contexts<Material>,
    vertices: Contexts<Vertex>,
    stage: Stage,
    followed: u64,
    copies: u64,
    /// Unknown entities: where the first stands, and how many there are.
    unknown: BTreeMap<String, (Location, u64)>,
}

impl<'a> Reader<'a> {
    fn new(bundle: &'a Bundle) -> Self {
        Self {
            bundle,
            texts: HashMap::new(),
            text_size: 0,
            open: Vec::new(),
            includes: Vec::new(),
            frames: Vec::new(),
            objects: 0,
            colors: Contexts::new("color", GREY),
            materials: Contexts::new("material", BLACK),
            vertices: Contexts::new("vertex", Vertex { position: DVec3::ZERO, normal: DVec3::ZERO }),
            stage: Stage::new(),
            followed: 0,
            copies: 0,
            unknown: BTreeMap::new(),
        }
    }

    /// Follows the entities of one file. Transforms end in the file where they begin.
    fn follow_all(&mut self, text: &Text) -> Result<(), SceneError> {
        let outside = self.frames.len();
        let mut index = 0;
        while let Some(entity) = text.entity(index) {
            index += 1;
            self.count(&entity)?;
            match (entity.keyword, entity.words.is_empty()) {
                ("xf", false) => self.push_transform(&entity, 0, index)?,
                ("xf", true) if self.frames.len() <= outside => {
                    return Err(entity.error("no transform is open in this file", "remove this \"xf\""));
                }
                ("xf", true) => {
                    if let Some(body) = self.next_copy(&entity)? {
                        index = body;
                    }
                }
                _ => self.follow(&entity)?,
            }
        }
        match self.frames.get(outside) {
            Some(frame) => {
                let problem = "the file ends inside of this transform";
                Err(SceneError::new(
                    &frame.location,
                    problem,
                    "end it with \"xf\", or restore the file if it is cut off",
                ))
            }
            None => Ok(()),
        }
    }

    fn count(&mut self, entity: &Entity<'_>) -> Result<(), SceneError> {
        self.followed += 1;
        if self.followed <= ENTITY_LIMIT {
            return Ok(());
        }
        let problem = format!("arrays and includes make this more than {ENTITY_LIMIT} entities");
        Err(entity.error(problem, "make smaller arrays"))
    }

    fn follow(&mut self, entity: &Entity<'_>) -> Result<(), SceneError> {
        match entity.keyword {
            "c" => self.colors.select(entity),
            "cxy" | "cspec" | "cct" | "cmix" => self.set_color(entity),
            "m" => self.materials.select(entity),
            "sides" | "rd" | "td" | "ed" | "rs" | "ts" | "ir" => {
                let color = *self.colors.current();
                self.materials.current().set(entity, color)
            }
            "v" => self.vertices.select(entity),
            "p" => {
                entity.check_count(3, 3, "p x y z")?;
                self.vertices.current().position = entity.triple(0)?;
                Ok(())
            }
            "n" => {
                entity.check_count(3, 3, "n dx dy dz")?;
                self.vertices.current().normal = entity.triple(0)?.normalize_or_zero();
                Ok(())
            }
            "f" | "fh" | "sph" | "cyl" | "cone" | "ring" | "torus" | "prism" => self.add_surface(entity),
            "o" => self.object(entity),
            "i" => self.include(entity),
            "ies" => self.luminaire(entity),
            _ => self.unknown(entity),
        }
    }

    fn set_color(&mut self, entity: &Entity<'_>) -> Result<(), SceneError> {
        let color = match entity.keyword {
            "cxy" => {
                entity.check_count(2, 2, "cxy x y")?;
                Color::new(entity.amount(0)?, entity.amount(1)?)
            }
            "cct" => {
                entity.check_count(1, 1, "cct kelvin")?;
                Some(entity.number(0)?).filter(|kelvin| *kelvin >= 100.0).and_then(Color::from_temperature)
            }
            "cspec" => {
                entity.check_count(4, 4096, "cspec first_nanometer last_nanometer value1 value2 …")?;
                let (first, last) = (entity.amount(0)?, entity.amount(1)?);
                let values = (2..entity.words.len()).map(|at| entity.amount(at)).collect::<Result<Vec<_>, _>>()?;
                Some(last).filter(|last| *last > first).and_then(|last| Color::from_spectrum(first, last, &values))
            }
            _ => {
                entity.check_count(2, 4096, "cmix weight1 color1 weight2 color2 …")?;
                if entity.words.len() % 2 == 1 {
                    return Err(entity.error("the last weight has no color", "give weights and colors in turn"));
                }
                let part = |at: usize| Ok((entity.amount(at)?, self.colors.find(entity.word(at + 1), entity)?));
                let parts = (0..entity.words.len()).step_by(2).map(part).collect::<Result<Vec<_>, SceneError>>()?;
                Color::mix(&parts)
            }
        };
        let remedy = "give chromaticities with y above 0 and x + y up to 1, at least 100 K, or visible light in a spectrum or mixture";
        *self.colors.current() = color.ok_or_else(|| entity.error("no color has these numbers", remedy))?;
        Ok(())
    }

    fn placed(&self, entity: &Entity<'_>) -> Result<Placed, SceneError> {
        match self.frames.last() {
            Some(frame) => Ok(frame.placed),
            None => Placed::new(DMat4::IDENTITY).ok_or_else(|| entity.error("the transform is broken", "")),
        }
    }

    fn add_surface(&mut self, entity: &Entity<'_>) -> Result<(), SceneError> {
        let placed = self.placed(entity)?;
        let material = *self.materials.current();
        let surface = self.stage.surface(&material, self.materials.current_name(), entity)?;
        let (vertices, stage) = (&self.vertices, &mut self.stage);
        Solid { entity, vertices, placed: &placed, surface, stage }.add()
    }

    /// The names of objects change nothing.
    fn object(&mut self, entity: &Entity<'_>) -> Result<(), SceneError> {
        entity.check_count(0, 1, "o name, or o to end it")?;
        if !entity.words.is_empty() {
            self.objects += 1;
            return Ok(());
        }
        let problem = "no object is open";
        self.objects = self.objects.checked_sub(1).ok_or_else(|| entity.error(problem, "remove this \"o\""))?;
        Ok(())
    }

    /// Puts a transform, which `entity` has from argument `first` on, inside of those in effect.
    fn push_transform(&mut self, entity: &Entity<'_>, first: usize, body: usize) -> Result<(), SceneError> {
        if self.frames.len() >= TRANSFORM_LIMIT {
            let problem = format!("transforms nest more than {TRANSFORM_LIMIT} deep");
            return Err(entity.error(problem, "end them with \"xf\""));
        }
        let placement = Placement::read(entity, first)?;
        self.copies = self.copies.saturating_add(placement.copies() - 1);
        if self.copies > COPY_LIMIT {
            let problem = format!("the arrays make more than {COPY_LIMIT} copies");
            return Err(entity.error(problem, "make smaller arrays"));
        }
        let placed = self.inside(&placement, entity)?;
        self.frames.push(Frame { placement, placed, body, location: entity.location() });
        Ok(())
    }

    /// The total transform of `placement` inside of those in effect.
    fn inside(&self, placement: &Placement, entity: &Entity<'_>) -> Result<Placed, SceneError> {
        let outer = self.frames.last().map_or(DMat4::IDENTITY, |frame| frame.placed.matrix());
        Placed::new(outer * placement.matrix())
            .ok_or_else(|| entity.error("the transform makes things vanish or explode", "check its scales and counts"))
    }

    /// Goes on to the next copy of the innermost transform, and gives where it begins; or ends the transform.
    fn next_copy(&mut self, entity: &Entity<'_>) -> Result<Option<usize>, SceneError> {
        let Some(mut frame) = self.frames.pop() else { return Ok(None) };
        if !frame.placement.advance() {
            return Ok(None);
        }
        frame.placed = self.inside(&frame.placement, entity)?;
        let body = frame.body;
        self.frames.push(frame);
        Ok(Some(body))
    }

    fn include(&mut self, entity: &Entity<'_>) -> Result<(), SceneError> {
        entity.check_count(1, usize::MAX, "i file [transform]")?;
        let name = self.resolved(entity.word(0));
        if self.open.contains(&name) {
            return Err(entity.error(format!("file {} includes itself", shown(&name)), "remove one of the includes"));
        }
        if self.open.len() > INCLUDE_DEPTH_LIMIT {
            let problem = format!("files include files more than {INCLUDE_DEPTH_LIMIT} deep");
            return Err(entity.error(problem, "include them from the main file"));
        }
        let text = self.text(&name, entity)?;
        self.open.push(name);
        let transformed = entity.words.len() > 1;
        if transformed {
            self.push_transform(entity, 1, 0)?;
        }
        loop {
            self.count(entity)?;
            self.follow_all(&text)?;
            if !transformed || self.next_copy(entity)?.is_none() {
                break;
            }
        }
        self.open.pop();
        Ok(())
    }

    fn text(&mut self, name: &str, entity: &Entity<'_>) -> Result<Rc<Text>, SceneError> {
        if let Some(text) = self.texts.get(name) {
            return Ok(text.clone());
        }
        let bytes = self.bundle.read(name, &entity.location())?;
        self.text_size += bytes.len();
        if self.text_size > TEXT_LIMIT {
            return Err(entity.error("the scene has more than 256 MiB of text", "simplify it"));
        }
        let text = Rc::new(Text::new(name, &bytes));
        self.includes.push((name.to_owned(), entity.location()));
        self.texts.insert(name.to_owned(), text.clone());
        Ok(text)
    }

    /// File names are relative to the file that names them. What leads out of the bundle keeps its `..` and is refused.
    fn resolved(&self, name: &str) -> String {
        let folder = self.open.last().and_then(|file| file.rsplit_once('/')).map_or("", |(folder, _)| folder);
        let mut parts: Vec<&str> = folder.split('/').filter(|part| !part.is_empty()).collect();
        if name.starts_with('/') {
            return name.to_owned();
        }
        for part in name.split('/').filter(|part| !part.is_empty() && *part != ".") {
            if part == ".." && parts.last().is_some_and(|last| *last != "..") {
                parts.pop();
            } else {
                parts.push(part);
            }
        }
        parts.join("/")
    }

    /// A luminaire: a point light with the intensities of an IES file. There a profile's downward direction is -z; here
    /// an `ies` emitter sends it along its +z.
    fn luminaire(&mut self, entity: &Entity<'_>) -> Result<(), SceneError> {
        entity.check_count(1, usize::MAX, "ies file [-m factor] [transform]")?;
        let name = self.resolved(entity.word(0));
        let scaled = entity.word(1) == "-m";
        let factor = if scaled { entity.amount(2)? } else { 1.0 };
        self.push_transform(entity, if scaled { 3 } else { 1 }, 0)?;
        loop {
            self.count(entity)?;
            let upright = DMat4::from_scale(DVec3::new(1.0, -1.0, -1.0));
            let to_world = self.placed(entity)?.matrix() * upright;
            let light = Draft::new(PluginClass::Emitter, "ies", &entity.location());
            let light = light.with_text("filename", &name).with_transform("to_world", to_world);
            let light = if scaled { light.with_rgb("intensity", [factor; 3]) } else { light };
            self.stage.add(light, entity)?;
            if self.next_copy(entity)?.is_none() {
                return Ok(());
            }
        }
    }

    fn unknown(&mut self, entity: &Entity<'_>) -> Result<(), SceneError> {
        const LISTED: usize = 100;
        let name: String = entity.keyword.chars().take(40).collect();
        if self.unknown.len() >= LISTED && !self.unknown.contains_key(&name) {
            let problem = format!("more than {LISTED} kinds of entities are unknown");
            return Err(entity.error(problem, "make sure that this is an MGF file"));
        }
        self.unknown.entry(name).or_insert_with(|| (entity.location(), 0)).1 += 1;
        Ok(())
    }
}
