//! Progress from one level to another (Giegl 2007, sections 7.2 and 7.4.1).

/// On the way from one level to another.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Crossing {
    /// The level that goes.
    pub from: usize,
    /// The level that comes.
    pub to: usize,
    /// Share done, 0..1.
    pub t: f64,
}

impl Crossing {
    /// How far it is from the finer of its levels to the coarser one, 0..1: the weight of vertices that move between them.
    #[must_use]
    pub fn coarseness(self) -> f64 {
        if self.from < self.to { self.t } else { 1.0 - self.t }
    }

    /// The same moment seen from the other end. Unpopping draws both alike, except at t = ½ exactly, where the roles
    /// change.
    #[must_use]
    pub fn reversed(self) -> Self {
        Self {
            from: self.to,
            to: self.from,
            t: 1.0 - self.t,
        }
    }
}

/// What is drawn of a chain: a level at rest, or two.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Shown {
    /// One level, alone.
    Level(usize),
    /// Two of them.
    Crossing(Crossing),
}

impl Shown {
    /// The level that it is at, or goes to.
    #[must_use]
    pub fn goal(self) -> usize {
        match self {
            Self::Level(level) => level,
            Self::Crossing(crossing) => crossing.to,
        }
    }

    /// The next moment, for transitions in time: `step` is the time passed as a share of a whole crossing.
    ///
    /// A crossing whose goal is no longer wanted turns back if its origin is, at the point where it is; else it ends
    /// first, so that never more than two levels are drawn. Steps that are not positive leave everything as it is; a
    /// whole step or more ends a crossing.
    #[must_use]
    pub fn advanced(self, wanted: usize, step: f64) -> Self {
        let crossing = match self {
            Self::Level(level) if level == wanted => return self,
            Self::Level(level) => Crossing {
                from: level,
                to: wanted,
                t: 0.0,
            },
            Self::Crossing(crossing) if crossing.from == wanted => crossing.reversed(),
            Self::Crossing(crossing) => crossing,
        };
        let t = crossing.t + step.max(0.0);
        if t >= 1.0 {
            Self::Level(crossing.to)
        } else {
            Self::Crossing(Crossing { t, ..crossing })
        }
    }
}
