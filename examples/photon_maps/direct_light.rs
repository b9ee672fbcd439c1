//! Section 4.2: direct light by Monte Carlo, with shadow photons and with PhotonDirect, in a hundred rooms with a lamp each (SCENE10).

use std::sync::Arc;
use std::sync::atomic::AtomicBool;

use photonfarm::estimate::Picture;
use photonfarm::math::random::{PassRandom, Stream, dimension};
use photonfarm::scene::Scene;
use photonfarm::scene::material::TransportMode;
use photonfarm::transport::Limits;
use photonfarm::transport::direct_light::LightSight;
use photonfarm::transport::direct_photons::{LIT_SEGMENTS, Stored, trace_direct_photons};
use photonfarm::transport::light_sights::LightSights;
use photonfarm::transport::photon_map::{Grid, LightSegment, Nearest, PhotonLookup, PhotonMap};
use photonfarm::transport::photon_tracing::PhotonSettings;
use photonfarm::transport::receiver::{Counting, Receiver};
use photonfarm::transport::shading;
use serde_json::{Value, json};

use crate::Fallible;
use crate::laboratory::{Experiment, errors, scene, show};

/// Width of the pictures that are measured.
const SIZE: u32 = 64;
/// Passes, and so samples per pixel, as in the thesis.
const PASSES: u32 = 8;
const SCENE: &str = "scene10/scene.xml";

/// A row of the thesis' table 4.1.
struct MonteCarlo {
    rays: u32,
    error: f64,
    seconds: f64,
}

const MONTE_CARLO: [MonteCarlo; 4] = [
    MonteCarlo { rays: 100, error: 0.030, seconds: 436.0 },
    MonteCarlo { rays: 200, error: 0.022, seconds: 821.0 },
    MonteCarlo { rays: 400, error: 0.016, seconds: 1507.0 },
    MonteCarlo { rays: 800, error: 0.013, seconds: 2875.0 },
];

/// A row of the table in section 4.2.3.
struct PhotonDirect {
    neighbors: u32,
    photons: u32,
    samples: u32,
    error: f64,
    seconds: f64,
    /// What Monte Carlo took for the same error, where it was measured, s.
    monte_carlo_seconds: Option<f64>,
}

const PHOTON_DIRECT: [PhotonDirect; 7] = [
    row(50, 10_000, 10, 0.018, 322.0, Some(1155.0)),
    row(50, 10_000, 100, 0.016, 1212.0, Some(1507.0)),
    row(100, 100_000, 10, 0.016, 926.0, Some(1507.0)),
    row(100, 100_000, 100, 0.013, 1863.0, Some(2875.0)),
    row(300, 100_000, 10, 0.013, 1352.0, Some(2875.0)),
    row(300, 100_000, 20, 0.011, 1450.0, None),
    row(300, 100_000, 50, 0.009, 1755.0, None),
];

const fn row(
    neighbors: u32,
    photons: u32,
    samples: u32,
    error: f64,
    seconds: f64,
    monte_carlo_seconds: Option<f64>,
) -> PhotonDirect {
    PhotonDirect { neighbors, photons, samples, error, seconds, monte_carlo_seconds }
}

/// Times of PhotonDirect over those of Monte Carlo for the same error.
struct Ratios {
    /// A look-up for every sample of a pixel.
    always: f64,
    /// Look-ups are used again.
    reused: f64,
}

/// Error relative to the mean of the picture, and processor time, s.
#[derive(Clone, Copy)]
struct Measured {
    error: f64,
    seconds: f64,
}

/// Prints the chapter.
pub(crate) fn run() -> Fallible<()> {
    let rooms = scene(SCENE, SIZE)?;
    let truth = truth(&rooms)?;
    println!("{CLAIM}");
    let plain = monte_carlo(&rooms, &truth)?;
    let ratios = photon_direct(&rooms, &truth, &plain)?;
    learnt_picks(&rooms, &truth, &plain)?;
    shadow_photons()?;
    pictures()?;
    print_verdict(&ratios);
    Ok(())
}

