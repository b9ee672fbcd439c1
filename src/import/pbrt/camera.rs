//! The camera, and the part of the screen that it shows.

use glam::{DMat4, DVec2, DVec3, DVec4};

use super::super::draft::Draft;
use super::super::values::shown;
use super::attributes::inverse;
use super::options::Directive;
use super::output::{Output, with_integer};
use super::parameters::Parameters;
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::SceneError;

/// A part of the plane in which a camera of fov 90° has the shorter side of its picture from -1 to 1.
struct Screen {
    least: DVec2,
    most: DVec2,
}

impl Screen {
    /// What the camera says, or else what follows from the picture's width over its height.
    fn read(parameters: &Parameters, aspect: f64) -> Result<Self, SceneError> {
        let refused = |problem: &str, remedy: &str| Err(SceneError::new(&parameters.place, problem, remedy));
        let aspect = match parameters.float("frameaspectratio")? {
            Some(ratio) if !(ratio > 0.0 && ratio < 1e6) => {
                return refused("the frameaspectratio is no aspect ratio", "give width over height");
            }
            ratio => ratio.unwrap_or(aspect),
        };
        let half = DVec2::new(aspect.max(1.0), (1.0 / aspect).max(1.0));
        let Some(window) = parameters.numbers("screenwindow", 4)? else { return Ok(Self { least: -half, most: half }) };
        let [x0, x1, y0, y1, ..] = *window else { return Ok(Self { least: -half, most: half }) };
        if x0 < x1 && y0 < y1 && [x0, x1, y0, y1].iter().all(|edge| edge.abs() < 1e6) {
            return Ok(Self { least: DVec2::new(x0, y0), most: DVec2::new(x1, y1) });
        }
        refused("the screenwindow is empty", "write x0 x1 y0 y1, ascending")
    }

    fn size(&self) -> DVec2 {
        self.most - self.least
    }

    /// From the middle to the edge of the smallest screen round the middle that holds this one.
    fn reach(&self) -> DVec2 {
        self.least.abs().max(self.most.abs())
    }
}

/// The sensor with its film.
///
/// # Errors
/// On cameras other than `perspective`, `orthographic` and `spherical`, and on screens without area.
pub(super) fn sensor(
    Directive { name, parameters }: &Directive,
    from_world: DMat4,
    (film, size): (Draft, [i64; 2]),
    output: &mut Output<'_>,
) -> Result<Draft, SceneError> {
    let place = &parameters.place;
    let inverse = inverse(from_world);
    if !inverse.is_finite() {
        return Err(SceneError::new(place, "the camera's transform cannot be inverted", "check the lines above it"));
    }
    let screen = Screen::read(parameters, size[0] as f64 / size[1] as f64)?;
    let pixels = DVec2::new(size[0] as f64, size[1] as f64);
    let [width, height] = (screen.size() / pixels).to_array();
    if (width / height - 1.0).abs() > 1e-3 && name != "spherical" {
        let instead = "pixels are square; the picture has the width of the window";
        output.approximated(place, "a screenwindow or frameaspectratio that is not that of the film", instead);
    }
    parameters.pass_over(&["shutteropen", "shutterclose"]);
    // x is to the right in pbrt, to the left here.
    let to_world = inverse * DMat4::from_scale(DVec3::new(-1.0, 1.0, 1.0));
    let sensor = match name.as_str() {
        "perspective" => {
            perspective(parameters, &screen, to_world)?.with_child("", shifted(film, size, &screen, output))
        }
        "orthographic" => orthographic(parameters, &screen, to_world, output)?.with_child("", film),
        "spherical" => spherical(parameters, inverse)?.with_child("", film),
        _ => {
            let remedy = "only \"perspective\", \"orthographic\" and \"spherical\" are supported";
            return Err(SceneError::new(place, format!("the camera is {}", shown(name)), remedy));
        }
    };
    output.report_unused(&format!("camera {}", shown(name)), parameters)?;
    Ok(sensor)
}

