//! `<Cameras>`: the first one, and the method that it asks for.

use glam::{DMat4, DVec3};

use super::super::changes;
use super::super::draft::Draft;
use super::super::notices::Notices;
use super::super::transform;
use super::super::values::shown;
use super::element::Element;
use crate::scene::description::{PluginClass, Value};
use crate::scene::error::{SceneError, nearest_name};
use crate::scene::notice::Notice;

const TAGS: [&str; 14] = [
    "Position",
    "Gaze",
    "GazePoint",
    "Up",
    "FovY",
    "NearPlane",
    "NearDistance",
    "FocusDistance",
    "ApertureSize",
    "ImageResolution",
    "ImageName",
    "NumSamples",
    "Renderer",
    "RendererParams",
];
/// Depths that are seen: the near plane of the format is where the picture is, and hides nothing.
const CLIP: [f64; 2] = [1e-4, 1e7];
/// The most hit points that a pixel may have.
const MOST_SAMPLES: i64 = 64;

/// The camera that is rendered.
pub(super) struct Camera<'a>(Element<'a>);

impl<'a> Camera<'a> {
    /// The camera of the `wanted` id or index, else the first.
    pub(super) fn find(scene: &Element<'a>, wanted: Option<&str>, notices: &mut Notices) -> Result<Self, SceneError> {
        let list = scene.required("Cameras")?;
        list.report_unknown(&["Camera"], &[], notices);
        let mut cameras: Vec<Element<'a>> = list.all("Camera").collect();
        if cameras.is_empty() {
            return Err(list.error("<Cameras> has no <Camera>", "add one"));
        }
        let names: Vec<&str> = cameras.iter().map(|camera| camera.attribute("id").unwrap_or_default()).collect();
        let chosen = changes::choose(&names, wanted, &list.location())?;
        if let (None, Some(second)) = (wanted, cameras.get(1)) {
            notices.add(Notice::ignored(&second.location(), "every camera but the first", "--camera chooses another"));
        }
        let camera = cameras.swap_remove(chosen);
        camera.report_unknown(&TAGS, &["type", "handedness"], notices);
        Ok(Self(camera))
    }

    /// Camera and film.
    pub(super) fn sensor(&self, notices: &mut Notices) -> Result<Draft, SceneError> {
        let camera = &self.0;
        let location = camera.location();
        let resolution: [f64; 2] = camera.required("ImageResolution")?.tuple()?;
        if !resolution.iter().all(|side| *side >= 1.0 && *side <= f64::from(u32::MAX) && side.fract() == 0.0) {
            let resolution = camera.required("ImageResolution")?;
            return Err(resolution.error("the resolution is no picture", "write width and height in pixels"));
        }
        let [width, height] = resolution.map(|side| Value::Integer(side as i64));
        let film = Draft::new(PluginClass::Film, "hdrfilm", &location).with("width", width).with("height", height);
        let lens = self.lens(notices)?;
        let sensor =
            Draft::new(PluginClass::Sensor, if lens.is_some() { "thinlens" } else { "perspective" }, &location)
                .with_float("fov", self.field_of_view(resolution[0] / resolution[1], notices)?)
                .with_text("fov_axis", "y")
                .with_float("near_clip", CLIP[0])
                .with_float("far_clip", CLIP[1])
                .with_transform("to_world", self.to_world()?);
        let sensor = match lens {
            Some([radius, distance]) => {
                sensor.with_float("aperture_radius", radius).with_float("focus_distance", distance)
            }
            None => sensor,
        };
        Ok(sensor.with_child("", film))
    }

    fn to_world(&self) -> Result<DMat4, SceneError> {
        let camera = &self.0;
        let position: [f64; 3] = camera.required("Position")?.tuple()?;
        let gaze = match camera.child("GazePoint")? {
            Some(point) => DVec3::from_array(point.tuple()?) - DVec3::from_array(position),
            None => DVec3::from_array(camera.required("Gaze")?.tuple()?),
        };
        let up = camera.required("Up")?.tuple()?;
        let turned = transform::look_at([0.0; 3], gaze.to_array(), up)
            .map_err(|_| camera.error("gaze and up give no view", "write two vectors in different directions"))?;
        let mirror = match camera.attribute("handedness") {
            None | Some("right") => 1.0,
            Some("left") => -1.0,
            Some(other) => {
                return Err(camera.error(format!("the handedness is {}", shown(other)), "write right or left"));
            }
        };
        Ok(transform::translate(position) * turned * transform::scale([mirror, 1.0, 1.0]))
    }

    /// The angle of view from bottom to top, degrees, of a picture of this aspect ratio.
    fn field_of_view(&self, aspect: f64, notices: &mut Notices) -> Result<f64, SceneError> {
        if let Some(degrees) = self.0.number_of("FovY")? {
            return Ok(degrees);
        }
        let plane = self.0.required("NearPlane")?;
        let [left, right, bottom, top] = plane.tuple()?;
        let [width, height] = [right - left, top - bottom];
        let distance = self.0.required("NearDistance")?.number()?;
        if !(width > 0.0 && height > 0.0 && distance > 0.0) {
            let remedy =
                "write \"left right bottom top\" with right above left, top above bottom, and a distance above 0";
            return Err(plane.error("the near plane is no picture", remedy));
        }
        let mut approximated = |subject: &str, explanation: &str| {
            notices.add(Notice::approximated(&plane.location(), subject, explanation));
        };
        if (left + right).abs() > 1e-6 * width || (bottom + top).abs() > 1e-6 * height {
            approximated("a near plane off the axis", "the camera looks along <Gaze> through the middle");
        }
        if (width / height / aspect - 1.0).abs() > 1e-3 {
            approximated("pixels that are not square", "the height of the near plane counts");
        }
        Ok(2.0 * libm::atan(0.5 * height / distance).to_degrees())
    }

