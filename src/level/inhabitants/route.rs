//! Where a figure is at a time: closed ways, and how one goes on them.

use bevy_math::Vec2;

/// Metres before and behind that a heading is taken over: figures turn in a curve, not on the spot.
const LOOK: f32 = 0.35;
/// Seconds in which a figure starts and stops.
const RAMP: f32 = 1.2;

/// A closed way on the ground (x, z).
#[derive(Clone, Debug, PartialEq)]
pub struct Route {
    points: Vec<Vec2>,
    /// Way to each point from the first, and round to it again.
    lengths: Vec<f32>,
}

impl Route {
    /// The way through these points and back to the first. `None` for fewer than three points or no length.
    pub fn new(points: Vec<Vec2>) -> Option<Self> {
        let mut lengths = vec![0.0];
        let mut sum = 0.0;
        for (i, point) in points.iter().enumerate() {
            sum += point.distance(points[(i + 1) % points.len()]);
            lengths.push(sum);
        }
        (points.len() >= 3 && sum.is_finite() && sum > 0.0).then_some(Self { points, lengths })
    }

    /// A rectangle with round corners, counter-clockwise seen from +y's tip downward x to z.
    pub fn around(min: Vec2, max: Vec2, corner: f32) -> Option<Self> {
        let middles = [
            (Vec2::new(max.x - corner, min.y + corner), -0.25),
            (max - corner, 0.0),
            (Vec2::new(min.x + corner, max.y - corner), 0.25),
            (min + corner, 0.5),
        ];
        if (max - min).min_element() < 2.0 * corner {
            return None;
        }
        let arc = |(middle, turn): (Vec2, f32)| {
            (0..=8).map(move |i| {
                let angle = (turn + 0.25 * i as f32 / 8.0) * std::f32::consts::TAU;
                middle + Vec2::from_angle(angle) * corner
            })
        };
        Self::new(middles.into_iter().flat_map(arc).collect())
    }

    /// Metres of the whole way.
    pub fn length(&self) -> f32 {
        self.lengths[self.points.len()]
    }

    /// The place after so many metres.
    pub fn at(&self, metres: f32) -> Vec2 {
        let along = metres.rem_euclid(self.length());
        let next = self
            .lengths
            .partition_point(|length| *length <= along)
            .clamp(1, self.points.len());
        let (from, to) = (self.points[next - 1], self.points[next % self.points.len()]);
        let step = self.lengths[next] - self.lengths[next - 1];
        from.lerp(
            to,
            if step > 0.0 {
                (along - self.lengths[next - 1]) / step
            } else {
                0.0
            },
        )
    }

    /// Shortest distance between the corners of two ways.
    pub fn gap(&self, other: &Self) -> f32 {
        let pairs = self
            .points
            .iter()
            .flat_map(|p| other.points.iter().map(|q| p.distance(*q)));
        pairs.fold(f32::MAX, f32::min)
    }

    /// Unit direction of the way there.
    pub fn direction(&self, metres: f32) -> Vec2 {
        (self.at(metres + LOOK) - self.at(metres - LOOK)).normalize_or(Vec2::Y)
    }
}

/// How one goes on a way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Pace {
    /// Always on.
    Steady {
        /// Metres per second; negative: the other way round.
        speed: f32,
        /// Metres at time 0.
        start: f32,
    },
    /// Stops at even distances.
    Browsing {
        /// Metres per second between stops.
        speed: f32,
        /// Metres from stop to stop.
        leg: f32,
        /// Seconds of a stop.
        rest: f32,
        /// Seconds that have gone at time 0.
        head_start: f32,
    },
}

/// What a figure does at a time.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Moment {
    /// Metres on the way.
    pub metres: f32,
    /// 1 walks, 0 stands; between them it starts or stops.
    pub walk: f32,
    /// Seconds since it stopped last.
    pub rested: f32,
}