fn perspective(parameters: &Parameters, screen: &Screen, to_world: DMat4) -> Result<Draft, SceneError> {
    let fov = parameters.float("fov")?.unwrap_or(90.0);
    let focus = parameters.float("focaldistance")?;
    let radius = parameters.float("lensradius")?.unwrap_or(0.0);
    let reach = screen.reach();
    // The usual screen keeps the number that the file has.
    let (fov, axis) = match reach.min_element() {
        1.0 => (fov, "smaller"),
        _ => {
            let half = libm::atan(libm::tan((0.5 * fov).to_radians()) * reach.x);
            (2.0 * half.to_degrees(), "x")
        }
    };
    let plugin = if radius > 0.0 { "thinlens" } else { "perspective" };
    let sensor = Draft::new(PluginClass::Sensor, plugin, &parameters.place)
        .with_float("fov", fov)
        .with_text("fov_axis", axis)
        // pbrt's rays begin at the camera and have no end.
        .with_float("near_clip", 1e-6)
        .with_float("far_clip", 1e10)
        .with_transform("to_world", to_world);
    if radius <= 0.0 {
        return Ok(sensor);
    }
    // Both are in the camera's space, which may be scaled.
    let scale = to_world.z_axis.truncate().length();
    Ok(sensor.with_float("aperture_radius", radius * scale).with_float("focus_distance", focus.unwrap_or(1e6) * scale))
}

/// The film as a window in a larger one, whose middle is that of the screen.
fn shifted(film: Draft, size: [i64; 2], screen: &Screen, output: &mut Output<'_>) -> Draft {
    let reach = screen.reach();
    if screen.least == -screen.most {
        return film;
    }
    // Rows run downwards.
    let (first, whole) = (DVec2::new(screen.least.x + reach.x, reach.y - screen.most.y), 2.0 * reach);
    let per_unit = DVec2::new(size[0] as f64, size[1] as f64) / screen.size();
    let [first, whole] = [first, whole].map(|extent| extent * per_unit);
    if (first - first.round()).abs().max_element().max((whole - whole.round()).abs().max_element()) > 1e-3 {
        let instead = "it begins at the nearest whole pixel";
        output.approximated(&film.location, "a screenwindow whose middle is not between pixels", instead);
    }
    let [first, whole] = [first, whole].map(|extent| [extent.x.round() as i64, extent.y.round() as i64]);
    let names = [["width", "crop_offset_x", "crop_width"], ["height", "crop_offset_y", "crop_height"]];
    (0..2).fold(film, |film, axis| {
        let [side, offset, count] = names[axis];
        let integer = |name: &str| {
            let parameter = film.parameters.iter().find(|parameter| parameter.name == name)?;
            if let Value::Integer(number) = parameter.value { Some(number) } else { None }
        };
        let (own, pixels) = (integer(offset).unwrap_or(0), integer(count).unwrap_or(size[axis]));
        let mut film = film;
        film.parameters.retain(|parameter| ![side, offset, count].contains(&parameter.name.as_str()));
        let film = with_integer(film, side, whole[axis].max(first[axis] + size[axis]));
        with_integer(with_integer(film, offset, first[axis] + own), count, pixels)
    })
}

fn orthographic(
    parameters: &Parameters,
    screen: &Screen,
    to_world: DMat4,
    output: &mut Output<'_>,
) -> Result<Draft, SceneError> {
    if parameters.float("lensradius")?.is_some_and(|radius| radius > 0.0) {
        output.ignored(&parameters.place, "the lens of an orthographic camera", "everything is in focus");
    }
    parameters.pass_over(&["focaldistance"]);
    let middle = 0.5 * (screen.least + screen.most);
    // x is turned round by `to_world` before.
    let middle = DMat4::from_translation(DVec3::new(-middle.x, middle.y, 0.0));
    let half = 0.5 * screen.size().x;
    let size = DMat4::from_scale(DVec3::new(half, half, 1.0));
    Ok(Draft::new(PluginClass::Sensor, "orthographic", &parameters.place)
        .with_float("near_clip", 1e-6)
        .with_float("far_clip", 1e10)
        .with_transform("to_world", to_world * middle * size))
}

/// A camera that sees all around: longitudes begin at +x there, behind here.
fn spherical(parameters: &Parameters, to_world: DMat4) -> Result<Draft, SceneError> {
    let mapping = parameters.text("mapping")?.unwrap_or("equalarea");
    if mapping != "equirectangular" {
        let problem =
            format!("the spherical camera has the mapping {}; \"equalarea\" is pbrt's default", shown(mapping));
        return Err(SceneError::new(&parameters.place, problem, "give it \"string mapping\" \"equirectangular\""));
    }
    parameters.pass_over(&["lensradius", "focaldistance"]);
    let turn = DMat4::from_cols(DVec4::Z, DVec4::Y, DVec4::NEG_X, DVec4::W);
    Ok(Draft::new(PluginClass::Sensor, "spherical", &parameters.place)
        .with_float("near_clip", 1e-6)
        .with_float("far_clip", 1e10)
        .with_transform("to_world", to_world * turn))
}
