//! Laws of [`Estimate::merge`]: it is the textbook's update whatever the shards and epochs, and refuses what does not fit.

use std::sync::Arc;

use crate::progressive::{Job, reference_scene};
use photonfarm::estimate::declaration::PHOTONS_EMITTED;
use photonfarm::estimate::radius::shrinkage;
use photonfarm::estimate::{
    Declaration, Estimate, MergeError, PixelEvenness, PixelTally, RadiusField, RadiusRule, Region, Shard, ShardSums,
    Tally, TallyError, Twin,
};
use photonfarm::math::random::{PathRandom, Stream};

const ALPHA: f64 = 2.0 / 3.0;
const PHOTONS: u64 = 1000;
const BOTH: [Twin; 2] = [Twin::Even, Twin::Odd];

fn region(rows: u32) -> Region {
    Region { row_start: 0, row_end: rows }
}

fn shard(first_pass: u32, passes: u32, rows: u32) -> Shard {
    Shard { first_pass, passes, region: region(rows) }
}

/// What gathering methods declare.
fn declaration(rule: RadiusRule) -> Arc<Declaration> {
    Arc::new(Declaration::gathering(rule, ALPHA))
}

/// A tally of one pass of invented pixels.
fn tally_of(first_pass: u32, rule: RadiusRule, pixels: &[PixelTally], emitted: u64) -> Tally {
    tally_with(first_pass, rule, pixels.iter().map(|pixel| (*pixel, PixelEvenness::default())), emitted)
}

/// The same, with how evenly the photons lie.
fn tally_with(
    first_pass: u32,
    rule: RadiusRule,
    pixels: impl Iterator<Item = (PixelTally, PixelEvenness)>,
    emitted: u64,
) -> Tally {
    let (tallies, evenness) = pixels.unzip();
    let sums = ShardSums { tallies, evenness };
    let shard = shard(first_pass, 1, sums.tallies.len() as u32);
    let mut tally = Tally::from_sums(shard, 1, &declaration(rule), &sums);
    tally.set_scalar(PHOTONS_EMITTED, emitted as f64);
    tally
}

/// An estimate of one column of `rows` pixels with radius 1.
fn column(rows: u32, rule: RadiusRule) -> Estimate {
    Estimate::new(1, rows, &[region(rows)], declaration(rule), &vec![1.0; rows as usize]).expect("one radius per pixel")
}

fn uniform(pass: u32, pixel: u32, block: u32) -> [f32; 4] {
    PathRandom::new(7, Stream::Photon, pass, pixel).block(block)
}

/// A tally of one pass with invented sums.
fn invented(first_pass: u32, rows: u32) -> Tally {
    invented_under(RadiusRule::Statistics, first_pass, rows)
}

fn invented_under(rule: RadiusRule, first_pass: u32, rows: u32) -> Tally {
    let mut pixels = vec![PixelTally::default(); rows as usize];
    for (index, pixel) in pixels.iter_mut().enumerate() {
        let [a, b, c, d] = uniform(first_pass, index as u32, 0);
        // Every third pixel finds nothing now and then.
        let found = if (index as u32 + first_pass).is_multiple_of(3) { 0.0 } else { (a * 40.0).floor() };
        (pixel.photons, pixel.flux, pixel.radiance) = (found, [found * b, found * c, found], [d, 0.0, a]);
        pixel.inner_flux = found * a * b;
    }
    tally_of(first_pass, rule, &pixels, PHOTONS)
}

fn close(found: f64, expected: f64, tolerance: f64, what: &str) {
    let difference = (found - expected).abs() / expected.abs().max(f64::MIN_POSITIVE);
    assert!(
        found == expected || difference <= tolerance,
        "{what}: {found} where {expected} is right ({difference:.2e})"
    );
}

/// The update of a pixel as the literature writes it, with the rescaling of what was gathered in an older radius.
struct Textbook {
    radius_squared: f64,
    photons: f64,
    tau: [f64; 3],
}

