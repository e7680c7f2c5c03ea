//! Assets from code: files that others can read, pictures, growth.

mod glb;
