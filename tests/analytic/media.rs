//! Participating media against closed forms: what absorbs is exact in every method, what scatters loses nothing.

use crate::rendered::{few_photons, rendered};
use std::path::Path;
use std::sync::Arc;

use photonfarm::import::{load_bytes, load_file};
use photonfarm::method::{self, METHODS, MethodChoice};
use photonfarm::scene::Scene;

const FILM: &str = "<film type='hdrfilm'><integer name='width' value='8'/><integer name='height' value='8'/><rfilter type='box'/></film>";

fn scene(content: &str) -> Arc<Scene> {
    let text = format!("<scene version='3.0.0'>{content}</scene>");
    let description = load_bytes("a.xml", text.as_bytes(), &[]).expect("the scene loads");
    Arc::new(Scene::prepare(&description).expect("the scene is good"))
}

/// The mean of each channel.
fn render(scene: &Arc<Scene>, name: &str, passes: u32) -> [f64; 3] {
    let mut parameters = few_photons(name);
    if ["mmlt", "mlt"].contains(&name) {
        // Chains begin with what a quarter as many paths find, and few of those find light behind glass.
        parameters.insert("mutations".to_owned(), 256.into());
    }
    if name == "mps" {
        // The same, and of photons of two kinds side by side more have to count in a look-up.
        for (parameter, value) in [("photons_per_pass", 65_536), ("large_steps", 100), ("caustic_neighbors", 100)] {
            parameters.insert(parameter.to_owned(), value.into());
        }
    }
    let picture = rendered(scene, name, parameters, passes, 7).radiance;
    [0, 1, 2].map(|channel| picture.iter().map(|pixel| f64::from(pixel[channel])).sum::<f64>() / picture.len() as f64)
}

fn assert_near(what: &str, found: [f64; 3], expected: [f64; 3], tolerance: f64) {
    for (one, other) in found.into_iter().zip(expected) {
        assert!((one / other - 1.0).abs() < tolerance, "{what}: {found:?} is not {expected:?}");
    }
}

/// A cube of a medium in an even sky, seen by parallel rays through its middle: 2 m of it.
fn cube_of(medium: &str) -> String {
    let place = "<transform name='to_world'><scale x='0.5' y='0.5'/><lookat origin='0,0,5' target='0,0,0' up='0,1,0'/></transform>";
    format!(
        "<integrator type='volpath'/><sensor type='orthographic'>{place}{FILM}</sensor><emitter type='constant'/>{medium}\
         <shape type='cube'><bsdf type='null'/><ref name='interior' id='m'/></shape>"
    )
}

fn homogeneous(parameters: &str) -> String {
    format!("<medium type='homogeneous' id='m'>{parameters}</medium>")
}

/// The share of emitted light that comes back once from the wall of an emitting sphere of diameter `a` extinction lengths: the mean of
/// exp(-a μ) over cosine-distributed directions.
fn returned(a: f64) -> f64 {
    2.0 * (1.0 - (1.0 + a) * f64::exp(-a)) / (a * a)
}

/// In a glowing matte sphere full of a medium that absorbs, the wall's radiance is L = Le + ρ L returned(2 σ r).
#[test]
fn analytic_every_method_absorbs_between_all_vertices() {
    let (albedo, extinction) = (0.6, [0.2, 0.5, 1.0]);
    let medium =
        "<medium type='homogeneous'><rgb name='sigma_t' value='0.2, 0.5, 1'/><rgb name='albedo' value='0'/></medium>";
    let content = format!(
        "<sensor type='perspective'><float name='fov' value='50'/>{FILM}{medium}</sensor>\
         <shape type='sphere'><boolean name='flip_normals' value='true'/>\
         <bsdf type='diffuse'><rgb name='reflectance' value='{albedo}'/></bsdf>\
         <emitter type='area'><rgb name='radiance' value='1'/></emitter></shape>"
    );
    let scene = scene(&content);
    let expected = extinction.map(|sigma| f64::exp(-sigma) / (1.0 - albedo * returned(2.0 * sigma)));
    for entry in METHODS {
        assert_near(entry.name, render(&scene, entry.name, 64), expected, 0.02);
    }
}

