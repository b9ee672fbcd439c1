//! Methods that make paths from two ends, against closed forms, against each other, and against references.

use std::sync::Arc;

use crate::progressive::{Job, reference_folder, reference_scene};
use crate::scene_files::{exr_file, prepare};
use photonfarm::estimate::{Picture, Region, Shard, picture_files};
use photonfarm::evaluation::compare;
use photonfarm::scene::Scene;

const UNBIASED: [&str; 3] = ["path", "bdpt", "light_tracing"];
const MERGING: [&str; 2] = ["pbdpm", "vcm"];

fn mean(picture: &Picture) -> f64 {
    picture.radiance.iter().flatten().map(|value| f64::from(*value)).sum::<f64>() / (3 * picture.radiance.len()) as f64
}

/// Mean of a picture and its standard error, from `batches` of `passes` passes with seeds of their own.
pub(crate) fn mean_and_error(
    scene: &Arc<Scene>,
    method: &str,
    parameters: &str,
    batches: u32,
    passes: u32,
) -> (f64, f64) {
    let job = Job::new(scene, method, parameters);
    let start = job.begin().estimate;
    let field = start.radius_field(job.region());
    let means: Vec<f64> = (0..batches)
        .map(|batch| {
            let mut estimate = start.clone();
            // Passes of other batches than the first are those that a longer job would make there.
            for pass in 0..passes {
                let shard = Shard { first_pass: batch * passes + pass, passes: 1, region: job.region() };
                let mut tally = job.renderer.trace(shard, &field, &job.never).expect("nobody cancels");
                tally.shard.first_pass = pass;
                estimate.merge(&tally, &field).expect("tallies come in order");
            }
            mean(&estimate.picture())
        })
        .collect();
    let count = f64::from(batches);
    let average = means.iter().sum::<f64>() / count;
    let variance = means.iter().map(|mean| (mean - average).powi(2)).sum::<f64>() / (count - 1.0);
    (average, (variance / count).sqrt())
}

/// Significance: with 16 batches, 4.5 standard errors are passed by chance once in 2,000 times; seeds are fixed.
pub(crate) const ERRORS: f64 = 4.5;

