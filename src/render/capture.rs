//! Reading textures of the render world back, between frames.
//!
//! For pictures, measurements and tests: each read waits for the GPU, so it has no place in a running game.

use bevy::{
    asset::{Handle, RenderAssetUsages},
    image::Image,
    prelude::*,
    render::{
        RenderApp,
        render_asset::RenderAssets,
        render_resource::{
            Buffer, BufferDescriptor, BufferUsages, CommandEncoderDescriptor, Extent3d, MapMode, Origin3d, PollType,
            TexelCopyBufferInfo, TexelCopyBufferLayout, TexelCopyTextureInfo, Texture, TextureAspect, TextureFormat,
            TextureUsages,
        },
        renderer::{RenderDevice, RenderQueue},
        texture::GpuImage,
    },
};
use thiserror::Error;

/// Why a texture could not be read.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum CaptureError {
    /// The app draws nothing: it has no render world.
    #[error("the app has no renderer")]
    NoRenderer,
    /// The image is not on the GPU (yet): render a frame first.
    #[error("the image is not on the GPU")]
    NotPrepared,
    /// The texture or buffer was made without the usage `COPY_SRC`.
    #[error("the texture or buffer was made without the usage COPY_SRC")]
    NotCopyable,
    /// A format without a fixed texel size, such as a compressed one.
    #[error("textures of format {0:?} cannot be read back")]
    Format(TextureFormat),
    /// There is no such layer.
    #[error("the texture has {layers} layers, not {layer}")]
    Layer {
        /// The layer asked for.
        layer: u32,
        /// The layers that there are.
        layers: u32,
    },
    /// The GPU did not answer.
    #[error("the GPU lost the read-back: {0}")]
    Device(String),
}

/// One layer of a texture in main memory, row 0 on top, rows without padding.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Texels {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// How [`bytes`](Self::bytes) are to be read.
    pub format: TextureFormat,
    /// `width * height` texels, little endian.
    pub bytes: Vec<u8>,
}

impl Texels {
    /// The texels of a 32-bit float format with one channel (`R32Float`, `Depth32Float`).
    ///
    /// Other formats give an empty list.
    #[must_use]
    pub fn to_f32(&self) -> Vec<f32> {
        match self.format {
            TextureFormat::R32Float | TextureFormat::Depth32Float => {
                let (texels, _) = self.bytes.as_chunks();
                texels.iter().copied().map(f32::from_le_bytes).collect()
            }
            _ => Vec::new(),
        }
    }
}

/// An image that a camera or a pass can draw into and [`read_image`] can read.
#[must_use]
pub fn readable_target(width: u32, height: u32, format: TextureFormat) -> Image {
    let mut image = Image::new_target_texture(width, height, format, None);
    image.texture_descriptor.usage |= TextureUsages::COPY_SRC;
    image.asset_usage = RenderAssetUsages::RENDER_WORLD;
    image
}

/// Reads an image that was rendered by the frames so far. Waits for the GPU.
///
/// # Errors
/// The image is not prepared, or not readable: see [`readable_target`].
pub fn read_image(app: &App, image: &Handle<Image>) -> Result<Texels, CaptureError> {
    let world = app.get_sub_app(RenderApp).ok_or(CaptureError::NoRenderer)?.world();
    let images = world
        .get_resource::<RenderAssets<GpuImage>>()
        .ok_or(CaptureError::NoRenderer)?;
    let gpu_image = images.get(image).ok_or(CaptureError::NotPrepared)?;
    read_texture(world, &gpu_image.texture, 0)
}

