//! Irradiance caching: records and gradients against closed forms, the octree against a full search, and pictures of
//! `photon_map` with a cache against those without.

use std::f64::consts::PI;

use crate::progressive::{Job, reference_folder, reference_scene};
use photonfarm::estimate::{Estimate, PixelTally, RadiusField, Region, Shard, picture_files};
use photonfarm::evaluation::{Metrics, compare};
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::math::{Frame, Rgb, Vec3, warp};
use photonfarm::scene::Scene;
use photonfarm::transport::irradiance::{
    Arrival, HemisphereCells, IrradianceCache, IrradianceQuery, IrradianceRecord, RadiusRange, TangentGradient,
};

const RANGE: RadiusRange = RadiusRange { smallest: 1e-3, largest: 10.0 };

fn uniform(family: u32, index: u32, block: u32) -> [f32; 4] {
    PathRandom::new(11, Stream::Camera, family, index).block(block)
}

/// A record of what `arrive` says comes along rays from `position`.
fn record(
    position: Vec3,
    normal: Vec3,
    cells: HemisphereCells,
    index: u32,
    arrive: impl Fn(Vec3, u32) -> Arrival,
) -> IrradianceRecord {
    let frame = Frame::from_normal(normal);
    let arrival = |cell: u32| {
        let [x, y, ..] = uniform(index, cell, 0);
        arrive(frame.to_world(cells.direction(cell, [x, y])), cell)
    };
    let mut arrivals: Vec<Arrival> = (0..cells.count()).map(arrival).collect();
    IrradianceRecord::new(position, frame, 0, cells, &mut arrivals, RANGE)
}

fn query(position: Vec3, normal: Vec3) -> IrradianceQuery {
    IrradianceQuery { position, normal, group: 0 }
}

/// A bright rectangle at height 1 over a plane through the origin: its corners along x and y, and its radiance.
const X: [f32; 2] = [0.2, 1.3];
const Y: [f32; 2] = [-0.5, 0.9];
const RADIANCE: Rgb = Rgb::new(1.0, 3.0, 0.5);

fn rectangle(origin: Vec3, direction: Vec3) -> Arrival {
    let distance = (1.0 - origin.z) / direction.z;
    let at = origin + direction * distance;
    let hits = direction.z > 0.0 && X[0] < at.x && at.x < X[1] && Y[0] < at.y && at.y < Y[1];
    if hits { Arrival { radiance: RADIANCE, distance } } else { Arrival::NOTHING }
}

/// Irradiance by the rectangle at radiance 1: Lambert's formula, Σ Γᵢ·(n·γᵢ)/2 over its edges, which see an angle Γᵢ.
fn lambert(position: [f64; 3], normal: [f64; 3]) -> f64 {
    let cross =
        |a: [f64; 3], b: [f64; 3]| [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]];
    let dot = |a: [f64; 3], b: [f64; 3]| a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
    let corner = |x: usize, y: usize| [f64::from(X[x]) - position[0], f64::from(Y[y]) - position[1], 1.0 - position[2]];
    let corners = [corner(0, 0), corner(1, 0), corner(1, 1), corner(0, 1)];
    let edge = |first: usize| {
        let (from, to) = (corners[first], corners[(first + 1) % 4]);
        let across = cross(from, to);
        let length = dot(across, across).sqrt();
        libm::atan2(length, dot(from, to)) * dot(normal, across) / length
    };
    0.5 * (0..4).map(edge).sum::<f64>().abs()
}

