//! The arguments of the command line.

use std::{path::PathBuf, str::FromStr};

use clap::{Args as ClapArgs, Parser, Subcommand};

use super::{
    pass::Pass,
    shots::{Shard, Size},
    stability::Along,
};
use crate::{
    level::scene::SceneSource,
    lod::settings::{LodKind, LodShadows},
    shadow::technique::{PRESETS, Technique, TechniqueError},
};

/// Sharp sun shadows over large worlds: walk in them, photograph them.
///
/// Without arguments, `umbrage` plays the forest.
#[derive(Debug, Parser)]
#[command(name = "umbrage", version)]
pub struct Args {
    /// The folder that contains levels/ and assets/ [default: $UMBRAGE_ASSETS, else here, else beside the executable]
    #[arg(long, global = true, value_name = "DIR")]
    pub assets: Option<PathBuf>,
    /// What to do; nothing: play the forest.
    #[command(subcommand)]
    pub command: Option<Command>,
}

/// What to do.
#[derive(Debug, Subcommand)]
pub enum Command {
    /// Walk through a scene
    Play(Play),
    /// Take pictures of scenes, without a window
    Shoot(Shoot),
    /// Compare shadow masks with ray-traced truth: a table, report.json, report.md, pictures and plots
    Judge(Judge),
    /// Measure what techniques cost along a camera path: a table, bench.json, bench.csv and plots
    Bench(Bench),
    /// Measure how much changes of levels of detail are seen along a camera path: a table, pop.json and a film strip
    Pop(Pop),
    /// Draw the papers' figures of error and storage from the formulas: PNG and CSV
    Plot(Plot),
    /// Rebuild the models in assets/models from code
    Forge(Forge),
    /// Say what there is
    List {
        /// What to list
        #[command(subcommand)]
        what: ListWhat,
    },
}

/// Arguments of `play`.
#[derive(Clone, Debug, PartialEq, ClapArgs)]
pub struct Play {
    /// A level (forest, city, room/fence), with settings (stress_trees:count=1000), or a .glb file
    #[arg(default_value = "forest")]
    pub scene: SceneSource,
    /// The technique to begin with, as in zp4+lispsm:size=1024 [default: zp4+lispsm]
    #[arg(long, value_name = "T", conflicts_with = "preset")]
    pub technique: Option<NamedTechnique>,
    /// A bundle of technique and budget: low, medium, high or ultra
    #[arg(long, value_name = "P", value_parser = preset)]
    pub preset: Option<Technique>,
    /// How levels of detail take each other's place: hard, late, plain, dither, geomorph or unpopping
    #[arg(long, value_name = "KIND", value_parser = lod_kind, default_value = "unpopping")]
    pub lod: LodKind,
}

impl Default for Play {
    fn default() -> Self {
        Self {
            scene: SceneSource::level("forest"),
            technique: None,
            preset: None,
            lod: LodKind::default(),
        }
    }
}

impl Play {
    /// The technique asked for, else the default.
    #[must_use]
    pub fn technique(&self) -> Technique {
        let named = self.technique.as_ref().map(|named| named.technique.clone());
        named.or_else(|| self.preset.clone()).unwrap_or_default()
    }
}

/// Arguments of `shoot` and `judge`.
#[derive(Clone, Debug, ClapArgs)]
pub struct Shoot {
    /// Levels (forest, city, room/fence), with settings (stress_trees:count=1000), or .glb files
    #[arg(required = true, value_name = "SCENE")]
    pub scenes: Vec<SceneSource>,
    /// A JSON file of shots, in place of the scenes' own
    #[arg(long, value_name = "FILE.json")]
    pub shots: Option<PathBuf>,
    /// Only the shot of this name; may be given several times
    #[arg(long = "shot", value_name = "NAME")]
    pub shot: Vec<String>,
    /// A technique, as in zp4+lispsm:size=1024; may be given several times
    #[arg(long = "technique", value_name = "T", default_value = "zp4+lispsm")]
    pub techniques: Vec<NamedTechnique>,
    /// Size of the pictures in pixels, in place of the shots' own
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// Which pictures, as `list passes` names them
    #[arg(long, value_name = "P,P", value_delimiter = ',', default_value = "beauty")]
    pub passes: Vec<Pass>,
    /// Also one sheet per shot and kind of picture, with all techniques in so many columns
    #[arg(long, value_name = "COLUMNS", value_parser = clap::value_parser!(u32).range(1..=32))]
    pub sheet: Option<u32>,
    /// How levels of detail are chosen and take each other's place: hard, late, plain, dither, geomorph or
    /// unpopping
    #[arg(long, value_name = "KIND", value_parser = lod_kind, default_value = "unpopping")]
    pub lod: LodKind,
    /// Only every N-th shot, beginning with the I-th (from 1)
    #[arg(long, value_name = "I/N", default_value = "1/1")]
    pub shard: Shard,
    /// Where the pictures and stats.json go
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

/// Arguments of `judge`.
#[derive(Clone, Debug, ClapArgs)]
pub struct Judge {
    /// What to judge
    #[command(flatten)]
    pub shoot: Shoot,
    /// Also say what perfectly spread texels would get wrong: five more rays per pixel and texel size
    #[arg(long)]
    pub floor: bool,
    /// Merge the reports of shards in these folders into the first, and judge nothing
    #[arg(long, value_name = "DIR", num_args = 1.., exclusive = true)]
    pub merge: Vec<PathBuf>,
    /// Stability in place of accuracy
    #[command(flatten)]
    pub stability: Stability,
}

/// Arguments of `judge` about stability.
#[derive(Clone, Debug, ClapArgs)]
pub struct Stability {
    /// Measure how much shadows crawl while this moves, at 60 frames per second: a table and stability.json
    #[arg(long, value_name = "MOTION,MOTION", value_delimiter = ',')]
    pub along: Vec<Along>,
    /// Frames of every motion; each is drawn, and its truth traced
    #[arg(long, value_name = "N", default_value_t = 24, requires = "along",
          value_parser = clap::value_parser!(u32).range(2..=600))]
    pub frames: u32,
    /// The camera path of the scene that `--along camera` follows
    #[arg(long, value_name = "NAME", requires = "along")]
    pub path: Option<String>,
}

