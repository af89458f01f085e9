//! Valid ranges of numbers.

/// An interval of valid numbers.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Range {
    /// Lower end.
    pub min: f64,
    /// Whether the lower end is excluded.
    pub open_min: bool,
    /// Upper end.
    pub max: f64,
    /// Whether the upper end is excluded.
    pub open_max: bool,
}

impl Range {
    /// Greater than 0.
    pub const POSITIVE: Range = Range { min: 0.0, open_min: true, max: f64::MAX, open_max: false };
    /// 0 or more.
    pub const NON_NEGATIVE: Range = Range::closed(0.0, f64::MAX);
    /// 0 to 1.
    pub const UNIT: Range = Range::closed(0.0, 1.0);
    /// Any finite number.
    pub const FINITE: Range = Range::closed(f64::MIN, f64::MAX);

    /// From `min` to `max`, both included.
    pub const fn closed(min: f64, max: f64) -> Range {
        Range { min, open_min: false, max, open_max: false }
    }

    /// Between `min` and `max`, both excluded.
    pub const fn open(min: f64, max: f64) -> Range {
        Range { min, open_min: true, max, open_max: true }
    }

    /// Whether `v` lies inside. False for NaN.
    pub fn contains(&self, v: f64) -> bool {
        (if self.open_min { v > self.min } else { v >= self.min })
            && (if self.open_max { v < self.max } else { v <= self.max })
    }
}

impl std::fmt::Display for Range {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match (self.min > f64::MIN, self.max < f64::MAX) {
            (false, false) => write!(f, "a finite number"),
            (true, false) if self.open_min => write!(f, "greater than {}", self.min),
            (true, false) => write!(f, "{} or more", self.min),
            (false, true) => write!(f, "{} or less", self.max),
            (true, true) if self.open_min || self.open_max => {
                let side = |open| if open { "excluded" } else { "included" };
                write!(f, "{} ({}) to {} ({})", self.min, side(self.open_min), self.max, side(self.open_max))
            }
            (true, true) => write!(f, "{} to {}", self.min, self.max),
        }
    }
}
