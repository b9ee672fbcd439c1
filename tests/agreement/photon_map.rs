//! `photon_map`: its building blocks against their definitions, and the whole against closed forms, other estimates of the
//! same light and converged pictures.

use std::f64::consts::PI;
use std::sync::Arc;

use crate::progressive::{Job, reference_folder, reference_scene};
use crate::scene_text::prepare;
use photonfarm::estimate::{Estimate, Picture, PixelTally, RadiusField, Region, Shard, picture_files};
use photonfarm::evaluation::{Metrics, compare};
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::math::{Rgb, Vec3, octahedral, warp};
use photonfarm::method::{MethodChoice, check};
use photonfarm::scene::Scene;
use photonfarm::transport::kernel::Kernel;
use photonfarm::transport::photon_map::{GatherQuery, Grid, Nearest, Photon, PhotonChunk, PhotonLookup, PhotonMap};

const KERNELS: [Kernel; 3] = [Kernel::Disc, Kernel::Cone, Kernel::Epanechnikov];

#[test]
fn analytic_kernels_have_mean_one_over_the_disc() {
    const STEPS: u32 = 100_000;
    for kernel in KERNELS {
        // Uniform on the disc is uniform in t².
        let value = |step: u32| f64::from(kernel.weight((step as f32 + 0.5) / STEPS as f32));
        let mean = (0..STEPS).map(value).sum::<f64>() / f64::from(STEPS);
        assert!((mean - 1.0).abs() < 1e-5, "{kernel:?} has mean {mean}");
        assert!((0..STEPS).all(|step| value(step) >= 0.0), "{kernel:?} is negative somewhere");
    }
}

fn uniform(family: u32, index: u32, block: u32) -> [f32; 4] {
    PathRandom::new(3, Stream::Photon, family, index).block(block)
}

/// Photons on the floor of the unit cube, denser in one corner, and some in the air.
fn cloud(family: u32, count: u32) -> Vec<Photon> {
    let photon = |index: u32| {
        let (place, other) = (uniform(family, index, 0), uniform(family, index, 1));
        let height = if index.is_multiple_of(5) { place[2] } else { 0.0 };
        let squeeze = if index.is_multiple_of(3) { 0.05 } else { 1.0 };
        let position = Vec3::new(place[0] * squeeze, height, place[1] * squeeze);
        let normal = if index.is_multiple_of(7) { warp::sphere([other[0], other[1]]) } else { Vec3::Y };
        Photon::new(position, octahedral::encode(normal), normal, Rgb::ONE, 1 + index % 9, index.is_multiple_of(2))
    };
    (0..count).map(photon).collect()
}

fn build(photons: &[Photon], cell: f32) -> PhotonMap {
    let grid = Grid::new(Vec3::ZERO, Vec3::ONE, cell, 1 << 20);
    let chunks: Vec<PhotonChunk> = photons.chunks(777).map(|chunk| PhotonChunk::sort(chunk, &grid)).collect();
    PhotonMap::build(&chunks, grid)
}

/// The squared distance of a photon that counts, from the definition: in space, or off the tangent plane over a quarter.
fn distance_squared(photon: &Photon, query: &GatherQuery) -> Option<f32> {
    let offset = Vec3::from_array(photon.position) - query.position;
    let byte = |shift: u32| f32::from((photon.normal_and_segments >> shift) as u8 as i8) / 127.0;
    let cosine = Vec3::new(byte(0), byte(8), byte(16)).dot(query.normal);
    let cosine = if query.both_sides { cosine.abs() } else { cosine };
    let distance = offset.length().max(4.0 * offset.dot(query.normal).abs());
    let counts = cosine > 0.7
        && photon.segments() <= query.most_segments
        && !(query.caustics_only && photon.is_scattered())
        && distance * distance < query.radius_squared;
    counts.then_some(distance * distance)
}

