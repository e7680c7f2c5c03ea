//! Truth about shadows, on the CPU: rays to the sun through everything that the renderer draws.
//!
//! Slow, exact, and never on by default: for measuring, not for playing.
//!
//! 1. [`mesh`]: triangles of one mesh in a bounding volume hierarchy of its own.
//! 2. [`scene`]: instances of meshes in a second hierarchy; instances share the tree of their mesh, so 10⁵ trees fit in
//!    memory.
//! 3. [`extract`]: all of it from a running app.
//! 4. [`pixels`]: truth for every pixel of a picture, from the depths that the GPU wrote; what makes a pixel valid.
//! 5. [`accuracy`]: a technique's mask against truth, overall and near true shadow edges.
//! 6. [`pictures`]: both as pictures.
//! 7. [`sampling`]: texel ÷ pixel of every valid pixel.
//! 8. [`coverage`]: how many texels visible receivers touch, and how many lie in the view.
//! 9. [`floor`]: what perfectly spread texels would get wrong.
//! 10. [`stability`]: how much masks crawl and pictures pop from frame to frame.

pub mod accuracy;
pub mod coverage;
pub mod extract;
pub mod floor;
pub mod mesh;
pub mod pictures;
pub mod pixels;
pub mod sampling;
pub mod scene;
pub mod stability;