impl Textbook {
    fn update(&mut self, found: f64, flux: [f64; 3], used: f64) {
        let rescale = self.radius_squared / used;
        let found = found * rescale;
        let fraction = if found > 0.0 { (self.photons + ALPHA * found) / (self.photons + found) } else { 1.0 };
        self.radius_squared *= fraction;
        for (tau, flux) in self.tau.iter_mut().zip(flux) {
            *tau = fraction * (*tau + flux * rescale);
        }
        self.photons += ALPHA * found;
    }
}

#[test]
fn merge_law_single_passes_are_the_textbook_update() {
    const ROWS: u32 = 32;
    let mut estimate = column(ROWS, RadiusRule::Statistics);
    let start = || Textbook { radius_squared: 1.0, photons: 0.0, tau: [0.0; 3] };
    let mut twins: Vec<Textbook> = (0..ROWS).map(|_| start()).collect();
    for pass in 0..200 {
        let (field, tally) = (estimate.radius_field(region(ROWS)), invented(pass, ROWS));
        estimate.merge(&tally, &field).expect("the tally fits");
        for ((twin, found), used) in twins.iter_mut().zip(tally.pixels()).zip(&field.radius_squared) {
            twin.update(f64::from(found.photons), found.flux.map(f64::from), f64::from(*used));
        }
    }
    let picture = estimate.picture();
    for (index, (pixel, twin)) in estimate.pixels().into_iter().zip(&twins).enumerate() {
        close(pixel.radius_squared, twin.radius_squared, 1e-9, "R²");
        close(pixel.photons, twin.photons, 1e-9, "N");
        let sums = estimate.sums(index, &BOTH);
        for channel in 0..3 {
            close(sums.flux_density[channel] * pixel.radius_squared, twin.tau[channel], 1e-9, "τ");
            let emitted = (200 * PHOTONS) as f64;
            let flux = twin.tau[channel] / (std::f64::consts::PI * twin.radius_squared * emitted);
            let expected = sums.radiance[channel] / 200.0 + flux;
            close(f64::from(picture.radiance[index][channel]), expected, 1e-6, "L");
        }
    }
}

/// A shard of the sums of `passes`, as one worker would have added them.
fn joined(tallies: &[Tally]) -> Tally {
    let mut sum = tallies[0].clone();
    sum.shard.passes = tallies.len() as u32;
    for tally in &tallies[1..] {
        sum.scalars.iter_mut().zip(&tally.scalars).for_each(|(sum, more)| *sum += more);
        for (sum, more) in sum.planes.iter_mut().zip(&tally.planes) {
            sum.iter_mut().zip(more).for_each(|(sum, more)| *sum += more);
        }
    }
    sum
}

/// Merges `tallies` in shards of the given lengths, all traced with the first field.
fn merged_in_shards(tallies: &[Tally], lengths: &[usize], rule: RadiusRule) -> Estimate {
    let rows = tallies[0].pixels().len() as u32;
    let mut estimate = column(rows, rule);
    let field = estimate.radius_field(region(rows));
    let mut start = 0;
    for length in lengths {
        estimate.merge(&joined(&tallies[start..start + length]), &field).expect("the tally fits");
        start += length;
    }
    assert_eq!(start, tallies.len());
    estimate
}

const CUTS: &[&[usize]] = &[&[24], &[12, 12], &[1, 23], &[23, 1], &[5, 7, 4, 8], &[3, 3, 3, 3, 3, 3, 3, 3], &[1; 24]];

