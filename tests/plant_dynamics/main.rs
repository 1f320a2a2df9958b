//! The general plant, read from its files, against closed forms; and what the laws of mechanics ask
//! of any plant.
//!
//! `plant` composes bodies, tanks and modes by an articulated-body recursion; `physics` writes down
//! the minimal-parameter equations of the benchmark problems. Nothing is shared but the numbers of
//! the file, so that an error in one cannot hide in the other. Allocations are counted here because
//! the counting allocator lives in `runtime`, which `plant` must not know.
#![forbid(unsafe_code)]

mod allocations;
mod appendage;
mod conservation;
mod dependence;
mod floating_arms;
mod flying_arm;
mod subject;
mod tank;

#[global_allocator]
static ALLOCATOR: runtime::sys::CountingAllocator = runtime::sys::CountingAllocator;
