//! Photons that go where the picture looks: the same picture with less noise, and nothing where nothing is to be gained.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use photonfarm::math::random::{PassRandom, Stream};
use photonfarm::scene::Scene;
use photonfarm::scene::light::emission_guide::{BY_POWER, EmissionPoint};
use photonfarm::transport::emission_learning::{EmittedPath, GuideParts, learn};

use crate::batches::{ERRORS, assert_same, bits_of_threads, mean_and_error, repository_scene};
use crate::progressive::{Job, reference_scene};
use crate::scene_text::prepare;

fn learns_a_guide(scene: &Arc<Scene>, method: &str, parameters: &str) -> bool {
    let pilot = Job::new(scene, method, parameters).renderer.pilot(&AtomicBool::new(false)).expect("nobody cancels");
    !pilot.guides().emission.is_empty()
}

#[test]
fn a_lamp_in_a_sealed_room_takes_no_photons() {
    let (scene, alone) =
        (repository_scene("sealed-lamp/scene.xml", "32"), repository_scene("sealed-lamp/alone.xml", "32"));
    for method in ["sppm", "ppm"] {
        let parameters = |emission: &str| {
            format!(
                r#"{{"direct": "photons", "photons_per_pass": 30000, "initial_radius": 0.2, "emission": "{emission}"}}"#
            )
        };
        let [power, auto] = ["power", "auto"].map(|emission| mean_and_error(&scene, method, &parameters(emission), 1));
        assert!(learns_a_guide(&scene, method, &parameters("auto")), "{method}: the pilot finds that it helps");
        assert_same(auto, power, 0.0, &format!("{method}, guided and by power"));
        // The same room without that lamp.
        let alone = mean_and_error(&alone, method, &parameters("power"), 1);
        assert_same(auto, alone, 0.0, &format!("{method}, with the lamp and without"));
        let [guided, power, alone] = [auto, power, alone].map(|[_, _, noise]| noise);
        assert!(guided < 0.1 * power, "{method}: guided {guided} and by power {power}");
        assert!(guided < 2.0 * alone, "{method}: guided {guided} and without the lamp {alone}");
    }
    let parameters = r#"{"photons_per_pass": 60000, "emission": "auto"}"#;
    assert!(learns_a_guide(&scene, "photon_map", parameters));
    let [with, without] = [&scene, &alone].map(|scene| mean_and_error(scene, "photon_map", parameters, 2));
    // Nearest photons lie nearer where more of them come: the bias differs.
    assert_same(with, without, 0.02, "photon_map, with the lamp and without");
}

/// An environment map, a spot, a point light, the sun's kind and an area light of uneven importance.
#[test]
fn guided_photons_of_all_kinds_of_lights_make_the_same_picture() {
    let body = "<sensor type='perspective'><float name='fov' value='40'/><transform name='to_world'>\
        <lookat origin='0, 0, 2' target='0, 0, 0' up='0, 1, 0'/></transform><film type='hdrfilm'>\
        <integer name='width' value='16'/><integer name='height' value='16'/><rfilter type='box'/></film></sensor>\
        <shape type='rectangle'><transform name='to_world'><scale value='4'/></transform><bsdf type='diffuse'/></shape>\
        <shape type='sphere'><point name='center' value='0.3, 0.1, 0.3'/><float name='radius' value='0.3'/><bsdf type='diffuse'/>\
        </shape><emitter type='constant'><rgb name='radiance' value='0.2, 0.3, 0.5'/></emitter>\
        <emitter type='spot'><rgb name='intensity' value='3, 2, 2'/><transform name='to_world'>\
        <lookat origin='1, 1, 2' target='0, 0, 0' up='0, 1, 0'/></transform></emitter>\
        <emitter type='point'><point name='position' value='-3, 3, 1'/><rgb name='intensity' value='5'/></emitter>\
        <emitter type='directional'><vector name='direction' value='1, 0.5, -2'/><rgb name='irradiance' value='0.5'/></emitter>\
        <shape type='sphere'><point name='center' value='-1, -1, 1'/><float name='radius' value='0.2'/>\
        <emitter type='area'><rgb name='radiance' value='4, 3, 2'/></emitter></shape>";
    let scene = Arc::new(prepare(body, &[]).expect("the scene is good"));
    let parameters = |emission: &str| {
        format!(
            r#"{{"direct": "photons", "photons_per_pass": 20000, "initial_radius": 0.03, "emission": "{emission}"}}"#
        )
    };
    assert!(learns_a_guide(&scene, "sppm", &parameters("guided")));
    let [power, guided] = ["power", "guided"].map(|emission| mean_and_error(&scene, "sppm", &parameters(emission), 8));
    assert_same(guided, power, 0.0, "guided and by power");
    assert_same(guided, mean_and_error(&scene, "path", "{}", 8), 0.01, "guided and path");
    assert!(guided[1] < 0.03 * guided[0], "the test is blind");
}