/// Means over many records against differences of the closed form.
#[test]
fn analytic_gradients_below_a_bright_rectangle() {
    const RECORDS: u32 = 300;
    const STEP: f64 = 1e-4;
    let zenith = [0.0, 0.0, 1.0];
    let truth = lambert([0.0; 3], zenith);
    let moved = |axis: usize| {
        let at = |step: f64| lambert(std::array::from_fn(|other| if other == axis { step } else { 0.0 }), zenith);
        (at(STEP) - at(-STEP)) / (2.0 * STEP)
    };
    // Turned about an axis, the normal goes along axis × normal.
    let turned = |axis: usize| {
        let at = |step: f64| {
            let normal = if axis == 0 { [0.0, -step, 1.0] } else { [step, 0.0, 1.0] };
            lambert([0.0; 3], normal)
        };
        (at(STEP) - at(-STEP)) / (2.0 * STEP)
    };
    // Borders are known to a cell only, which makes gradients up to 0.10 and 0.022 of E wrong here.
    for (rays, bound) in [(256, 0.13), (4096, 0.03)] {
        let cells = HemisphereCells::new(rays);
        let (mut irradiance, mut gradients) = (0.0, [0.0; 4]);
        for index in 0..RECORDS {
            let record = record(Vec3::ZERO, Vec3::Z, cells, index, |direction, _| rectangle(Vec3::ZERO, direction));
            let share = f64::from(RECORDS).recip();
            irradiance += f64::from(record.irradiance.x) * share;
            let along = |gradient: &TangentGradient, axis: Vec3| gradient.along(&record.frame, axis);
            let found = [
                along(&record.translation, Vec3::X),
                along(&record.translation, Vec3::Y),
                along(&record.rotation, Vec3::X),
                along(&record.rotation, Vec3::Y),
            ];
            for (sum, found) in gradients.iter_mut().zip(found) {
                *sum += f64::from(found.x) * share;
                let close = (found - found.x * RADIANCE).abs().max_element() < 1e-4 * (1.0 + found.y.abs());
                assert!(close, "channels differ by more than radiance: {found}");
            }
        }
        assert!((irradiance / truth - 1.0).abs() < 0.005, "{rays} rays: {irradiance} is not {truth}");
        let expected = [moved(0), moved(1), turned(0), turned(1)];
        println!("{rays} rays: {gradients:.4?}, expected {expected:.4?}, E {truth:.4}");
        for (found, expected) in gradients.iter().zip(expected) {
            assert!((found - expected).abs() < bound * truth, "{rays} rays: {gradients:?} is not {expected:?}");
        }
    }
}

/// What a record says of places around is closer to the truth than its own irradiance.
#[test]
fn analytic_extrapolation_below_a_bright_rectangle() {
    let cells = HemisphereCells::new(4096);
    let (mut with, mut without) = (0.0, 0.0);
    for index in 0..50 {
        let record = record(Vec3::ZERO, Vec3::Z, cells, index, |direction, _| rectangle(Vec3::ZERO, direction));
        let [x, y, u, v] = uniform(900, index, 0).map(|number| 2.0 * number - 1.0);
        let (position, normal) = (0.1 * Vec3::new(x, y, 0.0), Vec3::new(0.1 * u, 0.1 * v, 1.0).normalize());
        let truth = lambert(position.to_array().map(f64::from), normal.to_array().map(f64::from));
        let error = |found: Rgb| (f64::from(found.x) / truth - 1.0).powi(2);
        with += error(record.extrapolated(&query(position, normal)));
        without += error(record.irradiance);
    }
    assert!(with < 0.05 * without, "squared errors: {with} with gradients, {without} without");
}

/// Irradiance is π everywhere, whatever lies how far away: on a sphere, with records of few rays.
#[test]
fn furnace_interpolation_is_exact_in_an_even_field() {
    let mut cache = IrradianceCache::new(-Vec3::ONE, Vec3::ONE, 0.4);
    let place = |family: u32, index: u32| {
        let [x, y, ..] = uniform(family, index, 0);
        warp::sphere([x, y])
    };
    for index in 0..200 {
        let normal = place(901, index);
        let even = |_, cell: u32| Arrival { radiance: Rgb::ONE, distance: 0.2 + uniform(902, index, cell)[0] };
        cache.insert(record(normal, normal, HemisphereCells::new(16), index, even));
    }
    let mut seen = 0;
    for index in 0..1000 {
        let normal = place(903, index);
        if let Some(found) = cache.irradiance(&query(normal, normal)) {
            seen += 1;
            assert!((found.as_dvec3() / PI - 1.0).abs().max_element() < 1e-5, "{found}");
        }
    }
    assert!(seen > 500, "only {seen} places were covered");
}

