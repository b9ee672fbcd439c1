//! Filters with negative lobes: the weights themselves, the picture of an edge in closed form, and which methods take them.
//!
//! Bounds are 4.5 standard errors, passed by chance once in 10⁵ times; seeds are fixed.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::progressive::Job;
use crate::scene_text::prepare;
use photonfarm::estimate::{Region, Shard, Tally};
use photonfarm::method::{METHODS, SceneTraits, notices};
use photonfarm::render::Renderer;
use photonfarm::scene::Scene;

/// The cubic of Mitchell and Netravali for B = C = ⅓, multiplied out.
fn mitchell(x: f64) -> f64 {
    match x.abs() {
        x if x < 1.0 => (7.0 * x.powi(3) - 12.0 * x.powi(2) + 16.0 / 3.0) / 6.0,
        x if x < 2.0 => (-7.0 / 3.0 * x.powi(3) + 12.0 * x.powi(2) - 20.0 * x + 32.0 / 3.0) / 6.0,
        _ => 0.0,
    }
}

/// Catmull and Rom's spline.
fn catmullrom(x: f64) -> f64 {
    match x.abs() {
        x if x < 1.0 => 1.5 * x.powi(3) - 2.5 * x.powi(2) + 1.0,
        x if x < 2.0 => -0.5 * x.powi(3) + 2.5 * x.powi(2) - 4.0 * x + 2.0,
        _ => 0.0,
    }
}

fn lanczos(x: f64, lobes: f64) -> f64 {
    match PI * x.abs() {
        0.0 => 1.0,
        angle if x.abs() < lobes => lobes * angle.sin() * (angle / lobes).sin() / (angle * angle),
        _ => 0.0,
    }
}

