//! Feeds damaged scenes to every importer, and says where one panics, takes long or takes much memory.
//!
//! `cargo run --release --example fuzz_importers -- --seconds 60 [FORMAT …]`
//!
//! Each case is a scene of the corpus with a few edits (`mutation.rs`), chosen by the number of the case alone. It is read,
//! written in the native form and prepared, on a stack as small as that of a service's threads. Formats: xml, json, zip, files
//! (meshes, images and luminaires of an XML scene), old_xml, gltf, glb, mgf, pbrt, ceng795; all of them by default.
//!
//! What fails is saved as an ordinary scene file in `target/fuzz`: `--replay FILE` runs it again, as does `photonfarm scene
//! check`. A case that ends the whole process (a full stack, more than 4 GiB) is the one whose format and number stand in
//! `target/fuzz/running`: `--first NUMBER --cases 1 FORMAT` runs that one again, and `--save` saves it.

mod corpus;
mod memory;
mod mutation;

use std::error::Error;
use std::fs;
use std::panic::{AssertUnwindSafe, catch_unwind};
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicU64, Ordering};
use std::time::{Duration, Instant};

use clap::Parser;
use corpus::{Format, Sample};
use photonfarm::import::{load_bytes, native};
use photonfarm::scene::Scene;

/// A case that takes longer is reported.
const SLOW: Duration = Duration::from_secs(2);
/// A case that takes longer ends the process.
const ENDLESS: Duration = Duration::from_secs(30);
/// The most memory that a case may have at once, bytes.
const MOST_MEMORY: usize = 1 << 30;
/// The largest meshes that an importer may have made for a scene to be prepared, bytes.
const MOST_GENERATED: usize = 4 << 20;
/// The stack of a case, bytes: that of Rust's threads, the main one excepted.
const STACK: usize = 2 << 20;
const FOLDER: &str = "target/fuzz";

/// Feed damaged scenes to the importers.
#[derive(Parser)]
struct Arguments {
    /// Seconds for each format
    #[arg(long, default_value_t = 60.0)]
    seconds: f64,
    /// The number of the first case
    #[arg(long, default_value_t = 0)]
    first: u64,
    /// Stop after this many cases of each format
    #[arg(long, default_value_t = u64::MAX)]
    cases: u64,
    /// Save every case before it runs
    #[arg(long)]
    save: bool,
    /// Run this file instead
    #[arg(long)]
    replay: Option<PathBuf>,
    /// Formats; all when none is given
    formats: Vec<String>,
}

fn main() -> Result<(), Box<dyn Error>> {
    let arguments = Arguments::parse();
    let run = move || run(&arguments).map_err(|error| error.to_string());
    let thread = std::thread::Builder::new().stack_size(STACK).spawn(run)?;
    match thread.join().unwrap_or_else(|_| Err("the fuzzer itself failed".to_owned()))? {
        0 => Ok(()),
        failures => Err(format!("{failures} cases failed; they are in {FOLDER}").into()),
    }
}

/// How many cases failed.
fn run(arguments: &Arguments) -> Result<u32, Box<dyn Error>> {
    let began = watch();
    if let Some(path) = &arguments.replay {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        let verdict = judge(&name, &fs::read(path)?, &began);
        println!("{}", verdict.as_ref().err().map_or("nothing is wrong", String::as_str));
        return Ok(u32::from(verdict.is_err()));
    }
    // Panics are reported with their case.
    std::panic::set_hook(Box::new(|_| {}));
    fs::create_dir_all(FOLDER)?;
    let formats = corpus::formats()?;
    if let Some(unknown) = arguments.formats.iter().find(|name| formats.iter().all(|format| format.name != **name)) {
        let known: Vec<&str> = formats.iter().map(|format| format.name).collect();
        return Err(format!("there is no format {unknown}: give some of {}", known.join(", ")).into());
    }
    let chosen =
        |format: &&Format| arguments.formats.is_empty() || arguments.formats.iter().any(|name| name == format.name);
    formats.iter().filter(chosen).map(|format| fuzz(format, arguments, &began)).sum()
}

