//! The film: `hdrfilm`.
//!
//! | parameter | meaning | unit | default |
//! |---|---|---|---|
//! | `width`, `height` | of the whole picture | pixels | 768, 576 |
//! | `crop_offset_x`, `crop_offset_y` | first column and row that are rendered | pixels | 0 |
//! | `crop_width`, `crop_height` | how many columns and rows are rendered | pixels | all that are left |
//! | `sample_border` | whether camera paths also start outside of the picture, where filters reach beyond its edges | – | false |
//! | a nested `rfilter` | how far a pixel's camera paths spread: see [`filter`] | pixels | `gaussian` of 0.5 |

mod filter;

use super::description::{Node, PluginClass};
use super::error::{SceneError, nearest_name};
use super::fields::Fields;
use crate::math::Vec2;

pub(crate) use filter::Filter;

/// The most pixels a picture may have.
pub(crate) const MAX_PIXELS: u64 = 1 << 28;

/// The picture's size, its place in the whole film, and its filter.
#[derive(Clone, Debug)]
pub struct Film {
    /// Width of the picture, pixels.
    pub width: u32,
    /// Height of the picture, pixels.
    pub height: u32,
    /// Width and height of the whole film, of which the picture is a window, pixels.
    pub whole: [u32; 2],
    /// First column and row of the window.
    pub offset: [u32; 2],
    /// Whether camera paths also start outside of the picture, where filters reach beyond its edges; else the part of a filter
    /// that lies inside stands for the whole.
    pub samples_border: bool,
    /// The reconstruction filter.
    pub filter: Filter,
    /// The same where it has no negative lobes, else the `gaussian` that stands in for it.
    pub smooth_filter: Filter,
}

impl Default for Film {
    fn default() -> Self {
        Self {
            width: 768,
            height: 576,
            whole: [768, 576],
            offset: [0, 0],
            samples_border: false,
            filter: Filter::gaussian(0.5),
            smooth_filter: Filter::gaussian(0.5),
        }
    }
}

impl Film {
    /// Pixels of the whole film.
    #[inline]
    pub fn whole_pixel_count(&self) -> f32 {
        self.whole[0] as f32 * self.whole[1] as f32
    }

    /// Makes pixels larger until the picture has about `most` of them, at least one.
    pub fn shrink(&mut self, most: u32) {
        let scale = (f64::from(most) / (f64::from(self.width) * f64::from(self.height))).sqrt();
        if scale < 1.0 {
            let smaller = |size: u32| ((f64::from(size) * scale).round() as u32).max(1);
            (self.width, self.height) = (smaller(self.width), smaller(self.height));
            let first = |offset: u32| (f64::from(offset) * scale).floor() as u32;
            self.offset = self.offset.map(first);
            let whole = self.whole.map(smaller);
            self.whole = [whole[0].max(self.offset[0] + self.width), whole[1].max(self.offset[1] + self.height)];
        }
    }

    /// Whether a point of the whole film may count in any of the picture's pixels.
    #[inline]
    pub fn reaches(&self, point: Vec2) -> bool {
        let within = |at: f32, offset: u32, size: u32| {
            let (low, high) = if self.samples_border { self.filter.reach(at) } else { (at.floor(), at.floor()) };
            high >= offset as f32 && low < (offset + size) as f32
        };
        within(point.x * self.whole[0] as f32, self.offset[0], self.width)
            && within(point.y * self.whole[1] as f32, self.offset[1], self.height)
    }

    /// Where camera paths may start, from the left or upper edge of a `pixel` of the picture's `size` pixels.
    #[inline]
    fn edges(&self, pixel: u32, size: u32) -> [f32; 2] {
        if self.samples_border {
            return [f32::NEG_INFINITY, f32::INFINITY];
        }
        [-(pixel as f32), (size - pixel) as f32]
    }

