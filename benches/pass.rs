//! What a pass is made of, each part alone. `cargo bench --bench pass`; figures stand in `docs/measured/PERFORMANCE.md`.

use std::path::Path;
use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use divan::counter::{BytesCount, ItemsCount};
use divan::{Bencher, black_box};
use photonfarm::estimate::declaration::PHOTONS_EMITTED;
use photonfarm::estimate::{Declaration, Estimate, PixelTally, RadiusField, RadiusRule, Region, Shard, Tally};
use photonfarm::farm::wire::planes;
use photonfarm::import;
use photonfarm::math::Vec3;
use photonfarm::math::random::{PathRandom, Stream};
use photonfarm::method::{self, MethodChoice};
use photonfarm::render::Renderer;
use photonfarm::scene::Scene;
use photonfarm::transport::photon_map::{GatherQuery, Grid, Photon, PhotonChunk, PhotonLookup, PhotonMap};

fn main() {
    // One thread: the figures are CPU time per pass.
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build_global();
    pool.expect("the first pool of the process");
    divan::main();
}

/// The scene that the peers were measured with: a Cornell box with a large glass sphere, 512 × 512.
fn glass_box() -> Arc<Scene> {
    let description = import::load_file(Path::new("benches/scenes/cornell-large-glass.xml"), &[]).expect("own scene");
    Arc::new(Scene::prepare(&description).expect("own scene"))
}

/// 512 × 512 camera paths and 262,144 photons or light subpaths.
#[divan::bench(sample_count = 20, sample_size = 1, args = ["sppm", "ppm", "path", "bdpt", "light_tracing", "pbdpm", "vcm"])]
fn pass_of_512_by_512_pixels(bencher: Bencher<'_, '_>, method: &str) {
    let scene = glass_box();
    let choice = MethodChoice { name: method.to_owned(), parameters: serde_json::Map::new() };
    let checked = method::check(&choice, scene.pixel_count() as u64).expect("defaults");
    let renderer = Renderer::new(scene.clone(), &checked, 0).expect("defaults");
    let go_on = AtomicBool::new(false);
    let region = Region { row_start: 0, row_end: scene.height };
    let pilot = renderer.pilot(&go_on).expect("not cancelled");
    let renderer = renderer.guided(&pilot.guides()).expect("the pilot fits the lights");
    let declaration = renderer.declaration().clone();
    let estimate = Estimate::new(scene.width, scene.height, &[region], declaration, pilot.radius_squared());
    let estimate = estimate.expect("the pilot fits");
    let field = estimate.radius_field(region);
    bencher.bench_local(|| {
        let shard = Shard { first_pass: black_box(8), passes: 1, region };
        renderer.trace(shard, &field, &go_on).expect("not cancelled")
    });
}

const STORED: u32 = 1_000_000;
const QUERIES: u32 = 100_000;
/// About 28 photons lie within this radius on the unit square.
const RADIUS: f32 = 0.003;

fn square_of_photons() -> Vec<Photon> {
    let photon = |path| {
        let [x, y, _, _] = PathRandom::new(1, Stream::Photon, 0, path).block(0);
        Photon::new(Vec3::new(x, y, 0.0), 0, Vec3::Z, Vec3::ONE, 2, true)
    };
    (0..STORED).map(photon).collect()
}

fn grid() -> Grid {
    Grid::new(Vec3::ZERO, Vec3::new(1.0, 1.0, 0.001), 2.0 * RADIUS, 4 * u64::from(STORED))
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn sort_1_million_photons(bencher: Bencher<'_, '_>) {
    let photons = square_of_photons();
    bencher.counter(ItemsCount::new(STORED)).bench_local(|| {
        let chunks: Vec<PhotonChunk> = photons.chunks(8192).map(|chunk| PhotonChunk::sort(chunk, &grid())).collect();
        PhotonMap::build(&chunks, grid())
    });
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn gather_28_of_1_million_photons(bencher: Bencher<'_, '_>) {
    let map = PhotonMap::build(&[PhotonChunk::sort(&square_of_photons(), &grid())], grid());
    let queries: Vec<GatherQuery> = (0..QUERIES)
        .map(|query| {
            let [x, y, _, _] = PathRandom::new(2, Stream::Camera, 0, query).block(0);
            let position = Vec3::new(x, y, 0.0);
            GatherQuery {
                position,
                normal: Vec3::Z,
                radius_squared: RADIUS * RADIUS,
                most_segments: 127,
                caustics_only: false,
                both_sides: false,
            }
        })
        .collect();
    let accepted: f32 = queries.iter().map(|query| map.gather(query).photons).sum();
    bencher
        .counter(ItemsCount::new(accepted as u64))
        .bench_local(|| queries.iter().map(|query| map.gather(black_box(query)).photons).sum::<f32>());
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn merge_a_1920_by_1080_tally(bencher: Bencher<'_, '_>) {
    let (width, height) = (1920, 1080);
    let region = Region { row_start: 0, row_end: height };
    let pixels = (width * height) as usize;
    let first = vec![1e-4f32; pixels];
    let declaration = Arc::new(Declaration::gathering(RadiusRule::Statistics, 2.0 / 3.0));
    let estimate = Estimate::new(width, height, &[region], declaration.clone(), &first).expect("one radius per pixel");
    let found = vec![PixelTally { radiance: [1.0; 3], flux: [2.0; 3], photons: 30.0, inner_flux: 1.0 }; pixels];
    let shard = Shard { first_pass: 0, passes: 8, region };
    let mut tally = Tally::from_sums(shard, width, &declaration, &found.into());
    tally.set_scalar(PHOTONS_EMITTED, 1.0);
    let field = RadiusField { radius_squared: first, base_pass: 0, typical_radius_squared: 1e-4 };
    let bytes = pixels * size_of::<PixelTally>();
    bencher
        .counter(BytesCount::new(bytes))
        .with_inputs(|| estimate.clone())
        .bench_local_refs(|estimate| estimate.merge(&tally, &field).expect("fits"));
}

#[divan::bench(sample_count = 20, sample_size = 1)]
fn decode_a_1920_by_1080_plane(bencher: Bencher<'_, '_>) {
    let values: Vec<f32> =
        (0..1920 * 1080).map(|pixel| PathRandom::new(3, Stream::Camera, 0, pixel).block(0)[0]).collect();
    let bytes = planes::compress(&values);
    bencher
        .counter(BytesCount::of_slice(&values))
        .bench_local(|| planes::decompress(black_box(&bytes), values.len()).expect("just compressed"));
}
