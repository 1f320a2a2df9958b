//! Spatial inertia as three 3 × 3 blocks, and the 6 × 6 solve at a free root.
//!
//! `[n; f] = [A B; Bᵀ C] [α; a]`, moment and force about a point, angular first. `A` and `C` stay
//! symmetric by construction. All quantities are in world axes about the link's own origin: going
//! to the parent is a translation, never a rotation, which is where a formulation in body axes
//! spends most of its time.

use super::vector::{M3, Sym3, V3};
use crate::real::Real;

/// Symmetric 6 × 6 inertia: of a rigid body, or of an articulated body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(crate) struct SpatialInertia<T> {
    pub a: Sym3<T>,
    pub b: M3<T>,
    pub c: Sym3<T>,
}

impl<T: Real> SpatialInertia<T> {
    /// A rigid body: inertia about the origin, first moment `m c`, mass.
    #[inline(always)]
    pub fn rigid(inertia: Sym3<T>, first_moment: V3<T>, mass: f64) -> Self {
        Self { a: inertia, b: M3::skew(first_moment), c: Sym3::diagonal(T::constant(mass)) }
    }

    /// Moment and force of the acceleration (or momentum of the velocity) `(angular, linear)`.
    #[inline(always)]
    pub fn apply(&self, angular: V3<T>, linear: V3<T>) -> (V3<T>, V3<T>) {
        (self.a.apply(angular) + self.b.apply(linear), self.b.apply_transposed(angular) + self.c.apply(linear))
    }

    /// [`apply`](Self::apply) for an angular acceleration alone.
    #[inline(always)]
    pub fn apply_angular(&self, angular: V3<T>) -> (V3<T>, V3<T>) {
        (self.a.apply(angular), self.b.apply_transposed(angular))
    }

    /// `self − u uᵀ d`.
    #[inline(always)]
    pub fn subtract_dyad(&mut self, angular: V3<T>, linear: V3<T>, d: T) {
        self.a.subtract_dyad(angular, d);
        let w = linear * d;
        self.b.rows[0] -= w * angular.x;
        self.b.rows[1] -= w * angular.y;
        self.b.rows[2] -= w * angular.z;
        self.c.subtract_dyad(linear, d);
    }

    /// The same inertia about a point that lies `−r` from its present one (`r` leads from the new
    /// point to the old).
    ///
    /// `C' = C`, `B' = B + r× C`, `A' = A + r× Bᵀ − B' r×`.
    #[inline(always)]
    pub fn translated(&self, r: V3<T>) -> Self {
        let [c0, c1, c2] = self.c.rows();
        let [b0, b1, b2] = self.b.rows;
        // rows of r× C: C is symmetric, its rows are its columns
        let moved = [b0 + c2 * r.y - c1 * r.z, b1 + c0 * r.z - c2 * r.x, b2 + c1 * r.x - c0 * r.y];
        // −B' r×: row i is r × B'_i  ( (B' r×) x = B' (r × x) = (B'_i × r)·x );  r× Bᵀ: column j is
        // r × B_j
        let turned = [r.cross(moved[0]), r.cross(moved[1]), r.cross(moved[2])];
        let [d0, d1, d2] = [r.cross(b0), r.cross(b1), r.cross(b2)];
        let a = Sym3 {
            xx: self.a.xx + d0.x + turned[0].x,
            xy: self.a.xy + d1.x + turned[0].y,
            xz: self.a.xz + d2.x + turned[0].z,
            yy: self.a.yy + d1.y + turned[1].y,
            yz: self.a.yz + d2.y + turned[1].z,
            zz: self.a.zz + d2.z + turned[2].z,
        };
        Self { a, b: M3 { rows: moved }, c: self.c }
    }

    /// `self += other`, block by block; both about the same point.
    #[inline(always)]
    pub fn add(&mut self, other: &Self) {
        self.a += other.a;
        for (row, more) in self.b.rows.iter_mut().zip(other.b.rows) {
            *row += more;
        }
        self.c += other.c;
    }

    /// `(α, a)` with `self (α, a) = (moment, force)`, by two 3 × 3 eliminations: `C` first, then
    /// its Schur complement.
    ///
    /// Fails (NaN) only for a singular inertia, which [`Model::new`](super::Model::new) rejects.
    #[inline(always)]
    pub fn solve(&self, moment: V3<T>, force: V3<T>) -> (V3<T>, V3<T>) {
        let linear = Factor3::of(&self.c);
        let columns = [linear.solve(self.b.rows[0]), linear.solve(self.b.rows[1]), linear.solve(self.b.rows[2])];
        let [b0, b1, b2] = self.b.rows;
        let schur = Sym3 {
            xx: self.a.xx - b0.dot(columns[0]),
            xy: self.a.xy - b0.dot(columns[1]),
            xz: self.a.xz - b0.dot(columns[2]),
            yy: self.a.yy - b1.dot(columns[1]),
            yz: self.a.yz - b1.dot(columns[2]),
            zz: self.a.zz - b2.dot(columns[2]),
        };
        let reduced = moment - V3::new(columns[0].dot(force), columns[1].dot(force), columns[2].dot(force));
        let angular = Factor3::of(&schur).solve(reduced);
        (angular, linear.solve(force - self.b.apply_transposed(angular)))
    }
}

/// `L D Lᵀ` of a positive definite 3 × 3 matrix, with the reciprocals of `D`.
pub(crate) struct Factor3<T> {
    l10: T,
    l20: T,
    l21: T,
    d: V3<T>,
}

impl<T: Real> Factor3<T> {
    /// `L D Lᵀ` factors of a positive definite matrix; 1 division per pivot.
    #[inline(always)]
    pub fn of(s: &Sym3<T>) -> Self {
        let d0 = T::one() / s.xx;
        let (l10, l20) = (s.xy * d0, s.xz * d0);
        let d1 = T::one() / (s.yy - l10 * s.xy);
        let w = s.yz - l10 * s.xz;
        let l21 = w * d1;
        let d2 = T::one() / (s.zz - l20 * s.xz - l21 * w);
        Self { l10, l20, l21, d: V3::new(d0, d1, d2) }
    }

    /// `x` in `L D Lᵀ x = b`.
    #[inline(always)]
    pub fn solve(&self, b: V3<T>) -> V3<T> {
        let y = b.y - self.l10 * b.x;
        let z = (b.z - self.l20 * b.x - self.l21 * y) * self.d.z;
        let y = y * self.d.y - self.l21 * z;
        V3::new(b.x * self.d.x - self.l10 * y - self.l20 * z, y, z)
    }
}
