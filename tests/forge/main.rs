//! Assets from code: files that others can read, and the committed models.

mod assets;
mod glb;
mod leaves;
