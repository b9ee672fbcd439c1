//! What stands before `WorldBegin`: camera, film, pixel filter, integrator.

use glam::DMat4;

use super::super::draft::Draft;
use super::super::values::shown;
use super::camera;
use super::medium::MediumId;
use super::output::{Output, with_integer};
use super::parameters::Parameters;
use crate::scene::description::PluginClass;
use crate::scene::error::{Location, SceneError, nearest_name, shown_number};

/// A directive with its first string.
pub(super) struct Directive {
    pub name: String,
    pub parameters: Parameters,
}

/// The last of each directive, which is the one that counts.
#[derive(Default)]
pub(super) struct Options {
    /// With the transform from the world to it.
    pub camera: Option<(Directive, DMat4)>,
    pub film: Option<Directive>,
    pub filter: Option<Directive>,
    pub integrator: Option<Directive>,
    /// The id of the medium that the camera stands in.
    pub camera_medium: MediumId,
}

impl Options {
    /// Whether the integrator has this name.
    pub(super) fn has_method(&self, name: &str) -> bool {
        self.integrator.as_ref().is_some_and(|integrator| integrator.name == name)
    }

    /// The sensor and the integrator, of a scene in which shapes separate media or none do.
    ///
    /// # Errors
    /// Without a camera; as [`camera::sensor`].
    pub(super) fn plugins(
        &self,
        place: &Location,
        has_media: bool,
        output: &mut Output<'_>,
    ) -> Result<[Draft; 2], SceneError> {
        let Some((camera, from_world)) = &self.camera else {
            let remedy = "add a Camera before WorldBegin, and pass the main file, not an included one";
            return Err(SceneError::new(place, "the scene has no Camera", remedy));
        };
        let film = self.film(place, output)?;
        let sensor = camera::sensor(camera, *from_world, film, output)?;
        let sensor = match &self.camera_medium {
            Some(id) => sensor.with_reference(id),
            None => sensor,
        };
        let has_media = has_media || self.camera_medium.is_some();
        Ok([sensor, self.method(place, has_media, output)?])
    }

    /// The film, and the size of the whole picture, pixels.
    fn film(&self, place: &Location, output: &mut Output<'_>) -> Result<(Draft, [i64; 2]), SceneError> {
        let filter = self.pixel_filter(place, output)?;
        let Some(Directive { name, parameters }) = &self.film else {
            let film = with_integer(Draft::new(PluginClass::Film, "hdrfilm", place), "width", 1280);
            return Ok((with_integer(film, "height", 720).with_child("", filter), [1280, 720]));
        };
        match name.as_str() {
            "rgb" => {}
            "gbuffer" | "spectral" => {
                let subject = format!("film {}", shown(name));
                output.approximated(&parameters.place, subject, "the picture is a film \"rgb\"");
            }
            _ => {
                let problem = format!("there is no film {}", shown(name));
                let remedy = nearest_name(name, &["rgb", "gbuffer", "spectral"]);
                return Err(SceneError::new(&parameters.place, problem, remedy));
            }
        }
        let side = |name: &str, default: i64| -> Result<i64, SceneError> {
            match parameters.integer(name)?.unwrap_or(default) {
                pixels if (1..=1 << 28).contains(&pixels) => Ok(pixels),
                pixels => {
                    let problem = format!("\"{name}\" is {}", shown_number(pixels));
                    Err(SceneError::new(&parameters.place, problem, "give a number of pixels above 0"))
                }
            }
        };
        let size = [side("xresolution", 1280)?, side("yresolution", 720)?];
        let film = Draft::new(PluginClass::Film, "hdrfilm", &parameters.place);
        let film = with_integer(with_integer(film, "width", size[0]), "height", size[1]);
        let film = window(film, size, parameters)?;
        parameters.pass_over(&["filename", "savefp16", "diagonal"]);
        output.report_unused(&format!("film {}", shown(name)), parameters)?;
        // pbrt's camera paths start wherever a pixel's filter reaches.
        Ok((film.with_flag("sample_border", true).with_child("", filter), size))
    }

    fn pixel_filter(&self, place: &Location, output: &mut Output<'_>) -> Result<Draft, SceneError> {
        let plugin = |plugin: &str, place: &Location| Draft::new(PluginClass::ReconstructionFilter, plugin, place);
        let Some(Directive { name, parameters }) = &self.filter else {
            return Ok(plugin("gaussian", place).with_float("stddev", 0.5));
        };
        let place = &parameters.place;
        let default = match name.as_str() {
            "box" => 0.5,
            "triangle" | "mitchell" => 2.0,
            "gaussian" => 1.5,
            "sinc" => 4.0,
            _ => {
                let remedy = nearest_name(name, &["box", "triangle", "mitchell", "gaussian", "sinc"]);
                return Err(SceneError::new(place, format!("there is no pixel filter {}", shown(name)), remedy));
            }
        };
        let [x, y] = ["xradius", "yradius"].map(|name| parameters.float(name));
        let (x, y) = (x?.unwrap_or(default), y?.unwrap_or(default));
        if x != y {
            output.approximated(place, "a pixel filter of two radii", "their mean takes their place");
        }
        let radius = 0.5 * (x + y);
        let filter = match name.as_str() {
            "box" => plugin("box", place).with_float("radius", radius),
            "triangle" => plugin("tent", place).with_float("radius", radius),
            "gaussian" => {
                let stddev = parameters.float("sigma")?.unwrap_or(0.5);
                if (radius - 4.0 * stddev).abs() > 1.01 * stddev {
                    let instead = "it ends at four standard deviations";
                    output.approximated(
                        place,
                        format!("a gaussian filter of radius {}", shown_number(radius)),
                        instead,
                    );
                }
                plugin("gaussian", place).with_float("stddev", stddev)
            }
            "mitchell" => {
                if radius != 2.0 {
                    output.approximated(
                        place,
                        format!("a mitchell filter of radius {}", shown_number(radius)),
                        "its radius is 2",
                    );
                }
                let [b, c] = ["B", "C"].map(|name| parameters.float(name));
                let third = 1.0 / 3.0;
                plugin("mitchell", place).with_float("B", b?.unwrap_or(third)).with_float("C", c?.unwrap_or(third))
            }
            _ => {
                let tau = parameters.float("tau")?.unwrap_or(3.0);
                let lobes = tau.round();
                if tau != lobes || radius != lobes {
                    let subject =
                        format!("a sinc filter of radius {} and tau {}", shown_number(radius), shown_number(tau));
                    output.approximated(
                        place,
                        subject,
                        format!("a lanczos filter of {} lobes takes its place", shown_number(lobes)),
                    );
                }
                with_integer(plugin("lanczos", place), "lobes", lobes as i64)
            }
        };
        output.report_unused(&format!("pixel filter {}", shown(name)), parameters)?;
        Ok(filter)
    }

