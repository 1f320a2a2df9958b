//! Three-dimensional vectors, rotations and symmetric matrices of a [`Real`], written out.
//!
//! Why not nalgebra's: its products go through general loops, and a product of a dual with a
//! constant would pay for a derivative known to be zero. Each operation here is one expression the
//! compiler can schedule.

use crate::real::Real;
use core::ops::{Add, AddAssign, Mul, Neg, Sub, SubAssign};
use nalgebra::{Matrix3, Vector3};

/// A motion or a force: angular part (moment), linear part.
pub(crate) type Spatial<T> = (V3<T>, V3<T>);

#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct V3<T> {
    pub x: T,
    pub y: T,
    pub z: T,
}

impl<T: Real> V3<T> {
    /// The vector `[x, y, z]`.
    #[inline(always)]
    pub fn new(x: T, y: T, z: T) -> Self {
        Self { x, y, z }
    }

    /// The vector 0.
    #[inline(always)]
    pub fn zero() -> Self {
        Self::new(T::zero(), T::zero(), T::zero())
    }

    /// Constant components, with zero derivative.
    #[inline(always)]
    pub fn constant(v: &V3<f64>) -> Self {
        Self::new(T::constant(v.x), T::constant(v.y), T::constant(v.z))
    }

    /// `values[at..at + 3]`.
    #[inline(always)]
    pub fn read(values: &[T], at: usize) -> Self {
        let three = &values[at..at + 3];
        Self::new(three[0], three[1], three[2])
    }

    /// Writes x, y, z to `values[at..at + 3]`.
    #[inline(always)]
    pub fn write(self, values: &mut [T], at: usize) {
        values[at..at + 3].copy_from_slice(&self.array());
    }

    /// `[x, y, z]`.
    #[inline(always)]
    pub fn array(self) -> [T; 3] {
        [self.x, self.y, self.z]
    }

    /// `self · b`.
    #[inline(always)]
    pub fn dot(self, b: Self) -> T {
        self.x * b.x + self.y * b.y + self.z * b.z
    }

    /// `self × b`.
    #[inline(always)]
    pub fn cross(self, b: Self) -> Self {
        Self::new(self.y * b.z - self.z * b.y, self.z * b.x - self.x * b.z, self.x * b.y - self.y * b.x)
    }

    /// `self × (self × b)`.
    #[inline(always)]
    pub fn cross_twice(self, b: Self) -> Self {
        self * self.dot(b) - b * self.dot(self)
    }

    /// `factor · self`, the factor a constant.
    #[inline(always)]
    pub fn scale(self, factor: f64) -> Self {
        Self::new(self.x.scale(factor), self.y.scale(factor), self.z.scale(factor))
    }
}

impl V3<f64> {
    /// From nalgebra's vector.
    pub fn from_vector(v: &Vector3<f64>) -> Self {
        Self::new(v.x, v.y, v.z)
    }
}

impl<T: Real> From<[T; 3]> for V3<T> {
    #[inline(always)]
    fn from([x, y, z]: [T; 3]) -> Self {
        Self { x, y, z }
    }
}

impl<T: Real> Add for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn add(self, b: Self) -> Self {
        Self::new(self.x + b.x, self.y + b.y, self.z + b.z)
    }
}

impl<T: Real> Sub for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn sub(self, b: Self) -> Self {
        Self::new(self.x - b.x, self.y - b.y, self.z - b.z)
    }
}

impl<T: Real> Neg for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn neg(self) -> Self {
        Self::new(-self.x, -self.y, -self.z)
    }
}

impl<T: Real> AddAssign for V3<T> {
    #[inline(always)]
    fn add_assign(&mut self, b: Self) {
        *self = *self + b;
    }
}

impl<T: Real> SubAssign for V3<T> {
    #[inline(always)]
    fn sub_assign(&mut self, b: Self) {
        *self = *self - b;
    }
}

