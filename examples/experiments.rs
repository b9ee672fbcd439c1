//! The experiments of the thesis on bidirectional photon mapping [Vorba 2011, chapters 2 and 4], on scenes of our own: pictures
//! under `docs/measured/pictures/experiments` and the tables of `docs/measured/EXPERIMENTS.md` on standard output.
//!
//! `cargo run --release --example experiments -- 60` gives each equal-time picture 60 processor-seconds; all together take about
//! 30 minutes on two cores.

use std::error::Error;
use std::fs;
use std::path::Path;
use std::sync::Arc;

use photonfarm::estimate::Picture;
use photonfarm::estimate::picture_files::encode_png;
use photonfarm::evaluation::{self, ProcessStopwatch, Reference, Run, Stopwatch, compare, signed_difference};
use photonfarm::import;
use photonfarm::method::{self, MethodChoice};
use photonfarm::scene::Scene;
use serde_json::{Map, Value, json};

const PICTURES: &str = "docs/measured/pictures/experiments";

type Outcome<T> = Result<T, Box<dyn Error>>;

/// When a render ends.
#[derive(Clone, Copy)]
enum Until {
    Passes(u32),
    /// Processor-seconds.
    Seconds(f64),
}

fn main() -> Outcome<()> {
    let seconds: f64 =
        std::env::args().nth(1).ok_or("say how many processor-seconds a picture takes, for example 60")?.parse()?;
    fs::create_dir_all(PICTURES)?;
    strategies()?;
    weight_maps()?;
    differences()?;
    equal_time("kitchen-counter", &["path", "photon_map", "bdpm", "sppm", "pbdpm", "vcm"], seconds)?;
    equal_time("concert-hall", &["path", "sppm", "pbdpm", "vcm"], seconds)?;
    time_shares()
}

fn scene(name: &str, size: u32) -> Outcome<Arc<Scene>> {
    let file = Path::new("scenes").join(name).join("scene.xml");
    let description = import::load_file(&file, &[("size".to_owned(), size.to_string())])?;
    Ok(Arc::new(Scene::prepare(&description)?))
}

/// Renders with JSON parameters; also the passes it took.
fn render(scene: &Arc<Scene>, method: &str, parameters: &Value, until: Until) -> Outcome<(Picture, u32)> {
    let parameters = parameters.as_object().cloned().unwrap_or_else(Map::new);
    let choice = MethodChoice { name: method.to_owned(), parameters };
    let checked = method::check(&choice, scene.pixel_count() as u64)?;
    let mut stopwatch = ProcessStopwatch::start()?;
    let mut run = Run::start(scene, &checked, 1)?;
    let goes_on = |passes: u32, stopwatch: &mut ProcessStopwatch| -> Outcome<bool> {
        Ok(match until {
            Until::Passes(wanted) => passes < wanted,
            Until::Seconds(wanted) => stopwatch.spent()?.processor < wanted,
        })
    };
    while goes_on(run.passes(), &mut stopwatch)? {
        run.pass()?;
    }
    Ok((run.picture(), run.passes()))
}

/// Writes pictures of one height side by side.
fn write_row(name: &str, pictures: &[Picture], exposure: f32) -> Outcome<()> {
    let height = pictures.iter().map(|picture| picture.height).max().unwrap_or(0);
    let mut radiance = Vec::new();
    for row in 0..height as usize {
        for picture in pictures {
            let width = picture.width as usize;
            radiance.extend_from_slice(&picture.radiance[row * width..(row + 1) * width]);
        }
    }
    let width = pictures.iter().map(|picture| picture.width).sum();
    let file = encode_png(&Picture { width, height, radiance }, exposure)?;
    fs::write(Path::new(PICTURES).join(name), file)?;
    Ok(())
}

/// Figures 2.1 and 4.5: paths of three segments, gathered at the first vertex, at the second, and by both.
fn strategies() -> Outcome<()> {
    let scene = scene("cornell-ward", 256)?;
    let alone = |strategy: &str| json!({"length": 3, "strategy": strategy, "show": "unweighted", "camera_hits": "off", "light_hits": "off"});
    let both = json!({"length": 3, "camera_hits": "off", "light_hits": "off"});
    let pictures = [alone("2,1"), alone("1,2"), both]
        .iter()
        .map(|parameters| Ok(render(&scene, "pbdpm", parameters, Until::Passes(64))?.0))
        .collect::<Outcome<Vec<_>>>()?;
    write_row("strategies.png", &pictures, 0.0)
}

