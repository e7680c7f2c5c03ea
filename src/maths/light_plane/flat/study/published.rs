//! The numbers of the source's tables (Chong 4.1.3).

/// What the source compares.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PublishedMethod {
    /// Its method with either metric: they coincide.
    Both,
    /// Its method with L1.
    L1,
    /// Its method with L2.
    L2,
    /// Its method with L1 and two frusta.
    TwoFrusta,
    /// "PSM": [`PostPerspectivePrinted`](super::Method::PostPerspectivePrinted), not a perspective shadow map as it is.
    PostPerspective,
    /// The half-angle map.
    HalfAngle,
}

/// A row of its tables; footprints in pixels per texel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PublishedRow {
    /// The name of the [`Scene`](super::Scene) that is like it.
    pub scene: &'static str,
    /// What was measured.
    pub method: PublishedMethod,
    /// Of the film, in degrees.
    pub angle: Option<f64>,
    /// "Worst".
    pub worst: Option<f64>,
    /// "Average".
    pub average: f64,
    /// "Mean + σ".
    pub average_and_deviation: Option<f64>,
}

/// All rows of its tables.
pub const PUBLISHED: [PublishedRow; 15] = {
    use PublishedMethod::{Both, HalfAngle, L1, L2, PostPerspective};
    [
        row("single plane", Both, 9.0, 0.975, 0.960, 0.968),
        row("single plane", PostPerspective, 91.0, 4.33, 1.88, 3.10),
        row("single plane", HalfAngle, 51.0, 2.08, 1.17, 1.65),
        row("simple geometry", L1, 24.8, 1.54, 1.09, 1.42),
        row("simple geometry", L2, 29.2, 1.54, 1.10, 1.41),
        row("simple geometry", PostPerspective, 86.8, 4.74, 1.95, 3.20),
        row("simple geometry", HalfAngle, 25.3, 1.54, 1.09, 1.42),
        row("light from top", L1, 5.11, 6.42, 3.38, 4.39),
        row("light from top", L2, 5.13, 6.42, 3.38, 4.36),
        row("light from top", PostPerspective, 77.3, 73.7, 44.4, 67.4),
        row("light from top", HalfAngle, 83.1, 76.7, 46.2, 70.2),
        row("projection aliasing", L1, 33.9, 60.0, 17.7, 41.4),
        PublishedRow {
            scene: "projection aliasing",
            method: PublishedMethod::TwoFrusta,
            angle: None,
            worst: None,
            average: 7.75,
            average_and_deviation: None,
        },
        row("projection aliasing", PostPerspective, 67.7, 72.7, 22.1, 50.5),
        row("projection aliasing", HalfAngle, 83.7, 82.5, 25.3, 57.5),
    ]
};

const fn row(
    scene: &'static str,
    method: PublishedMethod,
    angle: f64,
    worst: f64,
    average: f64,
    average_and_deviation: f64,
) -> PublishedRow {
    PublishedRow {
        scene,
        method,
        angle: Some(angle),
        worst: Some(worst),
        average,
        average_and_deviation: Some(average_and_deviation),
    }
}