#[test]
fn merge_law_cuts_into_shards_do_not_matter_for_equal_passes() {
    const ROWS: u32 = 16;
    // Every pass is like the first.
    let mut tallies = vec![invented(1, ROWS); 24];
    for (pass, tally) in tallies.iter_mut().enumerate() {
        tally.shard.first_pass = 2 * pass as u32;
    }
    let whole = merged_in_shards(&tallies, &[24], RadiusRule::Statistics);
    for cut in CUTS {
        let estimate = merged_in_shards(&tallies, cut, RadiusRule::Statistics);
        for (pixel, expected) in estimate.pixels().into_iter().zip(whole.pixels()) {
            close(pixel.radius_squared, expected.radius_squared, 1e-6, "R²");
            close(pixel.photons, expected.photons, 1e-6, "N");
        }
    }
}

#[test]
fn merge_law_cuts_into_shards_keep_the_picture() {
    const ROWS: u32 = 16;
    for rule in [RadiusRule::Statistics, RadiusRule::Schedule, RadiusRule::Uniformity] {
        let tallies: Vec<Tally> = (0..24).map(|pass| invented_under(rule, 2 * pass, ROWS)).collect();
        let whole = merged_in_shards(&tallies, &[24], rule);
        for cut in CUTS {
            let estimate = merged_in_shards(&tallies, cut, rule);
            assert_eq!(estimate.photons_emitted(), 24 * PHOTONS);
            assert_eq!(estimate.passes(), 24);
            for pixel in 0..ROWS as usize {
                let [sums, expected] = [&estimate, &whole].map(|estimate| estimate.sums(pixel, &[Twin::Even]));
                for channel in 0..3 {
                    close(sums.flux_density[channel], expected.flux_density[channel], 1e-6, "τ/R²");
                    close(sums.radiance[channel], expected.radiance[channel], 1e-6, "radiance");
                }
                close(sums.inner_flux_density, expected.inner_flux_density, 1e-6, "inner τ/R²");
            }
        }
    }
}

/// Passes that differ are folded as if they were equal, so the radius depends a little on the cut. Measured: up to
/// 14 % for one pixel and 0.5 % for the mean of all, for Poisson counts around 20.
#[test]
fn merge_law_cuts_into_shards_hardly_change_the_radius() {
    const ROWS: u32 = 256;
    let poisson_tally = |pass: u32| {
        let pixel = |index| PixelTally { photons: poisson(20.0, pass, index) as f32, ..PixelTally::default() };
        tally_of(pass, RadiusRule::Statistics, &(0..ROWS).map(pixel).collect::<Vec<_>>(), PHOTONS)
    };
    let tallies: Vec<Tally> = (0..24).map(|pass| poisson_tally(2 * pass)).collect();
    let whole = merged_in_shards(&tallies, &[24], RadiusRule::Statistics);
    for cut in CUTS {
        let estimate = merged_in_shards(&tallies, cut, RadiusRule::Statistics);
        let pairs = estimate.pixels().into_iter().zip(whole.pixels());
        let ratios: Vec<f64> = pairs.map(|(pixel, expected)| pixel.radius_squared / expected.radius_squared).collect();
        let worst = ratios.iter().map(|ratio| (ratio - 1.0).abs()).fold(0.0, f64::max);
        let (mean, _) = mean_and_error(&ratios);
        assert!(worst < 0.2, "shards of {cut:?}: a radius² off by {worst}");
        assert!((mean - 1.0).abs() < 0.01, "shards of {cut:?}: mean radius² off by {mean}");
    }
}

/// What a pixel finds where photons lie evenly in its disc, or on one side of an edge through its middle. A disc of radius 1 holds 20 of an
/// even floor on average.
fn disc(radius_squared: f32, is_even: bool, pass: u32, index: u32) -> (PixelTally, PixelEvenness) {
    let (mut pixel, mut evenness) = (PixelTally::default(), PixelEvenness::default());
    for photon in 0..poisson(20.0 * f64::from(radius_squared), pass, index) as u32 {
        let [angle, area, ..] = uniform(1000 + pass, index, photon);
        let (sine, cosine) = (std::f32::consts::TAU * angle).sin_cos();
        if is_even || cosine > 0.0 {
            pixel.photons += 1.0;
            pixel.flux = pixel.flux.map(|flux| flux + 1.0);
            pixel.inner_flux += if area < 0.5 { 1.0 } else { 0.0 };
            evenness.flux_slope = [evenness.flux_slope[0] + cosine, evenness.flux_slope[1] + sine];
            evenness.squared_flux += 1.0;
        }
    }
    (pixel, evenness)
}