/// Figures 4.6 and 4.7: mean weights of the strategies that find paths of four segments, on a scale from blue over white to red.
fn weight_maps() -> Outcome<()> {
    let scene = scene("cornell-ward", 256)?;
    let mut row = vec![scale(24, scene.height)];
    println!("\n| photons gathered after | mean weight |\n|---|---:|");
    for strategy in ["3,1", "2,2", "1,3"] {
        let parameters =
            json!({"length": 4, "strategy": strategy, "show": "weights", "camera_hits": "off", "light_hits": "off"});
        let (found, _) = render(&scene, "pbdpm", &parameters, Until::Passes(64))?;
        let weights =
            found.radiance.iter().map(|[weight, count, _]| if *count > 0.0 { weight / count } else { f32::NAN });
        let known: Vec<f32> = weights.clone().filter(|weight| weight.is_finite()).collect();
        let mean = known.iter().sum::<f32>() / known.len().max(1) as f32;
        println!("| {} camera segments | {mean:.3} |", &strategy[2..]);
        row.push(Picture { radiance: weights.map(false_color).collect(), ..found });
    }
    write_row("weights.png", &row, 0.0)
}

/// Blue at 0, white at 0.5, red at 1; black where nothing was found.
fn false_color(weight: f32) -> [f32; 3] {
    let (low, high) = ((2.0 * weight).min(1.0), (2.0 - 2.0 * weight).min(1.0));
    if weight.is_nan() { [0.0; 3] } else { [low, low.min(high), high] }
}

/// The scale of [`false_color`], 1 at the top.
fn scale(width: u32, height: u32) -> Picture {
    let color = |row: u32| false_color(1.0 - (row as f32 + 0.5) / height as f32);
    let radiance = (0..height).flat_map(|row| vec![color(row); width as usize]).collect();
    Picture { width, height, radiance }
}

/// Figures 4.8 and 4.9: signed differences to a converged picture by another renderer.
fn differences() -> Outcome<()> {
    let Reference { scene, picture: reference, .. } =
        Reference::load(Path::new("tests/references/glossy-blocks-a010"))?;
    let paper = json!({"weights": "paper", "light_hits": "off", "camera_hits": "off"});
    let consistent = json!({"light_hits": "off", "camera_hits": "off"});
    let jobs = [
        ("bdpm", "paper", &paper),
        ("pbdpm", "paper", &paper),
        ("bdpm", "consistent", &consistent),
        ("pbdpm", "consistent", &consistent),
        ("sppm", "", &Value::Null),
    ];
    let mut row = Vec::new();
    println!("\n| method | weights | passes | mean bias | worst 8×8 block | relMSE |\n|---|---|---:|---:|---:|---:|");
    for (method, weights, parameters) in jobs {
        for passes in [64, 256] {
            let (picture, _) = render(&scene, method, parameters, Until::Passes(passes))?;
            let metrics = compare(&picture, &reference, None)?;
            let (bias, block) = (100.0 * metrics.bias, 100.0 * metrics.block_bias_max);
            println!("| {method} | {weights} | {passes} | {bias:+.2} % | {block:.1} % | {:.5} |", metrics.relmse);
            if passes == 256 {
                row.push(signed_difference(&picture, &reference, 0.2));
            }
        }
    }
    write_row("differences.png", &row, 0.0)
}

/// Figures 4.2, 4.3 and 4.10: the same processor time for each method, beside a longer render.
fn equal_time(name: &str, methods: &[&str], seconds: f64) -> Outcome<()> {
    let scene = scene(name, 256)?;
    let longest = json!({"max_depth": 7});
    let (reference, passes) = render(&scene, "vcm", &longest, Until::Seconds(8.0 * seconds))?;
    println!("\n{name}, beside {passes} passes of `vcm`:\n\n| method | passes | relMSE | mean |\n|---|---:|---:|---:|");
    let mut row = Vec::new();
    for method in methods {
        let (picture, passes) = render(&scene, method, &longest, Until::Seconds(seconds))?;
        let metrics = compare(&picture, &reference, None)?;
        println!("| {method} | {passes} | {:.4} | {:+.2} % |", metrics.relmse_trimmed, 100.0 * metrics.bias);
        row.push(picture);
    }
    row.push(reference);
    write_row(&format!("{name}.png"), &row, 0.0)
}

/// Table 4.11: what a pass costs without weights, and without density estimates at all.
fn time_shares() -> Outcome<()> {
    println!("\n| scene | density estimates | weights, in them | a pass |\n|---|---:|---:|---:|");
    for name in ["kitchen-counter", "cornell-ward", "concert-hall"] {
        let scene = scene(name, 256)?;
        let parameters = json!({"max_depth": 7, "light_hits": "off", "camera_hits": "off"});
        let parameters = parameters.as_object().cloned().unwrap_or_default();
        let choice = MethodChoice { name: "bdpm".to_owned(), parameters };
        let shares = evaluation::time_shares(&scene, &choice, 1, &mut ProcessStopwatch::start()?)?;
        let percent = |share: Option<f64>| 100.0 * share.unwrap_or(0.0);
        let (estimates, weights) = (percent(shares.density_estimates), percent(shares.weights));
        println!("| {name} | {estimates:.0} % | {weights:.0} % | {:.2} s |", shares.pass);
    }
    Ok(())
}
