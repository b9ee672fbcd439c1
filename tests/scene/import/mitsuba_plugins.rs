//! The tables of Mitsuba 3's plugins say what happens: a scene with each plugin and each parameter is loaded, and what is said to be the
//! same changes the scene, what is passed over does not, and what is refused is an error.

use std::io::Write as _;
use std::path::Path;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use photonfarm::farm::method_choice::{choice, without_passed_over};
use photonfarm::import::compatibility::Support;
use photonfarm::import::load_bytes;
use photonfarm::import::mitsuba_plugins::{CLASSES, Parameters, Plugin, markdown};
use photonfarm::math::Vec3;
use photonfarm::method;
use photonfarm::scene::Scene;
use photonfarm::scene::bundle::{Bundle, Files};
use photonfarm::scene::description::PluginClass;
use photonfarm::scene::geometry::{Interaction, Ray};

/// What a plugin must hold besides the parameter in question.
const NEEDED: &[(&str, &str)] = &[
    ("blendbsdf", "<float name='weight' value='0.4'/><bsdf type='diffuse'/><bsdf type='conductor'/>"),
    ("bumpmap", "<bsdf type='diffuse'/><texture type='checkerboard'/>"),
    ("mask", "<bsdf type='diffuse'/>"),
    ("normalmap", "<bsdf type='diffuse'/><texture name='normalmap' type='checkerboard'/>"),
    ("twosided", "<bsdf type='diffuse'/>"),
    ("instance", "<shape type='shapegroup'><shape type='cube'/></shape>"),
    ("shapegroup", "<shape type='cube'/>"),
    ("obj", "<string name='filename' value='gem.obj'/>"),
    ("ply", "<string name='filename' value='gem.ply'/>"),
    ("serialized", "<string name='filename' value='two.serialized'/>"),
    ("bitmap", "<string name='filename' value='tile.png'/>"),
    ("envmap", "<string name='filename' value='sky.exr'/>"),
    ("thinlens", "<float name='aperture_radius' value='0.1'/>"),
    ("blackbody", "<float name='temperature' value='4000'/>"),
    ("irregular", "<string name='wavelengths' value='400, 500, 700'/><string name='values' value='1, 2, 3'/>"),
    (
        "regular",
        "<float name='wavelength_min' value='400'/><float name='wavelength_max' value='700'/><string name='values' value='1, 2, 3'/>",
    ),
    ("srgb", "<rgb name='color' value='0.5, 0.4, 0.3'/>"),
    ("constvolume", "<float name='value' value='0.6'/>"),
    ("gridvolume", "<string name='filename' value='grid.vol'/>"),
    ("linearcurve", "<string name='filename' value='curves.txt'/>"),
    ("bsplinecurve", "<string name='filename' value='curves.txt'/>"),
    ("merge", "<shape type='cube'/>"),
    ("batch", "<sensor type='perspective'/>"),
    ("mesh_attribute", "<string name='name' value='vertex_color'/>"),
    ("aov", "<integrator type='path'/>"),
    ("moment", "<integrator type='path'/>"),
    ("stokes", "<integrator type='path'/>"),
];

const METER: &str = "<point name='origin' z='3'/><vector name='direction' x='0.1' z='-1'/>";

