//! Assets from code: files that others can read, and the committed models.

mod assets;
mod figures;
mod glb;
mod leaves;
