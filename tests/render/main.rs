//! Render tests: headless, on whatever Vulkan driver there is. Without one they fail and name the package to install.

mod blur;
mod depth_range;
mod fitted;
mod fitted_needs;
mod grove;
mod guard;
mod harness;
mod heat_map;
mod identity;
mod layers;
mod light_plane;
mod lighting;
mod lookup;
mod panes;
mod partitions;
mod reference;
mod room;
mod softness;
mod stability;
mod stable_maps;
mod truth;
mod unpop;
mod virtual_map;
