//! Levels: files, errors, generators, and loading in a headless app without a renderer.

mod files;
mod generators;
mod loading;
mod sources;
