//! [`Level`]: what a `.level.ron` file says. [`validate`](super::validate) holds the limits.
//!
//! Lengths are metres, angles degrees, y is up. Every field that a file names must exist here: an unknown one is an
//! error, not a silent default.

use bevy_math::{Vec2, Vec3};
use serde::{Deserialize, Serialize};

pub use super::sky::settings::{Air, SunSettings};
use super::{inhabitants::InhabitantRule, shot::Shot};

/// A level file.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Level {
    /// The file's path below `levels/` without `.level.ron`, for example `room/fence`.
    pub name: String,
    /// One sentence for lists.
    pub about: String,
    /// Same seed, same level, on every machine.
    pub seed: u64,
    /// What is built.
    pub generator: Generator,
    /// What it stands on.
    pub terrain: TerrainShape,
    /// Plants and rocks, thrown in this order.
    #[serde(default)]
    pub scatter: Vec<ScatterRule>,
    /// Animals and people.
    #[serde(default)]
    pub inhabitants: Vec<InhabitantRule>,
    /// Sun and sky.
    pub sun: SunSettings,
    /// Where the player starts.
    pub spawn: Spawn,
    /// Named cameras, at least one: techniques are judged by them, and by nothing else.
    pub shots: Vec<LevelShot>,
    /// Named cameras at other places under other suns, for choosing settings; taken only when they are named.
    #[serde(default)]
    pub tuning_shots: Vec<LevelShot>,
    /// Named cameras for pictures at other hours; nothing is judged by them, and they are taken only when they are
    /// named.
    #[serde(default)]
    pub views: Vec<LevelShot>,
    /// Named camera flights.
    #[serde(default)]
    pub camera_paths: Vec<CameraPath>,
}

/// What a level is built by.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Generator {
    /// Hills, plants, tracks with fences, huts.
    Forest(Forest),
    /// Streets, buildings, squares, a lattice tower.
    City(City),
    /// An analytic scene whose shadows can be worked out by hand.
    Room(Room),
    /// Many instances of a few trees on a square lattice.
    StressTrees(StressTrees),
}

/// Parameters of a forest; plants come from [`Level::scatter`], tracks from [`TerrainShape::tracks`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Forest {
    /// Log cabins.
    #[serde(default)]
    pub huts: Vec<HutSite>,
}

/// Where a hut stands; plants keep away from it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct HutSite {
    /// Middle of the hut (x, z).
    pub position: Vec2,
    /// Heading of the door; 0 looks along +z.
    pub yaw_deg: f32,
}

/// Parameters of a city, centred on the origin.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct City {
    /// Blocks along x and z, 3..=16 each.
    pub blocks: (u32, u32),
    /// Smallest and largest side of a block, pavement included.
    pub block_side: (f32, f32),
    /// Width of a street between kerbs.
    pub street: f32,
    /// Width of the two avenues that cross in the middle.
    pub avenue: f32,
    /// Width of the pavement around a block.
    pub pavement: f32,
    /// Floors of the highest buildings, in the middle; districts fall off from there.
    pub max_floors: u32,
    /// Height of the lattice tower.
    pub tower_height: f32,
    /// Parked cars, at most; fewer where kerbs run out.
    pub cars: u32,
}

/// Analytic rooms: a ground of [`TerrainShape::size`] with something on it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub enum Room {
    /// A cube on the plane.
    PlaneBox {
        /// Side of the cube.
        side: f32,
    },
    /// Two rows of poles along the plane's z axis.
    Poles {
        /// Distance between poles of a row.
        spacing: f32,
        /// Height of a pole.
        height: f32,
        /// Radius of a pole.
        radius: f32,
        /// Distance between the rows.
        gap: f32,
    },
    /// A fence of posts and rails along the plane's z axis.
    Fence {
        /// Distance between posts.
        post_spacing: f32,
        /// Height of a post.
        height: f32,
    },
    /// Thin wires that sag between poles along the plane's z axis.
    Wires {
        /// Distance between poles.
        spacing: f32,
        /// Height of the poles.
        height: f32,
        /// Diameter of a wire.
        diameter: f32,
        /// How far a wire sags in the middle.
        sag: f32,
    },
    /// Panes of glass one behind the other along the plane's z axis, under beams whose shadows fall on them.
    Glass {
        /// How many.
        panes: u32,
        /// Distance between them.
        spacing: f32,
        /// Height of a pane; it is half as wide again.
        height: f32,
    },
    /// A wall across the plane, a row of poles before it, and a card that stands on the plane between both.
    Wall {
        /// Where the wall stands, on the z axis; it looks along +z.
        place: f32,
        /// Height of the wall.
        height: f32,
        /// Distance between the poles, which are half as high as the wall and 3 m before it.
        spacing: f32,
        /// Height and width of the card, 6 m before the wall; 0: none.
        card: f32,
    },
}

