//! Coordinates and their names, as effects, sensors, actuators and initial values refer to them.

/// One generalised coordinate.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Coordinate {
    /// In `Workspace::position`; `None`: a wheel, which has only a speed.
    pub position: Option<usize>,
    /// In `Workspace::velocity`.
    pub v: usize,
}

/// A joint with one degree of freedom.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct JointSite {
    pub name: String,
    /// The outboard body.
    pub link: usize,
    pub coordinate: Coordinate,
    /// rad or m.
    pub rotary: bool,
    pub axis: [f64; 3],
}

/// The coordinate that an initial value names.
#[derive(Clone, Debug, PartialEq)]
pub(super) struct NamedCoordinate {
    /// As in [`InitialValue`](crate::description::InitialValue).
    pub name: String,
    pub what: InitialPlace,
}

/// Where an initial value goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) enum InitialPlace {
    Single(Coordinate),
    /// Axis 0 to 5 (x, y, z, rx, ry, rz) of the free body that is this link.
    Free {
        link: usize,
        axis: usize,
    },
    /// Speed, and its default.
    Wheel {
        v: usize,
        speed_rad_s: f64,
    },
}
