//! Volumes: numbers or colors in space. `constvolume` is one of them everywhere; `gridvolume` has them at the points of a grid.
//!
//! A grid fills the unit cube before its `to_world`, with its points in the middle of cells, as texels are, x fastest.
//! Its files are Mitsuba's: `VOL`, version 3, the encoding (1, single precision), three sizes, the number of channels (1 or
//! 3) and a box, which counts with `use_grid_bbox`; then the numbers, channels fastest. All are little-endian.

use std::sync::Arc;

use glam::{DMat4, DVec3};

use crate::math::{Rgb, Vec3};
use crate::scene::bundle::Bundle;
use crate::scene::description::{Node, PluginClass};
use crate::scene::error::{Location, SceneError, shown_number};
use crate::scene::fields::Fields;
use crate::scene::geometry::Ray;

const HEADER: usize = 48;
/// The most numbers of a grid: 1 GiB.
const MOST_NUMBERS: u64 = 1 << 28;

/// Colors in space.
#[derive(Clone, Debug)]
pub(super) enum Volume {
    /// The same everywhere.
    Constant(Rgb),
    /// Between the points of a grid.
    Grid(Grid),
}

/// What lies between the points of a grid.
#[derive(Clone, Copy, Debug)]
enum Filter {
    Nearest,
    Trilinear,
}

/// What lies beyond a grid's borders.
#[derive(Clone, Copy, Debug)]
enum Wrap {
    Repeat,
    Mirror,
    Clamp,
}

/// A grid of colors.
#[derive(Clone)]
pub(super) struct Grid {
    /// Points along x, y and z, at least 1 each.
    size: [usize; 3],
    values: Arc<[Rgb]>,
    largest: f32,
    /// From the world to the unit cube.
    to_cube: glam::Affine3A,
    filter: Filter,
    wrap: Wrap,
}

impl std::fmt::Debug for Grid {
    fn fmt(&self, formatter: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { size: [x, y, z], largest, to_cube, filter, wrap, .. } = self;
        write!(formatter, "Grid of {x} × {y} × {z} up to {largest}, {filter:?}, {wrap:?}, {to_cube:?}")
    }
}

/// Reads the parameter `name`, which is a color or a volume, of numbers from 0 to `most`.
///
/// # Errors
/// Other volumes, files that are damaged, and numbers out of range.
pub(super) fn read(
    fields: &mut Fields<'_>,
    name: &'static str,
    default: f64,
    most: f64,
    bundle: &Bundle,
) -> Result<Volume, SceneError> {
    let node = fields.named_child(PluginClass::Volume, name);
    let volume = match node {
        None => constant(fields.rgb(name)?.unwrap_or([default; 3])),
        Some(node) => match node.plugin.as_str() {
            "constvolume" => {
                let mut inside = Fields::new(node);
                let value = inside.rgb("value")?.unwrap_or([1.0; 3]);
                // It is the same everywhere; [`boxed`] reads it where it counts.
                inside.ignore(&["to_world"]);
                inside.finish()?;
                constant(value)
            }
            "gridvolume" => Volume::Grid(read_grid(node, bundle)?),
            other => {
                let problem = format!("volume \"{other}\" is not supported");
                return Err(SceneError::new(&node.location, problem, "use \"constvolume\" or \"gridvolume\""));
            }
        },
    };
    let [low, high] = volume.range();
    if low >= 0.0 && f64::from(high) <= most {
        return Ok(volume);
    }
    let problem = format!("\"{name}\" reaches from {} to {}", shown_number(low), shown_number(high));
    let remedy = if most.is_finite() {
        format!("give numbers from 0 to {most}")
    } else {
        "give numbers of at least 0".to_owned()
    };
    Err(node.map_or_else(
        || fields.error(name, problem.clone(), remedy.clone()),
        |node| SceneError::new(&node.location, &problem, &remedy),
    ))
}

/// A constant volume as Mitsuba's `heterogeneous` takes its extinction: within the unit cube under the volume's `to_world`, and nothing
/// beyond. Others stay as they are.
pub(super) fn boxed(volume: Volume, node: Option<&Node>) -> Result<Volume, SceneError> {
    let Volume::Constant(color) = volume else { return Ok(volume) };
    let to_world = node.map_or(Ok(DMat4::IDENTITY), |node| Fields::new(node).transform("to_world"))?;
    let to_cube = glam::Affine3A::from_mat4(to_world.inverse().as_mat4());
    let (values, largest) = (Arc::from([color]), color.max_element());
    Ok(Volume::Grid(Grid { size: [1; 3], values, largest, to_cube, filter: Filter::Nearest, wrap: Wrap::Clamp }))
}