/// Parameters of the instancing test.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct StressTrees {
    /// Number of trees, 1..=1,000,000.
    pub count: u32,
    /// Lattice spacing.
    pub spacing: f32,
    /// Whether far trees are drawn cell by cell (default), or every tree is an entity.
    #[serde(default = "yes")]
    pub cells: bool,
    /// Wind in metres per second, 0 (default) to 30; only in cells.
    #[serde(default)]
    pub wind: f32,
}

fn yes() -> bool {
    true
}

/// The ground.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TerrainShape {
    /// Extent along x and z, centred on the origin.
    pub size: Vec2,
    /// Absent: flat at y = 0.
    #[serde(default)]
    pub hills: Option<Hills>,
    /// Level places without trees.
    #[serde(default)]
    pub clearings: Vec<Clearing>,
    /// Paths, level across, without plants.
    #[serde(default)]
    pub tracks: Vec<TrackShape>,
}

/// Gradient noise in octaves of halving wavelength and height, and a rim that hides the edge of the world.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Hills {
    /// Largest height of the first octave above and below 0.
    pub amplitude: f32,
    /// Wavelength of the first octave.
    pub wavelength: f32,
    /// 1..=8.
    pub octaves: u32,
    /// Height of the rim at the very edge.
    pub rim_height: f32,
    /// Width of the rim.
    pub rim_width: f32,
}

/// A level place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Clearing {
    /// Middle (x, z).
    pub center: Vec2,
    /// No tree stands nearer to the middle.
    pub radius: f32,
    /// Water in the middle.
    #[serde(default)]
    pub pond: Option<Pond>,
}

/// Water in a hollow of a clearing; one can wade in it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Pond {
    /// Radius of the hollow, bank excluded; well below the clearing's.
    pub radius: f32,
    /// Depth of the water in the middle.
    pub depth: f32,
}

/// A path through the terrain: a smooth curve through its points.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct TrackShape {
    /// Trodden width.
    pub width: f32,
    /// At least two points (x, z).
    pub points: Vec<Vec2>,
    /// A fence on its left side (seen along the points).
    #[serde(default)]
    pub fence: Option<FenceShape>,
}

/// A fence beside a track.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct FenceShape {
    /// Distance between posts.
    pub post_spacing: f32,
    /// Height of a post.
    pub height: f32,
    /// Distance from the middle of the track.
    pub offset: f32,
}

/// What is thrown on the terrain. Heights are those at scale 1.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum Species {
    /// Norway spruce, 16 m.
    Spruce,
    /// Scots pine, 16 to 18 m.
    Pine,
    /// Oak with a broad crown, 12 m.
    Oak,
    /// Beech, 15 m.
    Beech,
    /// Silver birch, 13 to 15 m.
    Birch,
    /// Standing dead tree, 9 m.
    DeadTree,
    /// Hazel bush, 1.7 m.
    Bush,
    /// Male fern, 0.4 m high and 1.4 m wide.
    Fern,
    /// A patch of low grass, 0.4 m high and 3 m wide.
    Grass,
    /// A patch of high grass with ears, 0.8 m high and 3 m wide.
    TallGrass,
    /// A stone, 0.3 m.
    Stone,
    /// A block, 0.8 m.
    Rock,
    /// A boulder, 2 m.
    Boulder,
    /// A sawn stump, 0.5 m.
    Stump,
    /// A fallen log, 4.5 m long.
    Log,
}

