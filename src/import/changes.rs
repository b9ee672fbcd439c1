//! What a user changes of a scene, whatever its format: the picture's size and part, the camera, the default environment.
//!
//! Changes travel with the scene that they change, as the file [`FILE`] of its archive: a scene and its changes are one thing
//! with one hash, and whoever loads it sees the same.

use std::sync::Arc;

use serde::{Deserialize, Serialize};

use super::camera_path::{BetweenCameras, stand_between};
use super::formats::{Format, format, standard_name};
use super::pack::write_zip;
use super::{Archive, default_environment, resolve};
use crate::scene::bundle::{Bundle, Files, SCENE_COMMENT, scene_in_comment};
use crate::scene::description::{Child, Node, Parameter, PluginClass, Value};
use crate::scene::error::{Location, SceneError};
use crate::scene::notice::Notice;

/// The name in an archive of the changes of its scene.
pub const FILE: &str = "photonfarm.json";

/// Changes of a scene; what is not given stays as the scene says.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Changes {
    /// Width of the whole picture, pixels; alone it keeps the picture's proportions.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub width: Option<u32>,
    /// Height of the whole picture, pixels.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub height: Option<u32>,
    /// The part of the whole picture that is rendered.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub crop: Option<Crop>,
    /// The name of a camera, or its index among the scene's, counted from 0.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub camera: Option<String>,
    /// Whether a white environment of radiance 1 lights the scene. When nothing is said, a model without light of its own gets
    /// one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub environment: Option<Environment>,
    /// The moment that is shown of a scene in which things move, in the scene's own unit of time. When nothing is said, everything stands
    /// where it begins.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub time: Option<f64>,
    /// A camera between two of the scene's, in place of `camera`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub between_cameras: Option<BetweenCameras>,
}

/// A part of a picture, pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Crop {
    /// First column.
    pub x: u32,
    /// First row.
    pub y: u32,
    /// How many columns.
    pub width: u32,
    /// How many rows.
    pub height: u32,
}

/// Whether there is the default environment.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[serde(rename_all = "lowercase")]
pub enum Environment {
    /// Added to whatever else lights the scene.
    On,
    /// Never added.
    Off,
}

/// The film that Mitsuba takes where a scene has none, pixels.
pub(super) const DEFAULT_SIZE: [u32; 2] = [768, 576];

impl Changes {
    /// Whether nothing is changed.
    pub fn is_empty(&self) -> bool {
        *self == Self::default()
    }

    /// These changes, and of `others` what these do not say.
    pub(crate) fn over(self, others: Self) -> Self {
        Self {
            width: self.width.or(others.width),
            height: self.height.or(others.height),
            crop: self.crop.or(others.crop),
            camera: self.camera.or(others.camera),
            environment: self.environment.or(others.environment),
            time: self.time.or(others.time),
            between_cameras: self.between_cameras.or(others.between_cameras),
        }
    }

    /// Changes a resolved scene: all but the camera.
    pub(super) fn apply(&self, root: &mut Node, notices: &mut Vec<Notice>) -> Result<(), SceneError> {
        if self.width.is_some() || self.height.is_some() || self.crop.is_some() {
            self.change_film(root)?;
        }
        if self.environment == Some(Environment::On) {
            add_environment(root, notices)?;
        }
        Ok(())
    }

