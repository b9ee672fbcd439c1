//! Look-ups of `photon_map` with tests of plausibility and with a chosen k: where they help, where they fail, and by how much.
//!
//! A beam falls from a mirror, so that all its photons are caustic, come straight from above and lie evenly. Gathering them in three
//! segments finds no other light.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::progressive::Job;
use crate::scene_text;
use photonfarm::method::{MethodChoice, check};
use photonfarm::scene::Scene;

/// Radiance of a white floor in the beam.
const LIT: f64 = 1.0 / PI;
const WHITE: &str = "<bsdf type='diffuse'><rgb name='reflectance' value='1'/></bsdf>";

/// A horizontal sun, and a mirror that turns it down on −1 < x < 0, −1 < z < 1.
fn in_the_beam(shapes: &str, origin: &str, target: &str, fov: f64) -> Arc<Scene> {
    let body = format!(
        "<sensor type='perspective'><float name='fov' value='{fov}'/><transform name='to_world'>\
         <lookat origin='{origin}' target='{target}' up='0, 0, 1'/></transform><film type='hdrfilm'>\
         <integer name='width' value='16'/><integer name='height' value='16'/><rfilter type='box'/></film></sensor>\
         <emitter type='directional'><vector name='direction' x='1' y='0' z='0'/><rgb name='irradiance' value='1'/></emitter>\
         <shape type='rectangle'><transform name='to_world'><scale x='0.7071068' y='1'/>\
         <lookat origin='-0.5, 1.5, 0' target='-1.5, 0.5, 0' up='0, 0, 1'/></transform>\
         <bsdf type='conductor'><string name='material' value='none'/></bsdf></shape>{shapes}"
    );
    Arc::new(scene_text::prepare(&body, &[]).expect("the scene is good"))
}

/// A white rectangle of half sides `half`, around `middle`, that faces `normal`.
fn rectangle(half: [f64; 2], middle: [f64; 3], normal: [f64; 3]) -> String {
    let text = |place: [f64; 3]| place.map(|coordinate| coordinate.to_string()).join(", ");
    let target: [f64; 3] = std::array::from_fn(|axis| middle[axis] + normal[axis]);
    format!(
        "<shape type='rectangle'><transform name='to_world'><scale x='{}' y='{}'/>\
         <lookat origin='{}' target='{}' up='0, 0, 1'/></transform>{WHITE}</shape>",
        half[0],
        half[1],
        text(middle),
        text(target)
    )
}

/// A floor, seen where the beam lights it.
fn lit_floor() -> Arc<Scene> {
    in_the_beam(&floor(), "0.3, 0.9, 0", "-0.5, 0, 0", 16.0)
}

fn floor() -> String {
    rectangle([1.0, 1.0], [0.0; 3], [0.0, 1.0, 0.0])
}

