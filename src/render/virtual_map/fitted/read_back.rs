//! Reading what the GPU has written, within the frame or in the next.

use std::sync::mpsc::{Receiver, channel};

use bevy::{
    prelude::*,
    render::{
        render_resource::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, MapMode, PollType},
        renderer::{PendingCommandBuffers, RenderDevice, RenderQueue},
    },
};

/// Memory that the CPU can read, for the contents of some buffers one after the other.
#[derive(Clone, Debug)]
pub struct ReadBack {
    buffer: Buffer,
    sizes: Vec<u64>,
}

impl ReadBack {
    /// For buffers of these sizes in bytes, multiples of four.
    pub fn new(device: &RenderDevice, sizes: &[u64]) -> Self {
        let buffer = device.create_buffer(&BufferDescriptor {
            label: Some("umbrage_read_back"),
            size: sizes.iter().sum::<u64>().max(4),
            usage: BufferUsages::COPY_DST | BufferUsages::MAP_READ,
            mapped_at_creation: false,
        });
        Self {
            buffer,
            sizes: sizes.to_vec(),
        }
    }

    /// Whether it is for buffers of these sizes.
    pub fn is_for(&self, sizes: &[u64]) -> bool {
        self.sizes == sizes
    }

    /// Bytes of memory.
    pub fn bytes(&self) -> u64 {
        self.buffer.size()
    }

    /// Records copies of as many buffers, which need the usage `COPY_SRC`.
    pub fn copy(&self, encoder: &mut CommandEncoder, sources: &[Buffer]) {
        let mut offset = 0;
        for (source, size) in sources.iter().zip(&self.sizes) {
            encoder.copy_buffer_to_buffer(source, 0, &self.buffer, offset, *size);
            offset += size;
        }
    }

    /// The contents of the buffers at the time of the copies, which must have been submitted. Waits for the GPU. `None`
    /// when it does not answer.
    pub fn read(&self, device: &RenderDevice) -> Option<Vec<Vec<u8>>> {
        let slice = self.buffer.slice(..);
        let (sender, receiver) = channel();
        slice.map_async(MapMode::Read, move |result| {
            // The receiver waits below.
            let _ = sender.send(result.is_ok());
        });
        let contents = is_mapped(device, &receiver).then(|| {
            let mapped = slice.get_mapped_range();
            let mut rest = &mapped[..];
            let pieces = self.sizes.iter().map(|size| {
                let (piece, after) = rest.split_at(*size as usize);
                rest = after;
                piece.to_vec()
            });
            pieces.collect()
        });
        if contents.is_some() {
            self.buffer.unmap();
        }
        contents
    }
}

fn is_mapped(device: &RenderDevice, receiver: &Receiver<bool>) -> bool {
    device.poll(PollType::wait_indefinitely()).is_ok() && receiver.try_recv() == Ok(true)
}

/// Hands everything that the frame has recorded so far to the GPU, and these commands after it.
pub fn submit_now(world: &mut World, encoder: CommandEncoder) {
    let recorded = world
        .get_resource_mut::<PendingCommandBuffers>()
        .map_or_else(Vec::new, |mut pending| pending.take());
    let queue = world.resource::<RenderQueue>();
    queue.submit(recorded.into_iter().chain([encoder.finish()]));
}