/// Records of all sizes, some outside of the cube that the cache was made for.
#[test]
fn agreement_octree_of_records_equals_a_full_search() {
    let mut compared = 0;
    for error in [0.05, 0.2, 0.7] {
        let mut cache = IrradianceCache::new(Vec3::ZERO, Vec3::ONE, error);
        let plane = |family: u32, index: u32| {
            let [x, y, z, w] = uniform(family, index, 1);
            let normal = if w < 0.5 { Vec3::Z } else { Vec3::new(0.2, 0.0, 1.0).normalize() };
            (Vec3::new(1.2 * x - 0.1, 1.2 * y - 0.1, if z < 0.5 { 0.0 } else { 0.5 }), normal)
        };
        for index in 0..3000 {
            let (position, normal) = plane(904, index);
            let [size, ..] = uniform(905, index, 0);
            let distance = 10.0_f32.powf(-2.5 + 2.0 * size);
            let hemisphere = |_, cell: u32| {
                let [red, green, blue, _] = uniform(906, index, cell);
                Arrival { radiance: Rgb::new(red, green, blue), distance }
            };
            let record = record(position, normal, HemisphereCells::new(16), index, hemisphere);
            cache.insert(IrradianceRecord { group: index % 2, ..record });
        }
        for index in 0..1000 {
            let (position, normal) = plane(907, index);
            let query = IrradianceQuery { position, normal, group: index % 2 };
            let (mut sum, mut weights) = (Rgb::ZERO, 0.0);
            for record in cache.records() {
                if let Some(weight) = record.weight(&query, error) {
                    sum += record.extrapolated(&query) * weight;
                    weights += weight;
                }
            }
            let expected = (weights > 0.0).then(|| (sum / weights).max(Rgb::ZERO));
            match (cache.irradiance(&query), expected) {
                (None, None) => {}
                (Some(found), Some(expected)) => {
                    compared += 1;
                    assert!((found - expected).abs().max_element() < 1e-3, "{query:?}: {found}, not {expected}");
                }
                (found, expected) => panic!("{query:?}: {found:?}, not {expected:?}"),
            }
        }
    }
    assert!(compared > 1000, "only {compared} places were covered");
}

/// What a record on a table sees, the floor below does not; what a record on the floor sees may be taken for the table.
#[test]
fn records_in_front_of_a_place_do_not_count() {
    let mut cache = IrradianceCache::new(-Vec3::ONE, Vec3::ONE, 0.5);
    let far = |_, _| Arrival { radiance: Rgb::ONE, distance: 1.0 };
    cache.insert(record(Vec3::ZERO, Vec3::Z, HemisphereCells::new(64), 0, far));
    let at = |position: Vec3, normal: Vec3| cache.irradiance(&query(position, normal)).is_some();
    assert!(at(Vec3::new(0.3, 0.0, 0.0), Vec3::Z) && at(Vec3::new(0.3, 0.0, 0.1), Vec3::Z));
    assert!(!at(Vec3::new(0.3, 0.0, -0.1), Vec3::Z), "it lies behind");
    assert!(!at(Vec3::new(0.6, 0.0, 0.0), Vec3::Z), "it is too far off");
    assert!(!at(Vec3::ZERO, Vec3::new(0.0, 1.0, 1.0).normalize()), "it is turned too far");
    assert!(!at(Vec3::ZERO, -Vec3::Z), "it is the other side");
}

fn render(scene: &std::sync::Arc<Scene>, parameters: &str, passes: u32) -> Estimate {
    Job::new(scene, "photon_map", parameters).run(passes, 8)
}

fn metrics(name: &str, estimate: &Estimate) -> Metrics {
    let expected = picture_files::read_exr(&reference_folder(name).join("ref.exr")).expect("a reference can be read");
    compare(&estimate.picture(), &expected, None).expect("the sizes agree")
}