/// Direct light alone, with photons by power and picks without learnt occlusion, as the thesis has them; `more` replaces and adds parameters.
fn parameters(more: &Value) -> Value {
    let mut all = json!({
        "max_depth": 2, "final_gather": 0, "emission": "power", "light_picks": "importance", "photons_per_pass": 1,
    });
    if let (Some(all), Some(more)) = (all.as_object_mut(), more.as_object()) {
        all.extend(more.clone());
    }
    all
}

/// By very many light samples with picks that know what is hidden, at the same camera rays: what pixels' edges make of so few of them is the same
/// for all rows, and does not count.
fn truth(rooms: &Arc<Scene>) -> Fallible<Picture> {
    let parameters = parameters(&json!({ "direct_samples": 1024, "light_picks": "visible" }));
    Ok(Experiment { method: "photon_map", parameters, passes: PASSES, seed: 1 }.render(rooms)?.picture)
}

fn measure(rooms: &Arc<Scene>, truth: &Picture, more: &Value) -> Fallible<Measured> {
    let parameters = parameters(more);
    let rendered = Experiment { method: "photon_map", parameters, passes: PASSES, seed: 1 }.render(rooms)?;
    Ok(Measured { error: errors(&rendered.picture, truth)?.rel_rmse, seconds: rendered.seconds })
}

/// Table 4.1.
fn monte_carlo(rooms: &Arc<Scene>, truth: &Picture) -> Fallible<Vec<Measured>> {
    println!("| shadow rays a sample | thesis: error | time, s | here: error | time, s |\n|---:|---:|---:|---:|---:|");
    let mut all = Vec::new();
    for MonteCarlo { rays, error, seconds } in MONTE_CARLO {
        let found = measure(rooms, truth, &json!({ "direct_samples": rays }))?;
        println!("| {rays} | {error:.3} | {seconds} | {:.4} | {:.1} |", found.error, found.seconds);
        all.push(found);
    }
    Ok(all)
}

/// The time in which Monte Carlo has so small an error, s: between and beyond its rows on straight lines of the logarithms.
fn monte_carlo_seconds(plain: &[Measured], error: f64) -> f64 {
    let inner = plain[1..plain.len() - 1].iter().take_while(|row| row.error > error).count();
    let (before, after) = (plain[inner], plain[inner + 1]);
    let part = (before.error / error).ln() / (before.error / after.error).ln();
    before.seconds * (after.seconds / before.seconds).powf(part)
}

/// The table of section 4.2.3.
fn photon_direct(rooms: &Arc<Scene>, truth: &Picture, plain: &[Measured]) -> Fallible<Vec<Ratios>> {
    println!(
        "\n| k, N | samples | thesis: error | time, s | over Monte Carlo's | here: error | time, s | over Monte Carlo's | \
         look-ups used again: error | time, s | over Monte Carlo's |\n|---|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|"
    );
    let mut all = Vec::new();
    for PhotonDirect { neighbors, photons, samples, error, seconds, monte_carlo_seconds: theirs } in PHOTON_DIRECT {
        let their_ratio = theirs.map_or("–".to_owned(), |theirs| format!("{:.2}", seconds / theirs));
        print!("| {neighbors}, {photons} | {samples}+1 | {error:.3} | {seconds} | {their_ratio} |");
        let row = |reuse: f64| -> Fallible<f64> {
            let found = measure(
                rooms,
                truth,
                &json!({
                    "direct": "photon_direct", "photons_per_pass": photons, "direct_neighbors": neighbors,
                    "direct_samples": samples, "direct_reuse": reuse,
                }),
            )?;
            let ratio = found.seconds / monte_carlo_seconds(plain, found.error);
            print!(" {:.4} | {:.1} | {ratio:.2} |", found.error, found.seconds);
            Ok(ratio)
        };
        all.push(Ratios { always: row(0.0)?, reused: row(0.5)? });
        println!();
    }
    Ok(all)
}