#[test]
fn agreement_nearest_photons_equal_a_full_search() {
    let photons = cloud(1, 20_000);
    let mut found = Nearest::default();
    let (mut full, mut short) = (0, 0);
    for cell in [0.004, 0.05, 0.4, 3.0] {
        let map = build(&photons, cell);
        for index in 0..400 {
            let (place, other) = (uniform(2, index, 0), uniform(2, index, 1));
            let query = GatherQuery {
                position: Vec3::new(place[0], if index % 4 == 0 { place[2] } else { 0.0 }, place[1])
                    * if index % 2 == 0 { 0.06 } else { 1.0 },
                normal: if index % 6 == 0 { -Vec3::Y } else { Vec3::Y },
                radius_squared: [1e-5, 1e-3, 0.01, 0.2, 10.0][index as usize % 5],
                most_segments: if index % 3 == 0 { 4 } else { 127 },
                caustics_only: index % 7 == 0,
                both_sides: index % 12 == 0,
            };
            let count = 2 + (other[0] * 100.0) as usize;
            map.nearest(&query, count, &mut found);
            let mut distances: Vec<f32> =
                photons.iter().filter_map(|photon| distance_squared(photon, &query)).collect();
            distances.sort_by(f32::total_cmp);
            let radius_squared = distances.get(count - 1).copied().unwrap_or(query.radius_squared);
            let expected = distances.len().min(count - 1);
            assert_eq!(found.photons().len(), expected, "cells of {cell}: {query:?}");
            assert!((found.radius_squared() / radius_squared - 1.0).abs() < 1e-4, "cells of {cell}: {query:?}");
            let mut seen: Vec<f32> = found.photons().map(|(distance, _)| distance).collect();
            seen.sort_by(f32::total_cmp);
            for ((seen, expected), (distance, photon)) in seen.iter().zip(&distances).zip(found.photons()) {
                assert!((seen - expected).abs() <= 1e-4 * expected + 1e-12);
                let own = distance_squared(&map.photon(photon), &query).expect("a photon that counts");
                assert!((own - distance).abs() <= 1e-4 * own + 1e-12);
            }
            if expected == count - 1 { full += 1 } else { short += 1 }
        }
    }
    assert!(full > 300 && short > 300, "{full} full and {short} short: the test is one-sided");
}

/// Means over many maps: k - 1 photons over the disc of the k-th estimate a uniform density without bias, also where the
/// largest radius often cuts the search short.
#[test]
fn analytic_nearest_photons_measure_a_uniform_density() {
    const MAPS: u32 = 4000;
    const DENSITY: f64 = 400.0;
    // The fifth photon is at 0.06 on average.
    const SEARCHES: [(usize, f32); 5] = [(2, 0.3), (5, 0.4), (5, 0.06), (5, 0.04), (20, 0.4)];
    let mut found = Nearest::default();
    let mut sums = [[[0.0; 2]; 3]; 5];
    for family in 0..MAPS {
        let photon = |index: u32| {
            let [x, z, ..] = uniform(10 + family, index, 0);
            Photon::new(Vec3::new(x, 0.0, z), 0, Vec3::Y, Rgb::ONE, 1, false)
        };
        let photons: Vec<Photon> = (0..DENSITY as u32).map(photon).collect();
        let map = build(&photons, 0.2);
        for ((count, radius), sums) in SEARCHES.iter().zip(&mut sums) {
            let query = GatherQuery {
                position: Vec3::new(0.5, 0.0, 0.5),
                normal: Vec3::Y,
                radius_squared: radius * radius,
                most_segments: 127,
                caustics_only: false,
                both_sides: false,
            };
            map.nearest(&query, *count, &mut found);
            let inverse = 1.0 / found.radius_squared();
            for (kernel, sums) in KERNELS.iter().zip(sums) {
                let weight: f32 = found.photons().map(|(distance, _)| kernel.weight(distance * inverse)).sum();
                let density = f64::from(weight * inverse) / PI;
                sums[0] += density;
                sums[1] += density * density;
            }
        }
    }
    for (search, sums) in SEARCHES.iter().zip(sums) {
        for (kernel, [sum, squares]) in KERNELS.iter().zip(sums) {
            let mean = sum / f64::from(MAPS);
            let error = ((squares / f64::from(MAPS) - mean * mean) / f64::from(MAPS)).sqrt();
            assert!((mean - DENSITY).abs() < 4.0 * error, "{kernel:?}, {search:?}: {mean} ± {error}");
            // Two neighbours leave one photon: its inverse area has no variance to speak of.
            assert!(search.0 == 2 || error < 0.02 * DENSITY, "{kernel:?}, {search:?}: the test is blind");
        }
    }
}