    /// The picture's pixels that a point counts in which the film [reaches](Self::reaches), by index and filter weight; a filter's
    /// weights have an integral of 1 over where camera paths start, in pixels.
    #[inline]
    pub fn for_each_pixel(&self, point: Vec2, mut add: impl FnMut(u32, f32)) {
        let (x, y) = (point.x * self.whole[0] as f32, point.y * self.whole[1] as f32);
        let span = |at: f32, offset: u32, size: u32| {
            let (low, high) = self.filter.reach(at);
            let (low, high) = (low - offset as f32, high - offset as f32);
            // Float-to-integer casts saturate: negative becomes 0.
            (low.max(0.0) as u32, if high < 0.0 { 0 } else { (high as u32 + 1).min(size) })
        };
        let (left, right) = span(x, self.offset[0], self.width);
        let (top, bottom) = span(y, self.offset[1], self.height);
        for row in top..bottom {
            let down = self.filter.weight_within(y - (row + self.offset[1]) as f32, || self.edges(row, self.height));
            for column in left..right {
                let edges = || self.edges(column, self.width);
                let weight = down * self.filter.weight_within(x - (column + self.offset[0]) as f32, edges);
                if weight != 0.0 {
                    add(row * self.width + column, weight);
                }
            }
        }
    }

    /// A point of the whole film, (0, 0) top left to (1, 1) bottom right, for column and row of a pixel of the picture and
    /// two numbers in [0, 1); and what a path through it counts, which may be negative.
    #[inline]
    pub fn point(&self, pixel: [u32; 2], u: [f32; 2]) -> (Vec2, f32) {
        self.filtered_point(&self.filter, pixel, u)
    }

    /// [`Film::point`] for methods that take no negative lobes: all paths count 1.
    #[inline]
    pub fn smooth_point(&self, pixel: [u32; 2], u: [f32; 2]) -> Vec2 {
        self.filtered_point(&self.smooth_filter, pixel, u).0
    }

    #[inline]
    fn filtered_point(&self, filter: &Filter, [column, row]: [u32; 2], [x, y]: [f32; 2]) -> (Vec2, f32) {
        let (x, across) = filter.sample_within(x, || self.edges(column, self.width));
        let (y, down) = filter.sample_within(y, || self.edges(row, self.height));
        let place = Vec2::new(
            ((column + self.offset[0]) as f32 + x) / self.whole[0] as f32,
            ((row + self.offset[1]) as f32 + y) / self.whole[1] as f32,
        );
        (place, across * down)
    }
}

/// Reads a film.
pub(crate) fn read(node: &Node) -> Result<Film, SceneError> {
    if node.plugin != "hdrfilm" {
        let problem = format!("there is no film \"{}\"", node.plugin);
        return Err(SceneError::new(&node.location, problem, nearest_name(&node.plugin, &["hdrfilm"])));
    }
    let mut fields = Fields::new(node);
    let default = Film::default();
    let whole = [side(&mut fields, "width", default.width)?, side(&mut fields, "height", default.height)?];
    let (x, width) = window(&mut fields, ["crop_offset_x", "crop_width"], whole[0])?;
    let (y, height) = window(&mut fields, ["crop_offset_y", "crop_height"], whole[1])?;
    let pixels = u64::from(width) * u64::from(height);
    if pixels > MAX_PIXELS {
        let problem = format!("a picture of {width} × {height} is {pixels} pixels");
        return Err(fields.error("width", problem, format!("at most {MAX_PIXELS} pixels can be rendered")));
    }
    // These choose how Mitsuba writes files; pictures here are always linear 32-bit RGB until they are written.
    fields.ignore(&["pixel_format", "component_format", "file_format", "banner", "compensate"]);
    let samples_border = fields.boolean("sample_border")?.unwrap_or(default.samples_border);
    let filter = match fields.child(PluginClass::ReconstructionFilter) {
        Some(node) => filter::read(node)?,
        None => default.filter,
    };
    fields.finish()?;
    let smooth_filter = if filter.has_negative_lobes() { Filter::gaussian(0.5) } else { filter.clone() };
    Ok(Film { width, height, whole, offset: [x, y], samples_border, filter, smooth_filter })
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

/// First pixel and count of what is rendered along one side of `whole` pixels.
fn window(fields: &mut Fields<'_>, [offset, size]: [&'static str; 2], whole: u32) -> Result<(u32, u32), SceneError> {
    let first = fields.integer(offset)?.unwrap_or(0);
    let Some(left) = u32::try_from(first).ok().and_then(|first| whole.checked_sub(first)).filter(|left| *left > 0)
    else {
        let problem = format!("\"{offset}\" is {first} on a film of {whole} pixels");
        return Err(fields.error(offset, problem, format!("give a whole number from 0 to {}", whole - 1)));
    };
    let count = side(fields, size, left)?;
    if count > left {
        let problem = format!("{count} pixels from {first} on leave a film of {whole} pixels");
        return Err(fields.error(size, problem, format!("make \"{size}\" at most {left}")));
    }
    Ok((first as u32, count))
}
