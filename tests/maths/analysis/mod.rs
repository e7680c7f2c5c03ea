//! What theory says about errors, against the tables of the papers' specifications and against the pipeline.

mod direction;
mod hemisphere;
mod means;
mod metric;
mod overhead;
mod prediction;