/// Values that are no defaults, as XML; those of a certain plugin come first.
const VALUES: &[(&str, &str, &str)] = &[
    ("area", "radiance", "<rgb name='radiance' value='3, 2, 1'/>"),
    ("constvolume", "value", "<float name='value' value='0.3'/>"),
    ("sunsky", "albedo", "<rgb name='albedo' value='0.8'/>"),
    ("distant", "direction", "<vector name='direction' x='0.1' z='-1'/>"),
    ("distant", "target", "<point name='target' x='0.3'/>"),
    ("radiancemeter", "origin", METER),
    ("radiancemeter", "direction", METER),
    ("timed_sunsky", "albedo", "<rgb name='albedo' value='0.8'/>"),
    ("timed_sunsky", "shutter_open", "<float name='shutter_open' value='-1'/>"),
    ("timed_sunsky", "shutter_close", "<float name='shutter_close' value='2'/>"),
    ("", "start_year", "<integer name='start_year' value='2027'/>"),
    ("", "start_month", "<integer name='start_month' value='3'/>"),
    ("", "start_day", "<integer name='start_day' value='8'/>"),
    ("", "end_year", "<integer name='end_year' value='2027'/>"),
    ("", "end_month", "<integer name='end_month' value='3'/>"),
    ("", "end_day", "<integer name='end_day' value='9'/>"),
    ("", "window_start_time", "<float name='window_start_time' value='8'/>"),
    ("", "window_end_time", "<float name='window_end_time' value='17'/>"),
    ("linearcurve", "filename", "<string name='filename' value='others.txt'/>"),
    ("bsplinecurve", "filename", "<string name='filename' value='others.txt'/>"),
    ("mesh_attribute", "name", "<string name='name' value='vertex_heat'/>"),
    ("mesh_attribute", "scale", "<float name='scale' value='2'/>"),
    ("principledthin", "eta", "<float name='eta' value='1.7'/>"),
    ("gridvolume", "wrap_mode", "<string name='wrap_mode' value='repeat'/>"),
    ("gridvolume", "filename", "<string name='filename' value='other.vol'/>"),
    ("normalmap", "normalmap", ""),
    ("obj", "flip_tex_coords", "<boolean name='flip_tex_coords' value='false'/>"),
    ("obj", "filename", "<string name='filename' value='other.obj'/>"),
    ("ply", "filename", "<string name='filename' value='other.ply'/>"),
    ("serialized", "filename", "<string name='filename' value='other.serialized'/>"),
    ("envmap", "filename", "<string name='filename' value='other.exr'/>"),
    ("bitmap", "filename", "<string name='filename' value='grey.png'/>"),
    ("rawconstant", "value", "<vector name='value' value='0.3, 0.2, 0.1'/>"),
    ("srgb", "unbounded", "<boolean name='unbounded' value='true'/>"),
    ("spot", "texture", "<texture name='texture' type='checkerboard'/>"),
    ("thinlens", "focus_distance", "<float name='focus_distance' value='3'/>"),
    ("roughconductor", "alpha_u", "<float name='alpha_u' value='0.3'/><float name='alpha_v' value='0.1'/>"),
    ("roughconductor", "alpha_v", "<float name='alpha_u' value='0.1'/><float name='alpha_v' value='0.3'/>"),
    ("roughdielectric", "alpha_u", "<float name='alpha_u' value='0.3'/><float name='alpha_v' value='0.1'/>"),
    ("roughdielectric", "alpha_v", "<float name='alpha_u' value='0.1'/><float name='alpha_v' value='0.3'/>"),
    ("conductor", "eta", "<rgb name='eta' value='0.2'/><rgb name='k' value='3'/>"),
    ("conductor", "k", "<rgb name='eta' value='0.2'/><rgb name='k' value='3'/>"),
    ("roughconductor", "eta", "<rgb name='eta' value='0.2'/><rgb name='k' value='3'/>"),
    ("roughconductor", "k", "<rgb name='eta' value='0.2'/><rgb name='k' value='3'/>"),
    ("principled", "eta", "<float name='eta' value='1.7'/>"),
    ("projector", "fov_axis", "<float name='fov' value='50'/><string name='fov_axis' value='diagonal'/>"),
    ("perspective", "fov_axis", "<float name='fov' value='50'/><string name='fov_axis' value='diagonal'/>"),
    ("thinlens", "fov_axis", "<float name='fov' value='50'/><string name='fov_axis' value='diagonal'/>"),
    ("", "complex_sun", "<boolean name='complex_sun' value='true'/>"),
    ("", "day", "<integer name='day' value='20'/>"),
    ("", "diff_trans", "<float name='diff_trans' value='0.5'/>"),
    ("", "diffuse_transmittance_sampling_rate", "<float name='diffuse_transmittance_sampling_rate' value='0.5'/>"),
    ("", "hour", "<float name='hour' value='14'/>"),
    ("", "latitude", "<float name='latitude' value='20'/>"),
    ("", "longitude", "<float name='longitude' value='130'/>"),
    ("", "minute", "<float name='minute' value='30'/>"),
    ("", "month", "<integer name='month' value='5'/>"),
    ("", "second", "<float name='second' value='30'/>"),
    ("", "sky_scale", "<float name='sky_scale' value='2'/>"),
    ("", "specular_reflectance_sampling_rate", "<float name='specular_reflectance_sampling_rate' value='0.5'/>"),
    ("", "specular_transmittance_sampling_rate", "<float name='specular_transmittance_sampling_rate' value='0.5'/>"),
    ("", "sun_aperture", "<float name='sun_aperture' value='2'/>"),
    ("", "sun_direction", "<vector name='sun_direction' value='0, 0.6, 0.8'/>"),
    ("", "sun_scale", "<float name='sun_scale' value='2'/>"),
    ("", "timezone", "<float name='timezone' value='8'/>"),
    ("", "turbidity", "<float name='turbidity' value='5'/>"),
    ("", "year", "<integer name='year' value='2012'/>"),
    ("", "max_value", "<float name='max_value' value='1'/>"),
    ("", "use_grid_bbox", "<boolean name='use_grid_bbox' value='true'/>"),
    ("", "accel", "<boolean name='accel' value='false'/>"),
    ("", "albedo", "<rgb name='albedo' value='0.3'/>"),
    ("", "alpha", "<float name='alpha' value='0.35'/>"),
    ("", "alpha_u", "<float name='alpha_u' value='0.35'/>"),
    ("", "alpha_v", "<float name='alpha_v' value='0.35'/>"),
    ("", "anisotropic", "<float name='anisotropic' value='0.5'/>"),
    ("", "aovs", "<string name='aovs' value='dd:depth'/>"),
    ("", "aperture_radius", "<float name='aperture_radius' value='0.3'/>"),
    ("", "B", "<float name='B' value='0.1'/>"),
    ("", "banner", "<boolean name='banner' value='false'/>"),
    ("", "base_color", "<rgb name='base_color' value='0.2'/>"),
    ("", "beam_width", "<float name='beam_width' value='7'/>"),
    ("", "bitmap", "<string name='bitmap' value='x'/>"),
    ("", "block_size", "<integer name='block_size' value='8'/>"),
    ("", "bsdf_samples", "<integer name='bsdf_samples' value='0'/>"),
    ("", "C", "<float name='C' value='0.1'/>"),
    ("", "center", "<point name='center' x='0.3'/>"),
    ("", "clearcoat", "<float name='clearcoat' value='0.5'/>"),
    ("", "clearcoat_gloss", "<float name='clearcoat' value='1'/><float name='clearcoat_gloss' value='0.5'/>"),
    ("", "clearcoat_sampling_rate", "<float name='clearcoat_sampling_rate' value='0.5'/>"),
    ("", "color", "<rgb name='color' value='0.2'/>"),
    ("", "color0", "<rgb name='color0' value='0.9'/>"),
    ("", "color1", "<rgb name='color1' value='0.9'/>"),
    ("", "compensate", "<boolean name='compensate' value='true'/>"),
    ("", "component_format", "<string name='component_format' value='float32'/>"),
    ("", "crop_height", "<integer name='crop_height' value='5'/>"),
    ("", "crop_offset_x", "<integer name='crop_offset_x' value='5'/>"),
    ("", "crop_offset_y", "<integer name='crop_offset_y' value='5'/>"),
    ("", "crop_width", "<integer name='crop_width' value='5'/>"),
    ("", "cutoff_angle", "<float name='cutoff_angle' value='30'/>"),
    ("", "grid", "<string name='grid' value='x'/>"),
    ("", "data", "<string name='data' value='x'/>"),
    ("", "diffuse_reflectance", "<rgb name='diffuse_reflectance' value='0.2'/>"),
    ("", "diffuse_reflectance_sampling_rate", "<float name='diffuse_reflectance_sampling_rate' value='0.5'/>"),
    ("", "direction", "<vector name='direction' x='1'/>"),
    ("", "distribution", "<string name='distribution' value='ggx'/>"),
    ("", "emitter_samples", "<integer name='emitter_samples' value='0'/>"),
    ("", "eta", "<rgb name='eta' value='0.4'/>"),
    ("", "ext_ior", "<float name='ext_ior' value='1.2'/>"),
    ("", "face_normals", "<boolean name='face_normals' value='true'/>"),
    ("", "far_clip", "<float name='far_clip' value='100'/>"),
    ("", "file_format", "<string name='file_format' value='openexr'/>"),
    ("", "filter_type", "<string name='filter_type' value='nearest'/>"),
    ("", "flatness", "<float name='flatness' value='0.5'/>"),
    ("", "flip_invalid_normals", "<boolean name='flip_invalid_normals' value='false'/>"),
    ("", "flip_normals", "<boolean name='flip_normals' value='true'/>"),
    ("", "flip_tex_coords", "<boolean name='flip_tex_coords' value='true'/>"),
    ("", "focal_length", "<string name='focal_length' value='80mm'/>"),
    ("", "focus_distance", "<float name='focus_distance' value='3'/>"),
    ("", "format", "<string name='format' value='fp16'/>"),
    ("", "fov", "<float name='fov' value='50'/>"),
    ("", "g", "<float name='g' value='0.1'/>"),
    ("", "has_spectral_extinction", "<boolean name='has_spectral_extinction' value='false'/>"),
    ("", "height", "<integer name='height' value='20'/>"),
    ("", "hide_emitters", "<boolean name='hide_emitters' value='true'/>"),
    ("", "int_ior", "<float name='int_ior' value='1.7'/>"),
    ("", "intensity", "<rgb name='intensity' value='3'/>"),
    ("", "irradiance", "<rgb name='irradiance' value='3'/>"),
    ("", "jitter", "<boolean name='jitter' value='false'/>"),
    ("", "lobes", "<integer name='lobes' value='2'/>"),
    ("", "main_specular_sampling_rate", "<float name='main_specular_sampling_rate' value='0.5'/>"),
    ("", "material", "<string name='material' value='Au'/>"),
    ("", "max_depth", "<integer name='max_depth' value='4'/>"),
    ("", "metallic", "<float name='metallic' value='0.5'/>"),
    ("", "mis_compensation", "<boolean name='mis_compensation' value='true'/>"),
    ("", "near_clip", "<float name='near_clip' value='0.1'/>"),
    ("", "nonlinear", "<boolean name='nonlinear' value='true'/>"),
    ("", "opacity", "<float name='opacity' value='0.3'/>"),
    ("", "p0", "<point name='p0' x='0.3'/>"),
    ("", "p1", "<point name='p1' x='0.3' z='2'/>"),
    ("", "pixel_format", "<string name='pixel_format' value='rgb'/>"),
    ("", "position", "<point name='position' x='0.3'/>"),
    ("", "principal_point_offset_x", "<float name='principal_point_offset_x' value='0.1'/>"),
    ("", "principal_point_offset_y", "<float name='principal_point_offset_y' value='0.1'/>"),
    ("", "radiance", "<rgb name='radiance' value='3'/>"),
    ("", "radius", "<float name='radius' value='0.7'/>"),
    ("", "raw", "<boolean name='raw' value='true'/>"),
    ("", "reflectance", "<rgb name='reflectance' value='0.2'/>"),
    ("", "roughness", "<float name='roughness' value='0.2'/>"),
    ("", "rr_depth", "<integer name='rr_depth' value='3'/>"),
    ("", "sample_border", "<boolean name='sample_border' value='true'/>"),
    ("", "sample_count", "<integer name='sample_count' value='16'/>"),
    ("", "sample_emitters", "<boolean name='sample_emitters' value='false'/>"),
    ("", "sample_visible", "<boolean name='sample_visible' value='false'/>"),
    ("", "samples_per_pass", "<integer name='samples_per_pass' value='4'/>"),
    ("", "sampling_weight", "<float name='sampling_weight' value='2'/>"),
    ("", "scale", "<float name='scale' value='2'/>"),
    ("", "seed", "<integer name='seed' value='2'/>"),
    ("", "shading_samples", "<integer name='shading_samples' value='0'/>"),
    ("", "shape_index", "<integer name='shape_index' value='1'/>"),
    ("", "sheen", "<float name='sheen' value='0.5'/>"),
    ("", "sheen_tint", "<float name='sheen' value='1'/><float name='sheen_tint' value='0.5'/>"),
    ("", "shutter_close", "<float name='shutter_close' value='1'/>"),
    ("", "shutter_open", "<float name='shutter_open' value='0.1'/><float name='shutter_close' value='1'/>"),
    ("", "sigma_t", "<rgb name='sigma_t' value='0.3'/>"),
    ("", "silhouette_sampling_weight", "<float name='silhouette_sampling_weight' value='2'/>"),
    ("", "spec_tint", "<float name='spec_tint' value='0.5'/>"),
    ("", "spec_trans", "<float name='spec_trans' value='0.5'/>"),
    ("", "specular", "<float name='specular' value='0.2'/>"),
    ("", "specular_reflectance", "<rgb name='specular_reflectance' value='0.2'/>"),
    ("", "specular_transmittance", "<rgb name='specular_transmittance' value='0.2'/>"),
    ("", "srf", "<spectrum name='srf' value='400:1, 700:1'/>"),
    ("", "stddev", "<float name='stddev' value='0.8'/>"),
    ("", "strength", "<integer name='strength' value='2'/>"),
    ("", "temperature", "<float name='temperature' value='3000'/>"),
    ("", "timeout", "<float name='timeout' value='1000'/>"),
    ("", "to_uv", "<transform name='to_uv'><scale value='2'/></transform>"),
    ("", "to_world", "<transform name='to_world'><rotate x='1' angle='40'/><translate x='0.2'/></transform>"),
    ("", "use_shadowing_function", "<boolean name='use_shadowing_function' value='false'/>"),
    ("", "value", "<float name='value' value='0.3'/>"),
    ("", "values", "<string name='values' value='3, 1, 2'/>"),
    ("", "wavelength_max", "<float name='wavelength_max' value='650'/>"),
    ("", "wavelength_min", "<float name='wavelength_min' value='450'/>"),
    ("", "wavelengths", "<string name='wavelengths' value='400, 600, 700'/>"),
    ("", "weight", "<float name='weight' value='0.7'/>"),
    ("", "width", "<integer name='width' value='20'/>"),
    ("", "wrap_mode", "<string name='wrap_mode' value='clamp'/>"),
];

