//! Compiles the workers' protocol and stamps the build, so that only equal builds work on one picture.

use std::collections::hash_map::DefaultHasher;
use std::error::Error;
use std::fs;
use std::hash::{Hash, Hasher};
use std::path::{Path, PathBuf};

const PROTOCOL: [&str; 4] = ["worker", "lease", "result", "radius"];

fn main() -> Result<(), Box<dyn Error>> {
    let files = PROTOCOL.map(|name| format!("proto/photonfarm/v1/{name}.proto"));
    let descriptors = protox::compile(files, ["proto"])?;
    prost_build::Config::new().bytes(["."]).compile_fds(descriptors)?;
    println!("cargo:rustc-env=PHOTONFARM_BUILD={:016x}", source_hash()?);
    for watched in ["build.rs", "proto", "src", "Cargo.lock"] {
        println!("cargo:rerun-if-changed={watched}");
    }
    Ok(())
}

/// A hash of everything that decides what the program computes.
fn source_hash() -> Result<u64, Box<dyn Error>> {
    let mut files = vec![PathBuf::from("Cargo.lock")];
    for folder in ["src", "proto"] {
        list_files(Path::new(folder), &mut files)?;
    }
    files.sort();
    let mut hasher = DefaultHasher::new();
    for file in files {
        file.hash(&mut hasher);
        fs::read(&file)?.hash(&mut hasher);
    }
    for setting in ["TARGET", "OPT_LEVEL", "CARGO_CFG_TARGET_FEATURE"] {
        std::env::var(setting).unwrap_or_default().hash(&mut hasher);
    }
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
