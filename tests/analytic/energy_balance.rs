//! Photon energy: what lights send out arrives, is reflected with the albedo, and nothing is lost or made.
//!
//! Means over photon paths are compared with closed forms at four standard errors (6·10⁻⁵ each); seeds are fixed.

use std::f64::consts::PI;
use std::path::Path;

use crate::scene_text::prepare;
use photonfarm::import::load_file;
use photonfarm::math::Vec3;
use photonfarm::math::random::{PassRandom, Stream};
use photonfarm::scene::Scene;
use photonfarm::scene::geometry::Ray;
use photonfarm::scene::light::Light;
use photonfarm::scene::material::{TransportMode, View};
use photonfarm::transport::photon_map::Photon;
use photonfarm::transport::photon_tracing::{PhotonSettings, trace_photon};
use photonfarm::transport::{Counters, Limits};

const PATHS: u32 = 100_000;

/// Mean flux stored per path and its standard error, W. `most_segments` limits the segments of a stored photon.
fn stored_flux(scene: &Scene, most_segments: Option<u32>) -> (f64, f64) {
    let random = PassRandom::independent(5, Stream::Photon, 0);
    let settings = PhotonSettings {
        // A photon leaves one segment to the camera.
        limits: Limits { max_depth: most_segments.map(|segments| segments + 1), rr_depth: 1 },
        first_stored_segment: 1,
        narrow_takes_all: false,
        random: &random,
        paths: PATHS,
        guide: None,
    };
    let (mut photons, mut counters) = (Vec::<Photon>::new(), Counters::default());
    let (mut sum, mut squares) = (0.0, 0.0);
    for path in 0..PATHS {
        photons.clear();
        trace_photon(scene, &settings, path, &mut photons, &mut counters);
        let flux: f64 = photons.iter().map(|photon| f64::from(photon.flux[0])).sum();
        sum += flux;
        squares += flux * flux;
    }
    assert_eq!(counters.non_finite, 0);
    let mean = sum / f64::from(PATHS);
    (mean, ((squares / f64::from(PATHS) - mean * mean).max(0.0) / f64::from(PATHS)).sqrt())
}

fn power(scene: &Scene) -> f64 {
    scene.lights.lights().iter().map(Light::power).map(|power| f64::from(power.x)).sum()
}

fn assert_flux(scene: &Scene, most_segments: Option<u32>, expected: f64, what: &str) {
    let (mean, error) = stored_flux(scene, most_segments);
    // Rounding of single precision may add a little where nothing is random.
    let bound = 4.0 * error + 2e-5 * expected;
    assert!((mean - expected).abs() < bound, "{what}: {mean} ± {error} W stored where {expected} W arrive");
    assert!(bound < 0.03 * expected, "{what}: the test is blind");
}

fn scene(body: &str) -> Scene {
    prepare(&format!("<sensor type='perspective'/>{body}"), &[]).expect("the scene is good")
}

fn closed_room(shape: &str, albedo: f64) -> Scene {
    let bsdf = format!("<bsdf type='diffuse'><rgb name='reflectance' value='{albedo}, {albedo}, {albedo}'/></bsdf>");
    scene(&format!(
        "<shape type='{shape}'><boolean name='flip_normals' value='true'/>{bsdf}</shape>\
        <emitter type='point'><point name='position' value='0.3, -0.4, 0.5'/><rgb name='intensity' value='2, 2, 2'/></emitter>"
    ))
}

#[test]
fn analytic_closed_rooms_store_the_geometric_series() {
    for shape in ["cube", "sphere"] {
        for albedo in [0.0, 0.5, 0.8, 0.95] {
            let room = closed_room(shape, albedo);
            let emitted = 8.0 * PI;
            assert!((power(&room) / emitted - 1.0).abs() < 1e-5);
            let what = format!("{shape} of albedo {albedo}");
            assert_flux(&room, None, emitted / (1.0 - albedo), &what);
            // Σ_{k<n} ρᵏ for paths of at most n segments.
            let three = emitted * (1.0 + albedo + albedo * albedo);
            assert_flux(&room, Some(3), three, &format!("{what}, three segments"));
        }
    }
}

#[test]
fn analytic_furnaces_store_five_times_what_they_emit() {
    // Albedo 0.8 wherever photons are stored; mirror and glass lose nothing.
    for name in ["furnace-closed", "furnace-specular"] {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/references").join(name);
        let description = load_file(&folder.join("scene.xml"), &[]).expect("a reference scene loads");
        let furnace = Scene::prepare(&description).expect("a reference scene is good");
        assert_flux(&furnace, None, power(&furnace) / (1.0 - 0.8), name);
    }
}

