//! Levels: files, errors, generators, and loading in a headless app without a renderer.

mod cells;
mod files;
mod generators;
mod gltf_lods;
mod loading;
mod sources;