/// A filter in the scene's language, its weight, and its radius, pixels.
type Case = (&'static str, fn(f64) -> f64, f64);

const CASES: [Case; 5] = [
    ("<rfilter type='mitchell'/>", mitchell, 2.0),
    ("<rfilter type='mitchell'><float name='B' value='0'/><float name='C' value='0.5'/></rfilter>", catmullrom, 2.0),
    ("<rfilter type='catmullrom'/>", catmullrom, 2.0),
    ("<rfilter type='lanczos'/>", |x| lanczos(x, 3.0), 3.0),
    ("<rfilter type='lanczos'><integer name='lobes' value='2'/></rfilter>", |x| lanczos(x, 2.0), 2.0),
];

/// Midpoint rule from `from` to `to`.
fn integral(from: f64, to: f64, f: impl Fn(f64) -> f64) -> f64 {
    const STEPS: u32 = 20_000;
    let step = (to - from) / f64::from(STEPS);
    (0..STEPS).map(|index| f(from + (f64::from(index) + 0.5) * step)).sum::<f64>() * step
}

const SIDE: u32 = 12;

/// A camera that looks at the square of 2 × 2 round the origin, `body`, and a filter.
fn scene(filter: &str, body: &str) -> Arc<Scene> {
    let sensor = format!(
        "<sensor type='perspective'><float name='fov' value='90'/><transform name='to_world'><lookat origin='0, 0, 1' \
        target='0, 0, 0' up='0, 1, 0'/></transform><film type='hdrfilm'><integer name='width' value='{SIDE}'/>\
        <integer name='height' value='{SIDE}'/>{filter}</film></sensor>"
    );
    Arc::new(prepare(&format!("{sensor}{body}"), &[]).expect("the scene is good"))
}

/// Light of radiance 1 on the right of the picture, from half a pixel beyond its middle.
const HALF_LIT: &str = "<shape type='rectangle'><transform name='to_world'><scale x='4' y='9' z='1'/>\
    <translate x='4.0833333'/></transform><emitter type='area'><rgb name='radiance' value='1'/></emitter></shape>";

/// A checkered floor under a lamp behind the camera.
const CHECKERED: &str = "<shape type='rectangle'><transform name='to_world'><scale value='2'/></transform><bsdf type='diffuse'>\
    <texture type='checkerboard' name='reflectance'><transform name='to_uv'><scale x='5' y='5'/></transform></texture></bsdf>\
    </shape><shape type='rectangle'><transform name='to_world'><lookat origin='0.5, 1, 2' target='0, 0, 0' up='0, 1, 0'/>\
    </transform><emitter type='area'><rgb name='radiance' value='2'/></emitter></shape>";

#[test]
fn analytic_filters_with_negative_lobes_have_their_weights() {
    for (text, weight, radius) in CASES {
        let filter = scene(text, HALF_LIT).film.filter.clone();
        let whole = integral(-radius, radius, weight);
        for index in 0..500 {
            let x = 1.1 * radius * (f64::from(index) / 250.0 - 1.0);
            let found = f64::from(filter.weight(x as f32 + 0.5)) * whole;
            // The steepest filter changes by 0.02 within half a bin.
            assert!((found - weight(x)).abs() < 0.02, "{text} at {x}: {found} is not {}", weight(x));
        }
        // Samples that count ± give the filter's moments.
        let samples: Vec<(f64, f64)> = (0..100_000)
            .map(|index| filter.sample((index as f32 + 0.5) / 1e5))
            .map(|(place, count)| (f64::from(place) - 0.5, f64::from(count)))
            .collect();
        assert!(samples.iter().any(|(_, count)| *count < 0.0), "{text} has no negative lobes");
        for power in 0..4 {
            let found = samples.iter().map(|(x, count)| count * x.powi(power)).sum::<f64>() / 1e5;
            let expected = integral(-radius, radius, |x| weight(x) * x.powi(power)) / whole;
            assert!((found - expected).abs() < 2e-3, "{text}: moment {power} is {found}, not {expected}");
        }
    }
}

/// The picture of an edge is the filter's integral up to it: it rises above the light and falls below black.
#[test]
fn analytic_edges_ring_as_the_filter_does() {
    const PASSES: u32 = 6000;
    for (text, weight, radius) in [CASES[2], CASES[3]] {
        let scene = scene(text, HALF_LIT);
        let whole = integral(-radius, radius, weight);
        let expected: Vec<f64> = (0..SIDE)
            .map(|column| {
                let edge = (f64::from(SIDE / 2) - f64::from(column)).clamp(-radius, radius);
                integral(edge, radius, weight) / whole
            })
            .collect();
        assert!(expected.iter().any(|value| *value < -0.03) && expected.iter().any(|value| *value > 1.03));
        // No path counts more than c² with c = ∫|f|/∫f.
        let most = (integral(-radius, radius, |x| weight(x).abs()) / whole).powi(2);
        for (method, share) in [("path", 1.0), ("bdpt", 0.25), ("vcm", 0.25), ("pbdpm", 0.25), ("light_tracing", 0.25)]
        {
            let passes = (f64::from(PASSES) * share) as u32;
            let parameters = match method {
                "vcm" | "pbdpm" => r#"{"photons_per_pass": 16, "initial_radius": 0.02}"#,
                _ => "{}",
            };
            let picture = Job::new(&scene, method, parameters).run(passes, 64).picture();
            let error = most / f64::from(passes * SIDE).sqrt();
            assert!(error < 0.02, "the test is blind");
            for (column, expected) in expected.iter().enumerate() {
                let rows = picture.radiance.iter().skip(column).step_by(SIDE as usize);
                let found = rows.map(|pixel| f64::from(pixel[1])).sum::<f64>() / f64::from(SIDE);
                assert!((found - expected).abs() < 4.5 * error, "{text} {method} column {column}: {found}, {expected}");
            }
        }
    }
}

/// Reflected light, by every method that takes the filter: splats, connections and merged photons carry the sign too.
#[test]
fn analytic_methods_agree_on_a_ringing_picture() {
    let scene = scene("<rfilter type='lanczos'/>", CHECKERED);
    let pictures = |method: &str| -> Vec<Vec<[f32; 3]>> {
        let parameters = match method {
            "bdpm" | "pbdpm" | "vcm" => r#"{"photons_per_pass": 512, "initial_radius": 0.02, "max_depth": 2}"#,
            _ => r#"{"max_depth": 2}"#,
        };
        let job = Job::new(&scene, method, parameters);
        let start = job.begin().estimate;
        let field = start.radius_field(job.region());
        // Each batch is a job with a seed of its own: passes of one job are spread evenly, hence not independent.
        (0..8)
            .map(|seed| {
                let renderer = Renderer::new(job.scene.clone(), &job.method, seed).expect("the method can be prepared");
                let shard = Shard { first_pass: 0, passes: 250, region: job.region() };
                let tally = renderer.trace(shard, &field, &job.never).expect("nobody cancels");
                tally.check().expect("signs are possible");
                let mut estimate = start.clone();
                estimate.merge(&tally, &field).expect("tallies come in order");
                estimate.picture().radiance
            })
            .collect()
    };
    let moments = |batches: &[Vec<[f32; 3]>], pixel: usize| {
        let values: Vec<f64> = batches.iter().map(|picture| f64::from(picture[pixel][1])).collect();
        let mean = values.iter().sum::<f64>() / values.len() as f64;
        let squares = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>();
        (mean, squares / (values.len() * (values.len() - 1)) as f64)
    };
    let expected = pictures("path");
    let pixels = (SIDE * SIDE) as usize;
    let largest = (0..pixels).map(|pixel| moments(&expected, pixel).0).fold(0.0, f64::max);
    for method in METHODS.iter().filter(|method| method.negative_lobes && method.name != "path") {
        let found = pictures(method.name);
        // Over all pixels the squared difference is what the errors are: a lost sign is off by far more.
        let (mut squares, mut variances) = (0.0, 0.0);
        for pixel in 0..pixels {
            let (a, b) = (moments(&expected, pixel), moments(&found, pixel));
            squares += (a.0 - b.0).powi(2);
            variances += a.1 + b.1;
        }
        println!("{}: χ² {:.3}, error {:.4}", method.name, squares / variances, (variances / pixels as f64).sqrt());
        // The sum of 144 squares varies by 12 %, its bound by 4 %; discs blur the squares' edges a little.
        assert!(squares < 1.6 * variances, "{}: {squares} where errors make {variances}", method.name);
        assert!((variances / pixels as f64).sqrt() < 0.1 * largest, "{}: the test is blind", method.name);
    }
}

/// A method takes the filter, or what it makes has the bits of `gaussian`, and the user is told.
#[test]
fn analytic_methods_take_negative_lobes_as_the_table_says() {
    let [ringing, gaussian] =
        ["mitchell", "gaussian"].map(|name| scene(&format!("<rfilter type='{name}'/>"), CHECKERED));
    for method in METHODS {
        let [a, b] = [&ringing, &gaussian].map(|scene| Job::new(scene, method.name, "{}").run(2, 1).picture().radiance);
        assert_eq!(a != b, method.negative_lobes, "{}", method.name);
        let job = Job::new(&ringing, method.name, "{}");
        let told = notices(&job.method, SceneTraits::of(&ringing)).into_iter().filter(|text| text.contains("gaussian"));
        assert_eq!(told.count(), usize::from(!method.negative_lobes), "{}", method.name);
        assert!(!notices(&job.method, SceneTraits::of(&gaussian)).iter().any(|text| text.contains("gaussian")));
    }
}

#[test]
fn analytic_ringing_pictures_have_the_same_bits_on_any_threads_and_regions() {
    let scene = scene("<rfilter type='lanczos'/>", CHECKERED);
    for method in ["path", "bdpt", "light_tracing", "vcm"] {
        let job = Job::new(&scene, method, "{}");
        let field = job.begin().estimate.radius_field(job.region());
        let trace = |region: Region, threads: usize| -> Tally {
            let mut field = field.clone();
            let pixels = (region.row_start * SIDE) as usize..(region.row_end * SIDE) as usize;
            field.radius_squared = field.radius_squared.get(pixels).unwrap_or_default().to_vec();
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
            let shard = Shard { first_pass: 3, passes: 2, region };
            pool.install(|| job.renderer.trace(shard, &field, &job.never)).expect("nobody cancels")
        };
        let whole = trace(job.region(), 1);
        assert!(whole.planes == trace(job.region(), 3).planes, "{method}: threads change the picture");
        let part = trace(Region { row_start: 2, row_end: 7 }, 2);
        assert!(part.pixels() == whole.pixels()[2 * SIDE as usize..7 * SIDE as usize], "{method}: regions change it");
    }
}
