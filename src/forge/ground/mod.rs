//! What stands and lies between trees: ferns, grass, rocks, dead wood.

pub mod deadwood;
pub mod herbs;
pub mod rock;
