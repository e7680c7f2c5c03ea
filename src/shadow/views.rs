//! [`SunViews`]: what the systems computed this frame, for other game code, gizmos and the render room.

use bevy::{ecs::entity::EntityHashMap, prelude::*};

use super::layout::AtlasLayout;
use crate::maths::{face::FaceSet, polytope::Polytope};

/// One map: the light view that draws it and reads it.
#[derive(Clone, Debug, PartialEq, Reflect)]
pub struct LightView {
    /// World to light clip space; reverse z: 1 nearest to the light, 0 farthest; depth clamped.
    pub clip_from_world: Mat4,
    /// Rigid: the light view's axes and origin in the world (x = y × z, y the warp axis, z towards the light).
    pub world_from_light: Mat4,
    /// The whole warp and focus.
    pub clip_from_light: Mat4,
    /// Mean side of a texel in metres at the middle of the body (the local value is
    /// `maths::footprint`).
    pub texel_size: f32,
    /// The larger side of a texel in metres at the near end of the warp; equal to `texel_size` for square uniform texels.
    pub near_texel_size: f32,
    /// What the drop-in path takes from the depth of every caster, in units of the depth range: the same number of local
    /// texels everywhere in the map (see [`drop_in`](super::drop_in)). Zero on the full path.
    pub caster_depth_bias: f32,
    /// View depth interval that this map is meant for, in metres, half open.
    pub near_depth: f32,
    /// End of the interval.
    pub far_depth: f32,
    /// Length of view depth before the end of the interval over which the next map takes over, in metres; 0: none.
    pub seam_depth: f32,
    /// It serves only points that lie in no other map: no seam leads into it.
    pub stands_in: bool,
    /// The map in the atlas, in texels: x, y, width, height. On the drop-in path it is alone.
    pub atlas_rect: UVec4,
}

/// One partition of one camera.
#[derive(Clone, Debug, PartialEq)]
pub struct PartitionView {
    /// Corners of the slice of the view frustum that it lies in, in world space: near bottom left, bottom right, top right, top left, then far.
    pub split_frustum: [Vec3; 8],
    /// What the camera sees of the receivers in it: H in world space.
    pub visible: Polytope,
    /// The intersection body B in world space.
    pub body: Polytope,
    /// Its light view.
    pub light_view: LightView,
}

/// Light views of one light for one camera.
#[derive(Clone, Debug, PartialEq)]
pub struct CameraSunViews {
    /// View depth of the nearest point of the scene's bounds inside the view, in metres.
    pub near_depth: f32,
    /// View depth of the farthest.
    pub far_depth: f32,
    /// View depth at which shadows end whatever is seen: that of the settings, or the camera's far plane; may be infinite.
    pub end_depth: f32,
    /// One per partition: z-partitions near to far, face partitions side by side. A camera that sees nothing of the scene has no entry in [`SunViews`].
    pub partitions: Vec<PartitionView>,
    /// One map over the whole range: the fallback for transparent surfaces and the source of the caster set.
    pub master: LightView,
    /// Where the maps lie in the atlas.
    pub layout: AtlasLayout,
    /// The faces that face partitions were chosen from.
    pub face_set: Option<FaceSet>,
}

/// On the entity of a light with [`SunShadows`](super::settings::SunShadows): this frame's light views of every
/// active camera.
#[derive(Component, Clone, Debug, Default)]
pub struct SunViews {
    /// By camera entity.
    pub cameras: EntityHashMap<CameraSunViews>,
}