/// A slab of 0.5 m that refracts nothing lies between the sun and a matte floor.
#[test]
fn analytic_every_method_absorbs_inside_of_solids() {
    let place = "<transform name='to_world'><scale x='0.5' y='0.5'/><lookat origin='0,0,0.4' target='0,0,0' up='0,1,0'/></transform>";
    let medium = homogeneous("<rgb name='sigma_t' value='0.5, 1, 2'/><rgb name='albedo' value='0'/>");
    let content = format!(
        "<sensor type='orthographic'>{place}{FILM}</sensor>{medium}\
         <emitter type='directional'><vector name='direction' value='0, 0, -1'/><rgb name='irradiance' value='3'/></emitter>\
         <shape type='cube'><bsdf type='dielectric'><float name='int_ior' value='1'/><float name='ext_ior' value='1'/></bsdf>\
         <ref name='interior' id='m'/>\
         <transform name='to_world'><scale x='1.5' y='1.5' z='0.25'/><translate z='0.75'/></transform></shape>\
         <shape type='rectangle'><bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf></shape>"
    );
    let scene = scene(&content);
    let expected = [0.5, 1.0, 2.0].map(|sigma| 3.0 * 0.5 / std::f64::consts::PI * f64::exp(-0.5 * sigma));
    for entry in METHODS {
        assert_near(entry.name, render(&scene, entry.name, 96), expected, 0.03);
    }
}

#[test]
fn analytic_media_absorb_and_keep_what_they_scatter() {
    let absorbs =
        scene(&cube_of(&homogeneous("<rgb name='sigma_t' value='0.5, 1, 2'/><rgb name='albedo' value='0'/>")));
    assert_near("exact", render(&absorbs, "path", 1), [0.5, 1.0, 2.0].map(|sigma| f64::exp(-2.0 * sigma)), 1e-5);
    for phase in ["isotropic", "hg", "rayleigh"] {
        let furnace = format!("<rgb name='sigma_t' value='2'/><rgb name='albedo' value='1'/><phase type='{phase}'/>");
        assert_near(phase, render(&scene(&cube_of(&homogeneous(&furnace))), "path", 128), [1.0; 3], 0.02);
    }
}

/// Mitsuba's `path` sees no media, and says nothing; its `volpath` does.
#[test]
fn integrators_without_media_leave_them_out() {
    let content = cube_of(&homogeneous("<rgb name='albedo' value='0'/>")).replace("volpath", "path");
    let scene = scene(&content);
    assert!(scene.notices.iter().any(|notice| notice.contains("\"volpath\" renders them")), "{:?}", scene.notices);
    assert_near("path", render(&scene, "path", 4), [1.0; 3], 1e-5);
}

#[test]
fn media_are_refused_by_methods_that_do_not_render_them() {
    let scene = scene(&cube_of(&homogeneous("")));
    for entry in METHODS {
        let choice = MethodChoice { name: entry.name.to_owned(), parameters: serde_json::Map::new() };
        let checked = method::check(&choice, 64).expect("the parameters are good");
        let prepared = method::prepare(scene.clone(), &checked, 1);
        let error = prepared.err().map(|error| error.to_string()).unwrap_or_default();
        assert_eq!(error.is_empty(), entry.name == "path", "{}: {error}", entry.name);
        assert!(error.is_empty() || error.contains("participating media"), "{error}");
    }
}

/// A grid file as Mitsuba writes it.
fn grid_file(size: [i32; 3], channels: i32, values: &[f32]) -> Vec<u8> {
    let mut bytes = b"VOL\x03".to_vec();
    let header = [1, size[0], size[1], size[2], channels];
    bytes.extend(header.iter().flat_map(|number| number.to_le_bytes()));
    bytes.extend([0.0f32, 0.0, 0.0, 1.0, 1.0, 1.0].iter().chain(values).flat_map(|number| number.to_le_bytes()));
    bytes
}

