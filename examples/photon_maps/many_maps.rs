//! Section 4.4: photons in one map or in many, and pixels that look at one of them or another.

use std::sync::Arc;

use photonfarm::estimate::Picture;
use photonfarm::scene::Scene;
use serde_json::{Value, json};

use crate::Fallible;
use crate::laboratory::{Experiment, errors, reference, scene, show};

/// Width of pictures, pixels.
const SIZE: u32 = 129;
/// Each row is the root mean square over so many pictures with seeds of their own.
const SEEDS: u64 = 3;
/// Photons per map of the first table, and neighbors in one of them.
const MAP: u32 = 25_000;
const NEIGHBORS: u32 = 20;
/// How often as many photons: the thesis' error and time with one map, then with as many maps as this.
const DIVIDED: [(u32, [f64; 4]); 4] = [
    (1, [0.033, 40.0, 0.032, 39.0]),
    (4, [0.018, 157.0, 0.019, 141.0]),
    (16, [0.012, 655.0, 0.013, 516.0]),
    (64, [0.010, 2751.0, 0.011, 2207.0]),
];
/// Photons of the thesis' maps, its errors with one of them oversampled four times and with four in turn.
const IN_TURN: [(&str, [f64; 2]); 4] =
    [("100k", [0.070, 0.047]), ("200k", [0.043, 0.026]), ("1M", [0.017, 0.011]), ("5M", [0.010, 0.007])];
/// The same with one map and with 16, of which each pixel looks at one.
const SKIPPING: [(&str, [f64; 2]); 4] =
    [("100k", [0.081, 0.084]), ("200k", [0.049, 0.050]), ("1M", [0.021, 0.022]), ("5M", [0.015, 0.014])];
/// Photons of our maps in their place, for pictures of a sixteenth of the pixels.
const PHOTONS: [u32; 4] = [10_000, 20_000, 100_000, 500_000];

/// Errors of pictures and the time that one takes.
pub(crate) struct Row {
    /// Root mean square error over the truth's mean.
    pub(crate) error: f64,
    /// The same of means over 8 × 8 pixels: what stands in low frequencies.
    pub(crate) low: f64,
    /// Processor time, s.
    pub(crate) seconds: f64,
    /// The last picture.
    pub(crate) picture: Picture,
}

/// Renders so many passes with as many seeds.
pub(crate) fn measure(scene: &Arc<Scene>, truth: &Picture, parameters: &Value, passes: u32) -> Fallible<Row> {
    let (mut squares, mut low_squares, mut seconds, mut last) = (0.0, 0.0, 0.0, None);
    for seed in 1..=SEEDS {
        let rendered =
            Experiment { method: "photon_map", parameters: parameters.clone(), passes, seed }.render(scene)?;
        squares += errors(&rendered.picture, truth)?.rel_rmse.powi(2);
        low_squares += errors(&blocks(&rendered.picture), &blocks(truth))?.rel_rmse.powi(2);
        seconds += rendered.seconds;
        last = Some(rendered.picture);
    }
    let count = SEEDS as f64;
    let picture = last.ok_or("no picture was rendered")?;
    Ok(Row { error: (squares / count).sqrt(), low: (low_squares / count).sqrt(), seconds: seconds / count, picture })
}

/// Means over blocks of 8 × 8 pixels; what is left at the right and at the bottom is cut off.
fn blocks(picture: &Picture) -> Picture {
    const SIDE: u32 = 8;
    let (width, height) = (picture.width / SIDE, picture.height / SIDE);
    let mean = |block: u32| {
        let (column, row) = (block % width * SIDE, block / width * SIDE);
        let pixels = (0..SIDE * SIDE).map(|pixel| (row + pixel / SIDE) * picture.width + column + pixel % SIDE);
        let sum = pixels.fold([0.0f64; 3], |sum, pixel| {
            let found = picture.radiance[pixel as usize];
            [0, 1, 2].map(|channel| sum[channel] + f64::from(found[channel]))
        });
        sum.map(|sum| (sum / f64::from(SIDE * SIDE)) as f32)
    };
    Picture { width, height, radiance: (0..width * height).map(mean).collect() }
}

/// Prints the chapter.
pub(crate) fn run() -> Fallible<()> {
    println!("{CLAIM}");
    let scene = scene("scene6/scene.xml", SIZE)?;
    let truth = reference(&scene, "path", 1024)?;
    divided(&scene, &truth)?;
    in_turn(&scene, &truth)?;
    skipping(&scene, &truth)?;
    println!("{VERDICT}");
    Ok(())
}

fn divided(scene: &Arc<Scene>, truth: &Picture) -> Fallible<()> {
    println!("| photons | 1 map | | that many maps | | 1 map, as few neighbors | | thesis: 1 map | | maps | |");
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    println!("| | error | time, s | error | time, s | error | time, s | error | time, s | error | time, s |");
    let mut ratios = Ratios::default();
    for (maps, theirs) in DIVIDED {
        let parameters = |maps: u32, neighbors: u32, photons: u32| {
            json!({ "final_gather": 0, "emission": "power", "photons_per_pass": photons, "maps": maps,
                "neighbors": neighbors, "caustic_neighbors": neighbors })
        };
        let one = measure(scene, truth, &parameters(1, NEIGHBORS * maps, MAP * maps), 1)?;
        let many = measure(scene, truth, &parameters(maps, NEIGHBORS, MAP * maps), 1)?;
        let fine = measure(scene, truth, &parameters(1, NEIGHBORS, MAP * maps), 1)?;
        ratios.add(&one, &many, [theirs[0], theirs[2]]);
        println!(
            "| {maps} · {MAP} | {:.4} | {:.2} | {:.4} | {:.2} | {:.4} | {:.2} | {} | {} | {} | {} |",
            one.error,
            one.seconds,
            many.error,
            many.seconds,
            fine.error,
            fine.seconds,
            theirs[0],
            theirs[1],
            theirs[2],
            theirs[3]
        );
    }
    ratios.print("Photons in many maps against one");
    println!("{DIVIDED_NOTE}");
    Ok(())
}