fn needed(plugin: &str) -> &'static str {
    NEEDED.iter().find(|(name, _)| *name == plugin).map_or("", |(_, xml)| *xml)
}

fn value(plugin: &str, parameter: &str) -> &'static str {
    let of = |owner: &str| VALUES.iter().find(|(name, known, _)| *name == owner && *known == parameter);
    let found = of(plugin).or_else(|| of("")).unwrap_or_else(|| panic!("no value for {parameter} of {plugin}"));
    found.2
}

/// `needed` without what `given` gives.
fn without_given(needed: &str, given: &str) -> String {
    let name = |xml: &str| xml.split_once("name='").map(|(_, rest)| rest.split('\'').next().unwrap_or("").to_owned());
    let names: Vec<String> = given.split('<').filter_map(name).collect();
    let kept = needed.split_inclusive("/>").filter(|part| name(part).is_none_or(|name| !names.contains(&name)));
    kept.collect()
}

/// Everything of a scene with one plugin that decides how it looks; its own files are beside it.
fn outcome(class: PluginClass, title: &str, plugin: &str, given: &str) -> Result<String, String> {
    let node = |tag: &str, name: &str| {
        let inside = without_given(needed(plugin), given) + given;
        format!("<{tag}{name} type='{plugin}'>{inside}</{tag}>")
    };
    let [mut film, mut sensor, mut light] = [
        "<film type='hdrfilm'/>",
        "<sensor type='perspective'><transform name='to_world'><translate z='-6'/></transform>FILM</sensor>",
        "<emitter type='constant'/>",
    ]
    .map(str::to_owned);
    let (mut shape, mut integrator_node) = ("<shape type='cube'/>".to_owned(), String::new());
    match class {
        PluginClass::Bsdf => shape = format!("<shape type='sphere'>{}</shape>", node("bsdf", "")),
        PluginClass::Texture if title == "Spectra" => {
            light = format!("<emitter type='constant'>{}</emitter>", node("spectrum", " name='radiance'"));
        }
        PluginClass::Texture if plugin == "mesh_attribute" => {
            let texture = node("texture", " name='radiance'");
            let file = "<string name='filename' value='painted.ply'/>";
            shape = format!("<shape type='ply'>{file}<emitter type='area'>{texture}</emitter></shape>");
        }
        PluginClass::Texture => {
            // The power of a light shows what its texture makes of an image.
            let texture = node("texture", " name='radiance'");
            shape = format!("<shape type='sphere'><emitter type='area'>{texture}</emitter></shape>");
        }
        PluginClass::Emitter if plugin == "area" => {
            shape = format!("<shape type='sphere'>{}</shape>", node("emitter", ""));
        }
        PluginClass::Emitter if plugin == "directionalarea" => {
            shape = format!("<shape type='rectangle'>{}</shape>", node("emitter", ""));
        }
        PluginClass::Emitter => {
            light = node("emitter", "");
            if plugin == "timed_sunsky" {
                // One instant of the span: a whole one becomes a map, of which `{:?}` tells no texels.
                let instant = "<float name='shutter_open' value='0.3'/><float name='shutter_close' value='0.3'/>FILM";
                sensor = sensor.replace("FILM", instant);
            }
        }
        PluginClass::Sensor => {
            sensor = node("sensor", "").replace("</sensor>", "FILM</sensor>");
            if ["distant", "radiancemeter"].contains(&plugin) {
                film = one_pixel();
            }
        }
        PluginClass::Film => film = node("film", ""),
        PluginClass::ReconstructionFilter => film = format!("<film type='hdrfilm'>{}</film>", node("rfilter", "")),
        PluginClass::Sampler => film += &node("sampler", ""),
        PluginClass::Shape if ["instance", "merge", "shapegroup"].contains(&plugin) => shape += &node("shape", ""),
        PluginClass::Shape => {
            let pattern = "<bsdf type='diffuse'><texture name='reflectance' type='checkerboard'/></bsdf></shape>";
            shape = node("shape", "").replace("</shape>", pattern);
        }
        PluginClass::Medium => shape = in_medium(&node("medium", " name='interior'")),
        PluginClass::Phase => {
            shape = in_medium(&format!("<medium name='interior' type='homogeneous'>{}</medium>", node("phase", "")));
        }
        PluginClass::Volume => {
            let volume = node("volume", " name='albedo'");
            shape = in_medium(&format!("<medium name='interior' type='heterogeneous'>{volume}</medium>"));
        }
        PluginClass::Integrator => integrator_node = node("integrator", ""),
        PluginClass::Scene => panic!("a scene is no plugin of a scene"),
    }
    let text =
        format!("<scene version='3.0.0'>{integrator_node}{}{shape}{light}</scene>", sensor.replace("FILM", &film));
    let mut description = load_bytes("a.xml", text.as_bytes(), &[]).map_err(|error| error.to_string())?;
    description.bundle = Bundle::Archive(files().into());
    let scene = Scene::prepare(&description).map_err(|error| error.to_string())?;
    let integrator = scene.integrator.as_ref().map(|integrator| without_passed_over(integrator).0);
    let method = integrator.as_ref().map_or("path", |integrator| integrator.name.as_str());
    let choice = choice(method, &serde_json::Map::new(), integrator.as_ref());
    method::check(&choice, 64).map_err(|error| error.to_string())?;
    let primitives: Vec<_> =
        (0..scene.geometry.primitive_count()).map(|index| scene.geometry.primitive(index as u32)).collect();
    let geometry = format!("{primitives:?} {:?} {:?}", scene.geometry.bounds(), hits(&scene));
    Ok(format!(
        "{geometry} {:?} {:?} {:?} {:?} {:?} {} {:?}",
        scene.materials,
        scene.lights.lights(),
        scene.camera,
        scene.film,
        scene.integrator,
        scene.hides_lights,
        scene.media
    ))
}
fn one_pixel() -> String {
    "<film type='hdrfilm'><integer name='width' value='1'/><integer name='height' value='1'/></film>".to_owned()
}