impl Species {
    /// True for the species that count as trees and keep clearings free.
    pub fn is_tree(self) -> bool {
        matches!(
            self,
            Self::Spruce | Self::Pine | Self::Oak | Self::Beech | Self::Birch | Self::DeadTree
        )
    }
}

/// How one species is thrown.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct ScatterRule {
    /// What.
    pub species: Species,
    /// How many; fewer where the limits leave no room.
    pub count: u32,
    /// Free distance: two things keep the mean of their rules' spacings between them.
    pub spacing: f32,
    /// Smallest and largest slope.
    pub slope_deg: (f32, f32),
    /// Lowest and highest ground.
    pub height: (f32, f32),
    /// Smallest and largest scale.
    pub scale: (f32, f32),
    /// 0: everywhere alike; 1: only in patches.
    #[serde(default)]
    pub clumping: f32,
}

/// Where the player starts, eyes included.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Spawn {
    /// Eye.
    pub position: Vec3,
    /// Point looked at.
    pub look_at: Vec3,
}

/// A [`Shot`] as level files write it: unknown fields are errors here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct LevelShot {
    /// Unique in the level.
    pub name: String,
    /// Eye.
    pub position: Vec3,
    /// Point looked at.
    pub target: Vec3,
    /// Full vertical field of view.
    pub fov_y_deg: f32,
    /// Near plane.
    pub near: f32,
    /// Far plane.
    pub far: f32,
    /// Picture size in pixels; default 1280 x 720.
    #[serde(default = "default_size")]
    pub size: (u32, u32),
    /// Direction in which sunlight travels; absent: that of `hour`, or the level's.
    #[serde(default)]
    pub light_dir: Option<Vec3>,
    /// Local solar time of the level's day, in place of `light_dir`.
    #[serde(default)]
    pub hour: Option<f32>,
    /// What makes the shot hard.
    #[serde(default)]
    pub kind: Option<ShotKind>,
}

/// What a shot is there for. Each makes another part of a shadow technique fail first.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
pub enum ShotKind {
    /// At eye level, the sun less than 20° high: long shadows, texels stretched over the ground.
    LowSun,
    /// The sun more than 60° high: light across the view, where warps gain most.
    Overhead,
    /// Light travels in the view direction: warps lose their hold.
    LightBehind,
    /// Light travels towards the camera: shadows fall towards the viewer.
    LightAhead,
    /// A view over 80 m and more: the widest range of depth.
    LongView,
    /// Thin things near the camera before a far background.
    ThinNear,
    /// None of the others, as a player sees it.
    Ordinary,
}

impl ShotKind {
    /// For lists.
    #[must_use]
    pub fn about(self) -> &'static str {
        match self {
            Self::LowSun => "eye level, low sun",
            Self::Overhead => "sun overhead",
            Self::LightBehind => "light behind",
            Self::LightAhead => "light towards the camera",
            Self::LongView => "long view",
            Self::ThinNear => "thin things near, far background",
            Self::Ordinary => "as a player sees it",
        }
    }
}

fn default_size() -> (u32, u32) {
    (1280, 720)
}

/// A named camera flight.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct CameraPath {
    /// Unique in the level.
    pub name: String,
    /// At least two, in order of time.
    pub keys: Vec<PathKey>,
}

/// One key of a [`CameraPath`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct PathKey {
    /// Seconds from the start.
    pub time: f32,
    /// Eye.
    pub position: Vec3,
    /// Point looked at.
    pub target: Vec3,
}

impl CameraPath {
    /// Seconds from the first key to the last.
    pub fn duration(&self) -> f32 {
        match (self.keys.first(), self.keys.last()) {
            (Some(first), Some(last)) => last.time - first.time,
            _ => 0.0,
        }
    }