/// What picks that learnt occlusion make of the same light samples, without any photon.
fn learnt_picks(rooms: &Arc<Scene>, truth: &Picture, plain: &[Measured]) -> Fallible<()> {
    println!("\nWithout photons, with picks that a pilot taught which lamps are seen (`light_picks: visible`):\n");
    println!("| shadow rays a sample | error | time, s | over Monte Carlo's |\n|---:|---:|---:|---:|");
    for rays in [1, 10, 100] {
        let found = measure(rooms, truth, &json!({ "direct_samples": rays, "light_picks": "visible" }))?;
        let ratio = found.seconds / monte_carlo_seconds(plain, found.error);
        println!("| {rays} | {:.4} | {:.1} | {ratio:.2} |", found.error, found.seconds);
    }
    Ok(())
}

/// Photons of the table of shadow photons, and its k.
const SHADOW_PATHS: u32 = 100_000;
const SHADOW_NEIGHBORS: usize = 50;

/// Section 4.2.2: what shadow photons save.
fn shadow_photons() -> Fallible<()> {
    println!(
        "\nShadow photons, {SHADOW_PATHS} photons and k = {SHADOW_NEIGHBORS}: shares of the light samples that need no shadow ray, and how the mean of the \
         picture changes.\n"
    );
    println!("| scene | lights | shadow photons a photon | lit | dark | shadow ray | rays saved | mean |");
    println!("|---|---:|---:|---:|---:|---:|---:|---:|");
    for file in ["scene6/scene.xml", SCENE] {
        let scene = scene(file, SIZE)?;
        let map = shadow_map(&scene)?;
        let shadows = (0..map.len()).filter(|index| map.photon(*index).segments() > LIT_SEGMENTS).count();
        let sights = sights(&scene, &map);
        let share = |sight: LightSight| {
            let count = sights.iter().filter(|found| **found == sight).count();
            100.0 * count as f64 / sights.len().max(1) as f64
        };
        println!(
            "| {} | {} | {:.1} | {:.0} % | {:.0} % | {:.0} % | {:.0} % | {:+.2} % |",
            file.split('/').next().unwrap_or_default().to_uppercase(),
            scene.lights.lights().len(),
            shadows as f64 / (map.len() - shadows) as f64,
            share(LightSight::Lit),
            share(LightSight::Dark),
            share(LightSight::Unknown),
            100.0 - share(LightSight::Unknown),
            100.0 * shadow_bias(&scene)?
        );
    }
    Ok(())
}

fn shadow_map(scene: &Scene) -> Fallible<PhotonMap<LightSegment>> {
    let random = PassRandom::independent(1, Stream::Photon, 0);
    let settings = PhotonSettings {
        limits: Limits { max_depth: None, rr_depth: 1 },
        first_stored_segment: 1,
        narrow_takes_all: false,
        random: &random,
        paths: SHADOW_PATHS,
        guide: None,
    };
    let (low, high) = scene.geometry.bounds();
    let grid = Grid::new(low, high, 0.005 * (high - low).length(), 4 * u64::from(SHADOW_PATHS));
    let traced = trace_direct_photons(scene, &settings, Stored::LitAndShadows, grid, &AtomicBool::new(false));
    Ok(traced.ok_or("nobody cancels")?.0)
}

/// What is known of the light that is picked in each pixel.
fn sights(scene: &Scene, map: &PhotonMap<LightSegment>) -> Vec<LightSight> {
    let (mut found, mut known) = (Nearest::default(), LightSights::default());
    let radius = 0.025 * scene.geometry.bounding_sphere().1;
    let random = PassRandom::of_pixels(1, Stream::Camera, 0);
    let mut sight = |pixel: u32| {
        let random = random.path(pixel);
        let place = [pixel % scene.width, pixel / scene.width];
        let hit = scene.intersect_from_camera(&scene.camera_ray(place, random.block(dimension::CAMERA)))?;
        let (light, _) = scene.lights.pick(&scene.place(&hit), random.block(dimension::light(1))[2])?;
        let receiver = Receiver::new(scene, &hit, shading::view(&hit, TransportMode::Radiance));
        let counting =
            Counting { radius_squared: radius * radius, most_segments: LIT_SEGMENTS + 1, caustics_only: false };
        map.nearest(&receiver.query(counting), SHADOW_NEIGHBORS, &mut found);
        known.judge(map, &found);
        Some(known.of(light))
    };
    (0..scene.pixel_count() as u32).filter_map(&mut sight).collect()
}