/// A closed box of matte walls with blocks: the cache adds at most half a percent to the bias of the mean, and leaves less noise
/// than four gather rays.
#[test]
fn agreement_cached_irradiance_in_a_matte_box() {
    let scene = reference_scene("cornell-diffuse");
    let plain = render(&scene, "{}", 8);
    let cached = render(&scene, r#"{"cache_error": 0.2}"#, 8);
    assert_eq!(cached.non_finite(), 0);
    let to_plain = compare(&cached.picture(), &plain.picture(), None).expect("the sizes agree");
    let [plain, cached] = [plain, cached].map(|estimate| metrics("cornell-diffuse", &estimate));
    println!("plain {plain:?}\ncached {cached:?}\ncached to plain {to_plain:?}");
    assert!(to_plain.bias.abs() < 0.005, "the mean changes by {:.2} %", 100.0 * to_plain.bias);
    assert!(cached.bias.abs() < 0.01, "the mean is off by {:.2} %", 100.0 * cached.bias);
    assert!(cached.relmse < plain.relmse, "relMSE {} with a cache, {} without", cached.relmse, plain.relmse);
}

/// Radiance 1 everywhere: photons are noise, records keep it within the bounds that rays have.
#[test]
fn furnace_with_cached_irradiance() {
    for name in ["furnace-closed", "furnace-env", "furnace-specular"] {
        let scene = reference_scene(name);
        let picture = render(&scene, r#"{"cache_error": 0.3, "cache_rays": 64}"#, 8).picture();
        let sum: f64 = picture.radiance.iter().flatten().map(|value| f64::from(*value)).sum();
        let mean = sum / (3 * picture.radiance.len()) as f64;
        println!("{name}: {mean}");
        assert!((mean - 1.0).abs() < 0.01, "{name}: mean {mean}");
    }
}

/// Mirrors show matte surfaces after more segments than the camera sees them directly: records are not shared between them.
#[test]
fn agreement_cached_irradiance_on_short_paths() {
    let scene = reference_scene("cornell-glass");
    let mean = |parameters: &str| {
        let picture = render(&scene, parameters, 8).picture();
        picture.radiance.iter().flatten().map(|value| f64::from(*value)).sum::<f64>()
    };
    for (depth, bound) in [(2, 0.0), (3, 0.005), (5, 0.005)] {
        let plain = mean(&format!(r#"{{"max_depth": {depth}}}"#));
        let cached = mean(&format!(r#"{{"max_depth": {depth}, "cache_error": 0.2}}"#));
        println!("{depth} segments: {:+.5}", cached / plain - 1.0);
        // Two segments are direct light, which camera paths with the same random numbers find bit by bit.
        assert!((cached / plain - 1.0).abs() <= bound, "{depth} segments: {cached} with a cache, {plain} without");
    }
}

#[test]
fn agreement_cached_irradiance_of_threads_and_regions() {
    let scene = reference_scene("cornell-glass");
    let job = Job::new(&scene, "photon_map", r#"{"photons_per_pass": 16384, "cache_error": 0.3, "cache_rays": 64}"#);
    let field = job.begin().estimate.radius_field(job.region());
    let trace = |region: Region, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let radius_squared = vec![1.0; region.pixel_count(scene.width)];
        let field = RadiusField { radius_squared, ..field.clone() };
        let shard = Shard { first_pass: 3, passes: 1, region };
        pool.install(|| job.renderer.trace(shard, &field, &job.never)).expect("nobody cancels")
    };
    let bits = |pixels: &[PixelTally]| bytemuck::cast_slice::<_, u32>(pixels).to_vec();
    let whole = trace(job.region(), 1);
    assert!(bits(&whole.pixels()) == bits(&trace(job.region(), 2).pixels()), "threads change the picture");
    // Neither begins at a pixel of the first round.
    for band in [Region { row_start: 37, row_end: 38 }, Region { row_start: 5, row_end: 61 }] {
        let [start, end] = [band.row_start, band.row_end].map(|row| row as usize * scene.width as usize);
        assert!(bits(&whole.pixels()[start..end]) == bits(&trace(band, 2).pixels()), "regions change the picture");
    }
}