/// By `uniformity` a radius shrinks in half of the passes where photons lie evenly; beside an edge as by `statistics`. Neither
/// changes the density that is estimated.
#[test]
fn merge_law_uniformity_shrinks_only_uneven_discs() {
    const ROWS: u32 = 64;
    const PASSES: u32 = 256;
    let run = |rule: RadiusRule, is_even: bool| {
        let mut estimate = column(ROWS, rule);
        for pass in 0..PASSES {
            let field = estimate.radius_field(region(ROWS));
            let radii = (0..).zip(&field.radius_squared);
            let pixels = radii.map(|(index, radius)| disc(*radius, is_even, pass, index));
            estimate.merge(&tally_with(pass, rule, pixels, PHOTONS), &field).expect("the tally fits");
        }
        let radii = mean_and_error(&estimate.pixels().iter().map(|pixel| pixel.radius_squared).collect::<Vec<_>>());
        let density = |pixel: usize| estimate.sums(pixel, &BOTH).flux_density[0] / f64::from(PASSES);
        (radii.0, mean_and_error(&(0..ROWS as usize).map(density).collect::<Vec<_>>()))
    };
    let [statistics, even, edge] =
        [run(RadiusRule::Statistics, true), run(RadiusRule::Uniformity, true), run(RadiusRule::Uniformity, false)];
    println!("R² after {PASSES} passes: statistics {}, even {}, beside an edge {}", statistics.0, even.0, edge.0);
    assert!(even.0 > 2.5 * statistics.0, "an even disc shrank to {}", even.0);
    assert!(edge.0 < 1.15 * statistics.0, "an uneven disc stayed at {}, by statistics {}", edge.0, statistics.0);
    for ((_, (density, error)), expected) in [(statistics, 20.0), (even, 20.0), (edge, 10.0)] {
        assert!((density - expected).abs() < 4.0 * error, "{density} ± {error} is not {expected}");
    }
    assert!(even.1.1 < 0.8 * statistics.1.1, "noise {} is hardly less than {}", even.1.1, statistics.1.1);
}

