//! Figures 1 and 2 of the paper: where photons lie, seen from above.

use std::error::Error;
use std::ops::Range;
use std::sync::atomic::AtomicBool;

use image::{Rgb, RgbImage};
use photonfarm::math::random::{PassRandom, Stream};
use photonfarm::scene::Scene;
use photonfarm::transport::metropolis::chains::{Chains, Lengths};
use photonfarm::transport::metropolis::eye_subpaths::EyeSubpaths;
use photonfarm::transport::metropolis::path_space::PathSpace;
use photonfarm::transport::metropolis::path_space::proposals::Shares;
use photonfarm::transport::metropolis::path_space::window::FilmWindow;
use photonfarm::transport::metropolis::photon_paths::PhotonPaths;
use photonfarm::transport::photon_map::Photon;
use photonfarm::transport::photon_tracing::{PhotonSettings, trace_photon};
use photonfarm::transport::{Counters, Limits};

use crate::contenders::{Subject, picture_folder};

/// Photons that are drawn.
const PHOTONS: usize = 20_000;
/// Pixels of a metre.
const SCALE: f32 = 60.0;
/// The part of `rooms` that is drawn, m: x and z.
const PLAN: [Range<f32>; 2] = [-6.1..6.1, -6.1..2.1];

/// Draws photons by power and photons of whole paths in the plan of `rooms`.
pub(crate) fn draw() -> Result<(), Box<dyn Error>> {
    let subject = Subject::load("rooms", 192)?;
    for (file, photons) in
        [("rooms-plan-power.png", by_power(&subject.scene)), ("rooms-plan-mps.png", of_whole_paths(&subject.scene))]
    {
        let inside = photons.iter().filter(|photon| is_in_seen_room(photon)).count();
        let share = 100.0 * inside as f64 / photons.len() as f64;
        println!("![{share:.0} % of {} photons are in the room that is seen](metropolis/{file})", photons.len());
        plan(&photons).save(picture_folder()?.join(file))?;
    }
    Ok(())
}

/// The room of the camera is 4 × 4 m around the origin.
fn is_in_seen_room(photon: &Photon) -> bool {
    photon.position[0].abs() < 2.0 && photon.position[2].abs() < 2.0
}

fn plan(photons: &[Photon]) -> RgbImage {
    let [width, height] = PLAN.map(|side| ((side.end - side.start) * SCALE) as u32);
    let mut image = RgbImage::from_pixel(width, height, Rgb([255; 3]));
    for photon in photons {
        let [x, _, z] = photon.position;
        let [column, row] = [x - PLAN[0].start, z - PLAN[1].start].map(|distance| (distance * SCALE) as u32);
        if column < width && row < height {
            image.get_pixel_mut(column, row).0.iter_mut().for_each(|value| *value /= 2);
        }
    }
    image
}

fn by_power(scene: &Scene) -> Vec<Photon> {
    let random = PassRandom::independent(1, Stream::Photon, 0);
    let settings = PhotonSettings {
        limits: Limits { max_depth: None, rr_depth: 1 },
        first_stored_segment: 1,
        narrow_takes_all: false,
        random: &random,
        paths: PHOTONS as u32,
        guide: None,
    };
    let (mut photons, mut counters) = (Vec::new(), Counters::default());
    let mut path = 0;
    while photons.len() < PHOTONS {
        trace_photon(scene, &settings, path, &mut photons, &mut counters);
        path += 1;
    }
    photons
}

fn of_whole_paths(scene: &Scene) -> Vec<Photon> {
    let never = AtomicBool::new(false);
    let random = |stream| PassRandom::independent(1, stream, 0);
    let window = FilmWindow::new(scene);
    let eye = EyeSubpaths::trace(scene, &window, 1 << 14, &random(Stream::Importance), &never);
    let (eye, _) = eye.expect("nobody cancels");
    let paths = PathSpace {
        scene,
        lengths: Lengths { shortest: 3, longest: None },
        window,
        shares: Shares::new([30.0, 20.0, 20.0, 0.0, 20.0, 0.0]),
        user_paths: &[],
        least_importance: eye.usual(),
        pixels: 0..0,
    };
    let space = PhotonPaths { paths, eye: &eye, ways: 8, photons: PHOTONS as f32 };
    let chains = Chains {
        space: &space,
        large_steps: 0.3,
        mutations: 8 * PHOTONS as u32,
        chains: 64,
        starts: random(Stream::Bootstrap),
        trials: random(Stream::Trial),
        steps: random(Stream::Chain),
    };
    let found = chains.trace(&never).expect("nobody cancels");
    found.into_iter().flat_map(|found| found.brought).map(|found| found.photon).take(PHOTONS).collect()
}