    fn change_film(&self, root: &mut Node) -> Result<(), SceneError> {
        let Some(sensor) = root.children.iter_mut().find(|child| child.node.class == PluginClass::Sensor) else {
            return Ok(());
        };
        let sensor = Arc::make_mut(&mut sensor.node);
        if !sensor.children.iter().any(|child| child.node.class == PluginClass::Film) {
            sensor.children.push(Child { name: String::new(), node: Arc::new(film(&sensor.location)) });
        }
        let film = sensor.children.iter_mut().find(|child| child.node.class == PluginClass::Film);
        let Some(film) = film.map(|child| Arc::make_mut(&mut child.node)) else { return Ok(()) };
        let old = [integer(film, "width"), integer(film, "height")];
        let old = [0, 1].map(|axis| old[axis].unwrap_or(i64::from(DEFAULT_SIZE[axis])));
        let new = self.size(old);
        for (axis, [side, offset, count]) in AXES.iter().enumerate() {
            set(film, side, new[axis]);
            let scaled = |pixels: i64| (pixels as f64 * new[axis] as f64 / old[axis] as f64).round() as i64;
            // The scene's own window keeps its place in the whole picture.
            if let Some(first) = integer(film, offset) {
                set(film, offset, scaled(first));
            }
            if let Some(pixels) = integer(film, count) {
                set(film, count, scaled(pixels).max(1));
            }
        }
        let Some(Crop { x, y, width, height }) = self.crop else { return Ok(()) };
        let (first, pixels) = ([x, y].map(i64::from), [width, height].map(i64::from));
        for (axis, [_, offset, count]) in AXES.iter().enumerate() {
            if pixels[axis] < 1 || first[axis] + pixels[axis] > new[axis] {
                let problem = format!("the part {x},{y},{width},{height} leaves a picture of {} × {}", new[0], new[1]);
                return Err(SceneError::new(&film.location, problem, "give x,y,width,height in pixels of it"));
            }
            set(film, offset, first[axis]);
            set(film, count, pixels[axis]);
        }
        // A part shows what the whole picture shows there: its edges are not the picture's.
        film.parameters.retain(|parameter| parameter.name != "sample_border");
        let (location, value) = (film.location.clone(), Value::Boolean(true));
        film.parameters.push(Parameter { name: "sample_border".to_owned(), value, location });
        Ok(())
    }

    /// The size of a picture that was `old` before.
    fn size(&self, old: [i64; 2]) -> [i64; 2] {
        let scaled = |side: u32, [from, to]: [i64; 2]| {
            ((f64::from(side) * to as f64 / from.max(1) as f64).round() as i64).max(1)
        };
        match (self.width, self.height) {
            (None, None) => old,
            (Some(width), None) => [i64::from(width), scaled(width, old)],
            (None, Some(height)) => [scaled(height, [old[1], old[0]]), i64::from(height)],
            (Some(width), Some(height)) => [width, height].map(i64::from),
        }
    }
}

/// The parameters of a film along x and y: side, first pixel, and count of what is rendered.
const AXES: [[&str; 3]; 2] = [["width", "crop_offset_x", "crop_width"], ["height", "crop_offset_y", "crop_height"]];

pub(super) fn film(location: &Location) -> Node {
    Node {
        class: PluginClass::Film,
        plugin: "hdrfilm".to_owned(),
        id: String::new(),
        name: String::new(),
        parameters: Vec::new(),
        children: Vec::new(),
        location: location.clone(),
    }
}

pub(super) fn integer(node: &Node, name: &str) -> Option<i64> {
    match node.parameters.iter().find(|parameter| parameter.name == name)?.value {
        Value::Integer(number) => Some(number),
        _ => None,
    }
}

pub(super) fn set(node: &mut Node, name: &str, number: i64) {
    node.parameters.retain(|parameter| parameter.name != name);
    let (location, value) = (node.location.clone(), Value::Integer(number));
    node.parameters.push(Parameter { name: name.to_owned(), value, location });
}

fn add_environment(root: &mut Node, notices: &mut Vec<Notice>) -> Result<(), SceneError> {
    const ENVIRONMENTS: [&str; 4] = ["constant", "envmap", "sunsky", "timed_sunsky"];
    let own = root.children.iter().find(|child| ENVIRONMENTS.contains(&child.node.plugin.as_str()));
    if let Some(own) = own {
        let explanation = "the scene has an environment of its own";
        notices.push(Notice::ignored(&own.node.location, "the white environment that was asked for", explanation));
        return Ok(());
    }
    let emitter = resolve::resolve(&default_environment::emitter(&root.location), &[])?;
    root.children.push(Child { name: String::new(), node: Arc::new(emitter) });
    Ok(())
}