/// The mean of a picture over the radiance of a white floor in the beam.
fn mean(scene: &Arc<Scene>, parameters: &str, passes: u32) -> f64 {
    let parameters =
        format!(r#"{{"max_depth": 3, "emission": "power", "occlusion": "off", "kernel": "disc", {parameters}}}"#);
    let picture = Job::new(scene, "photon_map", &parameters).run(passes, 8).picture();
    picture.radiance.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / (picture.radiance.len() as f64 * LIT)
}

/// Two facets of a ridge, 30° apart: the beam grazes the upper one and does not reach the lower.
#[test]
fn analytic_the_arrival_angle_takes_light_off_the_dark_side_of_a_ridge() {
    let facet = |degrees: f64, up: f64| {
        let (sine, cosine) = degrees.to_radians().sin_cos();
        let along = 0.2 * up;
        rectangle([0.2, 1.0], [-0.5 - along * cosine, 0.3 + along * sine, 0.0], [sine, cosine, 0.0])
    };
    let shapes = facet(75.0, 1.0) + &facet(105.0, -1.0);
    let seen_at = |height: f64| in_the_beam(&shapes, "1, 0.25, 0", &format!("-0.5, {height}, 0"), 3.0);
    let (dark, lit) = (seen_at(0.25), seen_at(0.4));
    let look = |scene: &Arc<Scene>, test: &str| {
        mean(scene, &format!(r#"{test}"photons_per_pass": 40000, "largest_radius": 0.1"#), 64)
    };
    let leak = look(&dark, "");
    println!("the dark side of a ridge: {leak:.4} of the floor's radiance");
    assert!(leak > 0.01, "the test is blind: {leak}");
    assert_eq!(look(&dark, r#""arrival_angle": 90, "#), 0.0);
    // The beam is 75° off the normal of the lit side.
    let all = look(&lit, "");
    assert!((all - 75f64.to_radians().cos()).abs() < 0.02, "{all}");
    assert_eq!(look(&lit, r#""arrival_angle": 76, "#), all);
    assert_eq!(look(&lit, r#""arrival_angle": 74, "#), 0.0);
}

/// A shelf over the floor, out of the beam: photons of the floor beside it are behind its plane.
#[test]
fn analytic_the_culling_plane_keeps_light_of_the_floor_off_a_shelf() {
    let shapes = floor() + &rectangle([0.5, 1.0], [0.5, 0.01, 0.0], [0.0, 1.0, 0.0]);
    let shelf = in_the_beam(&shapes, "0.6, 0.5, 0", "0.07, 0.01, 0", 5.0);
    let look = |test: &str| mean(&shelf, &format!(r#"{test}"photons_per_pass": 40000, "largest_radius": 0.1"#), 4);
    let leak = look("");
    println!("a shelf beside a lit floor: {leak:.4} of the floor's radiance");
    assert!(leak > 0.02, "the test is blind: {leak}");
    assert_eq!(look(r#""culling_plane": "on", "#), 0.0);
    let floor = lit_floor();
    let look = |test: &str| mean(&floor, &format!(r#"{test}"photons_per_pass": 40000"#), 2);
    assert_eq!(look(r#""culling_plane": "on", "arrival_angle": 90, "#), look(""), "a flat floor loses nothing");
}

/// A white sphere in a white furnace, whose radiance is 1 everywhere; a fifth of it is direct light. Of the rest, light of a disc of
/// radius r on a sphere of radius R, an arrival angle of 90° loses (r/R)²/8, and the culling plane all.
#[test]
fn analytic_plausibility_tests_darken_a_sphere() {
    const DIRECT: f64 = 0.2;
    const RATIO: f64 = 0.14 / 0.3;
    let scene = scene_text::prepare(
        "<sensor type='perspective'><float name='fov' value='20'/><transform name='to_world'>\
         <lookat origin='0, 0, 0.9' target='0, 0, 0' up='0, 1, 0'/></transform><film type='hdrfilm'>\
         <integer name='width' value='16'/><integer name='height' value='16'/><rfilter type='box'/></film></sensor>\
         <shape type='sphere'><boolean name='flip_normals' value='true'/>\
         <bsdf type='diffuse'><rgb name='reflectance' value='0.8'/></bsdf>\
         <emitter type='area'><rgb name='radiance' value='0.2'/></emitter></shape>\
         <shape type='sphere'><float name='radius' value='0.3'/>\
         <bsdf type='diffuse'><rgb name='reflectance' value='1'/></bsdf></shape>",
        &[],
    );
    let scene = Arc::new(scene.expect("the scene is good"));
    let look = |test: &str| {
        let parameters = format!(
            r#"{{{test}"photons_per_pass": 40000, "final_gather": 0, "neighbors": 65536, "largest_radius": 0.14,
               "kernel": "disc", "occlusion": "off", "emission": "power"}}"#
        );
        let picture = Job::new(&scene, "photon_map", &parameters).run(8, 8).picture();
        picture.radiance.iter().map(|pixel| f64::from(pixel[0])).sum::<f64>() / picture.radiance.len() as f64
    };
    let [all, angle, plane] = ["", r#""arrival_angle": 90, "#, r#""culling_plane": "on", "#].map(look);
    println!("a sphere in a furnace: {all:.4}, by the arrival angle {angle:.4}, by the culling plane {plane:.4}");
    assert!((all - 1.0).abs() < 0.01, "{all} without tests");
    let expected = (1.0 - DIRECT) * RATIO * RATIO / 8.0;
    assert!((all - angle - expected).abs() < 0.12 * expected, "{} is not {expected}", all - angle);
    assert!((plane - DIRECT).abs() < 0.01, "{plane} is more than direct light");
}

/// Four photons in a disc on average: look-ups with fewer than five are black, and bring no light of them.
#[test]
fn analytic_too_few_photons_lose_energy() {
    const RADIUS: f64 = 0.05;
    let scene = lit_floor();
    // The sun's photons start evenly on the 4 m² that it sees of the box around the scene.
    let photons = (4.0 * 4.0 / (PI * RADIUS * RADIUS)).round();
    let look = |fewest: u32| {
        let parameters = format!(
            r#""photons_per_pass": {photons}, "largest_radius": {RADIUS}, "caustic_neighbors": 50, "fewest_photons": {fewest}"#
        );
        mean(&scene, &parameters, 256)
    };
    let [all, many] = [0, 10].map(look);
    // E[N; N ≥ 5] = 4·P(N ≥ 4) of a Poisson number of mean 4.
    let expected = 1.0 - (-4.0f64).exp() * (1.0 + 4.0 + 8.0 + 32.0 / 3.0);
    println!("four photons a disc: {all:.4}, where five are asked for {many:.4}; expected {expected:.4}");
    assert!((all - 1.0).abs() < 0.02, "{all}");
    assert!((many / all - expected).abs() < 0.02, "{}", many / all);
}

/// Where photons lie evenly, a k that is chosen by the centre of gravity has a bias, one by the mean direction has none.
#[test]
fn analytic_the_choice_of_k_on_an_even_floor() {
    let scene = lit_floor();
    let look = |choice: &str| {
        let parameters = format!(
            r#""photons_per_pass": 20000, "largest_radius": 0.2, "caustic_neighbors": 10, "neighbor_choice": "{choice}""#
        );
        mean(&scene, &parameters, 256)
    };
    let [fixed, gravity, direction] = ["fixed", "centre_of_gravity", "mean_direction"].map(look);
    println!("an even floor, k = 10: fixed {fixed:.4}, centre of gravity {gravity:.4}, mean direction {direction:.4}");
    assert!((fixed - 1.0).abs() < 0.01, "{fixed}");
    assert!((direction - fixed).abs() < 0.01, "{direction}");
    // 2.5 % by a simulation of discs in the plane.
    assert!((gravity - fixed + 0.025).abs() < 0.01, "{gravity}");
}

/// At the border of the beam, both choices take light back from the dark side and to the bright one.
#[test]
fn agreement_the_choice_of_k_at_a_border() {
    let seen_at = |place: f64| in_the_beam(&floor(), &format!("{place}, 0.5, 0"), &format!("{place}, 0, 0"), 5.0);
    // Pictures reach 0.022 m to both sides.
    let (bright, dark) = (seen_at(-0.025), seen_at(0.025));
    let look = |choice: &str| {
        let parameters = format!(
            r#""photons_per_pass": 40000, "largest_radius": 0.2, "caustic_neighbors": 100, "neighbor_choice": "{choice}""#
        );
        [1.0 - mean(&bright, &parameters, 16), mean(&dark, &parameters, 16)]
    };
    let [fixed, gravity, direction] = ["fixed", "centre_of_gravity", "mean_direction"].map(look);
    println!(
        "beside a border, missing and leaked: {fixed:.3?}, centre of gravity {gravity:.3?}, direction {direction:.3?}"
    );
    for chosen in [gravity, direction] {
        let is_less = chosen[0] < 0.9 * fixed[0] && chosen[1] < 0.8 * fixed[1];
        assert!(is_less, "{chosen:?} is hardly less than {fixed:?}");
    }
}

#[test]
fn parameters_of_look_ups_that_cannot_be() {
    let refused = [
        (r#"{"arrival_angle": 0}"#, "\"arrival_angle\" is 0; allowed: 1 to 180"),
        (r#"{"arrival_angle": 181}"#, "\"arrival_angle\" is 181; allowed: 1 to 180"),
        (r#"{"culling_plane": true}"#, "\"culling_plane\" is true; allowed: on, off"),
        (r#"{"fewest_photons": 101}"#, "\"fewest_photons\" is 101; allowed: 0 to 100"),
        (
            r#"{"fewest_photons": 10}"#,
            "\"fewest_photons\" is 10 % of \"caustic_neighbors\" 10, and what finds less than one photon is black already; \
             give more than 10, or 0",
        ),
        (
            r#"{"neighbor_choice": "gravity"}"#,
            "\"neighbor_choice\" is \"gravity\"; allowed: fixed, centre_of_gravity, mean_direction",
        ),
        (
            r#"{"neighbor_choice": "mean_direction", "neighbors": 2, "caustic_neighbors": 2}"#,
            "\"neighbor_choice\" has nothing to choose from where \"neighbors\" and \"caustic_neighbors\" are 2; \
             give more neighbors, or \"fixed\"",
        ),
    ];
    for (parameters, expected) in refused {
        let parameters = serde_json::from_str(parameters).expect("an object");
        let choice = MethodChoice { name: "photon_map".to_owned(), parameters };
        let message = check(&choice, 100).expect_err("refused").to_string();
        assert_eq!(message, format!("method \"photon_map\": {expected}"));
    }
}