#[test]
fn furnaces_have_radiance_one() {
    for name in ["furnace-closed", "furnace-env", "furnace-specular"] {
        let scene = reference_scene(name);
        let methods = UNBIASED.iter().chain(&MERGING).filter(|method| {
            // Mirrors and glass stay black in light tracing.
            name != "furnace-specular" || **method != "light_tracing"
        });
        for method in methods {
            let parameters =
                if MERGING.contains(method) { r#"{"initial_radius": 0.01, "photons_per_pass": 16384}"# } else { "{}" };
            let (found, error) = mean_and_error(&scene, method, parameters, 16, 4);
            println!("{name} {method}: {found:.5} ± {error:.5}");
            // Discs that reach over edges take a little.
            let bias = if MERGING.contains(method) { 0.003 } else { 0.0 };
            assert!((found - 1.0).abs() < ERRORS * error + bias, "{name} by {method}: {found} ± {error}");
            assert!(error < 0.0035, "{name} by {method}: the test is blind");
        }
    }
}

const SENSOR: &str = "<sensor type='perspective'><float name='fov' value='40'/><transform name='to_world'>\
    <lookat origin='0, 0, 2' target='0, 0, 0' up='0, 1, 0'/></transform><film type='hdrfilm'>\
    <integer name='width' value='16'/><integer name='height' value='16'/><rfilter type='box'/></film></sensor>";

/// A matte floor under a point light: radiance ρ/π·I·cos/d² in closed form, averaged over what the camera sees.
#[test]
fn direct_light_of_a_point_has_its_closed_form() {
    let body = "<shape type='rectangle'><transform name='to_world'><scale value='4'/></transform>\
        <bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf></shape>\
        <emitter type='point'><point name='position' value='0.3, 0.2, 1.5'/><rgb name='intensity' value='4'/></emitter>";
    let scene = Arc::new(prepare(&format!("{SENSOR}{body}"), &[]).expect("the scene is good"));
    let half = 2.0 * f64::tan(f64::to_radians(20.0));
    let steps = 400;
    let at = |index: i32| half * ((f64::from(index) + 0.5) * 2.0 / f64::from(steps) - 1.0);
    let mut expected = 0.0;
    for row in 0..steps {
        for column in 0..steps {
            let (x, y, z) = (at(column) - 0.3, at(row) - 0.2, 1.5);
            let squared: f64 = x * x + y * y + z * z;
            expected += 0.5 / std::f64::consts::PI * 4.0 * z / squared.powf(1.5) / f64::from(steps * steps);
        }
    }
    for method in ["path", "bdpt", "light_tracing", "vcm"] {
        let parameters = if method == "vcm" { r#"{"initial_radius": 0.02, "photons_per_pass": 4096}"# } else { "{}" };
        let (found, error) = mean_and_error(&scene, method, parameters, 16, 8);
        println!("{method}: {found:.5} ± {error:.5} of {expected:.5}");
        assert!((found - expected).abs() < ERRORS * error + 1e-5 * expected, "{method}: {found} ± {error}, {expected}");
        assert!(error < 0.02 * expected, "{method}: the test is blind");
    }
}

/// Every kind of light, seen by every method that can find it: no two may differ.
#[test]
fn methods_agree_in_pairs() {
    let room = "<shape type='rectangle'><transform name='to_world'><scale value='2'/></transform>\
        <bsdf type='roughconductor'><float name='alpha' value='0.3'/></bsdf></shape>\
        <shape type='sphere'><point name='center' value='0.2, 0.1, 0.4'/><float name='radius' value='0.3'/>\
        <bsdf type='diffuse'/></shape><shape type='sphere'><point name='center' value='-0.4, -0.2, 0.3'/>\
        <float name='radius' value='0.2'/><bsdf type='roughdielectric'><float name='alpha' value='0.3'/></bsdf></shape>";
    let lights = [
        (
            "area",
            "<shape type='rectangle'><transform name='to_world'><scale value='0.4'/><lookat origin='1, 1, 1.5' \
            target='0, 0, 0' up='0, 0, 1'/></transform><emitter type='area'><rgb name='radiance' value='8, 7, 5'/></emitter></shape>",
        ),
        (
            "sphere",
            "<shape type='sphere'><point name='center' value='1, 1, 1.5'/><float name='radius' value='0.3'/>\
            <emitter type='area'><rgb name='radiance' value='8, 7, 5'/></emitter></shape>",
        ),
        (
            "spot",
            "<emitter type='spot'><transform name='to_world'><lookat origin='1, 1, 2' target='0, 0, 0' \
            up='0, 0, 1'/></transform><rgb name='intensity' value='9'/></emitter>",
        ),
        (
            "directional",
            "<emitter type='directional'><vector name='direction' value='-1, -1, -2'/>\
            <rgb name='irradiance' value='3, 2, 1'/></emitter>",
        ),
        ("constant", "<emitter type='constant'><rgb name='radiance' value='1, 0.8, 0.6'/></emitter>"),
        ("map", "<emitter type='envmap'><string name='filename' value='sky.exr'/></emitter>"),
    ];
    let sky = exr_file(8, 5, |x, y| [x as f32 / 4.0, if (x, y) == (5, 1) { 9.0 } else { 0.5 }, (y % 2) as f32]);
    for (light, text) in lights {
        let scene =
            Arc::new(prepare(&format!("{SENSOR}{room}{text}"), &[("sky.exr", &sky)]).expect("the scene is good"));
        let found: Vec<(&str, f64, f64)> = UNBIASED
            .iter()
            .chain(&MERGING)
            .map(|method| {
                let parameters = match MERGING.contains(method) {
                    true => r#"{"initial_radius": 0.01, "photons_per_pass": 8192, "max_depth": 6}"#,
                    false => r#"{"max_depth": 6}"#,
                };
                let (mean, error) = mean_and_error(&scene, method, parameters, 16, 6);
                println!("{light} {method}: {mean:.5} ± {error:.5}");
                (*method, mean, error)
            })
            .collect();
        for (index, a) in found.iter().enumerate() {
            for b in &found[index + 1..] {
                let error = f64::hypot(a.2, b.2);
                // The little that discs lose at edges is left to those that merge.
                let bias = if MERGING.contains(&b.0) { 0.004 * a.1 } else { 0.0 };
                let difference = (a.1 - b.1).abs();
                assert!(difference < ERRORS * error + bias, "{light}: {} {} and {} {} ± {error}", a.0, a.1, b.0, b.1);
            }
        }
    }
}

/// Bounds on relMSE are 1.5 times what was measured.
fn check_reference(name: &str, bias_bound: f64, methods: &[(&str, f64)]) {
    let scene = reference_scene(name);
    let reference = picture_files::read_exr(&reference_folder(name).join("ref.exr")).expect("a reference can be read");
    for (method, relmse_bound) in methods {
        let estimate = Job::new(&scene, method, "{}").run(16, 8);
        let found = compare(&estimate.picture(), &reference, None).expect("the sizes agree");
        println!("{name} {method}: mean {:+.4}, relMSE {:.4}", found.bias, found.relmse);
        assert_eq!(estimate.non_finite(), 0);
        assert!(found.bias.abs() < bias_bound, "{name} by {method}: mean off by {:.2} %", 100.0 * found.bias);
        assert!(found.relmse < *relmse_bound, "{name} by {method}: relMSE {}", found.relmse);
    }
}

#[test]
fn agreement_cornell_diffuse() {
    check_reference("cornell-diffuse", 0.01, &[("path", 0.35), ("bdpt", 0.12), ("bdpm", 0.1), ("vcm", 0.1)]);
}

/// Kernels and nearest neighbors: each is another estimate of the same.
#[test]
fn agreement_of_kernels_and_neighbors() {
    let scene = reference_scene("cornell-diffuse");
    let (expected, error) = mean_and_error(&scene, "bdpm", r#"{"photons_per_pass": 16384}"#, 8, 4);
    for parameters in [
        r#"{"photons_per_pass": 16384, "kernel": "cone"}"#,
        r#"{"photons_per_pass": 16384, "neighbors": 8}"#,
        r#"{"photons_per_pass": 16384, "neighbors": 8, "kernel": "epanechnikov"}"#,
        r#"{"photons_per_pass": 16384, "weights": "paper"}"#,
        r#"{"photons_per_pass": 16384, "light_hits": "off", "camera_hits": "off"}"#,
    ] {
        let (found, own_error) = mean_and_error(&scene, "bdpm", parameters, 8, 4);
        println!("{parameters}: {found:.5} ± {own_error:.5}, plain {expected:.5} ± {error:.5}");
        let bound = ERRORS * f64::hypot(error, own_error) + 0.006 * expected;
        assert!((found - expected).abs() < bound, "{parameters}: {found} where {expected} is right");
        assert!(bound < 0.03 * expected, "the test is blind");
    }
}

/// Light subpaths that the camera sees land where camera subpaths start, whatever the filter and the window.
#[test]
fn agreement_of_splats_with_filters_and_windows() {
    let sensor = "<sensor type='thinlens'><float name='fov' value='40'/><float name='aperture_radius' value='0.05'/>\
        <float name='focus_distance' value='2'/><transform name='to_world'>\
        <lookat origin='0.1, -0.2, 2' target='0, 0, 0' up='0.1, 1, 0'/></transform><film type='hdrfilm'>\
        <integer name='width' value='24'/><integer name='height' value='20'/><integer name='crop_offset_x' value='5'/>\
        <integer name='crop_offset_y' value='3'/><integer name='crop_width' value='8'/>\
        <integer name='crop_height' value='8'/><rfilter type='gaussian'/></film></sensor>";
    let body = "<shape type='rectangle'><transform name='to_world'><scale value='2'/></transform>\
        <bsdf type='diffuse'><texture type='checkerboard' name='reflectance'><transform name='to_uv'>\
        <scale x='9' y='7'/></transform></texture></bsdf></shape><emitter type='spot'>\
        <transform name='to_world'><lookat origin='0.3, 0.2, 1.5' target='-0.1, 0.1, 0' up='0, 1, 0'/></transform>\
        <float name='cutoff_angle' value='30'/><rgb name='intensity' value='4'/></emitter>";
    let scene = Arc::new(prepare(&format!("{sensor}{body}"), &[]).expect("the scene is good"));
    let [a, b] = ["path", "light_tracing"].map(|method| Job::new(&scene, method, "{}").run(16_000, 8).picture());
    let whole = mean(&a);
    for (pixel, (a, b)) in a.radiance.iter().zip(&b.radiance).enumerate() {
        // About 3,500 light subpaths fall into a pixel: 2 % and less of noise; seeds are fixed.
        assert!((a[0] - b[0]).abs() < 0.08 * whole as f32, "pixel {pixel}: {} by camera, {} by light", a[0], b[0]);
    }
}

#[test]
fn agreement_cornell_glass() {
    check_reference("cornell-glass", 0.015, &[("path", 1.9), ("bdpt", 0.12), ("pbdpm", 0.1), ("vcm", 0.1)]);
}

#[test]
fn agreement_lantern() {
    check_reference("lantern", 0.015, &[("pbdpm", 0.3), ("vcm", 0.3)]);
}

#[test]
fn agreement_glossy_blocks() {
    check_reference("glossy-blocks-a010", 0.015, &[("path", 0.6), ("bdpt", 0.1), ("bdpm", 0.1), ("vcm", 0.1)]);
}

#[test]
fn agreement_dof() {
    check_reference("dof", 0.015, &[("path", 0.5), ("bdpt", 0.3), ("vcm", 0.3)]);
    // Light that happens to fall through the lens: noisy. After 300 passes the mean is off by +0.4 %.
    check_reference("dof", 0.03, &[("light_tracing", 6.0)]);
}

/// A region gives exactly the pixels that the whole picture gives, also of light subpaths that the camera sees.
#[test]
fn agreement_of_a_region_with_the_whole() {
    let scene = reference_scene("cornell-glass");
    for method in ["path", "bdpt", "light_tracing", "pbdpm", "vcm"] {
        let job = Job::new(&scene, method, "{}");
        let estimate = job.begin().estimate;
        let field = estimate.radius_field(job.region());
        let whole = Shard { first_pass: 0, passes: 1, region: job.region() };
        let whole = job.renderer.trace(whole, &field, &job.never).expect("nobody cancels");
        let region = Region { row_start: 10, row_end: 20 };
        let width = scene.width as usize;
        let mut part_field = field.clone();
        // Methods that gather nothing have no radii.
        part_field.radius_squared = field.radius_squared.get(10 * width..20 * width).unwrap_or_default().to_vec();
        let part = Shard { first_pass: 0, passes: 1, region };
        let part = job.renderer.trace(part, &part_field, &job.never).expect("nobody cancels");
        assert!(part.pixels() == whole.pixels()[10 * width..20 * width], "{method}");
    }
}
