//! The light `infinite` with an image, which covers the sphere by a square that keeps areas: as a map of latitude and longitude.

use std::f64::consts::PI;
use std::io::Cursor;

use exr::prelude::{Image, SpecificChannels, Vec2 as Place, WritableImage};
use glam::{DMat3, DMat4, DVec3};

use super::super::draft::Draft;
use super::super::values::shown;
use super::goniometric::equal_area_square;
use super::output::Output;
use super::parameters::Parameters;
use super::spectrum::luminance;
use super::texture::{self, in_memory};
use crate::math::Rgb;
use crate::scene::description::PluginClass;
use crate::scene::error::SceneError;

/// The fewest and the most rows of the map.
const ROWS: [usize; 2] = [16, 2048];
/// Places along each side of a texel of the map at which the image is looked up.
const SAMPLES: usize = 3;

/// Reads the light, whose image is `name`. The map stands in the world, so that mirrored light spaces need nothing more.
///
/// # Errors
/// On an image that cannot be read, and a transform that cannot be inverted.
pub(super) fn read(
    name: &str,
    parameters: &Parameters,
    to_world: DMat4,
    output: &mut Output<'_>,
) -> Result<Draft, SceneError> {
    let place = &parameters.place;
    if parameters.has("L") {
        return Err(SceneError::new(place, "the light has a color and an image", "remove one of them"));
    }
    let from_world = DMat3::from_mat4(to_world).inverse();
    if !from_world.is_finite() {
        return Err(SceneError::new(place, "the light's transform cannot be inverted", "check the lines above it"));
    }
    let image = in_memory(&texture::plain_image(name, parameters, output)?.with_text("wrap_mode", "clamp"), output)?;
    let [_, height] = image.size();
    let rows = (height as usize).clamp(ROWS[0], ROWS[1]);
    let radiance =
        |direction: DVec3| image.color(&equal_area_square((from_world * direction).normalize()).as_vec2().into());
    let map = Map::sample(rows, radiance);
    let scale = parameters.float("scale")?.unwrap_or(1.0);
    // As in pbrt, the illuminance is that of the upper half of the light's own space.
    let scale = match parameters.float("illuminance")?.filter(|illuminance| *illuminance > 0.0) {
        Some(illuminance) => {
            scale * illuminance / map.illuminance(from_world.inverse() * DVec3::Z).max(f64::MIN_POSITIVE)
        }
        None => scale,
    };
    let file = format!("infinite-{}.exr", output.made.files.len());
    let bytes =
        map.into_exr().map_err(|problem| SceneError::new(place, format!("the map cannot be made: {problem}"), ""))?;
    output.made.files.insert(file.clone(), bytes.into());
    let instead = format!("a map of latitude and longitude, {} × {rows}, takes its place", 2 * rows);
    output.approximated(place, format!("the image {} of an infinite light", shown(name)), instead);
    Ok(Draft::new(PluginClass::Emitter, "envmap", place).with_text("filename", &file).with_float("scale", scale))
}

/// Radiance by latitude and longitude, as the emitter `envmap` reads it.
struct Map {
    rows: usize,
    texels: Vec<Rgb>,
}

/// The direction at a row, from +y to -y, and a column, from -z towards +x, of a map of `rows` rows.
fn direction(row: f64, column: f64, rows: usize) -> DVec3 {
    let (sine, y) = libm::sincos(PI * row.clamp(0.0, (rows - 1) as f64) / (rows - 1) as f64);
    let (x, z) = libm::sincos(PI * (column + 0.5) / rows as f64);
    DVec3::new(sine * x, y, -sine * z)
}

impl Map {
    /// A map of means over its texels.
    fn sample(rows: usize, radiance: impl Fn(DVec3) -> Rgb) -> Self {
        let offset = |index: usize| (index as f64 + 0.5) / SAMPLES as f64 - 0.5;
        let texel = |row: usize, column: usize| {
            let places = (0..SAMPLES * SAMPLES).map(|index| [offset(index / SAMPLES), offset(index % SAMPLES)]);
            let colors =
                places.map(|[down, right]| radiance(direction(row as f64 + down, column as f64 + right, rows)));
            colors.sum::<Rgb>() / (SAMPLES * SAMPLES) as f32
        };
        let texels = (0..rows).flat_map(|row| (0..2 * rows).map(move |column| (row, column)));
        Self { rows, texels: texels.map(|(row, column)| texel(row, column)).collect() }
    }

    /// The luminance that arrives at a surface which faces `up`.
    fn illuminance(&self, up: DVec3) -> f64 {
        let up = up.normalize();
        let mut sum = 0.0;
        for (index, color) in self.texels.iter().enumerate() {
            let toward = direction((index / (2 * self.rows)) as f64, (index % (2 * self.rows)) as f64, self.rows);
            let sine = (1.0 - toward.y * toward.y).max(0.0).sqrt();
            sum += toward.dot(up).max(0.0) * sine * luminance(color.to_array().map(f64::from));
        }
        // A texel spans π/(rows - 1) of latitude and π/rows of longitude.
        sum * PI * PI / ((self.rows - 1) * self.rows) as f64
    }

    fn into_exr(self) -> Result<Vec<u8>, exr::error::Error> {
        let width = 2 * self.rows;
        let color = |place: Place<usize>| {
            let color = self.texels[place.y() * width + place.x()];
            (color.x, color.y, color.z)
        };
        let mut bytes = Vec::new();
        let image = Image::from_channels((width, self.rows), SpecificChannels::rgb(color));
        image.write().to_buffered(Cursor::new(&mut bytes))?;
        Ok(bytes)
    }
}