/// Reads one layer of mip 0 of any texture, with the device of the render world. Waits for the GPU.
///
/// # Errors
/// The texture lacks `COPY_SRC`, has no such layer or has a format without a texel size.
pub fn read_texture(render_world: &World, texture: &Texture, layer: u32) -> Result<Texels, CaptureError> {
    let (device, queue) = device_and_queue(render_world)?;
    if !texture.usage().contains(TextureUsages::COPY_SRC) {
        return Err(CaptureError::NotCopyable);
    }
    let layers = texture.depth_or_array_layers();
    if layer >= layers {
        return Err(CaptureError::Layer { layer, layers });
    }
    let (width, height, format) = (texture.width(), texture.height(), texture.format());
    let aspect = if format.is_depth_stencil_format() {
        TextureAspect::DepthOnly
    } else {
        TextureAspect::All
    };
    let texel_bytes = format
        .block_copy_size(Some(aspect))
        .ok_or(CaptureError::Format(format))?;
    if format.block_dimensions() != (1, 1) {
        return Err(CaptureError::Format(format));
    }
    let row_bytes = width * texel_bytes;
    let padded_row_bytes = RenderDevice::align_copy_bytes_per_row(row_bytes as usize);
    let buffer = device.create_buffer(&BufferDescriptor {
        label: Some("capture"),
        size: padded_row_bytes as u64 * u64::from(height),
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor { label: Some("capture") });
    encoder.copy_texture_to_buffer(
        TexelCopyTextureInfo {
            texture,
            mip_level: 0,
            origin: Origin3d { x: 0, y: 0, z: layer },
            aspect,
        },
        TexelCopyBufferInfo {
            buffer: &buffer,
            layout: TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: u32::try_from(padded_row_bytes).ok(),
                rows_per_image: None,
            },
        },
        Extent3d {
            width,
            height,
            depth_or_array_layers: 1,
        },
    );
    queue.submit([encoder.finish()]);
    let bytes = map(device, &buffer)?
        .chunks_exact(padded_row_bytes)
        .flat_map(|row| &row[..row_bytes as usize])
        .copied()
        .collect();
    Ok(Texels {
        width,
        height,
        format,
        bytes,
    })
}

/// Reads a whole buffer. Waits for the GPU.
///
/// # Errors
/// The buffer lacks `COPY_SRC`.
pub fn read_buffer(render_world: &World, source: &Buffer) -> Result<Vec<u8>, CaptureError> {
    let (device, queue) = device_and_queue(render_world)?;
    if !source.usage().contains(BufferUsages::COPY_SRC) {
        return Err(CaptureError::NotCopyable);
    }
    let buffer = device.create_buffer(&BufferDescriptor {
        label: Some("capture"),
        size: source.size(),
        usage: BufferUsages::MAP_READ | BufferUsages::COPY_DST,
        mapped_at_creation: false,
    });
    let mut encoder = device.create_command_encoder(&CommandEncoderDescriptor { label: Some("capture") });
    encoder.copy_buffer_to_buffer(source, 0, &buffer, 0, source.size());
    queue.submit([encoder.finish()]);
    map(device, &buffer)
}

fn device_and_queue(render_world: &World) -> Result<(&RenderDevice, &RenderQueue), CaptureError> {
    render_world
        .get_resource::<RenderDevice>()
        .zip(render_world.get_resource::<RenderQueue>())
        .ok_or(CaptureError::NoRenderer)
}

/// The bytes of a buffer with `MAP_READ`.
fn map(device: &RenderDevice, buffer: &Buffer) -> Result<Vec<u8>, CaptureError> {
    let (sender, receiver) = std::sync::mpsc::channel();
    buffer.slice(..).map_async(MapMode::Read, move |result| {
        // The receiver lives until the answer is there, or nobody wants it any more.
        let _ = sender.send(result);
    });
    device
        .poll(PollType::wait_indefinitely())
        .map_err(|error| CaptureError::Device(error.to_string()))?;
    receiver
        .recv()
        .map_err(|error| CaptureError::Device(error.to_string()))?
        .map_err(|error| CaptureError::Device(error.to_string()))?;
    Ok(buffer.slice(..).get_mapped_range().to_vec())
}

/// Waits until the GPU has done everything that was submitted: for timing whole frames.
pub fn wait_for_gpu(app: &App) {
    if let Some(device) = app
        .get_sub_app(RenderApp)
        .and_then(|render_app| render_app.world().get_resource::<RenderDevice>())
        && let Err(error) = device.poll(PollType::wait_indefinitely())
    {
        warn!("waiting for the GPU failed: {error}");
    }
}
