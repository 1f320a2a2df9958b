//! The estimators of the arm that fly, on simulated records beside methods that do not.

mod filter;
mod live;
mod mated;