    /// pbrt counts how often light is scattered, photonfarm the segments of its path: one more.
    fn method(&self, place: &Location, has_media: bool, output: &mut Output<'_>) -> Result<Draft, SceneError> {
        const DEPTH: i64 = 5;
        let draft = |name: &str, place: &Location| Draft::new(PluginClass::Integrator, name, place);
        let volumetric = if has_media { "volpath" } else { "path" };
        let Some(Directive { name, parameters }) = &self.integrator else {
            return Ok(with_integer(draft(volumetric, place), "max_depth", DEPTH + 1));
        };
        let place = &parameters.place;
        let (plugin, replaced) = match name.as_str() {
            "path" | "simplepath" => ("path", false),
            "volpath" | "simplevolpath" => (volumetric, name == "simplevolpath"),
            "bdpt" | "mlt" if has_media => (volumetric, true),
            "bdpt" => ("bdpt", false),
            "sppm" => ("sppm", false),
            "lightpath" => ("ptracer", false),
            "mlt" => ("bdpt", true),
            "ao" | "ambientocclusion" | "function" | "randomwalk" => ("path", true),
            _ => {
                let known = ["path", "volpath", "bdpt", "mlt", "sppm", "simplepath", "lightpath", "randomwalk"];
                let problem = format!("there is no integrator {}", shown(name));
                return Err(SceneError::new(place, problem, nearest_name(name, &known)));
            }
        };
        if replaced {
            let subject = format!("integrator {}", shown(name));
            output.approximated(place, subject, format!("\"{plugin}\" takes its place"));
        }
        let depth = match parameters.integer("maxdepth")?.unwrap_or(DEPTH) {
            depth if (0..1 << 31).contains(&depth) => depth,
            depth => {
                let problem = format!("\"maxdepth\" is {depth}");
                return Err(SceneError::new(place, problem, "give a whole number of at least 0"));
            }
        };
        let mut method = with_integer(draft(plugin, place), "max_depth", depth + 1);
        if plugin == "sppm" {
            output.approximated(place, "\"maxdepth\" of \"sppm\"", "it limits whole paths, not both of their parts");
            if let Some(photons) = parameters.integer("photonsperiteration")?.filter(|photons| *photons > 0) {
                method = with_integer(method, "photons_per_pass", photons);
            }
            if let Some(radius) = parameters.float("radius")? {
                method = method.with_float("initial_radius", radius);
            }
            parameters.pass_over(&["seed"]);
        }
        // They choose how pbrt finds the same light.
        let details = ["lightsampler", "rrthreshold", "samplelights", "samplebsdf", "visualizestrategies"];
        parameters.pass_over(&details);
        parameters.pass_over(&["visualizeweights", "bootstrapsamples", "chains", "mutationsperpixel"]);
        parameters.pass_over(&["largestepprobability", "sigma"]);
        output.report_unused(&format!("integrator {}", shown(name)), parameters)?;
        Ok(method)
    }
}

/// The part of the film that is rendered, in shares of its sides or in pixels.
fn window(film: Draft, size: [i64; 2], parameters: &Parameters) -> Result<Draft, SceneError> {
    let crop = parameters.numbers("cropwindow", 4)?;
    let pixels = parameters.numbers("pixelbounds", 4)?;
    let (edges, is_share) = match (crop, pixels) {
        (None, None) => return Ok(film),
        (_, Some(pixels)) => (pixels, false),
        (Some(crop), None) => (crop, true),
    };
    let mut film = film;
    for (axis, [offset, count]) in
        [["crop_offset_x", "crop_width"], ["crop_offset_y", "crop_height"]].iter().enumerate()
    {
        let whole = size[axis];
        let edge = |index: usize| {
            let place = edges[2 * axis + index];
            let pixel = if is_share { (place * whole as f64).ceil() } else { place };
            (pixel.is_finite() && (0.0..=whole as f64).contains(&pixel)).then_some(pixel as i64)
        };
        let (Some(first), Some(end)) = (edge(0), edge(1)) else {
            let remedy = "write x0 x1 y0 y1, shares from 0 to 1";
            return Err(SceneError::new(&parameters.place, "the crop window leaves the film", remedy));
        };
        if first >= end {
            return Err(SceneError::new(&parameters.place, "the crop window is empty", "write x0 x1 y0 y1"));
        }
        film = with_integer(with_integer(film, offset, first), count, end - first);
    }
    Ok(film)
}
