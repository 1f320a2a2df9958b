//! Guide to obsid: the concepts here, five worked cases in [`cases`], one page for every task.
//!
//! | to … | read |
//! |---|---|
//! | see what obsid answers, on data that come with it | [`cases`] |
//! | describe a system | [`plants`] |
//! | bring a recording | [`recordings`] |
//! | find unmodelled physics | [`diagnosis`] |
//! | identify modes | [`modes`] |
//! | plan an experiment | [`experiments`] |
//! | fly a scenario | [`scenarios`] |
//! | know what a crash does, read or change the code | [`architecture`] |
//!
#![doc = include_str!("concepts.md")]
#![forbid(unsafe_code)]

#[doc = include_str!("architecture.md")]
pub mod architecture {}

#[doc = include_str!("cases.md")]
pub mod cases {}

#[doc = include_str!("diagnosis.md")]
pub mod diagnosis {}

#[doc = include_str!("experiments.md")]
pub mod experiments {}

#[doc = include_str!("modes.md")]
pub mod modes {}

#[doc = include_str!("plants.md")]
pub mod plants {}

#[doc = include_str!("recordings.md")]
pub mod recordings {}

#[doc = include_str!("scenarios.md")]
pub mod scenarios {}