impl Pace {
    /// What one does after so many seconds.
    pub fn at(&self, seconds: f64) -> Moment {
        match *self {
            Self::Steady { speed, start } => Moment {
                metres: (f64::from(start) + f64::from(speed) * seconds) as f32,
                walk: 1.0,
                rested: 0.0,
            },
            Self::Browsing {
                speed,
                leg,
                rest,
                head_start,
            } => {
                // Half speed, on average, while starting and stopping.
                let moving = leg / speed + RAMP;
                let period = f64::from(rest + moving);
                let since = seconds + f64::from(head_start);
                let rounds = (since / period).floor();
                let now = (since - rounds * period) as f32;
                let gone = now - rest;
                let (done, walk) = if gone <= 0.0 {
                    (0.0, 0.0)
                } else if gone < RAMP {
                    (0.5 * speed * gone * gone / RAMP, gone / RAMP)
                } else if gone < moving - RAMP {
                    (speed * (gone - 0.5 * RAMP), 1.0)
                } else {
                    let left = moving - gone;
                    (leg - 0.5 * speed * left * left / RAMP, left / RAMP)
                };
                Moment {
                    metres: (rounds * f64::from(leg)) as f32 + done,
                    walk,
                    rested: now,
                }
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_square_is_walked_side_by_side_and_round() {
        let corners = [(0.0, 0.0), (4.0, 0.0), (4.0, 4.0), (0.0, 4.0)];
        let route = Route::new(corners.map(Vec2::from).to_vec()).expect("a way");
        assert_eq!(route.length(), 16.0);
        assert_eq!(route.at(6.0), Vec2::new(4.0, 2.0));
        assert_eq!(
            route.at(-1.0),
            Vec2::new(0.0, 1.0),
            "the last side leads back to the first corner"
        );
        assert_eq!(route.direction(14.0), Vec2::NEG_Y);
        assert!(
            route.direction(4.0).dot(Vec2::ONE.normalize()) > 0.99,
            "round the corner"
        );
        assert_eq!(Route::new(vec![Vec2::ONE; 5]), None);
        assert_eq!(Route::new(vec![Vec2::ZERO, Vec2::X]), None);
    }

    #[test]
    fn a_round_rectangle_stays_inside_and_has_its_length() {
        let (min, max) = (Vec2::new(-3.0, 1.0), Vec2::new(7.0, 9.0));
        let route = Route::around(min, max, 1.0).expect("there is room");
        // Sides less two radii each, and a circle of 6.283 m.
        assert!(
            (route.length() - (2.0 * 8.0 + 2.0 * 6.0 + 6.27)).abs() < 0.02,
            "{}",
            route.length()
        );
        for i in 0..100 {
            let p = route.at(i as f32 * 0.4);
            assert!(p.cmpge(min - 1e-4).all() && p.cmple(max + 1e-4).all(), "{p}");
        }
        assert_eq!(Route::around(min, max, 4.5), None);
    }

    #[test]
    fn who_browses_rests_starts_goes_and_stops() {
        let pace = Pace::Browsing {
            speed: 1.0,
            leg: 5.0,
            rest: 10.0,
            head_start: 0.0,
        };
        assert_eq!(pace.at(4.0).walk, 0.0);
        assert_eq!(pace.at(4.0).rested, 4.0);
        let starting = pace.at(10.6);
        assert!(
            (starting.walk - 0.5).abs() < 1e-5 && (starting.metres - 0.15).abs() < 1e-5,
            "{starting:?}"
        );
        let going = pace.at(13.1);
        assert!(
            going.walk == 1.0 && (going.metres - 2.5).abs() < 1e-4,
            "half way after half the time: {going:?}"
        );
        // 16.2 s later the next round begins 5 m on.
        let next = pace.at(16.2 + 4.0);
        assert!((next.metres - 5.0).abs() < 1e-4 && next.walk == 0.0, "{next:?}");
        let mut last = 0.0;
        for i in 0..2000 {
            let metres = pace.at(f64::from(i) * 0.02).metres;
            assert!(
                (-1e-4..0.021).contains(&(metres - last)),
                "no jump at {i}: {last} {metres}"
            );
            last = metres;
        }
    }

    #[test]
    fn steady_ones_go_on_for_ever() {
        let pace = Pace::Steady {
            speed: -1.3,
            start: 2.0,
        };
        let far = pace.at(100_000.0);
        assert!((far.metres + 129_998.0).abs() < 0.01 && far.walk == 1.0);
    }
}
