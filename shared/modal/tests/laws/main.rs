//! Laws of the methods on records whose truth is known.

mod cases;
mod free_decay;
mod known_input;
mod methods;
mod operational;
mod random_systems;
mod shapes;