/// A matte sphere of albedo ρ, seen from inside, with a point light of intensity I in its middle: direct light has radiance
/// ρI/(πR²) everywhere, and every further bounce ρ times the one before.
#[test]
fn analytic_bounces_in_a_sphere() {
    const ALBEDO: f64 = 0.6;
    const INTENSITY: f64 = 5.0;
    const RADIUS: f64 = 2.0;
    let scene = prepare(
        "<sensor type='perspective'><float name='fov' value='80'/><transform name='to_world'>\
        <lookat origin='0, 0, 0.5' target='0, 0.2, -1' up='0, 1, 0'/></transform><film type='hdrfilm'>\
        <integer name='width' value='32'/><integer name='height' value='32'/><rfilter type='box'/></film></sensor>\
        <shape type='sphere'><float name='radius' value='2'/><boolean name='flip_normals' value='true'/>\
        <bsdf type='diffuse'><rgb name='reflectance' value='0.6, 0.6, 0.6'/></bsdf></shape>\
        <emitter type='point'><rgb name='intensity' value='5, 5, 5'/></emitter>",
        &[],
    );
    let scene = Arc::new(scene.expect("the scene is good"));
    let direct = ALBEDO * INTENSITY / (PI * RADIUS * RADIUS);
    for (max_depth, bounces) in
        [(1, 0.0), (2, 1.0), (3, 1.0 + ALBEDO), (4, 1.0 + ALBEDO + ALBEDO * ALBEDO), (-1, 1.0 / (1.0 - ALBEDO))]
    {
        for rays in [0, 4] {
            let parameters =
                format!(r#"{{"photons_per_pass": 50000, "max_depth": {max_depth}, "final_gather": {rays}}}"#);
            let mean = mean(&Job::new(&scene, "photon_map", &parameters).run(12, 8));
            let expected = direct * bounces;
            // Noise and the bias of the nearest photons together were up to 0.5 %.
            let bound = 0.0075 * expected;
            assert!((mean - expected).abs() <= bound, "{max_depth} segments, {rays} rays: {mean} is not {expected}");
        }
    }
}

/// Mean of the channels over all pixels.
fn mean(estimate: &Estimate) -> f64 {
    let picture = estimate.picture();
    picture.radiance.iter().flatten().map(|value| f64::from(*value)).sum::<f64>() / (3 * picture.radiance.len()) as f64
}

fn metrics(name: &str, scene: &Scene, estimate: &Estimate) -> Metrics {
    let expected = if name.starts_with("furnace") {
        Picture { width: scene.width, height: scene.height, radiance: vec![[1.0; 3]; scene.pixel_count()] }
    } else {
        picture_files::read_exr(&reference_folder(name).join("ref.exr")).expect("a reference can be read")
    };
    compare(&estimate.picture(), &expected, None).expect("the sizes agree")
}

/// The bound on relMSE is 1.5 times what was measured.
fn check_reference(name: &str, parameters: &str, passes: u32, bias_bound: f64, relmse_bound: f64) {
    let scene = reference_scene(name);
    let estimate = Job::new(&scene, "photon_map", parameters).run(passes, 8);
    let found = metrics(name, &scene, &estimate);
    assert_eq!(estimate.non_finite(), 0);
    assert!(found.bias.abs() < bias_bound, "{name}: mean off by {:.2} %", 100.0 * found.bias);
    assert!(found.relmse < relmse_bound, "{name}: relMSE {}", found.relmse);
}

#[test]
fn agreement_photon_map_in_furnaces() {
    check_reference("furnace-closed", "{}", 8, 0.01, 0.0075);
    check_reference("furnace-env", "{}", 8, 0.005, 0.005);
    check_reference("furnace-specular", "{}", 8, 0.01, 0.0075);
}

/// Both structures find the same photons, whose sums differ by rounding alone.
#[test]
fn agreement_photon_map_in_a_grid_and_in_a_kd_tree() {
    let scene = reference_scene("cornell-glass");
    let picture = |structure: &str| {
        let parameters = format!(r#"{{"structure": "{structure}", "photons_per_pass": 20000}}"#);
        Job::new(&scene, "photon_map", &parameters).run(1, 8).picture().radiance
    };
    let [grid, tree] = [picture("grid"), picture("kdtree")];
    for (pixel, (grid, tree)) in grid.iter().zip(&tree).enumerate() {
        for channel in 0..3 {
            let difference = (grid[channel] - tree[channel]).abs();
            assert!(difference <= 1e-4 * grid[channel], "pixel {pixel}: {grid:?} in a grid, {tree:?} in a tree");
        }
    }
}

#[test]
fn agreement_photon_map_cornell_diffuse() {
    check_reference("cornell-diffuse", "{}", 12, 0.01, 0.075);
}

#[test]
fn agreement_photon_map_cornell_glass() {
    check_reference("cornell-glass", "{}", 12, 0.01, 0.055);
}

#[test]
fn agreement_photon_map_lantern() {
    check_reference("lantern", "{}", 12, 0.01, 0.019);
}

#[test]
fn agreement_photon_map_spot_mirror() {
    // The sharp rim of a caustic: a disc blurs it, and reaches further in the dark than in the light.
    check_reference("spot-mirror", "{}", 16, 0.01, 0.52);
}

#[test]
fn agreement_photon_map_glossy_blocks() {
    check_reference("glossy-blocks-a010", "{}", 12, 0.01, 0.15);
}

/// Looking at the global map directly finds the same light, with more bias.
#[test]
fn agreement_photon_map_without_final_gather() {
    check_reference("furnace-specular", r#"{"final_gather": 0}"#, 8, 0.01, 0.0075);
    check_reference("cornell-glass", r#"{"final_gather": 0}"#, 12, 0.01, 0.055);
}

/// Limits on the length of paths cut all parts at the same place.
#[test]
fn agreement_photon_map_with_sppm_on_short_paths() {
    let scene = reference_scene("cornell-glass");
    for depth in [3, 5] {
        let run = |method: &str| {
            let parameters = format!(r#"{{"max_depth": {depth}, "photons_per_pass": 32768}}"#);
            mean(&Job::new(&scene, method, &parameters).run(8, 8))
        };
        let ratio = run("photon_map") / run("sppm");
        // Both take direct light with the same random numbers, hence so little noise.
        assert!((ratio - 1.0).abs() < 0.003, "{depth} segments: {ratio}");
    }
}

fn bits(pixels: &[PixelTally]) -> Vec<u32> {
    bytemuck::cast_slice(pixels).to_vec()
}

#[test]
fn agreement_photon_map_of_threads_and_regions() {
    let scene = reference_scene("cornell-glass");
    let job = Job::new(&scene, "photon_map", r#"{"photons_per_pass": 16384}"#);
    let field = job.begin().estimate.radius_field(job.region());
    let trace = |region: Region, threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build().expect("a pool");
        let radius_squared = vec![1.0; region.pixel_count(scene.width)];
        let field = RadiusField { radius_squared, ..field.clone() };
        let shard = Shard { first_pass: 3, passes: 2, region };
        pool.install(|| job.renderer.trace(shard, &field, &job.never)).expect("nobody cancels")
    };
    let whole = trace(job.region(), 1);
    assert!(bits(&whole.pixels()) == bits(&trace(job.region(), 2).pixels()), "threads change the picture");
    let band = Region { row_start: 32, row_end: 64 };
    let pixels = 32 * scene.width as usize..64 * scene.width as usize;
    assert!(bits(&whole.pixels()[pixels]) == bits(&trace(band, 2).pixels()), "regions change the picture");
    let radiance_only = |pixel: &PixelTally| pixel.flux == [0.0; 3] && pixel.photons == 0.0;
    assert!(whole.pixels().iter().all(radiance_only));
}

#[test]
fn photon_map_parameters_that_cannot_be() {
    let refused = [
        (r#"{"neighbors": 1}"#, "\"neighbors\" is 1; allowed: 2 to 65536"),
        (r#"{"caustic_neighbors": 70000}"#, "\"caustic_neighbors\" is 70000; allowed: 2 to 65536"),
        (r#"{"largest_radius": 0}"#, "\"largest_radius\" is 0; allowed: 1e-18 to 1e18, auto"),
        (r#"{"kernel": "gauss"}"#, "\"kernel\" is \"gauss\"; allowed: disc, cone, epanechnikov"),
        (r#"{"final_gather": 1025}"#, "\"final_gather\" is 1025; allowed: 0 to 1024"),
        (r#"{"final_gather": -1}"#, "\"final_gather\" is -1; allowed: 0 to 1024"),
        (r#"{"neighbours": 20}"#, "there is no parameter \"neighbours\"; did you mean \"neighbors\"?"),
        (r#"{"alpha": 0.5}"#, "there is no parameter \"alpha\""),
    ];
    for (parameters, expected) in refused {
        let parameters = serde_json::from_str(parameters).expect("an object");
        let choice = MethodChoice { name: "photon_map".to_owned(), parameters };
        let message = check(&choice, 100).expect_err("refused").to_string();
        assert!(message.starts_with(&format!("method \"photon_map\": {expected}")), "{message}");
    }
    let choice = MethodChoice { name: "photon_map".to_owned(), parameters: serde_json::Map::new() };
    let checked = check(&choice, 100_000).expect("defaults are good");
    assert_eq!(checked.photons_per_pass, 100_000);
    assert_eq!(check(&checked.choice, 5), Ok(checked), "a written-out choice means the same for another size");
}
