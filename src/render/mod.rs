//! Render world: the passes that draw and apply light views.
