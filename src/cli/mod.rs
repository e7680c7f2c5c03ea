//! The command line: `play`, `shoot`, `judge`, `bench`, `pop`, `plot`, `forge`, `list`.
//!
//! Exit codes: 0 done; 1 could not do it, with one sentence on stderr; 2 wrong arguments. Pictures and tables are the
//! result: what goes to stdout is one line per result, everything else goes to stderr.

pub mod args;
mod bench;
mod forge;
pub mod headless;
mod judge;
mod list;
pub mod pass;
pub mod pictures;
mod play;
mod plot;
mod pop;
pub mod shoot;
pub mod shots;
pub mod stability;

use std::{
    io::{self, Write},
    process::ExitCode,
};

use clap::Parser;

use args::{Args, Command};

/// Why a command did not do what it was asked for.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Failure {
    /// It could not be done: exit code 1.
    #[error("{0}")]
    Failed(String),
    /// The arguments make no sense together with what they name: exit code 2.
    #[error("{0}")]
    Usage(String),
}

impl Failure {
    /// Something that could not be done.
    pub fn failed(error: impl ToString) -> Self {
        Self::Failed(error.to_string())
    }

    /// Wrong arguments.
    pub fn usage(error: impl ToString) -> Self {
        Self::Usage(error.to_string())
    }

    fn exit_code(&self) -> u8 {
        match self {
            Self::Failed(_) => 1,
            Self::Usage(_) => 2,
        }
    }
}

/// Runs the command line of this process.
#[must_use]
pub fn main() -> ExitCode {
    let args = match Args::try_parse() {
        Ok(args) => args,
        Err(error) => {
            // Nobody listens where even this fails.
            let _ = error.print();
            return ExitCode::from(u8::try_from(error.exit_code()).unwrap_or(2));
        }
    };
    match run(args) {
        Ok(()) => ExitCode::SUCCESS,
        Err(failure) => {
            let _ = writeln!(io::stderr(), "umbrage: {failure}");
            ExitCode::from(failure.exit_code())
        }
    }
}

fn run(args: Args) -> Result<(), Failure> {
    let assets = args.assets.as_deref();
    match args.command {
        None => play::run(assets, &args::Play::default()),
        Some(Command::Play(play_args)) => play::run(assets, &play_args),
        Some(Command::Shoot(shoot_args)) => shoot::run(assets, &shoot_args),
        Some(Command::Judge(judge_args)) if judge_args.stability.along.is_empty() => judge::run(assets, &judge_args),
        Some(Command::Judge(judge_args)) => stability::run(assets, &judge_args),
        Some(Command::Bench(bench_args)) => bench::run(assets, &bench_args),
        Some(Command::Pop(pop_args)) => pop::run(assets, &pop_args),
        Some(Command::Plot(plot_args)) => plot::run(&plot_args),
        Some(Command::Forge(forge_args)) => forge::run(assets, &forge_args),
        Some(Command::List { what }) => list::run(assets, &what),
    }
}

/// One line of result on stdout. A reader that has gone away, as in `umbrage list scenes | head -1`, is no error.
fn say(line: impl AsRef<str>) {
    let _ = writeln!(io::stdout(), "{}", line.as_ref());
}

/// One line of remark on stderr.
fn remark(line: impl AsRef<str>) {
    let _ = writeln!(io::stderr(), "umbrage: {}", line.as_ref());
}