    /// Eye and target, `seconds` after the first key: a smooth curve through the keys (Catmull and Rom, with the
    /// keys' own times), held at both ends. `None` without keys.
    pub fn sample(&self, seconds: f32) -> Option<(Vec3, Vec3)> {
        let first = self.keys.first()?;
        let time = first.time + seconds.clamp(0.0, self.duration());
        let after = self.keys.partition_point(|key| key.time <= time);
        let (i, j) = (after.saturating_sub(1), after.min(self.keys.len() - 1));
        let (a, b) = (self.keys[i], self.keys[j]);
        if a.time >= b.time {
            return Some((b.position, b.target));
        }
        let before = self.keys[i.saturating_sub(1)];
        let beyond = self.keys[(j + 1).min(self.keys.len() - 1)];
        let span = b.time - a.time;
        let t = (time - a.time) / span;
        let tangent = |from: PathKey, to: PathKey, pick: fn(PathKey) -> Vec3| {
            (pick(to) - pick(from)) / (to.time - from.time) * span
        };
        let curve = |pick: fn(PathKey) -> Vec3| {
            hermite(pick(a), tangent(before, b, pick), pick(b), tangent(a, beyond, pick), t)
        };
        Some((curve(|key| key.position), curve(|key| key.target)))
    }
}

/// The cubic from `a` to `b` with these tangents, at `t` in 0..=1.
fn hermite(a: Vec3, tangent_a: Vec3, b: Vec3, tangent_b: Vec3, t: f32) -> Vec3 {
    let (t2, t3) = (t * t, t * t * t);
    a * (2.0 * t3 - 3.0 * t2 + 1.0)
        + tangent_a * (t3 - 2.0 * t2 + t)
        + b * (3.0 * t2 - 2.0 * t3)
        + tangent_b * (t3 - t2)
}

impl Level {
    /// The level's shots in the form that the rest of the house uses.
    pub fn shots(&self) -> Vec<Shot> {
        self.shots.iter().map(|shot| self.shot(shot)).collect()
    }

    /// The shots that are taken only when they are named: [`Self::tuning_shots`], then [`Self::views`].
    pub fn named_only(&self) -> Vec<Shot> {
        self.tuning_shots
            .iter()
            .chain(&self.views)
            .map(|shot| self.shot(shot))
            .collect()
    }

    /// Direction in which sunlight travels in a shot.
    pub fn light_dir(&self, shot: &LevelShot) -> Vec3 {
        let at_hour = || shot.hour.map(|hour| self.sun.course().light_dir(hour));
        shot.light_dir.or_else(at_hour).unwrap_or_else(|| self.sun.light_dir())
    }

    fn shot(&self, shot: &LevelShot) -> Shot {
        Shot {
            scene: Some(self.name.clone()),
            name: shot.name.clone(),
            position: shot.position.to_array(),
            target: shot.target.to_array(),
            up: [0.0, 1.0, 0.0],
            fov_y_deg: shot.fov_y_deg,
            near: shot.near,
            far: shot.far,
            width: shot.size.0,
            height: shot.size.1,
            light_dir: self.light_dir(shot).to_array(),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn path() -> CameraPath {
        let key = |time, x| PathKey {
            time,
            position: Vec3::X * x,
            target: Vec3::X * (x + 1.0),
        };
        CameraPath {
            name: "walk".into(),
            keys: vec![key(1.0, 0.0), key(2.0, 2.0), key(4.0, 6.0)],
        }
    }

    #[test]
    fn a_path_passes_through_its_keys_and_is_held_at_its_ends() {
        let path = path();
        assert_eq!(path.duration(), 3.0);
        for (seconds, x) in [(-1.0, 0.0), (0.0, 0.0), (1.0, 2.0), (3.0, 6.0), (9.0, 6.0)] {
            let (position, target) = path.sample(seconds).unwrap();
            assert!((position.x - x).abs() < 1e-5, "{seconds} s: {position}");
            assert!((target.x - x - 1.0).abs() < 1e-5, "{seconds} s: {target}");
        }
    }

    #[test]
    fn constant_speed_stays_constant() {
        // The keys move at 2 m/s although their times are uneven.
        for step in 0..=30 {
            let seconds = step as f32 * 0.1;
            let (position, _) = path().sample(seconds).unwrap();
            assert!((position.x - 2.0 * seconds).abs() < 1e-4, "{seconds} s: {position}");
        }
    }

    #[test]
    fn an_empty_path_has_no_sample() {
        let path = CameraPath {
            name: "none".into(),
            keys: vec![],
        };
        assert_eq!(path.sample(0.0), None);
    }
}
