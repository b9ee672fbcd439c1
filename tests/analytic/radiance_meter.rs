//! `radiancemeter`: one number of closed form. Mitsuba 3.9.1 shows 0.2431, 0.2336, 0.2238 ± 0.0006 for the first ray.

use std::sync::Arc;

use crate::rendered::rendered;
use crate::scene_files::prepare;
use photonfarm::scene::Scene;

/// A checkerboard of 0.4 and 0.2 under an even sky of radiance 1 and a lamp.
fn scene(meter: &str, side: u32) -> Result<Scene, String> {
    let body = format!(
        "<sensor type='radiancemeter'>{meter}<film type='hdrfilm'><integer name='width' value='{side}'/>
        <integer name='height' value='{side}'/><rfilter type='box'/></film></sensor>
        <emitter type='constant'/>
        <emitter type='point'><point name='position' x='1' y='2' z='3'/><rgb name='intensity' value='9, 7, 5'/></emitter>
        <shape type='rectangle'><transform name='to_world'><scale value='2'/></transform><bsdf type='diffuse'>
        <texture name='reflectance' type='checkerboard'><transform name='to_uv'><scale value='6'/></transform></texture></bsdf></shape>"
    );
    prepare(&body, &[]).map_err(|error| error.to_string())
}

/// ρ/π (π + I cos θ/d²) arrives from a point (x, y, 0).
fn expected(reflectance: f64, [x, y]: [f64; 2], intensity: f64) -> f64 {
    let squared = (1.0 - x).powi(2) + (2.0 - y).powi(2) + 9.0;
    reflectance * (1.0 + intensity * 3.0 / (squared * squared.sqrt() * std::f64::consts::PI))
}

#[test]
fn closed_form_of_a_radiance_meter() {
    let rays = [
        ("<point name='origin' x='0.3' y='0.2' z='3'/><vector name='direction' y='0.1' z='-1'/>", 0.2, [0.3, 0.5]),
        // A transform counts before them.
        (
            "<transform name='to_world'><lookat origin='1.1, 0.5, 3' target='1.1, 0.5, 0' up='0, 1, 0'/></transform>
            <point name='origin' z='3'/><vector name='direction' z='-1'/>",
            0.4,
            [1.1, 0.5],
        ),
    ];
    for (ray, reflectance, place) in rays {
        let scene = Arc::new(scene(ray, 1).expect("a good scene"));
        for method in ["path", "bdpt"] {
            let pixels = rendered(&scene, method, serde_json::Map::new(), 256, 9).radiance;
            for (channel, intensity) in [9.0, 7.0, 5.0].into_iter().enumerate() {
                let (found, expected) = (f64::from(pixels[0][channel]), expected(reflectance, place, intensity));
                assert!((found / expected - 1.0).abs() < 0.02, "{method}, {ray}: {found} for {expected}");
            }
        }
    }
}

#[test]
fn radiance_meters_that_cannot_be() {
    for (meter, side, expected) in [
        ("", 4, "the film of a radiancemeter has 4 × 4 pixels"),
        ("<point name='origin' z='3'/>", 1, "\"origin\" and \"direction\" belong together"),
        ("<point name='origin' z='3'/><vector name='direction' z='0'/>", 1, "\"direction\" has no length"),
        ("<float name='fov' value='3'/>", 1, "has no parameter \"fov\""),
    ] {
        let found = scene(meter, side).err().unwrap_or_else(|| panic!("{meter} is no error"));
        assert!(found.contains(expected), "{found}");
    }
}