#[test]
fn a_guided_furnace_is_a_furnace() {
    let scene = reference_scene("furnace-closed");
    let parameters = r#"{"initial_radius": 0.01, "photons_per_pass": 16384, "emission": "guided"}"#;
    assert!(learns_a_guide(&scene, "sppm", parameters));
    let [found, error, _] = mean_and_error(&scene, "sppm", parameters, 4);
    println!("{found:.5} ± {error:.5}");
    assert!((found - 1.0).abs() < ERRORS * error + 0.003 && error < 0.0035, "{found} ± {error}");
}

/// Methods that weigh ways of finding paths guide lights as wholes, and their weights know it.
#[test]
fn light_subpaths_come_from_lamps_that_matter() {
    let (scene, alone) =
        (repository_scene("sealed-lamp/scene.xml", "16"), repository_scene("sealed-lamp/alone.xml", "16"));
    let expected = mean_and_error(&alone, "path", "{}", 32);
    for method in ["bdpt", "vcm", "pbdpm", "light_tracing"] {
        let radius = if method == "pbdpm" { r#""initial_radius": 0.1, "# } else { "" };
        let photons = if matches!(method, "vcm" | "pbdpm") { r#""photons_per_pass": 4000, "# } else { "" };
        let parameters = |emission: &str| format!(r#"{{{radius}{photons}"emission": "{emission}"}}"#);
        let [auto, power] = ["auto", "power"].map(|emission| mean_and_error(&scene, method, &parameters(emission), 2));
        assert!(learns_a_guide(&scene, method, &parameters("auto")), "{method}: the pilot finds that it helps");
        let bias = if method == "pbdpm" { 0.03 } else { 0.005 };
        assert_same(auto, expected, bias, &format!("{method}, and path without the lamp"));
        let without = mean_and_error(&alone, method, &parameters("power"), 1);
        let [auto, power, without] = [auto, power, without].map(|[_, _, noise]| noise);
        println!("{method}: {auto} guided, {power} by power, {without} alone");
        // The noise of light_tracing is that of rare bright paths, of which so few passes do not tell.
        assert!(method == "light_tracing" || auto < power && auto < 2.0 * without, "{method} is noisy");
    }
}

/// Nothing is paid where nothing is to be gained.
#[test]
fn photons_of_a_lamp_in_an_open_box_start_by_power() {
    for name in ["cornell-diffuse", "cornell-glass", "lantern", "furnace-closed"] {
        let scene = reference_scene(name);
        assert!(!learns_a_guide(&scene, "sppm", r#"{"emission": "auto"}"#), "{name}");
        let pilot = |emission: &str| {
            let job = Job::new(&scene, "sppm", &format!(r#"{{"emission": "{emission}"}}"#));
            job.renderer.pilot(&job.never).expect("nobody cancels")
        };
        assert_eq!(pilot("auto"), pilot("power"), "{name}: the same radii, the same cut");
    }
}

#[test]
fn guided_pictures_have_the_same_bits_from_any_number_of_threads() {
    let scene = repository_scene("sealed-lamp/scene.xml", "24");
    let parameters = r#"{"photons_per_pass": 10000, "emission": "auto"}"#;
    let bits = bits_of_threads(&scene, "sppm", parameters);
    assert!(learns_a_guide(&scene, "sppm", parameters));
    assert!(bits[0] == bits[1] && bits[1] == bits[2]);
}

/// Paths of two lights, spread evenly, that are worth what `worth` says of light and numbers.
fn paths(worth: impl Fn(u32, [f32; 4]) -> f64) -> Vec<EmittedPath> {
    let random = PassRandom::independent(11, Stream::Photon, 0);
    let path = |index: u32| {
        let light = index % 2;
        let numbers = random.path(index).block(0);
        EmittedPath { start: EmissionPoint { light, numbers, density: 1.0 }, worth: worth(light, numbers) }
    };
    (0..1 << 16).map(path).collect()
}

#[test]
fn what_photons_are_worth_is_learnt() {
    // An eighth of the second light is worth anything: photons that start there with density q have 1/q of the variance. An eighth goes by power,
    // and an eighth of the others evenly over that light.
    let corner = paths(|light, numbers| f64::from(u8::from(light == 1 && numbers[0] < 0.5 && numbers[2] > 0.75)));
    let lesson = learn(&corner, GuideParts::Cells, 2, |_| 0.5).expect("photons are worth something");
    let best = BY_POWER + (1.0 - BY_POWER) * (0.875 + 0.125 / 8.0) * 16.0;
    assert!((lesson.gain / best - 1.0).abs() < 0.1, "a gain of {} where {best} can be had", lesson.gain);
    // Where all is worth the same, no cell is cut and nothing is gained.
    let even = learn(&paths(|_, _| 2.0), GuideParts::Cells, 2, |_| 0.5).expect("photons are worth something");
    assert!((even.gain - 1.0).abs() < 1e-3 && even.values.len() == 2, "{even:?}");
    assert_eq!(learn(&paths(|_, _| 0.0), GuideParts::Cells, 2, |_| 0.5), None);
}
