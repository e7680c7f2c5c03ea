//! Light planes in space (Chong 2003 and what was derived beyond it).

mod algebra;
mod degenerate;
mod fit;
mod partition;
mod plan;
mod properties;
mod reference;
mod scene;
mod seen;
mod theorems;
