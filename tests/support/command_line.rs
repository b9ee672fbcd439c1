//! The program, started as its users start it.

use std::path::Path;
use std::process::{Command, Output, Stdio};

/// The program with `arguments`, without standard input and with no coordinator named by the environment.
pub(crate) fn program(arguments: &[&str]) -> Command {
    let mut command = Command::new(env!("CARGO_BIN_EXE_photonfarm"));
    command.args(arguments).env_remove("PHOTONFARM_URL").env_remove("PHOTONFARM_TOKEN").stdin(Stdio::null());
    command
}

/// What a run printed, and its exit code.
pub(crate) fn run(arguments: &[&str]) -> Output {
    program(arguments).output().expect("the program starts")
}

/// Standard error of a run that ended with `code`.
pub(crate) fn ended(output: &Output, code: i32) -> String {
    let stderr = String::from_utf8_lossy(&output.stderr).into_owned();
    assert_eq!(output.status.code(), Some(code), "{stderr}");
    stderr
}

/// Standard error of a run that must succeed.
pub(crate) fn success(arguments: &[&str]) -> String {
    ended(&run(arguments), 0)
}

/// Standard error of a run that must fail with `code`.
pub(crate) fn failure(arguments: &[&str], code: i32) -> String {
    ended(&run(arguments), code)
}

/// A path as an argument.
pub(crate) fn text(path: &Path) -> &str {
    path.to_str().expect("UTF-8")
}