/// What some rays meet: places, normals and texture coordinates.
fn hits(scene: &Scene) -> Vec<String> {
    let origins = [Vec3::new(0.3, 0.2, 3.0), Vec3::new(0.1, -3.0, 0.4), Vec3::new(2.5, 0.6, 0.3)];
    let hit = |origin: &Vec3| scene.intersect(&Ray::new(*origin, (Vec3::new(0.05, 0.1, 0.02) - *origin).normalize()));
    let told = |hit: Option<Interaction>| hit.map(|hit| format!("{:?} {:?} {:?}", hit.position, hit.frame, hit.uv));
    origins.iter().map(|origin| told(hit(origin)).unwrap_or_default()).collect()
}

/// A cube of a medium.
fn in_medium(medium: &str) -> String {
    format!("<shape type='cube'><bsdf type='null'/>{medium}</shape>")
}

/// The files that the scenes name.
fn files() -> Files {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/mitsuba_scenes/files");
    let read = |name: &str| std::fs::read(folder.join(name)).expect("the file is there");
    let changed = |name: &str| {
        let text = String::from_utf8(read(name)).expect("meshes are text");
        text.replace("0.2 0.8", "0.3 0.9").into_bytes()
    };
    let mut files: Files = ["gem.obj", "gem.ply", "tile.png", "grey.png", "sky.exr"]
        .map(|name| (name.to_owned(), read(name).into()))
        .into();
    files.insert("other.obj".to_owned(), changed("gem.obj").into());
    files.insert("other.ply".to_owned(), changed("gem.ply").into());
    files.insert("other.exr".to_owned(), read("half.exr").into());
    files.insert("curves.txt".to_owned(), curve(0.1).into());
    files.insert("others.txt".to_owned(), curve(0.2).into());
    files.insert("painted.ply".to_owned(), PAINTED.as_bytes().into());
    files.insert("grid.vol".to_owned(), grid(0.4).into());
    files.insert("other.vol".to_owned(), grid(0.3).into());
    files.insert("two.serialized".to_owned(), serialized(&[1.0, 2.0]).into());
    files.insert("other.serialized".to_owned(), serialized(&[1.5]).into());
    files
}