impl<T: Real> Mul<T> for V3<T> {
    type Output = Self;
    #[inline(always)]
    fn mul(self, factor: T) -> Self {
        Self::new(self.x * factor, self.y * factor, self.z * factor)
    }
}

/// A 3 × 3 matrix by rows.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct M3<T> {
    pub rows: [V3<T>; 3],
}

impl<T: Real> M3<T> {
    /// The identity I.
    #[inline(always)]
    pub fn identity() -> Self {
        let (one, zero) = (T::one(), T::zero());
        Self { rows: [V3::new(one, zero, zero), V3::new(zero, one, zero), V3::new(zero, zero, one)] }
    }

    /// `v ×` as a matrix.
    #[inline(always)]
    pub fn skew(v: V3<T>) -> Self {
        let zero = T::zero();
        Self { rows: [V3::new(zero, -v.z, v.y), V3::new(v.z, zero, -v.x), V3::new(-v.y, v.x, zero)] }
    }

    /// Rows as arrays.
    #[inline(always)]
    pub fn arrays(&self) -> [[T; 3]; 3] {
        [self.rows[0].array(), self.rows[1].array(), self.rows[2].array()]
    }

    /// First column.
    #[inline(always)]
    pub fn column_x(&self) -> V3<T> {
        V3::new(self.rows[0].x, self.rows[1].x, self.rows[2].x)
    }

    /// Second column.
    #[inline(always)]
    pub fn column_y(&self) -> V3<T> {
        V3::new(self.rows[0].y, self.rows[1].y, self.rows[2].y)
    }

    /// Third column.
    #[inline(always)]
    pub fn column_z(&self) -> V3<T> {
        V3::new(self.rows[0].z, self.rows[1].z, self.rows[2].z)
    }

    /// `self v`.
    #[inline(always)]
    pub fn apply(&self, v: V3<T>) -> V3<T> {
        V3::new(self.rows[0].dot(v), self.rows[1].dot(v), self.rows[2].dot(v))
    }

    /// `selfᵀ v`.
    #[inline(always)]
    pub fn apply_transposed(&self, v: V3<T>) -> V3<T> {
        self.rows[0] * v.x + self.rows[1] * v.y + self.rows[2] * v.z
    }

    /// `self v` for a constant `v`.
    #[inline(always)]
    pub fn apply_constant(&self, v: &V3<f64>) -> V3<T> {
        let row = |r: V3<T>| r.x.scale(v.x) + r.y.scale(v.y) + r.z.scale(v.z);
        V3::new(row(self.rows[0]), row(self.rows[1]), row(self.rows[2]))
    }

    /// `self b`, 3 × 3 by 3 × 3.
    #[inline(always)]
    pub fn product(&self, b: &Self) -> Self {
        let row = |r: V3<T>| b.rows[0] * r.x + b.rows[1] * r.y + b.rows[2] * r.z;
        Self { rows: [row(self.rows[0]), row(self.rows[1]), row(self.rows[2])] }
    }

    /// `self B` for a constant `B`.
    #[inline(always)]
    pub fn product_constant(&self, b: &M3<f64>) -> Self {
        let row = |r: V3<T>| {
            V3::new(
                r.x.scale(b.rows[0].x) + r.y.scale(b.rows[1].x) + r.z.scale(b.rows[2].x),
                r.x.scale(b.rows[0].y) + r.y.scale(b.rows[1].y) + r.z.scale(b.rows[2].y),
                r.x.scale(b.rows[0].z) + r.y.scale(b.rows[1].z) + r.z.scale(b.rows[2].z),
            )
        };
        Self { rows: [row(self.rows[0]), row(self.rows[1]), row(self.rows[2])] }
    }