#[test]
fn merge_law_what_does_not_fit_is_refused_and_changes_nothing() {
    const ROWS: u32 = 4;
    let mut estimate = column(ROWS, RadiusRule::Statistics);
    let field = estimate.radius_field(region(ROWS));
    estimate.merge(&invented(0, ROWS), &field).expect("the first pass fits");
    let before = estimate.clone();
    let mut refuse = |tally: &Tally, field: &RadiusField| {
        let error = estimate.merge(tally, field).expect_err("it does not fit");
        assert_eq!(estimate, before, "a refused tally changed the estimate");
        error
    };
    assert_eq!(refuse(&invented(0, ROWS), &field), MergeError::OutOfOrder { expected: 2, found: 0 });
    assert_eq!(refuse(&invented(3, ROWS), &field), MergeError::OutOfOrder { expected: 1, found: 3 });

    let elsewhere = Shard { first_pass: 1, passes: 1, region: Region { row_start: 1, row_end: 3 } };
    let elsewhere = Tally::zero(elsewhere, 1, &declaration(RadiusRule::Statistics));
    let schedule = invented_under(RadiusRule::Schedule, 1, ROWS);
    assert_eq!(refuse(&schedule, &field), MergeError::OtherDeclaration);
    let unknown = MergeError::UnknownRegion(Region { row_start: 1, row_end: 3 });
    assert_eq!(refuse(&elsewhere, &field), unknown);

    let mut short = invented(1, ROWS);
    short.plane_mut("photons").expect("declared").pop();
    assert_eq!(refuse(&short, &field), TallyError::WrongSize { expected: 4, found: 3 }.into());
    let small_field = RadiusField { radius_squared: vec![1.0; 3], ..field.clone() };
    assert_eq!(refuse(&invented(1, ROWS), &small_field), TallyError::WrongSize { expected: 4, found: 3 }.into());
    let mut dark = invented(1, ROWS);
    dark.set_scalar(PHOTONS_EMITTED, 0.0);
    assert_eq!(refuse(&dark, &field), TallyError::NothingEmitted.into());

    let spoiled_values = [
        ("photons", 0, -1.0),
        ("photons", 0, f32::NAN),
        ("photons", 0, f32::INFINITY),
        ("flux", 1, f32::NAN),
        ("radiance", 0, f32::NEG_INFINITY),
        ("inner_flux", 0, f32::NAN),
    ];
    for (wrong, channel, value) in spoiled_values {
        let mut tally = invented(1, ROWS);
        tally.plane_mut(wrong).expect("declared")[channel * ROWS as usize + 2] = value;
        let MergeError::Tally(TallyError::ImpossibleValue { plane, pixel, .. }) = refuse(&tally, &field) else {
            panic!("a wrong {wrong} was called something else");
        };
        assert_eq!((plane.as_str(), pixel), (wrong, 2));
    }
    for value in [-1.0, 0.5, f64::NAN, f64::INFINITY, 1e300] {
        let mut tally = invented(1, ROWS);
        tally.set_scalar("rays", value);
        let refused = refuse(&tally, &field);
        assert!(matches!(refused, MergeError::Tally(TallyError::ImpossibleScalar { .. })), "{refused}");
    }
}

#[test]
fn merge_law_a_wider_tally_is_refused() {
    let mut estimate = column(4, RadiusRule::Statistics);
    let field = estimate.radius_field(region(4));
    let wide = Tally::zero(shard(0, 1, 4), 2, &declaration(RadiusRule::Statistics));
    let wide_field = RadiusField { radius_squared: vec![1.0; 8], ..field };
    let refused = estimate.merge(&wide, &wide_field);
    assert_eq!(refused, Err(TallyError::WrongSize { expected: 4, found: 8 }.into()));
    assert_eq!(estimate, column(4, RadiusRule::Statistics));
}

// ---- The toy: photons of a uniform density, Poisson counts. -------------------------------------------------------

const TOY_PASSES: u32 = 1024;

/// A Poisson number by multiplying uniform ones [Knuth 1969].
fn poisson(mean: f64, pass: u32, pixel: u32) -> f64 {
    let end = (-mean).exp();
    let (mut product, mut count) = (1.0, 0.0);
    for block in 0.. {
        for u in uniform(pass, pixel, block) {
            product *= f64::from(u);
            if product <= end {
                return count;
            }
            count += 1.0;
        }
    }
    count
}

/// Radius² and radiance (1 is right) per pixel after all passes, in epochs of `epoch` shards of one pass. The first
/// gather finds `photons` on average.
fn toy(epoch: u32, photons: f64, pixels: u32) -> (Vec<f64>, Vec<f64>) {
    let mut estimate = column(pixels, RadiusRule::Statistics);
    for start in (0..TOY_PASSES).step_by(epoch as usize) {
        let field = estimate.radius_field(region(pixels));
        for pass in start..start + epoch {
            let scale = field.scale_of_pass(RadiusRule::Statistics, ALPHA, pass);
            let mut found_in = vec![PixelTally::default(); pixels as usize];
            for (index, pixel) in found_in.iter_mut().enumerate() {
                let gathered_in = f64::from(field.radius_squared[index] * scale);
                let found = poisson(photons * gathered_in, pass, index as u32);
                pixel.photons = found as f32 / scale;
                // Each photon carries so much flux that the radiance is 1.
                pixel.flux = [pixel.photons * (std::f64::consts::PI / photons) as f32; 3];
            }
            let tally = tally_of(pass, RadiusRule::Statistics, &found_in, 1);
            estimate.merge(&tally, &field).expect("the tally fits");
        }
    }
    let radii = estimate.pixels().into_iter().map(|pixel| pixel.radius_squared).collect();
    (radii, estimate.picture().radiance.iter().map(|pixel| f64::from(pixel[0])).collect())
}