/// Keeps the wanted one of the scene's sensors, or the first, or puts one between two.
///
/// # Errors
/// When no sensor has the wanted id or index.
pub(super) fn choose_sensor(root: &mut Node, changes: &Changes, notices: &mut Vec<Notice>) -> Result<(), SceneError> {
    if let Some(way) = &changes.between_cameras {
        return stand_between(root, way);
    }
    let wanted = changes.camera.as_deref();
    let is_sensor = |child: &Child| child.node.class == PluginClass::Sensor;
    let sensors: Vec<Arc<Node>> =
        root.children.iter().filter(|child| is_sensor(child)).map(|child| child.node.clone()).collect();
    let names: Vec<&str> = sensors.iter().map(|sensor| sensor.id.as_str()).collect();
    let chosen = choose(&names, wanted, &root.location)?;
    if let (None, Some(second)) = (wanted, sensors.get(1)) {
        notices.push(Notice::ignored(&second.location, "every camera but the first", "--camera chooses another"));
    }
    let mut index = 0;
    root.children.retain(|child| {
        let kept = !is_sensor(child) || index == chosen;
        index += usize::from(is_sensor(child));
        kept
    });
    Ok(())
}

/// The index of the wanted camera among those with `names`; the first when none is wanted.
///
/// # Errors
/// When there is none of that name or index.
pub(super) fn choose(names: &[&str], wanted: Option<&str>, place: &Location) -> Result<usize, SceneError> {
    let Some(wanted) = wanted else { return Ok(0) };
    let by_name = names.iter().position(|name| *name == wanted && !name.is_empty());
    let by_index = || wanted.parse().ok().filter(|index| *index < names.len());
    by_name.or_else(by_index).ok_or_else(|| {
        let shown: String = wanted.chars().take(80).collect();
        let listed = |(index, name): (usize, &&str)| match name.is_empty() {
            true => index.to_string(),
            false => format!("{index} {name:?}"),
        };
        let known: Vec<String> = names.iter().take(20).enumerate().map(listed).collect();
        let more = if names.len() > known.len() { format!(", … ({} in all)", names.len()) } else { String::new() };
        let remedy = match known.len() {
            0 => "the scene has none".to_owned(),
            1 => format!("the only one is {}", known[0]),
            _ => format!("there are {}{more}", known.join(", ")),
        };
        SceneError::new(place, format!("there is no camera {shown:?}"), remedy)
    })
}

/// Reads the changes that an archive brings along.
pub(super) fn read(bundle: &Bundle) -> Result<Changes, SceneError> {
    let Bundle::Archive(files) = bundle else { return Ok(Changes::default()) };
    let Some(text) = files.get(FILE) else { return Ok(Changes::default()) };
    serde_json::from_slice(text).map_err(|error| {
        let place = Location { file: FILE.to_owned(), line: error.line() as u32, ..Location::default() };
        SceneError::new(&place, format!("the changes of the scene cannot be read: {error}"), "pack the scene again")
    })
}

/// A packed scene, as [`load_bytes`](super::load_bytes) reads it, with `changes` before those that it may have already.
///
/// # Errors
/// When the bytes are no scene; when the archive is malformed.
pub fn with_changes(bytes: &[u8], changes: &Changes) -> Result<Vec<u8>, SceneError> {
    if changes.is_empty() {
        return Ok(bytes.to_vec());
    }
    let place = Location { file: super::UNNAMED.to_owned(), ..Location::default() };
    let found = format(bytes, &place)?;
    let mut known = Changes::default();
    let mut files = match found {
        Format::Zip => {
            let bundle = Archive::open(bytes, &place)?.bundle;
            known = read(&bundle)?;
            bundle.into_files()
        }
        single => Files::from([(standard_name(single).to_owned(), bytes.into())]),
    };
    let comment = scene_in_comment(bytes).filter(|_| found == Format::Zip);
    let comment = comment.map(|scene| format!("{SCENE_COMMENT}{scene}")).unwrap_or_default();
    let json = serde_json::to_vec(&changes.clone().over(known));
    let failed = |error: String| SceneError::new(&place, format!("the changes cannot be packed: {error}"), "");
    files.insert(FILE.to_owned(), json.map_err(|error| failed(error.to_string()))?.into());
    write_zip(&files, &comment).map_err(|error| failed(error.to_string()))
}
