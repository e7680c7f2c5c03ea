//! `umbrage plot`: the papers' figures, from the formulas.

use super::{
    Failure,
    args::Plot,
    pictures::{make_folder, write_whole},
    say,
};
use crate::plot::figures::{Figure, figures};

/// The name that means every figure.
const ALL: &str = "all";

/// Writes the chosen figures as PNG and CSV, one line each.
pub(super) fn run(args: &Plot) -> Result<(), Failure> {
    let chosen: Vec<&Figure> = figures()
        .filter(|figure| args.name == ALL || figure.name == args.name)
        .collect();
    if chosen.is_empty() {
        return Err(unknown(&args.name));
    }
    make_folder(&args.out).map_err(Failure::Failed)?;
    for figure in chosen {
        let png = figure.draw().and_then(|pixels| pixels.png()).map_err(Failure::failed)?;
        let path = args.out.join(format!("{}.png", figure.name));
        write_whole(&path, &png).map_err(Failure::failed)?;
        write_whole(&path.with_extension("csv"), figure.csv().as_bytes()).map_err(Failure::failed)?;
        say(format!("{:<34} {}", figure.name, path.display()));
    }
    Ok(())
}

fn unknown(name: &str) -> Failure {
    let names: Vec<&str> = figures().map(|figure| figure.name).collect();
    Failure::Usage(format!(
        "there is no figure `{name}`; there are {ALL}, {}",
        names.join(", ")
    ))
}

#[cfg(test)]
mod tests {
    use super::*;

    fn plot(name: &str, out: &std::path::Path) -> Result<(), Failure> {
        run(&Plot {
            name: name.to_owned(),
            out: out.to_owned(),
        })
    }

    #[test]
    fn one_figure_is_a_picture_and_a_table() {
        let folder = tempfile::tempdir().expect("a folder");
        let out = folder.path().join("plots");
        plot("stingl-fig2-8-error-of-warps", &out).expect("written");
        let file = |end: &str| out.join(format!("stingl-fig2-8-error-of-warps.{end}"));
        assert!(image::open(file("png")).is_ok_and(|picture| picture.width() > 600));
        assert!(std::fs::read_to_string(file("csv")).is_ok_and(|table| table.contains("LiSPSM")));
        assert_eq!(std::fs::read_dir(&out).expect("a folder").count(), 2);
    }

    #[test]
    fn unknown_names_are_wrong_arguments() {
        let folder = tempfile::tempdir().expect("a folder");
        let failure = plot("figure-1", folder.path()).expect_err("unknown");
        assert!(
            matches!(&failure, Failure::Usage(text) if text.contains("lloyd-fig12-maps")),
            "{failure}"
        );
    }
}
