//! The film: `hdrfilm` with `width` (pixels, 768) and `height` (pixels, 576) and a box filter.

use super::description::{Node, PluginClass};
use super::error::{SceneError, nearest_name};
use super::fields::Fields;

/// The most pixels a picture may have.
pub const MAX_PIXELS: u64 = 1 << 28;

/// The picture's size.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Film {
    /// Width, pixels.
    pub width: u32,
    /// Height, pixels.
    pub height: u32,
}

impl Default for Film {
    fn default() -> Self {
        Self { width: 768, height: 576 }
    }
}

/// Reads a film; what is approximated is added to `notices`.
pub fn read(node: &Node, notices: &mut Vec<String>) -> Result<Film, SceneError> {
    if node.plugin != "hdrfilm" {
        let problem = format!("there is no film \"{}\"", node.plugin);
        return Err(SceneError::new(&node.location, problem, nearest_name(&node.plugin, &["hdrfilm"])));
    }
    let mut fields = Fields::new(node);
    let default = Film::default();
    let width = side(&mut fields, "width", default.width)?;
    let height = side(&mut fields, "height", default.height)?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MAX_PIXELS {
        let problem = format!("a picture of {width} × {height} is {pixels} pixels");
        return Err(fields.error("width", problem, format!("at most {MAX_PIXELS} pixels can be rendered")));
    }
    // These choose how Mitsuba writes files; pictures here are always linear 32-bit RGB until they are written.
    fields.ignore(&["pixel_format", "component_format", "file_format", "sample_border", "banner", "compensate"]);
    if let Some(filter) = fields.child(PluginClass::ReconstructionFilter) {
        reconstruction_filter(filter, notices)?;
    }
    fields.finish()?;
    Ok(Film { width, height })
}

fn side(fields: &mut Fields<'_>, name: &'static str, default: u32) -> Result<u32, SceneError> {
    match fields.integer(name)? {
        None => Ok(default),
        Some(pixels) => match u32::try_from(pixels) {
            Ok(pixels) if pixels > 0 => Ok(pixels),
            _ => Err(fields.error(name, format!("\"{name}\" is {pixels} pixels"), "give a whole number of at least 1")),
        },
    }
}

fn reconstruction_filter(node: &Node, notices: &mut Vec<String>) -> Result<(), SceneError> {
    const OTHERS: &[&str] = &["tent", "gaussian", "mitchell", "catmullrom", "lanczos"];
    if OTHERS.contains(&node.plugin.as_str()) {
        notices.push(format!("{}: filter \"{}\" is replaced by \"box\"", node.location, node.plugin));
        return Ok(());
    }
    if node.plugin == "box" {
        let mut fields = Fields::new(node);
        fields.ignore(&["radius"]);
        return fields.finish();
    }
    let known: Vec<&str> = ["box"].into_iter().chain(OTHERS.iter().copied()).collect();
    let problem = format!("there is no rfilter \"{}\"", node.plugin);
    Err(SceneError::new(&node.location, problem, nearest_name(&node.plugin, &known)))
}