    /// `self S selfᵀ` for a constant symmetric `S`: an inertia in other axes.
    #[inline(always)]
    pub fn congruence(&self, s: &Sym3<f64>) -> Sym3<T> {
        let row = |r: V3<T>| {
            V3::new(
                r.x.scale(s.xx) + r.y.scale(s.xy) + r.z.scale(s.xz),
                r.x.scale(s.xy) + r.y.scale(s.yy) + r.z.scale(s.yz),
                r.x.scale(s.xz) + r.y.scale(s.yz) + r.z.scale(s.zz),
            )
        };
        let [a, b, c] = [row(self.rows[0]), row(self.rows[1]), row(self.rows[2])];
        Sym3 {
            xx: a.dot(self.rows[0]),
            xy: a.dot(self.rows[1]),
            xz: a.dot(self.rows[2]),
            yy: b.dot(self.rows[1]),
            yz: b.dot(self.rows[2]),
            zz: c.dot(self.rows[2]),
        }
    }
}

impl M3<f64> {
    /// From nalgebra's matrix.
    pub fn from_matrix(m: &Matrix3<f64>) -> Self {
        let row = |i: usize| V3::new(m[(i, 0)], m[(i, 1)], m[(i, 2)]);
        Self { rows: [row(0), row(1), row(2)] }
    }

    /// `self v` for a variable `v`.
    #[inline(always)]
    pub fn apply_to<T: Real>(&self, v: V3<T>) -> V3<T> {
        let row = |r: &V3<f64>| v.x.scale(r.x) + v.y.scale(r.y) + v.z.scale(r.z);
        V3::new(row(&self.rows[0]), row(&self.rows[1]), row(&self.rows[2]))
    }
}

/// A symmetric 3 × 3 matrix.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct Sym3<T> {
    pub xx: T,
    pub xy: T,
    pub xz: T,
    pub yy: T,
    pub yz: T,
    pub zz: T,
}

impl<T: Real> Sym3<T> {
    /// The matrix 0.
    #[inline(always)]
    pub fn zero() -> Self {
        let zero = T::zero();
        Self { xx: zero, xy: zero, xz: zero, yy: zero, yz: zero, zz: zero }
    }

    /// `value I`.
    #[inline(always)]
    pub fn diagonal(value: T) -> Self {
        Self { xx: value, yy: value, zz: value, ..Self::zero() }
    }

    /// Rows of the full matrix.
    #[inline(always)]
    pub fn rows(&self) -> [V3<T>; 3] {
        [V3::new(self.xx, self.xy, self.xz), V3::new(self.xy, self.yy, self.yz), V3::new(self.xz, self.yz, self.zz)]
    }

    /// `self v`.
    #[inline(always)]
    pub fn apply(&self, v: V3<T>) -> V3<T> {
        let [x, y, z] = self.rows();
        V3::new(x.dot(v), y.dot(v), z.dot(v))
    }

    /// `self − u uᵀ d`.
    #[inline(always)]
    pub fn subtract_dyad(&mut self, u: V3<T>, d: T) {
        let w = u * d;
        self.xx -= u.x * w.x;
        self.xy -= u.x * w.y;
        self.xz -= u.x * w.z;
        self.yy -= u.y * w.y;
        self.yz -= u.y * w.z;
        self.zz -= u.z * w.z;
    }
}

impl<T: Real> AddAssign for Sym3<T> {
    #[inline(always)]
    fn add_assign(&mut self, b: Self) {
        self.xx += b.xx;
        self.xy += b.xy;
        self.xz += b.xz;
        self.yy += b.yy;
        self.yz += b.yz;
        self.zz += b.zz;
    }
}

impl Sym3<f64> {
    /// Of the symmetric part of `m`.
    pub fn from_matrix(m: &Matrix3<f64>) -> Self {
        let mean = |i: usize, j: usize| 0.5 * (m[(i, j)] + m[(j, i)]);
        Self { xx: mean(0, 0), xy: mean(0, 1), xz: mean(0, 2), yy: mean(1, 1), yz: mean(1, 2), zz: mean(2, 2) }
    }
}