/// Most frames that are measured per technique.
const MAX_FRAMES: i64 = 100_000;

/// Arguments of `bench`.
#[derive(Clone, Debug, ClapArgs)]
pub struct Bench {
    /// A level (forest, city, room/fence), with settings (stress_trees:count=1000), or a .glb file
    #[arg(value_name = "SCENE")]
    pub scene: SceneSource,
    /// The camera path, as `list paths SCENE` names it [default: the scene's first]
    #[arg(long, value_name = "NAME")]
    pub path: Option<String>,
    /// A technique, as in zp4+lispsm:size=1024; may be given several times
    #[arg(long = "technique", value_name = "T", default_value = "zp4+lispsm")]
    pub techniques: Vec<NamedTechnique>,
    /// Measured frames per technique, spread evenly over the path
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(1..=MAX_FRAMES))]
    pub frames: u32,
    /// Print ratios to this technique, which is measured in the same run
    #[arg(long, value_name = "T")]
    pub against: Option<NamedTechnique>,
    /// The scene of the technique that ratios are printed to, measured after the others: the same one in another form
    #[arg(long, value_name = "SCENE", requires = "against")]
    pub against_scene: Option<SceneSource>,
    /// The kind of transition of the technique that ratios are printed to, measured after the others
    #[arg(long, value_name = "KIND", value_parser = lod_kind, requires = "against")]
    pub against_lod: Option<LodKind>,
    /// How levels of detail take each other's place: hard, late, plain, dither, geomorph or unpopping
    #[arg(long, value_name = "KIND", value_parser = lod_kind, default_value = "unpopping")]
    pub lod: LodKind,
    /// Size of the pictures in pixels [default: 1280x720]
    #[arg(long, value_name = "WxH")]
    pub size: Option<Size>,
    /// Where the files go
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

