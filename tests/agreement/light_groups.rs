//! Light groups: the picture of each is that of a scene in which nothing else emits, and all together are the picture.

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use rayon::ThreadPoolBuilder;

use crate::methods::{ERRORS, mean_and_error};
use crate::progressive::Job;
use crate::scene_text::prepare;
use photonfarm::estimate::{Estimate, Picture, Region, Shard, Tally};
use photonfarm::method::{self, CheckedMethod, MethodChoice};
use photonfarm::render::{Guides, Renderer};
use photonfarm::scene::Scene;

const GROUPS: [&str; 3] = ["lamp", "bulb", "others"];
/// Radii are given: the pilot finds them for all light, so that those of a group alone would be others, and their bias with them.
const METHODS: [(&str, &str); 8] = [
    ("path", "{}"),
    ("bdpt", "{}"),
    ("light_tracing", "{}"),
    ("sppm", r#"{"photons_per_pass": 4096, "initial_radius": 0.1}"#),
    (
        "sppm",
        r#"{"photons_per_pass": 4096, "initial_radius": 0.1, "emission": "guided", "light_picks": "visible", "radius_rule": "uniformity"}"#,
    ),
    ("vcm", r#"{"photons_per_pass": 4096, "initial_radius": 0.05}"#),
    ("photon_map", r#"{"photons_per_pass": 8192, "final_gather": 4}"#),
    ("mmlt", "{}"),
];

/// A lamp that the camera sees, a point light and an environment over a matte floor with a ball; only those of `lit` emit.
fn scene(lit: &[&str]) -> Arc<Scene> {
    let when = |name: &str, emitter: &str| if lit.contains(&name) { emitter.to_owned() } else { String::new() };
    let lamp = when(
        "lamp",
        "<emitter type='area'><rgb name='radiance' value='8, 4, 2'/><string name='light_group' value='lamp'/></emitter>",
    );
    let bulb = when(
        "bulb",
        "<emitter type='point'><point name='position' value='-0.7, 0.3, 0.8'/><rgb name='intensity' value='0.2, 0.5, 0.2'/>\
         <string name='light_group' value='bulb'/></emitter>",
    );
    let sky = when("others", "<emitter type='constant'><rgb name='radiance' value='0.1, 0.2, 0.5'/></emitter>");
    let body = format!(
        "<sensor type='perspective'><float name='fov' value='50'/><transform name='to_world'>\
         <lookat origin='0, -2.5, 1.5' target='0, 0, 0.4' up='0, 0, 1'/></transform><film type='hdrfilm'>\
         <integer name='width' value='16'/><integer name='height' value='12'/><rfilter type='box'/></film></sensor>\
         <shape type='rectangle'><transform name='to_world'><scale value='2'/></transform>\
         <bsdf type='diffuse'><rgb name='reflectance' value='0.6, 0.5, 0.4'/></bsdf></shape>\
         <shape type='sphere'><point name='center' value='0.4, 0, 0.3'/><float name='radius' value='0.3'/>\
         <bsdf type='diffuse'><rgb name='reflectance' value='0.3, 0.6, 0.3'/></bsdf></shape>\
         <shape type='sphere'><point name='center' value='-0.4, 0.5, 1'/><float name='radius' value='0.15'/>\
         <bsdf type='diffuse'/>{lamp}</shape>{bulb}{sky}"
    );
    Arc::new(prepare(&body, &[]).expect("the scene is good"))
}

fn checked(scene: &Scene, method: &str, parameters: &str) -> CheckedMethod {
    let parameters = serde_json::from_str(parameters).expect("parameters are a JSON object");
    let choice = MethodChoice { name: method.to_owned(), parameters };
    method::check(&choice, scene.pixel_count() as u64).expect("the parameters are good")
}

/// A job that keeps light groups apart, and its pilot's estimate.
struct Grouped {
    renderer: Renderer,
    start: Estimate,
    region: Region,
    never: AtomicBool,
}

impl Grouped {
    fn new(scene: &Arc<Scene>, method: &str, parameters: &str) -> Self {
        let renderer = Renderer::new(scene.clone(), &checked(scene, method, parameters), 1);
        let renderer = renderer.and_then(Renderer::with_light_groups).expect("groups can be kept apart");
        let never = AtomicBool::new(false);
        let pilot = renderer.pilot(&never).expect("nobody cancels");
        let renderer = renderer.guided(&pilot.guides()).expect("the pilot fits the lights");
        let region = Region { row_start: 0, row_end: scene.height };
        let declaration = renderer.declaration().clone();
        let start = Estimate::new(scene.width, scene.height, &[region], declaration, pilot.radius_squared());
        Self { renderer, start: start.expect("the pilot fits"), region, never }
    }

    fn tally(&self, first_pass: u32) -> Tally {
        let shard = Shard { first_pass, passes: 1, region: self.region };
        let field = self.start.radius_field(self.region);
        self.renderer.trace(shard, &field, &self.never).expect("nobody cancels")
    }

    /// The estimate of so many passes from `first_pass` on, all with the first radii.
    fn passes(&self, first_pass: u32, passes: u32) -> Estimate {
        let (mut estimate, field) = (self.start.clone(), self.start.radius_field(self.region));
        for pass in 0..passes {
            let mut tally = self.tally(first_pass + pass);
            tally.shard.first_pass = pass;
            estimate.merge(&tally, &field).expect("tallies come in order");
        }
        estimate
    }
}

fn mean(picture: &Picture) -> f64 {
    picture.radiance.iter().flatten().map(|value| f64::from(*value)).sum::<f64>() / (3 * picture.radiance.len()) as f64
}

fn statistics(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let average = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - average).powi(2)).sum::<f64>() / (count - 1.0);
    (average, (variance / count).sqrt())
}

#[test]
fn each_group_is_the_picture_of_its_lights_alone() {
    let whole = scene(&GROUPS);
    for (method, parameters) in METHODS {
        let job = Grouped::new(&whole, method, parameters);
        let (batches, passes) = (16, 4);
        let estimates: Vec<Estimate> = (0..batches).map(|batch| job.passes(batch * passes, passes)).collect();
        for group in GROUPS {
            let means: Vec<f64> = estimates.iter().map(|batch| mean(&batch.light_group_picture(group))).collect();
            let (found, error) = statistics(&means);
            let (expected, truth_error) = mean_and_error(&scene(&[group]), method, parameters, batches, passes);
            let allowed = ERRORS * error.hypot(truth_error);
            println!("{method} {parameters} {group}: {found:.5} ± {error:.5} of {expected:.5} ± {truth_error:.5}");
            assert!(
                (found - expected).abs() < allowed,
                "{method} {parameters} {group}: {found}, {expected} ± {allowed}"
            );
            assert!(allowed < 0.15 * expected, "{method} {group}: the test is blind");
        }
    }
}

#[test]
fn groups_add_up_to_the_picture_and_that_is_as_without_groups() {
    let whole = scene(&GROUPS);
    for (method, parameters) in METHODS {
        let job = Grouped::new(&whole, method, parameters);
        let (batches, passes) = (16, 4);
        let estimates: Vec<Estimate> = (0..batches).map(|batch| job.passes(batch * passes, passes)).collect();
        let (picture, groups) = (estimates[0].picture(), GROUPS.map(|group| estimates[0].light_group_picture(group)));
        for (pixel, color) in picture.radiance.iter().enumerate() {
            let sum = [0, 1, 2].map(|channel| groups.iter().map(|group| group.radiance[pixel][channel]).sum::<f32>());
            for (sum, whole) in sum.iter().zip(color) {
                assert!((sum - whole).abs() <= 1e-6 * whole.abs(), "{method}: {sum} of {whole} in pixel {pixel}");
            }
        }
        let (found, error) = statistics(&estimates.iter().map(|batch| mean(&batch.picture())).collect::<Vec<_>>());
        let (expected, plain_error) = mean_and_error(&whole, method, parameters, batches, passes);
        // The nearest photons of one group are farther away than those of all, and weights of what is merged are others.
        let bias = if ["photon_map", "vcm"].contains(&method) { 0.02 * expected } else { 0.0 };
        let allowed = ERRORS * error.hypot(plain_error) + bias;
        println!("{method} {parameters}: {found:.5} ± {error:.5} of {expected:.5} ± {plain_error:.5}");
        assert!((found - expected).abs() < allowed, "{method} {parameters}: {found}, {expected} ± {allowed}");
        // Photons of all groups are counted; chains emit as many as they happen to.
        if method == "mmlt" {
            continue;
        }
        let plain = Job::new(&whole, method, parameters).run(passes, 16);
        assert_eq!(estimates[0].photons_emitted(), GROUPS.len() as u64 * plain.photons_emitted(), "{method}");
    }
}

#[test]
fn threads_do_not_change_groups() {
    let whole = scene(&GROUPS);
    for (method, parameters) in METHODS {
        let [one, three] = [1, 3].map(|threads| {
            let pool = ThreadPoolBuilder::new().num_threads(threads).build().expect("threads");
            pool.install(|| Grouped::new(&whole, method, parameters).tally(3))
        });
        let bits = |tally: &Tally| tally.planes.iter().flatten().map(|value| value.to_bits()).collect::<Vec<_>>();
        assert!(bits(&one) == bits(&three), "{method} {parameters}");
        assert_eq!(one.scalars, three.scalars, "{method} {parameters}");
    }
}

/// Where there is one group, it is the picture of a job without groups, to the bit.
#[test]
fn a_single_group_has_the_bits_of_the_picture() {
    let lamp = scene(&["lamp"]);
    for (method, parameters) in METHODS {
        let found = Grouped::new(&lamp, method, parameters);
        let plain = Job::new(&lamp, method, parameters);
        let expected = plain.begin();
        let shard = Shard { first_pass: 5, passes: 2, region: plain.region() };
        let field = expected.estimate.radius_field(plain.region());
        let expected = expected.renderer.trace(shard, &field, &plain.never).expect("nobody cancels");
        let found = found.renderer.trace(shard, &field, &found.never).expect("nobody cancels");
        assert!(found.planes == expected.planes && found.scalars == expected.scalars, "{method} {parameters}");
        let names: Vec<&str> = found.declaration.planes.iter().map(|plane| plane.name.as_str()).collect();
        assert_eq!(names[0], "radiance.lamp", "{method}");
    }
}

/// What is only seen belongs to its group; a group that lights nothing is black but for that.
#[test]
fn what_is_only_seen_belongs_to_its_group() {
    let sign = "<shape type='rectangle'><transform name='to_world'><scale value='0.5'/></transform>\
        <bsdf type='diffuse'><rgb name='reflectance' value='0'/></bsdf><emitter type='area'><rgb name='radiance' value='3'/>\
        <boolean name='seen_only' value='true'/><string name='light_group' value='sign'/></emitter></shape>\
        <shape type='rectangle'><transform name='to_world'><scale value='2'/><translate z='-0.5'/></transform></shape>\
        <emitter type='point'><point name='position' value='0, 0, 3'/></emitter>\
        <sensor type='perspective'><float name='fov' value='30'/><transform name='to_world'>\
        <lookat origin='0, 0, 2' target='0, 0, 0' up='0, 1, 0'/></transform><film type='hdrfilm'>\
        <integer name='width' value='16'/><integer name='height' value='16'/><rfilter type='box'/></film></sensor>";
    let scene = Arc::new(prepare(sign, &[]).expect("the scene is good"));
    for method in ["path", "sppm", "mmlt", "photon_map"] {
        let estimate = Grouped::new(&scene, method, "{}").passes(0, 2);
        let [sign, others] = ["sign", "others"].map(|group| estimate.light_group_picture(group));
        let seen: Vec<bool> = sign.radiance.iter().map(|pixel| *pixel == [3.0; 3]).collect();
        assert!(seen.iter().filter(|seen| **seen).count() > 60, "{method}");
        for (pixel, seen) in seen.iter().enumerate() {
            let [sign, others] = [&sign, &others].map(|picture| picture.radiance[pixel]);
            let is_edge = !seen && sign != [0.0; 3];
            assert!(
                is_edge || (*seen && others == [0.0; 3]) || (!seen && others[0] > 0.0),
                "{method} {sign:?} {others:?}"
            );
        }
    }
}

/// Guides that know other groups only leave this one to picks by power.
#[test]
fn guides_of_other_groups_do_no_harm() {
    let whole = scene(&GROUPS);
    let checked = checked(&whole, "sppm", r#"{"photons_per_pass": 4096}"#);
    let renderer = Renderer::new(whole, &checked, 1).and_then(Renderer::with_light_groups).expect("groups");
    let lamp_alone = Guides { emission: vec![1.0, 0.0, 0.0], visibility: vec![1.0, 1e-6, 1e-6] };
    let never = AtomicBool::new(false);
    let pilot = renderer.pilot(&never).expect("nobody cancels");
    let region = Region { row_start: 0, row_end: 12 };
    let start = Estimate::new(16, 12, &[region], renderer.declaration().clone(), pilot.radius_squared());
    let (mut estimate, renderer) = (start.expect("the pilot fits"), renderer.guided(&lamp_alone).expect("they fit"));
    let field = estimate.radius_field(region);
    let tally = renderer.trace(Shard { first_pass: 0, passes: 4, region }, &field, &never).expect("nobody cancels");
    estimate.merge(&tally, &field).expect("it fits");
    for group in GROUPS {
        assert!(mean(&estimate.light_group_picture(group)) > 0.005, "{group} is dark");
    }
}

#[test]
fn groups_that_cannot_be_kept_apart_are_refused() {
    let lamp = |index: usize| {
        format!(
            "<emitter type='point'><point name='position' value='{index}, 0, 3'/>\
             <string name='light_group' value='group-{index}'/></emitter>"
        )
    };
    let of_groups = |count: usize| {
        let lamps: String = (0..count).map(lamp).collect();
        let floor = "<shape type='rectangle'/><sensor type='perspective'><transform name='to_world'>\
            <lookat origin='0, 0, 2' target='0, 0, 0' up='0, 1, 0'/></transform></sensor>";
        Arc::new(prepare(&format!("{floor}{lamps}"), &[]).expect("the scene is good"))
    };
    let kept_apart = |scene: &Arc<Scene>, method: &str, parameters: &str| {
        let renderer =
            Renderer::new(scene.clone(), &checked(scene, method, parameters), 1).expect("it can be prepared");
        renderer.with_light_groups().map(|_| ()).map_err(|error| error.to_string())
    };
    assert_eq!(kept_apart(&of_groups(16), "path", "{}"), Ok(()));
    let error = kept_apart(&of_groups(17), "path", "{}").expect_err("too many");
    assert_eq!(error, "light groups cannot be kept apart: the scene has 17; give its lights at most 16");
    let hint = r#"{"user_paths": [{"points": [[0, 0, 3], [0, 0, 0]]}]}"#;
    let error = kept_apart(&of_groups(2), "mlt", hint).expect_err("only one group has that lamp");
    assert!(error.ends_with("leave user_paths or light_groups out"), "{error}");
}
