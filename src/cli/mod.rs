//! The command line: one file per subcommand. Results go to standard output, everything else to standard error.

mod cancel;
mod change;
mod chart;
mod client;
mod clone;
mod compare;
mod evaluate;
mod exit_code;
mod extend;
mod farm_options;
mod fetch;
mod frames;
mod health;
mod import;
mod job_options;
mod jobs;
mod journal;
mod log_option;
mod map;
mod methods;
mod named;
mod one_job;
mod outputs;
mod pause;
mod plan;
mod preview;
mod processor;
mod progress;
mod provider_options;
mod render;
mod resume;
mod rm;
mod scene;
mod scene_file;
mod scene_input;
mod scene_options;
mod scenes;
mod sequences;
mod serve;
mod shell;
mod signals;
mod stop_options;
mod store;
mod store_options;
mod submit;
mod terminal;
mod tev;
mod tls_options;
mod token;
mod token_option;
mod top;
mod trust_options;
mod user;
mod watch;
mod weight_maps;
mod worker;
mod workers;

use std::future::Future;
use std::io::IsTerminal;
use std::process::ExitCode;

use clap::{Parser, Subcommand};
use tracing::level_filters::LevelFilter;
use tracing_subscriber::Layer;
use tracing_subscriber::filter::Targets;
use tracing_subscriber::layer::SubscriberExt;
use tracing_subscriber::util::SubscriberInitExt;

use exit_code::{CliError, EXIT_CODES};
use log_option::LogForm;

use crate::farm::EVENTS;
use crate::farm::wire::BUILD;

/// One photon-mapped picture on many machines.
#[derive(Debug, Parser)]
#[command(name = "photonfarm", version = BUILD, after_help = EXIT_CODES, subcommand_required = true, arg_required_else_help = true)]
struct CommandLine {
    /// Log more to standard error; twice for still more.
    #[arg(short, long, global = true, action = clap::ArgAction::Count)]
    verbose: u8,
    /// Say nothing on standard error but errors.
    #[arg(short, long, global = true, conflicts_with = "verbose")]
    quiet: bool,
    #[command(subcommand)]
    command: Command,
}

#[derive(Debug, Subcommand)]
enum Command {
    Render(render::Render),
    Serve(serve::Serve),
    Worker(worker::Worker),
    Submit(submit::Submit),
    Watch(watch::Watch),
    Fetch(fetch::Fetch),
    Cancel(cancel::Cancel),
    Pause(pause::Pause),
    Resume(resume::Resume),
    Extend(extend::Extend),
    Clone(clone::CloneJob),
    Change(change::Change),
    Rm(rm::Remove),
    Jobs(jobs::Jobs),
    Sequences(sequences::Sequences),
    Scenes(scenes::Scenes),
    Workers(workers::Workers),
    Journal(journal::Journal),
    Top(top::Top),
    Health(health::Health),
    Store(store::Store),
    User(user::User),
    Token(token::Token),
    Methods(methods::Methods),
    Import(import::Import),
    Scene(scene::Scene),
    Plan(plan::Plan),
    Compare(compare::Compare),
    Evaluate(evaluate::Evaluate),
    Chart(chart::Chart),
    Map(map::Map),
    Completions(shell::Completions),
    Manual(shell::Manual),
}

/// Reads the command line, does what it says and tells the exit code.
pub fn main() -> ExitCode {
    if let Err(missing) = processor::check() {
        terminal::error(&format!("photonfarm: {missing}"));
        return ExitCode::FAILURE;
    }
    let command_line = CommandLine::parse();
    let farm_log = match &command_line.command {
        Command::Serve(serve) => Some(serve.log.log),
        Command::Worker(worker) => Some(worker.log.log),
        _ => None,
    };
    if command_line.quiet {
        terminal::be_quiet();
    }
    start_log(command_line.verbose, farm_log);
    match run(command_line.command) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            terminal::error(&format!("photonfarm: {error}"));
            error.exit_code()
        }
    }
}

fn run(command: Command) -> Result<(), CliError> {
    match command {
        Command::Render(command) => in_runtime(command.run()),
        Command::Serve(command) => in_runtime(command.run()),
        Command::Worker(command) => in_runtime(command.run()),
        Command::Submit(command) => in_runtime(command.run()),
        Command::Watch(command) => in_runtime(command.run()),
        Command::Fetch(command) => in_runtime(command.run()),
        Command::Cancel(command) => in_runtime(command.run()),
        Command::Pause(command) => in_runtime(command.run()),
        Command::Resume(command) => in_runtime(command.run()),
        Command::Extend(command) => in_runtime(command.run()),
        Command::Clone(command) => in_runtime(command.run()),
        Command::Change(command) => in_runtime(command.run()),
        Command::Rm(command) => in_runtime(command.run()),
        Command::Jobs(command) => in_runtime(command.run()),
        Command::Sequences(command) => in_runtime(command.run()),
        Command::Scenes(command) => in_runtime(command.run()),
        Command::Workers(command) => in_runtime(command.run()),
        Command::Journal(command) => in_runtime(command.run()),
        Command::Top(command) => in_runtime(command.run()),
        Command::Health(command) => in_runtime(command.run()),
        Command::Store(command) => in_runtime(command.run()),
        Command::User(command) => in_runtime(command.run()),
        Command::Token(command) => in_runtime(command.run()),
        Command::Methods(command) => command.run(),
        Command::Import(command) => command.run(),
        Command::Scene(command) => command.run(),
        Command::Plan(command) => command.run(),
        Command::Compare(command) => command.run(),
        Command::Evaluate(command) => command.run(),
        Command::Chart(command) => command.run(),
        Command::Map(command) => command.run(),
        Command::Completions(command) => command.run(),
        Command::Manual(command) => command.run(),
    }
}

fn in_runtime(command: impl Future<Output = Result<(), CliError>>) -> Result<(), CliError> {
    let runtime = tokio::runtime::Builder::new_multi_thread().enable_all().build();
    let runtime = runtime.map_err(|error| CliError::Failed(format!("cannot start the runtime: {error}")))?;
    let result = runtime.block_on(command);
    // A shard that is being traced must not hold up the end.
    runtime.shutdown_background();
    result
}

fn start_log(verbose: u8, farm_log: Option<LogForm>) {
    let level = match verbose {
        _ if terminal::is_quiet() => LevelFilter::ERROR,
        0 => LevelFilter::WARN,
        1 => LevelFilter::INFO,
        2 => LevelFilter::DEBUG,
        _ => LevelFilter::TRACE,
    };
    // Who joins, leaves or dies is for everybody who runs a farm.
    let is_told = farm_log.is_some() && !terminal::is_quiet();
    let events = if is_told { level.max(LevelFilter::INFO) } else { level };
    let filter = Targets::new().with_default(level).with_target(EVENTS, events);
    let lines = tracing_subscriber::fmt::layer().with_writer(std::io::stderr).log_internal_errors(false);
    let lines = match farm_log.unwrap_or_default() {
        LogForm::Text => lines.with_ansi(std::io::stderr().is_terminal()).with_target(false).boxed(),
        LogForm::Json => {
            terminal::log_notes();
            lines.json().flatten_event(true).boxed()
        }
    };
    tracing_subscriber::registry().with(lines.with_filter(filter)).init();
}
