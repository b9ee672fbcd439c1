//! `sppm`: stochastic progressive photon mapping. Every pass traces one new camera path per pixel to the first surface
//! with a smooth lobe, emits photons, and gathers them there in a disc whose radius shrinks from pass to pass. All points that
//! a pixel sees share its statistics, so glossy surfaces, lenses and anti-aliasing converge too.
//!
//! References: [HJ09] Hachisuka & Jensen 2009, "Stochastic progressive photon mapping"; [KZ11] Knaus & Zwicker 2011,
//! "Progressive photon mapping: a probabilistic approach".
//!
//! | symbol | here | unit |
//! |---|---|---|
//! | R² | `pass.radius_squared` × `pass.scale` | m² |
//! | M, Φ | `PixelTally::photons`, `PixelTally::flux` (both over `pass.scale`) | –, W·sr⁻¹ |
//! | T | `GatherPoint::throughput` | – |
//! | α_p | photon flux, `Le·cos/pdf` | W |
//!
//! Limits: a bias that falls with the radius (corners and edges last); glossy surfaces seen in glossy surfaces need many
//! passes.

use std::sync::Arc;
use std::sync::atomic::{AtomicBool, Ordering};

use rayon::prelude::*;

use super::parameters::{self, HELP, ParameterHelp, ProgressiveParameters};
use super::photon_pass::{PhotonPasses, add_to_tally};
use super::{
    Bias, CheckedMethod, MethodChoice, MethodEntry, MethodError, Pass, PilotPass, PreparedMethod, blind_to_nothing,
    declare_gathering,
};
use crate::estimate::PixelTally;
use crate::math::random::{PassRandom, PathRandom, Stream};
use crate::scene::Scene;
use crate::transport::Counters;
use crate::transport::photon_map::{Gathered, PhotonMap};

const NAME: &str = "sppm";
const PARAMETERS: &[ParameterHelp] = HELP.split_at(HELP.len() - 1).0;

/// The row of the table.
pub const ENTRY: MethodEntry = MethodEntry {
    name: NAME,
    summary: "stochastic progressive photon mapping: new camera paths every pass, shared pixel statistics",
    cannot_sample: "nothing; every path with a surface that is not a mirror or glass is found",
    reference: "Hachisuka & Jensen 2009; Knaus & Zwicker 2011",
    bias: Bias::Shrinks,
    parameters: PARAMETERS,
    negative_lobes: false,
    media: false,
    strategies: None,
    blind_to: blind_to_nothing,
    check,
    declare: declare_gathering,
    prepare,
};

fn check(choice: &MethodChoice, pixels: u64) -> Result<CheckedMethod, MethodError> {
    Ok(parameters::read::<ProgressiveParameters>(NAME, &choice.parameters, PARAMETERS)?
        .checked(NAME, PARAMETERS, pixels))
}

fn prepare(scene: Arc<Scene>, method: &CheckedMethod, seed: u64) -> Result<Box<dyn PreparedMethod>, MethodError> {
    let parameters: ProgressiveParameters = parameters::read(NAME, &method.choice.parameters, PARAMETERS)?;
    Ok(Box::new(Sppm { passes: PhotonPasses::new(scene, method, &parameters, seed, true)? }))
}

struct Sppm {
    passes: PhotonPasses,
}

impl Sppm {
    /// One pixel of one pass.
    #[inline]
    fn trace_pixel(
        &self,
        pass: &Pass<'_>,
        map: &PhotonMap,
        (pixel, random): (usize, &PathRandom),
        radius_squared: f32,
        tally: &mut PixelTally,
        counters: &mut Counters,
    ) {
        let mut gathered = Gathered::default();
        let radiance = self.passes.camera_path(random, pixel, counters, |point, radiance, counters| {
            *radiance += point.throughput * self.passes.direct_light(point, random, counters);
            gathered.add(&self.passes.gather(map, point, radius_squared * pass.scale), point.throughput);
        });
        add_to_tally(tally, pass, radiance, &gathered, counters);
    }
}

impl PreparedMethod for Sppm {
    fn trace_pass(&self, pass: &Pass<'_>, pixels: &mut [PixelTally], cancel: &AtomicBool) -> Option<Counters> {
        let (map, mut total) =
            self.passes.photon_map(Stream::Photon, pass.index, pass.typical_radius_squared, cancel)?;
        let random = PassRandom::of_pixels(self.passes.seed, Stream::Camera, pass.index);
        let width = self.passes.scene.width as usize;
        let first_pixel = pass.region.row_start as usize * width;
        let rows = pixels.par_chunks_mut(width).zip(pass.radius_squared.par_chunks(width)).enumerate();
        let counters: Vec<Counters> = rows
            .map(|(row, (tallies, radii))| {
                let mut counters = Counters::default();
                if cancel.load(Ordering::Relaxed) {
                    return counters;
                }
                for (column, (tally, radius)) in tallies.iter_mut().zip(radii).enumerate() {
                    let pixel = first_pixel + row * width + column;
                    let path = (pixel, &random.path(pixel as u32));
                    self.trace_pixel(pass, &map, path, *radius, tally, &mut counters);
                }
                counters
            })
            .collect();
        counters.into_iter().for_each(|counters| total += counters);
        (!cancel.load(Ordering::Relaxed)).then_some(total)
    }

    fn pilot(&self, cancel: &AtomicBool) -> Option<PilotPass> {
        let (radii, counters) = self.passes.pilot(cancel)?;
        Some(PilotPass::with_radii(radii, counters))
    }
}
