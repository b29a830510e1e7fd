//! Plane geometry out of additions, multiplications and divisions, which every processor rounds alike: the path of the
//! robot is the same bit for bit on all of them. Sines, and `mul_add`, are not.

use core::ops::{Add, Mul, Sub};

/// A place in metres, or a direction.
#[derive(Debug, Clone, Copy, PartialEq, Default)]
pub(crate) struct Vector {
    pub(crate) x: f64,
    pub(crate) y: f64,
}

impl Vector {
    pub(crate) const fn new(x: f64, y: f64) -> Self {
        Self { x, y }
    }

    pub(crate) fn dot(self, other: Self) -> f64 {
        self.x * other.x + self.y * other.y
    }

    /// Positive if `other` lies to the left of this.
    pub(crate) fn cross(self, other: Self) -> f64 {
        self.x * other.y - self.y * other.x
    }

    pub(crate) fn length(self) -> f64 {
        square_root(self.dot(self))
    }

    /// The direction, which is to the front for a vector that has none.
    pub(crate) fn direction(self) -> Self {
        let length = self.length();
        if length > 0.0 { self * (1.0 / length) } else { Self::new(1.0, 0.0) }
    }

    /// A quarter turn to the left.
    pub(crate) fn to_the_left(self) -> Self {
        Self::new(-self.y, self.x)
    }

    /// Turned by the angle between the axis and `heading`, which is a direction.
    pub(crate) fn turned_by(self, heading: Self) -> Self {
        Self::new(self.x * heading.x - self.y * heading.y, self.x * heading.y + self.y * heading.x)
    }

    /// Turned back by that angle: seen from somebody who looks there.
    pub(crate) fn seen_along(self, heading: Self) -> Self {
        self.turned_by(Self::new(heading.x, -heading.y))
    }

    /// The direction after a turn by a small angle to the left: exactly a rotation, for the angle 2 atan(angle / 2).
    pub(crate) fn rotation(angle: f64) -> Self {
        let half = angle / 2.0;
        let scale = 1.0 / (1.0 + half * half);
        Self::new((1.0 - half * half) * scale, 2.0 * half * scale)
    }

    pub(crate) fn is_finite(self) -> bool {
        self.x.is_finite() && self.y.is_finite()
    }
}

impl Add for Vector {
    type Output = Self;

    fn add(self, other: Self) -> Self {
        Self::new(self.x + other.x, self.y + other.y)
    }
}

impl Sub for Vector {
    type Output = Self;

    fn sub(self, other: Self) -> Self {
        Self::new(self.x - other.x, self.y - other.y)
    }
}

impl Mul<f64> for Vector {
    type Output = Self;

    fn mul(self, factor: f64) -> Self {
        Self::new(self.x * factor, self.y * factor)
    }
}

/// By Newton's method, because `core` has no square root; zero for what has none.
fn square_root(square: f64) -> f64 {
    if square <= 0.0 {
        return 0.0;
    }
    // Half the exponent: right to within a few per cent, and each step doubles the digits.
    let mut root = f64::from_bits((square.to_bits() >> 1) + (1023 << 51));
    for _ in 0..5 {
        root = 0.5 * (root + square / root);
    }
    root
}
