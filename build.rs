//! Compiles the workers' protocol and stamps the build, so that only equal builds work on one picture.

use std::collections::hash_map::DefaultHasher;
use std::error::Error;
use std::fs;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;

const PROTOCOL: [&str; 4] = ["worker", "lease", "result", "radius"];

fn main() -> Result<(), Box<dyn Error>> {
    let files = PROTOCOL.map(|name| format!("proto/photonfarm/v1/{name}.proto"));
    let descriptors = protox::compile(files, ["proto"])?;
    prost_build::Config::new().bytes(["."]).compile_fds(descriptors)?;
    println!("cargo:rustc-env=PHOTONFARM_BUILD={:016x}", source_hash()?);
    for watched in FILES.iter().chain(&FOLDERS) {
        println!("cargo:rerun-if-changed={watched}");
    }
    Ok(())
}

/// Files that decide what the program computes: Cargo.toml holds the profiles, config.toml the target.
const FILES: [&str; 4] = ["build.rs", "Cargo.toml", "Cargo.lock", ".cargo/config.toml"];
/// Folders that do.
const FOLDERS: [&str; 2] = ["src", "proto"];
/// Settings of the build that do.
const SETTINGS: [&str; 6] =
    ["TARGET", "PROFILE", "OPT_LEVEL", "DEBUG", "CARGO_CFG_TARGET_FEATURE", "CARGO_ENCODED_RUSTFLAGS"];

/// A hash of everything that decides what the program computes.
fn source_hash() -> Result<u64, Box<dyn Error>> {
    let mut files: Vec<PathBuf> = FILES.iter().map(PathBuf::from).collect();
    for folder in FOLDERS {
        list_files(Path::new(folder), &mut files)?;
    }
    files.sort();
    let mut hasher = DefaultHasher::new();
    for file in files {
        file.hash(&mut hasher);
        fs::read(&file)?.hash(&mut hasher);
    }
    for setting in SETTINGS {
        std::env::var(setting).unwrap_or_default().hash(&mut hasher);
    }
    let compiler = Command::new(std::env::var("RUSTC")?).arg("-vV").output()?;
    compiler.stdout.hash(&mut hasher);
    Ok(hasher.finish())
}

fn list_files(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), Box<dyn Error>> {
    for entry in fs::read_dir(folder)? {
        let path = entry?.path();
        if path.is_dir() {
            list_files(&path, files)?;
        } else {
            files.push(path);
        }
    }
    Ok(())
}
