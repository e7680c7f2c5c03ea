//! The `umbrage` executable: everything it does is in [`umbrage::cli`].

use std::process::ExitCode;

fn main() -> ExitCode {
    umbrage::cli::main()
}
