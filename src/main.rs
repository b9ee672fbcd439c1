//! The `photonfarm` program; see [`photonfarm::cli`].

fn main() -> std::process::ExitCode {
    photonfarm::cli::main()
}
