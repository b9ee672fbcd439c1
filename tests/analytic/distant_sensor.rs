//! `distant`: the mean radiance that a scene sends in a direction, of closed form, and as Mitsuba 3.9.1 measures it.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::rendered::rendered;
use crate::scene_files::prepare;
use photonfarm::scene::Scene;

const BALL: &str =
    "<shape type='sphere'><point name='center' x='0.3' y='0.1' z='0.4'/><float name='radius' value='0.4'/>
    <bsdf type='diffuse'><rgb name='reflectance' value='0.5'/></bsdf></shape>";

/// A one-sided floor of [-1, 1]² under an even sky of radiance 1.
fn scene(sensor: &str, film: &str, further: &str) -> Result<Scene, String> {
    let body = format!(
        "<sensor type='distant'>{sensor}<film type='hdrfilm'>{film}</film></sensor><emitter type='constant'/>{further}
        <shape type='rectangle'><bsdf type='diffuse'><rgb name='reflectance' value='0.6, 0.4, 0.2'/></bsdf></shape>"
    );
    prepare(&body, &[]).map_err(|error| error.to_string())
}

const PIXEL: &str = "<integer name='width' value='1'/><integer name='height' value='1'/>";

fn mean(scene: Scene, method: &str, passes: u32) -> [f32; 3] {
    let mut parameters = serde_json::Map::from_iter([("max_depth".to_owned(), 3.into())]);
    // Direct light is sampled: photons are not what takes time here.
    parameters.extend((method == "sppm").then(|| ("photons_per_pass".to_owned(), 64.into())));
    rendered(&Arc::new(scene), method, parameters, passes, 5).radiance[0]
}

/// The floor is a part of the disc of area 2π round it, and the rest of the disc sees the sky.
#[test]
fn closed_form_of_a_distant_sensor() {
    let down = |x: f64| format!("<vector name='direction' x='{x}' z='-1'/>");
    let turned = "<transform name='to_world'><rotate x='1' angle='180'/></transform>";
    let box_filter = format!("{PIXEL}<rfilter type='box'/>");
    let border = format!("{PIXEL}<boolean name='sample_border' value='true'/>");
    let cases = [
        (down(0.0), PIXEL, 1.0, 1.0),
        (down(0.75), &box_filter, 0.8, 1.0),
        (turned.to_owned(), &border, 1.0, 1.0),
        // From below its back is black.
        ("<vector name='direction' z='1'/>".to_owned(), PIXEL, 1.0, 0.0),
        (String::new(), PIXEL, 1.0, 0.0),
    ];
    for (sensor, film, cosine, front) in cases {
        // Roulette and pairs of subpaths are noisier than paths alone.
        for (method, passes) in [("path", 4096), ("bdpt", 4096), ("light_tracing", 16384), ("sppm", 4096)] {
            let scene = scene(&sensor, film, "").expect("a good scene");
            for (found, reflectance) in mean(scene, method, passes).into_iter().zip([0.6, 0.4, 0.2]) {
                let share = 4.0 * cosine / (2.0 * PI);
                let expected = share * front * reflectance + 1.0 - share;
                let off = f64::from(found) - expected;
                assert!(off.abs() < 0.025, "{method}, {sensor}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn closed_form_of_a_distant_sensor_that_looks_at_a_point() {
    let at = |x: f64| format!("<vector name='direction' x='0.3' z='-1'/><point name='target' x='{x}' y='0.2' z='0'/>");
    for (sensor, expected) in [(at(0.3), [0.6, 0.4, 0.2]), (at(30.0), [1.0; 3])] {
        for method in ["path", "bdpt"] {
            let found = mean(scene(&sensor, PIXEL, "").expect("a good scene"), method, 256);
            for (found, expected) in found.into_iter().zip(expected) {
                assert!((found - expected).abs() < 0.02, "{method}, {sensor}: {found} for {expected}");
            }
        }
    }
}

/// Mitsuba 3.9.1, `scalar_rgb`, 40 000 samples of `path` with `max_depth` 3: ± 0.002.
#[test]
fn agreement_of_a_distant_sensor_with_mitsuba() {
    for (direction, expected) in
        [("x='0' z='-1'", [0.7346, 0.6396, 0.5445]), ("x='0.3' y='0.2' z='-1'", [0.7475, 0.6585, 0.5696])]
    {
        let sensor = format!("<vector name='direction' {direction}/>");
        let found = mean(scene(&sensor, PIXEL, BALL).expect("a good scene"), "path", 16384);
        for (found, expected) in found.into_iter().zip(expected) {
            assert!((found - expected).abs() < 0.012, "{direction}: {found} for {expected}");
        }
    }
}

#[test]
fn distant_sensors_that_cannot_be() {
    let film = "<integer name='width' value='4'/><integer name='height' value='1'/>";
    let both = "<vector name='direction' z='1'/><transform name='to_world'><translate x='1'/></transform>";
    for (sensor, film, expected) in [
        ("", film, "the film of a distant sensor has 4 × 1 pixels; give it one of width 1 and height 1"),
        (both, PIXEL, "there are \"direction\" and \"to_world\"; give one of them"),
        ("<vector name='direction' z='0'/>", PIXEL, "\"direction\" has no length"),
        ("<shape type='disk' name='target'/>", PIXEL, "the \"target\" of a distant sensor is a shape; give a point"),
        ("<float name='near_clip' value='1'/>", PIXEL, "has no parameter \"near_clip\""),
    ] {
        let found = scene(sensor, film, "").err().unwrap_or_else(|| panic!("{sensor} is no error"));
        assert!(found.contains(expected), "{found}");
    }
}
