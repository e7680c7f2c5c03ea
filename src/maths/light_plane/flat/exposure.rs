//! [`Exposure`]: a picture on a film.

use bevy_math::{DVec2, DVec3};

use super::{
    Degenerate, Film, Hit, Hull, Light, Sample, Tilt,
    film::{angle_of, wrapped},
};

/// What a picture asks of a film: where its pixels meet it and how badly it serves them. With one of these, every other
/// film of the same light is a [`Tilt`].
#[derive(Clone, Debug, PartialEq)]
pub struct Exposure {
    /// The film.
    pub film: Film,
    /// What of it is used: −1..=1 of the places.
    pub hull: Hull,
    /// One per pixel.
    pub samples: Vec<Sample>,
}

impl Exposure {
    /// A picture on the ordinary map ([`Film::half_angle`]) with the smallest hull: the initial film (Chong 3).
    ///
    /// # Errors
    /// Those of [`Film::half_angle`].
    pub fn half_angle(light: Light, hits: &[Hit]) -> Result<Self, Degenerate> {
        let (film, hull) = Film::half_angle(light, &points(hits))?;
        Self::within(film, hull, hits)
    }

    /// A picture on a film with the smallest hull.
    ///
    /// # Errors
    /// Those of [`Film::hull`].
    pub fn tight(film: Film, hits: &[Hit]) -> Result<Self, Degenerate> {
        Self::within(film, film.hull(&points(hits))?, hits)
    }

    /// A picture on a part of a film; pixels whose rays miss it are left out.
    ///
    /// Badness is |dp/dτ| times the hull's half width; infinite where the light sees a surface edge-on.
    ///
    /// # Errors
    /// [`Degenerate::NothingVisible`] if no pixel is left, [`Degenerate::Flat`] for a hull without width,
    /// [`Degenerate::NotFinite`].
    pub fn within(film: Film, hull: Hull, hits: &[Hit]) -> Result<Self, Degenerate> {
        let half_width = (hull.top - hull.bottom) / 2.0;
        if !half_width.is_finite() {
            return Err(Degenerate::NotFinite);
        }
        if half_width <= 0.0 {
            return Err(Degenerate::Flat);
        }
        let samples = hits.iter().filter_map(|hit| {
            let place = hull.place(film.coordinate(hit.point)?);
            // Places of the hull's own ends may be off by rounding.
            let is_inside = place.abs() <= 1.0 + 1.0e-12;
            is_inside.then(|| Sample {
                place: place.clamp(-1.0, 1.0),
                badness: half_width / film.rate(hit.point, hit.step).abs(),
            })
        });
        let samples: Vec<Sample> = samples.collect();
        if samples.is_empty() {
            return Err(Degenerate::NothingVisible);
        }
        Ok(Self { film, hull, samples })
    }

    /// With no badness above `largest` (pixels per unit of place). A surface that the light grazes has badness without
    /// bound, and no film would look at anything else: 1000 pixels per texel (500 times the texels of the film, here) is
    /// more than any real picture needs.
    #[must_use]
    pub fn limited(mut self, largest: f64) -> Self {
        for sample in &mut self.samples {
            sample.badness = sample.badness.min(largest);
        }
        self
    }

    /// The tilt to the film of a point light whose axis has `angle` in the world; `None` for an invalid one. Under
    /// parallel light turning the film tilts nothing, so every valid angle gives no tilt (Chong 4.1.3).
    pub fn tilt_of_angle(&self, angle: f64) -> Option<Tilt> {
        match self.film.light() {
            Light::Point { .. } => self.hull.tilt_of_turn(wrapped(angle - self.film.angle())),
            Light::Directional { travel } => {
                let between = angle - angle_of(travel)?;
                (between.cos() > 0.0).then(Tilt::default)
            }
        }
    }

    /// The angle in the world of the axis of a tilted film; `None` under parallel light, where a projection tilts, not a
    /// turn.
    pub fn angle_of_tilt(&self, tilt: Tilt) -> Option<f64> {
        matches!(self.film.light(), Light::Point { .. })
            .then(|| wrapped(self.film.angle() + self.hull.turn_of_tilt(tilt)))
    }

    /// The tilt to the film whose view plane goes through a homogeneous point (z, y, w): the one film that sees that point
    /// at infinity. `None` where that line cuts through the hull, and at the light itself.
    ///
    /// With w = 1 + k l on this film, k = −1 ÷ l of that point.
    pub fn tilt_through(&self, point: DVec3) -> Option<Tilt> {
        let (across, ahead) = self.film.quotient(point);
        let Hull { bottom, top } = self.hull;
        let strength = -(top - bottom) * ahead / (2.0 * across - (top + bottom) * ahead);
        Tilt::of_strength(strength)
    }

    /// Borders of `count` parts of the hull, −1 to 1: equal angles for a point light (Chong 3.2), equal widths under
    /// parallel light.
    pub fn even_borders(&self, count: usize) -> Vec<f64> {
        let count = count.max(1);
        let Hull { bottom, top } = self.hull;
        let share = |index: usize| index as f64 / count as f64;
        let borders = (0..=count).map(|index| match self.film.light() {
            _ if index == 0 => -1.0,
            _ if index == count => 1.0,
            Light::Directional { .. } => 2.0 * share(index) - 1.0,
            Light::Point { .. } => {
                let angle = bottom.atan() + (top.atan() - bottom.atan()) * share(index);
                self.hull.place(angle.tan())
            }
        });
        borders.collect()
    }
}

/// The angle of a film as the source prints it: degrees counter-clockwise from a vertical film, in 0..180, in pictures
/// whose camera looks to the left.
pub fn printed_angle(angle: f64) -> f64 {
    (-angle.to_degrees()).rem_euclid(180.0)
}

fn points(hits: &[Hit]) -> Vec<DVec2> {
    hits.iter().map(|hit| hit.point).collect()
}