/// The cube with media whose volumes are the files `a.vol` and so on, placed over the cube.
fn scene_with_grids(folder: &Path, medium: &str, files: &[Vec<u8>]) -> Result<Arc<Scene>, String> {
    for (name, bytes) in ["a.vol", "b.vol"].iter().zip(files) {
        std::fs::write(folder.join(name), bytes).expect("a file is written");
    }
    let path = folder.join("scene.xml");
    let text = format!("<scene version='3.0.0'>{}</scene>", cube_of(medium));
    std::fs::write(&path, text).expect("a file is written");
    let description = load_file(&path, &[]).map_err(|error| error.to_string())?;
    Scene::prepare(&description).map(Arc::new).map_err(|error| error.to_string())
}

fn grid(parameter: &str, file: &str, filter: &str) -> String {
    format!(
        "<volume type='gridvolume' name='{parameter}'><string name='filename' value='{file}'/>\
         <string name='filter_type' value='{filter}'/>\
         <transform name='to_world'><translate x='-0.5' y='-0.5' z='-0.5'/><scale value='2'/></transform></volume>"
    )
}

/// Along z the extinction has the means 1, 0.5 and 1.5 in its channels, whatever the filter.
#[test]
fn analytic_grids_absorb_and_keep_what_they_scatter() {
    let folder = tempfile::tempdir().expect("a folder");
    let column = [[0.0, 1.0, 0.5], [3.0, 0.0, 0.5], [1.0, 0.25, 3.5], [0.0, 0.75, 1.5]];
    let files = [grid_file([1, 1, 4], 3, column.as_flattened()), grid_file([2, 1, 1], 1, &[1.0, 1.0])];
    // Channels share a flight: where they differ much, scattering is noisy.
    let alike = column.map(|[red, ..]| [red + 1.0, red + 1.2, red + 0.8]);
    let alike = [grid_file([1, 1, 4], 3, alike.as_flattened()), files[1].clone()];
    for filter in ["trilinear", "nearest"] {
        let extinction = grid("sigma_t", "a.vol", filter);
        let absorbs = format!(
            "<medium type='heterogeneous' id='m'>{extinction}<float name='scale' value='0.5'/><rgb name='albedo' value='0'/></medium>"
        );
        let scene = scene_with_grids(folder.path(), &absorbs, &files).expect("a good scene");
        let expected = [1.0, 0.5, 1.5].map(|mean| f64::exp(-2.0 * 0.5 * mean));
        assert_near(filter, render(&scene, "path", 2048), expected, 0.02);
        let albedo = grid("albedo", "b.vol", filter);
        let scatters = format!("<medium type='heterogeneous' id='m'>{extinction}{albedo}<phase type='hg'/></medium>");
        let scene = scene_with_grids(folder.path(), &scatters, &alike).expect("a good scene");
        assert_near(filter, render(&scene, "path", 512), [1.0; 3], 0.02);
    }
}

/// The same medium as a grid and as one number looks the same where it scatters and absorbs.
#[test]
fn grids_of_one_number_agree_with_homogeneous_media() {
    let folder = tempfile::tempdir().expect("a folder");
    let parameters = "<rgb name='albedo' value='0.9, 0.6, 0.3'/><phase type='hg'><float name='g' value='0.3'/></phase>";
    let files = [grid_file([1, 1, 1], 1, &[1.5])];
    let varying =
        format!("<medium type='heterogeneous' id='m'>{}{parameters}</medium>", grid("sigma_t", "a.vol", "nearest"));
    let varying = scene_with_grids(folder.path(), &varying, &files).expect("a good scene");
    let even = scene(&cube_of(&homogeneous(&format!("<rgb name='sigma_t' value='1.5'/>{parameters}"))));
    assert_near("a grid", render(&varying, "path", 1024), render(&even, "path", 1024), 0.02);
}

