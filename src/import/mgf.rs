//! MGF, the Materials and Geometry Format, version 2 [Ward et al. 1997].
//!
//! A file is a list of entities, one a line. Some change what is current (color, material, vertex, transform), others make
//! surfaces of it. Every different material becomes a bsdf and a mesh of all polygons that have it. Lengths are meters;
//! photometric units are divided by 179 lm·W⁻¹, as Radiance does, so that the results of both agree; +z is up.
//! Whatever cannot be represented is in the notices.

mod array;
mod bsdf;
mod color;
mod color_entities;
mod context;
mod entities;
mod luminaire;
mod material;
mod mesh;
mod placement;
mod polygon;
mod solids;
mod stage;
mod text;
mod view;

use std::collections::{BTreeMap, HashMap};
use std::rc::Rc;

use glam::{DMat4, DVec3};

use super::compatibility;
use super::draft::Reading;
use super::substitution::refuse_defines;
use super::values::shown;
use crate::scene::bundle::{Bundle, Generated};
use crate::scene::error::{Location, SceneError, nearest_name};
use crate::scene::notice::Notice;
use array::{Copies, Mark};
use color::{Color, GREY};
use context::Contexts;
use material::{BLACK, Material};
use placement::Placement;
use solids::Solid;
use stage::{Placed, Stage, Vertex};
use text::{Entity, Text};

pub(super) use entities::ENTITIES;

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
        compatibility::has(ENTITIES, entity.keyword) && !vertex_of_obj
    };
    entities.peek().is_some() && entities.all(known)
}

/// Reads a scene file and everything that it includes from `bundle`. MGF has no parameters, so every define is an error.
pub(super) fn read(
    bytes: &[u8],
    location: &Location,
    bundle: &Bundle,
    defines: &[(String, String)],
) -> Result<(Reading, Generated), SceneError> {
    refuse_defines(defines, location, "an MGF scene has no parameters: write the value into it")?;
    let mut reader = Reader::new(bundle);
    let text = Rc::new(Text::new(&location.file, bytes));
    reader.text_size = text.size();
    reader.open.push(text.name.clone());
    reader.follow_all(&text)?;
    let Reader { mut stage, includes, unknown, .. } = reader;
    for (name, (location, count)) in unknown {
        let subject = format!("entity {} ({count} times)", shown(&name));
        stage.notices.push(Notice::ignored(&location, subject, nearest_name(&name, &compatibility::names(ENTITIES))));
    }
    let (scene, made, bounds, mut notices) = stage.finish(location);
    let root = view::with_camera(scene, bounds, bundle, &made, &mut notices);
    Ok((Reading { root, aliases: Vec::new(), includes, notices, moves: None }, made))
}

/// A transform that is in effect, with those round it.
struct Frame {
    placement: Placement,
    placed: Placed,
    /// The first entity inside.
    body: usize,
    location: Location,
    /// What there was before the first copy of an array, until that ends.
    mark: Option<Mark>,
    /// Whether further copies are made of what emits only.
    only_lights: bool,
}

/// The total transform of `placement` inside of `outer`.
fn placed_inside(outer: DMat4, placement: &Placement, entity: &Entity<'_>) -> Result<Placed, SceneError> {
    Placed::new(outer * placement.matrix())
        .ok_or_else(|| entity.error("the transform makes things vanish or explode", "check its scales and counts"))
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
        let mark = (placement.copies() > 1).then(|| self.stage.mark());
        let location = entity.location();
        self.frames.push(Frame { placement, placed, body, location, mark, only_lights: false });
        Ok(())
    }

    /// The total transform of `placement` inside of those in effect.
    fn inside(&self, placement: &Placement, entity: &Entity<'_>) -> Result<Placed, SceneError> {
        placed_inside(self.frames.last().map_or(DMat4::IDENTITY, |frame| frame.placed.matrix()), placement, entity)
    }

    /// Goes on to the next copy of the innermost transform, and gives where it begins; or ends the transform.
    fn next_copy(&mut self, entity: &Entity<'_>) -> Result<Option<usize>, SceneError> {
        let Some(mut frame) = self.frames.pop() else { return Ok(None) };
        match self.end_first_copy(&mut frame, entity)? {
            Copies::Made => {}
            Copies::PlacedButLights => {
                frame.only_lights = !std::mem::replace(&mut self.stage.only_lights, true);
            }
            Copies::Placed => return Ok(None),
        }
        if !frame.placement.advance() {
            self.stage.only_lights &= !frame.only_lights;
            return Ok(None);
        }
        frame.placed = self.inside(&frame.placement, entity)?;
        let body = frame.body;
        self.frames.push(frame);
        Ok(Some(body))
    }

    /// After the first copy of an array: places the others, where they are many.
    fn end_first_copy(&mut self, frame: &mut Frame, entity: &Entity<'_>) -> Result<Copies, SceneError> {
        let Some(mark) = frame.mark.take() else { return Ok(Copies::Made) };
        let outer = self.frames.last().map_or(DMat4::IDENTITY, |frame| frame.placed.matrix());
        let Frame { placement, placed, .. } = frame;
        let (copies, back) = (placement.copies(), placed.matrix().inverse());
        let moves = || {
            let mut moves = Vec::new();
            while placement.advance() {
                moves.push(placed_inside(outer, placement, entity)?.matrix() * back);
            }
            Ok(moves)
        };
        self.stage.end_first_copy(mark, copies, moves, entity)
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