/// Arguments of `pop`.
#[derive(Clone, Debug, ClapArgs)]
pub struct Pop {
    /// A level (forest, city), with settings (stress_trees:count=1000)
    #[arg(value_name = "SCENE")]
    pub scene: SceneSource,
    /// The camera path, as `list paths SCENE` names it [default: the scene's first]
    #[arg(long, value_name = "NAME")]
    pub path: Option<String>,
    /// A kind of transition: hard, late, plain, dither, geomorph or unpopping; may be given several times [default: hard,
    /// dither, plain, unpopping]
    #[arg(long = "kind", value_name = "KIND", value_parser = lod_kind)]
    pub kinds: Vec<LodKind>,
    /// Which levels cast shadows during a crossing: solid, both or fading
    #[arg(long, value_name = "WHICH", value_parser = lod_shadows, default_value = "fading")]
    pub shadows: LodShadows,
    /// Factor on distances for shadows: above 1 coarser levels than are seen cast them
    #[arg(long, value_name = "F", default_value_t = 1.0, value_parser = factor)]
    pub shadow_bias: f32,
    /// Fading objects before each other that are drawn with their nearest surface only
    #[arg(long, value_name = "N", default_value_t = 4, value_parser = clap::value_parser!(u32).range(1..=8))]
    pub layers: u32,
    /// Places on the path where the camera stops and watches
    #[arg(long, value_name = "N", default_value_t = 3, value_parser = clap::value_parser!(u32).range(1..=1000))]
    pub stops: u32,
    /// Frames at each, at 60 per second, for which the levels' eye walks on; what fades then is watched to its end
    #[arg(long, value_name = "N", default_value_t = 60, value_parser = clap::value_parser!(u32).range(2..=3600))]
    pub frames: u32,
    /// The technique of the sun's shadows
    #[arg(long, value_name = "T", default_value = "zp4+lispsm")]
    pub technique: NamedTechnique,
    /// Size of the pictures in pixels
    #[arg(long, value_name = "WxH", default_value = "480x270")]
    pub size: Size,
    /// Where the files go
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

/// Arguments of `plot`.
#[derive(Clone, Debug, PartialEq, Eq, ClapArgs)]
pub struct Plot {
    /// A figure, as `list plots` names it, or all
    #[arg(value_name = "NAME|all")]
    pub name: String,
    /// Where the files go
    #[arg(long, value_name = "DIR", default_value = "out")]
    pub out: PathBuf,
}

/// Arguments of `forge`.
#[derive(Clone, Debug, Default, PartialEq, Eq, ClapArgs)]
pub struct Forge {
    /// Only the asset of this name; may be given several times
    #[arg(long, value_name = "NAME")]
    pub only: Vec<String>,
    /// Write nothing there: compare the files with what the code makes, byte for byte
    #[arg(long)]
    pub check: bool,
    /// Also draw pictures of all levels of detail into this folder
    #[arg(long, value_name = "DIR")]
    pub preview: Option<PathBuf>,
}

/// What `list` lists.
#[derive(Clone, Debug, Subcommand)]
pub enum ListWhat {
    /// Levels
    Scenes,
    /// Techniques, their keys and presets
    Techniques,
    /// Kinds of pictures
    Passes,
    /// Figures of the papers
    Plots,
    /// Shots of a scene
    Shots {
        /// A level, with or without settings
        scene: SceneSource,
    },
    /// Camera paths of a scene
    Paths {
        /// A level, with or without settings
        scene: SceneSource,
    },
}

/// A technique with the text that asked for it: pictures are named by the text.
#[derive(Clone, Debug, PartialEq)]
pub struct NamedTechnique {
    /// As it was given.
    pub text: String,
    /// What it means.
    pub technique: Technique,
}

impl FromStr for NamedTechnique {
    type Err = TechniqueError;