const BLACK: &str =
    "<bsdf type='twosided'><bsdf type='diffuse'><rgb name='reflectance' value='0, 0, 0'/></bsdf></bsdf>";

#[test]
fn analytic_distant_light_on_what_it_meets() {
    let sun = "<emitter type='directional'><vector name='direction' value='0, -3, -4'/>\
        <rgb name='irradiance' value='2, 2, 2'/></emitter>";
    // A black floor of 2 × 2 m that the sun meets at a cosine of 0.6, alone and far off the middle of a larger scene.
    let floor = format!(
        "<shape type='rectangle'><transform name='to_world'><rotate x='1' angle='-90'/></transform>{BLACK}</shape>"
    );
    let lit = scene(&format!("{floor}{sun}"));
    let arriving = 2.0 * 4.0 * 0.6;
    assert!((power(&lit) / arriving - 1.0).abs() < 1e-5, "{} W are sent where {arriving} W arrive", power(&lit));
    assert_flux(&lit, None, arriving, "floor in the sun");
    // With a ball above its corner, most of what enters the box passes by.
    let ball_above = format!(
        "<shape type='sphere'><float name='radius' value='0.1'/><point name='center' value='0.8, 2, 0.8'/>{BLACK}</shape>"
    );
    let both = arriving + 2.0 * PI * 0.01;
    assert_flux(&scene(&format!("{floor}{ball_above}{sun}")), None, both, "floor and ball in the sun");

    let ball = format!(
        "<shape type='sphere'><float name='radius' value='0.5'/><point name='center' value='1, 2, 3'/>{BLACK}</shape>"
    );
    assert_flux(&scene(&format!("{ball}{sun}")), None, 2.0 * PI * 0.25, "ball in the sun");
    // A convex body gets π·L·A from an environment.
    let sky = "<emitter type='constant'><rgb name='radiance' value='3, 3, 3'/></emitter>";
    assert_flux(&scene(&format!("{ball}{sky}")), None, 3.0 * PI * PI, "ball under the sky");
    let cube = format!(
        "<shape type='cube'><transform name='to_world'><scale x='1' y='2' z='0.5'/><rotate y='1' angle='20'/></transform>{BLACK}</shape>"
    );
    let area = 8.0 * (2.0 + 1.0 + 0.5);
    // The sensor stands in the middle of this one, which is two-sided.
    assert_flux(&scene(&format!("{cube}{sky}")), None, 3.0 * PI * area, "cube under the sky");
}

#[test]
fn analytic_near_lights_reach_the_walls() {
    let room = format!("<shape type='sphere'><float name='radius' value='3'/>{BLACK}</shape>");
    let radiance = "<emitter type='area'><rgb name='radiance' value='3, 3, 3'/></emitter>";
    let lamps = [
        ("<shape type='rectangle'>LIGHT</shape>", PI * 4.0 * 3.0),
        ("<shape type='disk'>LIGHT</shape>", PI * PI * 3.0),
        ("<shape type='sphere'><float name='radius' value='0.5'/>LIGHT</shape>", PI * PI * 3.0),
        ("<shape type='cube'>LIGHT</shape>", PI * 24.0 * 3.0),
        (
            "<emitter type='spot'><float name='cutoff_angle' value='40'/><float name='beam_width' value='40'/></emitter>",
            { 2.0 * PI * (1.0 - 40f64.to_radians().cos()) },
        ),
    ];
    for (lamp, expected) in lamps {
        let lamp = lamp.replace("LIGHT", &format!("{BLACK}{radiance}"));
        let lit = scene(&format!("{room}{lamp}"));
        assert_flux(&lit, None, expected, &lamp);
    }
}

/// As in Mitsuba a shape without a bsdf is grey, but black if it emits.
#[test]
fn shapes_that_emit_reflect_nothing_unless_told() {
    let reflected = |parts: &str| {
        let lit = scene(&format!("<shape type='rectangle'>{parts}</shape><emitter type='constant'/>"));
        let ray = Ray { origin: Vec3::Z, direction: Vec3::NEG_Z, length: 2.0 };
        let hit = lit.intersect(&ray).expect("the rectangle is there");
        let view = View::new(hit.uv, Vec3::Z, TransportMode::Radiance);
        lit.material(hit.shape).sample(&view, [0.4; 3]).map_or(0.0, |sample| sample.weight.x)
    };
    let grey = "<bsdf type='diffuse'/>";
    assert!((reflected("") - 0.5).abs() < 1e-6);
    assert!(reflected("<emitter type='area'/>").abs() < 1e-6);
    assert!((reflected(&format!("<emitter type='area'/>{grey}")) - 0.5).abs() < 1e-6);
}