/// A triangle with a color and a number at each vertex.
const PAINTED: &str = "ply\nformat ascii 1.0\nelement vertex 3\nproperty float x\nproperty float y\nproperty float z\n\
    property float r\nproperty float g\nproperty float b\nproperty float heat_0\nelement face 1\n\
    property list uchar int vertex_indices\nend_header\n0 0 0 1 0 0 3\n1 0 0 0 1 0 4\n0 1 0 0 0 1 5\n3 0 1 2\n";

/// Control points of one curve, with radii.
fn curve(radius: f32) -> Vec<u8> {
    format!("0 0 0 {radius}\n0 0 1 {radius}\n0 1 1 {radius}\n0 1 2 {radius}\n").into_bytes()
}

/// Mitsuba's grids, version 3: two numbers in a box.
fn grid(number: f32) -> Vec<u8> {
    let mut file = b"VOL\x03".to_vec();
    file.extend([1_i32, 2, 1, 1, 1].iter().flat_map(|header| header.to_le_bytes()));
    let numbers = [0.0, 0.0, 0.0, 2.0, 1.0, 1.0, 0.2, number];
    file.extend(numbers.iter().flat_map(|number: &f32| number.to_le_bytes()));
    file
}

/// Mitsuba's serialized meshes, version 4: one tetrahedron with texture coordinates of each height.
fn serialized(heights: &[f32]) -> Vec<u8> {
    let (mut file, mut offsets) = (Vec::new(), Vec::new());
    for height in heights {
        // Single precision, with texture coordinates.
        let mut content = 0x1002_u32.to_le_bytes().to_vec();
        content.push(0);
        content.extend([4_u64, 4].iter().flat_map(|count| count.to_le_bytes()));
        let positions = [[1.0, 0.0, 0.0], [-1.0, 0.8, 0.0], [-1.0, -0.8, 0.0], [0.0, 0.0, *height]];
        let coordinates = [[0.0, 0.1], [1.0, 0.2], [0.3, 0.9], [0.5, 0.4]];
        content.extend(
            positions
                .iter()
                .flatten()
                .chain(coordinates.iter().flatten())
                .flat_map(|number: &f32| number.to_le_bytes()),
        );
        let corners = [[0_u32, 2, 1], [0, 1, 3], [1, 2, 3], [2, 0, 3]];
        content.extend(corners.iter().flatten().flat_map(|corner| corner.to_le_bytes()));
        offsets.push(file.len() as u64);
        file.extend([0x041c_u16, 4].iter().flat_map(|number| number.to_le_bytes()));
        let mut encoder = ZlibEncoder::new(Vec::new(), Compression::default());
        encoder.write_all(&content).expect("memory can be written");
        file.extend(encoder.finish().expect("memory can be written"));
    }
    file.extend(offsets.iter().flat_map(|offset| offset.to_le_bytes()));
    file.extend((heights.len() as u32).to_le_bytes());
    file
}

