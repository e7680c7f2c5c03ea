//! Which graphics adapters can be used, asked before Bevy's renderer, which panics where there is none.

use bevy::{
    render::settings::{Backends, WgpuSettings},
    tasks::block_on,
};
use thiserror::Error;

/// No driver, or none that is visible.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[error(
    "no graphics adapter was found; install a Vulkan driver (Debian, Ubuntu: the package mesa-vulkan-drivers, which \
     contains a software one) and check that VK_DRIVER_FILES, VK_ICD_FILENAMES and WGPU_BACKEND do not hide it"
)]
pub struct NoAdapter;

/// Renderer settings with the backends that Umbrage can use: OpenGL lacks indirect drawing from compute shaders.
#[must_use]
pub fn settings() -> WgpuSettings {
    WgpuSettings {
        backends: Some(backends()),
        ..WgpuSettings::default()
    }
}

fn backends() -> Backends {
    WgpuSettings::default().backends.unwrap_or(Backends::PRIMARY) - Backends::GL
}

/// Whether any adapter is there.
///
/// # Errors
/// There is none.
pub fn check() -> Result<(), NoAdapter> {
    let backends = backends();
    let instance = wgpu::Instance::new(wgpu::InstanceDescriptor {
        backends,
        ..wgpu::InstanceDescriptor::new_without_display_handle()
    });
    if block_on(instance.enumerate_adapters(backends)).is_empty() {
        Err(NoAdapter)
    } else {
        Ok(())
    }
}