fn in_turn(scene: &Arc<Scene>, truth: &Picture) -> Fallible<()> {
    println!("| photons | 1 map, 4 samples | | | 4 maps in turn | | | thesis: photons | 1 map | 4 maps |");
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    println!("| | error | low | time, s | error | low | time, s | | error | error |");
    let mut ratios = Ratios::default();
    for (photons, (theirs, [one, four])) in PHOTONS.into_iter().zip(IN_TURN) {
        let parameters = |paths: u32| json!({ "final_gather": 0, "emission": "power", "photons_per_pass": photons, "camera_paths": paths });
        let oversampled = measure(scene, truth, &parameters(4), 1)?;
        let turns = measure(scene, truth, &parameters(1), 4)?;
        print_pair(photons, &oversampled, &turns, theirs, [one, four]);
        ratios.add(&oversampled, &turns, [one, four]);
    }
    ratios.print("Four maps in turn against four samples of one");
    Ok(())
}

fn skipping(scene: &Arc<Scene>, truth: &Picture) -> Fallible<()> {
    println!("| photons | 1 map | | | `skipping: 4` | | | thesis: photons | 1 map | 16 maps |");
    println!("|---:|---:|---:|---:|---:|---:|---:|---:|---:|---:|");
    println!("| | error | low | time, s | error | low | time, s | | error | error |");
    let (mut ratios, mut pictures) = (Ratios::default(), None);
    for (photons, (theirs, [one, sixteen])) in PHOTONS.into_iter().zip(SKIPPING) {
        let parameters = |skipping: u32| json!({ "final_gather": 0, "emission": "power", "photons_per_pass": photons, "skipping": skipping });
        let plain = measure(scene, truth, &parameters(1), 1)?;
        let skipped = measure(scene, truth, &parameters(4), 1)?;
        print_pair(photons, &plain, &skipped, theirs, [one, sixteen]);
        ratios.add(&plain, &skipped, [one, sixteen]);
        pictures.get_or_insert((plain.picture, skipped.picture));
    }
    ratios.print("Skipping against one map");
    if let Some((plain, skipped)) = pictures {
        show(&plain, "many-maps-one", &format!("one map of {} photons", PHOTONS[0]))?;
        show(&skipped, "many-maps-skipping", "16 such maps, each pixel looks at one")?;
    }
    Ok(())
}

fn print_pair(photons: u32, left: &Row, right: &Row, theirs: &str, errors: [f64; 2]) {
    println!(
        "| {photons} | {:.4} | {:.4} | {:.2} | {:.4} | {:.4} | {:.2} | {theirs} | {} | {} |",
        left.error, left.low, left.seconds, right.error, right.low, right.seconds, errors[0], errors[1]
    );
}

const CLAIM: &str = "\
Claims: photons in m maps, every estimate the mean of the m, are as good as the same photons in one map, and slower to look up; of use is only that maps may be used in
turn. Four samples of a pixel from four maps have two thirds of the error of four from one map, at the cost of three more random walks. With *skipping* neighbors
look at different maps: the error is the same, but it is noise of high frequency in place of low frequency, which people mind less.

`photon_map` has `maps`, `camera_paths` and `skipping`; maps in turn are its passes. SCENE6, 129 pixels wide, without final gather and so with sampled direct light,
which the thesis had in the photons. Errors are root mean squares relative to the mean radiance, of three pictures each; *low* is the same of means over
8 × 8 pixels. Photons are a tenth of the thesis'.
";

const DIVIDED_NOTE: &str = "
Their column of photons is not legible in our copy; its times say that k grew with the photons in one map, as it does here, so that discs stay the same.
";

/// Ratios of errors, right over left, with one for each row.
#[derive(Default)]
pub(crate) struct Ratios {
    error: Vec<f64>,
    low: Vec<f64>,
    theirs: Vec<f64>,
}

impl Ratios {
    pub(crate) fn add(&mut self, left: &Row, right: &Row, theirs: [f64; 2]) {
        self.error.push(right.error / left.error);
        self.low.push(right.low / left.low);
        self.theirs.push(theirs[1] / theirs[0]);
    }

    /// Geometric means, with what they are of.
    pub(crate) fn print(&self, what: &str) {
        let mean = |ratios: &[f64]| (ratios.iter().map(|ratio| ratio.ln()).sum::<f64>() / ratios.len() as f64).exp();
        let [error, low, theirs] = [&self.error, &self.low, &self.theirs].map(|ratios| mean(ratios));
        println!(
            "\n{what}: error × {error:.2} on average, low frequencies × {low:.2}; in the thesis error × {theirs:.2}.\n"
        );
    }
}

const VERDICT: &str = "
The first claim holds exactly. So does the second, the less the more photons a map has: then the noise of sampled direct light is left, which four samples of one map average as well. Skipping
does what it should: the same error with a third less of low frequencies, and the less is won the denser the maps; it costs sixteen maps a pass.";
