//! [`FilmLayout`]: the maps of films in the atlas.

use bevy::math::UVec4;

use super::LightPlanes;
use crate::{
    maths::light_plane::space::FilmPartition,
    shadow::{
        layout::{AtlasLayout, cells_per_side},
        settings::{ShadowPath, SunShadows},
    },
};

/// The map of what was not seen takes one part in so many of the atlas's rows: it is read for a frame or two where something
/// comes into sight, and 6 % of the texels are 3 % of the sharpness.
const REST_SHARE: u32 = 16;

/// Where the maps of a frame lie.
pub(super) struct FilmLayout {
    /// The films in their order, then the map for the rest, if there is one.
    pub(super) atlas: AtlasLayout,
    /// The films alone, where they have different sizes: what the next frame keeps to.
    pub(super) films: Option<AtlasLayout>,
}

impl FilmLayout {
    /// One film has all of the square but the strip for the rest; several have rectangles with texels in proportion to √e
    /// ([`FilmPartition::needed_sizes`]). Cascades of the drop-in path have a map of their own each.
    pub(super) fn new(
        settings: &SunShadows,
        planes: &LightPlanes,
        partition: &FilmPartition,
        last: Option<&AtlasLayout>,
    ) -> Self {
        let count = partition.frusta.len() as u32;
        let side = settings.map_size;
        if settings.path == ShadowPath::DropIn {
            return Self::equal(AtlasLayout::equal(side, 1, (0..count).map(|_| 0)));
        }
        let rest = if planes.has_rest_map() {
            (side / REST_SHARE).max(1)
        } else {
            0
        };
        let inner = (side - rest).max(1);
        let (mut atlas, films) = if count == 1 {
            let mut one = AtlasLayout::equal(side, 1, std::iter::once(0));
            one.rects = vec![UVec4::new(0, 0, side, inner)];
            (one, None)
        } else {
            let slots: Vec<u32> = (0..count).collect();
            match AtlasLayout::balanced(partition.needed_sizes(), &slots, inner, last) {
                Some(films) => (films.clone(), Some(films)),
                None => (AtlasLayout::equal(inner / cells_per_side(count), count, 0..count), None),
            }
        };
        atlas.side = side;
        if rest > 0 {
            atlas.rects.push(UVec4::new(0, inner, side, rest));
        }
        Self { atlas, films }
    }

    fn equal(atlas: AtlasLayout) -> Self {
        Self { atlas, films: None }
    }
}

#[cfg(test)]
mod tests {
    use bevy::math::{DMat2, DVec2};

    use super::*;
    use crate::maths::light_plane::space::{Film, FilmFrame, FilmFrustum, FilmHull};

    fn partition(errors: &[f64]) -> FilmPartition {
        let square = [DVec2::ZERO, DVec2::X, DVec2::ONE, DVec2::Y];
        let frustum = |error: &f64| FilmFrustum {
            film: Film {
                bend: DVec2::ZERO,
                frame: FilmFrame {
                    corner: DVec2::ZERO,
                    sides: DMat2::IDENTITY,
                },
                error: *error,
                pixels: 1.0,
                aspect: 1.0,
            },
            hull: FilmHull::new(square).expect("a square"),
            depths: [1.0, 2.0],
        };
        FilmPartition {
            frusta: errors.iter().map(frustum).collect(),
        }
    }

    #[test]
    fn maps_do_not_overlap_and_follow_the_need() {
        let settings = SunShadows {
            map_size: 1024,
            ..SunShadows::HIGH
        };
        for errors in [&[1.0][..], &[1.0, 1.0], &[16.0, 1.0, 1.0], &[9.0, 4.0, 4.0, 1.0, 1.0]] {
            let layout = FilmLayout::new(&settings, &LightPlanes::default(), &partition(errors), None).atlas;
            assert_eq!((layout.side, layout.rects.len()), (1024, errors.len() + 1));
            for (index, a) in layout.rects.iter().enumerate() {
                assert!(
                    a.z > 0 && a.w > 0 && a.x + a.z <= 1024 && a.y + a.w <= 1024,
                    "{a} sticks out"
                );
                for b in &layout.rects[..index] {
                    let is_apart = a.x + a.z <= b.x || b.x + b.z <= a.x || a.y + a.w <= b.y || b.y + b.w <= a.y;
                    assert!(is_apart, "{a} overlaps {b}");
                }
            }
            let texels: Vec<u32> = layout.rects.iter().map(|rect| rect.z * rect.w).collect();
            assert!(
                texels.is_sorted_by(|a, b| f64::from(*b) < 1.1 * f64::from(*a)),
                "{texels:?}"
            );
        }
    }

    #[test]
    fn one_film_of_the_body_has_all_texels() {
        let planes = LightPlanes {
            cover: crate::maths::light_plane::space::FilmCover::Body,
            ..LightPlanes::default()
        };
        let layout = FilmLayout::new(&SunShadows::HIGH, &planes, &partition(&[1.0]), None).atlas;
        assert_eq!(layout.rects, [UVec4::new(0, 0, 2048, 2048)]);
    }
}
