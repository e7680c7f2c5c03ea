//! The forest: hills with plants by rules, fences along tracks, huts.

use bevy_math::{Quat, Vec2, Vec3};

use super::{
    format::{FenceShape, Forest, HutSite, Level},
    ground::{Ground, Surface},
    made::Made,
    model::{Model, Placement, Tint},
    scatter::{self, Thrown},
    scenery::{Finish, Scenery, Static},
    species,
    terrain::{Terrain, Track},
};

/// Nothing grows nearer to the middle of a hut.
pub const HUT_FREE: f32 = 7.0;

/// Generates a forest.
pub fn generate(level: &Level, forest: &Forest) -> Scenery {
    let terrain = Terrain::new(&level.terrain, level.seed);
    let mut statics: Vec<Static> = (terrain.tiles().into_iter().zip(terrain.covers()))
        .map(|(mesh, cover)| Static {
            name: "terrain",
            mesh,
            finish: Finish::Cover(cover),
        })
        .collect();
    statics.extend(terrain.clearings().iter().filter_map(|clearing| {
        Some(Static {
            name: "water",
            mesh: terrain.water(clearing)?,
            finish: Finish::Water,
        })
    }));
    let away_from_huts = |p: Vec2| forest.huts.iter().all(|hut| p.distance(hut.position) > HUT_FREE);
    let thrown = scatter::scatter(&terrain, &level.scatter, away_from_huts, level.seed);
    let mut placements: Vec<Placement> = thrown.iter().map(|thrown| plant(&terrain, thrown)).collect();
    placements.extend(forest.huts.iter().map(|site| hut(&terrain, site)));
    for (track, shape) in terrain.tracks().iter().zip(&level.terrain.tracks) {
        if let Some(fence) = shape.fence {
            placements.extend(fence_along(&terrain, track, &fence));
        }
    }
    let blockers = placements.iter().filter_map(Placement::blocker).collect();
    Scenery {
        statics,
        placements,
        ground: Ground::new(Surface::Hills(Box::new(terrain)), Vec::new(), blockers),
        ..Scenery::default()
    }
}

/// Sets something thrown on the ground: rocks, dead wood and herbs lie along the slope, trees stand nearly upright.
pub fn plant(terrain: &Terrain, thrown: &Thrown) -> Placement {
    let p = thrown.position;
    let position = Vec3::new(p.x, terrain.height(p), p.y);
    let upright = Quat::from_rotation_y(thrown.yaw);
    let rotation = if species::follows_slope(thrown.species) {
        Quat::from_rotation_arc(Vec3::Y, terrain.normal(p)) * upright
    } else {
        // Shapes are any number: its digits serve as dice for how a tree leans.
        let lean = species::lean(thrown.species) * share(thrown.variant, 1);
        let axis = Quat::from_rotation_y(std::f32::consts::TAU * share(thrown.variant, 2)) * Vec3::X;
        Quat::from_axis_angle(axis, lean) * upright
    };
    Placement {
        model: Model::Plant(thrown.species, thrown.variant),
        position,
        rotation,
        scale: Vec3::splat(thrown.scale),
        tint: species::tint(thrown.species, share(thrown.variant, 3)),
    }
}

/// A share of 0..=1 from one byte of a number; byte 0 chooses shapes.
fn share(number: u32, byte: u32) -> f32 {
    (number >> (8 * byte) & 255) as f32 / 255.0
}

/// A hut on the highest ground under it.
fn hut(terrain: &Terrain, site: &HutSite) -> Placement {
    let around = [(0.0, 0.0), (-2.5, -2.5), (2.5, -2.5), (-2.5, 2.5), (2.5, 2.5)];
    let height = around
        .iter()
        .map(|(x, z)| terrain.height(site.position + Vec2::new(*x, *z)))
        .fold(f32::MIN, f32::max);
    let position = Vec3::new(site.position.x, height, site.position.y);
    Placement::upright(Model::Made(Made::Hut), position, site.yaw_deg.to_radians())
}

/// Posts and rails on the left of a track.
fn fence_along(terrain: &Terrain, track: &Track, fence: &FenceShape) -> Vec<Placement> {
    let line: Vec<Vec2> = (0..track.points.len())
        .map(|i| {
            let (before, after) = (
                track.points[i.saturating_sub(1)],
                track.points[(i + 1).min(track.points.len() - 1)],
            );
            // Left of the walking direction, with z growing towards the viewer.
            let left = -(after - before).normalize().perp();
            track.points[i] + left * fence.offset
        })
        .collect();
    let feet: Vec<Vec3> = resample(&line, fence.post_spacing)
        .into_iter()
        // The inside of a tight bend comes too near to the track.
        .filter(|p| track.distance(*p) > 0.95 * fence.offset)
        .map(|p| Vec3::new(p.x, terrain.height(p), p.y))
        .collect();
    let mut placements = Vec::with_capacity(feet.len() * 2);
    for foot in &feet {
        placements.push(Placement {
            scale: Vec3::new(1.0, fence.height, 1.0),
            ..Placement::upright(Model::Made(Made::SplitPost), *foot, 0.0)
        });
    }
    for pair in feet.windows(2) {
        let along = pair[1] - pair[0];
        // A gap where posts were left out.
        if along.with_y(0.0).length() > 1.5 * fence.post_spacing {
            continue;
        }
        let yaw = Quat::from_rotation_y((-along.z).atan2(along.x));
        let rise = Quat::from_rotation_z((along.y / along.length()).asin());
        placements.push(Placement {
            model: Model::Made(Made::SplitRails),
            position: pair[0],
            rotation: yaw * rise,
            scale: Vec3::new(along.length(), fence.height, 1.0),
            tint: Tint::WHITE,
        });
    }
    placements
}

/// Points on a polyline at equal distances along it, the first point included.
fn resample(line: &[Vec2], spacing: f32) -> Vec<Vec2> {
    let mut points = vec![line[0]];
    let mut left = spacing;
    for pair in line.windows(2) {
        let length = pair[0].distance(pair[1]);
        let mut at = left;
        while at <= length {
            points.push(pair[0].lerp(pair[1], at / length));
            at += spacing;
        }
        left = at - length;
    }
    points
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn resampled_points_are_equally_far_apart() {
        let line = [
            Vec2::ZERO,
            Vec2::new(3.0, 0.0),
            Vec2::new(10.0, 0.0),
            Vec2::new(10.5, 0.0),
        ];
        let points = resample(&line, 2.0);
        assert_eq!(points.len(), 6);
        for (i, p) in points.iter().enumerate() {
            assert!((p.x - 2.0 * i as f32).abs() < 1e-5, "{p}");
        }
    }
}