fn mean_and_error(values: &[f64]) -> (f64, f64) {
    let count = values.len() as f64;
    let mean = values.iter().sum::<f64>() / count;
    let variance = values.iter().map(|value| (value - mean).powi(2)).sum::<f64>() / (count - 1.0);
    (mean, (variance / count).sqrt())
}

/// The sequential rule's R²/R₁² after 1024 passes of a uniform density.
const SEQUENTIAL: f64 = 0.0733;

#[test]
fn merge_law_epochs_shrink_the_radius_as_single_passes_do() {
    for photons in [5.0, 50.0] {
        let mut sequential = 0.0;
        for epoch in [1, 2, 4, 8, 16, 32, 64] {
            let what = format!("epochs of {epoch}, {photons} photons at first");
            let (radii, radiance) = toy(epoch, photons, 256);
            let (radius_squared, _) = mean_and_error(&radii);
            if epoch == 1 {
                sequential = radius_squared;
            }
            close(radius_squared, sequential, 0.02, &format!("{what}: mean R²"));
            // Few photons make the first updates uneven, which keeps the sequential rule's mean a little larger.
            close(radius_squared, SEQUENTIAL, if photons < 10.0 { 0.04 } else { 0.02 }, &format!("{what}: mean R²"));
            let (mean, error) = mean_and_error(&radiance);
            assert!((mean - 1.0).abs() < 3.0 * error, "{what}: radiance {mean} ± {error}");
            assert!(error < 0.01, "{what}: the test is blind, ± {error}");
        }
    }
}

#[test]
fn merge_law_tempting_rules_are_far_off() {
    const FIRST_GATHER: f64 = 50.0;
    const PIXELS: u32 = 64;
    // Averaging finished runs: 16 of 64 passes each keep the radius of 64 passes.
    let averaged = shrinkage(RadiusRule::Statistics, ALPHA, TOY_PASSES / 16);
    assert!(averaged > 2.3 * SEQUENTIAL, "averaging gives {averaged}");
    // Summing an epoch and updating once counts its photons as if they were one pass's.
    for (epoch, expected) in [(16u32, 0.184), (256, 0.453)] {
        let run = |index: u32| {
            let mut pixel = Textbook { radius_squared: 1.0, photons: 0.0, tau: [0.0; 3] };
            for start in (0..TOY_PASSES).step_by(epoch as usize) {
                let mean = FIRST_GATHER * pixel.radius_squared;
                let found: f64 = (start..start + epoch).map(|pass| poisson(mean, pass, index)).sum();
                pixel.update(found, [0.0; 3], pixel.radius_squared);
            }
            pixel.radius_squared
        };
        let radii: Vec<f64> = (0..PIXELS).map(run).collect();
        let (summed, _) = mean_and_error(&radii);
        close(summed, expected, 0.02, &format!("summing epochs of {epoch}"));
        assert!(summed > 2.3 * SEQUENTIAL);
    }
}