/// Runs the cases of a format, and tells how many failed.
fn fuzz(format: &Format, arguments: &Arguments, began: &AtomicU64) -> Result<u32, Box<dyn Error>> {
    for sample in &format.samples {
        let (name, bytes) = sample.file()?;
        let scene = load_bytes(&name, &bytes, &[]).and_then(|scene| Scene::prepare(&scene));
        scene.map_err(|error| format!("the corpus itself: {error}"))?;
    }
    let start = Instant::now();
    let (mut number, mut failures, mut accepted) = (arguments.first, 0, 0_u64);
    while start.elapsed().as_secs_f64() < arguments.seconds && number - arguments.first < arguments.cases {
        fs::write(Path::new(FOLDER).join("running"), format!("{} {number}\n", format.name))?;
        let (name, bytes) = mutation::mutate(format, number).file()?;
        let place = Path::new(FOLDER).join(format!("{}-{number}-{name}", format.name));
        if arguments.save {
            fs::write(&place, &bytes)?;
        }
        match judge(&name, &bytes, began) {
            Ok(read) => accepted += u64::from(read),
            Err(verdict) => {
                failures += 1;
                fs::write(&place, &bytes)?;
                println!("{}: {verdict}", place.display());
            }
        }
        number += 1;
    }
    let (cases, seconds) = (number - arguments.first, start.elapsed().as_secs_f64());
    println!(
        "{}: {cases} cases, {:.0} per second, {accepted} still good, {failures} failed",
        format.name,
        cases as f64 / seconds
    );
    Ok(failures)
}

/// Whether a case is still a scene, or what is wrong with how it was treated.
fn judge(name: &str, bytes: &[u8], began: &AtomicU64) -> Result<bool, String> {
    let before = memory::begin();
    let start = worked();
    began.store(now_ms(), Ordering::Relaxed);
    let outcome = catch_unwind(AssertUnwindSafe(|| import(name, bytes)));
    began.store(u64::MAX, Ordering::Relaxed);
    let (time, memory) = (worked().saturating_sub(start), memory::peak() - before);
    let read = outcome.map_err(|panic| {
        let text = panic.downcast_ref::<String>().map(String::as_str).or_else(|| panic.downcast_ref::<&str>().copied());
        format!("panics: {}", text.unwrap_or("without a message"))
    })?;
    match time > SLOW || memory > MOST_MEMORY {
        true => Err(format!("takes {:.1} s and {} MiB", time.as_secs_f64(), memory >> 20)),
        false => Ok(read),
    }
}

/// The time that this thread has worked, so that other programs do not count; the time that has passed where the system does
/// not tell.
fn worked() -> Duration {
    let text = fs::read_to_string("/proc/thread-self/schedstat").unwrap_or_default();
    let nanoseconds = text.split_whitespace().next().and_then(|number| number.parse().ok());
    nanoseconds.map_or_else(|| Duration::from_millis(now_ms()), Duration::from_nanos)
}

/// Does everything that is done to a scene before it is rendered, and tells whether it can be. Many triangles, of which a
/// short file can make millions, rightly take their time, so that scenes with such meshes are not prepared.
fn import(name: &str, bytes: &[u8]) -> bool {
    let Ok(scene) = load_bytes(name, bytes, &[]) else { return false };
    drop(native::to_json(&scene));
    let generated: usize = scene.bundle.generated().map_or(0, |made| {
        made.files.values().map(|content| content.len()).sum::<usize>()
            + made.meshes.values().map(|mesh| mesh.size()).sum::<usize>()
    });
    generated > MOST_GENERATED || Scene::prepare(&scene).is_ok()
}

/// Milliseconds since the process began.
fn now_ms() -> u64 {
    static START: std::sync::OnceLock<Instant> = std::sync::OnceLock::new();
    START.get_or_init(Instant::now).elapsed().as_millis() as u64
}

/// Watches over the cases: when the one that is running began, `u64::MAX` between them.
fn watch() -> Arc<AtomicU64> {
    let began = Arc::new(AtomicU64::new(u64::MAX));
    let watched = began.clone();
    std::thread::spawn(move || {
        loop {
            std::thread::sleep(Duration::from_millis(200));
            if now_ms().saturating_sub(watched.load(Ordering::Relaxed)) > ENDLESS.as_millis() as u64 {
                let running = fs::read_to_string(Path::new(FOLDER).join("running")).unwrap_or_default();
                eprintln!("the running case takes more than {} s: {}", ENDLESS.as_secs(), running.trim());
                std::process::exit(1);
            }
        }
    });
    began
}

impl Sample {
    /// The sample as one file: alone, or in an archive with what it refers to.
    fn file(&self) -> Result<(String, Vec<u8>), Box<dyn Error>> {
        use std::io::Write as _;
        if let [(name, content)] = self.files.as_slice() {
            return Ok((name.clone(), content.clone()));
        }
        let mut archive = zip::ZipWriter::new(std::io::Cursor::new(Vec::new()));
        let stored = zip::write::SimpleFileOptions::default().compression_method(zip::CompressionMethod::Stored);
        for (name, content) in &self.files {
            archive.start_file(name.as_str(), stored)?;
            archive.write_all(content)?;
        }
        Ok(("scene.zip".to_owned(), archive.finish()?.into_inner()))
    }
}