/// As in Mitsuba 3.9.1 a heterogeneous medium of one extinction fills the unit cube: a quarter of the picture sees 1 m of it.
#[test]
fn analytic_heterogeneous_media_end_at_their_box() {
    let whole = |sigma: f64| 0.75 + 0.25 * f64::exp(-sigma);
    let plain = "<rgb name='sigma_t' value='0.5, 1, 2'/>".to_owned();
    let halved = "<volume type='constvolume' name='sigma_t'><rgb name='value' value='1, 2, 4'/><transform name='to_world'>\
         <scale z='0.5'/></transform></volume>";
    for extinction in [plain.as_str(), halved] {
        let medium = format!("<medium type='heterogeneous' id='m'>{extinction}<rgb name='albedo' value='0'/></medium>");
        assert_near(extinction, render(&scene(&cube_of(&medium)), "path", 1024), [0.5, 1.0, 2.0].map(whole), 0.01);
    }
}

#[test]
fn bad_grids_are_refused() {
    let folder = tempfile::tempdir().expect("a folder");
    let good = grid_file([2, 2, 2], 1, &[0.5; 8]);
    let refused = |file: Vec<u8>, kind: &str, expected: &str| {
        let medium = format!("<medium type='{kind}' id='m'>{}</medium>", grid("sigma_t", "a.vol", "trilinear"));
        let error = scene_with_grids(folder.path(), &medium, &[file]).err().unwrap_or_default();
        assert!(error.contains(expected), "{error:?} does not say {expected:?}");
    };
    refused(good[..good.len() - 1].to_vec(), "heterogeneous", "79 bytes");
    refused(b"VOL".to_vec(), "heterogeneous", "no volume of version 3");
    refused(grid_file([0, 2, 2], 1, &[]), "heterogeneous", "0 × 2 × 2");
    refused(grid_file([i32::MAX; 3], 1, &[]), "heterogeneous", "more than can be kept");
    refused(grid_file([1, 1, 1], 2, &[1.0; 2]), "heterogeneous", "2 channels");
    refused(grid_file([1, 1, 1], 1, &[f32::NAN]), "heterogeneous", "not finite");
    refused(grid_file([1, 1, 1], 1, &[-1.0]), "heterogeneous", "reaches from -1");
    refused(good, "homogeneous", "make it \"heterogeneous\"");
}

#[test]
fn media_that_cannot_be_followed_are_refused_and_odd_ones_told() {
    let refused = |medium: &str, expected: &str| {
        let text = format!("<scene version='3.0.0'>{}</scene>", cube_of(medium));
        let description = load_bytes("a.xml", text.as_bytes(), &[]).expect("the scene loads");
        let error = Scene::prepare(&description).err().map(|error| error.to_string()).unwrap_or_default();
        assert!(error.contains(expected), "{error:?} does not say {expected:?}");
    };
    refused(&homogeneous("<float name='sigma_t' value='1e30'/><float name='scale' value='1e30'/>"), "single precision");
    refused(&homogeneous("<float name='sigma_t' value='1e7'/>"), "above 1e6");
    let folder = tempfile::tempdir().expect("a folder");
    let dense = format!("<medium type='heterogeneous' id='m'>{}</medium>", grid("sigma_t", "a.vol", "nearest"));
    let error = scene_with_grids(folder.path(), &dense, &[grid_file([1, 1, 1], 1, &[1e5])]).err().unwrap_or_default();
    assert!(error.contains("mean free paths"), "{error}");
    let absorbing = homogeneous("<float name='sigma_t' value='1e7'/><float name='albedo' value='0'/>");
    let around = scene(&cube_of(&absorbing).replace("origin='0,0,5'", "origin='0,0,0.5'"));
    assert!(
        around.notices.iter().any(|notice| notice.contains("name the medium in the sensor")),
        "{:?}",
        around.notices
    );
}