    /// Radius of the lens and distance of what is sharp, if there is a lens.
    fn lens(&self, notices: &mut Notices) -> Result<Option<[f64; 2]>, SceneError> {
        let side = self.0.number_of("ApertureSize")?.unwrap_or(0.0);
        if side == 0.0 {
            return Ok(None);
        }
        let explanation = "a round one of the same area takes its place";
        notices.add(Notice::approximated(&self.0.location(), "the square aperture", explanation));
        Ok(Some([side / f64::sqrt(std::f64::consts::PI), self.0.required("FocusDistance")?.number()?]))
    }

    /// The method, for paths of `depth` reflections and refractions.
    pub(super) fn integrator(
        &self,
        depth: i64,
        any_specular: bool,
        notices: &mut Notices,
    ) -> Result<Option<Draft>, SceneError> {
        let Some(renderer) = self.0.child("Renderer")? else {
            return Ok(Some(self.direct_light(depth, any_specular, notices)));
        };
        match renderer.word()? {
            "PathTracing" => self.path_tracing(depth, notices).map(Some),
            "ProgressivePhotonMapping" => self.photon_mapping(depth, any_specular, notices).map(Some),
            other => {
                let remedy = nearest_name(other, &["PathTracing", "ProgressivePhotonMapping"]);
                let explanation = format!("the default method renders the scene; {remedy}");
                let subject = format!("renderer {}", shown(other));
                notices.add(Notice::ignored(&renderer.location(), subject, explanation));
                Ok(None)
            }
        }
    }

    fn plugin(&self, name: &str, segments: i64) -> Draft {
        // Longer paths than any method counts are paths of any length.
        let segments = if segments > 1 << 31 { -1 } else { segments };
        let location = self.0.location();
        Draft::new(PluginClass::Integrator, name, &location).with("max_depth", Value::Integer(segments))
    }

    /// Without a renderer light is what comes straight from lights, in mirrors and through glass.
    fn direct_light(&self, depth: i64, any_specular: bool, notices: &mut Notices) -> Draft {
        if !any_specular || depth == 0 {
            return self.plugin("path", 2);
        }
        let explanation = "matte surfaces light each other as well, since mirrors and glass need long paths";
        notices.add(Notice::approximated(&self.0.location(), "ray tracing of direct light", explanation));
        self.plugin("path", depth.saturating_add(2))
    }

    fn path_tracing(&self, depth: i64, notices: &mut Notices) -> Result<Draft, SceneError> {
        const KNOWN: [&str; 3] = ["NextEventEstimation", "ImportanceSampling", "RussianRoulette"];
        let parameters = self.0.child("RendererParams")?;
        let words: Vec<&str> = parameters.iter().flat_map(Element::words).take(64).collect();
        if let Some(element) = parameters {
            for word in words.iter().filter(|word| !KNOWN.contains(word)) {
                let subject = format!("renderer parameter {}", shown(word));
                notices.add(Notice::ignored(&element.location(), subject, nearest_name(word, &KNOWN)));
            }
        }
        let segments = match (words.contains(&KNOWN[2]), words.contains(&KNOWN[0])) {
            (true, _) => -1,
            (false, true) => depth.saturating_add(2),
            (false, false) => depth.saturating_add(1),
        };
        Ok(self.plugin("path", segments))
    }

    fn photon_mapping(&self, depth: i64, any_specular: bool, notices: &mut Notices) -> Result<Draft, SceneError> {
        // Photons meet up to `depth` surfaces, camera paths as many mirrors: one limit holds for both together.
        let segments = if any_specular { depth.saturating_mul(2) } else { depth }.saturating_add(1);
        let explanation = format!("no path from light to camera has more than {segments} segments");
        notices.add(Notice::approximated(
            &self.0.location(),
            "the recursion depths of photons and camera",
            explanation,
        ));
        let (mut alpha, mut passes, mut photons, mut radius) = (0.7, 16, 100_000, 0.5);
        if let Some(parameters) = self.0.child("RendererParams")? {
            parameters.report_unknown(&["Alpha", "ProgressiveCount", "NumPhotons", "R_Initial"], &[], notices);
            let integer = |tag: &str| parameters.child(tag)?.map(|element| element.integer()).transpose();
            alpha = parameters.number_of("Alpha")?.unwrap_or(alpha);
            radius = parameters.number_of("R_Initial")?.unwrap_or(radius);
            passes = integer("ProgressiveCount")?.unwrap_or(passes);
            photons = integer("NumPhotons")?.unwrap_or(photons);
        }
        let mut samples = self.0.child("NumSamples")?.map_or(Ok(1), |element| element.integer())?.max(1);
        if samples > MOST_SAMPLES {
            let explanation = format!("{MOST_SAMPLES} camera paths per pixel are traced");
            notices.add(Notice::approximated(&self.0.location(), "the number of samples", explanation));
            samples = MOST_SAMPLES;
        }
        Ok(self
            .plugin("ppm", segments)
            .with_float("alpha", alpha)
            .with("passes", Value::Integer(passes))
            .with("photons_per_pass", Value::Integer(photons))
            .with_float("initial_radius", radius)
            .with("samples_per_pixel", Value::Integer(samples)))
    }
}