fn constant(rgb: [f64; 3]) -> Volume {
    Volume::Constant(Rgb::from_array(rgb.map(|channel| channel as f32)))
}

fn read_grid(node: &Node, bundle: &Bundle) -> Result<Grid, SceneError> {
    let mut fields = Fields::new(node);
    let Some(file) = fields.string("filename")? else {
        return Err(fields.error("filename", "\"gridvolume\" has no \"filename\"", "name its .vol file"));
    };
    let location = fields.location_of("filename");
    let filter = match fields.string("filter_type")?.unwrap_or("trilinear") {
        "trilinear" => Filter::Trilinear,
        "nearest" => Filter::Nearest,
        other => return Err(unknown(&fields, "filter_type", other, "use \"trilinear\" or \"nearest\"")),
    };
    let wrap = match fields.string("wrap_mode")?.unwrap_or("clamp") {
        "repeat" => Wrap::Repeat,
        "mirror" => Wrap::Mirror,
        "clamp" => Wrap::Clamp,
        other => return Err(unknown(&fields, "wrap_mode", other, "use \"clamp\", \"repeat\" or \"mirror\"")),
    };
    let to_world = fields.transform("to_world")?;
    let in_box = fields.boolean("use_grid_bbox")?.unwrap_or(false);
    // Colors are what they are, and the rest chooses how Mitsuba samples.
    fields.ignore(&["raw", "accel", "max_value"]);
    fields.finish()?;
    let read = parse(&bundle.read(file, location)?, location)?;
    let to_world = if in_box { to_world * read.place } else { to_world };
    let to_cube = glam::Affine3A::from_mat4(to_world.inverse().as_mat4());
    if !to_cube.is_finite() {
        return Err(SceneError::new(
            &node.location,
            "the grid is flat or its size is not finite",
            "check its to_world and its box",
        ));
    }
    let largest = read.values.iter().map(|value| value.max_element()).fold(0.0, f32::max);
    Ok(Grid { size: read.size, values: read.values.into(), largest, to_cube, filter, wrap })
}

fn unknown(fields: &Fields<'_>, name: &str, found: &str, remedy: &str) -> SceneError {
    fields.error(name, format!("\"{name}\" is \"{found}\""), remedy)
}

/// What a file holds.
struct GridFile {
    size: [usize; 3],
    values: Vec<Rgb>,
    /// The box, as a map from the unit cube.
    place: DMat4,
}

fn parse(bytes: &[u8], location: &Location) -> Result<GridFile, SceneError> {
    let damaged =
        |problem: String| SceneError::new(location, problem, "save the volume again as Mitsuba's VOL, version 3");
    let word = |at: usize| bytes.get(at..)?.first_chunk().copied();
    if bytes.len() < HEADER || !bytes.starts_with(b"VOL") || bytes[3] != 3 {
        return Err(damaged("the file is no volume of version 3".to_owned()));
    }
    let integer = |at: usize| word(at).map_or(0, i32::from_le_bytes);
    let (encoding, channels) = (integer(4), integer(20));
    let size = [integer(8), integer(12), integer(16)];
    if encoding != 1 || !matches!(channels, 1 | 3) || size.iter().any(|points| *points < 1) {
        let [x, y, z] = size;
        let problem = format!("the volume has encoding {encoding}, {channels} channels and {x} × {y} × {z} points");
        return Err(damaged(format!("{problem}; encoding 1, 1 or 3 channels and at least one point can be read")));
    }
    // Sizes are below 2³¹ each, so that two of them fit.
    let points =
        (size[0] as u64 * size[1] as u64).checked_mul(size[2] as u64).filter(|points| *points <= MOST_NUMBERS / 3);
    let numbers = points.map(|points| points * channels as u64);
    let expected = numbers.map(|numbers| HEADER as u64 + 4 * numbers);
    if expected != Some(bytes.len() as u64) {
        let expected = expected.map_or("more than can be kept".to_owned(), |bytes| bytes.to_string());
        return Err(damaged(format!("the volume has {} bytes, and its sizes ask for {expected}", bytes.len())));
    }
    let number = |at: usize| word(at).map_or(0.0, f32::from_le_bytes);
    let values = (HEADER..bytes.len()).step_by(4 * channels as usize).map(|at| match channels {
        1 => Rgb::splat(number(at)),
        _ => Rgb::new(number(at), number(at + 4), number(at + 8)),
    });
    let values: Vec<Rgb> = values.collect();
    if !values.iter().all(|value| value.is_finite()) {
        return Err(damaged("the volume has numbers that are not finite".to_owned()));
    }
    let corner = |at: usize| DVec3::new(number(at).into(), number(at + 4).into(), number(at + 8).into());
    let (low, high) = (corner(24), corner(36));
    let place = DMat4::from_translation(low) * DMat4::from_scale(high - low);
    Ok(GridFile { size: size.map(|points| points as usize), values, place })
}

