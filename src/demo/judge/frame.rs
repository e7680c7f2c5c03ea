//! The frozen frame on its way from the GPU: [`Frame`].

use bevy::{math::UVec2, render::renderer::RenderDevice};

/// Frames that must be equal, one after the other, before they count.
const EQUAL_FRAMES: u32 = 2;
/// Frames after which a picture that never stands still is given up.
const MAX_FRAMES: u32 = 240;

/// The images that are read back every frame until they stand still.
#[derive(Clone, Debug, Default, PartialEq)]
pub(super) struct Frame {
    /// The shadow mask: a byte per pixel, 255 lit.
    pub(super) mask: Vec<u8>,
    /// The view depth: four bytes per pixel, metres; sky 0.
    pub(super) depth: Vec<u8>,
    last_mask: Vec<u8>,
    last_depth: Vec<u8>,
    equal: u32,
    frames: u32,
}

/// Whether a frame can be judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Stillness {
    /// Not yet.
    Waiting,
    /// It can.
    Still,
    /// It never will.
    Restless,
}

impl Frame {
    /// One more frame is over, in which `is_compiling` shaders or not.
    pub(super) fn next(&mut self, is_compiling: bool) -> Stillness {
        self.frames += 1;
        let is_same = self.is_drawn() && self.mask == self.last_mask && self.depth == self.last_depth;
        self.equal = if is_same && !is_compiling { self.equal + 1 } else { 0 };
        self.last_mask.clone_from(&self.mask);
        self.last_depth.clone_from(&self.depth);
        match self.frames {
            _ if self.equal >= EQUAL_FRAMES => Stillness::Still,
            MAX_FRAMES.. => Stillness::Restless,
            _ => Stillness::Waiting,
        }
    }

    /// A mask without a lit pixel and without a depth is an image that was only cleared: drawn skies are lit.
    fn is_drawn(&self) -> bool {
        !self.depth.is_empty() && (self.mask.iter().any(|lit| *lit > 0) || self.depth.iter().any(|byte| *byte > 0))
    }

    /// The depths in metres.
    pub(super) fn depths(&self) -> Vec<f32> {
        let (texels, _) = self.depth.as_chunks();
        texels.iter().copied().map(f32::from_le_bytes).collect()
    }
}

/// The texels of a read-back without the bytes that pad its rows; empty where there are too few.
pub(super) fn without_padding(data: &[u8], size: UVec2, texel_bytes: usize) -> Vec<u8> {
    let row = size.x as usize * texel_bytes;
    let stride = RenderDevice::align_copy_bytes_per_row(row);
    if row == 0 || data.len() < stride * size.y as usize {
        return Vec::new();
    }
    data.chunks(stride)
        .take(size.y as usize)
        .flat_map(|padded| &padded[..row])
        .copied()
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn drawn(frame: &mut Frame, mask: [u8; 2], depth: f32) {
        frame.mask = mask.to_vec();
        frame.depth = [depth, 0.0].iter().flat_map(|metres| metres.to_le_bytes()).collect();
    }

    #[test]
    fn a_frame_is_still_when_it_was_drawn_twice_alike_without_compiling() {
        let mut frame = Frame::default();
        assert_eq!(frame.next(false), Stillness::Waiting, "nothing is there");
        drawn(&mut frame, [0, 0], 0.0);
        for _ in 0..5 {
            assert_eq!(frame.next(false), Stillness::Waiting, "only cleared");
        }
        drawn(&mut frame, [255, 255], 3.0);
        assert_eq!(frame.next(false), Stillness::Waiting, "new");
        assert_eq!(frame.next(true), Stillness::Waiting, "compiling");
        assert_eq!(frame.next(false), Stillness::Waiting);
        assert_eq!(frame.next(false), Stillness::Still);
        assert_eq!(frame.depths(), [3.0, 0.0]);
    }

    #[test]
    fn a_frame_that_moves_is_given_up() {
        let mut frame = Frame::default();
        let last = (0..1000)
            .map(|i| {
                drawn(&mut frame, [255, (i % 2) as u8], 1.0);
                frame.next(false)
            })
            .find(|stillness| *stillness != Stillness::Waiting);
        assert_eq!(last, Some(Stillness::Restless));
    }

    #[test]
    fn rows_lose_their_padding() {
        let mut data = vec![7; 512];
        data[..3].copy_from_slice(&[1, 2, 3]);
        data[256..259].copy_from_slice(&[4, 5, 6]);
        assert_eq!(without_padding(&data, UVec2::new(3, 2), 1), [1, 2, 3, 4, 5, 6]);
        assert!(without_padding(&data, UVec2::new(3, 3), 1).is_empty(), "too few");
        assert!(without_padding(&data, UVec2::ZERO, 1).is_empty());
    }
}