/// What is wrong with a row that says `support`, if a scene without and with what it says have these outcomes.
fn objection(support: Support, plain: &Result<String, String>, given: &Result<String, String>) -> Option<String> {
    match (support, given) {
        (Support::Refused, Err(_)) => None,
        (Support::Refused, Ok(_)) => Some("it is loaded".to_owned()),
        (_, Err(error)) => Some(error.clone()),
        (Support::PassedOver, Ok(_)) => (plain != given).then(|| "it changes the scene".to_owned()),
        (Support::Same | Support::Approximated, Ok(_)) => (plain == given).then(|| "it changes nothing".to_owned()),
    }
}

/// The names of parameters and how well each is represented.
fn each(parameters: &[Parameters]) -> impl Iterator<Item = (&'static str, Support)> {
    parameters.iter().flat_map(|group| group.names.split(' ').map(|name| (name, group.support)))
}

#[test]
fn the_tables_of_mitsuba_plugins_say_what_happens() {
    let mut wrong = Vec::new();
    let mut checked = 0;
    for class in CLASSES {
        for Plugin { name, support, parameters, .. } in class.plugins {
            let outcome = |given: &str| outcome(class.class, class.title, name, given);
            let plain = outcome("");
            if (*support == Support::Refused) != plain.is_err() {
                wrong.push(format!("{name} is said to be {}, and is {plain:.200?}", support.name()));
            }
            if *support == Support::Refused {
                continue;
            }
            for (parameter, support) in each(class.parameters).chain(each(parameters)) {
                checked += 1;
                if let Some(problem) = objection(support, &plain, &outcome(value(name, parameter))) {
                    wrong.push(format!("{parameter} of {name} is said to be {}: {problem}", support.name()));
                }
            }
        }
    }
    assert!(checked > 250, "only {checked} parameters");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

/// Whatever number stands in whatever parameter, no message has hundreds of digits.
#[test]
fn numbers_in_messages_are_short_for_every_parameter() {
    let (mut refused, mut wrong) = (0, Vec::new());
    for class in CLASSES {
        for Plugin { name, parameters, .. } in class.plugins {
            for (parameter, _) in each(class.parameters).chain(each(parameters)) {
                for (tag, number) in [("float", "1e300"), ("float", "-1e-300"), ("rgb", "-1e300")] {
                    let given = format!("<{tag} name='{parameter}' value='{number}'/>");
                    let Err(error) = outcome(class.class, class.title, name, &given) else { continue };
                    refused += 1;
                    let runs = error.split(|letter: char| !letter.is_ascii_digit());
                    if runs.map(str::len).max() > Some(20) {
                        wrong.push(error);
                    }
                }
            }
        }
    }
    assert!(refused > 300, "only {refused} errors");
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn the_page_has_the_tables_of_mitsuba_plugins() {
    let page = Path::new(env!("CARGO_MANIFEST_DIR")).join("docs/COMPATIBILITY.md");
    let text = std::fs::read_to_string(&page).expect("the page is there");
    let (begin, end) = ("<!-- mitsuba: begin -->\n\n", "<!-- mitsuba: end -->");
    let (head, rest) = text.split_once(begin).expect("the page has the section");
    let (tables, tail) = rest.split_once(end).expect("the section ends");
    let made = markdown();
    if std::env::var_os("PHOTONFARM_RENEW_COMPATIBILITY").is_some() {
        std::fs::write(&page, format!("{head}{begin}{made}{end}{tail}")).expect("writes");
        return;
    }
    assert!(tables == made, "renew it with PHOTONFARM_RENEW_COMPATIBILITY=1 cargo test --test scene mitsuba_plugins");
}