impl Volume {
    /// The color at a place in the world.
    #[inline]
    pub(super) fn at(&self, position: Vec3) -> Rgb {
        match self {
            Self::Constant(color) => *color,
            Self::Grid(grid) => grid.at(grid.to_cube.transform_point3(position)),
        }
    }

    /// The largest number of any channel.
    pub(super) fn largest(&self) -> f32 {
        self.range()[1]
    }

    fn range(&self) -> [f32; 2] {
        match self {
            Self::Constant(color) => [color.min_element(), color.max_element()],
            Self::Grid(grid) => {
                [grid.values.iter().map(|value| value.min_element()).fold(f32::INFINITY, f32::min), grid.largest]
            }
        }
    }

    /// The distances, m, between which a ray of finite direction is inside, within its length; the second is not above the first
    /// where it is nowhere.
    pub(super) fn reach(&self, ray: &Ray) -> [f32; 2] {
        let Self::Grid(grid) = self else { return [0.0, ray.length] };
        let origin = grid.to_cube.transform_point3(ray.origin);
        let direction = grid.to_cube.transform_vector3(ray.direction);
        let mut reach = [0.0f32, ray.length];
        for axis in 0..3 {
            let bounds = [0.0, 1.0].map(|bound| (bound - origin[axis]) / direction[axis]);
            // A ray along a face is inside: what is not a number bounds nothing.
            reach = [reach[0].max(bounds[0].min(bounds[1])), reach[1].min(bounds[0].max(bounds[1]))];
        }
        reach
    }

    /// How far it is across, m, if it ends somewhere.
    pub(super) fn size(&self) -> Option<f32> {
        match self {
            Self::Constant(_) => None,
            Self::Grid(grid) => Some(grid.to_cube.inverse().transform_vector3(Vec3::ONE).length()),
        }
    }

    /// The one color that it has everywhere.
    pub(super) fn constant(&self) -> Option<Rgb> {
        match self {
            Self::Constant(color) => Some(*color),
            Self::Grid(_) => None,
        }
    }
}

impl Grid {
    /// The color at a place of the unit cube.
    fn at(&self, place: Vec3) -> Rgb {
        let size = Vec3::from_array(self.size.map(|points| points as f32));
        match self.filter {
            Filter::Nearest => self.point((place * size).floor().to_array().map(|index| index as i64)),
            Filter::Trilinear => {
                let place = place * size - 0.5;
                let low = place.floor();
                let share = place - low;
                let low = low.to_array().map(|index| index as i64);
                let corner = |x, y, z| self.point([low[0] + x, low[1] + y, low[2] + z]);
                let along_x = |y, z| corner(0, y, z).lerp(corner(1, y, z), share.x);
                let along_y = |z| along_x(0, z).lerp(along_x(1, z), share.y);
                along_y(0).lerp(along_y(1), share.z)
            }
        }
    }

    fn point(&self, index: [i64; 3]) -> Rgb {
        let wrapped = |axis: usize| {
            let size = self.size[axis] as i64;
            let inside = match self.wrap {
                Wrap::Clamp => index[axis].clamp(0, size - 1),
                Wrap::Repeat => index[axis].rem_euclid(size),
                Wrap::Mirror => {
                    let folded = index[axis].rem_euclid(2 * size);
                    folded.min(2 * size - 1 - folded)
                }
            };
            inside as usize
        };
        self.values[(wrapped(2) * self.size[1] + wrapped(1)) * self.size[0] + wrapped(0)]
    }
}