#[test]
fn merge_law_shrinkage_has_a_closed_form() {
    // Π_{j=a}^{b-1} (j+α)/(j+1) = Γ(b+α)Γ(a+1)/(Γ(a+α)Γ(b+1)).
    let closed = |first: f64, last: f64, alpha: f64| {
        let logarithm = libm::lgamma(last + alpha) + libm::lgamma(first + 1.0)
            - libm::lgamma(first + alpha)
            - libm::lgamma(last + 1.0);
        logarithm.exp()
    };
    for alpha in [0.1, 0.5, ALPHA, 0.8, 0.99] {
        for passes in [0u32, 1, 2, 7, 64, 1024, 20_000] {
            let count = f64::from(passes);
            let what = format!("{passes} passes at {alpha}");
            // Differences of large logarithms lose digits: 10⁻⁹ holds while they are below 10⁵.
            close(shrinkage(RadiusRule::Statistics, alpha, passes), closed(0.0, count, alpha), 1e-9, &what);
            close(shrinkage(RadiusRule::Schedule, alpha, passes), closed(1.0, count + 1.0, alpha), 1e-9, &what);
        }
    }
    close(shrinkage(RadiusRule::Statistics, ALPHA, TOY_PASSES), SEQUENTIAL, 1e-3, "the toy's constant");
}

#[test]
fn merge_law_schedule_ignores_what_was_found() {
    let mut estimate = column(4, RadiusRule::Schedule);
    for pass in 0..10 {
        let field = estimate.radius_field(region(4));
        assert_eq!((field.base_pass, field.radius_squared.as_slice()), (0, &[1.0f32; 4][..]));
        let scale = f64::from(field.scale_of_pass(RadiusRule::Schedule, ALPHA, pass));
        close(scale, shrinkage(RadiusRule::Schedule, ALPHA, pass), 1e-6, "ρ");
        estimate.merge(&invented_under(RadiusRule::Schedule, pass, 4), &field).expect("the tally fits");
    }
}

// ---- A real picture. ---------------------------------------------------------------------------------------------

/// Where it stops holding: where the density that a pixel sees jumps from pass to pass (edges of objects and shadows, the
/// rim of the lamp), the photons of an epoch come from another disc than the sequential rule's. Measured after 64 passes:
/// in epochs of 8 and of 64, 3 % and 4 % of the radii are off by more than 2 %, 1.5 % by more than 5 %, the worst by
/// 24 % and 22 %; the mean radius by 0.2 %, the mean radiance by 0.002 %.
#[test]
fn merge_law_epochs_of_a_real_picture_agree() {
    const PASSES: u32 = 64;
    let job =
        Job::new(&reference_scene("cornell-diffuse"), "sppm", r#"{"photons_per_pass": 32768, "initial_radius": 0.06}"#);
    let sequential = job.run(PASSES, 1);
    for epoch in [8, 64] {
        let estimate = job.run(PASSES, epoch);
        let mut ratios: Vec<f64> = sequential
            .pixels()
            .iter()
            .zip(estimate.pixels())
            .filter(|(expected, _)| expected.photons > 0.0)
            .map(|(expected, pixel)| (pixel.radius_squared / expected.radius_squared).sqrt())
            .collect();
        ratios.sort_by(f64::total_cmp);
        let share = |bound: f64| {
            ratios.iter().filter(|ratio| (**ratio - 1.0).abs() < bound).count() as f64 / ratios.len() as f64
        };
        let radii = |estimate: &Estimate| {
            let found = estimate.pixels().into_iter().filter(|pixel| pixel.photons > 0.0);
            mean_and_error(&found.map(|pixel| pixel.radius_squared.sqrt()).collect::<Vec<_>>()).0
        };
        let radiance = |estimate: &Estimate| {
            let values = estimate.picture().radiance;
            mean_and_error(&values.iter().map(|p| f64::from(p[0] + p[1] + p[2]) / 3.0).collect::<Vec<_>>()).0
        };
        let (radius, light) = (radii(&estimate) / radii(&sequential), radiance(&estimate) / radiance(&sequential));
        assert!((radius - 1.0).abs() < 0.02, "epochs of {epoch}: mean radius {radius}");
        assert!(share(0.02) > 0.95, "epochs of {epoch}: {} of the radii are within 2 %", share(0.02));
        assert!((light - 1.0).abs() < 0.005, "epochs of {epoch}: mean radiance {light}");
    }
}
