//! The commands of README.md: its blocks of shell code run in order, and make what they name.
//!
//! They run as they stand, but for what would take long or reach beyond the test: fewer passes and pixels, one thread, a port and a data folder of
//! the test's own, and the program that is tested in place of `cargo run --release --`.

use std::fs;
use std::net::TcpListener;
use std::os::unix::fs::symlink;
use std::path::Path;
use std::process::{Command, Output};

/// By what passes are divided: those of renders, and those of jobs over HTTP, whose pictures keep their size.
const FEWER: [(&str, u32); 2] = [("--passes ", 8), ("\"passes\": ", 32)];
/// Passes of a render that names none.
const PASSES: u32 = 4;

/// Pixels on a side of a picture whose size is not given.
const SIZE: u32 = 128;

/// What stands before the blocks: every failure ends the script, `curl` fails when it is refused, and what was started ends with it.
const BEFORE: &str = r#"
set -euo pipefail
trap 'kill $(jobs -p) 2> /dev/null || true; wait' EXIT
curl() { command curl --silent --show-error --fail-with-body --retry 20 --retry-connrefused --retry-delay 1 "$@"; }
"#;

/// The blocks of README.md that are shell code.
fn blocks() -> Vec<String> {
    let readme = fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join("README.md")).expect("README.md");
    let fenced = readme.split("```").skip(1).step_by(2);
    fenced.filter_map(|block| block.strip_prefix("sh\n")).map(str::to_owned).collect()
}

/// A block as the test runs it.
fn substituted(block: &str, port: u16) -> String {
    let program = block.replace("cargo run --release --", "photonfarm");
    let mut lines = Vec::new();
    for line in program.replace("127.0.0.1:8080", &format!("127.0.0.1:{port}")).lines() {
        let mut line = with_fewer_passes(line);
        if line.starts_with("photonfarm render") {
            line = line.replace(" --workers 2", " --workers 1") + " --threads 1";
            if !line.contains("--passes") {
                line += &format!(" --passes {PASSES}");
            }
            if !line.contains("size") {
                line += &format!(" --size {SIZE}");
            }
        }
        if line.starts_with("photonfarm serve") {
            // Its reader would type the next command into another terminal.
            line += &format!(" --listen 127.0.0.1:{port} --data data &");
        }
        lines.push(line);
    }
    lines.join("\n")
}

/// `--passes 16` and `"passes": 256` with fewer of them.
fn with_fewer_passes(line: &str) -> String {
    let mut line = line.to_owned();
    for (before, fewer) in FEWER {
        if let Some((head, tail)) = line.split_once(before) {
            let end = tail.find(|sign: char| !sign.is_ascii_digit()).unwrap_or(tail.len());
            let passes: u32 = tail[..end].parse().expect("a number of passes");
            line = format!("{head}{before}{}{}", passes / fewer, &tail[end..]);
        }
    }
    line
}

/// Files that a block says it writes.
fn named_outputs(block: &str) -> Vec<&str> {
    let words: Vec<&str> = block.split_whitespace().collect();
    let options = ["-o", "--weight-maps", "--difference"];
    words.windows(2).filter(|pair| options.contains(&pair[0])).map(|pair| pair[1]).collect()
}

fn run(folder: &Path, script: &str) -> Output {
    let search = std::env::var("PATH").unwrap_or_default();
    let mut command = Command::new("bash");
    command.args(["-c", script]).current_dir(folder).env_remove("PHOTONFARM_URL").env_remove("PHOTONFARM_TOKEN");
    command.env("PATH", format!("{}:{search}", folder.join("bin").display())).output().expect("bash starts")
}

#[test]
fn its_commands_run_and_make_what_they_name() {
    let folder = tempfile::tempdir().expect("a folder");
    let folder = folder.path();
    let port = TcpListener::bind("127.0.0.1:0").and_then(|listener| listener.local_addr()).expect("a port").port();
    fs::create_dir(folder.join("bin")).expect("creates");
    symlink(env!("CARGO_BIN_EXE_photonfarm"), folder.join("bin/photonfarm")).expect("links");
    symlink(Path::new(env!("CARGO_MANIFEST_DIR")).join("scenes"), folder.join("scenes")).expect("links");
    let blocks = blocks();
    assert!(blocks.len() >= 10, "only {} blocks of shell code were found", blocks.len());
    let mut script = BEFORE.to_owned();
    for block in &blocks {
        script += &format!("{}\n", substituted(block, port));
        for output in named_outputs(block) {
            script +=
                &format!("test -s {output} || {{ echo 'README.md names {output}, which is not there' >&2; false; }}\n");
        }
    }
    let output = run(folder, &script);
    let (told, printed) = (String::from_utf8_lossy(&output.stderr), String::from_utf8_lossy(&output.stdout));
    assert!(output.status.success(), "{script}\n{printed}\n{told}");
    let is_like = |name: &str, magic: &[u8]| fs::read(folder.join(name)).expect(name).starts_with(magic);
    for (name, magic) in
        [("now.png", b"\x89PNG".as_slice()), ("now.jpg", b"\xff\xd8"), ("now.exr", b"\x76\x2f\x31\x01")]
    {
        assert!(is_like(name, magic), "{name} is another kind of file");
    }
    assert!(is_like("cornell-glass-mirror.png", b"\x89PNG"), "the first render writes what the page says");
    assert!(printed.contains("\"state\":\"done\""), "the job ends before its picture is fetched: {printed}");
}