/// How far the mean of direct light is off that of light samples at the same points, relative.
fn shadow_bias(scene: &Arc<Scene>) -> Fallible<f64> {
    let render = |more: &Value| {
        let experiment = Experiment { method: "photon_map", parameters: parameters(more), passes: PASSES, seed: 1 };
        experiment.render(scene)
    };
    let plain = render(&json!({ "direct_samples": 32 }))?;
    let found = render(&json!({
        "direct": "shadow_photons", "direct_samples": 32, "photons_per_pass": SHADOW_PATHS,
        "direct_neighbors": SHADOW_NEIGHBORS,
    }))?;
    Ok(errors(&found.picture, &plain.picture)?.bias)
}

/// The thesis' two pictures.
fn pictures() -> Fallible<()> {
    let rooms = scene(SCENE, 2 * SIZE)?;
    println!();
    let ways = [
        ("direct-monte-carlo", "Monte Carlo, 100 samples", json!({ "direct_samples": 100 })),
        (
            "direct-photon-direct",
            "PhotonDirect, 20+1 samples, 50/10,000 photons",
            json!({
                "direct": "photon_direct", "direct_samples": 20, "photons_per_pass": 10_000, "direct_neighbors": 50,
            }),
        ),
    ];
    for (name, caption, more) in ways {
        let parameters = parameters(&more);
        let rendered = Experiment { method: "photon_map", parameters, passes: 1, seed: 1 }.render(&rooms)?;
        show(&rendered.picture, name, &format!("{caption}: {:.1} s", rendered.seconds))?;
    }
    Ok(())
}

const CLAIM: &str = "\
Claim: with many lights of which few are seen, light samples in proportion to what photons brought from each light (PhotonDirect) reach the error of \
Monte Carlo in a quarter to four fifths of its time; used again close by, look-ups cost a twentieth. Shadow photons save nine shadow rays of ten [Jensen & Christensen 1995], but not with many \
lights.

`photon_map` has them as `direct: sample | photons | shadow_photons | photon_direct`. Here direct light alone is measured, with 8 samples a pixel as \
there. Errors are root mean squares over the picture's mean here, of an unknown unit there. Monte Carlo there picks lights by their power; here \
it picks them by an estimate of what arrives, without what is hidden, and so starts from much less noise.
";

/// Why PhotonDirect does not gain, where it does not.
const WHY: &str = " Monte Carlo is good here because importance picks the lamps of the room and those that shine through its doorways nearly as often as they matter, and spreads
its samples evenly among them; PhotonDirect leaves a lamp whose photons it missed to a single sample.";

/// Says what the measured ratios say.
fn print_verdict(ratios: &[Ratios]) {
    let always = || ratios.iter().map(|ratios| ratios.always);
    let reused = || ratios.iter().map(|ratios| ratios.reused);
    let faster = always().filter(|ratio| *ratio < 1.0).count();
    let verdict = match faster {
        0 => "does not hold",
        _ if faster == ratios.len() => "holds",
        _ => "holds in part",
    };
    let why = if faster == 0 { WHY } else { "" };
    let least = |values: &mut dyn Iterator<Item = f64>| values.fold(f64::INFINITY, f64::min);
    let most = |values: &mut dyn Iterator<Item = f64>| values.fold(0.0, f64::max);
    println!(
        "\nThe claim {verdict}: {faster} of {} settings of PhotonDirect are faster than Monte Carlo at their error. They take {:.2} to {:.2} of its time, {:.2} to \
         {:.2} where look-ups are used again; in the thesis 0.28 to 0.80.{why}",
        ratios.len(),
        least(&mut always()),
        most(&mut always()),
        least(&mut reused()),
        most(&mut reused()),
    );
}