    fn from_str(text: &str) -> Result<Self, TechniqueError> {
        Ok(Self {
            text: text.to_owned(),
            technique: text.parse()?,
        })
    }
}

fn preset(name: &str) -> Result<Technique, String> {
    Technique::preset(name).ok_or_else(|| {
        format!(
            "there is no preset `{name}`; there are {}",
            PRESETS.map(|(name, _)| name).join(", ")
        )
    })
}

fn lod_kind(name: &str) -> Result<LodKind, String> {
    LodKind::named(name).ok_or_else(|| {
        let names = LodKind::ALL.map(LodKind::name).join(", ");
        format!("there is no kind of transition `{name}`; there are {names}")
    })
}

fn factor(text: &str) -> Result<f32, String> {
    let factor = text
        .parse()
        .ok()
        .filter(|factor: &f32| *factor > 0.0 && factor.is_finite());
    factor.ok_or_else(|| format!("`{text}` is no factor: it must be a positive number"))
}

fn lod_shadows(name: &str) -> Result<LodShadows, String> {
    match name {
        "solid" => Ok(LodShadows::Solid),
        "both" => Ok(LodShadows::Both),
        "fading" => Ok(LodShadows::Fading),
        _ => Err(format!("`{name}` casts no shadows; there are solid, both, fading")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::shadow::technique::StockBias;

    fn parse(text: &str) -> Result<Args, clap::Error> {
        Args::try_parse_from(text.split_whitespace())
    }

    #[test]
    fn the_definition_is_sound() {
        <Args as clap::CommandFactory>::command().debug_assert();
    }

    #[test]
    fn shoot_has_the_defaults_of_the_contract() {
        let Ok(Args {
            command: Some(Command::Shoot(shoot)),
            ..
        }) = parse("umbrage shoot forest")
        else {
            panic!("`shoot forest` must parse");
        };
        assert_eq!(shoot.techniques[0].technique, Technique::default());
        assert_eq!(shoot.passes, [Pass::Beauty]);
        assert_eq!(
            (shoot.out.to_str(), shoot.shard, shoot.size),
            (Some("out"), Shard::ALL, None)
        );
    }

    #[test]
    fn options_repeat_and_passes_split_at_commas() {
        let text = "umbrage shoot a.glb forest --technique bevy --technique zp4+lispsm:size=512,filter=hard \
                    --shot x --shot y --passes beauty,mask --size 64x36 --shard 2/3 --assets dir";
        let Ok(Args {
            command: Some(Command::Shoot(shoot)),
            assets,
        }) = parse(text)
        else {
            panic!("must parse");
        };
        assert_eq!(
            (shoot.scenes.len(), shoot.techniques.len(), shoot.shot.len()),
            (2, 2, 2)
        );
        assert_eq!(shoot.techniques[1].text, "zp4+lispsm:size=512,filter=hard");
        assert_eq!(shoot.passes, [Pass::Beauty, Pass::Mask]);
        assert_eq!(assets, Some("dir".into()));
    }

    #[test]
    fn judge_takes_what_shoot_takes_or_folders_to_merge() {
        let judge = |text: &str| match parse(text) {
            Ok(Args {
                command: Some(Command::Judge(judge)),
                ..
            }) => Some(judge),
            _ => None,
        };
        let asked = judge("umbrage judge forest --floor --shard 2/3").expect("must parse");
        assert!(asked.floor && asked.merge.is_empty() && asked.shoot.scenes.len() == 1);
        let merged = judge("umbrage judge --merge a b").expect("must parse");
        assert_eq!(merged.merge, [PathBuf::from("a"), PathBuf::from("b")]);
        assert!(merged.shoot.scenes.is_empty());
        assert!(judge("umbrage judge").is_none() && judge("umbrage judge forest --merge a").is_none());
    }

    #[test]
    fn play_takes_a_technique_or_a_preset() {
        let technique = |text: &str| match parse(text) {
            Ok(Args {
                command: Some(Command::Play(play)),
                ..
            }) => Some(play.technique()),
            _ => None,
        };
        assert_eq!(technique("umbrage play"), Some(Technique::default()));
        assert_eq!(technique("umbrage play city --preset low"), Technique::preset("low"));
        assert_eq!(
            technique("umbrage play --technique bevy"),
            Some(Technique::Bevy(StockBias::default()))
        );
        assert_eq!(technique("umbrage play --technique bevy --preset low"), None);
    }

    #[test]
    fn judge_measures_accuracy_unless_something_moves() {
        let stability = |text: &str| match parse(text) {
            Ok(Args {
                command: Some(Command::Judge(judge)),
                ..
            }) => judge.stability,
            _ => panic!("`{text}` must parse"),
        };
        assert!(stability("umbrage judge forest").along.is_empty());
        let moving = stability("umbrage judge forest --along camera,sun --path walk --shot a");
        assert_eq!(moving.along, [Along::Camera, Along::Sun]);
        assert_eq!((moving.frames, moving.path.as_deref()), (24, Some("walk")));
    }

    #[test]
    fn bench_measures_the_default_against_a_rival() {
        let text = "umbrage bench forest --path walk --against bevy --frames 20 --size 64x36";
        let Ok(Args {
            command: Some(Command::Bench(bench)),
            ..
        }) = parse(text)
        else {
            panic!("must parse");
        };
        assert_eq!(bench.techniques[0].technique, Technique::default());
        assert_eq!(
            bench.against.map(|rival| rival.technique),
            Some(Technique::Bevy(StockBias::default()))
        );
        assert_eq!((bench.frames, bench.path.as_deref()), (20, Some("walk")));
    }

    #[test]
    fn plot_takes_one_name() {
        let Ok(Args {
            command: Some(Command::Plot(plot)),
            ..
        }) = parse("umbrage plot all")
        else {
            panic!("`plot all` must parse");
        };
        assert_eq!((plot.name.as_str(), plot.out.to_str()), ("all", Some("out")));
    }

    #[test]
    fn nonsense_exits_with_two() {
        for text in [
            "umbrage plot",
            "umbrage plot a b",
            "umbrage dance",
            "umbrage shoot",
            "umbrage shoot forest --technique blur",
            "umbrage shoot forest --size 0x10",
            "umbrage shoot forest --passes beauty,blur",
            "umbrage shoot forest --shard 4/3",
            "umbrage judge forest --along sideways",
            "umbrage judge forest --along sun --frames 1",
            "umbrage judge forest --path walk",
            "umbrage bench",
            "umbrage bench forest city",
            "umbrage bench forest --frames 0",
            "umbrage bench forest --frames 100001",
            "umbrage bench forest --against stock",
            "umbrage pop forest --kind sudden",
            "umbrage pop forest --shadows none",
            "umbrage pop forest --shadow-bias 0",
            "umbrage pop forest --shadow-bias x",
            "umbrage pop forest --layers 9",
            "umbrage shoot forest --lod sudden",
            "umbrage play --preset best",
            "umbrage list",
        ] {
            assert_eq!(parse(text).map_err(|error| error.exit_code()).err(), Some(2), "{text}");
        }
    }
}
