//! What the GPU has written, for the CPU: [`ReadBacks`] without waiting, [`ReadBack`] within the frame or in the next.

use std::sync::{
    Arc,
    atomic::{AtomicBool, Ordering},
    mpsc::{Receiver, channel},
};

use bevy::{
    prelude::*,
    render::{
        render_resource::{Buffer, BufferDescriptor, BufferUsages, CommandEncoder, MapMode, PollType},
        renderer::{PendingCommandBuffers, RenderDevice, RenderQueue},
    },
};

/// Copies per reader: one that the GPU writes, one being mapped, one to spare.
const COPIES: usize = 3;

/// Copies of one buffer that the CPU can map.
///
/// [`copy`](Self::copy) in a pass, [`map`](Self::map) after the frame was submitted; the bytes arrive when the GPU has
/// written them. While all copies are on their way, a frame is not read.
pub(super) struct ReadBacks {
    copies: Vec<Transfer>,
    /// The copy of this frame, until it is mapped.
    current: Option<usize>,
}

struct Transfer {
    buffer: Buffer,
    /// From the copy until its content has arrived.
    is_busy: Arc<AtomicBool>,
}

impl ReadBacks {
    /// For a buffer of so many bytes.
    pub(super) fn new(device: &RenderDevice, label: &str, bytes: u64) -> Self {
        let buffer = || {
            device.create_buffer(&BufferDescriptor {
                label: Some(label),
                size: bytes,
                usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
                mapped_at_creation: false,
            })
        };
        Self {
            copies: (0..COPIES)
                .map(|_| Transfer {
                    buffer: buffer(),
                    is_busy: Arc::default(),
                })
                .collect(),
            current: None,
        }
    }

    /// Whether a copy can be made in this frame.
    pub(super) fn has_room(&self) -> bool {
        self.current.is_none() && self.copies.iter().any(Transfer::is_free)
    }

    /// Records a copy of the whole buffer, if there is room for it.
    pub(super) fn copy(&mut self, encoder: &mut CommandEncoder, source: &Buffer) {
        let free = self.copies.iter().position(Transfer::is_free);
        if let (Some(free), None) = (free, self.current) {
            let target = &self.copies[free];
            encoder.copy_buffer_to_buffer(source, 0, &target.buffer, 0, source.size().min(target.buffer.size()));
            target.is_busy.store(true, Ordering::Release);
            self.current = Some(free);
        }
    }

    /// Maps the copy of the frame just submitted, if there is one; `arrive` gets its bytes, on whichever thread polls the
    /// device.
    pub(super) fn map(&mut self, arrive: impl FnOnce(&[u8]) + Send + 'static) {
        let Some(current) = self.current.take() else {
            return;
        };
        let Transfer { buffer, is_busy } = &self.copies[current];
        let (mapped, is_busy) = (buffer.clone(), is_busy.clone());
        buffer.slice(..).map_async(MapMode::Read, move |result| {
            // A device that is lost has no bytes; the frame says so elsewhere.
            if result.is_ok() {
                arrive(&mapped.slice(..).get_mapped_range());
                mapped.unmap();
            }
            is_busy.store(false, Ordering::Release);
        });
    }
}

impl Transfer {
    fn is_free(&self) -> bool {
        !self.is_busy.load(Ordering::Acquire)
    }
}

/// Memory that the CPU can read, for the contents of some buffers one after the other.
#[derive(Clone, Debug)]
pub(super) struct ReadBack {
    buffer: Buffer,
    sizes: Vec<u64>,
}

impl ReadBack {
    /// For buffers of these sizes in bytes, multiples of four.
    pub(super) fn new(device: &RenderDevice, sizes: &[u64]) -> Self {
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
    pub(super) fn is_for(&self, sizes: &[u64]) -> bool {
        self.sizes == sizes
    }

    /// Bytes of memory.
    pub(super) fn bytes(&self) -> u64 {
        self.buffer.size()
    }

    /// Records copies of as many buffers, which need the usage `COPY_SRC`.
    pub(super) fn copy(&self, encoder: &mut CommandEncoder, sources: &[Buffer]) {
        let mut offset = 0;
        for (source, size) in sources.iter().zip(&self.sizes) {
            encoder.copy_buffer_to_buffer(source, 0, &self.buffer, offset, *size);
            offset += size;
        }
    }

    /// The contents of the buffers at the time of the copies, which must have been submitted. Waits for the GPU. `None`
    /// when it does not answer.
    pub(super) fn read(&self, device: &RenderDevice) -> Option<Vec<Vec<u8>>> {
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
pub(super) fn submit_now(world: &mut World, encoder: CommandEncoder) {
    let recorded = world
        .get_resource_mut::<PendingCommandBuffers>()
        .map_or_else(Vec::new, |mut pending| pending.take());
    let queue = world.resource::<RenderQueue>();
    queue.submit(recorded.into_iter().chain([encoder.finish()]));
}
